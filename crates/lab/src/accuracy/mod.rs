//! Implements `geosweep-lab accuracy`, which compares maps with exact distances and measures their cost.

mod measure;
mod peers;
mod plots;
mod report;

use std::error::Error;
use std::path::PathBuf;

use geosweep::io::{OutputFile, StagedFile};
use geosweep::surface::builtin::Builtin;
use geosweep::{DeviceChoice, Engine, Wavefront};

use super::lists;
use super::publication::Publication;
use geosweep_cli::choices::{one_of, wavefront_names};
use geosweep_cli::output::{png_output, stage_picture, wanted_file};
use geosweep_cli::precision::Precision;
use geosweep_cli::terminal::{List, Outcome};
use measure::Measurement;
use peers::Peer;
use report::Report;

/// The arguments of `geosweep-lab accuracy`.
#[derive(clap::Args)]
#[command(after_help = examples())]
pub struct Args {
    /// Points per side
    #[arg(long, value_name = "N,...", value_delimiter = ',', value_parser = lists::size)]
    #[arg(default_values_t = [33, 65, 129, 257, 513, 1025])]
    sizes: Vec<usize>,
    /// Built-in surfaces (default: all)
    #[arg(long, value_name = "NAME,...", value_delimiter = ',', value_parser = measurable)]
    surfaces: Vec<Builtin>,
    /// Wavefronts (default: those that suit the surface: anchored over floor plans only)
    #[arg(long, value_name = "NAME,...", value_delimiter = ',')]
    wavefronts: Vec<Wavefront>,
    /// Engine that computes the maps
    #[arg(long, default_value = "cpu", value_parser = one_of(&ENGINES))]
    engine: Engine,
    /// Precision of the maps: double shows the method's own errors
    #[arg(long, value_enum, default_value_t)]
    precision: Precision,
    /// Output file for the report, as Markdown (default: standard output, unless --json)
    #[arg(short, long, value_name = "REPORT.md")]
    output: Option<PathBuf>,
    /// Folder for two plots: accuracy-size.png and accuracy-time.png
    #[arg(long, value_name = "FOLDER")]
    plots: Option<PathBuf>,
    /// Table with the results of other solvers, for plots and report: surface, size (points per side),
    /// solver, seconds, mean_error (relative)
    #[arg(long, value_name = "FILE.csv")]
    peers: Option<PathBuf>,
    /// Machine on which the times were measured, for the report
    #[arg(long, value_name = "TEXT")]
    machine: Option<String>,
    /// Print one JSON object; docs/json.md and docs/geosweep.schema.json describe it
    #[arg(long)]
    json: bool,
}

fn examples() -> String {
    format!(
        "\
Errors are relative to the exact distance, over all points but the source. The source lies
near row 0.31, column 0.41 of the grid, as fractions of its size; in the maze, it lies at
the corner where the corridor begins. The order is that of the mean error from the
previous size: the logarithm of the ratio of the errors over the logarithm of the ratio of
the spacings. Times are the shortest of a few runs, without the set-up.

Surfaces: {}.
Wavefronts: {}.

Examples:
  geosweep-lab accuracy
  geosweep-lab accuracy -o docs/figures/accuracy.md --plots docs/figures --peers docs/peers.csv
  geosweep-lab accuracy --precision double --sizes 65,129,257,513
  geosweep-lab accuracy --surfaces sphere,sheared-plane@72 --wavefronts point --sizes 65,129 --json",
        Builtin::measurable().map(|b| b.to_string()).collect::<Vec<_>>().join(", "),
        wavefront_names()
    )
}

const ENGINES: [(Engine, &str); 2] = [
    (Engine::Cpu, "Scans on the CPU"),
    (Engine::Vulkan(DeviceChoice::Any), "The first usable Vulkan device"),
];

fn measurable(text: &str) -> Result<Builtin, String> {
    let builtin = Builtin::parse(text)?;
    if Builtin::measurable().all(|known| known.name() != builtin.name()) {
        return Err(format!(
            "no exact distances are known on {builtin}, so a solver cannot be measured on it"
        ));
    }
    Ok(builtin)
}

pub fn run(args: &Args) -> Outcome {
    let outputs = Outputs::new(args)?;
    let peers = args.peers.as_deref().map_or(Ok(Vec::new()), peers::read)?;
    let sizes = lists::ascending(&args.sizes);
    let surfaces = lists::or_else(&args.surfaces, || Builtin::measurable().collect());
    let cases: Vec<_> = surfaces
        .into_iter()
        .map(|builtin| (builtin, lists::or_else(&args.wavefronts, || suited_to(builtin, sizes[0]))))
        .collect();
    let measured = measure::all(&cases, &sizes, &args.engine, args.precision)?;

    let report =
        Report { args, plots: outputs.plots_link(args), measured: &measured, peers: &peers };
    let markdown = report.to_string();
    let pictures = outputs.plots.map(|plots| draw(plots, &measured, &peers)).transpose()?;
    let rows: Vec<_> = measured.iter().map(Measurement::row).collect();
    Publication {
        command: "accuracy",
        markdown,
        output: outputs.report,
        pictures: pictures.into_iter().flatten().collect(),
        rows: &List("maps", &rows),
    }
    .publish(args.json)
}

/// Returns the wavefronts that suit a surface and a lone source. Anchored wavefronts are for floor plans only.
fn suited_to(builtin: Builtin, size: usize) -> Vec<Wavefront> {
    let mut suited = Wavefront::FOR_ANY_SURFACE.to_vec();
    if builtin.surface(size, size).is_ok_and(|surface| surface.is_floor_plan()) {
        suited.push(Wavefront::Anchored);
    }
    suited
}

/// The files to write. They are checked before the computation starts.
struct Outputs {
    report: Option<OutputFile>,
    plots: Option<[OutputFile; 2]>,
}

impl Outputs {
    fn new(args: &Args) -> Result<Self, Box<dyn Error>> {
        let report = wanted_file(args.output.as_ref(), "a report is", "md")?;
        let plots = args.plots.as_deref().map(|folder| {
            let [size, time] = plots::FILES.map(|name| png_output(&folder.join(name)));
            Ok::<_, Box<dyn Error>>([size?, time?])
        });
        Ok(Self { report, plots: plots.transpose()? })
    }

    /// Returns the folder of the plots relative to the report, if it lies below the report's folder.
    fn plots_link(&self, args: &Args) -> Option<PathBuf> {
        let folder = args.plots.as_deref()?.canonicalize().ok()?;
        let report = std::path::absolute(args.output.as_deref()?).ok()?;
        Some(folder.strip_prefix(report.parent()?.canonicalize().ok()?).ok()?.to_owned())
    }
}

/// Draws the plots of error against size and of error against time.
fn draw(
    [size, time]: [OutputFile; 2],
    measured: &[Measurement],
    peers: &[Peer],
) -> Result<[StagedFile; 2], Box<dyn Error>> {
    let (by_size, by_time) = (plots::by_size(measured, peers), plots::by_time(measured, peers));
    Ok([stage_picture(size, || by_size.draw())?, stage_picture(time, || by_time.draw())?])
}

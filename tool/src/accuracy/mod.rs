//! `geosweep accuracy`: how far maps are from exact distances, and what that costs.

mod measure;
mod peers;
mod plots;
mod report;

use std::error::Error;
use std::io::Write;
use std::path::PathBuf;
use std::process::ExitCode;

use clap::ValueEnum;
use geosweep::io::{OutputFile, StagedFile};
use geosweep::surface::builtin::Builtin;
use geosweep::{DeviceChoice, Engine, Wavefront};

use crate::output_file::{output_file, png_output};
use crate::precision::Precision;
use crate::study;
use crate::{Outcome, print};
use measure::Measurement;
use peers::Peer;
use report::Report;

/// The arguments of `geosweep accuracy`.
#[derive(clap::Args)]
#[command(after_help = examples())]
pub struct Args {
    /// Points a side
    #[arg(long, value_name = "N,...", value_delimiter = ',', value_parser = study::size)]
    #[arg(default_values_t = [33, 65, 129, 257, 513, 1025])]
    sizes: Vec<usize>,
    /// Built-in surfaces (default: all)
    #[arg(long, value_name = "NAME,...", value_delimiter = ',', value_parser = measurable)]
    surfaces: Vec<Builtin>,
    /// Wavefronts (default: those that suit the surface: anchored over floor plans only)
    #[arg(long, value_name = "NAME,...", value_delimiter = ',', value_parser = study::wavefront)]
    wavefronts: Vec<Wavefront>,
    /// What computes the maps
    #[arg(long, value_enum, default_value_t)]
    engine: EngineArg,
    /// In which precision: double leaves the method's own errors
    #[arg(long, value_enum, default_value_t)]
    precision: Precision,
    /// Where to write the report, as Markdown (default: standard output, unless --json)
    #[arg(short, long, value_name = "REPORT.md")]
    output: Option<PathBuf>,
    /// A folder for two plots: accuracy-size.png and accuracy-time.png
    #[arg(long, value_name = "FOLDER")]
    plots: Option<PathBuf>,
    /// A table of what other solvers achieve, for plots and report: surface, size (points a
    /// side), solver, seconds, mean_error (relative)
    #[arg(long, value_name = "FILE.csv")]
    peers: Option<PathBuf>,
    /// What the report says about the machine that the times come from
    #[arg(long, value_name = "TEXT")]
    machine: Option<String>,
    /// Print one JSON array with an object per map: surface, wavefront, points (a side), mean,
    /// rms, max (relative errors), order, iterations, seconds
    #[arg(long)]
    json: bool,
}

fn examples() -> String {
    format!(
        "\
Errors are relative to the exact distance, over all points but the source, which lies
near row 0.31, column 0.41 of the grid (in the maze, at the corner where its corridor
begins). The order is that of the mean error, from the size before: the base-2 logarithm
of the ratio of the errors over that of the ratio of the spacings. Times are those of
the solve alone, the shortest of a few.

Surfaces: {}.
Wavefronts: {}.

Examples:
  geosweep accuracy
  geosweep accuracy -o docs/accuracy.md --plots docs/figures --peers docs/peers.csv
  geosweep accuracy --precision double --sizes 65,129,257,513
  geosweep accuracy --surfaces sphere,sheared-plane@72 --wavefronts point --sizes 65,129 --json",
        Builtin::measurable().map(|b| b.to_string()).collect::<Vec<_>>().join(", "),
        study::wavefront_names()
    )
}

#[derive(Clone, Copy, Debug, Default, ValueEnum)]
enum EngineArg {
    /// Scans on the CPU
    #[default]
    Cpu,
    /// The first usable Vulkan device
    Vulkan,
}

fn measurable(text: &str) -> Result<Builtin, String> {
    let builtin = Builtin::parse(text)?;
    if Builtin::measurable().all(|known| known.name() != builtin.name()) {
        return Err(format!("no distances are known on {builtin} to hold a solver against"));
    }
    Ok(builtin)
}

pub fn run(args: &Args) -> Outcome {
    let outputs = Outputs::new(args)?;
    let peers = args.peers.as_deref().map_or(Ok(Vec::new()), peers::read)?;
    let sizes = study::ascending(&args.sizes);
    let surfaces = study::or_else(&args.surfaces, || Builtin::measurable().collect());
    let engine = match args.engine {
        EngineArg::Cpu => Engine::Cpu,
        EngineArg::Vulkan => Engine::Vulkan(DeviceChoice::Any),
    };
    let cases: Vec<_> = surfaces
        .into_iter()
        .map(|builtin| (builtin, study::or_else(&args.wavefronts, || suited_to(builtin, sizes[0]))))
        .collect();
    let measured = measure::all(&cases, &sizes, &engine, args.precision)?;

    let report =
        Report { args, plots: outputs.plots_link(args), measured: &measured, peers: &peers };
    let markdown = report.to_string();
    outputs.write(&markdown, &measured, &peers)?;
    if args.json {
        let rows: Vec<_> = measured.iter().map(Measurement::row).collect();
        print(serde_json::to_string(&rows)?)?;
    } else if args.output.is_none() {
        print(markdown.trim_end())?;
    }
    Ok(ExitCode::SUCCESS)
}

/// Anchors are for floor plans.
fn suited_to(builtin: Builtin, size: usize) -> Vec<Wavefront> {
    match builtin.surface(size, size) {
        Ok(surface) if surface.is_floor_plan() => Wavefront::EVERY.to_vec(),
        _ => Wavefront::ALL.to_vec(),
    }
}

/// The files to write, checked before the work begins.
struct Outputs {
    report: Option<OutputFile>,
    plots: Option<[OutputFile; 2]>,
}

impl Outputs {
    fn new(args: &Args) -> Result<Self, Box<dyn Error>> {
        let report = args.output.as_deref().map(|path| output_file(path, "a report is", "md"));
        let plots = args.plots.as_deref().map(|folder| {
            let [size, time] = plots::FILES.map(|name| png_output(&folder.join(name)));
            Ok::<_, Box<dyn Error>>([size?, time?])
        });
        Ok(Self { report: report.transpose()?, plots: plots.transpose()? })
    }

    /// The folder of the plots as seen from the report, if it lies below the report's own.
    fn plots_link(&self, args: &Args) -> Option<PathBuf> {
        let folder = args.plots.as_deref()?.canonicalize().ok()?;
        let report = std::path::absolute(args.output.as_deref()?).ok()?;
        Some(folder.strip_prefix(report.parent()?.canonicalize().ok()?).ok()?.to_owned())
    }

    /// Writes all files, then gives them their names.
    fn write(
        self,
        markdown: &str,
        measured: &[Measurement],
        peers: &[Peer],
    ) -> Result<(), Box<dyn Error>> {
        let mut staged = Vec::new();
        if let Some(report) = self.report {
            staged.push(report.stage(|writer| writer.write_all(markdown.as_bytes()))?);
        }
        if let Some([size, time]) = self.plots {
            let (by_size, by_time) =
                (plots::by_size(measured, peers), plots::by_time(measured, peers));
            staged.push(size.stage(|writer| by_size.draw().write_png(writer))?);
            staged.push(time.stage(|writer| by_time.draw().write_png(writer))?);
        }
        Ok(staged.into_iter().try_for_each(StagedFile::commit)?)
    }
}

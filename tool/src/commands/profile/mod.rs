//! Implements `geosweep profile`, which reports every pass of a map on a Vulkan device, its cost and what
//! bounds it.

mod against;
mod file;
mod kinds;
mod measure;
mod passes_csv;
mod picture;
mod renderdoc;
mod report;
mod subject;
mod trace;

use std::error::Error;
use std::path::PathBuf;
use std::process::ExitCode;

use geosweep::DEFAULT_TOLERANCE;
use geosweep::io::OutputFile;
use geosweep::vulkan::PairwiseSchedule;
use geosweep::vulkan::profile::{Capability, Grain};

use crate::choices::{Choice, auto_or, one_of};
use crate::output::{Written, check_outputs, commit, done, stage_picture, wanted_file, wanted_png};
use crate::problem::{self, SolverArgs, SourceArgs, SurfaceArgs};
use crate::terminal::{Outcome, print, print_json};
use against::{Comparison, Earlier, Whole};
use file::Summary;
use measure::{Measured, Wanted};
use report::Report;
use subject::Of;

/// The arguments of `geosweep profile`.
#[derive(clap::Args)]
#[command(after_help = examples())]
pub struct Args {
    #[command(flatten)]
    sources: SourceArgs,
    /// Profile a batch of maps from neighbouring points, in place of one map, as for the rows of a matrix on
    /// a Vulkan device. The value says where the maps are stored
    #[arg(long, value_parser = auto_or(BEST_PLACE, &PLACES))]
    #[arg(value_name = "WHERE", num_args = 0..=1, require_equals = true)]
    #[arg(default_missing_value = "auto", group = "sources", help_heading = "Sources")]
    #[arg(conflicts_with_all = ["source", "source_curve", "source_points", "schedule", "picture"])]
    pairwise: Option<Choice<PairwiseSchedule>>,
    #[command(flatten)]
    surface: SurfaceArgs,
    #[command(flatten)]
    solver: SolverArgs,

    /// Number of timed maps, after some warm-up maps: drivers compile at the first dispatch. Medians and
    /// ranges are over these maps
    #[arg(long, value_name = "N", default_value_t = 5, help_heading = "Profile")]
    #[arg(value_parser = clap::value_parser!(u32).range(1..=1000))]
    repeat: u32,
    /// Unit of work that gets its own time. Timestamps take time themselves: fewer disturb small maps less
    #[arg(long, value_name = "GRAIN", default_value = "auto")]
    #[arg(value_parser = auto_or(BEST_GRAIN, &GRAINS), help_heading = "Profile")]
    grain: Choice<Grain>,
    /// Profile as on a device without these capabilities
    #[arg(long, value_name = "NAME,...", value_delimiter = ',')]
    #[arg(value_parser = one_of(&CAPABILITIES), help_heading = "Profile")]
    without: Vec<Capability>,
    /// Capture one map with RenderDoc, which must have started the tool
    #[arg(long, help_heading = "Profile")]
    renderdoc: bool,

    /// Write the passes of the map with the median time as a trace for Perfetto or
    /// chrome://tracing
    #[arg(long, value_name = "FILE.json", help_heading = "Reports")]
    trace: Option<PathBuf>,
    /// Write the same passes as a table, one line per pass
    #[arg(long, value_name = "FILE.csv", help_heading = "Reports")]
    csv: Option<PathBuf>,
    /// Draw the texels that each scan has visited, or the tiles of each round
    #[arg(long, value_name = "FILE.png", help_heading = "Reports")]
    picture: Option<PathBuf>,
    /// Compare with an earlier profile, as --json has printed it: what got slower, by how much, and whether
    /// that is more than the noise between runs
    #[arg(long, value_name = "FILE.json", help_heading = "Reports")]
    against: Option<PathBuf>,
    /// Print one JSON object; docs/json.md and docs/geosweep.schema.json describe it
    #[arg(long, help_heading = "Reports")]
    json: bool,
}

const CAPABILITIES: [(Capability, &str); 5] = [
    (Capability::Timestamps, "Time on the device"),
    (Capability::Statistics, "Counted invocations"),
    (Capability::Executables, "Registers and spills of pipelines"),
    (Capability::Calibration, "The device's and the host's clock together"),
    (Capability::Labels, "Labels and names for tools"),
];

const BEST_PLACE: &str = "In shared memory if they fit";
const PLACES: [(PairwiseSchedule, &str); 2] = [
    (PairwiseSchedule::SharedMemory, "Each map in the shared memory of a workgroup"),
    (PairwiseSchedule::Images, "All maps in the layers of images"),
];

const BEST_GRAIN: &str = "Each scan, or something coarser if timestamps would add more than 2.5 % to a \
     map's time; with --against what was timed then";
const GRAINS: [(Grain, &str); 4] = [
    (Grain::Portions, "All iterations of a recording together"),
    (Grain::Iterations, "Each iteration"),
    (Grain::Scans, "Each scan"),
    (Grain::Blocks, "Each block of lines of a scan"),
];

fn examples() -> String {
    format!(
        "\
docs/profiling.md explains the table.

{}

Examples:
  geosweep profile builtin:sphere:400x400 --source 20,20
  geosweep profile builtin:maze:257x257 --source 0,0 --schedule tiles --picture rounds.png
  geosweep profile dem.tif --spacing 30 --source 120,85 --trace trace.json --csv passes.csv
  geosweep profile builtin:face:64x64 --pairwise --wavefront circular
  geosweep profile builtin:peaks:400x400 --source 20,20 --json > before.json
  geosweep profile builtin:peaks:400x400 --source 20,20 --against before.json",
        problem::builtin_names()
    )
}

pub fn run(args: &Args) -> Outcome {
    let options = args.solver.options()?;
    let outputs = Outputs::new(args)?;
    let earlier = args.against.as_deref().map(Earlier::read).transpose()?;
    let capture = args.renderdoc.then(renderdoc::Capture::new).transpose()?;
    let scene = args.surface.read()?;
    let sources = args.sources.sources(&scene)?.sources;
    let wanted = Wanted {
        surface: &scene.surface,
        of: args.pairwise.map_or(Of::Map(&sources), Of::Pairwise),
        options: &options,
        repeat: args.repeat,
        without: &args.without,
        // The same grain as in the earlier profile makes the records comparable.
        grain: args.grain.or(earlier.as_ref().and_then(Earlier::grain)),
        visits: args.picture.is_some(),
    };
    let measured = measure::measure(&wanted, capture)?;
    if !measured.converged {
        let tolerance = options.tolerance.unwrap_or(DEFAULT_TOLERANCE);
        problem::warn_of_no_convergence(
            &options,
            measured.iterations,
            measured.residual,
            tolerance,
        );
    }
    let summary = Summary::new(&measured);
    let comparison = earlier.as_ref().map(|earlier| Comparison::new(earlier, &summary));
    done([], &outputs.write(&measured, &scene, &sources)?);
    if args.json {
        print_json("profile", &Whole { summary: &summary, against: comparison.as_ref() })?;
    } else {
        print(Report { measured: &measured, summary: &summary, comparison: comparison.as_ref() })?;
    }
    Ok(ExitCode::SUCCESS)
}

/// The files to write. They are checked before the computation starts.
struct Outputs {
    trace: Option<OutputFile>,
    csv: Option<OutputFile>,
    picture: Option<OutputFile>,
}

impl Outputs {
    fn new(args: &Args) -> Result<Self, Box<dyn Error>> {
        let trace = wanted_file(args.trace.as_ref(), "a trace is", "json")?;
        let csv = wanted_file(args.csv.as_ref(), "a table of passes is", "csv")?;
        let picture = wanted_png(args.picture.as_ref())?;
        let files: Vec<_> = trace.iter().chain(&csv).chain(&picture).collect();
        let inputs = problem::inputs(&args.surface, &args.sources);
        check_outputs(&files, inputs.chain(args.against.as_deref()))?;
        Ok(Self { trace, csv, picture })
    }

    /// Writes all files, then moves them to their final names.
    fn write(
        self,
        measured: &Measured,
        scene: &problem::Scene,
        sources: &geosweep::Sources,
    ) -> Result<Written, Box<dyn Error>> {
        let mut staged = Vec::new();
        let run = measured.median_run();
        if let Some(output) = self.trace {
            staged.push(output.stage(|writer| trace::write(writer, measured, run))?);
        }
        if let Some(output) = self.csv {
            staged.push(output.stage(|writer| passes_csv::write(writer, run))?);
        }
        if let Some((output, visits)) = self.picture.zip(measured.visits.as_ref()) {
            let draw = || picture::draw(measured, visits, scene, sources);
            staged.push(stage_picture(output, draw)?);
        }
        Ok(commit(staged)?)
    }
}

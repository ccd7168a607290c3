//! Implements `geosweep-lab bench`, which measures how long maps take and what bounds them.

mod growth;
mod measure;
mod memory;
mod plot;
mod report;
mod surface;

use std::path::PathBuf;
use std::time::Duration;

use geosweep::vulkan::{Schedule, Tuning};
use geosweep::{DeviceChoice, Engine, Wavefront};

use super::lists;
use super::publication::Publication;
use geosweep_cli::choices::{one_of, wavefront_names};
use geosweep_cli::output::{stage_picture, wanted_file, wanted_png};
use geosweep_cli::terminal::Outcome;
pub use measure::{Measurements, Method, Plan, Timing, all as measure};
use report::{Report, summary};
pub use surface::BenchSurface;

/// The arguments of `geosweep-lab bench`.
#[derive(clap::Args)]
#[command(after_help = examples())]
pub struct Args {
    /// Points per side (default: the sizes of the paper's table 2, 150 to 1200, and 2048 and 4096 if memory
    /// allows; with --quick 150 and 400)
    #[arg(long, value_name = "N,...", value_delimiter = ',', value_parser = lists::size)]
    sizes: Vec<usize>,
    /// Built-in surfaces, terrain, or files of surfaces. A file has its own size, and heights have their
    /// file's spacing or 1 (default: plane, sphere, peaks, maze, terrain; with --quick sphere and maze)
    #[arg(long, value_name = "NAME|FILE,...", value_delimiter = ',')]
    #[arg(value_parser = BenchSurface::parse)]
    surfaces: Vec<BenchSurface>,
    /// Wavefronts (default: curved)
    #[arg(long, value_name = "NAME,...", value_delimiter = ',')]
    wavefront: Vec<Wavefront>,
    /// Engines
    #[arg(long, value_name = "NAME,...", value_delimiter = ',', value_parser = one_of(&ENGINES))]
    #[arg(default_values = ["cpu", "vulkan"])]
    engines: Vec<Engine>,
    /// Schedules on the Vulkan device (default: all; with --quick raster and tiles)
    #[arg(long, value_name = "NAME,...", value_delimiter = ',')]
    #[arg(value_parser = one_of(&Schedule::ALL.map(|schedule| (schedule, ""))))]
    schedules: Vec<Schedule>,
    /// Vulkan device: its index in `geosweep devices`, or a part of its name
    #[arg(long, value_name = "NAME|INDEX")]
    device: Option<DeviceChoice>,
    /// Portions of work on the Vulkan device, in place of the defaults for its kind: invocations and lines
    /// of a block of a scan, points per side of a tile, iterations inside a tile, and iterations or rounds
    /// per submission; `geosweep-lab tune` finds the best
    #[arg(long, value_name = "WIDTH,LINES,TILE,INNER[,TOGETHER]", value_parser = tuning)]
    tuning: Option<Tuning>,
    /// Stop a map that takes more than this, and leave out its engine or schedule at this size and larger
    /// ones (default: 3; with --quick 0.3)
    #[arg(long, value_name = "SECONDS", value_parser = seconds)]
    limit: Option<f64>,
    /// Start no map after this time, and report what is left out. Smaller sizes come first
    #[arg(long, value_name = "SECONDS", value_parser = seconds)]
    budget: Option<f64>,
    /// Fewer sizes, surfaces and runs, and a lower limit: takes about ten seconds
    #[arg(long)]
    quick: bool,
    /// Output file for the tables, as Markdown (default: standard output, unless --json)
    #[arg(short, long, value_name = "REPORT.md")]
    output: Option<PathBuf>,
    /// Draw time against points
    #[arg(long, value_name = "FILE.png")]
    plot: Option<PathBuf>,
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
Times are those of converged maps after the set-up of the surface: the median and the best
of 3 to 20 runs after a warm-up run. The set-up computes edge lengths and allocates the
solver's memory, or uploads the surface. An iteration is four scans, two updates of all
points, or a round of tiles.

The last three columns show what bounds a map: moving the data, computing the updates, or
empty dispatches. Each is the share of the time that this part would take alone at the
machine's peak rate, which is measured first. None can be much above 100 %, and the
largest is the bound; see docs/speed.md.

Surfaces: {}.
Wavefronts: {}.

Examples:
  geosweep-lab bench --quick
  geosweep-lab bench --sizes 600,1200 --surfaces sphere,maze --engines cpu --wavefront planar,curved
  geosweep-lab bench --surfaces dem.tif --schedules raster --json
  geosweep-lab bench -o speed.md --plot speed.png",
        BenchSurface::names(),
        wavefront_names()
    )
}

const ENGINES: [(Engine, &str); 3] = [
    (Engine::Cpu, "Scans on the CPU"),
    (Engine::Vulkan(DeviceChoice::Any), "A Vulkan device"),
    (Engine::FastMarching, "Fast marching on the CPU: updates in the order of time"),
];

const TABLE_2: [usize; 9] = [150, 200, 400, 600, 800, 1000, 1200, 2048, 4096];

/// Parses a duration in seconds.
pub fn seconds(text: &str) -> Result<f64, String> {
    match text.parse() {
        Ok(seconds) if (0.0..=1e6).contains(&seconds) => Ok(seconds),
        _ => Err("a limit is a number of seconds of at least 0".into()),
    }
}

fn tuning(text: &str) -> Result<Tuning, String> {
    let numbers: Result<Vec<u32>, _> = text.split(',').map(str::parse).collect();
    match numbers.as_deref() {
        Ok(&[scan_width, scan_lines, tile, inner, ref together @ ..]) if together.len() < 2 => {
            let together = together.first().copied();
            Ok(Tuning { scan_width, scan_lines, tile, inner, together, ..Tuning::ON_CPU })
        }
        _ => Err("portions are four or five numbers, such as 128,8,16,4".into()),
    }
}

pub fn run(args: &Args) -> Outcome {
    let output = wanted_file(args.output.as_ref(), "a report is", "md")?;
    let plot = wanted_png(args.plot.as_ref())?;
    let plan = args.plan();
    let measured = measure(&plan)?;

    let sheet = || plot::by_points(&measured.timings, &plan.methods).draw();
    let plot = plot.map(|plot| stage_picture(plot, sheet)).transpose()?;
    Publication {
        command: "bench",
        markdown: Report { measured: &measured, machine: args.machine.as_deref() }.to_string(),
        output,
        pictures: plot.into_iter().collect(),
        rows: &summary(&measured),
    }
    .publish(args.json)
}

impl Args {
    fn plan(&self) -> Plan {
        let sizes = if self.quick { &[150, 400][..] } else { &TABLE_2 };
        let surfaces =
            if self.quick { BenchSurface::quick_set() } else { BenchSurface::default_set() };
        let schedules = lists::or_else(&self.schedules, || match self.quick {
            true => vec![Schedule::Raster, Schedule::Tiles],
            false => Schedule::ALL.to_vec(),
        });
        let of_engine = |engine: &Engine| match engine {
            Engine::FastMarching => vec![Method::FastMarching],
            Engine::Vulkan(_) => schedules.iter().copied().map(Method::Vulkan).collect(),
            Engine::Cpu | Engine::Auto => vec![Method::Cpu],
        };
        Plan {
            surfaces: lists::or_else(&self.surfaces, || surfaces),
            sizes: lists::ascending(if self.sizes.is_empty() { sizes } else { &self.sizes }),
            wavefronts: lists::or_else(&self.wavefront, || vec![Wavefront::Curved]),
            methods: lists::or_else(&self.engines, Vec::new).iter().flat_map(of_engine).collect(),
            device: self.device.clone().unwrap_or_default(),
            tuning: self.tuning,
            iterations: None,
            limit: Duration::from_secs_f64(self.limit.unwrap_or(if self.quick {
                0.3
            } else {
                3.0
            })),
            budget: self.budget.map(Duration::from_secs_f64),
            long_enough: Duration::from_millis(if self.quick { 100 } else { 500 }),
        }
    }
}

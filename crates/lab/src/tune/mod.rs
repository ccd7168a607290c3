//! Implements `geosweep-lab tune`, which finds the portions of work and the schedule that suit a Vulkan device.

mod report;
mod results;
mod suggest;
mod sweep;

use geosweep_cli::warning;
use std::path::PathBuf;
use std::process::ExitCode;
use std::time::Duration;

use geosweep::{DeviceChoice, Wavefront};

use super::bench::{BenchSurface, seconds};
use super::lists;
use super::publication::Publication;
use geosweep_cli::output::wanted_file;
use geosweep_cli::terminal::Outcome;
use report::{Report, summary};
use sweep::{Plan, sweep};

/// The arguments of `geosweep-lab tune`.
#[derive(clap::Args)]
#[command(after_help = EXAMPLES)]
pub struct Args {
    /// Points per side (default: 64, 256, 1024; with --quick 64, 256)
    #[arg(long, value_name = "N,...", value_delimiter = ',', value_parser = lists::size)]
    sizes: Vec<usize>,
    /// Built-in surfaces, terrain, or files of surfaces, as `geosweep-lab bench` takes them (default: sphere,
    /// maze)
    #[arg(long, value_name = "NAME|FILE,...", value_delimiter = ',')]
    #[arg(value_parser = BenchSurface::parse)]
    surfaces: Vec<BenchSurface>,
    /// Wavefront
    #[arg(long, value_name = "NAME", default_value = "curved")]
    wavefront: Wavefront,
    /// Vulkan device: its index in `geosweep devices`, or a part of its name
    #[arg(long, value_name = "NAME|INDEX")]
    device: Option<DeviceChoice>,
    /// Leave out a map that takes longer than this with the device's default portions of work (default: 2;
    /// with --quick 0.5)
    #[arg(long, value_name = "SECONDS", value_parser = seconds)]
    limit: Option<f64>,
    /// Start no measurement after this time, and report what is left out (default: 300; with --quick 60)
    #[arg(long, value_name = "SECONDS", value_parser = seconds)]
    budget: Option<f64>,
    /// Fewer sizes, values and runs
    #[arg(long)]
    quick: bool,
    /// Output file for the tables, as Markdown (default: standard output, unless --json)
    #[arg(short, long, value_name = "REPORT.md")]
    output: Option<PathBuf>,
    /// Print one JSON object; docs/json.md and docs/geosweep.schema.json describe it
    #[arg(long)]
    json: bool,
}

const EXAMPLES: &str = "\
One number is changed at a time. The others keep the defaults for this kind of device.
Runs of each map alternate with runs of the untuned map, and the two maps are compared.
The best value of each number is suggested if its maps take less than 0.97 of the untuned
time. All suggested values together are timed once more. Times are the best of several
runs by the host's clock. The exit status is 1 if a map differs from the untuned one by
more than 1e-5 of the largest distance.

Examples:
  geosweep-lab tune --quick
  geosweep-lab tune --sizes 512,2048 --surfaces terrain --device NVIDIA -o tuning.md
  geosweep-lab bench --tuning 64,4,16,4 --schedules raster,tiles --engines vulkan";

pub fn run(args: &Args) -> Outcome {
    let output = wanted_file(args.output.as_ref(), "a report is", "md")?;
    let quick = |quick: f64, whole: f64| if args.quick { quick } else { whole };
    let sizes: &[usize] = if args.quick { &[64, 256] } else { &[64, 256, 1024] };
    let plan = Plan {
        surfaces: lists::or_else(&args.surfaces, BenchSurface::quick_set),
        sizes: lists::ascending(if args.sizes.is_empty() { sizes } else { &args.sizes }),
        wavefront: args.wavefront,
        device: args.device.clone().unwrap_or_default(),
        limit: Duration::from_secs_f64(args.limit.unwrap_or(quick(0.5, 2.0))),
        budget: Duration::from_secs_f64(args.budget.unwrap_or(quick(60.0, 300.0))),
        runs: if args.quick { 3 } else { 5 },
        quick: args.quick,
    };
    let swept = sweep(&plan)?;
    let differing = swept.differing();
    for row in &differing {
        let (knob, value) = (row.knob.name(), row.value);
        warning!("{knob} {value}: maps differ from the untuned ones");
    }
    let status = if differing.is_empty() { ExitCode::SUCCESS } else { ExitCode::FAILURE };
    Publication {
        command: "tune",
        markdown: Report(&swept).to_string(),
        output,
        pictures: Vec::new(),
        rows: &summary(&swept),
    }
    .publish(args.json)?;
    Ok(status)
}

//! Implements `geosweep-lab frames`, which measures the cost of a map in a renderer's frame.

mod host;
mod measure;
mod report;

use std::path::PathBuf;
use std::time::Duration;

use geosweep::vulkan::Schedule;
use geosweep::{DeviceChoice, Wavefront};

use super::bench::seconds;
use super::lists;
use super::publication::Publication;
use geosweep_cli::choices::one_of;
use geosweep_cli::output::wanted_file;
use geosweep_cli::terminal::Outcome;
use measure::{Plan, measure};
use report::{Report, summary};

/// The arguments of `geosweep-lab frames`.
#[derive(clap::Args)]
#[command(after_help = EXAMPLES)]
pub struct Args {
    /// Points per side
    #[arg(long, value_name = "N,...", value_delimiter = ',', value_parser = lists::size)]
    #[arg(default_values = ["64", "256", "1024"])]
    sizes: Vec<usize>,
    /// Schedules
    #[arg(long, value_name = "NAME,...", value_delimiter = ',')]
    #[arg(value_parser = one_of(&Schedule::ALL.map(|schedule| (schedule, ""))))]
    #[arg(default_values = ["raster", "tiles"])]
    schedules: Vec<Schedule>,
    /// Wavefront
    #[arg(long, value_name = "NAME", default_value = "curved")]
    wavefront: Wavefront,
    /// Vulkan device: its index in `geosweep devices`, or a part of its name
    #[arg(long, value_name = "NAME|INDEX")]
    device: Option<DeviceChoice>,
    /// Frames of each size and schedule, after three warm-up frames
    #[arg(long, value_name = "N", default_value_t = 60)]
    #[arg(value_parser = clap::value_parser!(u32).range(1..=100_000))]
    frames: u32,
    /// Largest number of iterations of scans in a frame. The number of rounds of tiles follows from the
    /// grid's size
    #[arg(long, value_name = "N", default_value_t = 8)]
    #[arg(value_parser = clap::value_parser!(u32).range(1..=1000))]
    iterations: u32,
    /// Start no further frames of a size and schedule after this time
    #[arg(long, value_name = "SECONDS", default_value = "10", value_parser = seconds)]
    limit: f64,
    /// Output file for the table, as Markdown (default: standard output, unless --json)
    #[arg(short, long, value_name = "REPORT.md")]
    output: Option<PathBuf>,
    /// Print one JSON object; docs/json.md and docs/geosweep.schema.json describe it
    #[arg(long)]
    json: bool,
}

const EXAMPLES: &str = "\
A sheet moves from frame to frame. The device's memory holds its vertices in eight phases
of the motion. Each frame measures the edges, solves the map from a source that moves too,
and leaves the distances for a renderer to sample. The time on the device is that between
two timestamps around all of this. The time on the host is that from the submission until
its fence is signalled.

Examples:
  geosweep-lab frames
  geosweep-lab frames --sizes 512 --schedules tiles --frames 300 --json";

pub fn run(args: &Args) -> Outcome {
    let output = wanted_file(args.output.as_ref(), "a report is", "md")?;
    let measured = measure(&Plan {
        sizes: lists::ascending(&args.sizes),
        schedules: lists::or_else(&args.schedules, Vec::new),
        wavefront: args.wavefront,
        device: args.device.clone().unwrap_or_default(),
        frames: args.frames,
        iterations: args.iterations,
        limit: Duration::from_secs_f64(args.limit),
    })?;
    Publication {
        command: "frames",
        markdown: Report(&measured).to_string(),
        output,
        pictures: Vec::new(),
        rows: &summary(&measured),
    }
    .publish(args.json)
}

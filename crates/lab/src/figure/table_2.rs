//! Implements `geosweep-lab figure table-2`: the paper's table 2.

use geosweep_cli::note;
use std::fmt::{self, Display, Formatter};
use std::path::PathBuf;
use std::time::Duration;

use geosweep::vulkan::{HeadlessSolver, Schedule};
use geosweep::{DeviceChoice, Wavefront};
use serde::Serialize;

use super::table::{Paper, on_a};
use crate::bench::{self, BenchSurface, Measurements, Method, Plan, Timing};
use crate::lists;
use crate::publication::Publication;
use geosweep_cli::output::wanted_file;
use geosweep_cli::terminal::{List, Outcome};

/// The arguments of `geosweep-lab figure table-2`.
#[derive(clap::Args)]
#[command(after_help = EXAMPLES)]
pub struct Args {
    /// Output file for the table, as Markdown (default: standard output, unless --json)
    #[arg(short, long, value_name = "TABLE.md")]
    output: Option<PathBuf>,
    /// Points per side (default: those of the paper)
    #[arg(long, value_name = "N,...", value_delimiter = ',', value_parser = lists::size)]
    #[arg(default_values_t = PAPER.sides())]
    sizes: Vec<usize>,
    /// Surface: built-in, terrain or a file, as for `geosweep-lab bench`
    #[arg(long, value_name = "NAME", default_value = "sphere", value_parser = BenchSurface::parse)]
    surface: BenchSurface,
    /// Vulkan device: its index in `geosweep devices`, or a part of its name (default: the first usable one;
    /// without any, the table has only the CPU)
    #[arg(long, value_name = "NAME|INDEX")]
    device: Option<DeviceChoice>,
    /// Machine on which the times were measured, for the table
    #[arg(long, value_name = "TEXT")]
    machine: Option<String>,
    /// Print one JSON object; docs/json.md and docs/geosweep.schema.json describe it
    #[arg(long)]
    json: bool,
}

const EXAMPLES: &str = "\
Single maps from a point: one iteration of raster scans with the planar wavefront, as
in the paper, and a converged map with the curved one. Times are taken as by `geosweep
bench`: the median of 3 to 20 runs after a warm-up run, without the set-up of the surface.

Examples:
  geosweep-lab figure table-2
  geosweep-lab figure table-2 --sizes 150,400 --json";

/// The milliseconds of an iteration, and the megabytes, on an nVidia 7950 GT in 2008.
const PAPER: Paper<7, 2> = Paper([
    (150, [111.0, 1.62]),
    (200, [120.8, 2.88]),
    (400, [162.9, 11.52]),
    (600, [276.6, 25.92]),
    (800, [419.2, 46.08]),
    (1000, [612.5, 72.0]),
    (1200, [736.2, 103.68]),
]);

/// The times of an engine at one size.
#[derive(Serialize)]
struct Row {
    engine: &'static str,
    rows: usize,
    cols: usize,
    points: usize,
    iteration_seconds: f64,
    iteration_spread: f64,
    iteration_bytes: Option<u64>,
    converged_seconds: f64,
    converged_spread: f64,
    converged_iterations: u32,
    converged_bytes: Option<u64>,
}

pub fn run(args: &Args) -> Outcome {
    let output = wanted_file(args.output.as_ref(), "a table is", "md")?;
    let device = args.device.clone().unwrap_or_default();
    let mut methods = vec![Method::Cpu];
    match HeadlessSolver::new(&device) {
        Ok(_) => methods.push(Method::Vulkan(Schedule::Raster)),
        Err(error) if args.device.is_some() => return Err(error.into()),
        Err(error) => note!("the table shows only the CPU: {error}"),
    }
    let measure = |wavefront, iterations| {
        bench::measure(&Plan {
            surfaces: vec![args.surface.clone()],
            sizes: lists::ascending(&args.sizes),
            wavefronts: vec![wavefront],
            methods: methods.clone(),
            device: device.clone(),
            tuning: None,
            iterations,
            limit: Duration::from_secs(600),
            budget: None,
            long_enough: Duration::from_secs(1),
        })
    };
    let once = measure(Wavefront::Planar, Some(1))?;
    let converged = measure(Wavefront::Curved, None)?;
    let rows: Vec<Row> =
        once.timings.iter().zip(&converged.timings).map(|(a, b)| Row::new(a, b)).collect();
    let markdown = Table { args, measured: &once, rows: &rows }.to_string();
    let (command, rows) = ("figure table-2", &List("sizes", &rows));
    Publication { command, markdown, output, pictures: Vec::new(), rows }.publish(args.json)
}

impl Row {
    /// Combines two timings of the same method on the same grid.
    fn new(once: &Timing, converged: &Timing) -> Self {
        Self {
            engine: once.method.engine(),
            rows: once.rows,
            cols: once.cols,
            points: once.points,
            iteration_seconds: once.median(),
            iteration_spread: once.spread(),
            iteration_bytes: once.bytes,
            converged_seconds: converged.median(),
            converged_spread: converged.spread(),
            converged_iterations: converged.iterations,
            converged_bytes: converged.bytes,
        }
    }
}

/// The rows as Markdown.
struct Table<'a> {
    args: &'a Args,
    measured: &'a Measurements,
    rows: &'a [Row],
}

impl Display for Table<'_> {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let machine = on_a(self.args.machine.as_ref());
        let device = match &self.measured.device {
            Some((name, _)) => format!("; vulkan is {name}"),
            None => String::new(),
        };
        writeln!(
            f,
            "\
# Table 2: time and memory of single maps

Distances from one point of the {} to all others, in milliseconds{machine}{device}: medians, and
half the distance of the quartiles. One iteration: four raster scans with the planar wavefront, as in
the paper. Converged: with the curved wavefront, as many iterations as it takes (in brackets).
Memory is what a solver holds that is kept for further maps, edge lengths included, in megabytes; on
the CPU a single planar map takes 25 bytes a point. The paper's own figures, from its table 2, are
those of one iteration on an nVidia 7950 GT in 2008.
",
            self.args.surface
        )?;
        writeln!(
            f,
            "\
| points | engine | one iteration | memory | M points/s | converged, curved | memory | paper: one iteration | memory |
|---:|---|---:|---:|---:|---:|---:|---:|---:|"
        )?;
        self.rows.iter().try_for_each(|row| {
            // The paper has square grids only.
            let side = if row.rows == row.cols { row.rows } else { 0 };
            let [time, bytes] =
                PAPER.cells(side, |[time, bytes]| [format!("{time:.0}"), format!("{bytes:.1}")]);
            let held = |bytes: Option<u64>| match bytes {
                Some(bytes) => format!("{:.1}", 1e-6 * bytes as f64),
                None => String::new(),
            };
            writeln!(
                f,
                "| {} x {} | {} | {:.2} ± {:.2} | {} | {:.0} | {:.2} ± {:.2} ({}) | {} | {time} | {bytes} |",
                row.rows,
                row.cols,
                row.engine,
                1e3 * row.iteration_seconds,
                1e3 * row.iteration_spread,
                held(row.iteration_bytes),
                1e-6 * row.points as f64 / row.iteration_seconds,
                1e3 * row.converged_seconds,
                1e3 * row.converged_spread,
                row.converged_iterations,
                held(row.converged_bytes),
            )
        })
    }
}

//! Implements `geosweep-lab figure table-1`: the paper's table 1.

use std::error::Error;
use std::fmt::{self, Display, Formatter};
use std::path::PathBuf;

use geosweep::cpu::Instructions;
use geosweep::pairwise::{Pairwise, PairwiseReport};
use geosweep::surface::builtin::Builtin;
use geosweep::{Engine, Options, Surface, Wavefront};
use serde::Serialize;

use super::table::{Paper, on_a};
use crate::lists;
use crate::publication::Publication;
use geosweep_cli::numbers::whole;
use geosweep_cli::output::wanted_file;
use geosweep_cli::terminal::{List, Outcome, progress};

/// The arguments of `geosweep-lab figure table-1`.
#[derive(clap::Args)]
#[command(after_help = EXAMPLES)]
pub struct Args {
    /// Output file for the table, as Markdown (default: standard output, unless --json)
    #[arg(short, long, value_name = "TABLE.md")]
    output: Option<PathBuf>,
    /// Points per side (default: those of the paper)
    #[arg(long, value_name = "N,...", value_delimiter = ',', value_parser = whole("points per side", 4..=128))]
    #[arg(default_values_t = PAPER.sides())]
    sizes: Vec<usize>,
    /// The built-in surface
    #[arg(long, value_name = "NAME", default_value = "sphere", value_parser = Builtin::parse)]
    surface: Builtin,
    /// Runs of each method, whose median counts
    #[arg(long, value_name = "N", default_value_t = 10, value_parser = whole("runs", 1..=1000))]
    runs: usize,
    /// Machine on which the times were measured, for the table
    #[arg(long, value_name = "TEXT")]
    machine: Option<String>,
    /// Print one JSON object; docs/json.md and docs/geosweep.schema.json describe it
    #[arg(long)]
    json: bool,
}

const EXAMPLES: &str = "\
All distances between the points of a square grid, by three methods: one iteration of
raster scans with the planar wavefront, sixteen maps in the lanes of one instruction
stream; this library's fast marching with the same wavefront, one map per thread; and
converged raster scans with the circular wavefront. Memory is allocated before the
clock starts.

Examples:
  geosweep-lab figure table-1
  geosweep-lab figure table-1 --sizes 32,64 --runs 3 --json";

/// The seconds of the raster scan and of fast marching on an AMD Opteron with SSE2 in 2008.
const PAPER: Paper<6, 2> = Paper([
    (32, [0.1541, 1.2824]),
    (44, [0.5156, 5.5156]),
    (50, [0.8348, 9.4335]),
    (54, [1.1336, 12.9128]),
    (60, [1.8539, 19.5472]),
    (64, [2.4762, 25.8347]),
]);

#[derive(Serialize)]
struct Row {
    #[serde(skip)]
    side: usize,
    vertices: usize,
    distances: usize,
    planar_seconds: f64,
    planar_spread: f64,
    fast_marching_seconds: f64,
    fast_marching_spread: f64,
    speed_up: f64,
    planar_distances_per_second: f64,
    circular_seconds: f64,
    circular_spread: f64,
    circular_distances_per_second: f64,
}

pub fn run(args: &Args) -> Outcome {
    let output = wanted_file(args.output.as_ref(), "a table is", "md")?;
    let sizes = lists::ascending(&args.sizes);
    let bar = progress(sizes.len());
    let mut rows = Vec::new();
    for side in sizes {
        bar.set_message(format!("{side} x {side} points"));
        rows.push(Row::measure(args.surface, side, args.runs)?);
        bar.inc(1);
    }
    bar.finish_and_clear();
    let markdown = Table { args, rows: &rows }.to_string();
    let (command, rows) = ("figure table-1", &List("sizes", &rows));
    Publication { command, markdown, output, pictures: Vec::new(), rows }.publish(args.json)
}

impl Row {
    fn measure(builtin: Builtin, side: usize, runs: usize) -> Result<Self, Box<dyn Error>> {
        let surface = builtin.surface(side, side)?;
        let options = |engine, wavefront, iterations| {
            Options::default()
                .with_engine(engine)
                .with_wavefront(wavefront)
                .with_iterations(iterations)
        };
        let planar = options(Engine::Cpu, Wavefront::Planar, Some(1));
        let (planar_seconds, planar_spread) = median(&surface, &planar, runs)?;
        let circular = options(Engine::Cpu, Wavefront::Circular, None);
        let (circular_seconds, circular_spread) = median(&surface, &circular, runs)?;
        let marching = options(Engine::FastMarching, Wavefront::Planar, None);
        let (fast_marching_seconds, fast_marching_spread) = median(&surface, &marching, runs)?;
        let distances = (side * side).pow(2);
        Ok(Self {
            side,
            vertices: side * side,
            distances,
            planar_seconds,
            planar_spread,
            fast_marching_seconds,
            fast_marching_spread,
            speed_up: fast_marching_seconds / planar_seconds,
            planar_distances_per_second: distances as f64 / planar_seconds,
            circular_seconds,
            circular_spread,
            circular_distances_per_second: distances as f64 / circular_seconds,
        })
    }
}

/// Returns the median time of a whole matrix, and half the interquartile range of the runs.
fn median(surface: &Surface, options: &Options, runs: usize) -> Result<(f64, f64), Box<dyn Error>> {
    let mut pairwise = Pairwise::new(surface, options)?;
    let run = |_| {
        let (_, PairwiseReport { solve_time, .. }) = pairwise.matrix(|_| ())?;
        Ok(solve_time.as_secs_f64())
    };
    // The runs stay on rayon's own threads. Threads that are woken up for each short run often end up on the
    // same core.
    let all = |_: &_| (0..runs).map(run).collect::<Result<Vec<f64>, geosweep::Error>>();
    let mut seconds = rayon::scope(all)?;
    seconds.sort_by(f64::total_cmp);
    let at = |fraction: f64| seconds[((runs - 1) as f64 * fraction).round() as usize];
    Ok((at(0.5), 0.5 * (at(0.75) - at(0.25))))
}

/// The rows as Markdown.
struct Table<'a> {
    args: &'a Args,
    rows: &'a [Row],
}

impl Display for Table<'_> {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let machine = on_a(self.args.machine.as_ref());
        let (threads, surface) = (rayon::current_num_threads(), self.args.surface);
        let (instructions, runs) = (Instructions::best(), self.args.runs);
        writeln!(
            f,
            "\
# Table 1: time of all pairs

All distances between the points of a grid on the {surface}, in seconds{machine},
{threads} threads, {instructions}: medians of {runs} runs and half the distance of their quartiles. Raster
scan: one iteration, planar wavefront. Circular: the same with circular wavefronts until
they have converged. The paper's own figures, from its table 1, are those of an AMD Opteron with
SSE2 in 2008.
"
        )?;
        writeln!(
            f,
            "\
| vertices | distances | raster scan | fast marching | speed-up | distances/s | circular, converged | distances/s | paper: raster scan | fast marching | speed-up |
|---:|---:|---:|---:|---:|---:|---:|---:|---:|---:|---:|"
        )?;
        self.rows.iter().try_for_each(|row| {
            let [scan, marching, ratio] = PAPER.cells(row.side, |[scan, marching]| {
                [format!("{scan:.2}"), format!("{marching:.1}"), format!("{:.1}", marching / scan)]
            });
            writeln!(
                f,
                "| {} | {} | {:.4} ± {:.4} | {:.2} ± {:.2} | {:.0} | {:.0} M | {:.4} ± {:.4} | {:.0} M | \
                 {scan} | {marching} | {ratio} |",
                row.vertices,
                row.distances,
                row.planar_seconds,
                row.planar_spread,
                row.fast_marching_seconds,
                row.fast_marching_spread,
                row.speed_up,
                1e-6 * row.planar_distances_per_second,
                row.circular_seconds,
                row.circular_spread,
                1e-6 * row.circular_distances_per_second,
            )
        })
    }
}

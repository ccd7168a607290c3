//! Implements `geosweep-lab figure maze`: the paper's figure 6.

use std::path::PathBuf;
use std::process::ExitCode;

use geosweep::Stop;
use geosweep::cpu::twins::scan_in_turn;
use geosweep::surface::builtin::Builtin;
use geosweep::surface::{EdgeLengths, Seed};
use geosweep::{DEFAULT_TOLERANCE, Sources, Surface, Wavefront};
use serde::Serialize;

use crate::lists;
use crate::panels::{Panel, Panels};
use geosweep_cli::output::{commit, done, png_output, stage_picture};
use geosweep_cli::terminal::{List, Outcome, print_json};

/// The arguments of `geosweep-lab figure maze`.
#[derive(clap::Args)]
#[command(after_help = EXAMPLES)]
pub struct Args {
    /// Output file for the picture
    #[arg(short, long, value_name = "FILE.png")]
    output: PathBuf,
    /// Points per side
    #[arg(long, value_name = "N", default_value_t = 201, value_parser = lists::size)]
    size: usize,
    /// Print one JSON object; docs/json.md and docs/geosweep.schema.json describe it
    #[arg(long)]
    json: bool,
}

const EXAMPLES: &str = "\
The distance from the outer end of the corridor of the built-in maze after one, two
and three iterations and, if the map has not converged by then, at convergence. An
iteration is the four rotated scans (down, up, right, left) of a GPU, computed here on
the CPU with the circular wavefront. Walls are light grey. Points that are not
reached yet are hatched.

Examples:
  geosweep-lab figure maze -o maze.png
  geosweep-lab figure maze --size 401 --json -o maze.png";

/// The corner at which the corridor begins.
const SOURCE: [f64; 2] = [0.0, 0.0];
/// The numbers of iterations that the paper shows.
const ITERATIONS: [u32; 3] = [1, 2, 3];
/// A number of iterations that suffices for any maze.
const ENOUGH: u32 = 1000;

/// The map after a number of iterations.
#[derive(Serialize)]
struct Stage {
    iterations: u32,
    converged: bool,
    points: usize,
    reached: usize,
    #[serde(skip)]
    distances: Vec<f32>,
}

pub fn run(args: &Args) -> Outcome {
    let output = png_output(&args.output)?;
    let surface = Builtin::Maze.surface(args.size, args.size)?;
    let sources = Sources::point(SOURCE[0], SOURCE[1]);
    let stages = stages(&surface, &sources)?;
    let panels: Vec<_> = stages.iter().map(Stage::panel).collect();
    let picture = Panels { surface: &surface, sources: &sources, panels: &panels };
    done([], &commit([stage_picture(output, || picture.draw())?])?);
    if args.json {
        print_json("figure maze", &List("stages", &stages))?;
    }
    Ok(ExitCode::SUCCESS)
}

/// Returns the maps after each of [`ITERATIONS`] and, if more are needed, the converged map.
fn stages(surface: &Surface, sources: &Sources) -> Result<Vec<Stage>, geosweep::Error> {
    let edges = EdgeLengths::new(surface)?;
    let seeds = sources.seeds(surface)?;
    let mut stages = Vec::new();
    for iterations in ITERATIONS.into_iter().chain([ENOUGH]) {
        let stage = Stage::after(iterations, surface, &edges, &seeds);
        let last = stage.converged;
        stages.push(stage);
        if last {
            break;
        }
    }
    Ok(stages)
}

impl Stage {
    fn after(iterations: u32, surface: &Surface, edges: &EdgeLengths<f32>, seeds: &[Seed]) -> Self {
        let stop = Stop::within(DEFAULT_TOLERANCE).or_after(iterations);
        let solution = scan_in_turn(edges, seeds, Wavefront::Circular, stop);
        let distances = solution.distances();
        Self {
            iterations: solution.iterations,
            converged: solution.residual <= stop.tolerance,
            points: surface.points(),
            reached: distances.iter().filter(|distance| distance.is_finite()).count(),
            distances,
        }
    }

    fn panel(&self) -> Panel<'_> {
        let Self { iterations, converged, points, reached, .. } = self;
        let plural = if *iterations == 1 { "" } else { "s" };
        let state = if *converged { ", converged" } else { "" };
        Panel {
            title: format!("{iterations} iteration{plural}{state}"),
            subtitle: format!("{reached} of {points} points reached"),
            values: &self.distances,
        }
    }
}

//! Implements `geosweep value`, which prints distances at places, also between grid points.

use std::fmt;
use std::process::ExitCode;

use geosweep::geometry::{PathError, PathTracer};
use geosweep::shown::exact;
use geosweep::surface::EdgeLengths;
use serde::Serialize;

use crate::numbers::{coordinates, place, place_xy};
use crate::output::check_outputs;
use crate::problem::{self, MapReport, SolverArgs, SourceArgs, SurfaceArgs};
use crate::terminal::{List, Outcome, print};

/// The arguments of `geosweep value`.
#[derive(clap::Args)]
#[command(after_help = examples())]
pub struct Args {
    /// Place: row and column, which may be fractional; repeatable
    #[arg(long, value_name = "R,C", value_parser = place, allow_hyphen_values = true)]
    #[arg(required_unless_present = "at_xy")]
    at: Vec<[f64; 2]>,
    /// Place in map coordinates, if SURFACE is georeferenced, or longitude and latitude; repeatable. In the output
    /// they come after the places of --at
    #[arg(long, value_name = "X,Y", value_parser = coordinates, allow_hyphen_values = true)]
    at_xy: Vec<[f64; 2]>,

    #[command(flatten)]
    sources: SourceArgs,
    #[command(flatten)]
    surface: SurfaceArgs,
    #[command(flatten)]
    solver: SolverArgs,

    /// Print one JSON object in place of lines; docs/json.md and docs/geosweep.schema.json describe it
    #[arg(long, help_heading = "Reports")]
    json: bool,
}

/// The distance of a place.
#[derive(Serialize)]
struct Value {
    row: f64,
    col: f64,
    distance: Distance,
}

/// A distance: in double precision at the grid points of a map in double precision, and otherwise in single
/// precision.
#[derive(Clone, Copy, Serialize)]
#[serde(untagged)]
enum Distance {
    Single(f32),
    Double(f64),
}

impl fmt::Display for Distance {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Single(distance) => distance.fmt(f),
            Self::Double(distance) => distance.fmt(f),
        }
    }
}

fn examples() -> String {
    format!(
        "\
Prints a line `row,column,distance` for each place, in the order given. Between grid
points, the distance is the earliest arrival along a straight line across the cell. It is
an error if a place is outside the grid, in a hole or not reached by any source.

{}

Examples:
  geosweep value dem.tif --source 120,85 --at 10.5,10.25
  geosweep value builtin:sphere:129x129 --source 64,64 --at 3.2,99.5 --at 0,0",
        problem::builtin_names()
    )
}

pub fn run(args: &Args) -> Outcome {
    let options = args.solver.options()?;
    check_outputs(&[], problem::inputs(&args.surface, &args.sources))?;
    let scene = args.surface.read()?;
    let sources = args.sources.sources(&scene)?;
    let mut at = args.at.clone();
    for &place in &args.at_xy {
        at.push(place_xy("--at-xy", &scene.frame(), place)?);
    }
    let place = |&place| scene.place(place).map_err(|why| format!("--at {why}"));
    let places: Vec<_> = at.iter().map(place).collect::<Result<_, _>>()?;
    let precision = problem::default_precision(&args.surface, &args.solver);
    let (map, double) = problem::solve_in(precision, &scene, &sources, &options)?;
    let edges = EdgeLengths::new(&scene.surface)?;
    // The distance at a place is the map's value, whether its path is shortened or not.
    let paths = PathTracer::new(&scene.surface, &edges, &sources, &map.distances)?.along_the_map();
    let found = paths.trace_all(&places).into_iter().collect::<Result<Vec<_>, PathError>>();
    let found = found.map_err(|error| scene.explain_path(error))?;
    let values = at.iter().zip(&places).zip(found).map(|((&[row, col], &place), path)| {
        let at_point = problem::double_at(double.as_ref(), place).map(Distance::Double);
        let distance = at_point.unwrap_or(Distance::Single(path.distance as f32));
        Value { row, col, distance }
    });
    if args.json {
        let map = MapReport::new(&scene, &map, double.as_ref());
        map.print("value", &List("values", &values.collect::<Vec<_>>()))?;
        return Ok(ExitCode::SUCCESS);
    }
    for Value { row, col, distance } in values {
        print(format!("{},{},{distance}", exact(row), exact(col)))?;
    }
    Ok(ExitCode::SUCCESS)
}

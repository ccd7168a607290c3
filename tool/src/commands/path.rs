//! `geosweep path`: shortest paths back to the sources.

use std::path::PathBuf;
use std::process::ExitCode;

use geosweep::geometry::{CurveError, Path, PathError, Paths};
use geosweep::io::{Attribute, IoError, Polyline, read_curves};
use geosweep::surface::EdgeLengths;
use serde::Serialize;

use super::over_map::draw_over_map;
use crate::numbers::place;
use crate::output::{commit, stage_picture};
use crate::picture::{path_line, rgb};
use crate::problem::{self, CurveFiles, MapSummary, Problem, ProblemArgs, Scene};
use crate::terminal::{Outcome, Spinner, print_json};

/// The arguments of `geosweep path`.
#[derive(clap::Args)]
#[command(after_help = examples())]
pub struct Args {
    /// Where to write the paths, repeatable: .npy float64 (k, 5) with row, column, x, y, z of each
    /// vertex from the start to the source, and a row of NaN between paths; .csv; .svg (the
    /// parameter domain); .geojson (from a GeoTIFF, in its coordinates); .ply or .obj (in space)
    #[arg(short, long, value_name = "PATHS", required_unless_present_any = ["picture", "json"])]
    output: Vec<PathBuf>,
    /// Where a path starts that leads back to its source: row and column, which may be fractional;
    /// repeatable
    #[arg(long, visible_alias = "to", value_name = "R,C", value_parser = place)]
    #[arg(allow_hyphen_values = true)]
    #[arg(required_unless_present = "from_file")]
    from: Vec<[f64; 2]>,
    /// A file of starts, after those of --from: an .npy array (K, 2) of rows and columns or (K, 5) as
    /// `geosweep sample` writes, or a text file with a line `row,col` for each, which may have more
    /// columns if its first line names them
    #[arg(long, value_name = "FILE")]
    from_file: Option<PathBuf>,

    #[command(flatten)]
    problem: ProblemArgs,

    /// Print one JSON object: what `distance --json` says of the map, and paths, an array of
    /// objects with from, distance (the map's value at the start), length (the path's own; with
    /// the source's start value it is the distance but for errors), source (its index in the order
    /// of points, then curves) and vertices
    #[arg(long, help_heading = "Reports")]
    json: bool,
}

fn examples() -> String {
    format!(
        "\
A start that is outside the grid, in a hole or not reached by any source is an
error, and nothing is written.

{}

Examples:
  geosweep path dem.tif --source 120,85 --from 10,10 --from 300.5,42 -o paths.geojson
  geosweep path builtin:maze:201x201 --source 0,0 --from 100,98 -o path.npy \\
      --picture path.png
  geosweep path scan.npy --source 80,64 --from-file starts.csv -o paths.obj --json",
        problem::builtin_names()
    )
}

pub fn run(args: &Args) -> Outcome {
    let files = CurveFiles::new(&args.output)?;
    let starts = args.starts()?;
    let Problem { scene, sources, map, picture } =
        args.problem.solve(&files, None, args.from_file.as_deref())?;
    let paths: Vec<Path> = {
        let _spinner = Spinner::new("tracing paths");
        let edges = EdgeLengths::new(&scene.surface)?;
        let paths = Paths::new(&scene.surface, &edges, &sources, &map.distances)?;
        paths.trace_all(&starts).into_iter().collect::<Result<_, PathError>>()?
    };

    let mut staged = files.stage(&scene, polylines(&paths, &scene)?)?;
    if let Some((output, look)) = picture {
        let curves = paths.iter().map(path_line).unzip();
        let quantity = args.problem.quantity(&scene);
        let draw = || draw_over_map(&scene, &sources, &map, &quantity, curves, look);
        staged.push(stage_picture(output, draw)?);
    }
    let written = commit(staged)?;
    problem::done_with_map(&scene, &map.report, &written);
    if args.json {
        let summary = Summary {
            map: MapSummary::new(&scene.surface, &map),
            paths: starts.iter().zip(&paths).map(|(from, path)| Row::new(*from, path)).collect(),
        };
        print_json("path", &summary)?;
    }
    Ok(ExitCode::SUCCESS)
}

impl Args {
    fn starts(&self) -> Result<Vec<[f64; 2]>, IoError> {
        let file = self.from_file.as_deref().map(read_curves).transpose()?;
        Ok(self.from.iter().copied().chain(file.unwrap_or_default().concat()).collect())
    }
}

fn polylines(paths: &[Path], scene: &Scene) -> Result<Vec<Polyline>, CurveError> {
    let polyline = |path: &Path| {
        let polyline = Polyline::new("path", path.curve.clone(), scene.shape())?
            .with("distance", Attribute::Number(path.distance))
            .with("length", Attribute::Number(path.length))
            .with("source", Attribute::Index(path.source));
        Ok(Polyline { color: rgb([0.75, 0.2, 0.1]), ..polyline })
    };
    paths.iter().map(polyline).collect()
}

#[derive(Serialize)]
struct Summary<'a> {
    #[serde(flatten)]
    map: MapSummary<'a>,
    paths: Vec<Row>,
}

#[derive(Serialize)]
struct Row {
    from: [f64; 2],
    distance: f64,
    length: f64,
    source: usize,
    vertices: usize,
}

impl Row {
    fn new(from: [f64; 2], path: &Path) -> Self {
        let Path { curve, distance, length, source } = path;
        Self {
            from,
            distance: *distance,
            length: *length,
            source: *source,
            vertices: curve.vertices.len(),
        }
    }
}

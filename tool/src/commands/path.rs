//! Implements `geosweep path`, which traces shortest paths back to the sources.

use std::error::Error;
use std::path::PathBuf;
use std::process::ExitCode;

use geosweep::geometry::{CurveError, Path, PathError, PathTracer};
use geosweep::io::{Attribute, GridFrame, PlaceFile, Polyline};
use geosweep::shown::seven_digits;
use geosweep::surface::EdgeLengths;
use serde::Serialize;

use super::over_map::draw_over_map;
use crate::numbers::{coordinates, place, place_xy};
use crate::output::{commit, stage_picture};
use crate::picture::{path_line, rgb};
use crate::problem::{self, CurveFiles, Problem, ProblemArgs, Scene};
use crate::terminal::{List, Outcome, Spinner, counted};

/// The arguments of `geosweep path`.
#[derive(clap::Args)]
#[command(after_help = examples())]
pub struct Args {
    /// Output file for the paths; repeatable. .npy is float64 (k, 5), with row, column, x, y, z of each
    /// vertex from the start to the source, and a row of NaN between paths. .csv has each path's distance,
    /// length, surface_length and source too, as in --json. The others are .svg (the parameter domain);
    /// .geojson (from a GeoTIFF, in its coordinates); .ply or .obj (in space)
    #[arg(short, long, value_name = "PATHS", required_unless_present_any = ["picture", "json"])]
    output: Vec<PathBuf>,
    /// Start of a path that leads back to its source: row and column, which may be fractional; repeatable
    #[arg(long, visible_alias = "to", value_name = "R,C", value_parser = place)]
    #[arg(allow_hyphen_values = true)]
    #[arg(required_unless_present_any = ["from_file", "from_xy"])]
    from: Vec<[f64; 2]>,
    /// Start in map coordinates, if SURFACE is georeferenced; repeatable. Such starts follow those of --from
    #[arg(long, visible_alias = "to-xy", value_name = "X,Y", value_parser = coordinates)]
    #[arg(allow_hyphen_values = true)]
    from_xy: Vec<[f64; 2]>,
    /// File of starts, which follow all others: a table, an .npy array or GeoJSON, as for --source-points.
    /// Start values in it are not used
    #[arg(long, value_name = "FILE")]
    from_file: Option<PathBuf>,

    #[command(flatten)]
    problem: ProblemArgs,

    /// Print one JSON object; docs/json.md and docs/geosweep.schema.json describe it
    #[arg(long, help_heading = "Reports")]
    json: bool,
}

fn examples() -> String {
    format!(
        "\
It is an error if a start is outside the grid, in a hole or not reached by any
source. Nothing is written then.

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
    let file = args.from_file.as_deref().map(PlaceFile::read).transpose()?;
    let mut problem = args.problem.solve(&files, None, args.from_file.as_deref(), |_| Ok(()))?;
    let picture = problem.picture.take();
    let Problem { scene, sources, map, .. } = &problem;
    let starts = args.starts(file.as_ref(), &scene.frame())?;
    let places: Vec<_> = starts
        .iter()
        .map(|&start| scene.place(start).map_err(|why| format!("start {why}")))
        .collect::<Result<_, _>>()?;
    let paths: Vec<Path> = {
        let _spinner = Spinner::new("tracing paths");
        let edges = EdgeLengths::new(&scene.surface)?;
        let paths = PathTracer::new(&scene.surface, &edges, sources, &map.distances)?;
        let paths = paths.trace_all(&places).into_iter().collect::<Result<_, PathError>>();
        paths.map_err(|error| scene.explain_path(error))?
    };
    let ends = starts.iter().copied().zip(places);
    let row = |(ends, path)| Row::new(ends, path, &problem);
    let rows: Vec<Row> = ends.zip(&paths).map(row).collect::<Result<_, CurveError>>()?;

    let mut staged = files.stage(scene, &ATTRIBUTES, polylines(&paths, &rows, scene)?)?;
    if let Some((output, look)) = picture {
        let curves = paths.iter().map(path_line).unzip();
        let quantity = args.problem.quantity(scene);
        let draw = || draw_over_map(scene, sources, map, &quantity, curves, look);
        staged.push(stage_picture(output, draw)?);
    }
    let written = commit(staged)?;
    problem::done_with(scene, &map.report, [lengths(&rows, args.problem.unit(scene))], &written);
    if args.json {
        problem.report().print("path", &List("paths", &rows))?;
    }
    Ok(ExitCode::SUCCESS)
}

impl Args {
    fn starts(
        &self,
        file: Option<&PlaceFile>,
        frame: &GridFrame,
    ) -> Result<Vec<[f64; 2]>, Box<dyn Error>> {
        let mut starts = self.from.clone();
        for &at in &self.from_xy {
            starts.push(place_xy("--from-xy", frame, at)?);
        }
        if let Some((file, path)) = file.zip(self.from_file.as_deref()) {
            starts.extend(file.points(frame)?.iter().map(|point| point.at));
            problem::remark(path, file, frame);
            if file.has_starts() {
                let name = path.display();
                note!("{name}: its start values are not used, since paths start there");
            }
        }
        Ok(starts)
    }
}

/// Describes the range of the paths' lengths.
fn lengths(rows: &[Row], unit: Option<&str>) -> String {
    let unit = unit.map(|unit| format!(" {unit}")).unwrap_or_default();
    let range = |of: fn(&Row) -> Option<f64>, unit: &str| {
        let values = || rows.iter().filter_map(of);
        let low = values().fold(f64::INFINITY, f64::min);
        let high = values().fold(f64::NEG_INFINITY, f64::max);
        match (low <= high, seven_digits(low), seven_digits(high)) {
            (false, ..) => None,
            (true, low, high) if low == high => Some(format!("{low}{unit}")),
            (true, low, high) => Some(format!("{low} to {high}{unit}")),
        }
    };
    let count = counted(rows.len() as u64, "path");
    let length = range(|row| Some(row.surface_length), &unit).unwrap_or_default();
    match range(|row| row.time, "") {
        None => format!("{count} of length {length}"),
        Some(time) => format!("{count} of length {length} and travel time {time}"),
    }
}

/// The names of the attributes of a path's polyline.
const ATTRIBUTES: [&str; 4] = ["distance", "length", "surface_length", "source"];

fn polylines(paths: &[Path], rows: &[Row], scene: &Scene) -> Result<Vec<Polyline>, CurveError> {
    let polyline = |(path, row): (&Path, &Row)| {
        let polyline = Polyline::new("path", path.curve.clone(), scene.shape())?
            .with("distance", Attribute::Number(row.distance))
            .with("length", Attribute::Number(row.length))
            .with("surface_length", Attribute::Number(row.surface_length))
            .with("source", Attribute::Index(row.source.into()));
        Ok(Polyline { color: rgb([0.75, 0.2, 0.1]), ..polyline })
    };
    paths.iter().zip(rows).map(polyline).collect()
}

#[derive(Serialize)]
struct Row {
    from: [f64; 2],
    distance: f64,
    length: f64,
    time: Option<f64>,
    surface_length: f64,
    source: i32,
    vertices: usize,
}

impl Row {
    /// Describes a path that starts at `from` on the given grid, which is `place` on the surface's grid.
    fn new(
        (from, place): ([f64; 2], [f64; 2]),
        path: &Path,
        problem: &Problem,
    ) -> Result<Self, CurveError> {
        let Path { curve, distance, length, source } = path;
        let surface = &problem.scene.surface;
        let is_slowed = surface.slowness().is_some();
        Ok(Self {
            from,
            distance: problem.double_at(place).unwrap_or(*distance),
            length: *length,
            time: is_slowed.then_some(*length),
            // Without a slowness, the path's own length is more accurate, since it is measured along arcs.
            surface_length: if is_slowed { curve.length(surface)? } else { *length },
            source: problem.sources.label(*source),
            vertices: curve.vertices.len(),
        })
    }
}

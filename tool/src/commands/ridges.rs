//! Implements `geosweep ridges`, which finds where wavefronts meet: the cut locus of the sources.

use std::path::PathBuf;
use std::process::ExitCode;

use geosweep::geometry::{CurveError, Ridge, ridges};
use geosweep::io::{Attribute, Polyline};
use geosweep::shown::excerpt;
use geosweep::surface::EdgeLengths;
use serde::Serialize;

use super::over_map::draw_over_map;
use crate::output::{commit, stage_picture};
use crate::picture::{rgb, ridge_line};
use crate::problem::{self, CurveFiles, Problem, ProblemArgs, Scene};
use crate::terminal::{List, Outcome, Spinner};

/// The arguments of `geosweep ridges`.
#[derive(clap::Args)]
#[command(after_help = examples())]
pub struct Args {
    /// Output file for the lines; repeatable: .npy (K, 5), .csv, .svg, .geojson, .ply or .obj, as in
    /// `geosweep contours --help`
    #[arg(short, long, value_name = "CURVES", required_unless_present_any = ["picture", "json"])]
    output: Vec<PathBuf>,
    /// Leave out lines on which the directions of the fronts differ by less than this angle. Below about 20
    /// degrees, some lines are artefacts of the grid
    #[arg(long, value_name = "DEGREES", default_value_t = 30.0, value_parser = angle)]
    #[arg(allow_hyphen_values = true)]
    least_angle: f64,

    #[command(flatten)]
    problem: ProblemArgs,

    /// Print one JSON object; docs/json.md and docs/geosweep.schema.json describe it
    #[arg(long, help_heading = "Reports")]
    json: bool,
}

fn angle(text: &str) -> Result<f64, String> {
    match text.trim().parse() {
        Ok(angle) if angle > 0.0 && angle <= 180.0 => Ok(angle),
        _ => Err(format!("`{}` is not an angle above 0 and up to 180 degrees", excerpt(text))),
    }
}

fn examples() -> String {
    format!(
        "\
Ridges are the lines on which the distance map has a kink, since fronts from different
directions meet there. They are the borders between the regions of several sources, and
the cut locus of each source, behind holes and hills. Shortest paths do not cross them.
Each line runs between two ends or junctions; its direction means nothing.

{}

Examples:
  geosweep ridges dem.tif --source 120,85 -o ridges.geojson --picture ridges.png
  geosweep ridges builtin:peaks:257x257 --source 60,60 -o ridges.svg --least-angle 20
  geosweep ridges scan.npy --source 80,64 --source 20,110 -o ridges.csv --json",
        problem::builtin_names()
    )
}

pub fn run(args: &Args) -> Outcome {
    let files = CurveFiles::new(&args.output)?;
    let mut problem = args.problem.solve(&files, None, None, |_| Ok(()))?;
    let picture = problem.picture.take();
    let Problem { scene, sources, map, .. } = &problem;
    let found = {
        let _spinner = Spinner::new("finding ridges");
        ridges(&EdgeLengths::new(&scene.surface)?, &map.distances, args.least_angle)?
    };
    let rows: Vec<Row> =
        found.iter().map(|ridge| Row::of(ridge, scene)).collect::<Result<_, _>>()?;

    let mut staged = files.stage(scene, &ATTRIBUTES, polylines(&found, &rows, scene)?)?;
    if let Some((output, look)) = picture {
        let curves = (found.iter().map(ridge_line).collect(), Vec::new());
        let quantity = args.problem.quantity(scene);
        let draw = || draw_over_map(scene, sources, map, &quantity, curves, look);
        staged.push(stage_picture(output, draw)?);
    }
    let written = commit(staged)?;
    problem::done_with_map(scene, &map.report, &written);
    if args.json {
        problem.report().print("ridges", &List("ridges", &rows))?;
    }
    Ok(ExitCode::SUCCESS)
}

/// The names of the attributes of a ridge's polyline.
const ATTRIBUTES: [&str; 3] = ["length", "least_angle", "largest_angle"];

fn polylines(ridges: &[Ridge], rows: &[Row], scene: &Scene) -> Result<Vec<Polyline>, CurveError> {
    let polyline = |(ridge, row): (&Ridge, &Row)| {
        let polyline = Polyline::new("ridge", ridge.curve.clone(), scene.shape())?
            .with("length", Attribute::Number(row.length))
            .with("least_angle", Attribute::Number(row.least_angle))
            .with("largest_angle", Attribute::Number(row.largest_angle));
        Ok(Polyline { color: rgb([0.75, 0.2, 0.1]), ..polyline })
    };
    ridges.iter().zip(rows).map(polyline).collect()
}

#[derive(Serialize)]
struct Row {
    vertices: usize,
    closed: bool,
    length: f64,
    least_angle: f64,
    largest_angle: f64,
}

impl Row {
    fn of(ridge: &Ridge, scene: &Scene) -> Result<Self, CurveError> {
        let Ridge { curve, angles } = ridge;
        Ok(Self {
            vertices: curve.vertices.len(),
            closed: curve.closed,
            length: curve.length(&scene.surface)?,
            least_angle: angles.iter().copied().fold(f64::INFINITY, f64::min),
            largest_angle: angles.iter().copied().fold(0.0, f64::max),
        })
    }
}

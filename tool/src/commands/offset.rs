//! Implements `geosweep offset`, which computes curves at given distances from curves.

use std::path::PathBuf;

use geosweep::geometry::{Levels, Side, offset_curves};
use geosweep::shown::exact;
use geosweep::surface::EdgeLengths;

use super::level_curves::{LevelCurves, comment, contours_of};
use crate::choices::{Choice, one_of_or};
use crate::numbers::Numbers;
use crate::problem::{self, CurveFiles, Problem, ProblemArgs};
use crate::terminal::Outcome;

/// The arguments of `geosweep offset`.
#[derive(clap::Args)]
#[command(after_help = examples())]
pub struct Args {
    /// Output file for the curves; repeatable: .npy (K, 5), .csv, .svg, .geojson, .ply or .obj, as in
    /// `geosweep contours --help`
    #[arg(short, long, value_name = "CURVES", required_unless_present_any = ["picture", "json"])]
    output: Vec<PathBuf>,
    /// Distances from the sources
    #[arg(long, value_name = "A,B,...", value_parser = Numbers::parse)]
    #[arg(allow_hyphen_values = true)]
    distances: Numbers,
    /// Side of the curves
    #[arg(long, default_value = "both", value_parser = one_of_or(&SIDES, BOTH))]
    side: Choice<Side>,

    #[command(flatten)]
    problem: ProblemArgs,

    /// Print one JSON object; docs/json.md and docs/geosweep.schema.json describe it
    #[arg(long, help_heading = "Reports")]
    json: bool,
}

const SIDES: [(Side, &str); 2] = [
    (
        Side::Left,
        "To the left of a curve in its direction: on the map if the curve is in map coordinates, otherwise with \
         rows downwards. The left of a polygon's ring is its inside",
    ),
    (Side::Right, "To its right"),
];
const BOTH: (&str, &str) = ("both", "All around");

fn examples() -> String {
    format!(
        "\
A curve is closed if its last vertex equals its first. With --side, a point belongs to
the side on which its shortest path meets the nearest curve. Offset curves are cut
where that side changes. Point sources have no sides.

{}

Examples:
  geosweep offset dem.tif --source-curve road.csv --distances 100,200 -o zones.geojson
  geosweep offset scan.npy --source-curve brow.csv --distances 5,10 --side left \\
      -o left.obj --picture left.png",
        problem::builtin_names()
    )
}

pub fn run(args: &Args) -> Outcome {
    let files = CurveFiles::new(&args.output)?;
    let problem = args.problem.solve(&files, None, None, |_| Ok(()))?;
    let Problem { scene, sources, map, .. } = &problem;
    if let Some(before) = args.distances.0.iter().find(|&&distance| distance < sources.start()) {
        let (before, start) = (exact(*before), exact(sources.start()));
        return Err(format!(
            "--distances {before}: nothing is nearer than the sources, where distances start with \
             {start}; give more"
        )
        .into());
    }
    let levels = Levels::List(args.distances.0.clone()).on(map, sources)?;
    let found = match args.side {
        None => contours_of(&problem, &levels),
        Some(side) => {
            let edges = EdgeLengths::new(&scene.surface)?;
            offset_curves(&scene.surface, &edges, sources, map, &levels, side)?
        }
    };
    comment(&found, &problem)?;
    let quantity = args.problem.quantity(scene);
    LevelCurves { command: "offset", kind: "offset", side: args.side, problem, found }
        .write(files, &quantity, args.json)
}

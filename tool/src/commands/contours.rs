//! Implements `geosweep contours`, which computes curves of equal distance.

use std::path::PathBuf;

use geosweep::geometry::Levels;

use super::level_curves::{LevelCurves, comment, contours_of, range};
use crate::numbers::{Numbers, whole};
use crate::problem::{self, CurveFiles, ProblemArgs};
use crate::terminal::Outcome;

/// The arguments of `geosweep contours`.
#[derive(clap::Args)]
#[command(after_help = examples())]
pub struct Args {
    /// Output file for the curves; repeatable. .npy is (K, 5), with row, column, x, y, z of each vertex and a
    /// row of NaN between curves. The others are .csv; .svg (the parameter domain); .geojson (from a GeoTIFF,
    /// in its coordinates); .ply or .obj (in space)
    #[arg(short, long, value_name = "CURVES", required_unless_present_any = ["picture", "json"])]
    output: Vec<PathBuf>,
    #[command(flatten)]
    levels: LevelArgs,

    #[command(flatten)]
    problem: ProblemArgs,

    /// Print one JSON object; docs/json.md and docs/geosweep.schema.json describe it
    #[arg(long, help_heading = "Reports")]
    json: bool,
}

#[derive(clap::Args)]
#[group(required = true, multiple = false)]
struct LevelArgs {
    /// Curves at these distances
    #[arg(long, value_name = "A,B,...", value_parser = Numbers::parse)]
    #[arg(allow_hyphen_values = true)]
    levels: Option<Numbers>,
    /// Curves at this many distances, equally spaced between the smallest and the largest
    #[arg(long, value_name = "N", value_parser = whole("distances", 1..=usize::MAX))]
    count: Option<usize>,
    /// Curves at all multiples of a distance
    #[arg(long, value_name = "D", allow_hyphen_values = true)]
    every: Option<f64>,
}

fn examples() -> String {
    format!(
        "\
Contours are closed, or end at the surface's border or at holes. Nearer points lie
to their left, as seen on the grid with rows downwards. A level outside the map's
range has no curve. At the largest distance, curves join the grid points that have it.

{}

Examples:
  geosweep contours dem.tif --source 120,85 --every 1000 -o km.geojson --picture km.png
  geosweep contours builtin:face:183x155 --source 103,77 --count 12 -o face.svg \\
      --picture face.png
  geosweep contours scan.npy --source 80,64 --levels 10,20,50 -o rings.csv -o rings.obj",
        problem::builtin_names()
    )
}

impl LevelArgs {
    fn levels(&self) -> Levels {
        match (&self.levels, self.count, self.every) {
            (Some(Numbers(levels)), _, _) => Levels::List(levels.clone()),
            (_, Some(count), _) => Levels::Count(count),
            (_, _, every) => Levels::Spacing(every.unwrap_or(f64::NAN)),
        }
    }
}

pub fn run(args: &Args) -> Outcome {
    let files = CurveFiles::new(&args.output)?;
    let problem = args.problem.solve(&files, None, None, |_| Ok(()))?;
    let levels = args.levels.levels().on(&problem.map, &problem.sources)?;
    let found = contours_of(&problem, &levels);
    comment(&found, &problem)?;
    if found.is_empty() {
        note!("no curve: {}", range(&problem.map));
    }
    let quantity = args.problem.quantity(&problem.scene);
    LevelCurves { command: "contours", kind: "contour", side: None, problem, found }
        .write(files, &quantity, args.json)
}

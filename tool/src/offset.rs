//! `geosweep offset`: curves at some distances from curves.

use std::path::PathBuf;

use clap::ValueEnum;
use geosweep::geometry::{Levels, Side, contours, offset_curves};
use geosweep::surface::EdgeLengths;

use crate::Outcome;
use crate::contours::{Numbers, comment};
use crate::level_curves::LevelCurves;
use crate::problem::{self, CurveFiles, Problem, ProblemArgs};

/// The arguments of `geosweep offset`.
#[derive(clap::Args)]
#[command(after_help = examples())]
pub struct Args {
    /// Where to write the curves, repeatable: .npy (K, 5), .csv, .svg, .geojson, .ply or .obj, as
    /// `geosweep contours --help` says
    #[arg(short, long, value_name = "CURVES", required_unless_present_any = ["picture", "json"])]
    output: Vec<PathBuf>,
    /// How far from the sources
    #[arg(long, value_name = "A,B,...", value_parser = Numbers::parse)]
    #[arg(allow_hyphen_values = true)]
    distances: Numbers,
    /// On which side of the curves
    #[arg(long, value_enum, default_value_t)]
    side: SideArg,

    #[command(flatten)]
    problem: ProblemArgs,

    /// Print one JSON object: what `distance --json` says of the map, and levels, an array of
    /// objects with level, curves, closed (how many of them are), vertices and length (in the unit
    /// of the surface)
    #[arg(long, help_heading = "Reports")]
    json: bool,
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
enum SideArg {
    /// To the left of a curve in its direction, as seen on the grid with rows downwards
    Left,
    /// To its right
    Right,
    /// All around
    #[default]
    Both,
}

fn examples() -> String {
    format!(
        "\
A curve is closed if its last vertex is its first. On one side, a point belongs to
the side on which its shortest path meets the nearest curve; curves are cut where
that changes, and point sources have no sides.

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
    let problem = args.problem.solve(&files, None, None)?;
    let Problem { scene, sources, map, .. } = &problem;
    if let Some(before) = args.distances.0.iter().find(|&&distance| distance < sources.start()) {
        let start = sources.start();
        return Err(format!(
            "--distances {before}: nothing is nearer than the sources, where distances start with \
             {start}; give more"
        )
        .into());
    }
    let levels = Levels::List(args.distances.0.clone()).on(map, sources)?;
    let side = args.side.side();
    let found = match side {
        None => contours(map, sources, &levels),
        Some((side, _)) => {
            let edges = EdgeLengths::new(&scene.surface)?;
            offset_curves(&scene.surface, &edges, sources, map, &levels, side)?
        }
    };
    comment(&found, &problem)?;
    let (quantity, side) = (args.problem.quantity(scene), side.map(|(_, name)| name));
    LevelCurves { kind: "offset", side, problem, found }.write(files, &quantity, args.json)
}

impl SideArg {
    fn side(self) -> Option<(Side, &'static str)> {
        match self {
            Self::Left => Some((Side::Left, "left")),
            Self::Right => Some((Side::Right, "right")),
            Self::Both => None,
        }
    }
}

//! `geosweep contours`: curves of equal distance.

use std::ops::Range;
use std::path::PathBuf;

use geosweep::geometry::{Contour, Levels, contours};
use geosweep::surface::{Source, SourceError};
use geosweep::{DistanceMap, Sources, Surface};

use crate::level_curves::LevelCurves;
use crate::problem::{self, CurveFiles, Problem, ProblemArgs, numbers};
use crate::{Outcome, say};

/// The arguments of `geosweep contours`.
#[derive(clap::Args)]
#[command(after_help = examples())]
pub struct Args {
    /// Where to write the curves, repeatable: .npy (K, 5) with row, column, x, y, z of each vertex
    /// and a row of NaN between curves; .csv; .svg (the parameter domain); .geojson (from a GeoTIFF,
    /// in its coordinates); .ply or .obj (in space)
    #[arg(short, long, value_name = "CURVES", required_unless_present_any = ["picture", "json"])]
    output: Vec<PathBuf>,
    #[command(flatten)]
    levels: LevelArgs,

    #[command(flatten)]
    problem: ProblemArgs,

    /// Print one JSON object: what `distance --json` says of the map, and levels, an array of
    /// objects with level, curves, closed (how many of them are), vertices and length (in the unit
    /// of the surface)
    #[arg(long, help_heading = "Reports")]
    json: bool,
}

#[derive(clap::Args)]
#[group(required = true, multiple = false)]
struct LevelArgs {
    /// At these distances
    #[arg(long, value_name = "A,B,...", value_parser = Numbers::parse)]
    #[arg(allow_hyphen_values = true)]
    levels: Option<Numbers>,
    /// At so many distances, equally spaced between the smallest and the largest
    #[arg(long, value_name = "N", value_parser = count)]
    count: Option<usize>,
    /// At all multiples of a distance
    #[arg(long, value_name = "D", allow_hyphen_values = true)]
    every: Option<f64>,
}

fn count(text: &str) -> Result<usize, String> {
    match text.parse() {
        Ok(count @ 1..) => Ok(count),
        _ => Err(format!("`{text}` is no number of distances; give 1 or more")),
    }
}

/// Numbers in one argument.
#[derive(Clone, Debug)]
pub struct Numbers(pub Vec<f64>);

impl Numbers {
    pub fn parse(text: &str) -> Result<Self, String> {
        numbers(text).map(Self)
    }
}

fn examples() -> String {
    format!(
        "\
Contours are closed, or end at the surface's border or at holes. Nearer points lie
to their left as seen on the grid with rows downwards. A level that the map does not
have gives no curve.

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
    let problem = args.problem.solve(&files, None, None)?;
    let levels = args.levels.levels().on(&problem.map, &problem.sources)?;
    let found = contours(&problem.map, &problem.sources, &levels);
    comment(&found, &problem)?;
    if found.is_empty() {
        let [low, high] = extent(&problem.map);
        say("note", format_args!("no curve: the distances on the grid run from {low} to {high}"));
    }
    let quantity = args.problem.quantity(&problem.scene);
    LevelCurves { kind: "contour", side: None, problem, found }.write(files, &quantity, args.json)
}

/// Names the levels that have no curve, or perhaps a part of it.
pub fn comment(found: &[Contour], problem: &Problem) -> Result<(), SourceError> {
    let Problem { scene, sources, map, .. } = problem;
    let levels = |which: &dyn Fn(&Contour) -> bool| {
        let levels = found.iter().filter(|contour| which(contour));
        levels.map(|contour| contour.level.to_string()).collect::<Vec<_>>().join(", ")
    };
    let none = levels(&|contour| contour.curves.is_empty());
    if !none.is_empty() {
        let [low, high] = extent(map);
        say(
            "note",
            format_args!("no curve at {none}: the distances on the grid run from {low} to {high}"),
        );
    }
    let near = sources
        .iter()
        .map(|source| beside(source, &scene.surface))
        .collect::<Result<Vec<_>, _>>()?;
    let cut = levels(&|contour| {
        !contour.curves.is_empty() && near.iter().any(|near| near.contains(&contour.level))
    });
    if !cut.is_empty() {
        say(
            "note",
            format_args!(
                "the curves at {cut} run between a source and the points of the grid beside it, \
                 closer than the grid's spacing there, and parts of them are missing; a finer grid \
                 has them whole"
            ),
        );
    }
    Ok(())
}

/// The smallest and the largest distance on the grid.
fn extent(map: &DistanceMap) -> [f32; 2] {
    let reached = map.distances.iter().copied().filter(|distance| distance.is_finite());
    [reached.fold(f32::INFINITY, f32::min), map.report.max_distance as f32]
}

/// The distances from a source to the points of the grid beside it.
fn beside(source: &Source, surface: &Surface) -> Result<Range<f64>, SourceError> {
    let seeds = Sources::from_iter([source.clone()]).seeds(surface)?;
    Ok(source.initial()..seeds.iter().map(|seed| seed.time).fold(source.initial(), f64::max))
}

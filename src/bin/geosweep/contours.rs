//! `geosweep contours`: curves of equal distance.

use std::path::PathBuf;
use std::process::ExitCode;

use geosweep::geometry::{Contour, CurveError, Levels, contours};
use geosweep::io::{Attribute, Polyline, StagedFile};
use geosweep::{DistanceMap, Sources};
use serde::Serialize;

use crate::picture::{CurvePicture, Key, Paint, Scale, contour_lines, mark_all, rgb, scale_of};
use crate::problem::{
    self, CurveFiles, MapSummary, PictureArgs, Scene, SolverArgs, SourceArgs, SurfaceArgs,
    check_outputs, numbers,
};
use crate::spinner::Spinner;
use crate::{Outcome, print, say};

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
    sources: SourceArgs,
    #[command(flatten)]
    surface: SurfaceArgs,
    #[command(flatten)]
    solver: SolverArgs,
    #[command(flatten)]
    picture: PictureArgs,

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
    #[arg(long, value_name = "N")]
    count: Option<usize>,
    /// At all multiples of a distance
    #[arg(long, value_name = "D", allow_hyphen_values = true)]
    every: Option<f64>,
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
    let options = args.solver.options()?;
    let files = CurveFiles::new(&args.output)?;
    let picture = args.picture.output()?;
    let outputs: Vec<_> = files.files().chain(&picture).collect();
    check_outputs(&outputs, problem::inputs(&args.surface, &args.sources))?;
    let scene = args.surface.read()?;
    files.check(&scene)?;
    let look = args.picture.look(&scene);
    let look = picture.as_ref().map(|_| look).transpose()?;
    let sources = args.sources.sources()?;
    let map = problem::solve(&scene, &sources, &args.solver, &options)?;
    let levels = args.levels.levels().on(&map, &sources)?;
    let found = contours(&map, &sources, &levels);
    comment(&found, &map, &sources);

    let scale = scale_of(&map, &sources);
    let lengths = lengths(&found, &scene)?;
    let polylines = polylines(&found, &lengths, &scene, &scale)?;
    let mut staged = files.stage(&scene, polylines)?;
    if let Some((output, look)) = picture.zip(look) {
        let _spinner = Spinner::new("drawing");
        let (source_lines, marks) = mark_all(&sources);
        let mut lines = contour_lines(&found, &scale, true);
        lines.extend(source_lines);
        let picture = CurvePicture {
            surface: &scene.surface,
            shape: scene.shape(),
            values: &map.distances,
            paint: Paint::Values(&scale, None),
            lines: &lines,
            marks: &marks,
            key: Key::Scale {
                quantity: &args.picture.quantity(&scene),
                scale: &scale,
                levels: &levels,
            },
        };
        staged.push(output.stage(|writer| picture.draw(look).write_png(writer))?);
    }
    staged.into_iter().try_for_each(StagedFile::commit)?;
    if args.json {
        let level = |(contour, lengths): (_, &Vec<f64>)| LevelSummary::new(contour, lengths);
        let summary = Summary {
            map: MapSummary::new(&scene.surface, &map),
            levels: found.iter().zip(&lengths).map(level).collect(),
        };
        print(serde_json::to_string(&summary)?)?;
    }
    Ok(ExitCode::SUCCESS)
}

/// Names the levels that have no curve.
fn comment(found: &[Contour], map: &DistanceMap, sources: &Sources) {
    let empty = found.iter().filter(|contour| contour.curves.is_empty());
    let levels: Vec<_> = empty.map(|contour| contour.level.to_string()).collect();
    if !levels.is_empty() {
        let (low, high) = (sources.start(), map.report.max_distance);
        let levels = levels.join(", ");
        say("note", format_args!("no curve at {levels}: the distances run from {low} to {high}"));
    }
}

/// The lengths of all curves, contour by contour.
fn lengths(found: &[Contour], scene: &Scene) -> Result<Vec<Vec<f64>>, CurveError> {
    let of = |contour: &Contour| {
        contour.curves.iter().map(|curve| curve.length(&scene.surface)).collect()
    };
    found.iter().map(of).collect()
}

fn polylines(
    found: &[Contour],
    lengths: &[Vec<f64>],
    scene: &Scene,
    scale: &Scale,
) -> Result<Vec<Polyline>, CurveError> {
    let mut polylines = Vec::new();
    for (contour, lengths) in found.iter().zip(lengths) {
        // The scale's light end is hard to see on white.
        let color = rgb(scale.color(contour.level as f32).map(|channel| 0.85 * channel));
        for (curve, &length) in contour.curves.iter().zip(lengths) {
            let polyline = Polyline::new("contour", curve.clone(), scene.shape())?
                .with("level", Attribute::Number(contour.level))
                .with("length", Attribute::Number(length));
            polylines.push(Polyline { color, ..polyline });
        }
    }
    Ok(polylines)
}

#[derive(Serialize)]
struct Summary<'a> {
    #[serde(flatten)]
    map: MapSummary<'a>,
    levels: Vec<LevelSummary>,
}

#[derive(Serialize)]
struct LevelSummary {
    level: f64,
    curves: usize,
    closed: usize,
    vertices: usize,
    length: f64,
}

impl LevelSummary {
    fn new(contour: &Contour, lengths: &[f64]) -> Self {
        let curves = &contour.curves;
        Self {
            level: contour.level,
            curves: curves.len(),
            closed: curves.iter().filter(|curve| curve.closed).count(),
            vertices: curves.iter().map(|curve| curve.vertices.len()).sum(),
            length: lengths.iter().sum(),
        }
    }
}

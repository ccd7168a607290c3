//! Implements `geosweep sample`, which spreads points over a surface.

use std::error::Error;
use std::path::PathBuf;
use std::process::ExitCode;

use geosweep::geometry::{Curve, CurveError, FarthestPoints, Voronoi};
use geosweep::io::{Attribute, OutputFile, Polyline, StagedFile};
use geosweep::shown::seven_digits;
use geosweep::surface::EdgeLengths;
use serde::Serialize;

use super::labels::{labels_output, numbers, stage_labels};
use super::samples::{Sample, farthest_points, middle};
use crate::numbers::{place, whole};
use crate::output::{check_outputs, commit, done, stage_picture};
use crate::picture::{Look, Regions};
use crate::problem::{CurveFiles, PictureArgs, Scene, SurfaceArgs, builtin_names};
use crate::terminal::{Outcome, counted, print_json};

/// The arguments of `geosweep sample`.
#[derive(clap::Args)]
#[command(after_help = examples())]
pub struct Args {
    /// Output file for the samples; repeatable. .npy is float64 (k, 5), with row, column, x, y, z of each
    /// sample. The others are .csv; .svg (the parameter domain); .geojson (from a GeoTIFF, in its
    /// coordinates); .ply or .obj (in space)
    #[arg(short, long, value_name = "SAMPLES")]
    #[arg(required_unless_present_any = ["labels", "picture", "json"])]
    output: Vec<PathBuf>,
    /// Number of samples
    #[arg(short = 'k', long, value_name = "K", value_parser = whole("samples", 1..=usize::MAX))]
    count: usize,
    /// First sample (default: the point next to the middle of the grid)
    #[arg(long, value_name = "R,C", value_parser = place, allow_hyphen_values = true)]
    first: Option<[f64; 2]>,
    /// Write the nearest sample of each point: .npy (M, N) or .tif, int32, counted from 0 in the order of the
    /// samples, with -1 at holes and where no sample reaches
    #[arg(long, value_name = "LABELS")]
    labels: Option<PathBuf>,

    #[command(flatten)]
    surface: SurfaceArgs,
    #[command(flatten)]
    picture: PictureArgs,

    /// Print one JSON object; docs/json.md and docs/geosweep.schema.json describe it
    #[arg(long, help_heading = "Reports")]
    json: bool,
}

fn examples() -> String {
    format!(
        "\
Farthest-point sampling, on the CPU with the curved wavefront: each sample is the point
that is farthest from all samples before it. Every point of the surface is within the
radius of a sample, and samples are at least that far apart.

{}

Examples:
  geosweep sample builtin:face:183x155 -k 50 -o samples.npy --picture samples.png
  geosweep sample dem.tif -k 100 --first 10,10 -o samples.geojson \\
      --labels regions.npy --json",
        builtin_names()
    )
}

pub fn run(args: &Args) -> Outcome {
    let files = CurveFiles::new(&args.output)?;
    let labels = labels_output(args.labels.as_ref())?;
    let picture = args.picture.output()?;
    let outputs: Vec<_> = files.files().chain(&labels).chain(&picture).collect();
    check_outputs(&outputs, args.surface.inputs().map(AsRef::as_ref))?;
    let scene = args.surface.read()?;
    let surface = &scene.surface;
    files.check(&scene)?;
    let look = picture.as_ref().map(|_| args.picture.look(&scene)).transpose()?;

    let edges = EdgeLengths::new(surface)?;
    let first = args.first.map(|first| scene.place(first).map_err(|why| format!("--first {why}")));
    let first = first.unwrap_or_else(|| Ok(middle(surface, None)))?;
    let sampled = farthest_points(surface, &edges, first, None, args.count);
    let (points, mut samples) = sampled.map_err(|error| match scene.explain(error) {
        // The message says `--first`, since here the source is a sample.
        geosweep::Error::Source(error) => error.to_string().replacen("source", "--first", 1).into(),
        error => Box::<dyn Error>::from(error),
    })?;

    let polyline = |(index, sample): (usize, &Sample)| {
        let curve = Curve { vertices: vec![[sample.row, sample.col]], closed: false };
        let polyline = Polyline::new("sample", curve, scene.shape())?;
        Ok(polyline.with("sample", Attribute::Index(index as i64)))
    };
    let polylines: Vec<_> =
        samples.iter().enumerate().map(polyline).collect::<Result<_, CurveError>>()?;
    let mut staged = files.stage(&scene, &["sample"], polylines)?;
    if labels.is_some() || picture.is_some() {
        let unit = args.picture.unit(&scene);
        staged.extend(stage_regions(&scene, &edges, &points, labels, picture.zip(look), unit)?);
    }
    let written = commit(staged)?;
    let radius = points.radius();
    let covers = if radius.is_finite() {
        format!("radius {}", seven_digits(f64::from(radius)))
    } else {
        "some points out of reach".into()
    };
    done(["CPU".into(), counted(samples.len() as u64, "sample"), covers], &written);
    if args.json {
        for sample in &mut samples {
            [sample.row, sample.col] = scene.given([sample.row, sample.col]);
        }
        print_json("sample", &Summary { radius: points.radius(), samples })?;
    }
    Ok(ExitCode::SUCCESS)
}

/// Writes the labels and the picture of the samples' regions. The files do not have their final names yet.
fn stage_regions(
    scene: &Scene,
    edges: &EdgeLengths<f32>,
    points: &FarthestPoints,
    labels: Option<OutputFile>,
    picture: Option<(OutputFile, Look)>,
    unit: Option<&str>,
) -> Result<Vec<StagedFile>, Box<dyn Error>> {
    let surface = &scene.surface;
    let (sources, distances) = (points.sources(), points.distances());
    let voronoi = Voronoi::new(surface, edges, sources, &distances)?;
    let names = numbers(&voronoi);
    let mut staged = Vec::new();
    if let Some(output) = labels {
        staged.push(stage_labels(output, scene, &voronoi, &names)?);
    }
    if let Some((output, look)) = picture {
        let areas = voronoi.areas(surface);
        let regions = Regions {
            surface,
            shape: scene.shape(),
            sources,
            labels: &names,
            values: &distances,
            voronoi: &voronoi,
            areas: Some((&areas, unit)),
        };
        staged.push(stage_picture(output, || regions.draw(look))?);
    }
    Ok(staged)
}

#[derive(Serialize)]
struct Summary {
    radius: f32,
    samples: Vec<Sample>,
}

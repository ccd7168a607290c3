//! Implements `geosweep voronoi`, which finds the part of a surface nearest to each source.

use std::path::PathBuf;
use std::process::ExitCode;

use geosweep::geometry::{Border, CurveError, NO_REGION, Voronoi};
use geosweep::io::{Attribute, Georeference, Polyline};
use geosweep::surface::EdgeLengths;
use serde::Serialize;

use super::labels::{labels_output, stage_labels};
use crate::output::{commit, stage_picture};
use crate::picture::Regions;
use crate::problem::{self, CurveFiles, Problem, ProblemArgs, Scene};
use crate::terminal::{Outcome, Spinner};

/// The arguments of `geosweep voronoi`.
#[derive(clap::Args)]
#[command(after_help = examples())]
pub struct Args {
    /// Output file for the regions: .npy (M, N) or .tif, int32. Each point has the index of its nearest
    /// source, counted from 0 in the order of --source, --source-xy, --source-lonlat, --source-points and
    /// --source-curve; -1 at holes and where no source reaches. If all sources are cells of rasters of whole numbers,
    /// cells of one value are one region, and each point has the value of its nearest cell
    #[arg(short, long, value_name = "LABELS")]
    #[arg(required_unless_present_any = ["borders", "picture", "json"])]
    output: Option<PathBuf>,
    /// Output file for the borders between regions; repeatable: .npy (K, 5), .csv, .svg, .geojson, .ply or
    /// .obj, as in `geosweep contours --help`
    #[arg(long, value_name = "CURVES")]
    borders: Vec<PathBuf>,

    #[command(flatten)]
    problem: ProblemArgs,

    /// Print one JSON object; docs/json.md and docs/geosweep.schema.json describe it
    #[arg(long, help_heading = "Reports")]
    json: bool,
}

fn examples() -> String {
    format!(
        "\
A source with a start value starts later, so that its region is smaller. Areas are
in the squared unit of the surface, without any slowness.

{}

Examples:
  geosweep voronoi dem.tif --source 120,85 --source 30,200 -o regions.npy \\
      --borders borders.geojson --picture regions.png
  geosweep voronoi builtin:face:183x155 --source 60,40 --source 60,115 \\
      --source 103,77 --json",
        problem::builtin_names()
    )
}

pub fn run(args: &Args) -> Outcome {
    let labels = labels_output(args.output.as_ref())?;
    let borders = CurveFiles::new(&args.borders)?;
    let mut problem = args.problem.solve(&borders, labels.as_ref(), None, |_| Ok(()))?;
    let picture = problem.picture.take();
    let Problem { scene, sources, map, .. } = &problem;
    let voronoi = {
        let _spinner = Spinner::new("finding regions");
        let edges = EdgeLengths::new(&scene.surface)?;
        let of_sources = Voronoi::new(&scene.surface, &edges, sources, &map.distances)?;
        match sources.regions() {
            Some((of_source, regions)) => of_sources.merged(&of_source, regions),
            None => of_sources,
        }
    };
    let names = sources.region_labels();
    let areas = voronoi.areas(&scene.surface);

    let mut staged = borders.stage(scene, &ATTRIBUTES, polylines(&voronoi, &names, scene)?)?;
    if let Some(output) = labels {
        staged.push(stage_labels(output, scene, &voronoi, &names)?);
    }
    if let Some((output, look)) = picture {
        let regions = Regions {
            surface: &scene.surface,
            shape: scene.shape(),
            sources,
            labels: &names,
            values: &map.distances,
            voronoi: &voronoi,
            areas: Some((&areas, args.problem.unit(scene))),
        };
        staged.push(stage_picture(output, || regions.draw(look))?);
    }
    let written = commit(staged)?;
    problem::done_with_map(scene, &map.report, &written);
    if args.json {
        let mut points = vec![0; voronoi.regions()];
        let labels = scene.crop(&voronoi.labels);
        let reached = labels.iter().filter(|label| **label != NO_REGION);
        reached.for_each(|label| points[*label as usize] += 1);
        let region =
            |(region, (&points, &area)): (usize, _)| Region { source: names[region], points, area };
        let named = |pair: [u32; 2]| pair.map(|region| names[region as usize]);
        let summary = Summary {
            area: areas.iter().sum(),
            regions: points.iter().zip(&areas).enumerate().map(region).collect(),
            neighbours: voronoi.neighbours().into_iter().map(named).collect(),
        };
        problem.report().print("voronoi", &summary)?;
    }
    Ok(ExitCode::SUCCESS)
}

/// The names of the attributes of a border's polyline.
const ATTRIBUTES: [&str; 3] = ["left", "right", "length"];

/// Returns the borders with the names of the regions on either side, as seen on the map if there is one.
fn polylines(voronoi: &Voronoi, names: &[i32], scene: &Scene) -> Result<Vec<Polyline>, CurveError> {
    let is_mirrored = scene.georeference.as_ref().is_ok_and(Georeference::is_mirrored);
    let polyline = |border: &Border| {
        let mut sides =
            border.regions.map(|region| Attribute::Index(names[region as usize].into()));
        if is_mirrored {
            sides.reverse();
        }
        let [left, right] = sides;
        let length = border.curve.length(&scene.surface)?;
        Ok(Polyline::new("border", border.curve.clone(), scene.shape())?
            .with("left", left)
            .with("right", right)
            .with("length", Attribute::Number(length)))
    };
    voronoi.borders.iter().map(polyline).collect()
}

#[derive(Serialize)]
struct Summary {
    area: f64,
    regions: Vec<Region>,
    neighbours: Vec<[i32; 2]>,
}

#[derive(Serialize)]
struct Region {
    source: i32,
    points: usize,
    area: f64,
}

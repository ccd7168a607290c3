//! Implements `geosweep distance`, which computes a map from a surface and sources.

use std::error::Error;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use geosweep::io::{MapFormat, OutputFile};
use geosweep::surface::Real;
use geosweep::{DistanceMap, ErrorEstimate, Options, Sources, Surface, Wavefront};
use serde::Serialize;

use super::directions::{DirectionArgs, DirectionOutputs};
use super::over_map::draw_over_map;
use crate::output::{Written, check_outputs, commit, stage_picture};
use crate::picture::{Look, Picture};
use crate::precision::{InPrecision, Number, Precision};
use crate::problem::{
    self, GivenSources, LimitArgs, MapSummary, PictureArgs, Scene, SolverArgs, SourceArgs,
    SurfaceArgs,
};
use crate::terminal::{Outcome, Spinner, print_json};

/// The arguments of `geosweep distance`.
#[derive(clap::Args)]
#[command(after_help = examples())]
pub struct Args {
    /// Output file for the map: .npy (M, N), .tif or .exr, float32, with +infinity at holes and where no
    /// source reaches. In double precision it is .npy or .tif, float64. A .tif gets the georeference of the
    /// surface's .tif or .asc. Optional with --picture, --error or --json
    #[arg(short, long, value_name = "MAP")]
    #[arg(required_unless_present_any = ["error", "picture", "json", "directions"])]
    output: Option<PathBuf>,

    #[command(flatten)]
    sources: SourceArgs,
    #[command(flatten)]
    surface: SurfaceArgs,
    #[command(flatten)]
    solver: SolverArgs,
    #[command(flatten)]
    limits: LimitArgs,

    /// Precision in which the map is computed and written (default: single; double with --geodetic, unless a Vulkan
    /// device is asked for)
    #[arg(long, value_enum, help_heading = "Accuracy")]
    precision: Option<Precision>,
    /// Output file for the estimated error of each distance, in the map's format and unit, with +infinity
    /// where there is no estimate. The estimate compares maps of every second and fourth point, which takes a
    /// third more time. Over floor plans it compares with a grid twice as fine, which takes four to five
    /// times the time. Behind holes of other surfaces it is far too large
    #[arg(long, value_name = "FILE", help_heading = "Accuracy")]
    error: Option<PathBuf>,
    /// Write the map minus its estimated error (Richardson's extrapolation), in a third more time. On smooth
    /// surfaces a half to a hundredth of the error remains, least with sources at grid points; behind holes
    /// the error grows. Over floor plans, write the distances of the finer grid
    #[arg(long, help_heading = "Accuracy")]
    extrapolate: bool,

    #[command(flatten)]
    directions: DirectionArgs,

    #[command(flatten)]
    picture: PictureArgs,
    /// Print one JSON object; docs/json.md and docs/geosweep.schema.json describe it
    #[arg(long, help_heading = "Reports")]
    json: bool,
}

fn examples() -> String {
    format!(
        "\
Distances are in the unit of the positions, or of the heights and the spacing,
which must have the same unit. Rows count downwards from 0, columns rightwards from 0.

{}

Examples:
  An elevation model in metres, 30 m between points, with a picture:
    geosweep distance dem.png --spacing 30 --source 172,201 -o map.npy --picture map.png
  A scan with a mask, from a curve and from a point that starts at 12.5:
    geosweep distance scan.npy --mask face.png --source-curve brow.csv \\
      --source 80.5,64.25,12.5 -o map.npy
  Travel times, on the CPU, with a report to parse:
    geosweep distance dem.tif --slowness slowness.npy --source 10,10 \\
      --engine cpu --json -o time.npy
  In double precision, for errors below the rounding of single precision:
    geosweep distance scan.npy --source 80,64 --precision double -o map.npy
  The way back at each point for a GIS, and the nearest of two sources:
    geosweep distance dem.tif --source 120,85 --source 30,200 -o map.tif \\
      --back-direction back.tif --back-link link.tif --nearest nearest.tif
  Only what is within 500 m of a well, and only as far as the nearest of two villages:
    geosweep distance dem.tif --source 120,85 --radius 500 -o near.tif
    geosweep distance dem.tif --source 120,85 --target 30,41 --target 200,17 \
      --target-mode any -o way.tif
  A built-in surface, with an estimate of each distance's error:
    geosweep distance builtin:sphere:257x257 --source 0,0 -o sphere.npy \\
      --error error.npy",
        problem::builtin_names()
    )
}

pub fn run(args: &Args) -> Outcome {
    args.precision().run(args)
}

impl InPrecision for &Args {
    type Result = Outcome;

    fn run<R: Number>(self) -> Outcome {
        let options = self.solver.options()?;
        let outputs = Outputs::new(self)?;
        let scene = self.surface.read()?;
        self.check(&scene)?;
        let look =
            outputs.picture.as_ref().map(|_| self.picture.look_at_map(&scene)).transpose()?;
        let options = self.limits.options(options, &scene)?;
        let sources = self.sources.sources(&scene)?;
        let mut solved = {
            let _spinner = Spinner::new("computing distances");
            let solved = Solved::<R>::new(self, &scene.surface, &sources, &options);
            solved.map_err(|error| scene.explain(error))?
        };
        scene.count(&mut solved.map);
        self.comment(&scene.surface, &solved, &options);
        problem::comment_on_starts::<R>(&scene.surface, &sources);
        problem::comment_on_size::<R>(&scene.surface);
        problem::comment_on_corners(&scene.surface, &solved.map);
        problem::comment_on_targets(&scene, &solved.map, &options);
        let written = outputs.write(self, &scene, &sources, look, &solved)?;
        problem::done_with_map(&scene, &solved.map.report, &written);
        if self.json {
            print_json("distance", &Summary::new(&scene, self, &solved))?;
        }
        Ok(ExitCode::SUCCESS)
    }
}

/// A map and its estimated errors, as they are written and reported.
struct Solved<R> {
    map: DistanceMap<R>,
    estimate: Option<Estimate<R>>,
}

/// The estimated errors of the map, before any extrapolation.
struct Estimate<R> {
    errors: Vec<R>,
    mean_relative: f64,
    max_relative: f64,
    unknown: usize,
}

impl<R: Real> Estimate<R> {
    fn of(estimate: &mut ErrorEstimate<R>) -> Self {
        let (mean_relative, max_relative) = estimate.relative();
        let unknown = estimate.unknown();
        let errors = std::mem::take(&mut estimate.errors);
        Self { errors, mean_relative, max_relative, unknown }
    }
}

impl<R: Number> Solved<R> {
    fn new(
        args: &Args,
        surface: &Surface,
        sources: &Sources,
        options: &Options,
    ) -> Result<Self, geosweep::Error> {
        if args.error.is_none() && !args.extrapolate {
            return Ok(Self { map: R::MAP(surface, sources, options)?, estimate: None });
        }
        let mut found = R::ESTIMATE(surface, sources, options)?;
        let estimate = Some(Estimate::of(&mut found));
        let map = if args.extrapolate { found.into_extrapolated_map() } else { found.map };
        Ok(Self { map, estimate })
    }
}

impl Args {
    fn precision(&self) -> Precision {
        self.precision.unwrap_or(problem::default_precision(&self.surface, &self.solver))
    }

    /// Rejects outputs that the surface does not support, before anything is computed.
    fn check(&self, scene: &Scene) -> Result<(), String> {
        self.directions.check(scene)
    }

    /// Prints notes about the map that the user should know.
    fn comment<R>(&self, surface: &Surface, solved: &Solved<R>, options: &Options) {
        let report = &solved.map.report;
        problem::comment(report, options);
        if let Some(Estimate { mean_relative, max_relative, unknown, .. }) = solved.estimate {
            let before = if self.extrapolate { " before extrapolation" } else { "" };
            note!(
                "estimated relative error{before}: mean {mean_relative:.1e}, largest \
                     {max_relative:.1e}"
            );
            if unknown > 0 {
                note!("{unknown} points have no estimate of their error");
            }
        }
        let holes = report.points < surface.chart().points();
        if self.extrapolate && holes && report.wavefront != Wavefront::Anchored {
            note!(
                "extrapolated distances are less accurate than plain ones where paths bend around \
                 holes"
            );
        }
    }
}

/// The files to write. They are checked before the computation starts.
struct Outputs {
    map: Option<(OutputFile, MapFormat)>,
    error: Option<(OutputFile, MapFormat)>,
    picture: Option<OutputFile>,
    directions: DirectionOutputs,
}

impl Outputs {
    fn new(args: &Args) -> Result<Self, Box<dyn Error>> {
        let map_output = |path| map_output(path, args.precision());
        let map = args.output.as_deref().map(map_output).transpose()?;
        let error = args.error.as_deref().map(map_output).transpose()?;
        let picture = args.picture.output()?;
        let directions = args.directions.outputs()?;
        let maps = map.iter().chain(&error).map(|(file, _)| file);
        let files: Vec<_> = maps.chain(&picture).chain(directions.files()).collect();
        let inputs = problem::inputs(&args.surface, &args.sources);
        let targets = args.limits.files().map(AsRef::as_ref);
        check_outputs(&files, inputs.chain(targets).chain(args.directions.input()))?;
        Ok(Self { map, error, picture, directions })
    }

    /// Writes all files, then moves them to their final names.
    fn write<R: Number>(
        self,
        args: &Args,
        scene: &Scene,
        sources: &GivenSources,
        look: Option<Look>,
        Solved { map, estimate }: &Solved<R>,
    ) -> Result<Written, Box<dyn Error>> {
        let (rows, cols) = (scene.chart().rows, scene.chart().cols);
        let geo_tags = scene.geo_tags.as_ref();
        let mut staged = self.directions.stage(scene, sources, map)?;
        if let Some((output, format)) = self.map {
            let distances = args.directions.sign.of(scene, sources, &map.distances)?;
            staged.push(
                output.stage(|writer| format.write(writer, rows, cols, &distances, geo_tags))?,
            );
        }
        if let Some(((output, format), Estimate { errors, .. })) = self.error.zip(estimate.as_ref())
        {
            let errors = scene.crop(errors);
            staged
                .push(output.stage(|writer| format.write(writer, rows, cols, &errors, geo_tags))?);
        }
        if let Some((output, look)) = self.picture.zip(look) {
            let (map, quantity) = (&map.to_single(), &args.picture.quantity(scene));
            let (surface, shape) = (&scene.surface, scene.shape());
            staged.push(stage_picture(output, || match look {
                Look::Map => Picture { surface, shape, map, sources, quantity }.draw(),
                look => draw_over_map(scene, sources, map, quantity, Default::default(), look),
            })?);
        }
        Ok(commit(staged)?)
    }
}

/// Returns the output file of a map, in the format that its extension names.
fn map_output(
    path: &Path,
    precision: Precision,
) -> Result<(OutputFile, MapFormat), Box<dyn Error>> {
    let format = MapFormat::of(path)?;
    if precision == Precision::Double && !format.holds_double() {
        let name = path.display();
        let message = format!(
            "{name}: {format} files hold single precision only; write .npy or .tif, or give \
             --precision single"
        );
        return Err(message.into());
    }
    Ok((OutputFile::new(path)?, format))
}

#[derive(Serialize)]
struct Summary<'a, R> {
    #[serde(flatten)]
    map: MapSummary<'a, R>,
    extrapolated: bool,
    mean_relative_error: Option<f64>,
    max_relative_error: Option<f64>,
}

impl<'a, R: Number> Summary<'a, R> {
    fn new(scene: &Scene, args: &Args, solved: &'a Solved<R>) -> Self {
        let Solved { map, estimate } = solved;
        Self {
            map: MapSummary::new(scene, map),
            extrapolated: args.extrapolate,
            mean_relative_error: estimate.as_ref().map(|estimate| estimate.mean_relative),
            max_relative_error: estimate.as_ref().map(|estimate| estimate.max_relative),
        }
    }
}

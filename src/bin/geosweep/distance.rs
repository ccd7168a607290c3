//! `geosweep distance`: from a surface and sources to a map.

use std::error::Error;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::Duration;

use clap::ValueEnum;
use clap::builder::{OsStringValueParser, TypedValueParser};
use geosweep::io::{self, MapFormat, OutputFile, SurfaceFile};
use geosweep::surface::builtin::Builtin;
use geosweep::{
    DEFAULT_TOLERANCE, DeviceChoice, DistanceMap, EdgeRule, Engine, ErrorEstimate, Options,
    Sources, Spacing, Surface, Wavefront, distance_map, estimate_error,
};
use indicatif::ProgressBar;
use serde::Serialize;

use crate::output_file::png_output;
use crate::picture::Picture;
use crate::surface_arg::SurfaceArg;
use crate::{Outcome, print, say};

/// The arguments of `geosweep distance`.
#[derive(clap::Args)]
#[command(after_help = examples())]
#[command(group = clap::ArgGroup::new("sources").required(true).multiple(true))]
pub struct Args {
    /// A file, or builtin:NAME:ROWSxCOLS. Files: .npy with positions (M, N, 3), heights (M, N) or a
    /// metric (M, N, 2, 2); .png with heights, grey, 8 or 16 bits; .tif with heights; .exr with
    /// positions in channels X, Y, Z or R, G, B, or heights in a single channel. NaN marks holes
    #[arg(value_parser = OsStringValueParser::new().try_map(SurfaceArg::parse))]
    surface: SurfaceArg,
    /// Where to write the map: .npy (M, N), .tif or .exr, float32, +infinity at holes and where no
    /// source reaches
    #[arg(short, long, value_name = "MAP")]
    output: PathBuf,

    /// A point source: row and column, which may be fractional, and the distance it starts with
    /// (default 0); repeatable
    #[arg(short, long, value_name = "R,C[,T0]", group = "sources", help_heading = "Sources")]
    #[arg(value_parser = point, allow_hyphen_values = true)]
    source: Vec<[f64; 3]>,
    /// A curve, every point of which is a source: an .npy array (K, 2) of rows and columns, or a
    /// text file with a line `row,col` per vertex; repeatable
    #[arg(long, value_name = "FILE", group = "sources", help_heading = "Sources")]
    source_curve: Vec<PathBuf>,

    /// Distance between columns and rows of heights, in the unit of the heights (default: what a
    /// projected GeoTIFF says, else 1)
    #[arg(long, value_name = "DX[,DY]", help_heading = "Surface", value_parser = spacing)]
    #[arg(allow_hyphen_values = true)]
    spacing: Option<Spacing>,
    /// Where the surface is (non-zero) and where it has holes (zero): .npy (M, N) of bool or uint8,
    /// or an 8-bit grey .png
    #[arg(long, value_name = "FILE", help_heading = "Surface")]
    mask: Option<PathBuf>,
    /// Weight of lengths at each point, the reciprocal of a speed, so that distances become travel
    /// times: .npy (M, N), positive
    #[arg(long, value_name = "FILE", help_heading = "Surface")]
    slowness: Option<PathBuf>,
    /// Lengths from this metric in place of SURFACE's, whose positions are still used for the
    /// picture: .npy (M, N, 2, 2), symmetric and positive definite, per step of one row (axis 0)
    /// and one column (axis 1)
    #[arg(long, value_name = "FILE", help_heading = "Surface")]
    metric: Option<PathBuf>,
    /// How long the surface is between neighbouring points; a metric has its own lengths
    #[arg(long, value_enum, default_value_t, help_heading = "Surface")]
    edges: EdgesArg,

    /// The front assumed between points
    #[arg(long, value_enum, default_value_t, help_heading = "Solver")]
    wavefront: WavefrontArg,
    /// What computes the map
    #[arg(long, value_enum, default_value_t, help_heading = "Solver")]
    engine: EngineArg,
    /// The Vulkan device: its index in `geosweep devices`, or a part of its name; implies
    /// --engine vulkan
    #[arg(long, value_name = "NAME|INDEX", help_heading = "Solver")]
    device: Option<String>,
    /// Stop after this many iterations of four scans (default: 10 for each row and column)
    #[arg(long, value_name = "N", help_heading = "Solver")]
    iterations: Option<u32>,
    /// Stop when no distance falls by more than this fraction in an iteration
    #[arg(long, value_name = "T", default_value_t = DEFAULT_TOLERANCE, help_heading = "Solver")]
    #[arg(allow_hyphen_values = true)]
    tolerance: f64,

    /// Estimate each distance's error from maps of every second and fourth point, which takes a
    /// third more time: .npy (M, N), .tif or .exr, float32, in the unit of the distances, +infinity
    /// where there is no estimate. Too large by far behind holes
    #[arg(long, value_name = "FILE", help_heading = "Accuracy")]
    error: Option<PathBuf>,
    /// Write the map less its estimated error (Richardson's extrapolation), for a third more time.
    /// On smooth surfaces a half to a hundredth of the error is left, least from sources at grid
    /// points; behind holes it grows
    #[arg(long, help_heading = "Accuracy")]
    extrapolate: bool,

    /// Draw the map: colours and lines of equal distance over the shaded surface
    #[arg(long, value_name = "FILE.png", help_heading = "Reports")]
    picture: Option<PathBuf>,
    /// Print one JSON object: engine, device, fallback, schedule, wavefront, iterations,
    /// iteration_bound (Theorem 1's, where it applies), residual, converged, solve_seconds, rows,
    /// cols, points, reached, max_distance, extrapolated, and with --error or --extrapolate the
    /// estimated mean_relative_error and max_relative_error before extrapolation
    #[arg(long, help_heading = "Reports")]
    json: bool,
}

fn examples() -> String {
    format!(
        "\
Distances are in the unit of the positions, or of the heights and the spacing,
which must agree. Rows count downwards from 0, columns rightwards from 0.

Built-in surfaces:
  {}; sheared-plane@DEGREES says by what angle.

Examples:
  An elevation model in metres, 30 m between points, with a picture:
    geosweep distance dem.png --spacing 30 --source 172,201 -o map.npy --picture map.png
  A scan with a mask, from a curve and from a point that starts at 12.5:
    geosweep distance scan.npy --mask face.png --source-curve brow.csv \\
      --source 80.5,64.25,12.5 -o map.npy
  Travel times, on the CPU, with a report to parse:
    geosweep distance dem.tif --slowness slowness.npy --source 10,10 \\
      --engine cpu --json -o time.npy
  A built-in surface, with an estimate of each distance's error:
    geosweep distance builtin:sphere:257x257 --source 0,0 -o sphere.npy \\
      --error error.npy",
        Builtin::names()
    )
}

#[derive(Clone, Copy, Debug, Default, ValueEnum)]
enum WavefrontArg {
    /// Curved; but point on a surface with a slowness, for point sources that start together
    #[default]
    Auto,
    /// Carries its curvature: the most accurate on smooth surfaces, around walls and from curves,
    /// in about twice the time of point
    Curved,
    /// Circular: exact on developable surfaces but for the sampling, for point sources only
    Point,
    /// Straight: first-order accurate, as in the paper
    Planar,
}

#[derive(Clone, Copy, Debug, Default, ValueEnum)]
enum EdgesArg {
    /// Along the surface where it bends alike at both ends, else the chord
    #[default]
    Arc,
    /// Straight: the surface is the polyhedron of its points
    Chord,
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
enum EngineArg {
    /// The first usable Vulkan device, else the CPU
    #[default]
    Auto,
    /// A Vulkan device, or an error
    Vulkan,
    /// Raster scans on the CPU
    Cpu,
    /// Fast marching on the CPU, the sequential reference
    FastMarching,
}

fn point(text: &str) -> Result<[f64; 3], String> {
    match numbers(text)?[..] {
        [row, col] => Ok([row, col, 0.0]),
        [row, col, start] => Ok([row, col, start]),
        _ => Err("a source is a row and a column, and perhaps a start value: R,C[,T0]".into()),
    }
}

fn spacing(text: &str) -> Result<Spacing, String> {
    let spacing = match numbers(text)?[..] {
        [both] => Spacing::square(both),
        [dx, dy] => Spacing { dx, dy },
        _ => return Err("a spacing is one number, or one for columns and one for rows".into()),
    };
    if spacing.dx > 0.0 && spacing.dy > 0.0 {
        Ok(spacing)
    } else {
        Err("a spacing must be positive".into())
    }
}

/// Finite numbers with commas between them.
fn numbers(text: &str) -> Result<Vec<f64>, String> {
    let number = |text: &str| match text.trim().parse::<f64>() {
        Ok(number) if number.is_finite() => Ok(number),
        _ => Err(format!("`{text}` is not a finite number")),
    };
    text.split(',').map(number).collect()
}

pub fn run(args: &Args) -> Outcome {
    let options = args.options()?;
    let outputs = Outputs::new(args)?;
    let scene = Scene::read(args)?;
    let sources = args.sources()?;
    let solved = {
        let _spinner = Spinner::new("computing distances");
        args.solve(&scene.surface, &sources, &options)?
    };
    args.comment(&scene.surface, &solved);
    outputs.write(&scene, &sources, &solved)?;
    if args.json {
        print(serde_json::to_string(&Summary::new(&scene.surface, args, &solved))?)?;
    }
    Ok(ExitCode::SUCCESS)
}

/// What is written and reported.
struct Solved {
    map: DistanceMap,
    estimate: Option<Estimate>,
}

/// The estimated errors of the map, before any extrapolation.
struct Estimate {
    errors: Vec<f32>,
    mean_relative: f64,
    max_relative: f64,
    unknown: usize,
}

impl Estimate {
    fn of(estimate: &mut ErrorEstimate) -> Self {
        let (mean_relative, max_relative) = estimate.relative();
        let unknown = estimate.unknown();
        let errors = std::mem::take(&mut estimate.errors);
        Self { errors, mean_relative, max_relative, unknown }
    }
}

impl Args {
    fn options(&self) -> Result<Options, String> {
        Ok(Options {
            engine: self.engine()?,
            wavefront: match self.wavefront {
                WavefrontArg::Auto => None,
                WavefrontArg::Curved => Some(Wavefront::Curved),
                WavefrontArg::Point => Some(Wavefront::PointSource),
                WavefrontArg::Planar => Some(Wavefront::Planar),
            },
            tolerance: self.tolerance,
            iterations: self.iterations,
        })
    }

    fn solve(
        &self,
        surface: &Surface,
        sources: &Sources,
        options: &Options,
    ) -> Result<Solved, geosweep::Error> {
        if self.error.is_none() && !self.extrapolate {
            let map = distance_map(surface, sources, options)?;
            return Ok(Solved { map, estimate: None });
        }
        let mut found = estimate_error(surface, sources, options)?;
        let estimate = Some(Estimate::of(&mut found));
        let map = if self.extrapolate { found.into_extrapolated_map() } else { found.map };
        Ok(Solved { map, estimate })
    }

    fn engine(&self) -> Result<Engine, String> {
        let device = self.device.as_ref().map(|device| match device.parse() {
            Ok(index) => DeviceChoice::Index(index),
            Err(_) => DeviceChoice::Name(device.clone()),
        });
        match (self.engine, device) {
            (EngineArg::Auto | EngineArg::Vulkan, Some(device)) => Ok(Engine::Vulkan(device)),
            (_, Some(_)) => Err("--device is for --engine vulkan; leave one of them out".into()),
            (EngineArg::Auto, None) => Ok(Engine::Auto),
            (EngineArg::Vulkan, None) => Ok(Engine::Vulkan(DeviceChoice::Any)),
            (EngineArg::Cpu, None) => Ok(Engine::Cpu),
            (EngineArg::FastMarching, None) => Ok(Engine::FastMarching),
        }
    }

    fn sources(&self) -> Result<Sources, io::IoError> {
        let points = self.source.iter().fold(Sources::default(), |sources, &[row, col, start]| {
            sources.and_point(row, col, start)
        });
        self.source_curve
            .iter()
            .try_fold(points, |sources, path| Ok(sources.and_curve(io::read_curve(path)?, 0.0)))
    }

    fn inputs(&self) -> impl Iterator<Item = &Path> {
        let surface = match &self.surface {
            SurfaceArg::File(path) => Some(path),
            SurfaceArg::Builtin(_) => None,
        };
        let optional = [surface, self.mask.as_ref(), self.slowness.as_ref(), self.metric.as_ref()];
        optional.into_iter().flatten().chain(&self.source_curve).map(PathBuf::as_path)
    }

    /// What the user should know though the map is there.
    fn comment(&self, surface: &Surface, solved: &Solved) {
        let report = &solved.map.report;
        if let Some(reason) = &report.fallback {
            say("note", format_args!("computed on the CPU, since Vulkan cannot be used: {reason}"));
        }
        if !report.converged {
            let (iterations, residual) = (report.iterations, report.residual);
            say(
                "warning",
                format_args!(
                    "not converged after {iterations} iterations: the last changed a distance by a \
                     fraction of {residual:.1e}, the tolerance is {:.1e}; give more --iterations",
                    self.tolerance
                ),
            );
        }
        let unreached = report.points - report.reached;
        if unreached > 0 {
            let points = report.points;
            say("note", format_args!("{unreached} of {points} points cannot be reached"));
        }
        if let Some(Estimate { mean_relative, max_relative, unknown, .. }) = solved.estimate {
            let before = if self.extrapolate { " before extrapolation" } else { "" };
            say(
                "note",
                format_args!(
                    "estimated relative error{before}: mean {mean_relative:.1e}, largest \
                     {max_relative:.1e}"
                ),
            );
            if unknown > 0 {
                say("note", format_args!("{unknown} points have no estimate of their error"));
            }
        }
        if self.extrapolate && report.points < surface.chart().points() {
            say(
                "note",
                "extrapolated distances are less accurate than plain ones where paths bend around \
                 holes",
            );
        }
    }
}

/// The files to write, checked before the work begins.
struct Outputs {
    map: OutputFile,
    format: MapFormat,
    error: Option<(OutputFile, MapFormat)>,
    picture: Option<OutputFile>,
}

impl Outputs {
    fn new(args: &Args) -> Result<Self, Box<dyn Error>> {
        let format = MapFormat::of(&args.output)?;
        let map = OutputFile::new(&args.output)?;
        let error = match &args.error {
            None => None,
            Some(path) => {
                let format = MapFormat::of(path)?;
                Some((OutputFile::new(path)?, format))
            }
        };
        let picture = args.picture.as_deref().map(png_output).transpose()?;
        let error_file = error.as_ref().map(|(file, _)| file);
        if let Some(file) = error_file.filter(|file| map.is_same(file)) {
            let name = file.path().display();
            return Err(format!("{name}: is the map's file too; choose another name").into());
        }
        // The same file under two names is rare and worth an error before anything is lost.
        let resolve = |path: &Path| fs::canonicalize(path).ok();
        for output in std::iter::once(&map).chain(error_file).chain(&picture) {
            let target = resolve(output.path());
            if target.is_some() && args.inputs().any(|input| resolve(input) == target) {
                let name = output.path().display();
                return Err(format!("{name}: is also an input; choose another name").into());
            }
        }
        Ok(Self { map, format, error, picture })
    }

    /// Writes all files, then gives them their names.
    fn write(
        self,
        scene: &Scene,
        sources: &Sources,
        Solved { map, estimate }: &Solved,
    ) -> Result<(), Box<dyn Error>> {
        let (rows, cols) = (map.chart.rows, map.chart.cols);
        let staged_map =
            self.map.stage(|writer| self.format.write(writer, rows, cols, &map.distances))?;
        let mut staged = vec![staged_map];
        if let Some(((output, format), Estimate { errors, .. })) = self.error.zip(estimate.as_ref())
        {
            staged.push(output.stage(|writer| format.write(writer, rows, cols, errors))?);
        }
        if let Some(output) = self.picture {
            let _spinner = Spinner::new("drawing");
            let picture = Picture { surface: &scene.surface, shape: scene.shape(), map, sources };
            staged.push(output.stage(|writer| picture.draw().write_png(writer))?);
        }
        Ok(staged.into_iter().try_for_each(io::StagedFile::commit)?)
    }
}

/// The surface that is solved for, and the one that is drawn.
struct Scene {
    surface: Surface,
    /// Where lengths come from a metric of their own, the surface that has positions.
    shape: Option<Surface>,
}

impl Scene {
    fn read(args: &Args) -> Result<Self, Box<dyn Error>> {
        let given = args.read_surface()?;
        let (rows, cols) = (given.rows(), given.cols());
        let (mut surface, shape) = match &args.metric {
            None => (given, None),
            Some(path) => {
                let metric = io::read_metric(path)?.fit(path, rows, cols)?;
                let surface = Surface::from_metric(rows, cols, metric)
                    .and_then(|surface| surface.with_mask(given.present()))
                    .map_err(|error| format!("{}: {error}", path.display()))?;
                (surface, Some(given))
            }
        };
        if let Some(path) = &args.mask {
            let mask = io::read_mask(path)?.fit(path, rows, cols)?;
            surface = surface.with_mask(&mask).map_err(|e| format!("{}: {e}", path.display()))?;
        }
        if let Some(path) = &args.slowness {
            let slowness = io::read_slowness(path)?.fit(path, rows, cols)?;
            surface =
                surface.with_slowness(slowness).map_err(|e| format!("{}: {e}", path.display()))?;
        }
        let surface = surface.with_edge_rule(match args.edges {
            EdgesArg::Arc => EdgeRule::Arc,
            EdgesArg::Chord => EdgeRule::Chord,
        });
        Ok(Self { surface, shape })
    }

    fn shape(&self) -> &Surface {
        self.shape.as_ref().unwrap_or(&self.surface)
    }
}

impl Args {
    fn read_surface(&self) -> Result<Surface, Box<dyn Error>> {
        match &self.surface {
            SurfaceArg::Builtin(builtin) => {
                if self.spacing.is_some() {
                    return Err("--spacing is for heights from a file; a built-in surface has \
                                its own size, leave it out"
                        .into());
                }
                Ok(builtin.surface()?)
            }
            SurfaceArg::File(path) => {
                let _spinner = Spinner::new("reading");
                let file = SurfaceFile::read(path)?;
                if file.lacks_spacing() && self.spacing.is_none() {
                    let name = path.display();
                    say(
                        "note",
                        format_args!(
                            "{name}: heights are taken as 1 apart; --spacing says otherwise"
                        ),
                    );
                }
                Ok(file.into_surface(self.spacing)?)
            }
        }
    }
}

/// A sign of life on a terminal while it lives.
struct Spinner(ProgressBar);

impl Spinner {
    fn new(doing: &'static str) -> Self {
        let bar = ProgressBar::new_spinner().with_message(doing);
        bar.enable_steady_tick(Duration::from_millis(100));
        Self(bar)
    }
}

impl Drop for Spinner {
    fn drop(&mut self) {
        self.0.finish_and_clear();
    }
}

#[derive(Serialize)]
struct Summary<'a> {
    engine: &'a str,
    device: Option<&'a str>,
    fallback: Option<&'a str>,
    schedule: &'a str,
    wavefront: &'a str,
    iterations: u32,
    iteration_bound: Option<u64>,
    residual: f64,
    converged: bool,
    solve_seconds: f64,
    rows: usize,
    cols: usize,
    points: usize,
    reached: usize,
    max_distance: f32,
    extrapolated: bool,
    mean_relative_error: Option<f64>,
    max_relative_error: Option<f64>,
}

impl<'a> Summary<'a> {
    fn new(surface: &Surface, args: &Args, solved: &'a Solved) -> Self {
        let Solved { map, estimate } = solved;
        let report = &map.report;
        Self {
            engine: report.engine,
            device: report.device.as_deref(),
            fallback: report.fallback.as_deref(),
            schedule: report.schedule,
            wavefront: report.wavefront.name(),
            iterations: report.iterations,
            iteration_bound: surface.iteration_bound(),
            residual: report.residual,
            converged: report.converged,
            solve_seconds: report.solve_time.as_secs_f64(),
            rows: map.chart.rows,
            cols: map.chart.cols,
            points: report.points,
            reached: report.reached,
            max_distance: report.max_distance,
            extrapolated: args.extrapolate,
            mean_relative_error: estimate.as_ref().map(|estimate| estimate.mean_relative),
            max_relative_error: estimate.as_ref().map(|estimate| estimate.max_relative),
        }
    }
}

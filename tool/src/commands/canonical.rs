//! Implements `geosweep canonical`, which computes the canonical form of a surface or a distance matrix.

use std::error::Error;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::Instant;

use geosweep::geometry::canonical::{
    self, CanonicalError, CanonicalForm, Distances, FormOptions, canonical_form_with,
};
use geosweep::glam::DVec3;
use geosweep::io::{
    OutputFile, SquareMatrix, is_distance_matrix, read_matrix, write_npy, write_ply,
};
use geosweep::pairwise::Pairwise;
use geosweep::surface::Chart;
use geosweep::{Options, Wavefront};
use serde::Serialize;

use crate::numbers::whole;
use crate::output::{Written, check_outputs, commit, done, stage_picture, wanted_png};
use crate::picture::FormPicture;
use crate::picture::scene::grid_triangles;
use crate::problem::{SurfaceArgs, builtin_names, warn_of_no_convergence};
use crate::terminal::{Outcome, Spinner, counted, print_json, progress};

/// The arguments of `geosweep canonical`.
#[derive(clap::Args)]
#[command(after_help = examples())]
pub struct Args {
    #[command(flatten)]
    surface: SurfaceArgs,
    /// Output file for the form. An .npy file is float64, (M, N, K) for a grid or (n, K) for a matrix, with
    /// NaN at points that are left out. A .ply file has two or three dimensions, and triangles for a grid
    #[arg(short, long, value_name = "FORM")]
    output: PathBuf,
    /// Read SURFACE as a matrix: an .npy array of the distances between n points, (n, n) or, as from SciPy's
    /// squareform, (n (n - 1) / 2,), with +infinity where there is no path. An array that can only be a
    /// matrix needs no option
    #[arg(long, help_heading = "Surface")]
    matrix: bool,
    /// Use at most this many points of a grid: every second row and column, every third, and so on. Their
    /// distances are still computed on the whole grid
    #[arg(long, value_name = "N", default_value_t = 5000, value_parser = whole("points", 2..=MOST_POINTS))]
    #[arg(help_heading = "Surface")]
    points: usize,

    /// Dimensions K of the space
    #[arg(long, value_name = "K", default_value_t = 3, help_heading = "Solver")]
    dimensions: usize,
    /// Stop after this many iterations of majorisation
    #[arg(long, value_name = "N", default_value_t = 1000, help_heading = "Solver")]
    iterations: usize,
    /// Stop when the stress falls by less than this fraction in each of two iterations
    #[arg(long, value_name = "T", default_value_t = canonical::DEFAULT_TOLERANCE)]
    #[arg(allow_hyphen_values = true, help_heading = "Solver")]
    tolerance: f64,
    /// Wavefront assumed between points when distances are computed: planar, circular or curved
    #[arg(long, value_name = "FRONT", default_value = "curved")]
    #[arg(help_heading = "Solver")]
    wavefront: Wavefront,

    /// Draw the form: shaded, coloured along the grid's columns, with some rows and columns as
    /// lines
    #[arg(long, value_name = "FILE.png", help_heading = "Reports")]
    picture: Option<PathBuf>,
    /// Print one JSON object; docs/json.md and docs/geosweep.schema.json describe it
    #[arg(long, help_heading = "Reports")]
    json: bool,
}

fn examples() -> String {
    format!(
        "\
The canonical form stays the same, up to rotations and reflections, when the surface
is bent without stretching. Points that are not connected to the largest piece of the
surface are left out.

{}

Examples:
  geosweep canonical builtin:torus:65x65 -o form.npy --picture form.png
  geosweep canonical face.npy --mask face.png --points 3000 -o form.ply --json
  geosweep canonical distances.npy --dimensions 2 -o form.npy",
        builtin_names()
    )
}

/// The largest number of points. The matrix of their distances must fit memory.
const MOST_POINTS: usize = 16384;

pub fn run(args: &Args) -> Outcome {
    let outputs = Outputs::new(args)?;
    let start = Instant::now();
    let Pairs { chart, points, matrix, given } = Pairs::read(args)?;
    let (distances, kept) = match Distances::of_largest_piece(points, matrix) {
        Err(CanonicalError::Asymmetric { there, back, .. }) if chart.is_some() => {
            return Err(format!(
                "the surface is too rough for its grid: the distance between two of its points is \
                 {there} in one direction and {back} in the other; smooth it, or take a finer grid"
            )
            .into());
        }
        distances => distances?,
    };
    let distance_seconds = start.elapsed().as_secs_f64();
    let left_out = given - kept.len();
    if left_out > 0 {
        let kept = kept.len();
        note!("{left_out} points are left out: no path leads to the {kept} others");
    }
    let start = Instant::now();
    let form = args.form(&distances)?;
    let form_seconds = start.elapsed().as_secs_f64();
    if !form.converged {
        let iterations = counted(form.iterations() as u64, "iteration");
        warning!("not settled after {iterations}; give more --iterations");
    }
    let placed = Placed::new(&form, points, &kept, chart);
    let written = outputs.write(&placed)?;
    let state = if form.converged { "settled" } else { "not settled" };
    let iterations = counted(form.iterations() as u64, "iteration");
    done(
        [
            format!("{} in {} dimensions", counted(kept.len() as u64, "point"), form.dimensions),
            format!("{state} after {iterations} in {form_seconds:.2} s"),
            format!("stress {:.2e}", form.stress_1()),
        ],
        &written,
    );
    if args.json {
        let summary = Summary {
            dimensions: form.dimensions,
            placed: kept.len(),
            left_out,
            rows: chart.map(|chart| chart.rows),
            cols: chart.map(|chart| chart.cols),
            iterations: form.iterations(),
            converged: form.converged,
            raw_stress: form.raw_stress(),
            stress_1: form.stress_1(),
            start_stress: form.stresses[0],
            distance_seconds,
            form_seconds,
        };
        print_json("canonical", &summary)?;
    }
    Ok(ExitCode::SUCCESS)
}

impl Args {
    fn form(&self, distances: &Distances) -> Result<CanonicalForm, Box<dyn Error>> {
        let options = FormOptions::default()
            .with_dimensions(self.dimensions)
            .with_tolerance(self.tolerance)
            .with_iterations(self.iterations);
        let bar = progress(self.iterations);
        let form = canonical_form_with(distances, &options, |step| {
            bar.set_message(format!("stress {:.4e}", step.stress));
            bar.set_position(step.iteration as u64);
        });
        bar.finish_and_clear();
        Ok(form?)
    }
}

/// The distances between all points, and the grid of the points.
struct Pairs {
    /// The grid that the points form, if there is one.
    chart: Option<Chart>,
    points: usize,
    matrix: Vec<f32>,
    /// The number of points that are not holes.
    given: usize,
}

impl Pairs {
    fn read(args: &Args) -> Result<Self, Box<dyn Error>> {
        let file = args.surface.file();
        if args.matrix {
            let path = file.ok_or("--matrix is for a file, not for a built-in surface")?;
            return Self::from_matrix(path);
        }
        if let Some(path) = file.filter(|path| is_distance_matrix(path)) {
            let name = path.display();
            note!("{name}: taken as a matrix of distances");
            return Self::from_matrix(path);
        }
        Self::from_surface(args)
    }

    fn from_matrix(path: &Path) -> Result<Self, Box<dyn Error>> {
        let _spinner = Spinner::new("reading");
        let SquareMatrix { points, distances } = read_matrix(path)?;
        Ok(Self { chart: None, points, matrix: distances, given: points })
    }

    fn from_surface(args: &Args) -> Result<Self, Box<dyn Error>> {
        let scene = args.surface.read()?;
        let surface = &scene.surface;
        let (chart, points) = every_few(scene.chart(), args.points);
        if chart != scene.chart() {
            let (Chart { rows, cols }, whole) = (chart, scene.chart());
            note!(
                "{rows} x {cols} of the {} x {} points are used; --points takes more",
                whole.rows,
                whole.cols
            );
        }
        let points: Vec<usize> =
            points.into_iter().map(|point| scene.index(point)).collect::<Result<_, _>>()?;
        let options = Options::default().with_wavefront(args.wavefront);
        let mut pairwise = Pairwise::new(surface, &options)?;
        let bar = progress(points.len()).with_message("computing distances");
        let (matrix, report) = pairwise.among(&points, |rows| bar.inc(rows as u64))?;
        bar.finish_and_clear();
        if !report.converged() {
            warn_of_no_convergence(&options, report.iterations, report.residual, report.tolerance);
        }
        let given = points.iter().filter(|&&point| surface.present()[point]).count();
        Ok(Self { chart: Some(chart), points: points.len(), matrix, given })
    }
}

/// Returns the grid of every k-th row and column of `whole`, and the rows and columns of its points in `whole`. The
/// step k is the smallest one that leaves at most `most` points.
fn every_few(whole: Chart, most: usize) -> (Chart, Vec<[f64; 2]>) {
    let count = |points: usize, step: usize| (points - 1) / step + 1;
    let grid = |step| Chart { rows: count(whole.rows, step), cols: count(whole.cols, step) };
    let step = (1..).find(|&step| grid(step).points() <= most).expect("some step leaves one point");
    let chart = grid(step);
    let place = |index| {
        let (row, col) = chart.position(index);
        [row, col].map(|line| (line * step) as f64)
    };
    (chart, (0..chart.points()).map(place).collect())
}

/// The coordinates of all points, filled in from the form's points.
struct Placed {
    chart: Option<Chart>,
    points: usize,
    dimensions: usize,
    /// The coordinates, NaN at points that are left out.
    coordinates: Vec<f64>,
}

impl Placed {
    fn new(form: &CanonicalForm, points: usize, kept: &[usize], chart: Option<Chart>) -> Self {
        let dimensions = form.dimensions;
        let mut coordinates = vec![f64::NAN; points * dimensions];
        for (&point, place) in kept.iter().zip(form.coordinates.chunks(dimensions)) {
            coordinates[point * dimensions..][..dimensions].copy_from_slice(place);
        }
        Self { chart, points, dimensions, coordinates }
    }

    fn shape(&self) -> Vec<usize> {
        match self.chart {
            Some(Chart { rows, cols }) => vec![rows, cols, self.dimensions],
            None => vec![self.points, self.dimensions],
        }
    }

    /// Returns the first three coordinates of each point. Missing coordinates are zero.
    fn positions(&self) -> Vec<DVec3> {
        let place = |place: &[f64]| {
            let axis = |axis: usize| place.get(axis).copied().unwrap_or_default();
            DVec3::new(axis(0), axis(1), axis(2))
        };
        self.coordinates.chunks(self.dimensions).map(place).collect()
    }
}

/// The files to write. They are checked before the computation starts.
struct Outputs {
    form: OutputFile,
    is_ply: bool,
    picture: Option<OutputFile>,
}

impl Outputs {
    fn new(args: &Args) -> Result<Self, Box<dyn Error>> {
        let name = args.output.display();
        let extension = args.output.extension().unwrap_or_default().to_ascii_lowercase();
        let is_ply = extension == "ply";
        if !is_ply && extension != "npy" {
            return Err(format!("{name}: a form is written as .npy or .ply").into());
        }
        if is_ply && !(2..=3).contains(&args.dimensions) {
            return Err(format!("{name}: a .ply has 2 or 3 dimensions; write .npy").into());
        }
        let form = OutputFile::new(&args.output)?;
        let picture = wanted_png(args.picture.as_ref())?;
        let outputs: Vec<_> = std::iter::once(&form).chain(&picture).collect();
        check_outputs(&outputs, args.surface.inputs().map(AsRef::as_ref))?;
        Ok(Self { form, is_ply, picture })
    }

    /// Writes all files, then moves them to their final names.
    fn write(self, placed: &Placed) -> Result<Written, Box<dyn Error>> {
        let positions = placed.positions();
        let form = if self.is_ply {
            let triangles = placed.chart.map(|chart| grid_triangles(chart, &positions));
            let points: Vec<_> = positions.iter().map(|position| position.to_array()).collect();
            self.form.stage(|writer| write_ply(writer, &points, &triangles.unwrap_or_default()))?
        } else {
            self.form.stage(|writer| write_npy(writer, &placed.shape(), &placed.coordinates))?
        };
        let mut staged = vec![form];
        if let Some(output) = self.picture {
            let picture = FormPicture::new(&positions, placed.chart);
            staged.push(stage_picture(output, || picture.draw())?);
        }
        Ok(commit(staged)?)
    }
}

#[derive(Serialize)]
struct Summary {
    dimensions: usize,
    placed: usize,
    left_out: usize,
    rows: Option<usize>,
    cols: Option<usize>,
    iterations: usize,
    converged: bool,
    raw_stress: f64,
    stress_1: f64,
    start_stress: f64,
    distance_seconds: f64,
    form_seconds: f64,
}

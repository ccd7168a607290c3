//! Implements `geosweep pairwise`, which computes the distances between all points of a surface.

mod sources;
mod sparse;

use std::borrow::Cow;
use std::error::Error;
use std::path::PathBuf;
use std::process::ExitCode;
use std::sync::atomic::{AtomicBool, Ordering};

use geosweep::geometry::Voronoi;
use geosweep::io::{
    Element, IoError, MatrixFile, MatrixLayout, OutputFile, Provenance, surface_checksum,
};
use geosweep::pairwise::{Pairwise, PairwiseReport, Rows};
use geosweep::surface::EdgeLengths;
use geosweep::{DEFAULT_TOLERANCE, DeviceChoice, Engine, Surface};
use indicatif::ProgressBar;
use serde::Serialize;

use super::labels::{labels_output, numbers, stage_labels};
use super::samples::{Sample, farthest_points, middle};
use crate::choices::one_of;
use crate::numbers::whole;
use crate::output::{Written, check_outputs, done, wanted_file};
use crate::precision::Precision;
use crate::problem::{
    Scene, SolverArgs, SurfaceArgs, builtin_names, convergence, engine_name, seconds,
    warn_of_no_convergence,
};
use crate::terminal::{Outcome, Spinner, print_json, progress_of_rows};
use sources::RowsOf;

/// The arguments of `geosweep pairwise`.
#[derive(clap::Args)]
#[command(after_help = examples(), mut_arg("schedule", |schedule| schedule.hide(true)))]
pub struct Args {
    #[command(flatten)]
    surface: SurfaceArgs,
    /// Output file for the distances: .npy, float32, (n, n) for the n points of the grid in row-major order.
    /// Distances of holes are +infinity, and so are those between points that no path connects. With --format
    /// csr it is .npz. Optional with --json, to time the solver alone
    #[arg(short, long, value_name = "D.npy|D.npz", required_unless_present = "json")]
    output: Option<PathBuf>,
    /// Compute only the rows of these points, (k, n). This is a range A..B of rows of the matrix, without B,
    /// or a file: .npy, (k,), with rows of the matrix; or points of the grid in a table, an .npy array or
    /// GeoJSON, as for --source-points of `geosweep distance`. Start values are added to a point's distances
    #[arg(long, value_name = "A..B|FILE", help_heading = "Matrix")]
    sources: Option<RowsOf>,
    /// Compute only the rows of k points that are far from one another, (k, n). The first is the point next
    /// to the middle of the grid. Each further one is the farthest from all before it, as in
    /// `geosweep sample`
    #[arg(long, value_name = "K", conflicts_with = "sources", help_heading = "Matrix")]
    #[arg(value_parser = whole("samples", 1..=usize::MAX))]
    sample: Option<usize>,
    /// With --sample, write the nearest sample of each point: .npy int32 (M, N), counted from 0, with -1 at
    /// holes and where no sample reaches
    #[arg(long, value_name = "LABELS.npy", requires = "sample", help_heading = "Matrix")]
    labels: Option<PathBuf>,
    /// Write no distance above this one, in the unit of the surface. In whole rows it is +infinity. With
    /// --format csr only the distances within the radius are computed and stored
    #[arg(long, value_name = "R", allow_hyphen_values = true, help_heading = "Matrix")]
    radius: Option<f64>,
    /// Form of the matrix
    #[arg(long, value_enum, default_value_t, help_heading = "Matrix")]
    format: MatrixForm,
    /// Type of the numbers
    #[arg(long, default_value = "float32", value_parser = one_of(&NUMBERS))]
    #[arg(help_heading = "Matrix")]
    numbers: Element,
    /// Write only the entries above the diagonal, row by row: (n (n - 1) / 2,), as in SciPy's squareform
    #[arg(long, conflicts_with_all = ["sources", "sample"], help_heading = "Matrix")]
    upper: bool,
    /// Replace the two distances between each pair of points by their mean. Needs disk space for another
    /// whole float32 matrix
    #[arg(long, conflicts_with_all = ["sources", "sample"], help_heading = "Matrix")]
    symmetrize: bool,
    /// Start rows from the distances to points of earlier rows (eq. 20 of the paper), and do not compute
    /// these again. Keeps the matrix in memory. Only for the planar and the circular wavefront on the CPU
    #[arg(long, conflicts_with_all = ["sources", "sample", "resume"])]
    #[arg(help_heading = "Solver")]
    from_symmetry: bool,
    #[command(flatten)]
    solver: SolverArgs,
    /// Continue from D.npy.part, which an interrupted command has left. The result is the same to the byte as
    /// without the interruption. If there is no such file, start from the first row
    #[arg(long, requires = "output")]
    resume: bool,
    /// Print one JSON object; docs/json.md and docs/geosweep.schema.json describe it
    #[arg(long, help_heading = "Reports")]
    json: bool,
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, clap::ValueEnum)]
enum MatrixForm {
    /// Whole rows, an .npy array
    #[default]
    Npy,
    /// The distances within --radius, the diagonal included, in an .npz archive for SciPy's load_npz
    Csr,
}

const NUMBERS: [(Element, &str); 2] = [
    (Element::Float32, "The numbers as the solvers compute them"),
    (
        Element::Float16,
        "Half the space: a relative error of up to 5e-4, and no distance above 65504",
    ),
];

fn examples() -> String {
    format!(
        "\
Each row is written when it is finished, so that the matrix may be larger than memory. Its
file is D.npy.part until it is complete. The curved wavefront is the most accurate. The
circular wavefront computes sixteen maps at once, many times faster, and is about as accurate
on surfaces with little curvature. The distances between two points in either direction
are computed separately and differ by the solver's error; --symmetrize takes their mean.

{}

Examples:
  geosweep pairwise face.npy -o distances.npy --wavefront circular
  geosweep pairwise dem.tif -o rows.npy --sources 4096..8192 --resume
  geosweep pairwise scan.npy -o rows.npy --sample 200 --labels regions.npy
  geosweep pairwise dem.tif -o near.npz --radius 500 --format csr
  geosweep pairwise builtin:torus:64x64 -o d.npy --upper --numbers float16 --symmetrize --json",
        builtin_names()
    )
}

/// Whether the user has interrupted the program.
static INTERRUPTED: AtomicBool = AtomicBool::new(false);

fn is_interrupted() -> bool {
    INTERRUPTED.load(Ordering::SeqCst)
}

/// The reason why no more rows are computed.
#[derive(Debug, thiserror::Error)]
enum Stopped {
    #[error(transparent)]
    Solver(#[from] geosweep::Error),
    #[error(transparent)]
    Output(#[from] IoError),
    #[error("interrupted")]
    Interrupted,
}

pub fn run(args: &Args) -> Outcome {
    if args.format == MatrixForm::Csr {
        return run_sparse(args);
    }
    let Outputs { matrix, labels } = Outputs::new(args)?;
    let scene = args.surface.read()?;
    let surface = &scene.surface;
    let samples = args.sample.map(|count| Samples::new(&scene, count)).transpose()?;
    let (sources, starts) = match &samples {
        Some(samples) => (samples.points.clone(), vec![0.0; samples.points.len()]),
        None => args.sources(&scene)?,
    };
    let options = args.options()?;
    let mut pairwise = Pairwise::new(surface, &options)?;
    let points = pairwise.points();
    let kept = scene.given_points();
    let layout = MatrixLayout {
        rows: sources.len(),
        cols: scene.chart().points(),
        element: args.numbers,
        upper: args.upper,
        symmetric: args.symmetrize,
    };
    let held = if args.from_symmetry { points * points * size_of::<f32>() } else { 0 };
    let memory_bytes = held + pairwise.bytes();
    let disk_bytes = matrix.as_ref().map_or(0, |_| layout.bytes());
    note!("{}", needs(layout, memory_bytes, disk_bytes));

    // A second interruption ends the program immediately, as it would without this handler.
    ctrlc::set_handler(|| {
        if INTERRUPTED.swap(true, Ordering::SeqCst) {
            std::process::exit(130);
        }
    })?;
    let begin = |output| {
        let made_from = args.provenance(surface, &sources, &starts)?;
        let file = if args.resume { MatrixFile::resume } else { MatrixFile::begin };
        Ok::<_, Box<dyn Error>>(file(output, layout, made_from)?)
    };
    let mut file = matrix.map(begin).transpose()?;
    let resumed_rows = file.as_ref().map_or(0, MatrixFile::rows);
    if resumed_rows > 0 {
        note!("continues after row {resumed_rows} of {}", layout.rows);
    }
    let bar = progress_of_rows(layout.rows, resumed_rows);
    let solved = if args.from_symmetry {
        by_symmetry(&mut pairwise, file.as_mut(), &bar)
    } else {
        row_by_row(
            &mut pairwise,
            file.as_mut(),
            (&sources[resumed_rows..], &starts[resumed_rows..]),
            kept.as_deref(),
            &bar,
        )
    };
    bar.finish_and_clear();
    let report = match solved {
        Ok(report) => report,
        Err(stopped) => return args.stopped(stopped, file, layout),
    };
    let mut written = Written::default();
    {
        let _spinner = Spinner::new(if args.symmetrize { "symmetrizing" } else { "writing" });
        let labels = samples.as_ref().zip(labels).map(|(samples, output)| {
            let regions = &samples.regions;
            stage_labels(output, &scene, regions, &numbers(regions))
        });
        let labels = labels.transpose()?;
        let finish = |file: MatrixFile| file.finish_while(|| !is_interrupted());
        if let Some((file, path)) = file.zip(args.output.as_ref()) {
            if let Some(unfinished) = finish(file)? {
                return args.stopped(Stopped::Interrupted, Some(unfinished), layout);
            }
            written.add(path);
        }
        if let Some(labels) = labels {
            written.add(labels.path());
            labels.commit()?;
        }
    }
    if !report.converged() {
        warn_of_no_convergence(&options, report.iterations, report.residual, report.tolerance);
    }
    let engine = engine_name(report.engine, report.device.as_deref());
    let how = convergence(report.iterations, report.converged());
    let time = seconds(report.solve_time);
    let shape = format!("{} rows of {} distances", layout.rows, layout.cols);
    done([engine, shape, format!("{how} in {time}")], &written);
    if args.json {
        let places = samples.as_ref().map(|samples| samples.places(&scene));
        let bytes = (memory_bytes, disk_bytes);
        let summary = Summary::new(&scene, &report, resumed_rows, bytes, places);
        print_json("pairwise", &summary)?;
    }
    Ok(ExitCode::SUCCESS)
}

/// Computes and writes the distances within a radius.
fn run_sparse(args: &Args) -> Outcome {
    let output = sparse::output(args)?;
    let scene = args.surface.read()?;
    let (sources, starts) = match args.sample {
        Some(count) => {
            let points = Samples::new(&scene, count)?.points;
            let starts = vec![0.0; points.len()];
            (points, starts)
        }
        None => args.sources(&scene)?,
    };
    sparse::run(args, &scene, (&sources, &starts), &args.options()?, output)
}

/// The files to write. They are checked before the computation starts.
struct Outputs {
    matrix: Option<OutputFile>,
    labels: Option<OutputFile>,
}

impl Outputs {
    fn new(args: &Args) -> Result<Self, Box<dyn Error>> {
        let matrix = wanted_file(args.output.as_ref(), "a matrix is", "npy")?;
        let labels = labels_output(args.labels.as_ref())?;
        let files = args.sources.iter().filter_map(RowsOf::file);
        let inputs = args.surface.inputs().chain(files).map(AsRef::as_ref);
        check_outputs(&matrix.iter().chain(&labels).collect::<Vec<_>>(), inputs)?;
        Ok(Self { matrix, labels })
    }
}

impl Args {
    fn options(&self) -> Result<geosweep::Options, String> {
        Ok(self.solver.options()?.with_radius(self.radius))
    }

    /// Returns the points of the rows on the surface's grid, and the start values of their distances.
    fn sources(&self, scene: &Scene) -> Result<(Vec<usize>, Vec<f64>), Box<dyn Error>> {
        let surface = &scene.surface;
        let Some(rows) = &self.sources else {
            let points = scene.given_points();
            let points = points.unwrap_or_else(|| (0..surface.chart().points()).collect());
            let starts = vec![0.0; points.len()];
            return Ok((points, starts));
        };
        let point = |(given, start)| Ok((scene.index(given)?, start));
        let points = rows.places(&scene.frame())?.into_iter().map(point);
        let points = points.collect::<Result<Vec<_>, String>>()?;
        let (sources, starts): (Vec<_>, Vec<_>) = points.into_iter().unzip();
        let holes = sources.iter().filter(|&&source| !surface.present()[source]).count();
        if holes > 0 && rows.file().is_some() {
            note!("{holes} of the sources are holes; their rows are +infinity");
        }
        Ok((sources, starts))
    }

    /// Handles a matrix that was not finished. The rows written so far are valid, whatever failed after them.
    /// A matrix computed in memory cannot be resumed.
    fn stopped(&self, stopped: Stopped, file: Option<MatrixFile>, layout: MatrixLayout) -> Outcome {
        let rows = file.as_ref().map_or(0, MatrixFile::rows);
        if self.from_symmetry {
            file.inspect(MatrixFile::discard);
            return Err(stopped.into());
        }
        let paused = file.map_or(Ok(()), MatrixFile::pause);
        match stopped {
            Stopped::Interrupted if rows > 0 => {
                paused?;
                let all = layout.rows;
                let what = format!("interrupted after {rows} of {all} rows");
                Err(format!("{what}; the same command with --resume continues").into())
            }
            stopped => Err(stopped.into()),
        }
    }

    /// Returns everything that determines the bytes of the matrix.
    fn provenance(
        &self,
        surface: &Surface,
        sources: &[usize],
        starts: &[f64],
    ) -> Result<Provenance, Box<dyn Error>> {
        let options = self.options()?;
        let wavefront = options.wavefront.map_or("auto", |wavefront| wavefront.name());
        let engine = match &options.engine {
            Engine::Auto | Engine::Cpu => "cpu".into(),
            Engine::FastMarching => "fast-marching".into(),
            Engine::Vulkan(DeviceChoice::Any) => "vulkan".into(),
            Engine::Vulkan(DeviceChoice::Gpu) => "vulkan on a GPU".into(),
            Engine::Vulkan(DeviceChoice::Name(name)) => format!("vulkan on {name}"),
            Engine::Vulkan(DeviceChoice::Index(index)) => format!("vulkan on device {index}"),
        };
        let sources = match sources {
            [first, .., last] if sources.is_sorted() && last - first + 1 == sources.len() => {
                format!("{first}..{}", last + 1)
            }
            _ => format!("{sources:?}"),
        };
        let starts = match starts.iter().all(|&start| start == 0.0) {
            true => "0".into(),
            false => format!("{starts:?}"),
        };
        Ok(Provenance::new()
            .with("surface", surface_checksum(surface)?)
            .with("sources", sources)
            .with("start values", starts)
            .with("wavefront", wavefront)
            .with("engine", engine)
            .with("tolerance", options.tolerance.unwrap_or(DEFAULT_TOLERANCE))
            .with("iterations", options.iterations.map_or("default".into(), |n| n.to_string()))
            .with("radius", options.radius.map_or("none".into(), |radius| radius.to_string()))
            .with("from symmetry", self.from_symmetry))
    }
}

/// Given points that are far from one another, and the Voronoi region of each.
struct Samples {
    points: Vec<usize>,
    regions: Voronoi,
}

impl Samples {
    fn new(scene: &Scene, count: usize) -> Result<Self, Box<dyn Error>> {
        let surface = &scene.surface;
        let (chart, edges) = (surface.chart(), EdgeLengths::new(surface)?);
        let is_given = scene.is_given();
        let first = middle(surface, is_given.as_deref());
        let (map, samples) = farthest_points(surface, &edges, first, is_given.as_deref(), count)?;
        let regions = Voronoi::new(surface, &edges, map.sources(), &map.distances())?;
        let index = |sample: &Sample| chart.index(sample.row as usize, sample.col as usize);
        Ok(Self { points: samples.iter().map(index).collect(), regions })
    }

    /// Returns the rows and columns of the samples on the given grid.
    fn places(&self, scene: &Scene) -> Vec<(usize, usize)> {
        let place = |&point: &usize| {
            let (row, col) = scene.surface.chart().position(point);
            let [row, col] = scene.given([row as f64, col as f64]);
            (row.round() as usize, col.round() as usize)
        };
        self.points.iter().map(place).collect()
    }
}

/// Computes rows and writes their distances to the points `kept`, or to all points.
fn row_by_row(
    pairwise: &mut Pairwise,
    mut file: Option<&mut MatrixFile>,
    (sources, starts): (&[usize], &[f64]),
    kept: Option<&[usize]>,
    bar: &ProgressBar,
) -> Result<PairwiseReport, Stopped> {
    let points = pairwise.points();
    let has_starts = starts.iter().any(|&start| start != 0.0);
    let mut starts = starts.iter();
    pairwise.rows(sources, |rows: Rows| {
        if let Some(file) = &mut file {
            let distances: Cow<[f32]> = match has_starts {
                true => started(&rows, &mut starts).into(),
                false => rows.distances.into(),
            };
            file.append(&cropped(distances, points, kept))?;
        }
        bar.inc(rows.sources.len() as u64);
        go_on()
    })
}

/// Returns rows of distances to the points `kept`, from rows of distances to all points.
fn cropped<'a>(distances: Cow<'a, [f32]>, points: usize, kept: Option<&[usize]>) -> Cow<'a, [f32]> {
    let Some(kept) = kept else { return distances };
    let rows = distances.chunks_exact(points);
    rows.flat_map(|row| kept.iter().map(|&point| row[point])).collect::<Vec<_>>().into()
}

/// Returns rows with the start value of each added to its distances.
fn started<'a>(rows: &Rows, starts: &mut impl Iterator<Item = &'a f64>) -> Vec<f32> {
    let row = |((_, distances), start): ((usize, &[f32]), &f64)| {
        let later = |distance: &f32| (f64::from(*distance) + start) as f32;
        distances.iter().map(later).collect::<Vec<_>>()
    };
    rows.iter().zip(starts).flat_map(row).collect()
}

fn go_on() -> Result<(), Stopped> {
    if is_interrupted() { Err(Stopped::Interrupted) } else { Ok(()) }
}

/// Computes the matrix in memory, and writes it. Glued surfaces are refused, so all points of the surface are
/// points of the given grid.
fn by_symmetry(
    pairwise: &mut Pairwise,
    file: Option<&mut MatrixFile>,
    bar: &ProgressBar,
) -> Result<PairwiseReport, Stopped> {
    let (matrix, report) = pairwise.matrix_by_symmetry(|rows| {
        bar.inc(rows as u64);
        go_on()
    })?;
    if let Some(file) = file {
        file.append(&matrix)?;
    }
    Ok(report)
}

/// Describes the disk space and memory that the matrix will take.
fn needs(layout: MatrixLayout, memory: usize, disk: u64) -> String {
    let sizes: Vec<_> = layout.shape().iter().map(usize::to_string).collect();
    let mib = |bytes: u64| bytes.div_ceil(1 << 20);
    format!(
        "{} distances of {}: {} MiB on disk, {} MiB of memory",
        sizes.join(" x "),
        layout.element.name(),
        mib(disk),
        mib(memory as u64)
    )
}

#[derive(Serialize)]
struct Summary<'a> {
    precision: Precision,
    rows: usize,
    cols: usize,
    points: usize,
    matrix_rows: usize,
    matrix_cols: usize,
    engine: &'static str,
    device: Option<&'a str>,
    wavefront: &'static str,
    iterations: u32,
    converged: bool,
    residual: f64,
    solve_seconds: f64,
    distances_per_second: f64,
    resumed_rows: usize,
    memory_bytes: usize,
    disk_bytes: u64,
    samples: Option<Vec<(usize, usize)>>,
    stored: Option<usize>,
}

impl<'a> Summary<'a> {
    fn new(
        scene: &Scene,
        report: &'a PairwiseReport,
        resumed_rows: usize,
        (memory_bytes, disk_bytes): (usize, u64),
        samples: Option<Vec<(usize, usize)>>,
    ) -> Self {
        Self {
            precision: Precision::Single,
            rows: scene.chart().rows,
            cols: scene.chart().cols,
            points: scene.points(),
            matrix_rows: resumed_rows + report.rows,
            matrix_cols: scene.chart().points(),
            engine: report.engine.name(),
            device: report.device.as_deref(),
            wavefront: report.wavefront.name(),
            iterations: report.iterations,
            converged: report.converged(),
            residual: report.residual,
            solve_seconds: report.solve_time.as_secs_f64(),
            distances_per_second: report.distances_per_second(),
            resumed_rows,
            memory_bytes,
            disk_bytes,
            samples,
            stored: None,
        }
    }

    /// Returns the summary of a sparse matrix with this number of stored distances.
    fn with_stored(self, stored: usize) -> Self {
        let distances_per_second = stored as f64 / self.solve_seconds;
        Self { stored: Some(stored), distances_per_second, ..self }
    }
}

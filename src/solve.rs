//! One call from surface and sources to distance map.

use std::time::{Duration, Instant};

use rayon::prelude::*;

use crate::Stop;
use crate::auto::Choice;
use crate::cpu::{self, Connections};
use crate::name::{UnknownName, by_name};
use crate::surface::{EdgeLengths, Real, Seed, Sources, Surface};
use crate::update::{EngineKind, Setting, SourceKind, Wavefront};
use crate::vulkan::{self, DeviceChoice, Schedule, VulkanError};
use crate::{DistanceMap, Error, Report};

/// Which engine computes a map.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum Engine {
    /// The CPU, but a GPU for large grids, where there is one and its set-up should pay: from 2^22 points on, a
    /// threshold that is reckoned, not measured. The report says which, and why. A Vulkan device that is a CPU is used only where it is asked for. With a
    /// [`Options::schedule`] only Vulkan will do. A program that keeps a [`vulkan::Solver`] sets up once,
    /// and may gain on smaller grids.
    #[default]
    Auto,
    /// A Vulkan device, or an error.
    Vulkan(DeviceChoice),
    /// Rotated raster scans on the CPU.
    Cpu,
    /// Fast marching on the CPU, the sequential reference for the planar front, with obtuse triangles
    /// split. With the other fronts it can err by several per cent where triangles are obtuse: it
    /// fixes points once, and where they are split a front's curvature is that of the air between.
    FastMarching,
}

impl Engine {
    /// What is left to be chosen, as it was for the map of this report.
    pub(crate) fn as_for(&self, report: &Report) -> Self {
        match (self, report.engine) {
            (Self::Auto, "cpu") => Self::Cpu,
            (Self::Auto, _) => Self::Vulkan(DeviceChoice::Any),
            _ => self.clone(),
        }
    }

    /// The name used by the tool, whichever device.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Auto => "auto",
            Self::Vulkan(_) => "vulkan",
            Self::Cpu => "cpu",
            Self::FastMarching => "fast-marching",
        }
    }
}

impl std::fmt::Display for Engine {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.name())
    }
}

/// By its [`name`](Engine::name); `vulkan` is any device.
impl std::str::FromStr for Engine {
    type Err = UnknownName;

    fn from_str(text: &str) -> Result<Self, UnknownName> {
        let all = [Self::Auto, Self::Vulkan(DeviceChoice::Any), Self::Cpu, Self::FastMarching];
        by_name("engine", text, &all.each_ref(), |engine| engine.name()).cloned()
    }
}

/// Default of [`Options::tolerance`]: near the rounding of single precision.
pub const DEFAULT_TOLERANCE: f64 = 1e-6;
/// The same for [`distance_map_f64`]: near the rounding of double precision.
pub const DEFAULT_TOLERANCE_F64: f64 = 1e-13;

/// How to compute a map. The default suits most surfaces.
#[derive(Clone, Debug, PartialEq)]
pub struct Options {
    /// Which engine.
    pub engine: Engine,
    /// The front assumed inside a triangle. By default curved, over a slowness too: the most accurate
    /// on smooth surfaces and from curves, and as good as the circular one on rough terrain. But
    /// [`Wavefront::Anchored`], which is exact, over floor plans ([`Surface::is_floor_plan`]) from
    /// points; and planar on surfaces that turn at random, on those whose slowness jumps all over
    /// them, and for fast marching. A curved map takes about twice the time of a circular one, one
    /// with anchors less.
    pub wavefront: Option<Wavefront>,
    /// The order of updates on a Vulkan device, which makes no difference to the map; by default
    /// [`Schedule::best_on`] the device. The CPU's engines have one order each.
    pub schedule: Option<Schedule>,
    /// Stop when no arrival time falls by more than this fraction in an iteration; by default
    /// [`DEFAULT_TOLERANCE`], in double precision [`DEFAULT_TOLERANCE_F64`].
    pub tolerance: Option<f64>,
    /// Stop after this many iterations of four scans; by default after more than any surface
    /// but a labyrinth needs (ten for each row and column).
    pub iterations: Option<u32>,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            engine: Engine::Auto,
            wavefront: None,
            schedule: None,
            tolerance: None,
            iterations: None,
        }
    }
}

impl Options {
    pub(crate) fn stop<R: Precision>(&self, surface: &Surface) -> Result<Stop, Error> {
        let tolerance = self.tolerance.unwrap_or(R::TOLERANCE);
        if !(0.0..1.0).contains(&tolerance) {
            let message = format!("tolerance {tolerance} is not in the range from 0 to 1");
            return Err(Error::Options(message));
        }
        let enough = 10 * (surface.rows() + surface.cols());
        let iterations = self.iterations.unwrap_or(u32::try_from(enough).unwrap_or(u32::MAX));
        if iterations == 0 {
            return Err(Error::Options("at least one iteration is needed".into()));
        }
        Ok(Stop { tolerance, iterations })
    }

    /// The wavefront of a map.
    pub(crate) fn wavefront(
        &self,
        surface: &Surface,
        sources: &Sources,
    ) -> Result<Wavefront, Error> {
        self.wavefront_of(surface, SourceKind::of(sources))
    }

    /// The wavefront of a map, from sources of which the kind is known.
    pub(crate) fn wavefront_of(
        &self,
        surface: &Surface,
        sources: SourceKind,
    ) -> Result<Wavefront, Error> {
        let engine = match self.engine {
            Engine::FastMarching => EngineKind::FastMarching,
            Engine::Auto | Engine::Vulkan(_) | Engine::Cpu => EngineKind::Map,
        };
        let setting = Setting::new(surface, sources, engine);
        Ok(Wavefront::resolve(self.wavefront, setting)?)
    }

    /// The wavefront of the rows of a distance matrix.
    pub(crate) fn wavefront_of_rows(&self, surface: &Surface) -> Result<Wavefront, Error> {
        let engine = match self.engine {
            Engine::FastMarching => EngineKind::FastMarching,
            Engine::Auto | Engine::Cpu => EngineKind::Matrix,
            Engine::Vulkan(_) => EngineKind::MatrixOnDevice,
        };
        let setting = Setting::new(surface, SourceKind::POINT, engine);
        Ok(Wavefront::resolve(self.wavefront, setting)?)
    }
}

/// Computes the geodesic distance from the sources to every point of a surface.
///
/// # Errors
/// If a source lies off the surface, an option is out of range, an edge of the surface is too
/// long or too short for single precision, or the engine asked for cannot run.
/// [`Engine::Auto`] falls back to the CPU where the GPU that it chose fails, and says why in the report.
pub fn distance_map(
    surface: &Surface,
    sources: &Sources,
    options: &Options,
) -> Result<DistanceMap, Error> {
    in_precision(surface, sources, options)
}

/// Computes the same distances in double precision, on the CPU, in two to four times the time and twice
/// the memory: for errors below the rounding of single precision, which is 1e-7 of a distance over some
/// hundred edges and up to some 1e-6 over a thousand.
///
/// ```
/// use geosweep::surface::builtin::Builtin;
/// use geosweep::{Options, Sources, distance_map_f64};
///
/// let surface = Builtin::Plane.surface(100, 100)?;
/// let map = distance_map_f64(&surface, &Sources::point(30.0, 40.0), &Options::default())?;
/// let exact = Builtin::Plane.exact_distance(100, 100, [30.0, 40.0], [99.0, 99.0]).unwrap();
/// assert!((map.distance(99, 99) - exact).abs() < 1e-14 * exact);
/// # Ok::<(), geosweep::Error>(())
/// ```
///
/// # Errors
/// As [`distance_map`]; and if a Vulkan device or a schedule is asked for, since shaders compute in
/// single precision. [`Engine::Auto`] is the CPU.
pub fn distance_map_f64(
    surface: &Surface,
    sources: &Sources,
    options: &Options,
) -> Result<DistanceMap<f64>, Error> {
    in_precision(surface, sources, options)
}

/// One of both.
pub(crate) fn in_precision<R: Precision>(
    surface: &Surface,
    sources: &Sources,
    options: &Options,
) -> Result<DistanceMap<R>, Error> {
    R::solve(&Problem::new::<R>(surface, sources, options)?, &options.engine)
}

/// A precision in which maps are computed.
pub(crate) trait Precision: Real {
    /// Default of [`Options::tolerance`].
    const TOLERANCE: f64;

    fn solve(problem: &Problem, engine: &Engine) -> Result<DistanceMap<Self>, Error>;
}

impl Precision for f32 {
    const TOLERANCE: f64 = DEFAULT_TOLERANCE;

    fn solve(problem: &Problem, engine: &Engine) -> Result<DistanceMap, Error> {
        match engine {
            Engine::Cpu | Engine::FastMarching if problem.schedule.is_some() => {
                Err(Error::Options("a schedule is for a Vulkan device, not for the CPU".into()))
            }
            Engine::Auto if problem.schedule.is_some() => {
                Ok(problem.solve_on_vulkan(&DeviceChoice::Any)?)
            }
            Engine::Cpu => problem.solve_on_cpu(),
            Engine::FastMarching => problem.solve_by_fast_marching(),
            Engine::Vulkan(choice) => Ok(problem.solve_on_vulkan(choice)?),
            Engine::Auto => problem.solve_on_the_best(),
        }
    }
}

impl Precision for f64 {
    const TOLERANCE: f64 = DEFAULT_TOLERANCE_F64;

    fn solve(problem: &Problem, engine: &Engine) -> Result<DistanceMap<f64>, Error> {
        match engine {
            _ if problem.schedule.is_some() => Err(only_single("a schedule")),
            Engine::Vulkan(_) => Err(only_single("a Vulkan device")),
            Engine::Auto => {
                let reason = "only the CPU computes in double precision".into();
                Ok(problem.solve_on_cpu()?.because(reason))
            }
            Engine::Cpu => problem.solve_on_cpu(),
            Engine::FastMarching => problem.solve_by_fast_marching(),
        }
    }
}

fn only_single(what: &str) -> Error {
    Error::Options(format!(
        "{what} is for single precision, in which shaders compute; leave it out, and the CPU computes \
         in double precision"
    ))
}

/// Numbers that a map takes at most for each point, its edges and result included: in single
/// precision 40 bytes (`tests/memory/resident.rs`), and the result.
const NUMBERS_OF_POINT: usize = 11;

/// An error if the memory for a map cannot be had. The engines end the process where that happens to
/// them.
fn check_memory<R: Real>(surface: &Surface) -> Result<(), Error> {
    let points = surface.chart().points();
    let bytes = points.saturating_mul(NUMBERS_OF_POINT * size_of::<R>());
    let mut room = Vec::<u8>::new();
    let there = room.try_reserve_exact(bytes);
    // Else compilers leave out what nothing uses.
    std::hint::black_box(&room);
    there.map_err(|_| Error::MapMemory { points, bytes })
}

/// A checked problem, ready for any engine.
pub(crate) struct Problem<'a> {
    surface: &'a Surface,
    /// Initial values less the smallest, so that a single source starts at zero, where the
    /// circular front is exact.
    seeds: Vec<Seed>,
    start: f64,
    wavefront: Wavefront,
    schedule: Option<Schedule>,
    stop: Stop,
}

impl<'a> Problem<'a> {
    fn new<R: Precision>(
        surface: &'a Surface,
        sources: &Sources,
        options: &Options,
    ) -> Result<Self, Error> {
        let seeds = sources.seeds_with_origins(surface)?;
        Self::from_seeds::<R>(surface, seeds, sources, options)
    }

    /// Starts from seeds that stand for the sources.
    pub(crate) fn from_seeds<R: Precision>(
        surface: &'a Surface,
        mut seeds: Vec<Seed>,
        sources: &Sources,
        options: &Options,
    ) -> Result<Self, Error> {
        let wavefront = options.wavefront(surface, sources)?;
        let stop = options.stop::<R>(surface)?;
        check_memory::<R>(surface)?;
        let start = sources.start();
        for seed in &mut seeds {
            seed.time -= start;
            seed.origin = seed.origin.map(|origin| origin.started_earlier(start));
        }
        let seeds = wavefront.seeds(surface, seeds);
        Ok(Self { surface, seeds, start, wavefront, schedule: options.schedule, stop })
    }

    fn solve_on_the_best(&self) -> Result<DistanceMap, Error> {
        let reason = match Choice::of(self.surface.chart()) {
            Choice::Cpu(reason) => return Ok(self.solve_on_cpu()?.because(reason)),
            Choice::Gpu(reason) => reason,
        };
        use VulkanError::{NoDevice, NoLoader, NoUsableDevice, Surface};
        match self.solve_on_vulkan(&DeviceChoice::Gpu) {
            Ok(map) => Ok(map.because(reason)),
            Err(Surface(error)) => Err(error.into()),
            Err(error @ (NoLoader(_) | NoDevice | NoUsableDevice(_))) => {
                Ok(self.solve_on_cpu()?.because(format!("there is no GPU: {error}")))
            }
            Err(error) => {
                let mut map = self.solve_on_cpu()?.because(reason);
                map.report.fallback = Some(error.to_string());
                Ok(map)
            }
        }
    }

    fn solve_on_cpu<R: Real>(&self) -> Result<DistanceMap<R>, Error> {
        let edges = EdgeLengths::<R>::new(self.surface)?;
        let start = Instant::now();
        let solution = cpu::rotated_scan(&edges, &self.seeds, self.wavefront, self.stop);
        let time = start.elapsed();
        let report = Report {
            engine: "cpu",
            iterations: solution.iterations,
            residual: solution.residual,
            ..self.report("rotated-scan", time)
        };
        Ok(self.finish(solution.distances(), report))
    }

    fn solve_by_fast_marching<R: Real>(&self) -> Result<DistanceMap<R>, Error> {
        let edges = EdgeLengths::<R>::new(self.surface)?;
        let split = Connections::split(self.surface)?;
        let start = Instant::now();
        let solution = cpu::fast_marching_with(&edges, &split, &self.seeds, self.wavefront);
        let time = start.elapsed();
        let report = Report { engine: "fast-marching", ..self.report("heap", time) };
        Ok(self.finish(solution.distances(), report))
    }

    fn solve_on_vulkan(&self, choice: &DeviceChoice) -> Result<DistanceMap, VulkanError> {
        let mut solver = vulkan::Solver::new(choice)?;
        let mut surface = solver.upload(self.surface)?;
        let method =
            vulkan::Method { wavefront: self.wavefront, schedule: self.schedule, stop: self.stop };
        let solution = solver.solve(&mut surface, &self.seeds, method)?;
        let report = Report {
            engine: "vulkan",
            device: Some(solver.device_name().to_owned()),
            iterations: solution.iterations,
            residual: solution.residual,
            ..self.report(solution.schedule.name(), solution.time)
        };
        Ok(self.finish(solution.distances, report))
    }

    fn report(&self, schedule: &'static str, solve_time: Duration) -> Report {
        Report {
            engine: "",
            device: None,
            reason: None,
            fallback: None,
            schedule,
            wavefront: self.wavefront,
            iterations: 1,
            residual: 0.0,
            tolerance: self.stop.tolerance,
            converged: false,
            solve_time,
            points: self.surface.points(),
            reached: 0,
            max_distance: 0.0,
            seams: self.surface.seams(),
            resolution: self.surface.resolution(),
        }
    }

    /// Adds the initial value that was taken away, and counts.
    fn finish<R: Real>(&self, mut distances: Vec<R>, report: Report) -> DistanceMap<R> {
        let of_row = |row: &mut [R]| {
            let (mut reached, mut largest) = (0, R::neg_infinity());
            for distance in row.iter_mut().filter(|distance| distance.is_finite()) {
                *distance = *distance + R::of(self.start);
                reached += 1;
                largest = largest.max(*distance);
            }
            (reached, largest)
        };
        let (reached, max_distance) = distances
            .par_chunks_mut(self.surface.cols())
            .map(of_row)
            .reduce(|| (0, R::neg_infinity()), |a, b| (a.0 + b.0, a.1.max(b.1)));
        let max_distance = max_distance.wide();
        let converged = report.residual <= self.stop.tolerance;
        DistanceMap {
            chart: self.surface.chart(),
            distances,
            report: Report { converged, reached, max_distance, ..report },
        }
    }
}

impl<R> DistanceMap<R> {
    /// The same map, with why its engine was chosen.
    fn because(mut self, reason: String) -> Self {
        self.report.reason = Some(reason);
        self
    }
}

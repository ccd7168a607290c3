//! Computes a distance map from a surface and its sources in one call.

use std::time::{Duration, Instant};

use rayon::prelude::*;

use crate::Stop;
use crate::cpu::{
    Order, RotatedScan, StraightFronts, needed_straight_fronts, seeds_for, straight_parts,
};
use crate::map_solver::{MapSolver, Waiting};
use crate::options::Options;
use crate::surface::{EdgeLengths, Groups, Origin, Real, Seed, SolverGrid, Sources, Surface, min};
use crate::update::Wavefront;
#[cfg(feature = "vulkan")]
use crate::vulkan::{DeviceChoice, Schedule};
use crate::{
    DEFAULT_TOLERANCE, DEFAULT_TOLERANCE_F64, DistanceMap, Engine, Error, Monitor, Report, Targets,
    UsedEngine,
};

/// Computes the geodesic distance from the sources to every point of a surface.
///
/// # Errors
/// If a source lies off the surface, an option is out of range, a target lies in a hole, an edge of the
/// surface is too long or too short for single precision, or the requested engine cannot run.
/// [`Engine::Auto`] falls back to the CPU if the GPU that it chose fails, and the report says why.
pub fn distance_map(
    surface: &Surface,
    sources: &Sources,
    options: &Options,
) -> Result<DistanceMap, Error> {
    in_precision(surface, sources, options, None)
}

/// Computes the geodesic distance from the sources to every point of a surface in double precision, on the
/// CPU.
///
/// This takes two to four times the time of single precision and twice the memory. It serves where errors
/// must be below the rounding of single precision, which is 1e-7 of a distance over some hundred edges and up
/// to about 1e-6 over a thousand.
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
/// The errors of [`distance_map`]. It is also an error to request a Vulkan device or a schedule, since
/// shaders compute in single precision. [`Engine::Auto`] is the CPU.
pub fn distance_map_f64(
    surface: &Surface,
    sources: &Sources,
    options: &Options,
) -> Result<DistanceMap<f64>, Error> {
    in_precision(surface, sources, options, None)
}

/// Computes a map in single or double precision, with what `solver` keeps of earlier maps.
pub(crate) fn in_precision<R: Precision>(
    surface: &Surface,
    sources: &Sources,
    options: &Options,
    solver: Option<&MapSolver>,
) -> Result<DistanceMap<R>, Error> {
    let seeds = sources.seeds_with_origins(surface)?;
    let wavefront = match solver {
        Some(solver) => solver.wavefront(sources, options)?,
        None => options.resolve_wavefront(surface, sources)?,
    };
    let parts = sources.iter().map(|source| straight_parts(surface, source)).collect();
    let problem = Problem::in_wavefront::<R>(surface, (seeds, parts), sources, options, wavefront)?;
    R::solve(&Problem { solver, ..problem }, &options.engine)
}

/// A precision in which maps are computed.
pub(crate) trait Precision: Real {
    /// Default of [`Options::tolerance`].
    const TOLERANCE: f64;

    /// Returns the solvers in this precision that wait for a map.
    fn waiting(solver: &MapSolver) -> &Waiting<Self>;

    fn solve(problem: &Problem, engine: &Engine) -> Result<DistanceMap<Self>, Error>;
}

impl Precision for f32 {
    const TOLERANCE: f64 = DEFAULT_TOLERANCE;

    fn waiting(solver: &MapSolver) -> &Waiting<Self> {
        solver.single()
    }

    fn solve(problem: &Problem, engine: &Engine) -> Result<DistanceMap, Error> {
        match engine {
            #[cfg(feature = "vulkan")]
            Engine::Cpu | Engine::FastMarching if problem.schedule.is_some() => {
                Err(Error::Options("a schedule is for a Vulkan device, not for the CPU".into()))
            }
            #[cfg(feature = "vulkan")]
            Engine::Auto if problem.schedule.is_some() => {
                problem.finished(problem.solve_on_vulkan(&DeviceChoice::Any)?)
            }
            Engine::Cpu => problem.solve_on_cpu(),
            Engine::FastMarching => problem.solve_in_order_of_time(),
            #[cfg(feature = "vulkan")]
            Engine::Vulkan(choice) => problem.finished(problem.solve_on_vulkan(choice)?),
            #[cfg(feature = "vulkan")]
            Engine::Auto => problem.solve_on_the_best(),
            #[cfg(not(feature = "vulkan"))]
            Engine::Auto => problem.solve_on_cpu(),
        }
    }
}

impl Precision for f64 {
    const TOLERANCE: f64 = DEFAULT_TOLERANCE_F64;

    fn waiting(solver: &MapSolver) -> &Waiting<Self> {
        solver.double()
    }

    fn solve(problem: &Problem, engine: &Engine) -> Result<DistanceMap<f64>, Error> {
        match engine {
            #[cfg(feature = "vulkan")]
            _ if problem.schedule.is_some() => Err(only_single("a schedule")),
            #[cfg(feature = "vulkan")]
            Engine::Vulkan(_) => Err(only_single("a Vulkan device")),
            Engine::Auto => {
                let reason = "only the CPU computes in double precision".into();
                Ok(problem.solve_on_cpu()?.because(reason))
            }
            Engine::Cpu => problem.solve_on_cpu(),
            Engine::FastMarching => problem.solve_in_order_of_time(),
        }
    }
}

#[cfg(feature = "vulkan")]
fn only_single(what: &str) -> Error {
    Error::Options(format!(
        "{what} is for single precision, in which shaders compute; leave it out, and the CPU computes \
         in double precision"
    ))
}

/// Returns the peak number of values per grid point in memory, including edges and result. In single precision these
/// are 40 bytes (`tests/memory/resident.rs`) and the 4 bytes of the result. Fronts that carry their ray take another 8
/// bytes, and the fans of points 20. Over an uneven slowness, fronts, slowness and curvature have values of their own,
/// and points in the order of time another four lengths, the times of final fronts and their places in the queue.
fn numbers_of_point(surface: &Surface, wavefront: Wavefront) -> usize {
    match wavefront {
        Wavefront::Rays => 18,
        _ if surface.is_slowed_unevenly() => 17,
        _ => 11,
    }
}

/// Returns an error if the memory for a map is not available. The engines themselves would end the process in
/// that case.
fn check_memory<R: Real>(surface: &Surface, wavefront: Wavefront) -> Result<(), Error> {
    let points = surface.chart().points();
    let bytes = points.saturating_mul(numbers_of_point(surface, wavefront) * size_of::<R>());
    let mut room = Vec::<u8>::new();
    let there = room.try_reserve_exact(bytes);
    // Without this, compilers remove the allocation as unused.
    std::hint::black_box(&room);
    there.map_err(|_| Error::MapMemory { points, bytes })
}

/// A checked problem, ready for any engine.
pub(crate) struct Problem<'a> {
    pub surface: &'a Surface,
    pub grid: SolverGrid<'a>,
    /// The seeds at the corners of the sources' cells, with the smallest initial value subtracted. A single source then
    /// starts at zero, where the circular front is exact.
    pub seeds: Vec<Seed>,
    /// The fronts along straight lines, where these tell the fronts of several sources apart.
    pub straight: Option<StraightFronts>,
    pub start: f64,
    pub wavefront: Wavefront,
    #[cfg(feature = "vulkan")]
    pub schedule: Option<Schedule>,
    pub stop: Stop,
    pub radius: f64,
    /// The targets on the solver's grid.
    pub targets: Option<Targets>,
    pub monitor: Monitor,
    /// The solvers that are kept from one map of the surface to the next.
    pub solver: Option<&'a MapSolver>,
}

/// Margin by which fronts go beyond the radius, as a fraction of the radius, so that rounding leaves out no point
/// within the radius.
const BEYOND: f64 = 1e-6;

impl<'a> Problem<'a> {
    /// Makes a problem from `seeds` that stand for the sources.
    pub(crate) fn from_seeds<R: Precision>(
        surface: &'a Surface,
        seeds: Vec<Seed>,
        sources: &Sources,
        options: &Options,
    ) -> Result<Self, Error> {
        let wavefront = options.resolve_wavefront(surface, sources)?;
        Self::in_wavefront::<R>(surface, (seeds, Vec::new()), sources, options, wavefront)
    }

    /// Makes a problem from seeds, and the points and segments of each source where these are known.
    fn in_wavefront<R: Precision>(
        surface: &'a Surface,
        (mut seeds, mut parts): (Vec<Seed>, Vec<Vec<Origin>>),
        sources: &Sources,
        options: &Options,
        wavefront: Wavefront,
    ) -> Result<Self, Error> {
        let stop = options.stop(surface, R::TOLERANCE)?;
        let (radius, targets) = (options.checked_radius()?, options.checked_targets(surface)?);
        let monitor = options.monitor();
        monitor.check()?;
        check_memory::<R>(surface, wavefront)?;
        let start = sources.start();
        for seed in &mut seeds {
            seed.time -= start;
            seed.origin = seed.origin.map(|origin| origin.started_earlier(start));
        }
        parts.iter_mut().flatten().for_each(|part| *part = part.started_earlier(start));
        let straight = if wavefront.is_curved() && !parts.is_empty() {
            needed_straight_fronts(surface, &parts).filter(|fronts| !fronts.has_holes())
        } else {
            None
        };
        // Straight lines need no points beyond seams.
        let grid = if straight.is_some() { surface.own_grid() } else { surface.solver_grid() };
        let targets = targets.map(|targets| grid.targets(targets));
        Ok(Self {
            surface,
            grid,
            seeds,
            straight,
            start,
            wavefront,
            #[cfg(feature = "vulkan")]
            schedule: options.schedule,
            stop,
            radius,
            targets,
            monitor,
            solver: None,
        })
    }

    pub fn solve_on_cpu<R: Precision>(&self) -> Result<DistanceMap<R>, Error> {
        self.solve_in(None)
    }

    fn solve_in_order_of_time<R: Precision>(&self) -> Result<DistanceMap<R>, Error> {
        self.solve_in(Some(Order::Times))
    }

    /// Returns the seeds from which engines solve, on the solver's grid.
    pub fn solver_seeds(&self) -> Vec<Seed> {
        let seeds = match &self.straight {
            Some(fronts) => fronts.seeds(),
            None => seeds_for(self.wavefront, self.surface, self.seeds.clone()),
        };
        seeds.into_iter().map(|seed| self.grid.seed(seed)).collect()
    }

    /// Returns the map of fronts along straight lines, which needs no iterations.
    fn along_straight_lines<R: Precision>(
        &self,
        fronts: &StraightFronts,
    ) -> Result<DistanceMap<R>, Error> {
        let start = Instant::now();
        let distances = fronts.times();
        self.monitor.check()?;
        let report = self.report(UsedEngine::Cpu, "straight-lines", start.elapsed());
        Ok(self.finish(distances, report))
    }

    /// Solves on the CPU in a given order, or in the best one.
    fn solve_in<R: Precision>(&self, order: Option<Order>) -> Result<DistanceMap<R>, Error> {
        if let (Some(fronts), None) = (&self.straight, order) {
            return self.along_straight_lines(fronts);
        }
        let seeds = self.solver_seeds();
        let kept = self.solver.and_then(|all| all.take::<R>(self.wavefront, order));
        let (start, mut solver) = match kept {
            Some(solver) => (Instant::now(), solver),
            None => {
                let edges = EdgeLengths::<R>::measured(self.grid.surface(), || {
                    Ok::<_, Error>(self.monitor.check()?)
                })?;
                let solver = match order {
                    Some(order) => RotatedScan::in_order(&edges, self.wavefront, order),
                    None => RotatedScan::new(&edges, self.wavefront),
                };
                (Instant::now(), solver)
            }
        };
        solver = solver.with_monitor(self.monitor.clone());
        solver.set_radius(self.time_limit());
        let convergence = match &self.targets {
            Some(targets) => solver.solve_to(&seeds, targets, self.stop),
            None => solver.solve(&seeds, self.stop),
        };
        let schedule = if solver.is_in_order_of_time() { "order-of-time" } else { "rotated-scan" };
        self.monitor.check()?;
        let mut time = start.elapsed();
        let distances = match self.solver {
            None => {
                let solution = solver.into_solution(convergence);
                time = start.elapsed();
                solution.distances()
            }
            Some(all) => {
                let distances = solver.distances();
                all.keep(self.wavefront, order, solver);
                distances
            }
        };
        let engine = match order {
            Some(Order::Times) => UsedEngine::FastMarching,
            _ => UsedEngine::Cpu,
        };
        let mut report = self.report(engine, schedule, time);
        (report.iterations, report.residual) = (convergence.iterations, convergence.residual);
        Ok(self.finish(distances, report))
    }

    pub fn report(
        &self,
        engine: UsedEngine,
        schedule: &'static str,
        solve_time: Duration,
    ) -> Report {
        let mut report = Report::new(engine, self.wavefront);
        report.schedule = schedule;
        report.tolerance = self.stop.tolerance;
        report.solve_time = solve_time;
        report.points = self.surface.points();
        report.seams = match self.solver {
            Some(solver) => solver.seams().to_vec(),
            None => self.surface.seams(),
        };
        report.resolution = self.surface.resolution();
        report.unresolved = self.surface.unresolved();
        report
    }

    /// Returns the time after which fronts are ignored. Like the times of seeds, it is relative to the smallest initial
    /// value.
    pub fn time_limit(&self) -> f64 {
        self.radius * (1.0 + BEYOND) - self.start
    }

    /// Returns the distance beyond which points count as unreached. `distances` are relative to the smallest initial
    /// value.
    fn end<R: Real>(&self, distances: &[R]) -> f64 {
        let Some(targets) = &self.targets else { return self.radius };
        let chart = self.grid.surface().chart();
        let last = targets.last(|[row, col]| {
            let distance = distances[chart.index(row, col)];
            (distance + R::of(self.start)).wide()
        });
        self.radius.min(last)
    }

    /// Gives all copies of a point of a glued surface the smallest of their distances, which differ by rounding.
    fn agree_on_copies<R: Real>(&self, distances: &mut [R]) {
        for group in self.surface.copies().into_iter().flat_map(Groups::iter) {
            let of_copies = group.iter().map(|&copy| distances[copy as usize]);
            let smallest = of_copies.fold(R::infinity(), min);
            group.iter().for_each(|&copy| distances[copy as usize] = smallest);
        }
    }

    /// Adds the subtracted initial value to all distances, and counts the points that were reached. Points
    /// beyond the radius or the needed targets become unreached.
    pub fn finish<R: Real>(&self, distances: Vec<R>, mut report: Report) -> DistanceMap<R> {
        let end = self.end(&distances);
        let mut distances = self.grid.crop(distances);
        self.agree_on_copies(&mut distances);
        let of_row = |row: &mut [R]| {
            let (mut reached, mut largest) = (0, R::neg_infinity());
            for distance in row.iter_mut().filter(|distance| distance.is_finite()) {
                *distance = *distance + R::of(self.start);
                if distance.wide() > end {
                    *distance = R::infinity();
                    continue;
                }
                reached += 1;
                largest = largest.max(*distance);
            }
            (reached, largest)
        };
        let (reached, max_distance) = distances
            .par_chunks_mut(self.surface.cols())
            .map(of_row)
            .reduce(|| (0, R::neg_infinity()), |a, b| (a.0 + b.0, a.1.max(b.1)));
        (report.reached, report.max_distance) = (reached, max_distance.wide());
        report.ends_at = Some(end).filter(|end| end.is_finite());
        report.converged = report.residual <= self.stop.tolerance;
        DistanceMap::reported(self.surface.chart(), distances, report)
    }
}

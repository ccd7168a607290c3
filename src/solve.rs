//! One call from surface and sources to distance map.

use std::time::{Duration, Instant};

use crate::cpu::{self, Connections, Stop};
use crate::surface::{EdgeLengths, Seed, Sources, Surface};
use crate::update::Wavefront;
use crate::vulkan::{self, Schedule, VulkanError};
use crate::{DistanceMap, Error, Report};

/// Which engine computes a map.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum Engine {
    /// The first usable Vulkan device, else the CPU; the report says which, and why. With a
    /// [`Options::schedule`] only Vulkan will do.
    #[default]
    Auto,
    /// A Vulkan device, or an error.
    Vulkan(DeviceChoice),
    /// Rotated raster scans on the CPU.
    Cpu,
    /// Fast marching on the CPU, the sequential reference for the planar front, with obtuse triangles
    /// split. With the other fronts it can err by several per cent where triangles are obtuse: it
    /// fixes points once, and where they are split a front's curvature is that of the air between. Where
    /// none is, curved fronts are exact around corners of holes ([`cpu::fast_marching`]).
    FastMarching,
}

/// Which Vulkan device, in the order of [`vulkan::devices`].
#[derive(Clone, Debug, Default, PartialEq)]
pub enum DeviceChoice {
    /// The first usable one: a discrete GPU before an integrated one before others.
    #[default]
    Any,
    /// The first whose name contains this text, whatever the case.
    Name(String),
    /// The one with this index.
    Index(usize),
}

/// Default of [`Options::tolerance`]: near the rounding of single precision.
pub const DEFAULT_TOLERANCE: f64 = 1e-6;

/// How to compute a map. The default suits most surfaces.
#[derive(Clone, Debug, PartialEq)]
pub struct Options {
    /// Which engine.
    pub engine: Engine,
    /// The front assumed inside a triangle. By default curved, the most accurate on smooth
    /// surfaces, around walls and from curves, and as good as the circular one on rough terrain;
    /// but circular for point sources that start together on a surface with a slowness, which may
    /// jump from point to point; and planar for fast marching. A curved map takes about twice the
    /// time of a circular one. On floor plans [`Wavefront::Arcs`] is better still.
    pub wavefront: Option<Wavefront>,
    /// The order of updates on a Vulkan device, which makes no difference to the map; by default
    /// [`Schedule::best_on`] the device. The CPU's engines have one order each.
    pub schedule: Option<Schedule>,
    /// Stop when no arrival time falls by more than this fraction in an iteration.
    pub tolerance: f64,
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
            tolerance: DEFAULT_TOLERANCE,
            iterations: None,
        }
    }
}

impl Options {
    pub(crate) fn stop(&self, surface: &Surface) -> Result<Stop, Error> {
        if !(self.tolerance >= 0.0 && self.tolerance < 1.0) {
            let message = format!("tolerance {} is not in the range from 0 to 1", self.tolerance);
            return Err(Error::Options(message));
        }
        let enough = 10 * (surface.rows() + surface.cols());
        let iterations = self.iterations.unwrap_or(u32::try_from(enough).unwrap_or(u32::MAX));
        if iterations == 0 {
            return Err(Error::Options("at least one iteration is needed".into()));
        }
        Ok(Stop { tolerance: self.tolerance, iterations })
    }

    /// The wavefront from a single point.
    pub(crate) fn wavefront_from_a_point(&self, surface: &Surface) -> Wavefront {
        let or_else = || match surface.slowness() {
            _ if self.engine == Engine::FastMarching => Wavefront::Planar,
            Some(_) => Wavefront::PointSource,
            None => Wavefront::Curved,
        };
        self.wavefront.unwrap_or_else(or_else)
    }

    pub(crate) fn wavefront(
        &self,
        surface: &Surface,
        sources: &Sources,
    ) -> Result<Wavefront, Error> {
        let circular = sources.are_points() && sources.start_together();
        match self.wavefront {
            None if circular || self.engine == Engine::FastMarching => {
                Ok(self.wavefront_from_a_point(surface))
            }
            None => Ok(Wavefront::Curved),
            Some(Wavefront::PointSource) if !sources.are_points() => Err(Error::Options(
                "the point-source wavefront needs point sources; use the curved or the planar one \
                 for curves"
                    .into(),
            )),
            Some(wavefront) => Ok(wavefront),
        }
    }
}

/// Computes the geodesic distance from the sources to every point of a surface.
///
/// # Errors
/// If a source lies off the surface, an option is out of range, an edge of the surface is too
/// long or too short for single precision, or the engine asked for cannot run.
/// [`Engine::Auto`] falls back to the CPU where Vulkan cannot run, and says why in the report.
pub fn distance_map(
    surface: &Surface,
    sources: &Sources,
    options: &Options,
) -> Result<DistanceMap, Error> {
    Problem::new(surface, sources, options)?.solve(&options.engine)
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
    fn new(surface: &'a Surface, sources: &Sources, options: &Options) -> Result<Self, Error> {
        Self::from_seeds(surface, sources.seeds(surface)?, sources, options)
    }

    /// Starts from seeds that stand for the sources.
    pub(crate) fn from_seeds(
        surface: &'a Surface,
        mut seeds: Vec<Seed>,
        sources: &Sources,
        options: &Options,
    ) -> Result<Self, Error> {
        let wavefront = options.wavefront(surface, sources)?;
        let stop = options.stop(surface)?;
        let start = sources.start();
        seeds.iter_mut().for_each(|seed| seed.time -= start);
        Ok(Self { surface, seeds, start, wavefront, schedule: options.schedule, stop })
    }

    pub(crate) fn solve(&self, engine: &Engine) -> Result<DistanceMap, Error> {
        match engine {
            Engine::Cpu | Engine::FastMarching if self.schedule.is_some() => {
                Err(Error::Options("a schedule is for a Vulkan device, not for the CPU".into()))
            }
            Engine::Auto if self.schedule.is_some() => {
                Ok(self.solve_on_vulkan(&DeviceChoice::Any)?)
            }
            Engine::Cpu => self.solve_on_cpu(None),
            Engine::FastMarching => self.solve_by_fast_marching(),
            Engine::Vulkan(choice) => Ok(self.solve_on_vulkan(choice)?),
            Engine::Auto => match self.solve_on_vulkan(&DeviceChoice::Any) {
                Ok(map) => Ok(map),
                Err(VulkanError::Surface(error)) => Err(error.into()),
                Err(reason) => self.solve_on_cpu(Some(reason.to_string())),
            },
        }
    }

    fn solve_on_cpu(&self, fallback: Option<String>) -> Result<DistanceMap, Error> {
        let edges = EdgeLengths::<f32>::new(self.surface)?;
        let start = Instant::now();
        let solution = cpu::rotated_scan(&edges, &self.seeds, self.wavefront, self.stop);
        let time = start.elapsed();
        let report = Report {
            engine: "cpu",
            fallback,
            iterations: solution.iterations,
            residual: solution.residual,
            ..self.report("rotated-scan", time)
        };
        Ok(self.finish(solution.distances(), report))
    }

    fn solve_by_fast_marching(&self) -> Result<DistanceMap, Error> {
        let edges = EdgeLengths::<f32>::new(self.surface)?;
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
            fallback: None,
            schedule,
            wavefront: self.wavefront,
            iterations: 1,
            residual: 0.0,
            converged: false,
            solve_time,
            points: self.surface.points(),
            reached: 0,
            max_distance: 0.0,
        }
    }

    /// Adds the initial value that was taken away, and counts.
    fn finish(&self, mut distances: Vec<f32>, report: Report) -> DistanceMap {
        let (mut reached, mut max_distance) = (0, f32::NEG_INFINITY);
        for distance in distances.iter_mut().filter(|distance| distance.is_finite()) {
            *distance += self.start as f32;
            reached += 1;
            max_distance = max_distance.max(*distance);
        }
        let converged = report.residual <= self.stop.tolerance;
        DistanceMap {
            chart: self.surface.chart(),
            distances,
            report: Report { converged, reached, max_distance, ..report },
        }
    }
}

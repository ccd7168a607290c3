//! Computes what is profiled: a map, or the maps of many sources at once.

use std::time::{Duration, Instant};

use geosweep::surface::Seed;
use geosweep::vulkan::profile::{Detail, SolveProfile};
use geosweep::vulkan::{
    HeadlessSolver, Method, PairwiseOnDevice, PairwiseSchedule, Schedule, SurfaceOnDevice,
    VulkanError,
};
use geosweep::{Options, Sources, Surface};

/// The kind of computation to profile.
#[derive(Clone, Copy)]
pub enum Of<'a> {
    /// A map from the given sources.
    Map(&'a Sources),
    /// A batch of maps at once, as computed for a matrix.
    Pairwise(Option<PairwiseSchedule>),
}

/// The subject of a profile, which can be computed repeatedly.
pub struct Subject {
    on_device: SurfaceOnDevice,
    method: Method,
    maps: Maps,
}

enum Maps {
    /// A map from seeds.
    One(Vec<Seed>),
    Batch(Box<Batch>),
}

/// Several maps at once.
struct Batch {
    pairwise: PairwiseOnDevice,
    sources: Vec<Option<usize>>,
    rows: Vec<f32>,
}

/// The method by which the subject was computed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Solved {
    Map(Schedule),
    Pairwise { schedule: PairwiseSchedule, maps: usize },
}

impl Solved {
    /// Returns the name of the schedule, for reports.
    pub fn schedule(self) -> String {
        match self {
            Self::Map(schedule) => schedule.name().into(),
            Self::Pairwise { schedule, .. } => format!("pairwise {schedule}"),
        }
    }

    pub fn maps(self) -> usize {
        match self {
            Self::Map(_) => 1,
            Self::Pairwise { maps, .. } => maps,
        }
    }
}

/// The outcome of a computation.
pub struct Ended {
    pub solved: Solved,
    pub iterations: u32,
    pub residual: f64,
}

impl Subject {
    /// Prepares the subject with the method that the options select. For a batch, this is the method for a
    /// map from a single point.
    pub fn new(
        solver: &HeadlessSolver,
        surface: &Surface,
        of: &Of,
        options: &Options,
    ) -> Result<Self, geosweep::Error> {
        let on_device = solver.upload(surface)?;
        let method = match of {
            Of::Map(sources) => options.method(surface, sources)?,
            Of::Pairwise(_) => options.method(surface, &Sources::point(0.0, 0.0))?,
        };
        let maps = match *of {
            Of::Map(sources) => {
                let mut seeds = sources.seeds(surface)?;
                // As in `distance_map`, the times of seeds are relative to the smallest one.
                let start = seeds.iter().map(|seed| seed.time).fold(f64::INFINITY, f64::min);
                seeds.iter_mut().for_each(|seed| seed.time -= start);
                Maps::One(geosweep::cpu::seeds_for(method.wavefront, surface, seeds))
            }
            Of::Pairwise(schedule) => {
                let pairwise = solver.pairwise(&on_device, method.wavefront, schedule)?;
                let (present, points) = (surface.present(), surface.chart().points());
                // The sources are consecutive points, as for consecutive rows of a matrix.
                let count = pairwise.batch().min(points);
                let first = (points - count) / 2;
                let source = |point: usize| present[point].then_some(point);
                let sources = (first..first + count).map(source).collect();
                let rows = vec![0.0; count * points];
                Maps::Batch(Box::new(Batch { pairwise, sources, rows }))
            }
        };
        Ok(Self { on_device, method, maps })
    }

    pub fn method(&self) -> Method {
        self.method
    }

    /// Computes the subject without profiling. Returns the time that it took.
    pub fn solve(&mut self, solver: &mut HeadlessSolver) -> Result<Duration, VulkanError> {
        let Self { on_device, method, maps } = self;
        match maps {
            Maps::One(seeds) => Ok(solver.solve(on_device, seeds, *method)?.time),
            Maps::Batch(batch) => {
                let Batch { pairwise, sources, rows } = &mut **batch;
                let begin = Instant::now();
                pairwise.solve(solver, on_device, sources, method.stop, rows)?;
                Ok(begin.elapsed())
            }
        }
    }

    /// Computes the subject with profiling.
    pub fn profile(
        &mut self,
        solver: &mut HeadlessSolver,
        detail: Detail,
    ) -> Result<(Ended, SolveProfile), VulkanError> {
        let Self { on_device, method, maps } = self;
        match maps {
            Maps::One(seeds) => {
                let (solution, profile) = solver.profile(on_device, seeds, *method, detail)?;
                let solved = Solved::Map(solution.schedule);
                let (iterations, residual) = (solution.iterations, solution.residual);
                Ok((Ended { solved, iterations, residual }, profile))
            }
            Maps::Batch(batch) => {
                let Batch { pairwise, sources, rows } = &mut **batch;
                let schedule = pairwise.schedule();
                let solved = Solved::Pairwise { schedule, maps: sources.iter().flatten().count() };
                let (convergence, profile) =
                    pairwise.profile(solver, on_device, sources, method.stop, rows, detail)?;
                let (iterations, residual) = (convergence.iterations, convergence.residual);
                Ok((Ended { solved, iterations, residual }, profile))
            }
        }
    }
}

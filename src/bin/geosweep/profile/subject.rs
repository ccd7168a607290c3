//! What is computed while it is profiled: a map, or the maps of many sources at once.

use std::time::{Duration, Instant};

use geosweep::cpu::Stop;
use geosweep::surface::Seed;
use geosweep::vulkan::profile::{Detail, SolveProfile};
use geosweep::vulkan::{
    Method, PairwiseOnDevice, PairwiseSchedule, Schedule, Solver, SurfaceOnDevice, VulkanError,
};
use geosweep::{Options, Sources, Surface};

use super::measure::Of;

/// Computes it as often as is wanted.
pub enum Subject {
    Map { on_device: SurfaceOnDevice, seeds: Vec<Seed>, method: Method },
    Pairwise(Box<Batch>),
}

/// Maps at once.
pub struct Batch {
    on_device: SurfaceOnDevice,
    pairwise: PairwiseOnDevice,
    sources: Vec<Option<usize>>,
    rows: Vec<f32>,
    stop: Stop,
}

/// In which way it was computed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Solved {
    Map(Schedule),
    Pairwise { schedule: PairwiseSchedule, maps: usize },
}

impl Solved {
    /// The schedule's name in reports.
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

/// What has come of it.
pub struct Ended {
    pub solved: Solved,
    pub iterations: u32,
    pub residual: f64,
}

impl Subject {
    /// With the method that the options mean; for maps at once as if from one of their sources.
    pub fn new(
        solver: &Solver,
        surface: &Surface,
        of: &Of,
        options: &Options,
    ) -> Result<(Self, Method), geosweep::Error> {
        let on_device = solver.upload(surface)?;
        match *of {
            Of::Map(sources) => {
                let method = options.method(surface, sources)?;
                let mut seeds = sources.seeds(surface)?;
                // As for a map, which adds the smallest start value in the end.
                let start = seeds.iter().map(|seed| seed.time).fold(f64::INFINITY, f64::min);
                seeds.iter_mut().for_each(|seed| seed.time -= start);
                Ok((Self::Map { on_device, seeds, method }, method))
            }
            Of::Pairwise(schedule) => {
                let method = options.method(surface, &Sources::point(0.0, 0.0))?;
                let (wavefront, stop) = (method.wavefront, method.stop);
                let pairwise = solver.pairwise(&on_device, wavefront, schedule)?;
                let (present, points) = (surface.present(), surface.chart().points());
                // Neighbours, as in a matrix whose rows are computed in their order.
                let count = pairwise.batch().min(points);
                let first = (points - count) / 2;
                let source = |point: usize| present[point].then_some(point);
                let sources = (first..first + count).map(source).collect();
                let rows = vec![0.0; count * points];
                let batch = Batch { on_device, pairwise, sources, rows, stop };
                Ok((Self::Pairwise(Box::new(batch)), method))
            }
        }
    }

    /// Without profiling: how long it takes.
    pub fn solve(&mut self, solver: &mut Solver) -> Result<Duration, VulkanError> {
        match self {
            Self::Map { on_device, seeds, method } => {
                Ok(solver.solve(on_device, seeds, *method)?.time)
            }
            Self::Pairwise(batch) => {
                let Batch { on_device, pairwise, sources, rows, stop } = &mut **batch;
                let begin = Instant::now();
                pairwise.solve(solver, on_device, sources, *stop, rows)?;
                Ok(begin.elapsed())
            }
        }
    }

    /// With it.
    pub fn profile(
        &mut self,
        solver: &mut Solver,
        detail: Detail,
    ) -> Result<(Ended, SolveProfile), VulkanError> {
        match self {
            Self::Map { on_device, seeds, method } => {
                let (solution, profile) = solver.profile(on_device, seeds, *method, detail)?;
                let solved = Solved::Map(solution.schedule);
                let (iterations, residual) = (solution.iterations, solution.residual);
                Ok((Ended { solved, iterations, residual }, profile))
            }
            Self::Pairwise(batch) => {
                let Batch { on_device, pairwise, sources, rows, stop } = &mut **batch;
                let schedule = pairwise.schedule();
                let solved = Solved::Pairwise { schedule, maps: sources.iter().flatten().count() };
                let (convergence, profile) =
                    pairwise.profile(solver, on_device, sources, *stop, rows, detail)?;
                let (iterations, residual) = (convergence.iterations, convergence.residual);
                Ok((Ended { solved, iterations, residual }, profile))
            }
        }
    }
}

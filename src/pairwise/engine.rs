//! Computes rows of the matrix: one interface to all engines.

use rayon::prelude::*;

use super::lanes::LaneEngine;
#[cfg(feature = "vulkan")]
use super::on_device::OnDevice;
use crate::cpu::{self, Order, RotatedScan};
use crate::surface::{EdgeLengths, Origin, Seed, SolverGrid, Surface};
use crate::{Convergence, Engine, Error, Monitor, Options, Stop, UsedEngine, Wavefront};

/// An engine, prepared for a surface.
pub(super) struct RowEngine<'a> {
    surface: &'a Surface,
    grid: SolverGrid<'a>,
    wavefront: Wavefront,
    pub monitor: Monitor,
    /// The distance beyond which points count as unreached.
    radius: f64,
    used: UsedEngine,
    kind: Kind,
}

enum Kind {
    /// Batches of maps in SIMD lanes.
    Lanes(LaneEngine),
    /// One map per thread, in an order that does not need several.
    Maps(EdgeLengths<f32>, Order),
    /// Maps on a Vulkan device.
    #[cfg(feature = "vulkan")]
    Vulkan(Box<OnDevice>),
}

impl<'a> RowEngine<'a> {
    pub fn new(
        surface: &'a Surface,
        wavefront: Wavefront,
        options: &Options,
    ) -> Result<Self, Error> {
        let (monitor, radius) = (options.monitor(), options.checked_radius()?);
        let grid = surface.solver_grid();
        let on_grid = grid.surface();
        let edges = || EdgeLengths::measured(on_grid, || Ok::<_, Error>(monitor.check()?));
        let (used, kind) = match &options.engine {
            Engine::Auto | Engine::Cpu => {
                let edges = edges()?;
                let kind = match LaneEngine::new(&grid, &edges, wavefront) {
                    Some(lanes) => Kind::Lanes(lanes),
                    None => {
                        let order = Order::best_on(&edges, wavefront, 1);
                        Kind::Maps(edges, order)
                    }
                };
                (UsedEngine::Cpu, kind)
            }
            Engine::FastMarching => (UsedEngine::FastMarching, Kind::Maps(edges()?, Order::Times)),
            #[cfg(feature = "vulkan")]
            Engine::Vulkan(choice) => {
                let device = OnDevice::new(choice, on_grid, wavefront, &monitor)?;
                (UsedEngine::Vulkan, Kind::Vulkan(Box::new(device)))
            }
        };
        Ok(Self { surface, grid, wavefront, monitor, radius, used, kind })
    }

    /// Returns the engine for the report.
    pub fn used(&self) -> UsedEngine {
        self.used
    }

    pub fn device(&self) -> Option<&str> {
        match &self.kind {
            #[cfg(feature = "vulkan")]
            Kind::Vulkan(device) => Some(device.name()),
            _ => None,
        }
    }

    pub fn wavefront(&self) -> Wavefront {
        self.wavefront
    }

    /// Returns the engine and the grid for the symmetric initialisation.
    ///
    /// # Errors
    /// If the engine or the surface does not support it.
    pub fn for_symmetry(&self) -> Result<(&LaneEngine, &SolverGrid<'a>), Error> {
        let fault = |message: &str| Err(Error::Options(message.into()));
        match &self.kind {
            Kind::Lanes(lanes) => Ok((lanes, &self.grid)),
            _ if self.surface.is_glued() => {
                fault("the symmetric initialisation is not for glued surfaces; leave it out")
            }
            _ => fault(
                "the symmetric initialisation is for the planar and the circular wavefront on the CPU; choose \
                 these, or leave it out",
            ),
        }
    }

    /// Returns the bytes of memory used for the surface and for the work of `threads` threads.
    pub fn bytes(&self, threads: usize) -> usize {
        match &self.kind {
            Kind::Lanes(lanes) => lanes.bytes(threads),
            Kind::Maps(edges, order) => {
                let map = RotatedScan::in_order(edges, self.wavefront, *order);
                edges.bytes() + threads * map.bytes()
            }
            #[cfg(feature = "vulkan")]
            Kind::Vulkan(device) => device.bytes(),
        }
    }

    /// Returns the smallest number of rows that keeps `threads` threads busy.
    pub fn rows_at_once(&self, threads: usize) -> usize {
        match &self.kind {
            Kind::Lanes(lanes) => lanes.rows_at_once(threads),
            Kind::Maps(..) => 4 * threads,
            #[cfg(feature = "vulkan")]
            Kind::Vulkan(device) => device.batch(),
        }
    }

    /// Returns the number of sources to compute together: about `about`, without splitting a batch.
    pub fn whole_batches(&self, sources: &[usize], about: usize) -> usize {
        match &self.kind {
            Kind::Lanes(lanes) => lanes.whole_batches(sources, about),
            _ => about.min(sources.len()),
        }
    }

    /// Computes the rows of some sources. The row of a hole is +infinity. `done` is called with the number of
    /// rows that have been added, from any thread.
    pub fn solve(
        &mut self,
        sources: &[usize],
        stop: Stop,
        into: &mut [f32],
        done: &(dyn Fn(usize) + Sync),
    ) -> Result<Convergence, Error> {
        let convergence = self.solve_whole(sources, stop, into, done)?;
        if self.radius < f64::INFINITY {
            let beyond = |distance: &&mut f32| f64::from(**distance) > self.radius;
            into.par_iter_mut().filter(beyond).for_each(|distance| *distance = f32::INFINITY);
        }
        Ok(convergence)
    }

    /// Computes rows as [`Self::solve`] does, but may leave distances beyond the radius.
    fn solve_whole(
        &mut self,
        sources: &[usize],
        stop: Stop,
        into: &mut [f32],
        done: &(dyn Fn(usize) + Sync),
    ) -> Result<Convergence, Error> {
        let (surface, grid) = (self.surface, &self.grid);
        let (wavefront, radius) = (self.wavefront, self.radius);
        match &mut self.kind {
            Kind::Lanes(lanes) => Ok(lanes.solve(grid, sources, stop, into, (&self.monitor, done))),
            Kind::Maps(edges, order) => {
                let new = || {
                    let solver = RotatedScan::in_order(edges, wavefront, *order);
                    let mut solver = solver.with_monitor(self.monitor.clone());
                    solver.set_radius(radius);
                    solver
                };
                let done = (&self.monitor, done);
                Ok(map_by_map(surface, sources, into, done, new, |solver, seed| {
                    let convergence = solver.solve(&seeds_of(wavefront, grid, seed), stop);
                    (convergence, grid.crop(solver.distances()))
                }))
            }
            #[cfg(feature = "vulkan")]
            Kind::Vulkan(device) => {
                device.solve((surface, grid), sources, stop, into, (&self.monitor, done))
            }
        }
    }
}

/// Returns the seeds of a grid point's map. Rows have no surroundings, so that all engines give the same rows. But where
/// all cells are alike and skewed, a front keeps its origin, as in single maps.
pub(super) fn seeds_of(wavefront: Wavefront, grid: &SolverGrid, seed: Seed) -> Vec<Seed> {
    let (seed, surface) = (grid.seed(seed), grid.surface());
    if surface.skew_around(seed.place()) == 1 || !surface.has_even_cells() {
        return vec![seed];
    }
    let origin = Some(Origin::point(seed.place(), seed.time));
    cpu::seeds_for(wavefront, surface, vec![Seed { origin, ..seed }])
}

/// Fills each row with a map of its own, one map per thread at a time. The row of a hole is +infinity.
fn map_by_map<S>(
    surface: &Surface,
    sources: &[usize],
    into: &mut [f32],
    (monitor, done): (&Monitor, &(dyn Fn(usize) + Sync)),
    new: impl Fn() -> S + Sync + Send,
    map: impl Fn(&mut S, Seed) -> (Convergence, Vec<f32>) + Sync + Send,
) -> Convergence {
    let rows = into.par_chunks_exact_mut(surface.chart().points()).zip(sources);
    let maps = rows.map_init(new, |solver, (into, &source)| {
        let (row, col) = surface.chart().position(source);
        if monitor.is_cancelled() {
            return Convergence::NONE;
        }
        let convergence = if surface.has(row, col) {
            let (convergence, distances) = map(solver, Seed::at_source(row, col, 0.0));
            into.copy_from_slice(&distances);
            convergence
        } else {
            into.fill(f32::INFINITY);
            Convergence::NONE
        };
        done(1);
        convergence
    });
    maps.reduce(|| Convergence::NONE, Convergence::worse)
}

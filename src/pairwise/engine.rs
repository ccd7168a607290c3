//! What computes rows: one interface over the engines.

use rayon::prelude::*;

use super::lanes::Lanes;
use super::report::Tally;
use crate::Stop;
use crate::cpu::{Connections, RotatedScan, fast_marching_with};
use crate::surface::{EdgeLengths, Seed, Surface};
use crate::vulkan::{PairwiseOnDevice, Solver, SurfaceOnDevice};
use crate::{Engine, Error, Wavefront};

/// An engine, ready for a surface.
pub(super) struct RowEngine<'a> {
    surface: &'a Surface,
    wavefront: Wavefront,
    kind: Kind<'a>,
}

enum Kind<'a> {
    /// Batches of maps.
    Lanes(Lanes<'a>),
    /// A map for each thread.
    Maps(EdgeLengths<f32>),
    /// The reference, a map for each thread.
    FastMarching(EdgeLengths<f32>, Connections<f32>),
    /// Batches of maps on a device.
    Vulkan(Box<OnDevice>),
}

struct OnDevice {
    pairwise: PairwiseOnDevice,
    surface: SurfaceOnDevice,
    solver: Solver,
}

/// Told how many rows have been added, from any thread.
pub(super) type Done<'a> = &'a (dyn Fn(usize) + Sync);

impl<'a> RowEngine<'a> {
    pub fn new(surface: &'a Surface, wavefront: Wavefront, engine: &Engine) -> Result<Self, Error> {
        let kind = match engine {
            Engine::Auto | Engine::Cpu => {
                let edges = EdgeLengths::new(surface)?;
                if wavefront.has_two_layers() {
                    Kind::Maps(edges)
                } else {
                    Kind::Lanes(Lanes::new(surface, &edges, wavefront))
                }
            }
            Engine::FastMarching => {
                Kind::FastMarching(EdgeLengths::new(surface)?, Connections::split(surface)?)
            }
            Engine::Vulkan(choice) => {
                let solver = Solver::new(choice)?;
                let on_device = solver.upload(surface)?;
                let pairwise = solver.pairwise(&on_device, wavefront, None)?;
                Kind::Vulkan(Box::new(OnDevice { pairwise, surface: on_device, solver }))
            }
        };
        Ok(Self { surface, wavefront, kind })
    }

    pub fn name(&self) -> &'static str {
        match self.kind {
            Kind::Lanes(_) | Kind::Maps(_) => "cpu",
            Kind::FastMarching(..) => "fast-marching",
            Kind::Vulkan(_) => "vulkan",
        }
    }

    pub fn device(&self) -> Option<&str> {
        match &self.kind {
            Kind::Vulkan(device) => Some(device.solver.device_name()),
            _ => None,
        }
    }

    /// The engine that has a symmetric initialisation.
    pub fn lanes(&self) -> Option<&Lanes<'a>> {
        match &self.kind {
            Kind::Lanes(lanes) => Some(lanes),
            _ => None,
        }
    }

    /// Bytes held for the surface and for the work of so many threads.
    pub fn bytes(&self, threads: usize) -> usize {
        match &self.kind {
            Kind::Lanes(lanes) => lanes.bytes(threads),
            Kind::Maps(edges) => {
                edges.bytes() + threads * RotatedScan::new(edges, self.wavefront).bytes()
            }
            Kind::FastMarching(edges, _) => {
                // Front, flag and a few entries of the heap for a point, and further connections.
                edges.bytes() + threads * edges.chart().bordered_points() * 64
            }
            Kind::Vulkan(device) => (device.surface.bytes() + device.pairwise.bytes()) as usize,
        }
    }

    /// The least number of rows that keeps so many threads at work.
    pub fn rows_at_once(&self, threads: usize) -> usize {
        match self.kind {
            Kind::Lanes(ref lanes) => lanes.rows_at_once(threads),
            Kind::Maps(_) | Kind::FastMarching(..) => 4 * threads,
            Kind::Vulkan(ref device) => device.pairwise.batch(),
        }
    }

    /// How many of the sources to compute together, about so many, without splitting a batch.
    pub fn whole_batches(&self, sources: &[usize], about: usize) -> usize {
        match &self.kind {
            Kind::Lanes(lanes) => lanes.whole_batches(sources, about),
            _ => about.min(sources.len()),
        }
    }

    /// Computes the rows of some sources; a hole's is +infinity.
    pub fn solve(
        &mut self,
        sources: &[usize],
        stop: Stop,
        into: &mut [f32],
        done: Done,
    ) -> Result<Tally, Error> {
        let (surface, wavefront) = (self.surface, self.wavefront);
        let seed = |source: usize| {
            let (row, col) = surface.chart().position(source);
            surface.has(row, col).then(|| [Seed::at_source(row, col, 0.0)])
        };
        let points = surface.chart().points();
        match &mut self.kind {
            Kind::Lanes(lanes) => Ok(lanes.solve(sources, stop, into, done)),
            Kind::Maps(edges) => {
                let rows = into.par_chunks_exact_mut(points).zip(sources);
                let tallies = rows.map_init(
                    || RotatedScan::new(edges, wavefront),
                    |solver, (row, &source)| {
                        let tally = if let Some(seeds) = seed(source) {
                            let tally = solver.solve(&seeds, stop).into();
                            row.copy_from_slice(&solver.distances());
                            tally
                        } else {
                            row.fill(f32::INFINITY);
                            Tally::default()
                        };
                        done(1);
                        tally
                    },
                );
                Ok(tallies.reduce(Tally::default, Tally::join))
            }
            Kind::FastMarching(edges, split) => {
                let map = |seed| fast_marching_with(edges, split, &[seed], wavefront);
                Ok(each_row(into, points, sources, done, |source| {
                    seed(source).map(|[seed]| map(seed).distances())
                }))
            }
            Kind::Vulkan(device) => {
                let OnDevice { pairwise, surface: on_device, solver } = &mut **device;
                let mut tally = Tally::default();
                let batch = pairwise.batch();
                for (sources, rows) in sources.chunks(batch).zip(into.chunks_mut(batch * points)) {
                    let present = surface.present();
                    let sources: Vec<_> =
                        sources.iter().map(|&source| present[source].then_some(source)).collect();
                    tally.add(pairwise.solve(solver, on_device, &sources, stop, rows)?.into());
                    done(sources.len());
                }
                Ok(tally)
            }
        }
    }
}

/// Fills rows by marching from their sources, one for each thread at a time; those of holes are +infinity.
fn each_row(
    into: &mut [f32],
    points: usize,
    sources: &[usize],
    done: Done,
    row_of: impl Fn(usize) -> Option<Vec<f32>> + Sync,
) -> Tally {
    let rows = into.par_chunks_exact_mut(points).zip(sources);
    rows.for_each(|(row, &source)| {
        match row_of(source) {
            Some(distances) => row.copy_from_slice(&distances),
            None => row.fill(f32::INFINITY),
        }
        done(1);
    });
    Tally { iterations: 1, residual: 0.0 }
}

//! Computes rows in SIMD lanes, in batches of maps on all threads.

use rayon::prelude::*;

use super::batches::{Batch, Batches};
use crate::cpu::PairwiseScan;
use crate::surface::{EdgeLengths, SolverGrid};
use crate::{Convergence, Monitor, Stop, Wavefront};

/// The batched engine of a surface on the CPU, for wavefronts that support batches.
pub(super) struct LaneEngine {
    scan: PairwiseScan,
    batches: Batches,
}

/// The number of rows in a generation; later rows start from completed generations. A generation needs a few batches
/// for the threads to share. In a larger one, fewer distances are known when a row starts.
const GENERATION: usize = 256;

impl LaneEngine {
    /// Prepares the engine. Returns `None` if maps of this wavefront cannot be computed side by side, or the surface is
    /// glued. Since glued surfaces are left out, the solver's grid is the surface's own.
    pub fn new(grid: &SolverGrid, edges: &EdgeLengths<f32>, wavefront: Wavefront) -> Option<Self> {
        let (scan, batches) = (PairwiseScan::new(edges, wavefront)?, Batches::new(grid.chart()));
        Some(Self { scan, batches })
    }

    /// Returns the bytes of memory used for the surface and for the work of `threads` threads.
    pub fn bytes(&self, threads: usize) -> usize {
        let (shared, batch) = self.scan.bytes();
        shared + threads * batch
    }

    /// Returns the smallest number of rows that keeps `threads` threads busy.
    pub fn rows_at_once(&self, threads: usize) -> usize {
        self.batches.most().max(PairwiseScan::LANES * threads)
    }

    /// Returns the number of sources to compute together: at most `most`, unless a single group is larger.
    pub fn whole_batches(&self, sources: &[usize], most: usize) -> usize {
        let ends = self.batches.split(sources).map(|(group, _)| group.end);
        ends.take_while(|&end| end <= most.max(self.batches.most())).last().unwrap_or(0)
    }

    /// Computes the rows of some sources, unless `monitor` cancels them. `done` is called with the number of rows
    /// that have been added.
    pub fn solve(
        &self,
        grid: &SolverGrid,
        sources: &[usize],
        stop: Stop,
        into: &mut [f32],
        (monitor, done): (&Monitor, &(dyn Fn(usize) + Sync)),
    ) -> Convergence {
        let points = grid.chart().points();
        let mut rows: Vec<_> = into.chunks_exact_mut(points).map(Some).collect();
        let batches = self.batches.split(sources).flat_map(|(_, batches)| batches);
        let parts: Vec<_> = batches
            .map(|Batch { sources, places }| {
                let rows: Vec<_> =
                    places.into_iter().map(|place| place.and_then(|at| rows[at].take())).collect();
                (grid.points(&sources), rows)
            })
            .collect();
        let solved = parts.into_par_iter().map(|(sources, mut rows)| {
            if monitor.is_cancelled() {
                return Convergence::NONE;
            }
            let convergence = self.scan.solve_rows(&sources, stop, &mut rows);
            done(rows.iter().flatten().count());
            convergence
        });
        solved.reduce(|| Convergence::NONE, Convergence::worse)
    }

    /// Computes the whole matrix with the symmetric initialisation (paper, eq. 20).
    pub fn solve_by_symmetry<E: Send>(
        &self,
        grid: &SolverGrid,
        stop: Stop,
        matrix: &mut [f32],
        done: &(dyn Fn(usize) -> Result<(), E> + Sync),
    ) -> Result<Convergence, E> {
        let points = grid.chart().points();
        let mut convergence = Convergence::NONE;
        for first in (0..points).step_by(GENERATION) {
            let (known, rest) = matrix.split_at_mut(first * points);
            let rows = &mut rest[..GENERATION.min(points - first) * points];
            let batches = rows.par_chunks_mut(PairwiseScan::LANES * points).enumerate();
            let solved = batches.map(|(batch, rows)| {
                let first = first + batch * PairwiseScan::LANES;
                let sources: Vec<_> = (first..first + rows.len() / points).collect();
                let sources = grid.points(&sources);
                let convergence = self.scan.solve_below(known, first, &sources, stop, rows);
                done(sources.len())?;
                Ok(convergence)
            });
            let solved = solved.try_reduce(|| Convergence::NONE, |a, b| Ok(a.worse(b)));
            convergence = convergence.worse(solved?);
        }
        Ok(convergence)
    }
}

//! Rows in lanes: batches of maps on all threads.

use rayon::prelude::*;

use super::batches::{Batch, batches};
use super::engine::Done;
use super::report::Tally;
use crate::Wavefront;
use crate::cpu::{PairwiseScan, Stop};
use crate::surface::{EdgeLengths, Surface};

/// The pairwise engine of the CPU on a surface.
pub(super) struct Lanes<'a> {
    surface: &'a Surface,
    wavefront: Wavefront,
    scan: PairwiseScan,
}

/// Rows that are done before others start from them. Threads need a few batches to share; more
/// rows, and less is known on average.
const GENERATION: usize = 256;

impl<'a> Lanes<'a> {
    /// Rows of a batch.
    pub const ROWS: usize = PairwiseScan::LANES;

    pub fn new(surface: &'a Surface, edges: &EdgeLengths<f32>, wavefront: Wavefront) -> Self {
        Self { surface, wavefront, scan: PairwiseScan::new(edges, wavefront) }
    }

    /// Bytes held for the surface and for the work of so many threads.
    pub fn bytes(&self, threads: usize) -> usize {
        let (shared, batch) = PairwiseScan::bytes(self.surface.chart(), self.wavefront);
        shared + threads * batch
    }

    /// How many of the sources to compute together, at most so many but for a single batch.
    pub fn whole_batches(&self, sources: &[usize], most: usize) -> usize {
        let ends = self.batches(sources).scan(0, |end, batch| {
            *end += batch.wanted.len();
            Some(*end)
        });
        ends.take_while(|&end| end <= most.max(Self::ROWS)).last().unwrap_or(0)
    }

    /// Computes the rows of some sources.
    pub fn solve(&self, sources: &[usize], stop: Stop, into: &mut [f32], done: Done) -> Tally {
        let points = self.surface.chart().points();
        let mut rest = into;
        let parts: Vec<_> = self
            .batches(sources)
            .map(|batch| {
                let rows = rest.split_off_mut(..batch.wanted.len() * points);
                (batch, rows.expect("a row for each source"))
            })
            .collect();
        let solved = parts.into_par_iter().map_init(Vec::new, |whole, (batch, rows)| {
            let Batch { sources, wanted } = batch;
            let sources = self.present(&sources);
            let tally = if wanted.len() == sources.len() {
                self.scan.solve(&sources, stop, rows)
            } else {
                whole.resize(sources.len() * points, 0.0);
                let convergence = self.scan.solve(&sources, stop, whole);
                rows.copy_from_slice(&whole[wanted.start * points..wanted.end * points]);
                convergence
            };
            done(wanted.len());
            Tally::from(tally)
        });
        solved.reduce(Tally::default, Tally::join)
    }

    /// Computes the whole matrix by the symmetric initialisation (paper, eq. 20).
    pub fn solve_by_symmetry(&self, stop: Stop, matrix: &mut [f32], done: Done) -> Tally {
        let points = self.surface.chart().points();
        let mut tally = Tally::default();
        for first in (0..points).step_by(GENERATION) {
            let (known, rest) = matrix.split_at_mut(first * points);
            let rows = &mut rest[..GENERATION.min(points - first) * points];
            let batches = rows.par_chunks_mut(Self::ROWS * points).enumerate();
            let solved = batches.map(|(batch, rows)| {
                let first = first + batch * Self::ROWS;
                let sources: Vec<_> = (first..first + rows.len() / points).collect();
                let sources = self.present(&sources);
                let convergence = self.scan.solve_below(known, first, &sources, stop, rows);
                done(sources.len());
                Tally::from(convergence)
            });
            tally.add(solved.reduce(Tally::default, Tally::join));
        }
        tally
    }

    fn batches(&self, sources: &[usize]) -> impl Iterator<Item = Batch> {
        batches(sources, self.surface.chart().points(), Self::ROWS)
    }

    /// Sources that are no holes.
    fn present(&self, sources: &[usize]) -> Vec<Option<usize>> {
        let present = self.surface.present();
        sources.iter().map(|&source| present[source].then_some(source)).collect()
    }
}

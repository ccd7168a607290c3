//! Rotated raster scans in lanes: whole rows, then whole columns.

use super::Instructions;
use super::fronts::{FrontKind, for_kind};
use super::scanner::Scanner;
use super::solution::{Solution, distances};
use crate::surface::{Chart, EdgeLengths, Real, Seed};
use crate::update::Wavefront;
use crate::{Convergence, Stop};

/// Solves by the scans rotated by 45 degrees (figure 3, second row): down and up, then right and
/// left. All points of a row or column are updated at once, in lanes; see [`RotatedScan`].
pub fn rotated_scan<R: Real>(
    edges: &EdgeLengths<R>,
    seeds: &[Seed],
    wavefront: Wavefront,
    stop: Stop,
) -> Solution<R> {
    for_kind!(edges, wavefront, kind => {
        let mut scanner = Scanner::new(edges, kind);
        let Convergence { iterations, residual } = scanner.solve(seeds, stop);
        Solution::new(edges.chart(), scanner.into_times(), iterations, residual)
    })
}

/// Solves one map after another of one surface by rotated scans, without allocating anew. The second
/// map of straight fronts on grids of 256 x 256 points and more fills 12 bytes a point in single
/// precision that make it and all others faster.
///
/// Opposite scans run side by side on two copies of the fronts, which are then merged: a front
/// that turns back has to pass through the other pair of scans anyhow. So the map is the same to
/// the bit for any number of threads.
#[derive(Debug)]
pub struct RotatedScan<'a, R> {
    chart: Chart,
    /// For a kind of front.
    scanner: Box<dyn Scans<R> + 'a>,
}

/// A [`Scanner`], whatever the kind of front.
trait Scans<R>: std::fmt::Debug + Send + Sync {
    fn solve(&mut self, seeds: &[Seed], stop: Stop) -> Convergence;
    fn add(&mut self, seeds: &[Seed], stop: Stop) -> Convergence;
    fn set_instructions(&mut self, instructions: Instructions);
    fn times(&self) -> &[R];
    fn visits(&self) -> u64;
    fn updates(&self) -> u64;
    fn bytes(&self) -> usize;
    fn boxed<'b>(&self) -> Box<dyn Scans<R> + 'b>
    where
        Self: 'b;
}

impl<'a, R: Real, K: FrontKind<'a, R>> Scans<R> for Scanner<'a, R, K> {
    fn solve(&mut self, seeds: &[Seed], stop: Stop) -> Convergence {
        self.solve(seeds, stop)
    }

    fn add(&mut self, seeds: &[Seed], stop: Stop) -> Convergence {
        self.add(seeds, stop)
    }

    fn set_instructions(&mut self, instructions: Instructions) {
        self.instructions = instructions;
    }

    fn times(&self) -> &[R] {
        self.times()
    }

    fn visits(&self) -> u64 {
        self.visits()
    }

    fn updates(&self) -> u64 {
        self.updates()
    }

    fn bytes(&self) -> usize {
        self.bytes()
    }

    fn boxed<'b>(&self) -> Box<dyn Scans<R> + 'b>
    where
        Self: 'b,
    {
        Box::new(self.clone())
    }
}

impl<'a, R: Real> RotatedScan<'a, R> {
    /// Makes room for the maps of a surface, on the best instructions there are.
    pub fn new(edges: &'a EdgeLengths<R>, wavefront: Wavefront) -> Self {
        let scanner: Box<dyn Scans<R> + 'a> =
            for_kind!(edges, wavefront, kind => Box::new(Scanner::new(edges, kind)));
        Self { chart: edges.chart(), scanner }
    }

    /// Chooses the instructions; the map does not depend on them.
    ///
    /// # Panics
    /// If this machine does not have them; see [`Instructions::available`].
    pub fn with_instructions(mut self, instructions: Instructions) -> Self {
        assert!(Instructions::available().contains(&instructions), "no {instructions} here");
        self.scanner.set_instructions(instructions);
        self
    }

    /// Computes the map of some sources.
    pub fn solve(&mut self, seeds: &[Seed], stop: Stop) -> Convergence {
        self.scanner.solve(seeds, stop)
    }

    /// Adds sources to the last map, as [`crate::vulkan::Solver::add`] does on a device. Only tiles
    /// that their fronts reach first are visited, so that a source among many costs what its own
    /// region does.
    ///
    /// If the last map has converged, so has this one, of all sources. With the planar wavefront it
    /// is the one that [`Self::solve`] finds from all of them, within the tolerance, whose updates
    /// have a single fixed point. The others' have not in theory; on smooth and on rough surfaces
    /// with holes both ways agree to rounding all the same (`tests/maps/sampling.rs`), but where curved
    /// fronts do not settle. Times fall, but a curved front that is renewed may come later by its
    /// error. Seeds that lie behind the map change nothing. On a new solver this is `solve`.
    ///
    /// ```
    /// use geosweep::cpu::RotatedScan;
    /// use geosweep::Stop;
    /// use geosweep::surface::{EdgeLengths, Seed, builtin::Builtin};
    /// use geosweep::Wavefront;
    ///
    /// let edges = EdgeLengths::<f32>::new(&Builtin::Plane.surface(101, 101)?)?;
    /// let stop = Stop { tolerance: 1e-6, iterations: 1000 };
    /// let mut solver = RotatedScan::new(&edges, Wavefront::PointSource);
    /// solver.solve(&[Seed::at_source(0, 0, 0.0)], stop);
    /// let before = solver.distances();
    /// solver.add(&[Seed::at_source(100, 100, 0.0)], stop);
    /// let after = solver.distances();
    /// assert!(after[0] == 0.0 && after[101 * 101 - 1] == 0.0);
    /// assert!(after.iter().zip(&before).all(|(after, before)| after <= before));
    /// # Ok::<(), geosweep::surface::SurfaceError>(())
    /// ```
    pub fn add(&mut self, seeds: &[Seed], stop: Stop) -> Convergence {
        self.scanner.add(seeds, stop)
    }

    /// The distances of the last map, row-major, +infinity where the sources do not reach.
    pub fn distances(&self) -> Vec<R> {
        distances(self.chart, self.scanner.times())
    }

    /// How many times the scans of the last map have come to a point, and read what its update
    /// needs, or have looked before whether to come.
    pub fn visits(&self) -> u64 {
        self.scanner.visits()
    }

    /// How many times they have updated one, each time from one triangle or two: less often, since
    /// of points that are settled a simpler test finds that no front comes earlier.
    pub fn updates(&self) -> u64 {
        self.scanner.updates()
    }

    /// Bytes held, beside the edge lengths.
    pub fn bytes(&self) -> usize {
        self.scanner.bytes()
    }

    /// The arrival times along a row, [`Real::FAR`] or later where no source reaches.
    pub(crate) fn row(&self, row: usize) -> &[R] {
        self.chart.row_of(self.scanner.times(), row)
    }
}

impl<R: Real> Clone for RotatedScan<'_, R> {
    fn clone(&self) -> Self {
        Self { chart: self.chart, scanner: self.scanner.boxed() }
    }
}

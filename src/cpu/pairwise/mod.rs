//! All pairs: the maps of neighbouring sources in the lanes of one instruction stream (paper,
//! section 5.1, Algorithm 4).

mod curved;
mod kernel;
mod marks;
mod outward;
mod pending;
mod planar;
mod point_source;
mod reach;
mod scans;
mod stage;

use super::{Instructions, RotatedScan};
use crate::surface::{Chart, EdgeLengths, Seed};
use crate::update::{Setting, Wavefront};
use crate::{Convergence, Stop};
use curved::Curved;
use kernel::LANES;
use planar::Planar;
use point_source::PointSource;
use scans::{Known, Scans};

/// Solves for batches of maps of one surface, from any number of threads.
///
/// The maps of a batch lie side by side in memory, point by point, and are updated together with
/// coefficients that all share, computed once for a surface. The scans are those of
/// [`super::scan_outward`], in the same order. A scan visits only points beside which a map of the
/// batch has changed since it passed, so sources in a batch should be neighbours.
pub struct PairwiseScan {
    chart: Chart,
    fronts: Fronts,
    instructions: Instructions,
}

enum Fronts {
    Planar(Scans<Planar>),
    PointSource(Scans<PointSource>),
    Curved(Scans<Curved>),
    /// One map after another: maps whose anchors differ have no update in common.
    Anchored(Box<EdgeLengths<f32>>),
}

impl PairwiseScan {
    /// Number of maps in a batch.
    pub const LANES: usize = LANES;

    /// Computes the coefficients of a surface, on the best instructions there are.
    pub fn new(edges: &EdgeLengths<f32>, wavefront: Wavefront) -> Self {
        let fronts = match wavefront.or_curved(Setting::of_engine(edges.floor().is_some())) {
            Wavefront::Planar => Fronts::Planar(Scans::new(edges)),
            Wavefront::PointSource => Fronts::PointSource(Scans::new(edges)),
            Wavefront::Curved => Fronts::Curved(Scans::new(edges)),
            Wavefront::Anchored => Fronts::Anchored(Box::new(edges.clone())),
        };
        Self { chart: edges.chart(), fronts, instructions: Instructions::best() }
    }

    /// Chooses the instructions; the maps do not depend on them.
    ///
    /// # Panics
    /// If this machine does not have them; see [`Instructions::available`].
    pub fn with_instructions(mut self, instructions: Instructions) -> Self {
        assert!(Instructions::available().contains(&instructions), "no {instructions} here");
        self.instructions = instructions;
        self
    }

    /// Bytes that a solver holds for a grid of some size: for itself, and for each batch that is
    /// computed at the same time.
    pub fn bytes(chart: Chart, wavefront: Wavefront) -> (usize, usize) {
        match wavefront {
            Wavefront::Planar => Scans::<Planar>::bytes(chart),
            Wavefront::PointSource => Scans::<PointSource>::bytes(chart),
            Wavefront::Curved | Wavefront::Anchored => Scans::<Curved>::bytes(chart),
        }
    }

    /// Computes the distances from at most [`Self::LANES`] grid points, given by their index, to
    /// all points: a row of `into` for each, +infinity where a source does not reach. `None` is no
    /// source and leaves a row of +infinity: give it for holes.
    ///
    /// # Panics
    /// If there are more sources, or `into` does not have as many rows of as many points.
    pub fn solve(&self, sources: &[Option<usize>], stop: Stop, into: &mut [f32]) -> Convergence {
        self.solve_from(sources, Known::NOTHING, stop, &mut self.rows(into))
    }

    /// The same with rows anywhere in memory, and only for the sources that have one.
    ///
    /// # Panics
    /// As [`Self::solve`].
    pub fn solve_rows(
        &self,
        sources: &[Option<usize>],
        stop: Stop,
        into: &mut [Option<&mut [f32]>],
    ) -> Convergence {
        self.solve_from(sources, Known::NOTHING, stop, into)
    }

    /// The same for sources that follow one another from `first` on, with the symmetric
    /// initialisation (paper, eq. 20): distances from them to the first points are taken from
    /// `rows`, the distances from those points, and are not computed again. The planar and the
    /// point-source front only, since a curved one would need curvatures there too.
    ///
    /// # Panics
    /// As [`Self::solve`]; if `rows` are not whole rows of the matrix's first `first` ones; and with
    /// the curved wavefront.
    pub fn solve_below(
        &self,
        rows: &[f32],
        first: usize,
        sources: &[Option<usize>],
        stop: Stop,
        into: &mut [f32],
    ) -> Convergence {
        let straight = matches!(self.fronts, Fronts::Planar(_) | Fronts::PointSource(_));
        assert!(straight, "curvatures are not known");
        let count = rows.len() / self.chart.points();
        assert!(rows.len().is_multiple_of(self.chart.points()) && count <= first, "rows before");
        let follow = |(lane, source): (usize, &Option<usize>)| {
            source.is_none_or(|source| source == first + lane)
        };
        assert!(sources.iter().enumerate().all(follow), "sources follow one another");
        self.solve_from(sources, Known { rows, count, column: first }, stop, &mut self.rows(into))
    }

    fn rows<'a>(&self, matrix: &'a mut [f32]) -> Vec<Option<&'a mut [f32]>> {
        let points = self.chart.points();
        assert!(matrix.len().is_multiple_of(points), "whole rows");
        matrix.chunks_exact_mut(points).map(Some).collect()
    }

    fn solve_from(
        &self,
        sources: &[Option<usize>],
        known: Known,
        stop: Stop,
        into: &mut [Option<&mut [f32]>],
    ) -> Convergence {
        assert!(sources.len() <= LANES, "a batch has at most {LANES} sources");
        assert_eq!(into.len(), sources.len(), "a row for each source");
        let points = self.chart.points();
        assert!(into.iter().flatten().all(|row| row.len() == points), "rows of {points} points");
        let instructions = self.instructions;
        match &self.fronts {
            Fronts::Planar(scans) => scans.solve(sources, known, stop, instructions, into),
            Fronts::PointSource(scans) => scans.solve(sources, known, stop, instructions, into),
            Fronts::Curved(scans) => scans.solve(sources, known, stop, instructions, into),
            Fronts::Anchored(edges) => self.solve_each(edges, sources, stop, into),
        }
    }

    fn solve_each(
        &self,
        edges: &EdgeLengths<f32>,
        sources: &[Option<usize>],
        stop: Stop,
        into: &mut [Option<&mut [f32]>],
    ) -> Convergence {
        let solver = RotatedScan::new(edges, Wavefront::Anchored);
        let mut solver = solver.with_instructions(self.instructions);
        let mut all = Convergence { iterations: 0, residual: 0.0 };
        for (source, row) in sources.iter().zip(into) {
            let Some(row) = row else { continue };
            row.fill(f32::INFINITY);
            let Some((row_of, col)) = source.map(|point| self.chart.position(point)) else {
                continue;
            };
            let found = solver.solve(&[Seed::at_source(row_of, col, 0.0)], stop);
            row.copy_from_slice(&solver.distances());
            all.iterations = all.iterations.max(found.iterations);
            all.residual = all.residual.max(found.residual);
        }
        all
    }
}

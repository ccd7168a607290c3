//! Measures edges and curvatures beside seams where the grid goes on.
//!
//! Near a side, arcs and curvatures depend on points beyond it. A strip of the grid across the seam has them
//! all. It is measured like any surface, and its values beside the seam take the place of those of the grid.

use std::ops::Range;

use glam::DVec3;

use super::super::chart::{Block, STORED};
use super::super::{EdgeLengths, Real, Surface, SurfaceError};
use super::lattice::Lattice;

/// Number of lines beside a seam whose edges and curvatures depend on points beyond it.
const DEPTH: usize = 3;
/// Number of further lines on which these depend.
const MARGIN: usize = 5;

/// Strips of the grid across its seams.
#[derive(Clone, Debug)]
pub(in super::super) struct Strips<R>(Vec<Strip<R>>);

impl<R> Default for Strips<R> {
    fn default() -> Self {
        Self(Vec::new())
    }
}

#[derive(Clone, Debug)]
struct Strip<R> {
    edges: EdgeLengths<R>,
    /// Row and column of the strip's first point.
    first: (isize, isize),
    /// The points of the grid whose values the strip has.
    block: Block,
}

impl<R: Real> Strip<R> {
    /// Returns the index of a grid point in the strip's bordered arrays.
    fn index(&self, (row, col): (usize, usize)) -> usize {
        let (row, col) = (row as isize - self.first.0, col as isize - self.first.1);
        self.edges.chart().bordered(row as usize, col as usize)
    }
}

impl<R: Real> Strips<R> {
    /// Measures the strips of a surface, with positions relative to `origin`.
    pub(in super::super) fn measure(
        surface: &Surface,
        origin: DVec3,
    ) -> Result<Self, SurfaceError> {
        let Some(glued) = &surface.glued else { return Ok(Self::default()) };
        let (chart, Lattice { cols, rows, .. }) = (surface.chart(), glued.lattice);
        let across = |lines: usize| [0..DEPTH.min(lines), lines.saturating_sub(DEPTH)..lines];
        let blocks_of =
            |is_glued: bool, blocks: [Block; 2]| blocks.into_iter().filter(move |_| is_glued);
        let of_cols = across(chart.cols).map(|cols| Block { rows: 0..chart.rows, cols });
        let of_rows = across(chart.rows).map(|rows| Block { rows, cols: 0..chart.cols });
        let blocks = blocks_of(cols.is_some(), of_cols).chain(blocks_of(rows.is_some(), of_rows));
        let strip = |block: Block| {
            let around = |range: &Range<usize>| {
                range.start as isize - MARGIN as isize..(range.end + MARGIN) as isize
            };
            let (rows, cols) = (around(&block.rows), around(&block.cols));
            let first = (rows.start, cols.start);
            let part = surface.beyond(&glued.lattice, rows, cols);
            Ok(Strip {
                edges: EdgeLengths::measured_from(&part, origin, || Ok::<_, SurfaceError>(()))?
                    .of_glued(),
                first,
                block,
            })
        };
        Ok(Self(blocks.map(strip).collect::<Result<_, SurfaceError>>()?))
    }

    /// Replaces the lengths of the edges beside seams. `lengths` are bordered arrays of the whole grid.
    pub(in super::super) fn replace_lengths(&self, surface: &Surface, lengths: &mut [Vec<R>; 4]) {
        let chart = surface.chart();
        for strip in &self.0 {
            for (row, col) in strip.block.places() {
                let (point, there) = (chart.bordered(row, col), strip.index((row, col)));
                for ((lengths, of_strip), to) in
                    lengths.iter_mut().zip(strip.edges.planes()).zip(STORED)
                {
                    if chart.neighbour(row, col, to).is_some() {
                        lengths[point] = of_strip[there];
                    }
                }
            }
        }
    }

    /// Replaces the Gaussian curvature beside seams, in a bordered array of the whole grid.
    pub(in super::super) fn replace_curvature(&self, whole: &EdgeLengths<R>, curvature: &mut [R]) {
        for strip in &self.0 {
            let of_strip = strip.edges.gaussian_curvature();
            for (row, col) in strip.block.places() {
                curvature[whole.chart().bordered(row, col)] = of_strip[strip.index((row, col))];
            }
        }
    }

    /// Returns the number of bytes held.
    pub(in super::super) fn bytes(&self) -> usize {
        self.0.iter().map(|strip| strip.edges.bytes()).sum()
    }
}

impl Surface {
    /// Returns some rows and columns of the grid as an open surface. They may lie beyond the sides; where the
    /// grid does not go on there, the surface has holes.
    pub(super) fn beyond(&self, lattice: &Lattice, rows: Range<isize>, cols: Range<isize>) -> Self {
        let chart = super::super::Chart { rows: rows.len(), cols: cols.len() };
        let points: Vec<_> = rows
            .flat_map(|row| cols.clone().map(move |col| (row, col)))
            .map(|(row, col)| lattice.at(self.chart, row, col))
            .map(|at| at.map(|(row, col)| self.chart.index(row, col)))
            .collect();
        Self {
            chart,
            inputs: self.inputs.gathered(&points),
            edge_rule: self.edge_rule,
            floor: Default::default(),
            glued: None,
        }
    }
}

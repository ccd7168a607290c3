//! Measures edges and curvatures beside seams where the grid goes on.
//!
//! Near a side, arcs and curvatures depend on points beyond it. A strip of the grid across the seam contains
//! all these points. The strip is measured like any surface, and its values replace the grid's own values
//! beside the seam.

use std::ops::Range;
use std::sync::Arc;

use rayon::prelude::*;

use super::super::chart::{Block, Chart, STORED};
use super::super::edges::Strip;
use super::super::{EdgeLengths, Real, Surface};
use super::lattice::Lattice;

/// Number of lines beside a seam whose edges and curvatures depend on points beyond it.
const DEPTH: usize = 3;
/// Number of further lines on which these edges and curvatures depend.
const MARGIN: usize = 5;
/// Number of columns of a strip along columns: `DEPTH + 2 * MARGIN` at least, and whole vectors of the widest
/// instructions. Rows of fewer points would be measured one point at a time.
const COLUMNS: usize = 16;

impl<R: Real> Strip<R> {
    /// Returns the index of a grid point in the strip's bordered arrays.
    fn index(&self, (row, col): (usize, usize)) -> usize {
        let (row, col) = (row as isize - self.first.0, col as isize - self.first.1);
        self.edges.chart().bordered(row as usize, col as usize)
    }
}

/// Measures the strips of a surface across its seams. `open` measures an open surface.
pub(in super::super) fn measured<R: Real, E>(
    surface: &Surface,
    open: impl Fn(&Surface) -> Result<EdgeLengths<R>, E>,
) -> Result<Vec<Strip<R>>, E> {
    let Some(glued) = &surface.glued else { return Ok(Vec::new()) };
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
        let (rows, mut cols) = (around(&block.rows), around(&block.cols));
        cols.end = cols.end.max(cols.start + COLUMNS as isize);
        let first = (rows.start, cols.start);
        let part = surface.beyond(&glued.lattice, rows, cols);
        Ok(Strip { edges: open(&part)?.of_glued(), first, block })
    };
    blocks.map(strip).collect()
}

/// Replaces the lengths of the edges beside seams. `lengths` are bordered arrays of the whole grid.
pub(in super::super) fn replace_lengths<R: Real>(
    strips: &[Strip<R>],
    chart: Chart,
    lengths: &mut [Vec<R>; 4],
) {
    for strip in strips {
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

impl<R: Real> EdgeLengths<R> {
    /// Returns these edges as those of a strip of a glued surface.
    fn of_glued(mut self) -> Self {
        let shared = Arc::get_mut(&mut self.shared);
        shared.expect("edges that have just been measured have no clones").of_glued = true;
        self
    }

    /// Corrects the Gaussian curvature of a glued surface beside its seams. `curvature` is a bordered array.
    pub(in super::super) fn across_seams(&self, curvature: &mut [R]) {
        if !self.shared.of_glued {
            return;
        }
        // Enters the thread pool once, and not for each loop over a strip.
        self.shared.strips.par_iter().for_each(|strip| {
            strip.edges.gaussian_curvature();
        });
        for strip in &self.shared.strips {
            let of_strip = strip.edges.gaussian_curvature();
            for (row, col) in strip.block.places() {
                curvature[self.chart().bordered(row, col)] = of_strip[strip.index((row, col))];
            }
        }
        self.share_curvature(curvature);
    }
}

impl Surface {
    /// Returns some rows and columns of the grid as an open surface. These lines may lie beyond the sides;
    /// where the grid does not go on there, the surface has holes.
    pub(super) fn beyond(&self, lattice: &Lattice, rows: Range<isize>, cols: Range<isize>) -> Self {
        let chart = Chart { rows: rows.len(), cols: cols.len() };
        let places = rows.flat_map(|row| cols.clone().map(move |col| (row, col)));
        let points = places.map(|(row, col)| lattice.at(self.chart, row, col));
        self.part(chart, points.map(|at| at.map(|(row, col)| self.chart.index(row, col))))
    }
}

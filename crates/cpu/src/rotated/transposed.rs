//! Transposes columns of the grid into lines: computes the source and destination of each block of entries.

use std::ops::Range;

use bytemuck::Pod;
use rayon::prelude::*;

use super::transpose::{Turned, transpose};
use crate::Instructions;
use crate::lines::span::TILE;
use crate::lines::window::Window;
use geosweep_surface::{Chart, EdgeLengths, Real};

/// Lengths of the edges from each point of a column to three points of the column before: in the same row, in the next
/// and in the previous one. Storing these lengths pays off for solvers of many maps: a scan to the right or left
/// otherwise spends a third of its time on transposing these lengths.
#[derive(Clone, Debug)]
pub(crate) struct TransposedEdges<R> {
    /// Distance in memory from a line to the next.
    stride: usize,
    edges: [Vec<R>; 3],
    is_filled: bool,
}

impl<R: Real> TransposedEdges<R> {
    /// Allocates memory for the edges of a surface. Zeroed memory takes no time and no physical memory before
    /// it is written.
    pub(crate) fn new(chart: Chart) -> Self {
        let lines = chart.transposed();
        let edges = [(); 3].map(|_| vec![R::zero(); lines.bordered_points()]);
        Self { stride: lines.stride(), edges, is_filled: false }
    }

    /// Transposes all edges, in parallel over columns, unless this has been done.
    pub(crate) fn fill(&mut self, edges: &EdgeLengths<R>, instructions: Instructions) {
        if std::mem::replace(&mut self.is_filled, true) {
            return;
        }
        let (chart, stride) = (edges.chart(), self.stride);
        let [up, up_next, up_previous] =
            self.edges.each_mut().map(|array| array.par_chunks_mut(TILE * stride));
        (up, up_next, up_previous).into_par_iter().enumerate().for_each(
            |(band, (up, up_next, up_previous))| {
                let (first, count) = (band * TILE, up.len() / stride);
                let window = Window::whole(chart);
                let lines = ColumnsToLines { window, first, count, instructions };
                // There is no column before the border.
                let skip = if band == 0 { 1 } else { 0 };
                let to = [up, up_next, up_previous];
                lines.transpose_edges_back(edges, to, skip, 0..chart.rows);
            },
        );
    }

    /// Returns these edges once they have been transposed.
    pub(crate) fn filled(&self) -> Option<&Self> {
        self.is_filled.then_some(self)
    }

    /// Returns the lines from column `first` on, counted from the border.
    pub(crate) fn lines(&self, first: usize) -> [&[R]; 3] {
        self.edges.each_ref().map(|edges| &edges[first * self.stride..])
    }

    /// Returns the number of bytes held.
    pub(crate) fn bytes(&self) -> usize {
        self.edges.iter().map(|edges| std::mem::size_of_val(edges.as_slice())).sum()
    }
}

/// A range of columns of a window's bordered arrays, which become lines of other arrays.
#[derive(Clone, Copy)]
pub(crate) struct ColumnsToLines {
    pub window: Window,
    /// The column of the first line, counted from the border, and the number of lines.
    pub first: usize,
    pub count: usize,
    pub instructions: Instructions,
}

impl ColumnsToLines {
    /// Transposes `rows` of an array, counted from the border, and skips the first `skip` lines. Each entry is read
    /// `down` rows below and `left` columns to the left of its position.
    pub(crate) fn transpose<T: Pod>(
        self,
        from: &[T],
        to: &mut [T],
        skip: usize,
        rows: Range<usize>,
        [down, left]: [usize; 2],
    ) {
        let from_stride = self.window.own().stride();
        let to_stride = self.window.grid().transposed().stride();
        let (row, col) = self.window.first();
        let block = Turned {
            from: (rows.start + down - row) * from_stride + self.first + skip - left - col,
            from_stride,
            to: skip * to_stride + rows.start,
            to_stride,
            rows: rows.len(),
            cols: self.count - skip,
        };
        transpose(from, to, block, self.instructions);
    }

    /// Transposes the lengths of the edges that lead to the previous column, for some rows.
    pub(crate) fn transpose_edges_back<R: Real>(
        self,
        edges: &EdgeLengths<R>,
        [up, up_next, up_previous]: [&mut [R]; 3],
        skip: usize,
        rows: Range<usize>,
    ) {
        // North in the transposed grid is west in the grid. The edge to the west is stored as the east edge of the
        // western neighbour. North-east in the transposed grid is south-west in the grid. The edge to the south-west
        // is stored as the north-east edge of the south-western neighbour. North-west is the same in both grids.
        let [east, _, north_east, north_west] = edges.planes();
        let Range { start, end } = rows;
        self.transpose(east, up, skip, start + 1..end + 1, [0, 1]);
        self.transpose(north_east, up_next, skip, start..end + 1, [1, 1]);
        self.transpose(north_west, up_previous, skip, start + 1..end + 2, [0, 0]);
    }
}

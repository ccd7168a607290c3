//! The grid's columns as lines: which entries of an array a transposition brings where.

use std::ops::Range;

use rayon::prelude::*;

use super::Instructions;
use super::tiles::TILE;
use super::transpose::{Block, transpose};
use crate::surface::{EdgeLengths, Real};

/// The lengths of the edges from each point of a column to the column before: to the same row, the next and
/// the previous one. For whoever scans many times, since a third of the time of a scan to the right or
/// left goes into transposing them.
#[derive(Clone, Debug)]
pub(super) struct Turned<R> {
    stride: usize,
    edges: [Vec<R>; 3],
}

impl<R: Real> Turned<R> {
    /// Turns all edges of a surface, in parallel over columns.
    pub(super) fn new(edges: &EdgeLengths<R>, instructions: Instructions) -> Self {
        let (chart, from_stride) = (edges.chart(), edges.chart().stride());
        let stride = chart.rows + 2;
        // Zeros come without work; every entry that is read is written below, by many threads at once.
        let mut turned = [(); 3].map(|_| vec![R::zero(); from_stride * stride]);
        let [up, up_next, up_previous] =
            turned.each_mut().map(|array| array.par_chunks_mut(TILE * stride));
        (up, up_next, up_previous).into_par_iter().enumerate().for_each(
            |(band, (up, up_next, up_previous))| {
                let (first, count) = (band * TILE, up.len() / stride);
                let lines = Lines { from_stride, to_stride: stride, first, count, instructions };
                // Nothing lies before the border.
                let skip = if band == 0 { 1 } else { 0 };
                let to = [up, up_next, up_previous];
                lines.turn_edges_back(edges, to, skip, 0..chart.rows, false);
            },
        );
        Self { stride, edges: turned }
    }

    /// The lines from a column on, counted from the border.
    pub(super) fn lines(&self, first: usize) -> [&[R]; 3] {
        self.edges.each_ref().map(|edges| &edges[first * self.stride..])
    }

    /// Bytes held.
    pub(super) fn bytes(&self) -> usize {
        self.edges.iter().map(|edges| std::mem::size_of_val(edges.as_slice())).sum()
    }
}

/// Columns of bordered arrays from one on, which become the lines of others.
#[derive(Clone, Copy)]
pub(super) struct Lines {
    pub from_stride: usize,
    pub to_stride: usize,
    /// The column of the first line, counted from the border, and the number of lines.
    pub first: usize,
    pub count: usize,
    pub instructions: Instructions,
}

impl Lines {
    /// Turns rows of an array, counted from the border, but for the first lines; each entry lies so far
    /// down and left of where it belongs.
    pub(super) fn turn<R: Real>(
        self,
        from: &[R],
        to: &mut [R],
        skip: usize,
        rows: Range<usize>,
        [down, left]: [usize; 2],
    ) {
        let block = Block {
            from: (rows.start + down) * self.from_stride + self.first + skip - left,
            from_stride: self.from_stride,
            to: skip * self.to_stride + rows.start,
            to_stride: self.to_stride,
            rows: rows.len(),
            cols: self.count - skip,
        };
        transpose(from, to, block, self.instructions);
    }

    /// Turns the edges back of some rows, and for arcs of the points beside them.
    pub(super) fn turn_edges_back<R: Real>(
        self,
        edges: &EdgeLengths<R>,
        [up, up_next, up_previous]: [&mut [R]; 3],
        skip: usize,
        rows: Range<usize>,
        beside: bool,
    ) {
        // A transposition makes north of east, north of west's east, and north-east of
        // south-west, which is stored as the north-east of another point; north-west stays.
        let [east, _, north_east, north_west] = edges.planes();
        let Range { start, end } = rows;
        let points = if beside { start..end + 2 } else { start + 1..end + 1 };
        self.turn(east, up, skip, points, [0, 1]);
        self.turn(north_east, up_next, skip, start..end + 1, [1, 1]);
        self.turn(north_west, up_previous, skip, start + 1..end + 2, [0, 0]);
    }
}

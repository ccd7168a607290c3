//! Columns as rows: a transposed copy of as many columns as a tile is wide, so that scans to the
//! right and left read and write points that lie side by side.

use std::ops::Range;

use super::Instructions;
use super::anchored_scan::{self, Plan};
use super::field::Field;
use super::tiles::{Scan, TILE};
use super::transpose::{Block, transpose};
use super::turned::{Lines, Turned};
use crate::surface::{Chart, EdgeLengths, Real};
use crate::update::Wavefront;

/// Up to [`TILE`] columns of bordered arrays and the one behind them, turned by a transposition into lines.
#[derive(Clone, Debug)]
pub(super) struct Panel<R> {
    stride: usize,
    times: Vec<R>,
    curvatures: Vec<R>,
    gaussian: Vec<R>,
    edges: [Vec<R>; 4],
    /// The first column, counted from the border, and the number of lines.
    first: usize,
    lines: usize,
}

/// The arrays of the grid that a panel is loaded from.
#[derive(Clone, Copy)]
pub(super) struct Grid<'a, R> {
    pub edges: &'a EdgeLengths<R>,
    /// The edges back of its columns, if they are kept.
    pub turned: Option<&'a Turned<R>>,
    pub gaussian: &'a [R],
}

impl<R: Real> Panel<R> {
    pub(super) fn new(chart: Chart, wavefront: Wavefront) -> Self {
        let stride = chart.rows + 2;
        // One more, to which edges of the last point reach.
        let array = || vec![R::FAR; (TILE + 1) * stride + 1];
        let anchored = wavefront == Wavefront::Anchored;
        let if_curved = || if wavefront.has_two_layers() { array() } else { Vec::new() };
        Self {
            stride,
            times: array(),
            curvatures: if_curved(),
            gaussian: if_curved(),
            // Anchors need none.
            edges: [(); 4].map(|_| if anchored { Vec::new() } else { array() }),
            first: 0,
            lines: 0,
        }
    }

    /// Frees the room for edges that are kept in [`Turned`].
    pub(super) fn free_edges_back(&mut self) {
        let [_, back @ ..] = &mut self.edges;
        *back = [(); 3].map(|_| Vec::new());
    }

    /// Bytes held.
    pub(super) fn bytes(&self) -> usize {
        let arrays = [&self.times, &self.curvatures, &self.gaussian].into_iter().chain(&self.edges);
        arrays.map(|array| std::mem::size_of_val(array.as_slice())).sum()
    }

    /// Copies rows of the columns of a band, and what their update needs around them.
    pub(super) fn load(
        &mut self,
        grid: Grid<R>,
        [times, curvatures]: [&[R]; 2],
        cols: &Range<usize>,
        rows: Range<usize>,
        scan: Scan,
        instructions: Instructions,
    ) {
        let (chart, curved) = (grid.edges.chart(), !curvatures.is_empty());
        // Counted from the border, column c is 1 + c, and the one behind lies before or after.
        self.first = if scan.is_forward() { cols.start } else { cols.start + 1 };
        self.lines = cols.len() + 1;
        let lines = Lines {
            from_stride: chart.stride(),
            to_stride: self.stride,
            first: self.first,
            count: self.lines,
            instructions,
        };
        let around = rows.start..rows.end + 2;
        lines.turn(times, &mut self.times, 0, around.clone(), [0, 0]);
        if curved {
            lines.turn(curvatures, &mut self.curvatures, 0, around.clone(), [0, 0]);
            lines.turn(grid.gaussian, &mut self.gaussian, 0, around, [0, 0]);
        }
        if self.edges[0].is_empty() {
            return;
        }
        let [next, back @ ..] = &mut self.edges;
        let [_, north, ..] = grid.edges.planes();
        lines.turn(north, next, 0, rows.start..rows.end + 1, [1, 0]);
        if grid.turned.is_none() {
            let back = back.each_mut().map(Vec::as_mut_slice);
            lines.turn_edges_back(grid.edges, back, 1, rows);
        }
    }

    /// The columns as lines.
    pub(super) fn field<'a>(&'a mut self, grid: Grid<'a, R>) -> Field<'a, R> {
        let [next, back @ ..] = &self.edges;
        let [up, up_next, up_previous] = match grid.turned {
            Some(turned) => turned.lines(self.first),
            None => back.each_ref().map(Vec::as_slice),
        };
        Field {
            stride: self.stride,
            times: &mut self.times,
            curvatures: &mut self.curvatures,
            gaussian: &self.gaussian,
            edges: [next, up, up_next, up_previous],
        }
    }

    /// The columns as lines of a floor plan, with some of their rows.
    pub(super) fn lines<'a>(
        &'a mut self,
        plan: &'a Plan<R>,
        chart: Chart,
        rows: Range<usize>,
        beyond: [&'a [R]; 2],
    ) -> anchored_scan::Lines<'a, R> {
        let held = ..self.lines * self.stride;
        anchored_scan::Lines {
            plan,
            chart,
            times: &mut self.times[held],
            anchors: &mut self.curvatures[held],
            holes: &self.gaussian[held],
            stride: self.stride,
            first: self.first,
            beyond: Some((rows.start + 1..rows.end + 1, beyond)),
        }
    }

    /// The line of a column, both counted from the border.
    pub(super) fn line(&self, col: usize) -> usize {
        col - self.first
    }

    /// Copies rows of the columns of a band back.
    pub(super) fn store(
        &self,
        [times, curvatures]: [&mut [R]; 2],
        to_stride: usize,
        cols: &Range<usize>,
        rows: Range<usize>,
        instructions: Instructions,
    ) {
        let block = Block {
            from: self.line(cols.start + 1) * self.stride + rows.start + 1,
            from_stride: self.stride,
            to: (rows.start + 1) * to_stride + cols.start + 1,
            to_stride,
            rows: cols.len(),
            cols: rows.len(),
        };
        transpose(&self.times, times, block, instructions);
        if !curvatures.is_empty() {
            transpose(&self.curvatures, curvatures, block, instructions);
        }
    }
}

//! Panels: transposed copies of as many columns as a tile is wide. With them, scans to the right and left read and
//! write points that are adjacent in memory.

use std::ops::Range;

use super::transpose::{Turned, transpose};
use super::transposed::{ColumnsToLines, TransposedEdges};
use crate::Instructions;
use crate::behind::Behind;
use crate::lines::line::{Beyond, GridLines, LinesInGrid};
use crate::lines::span::TILE;
use crate::lines::window::{Fronts, Window};
use crate::scan::Scan;
use geosweep_surface::update::Carried;
use geosweep_surface::{Block, Chart, EdgeLengths, Real};

/// Up to [`TILE`] columns of bordered arrays and the column behind them, transposed into lines.
#[derive(Clone, Debug)]
pub(crate) struct Panel<R, C, G> {
    /// Distance in memory from a line to the next.
    stride: usize,
    times: Vec<R>,
    carried: Vec<C>,
    surface_data: Vec<G>,
    /// Edge lengths; empty where they are not needed.
    edges: [Vec<R>; 4],
    /// The first column, counted from the border, and the number of lines.
    first: usize,
    lines: usize,
}

/// The surface data of the grid.
#[derive(Clone, Copy)]
pub(crate) struct Grid<'a, R, G> {
    pub edges: &'a EdgeLengths<R>,
    /// Transposed edges from each column to the column before it, if they are stored.
    pub transposed: Option<&'a TransposedEdges<R>>,
    pub surface_data: &'a [G],
}

impl<R: Real, C: Carried, G: bytemuck::Pod> Panel<R, C, G> {
    pub(crate) fn new(chart: Chart, needs_edges: bool) -> Self {
        let stride = chart.transposed().stride();
        // The edges of the last point reach one entry beyond the lines.
        let points = (TILE + 1) * stride + 1;
        Self {
            stride,
            times: vec![R::FAR; points],
            carried: vec![C::default(); points],
            surface_data: vec![G::zeroed(); points],
            edges: [(); 4].map(|_| vec![R::FAR; if needs_edges { points } else { 0 }]),
            first: 0,
            lines: 0,
        }
    }

    /// Frees the memory of the edges that [`TransposedEdges`] stores.
    pub(crate) fn free_edges_back(&mut self) {
        let [_, back @ ..] = &mut self.edges;
        *back = [(); 3].map(|_| Vec::new());
    }

    /// Returns the number of bytes held.
    pub(crate) fn bytes(&self) -> usize {
        let edges = self.edges.iter().map(|array| std::mem::size_of_val(array.as_slice()));
        std::mem::size_of_val(self.times.as_slice())
            + std::mem::size_of_val(self.carried.as_slice())
            + std::mem::size_of_val(self.surface_data.as_slice())
            + edges.sum::<usize>()
    }

    /// Copies points of a band of columns, and the data around them that their update needs.
    pub(crate) fn load(
        &mut self,
        grid: Grid<R, G>,
        Fronts { window, times, carried }: Fronts<R, C>,
        Block { rows, cols }: &Block,
        scan: Scan,
        instructions: Instructions,
    ) {
        let chart = grid.edges.chart();
        // Counted from the border, column c has the number c + 1. The panel also holds the column behind: the one
        // before the first column, or in a backward scan the one after the last.
        self.first = if scan.is_forward() { cols.start } else { cols.start + 1 };
        self.lines = cols.len() + 1;
        let from =
            |window| ColumnsToLines { window, first: self.first, count: self.lines, instructions };
        let (fronts, lines) = (from(window), from(Window::whole(chart)));
        let around = rows.start..rows.end + 2;
        fronts.transpose(times, &mut self.times, 0, around.clone(), [0, 0]);
        fronts.transpose(carried, &mut self.carried, 0, around.clone(), [0, 0]);
        lines.transpose(grid.surface_data, &mut self.surface_data, 0, around, [0, 0]);
        if self.edges[0].is_empty() {
            return;
        }
        let [next, back @ ..] = &mut self.edges;
        let [_, north, ..] = grid.edges.planes();
        lines.transpose(north, next, 0, rows.start..rows.end + 1, [1, 0]);
        if grid.transposed.is_none() {
            let back = back.each_mut().map(Vec::as_mut_slice);
            lines.transpose_edges_back(grid.edges, back, 1, rows.clone());
        }
    }

    /// Returns the columns as lines, of which the panel has the points in `rows`.
    pub(crate) fn lines<'a>(
        &'a mut self,
        grid: Grid<'a, R, G>,
        [near, far]: [Option<Fronts<'a, R, C>>; 2],
        rows: &Range<usize>,
        scan: Scan,
    ) -> GridLines<'a, R, C, G> {
        let chart = grid.edges.chart();
        let turned = chart.transposed();
        let [next, back @ ..] = &self.edges;
        let [up, up_next, up_previous] = match grid.transposed {
            Some(transposed) => transposed.lines(self.first),
            None => back.each_ref().map(Vec::as_slice),
        };
        let held = ..self.lines * self.stride;
        GridLines {
            behind: Behind::of(turned, scan.over_lines()),
            times: &mut self.times[held],
            carried: &mut self.carried[held],
            surface_data: &self.surface_data[held],
            edges: [next, up, up_next, up_previous],
            surface: (self.stride, 0),
            place: LinesInGrid {
                edges: grid.edges,
                scan,
                stride: self.stride,
                first: self.first,
                before: 0,
                beyond: Some(Beyond {
                    points: rows.start + 1..rows.end + 1,
                    lines: self.first..self.first + self.lines,
                    near,
                    far,
                }),
            },
        }
    }

    /// Copies points of a band of columns back into the grid.
    pub(crate) fn store(
        &self,
        (times, carried): (&mut [R], &mut [C]),
        window: Window,
        Block { rows, cols }: Block,
        instructions: Instructions,
    ) {
        let block = Turned {
            from: (cols.start + 1 - self.first) * self.stride + rows.start + 1,
            from_stride: self.stride,
            to: window.index(rows.start, cols.start),
            to_stride: window.own().stride(),
            rows: cols.len(),
            cols: rows.len(),
        };
        transpose(&self.times, times, block, instructions);
        transpose(&self.carried, carried, block, instructions);
    }
}

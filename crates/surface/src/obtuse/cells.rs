//! Marks the cells in which a triangle may be obtuse, while edges are measured.

use std::ops::Range;

use rayon::prelude::*;

use super::reach::reach;
use crate::chart::{Chart, Direction};
use crate::constants::OBTUSE;
use crate::lanes::{Instructions, Loop};
use crate::real::Real;

/// Number of adjacent cells of a row that are marked together.
pub(super) const CELLS: usize = 32;

/// Marks of groups of [`CELLS`] adjacent cells of a row. A mark says whether a triangle of the group may be obtuse.
/// Marks are set while edges are measured, which costs less than to read all edges again.
#[derive(Clone, Debug)]
pub(crate) struct MarkedCells {
    /// Number of marks in a row of cells. Row r of cells lies between the points of rows r - 1 and r, unlike in
    /// [`Chart::rows_of_cells`].
    in_row: usize,
    pub(super) marks: Vec<bool>,
}

impl MarkedCells {
    pub(crate) fn none(chart: Chart) -> Self {
        let in_row = chart.cols.div_ceil(CELLS);
        Self { in_row, marks: vec![false; chart.rows * in_row] }
    }

    /// Returns the marks of each row of cells.
    pub(crate) fn rows_mut(&mut self) -> impl IndexedParallelIterator<Item = &mut [bool]> {
        self.marks.par_chunks_mut(self.in_row)
    }

    pub(crate) fn any(&self) -> bool {
        self.marks.contains(&true)
    }

    /// Returns the ranges, within a row of `points` points, of the corners of marked cells.
    pub(super) fn ranges(&self, row: usize, points: usize) -> Vec<Range<usize>> {
        let of_cells = |row: usize| self.marks.get(row * self.in_row..(row + 1) * self.in_row);
        let rows = [of_cells(row), of_cells(row + 1)];
        let is_marked = |at: usize| rows.iter().flatten().any(|marks| marks[at]);
        let mut ranges: Vec<Range<usize>> = Vec::new();
        for at in (0..self.in_row).filter(|&at| is_marked(at)) {
            // The last of these cells has its right corners at the next point.
            let range = at * CELLS..((at + 1) * CELLS + 1).min(points);
            match ranges.last_mut() {
                Some(last) if last.end >= range.start => last.end = range.end,
                _ => ranges.push(range),
            }
        }
        ranges
    }
}

/// A search for obtuse triangles while rows are measured one after another.
pub(crate) struct RowAbove<R> {
    /// Lengths of the edges along the row above.
    east: Vec<R>,
    /// Marks of the cells between the last two rows, as in [`MarkedCells`].
    pub(crate) marks: Vec<bool>,
    /// Largest reach of the splits of all rows so far.
    pub(crate) reach: usize,
}

impl<R: Real> RowAbove<R> {
    /// Returns the state before the first row.
    pub(crate) fn none(cols: usize) -> Self {
        Self { east: vec![R::FAR; cols], marks: vec![false; cols.div_ceil(CELLS)], reach: 1 }
    }

    /// Checks the triangles between the row above and the next row, given the edges stored at the points of the next
    /// row.
    pub(crate) fn next(&mut self, [east, north, north_east, north_west]: &[Vec<R>; 4]) {
        let Self { east: above, marks, reach } = self;
        let mut cells = Cells { above, east, north, north_east, north_west, marks };
        Instructions::best().run(cells.again());
        if cells.marks.contains(&true) {
            *reach = cells.reach().max(*reach);
        }
        above.copy_from_slice(east);
    }
}

/// The cells between two rows of points. The lower row stores the edges between both.
struct Cells<'a, R> {
    above: &'a [R],
    east: &'a [R],
    north: &'a [R],
    north_east: &'a [R],
    north_west: &'a [R],
    marks: &'a mut [bool],
}

impl<R: Real> Cells<'_, R> {
    fn again(&mut self) -> Cells<'_, R> {
        Cells { marks: self.marks, ..*self }
    }

    /// Returns the largest reach of a split in marked cells.
    fn reach(&self) -> usize {
        let count = self.east.len().saturating_sub(1);
        let marked = self.marks.iter().enumerate().filter(|(_, mark)| **mark);
        let cells = marked.flat_map(|(at, _)| at * CELLS..((at + 1) * CELLS).min(count));
        let of_cell = |col: usize| {
            let square = |length: R| length * length;
            let (above, east) = (square(self.above[col]), square(self.east[col]));
            let (left, right) = (square(self.north[col]), square(self.north[col + 1]));
            let (rising, falling) =
                (square(self.north_east[col]), square(self.north_west[col + 1]));
            let corner = |diagonal: R, step: Direction, side: R, along: Direction, base: R| {
                reach([step, along].map(Direction::vector), [diagonal, side, base])
            };
            // A step at one end of a diagonal is the opposite of a step at the other end.
            let (up, down) = (Direction::NorthEast, Direction::SouthEast);
            let across = [(rising, up, Direction::North), (falling, down, Direction::South)];
            let ends = across.into_iter().zip([[left, right], [right, left]]);
            let corners = ends.flat_map(|((diagonal, step, aside), [near, far])| {
                let horizontal = [(east, far), (above, near)];
                let vertical = [(near, above), (far, east)];
                let along = |to| move |(side, base)| corner(diagonal, step, side, to, base);
                horizontal.map(along(Direction::East)).into_iter().chain(vertical.map(along(aside)))
            });
            corners.max().unwrap_or(1)
        };
        cells.map(of_cell).max().unwrap_or(1)
    }
}

impl<R: Real> Loop for Cells<'_, R> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let cells = self.east.len().saturating_sub(1);
        let (above, east) = (&self.above[..cells], &self.east[..cells]);
        let (left, right) = (&self.north[..cells], &self.north[1..][..cells]);
        let (rising, falling) = (&self.north_east[..cells], &self.north_west[1..][..cells]);
        // The limit marks too many triangles rather than too few: shaders test each triangle themselves, and the
        // engines would differ at a missed one.
        let (limit, missing) = (R::of(1.001 * OBTUSE), R::FAR * R::FAR);
        for (at, mark) in self.marks.iter_mut().enumerate() {
            let mut found = false;
            for col in at * CELLS..((at + 1) * CELLS).min(cells) {
                let square = |edges: &[R]| edges[col] * edges[col];
                let (above, east) = (square(above), square(east));
                let (left, right) = (square(left), square(right));
                // The angle at an end of a diagonal: the base joins the other end to another corner.
                let at_end = |diagonal: R, a: R, b: R| (diagonal + a < limit * b) & (b < missing);
                let at_ends = |d: R, a: R, b: R| at_end(d, a, b) | at_end(d, b, a);
                let (rising, falling) = (square(rising), square(falling));
                found |= at_ends(rising, east, right) | at_ends(rising, left, above);
                found |= at_ends(falling, east, left) | at_ends(falling, right, above);
            }
            *mark = found;
        }
    }
}

//! Defines the chart: the shape of a grid of M rows and N columns, and the layout of its points in arrays.
//!
//! North is towards smaller rows and east towards larger columns, as in a picture. This folder contains everything that
//! depends on the grid's shape: which neighbours a point has ([`Chart::neighbour`]), where a line ends
//! ([`Chart::walk`]), the lines, tiles, cells, edges and triangles, and the layout of arrays with a border. Other code
//! queries neighbours here and does not compare indices with the number of rows or columns itself. Gluing
//! (`surface/gluing/`) leaves the chart as it is: copies of a point on a seam are different grid points.

mod block;
mod bordered;
mod cells;
mod direction;
mod edge_slot;
mod lines;
mod offset;
mod side;
mod tiling;
mod triangles;

#[doc(hidden)]
pub use block::Block;
#[doc(hidden)]
pub use cells::{Cell, bilinear, corner_weights, grid_crossings};
pub use direction::Direction;
#[doc(hidden)]
pub use direction::ring;
#[doc(hidden)]
pub use edge_slot::{EdgeSlot, STORED};
#[doc(hidden)]
pub use lines::Lines;
#[doc(hidden)]
pub use offset::Offset;
pub use side::GridSide;
#[doc(hidden)]
pub use tiling::Tiling;
#[doc(hidden)]
pub use triangles::{Edge, triangles};

use std::ops::Range;

use glam::DVec2;

/// Size of the grid. Its methods define the layout of the bordered arrays of the CPU engine.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Chart {
    /// Number of rows, M.
    pub rows: usize,
    /// Number of columns, N.
    pub cols: usize,
}

impl Chart {
    /// Returns the number of grid points, holes included.
    #[inline]
    pub const fn points(self) -> usize {
        self.rows * self.cols
    }

    /// Returns the index of a grid point in a row-major array without border.
    #[inline]
    pub const fn index(self, row: usize, col: usize) -> usize {
        row * self.cols + col
    }

    /// Returns row and column of an index into a row-major array without border.
    #[inline]
    pub const fn position(self, index: usize) -> (usize, usize) {
        (index / self.cols, index % self.cols)
    }

    /// Returns the indices of a row in a row-major array without border.
    #[doc(hidden)]
    #[inline]
    pub const fn row(self, row: usize) -> Range<usize> {
        self.index(row, 0)..self.index(row + 1, 0)
    }

    /// Returns row and column of all grid points, row by row.
    #[doc(hidden)]
    #[inline]
    pub fn places(self) -> impl Iterator<Item = (usize, usize)> + Clone {
        (0..self.rows).flat_map(move |row| (0..self.cols).map(move |col| (row, col)))
    }

    /// Returns the last row and the last column.
    #[doc(hidden)]
    #[inline]
    pub const fn last(self) -> (usize, usize) {
        (self.rows - 1, self.cols - 1)
    }

    /// Returns whether a place lies on the grid: x is its fractional row, y its column.
    #[doc(hidden)]
    #[inline]
    pub fn holds(self, at: DVec2) -> bool {
        let (last_row, last_col) = self.last();
        (0.0..=last_row as f64).contains(&at.x) && (0.0..=last_col as f64).contains(&at.y)
    }

    /// Returns the grid point at a row and column, or `None` if these lie off the grid.
    #[inline]
    #[doc(hidden)]
    pub fn at(self, row: isize, col: isize) -> Option<(usize, usize)> {
        let (row, col) = (usize::try_from(row).ok()?, usize::try_from(col).ok()?);
        (row < self.rows && col < self.cols).then_some((row, col))
    }

    /// Returns the neighbour of a grid point, if the grid has it.
    #[inline]
    pub fn neighbour(self, row: usize, col: usize, to: Direction) -> Option<(usize, usize)> {
        self.along((row, col), to, 1)
    }

    /// Returns the grid point `steps` steps away from another one in the direction `to`, or for negative steps in the
    /// opposite direction. Returns `None` off the grid.
    #[doc(hidden)]
    #[inline]
    pub fn along(
        self,
        (row, col): (usize, usize),
        to: Direction,
        steps: isize,
    ) -> Option<(usize, usize)> {
        let (down, right) = to.step();
        self.at(row as isize + steps * down, col as isize + steps * right)
    }

    /// Returns the points from `from` in the direction `to`, up to the end of the grid.
    #[inline]
    pub(crate) fn walk(
        self,
        from: (usize, usize),
        to: Direction,
    ) -> impl Iterator<Item = (usize, usize)> {
        std::iter::successors(Some(from), move |&(row, col)| self.neighbour(row, col, to))
    }

    /// Returns the chart with an additional point between any two neighbours: row r and column c become 2 r
    /// and 2 c.
    #[inline]
    pub(crate) const fn refined(self) -> Self {
        Self { rows: 2 * self.rows - 1, cols: 2 * self.cols - 1 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const CHART: Chart = Chart { rows: 2, cols: 3 };

    #[test]
    fn neighbours_end_at_the_border() {
        assert_eq!(CHART.neighbour(0, 0, Direction::North), None);
        assert_eq!(CHART.neighbour(1, 2, Direction::East), None);
        assert_eq!(CHART.neighbour(1, 2, Direction::NorthWest), Some((0, 1)));
        assert_eq!(CHART.along((0, 2), Direction::West, 2), Some((0, 0)));
        assert_eq!(CHART.along((0, 2), Direction::West, -1), None);
        assert!(CHART.walk((1, 0), Direction::East).eq([(1, 0), (1, 1), (1, 2)]));
        assert!(CHART.walk((1, 0), Direction::NorthEast).eq([(1, 0), (0, 1)]));
    }

    #[test]
    fn places_are_in_the_order_of_their_indices() {
        let (points, last) = (CHART.points(), CHART.last());
        assert!(CHART.places().eq((0..points).map(|index| CHART.position(index))));
        assert!(CHART.places().map(|(row, col)| CHART.index(row, col)).eq(0..points));
        assert_eq!((CHART.row(1), last), (3..6, (1, 2)));
        assert!(CHART.holds(DVec2::new(1.0, 2.0)) && CHART.holds(DVec2::ZERO));
        for outside in [[1.01, 0.0], [0.0, 2.5], [-0.1, 0.0], [f64::NAN, 0.0]] {
            assert!(!CHART.holds(outside.into()));
        }
    }
}

//! Windows: parts of the grid whose fronts are stored in one array. Scans work on windows. The window of a whole map is
//! the grid.
//!
//! Rows, columns and points are always those of the grid. Only this file and [`super::line`] convert them to indices of
//! a window's arrays.

use crate::behind::Behind;
use crate::scan::Scan;
use geosweep_surface::update::{Carried, StoredFront};
use geosweep_surface::{Block, Chart, Offset, Real};

/// A block of the grid whose fronts are stored in a bordered array.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Window {
    /// The chart of the grid, and of the block alone.
    grid: Chart,
    own: Chart,
    /// The first row and column of the block.
    first: (usize, usize),
}

impl Window {
    /// Returns the window of the whole grid.
    pub(crate) fn whole(grid: Chart) -> Self {
        Self { grid, own: grid, first: (0, 0) }
    }

    /// Returns the window of a block of the grid.
    pub(crate) fn new(grid: Chart, block: &Block) -> Self {
        Self { grid, own: block.chart(), first: block.first() }
    }

    /// Returns the chart of the grid.
    pub(crate) fn grid(self) -> Chart {
        self.grid
    }

    /// Returns the chart of the window alone, which defines the layout of its arrays.
    pub(crate) fn own(self) -> Chart {
        self.own
    }

    /// Returns the window's first row and column.
    pub(crate) fn first(self) -> (usize, usize) {
        self.first
    }

    /// Returns the window's points.
    pub(crate) fn block(self) -> Block {
        let (row, col) = self.first;
        Block { rows: row..row + self.own.rows, cols: col..col + self.own.cols }
    }

    /// Returns the index of a point in the window's arrays.
    pub(crate) fn index(self, row: usize, col: usize) -> usize {
        self.own.bordered(row - self.first.0, col - self.first.1)
    }

    /// Returns the neighbours that a scan has just passed, as offsets in the window's arrays.
    pub(crate) fn behind(self, scan: Scan) -> [Offset; 3] {
        Behind::of(self.own, scan).points()
    }
}

/// The fronts at the points of a window.
#[derive(Clone, Copy)]
pub(crate) struct Fronts<'a, R, C> {
    pub window: Window,
    pub times: &'a [R],
    pub carried: &'a [C],
}

impl<R: Real, C: Carried> Fronts<'_, R, C> {
    /// Returns the front at a point of the window.
    #[inline(always)]
    pub(crate) fn of(&self, row: usize, col: usize) -> StoredFront<R, C> {
        let place = self.window.index(row, col);
        StoredFront { time: self.times[place], carried: self.carried[place] }
    }

    /// Returns the front at an entry of the grid's bordered array, given by row and column counted from the border.
    /// Returns `None` if the entry lies outside the window.
    pub(crate) fn at(&self, (row, col): (usize, usize)) -> Option<StoredFront<R, C>> {
        let Window { grid, own, first } = self.window;
        let (row, col) = (row.checked_sub(first.0)?, col.checked_sub(first.1)?);
        // The border around a window inside the grid holds no fronts of the grid's points.
        let is_whole = own == grid;
        let holds = |at: usize, points: usize| is_whole || (1..=points).contains(&at);
        (holds(row, own.rows) && holds(col, own.cols)).then(|| {
            let place = own.entry_index(row, col);
            StoredFront { time: self.times[place], carried: self.carried[place] }
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const GRID: Chart = Chart { rows: 9, cols: 11 };

    #[test]
    fn windows_hold_the_points_of_their_block() {
        let window = Window::new(GRID, &GRID.around((4, 8), 3));
        assert_eq!((window.first(), window.own()), ((1, 5), Chart { rows: 7, cols: 6 }));
        let mut times = vec![f32::FAR; window.own().bordered_points()];
        for (row, col) in window.block().places() {
            times[window.index(row, col)] = GRID.index(row, col) as f32;
        }
        let carried = vec![(); times.len()];
        let fronts = Fronts { window, times: &times, carried: &carried };
        for (row, col) in GRID.places() {
            let found = fronts.at(GRID.entry(GRID.bordered(row, col))).map(|front| front.time);
            let held = window.block().has((row, col));
            assert_eq!(found, held.then(|| GRID.index(row, col) as f32));
        }
    }

    #[test]
    fn the_whole_grid_holds_its_border_too() {
        let window = Window::whole(GRID);
        let times = vec![f32::FAR; GRID.bordered_points()];
        let carried = vec![(); times.len()];
        let fronts = Fronts { window, times: &times, carried: &carried };
        assert!(fronts.at((0, 0)).is_some() && fronts.at((10, 12)).is_some());
        assert_eq!(window.behind(Scan::DOWN).map(|offset| offset.from(14)), [0, 1, 2]);
    }
}

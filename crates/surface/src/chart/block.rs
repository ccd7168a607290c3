//! Defines blocks: parts of a chart that consist of some of its rows and columns.

use std::ops::Range;

use glam::DVec2;

use super::{Chart, Direction};

/// A rectangular block of points: a range of rows and of columns of a chart.
#[derive(Clone, Debug, PartialEq, Eq)]
#[doc(hidden)]
pub struct Block {
    pub rows: Range<usize>,
    pub cols: Range<usize>,
}

impl Block {
    /// Returns a chart that has only the points of the block.
    #[doc(hidden)]
    #[inline]
    pub fn chart(&self) -> Chart {
        Chart { rows: self.rows.len(), cols: self.cols.len() }
    }

    /// Returns the first row and column of the block.
    #[doc(hidden)]
    #[inline]
    pub fn first(&self) -> (usize, usize) {
        (self.rows.start, self.cols.start)
    }

    /// Returns the first row and column of the block as a vector.
    #[doc(hidden)]
    #[inline]
    pub fn origin(&self) -> DVec2 {
        DVec2::new(self.rows.start as f64, self.cols.start as f64)
    }

    /// Returns row and column of the block's points, row by row.
    #[doc(hidden)]
    pub fn places(&self) -> impl Iterator<Item = (usize, usize)> + Clone + use<> {
        let Self { rows, cols } = self.clone();
        rows.flat_map(move |row| cols.clone().map(move |col| (row, col)))
    }

    /// Returns whether a point of the chart belongs to the block.
    #[doc(hidden)]
    #[inline]
    pub fn has(&self, (row, col): (usize, usize)) -> bool {
        self.rows.contains(&row) && self.cols.contains(&col)
    }

    /// Returns whether a place lies between the points of the block.
    #[doc(hidden)]
    #[inline]
    pub fn holds(&self, at: DVec2) -> bool {
        self.chart().holds(at - self.origin())
    }

    /// Converts a point's row and column to those in the block.
    #[doc(hidden)]
    #[inline]
    pub fn local(&self, (row, col): (usize, usize)) -> (usize, usize) {
        (row - self.rows.start, col - self.cols.start)
    }

    /// Returns the points of the block beyond which the `chart` continues outside the block.
    #[doc(hidden)]
    pub fn rim(&self, chart: Chart) -> impl Iterator<Item = (usize, usize)> {
        use Direction::{East, North, South, West};
        let goes_on = move |&(row, col): &(usize, usize)| {
            let beside = [North, South, West, East].map(|to| chart.neighbour(row, col, to));
            beside.into_iter().flatten().any(|point| !self.has(point))
        };
        self.places().filter(goes_on)
    }
}

impl Chart {
    /// Returns the points at most `reach` rows and columns away from a point.
    #[doc(hidden)]
    #[inline]
    pub fn around(self, (row, col): (usize, usize), reach: usize) -> Block {
        self.around_span([row, row], [col, col], [reach; 2])
    }

    /// Returns the points at most `reach` rows and columns away from the points beside a place. If the place
    /// lies beyond the chart's border, the block may be empty.
    #[doc(hidden)]
    #[inline]
    pub fn around_place(self, at: DVec2, reach: usize) -> Block {
        let span = |at: f64| [at.floor() as usize, at.ceil() as usize];
        self.around_span(span(at.x), span(at.y), [reach; 2])
    }

    /// Returns the points at most `reach` rows and columns away from the block between two rows and two columns.
    #[doc(hidden)]
    pub fn around_span(self, rows: [usize; 2], cols: [usize; 2], reach: [usize; 2]) -> Block {
        let range = |[first, last]: [usize; 2], points: usize, reach: usize| {
            first.saturating_sub(reach)..points.min(last.saturating_add(reach + 1))
        };
        Block { rows: range(rows, self.rows, reach[0]), cols: range(cols, self.cols, reach[1]) }
    }

    /// Returns the points that have all eight neighbours.
    #[inline]
    pub(crate) fn interior(self) -> Block {
        let inner = |points: usize| 1..points.saturating_sub(1).max(1);
        Block { rows: inner(self.rows), cols: inner(self.cols) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const CHART: Chart = Chart { rows: 5, cols: 7 };

    #[test]
    fn blocks_end_at_the_border() {
        assert_eq!(CHART.around((1, 6), 2), Block { rows: 0..4, cols: 4..7 });
        let between = CHART.around_place(DVec2::new(1.5, 3.0), 1);
        assert_eq!(between, Block { rows: 0..4, cols: 2..5 });
        assert_eq!(between.chart(), Chart { rows: 4, cols: 3 });
        assert!(between.holds(DVec2::new(0.0, 2.5)) && !between.holds(DVec2::new(0.0, 1.5)));
        assert_eq!(between.local((3, 4)), (3, 2));
        assert_eq!(CHART.around_place(DVec2::new(9.0, 3.0), 1).places().count(), 0);
    }

    #[test]
    fn the_rim_is_where_the_chart_goes_on() {
        let block = CHART.around((0, 2), 1);
        assert_eq!(block, Block { rows: 0..2, cols: 1..4 });
        assert!(block.rim(CHART).eq([(0, 1), (0, 3), (1, 1), (1, 2), (1, 3)]));
        assert_eq!(CHART.around((2, 3), 9).rim(CHART).count(), 0);
    }

    #[test]
    fn inner_points_have_all_neighbours() {
        for (rows, cols) in [(5, 7), (3, 3), (2, 4), (1, 1)] {
            let chart = Chart { rows, cols };
            let has_all = |&(row, col): &(usize, usize)| {
                Direction::ALL.iter().all(|&to| chart.neighbour(row, col, to).is_some())
            };
            assert!(chart.interior().places().eq(chart.places().filter(has_all)));
        }
    }
}

//! Cuts out parts of a surface that go on over seams.

use std::borrow::Cow;
use std::collections::HashMap;
use std::ops::Range;

use glam::DVec2;

use super::super::{Chart, Direction, Surface};
use super::lattice::Lattice;

/// A part of a surface as a separate open surface. Like the grid, it continues over seams, so it may contain a point
/// more than once.
pub struct Sheet<'a> {
    whole: &'a Surface,
    part: Cow<'a, Surface>,
    /// Row and column of the part's first point on the whole grid, negative before the first row or column.
    first: (isize, isize),
}

impl Surface {
    /// Returns the part at most `reach` rows and columns away from a span of rows and columns.
    #[doc(hidden)]
    pub fn sheet(&self, rows: [usize; 2], cols: [usize; 2], reach: [usize; 2]) -> Sheet<'_> {
        let lattice = self.lattice();
        let rows = beyond(rows, self.rows(), lattice.rows.is_some(), reach[0]);
        let cols = beyond(cols, self.cols(), lattice.cols.is_some(), reach[1]);
        let first = (rows.start, cols.start);
        let within = |range: &Range<isize>, points: usize| {
            let inside = range.start >= 0 && range.end <= points as isize;
            inside.then_some(range.start as usize..range.end as usize)
        };
        let part = match (within(&rows, self.rows()), within(&cols, self.cols())) {
            (Some(rows), Some(cols)) => self.window(rows, cols),
            _ => self.beyond(&lattice, rows, cols),
        };
        Sheet { whole: self, part: Cow::Owned(part), first }
    }

    /// Returns the part of [`Self::sheet`] if it goes on over a seam, and the whole surface otherwise.
    pub(crate) fn sheet_over_seams(
        &self,
        rows: [usize; 2],
        cols: [usize; 2],
        reach: usize,
    ) -> Sheet<'_> {
        let lattice = self.lattice();
        let leaves = |[first, last]: [usize; 2], points: usize, goes_on: Option<bool>| {
            goes_on.is_some() && (first < reach || last + reach >= points)
        };
        if leaves(rows, self.rows(), lattice.rows) || leaves(cols, self.cols(), lattice.cols) {
            return self.sheet(rows, cols, [reach; 2]);
        }
        Sheet { whole: self, part: Cow::Borrowed(self), first: (0, 0) }
    }

    pub(super) fn lattice(&self) -> Lattice {
        self.glued.as_ref().map_or_else(Lattice::default, |glued| glued.lattice)
    }
}

/// Returns a span with `reach` lines on both sides, as far as the grid goes.
fn beyond([first, last]: [usize; 2], points: usize, goes_on: bool, reach: usize) -> Range<isize> {
    let (start, end) = (first as isize - reach as isize, (last + reach + 1) as isize);
    if goes_on { start..end } else { start.max(0)..end.min(points as isize) }
}

impl Sheet<'_> {
    /// Returns the part.
    #[doc(hidden)]
    pub fn part(&self) -> &Surface {
        &self.part
    }

    /// Returns the part's grid.
    #[doc(hidden)]
    pub fn chart(&self) -> Chart {
        self.part.chart()
    }

    /// Converts a place of the whole grid to the part's rows and columns.
    #[doc(hidden)]
    pub fn local(&self, at: DVec2) -> DVec2 {
        at - self.origin()
    }

    /// Converts a place of the part to the whole grid's rows and columns.
    pub(crate) fn place(&self, local: DVec2) -> DVec2 {
        let at = local + self.origin();
        self.whole.continued_place(at).unwrap_or(at)
    }

    /// Returns row and column on the whole grid of a point of the part.
    #[doc(hidden)]
    pub fn point(&self, (row, col): (usize, usize)) -> (usize, usize) {
        let (row, col) = (row as isize + self.first.0, col as isize + self.first.1);
        self.whole
            .continued(row, col)
            .expect("a sheet's points lie on the grid or where it goes on")
    }

    /// Returns the factors for rows and columns that convert a step at a point of the part to the same step on the whole
    /// grid.
    pub(crate) fn turn(&self, (row, col): (usize, usize)) -> DVec2 {
        if !self.whole.is_glued() {
            return DVec2::ONE;
        }
        let here = self.point((row, col));
        let chart = self.chart();
        let factor = |to: Direction, axis: fn((usize, usize)) -> usize| {
            let change = |to: Direction| {
                let there = axis(self.point(chart.neighbour(row, col, to)?));
                let change = there as f64 - axis(here) as f64;
                (change.abs() == 1.0).then_some(change)
            };
            change(to).or_else(|| change(to.opposite()).map(|back| -back)).unwrap_or(1.0)
        };
        DVec2::new(factor(Direction::South, |at| at.0), factor(Direction::East, |at| at.1))
    }

    /// Finds the points of the part that are copies of one of `points`, which are points of the whole grid. Returns for
    /// each the number in `points`, and the row and column in the part.
    #[doc(hidden)]
    pub fn points_at(&self, points: &[(usize, usize)]) -> Vec<(usize, (usize, usize))> {
        let all = points.iter().enumerate();
        if !self.whole.is_glued() {
            let local = |(number, &(row, col)): (usize, &(usize, usize))| {
                let (row, col) = (row as isize - self.first.0, col as isize - self.first.1);
                self.chart().at(row, col).map(|local| (number, local))
            };
            return all.filter_map(local).collect();
        }
        let mut numbers: HashMap<_, Vec<usize>> = HashMap::new();
        for (number, &point) in all {
            numbers.entry(self.whole.first_copy(point)).or_default().push(number);
        }
        let at = |local| {
            let found = numbers.get(&self.whole.first_copy(self.point(local)));
            found.into_iter().flatten().map(move |&number| (number, local))
        };
        self.chart().places().flat_map(at).collect()
    }

    fn origin(&self) -> DVec2 {
        DVec2::new(self.first.0 as f64, self.first.1 as f64)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Gluing, Spacing};

    #[test]
    fn sheets_go_on_where_the_grid_does() {
        let heights = (0..8 * 9).map(|index| f64::from(index / 9 % 7 * 10 + index % 9 % 8));
        let plane = Surface::from_heights(8, 9, heights.collect(), Spacing::square(1.0)).unwrap();
        let height = |surface: &Surface, (row, col)| surface.position(row, col).unwrap().z;
        for (gluing, chart) in [
            (None, Chart { rows: 4, cols: 4 }),
            (Some(Gluing::columns()), Chart { rows: 4, cols: 6 }),
            (Some(Gluing::both()), Chart { rows: 5, cols: 6 }),
        ] {
            let surface = gluing
                .into_iter()
                .fold(plane.clone(), |surface, gluing| surface.with_gluing(gluing).unwrap());
            let sheet = surface.sheet([1, 1], [0, 1], [2, 2]);
            // The sheet has rows from -1 or 0 to 3, and columns from -2 or 0 to 3.
            assert_eq!(sheet.chart(), chart);
            for local in sheet.chart().places() {
                let point = sheet.point(local);
                assert_eq!(height(sheet.part(), local), height(&surface, point));
                assert!(sheet.points_at(&[point]).contains(&(0, local)));
            }
            let place = DVec2::new(1.5, 0.25);
            assert_eq!(sheet.place(sheet.local(place)), place);
            assert_eq!(surface.sheet_over_seams([4, 4], [4, 5], 2).chart(), surface.chart());
        }
        let tube = plane.with_gluing(Gluing::columns()).unwrap();
        let sheet = tube.sheet([1, 1], [0, 1], [2, 2]);
        assert_eq!(sheet.point((0, 0)), (0, 6));
        // The last column is the first one.
        assert_eq!(sheet.points_at(&[(3, 8)]), [(0, (3, 2))]);
        assert_eq!(sheet.place(DVec2::new(1.0, 1.5)), DVec2::new(1.0, 7.5));
    }
}

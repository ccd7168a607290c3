//! Defines the cells of the grid, and locates places in them.

use std::ops::Range;

use glam::DVec2;

use super::Chart;

/// The part of the chart spanned by up to four neighbouring grid points: a cell, an edge or a single point.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[doc(hidden)]
pub struct Cell {
    pub rows: [usize; 2],
    pub cols: [usize; 2],
}

impl Chart {
    /// Returns the rows of cells. Each row of cells has the number of the row of points at its north.
    #[doc(hidden)]
    #[inline]
    pub const fn rows_of_cells(self) -> Range<usize> {
        0..self.rows.saturating_sub(1)
    }

    /// Returns the cells of a row of cells.
    #[doc(hidden)]
    #[inline]
    pub fn cells_of_row(self, row: usize) -> impl Iterator<Item = Cell> {
        (0..self.cols.saturating_sub(1)).map(move |col| Cell::of((row, col)))
    }

    /// Returns the cells that have both `a` and `b` as corners.
    #[doc(hidden)]
    pub fn cells_between(self, a: (usize, usize), b: (usize, usize)) -> impl Iterator<Item = Cell> {
        let firsts = |a: usize, b: usize, points: usize| {
            a.max(b).saturating_sub(1)..(a.min(b) + 1).min(points.saturating_sub(1))
        };
        let cols = firsts(a.1, b.1, self.cols);
        firsts(a.0, b.0, self.rows)
            .flat_map(move |row| cols.clone().map(move |col| Cell::of((row, col))))
    }

    /// Returns the first corners of the cells at most `reach` rows and columns around a point. In the grid's
    /// last row and column, the first points of edges and the last point count as such corners too.
    #[inline]
    pub(crate) fn cells_near(
        self,
        (row, col): (usize, usize),
        reach: usize,
    ) -> impl Iterator<Item = (usize, usize)> {
        let firsts = |at: usize, points: usize| at.saturating_sub(reach)..points.min(at + reach);
        let cols = firsts(col, self.cols);
        firsts(row, self.rows).flat_map(move |row| cols.clone().map(move |col| (row, col)))
    }

    /// Returns the cell that contains a place of the chart: the one to the south-east of a grid point, or the last one
    /// before the end of the grid.
    #[doc(hidden)]
    pub fn cell_at(self, at: DVec2) -> Cell {
        let low = |at: f64, points: usize| (at as usize).min(points.saturating_sub(2));
        Cell::of((low(at.x, self.rows), low(at.y, self.cols)))
    }

    /// Returns the cells that contain a position on the chart: one for a position inside a cell, two for one on an
    /// edge. A grid point is returned as a cell of its own, since its neighbours' first update is already exact.
    pub(crate) fn cells_around(self, at: DVec2) -> Vec<Cell> {
        let at_point = at.x.fract() == 0.0 && at.y.fract() == 0.0;
        let spans = |x: f64, points: usize| -> Vec<[usize; 2]> {
            let low = x as usize;
            if x.fract() != 0.0 {
                return vec![[low, low + 1]];
            }
            if at_point || points == 1 {
                return vec![[low, low]];
            }
            [low.checked_sub(1), Some(low)]
                .into_iter()
                .flatten()
                .filter(|low| low + 1 < points)
                .map(|low| [low, low + 1])
                .collect()
        };
        let cols = spans(at.y, self.cols);
        spans(at.x, self.rows)
            .into_iter()
            .flat_map(|rows| cols.iter().map(move |&cols| Cell { rows, cols }))
            .collect()
    }
}

impl Cell {
    /// Returns the cell to the south-east of a grid point.
    #[doc(hidden)]
    #[inline]
    pub const fn of((row, col): (usize, usize)) -> Self {
        Self { rows: [row, row + 1], cols: [col, col + 1] }
    }

    /// Returns the corners: north-west, north-east, south-west and south-east. Some coincide on an edge.
    #[inline]
    #[doc(hidden)]
    pub const fn corners(self) -> [(usize, usize); 4] {
        let Self { rows: [north, south], cols: [west, east] } = self;
        [(north, west), (north, east), (south, west), (south, east)]
    }

    /// Returns the first corner, which identifies the cell.
    #[inline]
    #[doc(hidden)]
    pub const fn north_west(self) -> (usize, usize) {
        (self.rows[0], self.cols[0])
    }

    /// Returns the indices of the corners in a row-major array.
    #[inline]
    #[doc(hidden)]
    pub fn indices(self, chart: Chart) -> [usize; 4] {
        self.corners().map(|(row, col)| chart.index(row, col))
    }

    /// Returns row and column of a place relative to the first corner.
    #[inline]
    #[doc(hidden)]
    pub fn inside(self, at: DVec2) -> DVec2 {
        at - DVec2::new(self.rows[0] as f64, self.cols[0] as f64)
    }
}

/// Returns the parameters, from 0 to 1, at which a segment crosses the grid's rows and columns, ends included.
pub fn grid_crossings(from: DVec2, to: DVec2) -> Vec<f64> {
    let mut cuts = vec![0.0, 1.0];
    for axis in 0..2 {
        let (a, b) = (from[axis], to[axis]);
        let (low, high) = (a.min(b), a.max(b));
        let mut line = low.floor() + 1.0;
        while line < high {
            cuts.push((line - a) / (b - a));
            line += 1.0;
        }
    }
    cuts.sort_by(f64::total_cmp);
    cuts
}

/// Returns the bilinear weights of a cell's corners at a position `v` rows and `u` columns from the first corner.
pub fn bilinear(v: f64, u: f64) -> [f64; 4] {
    [(1.0 - v) * (1.0 - u), (1.0 - v) * u, v * (1.0 - u), v * u]
}

/// Returns the weights of a cell's corners (north-west, north-east, south-west and south-east) at the place
/// `inside`, in rows and columns from the first corner. Some corners may be missing. The result is `None` in
/// a hole.
///
/// If one corner is missing, the half of the cell opposite to it still belongs to the surface.
pub fn corner_weights(there: [bool; 4], inside: DVec2) -> Option<[f64; 4]> {
    // Rounding may move a place on the cell's border outside.
    let (v, u) = (inside.x.clamp(0.0, 1.0), inside.y.clamp(0.0, 1.0));
    let mut weights = bilinear(v, u);
    let mut missing = (0..4).filter(|&corner| !there[corner]);
    if let (Some(hole), None) = (missing.next(), missing.next()) {
        // Weights over the triangle of the other three corners. Here v and u count from the row and the
        // column of the missing corner.
        let (v, u) = (if hole < 2 { v } else { 1.0 - v }, if hole % 2 == 0 { u } else { 1.0 - u });
        weights[hole ^ 1] = 1.0 - v;
        weights[hole ^ 2] = 1.0 - u;
        weights[hole ^ 3] = v + u - 1.0;
        weights[hole] = 0.0;
    }
    let weights = weights.map(|weight| if weight.abs() > 1e-12 { weight } else { 0.0 });
    let usable = |(weight, there): (&f64, bool)| *weight == 0.0 || (*weight > 0.0 && there);
    weights.iter().zip(there).all(usable).then_some(weights)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_beside_an_edge_have_its_ends() {
        for (rows, cols) in [(4, 5), (2, 2), (1, 4)] {
            let chart = Chart { rows, cols };
            let all: Vec<_> =
                chart.rows_of_cells().flat_map(|row| chart.cells_of_row(row)).collect();
            assert_eq!(all.len(), (rows - 1) * (cols - 1));
            for (a, b) in chart.places().flat_map(|a| chart.places().map(move |b| (a, b))) {
                let has_both = |cell: &&Cell| [a, b].iter().all(|end| cell.corners().contains(end));
                let found: Vec<_> = chart.cells_between(a, b).collect();
                assert!(all.iter().filter(has_both).eq(&found), "{a:?} {b:?}");
            }
        }
    }

    #[test]
    fn places_on_edges_lie_in_the_cells_on_both_sides() {
        let chart = Chart { rows: 4, cols: 5 };
        let around = |row, col| chart.cells_around(DVec2::new(row, col));
        assert_eq!(around(1.5, 2.5), [Cell { rows: [1, 2], cols: [2, 3] }]);
        assert_eq!(around(1.0, 2.0), [Cell { rows: [1, 1], cols: [2, 2] }]);
        let beside = [Cell { rows: [0, 1], cols: [2, 3] }, Cell { rows: [1, 2], cols: [2, 3] }];
        assert_eq!(around(1.0, 2.5), beside);
        assert_eq!(around(0.0, 2.5), beside[..1]);
        assert_eq!(beside[1].inside(DVec2::new(1.25, 2.5)), DVec2::new(0.25, 0.5));
    }
}

//! Inverts log maps: finds the place with given coordinates.

use glam::{DMat2, DVec2};

use super::frame::cubic;
use super::log_map::LogMap;

/// The length of a step of Newton's method, in cells, below which the search ends.
const EXACT: f64 = 1e-7;
/// The largest number of steps of Newton's method for one place.
const MOST: usize = 12;

impl LogMap {
    /// Returns the place (row and column, fractional) with the coordinates (u, v) in the plane of a source:
    /// the inverse of the log map, also called the exponential map. `source` is the index of the source.
    ///
    /// The place is found by walking along the shortest path from the source, one cell at a time. In the
    /// plane this path is the straight line to (u, v). Coordinates are interpolated by cubics, and linearly
    /// beside holes, borders of regions and the border of the grid. Returns `None` if the walk leaves the
    /// source's region or the grid (even over a seam), or if it meets a hole or the cut locus.
    ///
    /// # Panics
    /// If there is no such source.
    pub fn place(&self, source: usize, coordinates: [f64; 2]) -> Option<[f64; 2]> {
        let basis = self.bases[source];
        let target = DVec2::from(coordinates);
        let step = DVec2::from(basis.u) * target.x + DVec2::from(basis.v) * target.y;
        let mut at = DVec2::from(basis.at);
        if step == DVec2::ZERO {
            return Some(at.to_array());
        }
        let label = u32::try_from(source).ok()?;
        let most = 8 * (self.chart.rows + self.chart.cols);
        // The share of the line that has been walked.
        let mut walked = 0.0;
        let mut ahead = step;
        for _ in 0..most {
            let share = (1.0 / ahead.abs().max_element()).min(1.0 - walked);
            walked = if walked + share >= 1.0 - 1e-12 { 1.0 } else { walked + share };
            at = self.near(label, walked * target, at + share * ahead)?;
            if walked == 1.0 {
                return Some(at.to_array());
            }
            let (_, slope) = self.interpolated(label, at)?;
            ahead = slope.inverse() * target;
            if !ahead.is_finite() {
                return None;
            }
        }
        None
    }

    /// Returns the place near `at` whose coordinates are `target`.
    fn near(&self, label: u32, target: DVec2, mut at: DVec2) -> Option<DVec2> {
        let (last_row, last_col) = self.chart.last();
        let last = DVec2::new(last_row as f64, last_col as f64);
        let mut far = f64::INFINITY;
        for _ in 0..MOST {
            // A guess may lie a little beyond the border.
            let inside = at.clamp(DVec2::ZERO, last);
            if at.distance(inside) > 1.0 {
                return None;
            }
            at = inside;
            let (here, slope) = self.interpolated(label, at)?;
            let change = slope.inverse() * (target - here);
            if !change.is_finite() || change.length() > 4.0 {
                return None;
            }
            far = change.length();
            if far < EXACT {
                break;
            }
            at += change;
        }
        // At the border, the last change may lead outwards by rounding.
        (far < 1e-5 && self.chart.holds(at)).then_some(at)
    }

    /// Returns the coordinates at a place, and their derivatives by row and column.
    fn interpolated(&self, label: u32, at: DVec2) -> Option<(DVec2, DMat2)> {
        let cell = self.chart.cell_at(at);
        let ((row, col), DVec2 { x: v, y: u }) = (cell.north_west(), cell.inside(at));
        let (rows, cols) = (weights(v), weights(u));
        let value = |i: usize, j: usize| self.value(label, [row + i, col + j]);
        let sum = |count: std::ops::Range<usize>, rows: [[f64; 4]; 2], cols: [[f64; 4]; 2]| {
            let mut sums = [DVec2::ZERO; 3];
            for i in count.clone() {
                for j in count.clone() {
                    let value = value(i, j)?;
                    sums[0] += rows[0][i] * cols[0][j] * value;
                    sums[1] += rows[1][i] * cols[0][j] * value;
                    sums[2] += rows[0][i] * cols[1][j] * value;
                }
            }
            let [here, by_row, by_col] = sums;
            Some((here, DMat2::from_cols(by_row, by_col)))
        };
        let linear = |x: f64| [[0.0, 1.0 - x, x, 0.0], [0.0, -1.0, 1.0, 0.0]];
        sum(0..4, rows, cols).or_else(|| sum(1..3, linear(v), linear(u)))
    }

    /// Returns the coordinates of a grid point of a source's region. `row` and `col` are 1 larger than the
    /// row and the column of the point.
    fn value(&self, label: u32, [row, col]: [usize; 2]) -> Option<DVec2> {
        let (row, col) = (row.checked_sub(1)?, col.checked_sub(1)?);
        if row >= self.chart.rows || col >= self.chart.cols {
            return None;
        }
        let index = self.chart.index(row, col);
        let [u, v] = self.coordinates[index];
        let value = DVec2::new(u.into(), v.into());
        (self.labels[index] == label && value.is_finite()).then_some(value)
    }
}

/// Returns the weights of a cubic through four samples, and those of its derivative.
fn weights(x: f64) -> [[f64; 4]; 2] {
    let slopes = [
        -(3.0 * x * x - 6.0 * x + 2.0) / 6.0,
        (3.0 * x * x - 4.0 * x - 1.0) / 2.0,
        -(3.0 * x * x - 2.0 * x - 2.0) / 2.0,
        (3.0 * x * x - 1.0) / 6.0,
    ];
    [cubic(x), slopes]
}

//! Measures how skewed cells are: how far away the points lie that split the obtuse triangles in them.

use std::cmp::Reverse;

use glam::DVec2;
use rayon::prelude::*;

use super::obtuse::reach::splits_within;
use super::{Chart, Direction, Surface, kept};
use crate::constants::{FARTHEST_SPLIT, LOOKS, SAMPLE_BITS, SPLIT_REACH};

/// A place of a surface whose cells are so skewed that updates do not see all points from which fronts arrive there. A
/// map may be late by tens of per cent around it. The grid resolves such a surface if its rows or columns follow the
/// direction in which lengths are short.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "around row {row}, column {col}, cells are so skewed that fronts arrive from points {needed} rows or columns away; \
     updates look for points up to {seen} away"
)]
pub struct Unresolved {
    /// Row of the point.
    pub row: usize,
    /// Column of the point.
    pub col: usize,
    /// Distance of the points from which fronts arrive, in rows and columns.
    pub needed: usize,
    /// Distance up to which updates look for such points.
    pub seen: usize,
}

/// The point, of some thousands, whose cells are skewed most.
#[derive(Clone, Copy, Debug)]
pub(super) struct MostSkewed {
    at: (usize, usize),
    /// See [`Surface::skew_around`].
    needed: usize,
}

/// Limit of the squares of a triangle's sides for which any obtuse angle counts, but for rounding. Engines split triangles
/// only where the angle is clearly obtuse.
const EXACTLY: f64 = 1.0 - 1e-6;

impl Surface {
    /// Returns the place whose cells are skewed most, if that is too much for updates: if the axes of the metric have a
    /// ratio above 30, not along rows or columns, or above about 10 on a glued surface. It looks at some thousands of
    /// points. The result is `None` if all cells are alike, since arrival times then are lengths of straight
    /// lines.
    pub fn unresolved(&self) -> Option<Unresolved> {
        let MostSkewed { at: (row, col), needed } = *self.most_skewed();
        let seen = if self.is_glued() { SPLIT_REACH } else { FARTHEST_SPLIT } as usize;
        let is_far = needed > seen && !self.has_even_cells();
        is_far.then_some(Unresolved { row, col, needed, seen })
    }

    /// Returns whether some cells are so skewed that points which split obtuse triangles are more than `most` rows or
    /// columns away. It looks at some thousands of points.
    #[doc(hidden)]
    pub fn has_skewed_cells(&self, most: usize) -> bool {
        self.most_skewed().needed > most
    }

    fn most_skewed(&self) -> &MostSkewed {
        kept(&self.known.most_skewed, || {
            let all = self.samples().map(|at| MostSkewed { at, needed: self.skew_at(at) });
            let none = || MostSkewed { at: (0, 0), needed: 1 };
            all.reduce(none, |a, b| {
                let is_later = (Reverse(b.needed), b.at) < (Reverse(a.needed), a.at);
                if is_later { b } else { a }
            })
        })
    }

    /// Returns the distance in rows and columns of the farthest point that splits an obtuse triangle of some point in or
    /// beside the cell of a place, if the metric there were that of the triangle. The result is at least 1.
    ///
    /// In a constant metric, no triangle of a lattice point and its nearest points is obtuse. The result is then the
    /// distance of the farthest of the nearest points.
    #[doc(hidden)]
    pub fn skew_around(&self, place: DVec2) -> usize {
        let around = self.chart().around_place(place, 1);
        around.places().map(|at| self.skew_at(at)).max().unwrap_or(1)
    }

    /// Returns some thousands of points, evenly spread.
    fn samples(&self) -> impl ParallelIterator<Item = (usize, usize)> {
        let chart = self.chart();
        let all = (0..LOOKS * LOOKS).into_par_iter();
        all.map(move |number| sample(chart, number))
            .filter(move |&(row, col)| row < chart.rows && col < chart.cols)
    }

    /// Returns the largest distance for the triangles of a point in the half of its directions that begins east. Those in
    /// the other half have the same sides, as far as the metric around the point is the same.
    fn skew_at(&self, at: (usize, usize)) -> usize {
        let skew = |to: Direction| {
            let (side, other) =
                (self.edge_on_surface(at, to)?, self.edge_on_surface(at, to.next())?);
            let base = self.edge_on_surface(self.chart().neighbour(at.0, at.1, to)?, to.base())?;
            let squares = [side, other, base].map(|length| length * length);
            Some(splits_within([to, to.next()].map(Direction::vector), squares, EXACTLY))
        };
        Direction::ALL[..4].iter().filter_map(|&to| skew(to)).max().unwrap_or(1)
    }
}

/// Returns the row and column of a point of the sample, by its number. It may lie beyond the grid.
///
/// The points lie at other columns in each row, so that they meet features along columns too.
fn sample(chart: Chart, number: u32) -> (usize, usize) {
    let every = |points: usize| points.div_ceil(LOOKS as usize).max(1);
    let [down, right] = [number / LOOKS, number % LOOKS].map(|count| count as usize);
    let step = every(chart.cols);
    (down * every(chart.rows), right * step + down % step)
}

impl Unresolved {
    /// Returns the place that a device has found, which counts the points from the end of the sample so that the first of
    /// several points has the largest number (`glsl/passes/skew.glsl`). `seen` is the distance up to which updates look.
    #[doc(hidden)]
    pub fn found_by_device(chart: Chart, found: u32, seen: usize) -> Option<Self> {
        let last = (1 << SAMPLE_BITS) - 1;
        let needed = (found >> SAMPLE_BITS) as usize;
        let (row, col) = sample(chart, last - (found & last));
        (needed > seen).then_some(Self { row, col, needed, seen })
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;
    use crate::{MetricTensor, Spacing};

    /// Returns a surface of 11 x 13 points. `place` gives the position from row and column.
    fn surface(place: impl Fn(f64, f64) -> [f64; 3]) -> Surface {
        let positions = (0..11 * 13)
            .map(|index| DVec3::from_array(place((index / 13) as f64, (index % 13) as f64)));
        Surface::from_positions(11, 13, positions.collect()).unwrap()
    }

    /// Returns a metric whose axes have a ratio and whose longer axis is turned from point to point.
    fn metric(ratio: f64, turn: impl Fn(f64) -> f64) -> Surface {
        let tensors = (0..20).map(|index| {
            let axis = DVec2::from_angle(turn(f64::from(index)));
            let along = |a: f64, b: f64| a * b * (ratio * ratio - 1.0);
            MetricTensor {
                rr: 1.0 + along(axis.x, axis.x),
                rc: along(axis.x, axis.y),
                cc: 1.0 + along(axis.y, axis.y),
            }
        });
        Surface::from_metric(4, 5, tensors.collect()).unwrap()
    }

    #[test]
    fn cells_are_skewed_if_neighbours_are_not_the_nearest_points() {
        let by = |by: f64| surface(|row, col| [col + by * row, row, 0.0]);
        for (shear, skew) in [(0.0, 1), (0.4, 1), (1.0, 1), (1.4, 2), (-1.6, 2), (7.0, 7)] {
            for place in [[5.0, 5.0], [0.0, 0.0], [9.5, 0.3], [10.0, 12.0]] {
                assert_eq!(by(shear).skew_around(place.into()), skew, "{shear} {place:?}");
            }
            assert_eq!(by(shear).has_skewed_cells(1), skew > 1);
        }
        assert_eq!(surface(|row, col| [9.0 * col, row, 0.0]).skew_around(DVec2::ONE), 1);
        assert_eq!(
            [1.0, 1.5, 10.0, 100.0].map(|ratio| metric(ratio, |_| 0.6).has_skewed_cells(1)),
            [false, false, true, true]
        );
        // Long axes along rows and columns need no further points.
        assert!(!metric(100.0, |_| 0.0).has_skewed_cells(1));
    }

    #[test]
    fn skewed_cells_are_found_among_others() {
        let (rows, cols) = (200, 300);
        let heights = |from: usize| {
            let height = move |k: usize| {
                let (row, col) = (k / cols, k % cols);
                let slope = 9.0 * (col as f64 + 0.4 * row as f64);
                if (from..from + 40).contains(&row) { slope } else { 0.0 }
            };
            let heights = (0..rows * cols).map(height).collect();
            Surface::from_heights(rows, cols, heights, Spacing::square(1.0)).unwrap()
        };
        for from in [0, 37, 120] {
            let surface = heights(from);
            assert!(surface.has_skewed_cells(1), "{from}");
            assert!(surface.skew_around(DVec2::new(from as f64 + 20.0, 7.5)) > 1);
            assert_eq!(surface.skew_around(DVec2::new(190.0, 7.5)), 1);
        }
    }

    #[test]
    fn places_are_unresolved_where_a_turning_metric_needs_points_far_away() {
        let turning = |ratio: f64| metric(ratio, |index| 0.01 + 0.001 * index).unresolved();
        assert_eq!([1.0, 5.0, 15.0, 30.0].map(turning), [None; 4]);
        let found = turning(200.0).unwrap();
        assert!(found.needed > found.seen && found.row < 4 && found.col < 5, "{found:?}");
        assert!(found.to_string().contains(&format!("row {}, column {}", found.row, found.col)));
        // Cells that are all alike have straight lines.
        assert_eq!(metric(100.0, |_| 0.6).unresolved(), None);
    }
}

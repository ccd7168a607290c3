//! Detects surfaces whose cells are all alike.

use glam::DVec2;
use rayon::prelude::*;

use super::{Direction, Surface};

/// Relative tolerance for the lengths of edges in one direction.
const EVEN: f64 = 5e-6;

/// Maximum number of steps by which a basis is reduced. Each at least halves the longer side, up to the last one.
const MOST_STEPS: usize = 64;

/// Directions of the edges around a cell.
const WAYS: [Direction; 4] =
    [Direction::East, Direction::SouthEast, Direction::South, Direction::SouthWest];

impl Surface {
    /// Returns whether all cells are alike, whatever their shape, and the slowness is the same everywhere.
    /// Then all edges in a direction have the same length. This holds for even grids in the plane, on
    /// cylinders and on cones, and for a constant metric.
    #[doc(hidden)]
    pub fn has_even_cells(&self) -> bool {
        // Origins are continued along straight lines of the chart, which end at seams.
        if self.is_slowed_unevenly() || self.is_glued() {
            return false;
        }
        // An even grid is fitted first: on large grids, rounded positions give lengths of edges that differ by more
        // than the tolerance.
        if self.even_grid().is_some() {
            return true;
        }
        let is_even = |row: usize| {
            WAYS.into_iter().zip(self.first_edges()).all(|(to, first)| {
                let of = |col: usize| self.edge_on_surface((row, col), to);
                let mut lengths = (0..self.chart.cols).filter_map(of);
                let first = first.unwrap_or(0.0);
                lengths.all(|length| (length - first).abs() <= EVEN * first)
            })
        };
        (0..self.chart.rows).into_par_iter().all(is_even)
    }

    /// Returns whether all cells are alike and so skewed that the nearest points are more than `most` rows or columns
    /// away: some step of the reduced basis of Lagrange and Gauss, or the shorter sum of both steps, is that long. The
    /// triangles of these steps are the ones without an obtuse angle.
    #[doc(hidden)]
    pub fn has_skewed_cells(&self, most: f64) -> bool {
        let [Some(east), south_east, Some(south), south_west] = self.first_edges() else {
            return false;
        };
        let sides = east * east + south * south;
        let across = match (south_east, south_west) {
            (Some(diagonal), _) => 0.5 * (diagonal * diagonal - sides),
            (None, Some(diagonal)) => 0.5 * (sides - diagonal * diagonal),
            (None, None) => return false,
        };
        let dot = |a: DVec2, b: DVec2| {
            a.x * b.x * east * east + a.y * b.y * south * south + (a.x * b.y + a.y * b.x) * across
        };
        let (mut short, mut long) = (DVec2::X, DVec2::Y);
        for _ in 0..MOST_STEPS {
            if dot(long, long) < dot(short, short) {
                (short, long) = (long, short);
            }
            let times = (dot(short, long) / dot(short, short)).round();
            if times == 0.0 || !times.is_finite() {
                break;
            }
            long -= times * short;
        }
        // Where both steps are at a right angle, there is no need of a third one.
        let along = dot(short, long);
        let third = match along.abs() > EVEN * dot(short, short) {
            true => long - along.signum() * short,
            false => short,
        };
        [short, long, third].iter().any(|step| step.abs().max_element() > most)
            && self.has_even_cells()
    }

    /// Returns the lengths on the surface of the first edges in each of [`WAYS`].
    fn first_edges(&self) -> [Option<f64>; 4] {
        WAYS.map(|to| self.chart.places().find_map(|at| self.edge_on_surface(at, to)))
    }

    fn edge_on_surface(&self, (row, col): (usize, usize), to: Direction) -> Option<f64> {
        let end = self.has_edge(row, col, to).then(|| self.chart.neighbour(row, col, to))??;
        Some(self.length_on_surface((row, col), end))
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;
    use crate::builtin::Builtin;
    use crate::{MetricTensor, Spacing};

    /// Returns a surface of 11 x 13 points. `place` gives the position from row and column.
    fn surface(place: impl Fn(f64, f64) -> [f64; 3]) -> Surface {
        let positions = (0..11 * 13)
            .map(|index| DVec3::from_array(place((index / 13) as f64, (index % 13) as f64)));
        Surface::from_positions(11, 13, positions.collect()).unwrap()
    }

    #[test]
    fn sheared_and_rolled_grids_and_constant_metrics_have_even_cells() {
        let rolled = |turn: f64, along: f64| [8.0 * turn.sin(), along, 8.0 * turn.cos()];
        assert!(surface(|row, col| [3.0 * col + 0.7 * row, row, 0.5 * col]).has_even_cells());
        assert!(surface(|row, col| rolled(0.1 * col + 0.04 * row, row)).has_even_cells());
        let tensor = MetricTensor { rr: 4.0, rc: 0.5, cc: 1.0 };
        assert!(Surface::from_metric(4, 5, vec![tensor; 20]).unwrap().has_even_cells());
        // A relief of a thousandth of the spacing does not count.
        let mut heights = vec![0.0; 35];
        heights[0] = 1e-3;
        let hair = Surface::from_heights(5, 7, heights, Spacing::square(1.0)).unwrap();
        assert!(hair.has_even_cells());
        let mask: Vec<_> = (0..35).map(|index| index % 6 != 0).collect();
        assert!(hair.clone().with_mask(&mask).unwrap().has_even_cells());
        assert!(hair.clone().with_slowness(vec![2.0; 35]).unwrap().has_even_cells());
        let slowness = (0..35).map(|index| 1.0 + f64::from(index)).collect();
        assert!(!hair.with_slowness(slowness).unwrap().has_even_cells());
    }

    #[test]
    fn cells_are_skewed_if_neighbours_are_not_the_nearest_points() {
        let sheared =
            |by: f64| surface(|row, col| [col + by * row, row, 0.0]).has_skewed_cells(1.0);
        assert_eq!(
            [0.0, 0.4, 1.0, 1.4, -1.6, 7.0].map(sheared),
            [false, false, false, true, true, true]
        );
        assert!(!surface(|row, col| [9.0 * col, row, 0.0]).has_skewed_cells(1.0));
        let metric = |ratio: f64| {
            let axis = DVec2::from_angle(0.6);
            let along = |a: f64, b: f64| a * b * (ratio * ratio - 1.0);
            let tensor = MetricTensor {
                rr: 1.0 + along(axis.x, axis.x),
                rc: along(axis.x, axis.y),
                cc: 1.0 + along(axis.y, axis.y),
            };
            Surface::from_metric(4, 5, vec![tensor; 20]).unwrap().has_skewed_cells(1.0)
        };
        assert_eq!([1.0, 1.5, 10.0, 100.0].map(metric), [false, false, true, true]);
        assert!(
            !Builtin::ShearedPlane { degrees: 60.0 }
                .surface(9, 9)
                .unwrap()
                .with_slowness((0..81).map(f64::from).collect())
                .unwrap()
                .has_skewed_cells(1.0)
        );
    }

    #[test]
    fn others_have_not() {
        assert!(!surface(|row, col| [1.01f64.powf(col), row, 0.0]).has_even_cells());
        assert!(!surface(|row, col| [col, row, 0.05 * col.sin()]).has_even_cells());
        // All edges along rows and columns have the same length here; the diagonals do not.
        let rhombs = |row: f64, col: f64| [col + 0.2 * (row % 2.0), row * 0.96f64.sqrt(), 0.0];
        assert!(!surface(rhombs).has_even_cells());
        assert!(!Builtin::Sphere.surface(12, 12).unwrap().has_even_cells());
    }
}

//! Detects surfaces whose cells are all alike.

use rayon::prelude::*;

use super::{Direction, Surface};

/// Relative tolerance for the lengths of edges in one direction.
const EVEN: f64 = 5e-6;

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

    /// Returns the lengths on the surface of the first edges in each of [`WAYS`].
    fn first_edges(&self) -> [Option<f64>; 4] {
        WAYS.map(|to| self.chart.places().find_map(|at| self.edge_on_surface(at, to)))
    }

    /// Returns the length on the surface of the edge from a point to a neighbour, if there is one.
    pub(super) fn edge_on_surface(&self, (row, col): (usize, usize), to: Direction) -> Option<f64> {
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
    fn others_have_not() {
        assert!(!surface(|row, col| [1.01f64.powf(col), row, 0.0]).has_even_cells());
        assert!(!surface(|row, col| [col, row, 0.05 * col.sin()]).has_even_cells());
        // All edges along rows and columns have the same length here; the diagonals do not.
        let rhombs = |row: f64, col: f64| [col + 0.2 * (row % 2.0), row * 0.96f64.sqrt(), 0.0];
        assert!(!surface(rhombs).has_even_cells());
        assert!(!Builtin::Sphere.surface(12, 12).unwrap().has_even_cells());
    }
}

//! Finds the corners of holes, around which paths bend.

use glam::DVec2;
use rayon::prelude::*;

use geosweep_surface::{Chart, Direction, is_corner};

/// The corners of holes in the region that the map reaches.
#[derive(Clone, Debug, Default)]
pub(super) struct Corners {
    /// Whether each point of the bordered array is a corner. Empty if the map reaches all points.
    is_corner: Vec<bool>,
}

impl Corners {
    /// Finds the corners from the arrival times in a bordered array.
    pub(super) fn new(chart: Chart, times: &[f32]) -> Self {
        let is_reached = |time: &f32| *time < f32::INFINITY;
        if (0..chart.rows).all(|row| chart.row_of(times, row).iter().all(is_reached)) {
            return Self::default();
        }
        let mut corners = vec![false; chart.bordered_points()];
        chart.rows_mut(&mut corners).enumerate().for_each(|(row, corners)| {
            let around = chart.rows_around(times, row);
            for (col, corner) in corners.iter_mut().enumerate() {
                let whole = around.iter().all(|row| row[col..col + 3].iter().all(is_reached));
                let point = chart.bordered(row, col);
                if !whole && is_reached(&times[point]) {
                    let there = |to| is_reached(&times[chart.beside(point, to)]);
                    *corner = is_corner(Direction::ALL.map(there));
                }
            }
        });
        Self { is_corner: corners }
    }

    /// Returns whether the map reaches all points, so that there are no corners.
    pub(super) fn is_none(&self) -> bool {
        self.is_corner.is_empty()
    }

    /// Returns whether a point of the bordered array is a corner.
    pub(super) fn is_corner(&self, point: usize) -> bool {
        self.is_corner.get(point) == Some(&true)
    }

    /// Returns the corners at the ends of the edge on which the place `at` lies, or the corner at the place
    /// itself.
    pub(super) fn beside(&self, chart: Chart, at: DVec2) -> impl Iterator<Item = DVec2> {
        let on_edge = at.x.fract() == 0.0 || at.y.fract() == 0.0;
        let (first, last) = (at.floor(), at.ceil());
        let ends = [(on_edge, first), (on_edge && last != first, last)];
        ends.into_iter()
            .filter(|(is_end, _)| *is_end)
            .map(|(_, end)| end)
            .filter(move |end| self.is_corner(chart.bordered(end.x as usize, end.y as usize)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const CHART: Chart = Chart { rows: 5, cols: 7 };

    fn corners_without(holes: &[(usize, usize)]) -> (Corners, Vec<(usize, usize)>) {
        let mut times = vec![f32::INFINITY; CHART.bordered_points()];
        for (row, col) in CHART.places().filter(|at| !holes.contains(at)) {
            times[CHART.bordered(row, col)] = 1.0;
        }
        let corners = Corners::new(CHART, &times);
        let is_corner = |&(row, col): &(usize, usize)| corners.is_corner(CHART.bordered(row, col));
        let found = CHART.places().filter(is_corner).collect();
        (corners, found)
    }

    #[test]
    fn corners_surround_holes() {
        let (whole, none) = corners_without(&[]);
        assert!(whole.is_none() && none.is_empty());
        // Points on the border of the grid are not corners, even beside a hole that reaches the border.
        assert_eq!(corners_without(&[(2, 3)]).1, [(1, 3), (2, 2), (2, 4), (3, 3)]);
        assert_eq!(corners_without(&[(0, 3), (1, 3)]).1, [(1, 2), (1, 4), (2, 3)]);
        assert_eq!(corners_without(&[(0, 0)]).1, []);
    }

    #[test]
    fn places_on_edges_are_beside_their_ends() {
        let (corners, _) = corners_without(&[(2, 3)]);
        let beside = |row, col| corners.beside(CHART, DVec2::new(row, col)).collect::<Vec<_>>();
        assert_eq!(beside(1.0, 3.0), [DVec2::new(1.0, 3.0)]);
        assert_eq!(beside(0.25, 3.0), [DVec2::new(1.0, 3.0)]);
        assert_eq!(beside(2.0, 1.5), [DVec2::new(2.0, 2.0)]);
        assert_eq!(beside(1.5, 2.5), []);
        assert_eq!(beside(0.0, 0.5), []);
    }
}

//! Refines a floor plan to a grid twice as fine.

use glam::DVec2;

use super::floor_plan::has_numbers;
use super::{Direction, Surface};

impl Surface {
    /// Returns a floor plan ([`Self::is_floor_plan`]) with an additional point between any two neighbours.
    /// Row r and column c become 2 r and 2 c, and holes keep their outlines. Returns `None` on other
    /// surfaces, and if the result would have too many points for a floor plan.
    #[doc(hidden)]
    pub fn halved_floor(&self) -> Option<Self> {
        let grid = self.floor()?;
        let chart = self.chart().refined();
        if !has_numbers(chart) {
            return None;
        }
        let position = |(row, col)| grid.at(0.5 * DVec2::new(row as f64, col as f64));
        let positions = chart.places().map(position).collect();
        let there: Vec<_> =
            chart.places().map(|(row, col)| self.is_between_neighbours(row, col)).collect();
        let plane = Self::from_positions(chart.rows, chart.cols, positions).ok()?;
        plane.with_mask(&there).ok()
    }

    /// Returns whether a place, given in half rows and columns, is a grid point or lies on an edge.
    fn is_between_neighbours(&self, row: usize, col: usize) -> bool {
        let (r, c) = (row / 2, col / 2);
        let has_edge = |row, col, to| self.has_edge(row, col, to);
        match (row % 2, col % 2) {
            (0, 0) => self.has(r, c),
            (0, _) => has_edge(r, c, Direction::East),
            (_, 0) => has_edge(r, c, Direction::South),
            _ => has_edge(r, c, Direction::SouthEast) || has_edge(r, c + 1, Direction::SouthWest),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Spacing;

    #[test]
    fn outlines_stay() {
        // Two holes with a diagonal edge between them. Cells beside each hole are cut in half.
        let floor = [
            [true, true, true, true],
            [true, false, true, true],
            [true, true, false, true],
            [true, true, true, true],
        ];
        let spacing = Spacing { dx: 2.0, dy: 1.0 };
        let plane = Surface::from_heights(4, 4, vec![7.0; 16], spacing).unwrap();
        let surface = plane.with_mask(floor.as_flattened()).unwrap();
        let fine = surface.halved_floor().unwrap();
        let sign = |index: usize| if fine.present()[index] { '#' } else { '.' };
        let rows: Vec<String> =
            (0..7).map(|row| (7 * row..7 * row + 7).map(sign).collect()).collect();
        assert_eq!(
            rows,
            ["#######", "##.####", "#...###", "##...##", "###...#", "####.##", "#######"],
            "{rows:?}"
        );
        let length = |surface: &Surface, step: DVec2| surface.floor().unwrap().length(step);
        let step = DVec2::new(2.0, -6.0);
        approx::assert_relative_eq!(length(&fine, step), length(&surface, 0.5 * step));
    }

    #[test]
    fn other_surfaces_are_not_halved() {
        let heights = (0..16).map(|k| f64::from(k * k)).collect();
        let hill = Surface::from_heights(4, 4, heights, Spacing::square(1.0)).unwrap();
        assert!(hill.halved_floor().is_none());
        let large = Surface::from_heights(4000, 4000, vec![0.0; 16_000_000], Spacing::square(1.0));
        let large = large.unwrap();
        assert!(large.is_floor_plan() && large.halved_floor().is_none());
    }
}

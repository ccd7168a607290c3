//! Represents the place where a path enters a cell.

use glam::DVec2;

use super::cell::{ALONG, SIDES};
use super::place::Place;
use geosweep_surface::{Chart, Direction};

/// The place where a path enters a cell.
#[derive(Clone, Copy, Debug)]
pub(super) struct Entry {
    pub north_west: usize,
    /// The row and column of the north-western corner.
    pub corner: DVec2,
    /// The side of the cell that the path crosses, as an index of [`SIDES`]. `share` is the place on that
    /// side, as a fraction from its first corner.
    pub side: usize,
    pub share: f64,
}

// These functions are inlined, since they run for every line. Otherwise, numbers would be stored one by one
// and read back together, and the load would stall until all stores are done.
impl Entry {
    /// Returns the entry into the cell beyond the edge on which `place` lies. The path comes through the cell
    /// `from`.
    pub(super) fn beyond(chart: Chart, place: Place, from: usize) -> Option<Self> {
        let Place::Edge { first, along, share } = place else { return None };
        let (back, sides) = match along {
            Direction::East => (Direction::North, [0, 3]),
            _ => (Direction::West, [1, 2]),
        };
        let (north_west, side) =
            if first == from { (chart.beside(first, back), sides[1]) } else { (first, sides[0]) };
        Some(Self { north_west, corner: chart.bordered_place(north_west), side, share })
    }

    /// Converts the place at which a path leaves a cell into the entry into the next cell.
    #[inline(always)]
    pub(super) fn across(
        chart: Chart,
        north_west: usize,
        corner: DVec2,
        side: usize,
        share: f64,
    ) -> Self {
        let to = match side {
            0 => Direction::North,
            1 => Direction::West,
            2 => Direction::East,
            _ => Direction::South,
        };
        let (north_west, corner) = (chart.beside(north_west, to), corner + to.vector());
        Self { north_west, corner, side: SIDES.len() - 1 - side, share }
    }

    /// Returns the row and column within the cell.
    #[inline(always)]
    pub(super) fn inside(&self) -> DVec2 {
        // Corner indices are 2 * row + column.
        let [first, last] =
            SIDES[self.side].map(|corner| DVec2::new((corner / 2) as f64, (corner % 2) as f64));
        first + self.share * (last - first)
    }

    /// Returns the row and column of the place.
    #[inline(always)]
    pub(super) fn at(&self) -> DVec2 {
        self.corner + self.inside()
    }

    #[inline(always)]
    pub(super) fn place(&self, chart: Chart) -> Place {
        let first = chart.bordered_corners(self.north_west)[SIDES[self.side][0]];
        Place::Edge { first, along: ALONG[self.side], share: self.share }
    }
}

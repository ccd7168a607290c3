//! Where a path enters a cell.

use glam::DVec2;

use super::cell::{ALONG, SIDES};
use super::place::Place;
use crate::surface::{Chart, Direction};

/// Where a path enters a cell.
#[derive(Clone, Copy, Debug)]
pub(super) struct Entry {
    pub north_west: usize,
    /// Its row and column.
    pub corner: DVec2,
    /// Over which of the cell's [`SIDES`], and at which share of it.
    pub side: usize,
    pub share: f64,
}

// Inlined, all that goes with every line: numbers that are stored one by one and read back as one
// would wait for one another.
impl Entry {
    /// That of a place on the edge of the cell `from` which a path comes, into the one beyond.
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

    /// The same place as one that leads out of a cell.
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

    /// Row and column in the cell.
    #[inline(always)]
    pub(super) fn inside(&self) -> DVec2 {
        // Corners count rows by two and columns by one.
        let [first, last] =
            SIDES[self.side].map(|corner| DVec2::new((corner / 2) as f64, (corner % 2) as f64));
        first + self.share * (last - first)
    }

    /// Row and column.
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

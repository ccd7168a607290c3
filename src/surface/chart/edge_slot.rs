//! Which point the length of an edge is stored at.

use super::{Chart, Direction};

/// The directions stored at a point, in this order, here and in the shaders.
pub(crate) const STORED: [Direction; 4] =
    [Direction::East, Direction::North, Direction::NorthEast, Direction::NorthWest];

/// Where the length of an edge is stored: an offset from the point, and one of [`STORED`].
#[derive(Clone, Copy, Debug)]
pub(crate) struct EdgeSlot {
    pub offset: isize,
    pub stored: usize,
}

impl EdgeSlot {
    /// Its length at as many points in a row of bordered arrays, one for each of [`STORED`].
    pub(crate) fn row<R>(self, planes: [&[R]; 4], first: usize, points: usize) -> &[R] {
        &planes[self.stored][first.wrapping_add_signed(self.offset)..][..points]
    }

    /// The edge from the point `at` (an offset from the point that the slot is used for).
    pub(crate) fn new(chart: Chart, at: isize, to: Direction) -> Self {
        match STORED.iter().position(|&direction| direction == to) {
            Some(stored) => Self { offset: at, stored },
            None => Self::new(chart, at + chart.offset(to), to.opposite()),
        }
    }
}

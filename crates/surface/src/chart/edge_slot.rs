//! Determines at which point the length of an edge is stored.

use super::{Chart, Direction, Offset};

/// The directions whose edges are stored at a point, in this order, on the CPU and in the shaders.
pub const STORED: [Direction; 4] =
    [Direction::East, Direction::North, Direction::NorthEast, Direction::NorthWest];

/// The storage location of the length of an edge: an offset from the point, and an index into [`STORED`].
#[derive(Clone, Copy, Debug)]
#[doc(hidden)]
pub struct EdgeSlot {
    pub offset: Offset,
    pub stored: usize,
}

impl EdgeSlot {
    /// Returns the lengths of this edge for `points` points of a row, beginning with `first`. `planes` are
    /// bordered arrays, one for each direction of [`STORED`].
    #[doc(hidden)]
    #[inline]
    pub fn row<R>(self, planes: [&[R]; 4], first: usize, points: usize) -> &[R] {
        &planes[self.stored][self.offset.from(first)..][..points]
    }

    /// Returns the slot of a point's edge in the direction `to`.
    #[doc(hidden)]
    #[inline]
    pub fn of(chart: Chart, to: Direction) -> Self {
        Self::new(chart, Offset::NONE, to)
    }

    /// Returns the slot of an edge near a point. The edge leads in the direction `to` from the point that lies
    /// at the offset `at`.
    #[doc(hidden)]
    pub fn new(chart: Chart, at: Offset, to: Direction) -> Self {
        match STORED.iter().position(|&direction| direction == to) {
            Some(stored) => Self { offset: at, stored },
            None => Self::new(chart, at.and(chart.offset(to)), to.opposite()),
        }
    }
}

//! Defines the kinks of a map on edges of the grid, and the data that decide whether an edge has a kink.

use glam::{DMat2, DVec2};

/// A kink on an edge of the grid.
#[derive(Clone, Copy, Debug)]
pub(super) struct Kink {
    pub place: DVec2,
    pub angle: f64,
}

/// A part of a ridge in a triangle: its two nodes, and the kinks there.
pub(super) type Segment = ([u64; 2], [Kink; 2]);

/// The directions in which wavefronts arrive at both ends of an edge, in one plane.
pub(super) struct AtEnds {
    /// The directions at the first and at the last end.
    pub directions: [DVec2; 2],
    /// The metric of the plane.
    pub metric: DMat2,
    /// The vector from the first end to the last one.
    pub step: DVec2,
}

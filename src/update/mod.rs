//! The update: the arrival time at a point from the arrival times at two neighbours.
//!
//! Everything is expressed in the lengths of the triangle's edges. The functions here are the
//! twins of `glsl/update.glsl` and follow the same order of operations.

mod planar;
mod point_source;

pub use planar::planar;
pub use point_source::point_source;

use crate::surface::Real;

/// The shape of the front that an update assumes inside a triangle.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Wavefront {
    /// A straight front (paper, section 3): first-order accurate, for extended sources too.
    Planar,
    /// A circular front around a virtual point source: exact on developable surfaces but for
    /// the sampling, second-order elsewhere, for point sources.
    PointSource,
}

impl Wavefront {
    /// The name used by the tool and in reports.
    pub fn name(self) -> &'static str {
        match self {
            Self::Planar => "planar",
            Self::PointSource => "point",
        }
    }
}

impl std::fmt::Display for Wavefront {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.name())
    }
}

/// A triangle x0 x1 x2 with arrival times at x1 and x2; the update is for x0.
#[derive(Clone, Copy, Debug)]
pub struct Triangle<R> {
    /// Arrival time at x1.
    pub t1: R,
    /// Arrival time at x2.
    pub t2: R,
    /// Length of x0 x1.
    pub l1: R,
    /// Length of x0 x2.
    pub l2: R,
    /// Length of x1 x2.
    pub c: R,
}

impl<R: Real> Triangle<R> {
    /// The arrival time at x0: [`Real::FAR`] or later if neither x1 nor x2 is reached.
    #[inline]
    pub fn update(self, wavefront: Wavefront) -> R {
        match wavefront {
            Wavefront::Planar => planar(self),
            Wavefront::PointSource => point_source(self),
        }
    }

    /// The Dijkstra step along an edge (paper, eq. 16).
    #[inline]
    pub(crate) fn edge_step(self) -> R {
        (self.t1 + self.l1).min(self.t2 + self.l2)
    }

    /// Whether all three edges exist and none has zero length.
    #[inline]
    pub(crate) fn is_proper(self) -> bool {
        self.l1.max(self.l2).max(self.c) < R::FAR && self.l1.min(self.l2).min(self.c) > R::zero()
    }
}

//! Computes the update: the arrival time at a point from the arrival times at two neighbours.
//!
//! All formulas are in terms of the lengths of the triangle's edges. The functions are the twins of the kinds
//! in `glsl/update/wavefront.glsl`, with the same order of operations. They compute every case and select a
//! result without branches, so that compilers vectorize rows of points.

mod anchor;
mod anchored;
mod carried;
mod circular;
mod course;
#[cfg(feature = "twins")]
mod crossing;
mod curvature;
mod curved;
mod inside;
mod planar;
mod rays;
mod slowed;
mod wavefront;

#[doc(hidden)]
pub use anchor::Anchor;
#[doc(hidden)]
pub use anchored::{Floor, is_shorter};
#[doc(hidden)]
pub use carried::{Carried, EXACT, EXCHANGED, SEED, StoredFront, tag_of};
pub use circular::circular;
#[doc(hidden)]
pub use course::{CarriedRay, Course};
#[cfg(feature = "twins")]
#[doc(hidden)]
pub use crossing::base_crossing;
#[doc(hidden)]
pub use curvature::Curvature;
#[doc(hidden)]
pub use curved::curved_at;
pub use curved::{Curvatures, Front, curved};
#[doc(hidden)]
pub use inside::InsideSources;
pub use planar::planar;
#[doc(hidden)]
pub use rays::{FrontOfOne, RayApex, RayEnd, RayFront, of_one_front, rays};
#[doc(hidden)]
pub use slowed::{
    curved_slowed, curved_slowed_at, is_settled as is_settled_slowed, is_uneven, planar_slowed,
    planar_slowed_at,
};
pub use wavefront::Wavefront;
#[doc(hidden)]
pub use wavefront::{EngineKind, Setting, SourceKind, Unsuited};

use crate::constants::UPRIGHT;
use crate::{Real, is_obtuse, max, min};

/// A triangle x0 x1 x2 with arrival times at x1 and x2. The update is for x0.
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
    /// Returns the arrival time along an edge, the Dijkstra step (paper, eq. 16).
    #[inline(always)]
    fn edge_step(self) -> R {
        min(self.t1 + self.l1, self.t2 + self.l2)
    }

    /// Returns this triangle, or only its edges if it is obtuse at x0; see `surface/unfold.rs`.
    #[inline(always)]
    #[doc(hidden)]
    pub fn without_obtuse_face(self) -> Self {
        Self { c: if self.is_obtuse() { R::FAR } else { self.c }, ..self }
    }

    /// Returns whether the triangle is obtuse at x0.
    #[inline(always)]
    #[doc(hidden)]
    pub fn is_obtuse(self) -> bool {
        let Self { l1, l2, c, .. } = self;
        let per_base = c.recip();
        let [side, other] = [l1 * per_base, l2 * per_base];
        (c < R::FAR) & is_obtuse(side * side, other * other)
    }

    /// Returns this triangle with x1 and x2 exchanged.
    #[inline(always)]
    #[doc(hidden)]
    pub fn mirrored(self) -> Self {
        let Self { t1, t2, l1, l2, c } = self;
        Self { t1: t2, t2: t1, l1: l2, l2: l1, c }
    }
}

/// The shape of a triangle in units of its base x1 x2, seen from one end of the base. Computing it takes one
/// division, and does not overflow in any unit of length.
struct Shape<R> {
    /// 1 over the length of the base.
    per_base: R,
    /// Distance from this end of the base to x0.
    side: R,
    /// Distance from the other end of the base to x0.
    other: R,
    /// Distance from this end of the base to the foot of x0 on the base.
    foot: R,
    /// Square of the height of x0 over the base. It is positive only if all three edges exist and are the
    /// sides of a triangle with an area.
    height_squared: R,
    /// Whether all three edges exist and the triangle has an area.
    whole: bool,
}

impl<R: Real> Shape<R> {
    /// Computes the shape from the lengths of three edges.
    ///
    /// Chords are always the sides of a triangle. Lengths that are weighted by a slowness or taken from a
    /// metric need not be: an edge that is longer than the path around it is not a shortest path. A front
    /// across such a "triangle" would arrive too early, or before it left.
    #[inline(always)]
    fn new(side: R, other: R, base: R) -> Self {
        let exists = (side < R::FAR) & (other < R::FAR) & (base < R::FAR);
        let per_base = R::one() / base;
        let (side, other) = (side * per_base, other * per_base);
        let foot = R::of(0.5) * ((side * side - other * other) + R::one());
        let height_squared = (side - foot) * (side + foot);
        let whole = (height_squared > R::zero()) & exists;
        Self { per_base, side, other, foot, height_squared, whole }
    }

    /// Computes the shape from edges that are weighted by a slowness. `of_side` and `of_other` are the mean
    /// slownesses along these two edges, divided by the mean slowness along the base.
    #[inline(always)]
    fn on_surface([side, other, base]: [R; 3], [of_side, of_other]: [R; 2]) -> Self {
        let exists = (side < R::FAR) & (other < R::FAR) & (base < R::FAR);
        let shape = Self::new(side / of_side, other / of_other, base);
        Self { whole: shape.whole & exists, ..shape }
    }

    /// Returns whether the triangle is obtuse at x0.
    #[inline(always)]
    fn is_obtuse(&self) -> bool {
        is_obtuse(self.side * self.side, self.other * self.other)
    }

    /// Returns whether no angle is obtuse by more than a few degrees, as in cells that are not sheared. Then
    /// no triangle beside this one lets points depend on one another in a cycle.
    #[inline(always)]
    fn is_upright(&self) -> bool {
        let (side, other) = (self.side * self.side, self.other * self.other);
        let longest = max(max(side, other), R::one());
        longest < R::of(UPRIGHT) * (side + other + R::one() - longest)
    }
}

/// The shape of two edges at x0 and their base, for coefficients that are computed once. It makes the same
/// distinctions as `Shape`, in double precision and in the surface's units.
pub enum Corner {
    /// A triangle with an area.
    Triangle {
        /// Distance from x1 to the foot of x0 on the base.
        foot: f64,
        /// Height of x0 over the base.
        height: f64,
        /// Length of the base.
        base: f64,
    },
    /// Two edges that do not span a triangle.
    Edges,
    /// A single edge, of this length.
    Edge(f32),
    /// Neither edge exists.
    Nothing,
}

impl Corner {
    #[doc(hidden)]
    pub fn new(l1: f32, l2: f32, c: f32) -> Self {
        let there = |length: f32| length < f32::FAR;
        match (there(l1), there(l2)) {
            (false, false) => return Self::Nothing,
            (true, false) => return Self::Edge(l1),
            (false, true) => return Self::Edge(l2),
            (true, true) => {}
        }
        let base = f64::from(c);
        let shape = Shape::new(f64::from(l1), f64::from(l2), base);
        if there(c) && shape.whole {
            let height = base * shape.height_squared.sqrt();
            Self::Triangle { foot: base * shape.foot, height, base }
        } else {
            Self::Edges
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn without_a_triangle_the_front_runs_along_the_edges() {
        // In the first three cases one edge is longer than the sum of the others; in the last the base has no length.
        for (l1, l2, c) in [(1.0, 1.0, 3.0), (3.0, 1.0, 1.0), (1.0, 3.0, 1.0), (1.0, 1.0, 0.0)] {
            for (t1, t2) in [(2.0, 2.0), (2.0, 3.5), (4.5, 2.0)] {
                let triangle = Triangle { t1, t2, l1, l2, c };
                let edge_step = f64::min(t1 + l1, t2 + l2);
                let curvatures =
                    Curvatures { fronts: [0.5; 2], surface: [0.0; 3], alone: false, causal: false };
                let curved = curved(triangle, curvatures).time;
                for time in [planar(triangle), circular(triangle, false), curved] {
                    assert_eq!(time, edge_step, "{triangle:?}");
                }
            }
        }
    }
}

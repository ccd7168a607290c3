//! Provides the triangles of a span of points together with the slowness at their corners.

use crate::lines::span::Span;
use geosweep_surface::Real;
use geosweep_surface::update::{Carried, Triangle};

/// A span of points, with the slowness at each point and at the neighbours behind.
pub(super) struct Seen<'s, R, C, G, O, B> {
    pub span: &'s Span<'s, R, C, G>,
    /// Slowness at point `i`.
    pub own: O,
    /// Slowness at the neighbour `k` behind point `i`.
    pub behind: B,
}

impl<R: Real, C: Carried, G, O: Fn(usize) -> R, B: Fn(usize, usize) -> R> Seen<'_, R, C, G, O, B> {
    /// Returns one of the two triangles of point `i`, and the slowness at x0, x1 and x2. An obtuse triangle
    /// is reduced to its edges.
    #[inline(always)]
    pub(super) fn triangle<const LEFT: bool>(&self, i: usize) -> (Triangle<R>, [R; 3]) {
        let x1 = if LEFT { 0 } else { 1 };
        let slowness = [(self.own)(i), (self.behind)(x1, i), (self.behind)(x1 + 1, i)];
        let triangle = self.span.weighted_triangle::<LEFT>(i);
        (triangle.without_obtuse_face_on_surface(slowness), slowness)
    }

    /// Returns the triangle of [`Self::triangle`], with the neighbour across the grid's diagonal as x1.
    #[inline(always)]
    pub(super) fn seen_from_beside<const LEFT: bool>(&self, i: usize) -> (Triangle<R>, [R; 3]) {
        let (triangle, slowness) = self.triangle::<LEFT>(i);
        let [own, x1, x2] = slowness;
        if LEFT { (triangle, slowness) } else { (triangle.mirrored(), [own, x2, x1]) }
    }
}

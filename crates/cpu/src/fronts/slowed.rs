//! Provides the triangles of a span of points together with the slowness at their corners.

use crate::behind::Behind;
use crate::lines::span::{Before, Span};
use crate::scan::Scan;
use geosweep_surface::Real;
use geosweep_surface::update::{Carried, Triangle};

/// A span of points, with the slowness at each point and at the neighbours behind.
pub(super) struct Seen<'s, R, C, G, S> {
    pub span: &'s Span<'s, R, C, G>,
    /// Surface data at the neighbours behind each point.
    pub behind: [&'s [G]; 3],
    /// Returns the slowness in the data of a point.
    pub slowness: S,
}

impl<'s, R: Real, C: Carried, G: Copy, S: Fn(G) -> R> Seen<'s, R, C, G, S> {
    /// Creates the span that begins at point `first`, with the fronts from before a scan.
    #[inline(always)]
    pub(super) fn before(
        before: &Before<'s, R, C, G>,
        first: usize,
        span: &'s Span<'s, R, C, G>,
        points: usize,
        scan: Scan,
        slowness: S,
    ) -> Self {
        let at = Behind::of(before.edges.chart(), scan).points().map(|offset| offset.from(first));
        Self { span, behind: at.map(|at| &before.surface_data[at..][..points]), slowness }
    }

    /// Returns one of the two triangles of point `i`, and the slowness at x0, x1 and x2. An obtuse triangle
    /// is reduced to its edges.
    #[inline(always)]
    pub(super) fn triangle<const LEFT: bool>(&self, i: usize) -> (Triangle<R>, [R; 3]) {
        let x1 = if LEFT { 0 } else { 1 };
        let data = [self.span.surface_data[i], self.behind[x1][i], self.behind[x1 + 1][i]];
        let slowness = data.map(&self.slowness);
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

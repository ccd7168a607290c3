//! Provides the triangles of a span of points together with the slowness at their corners.

use crate::lines::span::{Before, Span, TILE, part};
use crate::scan::Scan;
use geosweep_surface::Real;
use geosweep_surface::update::{Carried, Triangle, is_uneven};

/// Data of the surface at each point of a span and at the neighbours behind it: before, beside and after it. Each number
/// has an array of its own, since compilers do not use all SIMD lanes where numbers alternate. The span itself is passed
/// beside this data: within it, compilers would lose sight of the lengths of its slices.
pub(super) struct Seen<R> {
    pub own: SurfaceLanes<R>,
    pub behind: [SurfaceLanes<R>; 3],
}

/// Data of the surface at the points of a span.
pub(super) struct SurfaceLanes<R> {
    pub slowness: [R; TILE],
    /// The Gaussian curvature, for fronts that need it.
    pub gaussian: [R; TILE],
}

impl<R: Real> SurfaceLanes<R> {
    #[inline(always)]
    fn new<G>(data: &[G], points: usize, numbers: impl Fn(&G) -> [R; 2]) -> Self {
        let mut lanes = Self { slowness: [R::one(); TILE], gaussian: [R::zero(); TILE] };
        for (i, data) in data[..points].iter().enumerate() {
            let [gaussian, slowness] = numbers(data);
            (lanes.gaussian[i], lanes.slowness[i]) = (gaussian, slowness);
        }
        lanes
    }
}

impl<R: Real> Seen<R> {
    /// Collects the data of a span, given those behind it. `numbers` returns the Gaussian curvature and the slowness
    /// in the data of a point.
    #[inline(always)]
    pub(super) fn new<C, G>(
        span: &Span<'_, R, C, G>,
        [before, beside, after]: [&[G]; 3],
        points: usize,
        numbers: impl Fn(&G) -> [R; 2] + Copy,
    ) -> Self {
        let lanes = |data| SurfaceLanes::new(data, points, numbers);
        let behind = [lanes(before), lanes(beside), lanes(after)];
        Self { own: lanes(span.surface_data), behind }
    }

    /// Collects the data of a span that begins at point `first`, with the fronts from before a scan.
    #[inline(always)]
    pub(super) fn before<C: Carried, G>(
        before: &Before<'_, R, C, G>,
        first: usize,
        span: &Span<'_, R, C, G>,
        points: usize,
        scan: Scan,
        numbers: impl Fn(&G) -> [R; 2] + Copy,
    ) -> Self {
        // Compilers do not always inline `map` of arrays into such long loops.
        let (chart, [a, b, c]) = (before.edges.chart(), scan.behind());
        let at = |to| part(before.surface_data, chart.offset(to).from(first), points);
        Self::new(span, [at(a), at(b), at(c)], points, numbers)
    }

    /// Returns one of the two triangles of point `i`, and the slowness at x0, x1 and x2.
    #[inline(always)]
    pub(super) fn triangle<C: Carried, G, const LEFT: bool>(
        &self,
        span: &Span<'_, R, C, G>,
        i: usize,
    ) -> (Triangle<R>, [R; 3]) {
        (span.weighted_triangle::<LEFT>(i), self.slownesses::<LEFT>(i))
    }

    /// Returns the triangle of [`Self::triangle`], with the neighbour across the grid's diagonal as x1.
    #[inline(always)]
    pub(super) fn seen_from_across<C: Carried, G, const LEFT: bool>(
        &self,
        span: &Span<'_, R, C, G>,
        i: usize,
    ) -> (Triangle<R>, [R; 3]) {
        let (triangle, slowness) = self.triangle::<C, G, LEFT>(span, i);
        let [own, x1, x2] = slowness;
        if LEFT { (triangle, slowness) } else { (triangle.mirrored(), [own, x2, x1]) }
    }

    /// Returns whether the slowness is uneven ([`is_uneven`]) in any triangle of the points.
    #[inline(always)]
    pub(super) fn is_uneven(&self, points: usize) -> bool {
        let mut uneven = false;
        for i in 0..points {
            let (left, right) = (self.slownesses::<true>(i), self.slownesses::<false>(i));
            uneven |= is_uneven(left) | is_uneven(right);
        }
        uneven
    }

    #[inline(always)]
    fn slownesses<const LEFT: bool>(&self, i: usize) -> [R; 3] {
        let x1 = if LEFT { 0 } else { 1 };
        [self.own.slowness[i], self.behind[x1].slowness[i], self.behind[x1 + 1].slowness[i]]
    }
}

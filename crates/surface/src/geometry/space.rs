//! Computes lengths between neighbouring grid points. Each kind of geometry is a type of its own, so that
//! loops over a row have no branches.

use crate::real::{Real, max};

/// A grid point in some precision: the three numbers of its geometry ([`Geometry::numbers`]), and its
/// slowness, which is 0 in a hole.
pub(crate) type Point<R> = [R; 4];

/// A space in which the distances of neighbouring points are measured.
pub(crate) trait Space<R: Real>: Copy {
    /// Whether grid lines have no corners, so that the lengths of their steps do not jump.
    const HAS_EVEN_STEPS: bool;

    /// Returns the vector from a point to its neighbour. A surface given only by its metric has no such
    /// vector.
    fn difference(self, a: Point<R>, b: Point<R>, step: (isize, isize)) -> [R; 3];

    /// Returns the length of the straight step between two neighbouring points, without slowness.
    #[inline(always)]
    fn separation(self, a: Point<R>, b: Point<R>, step: (isize, isize)) -> R {
        let d = self.difference(a, b, step);
        ((d[0] * d[0] + d[1] * d[1]) + d[2] * d[2]).sqrt()
    }
}

#[derive(Clone, Copy)]
pub(crate) struct Positions<const CORNERS: bool>;

#[derive(Clone, Copy)]
pub(crate) struct Heights<R> {
    pub dx: R,
    pub dy: R,
}

#[derive(Clone, Copy)]
pub(crate) struct Metric;

impl<R: Real, const CORNERS: bool> Space<R> for Positions<CORNERS> {
    const HAS_EVEN_STEPS: bool = !CORNERS;

    #[inline(always)]
    fn difference(self, a: Point<R>, b: Point<R>, _: (isize, isize)) -> [R; 3] {
        [b[0] - a[0], b[1] - a[1], b[2] - a[2]]
    }
}

impl<R: Real> Space<R> for Heights<R> {
    const HAS_EVEN_STEPS: bool = true;

    #[inline(always)]
    fn difference(self, a: Point<R>, b: Point<R>, (down, right): (isize, isize)) -> [R; 3] {
        [R::of(right as f64) * self.dx, R::of(down as f64) * self.dy, b[2] - a[2]]
    }
}

impl<R: Real> Space<R> for Metric {
    const HAS_EVEN_STEPS: bool = true;

    #[inline(always)]
    fn difference(self, _: Point<R>, _: Point<R>, _: (isize, isize)) -> [R; 3] {
        [R::zero(); 3]
    }

    /// Returns the length that, times the mean slowness of both points, equals the mean of the products of
    /// slowness and length at the two points. So a metric that is split into a slowness and a shape keeps its
    /// edge lengths.
    #[inline(always)]
    fn separation(self, a: Point<R>, b: Point<R>, step: (isize, isize)) -> R {
        let both = max(a[3] + b[3], R::min_positive_value());
        (a[3] * metric_length(a, step) + b[3] * metric_length(b, step)) / both
    }
}

#[inline(always)]
fn metric_length<R: Real>(g: Point<R>, step: (isize, isize)) -> R {
    let (down, right) = (R::of(step.0 as f64), R::of(step.1 as f64));
    let mixed = g[1] * (R::of(2.0) * right * down);
    max((g[0] * (down * down) + mixed) + g[2] * (right * right), R::zero()).sqrt()
}

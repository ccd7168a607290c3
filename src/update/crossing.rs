//! Where the way of a front to x0 crosses the base of its triangle.

use super::{Shape, Triangle, Wavefront};
use crate::surface::{Real, max, min};

/// Where the straight line on which the front arrives at x0 crosses the base, from 0 at x1 to 1 at
/// x2: at one of these if the front runs along an edge, or if one of them is not reached. The fronts'
/// curvatures at x1 and x2 count for the curved wavefront alone.
///
/// The twin of `glsl/base_crossing.glsl`; what is said of the front is what the updates say.
pub(crate) fn base_crossing<R: Real>(
    wavefront: Wavefront,
    triangle: Triangle<R>,
    [k1, k2]: [R; 2],
) -> R {
    let Triangle { t1, t2, l1, l2, c } = triangle;
    let (zero, one, half) = (R::zero(), R::one(), R::of(0.5));
    let swap = t1 < t2;
    let (t, near_t) = if swap { (t2, t1) } else { (t1, t2) };
    let (k, near_k) = if swap { (k2, k1) } else { (k1, k2) };
    let (l, near_l) = if swap { (l2, l1) } else { (l1, l2) };
    let shape = Shape::new(l, near_l, c);
    let d = (near_t - t) * shape.per_base;
    let kappa = match wavefront {
        Wavefront::Planar => zero,
        Wavefront::PointSource => c / max(t, R::of(0.25) * c),
        Wavefront::Curved => {
            let near_kappa = near_k * c;
            let passed = near_kappa / max(one - near_kappa * d, R::of(crate::constants::FOCUS));
            half * (passed + if k < R::SOURCE { k * c } else { passed })
        }
    };
    let h = max(shape.height_squared, zero).sqrt();
    let cos_a = half * kappa * ((one - d) * (one + d)) - d;
    let sin_a = max((one - cos_a) * (one + cos_a), zero).sqrt();
    let crossing = cos_a * h + sin_a * shape.foot;
    let width = sin_a + kappa * h;
    let is_front = shape.whole & (d > -one) & (cos_a <= one) & (width > zero);
    let along_edge = if t + l <= near_t + near_l { zero } else { one };
    let from_far = if is_front { max(min(crossing / width, one), zero) } else { along_edge };
    if swap { one - from_far } else { from_far }
}

//! Computes where the path of a front to x0 crosses the base of its triangle.

use super::{Shape, Triangle, Wavefront};
use crate::constants::{ABOUT_STRAIGHT, ALONG_BASE, FOCUS, FROM_SOURCE, STRADDLING};
use crate::{Real, Seed, max, min};

/// Returns where the straight line on which the front arrives at x0 crosses the base, from 0 at x1 to 1 at
/// x2. The result is 0 or 1 if the front runs along an edge, or if one end of the base has not been reached.
/// The curvatures of the fronts at x1 and x2 are used by the curved wavefront only.
///
/// The twin of `glsl/update/base_crossing.glsl`. The shape of the front is computed as in the updates.
pub fn base_crossing<R: Real>(wavefront: Wavefront, triangle: Triangle<R>, [k1, k2]: [R; 2]) -> R {
    let Triangle { t1, t2, l1, l2, c } = triangle;
    let (zero, one, half) = (R::zero(), R::one(), R::of(0.5));
    let at_source = R::of(Seed::AT_SOURCE);
    let swap = t1 < t2;
    let (t, near_t) = if swap { (t2, t1) } else { (t1, t2) };
    let (k, near_k) = if swap { (k2, k1) } else { (k1, k2) };
    let (l, near_l) = if swap { (l2, l1) } else { (l1, l2) };
    let shape = Shape::new(l, near_l, c);
    let d = (near_t - t) * shape.per_base;
    let kappa = match wavefront {
        Wavefront::Planar => zero,
        Wavefront::Circular | Wavefront::Anchored => c / max(t, R::of(0.25) * c),
        Wavefront::Curved | Wavefront::Rays => {
            let beside = (near_k >= at_source)
                & ((k * c).abs() < R::of(ABOUT_STRAIGHT))
                & (d > R::of(-FROM_SOURCE));
            let near_kappa = if beside { k * c } else { near_k * c };
            let passed = near_kappa / max(one - near_kappa * d, R::of(FOCUS));
            half * (passed + if k < at_source { k * c } else { passed })
        }
    };
    let h = max(shape.height_squared, zero).sqrt();
    let cos_a = half * kappa * ((one - d) * (one + d)) - d;
    let sin_a = max((one - cos_a) * (one + cos_a), zero).sqrt();
    let crossing = cos_a * h + sin_a * shape.foot;
    let width = sin_a + kappa * h;
    let of_one = (d > R::of(-ALONG_BASE)) & (kappa * (one - d) <= R::of(STRADDLING));
    let is_front = shape.whole & of_one & (width > zero);
    let along_edge = if t + l <= near_t + near_l { zero } else { one };
    let from_far = if is_front { max(min(crossing / width, one), zero) } else { along_edge };
    if swap { one - from_far } else { from_far }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec2;

    const X1: DVec2 = DVec2::new(0.0, 0.0);
    const X2: DVec2 = DVec2::new(1.0, 0.2);
    const X0: DVec2 = DVec2::new(0.4, 0.9);

    fn triangle(t1: f64, t2: f64) -> Triangle<f64> {
        Triangle { t1, t2, l1: X0.distance(X1), l2: X0.distance(X2), c: X1.distance(X2) }
    }

    /// Returns the position on the base at which the line from a point to x0 crosses it.
    fn exact(from: DVec2) -> f64 {
        let (along, to) = (X2 - X1, X0 - from);
        (from - X1).perp_dot(to) / along.perp_dot(to)
    }

    #[test]
    fn lines_from_points_cross_the_base_where_they_do() {
        for source in [DVec2::new(0.3, -0.8), DVec2::new(0.9, -30.0), DVec2::new(-0.1, -2.0)] {
            let times = [X1, X2].map(|end| source.distance(end));
            let ends = triangle(times[0], times[1]);
            let curvatures = times.map(|time| 1.0 / time);
            let of = |wavefront| base_crossing(wavefront, ends, curvatures);
            approx::assert_abs_diff_eq!(of(Wavefront::Circular), exact(source), epsilon = 1e-12);
            approx::assert_abs_diff_eq!(of(Wavefront::Curved), exact(source), epsilon = 1e-12);
        }
        // A straight front, as from far away.
        let ahead = DVec2::new(0.1, 1.0).normalize();
        let ends = triangle(5.0 + X1.dot(ahead), 5.0 + X2.dot(ahead));
        let found = base_crossing(Wavefront::Planar, ends, [0.0; 2]);
        approx::assert_abs_diff_eq!(found, exact(X0 - ahead), epsilon = 1e-12);
        approx::assert_abs_diff_eq!(
            base_crossing(Wavefront::Curved, ends, [0.0; 2]),
            found,
            epsilon = 1e-12
        );
    }

    #[test]
    fn fronts_along_edges_come_from_their_ends() {
        for wavefront in Wavefront::FOR_ANY_SURFACE {
            let of = |t1, t2| base_crossing(wavefront, triangle(t1, t2), [0.1; 2]);
            assert_eq!((of(2.0, f64::FAR), of(f64::FAR, 2.0)), (0.0, 1.0));
            // The ends differ by more than the length of the base.
            assert_eq!((of(2.0, 9.0), of(9.0, 2.0)), (0.0, 1.0));
            let flat = Triangle { l1: 3.0, l2: 1.0, c: 1.0, t1: 2.0, t2: 2.1 };
            assert_eq!(base_crossing(wavefront, flat, [0.1; 2]), 1.0);
        }
    }
}

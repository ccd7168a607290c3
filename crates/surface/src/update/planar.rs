//! Implements the planar wavefront (paper, section 3, eqs. 6-16).

use super::{Shape, Triangle};
use crate::{Real, max, min};

/// Returns the arrival time at x0 of a straight front that reaches x1 and x2 at t1 and t2.
///
/// In units of the base, with x1 at the origin, let (p, h) be x0. A front with d = t2 - t1 runs at an angle
/// with cosine d to the base, so t0 = t1 + p d + h sqrt(1 - d^2), the larger root of eq. 10. The upwind
/// condition (15) is the interval of d for which the ray to x0 crosses the base between x1 and x2: d |x0 x1|
/// <= p and d |x0 x2| >= p - 1. Outside of this interval the ray runs along an edge (16). The resulting t0 is
/// the minimum over the base of t plus distance (the Hopf-Lax form), which is monotone for every triangle,
/// including obtuse ones. In obtuse triangles, however, t0 is at least the time of the later end of the base.
/// Otherwise two points that each arrive through the other's triangle would make one another earlier forever.
#[inline(always)]
pub fn planar<R: Real>(triangle: Triangle<R>) -> R {
    let Triangle { t1, t2, l1, l2, c } = triangle;
    let along_edge = triangle.edge_step();
    let one = R::one();
    let shape = Shape::new(l1, l2, c);
    let p = shape.foot;
    let d = (t2 - t1) * shape.per_base;
    let upwind = shape.whole & (d * shape.side <= p) & (d * shape.other >= p - one);
    let across = max(shape.height_squared * ((one - d) * (one + d)), R::zero());
    let inside = max(t1 + c * (p * d + across.sqrt()), max(t1, t2));
    min(along_edge, if upwind { inside } else { along_edge })
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;
    use proptest::test_runner::RngSeed;

    use super::*;

    /// Returns the minimum over the edge of t plus distance, by brute force.
    fn hopf_lax(triangle: Triangle<f64>) -> f64 {
        let Triangle { t1, t2, l1, l2, c } = triangle;
        let p = (l1 * l1 - l2 * l2 + c * c) / (2.0 * c);
        let h = (l1 * l1 - p * p).max(0.0).sqrt();
        (0..=100_000)
            .map(|k| k as f64 / 100_000.0)
            .map(|s| t1 + s * (t2 - t1) + (p - s * c).hypot(h))
            .fold(f64::INFINITY, f64::min)
            .max(t1.max(t2))
            .min((t1 + l1).min(t2 + l2))
    }

    #[test]
    fn is_the_minimum_over_the_edge_for_acute_and_obtuse_triangles() {
        for (p, h) in [(0.5, 0.8), (0.1, 0.3), (-0.7, 0.4), (1.6, 0.2), (0.5, 0.05)] {
            let (l1, l2) = (f64::hypot(p, h), f64::hypot(p - 1.0, h));
            for d in [-1.5, -0.9, -0.3, 0.0, 0.2, 0.7, 1.0, 3.0] {
                let triangle = Triangle { t1: 4.0, t2: 4.0 + d, l1, l2, c: 1.0 };
                approx::assert_abs_diff_eq!(planar(triangle), hopf_lax(triangle), epsilon = 1e-9);
            }
        }
    }

    #[test]
    fn solves_the_quadratic_equation_of_the_paper() {
        // Eq. 10 with Q = (X'X)^-1, for a triangle whose ray comes from inside.
        let (x1, x2) = (glam::DVec2::new(1.0, -0.4), glam::DVec2::new(0.9, 0.5));
        let e = glam::DMat2::from_cols_array(&[x1.dot(x1), x1.dot(x2), x1.dot(x2), x2.dot(x2)]);
        let q = e.inverse();
        let (one, t) = (glam::DVec2::ONE, glam::DVec2::new(2.0, 2.1));
        let triangle =
            Triangle { t1: t.x, t2: t.y, l1: x1.length(), l2: x2.length(), c: x1.distance(x2) };
        let t0 = planar(triangle);
        let residual = t0 * t0 * one.dot(q * one) - 2.0 * t0 * one.dot(q * t) + t.dot(q * t) - 1.0;
        approx::assert_abs_diff_eq!(residual, 0.0, epsilon = 1e-12);
    }

    /// Generates triangles of any shape, including obtuse ones and needles, with times that a front can have:
    /// they differ by at most the length of the base.
    fn triangles() -> impl Strategy<Value = Triangle<f64>> {
        let corner = (-2.0..3.0, 1e-3..2.0);
        (corner, 0.0..10.0, -1.0..=1.0).prop_map(|((p, h), t1, d): ((f64, f64), f64, f64)| {
            let (l1, l2) = (f64::hypot(p, h), f64::hypot(p - 1.0, h));
            Triangle { t1, t2: t1 + d, l1, l2, c: 1.0 }
        })
    }

    proptest! {
        #![proptest_config(ProptestConfig { failure_persistence: None,
            rng_seed: RngSeed::Fixed(18), ..ProptestConfig::with_cases(4000) })]

        /// Monotonicity, one of the paper's requirements on an update (section 3): later neighbours never
        /// make a point earlier.
        #[test]
        fn is_monotone(triangle in triangles(), later in (0.0..1.0, 0.0..1.0)) {
            let Triangle { t1, t2, .. } = triangle;
            let after = Triangle { t1: t1 + later.0, t2: t2 + later.1, ..triangle };
            prop_assert!(planar(after) >= planar(triangle) - 1e-12);
        }

        /// Stability, eqs. 17 and 18: the error of the point is at most as large as a perturbation of the
        /// times.
        #[test]
        fn is_stable(
            triangle in triangles(),
            errors in (-1.0..1.0, -1.0..1.0),
            size in prop::sample::select(vec![1e-9, 1e-6, 1e-3, 0.1]),
        ) {
            let errors: [f64; 2] = [size * errors.0, size * errors.1];
            let Triangle { t1, t2, .. } = triangle;
            let perturbed = Triangle { t1: t1 + errors[0], t2: t2 + errors[1], ..triangle };
            let change = planar(perturbed) - planar(triangle);
            let bound = errors[0].abs().max(errors[1].abs());
            prop_assert!(change.abs() <= bound + 1e-12, "{change} by {errors:?}");
        }

        /// In an acute triangle a point is later than both points from which it is updated, if the front
        /// comes from between them.
        #[test]
        fn is_causal_in_acute_triangles(
            (p, h) in (0.05..0.95, 0.6..2.0),
            d in -1.0..=1.0,
        ) {
            let (p, h, d): (f64, f64, f64) = (p, h, d);
            let (l1, l2) = (f64::hypot(p, h), f64::hypot(p - 1.0, h));
            let t0 = planar(Triangle { t1: 4.0, t2: 4.0 + d, l1, l2, c: 1.0 });
            let comes_between = d * l1 <= p && d * l2 >= p - 1.0;
            prop_assert!(!comes_between || t0 > 4.0 + d.max(0.0), "{t0}");
        }
    }

    #[test]
    fn a_missing_edge_or_time_leaves_the_other() {
        let far = f32::FAR;
        let whole = Triangle { t1: 1.0, t2: 1.2, l1: 1.0, l2: 1.0, c: 1.0f32 };
        assert_eq!(planar(Triangle { t1: far, ..whole }), 2.2);
        assert_eq!(planar(Triangle { l1: far, c: far, ..whole }), 2.2);
        assert!(planar(Triangle { t1: far, t2: far, ..whole }) >= far);
    }
}

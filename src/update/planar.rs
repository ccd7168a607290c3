//! The planar wavefront (paper, section 3, eqs. 6-16).

use super::Triangle;
use crate::surface::Real;

/// The arrival time at x0 of a straight front that reaches x1 and x2 at t1 and t2.
///
/// With x1 at the origin and x2 at distance c, let (p, h) be x0. A front with d = t2 - t1 runs
/// at an angle with cosine d / c to the edge, so t0 = t1 + (p d + h sqrt(c^2 - d^2)) / c, the
/// larger root of eq. 10. The upwind condition (15) is the interval of d for which the ray to x0
/// crosses the edge between x1 and x2; at its ends the ray runs along an edge, so clamping d
/// gives the Dijkstra step (16) without a branch. This is the minimum over the edge of t plus
/// distance (the Hopf-Lax form): monotone for every triangle, obtuse ones included.
#[inline]
pub fn planar<R: Real>(triangle: Triangle<R>) -> R {
    let edge_step = triangle.edge_step();
    if !triangle.is_proper() {
        return edge_step;
    }
    let Triangle { t1, t2, l1, l2, c } = triangle;
    let half = R::of(0.5);
    let skew = l1 * l1 - l2 * l2;
    let cc = c * c;
    let latest = half * (cc + skew) / l1;
    let earliest = half * (skew - cc) / l2;
    let t1 = t1.min(t2 - earliest);
    let d = (t2 - t1).min(latest);
    let p = half * (cc + skew) / c;
    let across = ((l1 - p) * (l1 + p)).max(R::zero()) * ((c - d) * (c + d)).max(R::zero());
    edge_step.min(t1 + (p * d + across.sqrt()) / c)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The minimum over the edge of t plus distance, by brute force.
    fn hopf_lax(triangle: Triangle<f64>) -> f64 {
        let Triangle { t1, t2, l1, l2, c } = triangle;
        let p = (l1 * l1 - l2 * l2 + c * c) / (2.0 * c);
        let h = (l1 * l1 - p * p).max(0.0).sqrt();
        (0..=100_000)
            .map(|k| k as f64 / 100_000.0)
            .map(|s| t1 + s * (t2 - t1) + (p - s * c).hypot(h))
            .fold(f64::INFINITY, f64::min)
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
        // Eq. 10 with Q = (X'X)^-1 for a triangle whose ray comes from inside.
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

    #[test]
    fn a_missing_edge_or_time_leaves_the_other() {
        let far = f32::FAR;
        let whole = Triangle { t1: 1.0, t2: 1.2, l1: 1.0, l2: 1.0, c: 1.0f32 };
        assert_eq!(planar(Triangle { t1: far, ..whole }), 2.2);
        assert_eq!(planar(Triangle { l1: far, c: far, ..whole }), 2.2);
        assert!(planar(Triangle { t1: far, t2: far, ..whole }) >= far);
    }
}

//! Implements the circular front: its virtual source is unfolded into the triangle's plane.

use super::{Shape, Triangle};
use crate::constants::STRADDLING;
use crate::{Real, max, min};

/// Returns the arrival time at x0 of a circular front that reaches x1 and x2 at t1 and t2. If `causal`, a
/// front through the triangle arrives no earlier than t1 and t2, see [`super::Curvatures`].
///
/// The front's virtual source lies at the distances t1 and t2 from x1 and x2, on the opposite side of the
/// base from x0. The time t0 is its distance from x0 if the straight ray crosses the base, else the Dijkstra
/// step. In units of the base, with the farther end at the origin, let a be the angle there between the base
/// and the source, and kappa = 1 / t the front's curvature. Then t0 = t + n / (1 + sqrt(1 + kappa n)) with
/// n = kappa l^2 + 2 (h sin a - p cos a), which loses no digits for flat fronts. Measuring from the farther
/// end keeps kappa below 2 and the result symmetric.
#[inline(always)]
pub fn circular<R: Real>(triangle: Triangle<R>, causal: bool) -> R {
    let Triangle { t1, t2, l1, l2, c } = triangle;
    let along_edge = triangle.edge_step();
    let (zero, one, half) = (R::zero(), R::one(), R::of(0.5));
    let swap = t1 < t2;
    let (t, near) = if swap { (t2, t1) } else { (t1, t2) };
    let (l, other) = if swap { (l2, l1) } else { (l1, l2) };
    let shape = Shape::new(l, other, c);
    let p = shape.foot;
    let h = max(shape.height_squared, zero).sqrt();
    let d = (near - t) * shape.per_base;
    let kappa = c / max(t, R::of(0.25) * c);
    let cos_a = half * kappa * ((one - d) * (one + d)) - d;
    let sin_a = max((one - cos_a) * (one + cos_a), zero).sqrt();
    let crossing = cos_a * h + sin_a * p;
    let width = sin_a + kappa * h;
    // If a base straddles two sources, the times at its ends do not define a source between them.
    let of_one = kappa * (one - d) <= R::of(STRADDLING);
    let upwind = shape.whole & of_one & (crossing >= zero) & (crossing <= width);
    let n = kappa * (shape.side * shape.side) + (h * sin_a - p * cos_a) * R::of(2.0);
    let inside = t + c * (n / (one + max(one + kappa * n, zero).sqrt()));
    let inside = if causal { max(inside, t) } else { inside };
    min(along_edge, if upwind { inside } else { along_edge })
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec2;

    fn from_source(source: DVec2, x0: DVec2, x1: DVec2, x2: DVec2) -> Triangle<f64> {
        Triangle {
            t1: source.distance(x1),
            t2: source.distance(x2),
            l1: x0.distance(x1),
            l2: x0.distance(x2),
            c: x1.distance(x2),
        }
    }

    #[test]
    fn is_exact_wherever_the_ray_crosses_the_edge() {
        let (x1, x2) = (DVec2::new(0.0, 0.0), DVec2::new(1.0, 0.0));
        for x0 in [DVec2::new(0.4, 0.9), DVec2::new(-0.6, 0.5), DVec2::new(1.2, 0.1)] {
            for s in [0.02, 0.3, 0.5, 0.97] {
                for back in [0.01, 0.5, 3.0, 1e4] {
                    let crossing = x1.lerp(x2, s);
                    let source = crossing + back * (crossing - x0).normalize();
                    let t0 = circular(from_source(source, x0, x1, x2), false);
                    approx::assert_relative_eq!(t0, source.distance(x0), max_relative = 1e-11);
                }
            }
        }
    }

    #[test]
    fn tends_to_the_planar_front_far_from_the_source() {
        let triangle = Triangle { t1: 1e9, t2: 1e9 + 0.2, l1: 0.9, l2: 1.1, c: 1.0 };
        let difference = circular(triangle, false) - super::super::planar(triangle);
        approx::assert_abs_diff_eq!(difference, 0.0, epsilon = 1e-6);
    }

    #[test]
    fn is_symmetric_to_the_bit() {
        let triangle = Triangle { t1: 3.3f32, t2: 3.1, l1: 0.9, l2: 1.3, c: 1.1 };
        let Triangle { t1, t2, l1, l2, c } = triangle;
        let mirrored = Triangle { t1: t2, t2: t1, l1: l2, l2: l1, c };
        assert_eq!(circular(triangle, false), circular(mirrored, false));
    }

    #[test]
    fn two_sources_at_the_ends_give_the_edge_step() {
        let triangle = Triangle { t1: 0.0f32, t2: 0.0, l1: 1.0, l2: 1.2, c: 1.0 };
        assert_eq!(circular(triangle, false), 1.0);
        let triangle = Triangle { t1: 0.3f32, t2: 0.4, ..triangle };
        assert_eq!(circular(triangle, false), 1.3);
    }

    #[test]
    fn a_missing_edge_or_time_leaves_the_other() {
        let far = f32::FAR;
        let whole = Triangle { t1: 1.0, t2: 1.2, l1: 1.0, l2: 1.0, c: 1.0f32 };
        assert_eq!(circular(Triangle { t1: far, ..whole }, false), 2.2);
        assert_eq!(circular(Triangle { l1: far, c: far, ..whole }, false), 2.2);
        assert!(circular(Triangle { t1: far, t2: far, ..whole }, false) >= far);
    }
}

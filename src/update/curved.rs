//! The curved wavefront: a front that carries its geodesic curvature beside the arrival time.

use super::Triangle;
use crate::constants::{FOCUS, GRAZING};
use crate::surface::{DIFFRACTS, Real};

/// An arriving front: when, and how curved it is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Front<R> {
    /// Arrival time; [`Real::FAR`] or later if no front arrives.
    pub time: R,
    /// Geodesic curvature of the front, positive where it spreads: 1 / t around a point source
    /// in the plane, [`Real::SOURCE`] at the source itself.
    pub curvature: R,
    /// Whether this comes from a whole triangle, which knows where the ray runs; it then takes
    /// precedence over an equally early front that ran along the same edge.
    pub whole: bool,
}

/// What the curved update knows of x0, x1 and x2 beside their triangle.
#[derive(Clone, Copy, Debug)]
pub struct Bends<R> {
    /// Curvature of the front at x1 and x2.
    pub fronts: [R; 2],
    /// Gaussian curvature of the surface at x0, x1 and x2; the tag 1
    /// ([`Real::tag`]) marks points beside a hole or the border, where waves diffract.
    pub surface: [R; 3],
}

/// The front at x0, from fronts at x1 and x2.
///
/// Inside the triangle the front is circular as in [`super::point_source`], with the mean
/// curvature of both ends instead of 1 / t. At the place where the ray crosses the edge the
/// curvature is interpolated, and it is carried to x0 along the ray's length by `carried`. A
/// front that turns around the end of an edge beside a hole or the border starts there again as
/// from a point source: it is diffracted.
#[inline]
pub fn curved<R: Real>(triangle: Triangle<R>, bends: Bends<R>) -> Front<R> {
    let Triangle { t1, t2, l1, l2, c } = triangle;
    let Bends { fronts: [k1, k2], surface: [g0, g1, g2] } = bends;
    let (zero, one, half) = (R::zero(), R::one(), R::of(0.5));
    let whole = triangle.is_proper();

    let swap = t1 < t2;
    let [(t, k, l, g), (near_t, near_k, near_l, near_g)] = if swap {
        [(t2, k2, l2, g2), (t1, k1, l1, g1)]
    } else {
        [(t1, k1, l1, g1), (t2, k2, l2, g2)]
    };
    let p = half * ((l * l - near_l * near_l) + c * c) / c;
    let h = ((l - p) * (l + p)).max(zero).sqrt();
    let lead = near_t - t;
    let d = lead.max(-c);
    // Both ends' curvature at the farther one's time. A source there says nothing of the front.
    let passed = shifted(near_k, -d);
    let kappa = if k < R::SOURCE { half * (passed + k) } else { passed };
    let cos_a = (half * kappa * ((c - d) * (c + d)) - d) / c;
    let sin_a = ((one - cos_a) * (one + cos_a)).max(zero).sqrt();
    let crossing = cos_a * h + sin_a * p;
    let width = c * (sin_a + kappa * h);
    let is_front = whole && lead > -c && cos_a <= one && width > zero;
    let grazing = R::of(GRAZING) * width;

    if is_front && crossing >= zero && crossing <= width {
        let n = kappa * (l * l) + (h * sin_a - p * cos_a) * R::of(2.0);
        let time = t + n / (one + (one + kappa * n).max(zero).sqrt());
        let share = crossing / width;
        let across = p - share * c;
        let ray = (across * across + h * h).sqrt();
        let far_k = shifted(if k < R::SOURCE { k } else { kappa }, time - ray - t);
        let near_k = shifted(near_k, time - ray - near_t);
        let at_crossing = far_k + share * (near_k - far_k);
        let gaussian = half * (g0 + (g + share * (near_g - g)));
        return Front { time, curvature: carried(at_crossing, gaussian, ray), whole };
    }

    // Along the edge of the end from which it arrives first.
    let turns_far = whole && !(is_front && crossing >= -grazing);
    let turns_near = whole && !(is_front && crossing <= width + grazing);
    let from_far = t + l <= near_t + near_l;
    let (start, k, l, g, turns) = if from_far {
        (t, k, l, g, turns_far)
    } else {
        (near_t, near_k, near_l, near_g, turns_near)
    };
    let diffracted = turns && g.tag() == DIFFRACTS;
    let k = if diffracted { R::SOURCE } else { k };
    Front { time: start + l, curvature: carried(k, half * (g0 + g), l), whole }
}

/// Curvature of a front of a developable surface a time later.
#[inline]
fn shifted<R: Real>(curvature: R, later: R) -> R {
    curvature / (R::one() + curvature * later).max(R::of(FOCUS))
}

/// Curvature of a front after a ray of some length, on a surface of constant Gaussian curvature:
/// -J'/J of the Jacobi field J'' = -K J to third order. From a point source, whose curvature is
/// as good as infinite, this is 1/s - K s/3.
#[inline]
fn carried<R: Real>(curvature: R, gaussian: R, length: R) -> R {
    let bend = gaussian * (length * length);
    let cos = R::one() - R::of(0.5) * bend;
    let sin = length * (R::one() - bend * R::of(1.0 / 6.0));
    (curvature * cos - gaussian * sin) / (cos + curvature * sin).max(R::of(FOCUS))
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec2;

    fn flat(k1: f64, k2: f64) -> Bends<f64> {
        Bends { fronts: [k1, k2], surface: [0.0; 3] }
    }

    #[test]
    fn is_the_point_source_front_with_the_curvatures_of_one() {
        let (x1, x2) = (DVec2::new(0.0, 0.0), DVec2::new(1.0, 0.0));
        for (source, x0) in [
            (DVec2::new(0.3, -0.8), DVec2::new(0.4, 0.9)),
            (DVec2::new(0.9, -30.0), DVec2::new(0.2, 0.5)),
            (DVec2::new(-2.0, -2.0), DVec2::new(1.1, 0.7)),
        ] {
            let (t1, t2) = (source.distance(x1), source.distance(x2));
            let triangle =
                Triangle { t1, t2, l1: x0.distance(x1), l2: x0.distance(x2), c: x1.distance(x2) };
            let front = curved(triangle, flat(1.0 / t1, 1.0 / t2));
            approx::assert_relative_eq!(front.time, source.distance(x0), max_relative = 1e-12);
            let curvature = 1.0 / source.distance(x0);
            approx::assert_relative_eq!(front.curvature, curvature, max_relative = 1e-12);
        }
    }

    #[test]
    fn carries_the_curvature_of_circles_on_the_sphere() {
        // A circle of radius r around a pole has geodesic curvature cot r.
        let (r, s) = (0.7f64, 0.01);
        let exact = 1.0 / (r + s).tan();
        approx::assert_abs_diff_eq!(carried(1.0 / r.tan(), 1.0, s), exact, epsilon = 1e-7);
        let from_source = carried(f64::SOURCE, 1.0, s);
        approx::assert_abs_diff_eq!(from_source, 1.0 / s.tan(), epsilon = 1e-5);
        let from_source = carried(f32::SOURCE, 1.0, s as f32);
        approx::assert_relative_eq!(f64::from(from_source), 1.0 / s.tan(), max_relative = 1e-6);
    }

    #[test]
    fn diffraction_starts_again_as_from_a_source() {
        // The ray comes from the far left and turns around x1 by a right angle.
        let triangle = Triangle { t1: 5.0, t2: 5.0 + 0.98, l1: 1.0, l2: 2f64.sqrt(), c: 1.0 };
        let beside_a_hole = 0.0.with_tag(DIFFRACTS);
        let at = |g1| curved(triangle, Bends { fronts: [0.2, 0.2], surface: [0.0, g1, 0.0] });
        assert_eq!((at(0.0).time, at(beside_a_hole).time), (6.0, 6.0));
        approx::assert_relative_eq!(at(0.0).curvature, 0.2 / 1.2, max_relative = 1e-12);
        approx::assert_relative_eq!(at(beside_a_hole).curvature, 1.0, max_relative = 1e-12);
    }

    #[test]
    fn a_missing_edge_or_time_leaves_the_other() {
        let far = f32::FAR;
        let bends = Bends { fronts: [1.0, 0.0], surface: [0.0; 3] };
        let whole = Triangle { t1: 1.0, t2: 1.2, l1: 1.0, l2: 1.0, c: 1.0f32 };
        assert_eq!(curved(Triangle { t2: far, ..whole }, bends).time, 2.0);
        assert_eq!(curved(Triangle { l2: far, c: far, ..whole }, bends).time, 2.0);
        assert!(curved(Triangle { t1: far, t2: far, ..whole }, bends).time >= far);
        let front = curved(Triangle { t2: far, ..whole }, bends);
        assert!(front.curvature.is_finite() && front.whole);
    }
}

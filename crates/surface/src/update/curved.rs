//! Implements the curved wavefront: a front that carries its geodesic curvature beside the arrival time.

use super::{Shape, Triangle};
use crate::constants::{
    ABOUT_STRAIGHT, ALONG_BASE, BENT_AGAIN, BENT_APART, CLEARLY_LATER, FAN, FOCUS, FROM_SOURCE,
    GRAZING, STRADDLING, TOGETHER,
};
use crate::{DIFFRACTS, LACKING, Real, Seed, Tagged, max, min};

/// An arriving front: its arrival time and its curvature.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Front<R> {
    /// Arrival time; [`Real::FAR`] or later if no front arrives.
    pub time: R,
    /// Geodesic curvature of the front, positive where it spreads: 1 / t around a point source in the plane,
    /// [`Seed::AT_SOURCE`] at the source itself.
    pub curvature: R,
    /// Whether the front came through a triangle with all three edges, which determines where the ray runs. Such a
    /// front takes precedence over an equally early front along the same edge.
    pub whole: bool,
}

impl<R: Real> Front<R> {
    /// Returns the earlier of two fronts.
    ///
    /// If both arrive together, a front from a whole triangle is preferred, then the flatter front, since its ray
    /// continues straight along the common edge. This choice does not depend on the order in which triangles are
    /// visited. The time is the earlier one, since the delay of the other would grow from point to point.
    #[inline(always)]
    #[doc(hidden)]
    pub fn first(a: Self, b: Self) -> Self {
        let second = if a.arrives_with(b) { b.knows_better(a) } else { b.time < a.time };
        Self {
            time: min(a.time, b.time),
            curvature: if second { b.curvature } else { a.curvature },
            whole: if second { b.whole } else { a.whole },
        }
    }

    /// Returns whether another front arrives at the same time, up to rounding.
    #[inline(always)]
    #[doc(hidden)]
    pub fn arrives_with(self, other: Self) -> bool {
        let rounding = R::of(TOGETHER) * R::epsilon();
        (self.time - other.time).abs() <= rounding * self.time
    }

    /// Returns whether this one of two fronts that arrive together is preferred.
    #[inline(always)]
    #[doc(hidden)]
    pub fn knows_better(self, other: Self) -> bool {
        let flatter = (self.whole == other.whole) & (self.curvature < other.curvature);
        (self.whole & !other.whole) | flatter
    }

    /// Returns whether this front equals `kept` up to rounding. Both arrive together, and the same scan brought both,
    /// `kept` at an earlier visit. If such a front were renewed, all fronts that follow from it would be renewed too.
    #[inline(always)]
    #[doc(hidden)]
    pub fn is_same_as(self, kept: Self) -> bool {
        let rounding = self.curvature.abs() * (R::of(BENT_AGAIN) * R::epsilon());
        (self.whole == kept.whole) & ((kept.curvature - self.curvature).abs() <= rounding)
    }

    /// Returns whether this front is preferred to `kept`, which arrived together with it and may come from another
    /// scan. It is preferred if it is flatter by more than `BENT_APART`. Along a diagonal two scans bring the same
    /// front, up to its last digits. If these digits decided, the points of a diagonal would take their fronts from
    /// either scan, and a change would pass along the diagonal only in several iterations.
    #[inline(always)]
    #[doc(hidden)]
    pub fn replaces(self, kept: Self) -> bool {
        let apart = self.curvature.abs() * R::of(BENT_APART);
        let flatter = (self.whole == kept.whole) & (kept.curvature - self.curvature > apart);
        (self.whole & !kept.whole) | flatter
    }
}

/// The inputs of the curved update in addition to the triangle.
#[derive(Clone, Copy, Debug)]
pub struct Curvatures<R> {
    /// Curvatures of the front at x1 and x2.
    pub fronts: [R; 2],
    /// Gaussian curvatures of the surface at x0, x1 and x2. Their four lowest binary digits mark points
    /// beside a hole or the border, and corners of holes, where fronts diffract.
    pub surface: [R; 3],
    /// Whether one of x1 and x2 is a hole, and the other is x0's neighbour across a diagonal. A front along
    /// that diagonal is assumed to have come around the hole's corner, as most fronts there have, until
    /// another scan brings a better one. Without this assumption all points behind the corner would have to
    /// be renewed.
    pub alone: bool,
    /// Whether the update must be causal: x0 then does not depend on neighbours that arrive later. This is needed where
    /// several fronts meet; otherwise they would settle in more than one way, or never.
    pub causal: bool,
}

/// Returns the front at x0 from fronts at x1 and x2.
///
/// Inside the triangle the front is circular as in [`super::circular()`], with the mean curvature of both
/// ends in place of 1 / t. The curvatures of both ends are carried to the arrival time at x0, interpolated to
/// the place where the ray crosses the base, and bent by the surface's Gaussian curvature along the ray
/// (`bent`). A front that turns around the end of an edge beside a hole or the border is diffracted: it
/// starts there again as from a point source, or with the curvature of a narrow fan along a border (`FAN`).
#[inline(always)]
pub fn curved<R: Real>(triangle: Triangle<R>, curvatures: Curvatures<R>) -> Front<R> {
    curved_at::<R, true>(triangle, curvatures)
}

/// Returns the front of [`curved`]. `BORDER` is false only if x0 is known to lie neither beside a hole nor at the border,
/// so that fans along a border need no test.
#[inline(always)]
pub fn curved_at<R: Real, const BORDER: bool>(
    triangle: Triangle<R>,
    curvatures: Curvatures<R>,
) -> Front<R> {
    traced::<R, BORDER>(triangle, curvatures).front
}

/// A front, and the ray by which it arrives at x0. Vectors are in the plane of the triangle, with the base from x1 to
/// x2 along the first axis.
#[derive(Clone, Copy)]
pub(super) struct Traced<R> {
    pub front: Front<R>,
    /// Whether the front came through the face of the triangle.
    pub inside: bool,
    /// Direction of the ray at x0, not normalized.
    pub ray: [R; 2],
    /// The curvature of the front inside the triangle, in units of the base, the sine of the angle between the base and
    /// the ray at the later end, and the delay of the earlier end against the later one.
    pub kappa: R,
    pub sine: R,
    pub delay: R,
    /// Whether x2 is the later end.
    pub swap: bool,
    /// The foot of x0 on the base, from x1 on, its height, and the sides x0 x1 and x0 x2, in units of the base.
    pub apex: [R; 2],
    pub sides: [R; 2],
}

/// Returns the front of [`curved_at`] with its ray.
#[inline(always)]
pub(super) fn traced<R: Real, const BORDER: bool>(
    triangle: Triangle<R>,
    curvatures: Curvatures<R>,
) -> Traced<R> {
    let Triangle { t1, t2, l1, l2, c } = triangle;
    let Curvatures { fronts: [k1, k2], surface: [g0, g1, g2], alone, causal } = curvatures;
    let (zero, one, half, focus) = (R::zero(), R::one(), R::of(0.5), R::of(FOCUS));
    let at_source = R::of(Seed::AT_SOURCE);

    let swap = t1 < t2;
    let (t, near_t) = if swap { (t2, t1) } else { (t1, t2) };
    let (k, near_k) = if swap { (k2, k1) } else { (k1, k2) };
    let (g, near_g) = if swap { (g2, g1) } else { (g1, g2) };
    let (l, near_l) = if swap { (l2, l1) } else { (l1, l2) };
    // From here on lengths are in units of the base, except for the times and the lengths of the edges.
    let shape = Shape::new(l, near_l, c);
    let (p, whole) = (shape.foot, shape.whole);
    let h = max(shape.height_squared, zero).sqrt();
    let d = (near_t - t) * shape.per_base;
    // These are the curvatures of both ends at the time of the farther end. If the farther end is a source, its front
    // has no curvature yet. If the nearer end is a source, the front at the farther end usually came from there along
    // the base. If it did not, and is nearly straight, it started beside the source, and the source is the end of a
    // curve. Then the front at the farther end is the one that arrives at x0.
    let beside =
        (near_k >= at_source) & ((k * c).abs() < R::of(ABOUT_STRAIGHT)) & (d > R::of(-FROM_SOURCE));
    let near_kappa = if beside { k * c } else { near_k * c };
    let passed = near_kappa / max(one - near_kappa * d, focus);
    let far_kappa = if k < at_source { k * c } else { passed };
    let kappa = half * (passed + far_kappa);
    let cos_a = half * kappa * ((one - d) * (one + d)) - d;
    let sin_a = max((one - cos_a) * (one + cos_a), zero).sqrt();
    let crossing = cos_a * h + sin_a * p;
    let width = sin_a + kappa * h;
    // A front that came along the base to the base's later end has already passed x0, or turns around the nearer end.
    let of_one = (d > R::of(-ALONG_BASE)) & (kappa * (one - d) <= R::of(STRADDLING));
    let is_front = whole & of_one & (width > zero);
    let n = kappa * (shape.side * shape.side) + (h * sin_a - p * cos_a) * R::of(2.0);
    let root = max(one + kappa * n, zero).sqrt();
    // No front arrives at x0 earlier than at the later end of the base, so that each point depends on earlier points
    // only. A single front in cells that are not sheared may arrive earlier than at the later end, but not earlier than
    // at the earlier end: in a stretched cell x0 may be nearer to the source than an end of its base. Fronts also do
    // not arrive after a front along an edge.
    let rise = max(n / (one + root), if shape.is_upright() & !causal { d } else { zero });
    let (by_far, by_near) = (t + l, near_t + near_l);
    // `later` exceeds the time of the later end by more than the tolerance within which fronts arrive together.
    let later = t + t * (R::of(CLEARLY_LATER) * R::epsilon());
    let time = t + c * rise;
    let is_first = (time <= min(by_far, by_near)) & (!causal | (time >= later));
    let inside = is_front & (crossing >= zero) & (crossing <= width) & is_first;
    let far_spread = max(one + far_kappa * rise, focus);
    let near_spread = max(one + near_kappa * (rise - d), focus);
    let spread = far_spread * near_spread;

    // The front that arrives along an edge, taken from the edge that brings it first.
    let grazing = R::of(GRAZING) * width;
    let from_far = by_far <= by_near;
    let (edge_time, edge) = if from_far { (by_far, l) } else { (by_near, near_l) };
    let (edge_k, edge_g) = if from_far { (k, g) } else { (near_k, near_g) };
    // If the far end is reached after x0, its front is not known yet.
    let is_known = !causal | (later < by_near);
    let past_near = (crossing <= width + grazing) & is_known;
    let ahead = if from_far { crossing >= -grazing } else { past_near };
    let turns = (whole | alone) & !(is_front & ahead);
    // A front that is not known to turn is assumed to turn at corners of holes only, where most fronts turn.
    let is_corner = edge_g.tag_has(DIFFRACTS, DIFFRACTS);
    let diffracted = turns & edge_g.tag_has(LACKING, LACKING) & (from_far | is_known | is_corner);

    // A border that bends away from the front turns it a little at each point. The fan of the turned rays is narrower
    // than the cells beside the border. As the curvature of the front there, x0 takes the mean over the width of a cell.
    let (mut fan, mut starts_anew, mut in_fan) = (zero, diffracted, false);
    if BORDER {
        let beyond = if from_far { -crossing } else { crossing - width };
        let to_border = g0.tag_has(LACKING, LACKING);
        let along_border = edge_g.tag_has(LACKING | DIFFRACTS, LACKING) & to_border;
        let opens = is_front & along_border & (beyond > zero) & (from_far | is_known);
        fan = beyond * R::of(FAN) * shape.per_base;
        let is_narrow = opens & (fan * edge < h);
        let goes_on = max(one + edge_k * edge, focus);
        in_fan = is_narrow & (fan * goes_on > edge_k.abs() * h);
        starts_anew = (diffracted | opens) & !is_narrow;
    }
    let edge_k = if starts_anew { at_source } else { edge_k };

    // A single division gives the ray's crossing, its length and the curvature, both across the triangle and along an
    // edge.
    let weighted =
        (width - crossing) * far_kappa * near_spread + crossing * near_kappa * far_spread;
    let (by_edge, per_edge) =
        if in_fan { (fan, h) } else { (edge_k, max(one + edge_k * edge, focus)) };
    let dividend = if inside { weighted * shape.per_base } else { by_edge };
    let per = one / if inside { width * spread } else { per_edge };
    let share = crossing * spread * per;
    let ray = if inside { c * (root * h * spread * per) } else { edge };
    let gaussian = if inside { g + share * (near_g - g) } else { edge_g };
    let curvature = bent(dividend * per, half * (g0 + gaussian), ray);
    let front = Front { time: if inside { time } else { edge_time }, curvature, whole };
    let along = kappa * p - cos_a;
    let (side, other) = (shape.side, shape.other);
    Traced {
        front,
        inside,
        ray: [if swap { -along } else { along }, width],
        kappa,
        sine: sin_a,
        delay: d,
        swap,
        apex: [if swap { one - p } else { p }, h],
        sides: [if swap { other } else { side }, if swap { side } else { other }],
    }
}

/// Returns the curvature at the end of a ray on a surface of some Gaussian curvature, from the curvature on a
/// developable surface. The result is of first order in the Gaussian curvature along the ray, from the
/// Riccati equation k' = -k^2 - K. From a point source it is 1/s - K s/3.
#[inline(always)]
pub(super) fn bent<R: Real>(curvature: R, gaussian: R, ray: R) -> R {
    let x = curvature * ray;
    curvature - gaussian * ray * (R::one() - x + x * x * R::of(1.0 / 3.0))
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec2;

    fn flat(k1: f64, k2: f64) -> Curvatures<f64> {
        Curvatures { fronts: [k1, k2], surface: [0.0; 3], alone: false, causal: false }
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
        let edge = Triangle { t1: r, t2: f64::FAR, l1: s, l2: f64::FAR, c: f64::FAR };
        let after = |k| {
            curved(
                edge,
                Curvatures { fronts: [k, 0.0], surface: [1.0; 3], alone: false, causal: false },
            )
            .curvature
        };
        approx::assert_abs_diff_eq!(after(1.0 / r.tan()), 1.0 / (r + s).tan(), epsilon = 1e-6);
        approx::assert_abs_diff_eq!(after(Seed::AT_SOURCE), 1.0 / s.tan(), epsilon = 1e-5);
    }

    #[test]
    fn diffraction_starts_again_as_from_a_source() {
        // The ray comes from the far left and turns around x1 by a right angle.
        let triangle = Triangle { t1: 5.0, t2: 5.0 + 0.98, l1: 1.0, l2: 2f64.sqrt(), c: 1.0 };
        let beside_a_hole = 0.0.with_tag(LACKING);
        let bends = |g1| Curvatures { surface: [0.0, g1, 0.0], ..flat(0.2, 0.2) };
        let at = |g1| curved(triangle, bends(g1));
        assert_eq!((at(0.0).time, at(beside_a_hole).time), (6.0, 6.0));
        approx::assert_relative_eq!(at(0.0).curvature, 0.2 / 1.2, max_relative = 1e-12);
        approx::assert_relative_eq!(at(beside_a_hole).curvature, 1.0, max_relative = 1e-12);
    }

    #[test]
    fn fronts_along_a_diagonal_beside_a_hole_come_around_its_corner() {
        let far = f64::FAR;
        let edge = Triangle { t1: 5.0, t2: far, l1: 1.4, l2: far, c: far };
        let at = |g1: f64, alone| {
            curved(edge, Curvatures { surface: [0.0, g1, 0.0], alone, ..flat(0.2, 0.0) }).curvature
        };
        let beside_a_hole = 0.0.with_tag(LACKING);
        approx::assert_relative_eq!(at(beside_a_hole, true), 1.0 / 1.4, max_relative = 1e-12);
        for straight in [at(beside_a_hole, false), at(0.0, true)] {
            approx::assert_relative_eq!(straight, 0.2 / 1.28, max_relative = 1e-12);
        }
    }

    #[test]
    fn a_front_from_beside_the_end_of_a_curve_is_its_own() {
        // A straight line ends at x2 and passes x1 at some distance. x0 is beside the line.
        let (x0, x1, x2) = (DVec2::new(0.0, 1.0), DVec2::ZERO, DVec2::X);
        let along = DVec2::from_angle(0.4);
        let distance = |place: DVec2| along.perp_dot(place - x2).abs();
        let (t1, l1, l2) = (distance(x1), x0.distance(x1), x0.distance(x2));
        let triangle = Triangle { t1, t2: 0.0, l1, l2, c: 1.0 };
        for source in [Seed::AT_SOURCE, Seed::AT_SOURCE.with_tag(0)] {
            let front = curved(triangle, flat(0.0, source));
            approx::assert_abs_diff_eq!(front.time, distance(x0), epsilon = 1e-12);
            approx::assert_abs_diff_eq!(front.curvature, 0.0, epsilon = 1e-12);
        }
        // The result differs if the front at x1 is that of the source.
        let triangle = Triangle { t1: 1.0, ..triangle };
        approx::assert_abs_diff_eq!(
            curved(triangle, flat(1.0, Seed::AT_SOURCE)).time,
            l2,
            epsilon = 1e-12
        );
    }

    #[test]
    fn a_source_without_a_tag_is_one_with_it() {
        let single = Seed::AT_SOURCE as f32;
        assert_eq!(single.with_tag(0), single);
        assert_eq!(Seed::AT_SOURCE.with_tag(0), Seed::AT_SOURCE);
    }

    #[test]
    fn a_missing_edge_or_time_leaves_the_other() {
        let far = f32::FAR;
        let curvatures =
            Curvatures { fronts: [1.0, 0.0], surface: [0.0; 3], alone: false, causal: false };
        let whole = Triangle { t1: 1.0, t2: 1.2, l1: 1.0, l2: 1.0, c: 1.0f32 };
        assert_eq!(curved(Triangle { t2: far, ..whole }, curvatures).time, 2.0);
        assert_eq!(curved(Triangle { l2: far, c: far, ..whole }, curvatures).time, 2.0);
        assert!(curved(Triangle { t1: far, t2: far, ..whole }, curvatures).time >= far);
        let front = curved(Triangle { t2: far, ..whole }, curvatures);
        assert!(front.curvature.is_finite() && front.whole);
    }
}

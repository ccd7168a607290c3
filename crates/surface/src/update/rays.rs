//! Implements the wavefront whose fronts carry their ray: its direction, and the source from which it comes.
//!
//! A time and a curvature at each end of a base do not tell whether both ends were reached by one front. With the rays
//! at both ends, the front of each end can be continued to the other end. Where it arrives there when the other front
//! does, the front is one circle, and the curved update applies. Where it arrives later, the base crosses a crease, and
//! the front of each end goes on alone. A jump of curvature between both ends, as behind an obstacle or beside the
//! end of a curve, is a transition from one to the other.

use super::course::Course;
use super::curved::{Curvatures, Front, bent, traced};
use super::{Shape, Triangle};
use crate::angle::{angle_of, cosine, sin_cos};
use crate::constants::FAN;
use crate::{DIFFRACTS, LACKING, Real, Seed, Tagged, max, min};

/// An arriving front with its course.
#[derive(Clone, Copy, Debug, PartialEq)]
#[doc(hidden)]
pub struct RayFront<R: Real> {
    pub front: Front<R>,
    pub course: Course<R>,
}

impl<R: Real> RayFront<R> {
    /// Returns the earlier of two fronts ([`Front::first`]).
    #[inline(always)]
    pub fn first(a: Self, b: Self) -> Self {
        let second = if a.front.arrives_with(b.front) {
            b.front.knows_better(a.front)
        } else {
            b.front.time < a.front.time
        };
        Self {
            front: Front::first(a.front, b.front),
            course: if second { b.course } else { a.course },
        }
    }
}

/// The front at one end of a base, and the angles in the fan of that end.
#[derive(Clone, Copy, Debug)]
#[doc(hidden)]
pub struct RayEnd<R: Real> {
    pub curvature: R,
    pub course: Course<R>,
    /// The Gaussian curvature of the surface, with its tag.
    pub gaussian: R,
    /// The angles of the edges to the other end and to x0, as words.
    pub base: R::Bits,
    pub side: R::Bits,
}

/// The Gaussian curvature at x0, and the angles in its fan of the edges to x1 and x2.
#[derive(Clone, Copy, Debug)]
#[doc(hidden)]
pub struct RayApex<R: Real> {
    pub gaussian: R,
    pub edges: [R::Bits; 2],
}

/// Sums of both mismatches between which the curved update gives way to the fronts of single ends. The mismatch of an
/// end is the delay with which its front reaches the other end, in units of the base.
const CREASE: [f64; 2] = [0.003, 0.01];
/// Larger mismatches between which the same happens where one of them is negative.
const JUMP: [f64; 2] = [0.004, 0.012];
/// Mismatch of a front that counts as reached in time, and its rounding in units in the last place of the time.
const IN_TIME: f64 = 1e-4;
const ROUNDED: f64 = 2.0;
/// Distance from the ends of a base, in units of the base, within which a ray still crosses it.
const PAST_END: f64 = 3e-4;
/// Difference of curvatures, in units of the base, above which their circles tell where a jump crosses the base.
const APART: f64 = 0.02;
/// Distance between the places where two rays cross a base, in units of the base, up to which both are part of one
/// transition.
const TOGETHER: f64 = 0.2;
/// Cosine of the angle between a ray and an edge below which the front turns around the end of the edge, and the same
/// beside a hole or the border.
const TURNED: f64 = 0.995;
const TURNED_AT_BORDER: f64 = 1.0 - 1e-5;
/// Bounds of a curvature times the length of a ray, for the series of its change.
const BENT: [f64; 2] = [-9.0, 2.0];

/// A ray in the plane of the triangle. Lengths are in units of the base.
#[derive(Clone, Copy)]
struct Ray<R> {
    to: [R; 2],
    kappa: R,
    is_source: bool,
}

impl<R: Real> Ray<R> {
    #[inline(always)]
    fn new(end: &RayEnd<R>, base: R, [p, h]: [R; 2], mirrored: bool) -> Self {
        let wedge = R::angle_between(end.base, end.side);
        let from_base = R::angle_between(end.base, end.course.0);
        let from_base = if wedge < R::zero() { -from_base } else { from_base };
        // The fan scales the angles of its triangles. Half of the difference lies on either side of the ray.
        let spread =
            (angle_of([if mirrored { R::one() - p } else { p }, h]) - wedge.abs()) * R::of(0.5);
        let [sine, cosine] = sin_cos(from_base + spread);
        let (x, y) = (if mirrored { -cosine } else { cosine }, sine);
        let turns_round = end.course.is_to_both_sides() & (y < R::zero());
        let to = if turns_round { [-x, -y] } else { [x, y] };
        let is_source = end.curvature >= R::of(Seed::AT_SOURCE);
        Self { to, kappa: if is_source { R::zero() } else { end.curvature * base }, is_source }
    }

    /// Returns the delay with which the front passes a place, given from this end.
    #[inline(always)]
    fn rise(&self, [x, y]: [R; 2]) -> R {
        let square = x * x + y * y;
        let n = R::of(2.0) * (self.to[0] * x + self.to[1] * y) + self.kappa * square;
        let rise = n / (R::one() + max(R::one() + self.kappa * n, R::zero()).sqrt());
        if self.is_source { square.sqrt() } else { rise }
    }
}

/// The front of one end alone, at x0.
#[derive(Clone, Copy)]
struct Alone<R> {
    /// Whether its ray crosses the base after the front has left its source.
    comes: bool,
    rise: R,
    /// The place where the ray crosses the base, from x1 on, and the length from there.
    crossing: R,
    back: R,
    /// Direction of the ray at x0, normalized, and the curvature there.
    to: [R; 2],
    kappa: R,
}

impl<R: Real> Alone<R> {
    #[inline(always)]
    fn new(ray: &Ray<R>, at: R, [p, h]: [R; 2], side: R) -> Self {
        let (zero, one) = (R::zero(), R::one());
        let x = p - at;
        let rise = ray.rise([x, h]);
        let n = R::of(2.0) * (ray.to[0] * x + ray.to[1] * h) + ray.kappa * (side * side);
        let root = if ray.is_source { side } else { max(one + ray.kappa * n, zero).sqrt() };
        let ahead = if ray.is_source {
            [x, h]
        } else {
            [ray.to[0] + ray.kappa * x, ray.to[1] + ray.kappa * h]
        };
        let norm = max((ahead[0] * ahead[0] + ahead[1] * ahead[1]).sqrt(), R::min_positive_value());
        let to = [ahead[0] / norm, ahead[1] / norm];
        let up = max(to[1], R::of(1e-7));
        let back = h / up;
        let crossing = p - h * to[0] / up;
        let past = R::of(PAST_END);
        // A front that spreads has no ray behind its centre.
        let from_centre = if ray.is_source {
            side
        } else if ray.kappa > zero {
            root / ray.kappa
        } else {
            R::FAR
        };
        let comes = (to[1] > R::of(1e-7))
            & (crossing >= -past)
            & (crossing <= one + past)
            & (back <= from_centre * (one + past));
        let kappa = if ray.is_source { one / side } else { ray.kappa / max(root, R::of(0.1)) };
        Self { comes, rise, crossing: min(max(crossing, zero), one), back, to, kappa }
    }
}

#[inline(always)]
fn smooth_step<R: Real>([from, to]: [f64; 2], x: R) -> R {
    let at = min(max((x - R::of(from)) * R::of(1.0 / (to - from)), R::zero()), R::one());
    at * at * (R::of(3.0) - R::of(2.0) * at)
}

/// Returns the curvature at the end of a ray, for curvatures that the ray resolves.
#[inline(always)]
fn bent_within<R: Real>(curvature: R, gaussian: R, length: R) -> R {
    let within = max(curvature, R::of(BENT[0]) / length);
    let bound = min(within, R::of(BENT[1]) / length);
    within + (bent(bound, gaussian, length) - bound)
}

/// Returns the front at x0 from fronts at x1 and x2 that carry their rays.
#[doc(hidden)]
#[inline]
pub fn rays<R: Real>(
    triangle: Triangle<R>,
    ends: &[RayEnd<R>; 2],
    apex: &RayApex<R>,
) -> RayFront<R> {
    let along = along_edges(triangle, ends, apex);
    let Some(face) = through_face(triangle, ends, apex) else { return along };
    let rounding = R::one() + R::of(4.0) * R::epsilon();
    if face.front.time > along.front.time * rounding {
        return along;
    }
    let time = min(face.front.time, along.front.time);
    RayFront { front: Front { time, ..face.front }, ..face }
}

/// A front through the face of a triangle whose base one front has reached.
#[derive(Clone, Copy, Debug)]
#[doc(hidden)]
pub struct FrontOfOne<R: Real> {
    /// The front. If it is not `inside`, its time is that along an edge, and the rest is not defined.
    pub front: RayFront<R>,
    pub inside: bool,
    /// Whether one front has reached both ends of the base, so that [`rays`] has the same result. Otherwise
    /// this front is not valid.
    pub is_one: bool,
}

/// Returns the front at x0 if one front has reached both ends of the base. This is the common case, without branches.
/// The test compares the turn of the ray along the base, and its direction at x1, with those of a circle.
#[inline(always)]
#[doc(hidden)]
pub fn of_one_front<R: Real>(
    triangle: Triangle<R>,
    ends: &[RayEnd<R>; 2],
    apex: &RayApex<R>,
) -> FrontOfOne<R> {
    let (zero, one, half) = (R::zero(), R::one(), R::of(0.5));
    let half_turn = R::of(std::f64::consts::PI);
    let fronts = [ends[0].curvature, ends[1].curvature];
    let surface = [apex.gaussian, ends[0].gaussian, ends[1].gaussian];
    let bends = Curvatures { fronts, surface, alone: false, causal: false };
    let traced = traced::<R, false>(triangle, bends);
    let wedge = R::angle_between(apex.edges[0], apex.edges[1]);
    let sign = if wedge < zero { -one } else { one };
    let first = R::angle_between(ends[0].base, ends[0].course.0);
    let second = R::angle_between(ends[1].base, ends[1].course.0);
    let second = if second > zero { second - half_turn } else { second + half_turn };
    let turn = sign * (first - second);
    let d = if traced.swap { -traced.delay } else { traced.delay };
    let growth = one + traced.kappa * traced.delay;
    let sine_of_turn = turn - turn * turn * turn * R::of(1.0 / 6.0);
    let kappa = fronts[0] * triangle.c;
    let cosine = cosine(first);
    let late = cosine - (d - kappa * half * (one - d * d));
    let at_source = R::of(Seed::AT_SOURCE);
    let exists =
        max(max(triangle.t1, triangle.t2), max(max(triangle.l1, triangle.l2), triangle.c)) < R::FAR;
    let turns =
        (sine_of_turn * growth - traced.kappa * traced.sine).abs() <= R::of(CREASE[0]) * growth;
    let agrees = late.abs() <= R::of(JUMP[0]) * (one + kappa * d);
    // A front that leaves the base on the other side has no ray through this face.
    let leaves = (sign * first < zero)
        & (sign * second < zero)
        & !ends[0].course.is_to_both_sides()
        & !ends[1].course.is_to_both_sides();
    let plain =
        (max(fronts[0], fronts[1]) < at_source) & ends[0].course.is_plain_as(ends[1].course);
    let angle = angle_at_apex(apex, traced.apex, traced.sides, traced.ray);
    let inside = traced.inside & !leaves;
    let along_edge = min(triangle.t1 + triangle.l1, triangle.t2 + triangle.l2);
    let time = if inside { traced.front.time } else { along_edge };
    FrontOfOne {
        front: RayFront {
            front: Front { time, whole: inside, ..traced.front },
            course: ends[0].course.turned_to(angle),
        },
        inside,
        is_one: !exists | leaves | (turns & agrees & plain),
    }
}

/// Returns the first front along an edge.
#[inline]
fn along_edges<R: Real>(
    triangle: Triangle<R>,
    ends: &[RayEnd<R>; 2],
    apex: &RayApex<R>,
) -> RayFront<R> {
    let Triangle { t1, t2, l1, l2, .. } = triangle;
    let second = t2 + l2 < t1 + l1;
    let (end, edge) = (&ends[usize::from(second)], apex.edges[usize::from(second)]);
    let (time, length) = if second { (t2 + l2, l2) } else { (t1 + l1, l1) };
    let at_source = R::of(Seed::AT_SOURCE);
    if !(time < R::FAR) {
        let front = Front { time: R::FAR, curvature: R::zero(), whole: false };
        return RayFront { front, course: end.course };
    }
    let [sine, cosine] = sin_cos(R::angle_between(end.side, end.course.0));
    let cosine = if end.course.is_to_both_sides() { cosine.abs() } else { cosine };
    let is_at_border = end.gaussian.tag_has(LACKING, LACKING);
    let turns = cosine < R::of(if is_at_border { TURNED_AT_BORDER } else { TURNED });
    let goes_on = end.curvature / max(R::one() + end.curvature * length, R::of(0.1));
    let is_source = end.curvature >= at_source;
    let narrow = narrow_fan(triangle, length, sine.abs()).filter(|_| {
        let follows_border = end.gaussian.tag_has(LACKING | DIFFRACTS, LACKING);
        follows_border & apex.gaussian.tag_has(LACKING, LACKING) & (cosine > R::zero())
    });
    let curvature = match narrow {
        _ if is_source | (turns & narrow.is_none()) => length.recip(),
        Some(fan) if turns & (fan > goes_on.abs()) => fan,
        _ => goes_on,
    };
    let curvature = bent_within(curvature, R::of(0.5) * (apex.gaussian + end.gaussian), length);
    let angle = R::angle_ahead(edge, R::of(std::f64::consts::PI));
    RayFront { front: Front { time, curvature, whole: false }, course: end.course.turned_to(angle) }
}

/// Returns the curvature, at the next point of a border, of the fan of rays that leave a border which turns away from the
/// front by an angle, given the sine of the angle: the mean over the width of a cell. Returns `None` if the fan is not
/// narrower than a cell.
#[inline]
fn narrow_fan<R: Real>(triangle: Triangle<R>, length: R, sine: R) -> Option<R> {
    let Triangle { l1, l2, c, .. } = triangle;
    let shape = Shape::new(l1, l2, c);
    if !shape.whole {
        return None;
    }
    let height = shape.height_squared.sqrt();
    let fan = R::of(FAN) * sine * (length * shape.per_base) * shape.per_base;
    (fan * length < height).then(|| fan / height)
}

/// Returns the front through the face of a triangle, if there is one.
#[inline]
fn through_face<R: Real>(
    triangle: Triangle<R>,
    ends: &[RayEnd<R>; 2],
    apex: &RayApex<R>,
) -> Option<RayFront<R>> {
    let Triangle { t1, t2, l1, l2, c } = triangle;
    if max(t1, t2) >= R::FAR || max(max(l1, l2), c) >= R::FAR {
        return None;
    }
    let shape = Shape::new(l1, l2, c);
    if !shape.whole {
        return None;
    }
    let (zero, one, half) = (R::zero(), R::one(), R::of(0.5));
    let (p, h) = (shape.foot, shape.height_squared.sqrt());
    let d = (t2 - t1) * shape.per_base;
    let first = Ray::new(&ends[0], c, [p, h], false);
    let second = Ray::new(&ends[1], c, [p, h], true);
    let m1 = first.rise([one, zero]) - d;
    let m2 = second.rise([-one, zero]) + d;
    let in_time = R::of(IN_TIME) + R::of(ROUNDED) * R::epsilon() * max(t1, t2) * shape.per_base;
    let is_crease = (m1 >= -in_time) & (m2 >= -in_time);
    let of_crease = smooth_step(CREASE, m1 + m2);
    let of_jump = smooth_step(JUMP, max(m1.abs(), m2.abs()));
    let mut weight = if is_crease { of_crease } else { max(of_jump, of_crease) };
    // The source lies between both ends, and its front leaves it to both sides.
    let is_divided = first.to[0] * second.to[0] + first.to[1] * second.to[1] < zero;
    // Both fronts arrive earlier than the other one: the fan between both rays is not resolved.
    let is_fan = (m1 < -in_time)
        & (m2 < -in_time)
        & (weight > zero)
        & !first.is_source
        & !second.is_source
        & !is_divided;
    let mut curvatures = [ends[0].curvature, ends[1].curvature];
    let mut alone = None;
    if is_fan {
        let up = first.to[1] + second.to[1];
        let spread =
            max((second.to[0] - first.to[0]) / max(R::of(0.25) * up * up, R::of(0.05)), zero);
        curvatures = curvatures.map(|k| k + weight * (spread * shape.per_base - k));
        weight = zero;
    } else if weight > zero {
        let of_first = Alone::new(&first, zero, [p, h], shape.side);
        let of_second = Alone::new(&second, one, [p, h], shape.other);
        let ends_alone = [of_first, of_second];
        alone = if is_crease {
            let free = |own: &Alone<R>, start: R, other: &Ray<R>, other_start: R, at: R| {
                let there = other_start + other.rise([own.crossing - at, zero]);
                own.comes && start + own.rise - own.back <= there + in_time
            };
            let comes_1 = free(&of_first, zero, &second, d, one);
            let comes_2 = free(&of_second, d, &first, zero, zero);
            let second_is_first = of_second.rise + d < of_first.rise;
            match (comes_1, comes_2) {
                (false, false) => None,
                (true, false) => Some(Joint::of(&ends_alone, 0, d)),
                (false, true) => Some(Joint::of(&ends_alone, 1, d)),
                (true, true) => Some(Joint::of(&ends_alone, usize::from(second_is_first), d)),
            }
        } else {
            let jump = jump_at([&first, &second], [m1, m2], is_divided);
            match (of_first.comes, of_second.comes) {
                (true, true) => Some(Joint::across(&ends_alone, jump, d)),
                (true, false) if of_first.crossing <= jump + R::of(PAST_END) => {
                    Some(Joint::of(&ends_alone, 0, d))
                }
                (false, true) if of_second.crossing >= jump - R::of(PAST_END) => {
                    Some(Joint::of(&ends_alone, 1, d))
                }
                _ => None,
            }
        };
    }
    let surface = [apex.gaussian, ends[0].gaussian, ends[1].gaussian];
    let both = if weight < one {
        let bends = Curvatures { fronts: curvatures, surface, alone: false, causal: false };
        Some(traced::<R, false>(triangle, bends)).filter(|traced| traced.inside)
    } else {
        None
    };
    let of_alone = alone.map(|joint| {
        let gaussian =
            half * (apex.gaussian + surface[1] + joint.second * (surface[2] - surface[1]));
        let not_before = max(t1 + c * joint.rise, min(t1, t2));
        let curvature = bent_within(joint.kappa * shape.per_base, gaussian, c * joint.back);
        (not_before, curvature, joint.to, if joint.second < half { 0 } else { 1 })
    });
    let (time, curvature, to, end) = match (both, of_alone) {
        (Some(both), Some((time, curvature, to, end))) => {
            let norm = (both.ray[0] * both.ray[0] + both.ray[1] * both.ray[1]).sqrt();
            let mixed = |a: R, b: R| a + weight * (b - a);
            (
                mixed(both.front.time, time),
                mixed(both.front.curvature, curvature),
                [mixed(both.ray[0] / norm, to[0]), mixed(both.ray[1] / norm, to[1])],
                if weight > half { end } else { own_end(&[first, second], [p, h], d) },
            )
        }
        (Some(both), None) if weight < one => {
            (both.front.time, both.front.curvature, both.ray, own_end(&[first, second], [p, h], d))
        }
        (None, Some(found)) if weight >= half => found,
        _ => return None,
    };
    let course =
        ends[end].course.turned_to(angle_at_apex(apex, [p, h], [shape.side, shape.other], to));
    Some(RayFront { front: Front { time, curvature, whole: true }, course })
}

/// Returns the end whose front reaches x0 first.
#[inline(always)]
fn own_end<R: Real>([first, second]: &[Ray<R>; 2], [p, h]: [R; 2], d: R) -> usize {
    usize::from(second.rise([p - R::one(), h]) + d < first.rise([p, h]))
}

/// Returns the place on the base where the curvature of the front jumps: where the line through the centres of both
/// circles crosses the base, or where both fronts would be late by as much.
#[inline(always)]
fn jump_at<R: Real>([first, second]: [&Ray<R>; 2], [m1, m2]: [R; 2], is_divided: bool) -> R {
    let (zero, one) = (R::zero(), R::one());
    let den = second.kappa * first.to[1] - first.kappa * second.to[1];
    let num = first.to[0] * second.to[1] - second.to[0] * first.to[1] + second.kappa * first.to[1];
    let has_centres = (den.abs() > R::of(APART)) & !first.is_source & !second.is_source;
    // Beside a straight source, the front of each end would pass the other one as early as it is away from the source.
    let (a, b) = (m2.abs(), m1.abs());
    let (a, b) = if is_divided { (a, b) } else { (a.sqrt(), b.sqrt()) };
    let at = if has_centres { num / den } else { a / max(a + b, R::min_positive_value()) };
    min(max(at, zero), one)
}

/// Fronts of single ends, joined.
#[derive(Clone, Copy)]
struct Joint<R> {
    rise: R,
    kappa: R,
    to: [R; 2],
    back: R,
    /// The share of the second front.
    second: R,
}

impl<R: Real> Joint<R> {
    /// Returns the front of one end, delayed against the first end.
    #[inline(always)]
    fn of(ends: &[Alone<R>; 2], end: usize, d: R) -> Self {
        let Alone { rise, kappa, to, back, .. } = ends[end];
        let (delay, second) = if end == 0 { (R::zero(), R::zero()) } else { (d, R::one()) };
        Self { rise: rise + delay, kappa, to, back, second }
    }

    /// Returns the front across a base on which the curvature jumps at a place. Rays that cross the base far apart are not
    /// those of one smooth transition. Then the front is the one whose ray crosses its own side of the jump.
    #[inline(always)]
    fn across(ends: &[Alone<R>; 2], jump: R, d: R) -> Self {
        let [a, b] = ends;
        if (a.crossing - b.crossing).abs() <= R::of(TOGETHER) {
            return Self::between(ends, jump, d);
        }
        let (beyond_a, beyond_b) = (a.crossing - jump, jump - b.crossing);
        let both = max(beyond_a, beyond_b) <= R::zero();
        let second = if both { b.rise + d < a.rise } else { beyond_b < beyond_a };
        Self::of(ends, usize::from(second), d)
    }

    /// Returns the transition from one front to the other about a place of the base.
    #[inline(always)]
    fn between([a, b]: &[Alone<R>; 2], jump: R, d: R) -> Self {
        let (one, least) = (R::one(), R::of(0.01));
        let (per_first, per_second) = (one / max(jump, least), one / max(one - jump, least));
        let mut at = R::of(0.5) * (a.crossing + b.crossing);
        let (mut second, mut slope) = (R::zero(), R::zero());
        for _ in 0..2 {
            let (u, v) = (at * per_first, (one - at) * per_second);
            let [u7, v7] = [u, v].map(|x| {
                let (square, cube) = (x * x, x * x * x);
                square * square * cube
            });
            let (of_a, of_b) = (u7 * u, v7 * v);
            let per = one / (of_a + of_b + R::min_positive_value());
            second = of_a * per;
            at = a.crossing + second * (b.crossing - a.crossing);
            slope = R::of(8.0) * (u7 * per_first * of_b + of_a * v7 * per_second) * per * per;
        }
        let mix = |a: R, b: R| a + second * (b - a);
        let (kappa, back) = (mix(a.kappa, b.kappa), mix(a.back, b.back));
        let to = [mix(a.to[0], b.to[0]), mix(a.to[1], b.to[1])];
        // The transition itself turns the front.
        let late = b.rise + d - a.rise;
        let turn = slope * late / max(to[1], R::of(0.05)) * max(one - kappa * back, R::zero());
        let turn = min(max(turn, R::of(-0.3)), R::of(0.3));
        let to = [to[0] + turn * to[1], to[1] - turn * to[0]];
        Self { rise: mix(a.rise, b.rise + d), kappa, to, back, second }
    }
}

/// Returns the angle in the fan of x0 of a ray in the plane of the triangle. It is measured from the middle between the
/// edges, so that both sides share the scaling of the fan.
#[inline(always)]
fn angle_at_apex<R: Real>(
    apex: &RayApex<R>,
    [p, h]: [R; 2],
    [side, other]: [R; 2],
    to: [R; 2],
) -> R::Bits {
    let wedge = R::angle_between(apex.edges[0], apex.edges[1]);
    let middle = [(R::one() - p) * side - p * other, -h * (side + other)];
    let across = middle[1] * to[0] - middle[0] * to[1];
    let along = -(middle[0] * to[0] + middle[1] * to[1]);
    let from_middle = angle_of([along, across]);
    let from_middle = if wedge < R::zero() { -from_middle } else { from_middle };
    let half_turn = R::of(std::f64::consts::PI);
    R::angle_ahead(apex.edges[0], R::of(0.5) * wedge + half_turn + from_middle)
}

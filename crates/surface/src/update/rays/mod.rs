//! Implements the wavefront whose fronts carry their ray: its direction, and the source from which it comes.
//!
//! A time and a curvature at each end of a base do not tell whether both ends were reached by one front. With the rays
//! at both ends, the front of each end can be continued to the other end. Where it arrives there when the other front
//! does, the front is one circle, and the curved update applies. Where it arrives later, the base crosses a crease, and
//! the front of each end goes on alone. A jump of curvature between both ends, as behind an obstacle or beside the
//! end of a curve, is a transition from one to the other.

mod alone;
mod of_one;

use super::course::Course;
use super::curved::{Curvatures, Front, bent, traced};
use super::{Shape, Triangle};
use crate::angle::{angle_of, sin_cos};
use crate::constants::FAN;
use crate::{DIFFRACTS, LACKING, Real, Seed, Tagged, max, min};
use alone::{Alone, Joint, Ray, jump_at};
pub use of_one::{FrontOfOne, of_one_front};

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
    if time >= R::FAR {
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

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec2;

    /// A point source, or a straight front that passes a place at the time zero in a direction.
    #[derive(Clone, Copy)]
    enum From {
        Point(DVec2),
        Line(DVec2, DVec2),
    }

    impl From {
        fn time(self, at: DVec2) -> f64 {
            match self {
                Self::Point(from) => at.distance(from),
                Self::Line(on, along) => (at - on).dot(along.normalize()),
            }
        }

        fn ray(self, at: DVec2) -> DVec2 {
            match self {
                Self::Point(from) => at - from,
                Self::Line(_, along) => along,
            }
        }

        fn curvature(self, at: DVec2) -> f64 {
            match self {
                Self::Point(from) => at.distance(from).recip(),
                Self::Line(..) => 0.0,
            }
        }
    }

    /// Words of angles in a plane.
    fn word(to: DVec2) -> u64 {
        f64::angle_ahead(0, to.to_angle())
    }

    /// The arguments of an update in a plane, from a front at each end of the base.
    fn update(
        [x0, x1, x2]: [DVec2; 3],
        [first, second]: [From; 2],
    ) -> (Triangle<f64>, [RayEnd<f64>; 2], RayApex<f64>) {
        let end = |at: DVec2, other: DVec2, from: From, source| RayEnd {
            curvature: from.curvature(at),
            course: Course::new(word(from.ray(at)), source),
            gaussian: 0.0,
            base: word(other - at),
            side: word(x0 - at),
        };
        let (l1, l2, c) = (x0.distance(x1), x0.distance(x2), x1.distance(x2));
        let triangle = Triangle { t1: first.time(x1), t2: second.time(x2), l1, l2, c };
        let other = u32::from(!std::ptr::eq(&first, &second));
        let ends = [end(x1, x2, first, 1), end(x2, x1, second, 1 + other)];
        (triangle, ends, RayApex { gaussian: 0.0, edges: [word(x1 - x0), word(x2 - x0)] })
    }

    /// Triangles of square, long and sheared cells, and their mirror images.
    fn triangles() -> Vec<[DVec2; 3]> {
        let at = DVec2::new;
        let upright = [
            [at(0.0, 1.0), at(0.0, 0.0), at(1.0, 0.0)],
            [at(3.0, 1.0), at(0.0, 0.0), at(3.0, 0.0)],
            [at(0.3, 0.8), at(0.0, 0.0), at(1.0, 0.0)],
        ];
        let mirrored = upright.map(|[x0, x1, x2]| [x0, x2, x1]);
        upright.into_iter().chain(mirrored).collect()
    }

    #[test]
    fn one_front_is_its_circle() {
        for corners in triangles() {
            let [x0, x1, x2] = corners;
            for step in 0..40 {
                // The ray crosses the base.
                let crossing = x1.lerp(x2, 0.05 + 0.9 * f64::from(step % 10) / 9.0);
                let away = [0.6, 3.0, 40.0, 1e3][step as usize / 10];
                let from = From::Point(crossing + (crossing - x0) * away);
                let (triangle, ends, apex) = update(corners, [from, from]);
                let ends = ends.map(|end| RayEnd { course: Course::new(end.course.0, 1), ..end });
                let of_one = of_one_front(triangle, &ends, &apex);
                // Near its source the front turns too much along the base for the fast test.
                assert!(of_one.is_one || away < 10.0, "{corners:?} {crossing} {away}");
                let fast = of_one.is_one.then_some(of_one.front);
                for found in fast.into_iter().chain([rays(triangle, &ends, &apex)]) {
                    let exact = from.time(x0);
                    assert!((found.front.time - exact).abs() < 1e-7 * exact, "{found:?} {exact}");
                    let turn = f64::angle_between(word(from.ray(x0)), found.course.0);
                    assert!(turn.abs() < 1e-6 && found.front.whole, "{turn}");
                    assert!((found.front.curvature * exact - 1.0).abs() < 1e-5);
                }
            }
        }
    }

    #[test]
    fn where_two_fronts_meet_the_earlier_goes_on_alone() {
        for corners in triangles() {
            let [x0, x1, x2] = corners;
            let base = x2 - x1;
            let down = base.perp() * base.perp().dot(x1 - x0).signum();
            for (a, b) in [(0.0, 0.0), (0.2, -0.3), (-0.4, 0.1)] {
                // Both sources lie beyond the base, each nearer to its own end.
                let sources = [x1 + down + a * base - base, x2 + 1.2 * down + b * base + base];
                let [first, second] = sources.map(From::Point);
                let nearer = |at: DVec2| first.time(at) <= second.time(at);
                if !nearer(x1) || nearer(x2) {
                    continue;
                }
                let (triangle, ends, apex) = update(corners, [first, second]);
                assert!(!of_one_front(triangle, &ends, &apex).is_one);
                let found = rays(triangle, &ends, &apex);
                let exact = first.time(x0).min(second.time(x0));
                assert!(found.front.time >= exact - 1e-6, "{} early: {exact}", found.front.time);
                let along = (triangle.t1 + triangle.l1).min(triangle.t2 + triangle.l2);
                assert!(found.front.time <= along + 1e-12);
            }
        }
    }

    /// Beside the end of a straight source, the front is straight on one side and a circle on the other.
    #[test]
    fn a_straight_front_and_the_circle_around_its_end_meet_at_a_jump() {
        let corners = [DVec2::new(0.0, 1.0), DVec2::new(0.0, 0.0), DVec2::new(1.0, 0.0)];
        for end in [0.25, 0.5, 0.75] {
            let tip = DVec2::new(end, -0.8);
            let (line, circle) = (From::Line(tip, DVec2::Y), From::Point(tip));
            let (triangle, ends, apex) = update(corners, [circle, line]);
            let found = rays(triangle, &ends, &apex);
            // The corner x0 lies on the side of the circle. The transition from one to the other has a width.
            let exact = circle.time(corners[0]);
            assert!((found.front.time - exact).abs() < 1e-3, "{end}: {found:?} {exact}");
        }
    }

    /// The fronts on both sides of a straight source do not make one front.
    #[test]
    fn a_source_between_both_ends_is_no_front() {
        let corners = [DVec2::new(0.0, 1.0), DVec2::new(0.0, 0.0), DVec2::new(1.0, 0.0)];
        let on = DVec2::new(0.4, 0.0);
        for along in [DVec2::new(1.0, 0.3), DVec2::new(1.0, -0.3)] {
            let (first, second) = (From::Line(on, -along), From::Line(on, along));
            let (triangle, ends, apex) = update(corners, [first, second]);
            let found = rays(triangle, &ends, &apex);
            let exact = first.time(corners[0]).abs();
            assert!(found.front.time >= exact - 1e-6, "{found:?} {exact}");
        }
    }

    #[test]
    fn fronts_leave_a_curve_through_grid_points_to_both_sides() {
        for side in [1.0, -1.0] {
            let corners = [DVec2::new(0.3, side), DVec2::new(0.0, 0.0), DVec2::new(1.0, 0.0)];
            let line = From::Line(DVec2::ZERO, DVec2::Y);
            let (triangle, mut ends, apex) = update(corners, [line, line]);
            for end in &mut ends {
                end.course = Course::new(end.course.0, 1).to_both_sides();
            }
            let found = rays(triangle, &ends, &apex);
            assert!((found.front.time - 1.0).abs() < 1e-7 && found.front.whole, "{found:?}");
        }
    }
}

//! Continues the front of a single end of a base to x0, and joins the fronts of both ends where a curvature jumps.

use super::{APART, PAST_END, RayEnd, TOGETHER};
use crate::angle::{angle_of, sin_cos};
use crate::{Real, Seed, max, min};

/// A ray in the plane of the triangle. Lengths are in units of the base.
#[derive(Clone, Copy)]
pub(super) struct Ray<R> {
    pub(super) to: [R; 2],
    pub(super) kappa: R,
    pub(super) is_source: bool,
}

impl<R: Real> Ray<R> {
    #[inline(always)]
    pub(super) fn new(end: &RayEnd<R>, base: R, [p, h]: [R; 2], mirrored: bool) -> Self {
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
    pub(super) fn rise(&self, [x, y]: [R; 2]) -> R {
        let square = x * x + y * y;
        let n = R::of(2.0) * (self.to[0] * x + self.to[1] * y) + self.kappa * square;
        let rise = n / (R::one() + max(R::one() + self.kappa * n, R::zero()).sqrt());
        if self.is_source { square.sqrt() } else { rise }
    }
}

/// The front of one end alone, at x0.
#[derive(Clone, Copy)]
pub(super) struct Alone<R> {
    /// Whether its ray crosses the base after the front has left its source.
    pub(super) comes: bool,
    pub(super) rise: R,
    /// The place where the ray crosses the base, from x1 on, and the length from there.
    pub(super) crossing: R,
    pub(super) back: R,
    /// Direction of the ray at x0, normalized, and the curvature there.
    pub(super) to: [R; 2],
    pub(super) kappa: R,
}

impl<R: Real> Alone<R> {
    #[inline(always)]
    pub(super) fn new(ray: &Ray<R>, at: R, [p, h]: [R; 2], side: R) -> Self {
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

/// Returns the place on the base where the curvature of the front jumps: where the line through the centres of both
/// circles crosses the base, or where both fronts would be late by as much.
#[inline(always)]
pub(super) fn jump_at<R: Real>(
    [first, second]: [&Ray<R>; 2],
    [m1, m2]: [R; 2],
    is_divided: bool,
) -> R {
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
pub(super) struct Joint<R> {
    pub(super) rise: R,
    pub(super) kappa: R,
    pub(super) to: [R; 2],
    pub(super) back: R,
    /// The share of the second front.
    pub(super) second: R,
}

impl<R: Real> Joint<R> {
    /// Returns the front of one end, delayed against the first end.
    #[inline(always)]
    pub(super) fn of(ends: &[Alone<R>; 2], end: usize, d: R) -> Self {
        let Alone { rise, kappa, to, back, .. } = ends[end];
        let (delay, second) = if end == 0 { (R::zero(), R::zero()) } else { (d, R::one()) };
        Self { rise: rise + delay, kappa, to, back, second }
    }

    /// Returns the front across a base on which the curvature jumps at a place. Rays that cross the base far apart are not
    /// those of one smooth transition. Then the front is the one whose ray crosses its own side of the jump.
    #[inline(always)]
    pub(super) fn across(ends: &[Alone<R>; 2], jump: R, d: R) -> Self {
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
    pub(super) fn between([a, b]: &[Alone<R>; 2], jump: R, d: R) -> Self {
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

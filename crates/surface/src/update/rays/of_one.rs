//! Computes the front through a base that one front has reached, without branches.

use super::super::Triangle;
use super::super::curved::{Curvatures, Front, traced};
use super::{CREASE, JUMP, RayApex, RayEnd, RayFront, angle_at_apex};
use crate::angle::cosine;
use crate::{Real, Seed, max, min};

/// A front through the face of a triangle whose base one front has reached.
#[derive(Clone, Copy, Debug)]
#[doc(hidden)]
pub struct FrontOfOne<R: Real> {
    /// The front. If it is not whole, its time is that along an edge, and the rest is not defined.
    pub front: RayFront<R>,
    /// Whether one front has reached both ends of the base, so that [`super::rays`] has the same result. Otherwise
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
    let is_everywhere = max(fronts[0], fronts[1]) >= at_source;
    let leaves = !is_everywhere
        & (sign * first < zero)
        & (sign * second < zero)
        & !ends[0].course.is_to_both_sides()
        & !ends[1].course.is_to_both_sides();
    let plain = !is_everywhere & ends[0].course.is_plain_as(ends[1].course);
    let angle = angle_at_apex(apex, traced.apex, traced.sides, traced.ray);
    let inside = traced.inside & !leaves;
    let along_edge = min(triangle.t1 + triangle.l1, triangle.t2 + triangle.l2);
    let time = if inside { traced.front.time } else { along_edge };
    FrontOfOne {
        front: RayFront {
            front: Front { time, whole: inside, ..traced.front },
            course: ends[0].course.turned_to(angle),
        },
        is_one: !exists | leaves | (turns & agrees & plain),
    }
}

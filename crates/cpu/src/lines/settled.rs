//! Finds points that an update leaves unchanged, without the update's square roots and divisions.
//!
//! A front crosses the base x1 x2 of a triangle at some point x. The time there is at least the linear
//! interpolation between t1 and t2, less a bulge. From there the front has to travel at least |x0 - x|. That
//! is at least `u . (x0 - x)` for every unit vector u. So the front arrives no earlier than the lesser of
//!
//! - t1 + u . (x0 - x1) and
//! - t2 + u . (x0 - x2),
//!
//! less the bulge. Here x1 is the neighbour across the grid's diagonal, and u is the direction from x1 to x0. On the
//! other side of that diagonal lies a triangle of a scan along the other axis, and the test also finds settled fronts
//! that came through that triangle. Until a map converges, scans visit a point about four times, and only one or two of
//! these visits need the update. With x1 and x2 exchanged, u is the direction from the neighbour beside x0 to x0. That
//! test decides whether an update can skip one of the two triangles of x0.
//!
//! `crate::pairwise` has the same test, with coefficients that are computed once for many maps.

use geosweep_surface::update::Triangle;
use geosweep_surface::{Real, max, min};

/// A point that a scan visits, before any update.
pub struct Visited<R> {
    /// Arrival time.
    pub now: R,
    /// The two triangles of the scan. In both, x1 is the neighbour across the diagonal.
    pub triangles: [Triangle<R>; 2],
}

impl<R: Real> Visited<R> {
    /// Returns whether no front arrives at the point earlier than the present one: either all neighbours behind it are
    /// reached no earlier than the point itself, or neither triangle brings an earlier front. `settled` tells for each
    /// triangle whether it brings no earlier front.
    #[inline(always)]
    #[doc(hidden)]
    pub fn stays(&self, settled: [bool; 2]) -> bool {
        let [left, right] = &self.triangles;
        let behind = min(left.t1, min(left.t2, right.t1));
        (behind >= self.now) | (settled[0] & settled[1])
    }
}

/// Lower bounds of a planar front's arrival time, minus the present time.
struct Lead<R> {
    /// The bound from x1.
    across: R,
    /// The bound from x2, times the length of the edge to x1, which saves a division.
    beside: R,
    /// The length of the edge to x1.
    edge: R,
}

impl<R: Real> Lead<R> {
    #[inline(always)]
    fn new(Triangle { t1, t2, l1, l2, c }: Triangle<R>, now: R) -> Self {
        // The minimum applies where the lengths form no triangle. Fronts then run along its edges only.
        let projection = min(R::of(0.5) * (l1 * l1 + l2 * l2 - c * c), l1 * l2);
        Self { across: t1 + l1 - now, beside: (t2 - now) * l1 + projection, edge: l1 }
    }

    /// Returns whether both bounds exceed a bulge of `dividend / divisor`, or false where edges are missing.
    #[inline(always)]
    fn exceeds(self, dividend: R, divisor: R) -> bool {
        (self.across * divisor > dividend) & (self.beside * divisor > self.edge * dividend)
    }
}

/// Returns whether it is certain, up to rounding, that no planar front arrives through a triangle earlier than `now`:
/// neither bound of the module's comment is earlier. Here and below, x1 may be either end of the base. The two choices
/// are different tests: either may find a settled point that the other misses.
#[inline(always)]
pub fn from_planar<R: Real>(triangle: Triangle<R>, now: R) -> bool {
    let Lead { across, beside, .. } = Lead::new(triangle, now);
    (across >= R::zero()) & (beside >= R::zero())
}

/// Returns whether it is certain that no circular front arrives through a triangle earlier than `now`. Let r be the
/// distance from the front's source to the nearest point of the base. Then the times along the base are at most c^2 /
/// 8r below their linear interpolation. With t as the time at the earlier end, r is at least t - c / 2.
#[inline(always)]
pub fn from_circular<R: Real>(triangle: Triangle<R>, now: R) -> bool {
    let Triangle { t1, t2, c, .. } = triangle;
    let distance = max(min(t1, t2) - R::of(0.5) * c, R::zero());
    Lead::new(triangle, now).exceeds(R::of(0.125) * c * c, distance)
}

/// Returns whether it is certain that every curved front through a triangle arrives later than `now`, given the
/// curvatures at x1 and x2. With kappa as the larger curvature, the centre of the front that the update assumes is at
/// least 1 / kappa from the later end of the base. So the centre is at least 1 / kappa - c from all points of the base.
#[inline(always)]
pub(crate) fn from_curved<R: Real>(triangle: Triangle<R>, curvatures: [R; 2], now: R) -> bool {
    let [k1, k2] = curvatures;
    let kappa = max(max(k1, k2), R::zero()) * triangle.c;
    let divisor = R::of(8.0) * max(R::one() - kappa, R::zero());
    // This is an upper bound of the rounding in this test.
    let slack = R::of(16.0) * R::epsilon() * now;
    Lead::new(triangle, now).exceeds(triangle.c * kappa + slack * divisor, divisor)
}

#[cfg(test)]
mod tests {
    use super::*;
    use geosweep_surface::update::{Curvatures, circular, curved, planar};
    use glam::DVec2;

    /// Calls `check` with triangles of all shapes, obtuse and acute, and the arrival times of fronts from all
    /// directions.
    fn every_triangle(check: impl Fn(Triangle<f32>)) {
        let steps =
            |from: f64, to: f64| (0..8).map(move |k| from + (to - from) * f64::from(k) / 7.0);
        for (angle, length) in
            steps(0.1, 3.0).flat_map(|a| [0.4, 1.0, 1.4, 3.0].map(move |length| (a, length)))
        {
            let (x1, x2) = (DVec2::new(length, 0.0), DVec2::from_angle(angle));
            for (angle, distance) in
                steps(-3.1, 3.1).flat_map(|a| [1.5, 4.0, 30.0, 500.0].map(move |far| (a, far)))
            {
                let source = DVec2::from_angle(angle) * distance;
                let [t1, t2] = [x1, x2].map(|corner| corner.distance(source) as f32);
                let (l1, l2) = (x1.length() as f32, x2.length() as f32);
                check(Triangle { t1, t2, l1, l2, c: x1.distance(x2) as f32 });
            }
        }
    }

    /// Asserts, for present times before and after a front, that no front arrives earlier where the test reports
    /// settled. Also asserts that the test is worth its cost: it must hold for more than `share` of the present times
    /// before which no front arrives.
    fn assert_settles(
        share: f64,
        arrival: impl Fn(Triangle<f32>) -> f32,
        settled: impl Fn(Triangle<f32>, f32) -> bool,
    ) {
        let counts = std::cell::Cell::new([0; 2]);
        every_triangle(|triangle| {
            let arrives = arrival(triangle);
            let first = min(triangle.t1, triangle.t2);
            for now in (0..100).map(|k| first + 0.04 * k as f32) {
                let [mut all, mut found] = counts.get();
                if settled(triangle, now) {
                    let rounding = 8.0 * f32::EPSILON * now;
                    assert!(arrives >= now - rounding, "{arrives} before {now}: {triangle:?}");
                    found += 1;
                }
                all += u32::from(arrives >= now);
                counts.set([all, found]);
            }
        });
        let [all, found] = counts.get().map(f64::from);
        assert!(found > share * all, "{found} of {all}");
    }

    #[test]
    fn no_settled_point_is_reached_earlier_by_a_planar_front() {
        assert_settles(0.5, planar, from_planar);
    }

    #[test]
    fn no_settled_point_is_reached_earlier_by_a_circular_front() {
        assert_settles(0.3, |triangle| circular(triangle, false), from_circular);
    }

    #[test]
    fn no_settled_point_is_reached_earlier_by_a_curved_front() {
        // Fronts that spread, are flat or converge, mostly with different curvatures at both ends.
        for curvatures in
            [[0.3, 0.2], [0.01, 0.7], [0.0; 2], [-0.2, 0.05], [-0.5, -1.0], [1e18, 2.0]]
        {
            let bends =
                Curvatures { fronts: curvatures, surface: [0.0; 3], alone: false, causal: false };
            let share = if curvatures[0] > 1.0 { -1.0 } else { 0.15 };
            assert_settles(
                share,
                |triangle| curved(triangle, bends).time,
                |triangle, now| {
                    let settled = from_curved(triangle, curvatures, now);
                    assert!(!settled || curved(triangle, bends).time > now, "at the same time");
                    settled
                },
            );
        }
    }

    #[test]
    fn nothing_is_settled_where_an_edge_is_missing() {
        let far = f32::FAR;
        let whole = Triangle { t1: 1.0, t2: 1.0, l1: 1.4, l2: 1.0, c: 1.0 };
        for triangle in [
            Triangle { t1: far, l1: far, c: far, ..whole },
            Triangle { c: far, ..whole },
            Triangle { t2: far, l2: far, c: far, ..whole },
        ] {
            let now = planar(triangle) + 0.1;
            assert!(!from_planar(triangle, now), "{triangle:?}");
            assert!(!from_circular(triangle, now), "{triangle:?}");
            assert!(!from_curved(triangle, [0.1; 2], now), "{triangle:?}");
        }
    }
}

//! Bounds how early a front can arrive, without the square roots of an update.

use super::kernel::Fan;
use geosweep_surface::update::Corner;
use geosweep_surface::{max, min};

/// A lower bound of the arrival times that a fan can give.
///
/// A planar front crosses the base x1 x2 of a triangle at some point x. The time t(x) there is the linear
/// interpolation between t1 and t2. From there the front has to travel at least |x0 - x|. That is at least
/// `u . (x0 - x)` for every unit vector u. The sum is linear in x. So t0 is not earlier than the lesser of
///
/// - t1 + u . (x0 - x1) and
/// - t2 + u . (x0 - x2).
///
/// Here u runs along the outer edge of each triangle, which is a diagonal of the grid. A scan along the other axis has
/// a triangle on the other side of that diagonal. The bound also detects points that keep a time from that triangle. So
/// the four scans update each point about once and not twice.
#[derive(Clone, Copy, Debug)]
pub(super) struct Reach {
    before: f32,
    beside: f32,
    after: f32,
}

impl Reach {
    pub(super) fn new(fan: Fan) -> Self {
        let [before, beside, after] = fan.edges;
        let along = |outer: f32, base: f32| match Corner::new(outer, beside, base) {
            Corner::Triangle { .. } => {
                let [outer, beside, base] = [outer, beside, base].map(f64::from);
                (0.5 * (outer * outer + beside * beside - base * base) / outer) as f32
            }
            _ => beside,
        };
        let beside = min(along(before, fan.bases[0]), along(after, fan.bases[1]));
        Self { before, beside, after }
    }

    /// Returns a lower bound, up to rounding, of the arrival time of planar fronts, given the arrival times at the
    /// points behind.
    #[inline(always)]
    pub(super) fn earliest(&self, before: f32, beside: f32, after: f32) -> f32 {
        min(min(before + self.before, beside + self.beside), after + self.after)
    }
}

/// A bound of how far a circular front can be ahead of a planar one between the ends of a base.
///
/// If the front's source is at a distance r from the nearest point of the base, the distance from the source to the
/// points of the base is at most c^2 / 8r below its linear interpolation between the ends. If t is the time at the
/// earlier end, r is at least t - c / 2.
#[derive(Clone, Copy, Debug)]
pub(super) struct Bulge {
    half_base: f32,
    /// c^2 / 8.
    times_distance: f32,
}

impl Bulge {
    pub(super) fn new(fan: Fan) -> Self {
        let [before, beside, after] = fan.edges;
        let longest = [(before, fan.bases[0]), (after, fan.bases[1])]
            .into_iter()
            .filter(|&(outer, base)| {
                matches!(Corner::new(outer, beside, base), Corner::Triangle { .. })
            })
            .fold(0.0, |longest, (_, base)| max(longest, base));
        // Positive, so that a time no earlier than all planar fronts is not kept.
        let times_distance = max(0.125 * longest * longest, f32::MIN_POSITIVE);
        Self { half_base: 0.5 * longest, times_distance }
    }

    /// Returns whether a time that is `ahead` of all planar fronts stays the earliest, if the earliest of the points
    /// behind is reached at `first`.
    #[inline(always)]
    pub(super) fn keeps(&self, ahead: f32, first: f32) -> bool {
        ahead * max(first - self.half_base, 0.0) >= self.times_distance
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use geosweep_surface::Real;
    use geosweep_surface::update::{self, circular, planar};

    /// Calls `check` with fans of all shapes, obtuse and acute, and with fronts from all directions.
    fn every_fan(check: impl Fn(Fan, [f32; 3])) {
        let place = |angle: f64, length: f64| glam::DVec2::from_angle(angle) * length;
        let steps =
            |from: f64, to: f64| (0..6).map(move |k| from + (to - from) * f64::from(k) / 5.0);
        for (first, second) in steps(0.2, 2.2).flat_map(|a| steps(0.2, 2.2).map(move |b| (a, b))) {
            for (outer, inner) in [(1.4, 1.0), (1.0, 1.0), (0.6, 1.0), (2.5, 1.0)] {
                let (before, beside, after) =
                    (place(first, outer), place(0.0, inner), place(-second, 1.3));
                let fan = Fan {
                    edges: [before, beside, after].map(|corner| corner.length() as f32),
                    bases: [before.distance(beside) as f32, beside.distance(after) as f32],
                };
                for (angle, far) in
                    steps(-2.5, 2.5).flat_map(|a| [1.5, 3.0, 20.0, 300.0].map(move |far| (a, far)))
                {
                    let source = place(angle, far);
                    let times =
                        [before, beside, after].map(|corner| corner.distance(source) as f32);
                    check(fan, times);
                }
            }
        }
    }

    fn updates(fan: Fan, [a, b, c]: [f32; 3], update: fn(update::Triangle<f32>) -> f32) -> f32 {
        let [l1, l2, l3] = fan.edges;
        let left = update::Triangle { t1: a, t2: b, l1, l2, c: fan.bases[0] };
        let right = update::Triangle { t1: b, t2: c, l1: l2, l2: l3, c: fan.bases[1] };
        min(update(left), update(right))
    }

    #[test]
    fn no_planar_front_is_earlier() {
        every_fan(|fan, times| {
            let [a, b, c] = times;
            let (t0, bound) = (updates(fan, times, planar), Reach::new(fan).earliest(a, b, c));
            assert!(t0 >= bound * (1.0 - 4.0 * f32::EPSILON), "{t0} before {bound}: {fan:?}");
        });
    }

    #[test]
    fn no_circular_front_is_earlier_than_what_is_kept() {
        let kept = std::cell::Cell::new(0);
        every_fan(|fan, times| {
            let [a, b, c] = times;
            let (reach, bulge) = (Reach::new(fan), Bulge::new(fan));
            let (t0, first) =
                (updates(fan, times, |triangle| circular(triangle, false)), min(min(a, b), c));
            for now in (0..80).map(|k| first + 0.05 * k as f32) {
                if bulge.keeps(reach.earliest(a, b, c) - now, first) {
                    kept.set(kept.get() + 1);
                    assert!(t0 >= now * (1.0 - 8.0 * f32::EPSILON), "{t0} before {now}: {fan:?}");
                }
            }
        });
        assert!(kept.get() > 1000, "the test keeps hardly anything");
    }

    /// The fan has edges without a triangle, beside a source.
    #[test]
    fn unreached_times_are_never_kept() {
        let far = f32::FAR;
        let fan = Fan { edges: [far, 1.0, far], bases: [far; 2] };
        let earliest = Reach::new(fan).earliest(far, 0.0, far);
        assert_eq!(earliest, 1.0);
        assert!(!Bulge::new(fan).keeps(earliest - far, 0.0));
        assert!(!Bulge::new(fan).keeps(earliest - 1.5, 0.0));
    }

    /// A front along one axis of the grid has its times from one scan, and the other scans do not change
    /// them.
    #[test]
    fn the_scan_across_leaves_arrived_fronts() {
        let diagonal = 2f32.sqrt();
        let fan = Fan { edges: [diagonal, 1.0, diagonal], bases: [1.0; 2] };
        // The scan comes from the west. The source lies to the north, at these angles from north.
        for angle in (0..44).map(|degrees| (degrees as f32).to_radians()) {
            let (south, east) = (angle.cos(), angle.sin());
            let now = 100.0;
            let [a, b, c] = [now - south - east, now - east, now + south - east];
            let reach = Reach::new(fan);
            assert!(reach.earliest(a, b, c) >= now);
            // At 44 degrees the bulge is larger than the lead.
            let kept = Bulge::new(fan).keeps(reach.earliest(a, b, c) - now, min(min(a, b), c));
            assert!(kept || angle > 0.7);
        }
    }
}

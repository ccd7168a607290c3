//! The front at x0 where two arcs of different curvature touch on the triangle's base: along the
//! border of the shadow behind a corner, where the front that runs by and the one that is diffracted
//! at the corner go on side by side; along the ray on which the front of a curve's end, or bend, meets
//! that of the curve.
//!
//! Arrival times and their gradient are continuous across that ray, the curvature is not, and its mean
//! that [`super::curved`] takes is neither's: an error of first order in the grid's step that follows
//! the ray. Here each arc is continued by itself. What the two ends of a base know is too little to
//! tell where the ray crosses it; a point y on the other side of the base, upwind, of the same arc as
//! one end tells that end's direction, and that the arcs touch tells the rest. On a flat surface the
//! result is exact.
//!
//! The twin of `glsl/two_arcs.glsl`.

use super::curved::{bent, curved};
use super::{Bends, Front, Shape, Triangle};
use crate::constants::{ALONG_A_RAY, ARCS_ALIKE, ARCS_APART, ARCS_BESIDE, ARCS_TOUCHING, FOCUS};
use crate::surface::{Real, max, min};

/// A point on the other side of the base x1 x2 from x0, and the front there.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Across<R> {
    /// Arrival time.
    pub time: R,
    /// Curvature of the front.
    pub curvature: R,
    /// Lengths of the edges to x1 and x2.
    pub sides: [R; 2],
}

impl<R> Across<R> {
    fn mirrored(self) -> Self {
        let [to_x1, to_x2] = self.sides;
        Self { sides: [to_x2, to_x1], ..self }
    }
}

/// Whether the fronts at both ends of a base are arcs of different curvature, by more than a share of the
/// larger: along a single arc 1 / k grows with the arrival time. Along fronts on curved surfaces
/// curvatures differ, too, which maps would lose accuracy by.
#[inline(always)]
pub(crate) fn are_two_arcs<R: Real>([t1, t2]: [R; 2], [k1, k2]: [R; 2]) -> bool {
    let apart = apart([t1, t2], [k1, k2]).abs() > R::of(ARCS_APART) * max(k1.abs(), k2.abs());
    apart & (max(t1, t2) < R::FAR) & (max(k1, k2) < R::SOURCE)
}

/// By how much the curvatures of arcs at both ends of a base differ, to within their spreading.
#[inline(always)]
fn apart<R: Real>([t1, t2]: [R; 2], [k1, k2]: [R; 2]) -> R {
    (k2 - k1) - k1 * k2 * (t1 - t2)
}

/// Whether a point across a base is of the same arc as one of its ends, all given by arrival time and
/// curvature: unless one of both is, [`two_arcs`] says nothing.
#[inline(always)]
pub(crate) fn is_of_either<R: Real>([x1, x2]: [[R; 2]; 2], across: [R; 2]) -> bool {
    is_of_same(x2, x1, across) | is_of_same(x1, x2, across)
}

/// Whether a point across a base is of the same arc as one of its ends: if both curvatures, at the end's
/// time, differ by less than a share of what the ends' do.
#[inline(always)]
fn is_of_same<R: Real>([t, k]: [R; 2], other: [R; 2], across: [R; 2]) -> bool {
    let spread = |[later, k]: [R; 2]| max(R::one() - k * (later - t), R::of(FOCUS));
    let (of_other, of_across) = (spread(other), spread(across));
    let apart = R::of(ARCS_ALIKE) * (other[1] - k * of_other).abs();
    (across[0] < R::FAR) & ((across[1] - k * of_across).abs() * of_other <= apart * of_across)
}

/// The front at x0 through a base on which two arcs touch, with either point across it; `None` if that
/// is not what they say.
pub(crate) fn two_arcs<R: Real>(
    triangle: Triangle<R>,
    bends: Bends<R>,
    across: [Across<R>; 2],
) -> Option<Front<R>> {
    let Triangle { t1, t2, l1, l2, c } = triangle;
    let Bends { fronts: [k1, k2], surface: [g0, g1, g2], .. } = bends;
    let mirrored = Triangle { t1: t2, t2: t1, l1: l2, l2: l1, c };
    // With the direction from a pair of points that lie the least along a ray.
    let mut best: Option<Arrival<R>> = None;
    for y in across {
        let of_x2 = arrival(triangle, [k1, k2], y).map(|front| (front, [g2, g1]));
        let of_x1 = arrival(mirrored, [k2, k1], y.mirrored()).map(|front| (front, [g1, g2]));
        for (front, [here, there]) in [of_x2, of_x1].into_iter().flatten() {
            if best.as_ref().is_none_or(|best| front.along < best.along) {
                let gaussian = R::of(0.5) * (g0 + here + front.share * (there - here));
                let curvature = bent(front.curvature, gaussian, front.ray);
                best = Some(Arrival { curvature, ..front });
            }
        }
    }
    // No later than along an edge, and after all that it comes from. Between the same two times arcs of
    // different curvature lie no further apart than by that times the base's square, or they do not touch
    // but meet, behind a hole.
    let latest = min(t1 + l1, t2 + l2) * (R::one() + R::of(16.0) * R::epsilon());
    let apart = apart([t1, t2], [k1, k2]).abs() * c * c;
    best.map(|front| Front { time: front.time, curvature: front.curvature, whole: true })
        .filter(|front| front.time <= latest && front.time > t1 && front.time > t2)
        .filter(|front| (front.time - curved(triangle, bends).time).abs() <= apart)
}

/// A front at x0, and its way there.
struct Arrival<R> {
    time: R,
    curvature: R,
    /// Length from the base, and where it crosses that: from 0 at x2 to 1 at x1.
    ray: R,
    share: R,
    /// How much the edge from y to x2 lies along the ray there: the cosine between them.
    along: R,
}

/// The front at x0 if y is of the same arc as x2. In units of the base, with x2 at the origin, x1 at
/// (1, 0), x0 above the base and y below it.
fn arrival<R: Real>(triangle: Triangle<R>, [k1, k2]: [R; 2], y: Across<R>) -> Option<Arrival<R>> {
    let Triangle { t1, t2, l1, l2, c } = triangle;
    let (zero, one, two) = (R::zero(), R::one(), R::of(2.0));
    if !is_of_same([t2, k2], [t1, k1], [y.time, y.curvature]) {
        return None;
    }
    let above = Shape::new(l2, l1, c);
    let below = Shape::new(y.sides[1], y.sides[0], c);
    if !(above.whole && below.whole) {
        return None;
    }
    let (x2, x1) = ([zero, zero], [one, zero]);
    let x0 = [above.foot, above.height_squared.sqrt()];
    let place_of_y = [below.foot, -below.height_squared.sqrt()];
    let later = |time: R| (time - t2) * above.per_base;
    let (d1, dy) = (later(t1), later(y.time));
    let (k1, k2) = (k1 * c, k2 * c);

    // The ray at x2, which may cross the base a little beyond its ends (ARCS_BESIDE), since rounding
    // decides where it runs through a grid point: the front arrives at y so much earlier, and on that
    // side of y on which it arrives at x1 about when it does. Often it runs through y, since corners lie
    // on the grid: the square root of the times' rounding would turn it.
    let length = below.side;
    let cosine = (dy - R::of(0.5) * k2 * (length * length - dy * dy)) / length;
    if cosine.abs() > one + R::of(ARCS_BESIDE) {
        return None;
    }
    let rounding = R::of(ALONG_A_RAY) * R::epsilon() * max(t1, t2) * above.per_base;
    let is_along = (one - cosine.abs()) * length <= rounding;
    let cosine = if is_along { one.copysign(cosine) } else { cosine };
    let doubt = cosine.abs();
    let sine = max((one - cosine) * (one + cosine), zero).sqrt();
    let towards_y = scaled(one / length, place_of_y);
    let known = [sine, -sine].map(|sine| {
        let ahead = sum(scaled(cosine, towards_y), scaled(sine, [-towards_y[1], towards_y[0]]));
        Arc { place: x2, ahead, curvature: k2 }
    });
    let [early, other] = known.map(|arc| arc.rise(x1) - d1);
    let (known, early) =
        if early.abs() <= other.abs() { (known[0], early) } else { (known[1], other) };

    // That of x1 touches it, to within ARCS_TOUCHING for the same reason: the distance of their centres
    // is the difference of their radii. So much says the cosine of the angle between the rays of both at
    // x1, times `spread`.
    let (rise, spread) = (known.rise(x1), known.spread(x1));
    let bend = (k2 - k1) - R::of(0.5) * k1 * k2 * (rise + d1);
    let half_squared = early * bend / (two * spread);
    if !(half_squared >= -R::of(ARCS_TOUCHING) && half_squared <= one) {
        return None;
    }
    let half_squared = max(half_squared, zero);
    let (cosine, sine) =
        (one - two * half_squared, two * (half_squared * (one - half_squared)).sqrt());
    // The more curved of the two is the one that the corner has sent, and its rays spread to its side.
    let is_fan = bend > zero;
    let sine = if is_fan { sine } else { -sine };
    let [across, along] = scaled(one / spread, known.ray(x1));
    let ahead = [cosine * across - sine * along, sine * across + cosine * along];
    let touching = Arc { place: x1, ahead, curvature: k1 };

    // The ray on which they touch runs through both centres, and x1 and x2 lie to its sides.
    let per = one / (k1 - k2 + k1 * k2 * d1);
    let between = sum(scaled(k1 * k2 * per, x1), scaled(k1 * per, known.ahead));
    let between = sum(between, scaled(-k2 * per, touching.ahead));
    let fan = if is_fan { known } else { touching };
    let beside = R::of(ARCS_BESIDE);
    let parts =
        clockwise(between, fan.ray(x1)) >= -beside && clockwise(between, fan.ray(x2)) <= beside;
    // And x0 lies between the rays at x1 and x2.
    let inside = clockwise(known.ahead, x0) >= -beside
        && clockwise(touching.ahead, sum(x0, scaled(-one, x1))) <= beside;
    let of_x1 = clockwise(between, fan.ray(x0)) > zero;
    let (arc, start) = if of_x1 { (touching, t1) } else { (known, t2) };
    let [across, along] = arc.ray(x0);
    let upwards = fan.curvature > zero && along > zero;
    if !(upwards && parts && inside) {
        return None;
    }
    Some(Arrival {
        time: start + c * arc.rise(x0),
        curvature: arc.curvature * above.per_base / arc.spread(x0),
        ray: c * x0[1] * arc.spread(x0) / along,
        share: x0[0] - x0[1] * across / along,
        along: doubt,
    })
}

/// A circular front at the time when it arrives at a place.
#[derive(Clone, Copy)]
struct Arc<R> {
    place: [R; 2],
    /// The direction of its ray there.
    ahead: [R; 2],
    curvature: R,
}

impl<R: Real> Arc<R> {
    /// How many times as far from the centre another place is.
    fn spread(self, to: [R; 2]) -> R {
        max(R::one() + self.curvature * self.excess(to), R::zero()).sqrt()
    }

    /// How much later it arrives there.
    fn rise(self, to: [R; 2]) -> R {
        self.excess(to) / (R::one() + self.spread(to))
    }

    /// The direction of the ray there, times the spread.
    fn ray(self, to: [R; 2]) -> [R; 2] {
        let way = sum(to, scaled(-R::one(), self.place));
        sum(self.ahead, scaled(self.curvature, way))
    }

    fn excess(self, to: [R; 2]) -> R {
        let [x, y] = sum(to, scaled(-R::one(), self.place));
        self.curvature * (x * x + y * y) + R::of(2.0) * (self.ahead[0] * x + self.ahead[1] * y)
    }
}

fn scaled<R: Real>(by: R, [x, y]: [R; 2]) -> [R; 2] {
    [by * x, by * y]
}

fn sum<R: Real>(a: [R; 2], b: [R; 2]) -> [R; 2] {
    [a[0] + b[0], a[1] + b[1]]
}

/// Positive if b points to the right of a, which is the side of x1 for what runs upwards.
fn clockwise<R: Real>(a: [R; 2], b: [R; 2]) -> R {
    a[1] * b[0] - a[0] * b[1]
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec2;

    /// A front from a source, diffracted at a corner to the right of the ray through it.
    struct Fronts {
        /// The source's distance behind the corner; infinite for a straight front.
        behind: f64,
        corner: DVec2,
        ahead: DVec2,
    }

    impl Fronts {
        /// Time since the front has passed the corner, and curvature.
        fn at(&self, place: DVec2) -> [f64; 2] {
            let way = place - self.corner;
            let in_shadow = self.ahead.perp_dot(way) < 0.0;
            if in_shadow {
                return [way.length(), 1.0 / way.length()];
            }
            if self.behind.is_infinite() {
                return [way.dot(self.ahead), 0.0];
            }
            let distance = place.distance(self.corner - self.behind * self.ahead);
            [distance - self.behind, 1.0 / distance]
        }
    }

    /// Triangles whose base both arcs cross, with the source near and far, close to the corner and
    /// far from it, upwards through the base at all angles.
    fn every_case(mut check: impl FnMut(&Fronts, [DVec2; 5])) {
        let (x1, x2) = (DVec2::new(1.0, 0.1), DVec2::ZERO);
        for (x0, across) in [
            (DVec2::new(0.0, 1.0), [DVec2::new(0.0, -1.0), DVec2::new(1.0, -0.9)]),
            (DVec2::new(0.9, 1.3), [DVec2::new(0.2, -0.8), DVec2::new(0.9, -1.1)]),
        ] {
            for behind in [0.5, 3.0, 200.0, f64::INFINITY] {
                for (away, place, angle) in [(2.0, 0.3, 1.9), (2.0, 0.7, 1.2), (15.0, 0.5, 1.5)] {
                    let ahead = DVec2::from_angle(angle);
                    let corner = x2 + place * (x1 - x2) - away * ahead;
                    let fronts = Fronts { behind, corner, ahead };
                    check(&fronts, [x0, x1, x2, across[0], across[1]]);
                }
            }
        }
    }

    fn found(
        fronts: &Fronts,
        [x0, x1, x2, y, z]: [DVec2; 5],
    ) -> (Triangle<f64>, Option<Front<f64>>) {
        let [[t1, k1], [t2, k2]] = [x1, x2].map(|place| fronts.at(place));
        let (l1, l2, c) = (x0.distance(x1), x0.distance(x2), x1.distance(x2));
        let triangle = Triangle { t1, t2, l1, l2, c };
        let across = [y, z].map(|place| {
            let [time, curvature] = fronts.at(place);
            Across { time, curvature, sides: [place.distance(x1), place.distance(x2)] }
        });
        let bends = Bends { fronts: [k1, k2], surface: [0.0; 3], alone: false };
        let front = two_arcs(triangle, bends, across);
        let may =
            |point: Across<f64>| is_of_either([[t1, k1], [t2, k2]], [point.time, point.curvature]);
        assert!(front.is_none() || across.into_iter().any(may));
        (triangle, front)
    }

    #[test]
    fn arcs_that_touch_on_the_base_are_continued_exactly() {
        let (mut exact, mut others) = (0, 0);
        every_case(|fronts, places| {
            let [x0, x1, x2, y, z] = places;
            let (triangle, front) = found(fronts, places);
            let turned = found(fronts, [x0, x2, x1, z, y]).1;
            let same = |a: &Front<f64>, b: &Front<f64>| {
                approx::abs_diff_eq!(a.time, b.time, epsilon = 1e-9)
            };
            assert!(front.iter().zip(&turned).all(|(a, b)| same(a, b)), "{front:?} {turned:?}");
            assert_eq!(front.is_some(), turned.is_some());
            let Some(front) = front else {
                others += 1;
                return;
            };
            let [time, curvature] = fronts.at(x0);
            // Square roots of rounding tell where the ray crosses the base.
            approx::assert_abs_diff_eq!(front.time, time, epsilon = 1e-9);
            approx::assert_relative_eq!(front.curvature, curvature, max_relative = 1e-6);
            let fronts = [x1, x2].map(|place| fronts.at(place)[1]);
            let mean = curved(triangle, Bends { fronts, surface: [0.0; 3], alone: false });
            // Far from the corner, with the source close behind it, both arcs are about the same.
            let apart = are_two_arcs([triangle.t1, triangle.t2], fronts);
            exact += usize::from(apart && (mean.time - time).abs() > 1e-4);
        });
        // The others' rays to x0 do not cross this base; of many the mean would be wrong.
        assert!(exact > 8 && others < 12, "{exact} {others}");
    }

    #[test]
    fn a_single_arc_is_not_taken_for_two() {
        for source in [DVec2::new(0.3, -0.8), DVec2::new(-4.0, -30.0), DVec2::new(0.9, -1.5)] {
            let [t1, t2] = [DVec2::X, DVec2::ZERO].map(|place| place.distance(source));
            assert!(!are_two_arcs([t1, t2], [1.0 / t1, 1.0 / t2]));
        }
        assert!(are_two_arcs([1.0, 1.2], [0.5, 0.2]));
        assert!(!are_two_arcs([1.0, f32::FAR], [0.5, 0.0]));
        assert!(!are_two_arcs([1.0, 1.2], [f32::SOURCE, 0.2]));
    }

    #[test]
    fn fronts_from_different_sides_are_not_two_arcs_that_touch() {
        // They meet between x1 and x2, with rays a right angle apart.
        let (x0, x1, x2) = (DVec2::new(0.5, 1.0), DVec2::X, DVec2::ZERO);
        let sources = [DVec2::new(6.0, -5.5), DVec2::new(-2.5, -3.0)];
        let time = |place: DVec2, side: usize| place.distance(sources[side]) + [0.0, 3.55][side];
        let [t1, t2] = [time(x1, 0), time(x2, 1)];
        let triangle = Triangle { t1, t2, l1: x0.distance(x1), l2: x0.distance(x2), c: 1.0 };
        let curvatures = [x1.distance(sources[0]), x2.distance(sources[1])].map(f64::recip);
        assert!(are_two_arcs([triangle.t1, triangle.t2], curvatures));
        let across = [(DVec2::new(0.0, -1.0), 1), (DVec2::new(1.0, -1.0), 0)].map(|(y, side)| {
            let curvature = 1.0 / y.distance(sources[side]);
            Across { time: time(y, side), curvature, sides: [y.distance(x1), y.distance(x2)] }
        });
        let bends = Bends { fronts: curvatures, surface: [0.0; 3], alone: false };
        assert_eq!(two_arcs(triangle, bends, across), None);
    }

    #[test]
    fn fronts_that_meet_behind_a_small_wall_are_not_two_arcs_that_touch() {
        // From both corners of a wall of 3 points; five points behind it they are almost one.
        let corners = [(DVec2::new(2.0, -6.0), 0.207), (DVec2::new(-2.0, -6.0), 0.0)];
        let front = |place: DVec2| {
            let [a, b] = corners.map(|(corner, time)| {
                let radius = place.distance(corner);
                [time + radius, 1.0 / radius]
            });
            if a[0] < b[0] { a } else { b }
        };
        let (x0, x1, x2) = (DVec2::ZERO, DVec2::new(1.0, -1.0), DVec2::NEG_Y);
        let [[t1, k1], [t2, k2]] = [x1, x2].map(front);
        assert!(are_two_arcs([t1, t2], [k1, k2]));
        let triangle = Triangle { t1, t2, l1: x0.distance(x1), l2: x0.distance(x2), c: 1.0 };
        let across = [DVec2::new(0.0, -2.0), DVec2::new(1.0, -2.0)].map(|y| {
            let [time, curvature] = front(y);
            Across { time, curvature, sides: [y.distance(x1), y.distance(x2)] }
        });
        let bends = Bends { fronts: [k1, k2], surface: [0.0; 3], alone: false };
        assert_eq!(two_arcs(triangle, bends, across), None);
    }

    #[test]
    fn a_ray_through_the_point_across_is_not_turned_by_rounding() {
        // Fronts as a map in single precision has them, and what they are: from x1 the ray runs along the
        // diagonal to y, at which it is at a corner's fan of radius 8^(1/2) + 2^(1/2).
        let single = [
            [39.715_626, 0.176_777_02],
            [39.051_247, 0.025_608_705],
            [38.301_414, 0.235_702_41],
            [39.078_537, 0.277_350_2f32],
        ];
        let double = [
            [39.715_626_981_345, 0.176_776_695_296_6],
            [39.051_248_371_924, 0.025_607_375_991_554],
            [38.301_413_418_972, 0.235_702_260_395_514],
            [39.078_537_569_690, 0.277_350_098_112_613],
        ];
        fn time<R: Real>([[t1, k1], [t2, k2], y, z]: [[R; 2]; 4]) -> f64 {
            let [one, diagonal] = [R::one(), R::of(2.0).sqrt()];
            let triangle = Triangle { t1, t2, l1: one, l2: diagonal, c: one };
            let across = [(y, [diagonal, one]), (z, [one, diagonal])]
                .map(|([time, curvature], sides)| Across { time, curvature, sides });
            let bends = Bends { fronts: [k1, k2], surface: [R::zero(); 3], alone: false };
            two_arcs(triangle, bends, across).unwrap().time.wide()
        }
        approx::assert_abs_diff_eq!(time(double), 40.459_856_632_857, epsilon = 1e-7);
        approx::assert_abs_diff_eq!(time(single), 40.459_856_632_857, epsilon = 2e-5);
    }

    #[test]
    fn nothing_is_said_where_points_are_missing() {
        let triangle = Triangle { t1: 1.0, t2: 1.2, l1: 1.0, l2: 1.0, c: 1.0f32 };
        let bends = Bends { fronts: [0.9, 0.2], surface: [0.0; 3], alone: false };
        let far = f32::FAR;
        let missing = Across { time: far, curvature: 0.0, sides: [far; 2] };
        assert_eq!(two_arcs(triangle, bends, [missing; 2]), None);
        let present = Across { time: 0.2, curvature: 0.25, sides: [1.0; 2] };
        let flat = Triangle { l1: 3.0, ..triangle };
        assert_eq!(two_arcs(flat, bends, [present; 2]), None);
    }
}

//! Implements fronts over a slowness that differs between the corners of a triangle. The twin of
//! `glsl/update/slowed.glsl`.
//!
//! The slowness is linear along each edge. An edge costs its length times the mean slowness of its ends.
//! A ray from a place y of the base to x0 costs |y x0| times the mean slowness of its ends. A front
//! arrives along the ray for which the sum of its time at y and that cost is least ([`Slope`]). The costs of the edges
//! do not give the shape of a triangle: an equilateral triangle between corners of slowness 1, 1 and 100 would seem
//! long and thin. The shape follows from the lengths on the surface: the costs divided by the mean slownesses.
//!
//! The sum is convex from one end of the base up to some place. Beyond that place, if it lies on the base, the sum is
//! concave. So the minimum is at an end, where an edge runs, or at the one place within the convex part to which
//! Newton's method converges. Any place gives an upper bound, and the error of the time is quadratic in that of the
//! place. So one step suffices where the corners' slownesses are nearly the same ([`is_uneven`]).

use super::curved::{Curvatures, bent};
use super::{Front, Shape, Triangle};
use crate::constants::{
    ABOUT_STRAIGHT, ALONG_BASE, CLEARLY_LATER, EVEN_CORNERS, FAN, FOCUS, FROM_SOURCE, GRAZING,
    STEEPEST, STEEPEST_GUESS, STRADDLING,
};
use crate::{DIFFRACTS, LACKING, Real, Seed, Tagged, jumps, max, min};

/// Returns 1 if the slowness jumps at one of three points, else 0.
#[inline(always)]
fn jump_of<R: Real>([a, b, c]: [R; 3]) -> R {
    if jumps(a) | jumps(b) | jumps(c) { R::one() } else { R::zero() }
}

impl<R: Real> Triangle<R> {
    /// Returns whether the triangle is obtuse at x0 on the surface, given the slowness at x0, x1 and x2.
    #[inline(always)]
    #[doc(hidden)]
    pub fn is_obtuse_on_surface(self, [s0, s1, s2]: [R; 3]) -> bool {
        let per_base_slowness = R::one() / (s1 + s2);
        let of_sides = [(s0 + s1) * per_base_slowness, (s0 + s2) * per_base_slowness];
        let shape = Shape::on_surface([self.l1, self.l2, self.c], of_sides);
        (self.c < R::FAR) & shape.is_obtuse()
    }
}

/// Returns whether the slownesses at the corners of a triangle differ so much that a single step does not find the place
/// where the ray crosses the base.
#[inline(always)]
#[doc(hidden)]
pub fn is_uneven<R: Real>([s0, s1, s2]: [R; 3]) -> bool {
    let range = max(max(s1, s2), s0) - min(min(s1, s2), s0);
    range > R::of(EVEN_CORNERS) * (s1 + s2)
}

/// The cost of rays from the base to x0, in units of the base's cost. Places on the base count from 0 at one end to 1 at
/// the other end. The ray from the place w costs sqrt((w - foot)^2 + height^2) (near + slope w).
struct Rays<R> {
    foot: R,
    height: R,
    /// Mean slowness along the ray from place 0, divided by the mean slowness along the base.
    near: R,
    /// The mean slowness along the ray from place 1, relative to that of the base, less `near`.
    slope: R,
    /// Whether the slowness is uneven ([`is_uneven`]).
    uneven: bool,
}

/// Returns the place of the base that is nearest to a place on its line.
#[inline(always)]
fn within<R: Real>(place: R) -> R {
    max(min(place, R::one()), R::zero())
}

impl<R: Real> Rays<R> {
    /// Returns the place that the law of refraction gives for a straight front, whose time along the base rises by `d`,
    /// and the slowness between the base and x0. It is exact where the slowness is constant.
    #[inline(always)]
    fn refracted(&self, d: R) -> R {
        let Self { foot, height, near, slope, uneven } = *self;
        let (one, across) = (R::one(), near + slope * within(foot));
        // Along a base across which the slowness rises, this law has no solution.
        let steepest = if uneven { R::of(STEEPEST_GUESS) } else { R::of(STEEPEST) };
        let cosine = max(min(-(d + slope * height) / across, steepest), -steepest);
        within(foot + height * cosine / ((one - cosine) * (one + cosine)).sqrt())
    }

    /// Returns the next place by a step of Newton's method for a straight front.
    ///
    /// The sum need not be convex. So its second derivative is taken as at least a quarter of the contribution of the
    /// ray. All terms are multiplied by a power of the distance from the place to x0, which saves divisions.
    #[inline(always)]
    fn step(&self, d: R, place: R) -> R {
        let Self { foot, height, near, slope, .. } = *self;
        let from_foot = place - foot;
        let squared_height = height * height;
        let squared = from_foot * from_foot + squared_height;
        let distance = squared.sqrt();
        let mean = near + slope * place;
        let falls = d * distance + mean * from_foot + slope * squared;
        let convex = squared_height * mean;
        let bends = convex + R::of(2.0) * slope * from_foot * squared;
        within(place - falls * squared / max(bends, R::of(0.25) * convex))
    }

    /// Returns the cost of the ray from a place.
    #[inline(always)]
    fn cost(&self, place: R) -> R {
        let Self { foot, height, near, slope, .. } = *self;
        let from_foot = place - foot;
        (from_foot * from_foot + height * height).sqrt() * (near + slope * place)
    }
}

/// The arrival time of a front along the base, in the same units: the time of a circular front of curvature
/// `kappa`, less a bulge. At the later end of the base, the derivative of the circle's time along the base is `-cos_a`.
struct Slope<R> {
    kappa: R,
    cos_a: R,
    sin_a: R,
    /// Part of the time's second derivative that a smoothly varying slowness adds to that of the circle.
    bulge: R,
}

impl<R: Real> Slope<R> {
    /// Returns the next place by a step of Newton's method on the base's line, beyond its ends too.
    #[inline(always)]
    fn step(&self, rays: &Rays<R>, place: R) -> R {
        let (zero, one, half) = (R::zero(), R::one(), R::of(0.5));
        let Self { kappa, cos_a, sin_a, bulge } = *self;
        let Rays { foot, height, near, slope, .. } = *rays;
        let squared = height * height;
        let n = (kappa * place - cos_a * R::of(2.0)) * place;
        let per_root = one / max(one + kappa * n, R::of(1e-4)).sqrt();
        let along = kappa * place - cos_a;
        let from_foot = place - foot;
        let per_distance = one / (from_foot * from_foot + squared).sqrt();
        let mean = near + slope * place;
        let cosine = from_foot * per_distance;
        let squared_distance = from_foot * from_foot + squared;
        let falls = along * per_root - bulge * (half - place)
            + mean * cosine
            + slope * (squared_distance * per_distance);
        // As in `Rays::step`, with the contribution of the front's circle.
        let spreads = max(kappa, zero) * (sin_a * sin_a) * (per_root * per_root * per_root);
        let convex = spreads + squared * mean * (per_distance * per_distance * per_distance);
        let bends = convex + R::of(2.0) * slope * cosine + bulge;
        place - falls / max(bends, R::of(0.25) * convex)
    }

    /// Returns the time from the front's arrival at the later end of the base until it arrives at x0 through a place.
    #[inline(always)]
    fn rise(&self, rays: &Rays<R>, place: R) -> R {
        let (one, half) = (R::one(), R::of(0.5));
        let Self { kappa, cos_a, bulge, .. } = *self;
        let n = (kappa * place - cos_a * R::of(2.0)) * place;
        let root = max(one + kappa * n, R::of(1e-4)).sqrt();
        n / (one + root) - half * bulge * (place * (one - place)) + rays.cost(place)
    }
}

/// Returns the curvature of a front after a length in which it spreads as on a plane. A front that would meet its focus
/// goes on as a straight one. Behind its focus it would be late, and it does not come first there. Where a slope of the
/// slowness begins or ends, the curvature of the front misses what the kink adds to it, and fronts that spread seem to
/// have a focus.
#[inline(always)]
fn spread_by<R: Real>(curvature: R, length: R) -> R {
    let goes_on = R::one() + curvature * length;
    if goes_on < R::of(FOCUS) { R::zero() } else { curvature / goes_on }
}

/// Returns the arrival time at x0 of a straight front that reaches x1 and x2 at t1 and t2, given the slowness
/// at x0, x1 and x2. A front through the triangle arrives no earlier than the later of both times, see
/// [`super::planar()`]; a front along an edge may arrive earlier.
#[inline(always)]
pub fn planar_slowed<R: Real>(triangle: Triangle<R>, slowness: [R; 3]) -> R {
    planar_slowed_at::<R, true, false>(triangle, slowness)
}

/// Returns the time of [`planar_slowed`]. `UNEVEN` is false only if the slowness is known not to be uneven
/// ([`is_uneven`]), which saves steps. With `FACE`, only the edges of an obtuse triangle count.
#[inline(always)]
#[doc(hidden)]
pub fn planar_slowed_at<R: Real, const UNEVEN: bool, const FACE: bool>(
    triangle: Triangle<R>,
    slowness: [R; 3],
) -> R {
    let Triangle { t1, t2, l1, l2, c } = triangle;
    let along_edge = triangle.edge_step();
    let [s0, s1, s2] = slowness;
    let (zero, one) = (R::zero(), R::one());
    let per_base_slowness = one / (s1 + s2);
    let (from_x1, from_x2) = ((s0 + s1) * per_base_slowness, (s0 + s2) * per_base_slowness);
    let shape = Shape::on_surface([l1, l2, c], [from_x1, from_x2]);
    let d = (t2 - t1) * shape.per_base;
    let height = max(shape.height_squared, zero).sqrt();
    let uneven = UNEVEN && is_uneven(slowness);
    let rays = Rays { foot: shape.foot, height, near: from_x1, slope: from_x2 - from_x1, uneven };
    let mut place = rays.step(d, rays.refracted(d));
    if UNEVEN {
        let further = rays.step(d, rays.step(d, place));
        place = if uneven { further } else { place };
    }
    let whole = if FACE { shape.whole & !shape.is_obtuse() } else { shape.whole };
    let inside = whole & (place > zero) & (place < one);
    let time = max(t1 + c * (d * place + rays.cost(place)), max(t1, t2));
    min(along_edge, if inside { time } else { along_edge })
}

/// Returns the front at x0 from fronts at x1 and x2, given the slowness at x0, x1 and x2. It equals the front of
/// [`super::curved()`] where the slowness is constant.
///
/// Curvatures are measured in the surface's metric scaled by the slowness, in which lengths are travel times. Where the
/// slowness jumps, these curvatures are of no use. The quantity that is continuous across a jump is the second
/// derivative of the time along the front's tangent: curvature times slowness squared. Points have a tag where the
/// slowness jumps ([`jumps`]).
#[inline(always)]
pub fn curved_slowed<R: Real>(
    triangle: Triangle<R>,
    curvatures: Curvatures<R>,
    slowness: [R; 3],
) -> Front<R> {
    curved_slowed_at::<R, true, false>(triangle, curvatures, slowness)
}

/// Returns the front of [`curved_slowed`]. `UNEVEN` is false only if the slowness is known neither to jump nor to be
/// uneven ([`is_uneven`]). With `FACE`, only the edges of an obtuse triangle count.
#[inline(always)]
#[doc(hidden)]
pub fn curved_slowed_at<R: Real, const UNEVEN: bool, const FACE: bool>(
    triangle: Triangle<R>,
    curvatures: Curvatures<R>,
    slowness: [R; 3],
) -> Front<R> {
    let Triangle { t1, t2, l1, l2, c } = triangle;
    let Curvatures { fronts: [k1, k2], surface: [g0, g1, g2], alone, causal } = curvatures;
    let [s0, s1, s2] = slowness;
    let (zero, one, half, focus) = (R::zero(), R::one(), R::of(0.5), R::of(FOCUS));
    let at_source = R::of(Seed::AT_SOURCE);

    let swap = t1 < t2;
    let (t, near_t) = if swap { (t2, t1) } else { (t1, t2) };
    let (k, near_k) = if swap { (k2, k1) } else { (k1, k2) };
    let (g, near_g) = if swap { (g2, g1) } else { (g1, g2) };
    let (l, near_l) = if swap { (l2, l1) } else { (l1, l2) };
    let (s, near_s) = if swap { (s2, s1) } else { (s1, s2) };
    let jump = if UNEVEN { jump_of(slowness) } else { zero };
    let uneven = UNEVEN && is_uneven(slowness);
    let per_base_slowness = one / (s + near_s);
    // These are relative to the base's slowness, which is the mean of the slownesses at its two ends.
    let (own, far, near) = (
        (s0 + s0) * per_base_slowness,
        (s + s) * per_base_slowness,
        (near_s + near_s) * per_base_slowness,
    );
    let (from_far, from_near) = (half * (own + far), half * (own + near));
    let shape = Shape::on_surface([l, near_l, c], [from_far, from_near]);
    let p = shape.foot;
    let whole = if FACE { shape.whole & !shape.is_obtuse() } else { shape.whole };
    let h = max(shape.height_squared, zero).sqrt();
    let d = (near_t - t) * shape.per_base;
    // The factor by which a curvature changes across a jump of the slowness; it is 1 where the slowness does not jump.
    let passes = |from: R, to: R| one + jump * (from * from / (to * to) - one);
    let beside =
        (near_k >= at_source) & ((k * c).abs() < R::of(ABOUT_STRAIGHT)) & (d > R::of(-FROM_SOURCE));
    let own_kappa = k * c * passes(far, one);
    let near_kappa = if beside { own_kappa } else { near_k * c * passes(near, one) };
    let passed = near_kappa / max(one - near_kappa * d, focus);
    let far_kappa = if k < at_source { own_kappa } else { passed };
    let kappa = half * (passed + far_kappa);
    let cos_a = half * kappa * ((one - d) * (one + d)) - d;
    let sin_a = max((one - cos_a) * (one + cos_a), zero).sqrt();
    let width = sin_a + kappa * h;
    let of_one = (d > R::of(-ALONG_BASE)) & (kappa * (one - d) <= R::of(STRADDLING));
    let is_front = whole & of_one & (width > zero);
    // The time along the base bends with the change of the slowness along the base and across it.
    let along = max(min(d, one), -one);
    let across = max((one - along) * (one + along), zero).sqrt();
    let rises = (own - (far + p * (near - far))) / h;
    let bulge = (one - jump) * (along * (near - far) - across * rises);
    let rays = Rays { foot: p, height: h, near: from_far, slope: from_near - from_far, uneven };
    let front = Slope { kappa, cos_a, sin_a, bulge };
    // The guess is for a constant slowness. Where the slowness jumps, the iteration starts instead at the place that the
    // law of refraction gives for a straight front.
    let guess = within((cos_a * h + sin_a * p) / max(width, R::of(1e-6)));
    let guess = if UNEVEN { guess + (rays.refracted(d) - guess) * jump } else { guess };
    let mut beyond = front.step(&rays, guess);
    if UNEVEN {
        let further = front.step(&rays, within(front.step(&rays, within(beyond))));
        beyond = if uneven { further } else { beyond };
    }
    let place = within(beyond);
    let rise = front.rise(&rays, place);
    let (by_far, by_near) = (t + l, near_t + near_l);
    let later = t + t * (R::of(CLEARLY_LATER) * R::epsilon());
    let time = t + c * max(rise, if shape.is_upright() & !causal { d } else { zero });
    let is_first = (time <= min(by_far, by_near)) & (!causal | (time >= later));
    let inside = is_front & (place > zero) & (place < one) & is_first;

    // The front that arrives along an edge, taken from the edge that brings it first.
    let grazing = R::of(GRAZING);
    let is_from_far = by_far <= by_near;
    let (edge_time, edge) = if is_from_far { (by_far, l) } else { (by_near, near_l) };
    let (edge_k, edge_g) = if is_from_far { (k, g) } else { (near_k, near_g) };
    let edge_s = if is_from_far { far } else { near };
    let is_known = !causal | (later < by_near);
    let past_near = (beyond <= one + grazing) & is_known;
    let ahead = if is_from_far { beyond >= -grazing } else { past_near };
    let turns = (whole | alone) & !(is_front & ahead);
    let is_corner = edge_g.tag_has(DIFFRACTS, DIFFRACTS);
    let diffracted =
        turns & edge_g.tag_has(LACKING, LACKING) & (is_from_far | is_known | is_corner);

    // The fan of rays that a border turns, as in `curved`, from the shape of the front without the bulge.
    let sight = cos_a * h + sin_a * p;
    let past = if is_from_far { -sight } else { sight - width };
    let fan = past * R::of(FAN) * shape.per_base;
    let along_border = edge_g.tag_has(LACKING | DIFFRACTS, LACKING) & g0.tag_has(LACKING, LACKING);
    let opens = is_front & along_border & (past > zero) & (is_from_far | is_known);
    let is_narrow = opens & (fan * edge < h);
    let goes_on = max(one + edge_k * edge, focus);
    let in_fan = is_narrow & (fan * goes_on > edge_k.abs() * h);
    let edge_k = if (diffracted | opens) & !is_narrow { at_source } else { edge_k };

    // Where the slowness jumps, a front spreads as it would at a constant slowness, the harmonic mean of the slownesses
    // at both ends of the ray.
    let from = far + place * (near - far);
    let spreads = one + jump * (one / (from * own) - one);
    let spread = max(rise, zero) * spreads;
    let far_end = spread_by(far_kappa, spread);
    let near_end = spread_by(near_kappa, spread - d * spreads);
    let through = (far_end + place * (near_end - far_end)) * shape.per_base * passes(one, own);
    let edge_spread = edge * (one + jump * (edge_s / own - one));
    let by_edge = if in_fan { fan / h } else { spread_by(edge_k, edge_spread) };
    let by_edge = by_edge * passes(edge_s, own);
    let from_foot = place - p;
    let length = (from_foot * from_foot + h * h).sqrt();
    let ray = if inside { c * length * (from_far + place * (from_near - from_far)) } else { edge };
    let gaussian = if inside { g + place * (near_g - g) } else { edge_g };
    // The Gaussian curvature on one side of a jump does not apply on the other side.
    let gaussian = (half * (g0 + gaussian)) * (one - jump);
    let curvature = bent(if inside { through } else { by_edge }, gaussian, ray);
    Front { time: if inside { time } else { edge_time }, curvature, whole }
}

/// Returns whether a bound shows that every front through a triangle comes later than `now`, given the curvatures at x1
/// and x2. `UNEVEN` is false only if the slowness is known not to jump.
///
/// The bound is that of `cpu/lines/settled.rs`. A ray from a place x of the base is at least as long as its projection
/// u . (x0 - x) on the direction u from x1 to x0. The projection and the slowness are linear along the base. So their
/// product, which bounds the cost of the ray, falls below the linear function between its values at both ends by at
/// most a quarter of the product of both changes.
#[inline(always)]
pub fn is_settled<R: Real, const UNEVEN: bool>(
    triangle: Triangle<R>,
    [k1, k2]: [R; 2],
    slowness: [R; 3],
    now: R,
) -> bool {
    let Triangle { t1, t2, l1, l2, c } = triangle;
    let [s0, s1, s2] = slowness;
    let (zero, one) = (R::zero(), R::one());
    let per_base_slowness = one / (s1 + s2);
    let (from_x1, from_x2) = ((s0 + s1) * per_base_slowness, (s0 + s2) * per_base_slowness);
    let shape = Shape::on_surface([l1, l2, c], [from_x1, from_x2]);
    let Shape { side, other, foot, .. } = shape;
    let projection = min(side - foot / side, other);
    let dip = c * (R::of(0.25) * max((projection - side) * (from_x2 - from_x1), zero));
    // Bound of the rounding of all these terms.
    let slack = R::of(16.0) * R::epsilon() * now;
    let lead = min(t1 + l1, t2 + c * (projection * from_x2)) - dip - now;
    let jump = if UNEVEN { jump_of(slowness) } else { zero };
    // Slownesses relative to the mean of the base's ends.
    let passes = |s: R| {
        let relative = (s + s) * per_base_slowness;
        one + jump * (relative * relative - one)
    };
    let kappa = max(max(k1 * passes(s1), k2 * passes(s2)), zero) * c;
    let height = max(shape.height_squared, zero).sqrt();
    let (along, across) = ((s2 - s1).abs(), (s0 - s1).abs());
    let rises = across + along * (one + foot.abs());
    let bulge =
        (one - jump) * ((along + rises / height) * (per_base_slowness + per_base_slowness)) * c;
    let room = R::of(8.0) * max(one - kappa, zero);
    (lead - slack) * room > c * kappa + R::of(0.125) * bulge * room
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns the least sum over the base of the time and the cost of the ray to x0, by brute force, and no earlier
    /// than the later end of the base, unless along an edge.
    fn least(triangle: Triangle<f64>, [s0, s1, s2]: [f64; 3], [p, h, c]: [f64; 3]) -> f64 {
        let Triangle { t1, t2, l1, l2, .. } = triangle;
        let through =
            |w: f64| t1 + w * (t2 - t1) + (w * c - p).hypot(h) * 0.5 * (s0 + s1 + w * (s2 - s1));
        let places = (0..=20_000).map(|k| through(f64::from(k) / 20_000.0));
        places.fold(f64::INFINITY, f64::min).max(t1.max(t2)).min((t1 + l1).min(t2 + l2))
    }

    /// Returns numbers in 0..1 that look random.
    fn numbers() -> impl FnMut() -> f64 {
        let mut state = 1u64;
        move || {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            (state >> 33) as f64 / f64::from(1u32 << 31)
        }
    }

    /// Calls `check` with triangles of many shapes, slownesses up to a contrast, and their exact times.
    fn every_triangle(contrast: f64, mut check: impl FnMut(Triangle<f64>, [f64; 3], f64)) {
        let mut next = numbers();
        for k in 0..2000 {
            let c = 0.5 + next();
            let [p, h] = match k % 4 {
                0 => [0.0, 1.0],
                1 => [c, 1.0],
                2 => [c * next(), 0.3 + next()],
                _ => [c * (2.0 * next() - 0.5), 0.15 + next()],
            };
            let s = [next(), next(), next()].map(|power| contrast.powf(power));
            let [s0, s1, s2] = s;
            let (l1, l2) = (p.hypot(h), (c - p).hypot(h));
            let base = 0.5 * c * (s1 + s2);
            let triangle = Triangle {
                t1: 10.0,
                t2: 10.0 + base * (2.0 * next() - 1.0),
                l1: 0.5 * l1 * (s0 + s1),
                l2: 0.5 * l2 * (s0 + s2),
                c: base,
            };
            check(triangle, s, least(triangle, s, [p, h, c]));
        }
    }

    #[test]
    fn straight_fronts_arrive_at_the_least_sum() {
        for (contrast, mean, largest) in [
            (1.0, 1e-9, 1e-8),
            (1.01, 1e-7, 1e-5),
            (1.1, 1e-6, 1e-4),
            (10.0, 1e-3, 0.3),
            (1000.0, 1.0, 1.0),
        ] {
            let mut errors = Vec::new();
            every_triangle(contrast, |triangle, s, exact| {
                let error = planar_slowed(triangle, s) - exact;
                let step = triangle.l1.min(triangle.l2);
                errors.push(error / step);
            });
            errors.sort_by(f64::total_cmp);
            let of = errors.iter().map(|e| e.abs()).sum::<f64>() / errors.len() as f64;
            println!(
                "{contrast}: mean {of:.1e}, 90% {:.1e} 99% {:.1e} largest {:.1e}, least {:.1e}",
                errors[1800], errors[1980], errors[1999], errors[0]
            );
            assert!(of <= mean && errors[1999] <= largest);
        }
    }
}

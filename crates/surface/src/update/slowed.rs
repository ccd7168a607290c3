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
//! place.

use super::curved::{Curvatures, bent};
use super::{Front, Shape, Triangle};
use crate::constants::{
    ABOUT_STRAIGHT, ALONG_BASE, CLEARLY_LATER, CROSSING_STEPS, FAN, FOCUS, FROM_SOURCE, GRAZING,
    STEEPEST_GUESS, STRADDLING,
};
use crate::{DIFFRACTS, LACKING, Real, Seed, Tagged, jumps, max, min};

/// Returns 1 if the slowness jumps at one of three points, else 0.
#[inline(always)]
fn jump_of<R: Real>([a, b, c]: [R; 3]) -> R {
    if jumps(a) | jumps(b) | jumps(c) { R::one() } else { R::zero() }
}

impl<R: Real> Triangle<R> {
    /// Returns this triangle, or only its edges if it is obtuse at x0 on the surface, given the slowness at x0,
    /// x1 and x2.
    #[inline(always)]
    #[doc(hidden)]
    pub fn without_obtuse_face_on_surface(self, slowness: [R; 3]) -> Self {
        let is_obtuse = self.is_obtuse_on_surface(slowness);
        Self { c: if is_obtuse { R::FAR } else { self.c }, ..self }
    }

    /// Returns whether the triangle is obtuse at x0 on the surface.
    #[inline(always)]
    #[doc(hidden)]
    pub fn is_obtuse_on_surface(self, [s0, s1, s2]: [R; 3]) -> bool {
        let per_base = (s1 + s2) / self.c;
        let side = self.l1 / (s0 + s1) * per_base;
        let other = self.l2 / (s0 + s2) * per_base;
        (self.c < R::FAR) & crate::is_obtuse(side * side, other * other)
    }
}

/// The cost of rays from the base to x0, in units of the base's cost. Places on the base count from 0 at the end that
/// the front reaches later to 1 at the other end. The ray from the place w costs sqrt((w - foot)^2 + height^2) (near +
/// slope w).
pub struct Rays<R> {
    foot: R,
    height: R,
    /// Mean slowness along the ray from place 0, divided by the mean slowness along the base.
    near: R,
    /// The mean slowness along the ray from place 1, relative to that of the base, less `near`.
    slope: R,
    jump: R,
}

/// The arrival time of a front along the base, in the same units: the time of a circular front of curvature `kappa`,
/// less a bulge. At the later end of the base, the derivative of the circle's time along the base is `-cos_a`.
struct Slope<R> {
    /// Time at the other end less the time at the end reached later: never positive.
    d: R,
    kappa: R,
    cos_a: R,
    sin_a: R,
    /// Part of the time's second derivative that a smoothly varying slowness adds to that of the circle.
    bulge: R,
}

/// Point where a ray crosses the base.
struct Crossing<R> {
    place: R,
    /// Time from the front's arrival at the later end of the base until it arrives at x0 through that place, in units
    /// of the base's cost.
    rise: R,
    /// Approximate position on the base, extended beyond its ends.
    beyond: R,
}

impl<R: Real> Slope<R> {
    #[inline(always)]
    fn crossing(&self, rays: &Rays<R>, guess: R) -> Crossing<R> {
        let (zero, one, half) = (R::zero(), R::one(), R::of(0.5));
        let Self { d, kappa, cos_a, sin_a, bulge } = *self;
        let Rays { foot, height, near, slope, jump } = *rays;
        let within = |place: R| max(min(place, one), zero);
        // The guess is for a constant slowness. Where the slowness jumps, the iteration starts instead at the place
        // that the law of refraction gives for the slowness between the base and x0.
        let across = near + slope * within(foot);
        let steepest = R::of(STEEPEST_GUESS);
        let cosine = max(min(-(d + slope * height) / across, steepest), -steepest);
        let refracted = foot + height * cosine / ((one - cosine) * (one + cosine)).sqrt();
        let mut place = within(guess);
        place = place + (within(refracted) - place) * jump;
        let squared = height * height;
        let mut first = Crossing { place, rise: R::FAR, beyond: place };
        for _ in 0..=CROSSING_STEPS {
            let n = (kappa * place - cos_a * R::of(2.0)) * place;
            let root = max(one + kappa * n, R::of(1e-4)).sqrt();
            let along = kappa * place - cos_a;
            let from_foot = place - foot;
            let distance = (from_foot * from_foot + squared).sqrt();
            let mean = near + slope * place;
            let rise = n / (one + root) - half * bulge * (place * (one - place)) + distance * mean;
            let is_first = rise < first.rise;
            first.place = if is_first { place } else { first.place };
            first.rise = min(rise, first.rise);
            let (per_root, per_distance) = (one / root, one / distance);
            let cosine = from_foot * per_distance;
            let falls =
                along * per_root - bulge * (half - place) + mean * cosine + slope * distance;
            // The sum need not be convex. So its second derivative is taken as at least a quarter of the contributions
            // of the front's circle and the ray.
            let spreads = max(kappa, zero) * (sin_a * sin_a) * (per_root * per_root * per_root);
            let convex = spreads + squared * mean * (per_distance * per_distance * per_distance);
            let bends = convex + R::of(2.0) * slope * cosine + bulge;
            first.beyond = place - falls / max(bends, R::of(0.25) * convex);
            place = within(first.beyond);
        }
        first
    }
}

/// Returns the arrival time at x0 of a straight front that reaches x1 and x2 at t1 and t2, given the slowness
/// at x0, x1 and x2. A front through the triangle arrives no earlier than the later of both times, see
/// [`super::planar()`]; a front along an edge may arrive earlier.
#[inline(always)]
pub fn planar_slowed<R: Real>(triangle: Triangle<R>, slowness: [R; 3]) -> R {
    let Triangle { t1, t2, l1, l2, c } = triangle;
    let along_edge = triangle.edge_step();
    let [s0, s1, s2] = slowness;
    let (zero, one) = (R::zero(), R::one());
    let swap = t1 < t2;
    let (t, near_t) = if swap { (t2, t1) } else { (t1, t2) };
    let (l, near_l) = if swap { (l2, l1) } else { (l1, l2) };
    let (s, near_s) = if swap { (s2, s1) } else { (s1, s2) };
    let per_base_slowness = one / (s + near_s);
    let (from_far, from_near) = ((s0 + s) * per_base_slowness, (s0 + near_s) * per_base_slowness);
    let shape = Shape::on_surface([l, near_l, c], [from_far, from_near]);
    let d = (near_t - t) * shape.per_base;
    let height = max(shape.height_squared, zero).sqrt();
    let rays =
        Rays { foot: shape.foot, height, near: from_far, slope: from_near - from_far, jump: one };
    let slope = Slope { d, kappa: zero, cos_a: -d, sin_a: zero, bulge: zero };
    let crossing = slope.crossing(&rays, zero);
    let inside = shape.whole & (crossing.place > zero) & (crossing.place < one);
    let time = t + c * max(crossing.rise, zero);
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
    let jump = jump_of(slowness);
    let per_base_slowness = one / (s + near_s);
    // These are relative to the base's slowness, which is the mean of the slownesses at its two ends.
    let [own, far, near] =
        [s0, s, near_s].map(|slowness| (slowness + slowness) * per_base_slowness);
    let (from_far, from_near) = (half * (own + far), half * (own + near));
    let shape = Shape::on_surface([l, near_l, c], [from_far, from_near]);
    let (p, whole) = (shape.foot, shape.whole);
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
    let rays = Rays { foot: p, height: h, near: from_far, slope: from_near - from_far, jump };
    let crossing = Slope { d, kappa, cos_a, sin_a, bulge }
        .crossing(&rays, (cos_a * h + sin_a * p) / max(width, R::of(1e-6)));
    let Crossing { place, rise, beyond } = crossing;
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
    let far_end = far_kappa / max(one + far_kappa * spread, focus);
    let near_end = near_kappa / max(one + near_kappa * (spread - d * spreads), focus);
    let through = (far_end + place * (near_end - far_end)) * shape.per_base * passes(one, own);
    let edge_spread = edge * (one + jump * (edge_s / own - one));
    let (by_edge, per_edge) =
        if in_fan { (fan, h) } else { (edge_k, max(one + edge_k * edge_spread, focus)) };
    let by_edge = by_edge / per_edge * passes(edge_s, own);
    let from_foot = place - p;
    let length = (from_foot * from_foot + h * h).sqrt();
    let ray = if inside { c * length * (from_far + place * (from_near - from_far)) } else { edge };
    let gaussian = if inside { g + place * (near_g - g) } else { edge_g };
    // The Gaussian curvature on one side of a jump does not apply on the other side.
    let gaussian = (half * (g0 + gaussian)) * (one - jump);
    let curvature = bent(if inside { through } else { by_edge }, gaussian, ray);
    Front { time: if inside { time } else { edge_time }, curvature, whole }
}

/// Returns whether a bound shows that every front through a triangle comes at `now` or later, or, for curved fronts,
/// later than `now`. `curvatures` are those at x1 and x2, or `None` for straight fronts.
///
/// The bound is that of `cpu/lines/settled.rs`. A ray from a place x of the base is at least as long as its projection
/// u . (x0 - x) on the direction u from x1 to x0. The projection and the slowness are linear along the base. So their
/// product, which bounds the cost of the ray, falls below the linear function between its values at both ends by at
/// most a quarter of the product of both changes.
#[inline(always)]
pub fn is_settled<R: Real>(
    triangle: Triangle<R>,
    curvatures: Option<[R; 2]>,
    slowness: [R; 3],
    now: R,
) -> bool {
    let Triangle { t1, t2, l1, l2, c } = triangle;
    let [s0, s1, s2] = slowness;
    let (zero, one, half) = (R::zero(), R::one(), R::of(0.5));
    let [mean1, mean2, mean] = [half * (s0 + s1), half * (s0 + s2), half * (s1 + s2)];
    let [long1, long2, base] = [l1 / mean1, l2 / mean2, c / mean];
    let foot = half * (long1 * long1 - long2 * long2 + base * base) / base;
    let projection = min(long1 - foot * base / long1, long2);
    let dip = R::of(0.25) * max((projection - long1) * (mean2 - mean1), zero);
    // Bound of the rounding of all these terms.
    let slack = R::of(16.0) * R::epsilon() * now;
    let lead = min(t1 + l1, t2 + projection * mean2) - dip - now;
    let Some([k1, k2]) = curvatures else { return lead >= slack };
    let jump = jump_of(slowness);
    let passes = |from: R| one + jump * (from * from / (mean * mean) - one);
    let kappa = max(max(k1 * passes(s1), k2 * passes(s2)), zero) * c;
    let height = ((long1 - foot) * (long1 + foot)).sqrt();
    let rises = (s0 - s1).abs() + (s2 - s1).abs() * (one + foot.abs() / base);
    let bulge = (one - jump) * ((s2 - s1).abs() + rises * base / height) * c / mean;
    let room = R::of(8.0) * max(one - kappa, zero);
    (lead - slack) * room > c * kappa + R::of(0.125) * bulge * room
}

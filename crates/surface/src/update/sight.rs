//! Implements the curved update where fronts of several origins meet.
//!
//! Time and curvature do not tell to which source a front belongs. Two fronts that arrive together from neighbouring
//! sources look like one circle around a point between them, and that circle arrives too early. Therefore fronts of
//! maps with several sources carry the number of their origin ([`Origin`]) in place of the curvature, as long as the
//! straight line from there explains their time. A triangle whose ends have the same origin has one front, whose
//! curvature follows from the distance to that origin. If the ends have different origins, the front of each end
//! continues separately: its time grows with the distance from its origin, if the ray to x0 crosses the base.
//!
//! Distances from origins are computed in double precision, also for maps in single precision. They span many
//! cells, and in long or sheared cells their squares are small differences of large numbers.

use super::Triangle;
use super::curved::{Curvatures, Front, curved};
use crate::constants::{BENDS_MOST, CLEARLY_LATER, IN_SIGHT, ON_LINE, PAST_EDGE, UNBLOCKED};
use crate::{Origin, Real, Seed, max, min};

/// An origin as seen from a point, in rows and columns.
#[derive(Clone, Copy, Debug)]
pub struct Sighted<R> {
    /// Step from the point to one end of the source.
    pub to: [R; 2],
    /// Step from that end to the other.
    pub extent: [R; 2],
    /// Time at which fronts leave the origin; [`Real::FAR`] if the front's origin is not known.
    pub start: R,
}

impl<R: Real> Sighted<R> {
    /// Returns the value for a front whose origin is not known.
    #[doc(hidden)]
    pub fn unknown() -> Self {
        Self { to: [R::zero(); 2], extent: [R::zero(); 2], start: R::FAR }
    }

    /// Returns an origin as seen from the border's first point. `first` is the place of the chart's first
    /// point in a bordered array.
    #[doc(hidden)]
    pub fn of(origin: &Origin, first: [f64; 2]) -> Self {
        let [a, b] = origin.ends;
        let to = [a.x + first[0], a.y + first[1]].map(R::of);
        Self { to, extent: (b - a).to_array().map(R::of), start: R::of(origin.start) }
    }

    /// Returns this origin as seen from a point at the given place.
    #[inline(always)]
    #[doc(hidden)]
    pub fn from(self, [row, col]: [R; 2]) -> Self {
        Self { to: [self.to[0] - row, self.to[1] - col], ..self }
    }

    #[inline(always)]
    fn is_known(&self) -> bool {
        self.start < R::FAR
    }

    #[inline(always)]
    fn is(&self, other: &Self) -> bool {
        let same = |a: [R; 2], b: [R; 2]| (a[0] == b[0]) & (a[1] == b[1]);
        same(self.to, other.to) & same(self.extent, other.extent) & (self.start == other.start)
    }
}

/// The steps from x0 to x1 and x2, in rows and columns.
#[derive(Clone, Copy, Debug)]
pub struct Steps {
    first: [f64; 2],
    second: [f64; 2],
    /// 1 over the area that both steps span.
    per_area: f64,
}

impl Steps {
    #[doc(hidden)]
    pub fn new([first, second]: [[isize; 2]; 2]) -> Self {
        let [first, second] = [first, second].map(|step| step.map(|by| by as f64));
        let per_area = (first[0] * second[1] - first[1] * second[0]).recip();
        Self { first, second, per_area }
    }

    /// Decomposes a step into shares of both steps.
    #[inline(always)]
    fn shares(&self, step: [f64; 2]) -> [f64; 2] {
        let Self { first, second, per_area } = *self;
        [
            (step[0] * second[1] - step[1] * second[0]) * per_area,
            (first[0] * step[1] - first[1] * step[0]) * per_area,
        ]
    }
}

/// The scalar products of the steps x0 x1 and x0 x2 in the plane of a triangle: of the first with itself, of
/// both, and of the second with itself. Other steps are given as shares of these two.
#[derive(Clone, Copy)]
struct Plane([f64; 3]);

impl Plane {
    #[inline(always)]
    fn of([l1, l2, c]: [f64; 3]) -> Self {
        let (first, second) = (l1 * l1, l2 * l2);
        Self([first, 0.5 * (first + second - c * c), second])
    }

    #[inline(always)]
    fn dot(self, a: [f64; 2], b: [f64; 2]) -> f64 {
        let [first, both, second] = self.0;
        a[0] * (first * b[0] + both * b[1]) + a[1] * (both * b[0] + second * b[1])
    }
}

/// A straight source in the plane of a triangle.
#[derive(Clone, Copy)]
struct Source {
    plane: Plane,
    to: [f64; 2],
    extent: [f64; 2],
    per_square: f64,
}

/// Ray to a point from the closest point of a source.
#[derive(Clone, Copy)]
struct Ray {
    /// Vector along the ray, from the source to its target.
    step: [f64; 2],
    length: f64,
    /// Whether the ray starts between the source's ends, at a right angle to the source.
    is_beside: bool,
}

impl Source {
    #[inline(always)]
    fn new<R: Real>(plane: Plane, steps: &Steps, sighted: &Sighted<R>) -> Self {
        let extent = steps.shares(sighted.extent.map(R::wide));
        let square = plane.dot(extent, extent);
        let per_square = if square > 0.0 { 1.0 / square } else { 0.0 };
        Self { plane, to: steps.shares(sighted.to.map(R::wide)), extent, per_square }
    }

    #[inline(always)]
    fn ray_to(&self, place: [f64; 2]) -> Ray {
        let Self { plane, to, extent, per_square } = *self;
        let from_end = [place[0] - to[0], place[1] - to[1]];
        let along = plane.dot(from_end, extent) * per_square;
        let foot = min(max(along, 0.0), 1.0);
        let step = [from_end[0] - foot * extent[0], from_end[1] - foot * extent[1]];
        let length = max(plane.dot(step, step), 0.0).sqrt();
        Ray { step, length, is_beside: (foot > 0.0) & (foot < 1.0) }
    }
}

/// The corners x1 and x2 in the plane of a triangle.
const CORNERS: [[f64; 2]; 2] = [[1.0, 0.0], [0.0, 1.0]];

/// The inputs of an update for the front at one end of a base.
#[derive(Clone, Copy)]
struct End<R> {
    time: R,
    carried: R,
    /// Gaussian curvature of the surface.
    gaussian: R,
}

/// The front at one end of a base as seen from its origin.
#[derive(Clone, Copy)]
struct FromOrigin {
    is_known: bool,
    /// Whether the straight line explains the front's time, and whether it does so nearly up to rounding.
    is_in_sight: bool,
    is_on_line: bool,
    /// Delay of the front relative to the line.
    late: f64,
    /// Curvature of the front, from its distance.
    curvature: f64,
    /// The ray to x0, and whether it crosses the base.
    ray: Ray,
    crosses: bool,
    /// The share of the base that lies before the crossing.
    crossing: f64,
    /// Time at which the same front arrives at the other end.
    other: f64,
    start: f64,
    /// Length of the base.
    base: f64,
}

impl FromOrigin {
    #[inline(always)]
    fn new<R: Real>(
        plane: Plane,
        base: f64,
        steps: &Steps,
        sighted: &Sighted<R>,
        end: End<R>,
        [here, there]: [[f64; 2]; 2],
    ) -> Self {
        let is_known = sighted.is_known();
        let start = if is_known { sighted.start.wide() } else { 0.0 };
        let source = Source::new(plane, steps, sighted);
        let [ray, to_end, to_other] = [[0.0; 2], here, there].map(|place| source.ray_to(place));
        let time = end.time.wide();
        let rounding = ROUNDING * R::epsilon().wide() * time.abs();
        let late = time - start - to_end.length;
        let within = |part: f64| late.abs() <= part * (to_end.length + base) + rounding;
        let of_source = curvature(time - start, to_end.is_beside, end.gaussian.wide());
        // The ray comes from within the angle between both edges.
        let [along_first, along_second] = [-ray.step[0], -ray.step[1]];
        let all = along_first + along_second;
        let least = -PAST_EDGE * all.abs();
        Self {
            is_known,
            is_in_sight: is_known & within(IN_SIGHT),
            is_on_line: within(ON_LINE),
            late,
            curvature: if is_known { of_source } else { end.carried.wide() },
            ray,
            crosses: (all > 0.0) & (along_first >= least) & (along_second >= least),
            crossing: min(max(along_second / all, 0.0), 1.0),
            other: start + late + to_other.length,
            start,
            base,
        }
    }

    /// Returns the time at which the front arrives at x0 along the line, with a delay of `late`.
    #[inline(always)]
    fn arrival(&self, late: f64) -> f64 {
        self.start + (self.ray.length + late)
    }

    /// Returns the value that the front carries at x0. It is the number of the origin as long as the line
    /// explains the front's time, and the surface is flat enough for the curvature to follow from the
    /// distance. Otherwise it is the curvature.
    #[inline(always)]
    fn carried<R: Real>(&self, time: R, number: R, gaussian: R) -> R {
        let (away, gaussian) = (time.wide() - self.start, gaussian.wide());
        let near = IN_SIGHT * (self.ray.length + self.base);
        let is_straight = (away - self.ray.length).abs() <= near;
        let is_flat = (gaussian * away * away).abs() <= BENDS_MOST;
        let bent = R::of(curvature(away, self.ray.is_beside, gaussian));
        if is_straight & is_flat { number } else { bent }
    }
}

/// Largest deviation of a front from its line due to rounding, in units in the last place of the time.
const ROUNDING: f64 = 16.0;

/// Returns the curvature of a front at some distance from a point or a straight line, on a surface of this
/// Gaussian curvature: from the Riccati equation k' = -k^2 - K.
#[inline(always)]
fn curvature(away: f64, is_beside: bool, gaussian: f64) -> f64 {
    let bend = gaussian * away;
    let round = min(1.0 / away, Seed::AT_SOURCE) - bend * (1.0 / 3.0);
    let round = if away > 0.0 { round } else { Seed::AT_SOURCE };
    if is_beside { -bend } else { round }
}

/// Returns the front at x0 from fronts at x1 and x2 that may have different origins. `curvatures.fronts`
/// holds the values that points carry: curvatures or numbers of origins, which `sighted` describes. If the
/// triangle is obtuse, only fronts on a straight line from their origin come through its face.
#[inline(always)]
pub fn curved_from_origins<R: Real>(
    triangle: Triangle<R>,
    curvatures: Curvatures<R>,
    steps: &Steps,
    sighted: [Sighted<R>; 2],
) -> Front<R> {
    let Triangle { t1, t2, l1, l2, c } = triangle;
    let Curvatures { fronts, surface: [g0, g1, g2], causal, .. } = curvatures;
    let exists = max(max(l1, l2), c) < R::FAR;
    let lengths = [l1, l2, c].map(|length| if exists { length.wide() } else { 1.0 });
    let (plane, base) = (Plane::of(lengths), lengths[2]);
    let ends = [
        End { time: t1, carried: fronts[0], gaussian: g1 },
        End { time: t2, carried: fronts[1], gaussian: g2 },
    ];
    let [x1, x2] = CORNERS;
    let first = FromOrigin::new(plane, base, steps, &sighted[0], ends[0], [x1, x2]);
    let second = FromOrigin::new(plane, base, steps, &sighted[1], ends[1], [x2, x1]);
    let same = first.is_known & second.is_known & sighted[0].is(&sighted[1]);
    let of_one = same & first.is_in_sight & second.is_in_sight & exists;
    // On a straight line the shape of the front is not needed.
    let exact = of_one & first.is_on_line & second.is_on_line;
    let obtuse = triangle.is_obtuse();
    let apart = first.is_in_sight & second.is_in_sight & !same;
    let later = max(t1, t2);
    let later = later + later.abs() * (R::of(CLEARLY_LATER) * R::epsilon());
    let unblocked = UNBLOCKED * base;
    let comes = |end: &FromOrigin, time: R, other: R| {
        let free = of_one | (other.wide() <= end.other + unblocked);
        let in_order = end.is_on_line | (!obtuse & (!causal | (time >= later)));
        end.is_in_sight & end.crosses & free & exists & in_order & !(of_one & !exact)
    };
    let late = first.late + first.crossing * (second.late - first.late);
    let time_1 = R::of(first.arrival(if exact { late } else { first.late }));
    let time_2 = R::of(second.arrival(second.late));
    let comes_1 = comes(&first, time_1, t2);
    let comes_2 = comes(&second, time_2, t1) & !exact;
    // Fronts that continue separately have no common front, except along the edges.
    let faceless = apart | comes_1 | comes_2 | exact | obtuse;
    let of_both = curved(
        Triangle { c: if faceless { R::FAR } else { c }, ..triangle },
        Curvatures {
            fronts: [first.curvature, second.curvature].map(R::of),
            causal: causal & !of_one,
            ..curvatures
        },
    );
    let keeps_name = of_one & !exact & first.crosses & (of_both.time < R::FAR);
    let named = first.carried(of_both.time, fronts[0], g0);
    // A front along an edge gives way to a front that arrives together with it, up to rounding, and carries
    // the number of its origin.
    let rounding = of_both.time.abs() * (R::of(ROUNDING) * R::epsilon());
    let gives_way = !keeps_name & (first.is_known | second.is_known);
    let mut arrival = Front {
        time: if gives_way { of_both.time + rounding } else { of_both.time },
        curvature: if keeps_name { named } else { of_both.curvature },
        whole: of_both.whole,
    };
    for (comes, end, time, number) in
        [(comes_1, &first, time_1, fronts[0]), (comes_2, &second, time_2, fronts[1])]
    {
        let is_first = comes & (time <= arrival.time);
        let carried = end.carried(time, number, g0);
        arrival = Front {
            time: if is_first { time } else { arrival.time },
            curvature: if is_first { carried } else { arrival.curvature },
            whole: is_first | arrival.whole,
        };
    }
    arrival
}

/// Returns the time at which the front of an origin arrives at a point along a straight line through one of
/// the point's triangles, which are given by their edges and the steps to their ends. The result is `None` if
/// the line passes through none of them.
pub fn line_to<R: Real>(
    triangles: impl IntoIterator<Item = ([R; 3], [[isize; 2]; 2])>,
    sighted: &Sighted<R>,
) -> Option<R> {
    let here = |(lengths, steps): ([R; 3], [[isize; 2]; 2])| {
        let [l1, l2, c] = lengths;
        if max(max(l1, l2), c) >= R::FAR {
            return None;
        }
        let lengths = lengths.map(R::wide);
        let end = End { time: sighted.start, carried: R::zero(), gaussian: R::zero() };
        let (plane, steps) = (Plane::of(lengths), Steps::new(steps));
        let from = FromOrigin::new(plane, lengths[2], &steps, sighted, end, CORNERS);
        let is_source = from.ray.length <= ON_LINE * lengths[2];
        (from.crosses || is_source).then(|| R::of(from.arrival(0.0)))
    };
    triangles.into_iter().find_map(here)
}

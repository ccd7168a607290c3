//! Implements fronts that carry their ray.

use std::sync::Arc;

use super::kind::{FrontKind, Fronts, TriangleFronts, TriangleKind, Triangular};
use super::lanes::LaneKind;
use super::surface_array::SurfaceArray;
use crate::bend_units;
use crate::lines::line::ScanLine;
use crate::lines::settled::{Visited, from_curved};
use crate::lines::span::{Before, LargestChanges, Span, TILE};
use crate::scan::{Scan, UpdateOptions};
use geosweep_surface::update::{
    Carried, CarriedRay, Course, Front, RayApex, RayEnd, RayFront, SEED, StoredFront, Triangle,
    of_one_front, rays,
};
use geosweep_surface::{Chart, Direction, EdgeLengths, Fan, Heading, Real, Seed, min};

/// The front of [`geosweep_surface::Wavefront::Rays`].
#[derive(Clone, Debug)]
pub(crate) struct Rays<R> {
    edges: EdgeLengths<R>,
    fans: Arc<Vec<Fan<R>>>,
}

/// A front stored at a point.
type KeptRay<R> = StoredFront<R, CarriedRay<R>>;

impl<R: Real> Rays<R> {
    pub(crate) fn new(edges: &EdgeLengths<R>) -> Self {
        Self { edges: edges.clone(), fans: edges.shared_fans() }
    }

    /// Returns the angle in the fan of a point of the direction to another point near it.
    fn angle(&self, from: usize, to: usize) -> R::Bits {
        let chart = self.edges.chart();
        let [a, b] = [from, to].map(|point| chart.entry(point));
        let step = [b.0 as isize - a.0 as isize, b.1 as isize - a.1 as isize];
        let fan = &self.fans[from];
        match Direction::ALL
            .into_iter()
            .find(|direction| <[isize; 2]>::from(direction.step()) == step)
        {
            Some(direction) => fan.angle(direction as usize),
            None => self.edges.angle_of_step(fan, from, step.map(|by| by as f64)),
        }
    }

    fn course(&self, seed: &Seed) -> Course<R> {
        let point = self.edges.chart().bordered(seed.row, seed.col);
        let fan = &self.fans[point];
        let turned = |step: [f64; 2], by: f64| {
            let angle = self.edges.angle_of_step(fan, point, step);
            Course::new(R::angle_ahead(angle, R::of(by)), seed.source)
        };
        match seed.heading {
            Heading::Everywhere => Course::new(R::Bits::default(), seed.source),
            Heading::Along(step) => turned((-step).to_array(), std::f64::consts::PI),
            Heading::ToBothSides(step) => {
                turned(step.to_array(), std::f64::consts::FRAC_PI_2).to_both_sides()
            }
        }
    }
}

impl<R: Real> FrontKind<R> for Rays<R> {
    type Carried = CarriedRay<R>;
    type Arrival = RayFront<R>;
    /// Points at which fronts meet are computed one by one, and take most of the time.
    const AVX512: bool = false;

    fn arrival_of_seed(&mut self, seed: &Seed) -> RayFront<R> {
        let front = Front { time: R::of(seed.time), curvature: R::of(seed.curvature), whole: true };
        RayFront { front, course: self.course(seed) }
    }
}

impl<R> Triangular for Rays<R> {}

impl<R: Real> TriangleKind<R> for Rays<R> {
    fn arrival(
        &self,
        [x0, x1, x2]: [usize; 3],
        triangle: Triangle<R>,
        carried: [CarriedRay<R>; 2],
        _: bool,
    ) -> RayFront<R> {
        let end = |own: usize, other: usize, carried: CarriedRay<R>| RayEnd {
            curvature: carried.value(),
            course: carried.course(),
            gaussian: self.fans[own].gaussian(),
            base: self.angle(own, other),
            side: self.angle(own, x0),
        };
        let ends = [end(x1, x2, carried[0]), end(x2, x1, carried[1])];
        let edges = [self.angle(x0, x1), self.angle(x0, x2)];
        rays(triangle, &ends, &RayApex { gaussian: self.fans[x0].gaussian(), edges })
    }
}

impl<R: Real> Fronts<R> for CarriedRay<R> {
    type Arrival = RayFront<R>;
    const TAKES_BACK: bool = true;

    /// Returns the front at a point after a scan has brought `front` to it, by the rules of curved fronts.
    #[inline(always)]
    fn accept(kept: KeptRay<R>, front: RayFront<R>, scan: u8, renews: bool) -> KeptRay<R> {
        let before = kept.carried.front(kept.time);
        let brought = CarriedRay::of(front, scan);
        let arrival = Front { curvature: brought.value(), ..front.front };
        let was_reached = kept.time < R::FAR;
        let together = was_reached & arrival.arrives_with(before.front);
        let first =
            if together { arrival.replaces(before.front) } else { arrival.time < kept.time };
        let is_same = arrival.is_same_as(before.front) & front.course.is_same_as(before.course);
        let is_new = !(together & is_same);
        let accepted = first | (was_reached & renews & kept.carried.is_from(scan) & is_new);
        let time = if together { min(kept.time, arrival.time) } else { arrival.time };
        StoredFront {
            time: if accepted { time } else { kept.time },
            carried: if accepted { brought } else { kept.carried },
        }
    }

    fn arrival_of_front(kept: KeptRay<R>) -> RayFront<R> {
        kept.carried.front(kept.time)
    }

    #[inline(always)]
    fn first(a: KeptRay<R>, b: KeptRay<R>) -> KeptRay<R> {
        let (of_a, of_b) = (a.carried.front(a.time).front, b.carried.front(b.time).front);
        let second =
            if of_a.arrives_with(of_b) { of_b.knows_better(of_a) } else { of_b.time < of_a.time };
        StoredFront {
            time: min(a.time, b.time),
            carried: if second { b.carried } else { a.carried },
        }
    }

    #[inline(always)]
    fn change(before: KeptRay<R>, after: KeptRay<R>) -> R::Bits {
        let bend = (after.carried.value() - before.carried.value()).abs() * after.time;
        before.time.units_between(after.time).max(bend_units(bend))
    }
}

impl<R: Real> TriangleFronts<R> for CarriedRay<R> {
    fn time(arrival: RayFront<R>) -> R {
        arrival.front.time
    }

    fn earlier(a: RayFront<R>, b: RayFront<R>) -> RayFront<R> {
        RayFront::first(a, b)
    }

    fn curvature(kept: KeptRay<R>) -> R {
        kept.carried.value()
    }

    fn circle(radius: R) -> Self {
        let front = Front { time: radius, curvature: radius.recip(), whole: false };
        Self::of(RayFront { front, course: Course::new(R::Bits::default(), 0) }, SEED)
    }
}

/// The directions that the update of a line needs: from a point to the three neighbours behind it, and along the line.
pub(crate) struct RayLine {
    behind: [Direction; 3],
    along: Direction,
}

impl<R: Real> LaneKind<R> for Rays<R> {
    type SurfaceData = Fan<R>;
    type OfLine<'k> = RayLine;
    const TELLS_BENDS: bool = true;

    fn surface_data(&self, _: Chart) -> SurfaceArray<Fan<R>> {
        SurfaceArray::OfEdges(self.fans.clone())
    }

    fn of_line(&self, _: [usize; 2], scan: Scan) -> RayLine {
        let along = if scan.by_rows() { Direction::East } else { Direction::South };
        RayLine { behind: scan.behind(), along }
    }

    #[inline(always)]
    fn update_span(
        of_line: &RayLine,
        line: &mut ScanLine<'_, '_, R, Self::Carried, Self::SurfaceData>,
        [start, points]: [usize; 2],
        splits: &[(usize, Option<Self::Arrival>)],
        options: UpdateOptions,
        changes: &mut LargestChanges<R>,
    ) -> Option<bool> {
        let span = line.span(start, points);
        let has_splits = !splits.is_empty();
        let is_settled = match has_splits {
            false => leaves::<_, false>(&span, points, options),
            true => {
                let is_alone = splits.iter().all(|(_, front)| front.is_none());
                is_alone && leaves::<_, true>(&span, points, options)
            }
        };
        if is_settled {
            return None;
        }
        let surface_behind = line.surface_behind(start, points);
        let on = OnSpan { of_line, span, surface_behind, has_splits };
        let first = on.first_fronts(points, options);
        let (mut times, mut carried) = ([R::zero(); TILE], [CarriedRay::default(); TILE]);
        let mut any = false;
        for i in 0..points {
            let before = StoredFront { time: span.times[i], carried: span.carried[i] };
            let mut front = first.get(i);
            if has_splits {
                let split = splits.iter().find(|(place, _)| *place == start + i);
                if let Some((_, Some(split))) = split {
                    front = RayFront::first(front, *split);
                }
            }
            let after = CarriedRay::accept(before, front, options.scan.0, options.renews);
            (times[i], carried[i]) = (after.time, after.carried);
            let change = before.time.units_between(after.time);
            any |= after != before;
            changes.note(i, change);
            let [bent_before, bent] = [before.carried.value(), after.carried.value()];
            changes.note_bend(i, (bent - bent_before).abs() * after.time);
        }
        line.set(start, &times[..points], &carried[..points]);
        Some(any)
    }

    #[inline(always)]
    fn leaves(
        &self,
        _: &Before<'_, R, Self::Carried, Self::SurfaceData>,
        _: usize,
        span: Span<'_, R, Self::Carried, Self::SurfaceData>,
        points: usize,
        options: UpdateOptions,
    ) -> bool {
        leaves::<_, false>(&span, points, options)
    }
}

/// Returns whether a scan leaves a span of points unchanged.
#[inline(always)]
fn leaves<R: Real, const SPLIT: bool>(
    span: &Span<'_, R, CarriedRay<R>, Fan<R>>,
    points: usize,
    options: UpdateOptions,
) -> bool {
    if span.is_renewed(points, options) {
        return false;
    }
    if span.leads(points) {
        return true;
    }
    let [before, beside, after] = span.carried_behind;
    let (mut settled, limit) = (true, R::of(options.limit));
    for i in 0..points {
        let visited: Visited<R> = span.visited::<SPLIT>(i, limit);
        let [left, right] = visited.triangles;
        let [k_before, k_beside, k_after] =
            [before[i].value(), beside[i].value(), after[i].value()];
        let of = [
            from_curved(left, [k_before, k_beside], visited.now),
            from_curved(right, [k_after, k_beside], visited.now),
        ];
        settled &= visited.stays(of);
    }
    settled
}

/// The first front to reach each point of a span.
struct FirstRays<R: Real> {
    times: [R; TILE],
    curvatures: [R; TILE],
    courses: [R::Bits; TILE],
    /// 1 where the front came through the face of a triangle, else 0.
    inside: [R; TILE],
    /// 1 where the front is not valid, since several fronts may have reached the base.
    doubtful: [R; TILE],
}

impl<R: Real> FirstRays<R> {
    #[inline(always)]
    fn none() -> Self {
        let zero = [R::zero(); TILE];
        Self {
            times: zero,
            curvatures: zero,
            courses: [R::Bits::default(); TILE],
            inside: zero,
            doubtful: zero,
        }
    }

    #[inline(always)]
    fn get(&self, i: usize) -> RayFront<R> {
        let whole = self.inside[i] > R::zero();
        let front = Front { time: self.times[i], curvature: self.curvatures[i], whole };
        RayFront { front, course: Course(self.courses[i]) }
    }

    #[inline(always)]
    fn set(&mut self, i: usize, RayFront { front, course }: RayFront<R>) {
        (self.times[i], self.curvatures[i]) = (front.time, front.curvature);
        self.courses[i] = course.0;
        self.inside[i] = if front.whole { R::one() } else { R::zero() };
        self.doubtful[i] = R::zero();
    }

    #[inline(always)]
    fn is_doubtful(&self, i: usize) -> bool {
        self.doubtful[i] > R::zero()
    }

    /// Returns the front, or none if it is not valid.
    #[inline(always)]
    fn valid(&self, i: usize) -> RayFront<R> {
        let RayFront { front, course } = self.get(i);
        let none = Front { time: R::FAR, curvature: R::zero(), whole: false };
        RayFront { front: if self.is_doubtful(i) { none } else { front }, course }
    }
}

/// The angles of one edge in the fans of a span's points.
#[inline(always)]
fn angles<R: Real>(fans: &[Fan<R>], to: Direction, points: usize) -> [R::Bits; TILE] {
    let mut found = [R::Bits::default(); TILE];
    for (found, fan) in found.iter_mut().zip(&fans[..points]) {
        *found = fan.angle(to as usize);
    }
    found
}

/// A span of points and the surface behind them.
struct OnSpan<'a, R: Real> {
    of_line: &'a RayLine,
    span: Span<'a, R, CarriedRay<R>, Fan<R>>,
    surface_behind: [&'a [Fan<R>]; 3],
    has_splits: bool,
}

impl<R: Real> OnSpan<'_, R> {
    #[inline(always)]
    fn first_fronts(&self, points: usize, options: UpdateOptions) -> FirstRays<R> {
        let span = &self.span;
        let (mut first, mut second) = (FirstRays::none(), FirstRays::none());
        self.through::<true>(points, &mut first);
        self.through::<false>(points, &mut second);
        // Which triangles of a point to compute again: 1 for the left one, 2 for the right one.
        let mut again = [R::zero(); TILE];
        let mut any = false;
        for (i, again) in again[..points].iter_mut().enumerate() {
            let (left, right) = (first.valid(i), second.valid(i));
            let best = RayFront::first(left, right);
            let renewed = options.renews & span.carried[i].is_from(options.scan.0);
            let now = if renewed { R::FAR } else { span.times[i] };
            let until = min(now, best.front.time);
            let along_edge = !best.front.whole & (best.front.time < now);
            let left = along_edge | (first.is_doubtful(i) & !self.comes_after::<true>(i, until));
            let right = along_edge | (second.is_doubtful(i) & !self.comes_after::<false>(i, until));
            any |= left | right;
            let of_left = if left { R::one() } else { R::zero() };
            *again = of_left + if right { R::of(2.0) } else { R::zero() };
        }
        if any {
            for (i, which) in again[..points].iter().enumerate() {
                if *which > R::zero() {
                    let which = which.wide() as u8;
                    self.compute_again(i, which, &mut first, &mut second);
                }
            }
        }
        for i in 0..points {
            first.set(i, RayFront::first(first.valid(i), second.valid(i)));
        }
        first
    }

    /// Returns whether it is certain that a triangle brings no front before a time.
    #[inline(always)]
    fn comes_after<const LEFT: bool>(&self, i: usize, until: R) -> bool {
        let x1 = if LEFT { 0 } else { 1 };
        let span = &self.span;
        let triangle = span.weighted_triangle::<LEFT>(i);
        let curvatures = [x1, x1 + 1].map(|x| span.carried_behind[x][i].value());
        let starts_later = min(triangle.t1, triangle.t2) >= until;
        starts_later
            | from_curved(triangle, curvatures, until)
            | from_curved(triangle.mirrored(), curvatures, until)
    }

    /// Computes fronts at a point where several fronts may meet.
    #[inline(never)]
    fn compute_again(
        &self,
        i: usize,
        which: u8,
        first: &mut FirstRays<R>,
        second: &mut FirstRays<R>,
    ) {
        let (of_line, span, behind) = (self.of_line, &self.span, &self.surface_behind);
        if which & 1 != 0 {
            first.set(i, of_line.front::<R, true>(span, behind, i, self.has_splits));
        }
        if which & 2 != 0 {
            second.set(i, of_line.front::<R, false>(span, behind, i, self.has_splits));
        }
    }

    /// Computes the fronts of [`of_one_front`] through one of the two triangles of each point.
    #[inline(always)]
    fn through<const LEFT: bool>(&self, points: usize, found: &mut FirstRays<R>) {
        let (span, of_line) = (&self.span, self.of_line);
        let x1 = if LEFT { 0 } else { 1 };
        let own = span.surface_data;
        let base_1 = angles(self.surface_behind[x1], of_line.along, points);
        let base_2 = angles(self.surface_behind[x1 + 1], of_line.along.opposite(), points);
        let edge_1 = angles(own, of_line.behind[x1], points);
        let edge_2 = angles(own, of_line.behind[x1 + 1], points);
        let mut gaussian = [[R::zero(); TILE]; 3];
        let mut curvature = [[R::zero(); TILE]; 2];
        let mut course = [[R::Bits::default(); TILE]; 2];
        for i in 0..points {
            gaussian[0][i] = own[i].gaussian();
            for end in 0..2 {
                let carried = span.carried_behind[x1 + end][i];
                gaussian[1 + end][i] = self.surface_behind[x1 + end][i].gaussian();
                curvature[end][i] = carried.value();
                course[end][i] = carried.course().0;
            }
        }
        for i in 0..points {
            let triangle = span.weighted_triangle::<LEFT>(i);
            let triangle = if self.has_splits { triangle.without_obtuse_face() } else { triangle };
            let end = |end: usize, base: R::Bits| RayEnd {
                curvature: curvature[end][i],
                course: Course(course[end][i]),
                gaussian: gaussian[1 + end][i],
                base,
                side: R::Bits::default(),
            };
            let ends = [end(0, base_1[i]), end(1, base_2[i])];
            let apex = RayApex { gaussian: gaussian[0][i], edges: [edge_1[i], edge_2[i]] };
            let of_one = of_one_front(triangle, &ends, &apex);
            found.set(i, of_one.front);
            found.doubtful[i] = if of_one.is_one { R::zero() } else { R::one() };
        }
    }
}

impl RayLine {
    /// Returns the front through one of the two triangles of point `i` of a span.
    #[inline]
    fn front<R: Real, const LEFT: bool>(
        &self,
        span: &Span<'_, R, CarriedRay<R>, Fan<R>>,
        surface_behind: &[&[Fan<R>]; 3],
        i: usize,
        is_split: bool,
    ) -> RayFront<R> {
        let x1 = if LEFT { 0 } else { 1 };
        let triangle = span.weighted_triangle::<LEFT>(i);
        let triangle = if is_split { triangle.without_obtuse_face() } else { triangle };
        let end = |x: usize, base: Direction| {
            let (carried, fan) = (span.carried_behind[x][i], &surface_behind[x][i]);
            RayEnd {
                curvature: carried.value(),
                course: carried.course(),
                gaussian: fan.gaussian(),
                base: fan.angle(base as usize),
                side: fan.angle(self.behind[x].opposite() as usize),
            }
        };
        let ends = [end(x1, self.along), end(x1 + 1, self.along.opposite())];
        let own = &span.surface_data[i];
        let edges = [x1, x1 + 1].map(|x| own.angle(self.behind[x] as usize));
        rays(triangle, &ends, &RayApex { gaussian: own.gaussian(), edges })
    }
}

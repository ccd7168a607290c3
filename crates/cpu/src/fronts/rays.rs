//! Implements fronts that carry their ray.

use std::sync::Arc;

use super::kind::{FrontKind, Fronts, TriangleFronts, TriangleKind, Triangular};
use super::lanes::LaneKind;
use super::surface_array::SurfaceArray;
use crate::bend_units;
use crate::lines::line::ScanLine;
use crate::lines::span::{Before, LargestChanges, Span, TILE};
use crate::scan::{Scan, UpdateOptions};
use geosweep_surface::update::{
    Carried, CarriedRay, Course, Front, RayApex, RayEnd, RayFront, SEED, StoredFront, Triangle, rays,
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
        match Direction::ALL.into_iter().find(|direction| <[isize; 2]>::from(direction.step()) == step) {
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
        StoredFront { time: min(a.time, b.time), carried: if second { b.carried } else { a.carried } }
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
        update_span(of_line, line, [start, points], splits, options, changes)
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
        !span.is_renewed(points, options) && span.leads(points)
    }
}

#[inline(never)]
fn update_span<R: Real>(
    of_line: &RayLine,
    line: &mut ScanLine<'_, '_, R, CarriedRay<R>, Fan<R>>,
    [start, points]: [usize; 2],
    splits: &[(usize, Option<RayFront<R>>)],
    options: UpdateOptions,
    changes: &mut LargestChanges<R>,
) -> Option<bool> {
    let span = line.span(start, points);
    if !span.is_renewed(points, options) && span.leads(points) {
        return None;
    }
    let surface_behind = line.surface_behind(start, points);
    let (mut times, mut carried) = ([R::zero(); TILE], [CarriedRay::default(); TILE]);
    let mut any = false;
    for i in 0..points {
        let before = StoredFront { time: span.times[i], carried: span.carried[i] };
        let mut first = of_line.front::<R, true>(&span, &surface_behind, i, !splits.is_empty());
        first = RayFront::first(first, of_line.front::<R, false>(&span, &surface_behind, i, !splits.is_empty()));
        let split = splits.iter().find(|(place, _)| *place == start + i);
        if let Some((_, Some(split))) = split {
            first = RayFront::first(first, *split);
        }
        let after = CarriedRay::accept(before, first, options.scan.0, options.renews);
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

//! Arrival times in a bordered array, and the update of one point in it.

use rayon::prelude::*;

use super::bend_units;
use crate::constants::{ANCHOR_COUNTS, WHOLE};
use crate::surface::EdgeSlot;
use crate::surface::{Chart, Direction, EdgeLengths, Real, Seed, TAG, min};
use crate::update::{
    Bends, Floor, Front, Triangle, Wavefront, curved, is_shorter, planar, point_source,
};

/// A distance map as a CPU solver leaves it.
#[derive(Clone, Debug)]
pub struct Solution<R> {
    pub(super) chart: Chart,
    pub(super) times: Vec<R>,
    /// Iterations of four scans; fast marching counts as one.
    pub iterations: u32,
    /// Largest relative change of an arrival time in the last iteration, to within a factor of two
    /// upwards; a point that was reached in it counts as 1.
    pub residual: f64,
}

impl<R: Real> Solution<R> {
    pub(super) fn new(chart: Chart, times: Vec<R>, iterations: u32, residual: f64) -> Self {
        Self { chart, times, iterations, residual }
    }

    /// The distances, row-major, +infinity where the sources do not reach.
    pub fn distances(&self) -> Vec<R> {
        distances(self.chart, &self.times)
    }
}

/// The arrival times of a bordered array as distances, row-major.
pub(super) fn distances<R: Real>(chart: Chart, times: &[R]) -> Vec<R> {
    let mut distances = vec![R::zero(); chart.points()];
    distances.par_chunks_mut(chart.cols).enumerate().for_each(|(row, distances)| {
        let times = &times[chart.bordered(row, 0)..][..chart.cols];
        for (distance, &time) in distances.iter_mut().zip(times) {
            *distance = if time < R::FAR { time } else { R::infinity() };
        }
    });
    distances
}

/// Tag ([`Real::with_tag`]) of the curvature of fronts that no scan has brought.
pub(super) const SEED: u8 = 0;

/// The fronts at all points of a bordered array while a solver works on them.
#[derive(Clone)]
pub(super) struct Fronts<'a, R> {
    edges: &'a EdgeLengths<R>,
    wavefront: Wavefront,
    times: Vec<R>,
    /// Of the fronts, tagged with the scan that has brought them, or in their place the numbers of their
    /// anchors; empty if the front has neither.
    curvatures: Vec<R>,
    /// Of the surface; empty unless the wavefront is curved.
    gaussian: &'a [R],
    /// If fronts have anchors.
    floor: Option<Floor<R>>,
}

impl<'a, R: Real> Fronts<'a, R> {
    /// No point reached but the seeds.
    pub(super) fn start(edges: &'a EdgeLengths<R>, seeds: &[Seed], wavefront: Wavefront) -> Self {
        let points = edges.chart().bordered_points();
        let wavefront = wavefront.over(edges);
        let mut fronts = Self {
            edges,
            wavefront,
            times: vec![R::FAR; points],
            curvatures: vec![R::zero(); if wavefront.has_two_layers() { points } else { 0 }],
            gaussian: if wavefront.is_curved() { edges.gaussian_curvature() } else { &[] },
            floor: (wavefront == Wavefront::Anchored).then(|| Floor::of(edges)).flatten(),
        };
        for seed in seeds {
            let curvature = match &mut fronts.floor {
                Some(floor) => floor.anchor_of(seed),
                None => R::of(seed.curvature),
            };
            let front = Front { time: R::of(seed.time), curvature, whole: true };
            fronts.lower(edges.chart().bordered(seed.row, seed.col), front);
        }
        fronts
    }

    /// Arrival time at a point.
    #[inline]
    pub(super) fn time(&self, point: usize) -> R {
        self.times[point]
    }

    /// The front that reaches a point through the triangle with x1 and x2, whose arrival times
    /// are given beside the lengths; see [`Bends`] for `alone`.
    #[inline]
    pub(super) fn arrival(
        &self,
        point: usize,
        x: [usize; 2],
        triangle: Triangle<R>,
        alone: bool,
    ) -> Front<R> {
        let straight = |time| Front { time, curvature: R::zero(), whole: false };
        match self.wavefront {
            Wavefront::Planar => straight(planar(triangle)),
            Wavefront::PointSource => straight(point_source(triangle)),
            Wavefront::Curved => curved(triangle, self.bends(point, x, alone)),
            Wavefront::Anchored => unreachable!("anchors are no front of a triangle alone"),
        }
    }

    /// What a curved front knows of a triangle's corners.
    #[inline]
    fn bends(&self, point: usize, [x1, x2]: [usize; 2], alone: bool) -> Bends<R> {
        Bends {
            fronts: [x1, x2].map(|corner| self.curvatures[corner]),
            surface: [point, x1, x2].map(|corner| self.gaussian[corner]),
            alone,
        }
    }

    /// The first of the fronts that reach a point through the two triangles of a scan.
    #[inline]
    pub(super) fn through(&self, point: usize, behind: &Behind) -> Front<R> {
        self.through_seen(point, behind, |x| self.at(x))
    }

    /// The same, with the fronts at anchors seen through `front`.
    #[inline]
    pub(super) fn through_seen(
        &self,
        point: usize,
        behind: &Behind,
        front: impl Fn(usize) -> [R; 2],
    ) -> Front<R> {
        if let Some(floor) = &self.floor {
            let way = floor.reach(point, behind.middle as usize, front);
            return Front { time: way.time, curvature: R::of_number(way.anchor), whole: false };
        }
        let time = |x: usize| self.times[x];
        let [a, b] =
            behind.triangles.each_ref().map(|slots| self.through_known(point, slots, time));
        Front::first(a, b)
    }

    /// The front that reaches a point through one triangle, with arrival times seen through `time`.
    #[inline]
    pub(super) fn through_known(
        &self,
        point: usize,
        slots: &TriangleSlots,
        time: impl Fn(usize) -> R,
    ) -> Front<R> {
        let (x, triangle) = self.triangle(point, slots, time);
        let alone = [triangle.l1, triangle.l2][slots.axis] >= R::FAR;
        self.arrival(point, x, triangle, alone)
    }

    /// A triangle of a point, with arrival times seen through `time`, and the curvatures of the
    /// fronts at its two other corners; zero unless the wavefront is curved.
    pub(super) fn seen_through(
        &self,
        point: usize,
        slots: &TriangleSlots,
        time: impl Fn(usize) -> R,
    ) -> (Triangle<R>, [R; 2]) {
        let (x, triangle) = self.triangle(point, slots, time);
        (triangle, x.map(|corner| self.at(corner)[1]))
    }

    #[inline]
    fn triangle(
        &self,
        point: usize,
        slots: &TriangleSlots,
        time: impl Fn(usize) -> R,
    ) -> ([usize; 2], Triangle<R>) {
        let x1 = point.wrapping_add_signed(slots.x1);
        let x2 = point.wrapping_add_signed(slots.x2);
        let [l1, l2, c] = slots.lengths(self.edges, point);
        ([x1, x2], Triangle { t1: time(x1), t2: time(x2), l1, l2, c })
    }

    /// Accepts a front at a point if it is the first; returns the change of the time.
    #[inline]
    pub(super) fn lower(&mut self, point: usize, front: Front<R>) -> R::Bits {
        self.accept(point, front, SEED, false)
    }

    /// Accepts a front that one of the scans, numbered from 1, brings to a point (see [`accept`]);
    /// returns the change of the front, in units of its arrival time ([`Real::units_between`]).
    #[inline]
    pub(super) fn accept(
        &mut self,
        point: usize,
        front: Front<R>,
        scan: u8,
        renews: bool,
    ) -> R::Bits {
        let before = self.times[point];
        let Some(curvature) = self.curvatures.get_mut(point) else {
            let time = if front.time < before { front.time } else { before };
            self.times[point] = time;
            return before.units_between(time);
        };
        let bent_before = *curvature;
        if self.floor.is_some() {
            let anchored = [before, bent_before];
            let [time, anchor] = accept_anchored(anchored, front, scan, renews);
            (self.times[point], *curvature) = (time, anchor);
            return change_of_anchored(anchored, [time, anchor]);
        }
        (self.times[point], *curvature) = accept(before, bent_before, front, scan, renews);
        change([before, bent_before], [self.times[point], *curvature])
    }

    /// How much the front at a point has changed since, as from [`Self::accept`].
    pub(super) fn change_from(&self, before: &Self, point: usize) -> R::Bits {
        let [old, new] = [before, self].map(|fronts| fronts.at(point));
        self.change(old, new)
    }

    fn change(&self, old: [R; 2], new: [R; 2]) -> R::Bits {
        if self.floor.is_some() { change_of_anchored(old, new) } else { change(old, new) }
    }

    /// Arrival time and tagged curvature at a point; zero unless the wavefront is curved.
    pub(super) fn at(&self, point: usize) -> [R; 2] {
        [self.times[point], self.curvatures.get(point).copied().unwrap_or(R::zero())]
    }

    fn set(&mut self, point: usize, [time, curvature]: [R; 2]) {
        self.times[point] = time;
        if let Some(held) = self.curvatures.get_mut(point) {
            *held = curvature;
        }
    }

    /// Takes over the front at a point.
    pub(super) fn copy_point(&mut self, from: &Self, point: usize) {
        self.set(point, from.at(point));
    }

    /// Takes the first of the fronts that copies have at a point after scans of their own, numbered
    /// from 1 in their order; returns the change. A front that the copy's own scan has not brought
    /// stands for nothing but the one that is here; if that has been taken back, none is left.
    pub(super) fn take_first(&mut self, copies: &[Self; 4], point: usize) -> R::Bits {
        let (before, first) = match self.floor {
            Some(_) => (self.at(point), first_anchored as fn([R; 2], [R; 2]) -> [R; 2]),
            None => (self.at(point), first as fn([R; 2], [R; 2]) -> [R; 2]),
        };
        let (mut taken, mut left): (Option<[R; 2]>, _) = (None, before);
        for (copy, scan) in copies.iter().zip(1..) {
            let other = copy.at(point);
            let straight = self.curvatures.is_empty();
            if other[0] >= R::FAR {
                left = other;
            } else if straight || is_from(other[1], scan) {
                taken = Some(taken.map_or(other, |taken| first(taken, other)));
            }
        }
        let after = taken.unwrap_or(left);
        self.set(point, after);
        self.change(before, after)
    }

    pub(super) fn finish(self, iterations: u32, residual: f64) -> Solution<R> {
        Solution::new(self.edges.chart(), self.times, iterations, residual)
    }
}

/// The change of an arrival time and a curvature, in units of the time ([`Real::units_between`]).
#[inline(always)]
fn change<R: Real>(before: [R; 2], after: [R; 2]) -> R::Bits {
    let bend = (after[1] - before[1]).abs() * after[0];
    before[0].units_between(after[0]).max(bend_units(bend))
}

/// The arrival time and the tagged curvature at a point after one of the scans, numbered from 1,
/// has brought a front to it.
///
/// The front is accepted if it is the first, or arrives with that and is preferred
/// ([`Front::replaces`]). If the scan `renews`, it is accepted as well, earlier or later, if it has
/// brought the one before: that came from the same triangles, whose fronts have changed since. So
/// nothing that was computed from a preliminary curvature stays. What differs by rounding alone is no
/// change ([`Front::is_same_as`]): the last digits of a front far away would else be passed on from
/// point to point and visited anew. Else the one that is here stays, so that scans that arrive together
/// do not take turns.
#[inline(always)]
pub(super) fn accept<R: Real>(
    time: R,
    curvature: R,
    front: Front<R>,
    scan: u8,
    renews: bool,
) -> (R, R) {
    let before = self::front(time, curvature);
    let front = Front { curvature: tagged(front, scan), ..front };
    let was_reached = time < R::FAR;
    let together = was_reached & front.arrives_with(before);
    let first = if together { front.replaces(before) } else { front.time < time };
    let is_new = !(together & front.is_same_as(before));
    let accepted = first | (was_reached & renews & is_from(curvature, scan) & is_new);
    let arrival = if together { min(time, front.time) } else { front.time };
    (if accepted { arrival } else { time }, if accepted { front.curvature } else { curvature })
}

/// [`accept`] of a front with the number of its anchor, zero where none has arrived: what comes shorter than
/// what is here, by more than rounding; and if the scan `renews`, what it brings in place of what it has
/// brought before.
#[inline(always)]
pub(super) fn accept_anchored<R: Real>(
    [time, anchor]: [R; 2],
    front: Front<R>,
    scan: u8,
    renews: bool,
) -> [R; 2] {
    let is_same = !is_shorter(front.time, time)
        & !is_shorter(time, front.time)
        & anchor.is_numbered_as(front.curvature);
    let again = (time < R::FAR) & renews & is_from(anchor, scan) & !is_same;
    let accepted = is_shorter(front.time, time) | again;
    let brought = if front.time < R::FAR { front.curvature.with_tag(scan) } else { R::zero() };
    [if accepted { front.time } else { time }, if accepted { brought } else { anchor }]
}

/// [`change`] of a front with the number of its anchor: another one is news for the points beside it, if
/// none for the map.
#[inline(always)]
pub(super) fn change_of_anchored<R: Real>(before: [R; 2], after: [R; 2]) -> R::Bits {
    let turns = !before[1].is_numbered_as(after[1]);
    let turn = if turns { R::of(ANCHOR_COUNTS).in_units() } else { R::Bits::default() };
    before[0].units_between(after[0]).max(turn)
}

/// [`first`] of fronts with numbers of their anchors: the second if it is shorter by more than rounding.
#[inline(always)]
pub(super) fn first_anchored<R: Real>(a: [R; 2], b: [R; 2]) -> [R; 2] {
    if is_shorter(b[0], a[0]) { b } else { a }
}

/// A front's curvature, tagged with the scan that brings it and whether its triangle is whole.
#[inline(always)]
fn tagged<R: Real>(front: Front<R>, scan: u8) -> R {
    let (whole, half) =
        (front.curvature.with_tag(scan | WHOLE as u8), front.curvature.with_tag(scan));
    if front.whole { whole } else { half }
}

/// The first of two fronts, given as arrival times and tagged curvatures; of those that arrive together
/// as [`Front::first`].
#[inline(always)]
pub(super) fn first<R: Real>(a: [R; 2], b: [R; 2]) -> [R; 2] {
    let ([of_a, of_b], time) = ([a, b].map(|[time, k]| front(time, k)), min(a[0], b[0]));
    let second =
        if of_a.arrives_with(of_b) { of_b.knows_better(of_a) } else { of_b.time < of_a.time };
    [time, if second { b[1] } else { a[1] }]
}

/// The front that an arrival time and a tagged curvature stand for.
#[inline(always)]
pub(super) fn front<R: Real>(time: R, curvature: R) -> Front<R> {
    Front { time, curvature, whole: !curvature.tag_has(WHOLE as u8, 0) }
}

/// Whether a scan has brought a front with this tagged curvature.
#[inline(always)]
pub(super) fn is_from<R: Real>(curvature: R, scan: u8) -> bool {
    curvature.tag_has(TAG & !(WHOLE as u8), scan)
}

/// The two triangles of a scan: with three neighbours that follow one another.
#[derive(Clone, Copy, Debug)]
pub(super) struct Behind {
    triangles: [TriangleSlots; 2],
    /// The second of the neighbours.
    middle: Direction,
}

impl Behind {
    pub(super) fn new(chart: Chart, [a, b, c]: [Direction; 3]) -> Self {
        let triangles = [TriangleSlots::new(chart, a, b), TriangleSlots::new(chart, b, c)];
        Self { triangles, middle: b }
    }
}

/// Where a triangle's two other corners and its edges lie, seen from its point x0.
#[derive(Clone, Copy, Debug)]
pub(super) struct TriangleSlots {
    /// Which of x1 and x2 is the neighbour along an axis of the grid; the other is one across a diagonal.
    axis: usize,
    x1: isize,
    x2: isize,
    l1: EdgeSlot,
    l2: EdgeSlot,
    c: EdgeSlot,
}

impl TriangleSlots {
    /// The triangle between two directions that follow one another.
    pub(super) fn new(chart: Chart, first: Direction, second: Direction) -> Self {
        let (from, to) = (first.step(), second.step());
        let base = Direction::ALL
            .into_iter()
            .find(|direction| direction.step() == (to.0 - from.0, to.1 - from.1))
            .expect("the directions of a triangle follow one another");
        Self {
            axis: usize::from(from.0 * from.1 != 0),
            x1: chart.offset(first),
            x2: chart.offset(second),
            l1: EdgeSlot::new(chart, 0, first),
            l2: EdgeSlot::new(chart, 0, second),
            c: EdgeSlot::new(chart, chart.offset(first), base),
        }
    }

    /// Lengths of x0 x1, x0 x2 and x1 x2.
    #[inline]
    pub(super) fn lengths<R: Real>(&self, edges: &EdgeLengths<R>, point: usize) -> [R; 3] {
        [self.l1, self.l2, self.c].map(|slot| edges.at(point, slot))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What becomes of a front of time 1.5 and curvature 0.3 that scan 2 has brought from a whole triangle
    /// when this comes.
    fn after<R: Real>([time, curvature]: [f64; 2], scan: u8, renews: bool) -> [R; 2] {
        let whole = true;
        let old = tagged(Front { time: R::of(1.5), curvature: R::of(0.3), whole }, 2);
        let front = Front { time: R::of(time), curvature: R::of(curvature), whole };
        accept(R::of(1.5), old, front, scan, renews).into()
    }

    fn assert_renews_but_for_rounding<R: Real>() {
        let kept = after::<R>([2.0, 0.3], 1, true);
        assert_eq!(kept[0], R::of(1.5));
        let digit = R::epsilon().wide();
        let is_kept = |front, scan, renews| after::<R>(front, scan, renews) == kept;
        // Its own scan brings it again.
        assert!(is_kept([1.5 + digit, 0.3], 2, true));
        assert!(is_kept([1.5 - digit, 0.3 * (1.0 + 64.0 * digit)], 2, true));
        for changed in [[1.5 + 4.0 * digit, 0.3], [1.5, 0.3 * (1.0 + 4096.0 * digit)]] {
            assert_eq!(after::<R>(changed, 2, true)[0], R::of(changed[0]));
            assert!(!is_kept(changed, 2, true) && is_kept(changed, 2, false));
            assert!(is_kept(changed, 1, true));
        }
        // Another brings one that arrives together with it, earlier by a digit, or earlier by more.
        assert!(is_kept([1.5 - digit, 0.299], 1, true));
        assert!(!is_kept([1.5 - digit, 0.29], 1, true));
        assert!(!is_kept([1.5 - 4.0 * digit, 0.299], 1, true));
    }

    #[test]
    fn fronts_that_come_again_are_renewed_but_for_rounding() {
        assert_renews_but_for_rounding::<f32>();
        assert_renews_but_for_rounding::<f64>();
    }
}

//! Computes the fronts at points from those at earlier points, which are final.

use super::BucketScanner;
use super::state::{State, none};
use crate::fronts::{BATCH, Fronts, MOST, Pulled, TriangleFronts, TriangleKind};
use geosweep_surface::update::{StoredFront, Triangle};
use geosweep_surface::{Real, SplitPart};

/// Scan number of fronts that are computed in the order of time. No scan renews them.
const IN_ORDER: u8 = 1;

/// Least change of a front after which points that depend on it are computed again, in units of the rounding of its time.
pub(super) const CHANGE: u32 = 2;

impl<R: Real, K: TriangleKind<R>> BucketScanner<R, K> {
    /// Computes the fronts at points.
    #[inline(always)]
    pub(super) fn compute(
        &mut self,
        batch: &[usize],
        lanes: &mut Pulled<R, K::Carried>,
        arrivals: &mut [K::Arrival; MOST],
    ) {
        let mut ends = [0; BATCH];
        lanes.count = 0;
        for (&point, end) in batch.iter().zip(&mut ends) {
            self.add_behind(point, lanes);
            *end = lanes.count;
        }
        self.triangles += lanes.count as u64;
        self.shared.kind.arrivals(lanes, arrivals);
        let mut start = 0;
        for (&point, &end) in batch.iter().zip(&ends) {
            let mut first = arrivals[start..end].iter().copied().reduce(K::Carried::earlier);
            start = end;
            if self.shared.parts.is_some() {
                first = self.through_parts(point, first);
            }
            self.settle(point, first);
        }
    }

    /// Computes the front at all copies of a point.
    #[inline(never)]
    pub(super) fn compute_copies(
        &mut self,
        point: usize,
        lanes: &mut Pulled<R, K::Carried>,
        arrivals: &mut [K::Arrival; MOST],
    ) {
        let mut first: Option<K::Arrival> = None;
        self.each_copy(point, |solver, copy| {
            solver.states[copy].clear(State::WAITS);
            lanes.count = 0;
            solver.add_behind(copy, lanes);
            solver.triangles += lanes.count as u64;
            solver.shared.kind.arrivals(lanes, arrivals);
            let all = first.into_iter().chain(arrivals[..lanes.count].iter().copied());
            first = all.reduce(K::Carried::earlier);
            if solver.shared.parts.is_some() {
                first = solver.through_parts(copy, first);
            }
        });
        self.settle(point, first);
    }

    #[inline(always)]
    fn add_behind(&self, point: usize, lanes: &mut Pulled<R, K::Carried>) {
        let fronts = (self.fronts.settled.as_slice(), self.fronts.carried.as_slice());
        self.neighbours.add_behind(&self.shared.lengths, fronts, self.place(point), lanes);
    }

    /// Returns the earlier of a front at a point and the fronts through parts of its obtuse triangles.
    #[inline(never)]
    fn through_parts(&self, point: usize, first: Option<K::Arrival>) -> Option<K::Arrival> {
        let on_surface = self.view.on_surface(point);
        let parts = self.shared.parts.iter().flat_map(|parts| parts.behind(on_surface));
        let arrivals = parts.filter_map(|part| self.through_part(on_surface, part));
        first.into_iter().chain(arrivals).reduce(K::Carried::earlier)
    }

    /// Returns the front that reaches a point of the surface through a part of an obtuse triangle, or `None` if no front
    /// at its other corners is final.
    pub(super) fn through_part(&self, point: usize, part: SplitPart<R>) -> Option<K::Arrival> {
        let ends = part.corners.map(|corner| self.view.here(corner));
        let is_final = ends.map(|end| self.fronts.is_final(end));
        if is_final == [false, false] {
            return None;
        }
        let fronts = [0, 1].map(|k| if is_final[k] { self.fronts.at(ends[k]) } else { none() });
        let ([a, b], [l1, l2, c]) = (fronts, part.lengths);
        let triangle = Triangle { t1: a.time, t2: b.time, l1, l2, c };
        let corners = [point, part.corners[0], part.corners[1]];
        Some(self.shared.kind.arrival_over(
            corners,
            triangle,
            [a.carried, b.carried],
            part.slowness,
        ))
    }

    /// Gives a point and its copies the first front that arrives there from earlier points.
    #[inline(always)]
    fn settle(&mut self, point: usize, first: Option<K::Arrival>) {
        let before = self.fronts.at(point);
        let state = self.states[point];
        let own = if state.is(State::SEED) { self.front_of_seed(point) } else { none() };
        let after = first.map_or(own, |first| K::Carried::accept(own, first, IN_ORDER, false));
        if state.is(State::COMPUTED) {
            if K::Carried::change(before, after) <= R::Bits::from(CHANGE) {
                self.finish(point, before);
                return;
            }
            self.call_back_after(point, before, after);
        }
        let time = after.time.wide();
        if time > self.shared.settings.limit.time() || self.queue.is_later(time) {
            self.postpone(point, after);
        } else {
            self.finish(point, after);
        }
    }

    /// Makes the front at a point and its copies final.
    #[inline(always)]
    fn finish(&mut self, point: usize, front: StoredFront<R, K::Carried>) {
        if self.shared.edges.copies().is_some() {
            self.each_copy(point, |solver, copy| solver.finish_one(copy, front));
        } else {
            self.finish_one(point, front);
        }
    }

    #[inline(always)]
    fn finish_one(&mut self, point: usize, front: StoredFront<R, K::Carried>) {
        self.fronts.set(point, front);
        self.fronts.settled[point] = front.time;
        self.states[point].set(State::COMPUTED);
        if self.states[point].is(State::SHARED) {
            self.news.push(point as u32);
        }
    }

    /// Lets a point wait again, since its front arrives later than the bucket in work or than the limit, or no longer.
    #[inline(never)]
    fn postpone(&mut self, point: usize, front: StoredFront<R, K::Carried>) {
        let waits = front.time < R::FAR;
        self.each_copy(point, |solver, copy| {
            solver.fronts.set(copy, front);
            solver.states[copy].clear(State::COMPUTED);
            solver.states[copy].set(if waits { State::WAITS } else { 0 });
        });
        if !waits {
            if self.states[point].is(State::SHARED) {
                self.news.push(point as u32);
            }
        } else if front.time.wide() > self.shared.settings.limit.time() {
            self.beyond.push(point as u32);
        } else {
            self.queue.push(point as u32, front.time.wide());
        }
    }

    #[inline(never)]
    fn front_of_seed(&self, point: usize) -> StoredFront<R, K::Carried> {
        let own = self.seeds.iter().filter(|&&(seed, _)| seed as usize == point);
        own.map(|&(_, front)| front).reduce(K::Carried::first).unwrap_or(none())
    }
}

//! Tells the neighbours of a point whose front is final: those that wait for it, and those that were final before it.

use super::BucketScanner;
use super::neighbours::{TOGETHER, bits};
use super::state::{State, StoredFronts};
use crate::fronts::{MOST, Pulled, TriangleFronts, TriangleKind};
use geosweep_surface::Real;
use geosweep_surface::update::StoredFront;

impl<R: Real, K: TriangleKind<R>> BucketScanner<R, K> {
    /// Passes on the front at a point, if it is final: points that are not final wait for the front along the edge.
    /// Adds the triangles to final points that the front may reach first.
    #[inline(always)]
    pub(super) fn pass_on(&mut self, point: usize, lanes: &mut Pulled<R, K::Carried>) {
        if !self.fronts.is_final(point) {
            return;
        }
        let StoredFronts { times, settled, .. } = &self.fronts;
        let place = self.place(point);
        let around = self.neighbours.later(&self.shared.lengths, [times, settled], place);
        for k in bits(around.waiting) {
            self.expect(self.neighbours.neighbour(place, k).here, around.by_edges[k]);
        }
        for k in bits(around.settled) {
            let other = self.neighbours.neighbour(place, k);
            if !self.states[other.here].is(State::FOREIGN) {
                let fronts = (self.fronts.settled.as_slice(), self.fronts.carried.as_slice());
                self.neighbours.add_beside(&self.shared.lengths, fronts, (other, k + 4), lanes);
            }
        }
        if self.shared.parts.is_some() {
            self.pass_on_through_parts(point);
        }
    }

    /// Passes on the front at all copies of a point. There may be more of them than lanes.
    #[inline(never)]
    pub(super) fn pass_on_copies(
        &mut self,
        point: usize,
        lanes: &mut Pulled<R, K::Carried>,
        arrivals: &mut [K::Arrival; MOST],
    ) {
        self.each_copy(point, |solver, copy| {
            solver.pass_on(copy, lanes);
            solver.call_back(lanes, arrivals);
        });
    }

    #[inline(never)]
    fn pass_on_through_parts(&mut self, point: usize) {
        let Some(parts) = self.shared.parts.take() else { return };
        let time = self.fronts.times[point];
        for (on_surface, part, length) in parts.beside(self.view.on_surface(point)) {
            let Some(to) = self.view.own(on_surface) else { continue };
            if self.fronts.times[to] <= time {
            } else if !self.fronts.is_final(to) {
                self.expect(to, time + length);
            } else if let Some(arrival) = self.through_part(on_surface, part) {
                self.call_back_if_first(to, arrival);
            }
        }
        self.shared.parts = Some(parts);
    }

    /// Lets a point whose front is not final wait for a front that arrives along an edge.
    #[inline(always)]
    fn expect(&mut self, point: usize, time: R) {
        let (before, state) = (self.fronts.times[point], self.states[point]);
        if state.is(State::COMPUTED | State::FOREIGN) || time >= before {
            return;
        }
        if self.shared.edges.copies().is_some() {
            self.each_copy(point, |solver, copy| solver.expect_one(copy, time));
        } else {
            self.expect_one(point, time);
        }
        let limit = self.shared.settings.limit.time();
        let [from, to] = [before.wide().min(limit), time.wide().min(limit)];
        self.states[point].set(State::WAITS);
        if before >= R::FAR || !self.queue.share(from, to) {
            self.queue.push(point as u32, to);
        }
    }

    #[inline(always)]
    fn expect_one(&mut self, point: usize, time: R) {
        if self.fronts.times[point] >= R::FAR {
            self.reached.push(point as u32);
        }
        self.fronts.times[point] = time;
    }

    /// Lets final points wait again that fronts reach first through triangles.
    #[inline(always)]
    pub(super) fn call_back(
        &mut self,
        lanes: &mut Pulled<R, K::Carried>,
        arrivals: &mut [K::Arrival; MOST],
    ) {
        if lanes.count == 0 {
            return;
        }
        self.triangles += lanes.count as u64;
        self.shared.kind.arrivals(lanes, arrivals);
        for (k, &arrival) in arrivals[..lanes.count].iter().enumerate() {
            self.call_back_if_first(self.view.here(lanes.corners[0][k] as usize), arrival);
        }
        lanes.count = 0;
    }

    #[inline(always)]
    fn call_back_if_first(&mut self, point: usize, arrival: K::Arrival) {
        let time = self.fronts.times[point];
        let together = time + time * R::of(TOGETHER) * R::epsilon();
        let arrival = K::Carried::time(arrival);
        if self.fronts.is_final(point) && arrival <= together {
            self.wait(point, if arrival < time { arrival } else { time });
        }
    }

    /// Lets all final points wait again that may depend on the front at a point, which changes.
    #[inline(never)]
    pub(super) fn call_back_after(
        &mut self,
        point: usize,
        before: StoredFront<R, K::Carried>,
        after: StoredFront<R, K::Carried>,
    ) {
        let delay = after.time - before.time;
        let mut dependent = Vec::new();
        self.each_copy(point, |solver, copy| {
            let StoredFronts { times, settled, .. } = &solver.fronts;
            let place = solver.place(copy);
            let around = solver.neighbours.later(&solver.shared.lengths, [times, settled], place);
            let neighbour =
                |k: usize| (solver.neighbours.neighbour(place, k).here, around.by_edges[k]);
            dependent.extend(bits(around.settled).map(neighbour));
            let parts = solver.shared.parts.iter().flat_map(|parts| parts.beside(place.on_surface));
            dependent.extend(
                parts.filter_map(|(to, _, length)| {
                    Some((solver.view.own(to)?, before.time + length))
                }),
            );
        });
        for (to, by_edge) in dependent {
            let time = self.fronts.times[to];
            let is_own = !self.states[to].is(State::FOREIGN);
            if is_own && self.fronts.is_final(to) && time > before.time {
                let arrival = by_edge + delay;
                self.wait(to, if arrival < time { arrival } else { time });
            }
        }
    }
}

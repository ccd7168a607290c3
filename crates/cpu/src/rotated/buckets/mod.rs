//! Solves point by point in the order of arrival times.
//!
//! Over a rough slowness rays turn in every cell, and scans in four directions have to be repeated many times. Here the
//! front at a point is computed when its time has come, mostly once, from the fronts at earlier points, which are final.
//! So it does not depend on the order of points. The queue has buckets of time instead of a total order: until a point's
//! front is computed, it waits in the bucket of the earliest front along an edge. When a point becomes final, neighbours
//! that are already final return to the queue if its front reaches them first. A batch of points is computed in SIMD
//! lanes (`fronts/pulled.rs`).

mod neighbours;
mod parts;
mod queue;

use std::sync::Arc;

use self::neighbours::{Later, Lengths, Neighbours, TOGETHER, lengths_of};
use self::parts::PartsAround;
use self::queue::Buckets;
use super::prepared::Settings;
use super::scans::Scans;
use crate::Instructions;
use crate::fronts::{BATCH, Fronts, MOST, Pulled, TriangleFronts, TriangleKind};
use crate::limit::Limit;
use geosweep_surface::lanes::Loop;
use geosweep_surface::update::{StoredFront, Triangle};
use geosweep_surface::{Block, Convergence, EdgeLengths, Monitor, Real, Seed, SplitPart, Stop};

/// A solver for one kind of front; see [`crate::RotatedScan`].
#[derive(Clone, Debug)]
pub(crate) struct BucketScanner<R: Real, K: TriangleKind<R>> {
    edges: EdgeLengths<R>,
    kind: K,
    settings: Settings,
    neighbours: Neighbours,
    lengths: Arc<Lengths<R>>,
    parts: Option<PartsAround<R>>,
    fronts: StoredFronts<R, K::Carried>,
    states: Vec<State>,
    queue: Buckets,
    /// Points whose fronts arrive after the limit.
    beyond: Vec<u32>,
    /// The seeds' own fronts.
    seeds: Vec<(u32, StoredFront<R, K::Carried>)>,
    /// The points that have been reached.
    reached: Vec<u32>,
    /// Numbers of points whose fronts have been computed, and of triangles that this took.
    taken: u64,
    triangles: u64,
}

/// Fronts at all points, as bordered arrays. At a point that waits for the first time, only the arrival time along an
/// edge is known.
#[derive(Clone, Debug)]
struct StoredFronts<R, C> {
    times: Vec<R>,
    carried: Vec<C>,
}

impl<R: Real, C: Copy> StoredFronts<R, C> {
    #[inline(always)]
    fn at(&self, point: usize) -> StoredFront<R, C> {
        StoredFront { time: self.times[point], carried: self.carried[point] }
    }

    fn set(&mut self, point: usize, front: StoredFront<R, C>) {
        (self.times[point], self.carried[point]) = (front.time, front.carried);
    }
}

/// What is known of a point, as bits.
#[derive(Clone, Copy, Debug, Default)]
struct State(u8);

impl State {
    /// The point's front is final, as far as is known.
    const FINAL: u8 = 1;
    /// The point waits in the queue.
    const WAITS: u8 = 2;
    /// The point's front has been computed. It may have been final and wait again.
    const COMPUTED: u8 = 4;
    /// A seed is at the point.
    const SEED: u8 = 8;

    #[inline(always)]
    fn is(self, bits: u8) -> bool {
        self.0 & bits != 0
    }

    #[inline(always)]
    fn is_final(self) -> bool {
        self.is(Self::FINAL)
    }

    #[inline(always)]
    fn set(&mut self, bits: u8) {
        self.0 |= bits;
    }

    #[inline(always)]
    fn clear(&mut self, bits: u8) {
        self.0 &= !bits;
    }
}

/// Scan number of fronts that are computed in the order of time. No scan renews them.
const IN_ORDER: u8 = 1;

/// Least change of a front after which points that depend on it are computed again, in units of the rounding of its time.
const CHANGE: u32 = 2;

/// Largest number of targets whose times are read after each bucket. More targets are read after [`SELDOM`] buckets.
const FEW_TARGETS: usize = 16;
const SELDOM: u64 = 16;

/// Mean number of computations of a point after which a map counts as one that does not converge.
const MOST_COMPUTED: u64 = 64;

impl<R: Real, K: TriangleKind<R>> BucketScanner<R, K> {
    pub(crate) fn new(edges: &EdgeLengths<R>, kind: K) -> Self {
        let chart = edges.chart();
        let points = chart.bordered_points();
        let settings = Settings {
            limit: Limit::NONE,
            instructions: Instructions::best(),
            monitor: Monitor::default(),
        };
        Self {
            edges: edges.clone(),
            parts: PartsAround::of(edges),
            kind,
            settings,
            neighbours: Neighbours::new(chart),
            lengths: Arc::new(lengths_of(edges)),
            fronts: StoredFronts {
                times: vec![R::FAR; points],
                carried: vec![K::Carried::default(); points],
            },
            states: vec![State::default(); points],
            queue: Buckets::new(width(edges)),
            beyond: Vec::new(),
            seeds: Vec::new(),
            reached: Vec::new(),
            taken: 0,
            triangles: 0,
        }
    }

    /// Resets all points to unreached.
    fn forget(&mut self) {
        self.kind.forget();
        for &point in &self.reached {
            self.fronts.set(point as usize, none());
            self.states[point as usize] = State::default();
        }
        self.reached.clear();
        self.seeds.clear();
        self.beyond.clear();
        self.queue.clear();
        (self.taken, self.triangles) = (0, 0);
    }

    fn seed(&mut self, seeds: &[Seed]) {
        let mut started = Vec::new();
        let (reached, times) = (&mut self.reached, self.fronts.times.as_mut_slice());
        let fronts = (times, self.fronts.carried.as_mut_slice());
        self.kind.start(self.edges.chart(), seeds, fronts, |_, point, [before, after]| {
            if before.time >= R::FAR {
                reached.push(point as u32);
            }
            if after != before {
                started.push((point, after));
            }
        });
        for (point, front) in started {
            self.each_copy(point, |solver, copy| {
                if solver.fronts.times[copy] >= R::FAR {
                    solver.reached.push(copy as u32);
                }
                if copy == point || front.time < solver.fronts.times[copy] {
                    solver.fronts.set(copy, front);
                }
                solver.states[copy].set(State::SEED);
                solver.seeds.push((copy as u32, front));
            });
            self.wait(point, front.time);
        }
    }

    /// Calls `visit` with all copies of a point, on a glued surface, including the point itself.
    fn each_copy(&mut self, point: usize, mut visit: impl FnMut(&mut Self, usize)) {
        match self.edges.clone().copies().and_then(|copies| copies.around(point)) {
            Some(copies) => copies.iter().for_each(|&copy| visit(self, copy as usize)),
            None => visit(self, point),
        }
    }

    /// Lets a point and its copies wait in the queue for a front that arrives at a time.
    fn wait(&mut self, point: usize, time: R) {
        if self.edges.copies().is_none() {
            self.states[point].clear(State::FINAL);
            self.states[point].set(State::WAITS);
        } else {
            self.each_copy(point, |solver, copy| {
                solver.states[copy].clear(State::FINAL);
                solver.states[copy].set(State::WAITS);
            });
        }
        self.queue.push(point as u32, time.wide().min(self.settings.limit.time()));
    }

    /// Computes the fronts of points until none waits, up to the limit.
    fn run(&mut self) -> Convergence {
        let targets = self.settings.limit.targets().len();
        let (mut lanes, mut arrivals) = (Box::new(Pulled::new()), None);
        let (mut buckets, mut residual) = (0u64, 0.0);
        loop {
            let instructions = self.settings.instructions;
            instructions.run(Bucket {
                solver: &mut *self,
                lanes: &mut lanes,
                arrivals: &mut arrivals,
            });
            buckets += 1;
            if targets > 0 && (targets <= FEW_TARGETS || buckets.is_multiple_of(SELDOM)) {
                self.lower_limit();
            }
            let (times, states) = (&self.fronts.times, &self.states);
            let limit = self.settings.limit.time();
            let key = |point: u32| waiting(times, states, limit, point);
            if !self.queue.advance(key) || self.queue.time() > limit {
                break;
            }
            if buckets.is_multiple_of(SELDOM) && self.settings.monitor.is_cancelled() {
                break;
            }
            if self.taken > MOST_COMPUTED * (self.reached.len() as u64 + 1000) {
                residual = f64::INFINITY;
                break;
            }
        }
        self.settings.monitor.note(1, residual);
        Convergence { iterations: 1, residual }
    }

    /// Lowers the limit to the time of the targets, once their fronts are final.
    fn lower_limit(&mut self) {
        let (chart, before) = (self.edges.chart(), self.settings.limit.time());
        let (times, states) = (&self.fronts.times, &self.states);
        self.settings.limit.lower(|[row, col]| {
            let point = chart.bordered(row, col);
            if states[point].is_final() { times[point].wide() } else { geosweep_surface::FAR }
        });
        if self.settings.limit.time() < before {
            self.requeue_waiting();
        }
    }

    /// Sorts all points that wait into buckets again.
    fn requeue_waiting(&mut self) {
        let (times, states) = (&self.fronts.times, &self.states);
        let limit = self.settings.limit.time();
        self.queue.restart(|point| waiting(times, states, limit, point));
    }

    /// Computes the fronts at up to [`BATCH`] points of the bucket in work, and passes them on. Returns whether there
    /// were any.
    #[inline(always)]
    fn run_batch(
        &mut self,
        lanes: &mut Pulled<R, K::Carried>,
        arrivals: &mut Option<[K::Arrival; MOST]>,
    ) -> bool {
        let (mut batch, mut count) = ([0; BATCH], 0);
        while count < BATCH {
            let Some(point) = self.queue.take() else { break };
            if let Some(ahead) = self.queue.ahead(2 * BATCH) {
                self.neighbours.prefetch(&self.lengths, &self.fronts.times, ahead as usize);
            }
            let point = point as usize;
            if self.states[point].is(State::WAITS) {
                self.states[point].clear(State::WAITS);
                batch[count] = point;
                count += 1;
            }
        }
        let batch = &batch[..count];
        let arrivals = arrivals.get_or_insert([K::Carried::arrival_of_front(none()); MOST]);
        if self.edges.copies().is_some() {
            batch.iter().for_each(|&point| self.compute_copies(point, lanes, arrivals));
        } else {
            self.compute(batch, lanes, arrivals);
        }
        lanes.count = 0;
        for &point in batch {
            if self.edges.copies().is_some() {
                self.pass_on_copies(point, lanes, arrivals);
            } else {
                self.pass_on(point, lanes);
            }
        }
        self.call_back(lanes, arrivals);
        self.taken += count as u64;
        count > 0
    }

    /// Computes the fronts at points.
    #[inline(always)]
    fn compute(
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
        self.kind.arrivals(lanes, arrivals);
        let mut start = 0;
        for (&point, &end) in batch.iter().zip(&ends) {
            let mut first: Option<K::Arrival> = None;
            for &arrival in &arrivals[start..end] {
                first = Some(first.map_or(arrival, |first| K::Carried::earlier(first, arrival)));
            }
            start = end;
            if self.parts.is_some() {
                first = self.through_parts(point, first);
            }
            self.settle(point, first);
        }
    }

    /// Computes the front at all copies of a point.
    #[inline(never)]
    fn compute_copies(
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
            solver.kind.arrivals(lanes, arrivals);
            for &arrival in &arrivals[..lanes.count] {
                first = Some(first.map_or(arrival, |first| K::Carried::earlier(first, arrival)));
            }
            if solver.parts.is_some() {
                first = solver.through_parts(copy, first);
            }
        });
        self.settle(point, first);
    }

    #[inline(always)]
    fn add_behind(&self, point: usize, lanes: &mut Pulled<R, K::Carried>) {
        let fronts = (self.fronts.times.as_slice(), self.fronts.carried.as_slice());
        let states = (self.states.as_slice(), State::is_final);
        self.neighbours.add_behind(&self.lengths, fronts, states, point, lanes);
    }

    /// Returns the earlier of a front at a point and the fronts through parts of its obtuse triangles.
    #[inline(never)]
    fn through_parts(&self, point: usize, mut first: Option<K::Arrival>) -> Option<K::Arrival> {
        let parts = self.parts.iter().flat_map(|parts| parts.behind(point));
        for part in parts {
            let Some(arrival) = self.through_part(point, part) else { continue };
            first = Some(first.map_or(arrival, |first| K::Carried::earlier(first, arrival)));
        }
        first
    }

    /// Returns the front that reaches a point through a part of an obtuse triangle, or `None` if no front at its other
    /// corners is final.
    fn through_part(&self, point: usize, part: SplitPart<R>) -> Option<K::Arrival> {
        let is_final = part.corners.map(|corner| self.states[corner].is_final());
        if is_final == [false, false] {
            return None;
        }
        let fronts =
            [0, 1].map(|k| if is_final[k] { self.fronts.at(part.corners[k]) } else { none() });
        let ([a, b], [l1, l2, c]) = (fronts, part.lengths);
        let triangle = Triangle { t1: a.time, t2: b.time, l1, l2, c };
        let corners = [point, part.corners[0], part.corners[1]];
        Some(self.kind.arrival_over(corners, triangle, [a.carried, b.carried], part.slowness))
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
        if time > self.settings.limit.time() || self.queue.is_later(time) {
            self.postpone(point, after);
        } else {
            self.finish(point, after);
        }
    }

    /// Makes the front at a point and its copies final.
    #[inline(always)]
    fn finish(&mut self, point: usize, front: StoredFront<R, K::Carried>) {
        if self.edges.copies().is_some() {
            self.each_copy(point, |solver, copy| solver.finish_one(copy, front));
        } else {
            self.finish_one(point, front);
        }
    }

    #[inline(always)]
    fn finish_one(&mut self, point: usize, front: StoredFront<R, K::Carried>) {
        self.fronts.set(point, front);
        self.states[point].set(State::FINAL | State::COMPUTED);
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
        } else if front.time.wide() > self.settings.limit.time() {
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

    /// Passes on the front at a point, if it is final: points that are not final wait for the front along the edge.
    /// Adds the triangles to final points that the front may reach first.
    #[inline(always)]
    fn pass_on(&mut self, point: usize, lanes: &mut Pulled<R, K::Carried>) {
        if !self.states[point].is_final() {
            return;
        }
        let (later, count) = self.neighbours.later(&self.lengths, &self.fronts.times, point);
        for &Later { point: to, number, by_edge } in &later[..count] {
            if self.states[to].is_final() {
                let fronts = (self.fronts.times.as_slice(), self.fronts.carried.as_slice());
                let states = (self.states.as_slice(), State::is_final);
                self.neighbours.add_beside(&self.lengths, fronts, states, [to, number], lanes);
            } else {
                self.expect(to, by_edge);
            }
        }
        if self.parts.is_some() {
            self.pass_on_through_parts(point);
        }
    }

    /// Passes on the front at all copies of a point. There may be more of them than lanes.
    #[inline(never)]
    fn pass_on_copies(
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
        let Some(parts) = self.parts.take() else { return };
        let time = self.fronts.times[point];
        for (to, part, length) in parts.beside(point) {
            if self.fronts.times[to] <= time {
            } else if !self.states[to].is_final() {
                self.expect(to, time + length);
            } else if let Some(arrival) = self.through_part(to, part) {
                self.call_back_if_first(to, arrival);
            }
        }
        self.parts = Some(parts);
    }

    /// Lets a point whose front is not final wait for a front that arrives along an edge.
    #[inline(always)]
    fn expect(&mut self, point: usize, time: R) {
        let (before, state) = (self.fronts.times[point], self.states[point]);
        if state.is(State::COMPUTED) || time >= before {
            return;
        }
        if self.edges.copies().is_some() {
            self.each_copy(point, |solver, copy| solver.expect_one(copy, time));
        } else {
            self.expect_one(point, time);
        }
        let limit = self.settings.limit.time();
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
    fn call_back(&mut self, lanes: &mut Pulled<R, K::Carried>, arrivals: &mut [K::Arrival; MOST]) {
        if lanes.count == 0 {
            return;
        }
        self.triangles += lanes.count as u64;
        self.kind.arrivals(lanes, arrivals);
        for (k, &arrival) in arrivals[..lanes.count].iter().enumerate() {
            self.call_back_if_first(lanes.corners[0][k] as usize, arrival);
        }
        lanes.count = 0;
    }

    #[inline(always)]
    fn call_back_if_first(&mut self, point: usize, arrival: K::Arrival) {
        let time = self.fronts.times[point];
        let together = time + time * R::of(TOGETHER) * R::epsilon();
        let arrival = K::Carried::time(arrival);
        if self.states[point].is_final() && arrival <= together {
            self.wait(point, if arrival < time { arrival } else { time });
        }
    }

    /// Lets all final points wait again that may depend on the front at a point, which changes.
    #[inline(never)]
    fn call_back_after(
        &mut self,
        point: usize,
        before: StoredFront<R, K::Carried>,
        after: StoredFront<R, K::Carried>,
    ) {
        let delay = after.time - before.time;
        let mut dependent = Vec::new();
        self.each_copy(point, |solver, copy| {
            let times = &solver.fronts.times;
            let (later, count) = solver.neighbours.later(&solver.lengths, times, copy);
            dependent.extend(later[..count].iter().map(|later| (later.point, later.by_edge)));
            let parts = solver.parts.iter().flat_map(|parts| parts.beside(copy));
            dependent.extend(parts.map(|(to, _, length)| (to, before.time + length)));
        });
        for (to, by_edge) in dependent {
            let time = self.fronts.times[to];
            if self.states[to].is_final() && time > before.time {
                let arrival = by_edge + delay;
                self.wait(to, if arrival < time { arrival } else { time });
            }
        }
    }
}

/// Returns the front at a point that none has reached.
fn none<R: Real, C: Default>() -> StoredFront<R, C> {
    StoredFront { time: R::FAR, carried: C::default() }
}

/// Returns the time of a point in the queue, or `None` if it does not wait.
fn waiting<R: Real>(times: &[R], states: &[State], limit: f64, point: u32) -> Option<f64> {
    let point = point as usize;
    states[point].is(State::WAITS).then(|| times[point].wide().min(limit))
}

/// Returns the time that a bucket spans: half the harmonic mean of the costs of edges along rows and columns. Wider
/// buckets bring points out of order, narrower ones cost more than they save.
fn width<R: Real>(edges: &EdgeLengths<R>) -> f64 {
    let [east, north, ..] = edges.planes();
    let (mut sum, mut total, mut count) = (0.0, 0.0, 0u64);
    for length in east.iter().chain(north).map(|length| length.wide()) {
        if length < geosweep_surface::FAR {
            sum += length.recip();
            total += length;
            count += 1;
        }
    }
    if count == 0 {
        return 1.0;
    }
    let (harmonic, mean) = (count as f64 / sum, total / count as f64);
    (0.5 * harmonic).max(mean * LEAST_WIDTH)
}

/// Least width of a bucket, as a part of the mean cost of edges. Where travel is free on a part of the surface, the
/// harmonic mean is close to zero.
const LEAST_WIDTH: f64 = 1e-3;

/// The bucket in work, whose points' fronts are computed.
struct Bucket<'a, R: Real, K: TriangleKind<R>> {
    solver: &'a mut BucketScanner<R, K>,
    lanes: &'a mut Pulled<R, K::Carried>,
    arrivals: &'a mut Option<[K::Arrival; MOST]>,
}

impl<R: Real, K: TriangleKind<R>> Loop for Bucket<'_, R, K> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        while self.solver.run_batch(self.lanes, self.arrivals) {}
    }
}

impl<R: Real, K: TriangleKind<R>> Scans<R> for BucketScanner<R, K> {
    fn solve(&mut self, seeds: &[Seed], _: Stop) -> Convergence {
        self.forget();
        self.seed(seeds);
        self.run()
    }

    fn add(&mut self, seeds: &[Seed], _: Stop) -> Convergence {
        for &point in &self.reached {
            let carried = &mut self.fronts.carried[point as usize];
            *carried = carried.released();
        }
        for (_, front) in &mut self.seeds {
            front.carried = front.carried.released();
        }
        self.requeue_waiting();
        self.seed(seeds);
        self.run()
    }

    fn go_on(&mut self, _: &[Seed], _: Stop, limit: Limit) -> Option<Convergence> {
        self.settings.limit = limit;
        self.requeue_waiting();
        for point in std::mem::take(&mut self.beyond) {
            let (point, time) = (point as usize, self.fronts.times[point as usize].wide());
            if self.states[point].is(State::WAITS) {
                self.queue.push(point as u32, time);
            }
        }
        let any = self.queue.has_points();
        any.then(|| self.run())
    }

    fn used(&self) -> Vec<Block> {
        let chart = self.edges.chart();
        let places = self.reached.iter().map(|&point| chart.bordered_position(point as usize));
        places.map(|(row, col)| Block { rows: row..row + 1, cols: col..col + 1 }).collect()
    }

    fn settings(&mut self) -> &mut Settings {
        &mut self.settings
    }

    fn times(&self) -> &[R] {
        &self.fronts.times
    }

    fn into_times(self: Box<Self>) -> Vec<R> {
        self.fronts.times
    }

    fn visits(&self) -> u64 {
        self.taken
    }

    fn updates(&self) -> u64 {
        self.triangles
    }

    fn bytes(&self) -> usize {
        size_of_val(self.fronts.times.as_slice())
            + size_of_val(self.fronts.carried.as_slice())
            + self.states.len()
            + size_of_val(self.lengths.as_slice())
            + size_of_val(self.reached.as_slice())
            + self.parts.as_ref().map_or(0, PartsAround::bytes)
    }

    fn is_in_order_of_time(&self) -> bool {
        true
    }

    fn boxed(&self) -> Box<dyn Scans<R>> {
        Box::new(self.clone())
    }
}

//! Solves point by point in the order of arrival times.
//!
//! Over a rough slowness rays turn in every cell, and scans in four directions have to be repeated many times. Here the
//! front at a point is computed when its time has come, mostly once, from the fronts at earlier points, which are final.
//! So it does not depend on the order of points. The queue has buckets of time instead of a total order: until a point's
//! front is computed, it waits in the bucket of the earliest front along an edge. When a point becomes final, neighbours
//! that are already final return to the queue if its front reaches them first. A batch of points is computed in SIMD
//! lanes (`fronts/pulled.rs`).

mod compute;
mod in_patches;
mod neighbours;
mod pass_on;
mod queue;
mod state;
mod view;

use std::sync::Arc;

use self::in_patches::Told;
pub(super) use self::in_patches::in_order_of_time;
use self::neighbours::{Lengths, Neighbours, Place, lengths_of};
use self::queue::{Buckets, width};
use self::state::{State, StoredFronts, none, waiting};
use self::view::View;
use super::prepared::Settings;
use super::scans::Scans;
use crate::Instructions;
use crate::fronts::{BATCH, Fronts, MOST, Pulled, TriangleKind, prefetch_rows};
use crate::limit::Limit;
use geosweep_surface::lanes::Loop;
use geosweep_surface::update::{StoredFront, tag_of};
use geosweep_surface::{Block, Convergence, EdgeLengths, Monitor, PartsAround, Real, Seed, Stop};

/// A solver for one kind of front; see [`crate::RotatedScan`].
#[derive(Clone, Debug)]
pub(crate) struct BucketScanner<R: Real, K: TriangleKind<R>> {
    shared: Shared<R, K>,
    view: View,
    neighbours: Neighbours,
    fronts: StoredFronts<R, K::Carried>,
    states: Vec<State>,
    queue: Buckets,
    /// Points whose fronts arrive after the limit.
    beyond: Vec<u32>,
    /// The seeds' own fronts.
    seeds: Vec<(u32, StoredFront<R, K::Carried>)>,
    /// The points that have been reached.
    reached: Vec<u32>,
    /// Points that other patches see and whose fronts have changed.
    news: Vec<u32>,
    /// Numbers of points whose fronts have been computed, and of triangles that this took.
    taken: u64,
    triangles: u64,
}

/// Largest number of targets whose times are read after each bucket. More targets are read after [`SELDOM`] buckets.
const FEW_TARGETS: usize = 16;
const SELDOM: u64 = 16;

/// Number of buckets ahead of the one in work whose points are not sorted again.
const BUCKETS: usize = 1 << 11;

/// Mean number of computations of a point after which a map counts as one that does not converge.
const MOST_COMPUTED: u64 = 64;

/// The data of a surface that the solvers of all its patches share.
#[derive(Clone, Debug)]
struct Shared<R: Real, K> {
    edges: EdgeLengths<R>,
    kind: K,
    settings: Settings,
    lengths: Arc<Lengths<R>>,
    parts: Option<Arc<PartsAround<R>>>,
    /// The time that a bucket spans.
    width: f64,
}

impl<R: Real, K> Shared<R, K> {
    fn new(edges: &EdgeLengths<R>, kind: K) -> Self {
        Self {
            edges: edges.clone(),
            kind,
            settings: Settings {
                limit: Limit::NONE,
                instructions: Instructions::best(),
                monitor: Monitor::default(),
            },
            lengths: Arc::new(lengths_of(edges)),
            parts: PartsAround::of(edges).map(Arc::new),
            width: width(edges),
        }
    }

    fn bytes(&self) -> usize {
        size_of_val(self.lengths.as_slice()) + self.parts.as_ref().map_or(0, |parts| parts.bytes())
    }
}

impl<R: Real, K: TriangleKind<R>> BucketScanner<R, K> {
    fn new(shared: Shared<R, K>) -> Self {
        let view = View::whole(shared.edges.chart());
        Self::of(shared, view, BUCKETS)
    }

    /// Returns a solver for the points of a view, with a queue of `buckets` buckets.
    fn of(shared: Shared<R, K>, view: View, buckets: usize) -> Self {
        let points = view.layout().bordered_points();
        Self {
            neighbours: Neighbours::new(shared.edges.chart(), view.layout()),
            queue: Buckets::new(shared.width, buckets),
            shared,
            view,
            fronts: StoredFronts {
                times: vec![R::FAR; points],
                carried: vec![K::Carried::default(); points],
                settled: vec![R::FAR; points],
            },
            states: vec![State::default(); points],
            beyond: Vec::new(),
            seeds: Vec::new(),
            reached: Vec::new(),
            news: Vec::new(),
            taken: 0,
            triangles: 0,
        }
    }

    /// Resets all points to unreached.
    fn forget(&mut self) {
        self.shared.kind.forget();
        for &point in &self.reached {
            self.fronts.set(point as usize, none());
            self.fronts.settled[point as usize] = R::FAR;
            self.states[point as usize].clear(State::WAITS | State::COMPUTED | State::SEED);
        }
        self.reached.clear();
        self.seeds.clear();
        self.beyond.clear();
        self.queue.clear();
        (self.taken, self.triangles) = (0, 0);
    }

    /// Prepares the map for fronts of new sources: they replace those of exact seeds too.
    fn release(&mut self) {
        for &point in &self.reached {
            let carried = &mut self.fronts.carried[point as usize];
            *carried = carried.released();
        }
        for (_, front) in &mut self.seeds {
            front.carried = front.carried.released();
        }
        self.requeue_waiting();
    }

    fn seed(&mut self, seeds: &[Seed]) {
        self.shared.kind.expect(seeds);
        for seed in seeds {
            let arrival = self.shared.kind.arrival_of_seed(seed);
            self.plant(self.view.at((seed.row, seed.col)), arrival, tag_of(seed));
        }
    }

    /// Starts the front of a seed, unless the present front at its point and copies is kept.
    fn plant(&mut self, point: usize, arrival: K::Arrival, tag: u8) {
        let before = self.fronts.at(point);
        let front = K::Carried::accept(before, arrival, tag, false);
        if front == before {
            return;
        }
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

    /// Returns the number of bytes held, without what patches share.
    fn own_bytes(&self) -> usize {
        size_of_val(self.fronts.times.as_slice())
            + size_of_val(self.fronts.settled.as_slice())
            + size_of_val(self.fronts.carried.as_slice())
            + self.states.len()
            + size_of_val(self.reached.as_slice())
            + self.view.bytes()
    }

    /// Returns a point with its index on the surface.
    #[inline(always)]
    fn place(&self, point: usize) -> Place {
        Place { here: point, on_surface: self.view.on_surface(point) }
    }

    /// Calls `visit` with all copies of a point, on a glued surface, including the point itself.
    fn each_copy(&mut self, point: usize, mut visit: impl FnMut(&mut Self, usize)) {
        match self.shared.edges.clone().copies().and_then(|copies| copies.around(point)) {
            Some(copies) => copies.iter().for_each(|&copy| visit(self, copy as usize)),
            None => visit(self, point),
        }
    }

    /// Lets a point and its copies wait in the queue for a front that arrives at a time.
    fn wait(&mut self, point: usize, time: R) {
        if self.shared.edges.copies().is_none() {
            self.fronts.settled[point] = R::FAR;
            self.states[point].set(State::WAITS);
        } else {
            self.each_copy(point, |solver, copy| {
                solver.fronts.settled[copy] = R::FAR;
                solver.states[copy].set(State::WAITS);
            });
        }
        self.queue.push(point as u32, time.wide().min(self.shared.settings.limit.time()));
    }

    /// Computes the fronts of points until none waits, up to the limit.
    fn run(&mut self) -> Convergence {
        let targets = self.shared.settings.limit.targets().len();
        let mut lanes = Box::new(Pulled::new());
        let mut arrivals = [K::Carried::arrival_of_front(none()); MOST];
        let (mut buckets, mut residual) = (0u64, 0.0);
        loop {
            let instructions = self.shared.settings.instructions;
            instructions.run(Round {
                solver: &mut *self,
                lanes: &mut lanes,
                arrivals: &mut arrivals,
                told: &[],
                until: None,
            });
            buckets += 1;
            if targets > 0 && (targets <= FEW_TARGETS || buckets.is_multiple_of(SELDOM)) {
                self.lower_limit();
            }
            if !self.advance(f64::INFINITY) || self.queue.time() > self.shared.settings.limit.time()
            {
                break;
            }
            if buckets.is_multiple_of(SELDOM) && self.shared.settings.monitor.is_cancelled() {
                break;
            }
            if self.taken > MOST_COMPUTED * (self.reached.len() as u64 + 1000) {
                residual = f64::INFINITY;
                break;
            }
        }
        self.shared.settings.monitor.note(1, residual);
        Convergence { iterations: 1, residual }
    }

    /// Goes on to the next bucket, not beyond a time. Returns whether there is one.
    fn advance(&mut self, until: f64) -> bool {
        let (times, states) = (&self.fronts.times, &self.states);
        let limit = self.shared.settings.limit.time();
        self.queue.advance(until, |point| waiting(times, states, limit, point))
    }

    /// Lowers the limit to the time of the targets, once their fronts are final.
    fn lower_limit(&mut self) {
        let before = self.shared.settings.limit.time();
        let (view, settled) = (&self.view, &self.fronts.settled);
        self.shared.settings.limit.lower(|[row, col]| settled[view.at((row, col))].wide());
        if self.shared.settings.limit.time() < before {
            self.requeue_waiting();
        }
    }

    /// Sorts points that wait into buckets again, up to a later limit.
    fn go_on_to(&mut self, limit: Limit) {
        self.shared.settings.limit = limit;
        self.requeue_waiting();
        for point in std::mem::take(&mut self.beyond) {
            let (point, time) = (point as usize, self.fronts.times[point as usize].wide());
            if self.states[point].is(State::WAITS) {
                self.queue.push(point as u32, time);
            }
        }
    }

    /// Sorts all points that wait into buckets again.
    fn requeue_waiting(&mut self) {
        let (times, states) = (&self.fronts.times, &self.states);
        let limit = self.shared.settings.limit.time();
        self.queue.restart(|point| waiting(times, states, limit, point));
    }

    /// Computes the fronts at up to [`BATCH`] points of the bucket in work, and passes them on. Returns whether there
    /// were any.
    #[inline(always)]
    fn run_batch(
        &mut self,
        lanes: &mut Pulled<R, K::Carried>,
        arrivals: &mut [K::Arrival; MOST],
    ) -> bool {
        let (mut batch, mut count) = ([0; BATCH], 0);
        while count < BATCH {
            let Some(point) = self.queue.take() else { break };
            if let Some(ahead) = self.queue.ahead(2 * BATCH) {
                let [rows, on_surface] = self.neighbours.rows_of(self.place(ahead as usize));
                prefetch_rows(&self.shared.lengths, on_surface);
                prefetch_rows(&self.fronts.times, rows);
                prefetch_rows(&self.fronts.settled, rows);
                prefetch_rows(&self.fronts.carried, rows);
                self.shared.kind.prefetch(on_surface);
            }
            let point = point as usize;
            if self.states[point].is(State::WAITS) {
                self.states[point].clear(State::WAITS);
                batch[count] = point;
                count += 1;
            }
        }
        let batch = &batch[..count];
        if self.shared.edges.copies().is_some() {
            batch.iter().for_each(|&point| self.compute_copies(point, lanes, arrivals));
        } else {
            self.compute(batch, lanes, arrivals);
        }
        lanes.count = 0;
        for &point in batch {
            if self.shared.edges.copies().is_some() {
                self.pass_on_copies(point, lanes, arrivals);
            } else {
                self.pass_on(point, lanes);
            }
        }
        self.call_back(lanes, arrivals);
        self.taken += count as u64;
        count > 0
    }
}

/// Computes the fronts of the points that wait in the bucket in work, and in all buckets up to a time if one is given.
struct Round<'a, R: Real, K: TriangleKind<R>> {
    solver: &'a mut BucketScanner<R, K>,
    lanes: &'a mut Pulled<R, K::Carried>,
    arrivals: &'a mut [K::Arrival; MOST],
    /// Fronts that have come to points around a patch.
    told: &'a [Told<R, K::Carried>],
    until: Option<f64>,
}

impl<R: Real, K: TriangleKind<R>> Loop for Round<'_, R, K> {
    type Output = ();
    const AVX512: bool = K::AVX512;

    #[inline(always)]
    fn run(self) {
        let Self { solver, lanes, arrivals, told, until } = self;
        for &told in told {
            solver.hear(told, lanes, arrivals);
        }
        loop {
            while solver.run_batch(lanes, arrivals) {}
            if !until.is_some_and(|until| solver.advance(until)) {
                break;
            }
        }
    }
}

impl<R: Real, K: TriangleKind<R>> Scans<R> for BucketScanner<R, K> {
    fn solve(&mut self, seeds: &[Seed], _: Stop) -> Convergence {
        self.forget();
        self.seed(seeds);
        self.run()
    }

    fn add(&mut self, seeds: &[Seed], _: Stop) -> Convergence {
        self.release();
        self.seed(seeds);
        self.run()
    }

    fn go_on(&mut self, _: &[Seed], _: Stop, limit: Limit) -> Option<Convergence> {
        self.go_on_to(limit);
        let any = self.queue.has_points();
        any.then(|| self.run())
    }

    fn used(&self) -> Vec<Block> {
        let chart = self.shared.edges.chart();
        let places = self.reached.iter().map(|&point| chart.bordered_position(point as usize));
        places.map(|(row, col)| Block { rows: row..row + 1, cols: col..col + 1 }).collect()
    }

    fn settings(&mut self) -> &mut Settings {
        &mut self.shared.settings
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
        self.own_bytes() + self.shared.bytes()
    }

    fn is_in_order_of_time(&self) -> bool {
        true
    }

    fn boxed(&self) -> Box<dyn Scans<R>> {
        Box::new(self.clone())
    }
}

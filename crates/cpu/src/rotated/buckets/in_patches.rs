//! Solves in the order of time by patches of the surface, on all threads.
//!
//! Each patch has a queue of its own, and copies of the fronts at the points around it. In a round, all patches in which
//! fronts move solve up to the same time. Then they tell each other the fronts along their borders. Rounds are short
//! against the time in which a front crosses a patch, so that few points have been computed without a front that comes
//! from a neighbour in the same round; these are computed again. The map is that of a single queue, up to rounding, and
//! the same for any number of threads.

use rayon::prelude::*;

use super::state::{State, none};
use super::view::View;
use super::{BucketScanner, MOST_COMPUTED, Round, Shared};
use crate::fronts::{Fronts, MOST, Pulled, TriangleKind};
use crate::limit::Limit;
use crate::rotated::prepared::Settings;
use crate::rotated::scans::{PatchCounts, Scans};
use geosweep_surface::update::{StoredFront, tag_of};
use geosweep_surface::{Block, Chart, Convergence, EdgeLengths, Real, Seed, Stop, Tiling};

/// Number of buckets of a round: the time of about two edges. With 16 buckets 1.05 to 1.6 points are computed for each
/// point of the surface.
const ROUND: f64 = 4.0;

/// Number of buckets of a patch whose points are not sorted again.
const BUCKETS: usize = 1 << 8;

/// Returns a solver in the order of time: with one queue, or by patches of `side` points a side. On a glued surface the
/// copies of a point would lie in different patches, so it has one queue; and so have surfaces whose obtuse triangles are
/// split by points farther away than an eighth of a side.
pub(in crate::rotated) fn in_order_of_time<R: Real, K: TriangleKind<R>>(
    edges: &EdgeLengths<R>,
    kind: K,
    side: Option<usize>,
) -> Box<dyn Scans<R>> {
    let shared = Shared::new(edges, kind);
    let has_patches = |side: &usize| edges.copies().is_none() && 8 * edges.reach() <= *side;
    match side.filter(has_patches) {
        Some(side) => Box::new(PatchedBuckets::new(shared, side)),
        None => Box::new(BucketScanner::new(shared)),
    }
}

/// The front at a point of the surface, for a patch that sees the point.
#[derive(Clone, Copy, Debug)]
pub(super) struct Told<R, C> {
    on_surface: u32,
    front: StoredFront<R, C>,
}

/// A block of points with a queue of its own.
#[derive(Clone, Debug)]
struct Patch<R: Real, K: TriangleKind<R>> {
    block: Block,
    /// The solver, from the first front that reaches the patch on.
    solver: Option<BucketScanner<R, K>>,
    /// Fronts that have reached points around the patch since its last round.
    told: Vec<Told<R, K::Carried>>,
    /// Fronts that its last round has brought to points that other patches see.
    news: Vec<Told<R, K::Carried>>,
    /// A time before which nothing is left to do.
    next: f64,
}

/// A solver by patches for one kind of front.
#[derive(Clone, Debug)]
struct PatchedBuckets<R: Real, K: TriangleKind<R>> {
    shared: Shared<R, K>,
    tiling: Tiling,
    side: usize,
    /// Distance from which an update reads points.
    reach: usize,
    patches: Vec<Patch<R, K>>,
    /// Arrival times on the whole surface.
    times: Vec<R>,
    counts: PatchCounts,
}

impl<R: Real, K: TriangleKind<R>> PatchedBuckets<R, K> {
    fn new(shared: Shared<R, K>, side: usize) -> Self {
        let chart = shared.edges.chart();
        let tiling = Tiling::new(chart, side);
        let places = tiling.tiles().places();
        let block = |(row, col)| tiling.points(tiling.tiles().around((row, col), 0));
        let patches: Vec<_> = places.map(|place| Patch::new(block(place))).collect();
        Self {
            reach: shared.edges.reach(),
            tiling,
            side,
            counts: PatchCounts { patches: patches.len() as u64, ..PatchCounts::default() },
            patches,
            times: vec![R::FAR; chart.bordered_points()],
            shared,
        }
    }

    fn solvers(&mut self) -> impl Iterator<Item = &mut BucketScanner<R, K>> {
        self.patches.iter_mut().filter_map(|patch| patch.solver.as_mut())
    }

    fn seed(&mut self, seeds: &[Seed]) {
        self.shared.kind.expect(seeds);
        let arrival = |seed| (seed, self.shared.kind.arrival_of_seed(seed));
        let arrivals: Vec<_> = seeds.iter().map(arrival).collect();
        // The kind of front may depend on all seeds.
        let kind = self.shared.kind.clone();
        self.solvers().for_each(|solver| solver.shared.kind = kind.clone());
        for (seed, arrival) in arrivals {
            let place = (seed.row, seed.col);
            let ((row, col), _) = self.tiling.tile_of(place);
            let patch = &mut self.patches[self.tiling.tiles().index(row, col)];
            let solver = patch.solver(&self.shared, self.reach);
            solver.plant(solver.view.at(place), arrival, tag_of(seed));
            patch.next = patch.next.min(seed.time);
        }
    }

    fn run(&mut self) -> Convergence {
        let round_time = ROUND * self.shared.width;
        let (mut until, mut residual) = (0.0, 0.0);
        loop {
            let first = self.patches.iter().map(|patch| patch.next).fold(f64::INFINITY, f64::min);
            let limit = self.shared.settings.limit.time();
            if first == f64::INFINITY || first > limit {
                break;
            }
            until = f64::max(until, first) + round_time;
            let (shared, reach) = (&self.shared, self.reach);
            let mut round: Vec<_> =
                self.patches.iter_mut().filter(|patch| patch.next <= until).collect();
            self.counts.rounds += 1;
            self.counts.visits += round.len() as u64;
            round.par_iter_mut().with_max_len(1).for_each(|patch| patch.run(shared, reach, until));
            self.tell();
            self.lower_limit();
            if self.shared.settings.monitor.is_cancelled() {
                break;
            }
            let reached = self.sum(|solver| solver.reached.len() as u64);
            if self.visits() > MOST_COMPUTED * (reached + 1000) {
                residual = f64::INFINITY;
                break;
            }
        }
        self.counts.iterations = self.counts.visits;
        self.collect();
        self.shared.settings.monitor.note(1, residual);
        Convergence { iterations: 1, residual }
    }

    /// Tells patches the new fronts at the points around them.
    fn tell(&mut self) {
        let (chart, tiles) = (self.shared.edges.chart(), self.tiling.tiles());
        for number in 0..self.patches.len() {
            let mut news = std::mem::take(&mut self.patches[number].news);
            for told in news.drain(..) {
                let place = chart.bordered_position(told.on_surface as usize);
                let around = chart.around(place, self.reach);
                let corners = [
                    (around.rows.start, around.cols.start),
                    (around.rows.start, around.cols.end - 1),
                    (around.rows.end - 1, around.cols.start),
                    (around.rows.end - 1, around.cols.end - 1),
                ];
                let mut seeing = corners.map(|corner| {
                    let ((row, col), _) = self.tiling.tile_of(corner);
                    tiles.index(row, col)
                });
                seeing.sort_unstable();
                for k in 0..seeing.len() {
                    let other = seeing[k];
                    if other != number && !seeing[..k].contains(&other) {
                        let patch = &mut self.patches[other];
                        patch.told.push(told);
                        patch.next = patch.next.min(told.front.time.wide());
                    }
                }
            }
            self.patches[number].news = news;
        }
    }

    /// Lowers the limit to the time of the targets, once their fronts are final.
    fn lower_limit(&mut self) {
        let before = self.shared.settings.limit.time();
        let (tiling, patches) = (self.tiling, &self.patches);
        self.shared.settings.limit.lower(|[row, col]| {
            let ((tile_row, tile_col), _) = tiling.tile_of((row, col));
            let solver = &patches[tiling.tiles().index(tile_row, tile_col)].solver;
            solver.as_ref().map_or(f64::INFINITY, |solver| {
                solver.fronts.settled[solver.view.at((row, col))].wide()
            })
        });
        let limit = self.shared.settings.limit.time();
        if limit < before {
            for solver in self.solvers() {
                solver.shared.settings.limit = Limit::at(limit);
                solver.requeue_waiting();
            }
        }
    }

    /// Copies the arrival times of all patches to the array of the surface.
    fn collect(&mut self) {
        let (chart, tiling, patches) = (self.shared.edges.chart(), self.tiling, &self.patches);
        let side = self.side;
        chart.bands_mut(&mut self.times, side).enumerate().for_each(|(band, times)| {
            for patch in &patches[tiling.tiles().row(band)] {
                let Some(solver) = &patch.solver else { continue };
                let Block { rows, cols } = &patch.block;
                for row in rows.clone() {
                    let from = solver.view.at((row, cols.start));
                    times[chart.in_band(row - band * side, cols)]
                        .copy_from_slice(&solver.fronts.times[from..][..cols.len()]);
                }
            }
        });
    }

    fn sum(&self, of: impl Fn(&BucketScanner<R, K>) -> u64) -> u64 {
        self.patches.iter().filter_map(|patch| patch.solver.as_ref()).map(of).sum()
    }
}

impl<R: Real, K: TriangleKind<R>> Patch<R, K> {
    fn new(block: Block) -> Self {
        Self { block, solver: None, told: Vec::new(), news: Vec::new(), next: f64::INFINITY }
    }

    fn solver(&mut self, shared: &Shared<R, K>, reach: usize) -> &mut BucketScanner<R, K> {
        self.solver.get_or_insert_with(|| {
            let chart = shared.edges.chart();
            let view = View::around(chart, &self.block, reach);
            let mut solver = BucketScanner::of(shared.clone(), view, BUCKETS);
            solver.mark_borders(chart, &self.block, reach);
            solver
        })
    }

    /// Takes in the fronts around the patch, and solves up to a time.
    fn run(&mut self, shared: &Shared<R, K>, reach: usize, until: f64) {
        let (mut told, mut news) = (std::mem::take(&mut self.told), std::mem::take(&mut self.news));
        let solver = self.solver(shared, reach);
        let next = solver.run_until(until, &told);
        let points = std::mem::take(&mut solver.news);
        news.extend(points.into_iter().map(|point| {
            let point = point as usize;
            let is_final = solver.fronts.is_final(point);
            let front = if is_final { solver.fronts.at(point) } else { none() };
            Told { on_surface: solver.view.on_surface(point) as u32, front }
        }));
        told.clear();
        (self.told, self.news, self.next) = (told, news, next);
    }
}

impl<R: Real, K: TriangleKind<R>> BucketScanner<R, K> {
    /// Marks the points around a block, and those of the block that others see.
    fn mark_borders(&mut self, chart: Chart, block: &Block, reach: usize) {
        self.states.iter_mut().for_each(|state| state.set(State::FOREIGN));
        let inside = |from: usize, at: usize, end: usize, last: usize| {
            (from == 0 || at >= from + reach) && (end == last || at + reach < end)
        };
        for (row, col) in block.places() {
            let state = &mut self.states[self.view.at((row, col))];
            state.clear(State::FOREIGN);
            let (rows, cols) = (&block.rows, &block.cols);
            if !(inside(rows.start, row, rows.end, chart.rows)
                && inside(cols.start, col, cols.end, chart.cols))
            {
                state.set(State::SHARED);
            }
        }
    }

    /// Takes in fronts at the points around a patch, and computes the fronts of points up to a time. Returns a time before
    /// which no point waits.
    fn run_until(&mut self, until: f64, told: &[Told<R, K::Carried>]) -> f64 {
        let earliest = told.iter().map(|told| told.front.time.wide()).fold(f64::INFINITY, f64::min);
        self.queue.go_back(earliest);
        let (mut lanes, mut arrivals) =
            (Box::new(Pulled::new()), [K::Carried::arrival_of_front(none()); MOST]);
        let instructions = self.shared.settings.instructions;
        instructions.run(Round {
            solver: self,
            lanes: &mut lanes,
            arrivals: &mut arrivals,
            told,
            until: Some(until),
        });
        self.queue.next().unwrap_or(f64::INFINITY)
    }

    /// Takes in the front at a point of another patch.
    #[inline(always)]
    pub(super) fn hear(
        &mut self,
        Told { on_surface, front }: Told<R, K::Carried>,
        lanes: &mut Pulled<R, K::Carried>,
        arrivals: &mut [K::Arrival; MOST],
    ) {
        let point = self.view.here(on_surface as usize);
        let before = self.fronts.at(point);
        if self.fronts.is_final(point) {
            if K::Carried::change(before, front) <= R::Bits::from(super::compute::CHANGE) {
                return;
            }
            self.call_back_after(point, before, front);
        } else if before.time >= R::FAR {
            self.reached.push(point as u32);
        }
        self.fronts.set(point, front);
        self.fronts.settled[point] = front.time;
        lanes.count = 0;
        self.pass_on(point, lanes);
        self.call_back(lanes, arrivals);
    }
}

impl<R: Real, K: TriangleKind<R>> Scans<R> for PatchedBuckets<R, K> {
    fn solve(&mut self, seeds: &[Seed], _: Stop) -> Convergence {
        self.shared.kind.forget();
        self.counts = PatchCounts { patches: self.counts.patches, ..PatchCounts::default() };
        let settings = self.shared.settings.clone();
        for patch in &mut self.patches {
            patch.next = f64::INFINITY;
            patch.told.clear();
            if let Some(solver) = &mut patch.solver {
                solver.forget();
                solver.shared.settings = settings.clone();
            }
        }
        self.seed(seeds);
        self.run()
    }

    fn add(&mut self, seeds: &[Seed], _: Stop) -> Convergence {
        self.solvers().for_each(BucketScanner::release);
        self.seed(seeds);
        self.run()
    }

    fn go_on(&mut self, _: &[Seed], _: Stop, limit: Limit) -> Option<Convergence> {
        let time = limit.time();
        self.shared.settings.limit = limit;
        let mut any = false;
        for patch in &mut self.patches {
            let Some(solver) = &mut patch.solver else { continue };
            solver.go_on_to(Limit::at(time));
            let next = solver.queue.next().unwrap_or(f64::INFINITY);
            patch.next = patch.next.min(next);
            any |= next < f64::INFINITY || !patch.told.is_empty();
        }
        any.then(|| self.run())
    }

    fn used(&self) -> Vec<Block> {
        let used = self.patches.iter().filter(|patch| patch.solver.is_some());
        used.map(|patch| patch.block.clone()).collect()
    }

    fn settings(&mut self) -> &mut Settings {
        &mut self.shared.settings
    }

    fn times(&self) -> &[R] {
        &self.times
    }

    fn into_times(self: Box<Self>) -> Vec<R> {
        self.times
    }

    fn visits(&self) -> u64 {
        self.sum(|solver| solver.taken)
    }

    fn updates(&self) -> u64 {
        self.sum(|solver| solver.triangles)
    }

    fn bytes(&self) -> usize {
        let of_solvers = self.sum(|solver| solver.own_bytes() as u64) as usize;
        of_solvers + self.shared.bytes() + size_of_val(self.times.as_slice())
    }

    fn patches(&self) -> Option<PatchCounts> {
        Some(self.counts)
    }

    fn is_in_order_of_time(&self) -> bool {
        true
    }

    fn boxed(&self) -> Box<dyn Scans<R>> {
        Box::new(self.clone())
    }
}

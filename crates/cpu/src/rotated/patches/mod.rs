//! Solves by patches of the grid, in the order in which fronts reach them. Any thread may visit any patch.
//!
//! A patch is *due* once a front has changed along its border. Its due time is the time of the earliest such front. A
//! round visits the patches that no neighbour is about to change ([`order`]). These visits run in parallel. Each visit
//! starts from the fronts before the round, runs scans until the patch has settled ([`visit`]), and reports its changes
//! to the neighbours. Then the round's results are written to the grid's arrays. So the map is the same for any number
//! of threads. The order by time is that of heap-cell methods (Chacon and Vladimirsky, "Fast two-scale methods for
//! eikonal equations", 2012), where cells wait in a heap.

mod order;
mod patch;
mod room;
mod visit;

use std::collections::BTreeSet;

use rayon::prelude::*;

use super::prepared::{FEW_ITERATIONS, Prepared, Settings};
use super::scans::{PatchCounts, Scans};
use super::tiles::Tiles;
use super::typical_edge::typical_edge;
use crate::fronts::exchange::exchange;
use crate::fronts::{Fronts as _, LaneKind};
use crate::limit::Limit;
use crate::lines::span::TILE;
use crate::lines::window::{Fronts, Window};
use crate::progress::Progress;
use crate::scan::Scan;
use geosweep_surface::update::StoredFront;
use geosweep_surface::{Block, EdgeLengths, Real, Seed, Tiling, min, relative_change};
use geosweep_surface::{Convergence, Stop};
use order::Dues;
use patch::{News, Patch, Woken};
use room::{Pool, Room};
use visit::Visits;

/// Borrows the fields of the scanner that the visits of a round share, and no others.
macro_rules! visits {
    ($scanner:ident, $window:ident, $reach:ident) => {
        Visits {
            on: &$scanner.on,
            far: Fronts { window: $window, times: &$scanner.times, carried: &$scanner.carried },
            panels: &$scanner.panels,
            tiling: $scanner.tiling,
            reach: $reach,
            inner: $scanner.plan.inner,
            limit: $scanner.on.settings.limit.time(),
        }
    };
}

/// Parameters of a solution by patches.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Plan {
    /// Number of points on a side of a patch, a multiple of [`TILE`].
    pub side: usize,
    /// Maximum delay of a patch relative to the earliest patch, in sides of a patch. Patches that are due later wait.
    pub band: f64,
    /// Maximum delay of a patch relative to any neighbour, in sides of a patch. Patches that are due later wait.
    pub lag: f64,
    /// Largest number of iterations in a visit.
    pub inner: u32,
    /// Largest number of patches in a round. It limits the working memory.
    pub most: usize,
}

impl Plan {
    /// Returns the plan for patches of `side` points a side. Maps with different sides differ by rounding only.
    pub(crate) const fn new(side: usize) -> Self {
        Self { side, band: 8.0, lag: 0.0, inner: 16, most: 64 }
    }
}

/// Divisor of the tolerance. A change is reported to a neighbour if it exceeds the tolerance divided by this number.
const PASSED_ON: u32 = 8;

/// A solver by patches for one kind of front.
#[derive(Clone, Debug)]
pub(crate) struct PatchScanner<R: Real, K: LaneKind<R>> {
    pub(crate) on: Prepared<R, K>,
    plan: Plan,
    tiling: Tiling,
    patches: Vec<Patch>,
    dues: Dues<R>,
    /// The fronts of the whole grid, as they were before the round.
    times: Vec<R>,
    carried: Vec<K::Carried>,
    rooms: Vec<Room<R, K::Carried>>,
    panels: Pool<R, K::Carried, K::SurfaceData>,
    counts: PatchCounts,
    /// For each patch, the time of the earliest front that the last round has changed along its border.
    woken: Vec<Option<R>>,
    /// Number of points that were examined to find patches that are due, since the start of the map.
    looked: u64,
    /// Largest change along the border of a patch that had no iterations left to process it.
    unseen: R::Bits,
}

impl<R: Real, K: LaneKind<R>> PatchScanner<R, K> {
    pub(crate) fn new(edges: &EdgeLengths<R>, kind: K, plan: Plan) -> Self {
        assert!(plan.side.is_multiple_of(TILE), "patches consist of tiles");
        let (chart, on) = (edges.chart(), Prepared::new(edges, kind));
        let tiling = Tiling::new(chart, plan.side);
        let side = plan.side as f64 * f64::from(typical_edge(edges));
        let [band, lag] = [plan.band, plan.lag].map(|sides| R::of(sides * side));
        let patches: Vec<_> = tiling
            .tiles()
            .places()
            .map(|(row, col)| {
                let block = tiling.points(tiling.tiles().around((row, col), 0));
                let [rows, cols] =
                    [&block.rows, &block.cols].map(|span| [span.start, span.end - 1]);
                let window = Window::new(chart, &chart.around_span(rows, cols, [TILE; 2]));
                let tiles = Tiles::new(window, &block);
                let progress = Progress::new(Stop::after(0));
                Patch { block, window, tiles, progress }
            })
            .collect();
        Self {
            on,
            plan,
            tiling,
            dues: Dues::new(tiling.tiles(), band, lag),
            patches,
            times: vec![R::FAR; chart.bordered_points()],
            carried: vec![K::Carried::default(); chart.bordered_points()],
            rooms: Vec::new(),
            panels: Pool::default(),
            counts: PatchCounts::default(),
            woken: vec![None; tiling.tiles().points()],
            looked: 0,
            unseen: R::Bits::default(),
        }
    }

    /// Examines all patches with a change that some scan has not seen.
    fn wake_unsettled(&mut self) {
        for (patch, woken) in self.patches.iter().zip(&mut self.woken) {
            if Scan::ALL.iter().any(|&scan| patch.tiles.has_pending(scan)) {
                *woken = Some(R::zero());
            }
        }
        self.wake();
    }

    /// Resets all points to unreached.
    fn forget(&mut self) {
        self.on.kind.forget();
        self.times.fill(R::FAR);
        self.carried.fill(K::Carried::default());
        self.patches.iter_mut().for_each(|patch| patch.tiles.reset());
        self.counts = PatchCounts::default();
        self.looked = 0;
        self.rooms.iter_mut().for_each(Room::forget);
    }

    fn start(&mut self, stop: Stop) {
        self.dues.clear();
        self.unseen = R::Bits::default();
        // There is at least one iteration, as with scans of the whole grid.
        let stop = stop.or_after(stop.iterations.max(1));
        self.patches.iter_mut().for_each(|patch| patch.progress = Progress::new(stop));
    }

    /// Starts fronts from the seeds that are earlier than the map at their points.
    fn seed(&mut self, seeds: &[Seed]) {
        let (chart, mut earlier) = (self.on.chart(), Vec::new());
        let fronts = (self.times.as_mut_slice(), self.carried.as_mut_slice());
        self.on.kind.start(chart, seeds, fronts, |seed, _, [before, after]| {
            if R::of(seed.time) < before.time {
                earlier.push(((seed.row, seed.col), after.time));
            }
        });
        earlier.into_iter().for_each(|(place, time)| self.touch(place, time));
        self.exchange(R::Bits::default());
        self.wake();
    }

    /// Notifies all patches that see a point that its front has changed to `time`.
    fn touch(&mut self, (row, col): (usize, usize), time: R) {
        for patch in self.seeing((row, col)) {
            self.patches[patch].tiles.touch(row, col);
            self.dues.enlist(patch, time);
        }
    }

    /// Returns the patches that see a point.
    fn seeing(&self, at: (usize, usize)) -> BTreeSet<usize> {
        let patch = |near| {
            let ((row, col), _) = self.tiling.tile_of(near);
            self.tiling.tiles().index(row, col)
        };
        self.on.chart().around(at, self.reach()).places().map(patch).collect()
    }

    /// Gives all copies of each point of a glued surface the earliest front among them, and reports the changes to the
    /// patches that see these points.
    fn exchange(&mut self, tolerance: R::Bits) {
        let (edges, tiling) = (self.on.edges.clone(), self.tiling);
        let place = |point| edges.chart().bordered_position(point);
        let at = |map: &Self, point: usize| {
            let ((row, col), _) = tiling.tile_of(place(point));
            let Patch { progress, .. } = &map.patches[tiling.tiles().index(row, col)];
            let front = StoredFront { time: map.times[point], carried: map.carried[point] };
            (front, progress.renews())
        };
        exchange::<R, K, _>(&edges, self, at, |map, point, [before, after]| {
            (map.times[point], map.carried[point]) = (after.time, after.carried);
            let (change, time) = (K::Carried::change(before, after), min(before.time, after.time));
            if change > R::Bits::default() && time.wide() <= map.on.settings.limit.time() {
                for to in map.seeing(place(point)) {
                    map.tell(News { to, at: place(point), time, change }, tolerance);
                }
            }
        });
    }

    /// Returns the largest distance, in rows and columns, from which an update reads a point.
    fn reach(&self) -> usize {
        if K::NEEDS_EDGES { self.on.edges.reach() } else { 1 }
    }

    fn converge(&mut self, seeds: &[Seed], stop: Stop) -> Convergence {
        let tolerance = R::of(stop.tolerance).in_units();
        self.counts.patches = self.patches.len() as u64;
        let mut many = u64::from(FEW_ITERATIONS) * self.counts.patches;
        loop {
            let round = self.dues.next_round(self.plan.most, R::of(self.on.settings.limit.time()));
            if round.is_empty() {
                let is_last = self.patches.iter().any(|patch| patch.progress.is_last());
                if is_last || !K::has_lost(self.on.chart(), seeds, &self.times) {
                    return self.convergence();
                }
                self.seed(seeds);
                continue;
            }
            self.visit(&round);
            let Convergence { iterations, residual } = self.convergence();
            let monitor = &self.on.settings.monitor;
            monitor.note(iterations, residual);
            if monitor.is_cancelled() {
                return self.convergence();
            }
            self.on.lower_limit(&self.times);
            self.pass_on(&round, tolerance);
            if self.counts.iterations > many {
                many = u64::MAX;
                self.on.store_parts();
            }
        }
    }

    /// Returns the largest number of iterations of any patch, and the largest change that remains.
    fn convergence(&self) -> Convergence {
        let visited = self.patches.iter().map(|patch| &patch.progress);
        let visited = visited.filter(|progress| progress.iterations > 0);
        let all =
            visited.fold(Convergence::NONE, |all, progress| all.worse(progress.convergence()));
        let unseen = relative_change::<R>(self.unseen);
        all.worse(Convergence { iterations: 1, residual: unseen })
    }

    /// Visits some patches in parallel, and writes their fronts to the grid's arrays.
    fn visit(&mut self, round: &[usize]) {
        while self.rooms.len() < round.len() {
            self.rooms.push(Room::new(self.on.chart()));
        }
        let (window, reach) = (Window::whole(self.on.chart()), self.reach());
        let visits = visits!(self, window, reach);
        let chosen = self.patches.iter_mut().enumerate();
        let chosen = chosen.filter(|(patch, _)| round.binary_search(patch).is_ok());
        let mut chosen: Vec<_> = chosen.zip(&mut self.rooms).collect();
        chosen.par_iter_mut().with_max_len(1).for_each(|((number, patch), room)| {
            visits.visit(*number, patch, room);
        });
        self.write(round);
    }

    /// Writes the fronts of visited patches to the grid's arrays, in parallel over rows of patches.
    fn write(&mut self, round: &[usize]) {
        let (chart, side, tiles) = (self.on.chart(), self.plan.side, self.tiling.tiles());
        let rooms = &self.rooms;
        let bands = chart.bands_mut(&mut self.times, side);
        let bands = bands.zip(chart.bands_mut(&mut self.carried, side));
        bands.enumerate().for_each(|(band, (times, carried))| {
            let of_band = round.iter().zip(rooms);
            let of_band = of_band.filter(|(patch, _)| tiles.position(**patch).0 == band);
            of_band.for_each(|(_, room)| room.store(chart, band * side, times, carried));
        });
    }

    /// Reports the changes of visited patches to their neighbours. Patches that have not settled are due again.
    fn pass_on(&mut self, round: &[usize], tolerance: R::Bits) {
        self.counts.rounds += 1;
        self.counts.visits += round.len() as u64;
        for (index, &patch) in round.iter().enumerate() {
            let room = &mut self.rooms[index];
            self.counts.iterations += u64::from(room.iterations);
            let Patch { progress, .. } = &self.patches[patch];
            if !room.settled && !progress.is_last() {
                self.dues.enlist(patch, room.first);
            }
            let mut all = std::mem::take(&mut room.news);
            all.drain(..).for_each(|news| self.tell(news, tolerance));
            self.rooms[index].news = all;
        }
        self.exchange(tolerance);
        self.wake();
    }

    /// Reports a change to a patch that sees it.
    fn tell(&mut self, News { to, at, time, change }: News<R>, tolerance: R::Bits) {
        let Patch { tiles, progress, .. } = &mut self.patches[to];
        tiles.touch(at.0, at.1);
        // Changes within the tolerance add up from patch to patch. So changes above a fraction of the tolerance are
        // passed on. After many iterations without a newly reached point, changes within the full tolerance are not
        // passed on either, so that iterations end.
        let least = if progress.renews() { tolerance / PASSED_ON.into() } else { tolerance };
        if change <= least {
            return;
        }
        if progress.is_last() {
            self.unseen = self.unseen.max(change);
        } else {
            let woken = &mut self.woken[to];
            *woken = Some(woken.map_or(time, |earliest| earliest.min(time)));
        }
    }

    /// Examines in parallel the patches along whose border a front has changed. Patches in which a scan has work are
    /// due.
    fn wake(&mut self) {
        let (window, reach) = (Window::whole(self.on.chart()), self.reach());
        let visits = visits!(self, window, reach);
        let woken = self.patches.iter_mut().zip(&mut self.woken).enumerate();
        let mut woken: Vec<_> = woken
            .filter_map(|(number, (patch, woken))| {
                Some(Woken { number, patch, time: woken.take()?, looked: 0, is_due: false })
            })
            .collect();
        woken.par_iter_mut().with_max_len(1).for_each(|woken| visits.look(woken));
        for Woken { number, time, looked, is_due, .. } in woken {
            self.looked += looked;
            if is_due {
                self.dues.enlist(number, time);
            }
        }
    }
}

impl<R: Real, K: LaneKind<R>> Scans<R> for PatchScanner<R, K> {
    fn solve(&mut self, seeds: &[Seed], stop: Stop) -> Convergence {
        rayon::scope(|_| {
            if self.on.prepare() {
                self.panels = Pool::default();
            }
            self.forget();
            self.start(stop);
            self.seed(seeds);
            self.converge(seeds, stop)
        })
    }

    fn add(&mut self, seeds: &[Seed], stop: Stop) -> Convergence {
        self.carried.iter_mut().for_each(|carried| *carried = carried.released());
        let was_stopped = self.patches.iter().any(|patch| patch.progress.is_last());
        self.start(stop);
        self.seed(seeds);
        rayon::scope(|_| {
            if was_stopped {
                self.wake_unsettled();
            }
            self.converge(seeds, stop)
        })
    }

    fn go_on(&mut self, seeds: &[Seed], stop: Stop, limit: Limit) -> Option<Convergence> {
        let before = std::mem::replace(&mut self.on.settings.limit, limit).time();
        self.start(stop);
        let chart = self.on.chart();
        let beyond = |time: R| time.wide() > before && time < R::FAR;
        let found: Vec<_> = chart
            .places()
            .map(|(row, col)| ((row, col), self.times[chart.bordered(row, col)]))
            .filter(|&(_, time)| beyond(time))
            .collect();
        found.iter().for_each(|&(place, time)| self.touch(place, time));
        (!found.is_empty()).then(|| rayon::scope(|_| self.converge(seeds, stop)))
    }

    fn used(&self) -> Vec<Block> {
        vec![Window::whole(self.on.chart()).block()]
    }

    fn settings(&mut self) -> &mut Settings {
        &mut self.on.settings
    }

    fn times(&self) -> &[R] {
        &self.times
    }

    fn into_times(self: Box<Self>) -> Vec<R> {
        self.times
    }

    fn visits(&self) -> u64 {
        self.looked + self.rooms.iter().map(|room| room.looked + room.copy.visits).sum::<u64>()
    }

    fn updates(&self) -> u64 {
        self.rooms.iter().map(|room| room.copy.updates).sum()
    }

    fn bytes(&self) -> usize {
        let tiles = self.patches.iter().map(|patch| patch.tiles.bytes()).sum::<usize>();
        let rooms = self.rooms.iter().map(|room| room.copy.bytes()).sum::<usize>();
        std::mem::size_of_val(self.times.as_slice())
            + std::mem::size_of_val(self.carried.as_slice())
            + tiles
            + rooms
            + self.panels.bytes()
            + self.on.bytes()
    }

    fn patches(&self) -> Option<PatchCounts> {
        Some(self.counts)
    }

    fn boxed(&self) -> Box<dyn Scans<R>> {
        Box::new(self.clone())
    }
}

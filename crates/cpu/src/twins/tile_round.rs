//! Implements rounds of scans inside tiles. The twin of `glsl/passes/tile_round.glsl` and
//! `glsl/passes/settle.comp`.

use super::behind;
use crate::Solution;
use crate::behind::Behind;
use crate::fronts::{Fronts, PointKind, for_kind};
use crate::points::PointFronts;
use crate::rotated::typical_edge::typical_edge;
use crate::scan::Scan;
use geosweep_surface::Stop;
use geosweep_surface::constants::{BAND_SIDES, PATIENCE};
use geosweep_surface::update::Wavefront;
use geosweep_surface::{Chart, EdgeLengths, Real, Seed, Tiling, relative_change};
use num_traits::One;

/// Options of rounds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Rounds {
    /// Number of points on a side of a tile. It is even.
    pub tile: usize,
    /// Largest number of iterations of four scans inside a tile in one round.
    pub inner: u32,
    /// Number of rounds per recording. At the end of each recording, `settle.comp` decides whether to keep renewing
    /// curved fronts.
    pub recorded: u32,
    /// Number of tiles on the list above which tiles that are due much later than the first one wait. It is 0 in
    /// shaders on CPUs and 64 on GPUs. With `None`, no tile waits.
    pub few: Option<usize>,
}

/// Solves by rounds. A round visits the tiles beside which the previous round has changed something, and
/// iterates four scans inside each. Each round equals that of the shaders. An iteration of the solution is a
/// round.
pub fn tile_rounds<R: Real>(
    edges: &EdgeLengths<R>,
    seeds: &[Seed],
    wavefront: Wavefront,
    stop: Stop,
    rounds: Rounds,
) -> Solution<R> {
    tile_rounds_within(edges, seeds, wavefront, stop, rounds, f64::INFINITY).0
}

/// Solves as [`tile_rounds`] does, up to a radius, and also returns the number of tiles visited in all rounds.
/// A few points beyond the radius may have provisional times.
pub fn tile_rounds_within<R: Real>(
    edges: &EdgeLengths<R>,
    seeds: &[Seed],
    wavefront: Wavefront,
    stop: Stop,
    rounds: Rounds,
    radius: f64,
) -> (Solution<R>, u64) {
    for_kind!(edges, wavefront, kind => {
        solve(PointFronts::start_within(edges, kind, seeds, radius), seeds, stop, rounds)
    })
}

fn solve<R: Real, K: PointKind<R>>(
    fronts: PointFronts<R, K>,
    seeds: &[Seed],
    stop: Stop,
    rounds: Rounds,
) -> (Solution<R>, u64) {
    let mut tiles = Tiles::new(fronts, seeds, stop, rounds);
    loop {
        let count = rounds.recorded.min(stop.iterations - tiles.iterations);
        let mut unsettled = Vec::new();
        let mut reached = false;
        for _ in 0..count {
            if tiles.list.is_empty() {
                break;
            }
            let round = tiles.round();
            unsettled.push(round.unsettled);
            reached |= round.reached;
        }
        if tiles.settle(&unsettled, reached, count) {
            let residual = relative_change::<R>(tiles.last_residual);
            let visits = tiles.visits;
            return (tiles.fronts.finish(tiles.iterations, residual), visits);
        }
    }
}

/// The tiles of a grid and the fronts in them.
struct Tiles<R: Real, K: PointKind<R>> {
    chart: Chart,
    tiling: Tiling,
    /// Largest distance, in rows and columns, from which an update reads a point.
    reach: usize,
    rounds: Rounds,
    behind: [Behind; 4],
    /// The fronts before the round.
    fronts: PointFronts<R, K>,
    /// Four copies of the fronts, one for each scan. Only the fronts in and around the visited tile are in use.
    copies: [PointFronts<R, K>; 4],
    /// The tiles to visit in the next round.
    list: Vec<(usize, usize)>,
    /// The time at which each tile is due, if it is on the list.
    due: Vec<Option<R>>,
    /// A tile waits if it is due later than the first tile by more than this time. If the time is zero, no tile waits.
    band: R,
    /// Number of tiles visited so far.
    visits: u64,
    tolerance: R::Bits,
    most: u32,
    iterations: u32,
    last_residual: R::Bits,
    since_reached: u32,
    renews: bool,
}

/// Outcome of a round, of a visit to a tile, or of an exchange.
#[derive(Default)]
struct Visit<B> {
    /// Largest change that another round has to pass on.
    unsettled: B,
    /// Whether a point was reached for the first time.
    reached: bool,
}

impl<B: Ord + Copy> Visit<B> {
    fn add(&mut self, other: Self) {
        self.unsettled = self.unsettled.max(other.unsettled);
        self.reached |= other.reached;
    }
}

impl<R: Real, K: PointKind<R>> Tiles<R, K> {
    fn new(fronts: PointFronts<R, K>, seeds: &[Seed], stop: Stop, rounds: Rounds) -> Self {
        let chart = fronts.edges.chart();
        let mut tiles = Self {
            chart,
            tiling: Tiling::new(chart, rounds.tile),
            reach: fronts.edges.reach(),
            rounds,
            behind: behind(chart),
            copies: std::array::from_fn(|_| fronts.clone()),
            list: Vec::new(),
            due: Vec::new(),
            band: match rounds.few.is_some() {
                true => R::of(
                    (BAND_SIDES as f32 * rounds.tile as f32 * typical_edge(&fronts.edges)).into(),
                ),
                false => R::zero(),
            },
            visits: 0,
            fronts,
            tolerance: R::of(stop.tolerance).in_units(),
            most: stop.iterations,
            iterations: 0,
            last_residual: R::Bits::default(),
            since_reached: 0,
            renews: true,
        };
        // Enlists the tiles of the texels around the texel of each seed.
        let texels = Tiling::new(chart, 2);
        for seed in seeds {
            let (texel, _) = texels.tile_of((seed.row, seed.col));
            for (row, col) in texels.tiles().around(texel, 1).places() {
                let (tile, _) = tiles.tiling.tile_of((2 * row, 2 * col));
                let time = tiles.fronts.time(chart.bordered(seed.row, seed.col));
                tiles.enlist(tile, time);
            }
        }
        tiles.exchange(false);
        tiles
    }

    /// Gives all copies of points of a glued surface the earliest front among them, and enlists the tiles that
    /// see a change.
    fn exchange(&mut self, renews: bool) -> Visit<R::Bits> {
        let mut changes = Vec::new();
        self.fronts.exchange(renews, |place, fronts| changes.push((place, fronts)));
        let mut found = Visit::<R::Bits>::default();
        for (place, [before, after]) in changes {
            found.reached |= before.time >= R::FAR && after.time < R::FAR;
            let by = K::Carried::change(before, after);
            if by <= self.tolerance {
                continue;
            }
            found.unsettled = found.unsettled.max(by);
            let (own, _) = self.tiling.tile_of(place);
            for tile in self.tiling.beside(place, self.reach).chain([own]) {
                self.enlist(tile, before.time.min(after.time));
            }
        }
        found
    }

    fn enlist(&mut self, tile: (usize, usize), time: R) {
        let tiles = self.tiling.tiles();
        self.due.resize(tiles.points(), None);
        let due = &mut self.due[tiles.index(tile.0, tile.1)];
        match due {
            None => self.list.push(tile),
            Some(due) => return *due = due.min(time),
        }
        *due = Some(time);
    }

    /// Visits the tiles on the list that do not wait. All of them see the fronts from before the round.
    fn round(&mut self) -> Visit<R::Bits> {
        let mut after = self.fronts.clone();
        let mut round = Visit::<R::Bits>::default();
        let tiles = self.tiling.tiles();
        let due = std::mem::take(&mut self.due);
        let first = due.iter().flatten().copied().fold(R::infinity(), R::min);
        let list = std::mem::take(&mut self.list);
        let may_wait = self.rounds.few.is_some_and(|few| list.len() > few);
        for tile in list {
            let time = due[tiles.index(tile.0, tile.1)].expect("it is on the list");
            if time > self.fronts.limit() {
                continue;
            }
            if may_wait && self.band > R::zero() && time > first + self.band {
                self.enlist(tile, time);
                round.unsettled = round.unsettled.max(self.tolerance + R::Bits::one());
                continue;
            }
            self.visits += 1;
            round.add(self.visit(tile, time, &mut after));
        }
        self.fronts = after;
        round.add(self.exchange(self.renews));
        round
    }

    fn visit(
        &mut self,
        tile: (usize, usize),
        was_due: R,
        after: &mut PointFronts<R, K>,
    ) -> Visit<R::Bits> {
        let chart = self.chart;
        let block = self.tiling.points(self.tiling.tiles().around(tile, 0));
        for point in chart.with_halo(&block) {
            self.copies.iter_mut().for_each(|copy| copy.copy_point(&self.fronts, point));
        }
        let mut change = R::Bits::default();
        for _ in 0..self.rounds.inner {
            let fronts = &self.fronts;
            for (index, copy) in self.copies.iter_mut().enumerate() {
                let (behind, scan) = (&self.behind[index], index as u8 + 1);
                // Farther away, fronts are seen as they were before the round.
                let near = |x| chart.is_near(&block, x);
                let (order, turned) = (Scan(scan), block.clone().by(Scan(scan).lines()));
                for line in order.in_order(turned.rows) {
                    let points = turned.cols.clone().map(|at| order.lines().place(line, at));
                    let points = points.map(|(row, col)| chart.bordered(row, col));
                    // All points of the line are updated from the fronts before its update.
                    let seen = |x| if near(x) { copy.at(x) } else { fronts.at(x) };
                    let arrive = |point| (point, copy.reach_seen(point, behind, seen));
                    for (point, front) in points.map(arrive).collect::<Vec<_>>() {
                        copy.accept(point, front, scan, self.renews);
                    }
                }
            }
            change = R::Bits::default();
            for (row, col) in block.places() {
                let point = chart.bordered(row, col);
                change = change.max(self.merge(after, point));
            }
            if change <= self.tolerance {
                break;
            }
        }

        let mut border_change = R::Bits::default();
        let mut reached = false;
        let mut first: Option<R> = None;
        for (row, col) in block.places() {
            let point = chart.bordered(row, col);
            reached |= self.fronts.time(point) >= R::FAR && after.time(point) < R::FAR;
            let by = after.change_from(&self.fronts, point);
            if by <= self.tolerance {
                continue;
            }
            let time = after.time(point).min(self.fronts.time(point));
            first = Some(first.map_or(time, |first| first.min(time)));
            for beside in self.tiling.beside((row, col), self.reach) {
                self.enlist(beside, time);
                border_change = border_change.max(by);
            }
        }
        if change > self.tolerance {
            self.enlist(tile, first.unwrap_or(was_due));
        }
        Visit { unsettled: change.max(border_change), reached }
    }

    /// Makes the four copies of the fronts at a point equal again, with the first front to arrive, and returns the
    /// change. A front that is not from the copy's own scan is old and does not count.
    fn merge(&mut self, after: &mut PointFronts<R, K>, point: usize) -> R::Bits {
        let change = after.take_first(&self.copies, point);
        self.copies.iter_mut().for_each(|copy| copy.copy_point(after, point));
        change
    }

    /// Ends the rounds of a recording, and returns whether they were the last. `unsettled` holds the largest
    /// unsettled change of each round. The twin of `settle.comp`, except that all fronts are in one array here and need
    /// not be copied back.
    fn settle(&mut self, unsettled: &[R::Bits], reached: bool, recorded: u32) -> bool {
        let visited = unsettled.len() as u32;
        self.iterations += visited;
        self.last_residual = unsettled.last().copied().unwrap_or(self.last_residual);
        self.since_reached = if reached { 0 } else { self.since_reached + visited };
        if self.since_reached >= PATIENCE {
            self.renews = false;
        }
        visited < recorded || self.list.is_empty() || self.iterations >= self.most
    }
}

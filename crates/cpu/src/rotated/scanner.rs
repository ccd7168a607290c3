//! Runs rotated scans of one kind of front until a map has converged, for one map after another.

use rayon::prelude::*;

use super::changed::Changed;
use super::due::find_due;
use super::exchange::exchange;
use super::merge::merge;
use super::panel::Panel;
use super::prepared::{FEW_ITERATIONS, Prepared, Settings};
use super::scan_copy::{On, ScanCopy};
use super::scans::Scans;
use super::tiles::Tiles;
use crate::fronts::{Fronts, LaneKind};
use crate::limit::Limit;
use crate::lines::span::Before;
use crate::lines::window::Window;
use crate::progress::Progress;
use crate::scan::{Scan, UpdateOptions};
use geosweep_surface::update::StoredFront;
use geosweep_surface::{Block, EdgeLengths, Real, Seed};
use geosweep_surface::{Convergence, Stop};

/// A solver for one kind of front; see [`crate::RotatedScan`].
#[derive(Clone, Debug)]
pub(crate) struct Scanner<R: Real, K: LaneKind<R>> {
    pub(crate) on: Prepared<R, K>,
    tiles: Tiles,
    /// The fronts as two opposite scans see them. Between pairs of scans both copies are equal.
    copies: [ScanCopy<R, K::Carried>; 2],
    panels: [Panel<R, K::Carried, K::SurfaceData>; 2],
    /// Number of points that were examined before scans, to find the tiles in which the scans have work.
    looked: u64,
}

impl<R: Real, K: LaneKind<R>> Scanner<R, K> {
    pub(crate) fn new(edges: &EdgeLengths<R>, kind: K) -> Self {
        let (on, window) = (Prepared::new(edges, kind), Window::whole(edges.chart()));
        let tiles = Tiles::new(window, &window.block());
        // Each copy is allocated by the thread that will use it.
        let copy = || (ScanCopy::new(window, &tiles), on.panel());
        let ((a, panel_a), (b, panel_b)) = rayon::join(copy, copy);
        Self { on, tiles, copies: [a, b], panels: [panel_a, panel_b], looked: 0 }
    }

    fn converge(&mut self, seeds: &[Seed], stop: Stop) -> Convergence {
        let mut progress = Progress::new(stop);
        loop {
            let vertical = self.scan([Scan::DOWN, Scan::UP], progress.renews());
            let horizontal = self.scan([Scan::RIGHT, Scan::LEFT], progress.renews());
            let is_done = progress.is_done::<R>(vertical.max(horizontal));
            self.on.lower_limit(&self.copies[0].times);
            let monitor = &self.on.settings.monitor;
            monitor.note(progress.iterations, progress.residual);
            if monitor.is_cancelled() {
                return progress.convergence();
            }
            if !is_done {
                if progress.iterations == FEW_ITERATIONS {
                    self.on.store_parts();
                }
                continue;
            }
            if progress.is_last() || !K::has_lost(self.on.chart(), seeds, self.times()) {
                return progress.convergence();
            }
            self.seed(seeds);
        }
    }

    /// Returns the front at a point of the last map.
    pub(crate) fn front(&self, row: usize, col: usize) -> StoredFront<R, K::Carried> {
        let point = self.on.chart().bordered(row, col);
        let ScanCopy { times, carried, .. } = &self.copies[0];
        StoredFront { time: times[point], carried: carried[point] }
    }

    /// Resets all points to unreached.
    fn forget(&mut self) {
        self.looked = 0;
        self.on.kind.forget();
        let tiles = &self.tiles;
        self.copies.par_iter_mut().for_each(|copy| copy.forget(tiles));
        self.tiles.reset();
    }

    /// Starts fronts from the seeds that are earlier than the map at their points.
    fn seed(&mut self, seeds: &[Seed]) {
        let (chart, tiles) = (self.on.chart(), &mut self.tiles);
        let [copy, other] = &mut self.copies;
        let fronts = (copy.times.as_mut_slice(), copy.carried.as_mut_slice());
        self.on.kind.start(chart, seeds, fronts, |seed, point, [before, after]| {
            (other.times[point], other.carried[point]) = (after.time, after.carried);
            if R::of(seed.time) < before.time {
                tiles.touch(seed.row, seed.col);
            }
        });
        let limit = self.on.settings.limit.time();
        exchange::<R, K>(&self.on.edges, &mut self.copies, &mut self.tiles, false, limit);
    }

    /// Runs two opposite scans and returns the largest change.
    fn scan(&mut self, scans: [Scan; 2], renews: bool) -> R::Bits {
        let Prepared { edges, kind, settings, .. } = &self.on;
        let Settings { instructions, ref monitor, .. } = *settings;
        let (grid, limit) = (self.on.grid(), settings.limit.time());
        let options = scans.map(|scan| UpdateOptions { scan, renews, limit, instructions });
        let fronts = self.copies[0].fronts();
        let before = Before { edges, fronts, far: None, surface_data: grid.surface_data };
        self.looked += find_due(kind, before, &mut self.tiles, &options);
        let (tiles, [first, second]) = (&self.tiles, &mut self.copies);
        let [a, b] = self.panels.each_mut().map(|panel| On { grid, panel, far: None, monitor });
        let (a, b) = rayon::join(
            || first.scan(kind, a, tiles, options[0]),
            || second.scan(kind, b, tiles, options[1]),
        );
        merge::<R, K>(edges.chart(), tiles, [first, second], scans, instructions);
        self.tiles.passed(scans, [&self.copies[0].changed, &self.copies[1].changed]);
        self.copies.iter_mut().for_each(|copy| copy.changed.fill(Changed::No));
        a.max(b).max(exchange::<R, K>(edges, &mut self.copies, &mut self.tiles, renews, limit))
    }
}

impl<R: Real, K: LaneKind<R>> Scans<R> for Scanner<R, K> {
    fn solve(&mut self, seeds: &[Seed], stop: Stop) -> Convergence {
        // Enters the thread pool once, and not for each pair of scans.
        rayon::scope(|_| {
            if self.on.prepare() {
                self.panels.iter_mut().for_each(Panel::free_edges_back);
            }
            self.forget();
            self.seed(seeds);
            self.converge(seeds, stop)
        })
    }

    fn add(&mut self, seeds: &[Seed], stop: Stop) -> Convergence {
        for ScanCopy { carried, .. } in &mut self.copies {
            carried.iter_mut().for_each(|carried| *carried = carried.released());
        }
        self.seed(seeds);
        // Enters the thread pool once, and not for each pair of scans.
        rayon::scope(|_| self.converge(seeds, stop))
    }

    fn go_on(&mut self, seeds: &[Seed], stop: Stop, limit: Limit) -> Option<Convergence> {
        let before = std::mem::replace(&mut self.on.settings.limit, limit).time();
        let beyond = |&time: &R| time.wide() > before && time < R::FAR;
        let fronts = self.copies[0].fronts();
        let place = |(row, col)| (fronts.of(row, col).time, (row, col));
        let points = self.tiles.used().flat_map(|block| block.places()).map(place);
        let found: Vec<_> = points.filter(|(time, _)| beyond(time)).map(|(_, at)| at).collect();
        found.iter().for_each(|&(row, col)| self.tiles.touch(row, col));
        (!found.is_empty()).then(|| rayon::scope(|_| self.converge(seeds, stop)))
    }

    fn used(&self) -> Vec<Block> {
        self.tiles.used().collect()
    }

    fn settings(&mut self) -> &mut Settings {
        &mut self.on.settings
    }

    fn times(&self) -> &[R] {
        &self.copies[0].times
    }

    fn into_times(self: Box<Self>) -> Vec<R> {
        let [copy, _] = self.copies;
        copy.times
    }

    fn visits(&self) -> u64 {
        self.looked + self.copies.iter().map(|copy| copy.visits).sum::<u64>()
    }

    fn updates(&self) -> u64 {
        self.copies.iter().map(|copy| copy.updates).sum()
    }

    fn bytes(&self) -> usize {
        let copies = self.copies.iter().map(ScanCopy::bytes).sum::<usize>();
        let panels = self.panels.iter().map(Panel::bytes).sum::<usize>();
        copies + panels + self.tiles.bytes() + self.on.bytes()
    }

    fn boxed(&self) -> Box<dyn Scans<R>> {
        Box::new(self.clone())
    }
}

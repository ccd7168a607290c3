//! Runs rotated scans of one kind of front until a map has converged, for one map after another.

use std::borrow::Cow;

use rayon::prelude::*;

use super::due::find_due;
use super::fronts::{FrontKind, KeptBy};
use super::line_update::How;
use super::merge::merge;
use super::panel::Grid;
use super::scan::Scan;
use super::scan_copy::ScanCopy;
use super::stretch::Before;
use super::tiles::Tiles;
use super::transposed::TransposedEdges;
use super::{Instructions, Progress};
use crate::surface::{EdgeLengths, Real, Seed};
use crate::update::{Kept, tag_of};
use crate::{Convergence, Stop};

/// A solver for one kind of front; see [`super::RotatedScan`].
#[derive(Clone, Debug)]
pub(super) struct Scanner<'a, R: Real, K: FrontKind<'a, R>> {
    edges: &'a EdgeLengths<R>,
    kind: K,
    /// Data of each surface point that the front needs.
    ground: Cow<'a, [K::Ground]>,
    pub(super) instructions: Instructions,
    tiles: Tiles,
    /// The fronts as two opposite scans see them. Between pairs of scans both copies are equal.
    copies: [ScanCopy<R, K::Carried, K::Ground>; 2],
    /// Transposed edges, for straight fronts on large grids. The second map fills them. Other fronts have
    /// more data per point to keep.
    transposed: Option<TransposedEdges<R>>,
    /// Whether a map has been solved.
    solved: bool,
    /// Number of points that were examined before scans started.
    looked: u64,
}

/// Minimum number of grid points for keeping transposed edges. On smaller grids these and the panels would
/// take more than 40 bytes per point, and the arrays to transpose lie in near caches.
const TRANSPOSED_FROM: usize = 256 * 256;

/// Number of iterations of a map after which storing the parts of many obtuse triangles pays. On a plane
/// sheared by 60 degrees, of which a map takes two, storing them at once takes half as long again; on steep
/// hills, of which one takes 20, not storing them takes 1.3 to 1.8 times as long.
const FEW_ITERATIONS: u32 = 3;

impl<'a, R: Real, K: FrontKind<'a, R>> Scanner<'a, R, K> {
    pub(super) fn new(edges: &'a EdgeLengths<R>, kind: K) -> Self {
        let (chart, tiles) = (edges.chart(), Tiles::new(edges.chart()));
        let copy = || ScanCopy::new(chart, &tiles, K::NEEDS_EDGES);
        // Each copy is allocated by the thread that will use it.
        let copies = rayon::join(copy, copy).into();
        if K::NEEDS_EDGES {
            // Found here, since the threads of a scan would wait for one another.
            edges.store_few_parts();
        }
        let carries_nothing = size_of::<K::Carried>() == 0;
        let keeps_edges = carries_nothing && chart.points() >= TRANSPOSED_FROM;
        Self {
            edges,
            ground: kind.ground(chart),
            kind,
            instructions: Instructions::best(),
            copies,
            tiles,
            transposed: keeps_edges.then(|| TransposedEdges::new(chart)),
            solved: false,
            looked: 0,
        }
    }

    /// Computes the distance map of `seeds`.
    pub(super) fn solve(&mut self, seeds: &[Seed], stop: Stop) -> Convergence {
        // Enters the thread pool once, and not for each pair of scans.
        rayon::scope(|_| {
            if std::mem::replace(&mut self.solved, true) {
                self.prepare_for_many();
            }
            self.forget();
            self.seed(seeds);
            self.converge(seeds, stop)
        })
    }

    /// Adds sources to the last map, which is a warm start. Only tiles that the new fronts reach first are
    /// visited.
    pub(super) fn add(&mut self, seeds: &[Seed], stop: Stop) -> Convergence {
        for ScanCopy { carried, .. } in &mut self.copies {
            carried.iter_mut().for_each(|carried| *carried = K::released(*carried));
        }
        self.seed(seeds);
        // Enters the thread pool once, and not for each pair of scans.
        rayon::scope(|_| self.converge(seeds, stop))
    }

    fn converge(&mut self, seeds: &[Seed], stop: Stop) -> Convergence {
        let mut progress = Progress::new(stop);
        loop {
            let vertical = self.scan([Scan::DOWN, Scan::UP], progress.renews());
            let horizontal = self.scan([Scan::RIGHT, Scan::LEFT], progress.renews());
            if !progress.is_done::<R>(vertical.max(horizontal)) {
                if progress.iterations == FEW_ITERATIONS {
                    self.store_parts();
                }
                continue;
            }
            let chart = self.edges.chart();
            let is_lost =
                |seed: &Seed| seed.is_lost(self.times()[chart.bordered(seed.row, seed.col)]);
            let goes_on = K::TAKES_BACK && !progress.is_last() && seeds.iter().any(is_lost);
            if !goes_on {
                let Progress { iterations, residual, .. } = progress;
                return Convergence { iterations, residual };
            }
            self.seed(seeds);
        }
    }

    /// Returns the arrival times of the last map, as a bordered array.
    pub(super) fn times(&self) -> &[R] {
        &self.copies[0].times
    }

    pub(super) fn into_times(self) -> Vec<R> {
        let [copy, _] = self.copies;
        copy.times
    }

    /// Returns the front at a point of the last map.
    pub(super) fn front(&self, row: usize, col: usize) -> KeptBy<'a, R, K> {
        let point = self.edges.chart().bordered(row, col);
        let ScanCopy { times, carried, .. } = &self.copies[0];
        Kept { time: times[point], carried: carried[point] }
    }

    pub(super) fn visits(&self) -> u64 {
        self.looked + self.copies.iter().map(|copy| copy.visits).sum::<u64>()
    }

    pub(super) fn updates(&self) -> u64 {
        self.copies.iter().map(|copy| copy.updates).sum()
    }

    /// Returns the number of bytes held, without the edge lengths and the data stored with them.
    pub(super) fn bytes(&self) -> usize {
        let ground = match &self.ground {
            Cow::Borrowed(_) => 0,
            Cow::Owned(ground) => std::mem::size_of_val(ground.as_slice()),
        };
        let copies = self.copies.iter().map(ScanCopy::bytes).sum::<usize>();
        let transposed = self.transposed.as_ref().map_or(0, TransposedEdges::bytes);
        copies + self.tiles.bytes() + transposed + ground + self.kind.bytes()
    }

    /// Stores what makes the second map and all later ones faster: the parts of all obtuse triangles, and the
    /// edges between columns in the order that scans to the right and left need.
    fn prepare_for_many(&mut self) {
        self.store_parts();
        if let Some(transposed) = &mut self.transposed {
            transposed.fill(self.edges, self.instructions);
            self.copies.iter_mut().for_each(|copy| copy.panel.free_edges_back());
        }
    }

    /// Stores the parts of all obtuse triangles, if that has not been done yet.
    fn store_parts(&self) {
        if K::NEEDS_EDGES {
            self.edges.parts_on_side(Scan::DOWN.back());
        }
    }

    /// Resets all points to unreached.
    fn forget(&mut self) {
        self.looked = 0;
        self.kind.forget();
        self.copies.par_iter_mut().for_each(ScanCopy::forget);
        self.tiles.reset();
    }

    /// Starts fronts from those seeds that arrive before the map.
    fn seed(&mut self, seeds: &[Seed]) {
        let chart = self.edges.chart();
        self.kind.expect(seeds);
        for seed in seeds {
            let point = chart.bordered(seed.row, seed.col);
            let arrival = self.kind.arrival_of_seed(seed);
            let mut changed = false;
            for ScanCopy { times, carried, .. } in &mut self.copies {
                let kept = Kept { time: times[point], carried: carried[point] };
                changed |= R::of(seed.time) < kept.time;
                let front = K::accept(kept, arrival, tag_of(seed), false);
                (times[point], carried[point]) = (front.time, front.carried);
            }
            if changed {
                self.tiles.touch(seed.row, seed.col);
            }
        }
    }

    /// Runs two opposite scans and returns the largest change.
    fn scan(&mut self, scans: [Scan; 2], renews: bool) -> R::Bits {
        let (edges, ground) = (self.edges, &*self.ground);
        let transposed = self.transposed.as_ref().and_then(TransposedEdges::filled);
        let grid = Grid { edges, transposed, ground };
        let instructions = self.instructions;
        let how = scans.map(|scan| How { scan, renews, instructions });
        let ScanCopy { times, carried, .. } = &self.copies[0];
        let before = Before { edges, times, carried, ground };
        self.looked += find_due(&self.kind, before, &mut self.tiles, how);
        let (kind, tiles, [first, second]) = (&self.kind, &self.tiles, &mut self.copies);
        let (a, b) = rayon::join(
            || first.scan(kind, grid, tiles, how[0]),
            || second.scan(kind, grid, tiles, how[1]),
        );
        merge::<R, K>(edges.chart(), tiles, [first, second], scans, instructions);
        self.tiles.passed(scans, [&self.copies[0].changed, &self.copies[1].changed]);
        self.copies.iter_mut().for_each(|copy| copy.changed.fill(false));
        a.max(b)
    }
}

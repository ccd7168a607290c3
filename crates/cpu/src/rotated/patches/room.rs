//! Working memory of visits to patches, which later rounds reuse.

use std::sync::Mutex;

use super::patch::News;
use crate::lines::window::{Fronts, Window};
use crate::rotated::changed::Changed;
use crate::rotated::panel::Panel;
use crate::rotated::scan_copy::ScanCopy;
use crate::rotated::tiles::Tiles;
use geosweep_surface::update::Carried;
use geosweep_surface::{Block, Chart, Direction, Real};

/// The fronts in the window of a visited patch, and the outcome of the visit.
#[derive(Clone, Debug)]
pub(super) struct Room<R: Real, C> {
    pub copy: ScanCopy<R, C>,
    /// Blocks that cover all changed tiles of the patch.
    changed: Vec<Block>,
    /// Changes of the window's tiles.
    pub marks: Vec<Changed>,
    /// Changes to report to the neighbours.
    pub news: Vec<News<R>>,
    /// Number of iterations of the visit.
    pub iterations: u32,
    /// Whether the last iteration changed nothing by more than the tolerance.
    pub settled: bool,
    /// Earliest time whose update is pending, if the patch has not settled.
    pub first: R,
    /// Number of points that were examined before scans started, since the start of the map.
    pub looked: u64,
}

impl<R: Real, C: Carried> Room<R, C> {
    pub(super) fn new(grid: Chart) -> Self {
        Self {
            copy: ScanCopy::empty(grid),
            changed: Vec::new(),
            marks: Vec::new(),
            news: Vec::new(),
            iterations: 0,
            settled: true,
            first: R::zero(),
            looked: 0,
        }
    }

    /// Resets the counters for a new map.
    pub(super) fn forget(&mut self) {
        self.looked = 0;
        (self.copy.visits, self.copy.updates) = (0, 0);
    }

    /// Copies the fronts of a block of a window. Only this block is read and written until the next call.
    pub(super) fn load(
        &mut self,
        window: Window,
        tiles: &Tiles,
        from: Fronts<R, C>,
        Block { rows, cols }: Block,
    ) {
        let own = window.own();
        let ScanCopy { window: held, times, carried, changed, .. } = &mut self.copy;
        *held = window;
        times.resize(own.bordered_points(), R::FAR);
        carried.resize(own.bordered_points(), C::default());
        changed.clear();
        changed.resize(tiles.len(), Changed::No);
        own.fill_border_rows(times, R::FAR);
        own.fill_border_rows(carried, C::default());
        for row in rows {
            let (here, there) = (window.index(row, cols.start), from.window.index(row, cols.start));
            let last = here + cols.len() - 1;
            let ends = [own.beside(here, Direction::West), own.beside(last, Direction::East)];
            times[here..][..cols.len()].copy_from_slice(&from.times[there..][..cols.len()]);
            carried[here..][..cols.len()].copy_from_slice(&from.carried[there..][..cols.len()]);
            // The entries beside the block hold no fronts. At the grid's border, updates read them.
            ends.iter().for_each(|&end| (times[end], carried[end]) = (R::FAR, C::default()));
        }
        self.changed.clear();
    }

    /// Notes which tiles have changed.
    pub(super) fn note_changes(&mut self, tiles: &Tiles, changed: &[Changed]) {
        self.changed.extend(tiles.spans(changed));
    }

    /// Returns the blocks that have changed.
    pub(super) fn changed(&self) -> &[Block] {
        &self.changed
    }

    /// Copies the changed blocks to a band of the grid's arrays, whose first row is `first`.
    pub(super) fn store(&self, chart: Chart, first: usize, times: &mut [R], carried: &mut [C]) {
        let from = self.copy.fronts();
        for Block { rows, cols } in &self.changed {
            for row in rows.clone() {
                let to = chart.in_band(row - first, cols);
                let here = from.window.index(row, cols.start);
                times[to.clone()].copy_from_slice(&from.times[here..][..cols.len()]);
                carried[to].copy_from_slice(&from.carried[here..][..cols.len()]);
            }
        }
    }
}

/// Panels that are not in use. There are at most as many as threads.
#[derive(Debug)]
pub(super) struct Pool<R, C, G>(Mutex<Vec<Panel<R, C, G>>>);

impl<R, C, G> Default for Pool<R, C, G> {
    fn default() -> Self {
        Self(Mutex::new(Vec::new()))
    }
}

/// A clone starts without panels.
impl<R, C, G> Clone for Pool<R, C, G> {
    fn clone(&self) -> Self {
        Self::default()
    }
}

impl<R: Real, C: Carried, G: bytemuck::Pod> Pool<R, C, G> {
    /// Lends a panel to some work.
    pub(super) fn with<T>(
        &self,
        new: impl FnOnce() -> Panel<R, C, G>,
        work: impl FnOnce(&mut Panel<R, C, G>) -> T,
    ) -> T {
        let held = "no thread panics while it takes or returns a panel";
        let spare = self.0.lock().expect(held).pop();
        // The lock is released before a new panel is allocated.
        let mut panel = spare.unwrap_or_else(new);
        let result = work(&mut panel);
        self.0.lock().expect(held).push(panel);
        result
    }

    /// Returns the number of bytes held.
    pub(super) fn bytes(&self) -> usize {
        self.0.lock().map_or(0, |panels| panels.iter().map(Panel::bytes).sum())
    }
}

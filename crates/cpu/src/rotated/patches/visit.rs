//! Visits a patch: scans it until it has settled, and collects the changes that its neighbours see.

use super::patch::{News, Patch, Woken};
use super::room::{Pool, Room};
use crate::fronts::{Fronts as _, LaneKind};
use crate::lines::span::{Before, TILE};
use crate::lines::window::Fronts;
use crate::rotated::changed::Changed;
use crate::rotated::due::find_due;
use crate::rotated::panel::Panel;
use crate::rotated::prepared::Prepared;
use crate::rotated::scan_copy::On;
use crate::scan::{Scan, UpdateOptions};
use geosweep_surface::update::{Carried, StoredFront};
use geosweep_surface::{Block, Real, Tiling, min};

/// Data that the visits of a round share.
pub(super) struct Visits<'v, R: Real, K: LaneKind<R>> {
    pub on: &'v Prepared<R, K>,
    /// The fronts of the whole grid before the round.
    pub far: Fronts<'v, R, K::Carried>,
    pub panels: &'v Pool<R, K::Carried, K::SurfaceData>,
    pub tiling: Tiling,
    /// Largest distance, in rows and columns, from which an update reads a point.
    pub reach: usize,
    /// Largest number of iterations.
    pub inner: u32,
    /// Largest arrival time that scans continue; see [`UpdateOptions`].
    pub limit: f64,
}

impl<R: Real, K: LaneKind<R>> Visits<'_, R, K> {
    /// Determines whether a scan has work in a patch, after changes around it. If no scan has work, the changes count
    /// as seen by all scans.
    pub(super) fn look(&self, Woken { patch, looked, is_due, .. }: &mut Woken<R>) {
        let renews = patch.progress.renews();
        let options = |scan| self.options(scan, renews);
        let grid = self.on.grid();
        let before = Before {
            edges: grid.edges,
            fronts: self.far,
            far: None,
            surface_data: grid.surface_data,
        };
        *looked = find_due(&self.on.kind, before, &mut patch.tiles, &Scan::ALL.map(options));
        *is_due = patch.tiles.any_is_due();
        if !*is_due {
            patch.tiles.passed(Scan::ALL, [&[]; 4]);
        }
    }

    fn options(&self, scan: Scan, renews: bool) -> UpdateOptions {
        UpdateOptions {
            scan,
            renews,
            limit: self.limit,
            instructions: self.on.settings.instructions,
        }
    }

    /// Visits a patch, given its number.
    pub(super) fn visit(&self, number: usize, patch: &mut Patch, room: &mut Room<R, K::Carried>) {
        let chart = self.on.chart();
        let [rows, cols] = [&patch.block.rows, &patch.block.cols].map(|at| [at.start, at.end - 1]);
        // Anchored fronts, whose updates need no edges, may come from anchors farther away than the reach. The window
        // then holds a whole tile around the patch.
        let reach = if K::NEEDS_EDGES { self.reach } else { TILE };
        let seen = chart.around_span(rows, cols, [reach; 2]);
        room.load(patch.window, &patch.tiles, self.far, seen);
        self.panels.with(|| self.on.panel(), |panel| self.settle(patch, room, panel));
        self.report(number, room);
    }

    /// Iterates scans until nothing changes by more than the tolerance.
    fn settle(
        &self,
        patch: &mut Patch,
        room: &mut Room<R, K::Carried>,
        panel: &mut Panel<R, K::Carried, K::SurfaceData>,
    ) {
        (room.iterations, room.settled) = (0, false);
        let scans = in_order(room.copy.fronts(), &patch.block);
        let mut changed = std::mem::take(&mut room.marks);
        changed.clear();
        changed.resize(patch.tiles.len(), Changed::No);
        while room.iterations < self.inner && !room.settled && !patch.progress.is_last() {
            let renews = patch.progress.renews();
            let mut change = R::Bits::default();
            for scan in scans {
                change = change.max(self.scan(patch, room, panel, scan, renews));
                for (all, tile) in changed.iter_mut().zip(&mut room.copy.changed) {
                    *all = std::mem::take(tile).max(*all);
                }
            }
            room.iterations += 1;
            patch.progress.is_done::<R>(change);
            room.settled = patch.progress.is_settled();
        }
        room.note_changes(&patch.tiles, &changed);
        room.marks = changed;
    }

    /// Runs one scan and returns the largest change.
    fn scan(
        &self,
        patch: &mut Patch,
        room: &mut Room<R, K::Carried>,
        panel: &mut Panel<R, K::Carried, K::SurfaceData>,
        scan: Scan,
        renews: bool,
    ) -> R::Bits {
        let Patch { tiles, .. } = patch;
        if !tiles.has_pending(scan) {
            return R::Bits::default();
        }
        let (grid, far) = (self.on.grid(), Some(self.far));
        let options = self.options(scan, renews);
        let fronts = room.copy.fronts();
        let before = Before { edges: grid.edges, fronts, far, surface_data: grid.surface_data };
        room.looked += find_due(&self.on.kind, before, tiles, &[options]);
        let change = room.copy.scan(
            &self.on.kind,
            On { grid, panel, far, monitor: &self.on.settings.monitor },
            tiles,
            options,
        );
        tiles.passed([scan], [&room.copy.changed]);
        change
    }

    /// Collects the changes of points that updates of neighbouring patches read.
    fn report(&self, number: usize, room: &mut Room<R, K::Carried>) {
        let tiles = self.tiling.tiles();
        let mut news = std::mem::take(&mut room.news);
        let position = tiles.position(number);
        room.first = R::FAR;
        for beside in tiles.around(position, 1).places().filter(|&beside| beside != position) {
            let to = tiles.index(beside.0, beside.1);
            let block = self.tiling.points(tiles.around(beside, 0));
            for changed in room.changed() {
                let seen = within(changed, &block, self.reach);
                for tile in tiles_of(&seen) {
                    let (change, time) = self.change(room, &tile);
                    if change > R::Bits::default() && time.wide() <= self.limit {
                        news.push(News { to, at: tile.first(), time, change });
                    }
                }
            }
        }
        if !room.settled {
            let changed = room.changed().iter().map(|block| self.change(room, block).1);
            room.first = changed.fold(R::FAR, min);
        }
        room.news = news;
    }

    /// Returns the largest change in a block since before the round, and the earliest time that has changed.
    fn change(&self, room: &Room<R, K::Carried>, block: &Block) -> (R::Bits, R) {
        let (mut largest, mut first) = (R::Bits::default(), R::FAR);
        for (row, col) in block.places() {
            let before: StoredFront<R, K::Carried> = self.far.of(row, col);
            let after: StoredFront<R, K::Carried> = room.copy.fronts().of(row, col);
            let change = K::Carried::change(before, after);
            if change > R::Bits::default() {
                largest = largest.max(change);
                first = min(first, min(before.time, after.time));
            }
        }
        (largest, first)
    }
}

/// Returns the four scans in the order of a visit: first the two along which the fronts around a block move, then the
/// opposite ones. The first two bring final fronts to most points, and the others change little. The times along the
/// sides of the block rise in the direction of the fronts. If no side shows a rise, fronts are assumed to come from the
/// sides that they have reached.
fn in_order<R: Real, C: Carried>(fronts: Fronts<R, C>, block: &Block) -> [Scan; 4] {
    // Rows and columns of the points around, counted from the border.
    let rows = [block.rows.start, block.rows.end + 1];
    let cols = [block.cols.start, block.cols.end + 1];
    let time = |row, col| fronts.at((row, col)).map_or(R::FAR, |front| front.time);
    let rise = |sides: [usize; 2], ends: [usize; 2], time: &dyn Fn(usize, usize) -> R| {
        let along = sides.map(|side| [time(side, ends[0] + 1), time(side, ends[1] - 1)]);
        let known = along.into_iter().filter(|ends| ends.iter().all(|time| *time < R::FAR));
        let known = known.map(|[first, last]| last - first).reduce(|a, b| a + b);
        known.unwrap_or_else(|| {
            let middle = usize::midpoint(sides[0], sides[1]);
            let [first, last] = ends.map(|end| time(middle, end));
            if first < last {
                R::FAR
            } else if last < first {
                -R::FAR
            } else {
                R::zero()
            }
        })
    };
    let right = rise(rows, cols, &|row, col| time(row, col));
    let down = rise(cols, rows, &|col, row| time(row, col));
    let vertical = if down < R::zero() { [Scan::UP, Scan::DOWN] } else { [Scan::DOWN, Scan::UP] };
    let horizontal =
        if right < R::zero() { [Scan::LEFT, Scan::RIGHT] } else { [Scan::RIGHT, Scan::LEFT] };
    let [[a, c], [b, d]] = match right.abs() > down.abs() {
        true => [horizontal, vertical],
        false => [vertical, horizontal],
    };
    [a, b, c, d]
}

/// Returns the points of a block that are at most `reach` rows and columns away from another block.
fn within(block: &Block, other: &Block, reach: usize) -> Block {
    let span = |own: &std::ops::Range<usize>, other: &std::ops::Range<usize>| {
        let start = own.start.max(other.start.saturating_sub(reach));
        start..own.end.min(other.end + reach).max(start)
    };
    Block { rows: span(&block.rows, &other.rows), cols: span(&block.cols, &other.cols) }
}

/// Returns the parts of a block that lie in different tiles.
fn tiles_of(block: &Block) -> impl Iterator<Item = Block> {
    let spans = |range: std::ops::Range<usize>| {
        let first = range.start / TILE;
        let last = if range.is_empty() { first } else { range.end.div_ceil(TILE) };
        (first..last)
            .map(move |tile| range.start.max(tile * TILE)..range.end.min((tile + 1) * TILE))
    };
    let cols = block.cols.clone();
    spans(block.rows.clone()).flat_map(move |rows| {
        spans(cols.clone()).map(move |cols| Block { rows: rows.clone(), cols })
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lines::window::Window;
    use geosweep_surface::Chart;

    #[test]
    fn a_neighbour_sees_changes_within_reach() {
        let block = |rows, cols| Block { rows, cols };
        let patch = block(64..128, 64..128);
        let seen = |other| within(&patch, &other, 2);
        assert_eq!(seen(block(0..64, 64..128)), block(64..66, 64..128));
        assert_eq!(seen(block(128..150, 128..150)), block(126..128, 126..128));
        assert_eq!(seen(block(64..128, 0..64)), block(64..128, 64..66));
        // The changed points lie too far away.
        let changed = block(80..96, 64..128);
        assert_eq!(within(&changed, &block(0..64, 64..128), 2).places().count(), 0);
    }

    #[test]
    fn the_scan_that_goes_with_the_fronts_is_first() {
        let grid = Chart { rows: 40, cols: 40 };
        let window = Window::whole(grid);
        let block = Block { rows: 16..32, cols: 16..32 };
        let order = |time: &dyn Fn(f32, f32) -> f32| {
            let mut times = vec![f32::FAR; grid.bordered_points()];
            for (row, col) in grid.places().filter(|&place| !block.has(place)) {
                times[window.index(row, col)] = time(row as f32, col as f32);
            }
            let carried = vec![(); times.len()];
            in_order(Fronts { window, times: &times, carried: &carried }, &block)
        };
        let [down, up, right, left] = Scan::ALL;
        assert_eq!(order(&|row, col| 2.0 * row + col), [down, right, up, left]);
        assert_eq!(order(&|row, col| 200.0 - row - 2.0 * col), [left, up, right, down]);
        let from_left = |_: f32, col: f32| if col < 16.0 { col } else { f32::FAR };
        assert_eq!(order(&from_left)[0], right);
        let from_below = |row: f32, _: f32| if row < 32.0 { f32::FAR } else { 50.0 - row };
        assert_eq!(order(&from_below)[0], up);
    }

    #[test]
    fn blocks_are_cut_where_tiles_end() {
        let block = Block { rows: 30..34, cols: 16..40 };
        let parts: Vec<_> = tiles_of(&block).map(|part| (part.rows, part.cols)).collect();
        let expected = [(30..32, 16..32), (30..32, 32..40), (32..34, 16..32), (32..34, 32..40)];
        assert_eq!(parts, expected);
        assert_eq!(tiles_of(&Block { rows: 5..5, cols: 0..9 }).count(), 0);
    }
}

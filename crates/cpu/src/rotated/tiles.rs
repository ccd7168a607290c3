//! Tracks the active set: the tiles that a scan has to visit. These are the tiles in which, or beside which, a front
//! has changed since the scan last visited or examined them.

use std::ops::Range;

use rayon::prelude::*;

use super::changed::Changed;
use crate::lines::span::TILE;
use crate::lines::window::Window;
use crate::scan::{Scan, UpdateOptions};
use geosweep_surface::{Block, Chart, Tiling};

/// The flags of all scans.
const ALL: u8 = 0b11110;

/// The tiles of a window, with flags of scans for each.
#[derive(Clone, Debug)]
pub(crate) struct Tiles {
    place: TilesInGrid,
    /// The chart of the tiles.
    chart: Chart,
    /// The tiles that scans may change. The tiles around them are only read.
    inner: Block,
    /// Whether the tile has points that have been reached.
    used: Vec<bool>,
    /// Scans that have not seen the tile's last change yet.
    pending: Vec<u8>,
    /// Scans that are about to run and have to examine the tile, since it is beside or ahead of such a change.
    beside: Vec<u8>,
    /// Scans that are about to run and have work in the tile.
    due: Vec<u8>,
}

/// The positions of tiles in the grid.
#[derive(Clone, Copy, Debug)]
pub(crate) struct TilesInGrid {
    tiling: Tiling,
    /// The first row and column of the first tile.
    first: (usize, usize),
}

impl TilesInGrid {
    /// Returns the chart of the points.
    pub(crate) fn chart(self) -> Chart {
        self.tiling.chart()
    }

    /// Returns the rows of points of some rows of tiles.
    pub(crate) fn rows(self, tiles: Range<usize>) -> Range<usize> {
        shifted(self.tiling.rows(tiles), self.first.0)
    }

    /// Returns the columns of points of some columns of tiles.
    pub(crate) fn cols(self, tiles: Range<usize>) -> Range<usize> {
        shifted(self.tiling.cols(tiles), self.first.1)
    }

    /// Returns the tile of a point.
    fn tile_of(self, (row, col): (usize, usize)) -> (usize, usize) {
        self.tiling.tile_of((row - self.first.0, col - self.first.1)).0
    }
}

fn shifted(range: Range<usize>, by: usize) -> Range<usize> {
    range.start + by..range.end + by
}

impl Tiles {
    /// Creates the tiles of a window. Scans may change only the block `inner`, which consists of whole tiles.
    pub(crate) fn new(window: Window, inner: &Block) -> Self {
        let place = TilesInGrid { tiling: Tiling::new(window.own(), TILE), first: window.first() };
        let chart = place.tiling.tiles();
        let none = || vec![0; chart.points()];
        let (first, last) = (inner.first(), (inner.rows.end - 1, inner.cols.end - 1));
        let ((row, col), (last_row, last_col)) = (place.tile_of(first), place.tile_of(last));
        let inner = Block { rows: row..last_row + 1, cols: col..last_col + 1 };
        let used = vec![false; chart.points()];
        Self { place, chart, inner, used, pending: none(), beside: none(), due: none() }
    }

    /// Returns the positions of the tiles.
    pub(crate) fn place(&self) -> TilesInGrid {
        self.place
    }

    /// Returns the number of bytes held.
    pub(crate) fn bytes(&self) -> usize {
        self.used.len() + self.pending.len() + self.beside.len() + self.due.len()
    }

    /// Returns the number of tiles.
    pub(crate) fn len(&self) -> usize {
        self.pending.len()
    }

    /// Forgets all changes.
    pub(crate) fn reset(&mut self) {
        self.pending.fill(0);
        self.used.fill(false);
    }

    /// Returns blocks of points, row by row of tiles, that cover all reached points.
    pub(crate) fn used(&self) -> impl Iterator<Item = Block> {
        let runs = move |row: usize| {
            let used = &self.used[row * self.chart.cols..][..self.chart.cols];
            let mut end = 0;
            std::iter::from_fn(move || {
                let start = end + used[end..].iter().position(|&used| used)?;
                end = start + used[start..].iter().take_while(|&&used| used).count();
                Some((row, start..end))
            })
        };
        (0..self.chart.rows).flat_map(runs).map(|(row, tiles)| Block {
            rows: self.place.rows(row..row + 1),
            cols: self.place.cols(tiles),
        })
    }

    /// Notes a front at a point that no scan has to continue.
    pub(crate) fn note(&mut self, row: usize, col: usize) {
        let (row, col) = self.place.tile_of((row, col));
        self.used[self.chart.index(row, col)] = true;
    }

    /// Notes a change at a point that no scan has seen.
    pub(crate) fn touch(&mut self, row: usize, col: usize) {
        let (row, col) = self.place.tile_of((row, col));
        let tile = self.chart.index(row, col);
        (self.pending[tile], self.used[tile]) = (ALL, true);
    }

    /// Returns whether a scan has work in some tile.
    pub(crate) fn any_is_due(&self) -> bool {
        self.due.iter().any(|due| *due != 0)
    }

    /// Returns whether there is a change that a scan has not seen yet.
    pub(crate) fn has_pending(&self, scan: Scan) -> bool {
        self.pending.iter().any(|pending| pending & scan.bit() != 0)
    }

    /// Returns, for each row of inner tiles, the block of points from the first to the last tile that is marked as
    /// changed in `some`.
    pub(crate) fn spans<'t>(&'t self, some: &'t [Changed]) -> impl Iterator<Item = Block> + 't {
        let cols = &self.inner.cols;
        self.inner.rows.clone().filter_map(move |row| {
            let is_some = |col: &usize| some[self.chart.index(row, *col)] > Changed::No;
            let (first, last) = (cols.clone().find(is_some)?, cols.clone().rev().find(is_some)?);
            Some(Block {
                rows: self.place.rows(row..row + 1),
                cols: self.place.cols(first..last + 1),
            })
        })
    }

    /// Returns the bands of tiles that a scan passes, in its order.
    pub(crate) fn bands(&self, scan: Scan) -> impl Iterator<Item = usize> + use<> {
        scan.in_order(self.inner.clone().by(scan.lines()).rows)
    }

    /// Returns the number of tiles in a band.
    pub(crate) fn in_band(&self, scan: Scan) -> usize {
        self.chart.by(scan.lines()).cols
    }

    /// Returns the index of a tile, given its band and its position in the band.
    pub(crate) fn index(&self, scan: Scan, band: usize, place: usize) -> usize {
        let (row, col) = scan.lines().place(band, place);
        self.chart.index(row, col)
    }

    /// Returns the points of a span of a band, as a block whose rows are the scan's lines.
    pub(crate) fn lines(&self, scan: Scan, band: usize, run: Range<usize>) -> Block {
        let tiles = Block { rows: band..band + 1, cols: run }.by(scan.lines());
        let points = Block { rows: self.place.rows(tiles.rows), cols: self.place.cols(tiles.cols) };
        points.by(scan.lines())
    }

    /// Returns the tiles that a change of `tile` may affect in a scan: the tile itself, and those beside and ahead of
    /// it.
    fn followed(&self, scan: Scan, tile: usize) -> Block {
        let (place, lines) = (self.chart.position(tile), scan.lines());
        let (band, _) = lines.place(place.0, place.1);
        let Block { rows: bands, cols } = self.chart.around(place, 1).by(lines);
        let rows = if scan.is_forward() { band..bands.end } else { bands.start..band + 1 };
        let Block { rows, cols } = Block { rows, cols }.by(lines);
        let within = |range: Range<usize>, inner: &Range<usize>| {
            let start = range.start.max(inner.start);
            start..range.end.min(inner.end).max(start)
        };
        Block { rows: within(rows, &self.inner.rows), cols: within(cols, &self.inner.cols) }
    }

    /// Returns two slices for each row of tiles. The first slice has, for each tile, the flags of those `scans` that
    /// have to examine the tile, since it is beside or ahead of a changed tile. The second slice is zero: the caller
    /// adds the flags of the scans that have work in the tile.
    pub(crate) fn rows_beside_changes(
        &mut self,
        scans: &[UpdateOptions],
    ) -> impl IndexedParallelIterator<Item = (&[u8], &mut [u8])> {
        self.beside.fill(0);
        self.due.fill(0);
        let all = scans.iter().fold(0, |all, options| all | options.scan.bit());
        let changed = self.pending.iter().enumerate().filter(|(_, pending)| *pending & all != 0);
        for (tile, pending) in changed {
            let scans = scans.iter().map(|options| options.scan);
            for scan in scans.filter(|scan| pending & scan.bit() != 0) {
                let Block { rows, cols } = self.followed(scan, tile);
                for row in rows {
                    for beside in &mut self.beside[row * self.chart.cols..][cols.clone()] {
                        *beside |= scan.bit();
                    }
                }
            }
        }
        let cols = self.chart.cols;
        self.beside.par_chunks(cols).zip(self.due.par_chunks_mut(cols))
    }

    /// Finds the spans of a band that a scan has to visit. They consist of the tiles that are due, the tiles ahead of
    /// tiles that the scan has changed, and the tiles beside all these.
    pub(crate) fn runs(
        &self,
        scan: Scan,
        band: usize,
        changed: &[Changed],
        runs: &mut Vec<Range<usize>>,
    ) {
        runs.clear();
        let (tiles, back) = (self.chart.by(scan.lines()), scan.over_lines().back());
        let inner = self.inner.clone().by(scan.lines()).cols;
        let behind = tiles.neighbour(band, 0, back).map(|(behind, _)| behind);
        let news = |place: usize| {
            self.due[self.index(scan, band, place)] & scan.bit() != 0
                || behind.is_some_and(|behind| {
                    changed[self.index(scan, behind, place)] == Changed::Within
                })
        };
        for place in inner.clone().filter(|&place| news(place)) {
            let Range { start, end } = tiles.around((band, place), 1).cols;
            let (start, end) = (start.max(inner.start), end.min(inner.end));
            match runs.last_mut() {
                Some(last) if last.end >= start => last.end = end,
                _ => runs.push(start..end),
            }
        }
    }

    /// Notes the tiles that some scans, run in parallel, have changed. None of these scans has seen the changes of the
    /// others yet. Changes beyond the limit are pending for no scan. An empty list means that the scan has changed no
    /// tile.
    pub(crate) fn passed<const N: usize>(&mut self, scans: [Scan; N], changed: [&[Changed]; N]) {
        let seen = !scans.iter().fold(0, |all, scan| all | scan.bit());
        for (tile, (pending, used)) in self.pending.iter_mut().zip(&mut self.used).enumerate() {
            *pending &= seen;
            for (scan, changed) in scans.iter().zip(changed) {
                *used |= changed.get(tile).is_some_and(|changed| *changed > Changed::No);
                if changed.get(tile) == Some(&Changed::Within) {
                    *pending |= ALL & !scan.bit();
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn runs(tiles: &Tiles, scan: Scan, band: usize, changed: &[Changed]) -> Vec<[usize; 2]> {
        let mut runs = Vec::new();
        tiles.runs(scan, band, changed, &mut runs);
        runs.into_iter().map(|run| [run.start, run.end]).collect()
    }

    fn whole(rows: usize, cols: usize) -> Tiles {
        let window = Window::whole(Chart { rows, cols });
        Tiles::new(window, &window.block())
    }

    fn hows(scans: [Scan; 2]) -> [UpdateOptions; 2] {
        scans.map(|scan| UpdateOptions {
            scan,
            renews: true,
            limit: f64::INFINITY,
            instructions: crate::Instructions::best(),
        })
    }

    /// Marks all tiles that a scan has to examine as due.
    fn all_due(tiles: &mut Tiles, scans: [Scan; 2]) {
        let scans = hows(scans);
        tiles.rows_beside_changes(&scans).for_each(|(beside, due)| due.copy_from_slice(beside));
    }

    #[test]
    fn tiles_around_the_inner_ones_are_seen_but_not_changed() {
        let grid = Chart { rows: 160, cols: 160 };
        let window = Window::new(grid, &Block { rows: 48..112, cols: 32..112 });
        let inner = Block { rows: 64..96, cols: 48..96 };
        let mut tiles = Tiles::new(window, &inner);
        let quiet = vec![Changed::No; tiles.len()];
        // The touched points lie above the inner tiles and beside them.
        tiles.touch(50, 60);
        tiles.touch(70, 100);
        assert!(tiles.has_pending(Scan::LEFT));
        all_due(&mut tiles, [Scan::DOWN, Scan::UP]);
        assert_eq!(runs(&tiles, Scan::DOWN, 1, &quiet), [[1, 4]]);
        assert_eq!(runs(&tiles, Scan::UP, 2, &quiet), [[0; 2]; 0]);
        assert!(tiles.bands(Scan::UP).eq([2, 1]));
        assert_eq!(tiles.lines(Scan::DOWN, 1, 1..4), Block { rows: 64..80, cols: 48..96 });
        assert_eq!(tiles.lines(Scan::LEFT, 3, 1..3), Block { rows: 80..96, cols: 64..96 });
        all_due(&mut tiles, [Scan::RIGHT, Scan::LEFT]);
        assert_eq!(runs(&tiles, Scan::LEFT, 3, &quiet), [[1, 3]]);
        tiles.passed([Scan::LEFT], [&quiet]);
        assert!(!tiles.has_pending(Scan::LEFT) && tiles.has_pending(Scan::RIGHT));
    }

    #[test]
    fn a_scan_visits_what_lies_beside_and_ahead_of_a_change() {
        let mut tiles = whole(70, 160);
        tiles.touch(40, 100);
        let quiet = vec![Changed::No; tiles.len()];
        // The source lies in tile 2, 6. A scan may continue beside tiles that are due.
        all_due(&mut tiles, [Scan::DOWN, Scan::UP]);
        assert_eq!(runs(&tiles, Scan::DOWN, 1, &quiet), [[0; 2]; 0]);
        assert_eq!(runs(&tiles, Scan::DOWN, 2, &quiet), [[4, 9]]);
        assert_eq!(runs(&tiles, Scan::DOWN, 3, &quiet), [[4, 9]]);
        assert_eq!(runs(&tiles, Scan::DOWN, 4, &quiet), [[0; 2]; 0]);
        assert_eq!(runs(&tiles, Scan::UP, 1, &quiet), [[4, 9]]);
        assert_eq!(runs(&tiles, Scan::UP, 3, &quiet), [[0; 2]; 0]);
        let mut changed = quiet.clone();
        changed[tiles.index(Scan::DOWN, 2, 1)] = Changed::Within;
        assert_eq!(runs(&tiles, Scan::DOWN, 3, &changed), [[0, 3], [4, 9]]);
        assert_eq!(runs(&tiles, Scan::DOWN, 2, &changed), [[4, 9]]);
        all_due(&mut tiles, [Scan::RIGHT, Scan::LEFT]);
        assert_eq!(runs(&tiles, Scan::LEFT, 5, &quiet), [[0, 5]]);
        assert_eq!(runs(&tiles, Scan::LEFT, 7, &quiet), [[0; 2]; 0]);
        assert_eq!(runs(&tiles, Scan::RIGHT, 7, &quiet), [[0, 5]]);
        assert_eq!(runs(&tiles, Scan::DOWN, 2, &quiet), [[0; 2]; 0]);
    }

    #[test]
    fn tiles_that_are_not_due_are_visited_only_after_changes() {
        let mut tiles = whole(70, 160);
        tiles.touch(40, 100);
        let mut changed = vec![Changed::No; tiles.len()];
        tiles.rows_beside_changes(&hows([Scan::DOWN, Scan::UP])).for_each(|_| {});
        assert_eq!(runs(&tiles, Scan::DOWN, 3, &changed), [[0; 2]; 0]);
        changed[tiles.index(Scan::DOWN, 2, 6)] = Changed::Within;
        assert_eq!(runs(&tiles, Scan::DOWN, 3, &changed), [[5, 8]]);
    }

    #[test]
    fn tiles_that_a_scan_has_changed_are_pending_for_the_others() {
        let mut tiles = whole(16, 64);
        tiles.touch(3, 3);
        let (quiet, mut down) = (vec![Changed::No; 4], vec![Changed::No; 4]);
        (down[0], down[1]) = (Changed::Within, Changed::Beyond);
        tiles.passed([Scan::DOWN, Scan::UP], [&down, &quiet]);
        all_due(&mut tiles, [Scan::DOWN, Scan::UP]);
        assert_eq!(runs(&tiles, Scan::DOWN, 0, &quiet), [[0; 2]; 0]);
        assert_eq!(runs(&tiles, Scan::UP, 0, &quiet), [[0, 3]]);
        all_due(&mut tiles, [Scan::RIGHT, Scan::LEFT]);
        assert_eq!(runs(&tiles, Scan::RIGHT, 0, &quiet), [[0, 1]]);
    }
}

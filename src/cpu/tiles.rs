//! Tracks which parts of the grid a scan has to visit: those whose surroundings have changed since it last
//! looked at them, except where every point is still unreached.

use std::ops::Range;

use rayon::prelude::*;

use super::scan::Scan;
use crate::surface::{Block, Chart, Direction, Tiling};

/// Number of points on a side of a tile. A front moves at most one point per line. So within a band of `TILE`
/// lines it moves at most to the neighbouring tile.
pub(super) const TILE: usize = 16;

/// The flags of all scans.
const ALL: u8 = 0b11110;

/// The tiles of the grid, with flags of scans for each.
#[derive(Clone, Debug)]
pub(super) struct Tiles {
    tiling: Tiling,
    /// The chart of the tiles.
    chart: Chart,
    /// Scans that have yet to see the tile's last change.
    pending: Vec<u8>,
    /// Scans of the current pair that have to examine the tile, which is beside or ahead of such a change.
    beside: Vec<u8>,
    /// Scans of the current pair that have work in the tile.
    due: Vec<u8>,
}

impl Tiles {
    pub(super) fn new(chart: Chart) -> Self {
        let tiling = Tiling::new(chart, TILE);
        let none = || vec![0; tiling.tiles().points()];
        Self { tiling, chart: tiling.tiles(), pending: none(), beside: none(), due: none() }
    }

    /// Returns the positions of the tiles.
    pub(super) fn tiling(&self) -> Tiling {
        self.tiling
    }

    /// Returns the number of bytes held.
    pub(super) fn bytes(&self) -> usize {
        self.pending.len() + self.beside.len() + self.due.len()
    }

    /// Returns the number of tiles.
    pub(super) fn len(&self) -> usize {
        self.pending.len()
    }

    /// Forgets all changes.
    pub(super) fn reset(&mut self) {
        self.pending.fill(0);
    }

    /// Notes that a point has changed and that no scan has seen the change.
    pub(super) fn touch(&mut self, row: usize, col: usize) {
        let ((row, col), _) = self.tiling.tile_of((row, col));
        self.pending[self.chart.index(row, col)] = ALL;
    }

    /// Returns the bands of tiles that a scan passes, in its order.
    pub(super) fn bands(&self, scan: Scan) -> impl Iterator<Item = usize> + use<> {
        scan.in_order(0..self.chart.by(scan.lines()).rows)
    }

    /// Returns the number of tiles in a band.
    pub(super) fn in_band(&self, scan: Scan) -> usize {
        self.chart.by(scan.lines()).cols
    }

    /// Returns the index of a tile, given its band and its place in the band.
    pub(super) fn index(&self, scan: Scan, band: usize, place: usize) -> usize {
        let (row, col) = scan.lines().place(band, place);
        self.chart.index(row, col)
    }

    /// Returns the points of a stretch of a band, as a block whose rows are the scan's lines.
    pub(super) fn lines(&self, scan: Scan, band: usize, run: Range<usize>) -> Block {
        let tiles = Block { rows: band..band + 1, cols: run };
        self.tiling.points(tiles.by(scan.lines())).by(scan.lines())
    }

    /// Returns the tiles in which a scan may have to follow a change of `tile`: the tile itself, and those
    /// beside and ahead of it.
    fn followed(&self, scan: Scan, tile: usize) -> impl Iterator<Item = usize> + use<> {
        let (chart, (row, col), behind) = (self.chart, self.chart.position(tile), scan.behind());
        let to = Direction::ALL.into_iter().filter(move |to| !behind.contains(to));
        let beside = to.filter_map(move |to| chart.neighbour(row, col, to));
        std::iter::once(tile).chain(beside.map(move |(row, col)| chart.index(row, col)))
    }

    /// Returns, for each row of tiles, the scans of a pair that have to examine each tile: those beside or
    /// ahead of a changed tile. The second slice of each row takes the scans that have work there. It is
    /// cleared first.
    pub(super) fn rows_beside_changes(
        &mut self,
        scans: [Scan; 2],
    ) -> impl IndexedParallelIterator<Item = (&[u8], &mut [u8])> {
        self.beside.fill(0);
        self.due.fill(0);
        let both = scans[0].bit() | scans[1].bit();
        let changed = self.pending.iter().enumerate().filter(|(_, pending)| *pending & both != 0);
        for (tile, pending) in changed {
            for scan in scans.into_iter().filter(|scan| pending & scan.bit() != 0) {
                for tile in self.followed(scan, tile) {
                    self.beside[tile] |= scan.bit();
                }
            }
        }
        let cols = self.chart.cols;
        self.beside.par_chunks(cols).zip(self.due.par_chunks_mut(cols))
    }

    /// Finds the stretches of a band that a scan has to visit: those beside tiles that are due, and those
    /// ahead of tiles that the scan has changed.
    pub(super) fn runs(
        &self,
        scan: Scan,
        band: usize,
        changed: &[bool],
        runs: &mut Vec<Range<usize>>,
    ) {
        runs.clear();
        let (tiles, back) = (self.chart.by(scan.lines()), scan.over_lines().back());
        let behind = tiles.neighbour(band, 0, back).map(|(behind, _)| behind);
        let news = |place: usize| {
            self.due[self.index(scan, band, place)] & scan.bit() != 0
                || behind.is_some_and(|behind| changed[self.index(scan, behind, place)])
        };
        for place in (0..tiles.cols).filter(|&place| news(place)) {
            let Range { start, end } = tiles.around((band, place), 1).cols;
            match runs.last_mut() {
                Some(last) if last.end >= start => last.end = end,
                _ => runs.push(start..end),
            }
        }
    }

    /// Notes that two scans have passed and which tiles they have changed. Each sees the other's changes only
    /// now.
    pub(super) fn passed(&mut self, scans: [Scan; 2], changed: [&[bool]; 2]) {
        let seen = !(scans[0].bit() | scans[1].bit());
        for (tile, pending) in self.pending.iter_mut().enumerate() {
            *pending &= seen;
            for (scan, changed) in scans.iter().zip(changed) {
                if changed[tile] {
                    *pending |= ALL & !scan.bit();
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn runs(tiles: &Tiles, scan: Scan, band: usize, changed: &[bool]) -> Vec<[usize; 2]> {
        let mut runs = Vec::new();
        tiles.runs(scan, band, changed, &mut runs);
        runs.into_iter().map(|run| [run.start, run.end]).collect()
    }

    /// Marks all tiles that a scan has to examine as due.
    fn all_due(tiles: &mut Tiles, scans: [Scan; 2]) {
        tiles.rows_beside_changes(scans).for_each(|(beside, due)| due.copy_from_slice(beside));
    }

    #[test]
    fn a_scan_visits_what_lies_beside_and_ahead_of_a_change() {
        let mut tiles = Tiles::new(Chart { rows: 70, cols: 160 });
        tiles.touch(40, 100);
        let quiet = vec![false; tiles.len()];
        // The source lies in tile 2, 6. A scan may go on beside tiles that are due.
        all_due(&mut tiles, [Scan::DOWN, Scan::UP]);
        assert_eq!(runs(&tiles, Scan::DOWN, 1, &quiet), [[0; 2]; 0]);
        assert_eq!(runs(&tiles, Scan::DOWN, 2, &quiet), [[4, 9]]);
        assert_eq!(runs(&tiles, Scan::DOWN, 3, &quiet), [[4, 9]]);
        assert_eq!(runs(&tiles, Scan::DOWN, 4, &quiet), [[0; 2]; 0]);
        assert_eq!(runs(&tiles, Scan::UP, 1, &quiet), [[4, 9]]);
        assert_eq!(runs(&tiles, Scan::UP, 3, &quiet), [[0; 2]; 0]);
        let mut changed = quiet.clone();
        changed[tiles.index(Scan::DOWN, 2, 1)] = true;
        assert_eq!(runs(&tiles, Scan::DOWN, 3, &changed), [[0, 3], [4, 9]]);
        assert_eq!(runs(&tiles, Scan::DOWN, 2, &changed), [[4, 9]]);
        all_due(&mut tiles, [Scan::RIGHT, Scan::LEFT]);
        assert_eq!(runs(&tiles, Scan::LEFT, 5, &quiet), [[0, 5]]);
        assert_eq!(runs(&tiles, Scan::LEFT, 7, &quiet), [[0; 2]; 0]);
        assert_eq!(runs(&tiles, Scan::RIGHT, 7, &quiet), [[0, 5]]);
        assert_eq!(runs(&tiles, Scan::DOWN, 2, &quiet), [[0; 2]; 0]);
    }

    #[test]
    fn what_is_not_due_is_visited_after_changes_alone() {
        let mut tiles = Tiles::new(Chart { rows: 70, cols: 160 });
        tiles.touch(40, 100);
        let mut changed = vec![false; tiles.len()];
        tiles.rows_beside_changes([Scan::DOWN, Scan::UP]).for_each(|_| {});
        assert_eq!(runs(&tiles, Scan::DOWN, 3, &changed), [[0; 2]; 0]);
        changed[tiles.index(Scan::DOWN, 2, 6)] = true;
        assert_eq!(runs(&tiles, Scan::DOWN, 3, &changed), [[5, 8]]);
    }

    #[test]
    fn what_a_scan_has_changed_is_pending_for_the_others() {
        let mut tiles = Tiles::new(Chart { rows: 16, cols: 64 });
        tiles.touch(3, 3);
        let (quiet, down) = (vec![false; 4], vec![true, false, false, false]);
        tiles.passed([Scan::DOWN, Scan::UP], [&down, &quiet]);
        all_due(&mut tiles, [Scan::DOWN, Scan::UP]);
        assert_eq!(runs(&tiles, Scan::DOWN, 0, &quiet), [[0; 2]; 0]);
        assert_eq!(runs(&tiles, Scan::UP, 0, &quiet), [[0, 3]]);
        all_due(&mut tiles, [Scan::RIGHT, Scan::LEFT]);
        assert_eq!(runs(&tiles, Scan::RIGHT, 0, &quiet), [[0, 1]]);
    }
}

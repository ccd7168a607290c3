//! Which parts of the grid a scan has to visit: those whose surroundings have changed since it
//! looked at them last, and none where every point is still unreached.

use std::ops::Range;

use rayon::prelude::*;

use crate::surface::{Chart, Direction};

/// Points on a side of a tile. A front moves one point a line, so within a band of as many lines
/// it leaves a tile for the next at most.
pub(super) const TILE: usize = 16;

/// The four scans of an iteration, numbered from 1: down, up, right and left.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Scan(pub u8);

impl Scan {
    pub(super) const DOWN: Self = Self(1);
    pub(super) const UP: Self = Self(2);
    pub(super) const RIGHT: Self = Self(3);
    pub(super) const LEFT: Self = Self(4);
    pub(super) const ALL: [Self; 4] = [Self::DOWN, Self::UP, Self::RIGHT, Self::LEFT];

    /// Whether lines are rows.
    pub(super) fn by_rows(self) -> bool {
        self.0 <= 2
    }

    /// Whether lines are passed in the order of their index.
    pub(super) fn is_forward(self) -> bool {
        self.0 % 2 == 1
    }

    /// Rows and columns from a line to the next.
    pub(super) fn ahead(self) -> [isize; 2] {
        let (row, col) = self.back().opposite().step();
        [row, col]
    }

    /// From a point to that beside it on the line behind.
    pub(super) fn back(self) -> Direction {
        match self {
            Self::DOWN => Direction::North,
            Self::UP => Direction::South,
            Self::RIGHT => Direction::West,
            _ => Direction::East,
        }
    }

    /// From a point to the three neighbours that the scan has just passed, in the order in which these lie
    /// on their line.
    pub(super) fn behind(self) -> [Direction; 3] {
        let back = self.back();
        match self {
            Self::DOWN | Self::LEFT => [back.next(), back, back.previous()],
            _ => [back.previous(), back, back.next()],
        }
    }

    /// The scan by rows that passes lines in the same order: this one, if columns are turned into rows.
    pub(super) fn over_lines(self) -> Self {
        if self.is_forward() { Self::DOWN } else { Self::UP }
    }

    /// Its flag.
    pub(super) fn bit(self) -> u8 {
        1 << self.0
    }
}

/// Flags of all scans.
const ALL: u8 = 0b11110;

/// Tiles of the grid, with flags of scans for each.
#[derive(Clone, Debug)]
pub(super) struct Tiles {
    rows: usize,
    cols: usize,
    /// Those that have yet to see its last change.
    pending: Vec<u8>,
    /// Those of the two at hand that have to look at it, beside or ahead of such a change.
    beside: Vec<u8>,
    /// Those of them that have something to do there.
    due: Vec<u8>,
}

impl Tiles {
    pub(super) fn new(chart: Chart) -> Self {
        let (rows, cols) = (chart.rows.div_ceil(TILE), chart.cols.div_ceil(TILE));
        let none = || vec![0; rows * cols];
        Self { rows, cols, pending: none(), beside: none(), due: none() }
    }

    /// Bytes held.
    pub(super) fn bytes(&self) -> usize {
        self.pending.len() + self.beside.len() + self.due.len()
    }

    /// Number of tiles.
    pub(super) fn len(&self) -> usize {
        self.pending.len()
    }

    /// Forgets all changes.
    pub(super) fn reset(&mut self) {
        self.pending.fill(0);
    }

    /// A point has changed, and no scan has seen it.
    pub(super) fn touch(&mut self, row: usize, col: usize) {
        self.pending[row / TILE * self.cols + col / TILE] = ALL;
    }

    /// The bands of tiles that a scan passes, in its order.
    pub(super) fn bands(&self, scan: Scan) -> impl Iterator<Item = usize> + use<> {
        let count = if scan.by_rows() { self.rows } else { self.cols };
        let last = count - 1;
        (0..count).map(move |k| if scan.is_forward() { k } else { last - k })
    }

    /// Tiles in a band.
    pub(super) fn in_band(&self, scan: Scan) -> usize {
        if scan.by_rows() { self.cols } else { self.rows }
    }

    /// Index of a tile, given its band and its place in it.
    pub(super) fn index(&self, scan: Scan, band: usize, place: usize) -> usize {
        if scan.by_rows() { band * self.cols + place } else { place * self.cols + band }
    }

    /// The tiles, by row and column, in which a scan may have to follow a change of one of them.
    fn followed(
        &self,
        scan: Scan,
        row: usize,
        col: usize,
    ) -> impl Iterator<Item = (usize, usize)> + use<> {
        let ahead = |at: usize, count: usize| {
            if scan.is_forward() { at..(at + 2).min(count) } else { at.saturating_sub(1)..at + 1 }
        };
        let beside = |at: usize, count: usize| at.saturating_sub(1)..(at + 2).min(count);
        let (rows, cols) = if scan.by_rows() {
            (ahead(row, self.rows), beside(col, self.cols))
        } else {
            (beside(row, self.rows), ahead(col, self.cols))
        };
        rows.flat_map(move |row| cols.clone().map(move |col| (row, col)))
    }

    /// For each row of tiles, which of two scans have to look at each of them: what lies beside or
    /// ahead of a tile that has changed; and room to say which have something to do, where nothing
    /// is due yet.
    pub(super) fn rows_beside_changes(
        &mut self,
        scans: [Scan; 2],
    ) -> impl IndexedParallelIterator<Item = (&[u8], &mut [u8])> {
        self.beside.fill(0);
        self.due.fill(0);
        let both = scans[0].bit() | scans[1].bit();
        let changed = self.pending.iter().enumerate().filter(|(_, pending)| *pending & both != 0);
        for (tile, pending) in changed {
            let (row, col) = (tile / self.cols, tile % self.cols);
            for scan in scans.into_iter().filter(|scan| pending & scan.bit() != 0) {
                for (row, col) in self.followed(scan, row, col) {
                    self.beside[row * self.cols + col] |= scan.bit();
                }
            }
        }
        self.beside.par_chunks(self.cols).zip(self.due.par_chunks_mut(self.cols))
    }

    /// The stretches of a band that a scan has to visit: beside tiles where something is due, and
    /// ahead of those that it has changed.
    pub(super) fn runs(
        &self,
        scan: Scan,
        band: usize,
        changed: &[bool],
        runs: &mut Vec<Range<usize>>,
    ) {
        runs.clear();
        let behind = if scan.is_forward() { band.checked_sub(1) } else { Some(band + 1) };
        let count = if scan.by_rows() { self.rows } else { self.cols };
        let behind = behind.filter(|&behind| behind < count);
        let news = |place: usize| {
            self.due[self.index(scan, band, place)] & scan.bit() != 0
                || behind.is_some_and(|behind| changed[self.index(scan, behind, place)])
        };
        let places = self.in_band(scan);
        for place in (0..places).filter(|&place| news(place)) {
            let (start, end) = (place.saturating_sub(1), (place + 2).min(places));
            match runs.last_mut() {
                Some(last) if last.end >= start => last.end = end,
                _ => runs.push(start..end),
            }
        }
    }

    /// Two scans, seeing one another's changes only now, have passed and changed these tiles.
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

/// The points of some tiles, of `count` in a row or column.
pub(super) fn points(tiles: Range<usize>, count: usize) -> Range<usize> {
    tiles.start * TILE..(tiles.end * TILE).min(count)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn runs(tiles: &Tiles, scan: Scan, band: usize, changed: &[bool]) -> Vec<[usize; 2]> {
        let mut runs = Vec::new();
        tiles.runs(scan, band, changed, &mut runs);
        runs.into_iter().map(|run| [run.start, run.end]).collect()
    }

    /// Takes all that a scan has to look at for due.
    fn all_due(tiles: &mut Tiles, scans: [Scan; 2]) {
        tiles.rows_beside_changes(scans).for_each(|(beside, due)| due.copy_from_slice(beside));
    }

    #[test]
    fn a_scan_visits_what_lies_beside_and_ahead_of_a_change() {
        let mut tiles = Tiles::new(Chart { rows: 70, cols: 160 });
        tiles.touch(40, 100);
        let quiet = vec![false; tiles.len()];
        // The source lies in tile 2, 6; beside what is due a scan may follow.
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

//! Which parts of the grid a scan has to visit: those whose surroundings have changed since it
//! looked at them last, and none where every point is still unreached.

use std::ops::Range;

use crate::surface::Chart;

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

    /// Whether lines are rows.
    pub(super) fn by_rows(self) -> bool {
        self.0 <= 2
    }

    /// Whether lines are passed in the order of their index.
    pub(super) fn is_forward(self) -> bool {
        self.0 % 2 == 1
    }

    fn bit(self) -> u8 {
        1 << self.0
    }
}

/// Flags of all scans.
const ALL: u8 = 0b11110;

/// Tiles of the grid, and for each the scans that have yet to see its last change.
#[derive(Clone, Debug)]
pub(super) struct Tiles {
    rows: usize,
    cols: usize,
    pending: Vec<u8>,
}

impl Tiles {
    pub(super) fn new(chart: Chart) -> Self {
        let (rows, cols) = (chart.rows.div_ceil(TILE), chart.cols.div_ceil(TILE));
        Self { rows, cols, pending: vec![0; rows * cols] }
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

    /// The stretches of a band that a scan has to visit: beside tiles, in the band or behind it,
    /// that have changed, `changed` in this very scan.
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
            std::iter::once(band).chain(behind).any(|band| {
                let tile = self.index(scan, band, place);
                changed[tile] || self.pending[tile] & scan.bit() != 0
            })
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

#[cfg(test)]
mod tests {
    use super::*;

    fn runs(tiles: &Tiles, scan: Scan, band: usize, changed: &[bool]) -> Vec<[usize; 2]> {
        let mut runs = Vec::new();
        tiles.runs(scan, band, changed, &mut runs);
        runs.into_iter().map(|run| [run.start, run.end]).collect()
    }

    #[test]
    fn a_scan_visits_what_lies_beside_and_ahead_of_a_change() {
        let mut tiles = Tiles::new(Chart { rows: 70, cols: 160 });
        tiles.touch(40, 100);
        let quiet = vec![false; tiles.len()];
        // The source lies in tile 2, 6.
        assert_eq!(runs(&tiles, Scan::DOWN, 1, &quiet), [[0; 2]; 0]);
        assert_eq!(runs(&tiles, Scan::DOWN, 2, &quiet), [[5, 8]]);
        assert_eq!(runs(&tiles, Scan::DOWN, 3, &quiet), [[5, 8]]);
        assert_eq!(runs(&tiles, Scan::UP, 1, &quiet), [[5, 8]]);
        assert_eq!(runs(&tiles, Scan::LEFT, 5, &quiet), [[1, 4]]);
        let mut changed = quiet.clone();
        changed[tiles.index(Scan::DOWN, 3, 1)] = true;
        assert_eq!(runs(&tiles, Scan::DOWN, 4, &changed), [[0, 3]]);
        assert_eq!(runs(&tiles, Scan::DOWN, 3, &changed), [[0, 3], [5, 8]]);
    }

    #[test]
    fn what_a_scan_has_changed_is_pending_for_the_others() {
        let mut tiles = Tiles::new(Chart { rows: 16, cols: 48 });
        tiles.touch(3, 3);
        let (quiet, down) = (vec![false; 3], vec![true, false, false]);
        tiles.passed([Scan::DOWN, Scan::UP], [&down, &quiet]);
        assert_eq!(runs(&tiles, Scan::DOWN, 0, &quiet), [[0; 2]; 0]);
        assert_eq!(runs(&tiles, Scan::UP, 0, &quiet), [[0, 2]]);
        assert_eq!(runs(&tiles, Scan::RIGHT, 0, &quiet), [[0, 1]]);
    }
}

//! Tracks the points that a scan has to visit: the points beside a change that the scan has not seen yet.

use std::sync::Arc;

use super::farther::Farther;
use super::marks::{Marks, WORD};
use crate::scan::Scan;
use geosweep_surface::{Chart, Lines};

/// The points that each scan has to visit. All maps of a batch share them, since their sources are
/// neighbours.
#[derive(Clone, Debug)]
pub(super) struct Pending {
    chart: Chart,
    /// Points to visit for each scan, indexed by the number of the scan less one. Lines are those of the scan.
    visits: [Marks; 4],
    /// Points that the current scan has changed, by rows and by columns.
    changed: [Marks; 2],
    /// Number of known points, which are never visited: the first ones in row-major order.
    known: usize,
    /// Shared by all batches of a surface.
    farther: Arc<Farther>,
}

impl Pending {
    pub(super) fn new(chart: Chart, farther: Arc<Farther>) -> Self {
        let [by_rows, by_cols] = [chart, chart.transposed()].map(Marks::none);
        Self {
            chart,
            visits: [by_rows.clone(), by_rows.clone(), by_cols.clone(), by_cols.clone()],
            changed: [by_rows, by_cols],
            known: 0,
            farther,
        }
    }

    pub(super) fn bytes(chart: Chart) -> usize {
        3 * (Marks::bytes(chart) + Marks::bytes(chart.transposed()))
    }

    /// Forgets all changes and marks all points to be visited except the first `known` ones in row-major order, whose
    /// distances are known.
    pub(super) fn start(&mut self, known: usize) {
        self.known = known;
        self.visits.iter_mut().for_each(|visits| visits.fill(known > 0));
        self.changed.iter_mut().for_each(|changed| changed.fill(false));
    }

    /// Notes that a point has changed and that no scan has seen the change.
    pub(super) fn touch(&mut self, row: usize, col: usize) {
        for scan in [Scan::DOWN, Scan::RIGHT] {
            let (line, point) = scan.lines().place(row, col);
            self.changed[kind(scan)].mark(line, point);
            self.tell(scan, line);
            self.changed[kind(scan)].line_mut(line).fill(0);
        }
    }

    /// Takes the points of a line that a scan has to visit, or returns `None` if there are none. The scan must unmark
    /// the points that it does not change, and then call [`Self::tell`]. Unless it visits the points in all maps
    /// (`all_maps`), they stay pending for another visit.
    pub(super) fn take(&mut self, scan: Scan, line: usize, all_maps: bool) -> Option<&mut [u64]> {
        let first = scan.lines().before(self.chart, line, self.known);
        let end = self.chart.by(scan.lines()).cols;
        let visits = self.visits[index(scan)].line_mut(line);
        let taken = self.changed[kind(scan)].line_mut(line);
        for (k, (taken, visits)) in taken.iter_mut().zip(visits).enumerate() {
            let below = |point: usize| match point.saturating_sub(k * WORD) {
                bits if bits < WORD => (1 << bits) - 1,
                _ => u64::MAX,
            };
            *taken = *visits & below(end) & !below(first);
            if all_maps {
                *visits = 0;
            }
        }
        taken.iter().any(|&word| word != 0).then_some(taken)
    }

    /// Marks further points of a line that the current scan has changed.
    pub(super) fn changed_too(&mut self, scan: Scan, line: usize, changed: &[u64]) {
        let all = self.changed[kind(scan)].line_mut(line);
        all.iter_mut().zip(changed).for_each(|(all, changed)| *all |= changed);
    }

    /// Reports the changes on a line to both scans over lines of this kind (rows or columns).
    pub(super) fn tell(&mut self, scan: Scan, line: usize) {
        let changed = self.changed[kind(scan)].line(line);
        let over = match scan.lines() {
            Lines::Rows => [Scan::DOWN, Scan::UP],
            Lines::Cols => [Scan::RIGHT, Scan::LEFT],
        };
        let lines = self.chart.by(scan.lines());
        for concern in self.farther.of(scan.lines(), line, changed) {
            self.visits[index(concern.scan())].mark(concern.line as usize, concern.point as usize);
        }
        for scan in over {
            let ahead = scan.over_lines().back().opposite();
            if let Some((next, _)) = lines.neighbour(line, 0, ahead) {
                self.visits[index(scan)].spread(next, changed);
            }
        }
    }

    /// Ends a scan. Reports its changes to the scans over lines of the other kind.
    pub(super) fn end(&mut self, scan: Scan) {
        let [rows, cols] = &mut self.changed;
        let turned = match scan.lines() {
            Lines::Rows => {
                rows.transpose_into(cols);
                Scan::RIGHT
            }
            Lines::Cols => {
                cols.transpose_into(rows);
                Scan::DOWN
            }
        };
        (0..self.chart.by(turned.lines()).rows).for_each(|line| self.tell(turned, line));
        self.changed.iter_mut().for_each(|changed| changed.fill(false));
    }
}

/// Returns 0 if the lines of a scan are rows, and 1 if they are columns.
fn kind(scan: Scan) -> usize {
    scan.lines() as usize
}

fn index(scan: Scan) -> usize {
    usize::from(scan.0) - 1
}

//! Which points a scan has to visit: those beside a change that it has not seen yet.

use crate::cpu::tiles::Scan;
use crate::surface::Chart;

/// Points of a line, or lines, from `start` to before `end`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Span {
    pub start: usize,
    pub end: usize,
}

impl Span {
    pub(super) const EMPTY: Self = Self { start: usize::MAX, end: 0 };

    pub(super) fn one(at: usize) -> Self {
        Self { start: at, end: at + 1 }
    }

    pub(super) fn is_empty(self) -> bool {
        self.start >= self.end
    }

    pub(super) fn join(&mut self, other: Self) {
        *self = Self { start: self.start.min(other.start), end: self.end.max(other.end) };
    }

    /// With the neighbours on both sides.
    fn grown(self) -> Self {
        Self { start: self.start.saturating_sub(1), end: self.end + 1 }
    }
}

/// For each scan and each of its lines the points that it has to visit. All maps of a batch share
/// these, since their sources are neighbours.
#[derive(Clone, Debug)]
pub(super) struct Pending {
    chart: Chart,
    /// By the number of the scan, less one.
    lines: [Vec<Span>; 4],
    /// Points before this one, row-major, are known and never visited.
    known: usize,
}

/// The part of the grid that a scan has changed.
#[derive(Clone, Copy, Debug)]
pub(super) struct Change {
    pub lines: Span,
    pub points: Span,
}

impl Change {
    pub(super) const NONE: Self = Self { lines: Span::EMPTY, points: Span::EMPTY };
}

impl Pending {
    pub(super) fn new(chart: Chart) -> Self {
        let (rows, cols) = (vec![Span::EMPTY; chart.rows], vec![Span::EMPTY; chart.cols]);
        Self { chart, lines: [rows.clone(), rows, cols.clone(), cols], known: 0 }
    }

    /// Forgets all changes; points before `known`, row-major, are as they are, and everything
    /// after them has yet to hear of them.
    pub(super) fn start(&mut self, known: usize) {
        self.known = known;
        for scan in SCANS {
            let whole = Span { start: 0, end: self.points(scan) };
            let pending = if known > 0 { whole } else { Span::EMPTY };
            self.lines[scan.0 as usize - 1].fill(pending);
        }
    }

    /// A point has changed, and no scan has seen it.
    pub(super) fn touch(&mut self, row: usize, col: usize) {
        let (row, col) = (Span::one(row), Span::one(col));
        self.changed(Scan::DOWN, Change { lines: row, points: col });
        self.changed(Scan::RIGHT, Change { lines: col, points: row });
    }

    /// Takes the points of a line that a scan has to visit.
    pub(super) fn take(&mut self, scan: Scan, line: usize) -> Span {
        let span = std::mem::replace(&mut self.lines[scan.0 as usize - 1][line], Span::EMPTY);
        let end = span.end.min(self.points(scan));
        Span { start: span.start.max(self.first_unknown(scan, line)), end }
    }

    /// Lines have changed: tells both scans over lines of this kind.
    pub(super) fn changed(&mut self, scan: Scan, change: Change) {
        let Change { lines, points } = change;
        let [forward, backward] = if scan.by_rows() { [0, 1] } else { [2, 3] };
        for line in lines.start..lines.end {
            if let Some(next) = self.lines[forward].get_mut(line + 1) {
                next.join(points.grown());
            }
            if line > 0 {
                self.lines[backward][line - 1].join(points.grown());
            }
        }
    }

    /// Number of lines of a scan.
    pub(super) fn lines(&self, scan: Scan) -> usize {
        if scan.by_rows() { self.chart.rows } else { self.chart.cols }
    }

    fn points(&self, scan: Scan) -> usize {
        if scan.by_rows() { self.chart.cols } else { self.chart.rows }
    }

    fn first_unknown(&self, scan: Scan, line: usize) -> usize {
        if scan.by_rows() {
            self.known.saturating_sub(line * self.chart.cols)
        } else {
            self.known.saturating_sub(line).div_ceil(self.chart.cols)
        }
    }
}

/// The scans of an iteration, in their order (paper, figure 3, second row).
pub(super) const SCANS: [Scan; 4] = [Scan::DOWN, Scan::UP, Scan::RIGHT, Scan::LEFT];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_source_wakes_its_neighbours_and_nothing_else() {
        let mut pending = Pending::new(Chart { rows: 4, cols: 5 });
        pending.start(0);
        pending.touch(1, 4);
        assert_eq!(pending.take(Scan::DOWN, 2), Span { start: 3, end: 5 });
        assert_eq!(pending.take(Scan::UP, 0), Span { start: 3, end: 5 });
        assert_eq!(pending.take(Scan::LEFT, 3), Span { start: 0, end: 3 });
        for scan in SCANS {
            assert!((0..pending.lines(scan)).all(|line| pending.take(scan, line).is_empty()));
        }
    }

    #[test]
    fn known_points_are_not_visited() {
        let chart = Chart { rows: 4, cols: 5 };
        for known in 1..=20 {
            for scan in SCANS {
                let mut pending = Pending::new(chart);
                pending.start(known);
                let mut visited = Vec::new();
                for line in 0..pending.lines(scan) {
                    let Span { start, end } = pending.take(scan, line);
                    let index = |point| match scan.by_rows() {
                        true => chart.index(line, point),
                        false => chart.index(point, line),
                    };
                    visited.extend((start..end).map(index));
                }
                visited.sort();
                assert_eq!(visited, (known..20).collect::<Vec<_>>());
            }
        }
    }
}

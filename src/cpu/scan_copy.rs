//! A copy of the fronts for one of two opposite scans, and the scan itself: band by band, line by line.

use std::ops::Range;

use super::behind::Behind;
use super::fronts::FrontKind;
use super::line::{GridLines, LinesInGrid};
use super::line_update::{How, Updated};
use super::panel::{Grid, Panel};
use super::tiles::{Scan, Tiles, points};
use crate::surface::{Chart, Real};
use crate::update::Carried;

/// The fronts at all points as one scan sees them, and its work space.
#[derive(Clone, Debug)]
pub(super) struct ScanCopy<R, C, G> {
    /// Arrival times, and what fronts carry, as bordered arrays.
    pub times: Vec<R>,
    pub carried: Vec<C>,
    /// The tiles that the scan has changed.
    pub changed: Vec<bool>,
    pub panel: Panel<R, C, G>,
    /// The stretches of a band to visit, and the tiles of one of them that have changed.
    runs: Vec<Range<usize>>,
    marks: Vec<bool>,
    /// Visits and updates of a point since the start.
    pub visits: u64,
    pub updates: u64,
}

impl<R: Real, C: Carried, G: bytemuck::Pod> ScanCopy<R, C, G> {
    pub(super) fn new(chart: Chart, tiles: &Tiles, needs_edges: bool) -> Self {
        let points = chart.bordered_points();
        let longest_band = tiles.in_band(Scan::DOWN).max(tiles.in_band(Scan::RIGHT));
        Self {
            times: vec![R::FAR; points],
            carried: vec![C::default(); points],
            changed: vec![false; tiles.len()],
            panel: Panel::new(chart, needs_edges),
            runs: Vec::with_capacity(longest_band),
            marks: Vec::with_capacity(longest_band),
            visits: 0,
            updates: 0,
        }
    }

    /// Bytes held.
    pub(super) fn bytes(&self) -> usize {
        std::mem::size_of_val(self.times.as_slice())
            + std::mem::size_of_val(self.carried.as_slice())
            + self.changed.len()
            + self.panel.bytes()
    }

    /// No point reached.
    pub(super) fn forget(&mut self) {
        (self.visits, self.updates) = (0, 0);
        self.times.fill(R::FAR);
        self.carried.fill(C::default());
    }

    /// Visits the tiles where something is due, and those ahead of its changes; returns the largest change.
    pub(super) fn scan<'a, K: FrontKind<'a, R, Carried = C, Ground = G>>(
        &mut self,
        kind: &K,
        grid: Grid<R, G>,
        tiles: &Tiles,
        how: How,
    ) -> R::Bits {
        let mut updated = Updated::<R::Bits>::default();
        let mut runs = std::mem::take(&mut self.runs);
        for band in tiles.bands(how.scan) {
            tiles.runs(how.scan, band, &self.changed, &mut runs);
            for run in &runs {
                updated = updated.and(if how.scan.by_rows() {
                    self.scan_rows(kind, grid, tiles, how, band, run)
                } else {
                    self.scan_cols(kind, grid, tiles, how, band, run)
                });
            }
        }
        self.runs = runs;
        self.updates += updated.points;
        updated.largest
    }

    /// Scans a stretch of the rows of a band.
    fn scan_rows<'a, K: FrontKind<'a, R, Carried = C, Ground = G>>(
        &mut self,
        kind: &K,
        grid: Grid<R, G>,
        tiles: &Tiles,
        how: How,
        band: usize,
        run: &Range<usize>,
    ) -> Updated<R::Bits> {
        let chart = grid.edges.chart();
        let first = tiles.index(how.scan, band, run.start);
        let changed = &mut self.changed[first..first + run.len()];
        let (rows, cols) = (points(band..band + 1, chart.rows), points(run.clone(), chart.cols));
        self.visits += (rows.len() * cols.len()) as u64;
        let mut lines = GridLines {
            stride: chart.stride(),
            behind: Behind::of(chart, how.scan),
            times: &mut self.times,
            carried: &mut self.carried,
            ground: grid.ground,
            edges: grid.edges.planes(),
            place: LinesInGrid { edges: grid.edges, first: 0, beyond: None },
        };
        in_order(rows, how.scan, |row| kind.update(&mut lines, row + 1, &cols, how, changed))
    }

    /// Scans a stretch of the columns of a band.
    fn scan_cols<'a, K: FrontKind<'a, R, Carried = C, Ground = G>>(
        &mut self,
        kind: &K,
        grid: Grid<R, G>,
        tiles: &Tiles,
        how: How,
        band: usize,
        run: &Range<usize>,
    ) -> Updated<R::Bits> {
        let chart = grid.edges.chart();
        let (rows, cols) = (points(run.clone(), chart.rows), points(band..band + 1, chart.cols));
        self.visits += (rows.len() * cols.len()) as u64;
        let panel = &mut self.panel;
        let fronts = (self.times.as_slice(), self.carried.as_slice());
        panel.load(grid, fronts, &cols, rows.clone(), how.scan, how.instructions);
        let first = panel.line(cols.start + 1);
        self.marks.clear();
        self.marks.resize(run.len(), false);
        let mut lines = panel.lines(grid, fronts, &rows, how.scan);
        let updated = in_order(cols.clone(), how.scan, |col| {
            kind.update(&mut lines, col - cols.start + first, &rows, how, &mut self.marks)
        });
        for (place, _) in run.clone().zip(&self.marks).filter(|(_, marked)| **marked) {
            self.changed[tiles.index(how.scan, band, place)] = true;
            let fronts = (self.times.as_mut_slice(), self.carried.as_mut_slice());
            let rows = points(place..place + 1, chart.rows);
            panel.store(fronts, chart.stride(), &cols, rows, how.instructions);
        }
        updated
    }
}

/// Updates lines in the order of a scan.
fn in_order<B: Ord + Default>(
    lines: Range<usize>,
    scan: Scan,
    update: impl FnMut(usize) -> Updated<B>,
) -> Updated<B> {
    let none = Updated::default();
    if scan.is_forward() {
        lines.map(update).fold(none, Updated::and)
    } else {
        lines.rev().map(update).fold(none, Updated::and)
    }
}

//! Holds a copy of the fronts for one of two opposite scans, and runs the scan: band by band, line by line.

use std::ops::Range;

use super::behind::Behind;
use super::fronts::FrontKind;
use super::line::{GridLines, LinesInGrid};
use super::line_update::{How, Updated};
use super::panel::{Grid, Panel};
use super::scan::Scan;
use super::tiles::Tiles;
use crate::surface::{Block, Chart, Real};
use crate::update::Carried;

/// The fronts at all points as one scan sees them, and the scan's working memory.
#[derive(Clone, Debug)]
pub(super) struct ScanCopy<R, C, G> {
    /// Arrival times and the data that fronts carry, as bordered arrays.
    pub times: Vec<R>,
    pub carried: Vec<C>,
    /// Flags of the tiles that the scan has changed.
    pub changed: Vec<bool>,
    pub panel: Panel<R, C, G>,
    /// The stretches of a band to visit, and flags of the tiles of one stretch that have changed.
    runs: Vec<Range<usize>>,
    marks: Vec<bool>,
    /// Number of visits and updates of a point since the start of the map.
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

    /// Returns the number of bytes held.
    pub(super) fn bytes(&self) -> usize {
        std::mem::size_of_val(self.times.as_slice())
            + std::mem::size_of_val(self.carried.as_slice())
            + self.changed.len()
            + self.panel.bytes()
    }

    /// Resets all points to unreached.
    pub(super) fn forget(&mut self) {
        (self.visits, self.updates) = (0, 0);
        self.times.fill(R::FAR);
        self.carried.fill(C::default());
    }

    /// Visits the tiles that are due, and those ahead of the scan's own changes. Returns the largest change.
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
                updated = updated.and(self.scan_run(kind, grid, tiles, how, band, run));
            }
        }
        self.runs = runs;
        self.updates += updated.points;
        updated.largest
    }

    /// Scans a stretch of a band.
    fn scan_run<'a, K: FrontKind<'a, R, Carried = C, Ground = G>>(
        &mut self,
        kind: &K,
        grid: Grid<R, G>,
        tiles: &Tiles,
        how: How,
        band: usize,
        run: &Range<usize>,
    ) -> Updated<R::Bits> {
        let (chart, scan) = (grid.edges.chart(), how.scan);
        let points = |run| tiles.lines(scan, band, run);
        let Block { rows: lines, cols: along } = points(run.clone());
        self.visits += (lines.len() * along.len()) as u64;
        self.marks.clear();
        self.marks.resize(run.len(), false);
        let marks = &mut self.marks;
        let mut update = |here: &mut GridLines<R, C, G>| {
            let update = |line| kind.update(here, here.number(line), &along, how, marks);
            scan.in_order(lines.clone()).map(update).fold(Updated::default(), Updated::and)
        };
        let changed = |place| tiles.index(scan, band, place);
        if scan.by_rows() {
            let updated = update(&mut GridLines {
                stride: chart.stride(),
                behind: Behind::of(chart, scan),
                times: &mut self.times,
                carried: &mut self.carried,
                ground: grid.ground,
                edges: grid.edges.planes(),
                place: LinesInGrid { edges: grid.edges, first: 0, beyond: None },
            });
            marked(run, &self.marks).for_each(|place| self.changed[changed(place)] = true);
            return updated;
        }
        let panel = &mut self.panel;
        let fronts = (self.times.as_slice(), self.carried.as_slice());
        panel.load(grid, fronts, &points(run.clone()).by(scan.lines()), scan, how.instructions);
        let updated = update(&mut panel.lines(grid, fronts, &along, scan));
        for place in marked(run, &self.marks) {
            self.changed[changed(place)] = true;
            let fronts = (self.times.as_mut_slice(), self.carried.as_mut_slice());
            let points = points(place..place + 1).by(scan.lines());
            panel.store(fronts, chart, points, how.instructions);
        }
        updated
    }
}

/// Returns those of `tiles` that are marked.
fn marked<'a>(tiles: &Range<usize>, marks: &'a [bool]) -> impl Iterator<Item = usize> + use<'a> {
    tiles.clone().zip(marks).filter(|&(_, &marked)| marked).map(|(tile, _)| tile)
}

//! Fronts of a window as one scan sees them, and the run of the scan: band by band, line by line.

use std::ops::Range;

use super::changed::Changed;
use super::line_update::{Updated, update_line};
use super::panel::{Grid, Panel};
use super::tiles::Tiles;
use crate::behind::Behind;
use crate::fronts::LaneKind;
use crate::lines::line::{Beyond, GridLines, LinesInGrid};
use crate::lines::window::{Fronts, Window};
use crate::scan::{Scan, UpdateOptions};
use geosweep_surface::Monitor;
use geosweep_surface::update::Carried;
use geosweep_surface::{Block, Chart, Real};

/// The fronts at all points of a window as one scan sees them, and the scan's working memory.
#[derive(Clone, Debug)]
pub(crate) struct ScanCopy<R, C> {
    pub window: Window,
    /// Arrival times and the data that fronts carry, as bordered arrays.
    pub times: Vec<R>,
    pub carried: Vec<C>,
    /// Change of each tile by the scan.
    pub changed: Vec<Changed>,
    /// Working memory: the spans of a band to visit, and the changes of the tiles in one span.
    runs: Vec<Range<usize>>,
    marks: Vec<Changed>,
    /// Numbers of visits and of updates of points since the start of the map.
    pub visits: u64,
    pub updates: u64,
}

/// Data that a scan needs besides the fronts of its window: the surface, a panel for columns, and the fronts of the
/// whole grid if the window is smaller.
pub(crate) struct On<'a, R, C, G> {
    pub grid: Grid<'a, R, G>,
    pub panel: &'a mut Panel<R, C, G>,
    pub far: Option<Fronts<'a, R, C>>,
    pub monitor: &'a Monitor,
}

impl<R: Real, C: Carried> ScanCopy<R, C> {
    pub(crate) fn new(window: Window, tiles: &Tiles) -> Self {
        let points = window.own().bordered_points();
        let longest_band = tiles.in_band(Scan::DOWN).max(tiles.in_band(Scan::RIGHT));
        Self {
            window,
            times: vec![R::FAR; points],
            carried: vec![C::default(); points],
            changed: vec![Changed::No; tiles.len()],
            runs: Vec::with_capacity(longest_band),
            marks: Vec::with_capacity(longest_band),
            visits: 0,
            updates: 0,
        }
    }

    /// Returns a copy with an empty window. It allocates no fronts.
    pub(crate) fn empty(grid: Chart) -> Self {
        let window = Window::new(grid, &Block { rows: 0..0, cols: 0..0 });
        Self {
            window,
            times: Vec::new(),
            carried: Vec::new(),
            changed: Vec::new(),
            runs: Vec::new(),
            marks: Vec::new(),
            visits: 0,
            updates: 0,
        }
    }

    /// Returns the number of bytes held.
    pub(crate) fn bytes(&self) -> usize {
        std::mem::size_of_val(self.times.as_slice())
            + std::mem::size_of_val(self.carried.as_slice())
            + self.changed.len()
    }

    /// Returns the fronts.
    pub(crate) fn fronts(&self) -> Fronts<'_, R, C> {
        Fronts { window: self.window, times: &self.times, carried: &self.carried }
    }

    /// Resets all points that have been reached to unreached. These points lie in the used tiles of `tiles`.
    pub(crate) fn forget(&mut self, tiles: &Tiles) {
        (self.visits, self.updates) = (0, 0);
        for Block { rows, cols } in tiles.used() {
            for row in rows {
                let first = self.window.index(row, cols.start);
                self.times[first..][..cols.len()].fill(R::FAR);
                self.carried[first..][..cols.len()].fill(C::default());
            }
        }
    }

    /// Runs a scan over the tiles that are due and over the tiles ahead of its own changes. Returns the largest change.
    pub(crate) fn scan<K: LaneKind<R, Carried = C>>(
        &mut self,
        kind: &K,
        on: On<'_, R, C, K::SurfaceData>,
        tiles: &Tiles,
        options: UpdateOptions,
    ) -> R::Bits {
        let mut on = on;
        let mut updated = Updated::<R::Bits>::default();
        let mut runs = std::mem::take(&mut self.runs);
        for band in tiles.bands(options.scan) {
            if on.monitor.is_cancelled() {
                break;
            }
            tiles.runs(options.scan, band, &self.changed, &mut runs);
            for run in &runs {
                updated = updated.and(self.scan_run(kind, &mut on, tiles, options, (band, run)));
            }
        }
        self.runs = runs;
        self.updates += updated.points;
        updated.largest
    }

    /// Scans a span of a band.
    fn scan_run<K: LaneKind<R, Carried = C>>(
        &mut self,
        kind: &K,
        On { grid, panel, far, .. }: &mut On<'_, R, C, K::SurfaceData>,
        tiles: &Tiles,
        options: UpdateOptions,
        (band, run): (usize, &Range<usize>),
    ) -> Updated<R::Bits> {
        let (grid, far, scan, window) = (*grid, *far, options.scan, self.window);
        let points = |run| tiles.lines(scan, band, run);
        let Block { rows: lines, cols: along } = points(run.clone());
        let visited = (lines.len() * along.len()) as u64;
        self.marks.clear();
        self.marks.resize(run.len(), Changed::No);
        let marks = &mut self.marks;
        let mut update = |here: &mut GridLines<R, C, K::SurfaceData>| {
            let update =
                |line| update_line(kind, here, here.place.number(line), &along, options, marks);
            scan.in_order(lines.clone()).map(update).fold(Updated::default(), Updated::and)
        };
        let changed = |place| tiles.index(scan, band, place);
        if scan.by_rows() {
            let fronts = (self.times.as_mut_slice(), self.carried.as_mut_slice());
            let updated = update(&mut rows(grid, window, fronts, far, scan));
            for (place, of_tile) in marked(run, &self.marks) {
                let changed = &mut self.changed[changed(place)];
                *changed = of_tile.max(*changed);
            }
            self.visits += visited - updated.beyond;
            return updated;
        }
        let fronts = Fronts { window, times: &self.times, carried: &self.carried };
        panel.load(grid, fronts, &points(run.clone()).by(scan.lines()), scan, options.instructions);
        let updated = update(&mut panel.lines(grid, [Some(fronts), far], &along, scan));
        self.visits += visited - updated.beyond;
        for (place, of_tile) in marked(run, &self.marks) {
            let changed = &mut self.changed[changed(place)];
            *changed = of_tile.max(*changed);
            let fronts = (self.times.as_mut_slice(), self.carried.as_mut_slice());
            let points = points(place..place + 1).by(scan.lines());
            panel.store(fronts, window, points, options.instructions);
        }
        updated
    }
}

/// Returns the rows of a window as lines.
fn rows<'a, R, C, G>(
    grid: Grid<'a, R, G>,
    window: Window,
    (times, carried): (&'a mut [R], &'a mut [C]),
    far: Option<Fronts<'a, R, C>>,
    scan: Scan,
) -> GridLines<'a, R, C, G>
where
    R: Real,
{
    let (chart, (first, before)) = (grid.edges.chart(), window.first());
    let Block { rows, cols } = window.block();
    let beyond = far.is_some().then(|| Beyond {
        points: cols.start + 1..cols.end + 1,
        lines: rows.start + 1..rows.end + 1,
        near: None,
        far,
    });
    GridLines {
        behind: Behind::of(chart, scan),
        times,
        carried,
        surface_data: grid.surface_data,
        edges: grid.edges.planes(),
        surface: (chart.stride(), first),
        place: LinesInGrid {
            edges: grid.edges,
            scan,
            stride: window.own().stride(),
            first,
            before,
            beyond,
        },
    }
}

/// Returns the changed ones of `tiles`, with their marks.
fn marked<'a>(
    tiles: &Range<usize>,
    marks: &'a [Changed],
) -> impl Iterator<Item = (usize, Changed)> + use<'a> {
    tiles.clone().zip(marks.iter().copied()).filter(|&(_, marked)| marked > Changed::No)
}

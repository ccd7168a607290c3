//! Advances several paths at once, in SIMD lanes, where they run on nearly straight. This costs a fraction of
//! a search.

use glam::DVec2;

use super::cell::{self, SIDES};
use super::edge_times::{Crossing, EdgeTimes};
use super::entry::Entry;
use super::search::{AT_POINT, fits, is_triangle};
use super::tracer::Tracer;
use geosweep_surface::Chart;
use geosweep_surface::lanes::{Instructions, Loop};

/// The number of paths that advance side by side. It is twice the width of the widest vectors in double
/// precision, so that one half computes while the other waits for square roots.
pub(super) const LANES: usize = 16;

/// A path whose line across a cell is shorter than this fraction of its heading leaves the cell over the edge by which
/// it entered.
const LEAVES_AT_ONCE: f64 = 1e-9;

/// A straight line across a cell.
pub(super) struct Crossed {
    /// The end of the line, as the entry into the next cell.
    pub end: Entry,
    /// The arrival time at the end.
    pub time: f64,
    pub length: f64,
    /// The cell, given by its north-western corner.
    pub cell: usize,
}

/// One number for each path.
type Lanes = [f64; LANES];

/// The cells that paths are about to cross, and the lines across them.
#[derive(Default)]
pub(super) struct Ahead {
    entries: [Option<Entry>; LANES],
    headings: Headings,
    cells: Cells,
}

impl Ahead {
    /// Puts a path into the lane `lane`. The path enters a cell at `entry` in the direction `heading`.
    /// `zero_time` is the time that is subtracted before times are squared; `below` is the arrival time at the entry.
    #[inline(always)]
    pub(super) fn enter(
        &mut self,
        lane: usize,
        entry: Entry,
        heading: DVec2,
        [zero_time, below]: [f64; 2],
    ) {
        let inside = entry.inside();
        let Headings { inside: [row, col], heading: [by_row, by_col], .. } = &mut self.headings;
        (row[lane], col[lane]) = (inside.x, inside.y);
        (by_row[lane], by_col[lane]) = (heading.x, heading.y);
        let cells = &mut self.cells;
        (cells.zero_time[lane], cells.below[lane], cells.share[lane]) =
            (zero_time, below, entry.share);
        self.entries[lane] = Some(entry);
    }

    /// Computes the lines of all lanes.
    pub(super) fn look(&mut self, tracer: &Tracer) {
        // Over a slowness, lines are searched for: they refract where it jumps.
        if tracer.edges.slowness().is_some() {
            self.entries = [None; LANES];
            return;
        }
        let instructions = Instructions::best();
        instructions.run(&mut self.headings);
        let Headings { side, near, leaves, .. } = &self.headings;
        let cells = &mut self.cells;
        cells.share_ahead = *near;
        for lane in 0..LANES {
            let Some(Entry { north_west, side: own, .. }) = self.entries[lane] else { continue };
            if !leaves[lane] || tracer.goals.touches(north_west) {
                self.entries[lane] = None;
                continue;
            }
            let (own, ahead) = (SIDES[own], SIDES[side[lane] as usize]);
            let corners = tracer.chart().bordered_corners(north_west);
            let ends = ahead.map(|corner| corners[corner]);
            if !ends.iter().all(|&end| tracer.is_reached(end)) {
                self.entries[lane] = None;
                continue;
            }
            let length = |ends| cell::length(tracer.edges, &corners, ends);
            cells.own_length[lane] = length(own);
            cells.length[lane] = length(ahead);
            for (all, from) in cells.across.iter_mut().zip(own) {
                for (all, to) in all.iter_mut().zip(ahead) {
                    all[lane] = length([from, to]);
                }
            }
            let times = tracer.times_along(ends);
            for (all, time) in cells.times.iter_mut().zip(times) {
                all[lane] = time;
            }
            for (all, ratio) in cells.ratios.iter_mut().zip(tracer.ratios_along(ends)) {
                all[lane] = ratio;
            }
        }
        instructions.run(cells);
    }

    /// Returns the line across the cell of a lane, and empties the lane.
    ///
    /// The line is returned only if it ends on the side to which the previous line points, and fits the
    /// arrival time. A search would then find nothing better. Beside sources, at corners of holes and where
    /// wavefronts meet, a search is needed.
    #[inline(always)]
    pub(super) fn take(&mut self, chart: Chart, lane: usize) -> Option<Crossed> {
        let Entry { north_west, corner, .. } = self.entries[lane].take()?;
        let Cells { found: [share, time, length], is_good, .. } = &self.cells;
        let side = self.headings.side[lane] as usize;
        let end = Entry::across(chart, north_west, corner, side, share[lane]);
        let (time, length) = (time[lane], length[lane]);
        is_good[lane].then_some(Crossed { end, time, length, cell: north_west })
    }
}

/// Straight lines in grid coordinates, and the places at which they leave their cells.
#[derive(Default)]
struct Headings {
    /// The row and column within the cell.
    inside: [Lanes; 2],
    /// The direction, by rows and by columns.
    heading: [Lanes; 2],
    /// The side of the cell by which the line leaves, as an index of [`SIDES`]. `near` is the place on that side, as a
    /// fraction from its first corner.
    side: [u64; LANES],
    near: Lanes,
    /// Whether the line leaves the cell elsewhere than it entered.
    leaves: [bool; LANES],
}

impl Loop for &mut Headings {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        for lane in 0..LANES {
            let [row, col] = self.inside.each_ref().map(|all| all[lane]);
            let [by_row, by_col] = self.heading.each_ref().map(|all| all[lane]);
            let until = |at: f64, by: f64| {
                let way = (if by > 0.0 { 1.0 } else { 0.0 } - at) / by;
                if by == 0.0 { f64::INFINITY } else { way }
            };
            let (to_row, to_col) = (until(row, by_row), until(col, by_col));
            let is_row = to_row < to_col;
            let way = if is_row { to_row } else { to_col };
            let on_row = if by_row > 0.0 { 3 } else { 0 };
            let on_col = if by_col > 0.0 { 2 } else { 1 };
            self.side[lane] = if is_row { on_row } else { on_col };
            self.near[lane] = if is_row { col + way * by_col } else { row + way * by_row };
            self.leaves[lane] = (way > LEAVES_AT_ONCE) & (way < f64::INFINITY);
        }
    }
}

/// Lines across cells: the inputs of the search for the earliest arrival, and its results.
#[derive(Default)]
struct Cells {
    zero_time: Lanes,
    /// The arrival times at the starts of the lines.
    below: Lanes,
    /// The places at which the lines start, as fractions of the sides on which they start.
    share: Lanes,
    /// Estimates of the places at which the lines end, as fractions of the sides ahead.
    share_ahead: Lanes,
    /// The lengths of the sides on which the lines start.
    own_length: Lanes,
    /// The distances from either end of the starting side to either end of the side ahead.
    across: [[Lanes; 2]; 2],
    /// The lengths of the sides ahead.
    length: Lanes,
    /// The arrival times at four points in a row. The middle two are the ends of the side ahead.
    times: [Lanes; 4],
    /// The lengths of the edges before and behind the sides ahead, as parts of these.
    ratios: [Lanes; 2],
    /// The places at which the lines end, as fractions of the sides ahead, the arrival times there, and the lengths of
    /// the lines.
    found: [Lanes; 3],
    is_good: [bool; LANES],
}

impl Loop for &mut Cells {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        for lane in 0..LANES {
            let times = self.times.each_ref().map(|all| all[lane]);
            let ratios = self.ratios.each_ref().map(|all| all[lane]);
            let (share, length, below) = (self.share[lane], self.length[lane], self.below[lane]);
            let rest = 1.0 - share;
            let spread = rest * share * (self.own_length[lane] * self.own_length[lane]);
            let square = |end: usize| {
                let [a, b] = self.across.each_ref().map(|all| all[end][lane]);
                rest * (a * a) + share * (b * b) - spread
            };
            let ends = [square(0), square(1)];
            let edge = EdgeTimes::new(self.zero_time[lane], times, ratios, length);
            let (Crossing { share, time, distance }, is_settled) =
                edge.crossing_near(self.share_ahead[lane], ends);
            self.found[0][lane] = share;
            self.found[1][lane] = time;
            self.found[2][lane] = distance;
            let is_between = (share - 0.5).abs() <= 0.5 - AT_POINT;
            self.is_good[lane] = is_settled
                & is_triangle(ends, length * length)
                & is_between
                & (time < below)
                & fits(time, distance, below);
        }
    }
}

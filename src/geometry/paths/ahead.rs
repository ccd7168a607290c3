//! The next lines of several paths where nothing bends them much, for a fraction of what searches
//! cost.

use glam::DVec2;

use super::cell::{self, SIDES};
use super::edge_times::{Crossing, EdgeTimes};
use super::entry::Entry;
use super::search::{AT_POINT, fits, is_triangle};
use super::tracer::Tracer;
use crate::lanes::{Instructions, Loop};
use crate::surface::Chart;

/// Paths that go on side by side: twice as many as the widest vectors hold in double precision, so
/// that one half is at work while the other one waits for roots.
pub(super) const LANES: usize = 16;

/// A heading that leaves a cell within less than this part of itself leaves it over the edge that it
/// came by.
const LEAVES_AT_ONCE: f64 = 1e-9;

/// A line across a cell.
pub(super) struct Crossed {
    /// Where it ends, as a place that leads into the next cell.
    pub end: Entry,
    /// Arrival time there.
    pub time: f64,
    pub length: f64,
    /// The cell, by its north-western corner.
    pub cell: usize,
}

/// A number for each path.
type Lanes = [f64; LANES];

/// The cells that paths have come to, and the lines across them.
#[derive(Default)]
pub(super) struct Ahead {
    entries: [Option<Entry>; LANES],
    headings: Headings,
    cells: Cells,
}

impl Ahead {
    /// A path that has come to a cell, since some moment and at a time `below`.
    #[inline(always)]
    pub(super) fn enter(
        &mut self,
        lane: usize,
        entry: Entry,
        heading: DVec2,
        [moment, below]: [f64; 2],
    ) {
        let inside = entry.inside();
        let Headings { inside: [row, col], heading: [by_row, by_col], .. } = &mut self.headings;
        (row[lane], col[lane]) = (inside.x, inside.y);
        (by_row[lane], by_col[lane]) = (heading.x, heading.y);
        let cells = &mut self.cells;
        (cells.moment[lane], cells.below[lane], cells.share[lane]) = (moment, below, entry.share);
        self.entries[lane] = Some(entry);
    }

    /// Finds the lines of all.
    pub(super) fn look(&mut self, tracer: &Tracer) {
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
        }
        instructions.run(cells);
    }

    /// The line across the cell that a path has come to, if it ends on the side to which the line
    /// before points and fits the arrival time, so that a search would find nothing better:
    /// but beside sources, at corners of holes and where fronts meet, it does.
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

/// Where straight lines on the grid leave cells.
#[derive(Default)]
struct Headings {
    /// Row and column in the cell.
    inside: [Lanes; 2],
    /// By rows and by columns.
    heading: [Lanes; 2],
    /// Which of the cell's [`SIDES`] the line leaves it by, and at which share of it.
    side: [u64; LANES],
    near: Lanes,
    /// Whether it does so elsewhere than it came.
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

/// Where lines across cells arrive first.
#[derive(Default)]
struct Cells {
    moment: Lanes,
    /// Arrival times where the lines start.
    below: Lanes,
    /// Shares of the sides that they start on.
    share: Lanes,
    /// Near where they end on those ahead.
    share_ahead: Lanes,
    /// Of the sides that they start on.
    own_length: Lanes,
    /// From either end of these to either end of those ahead.
    across: [[Lanes; 2]; 2],
    /// Of the sides ahead.
    length: Lanes,
    /// At four points in a row, the middle ones being the ends of the sides ahead.
    times: [Lanes; 4],
    /// At which shares the lines end, the arrival times there, and the lines' lengths.
    found: [Lanes; 3],
    is_good: [bool; LANES],
}

impl Loop for &mut Cells {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        for lane in 0..LANES {
            let times = self.times.each_ref().map(|all| all[lane]);
            let (share, length, below) = (self.share[lane], self.length[lane], self.below[lane]);
            let rest = 1.0 - share;
            let spread = rest * share * (self.own_length[lane] * self.own_length[lane]);
            let square = |end: usize| {
                let [a, b] = self.across.each_ref().map(|all| all[end][lane]);
                rest * (a * a) + share * (b * b) - spread
            };
            let ends = [square(0), square(1)];
            let edge = EdgeTimes::new(self.moment[lane], times, length);
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

//! The update of one line of points over a floor plan, by anchors: what rotated scans are made of there.
//!
//! Nearly everywhere all points behind a stretch have one anchor, and no hole is beside them: then a point
//! is reached from it if the straight line runs between its neighbours behind, which is one square root for
//! each, in lanes. Elsewhere points are updated one after another, as `update/anchored.rs` has it.

use std::ops::Range;

use super::line_update::{How, Updated};
use super::state::{accept_anchored, change_of_anchored, is_from};
use super::tiles::{Scan, TILE};
use crate::lanes::Work;
use crate::surface::{Chart, EdgeLengths, Real, min};
use crate::update::{Floor, Front};

/// A floor plan, and which of its points have all their neighbours.
#[derive(Clone, Debug)]
pub(super) struct Plan<'a, R> {
    pub floor: Floor<'a, R>,
    /// Zero at points of the bordered array that have all their edges, 1 at all others.
    pub parts: Vec<R>,
}

impl<'a, R: Real> Plan<'a, R> {
    pub(super) fn new(edges: &'a EdgeLengths<R>, floor: Floor<'a, R>) -> Self {
        let chart = edges.chart();
        let mut parts = vec![R::one(); chart.bordered_points()];
        for (row, col) in (0..chart.points()).map(|index| chart.position(index)) {
            let point = chart.bordered(row, col);
            if (0..8).all(|to| floor.neighbour(point, to).is_some()) {
                parts[point] = R::zero();
            }
        }
        Self { floor, parts }
    }
}

/// The lines of a grid, or of some of its columns turned into lines, while a scan updates them.
pub(super) struct Lines<'a, R> {
    pub plan: &'a Plan<'a, R>,
    pub chart: Chart,
    /// Arrival times, numbers of anchors, and [`Plan::parts`]: point p of line l has index
    /// l * `stride` + p + 1, with points counted from the first of the grid.
    pub times: &'a mut [R],
    pub anchors: &'a mut [R],
    pub parts: &'a [R],
    pub stride: usize,
    /// Which row or column, counted from the border, is the first of these lines.
    pub first: usize,
    /// Of lines that are columns: which rows of them are here, and the whole grid, where fronts are found
    /// that are not.
    pub beyond: Option<(Range<usize>, [&'a [R]; 2])>,
}

impl<R: Real> Lines<'_, R> {
    /// The front at a point of the grid.
    fn front(&self, point: usize) -> [R; 2] {
        let Some((rows, [times, anchors])) = &self.beyond else {
            return [self.times[point], self.anchors[point]];
        };
        let (row, col) = (point / self.chart.stride(), point % self.chart.stride());
        let lines = self.times.len() / self.stride;
        match col.checked_sub(self.first) {
            Some(line) if line < lines && rows.contains(&row) => {
                let place = line * self.stride + row;
                [self.times[place], self.anchors[place]]
            }
            _ => [times[point], anchors[point]],
        }
    }

    /// Updates points of a line from the line behind, and marks which stretches of [`TILE`] points have
    /// changed.
    pub(super) fn update(
        &mut self,
        line: usize,
        points: Range<usize>,
        how: How,
        changed: &mut [bool],
    ) -> Updated<R::Bits> {
        how.instructions.run(Update { lines: self, line, points, how, changed })
    }

    /// The way to a point from the line behind, one point at a time.
    #[inline(never)]
    fn reach(&self, point: usize, scan: Scan) -> Front<R> {
        let way = self.plan.floor.reach(point, scan.back() as usize, |x| self.front(x));
        Front { time: way.time, curvature: R::of_number(way.anchor), whole: false }
    }
}

struct Update<'a, 'b, R> {
    lines: &'a mut Lines<'b, R>,
    line: usize,
    points: Range<usize>,
    how: How,
    changed: &'a mut [bool],
}

impl<R: Real> Work for Update<'_, '_, R> {
    type Output = Updated<R::Bits>;

    #[inline(always)]
    fn run(self) -> Updated<R::Bits> {
        let Self { lines, line, points, how, changed } = self;
        let mut updated = Updated::<R::Bits>::default();
        for (tile, changed) in changed.iter_mut().enumerate() {
            let count = (points.len() - tile * TILE).min(TILE);
            // The last stretch overlaps the one before, as a number of points that is known when this is
            // compiled needs no loop.
            let found = match points.len().checked_sub(TILE) {
                Some(last) => {
                    update(lines, line, points.start + (tile * TILE).min(last), TILE, how)
                }
                None => update(lines, line, points.start, points.len(), how),
            };
            let Some((largest, any)) = found else { continue };
            *changed |= any;
            updated = updated.and(Updated { largest, points: count as u64 });
        }
        updated
    }
}

/// The update of a stretch of a line: its largest change, and whether it has changed anything at all;
/// `None` if nothing comes.
#[inline(always)]
fn update<R: Real>(
    lines: &mut Lines<R>,
    line: usize,
    start: usize,
    points: usize,
    how: How,
) -> Option<(R::Bits, bool)> {
    let line_behind = if how.scan.is_forward() { line - 1 } else { line + 1 };
    let (here, there) = (line * lines.stride + start + 1, line_behind * lines.stride + start);
    let (times, anchors) = (&lines.times[here..][..points], &lines.anchors[here..][..points]);
    let times_behind = &lines.times[there..][..points + 2];
    let anchors_behind = &lines.anchors[there..][..points + 2];
    let parts_behind = &lines.parts[there..][..points + 2];

    let (mut renewed, mut leads) = (false, true);
    for i in 0..points {
        renewed |= how.renews & is_from(anchors[i], how.scan.0);
        let behind = min(times_behind[i], min(times_behind[i + 1], times_behind[i + 2]));
        leads &= behind >= times[i];
    }
    if leads & !renewed {
        return None;
    }
    let mut is_one = true;
    for i in 0..points + 2 {
        is_one &= anchors_behind[i].is_numbered_as(anchors_behind[0])
            & (times_behind[i] < R::FAR)
            & (parts_behind[i] == R::zero());
    }
    let [row, col] = if how.scan.by_rows() {
        [lines.first + line, start + 1]
    } else {
        [start + 1, lines.first + line]
    };
    let mut brought = [[R::FAR, R::zero()]; TILE];
    if is_one {
        let point = row * lines.chart.stride() + col;
        let beside = point.wrapping_add_signed(lines.chart.offset(how.scan.back()));
        let from = lines.plan.floor.anchor_of(beside, |x| lines.front(x));
        let ([start, to_row, to_col], anchor) = (from.seen_from([row, col]), anchors_behind[0]);
        let (along_rows, along_cols) =
            if how.scan.by_rows() { (R::zero(), R::one()) } else { (R::one(), R::zero()) };
        let ahead = if how.scan.by_rows() { to_row } else { to_col };
        let back = if how.scan.is_forward() { -ahead } else { ahead };
        for (i, brought) in brought[..points].iter_mut().enumerate() {
            let steps = R::of(i as f64);
            let step = [to_row - along_rows * steps, to_col - along_cols * steps];
            let aside = if how.scan.by_rows() { step[1] } else { step[0] };
            let time = start + lines.plan.floor.length(step);
            let passes = (aside.abs() <= back) & (back >= R::one());
            *brought = [if passes { time } else { R::FAR }, anchor];
        }
    } else {
        for (i, brought) in brought[..points].iter_mut().enumerate() {
            let behind = min(times_behind[i], min(times_behind[i + 1], times_behind[i + 2]));
            if behind < R::FAR {
                let (row, col) = if how.scan.by_rows() { (row, col + i) } else { (row + i, col) };
                let front = lines.reach(row * lines.chart.stride() + col, how.scan);
                *brought = [front.time, front.curvature];
            }
        }
    }
    let (mut largest, mut any) = (R::Bits::default(), false);
    let mut after = [[R::zero(); 2]; TILE];
    for i in 0..points {
        let before = [times[i], anchors[i]];
        let [time, curvature] = brought[i];
        let front = Front { time, curvature, whole: false };
        after[i] = accept_anchored(before, front, how.scan.0, how.renews);
        largest = largest.max(change_of_anchored(before, after[i]));
        any |= before[0].units_between(after[i][0]).max(before[1].units_between(after[i][1]))
            > R::Bits::default();
    }
    if any {
        for (i, &[time, anchor]) in after[..points].iter().enumerate() {
            (lines.times[here + i], lines.anchors[here + i]) = (time, anchor);
        }
    }
    Some((largest, any))
}

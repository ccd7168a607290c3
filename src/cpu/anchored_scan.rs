//! The update of one line of points over a floor plan, by anchors: what rotated scans are made of there.
//!
//! Nearly everywhere all points behind a stretch have one anchor, and no hole is beside them: then a point
//! is reached from it if the straight line runs between its neighbours behind, which is one square root for
//! each, in lanes. Elsewhere points are updated one after another, as `update/anchored.rs` has it.

use std::ops::Range;

use rayon::prelude::*;

use super::line_update::{How, Updated};
use super::state::{accept_anchored, change_of_anchored, is_from};
use super::tiles::{Scan, TILE};
use crate::lanes::{Work, prefetch};
use crate::surface::{Chart, Real, TAG, min};
use crate::update::{Floor, Front};

/// A floor plan, and where one anchor behind a point is all that a scan has to look at.
#[derive(Clone, Debug)]
pub(super) struct Plan<R> {
    pub floor: Floor<R>,
    /// Of each point of the bordered array, tagged with a bit for each scan: clear where the point has
    /// edges to all three neighbours behind, and none of these is a corner.
    pub holes: Vec<R>,
}

impl<R: Real> Plan<R> {
    pub(super) fn new(chart: Chart, floor: Floor<R>) -> Self {
        let stride = chart.stride();
        let mut holes = vec![R::one().with_tag(TAG); chart.bordered_points()];
        let inner = stride..holes.len() - stride;
        holes[inner].par_chunks_mut(stride).enumerate().for_each(|(row, holes)| {
            for (col, hole) in holes.iter_mut().enumerate().skip(1).take(chart.cols) {
                let point = (row + 1) * stride + col;
                let blocks = |scan: &Scan| !floor.is_open(point, scan.back() as usize);
                let blocked = Scan::ALL.iter().filter(|scan| blocks(scan));
                let tag = blocked.fold(0, |tag, scan| tag | hole_bit(*scan));
                *hole = R::one().with_tag(tag);
            }
        });
        Self { floor, holes }
    }

    /// Whether that is so at a point, of which this is the value in [`Plan::holes`], and the three neighbours
    /// behind have this anchor.
    #[inline(always)]
    pub(super) fn is_of_one(anchor: R, behind: [R; 3], hole: R, scan: Scan) -> bool {
        let [a, b, c] = behind.map(|other| other.is_numbered_as(anchor));
        a & b & c & hole.tag_has(hole_bit(scan), 0)
    }

    /// Bytes held.
    pub(super) fn bytes(&self) -> usize {
        self.floor.bytes() + std::mem::size_of_val(self.holes.as_slice())
    }
}

#[inline(always)]
fn hole_bit(scan: Scan) -> u8 {
    scan.bit() >> 1
}

/// The lines of a grid, or of some of its columns turned into lines, while a scan updates them.
pub(super) struct Lines<'a, R> {
    pub plan: &'a Plan<R>,
    pub chart: Chart,
    /// Arrival times, numbers of anchors, and [`Plan::holes`]: point p of line l has index
    /// l * `stride` + p + 1, with points counted from the first of the grid.
    pub times: &'a mut [R],
    pub anchors: &'a mut [R],
    pub holes: &'a [R],
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

    /// Asks for what the next line's update needs from some point on.
    #[inline(always)]
    fn prefetch_next(&self, line: usize, start: usize, scan: Scan) {
        let next = if scan.is_forward() { line + 1 } else { line - 1 };
        let place = (next * self.stride + start + 1) as isize;
        prefetch(self.times, place);
        prefetch(self.anchors, place);
        prefetch(self.holes, place);
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
            lines.prefetch_next(line, points.start + tile * TILE, how.scan);
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
    let behind = Behind {
        times: &lines.times[there..][..points + 2],
        anchors: &lines.anchors[there..][..points + 2],
        holes: &lines.holes[here..][..points],
    };
    let (mut renewed, mut leads) = (false, true);
    for i in 0..points {
        renewed |= how.renews & is_from(anchors[i], how.scan.0);
        leads &= behind.first(i) >= times[i];
    }
    if leads & !renewed {
        return None;
    }
    let mut is_one = behind.times[0] < R::FAR;
    for i in 0..points {
        is_one &= behind.has(i, behind.anchors[0], how.scan);
    }
    let first = match how.scan.by_rows() {
        true => [lines.first + line, start + 1],
        false => [start + 1, lines.first + line],
    };
    let mut brought = Brought { times: [R::FAR; TILE], anchors: [R::zero(); TILE] };
    if is_one {
        brought.bring_from_one(lines, &behind, first, 0..points, how.scan);
    } else {
        let may_come =
            |i: usize| behind.first(i) < times[i] || how.renews && is_from(anchors[i], how.scan.0);
        brought.bring_from_several(lines, &behind, first, points, how.scan, may_come);
    }
    let (mut new_times, mut new_anchors) = ([R::zero(); TILE], [R::zero(); TILE]);
    let mut changes = [R::Bits::default(); TILE];
    let mut any = false;
    for i in 0..points {
        let before = [times[i], anchors[i]];
        let front = Front { time: brought.times[i], curvature: brought.anchors[i], whole: false };
        let after = accept_anchored(before, front, how.scan.0, how.renews);
        changes[i] = change_of_anchored(before, after);
        any |= before[0].units_between(after[0]).max(before[1].units_between(after[1]))
            > R::Bits::default();
        [new_times[i], new_anchors[i]] = after;
    }
    if any {
        lines.times[here..][..points].copy_from_slice(&new_times[..points]);
        lines.anchors[here..][..points].copy_from_slice(&new_anchors[..points]);
    }
    Some((changes.into_iter().max().unwrap_or_default(), any))
}

/// The points behind a stretch, from the one before its first to the one after its last.
struct Behind<'a, R> {
    times: &'a [R],
    anchors: &'a [R],
    /// At the points of the stretch.
    holes: &'a [R],
}

impl<R: Real> Behind<'_, R> {
    /// The earliest of the three behind a point.
    #[inline(always)]
    fn first(&self, i: usize) -> R {
        min(self.times[i], min(self.times[i + 1], self.times[i + 2]))
    }

    /// Whether all three have an anchor, and no hole is near.
    #[inline(always)]
    fn has(&self, i: usize, anchor: R, scan: Scan) -> bool {
        let behind = [self.anchors[i], self.anchors[i + 1], self.anchors[i + 2]];
        Plan::is_of_one(anchor, behind, self.holes[i], scan)
    }
}

/// What a scan brings to the points of a stretch: times and numbers of anchors.
struct Brought<R> {
    times: [R; TILE],
    anchors: [R; TILE],
}

impl<R: Real> Brought<R> {
    /// To points behind which all have one anchor, and no hole is near.
    #[inline(always)]
    fn bring_from_one(
        &mut self,
        lines: &Lines<R>,
        behind: &Behind<R>,
        [row, col]: [usize; 2],
        points: Range<usize>,
        scan: Scan,
    ) {
        let i = points.start;
        let [row, col] = if scan.by_rows() { [row, col + i] } else { [row + i, col] };
        let (ahead, along) = (scan.ahead(), if scan.by_rows() { [0, 1] } else { [1, 0] });
        let rays = lines.plan.floor.rays([row, col], ahead, along, |x| lines.front(x));
        self.anchors[points.clone()].fill(behind.anchors[i]);
        let beside = &behind.times[points.start + 1..points.end + 1];
        for (i, (time, &behind)) in self.times[points].iter_mut().zip(beside).enumerate() {
            *time = rays.time(i, behind);
        }
    }

    /// To others: as many as possible at once, and the rest one after another.
    #[inline(always)]
    fn bring_from_several(
        &mut self,
        lines: &Lines<R>,
        behind: &Behind<R>,
        first: [usize; 2],
        points: usize,
        scan: Scan,
        may_come: impl Fn(usize) -> bool,
    ) {
        let (mut wanted, mut of_one) = ([false; TILE], [false; TILE]);
        for i in 0..points {
            wanted[i] = may_come(i);
            of_one[i] = behind.has(i, behind.anchors[i], scan);
        }
        let mut i = 0;
        while i < points {
            if !wanted[i] {
                i += 1;
                continue;
            }
            if of_one[i] && behind.times[i] < R::FAR {
                let anchor = behind.anchors[i];
                let goes_on =
                    |&other: &usize| of_one[other] && behind.anchors[other].is_numbered_as(anchor);
                let run = (i..points).take_while(goes_on).count();
                self.bring_from_one(lines, behind, first, i..i + run, scan);
                i += run;
                continue;
            }
            let [row, col] = first;
            let [row, col] = if scan.by_rows() { [row, col + i] } else { [row + i, col] };
            let point = row * lines.chart.stride() + col;
            if lines.plan.floor.has(point) {
                let front = lines.reach(point, scan);
                (self.times[i], self.anchors[i]) = (front.time, front.curvature);
            }
            i += 1;
        }
    }
}

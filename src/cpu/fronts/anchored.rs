//! Implements fronts over a floor plan that carry the number of their anchor.
//!
//! Nearly everywhere all points behind a span have the same anchor, and there is no hole beside them. Then
//! the anchor reaches a point if the straight line to it runs between its neighbours behind. That takes one
//! square root per point, in SIMD lanes. Elsewhere points are updated one after another, as in
//! `update/anchored.rs`.

use std::ops::Range;

use bytemuck::{Pod, Zeroable};
use rayon::prelude::*;

use super::kind::FrontKind;
use super::surface_array::SurfaceArray;
use crate::constants::ANCHOR_COUNTS;
use crate::cpu::behind::Behind;
use crate::cpu::rotated::line::GridLines;
use crate::cpu::rotated::line_update::{Changed, LineUpdate, Spans, UpdateOptions, Updated};
use crate::cpu::rotated::span::{Before, Span};
use crate::cpu::rotated::tiles::TILE;
use crate::cpu::scan::Scan;
use crate::lanes::prefetch;
use crate::surface::{Chart, EdgeLengths, EvenGrid, Real, Seed, TAG, Tagged, min};
use crate::update::{Anchor, Carried, Floor, Kept, is_shorter};

/// The front of [`crate::Wavefront::Anchored`].
#[derive(Clone, Debug)]
pub(in crate::cpu) struct Anchored<R> {
    floor: Floor<R>,
}

/// The front that a point keeps or that reaches it: its arrival time and its anchor.
type KeptAnchored<R> = Kept<R, Anchor<R>>;

/// Flags of the scans that have a hole behind a point: one of the three neighbours is missing, or there is a
/// corner. For the other scans, one anchor behind the point is all that matters.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(transparent)]
pub(in crate::cpu) struct HolesBehind<R>(R);

impl<R: Real> HolesBehind<R> {
    fn new(scans: impl Iterator<Item = Scan>) -> Self {
        Self(R::one().with_tag(scans.fold(0, |tag, scan| tag | Self::digit(scan))))
    }

    #[inline(always)]
    fn digit(scan: Scan) -> u8 {
        scan.bit() >> 1
    }

    #[inline(always)]
    fn is_none_for(self, scan: Scan) -> bool {
        self.0.tag_has(Self::digit(scan), 0)
    }
}

impl<R: Real> Anchored<R> {
    /// Creates the front for a floor plan with these edges on this grid.
    pub(in crate::cpu) fn new(edges: &EdgeLengths<R>, grid: EvenGrid) -> Self {
        Self { floor: Floor::new(edges, grid) }
    }
}

impl<R: Real> FrontKind<R> for Anchored<R> {
    type Carried = Anchor<R>;
    type Arrival = KeptAnchored<R>;
    type SurfaceData = HolesBehind<R>;

    const NEEDS_EDGES: bool = false;

    fn arrival_of_seed(&mut self, seed: &Seed) -> KeptAnchored<R> {
        Kept { time: R::of(seed.time), carried: self.floor.anchor_of(seed) }
    }

    fn forget(&mut self) {
        self.floor.forget();
    }

    #[inline]
    fn reach(
        &self,
        _: &EdgeLengths<R>,
        point: usize,
        behind: &Behind,
        seen: impl Fn(usize) -> KeptAnchored<R>,
    ) -> KeptAnchored<R> {
        let way = self.floor.reach(point, behind.middle() as usize, seen);
        Kept { time: way.time, carried: Anchor::new(way.anchor) }
    }

    /// Accepts an arrival that is shorter than the present front by more than rounding. If the scan `renews`,
    /// also accepts what replaces a front that the same scan brought.
    #[inline(always)]
    fn accept(
        kept: KeptAnchored<R>,
        arrival: KeptAnchored<R>,
        scan: u8,
        renews: bool,
    ) -> KeptAnchored<R> {
        let is_same = !is_shorter(arrival.time, kept.time)
            & !is_shorter(kept.time, arrival.time)
            & kept.carried.is(arrival.carried);
        let again = (kept.time < R::FAR) & renews & kept.carried.is_from(scan) & !is_same;
        let accepted = is_shorter(arrival.time, kept.time) | again;
        let brought = arrival.carried.brought_by(scan);
        let brought = if arrival.time < R::FAR { brought } else { Anchor::default() };
        Kept {
            time: if accepted { arrival.time } else { kept.time },
            carried: if accepted { brought } else { kept.carried },
        }
    }

    /// Returns the front itself. Floor plans are not glued.
    fn arrival_of_front(kept: KeptAnchored<R>) -> KeptAnchored<R> {
        kept
    }

    /// Returns the second front if it is shorter by more than rounding, else the first.
    #[inline(always)]
    fn first(a: KeptAnchored<R>, b: KeptAnchored<R>) -> KeptAnchored<R> {
        let second = is_shorter(b.time, a.time);
        Kept {
            time: if second { b.time } else { a.time },
            carried: if second { b.carried } else { a.carried },
        }
    }

    /// A changed anchor matters to neighbouring points, though not to the map.
    #[inline(always)]
    fn change(before: KeptAnchored<R>, after: KeptAnchored<R>) -> R::Bits {
        let turns = !before.carried.is(after.carried);
        let turn = if turns { R::of(ANCHOR_COUNTS).in_units() } else { R::Bits::default() };
        before.time.units_between(after.time).max(turn)
    }

    fn surface_data(&self, chart: Chart) -> SurfaceArray<HolesBehind<R>> {
        let mut holes = vec![HolesBehind(R::one().with_tag(TAG)); chart.bordered_points()];
        chart.rows_mut(&mut holes).enumerate().for_each(|(row, holes)| {
            for (col, hole) in holes.iter_mut().enumerate() {
                let point = chart.bordered(row, col);
                let blocks = |scan: &Scan| !self.floor.is_open(point, scan.back() as usize);
                *hole = HolesBehind::new(Scan::ALL.into_iter().filter(blocks));
            }
        });
        SurfaceArray::Own(holes)
    }

    fn bytes(&self) -> usize {
        self.floor.bytes()
    }

    fn update(
        &self,
        lines: &mut GridLines<'_, R, Self::Carried, Self::SurfaceData>,
        line: usize,
        points: &Range<usize>,
        options: UpdateOptions,
        changed: &mut [Changed],
    ) -> Updated<R::Bits> {
        let line = AnchoredLine { floor: &self.floor, lines, line, points, scan: options.scan };
        options.instructions.run(LineUpdate { line, options, changed })
    }

    /// Decides this only where one anchor serves all points behind. Where there are several, there is work to
    /// do.
    #[inline(always)]
    fn leaves(
        &self,
        before: &Before<'_, R, Self::Carried, Self::SurfaceData>,
        first: usize,
        span: Span<'_, R, Self::Carried, Self::SurfaceData>,
        points: usize,
        options: UpdateOptions,
    ) -> bool {
        if span.is_renewed(points, options) {
            return false;
        }
        if span.leads(points) {
            return true;
        }
        let [behind, beside, after] = span.carried_behind;
        let anchor = beside[0];
        let mut is_one = span.times_behind[1][0] < R::FAR;
        for i in 0..points {
            let anchors = [behind[i], beside[i], after[i]];
            is_one &= is_of_one(anchor, anchors, span.surface_data[i], options.scan);
        }
        if !is_one {
            return false;
        }
        let at = before.edges.chart().entry(first).into();
        let rays = self.floor.rays(at, options.scan.ahead(), [0, 1], |x| before.front(x));
        let (mut settled, limit) = (true, R::of(options.limit));
        for (i, &time) in span.times[..points].iter().enumerate() {
            settled &= !is_shorter(rays.time(i, span.times_behind[1][i]), min(time, limit));
        }
        settled
    }
}

/// Returns whether three neighbours behind a point have this anchor and no hole is near.
#[inline(always)]
fn is_of_one<R: Real>(
    anchor: Anchor<R>,
    [a, b, c]: [Anchor<R>; 3],
    holes: HolesBehind<R>,
    scan: Scan,
) -> bool {
    a.is(anchor) & b.is(anchor) & c.is(anchor) & holes.is_none_for(scan)
}

/// A line while a scan updates it.
struct AnchoredLine<'l, 'g, R> {
    floor: &'l Floor<R>,
    lines: &'l mut GridLines<'g, R, Anchor<R>, HolesBehind<R>>,
    line: usize,
    points: &'l Range<usize>,
    scan: Scan,
}

impl<R: Real> Spans for AnchoredLine<'_, '_, R> {
    type Changes = R::Bits;
    type Bits = R::Bits;

    #[inline(always)]
    fn points(&self) -> usize {
        self.points.len()
    }

    #[inline(always)]
    fn prefetch_next(&self, start: usize) {
        // Before the first line and after the last one there is no line, and nothing is read.
        let (lines, start) = (&self.lines, self.points.start + start);
        let ahead = |stride: usize| stride as isize * if self.scan.is_forward() { 1 } else { -1 };
        let place = lines.at(self.line, start) as isize + ahead(lines.stride);
        prefetch(lines.times, place);
        prefetch(lines.carried, place);
        let on_surface = lines.on_surface(self.line, start) as isize;
        prefetch(lines.surface_data, on_surface + ahead(lines.surface.0));
    }

    #[inline(always)]
    fn is_beyond(&self, start: usize, points: usize, limit: f64) -> bool {
        if limit == f64::INFINITY {
            return false;
        }
        let (lines, start) = (&*self.lines, self.points.start + start);
        let behind = lines.line_behind(self.line, self.scan);
        let (here, there) = (lines.at(self.line, start), lines.at(behind, start) - 1);
        let times = lines.times[here..][..points].iter().chain(&lines.times[there..][..points + 2]);
        times.fold(R::FAR, |first, &time| min(first, time)).wide() > limit
    }

    #[inline(always)]
    fn update(
        &mut self,
        start: usize,
        points: usize,
        options: UpdateOptions,
        largest: &mut R::Bits,
    ) -> Option<Changed> {
        let (lines, start) = (&*self.lines, self.points.start + start);
        let line_behind = lines.line_behind(self.line, options.scan);
        let (here, there) = (lines.at(self.line, start), lines.at(line_behind, start) - 1);
        let (times, anchors) = (&lines.times[here..][..points], &lines.carried[here..][..points]);
        let behind = LineBehind {
            times: &lines.times[there..][..points + 2],
            anchors: &lines.carried[there..][..points + 2],
            holes: &lines.surface_data[lines.on_surface(self.line, start)..][..points],
        };
        let (mut renewed, mut leads) = (false, true);
        for i in 0..points {
            renewed |= options.renews & anchors[i].is_from(options.scan.0);
            leads &= behind.first(i) >= times[i];
        }
        if leads & !renewed {
            return None;
        }
        let mut is_one = behind.times[0] < R::FAR;
        for i in 0..points {
            is_one &= behind.has(i, behind.anchors[0], options.scan);
        }
        let first = lines.position(self.line, start, options.scan);
        let mut brought = Brought { times: [R::FAR; TILE], anchors: [Anchor::default(); TILE] };
        if is_one {
            brought.bring_from_one(self.floor, lines, &behind, first, 0..points, options.scan);
        } else {
            let may_come = |i: usize| {
                behind.first(i) < times[i] || options.renews && anchors[i].is_from(options.scan.0)
            };
            brought.bring_from_several(
                self.floor,
                lines,
                &behind,
                first,
                points,
                options.scan,
                may_come,
            );
        }
        let (mut new_times, mut new_anchors) = ([R::zero(); TILE], [Anchor::default(); TILE]);
        let mut changes = [R::Bits::default(); TILE];
        let mut any = false;
        for i in 0..points {
            let before = Kept { time: times[i], carried: anchors[i] };
            let arrival = Kept { time: brought.times[i], carried: brought.anchors[i] };
            let after = Anchored::accept(before, arrival, options.scan.0, options.renews);
            changes[i] = Anchored::change(before, after);
            any |= (before.time.units_between(after.time) > R::Bits::default())
                | before.carried.differs(after.carried);
            (new_times[i], new_anchors[i]) = (after.time, after.carried);
        }
        let first = |i: usize| {
            let differs = new_times[i] != times[i] || new_anchors[i].differs(anchors[i]);
            differs.then(|| min(new_times[i], times[i]))
        };
        let changed = Changed::of(any, options.limit, points, first);
        if any {
            self.lines.times[here..][..points].copy_from_slice(&new_times[..points]);
            self.lines.carried[here..][..points].copy_from_slice(&new_anchors[..points]);
        }
        *largest = (*largest).max(changes.into_iter().max().unwrap_or_default());
        Some(changed)
    }

    #[inline(always)]
    fn largest(changes: R::Bits) -> R::Bits {
        changes
    }
}

/// The points behind a span, from the one before its first point to the one after its last.
struct LineBehind<'a, R> {
    times: &'a [R],
    anchors: &'a [Anchor<R>],
    /// Holes behind the points of the span.
    holes: &'a [HolesBehind<R>],
}

impl<R: Real> LineBehind<'_, R> {
    /// Returns the earliest time of the three points behind a point.
    #[inline(always)]
    fn first(&self, i: usize) -> R {
        min(self.times[i], min(self.times[i + 1], self.times[i + 2]))
    }

    /// Returns whether all three points behind have this anchor and no hole is near.
    #[inline(always)]
    fn has(&self, i: usize, anchor: Anchor<R>, scan: Scan) -> bool {
        let behind = [self.anchors[i], self.anchors[i + 1], self.anchors[i + 2]];
        is_of_one(anchor, behind, self.holes[i], scan)
    }
}

/// The fronts that a scan brings to the points of a span.
struct Brought<R> {
    times: [R; TILE],
    anchors: [Anchor<R>; TILE],
}

impl<R: Real> Brought<R> {
    /// Computes the fronts at points whose neighbours behind all have one anchor and no hole near.
    #[inline(always)]
    fn bring_from_one(
        &mut self,
        floor: &Floor<R>,
        lines: &GridLines<R, Anchor<R>, HolesBehind<R>>,
        behind: &LineBehind<R>,
        first: [usize; 2],
        points: Range<usize>,
        scan: Scan,
    ) {
        let i = points.start;
        let (ahead, along) = (scan.ahead(), if scan.by_rows() { [0, 1] } else { [1, 0] });
        let rays = floor.rays(further(first, i, scan), ahead, along, |x| lines.front(x));
        self.anchors[points.clone()].fill(behind.anchors[i]);
        let beside = &behind.times[points.start + 1..points.end + 1];
        for (i, (time, &behind)) in self.times[points].iter_mut().zip(beside).enumerate() {
            *time = rays.time(i, behind);
        }
    }

    /// Computes the fronts at other points: as many as possible at once, and the rest one after another.
    #[allow(clippy::too_many_arguments)]
    #[inline(always)]
    fn bring_from_several(
        &mut self,
        floor: &Floor<R>,
        lines: &GridLines<R, Anchor<R>, HolesBehind<R>>,
        behind: &LineBehind<R>,
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
                let goes_on = |&other: &usize| of_one[other] && behind.anchors[other].is(anchor);
                let run = (i..points).take_while(goes_on).count();
                self.bring_from_one(floor, lines, behind, first, i..i + run, scan);
                i += run;
                continue;
            }
            let [row, col] = further(first, i, scan);
            let point = lines.place.edges.chart().entry_index(row, col);
            if floor.has(point) {
                let arrival = reach(floor, lines, point, scan);
                (self.times[i], self.anchors[i]) = (arrival.time, arrival.carried);
            }
            i += 1;
        }
    }
}

/// Returns the position of the point that is `by` points further along a line.
#[inline(always)]
fn further([row, col]: [usize; 2], by: usize, scan: Scan) -> [usize; 2] {
    if scan.by_rows() { [row, col + by] } else { [row + by, col] }
}

/// Returns the shortest path to a point from the line behind, for a single point.
#[inline(never)]
fn reach<R: Real>(
    floor: &Floor<R>,
    lines: &GridLines<R, Anchor<R>, HolesBehind<R>>,
    point: usize,
    scan: Scan,
) -> KeptAnchored<R> {
    let way = floor.reach(point, scan.back() as usize, |x| lines.front(x));
    Kept { time: way.time, carried: Anchor::new(way.anchor) }
}

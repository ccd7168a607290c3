//! Implements fronts over a floor plan that carry the number of their anchor.
//!
//! Nearly everywhere all points behind a span have the same anchor, and there is no hole beside them. Then the anchor
//! reaches a point if the straight line from the anchor to the point runs between the point's neighbours behind. This
//! test and the arrival time take two square roots per point, in SIMD lanes. Elsewhere points are updated one after
//! another, as in `update/anchored.rs`.

use std::ops::Range;

use bytemuck::{Pod, Zeroable};
use rayon::prelude::*;

use super::kind::{FrontKind, Fronts, PointKind};
use super::lanes::LaneKind;
use super::surface_array::SurfaceArray;
use crate::behind::Behind;
use crate::lines::line::ScanLine;
use crate::lines::span::{Before, LargestChanges, Span, TILE};
use crate::scan::{Scan, UpdateOptions};
use geosweep_surface::constants::ANCHOR_COUNTS;
use geosweep_surface::update::{Anchor, Carried, Floor, StoredFront, is_shorter};
use geosweep_surface::{Chart, EdgeLengths, EvenGrid, Real, Seed, TAG, Tagged, min};

/// The front of [`geosweep_surface::Wavefront::Anchored`].
#[derive(Clone, Debug)]
pub(crate) struct Anchored<R> {
    floor: Floor<R>,
}

/// A front at a point, or one that reaches it: its arrival time and its anchor.
type KeptAnchored<R> = StoredFront<R, Anchor<R>>;

/// Flags of the scans that have a hole behind a point: one of the three neighbours behind is missing, or one of them is
/// a corner. For all other scans the update depends only on the anchors of these neighbours.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(transparent)]
pub(crate) struct HolesBehind<R>(R);

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
    pub(crate) fn new(edges: &EdgeLengths<R>, grid: EvenGrid) -> Self {
        Self { floor: Floor::new(edges, grid) }
    }
}

impl<R: Real> FrontKind<R> for Anchored<R> {
    type Carried = Anchor<R>;
    type Arrival = KeptAnchored<R>;

    fn arrival_of_seed(&mut self, seed: &Seed) -> KeptAnchored<R> {
        StoredFront { time: R::of(seed.time), carried: self.floor.anchor_of(seed) }
    }

    fn forget(&mut self) {
        self.floor.forget();
    }
}

impl<R: Real> Fronts<R> for Anchor<R> {
    type Arrival = KeptAnchored<R>;

    /// Accepts an arrival that is shorter than the present front by more than rounding. If the scan `renews`, an
    /// arrival also replaces an earlier front of the same scan, unless both agree within rounding.
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
        StoredFront {
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
        StoredFront {
            time: if second { b.time } else { a.time },
            carried: if second { b.carried } else { a.carried },
        }
    }

    /// Returns the change of the arrival time. A changed anchor counts as a change too: it affects neighbouring points,
    /// although the distance here stays.
    #[inline(always)]
    fn change(before: KeptAnchored<R>, after: KeptAnchored<R>) -> R::Bits {
        let turns = !before.carried.is(after.carried);
        let turn = if turns { R::of(ANCHOR_COUNTS).in_units() } else { R::Bits::default() };
        before.time.units_between(after.time).max(turn)
    }
}

impl<R: Real> PointKind<R> for Anchored<R> {
    #[inline]
    fn reach(
        &self,
        _: &EdgeLengths<R>,
        point: usize,
        behind: &Behind,
        seen: impl Fn(usize) -> KeptAnchored<R>,
    ) -> KeptAnchored<R> {
        let way = self.floor.reach(point, behind.middle() as usize, seen);
        StoredFront { time: way.time, carried: Anchor::new(way.anchor) }
    }
}

impl<R: Real> LaneKind<R> for Anchored<R> {
    type SurfaceData = HolesBehind<R>;
    type OfLine<'k> = &'k Floor<R>;
    const NEEDS_EDGES: bool = false;

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

    fn of_line(&self, _: [usize; 2], _: Scan) -> &Floor<R> {
        &self.floor
    }

    #[inline(always)]
    fn update_span(
        floor: &&Floor<R>,
        line: &mut ScanLine<'_, '_, R, Self::Carried, Self::SurfaceData>,
        [start, points]: [usize; 2],
        _: &[(usize, Option<Self::Arrival>)],
        options: UpdateOptions,
        changes: &mut LargestChanges<R>,
    ) -> Option<bool> {
        let span = line.span_without_edges(start, points);
        let renewed = span.is_renewed(points, options);
        if span.leads(points) & !renewed {
            return None;
        }
        let mut brought = Brought { times: [R::FAR; TILE], anchors: [Anchor::default(); TILE] };
        brought.bring(floor, line, &span, [start, points], options);
        let (mut times, mut anchors) = ([R::zero(); TILE], [Anchor::default(); TILE]);
        let mut any = false;
        for i in 0..points {
            let before = StoredFront { time: span.times[i], carried: span.carried[i] };
            let arrival = StoredFront { time: brought.times[i], carried: brought.anchors[i] };
            let after = Anchor::accept(before, arrival, options.scan.0, options.renews);
            changes.note(i, Anchor::change(before, after));
            any |= (before.time.units_between(after.time) > R::Bits::default())
                | before.carried.differs(after.carried);
            (times[i], anchors[i]) = (after.time, after.carried);
        }
        if any {
            line.set(start, &times[..points], &anchors[..points]);
        }
        Some(any)
    }

    /// Returns true only if no point is later than a neighbour behind it, or if all points behind have one anchor.
    /// Where they have several anchors, the points must be updated.
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

/// Returns whether all three neighbours behind a point have this anchor and no hole is near.
#[inline(always)]
fn is_of_one<R: Real>(
    anchor: Anchor<R>,
    [a, b, c]: [Anchor<R>; 3],
    holes: HolesBehind<R>,
    scan: Scan,
) -> bool {
    a.is(anchor) & b.is(anchor) & c.is(anchor) & holes.is_none_for(scan)
}

/// A line of points whose fronts have anchors.
type AnchoredLine<'l, 'g, R> = ScanLine<'l, 'g, R, Anchor<R>, HolesBehind<R>>;

/// A span of adjacent points whose fronts have anchors.
type AnchoredSpan<'a, R> = Span<'a, R, Anchor<R>, HolesBehind<R>>;

/// Returns whether all three points behind point `i` have this anchor and no hole is near.
#[inline(always)]
fn has<R: Real>(span: &AnchoredSpan<R>, i: usize, anchor: Anchor<R>, scan: Scan) -> bool {
    let [before, beside, after] = span.carried_behind;
    is_of_one(anchor, [before[i], beside[i], after[i]], span.surface_data[i], scan)
}

/// The fronts that a scan brings to the points of a span.
struct Brought<R> {
    times: [R; TILE],
    anchors: [Anchor<R>; TILE],
}

impl<R: Real> Brought<R> {
    /// Computes the fronts at a span of points of a line, given their start and number.
    #[inline(always)]
    fn bring(
        &mut self,
        floor: &Floor<R>,
        line: &AnchoredLine<R>,
        span: &AnchoredSpan<R>,
        [start, points]: [usize; 2],
        options: UpdateOptions,
    ) {
        let (scan, first) = (options.scan, further(line.first, start, options.scan));
        let [anchors, ..] = span.carried_behind;
        let mut is_one = span.times_behind[0][0] < R::FAR;
        for i in 0..points {
            is_one &= has(span, i, anchors[0], scan);
        }
        if is_one {
            self.bring_from_one(floor, line, span, first, 0..points, scan);
            return;
        }
        let [before, beside, after] = span.times_behind;
        let may_come = |i: usize| {
            min(before[i], min(beside[i], after[i])) < span.times[i]
                || options.renews && span.carried[i].is_from(scan.0)
        };
        let (mut wanted, mut of_one) = ([false; TILE], [false; TILE]);
        for i in 0..points {
            wanted[i] = may_come(i);
            of_one[i] = has(span, i, anchors[i], scan);
        }
        // Updates runs of points with one anchor behind them at once, and all other points one by one.
        let mut i = 0;
        while i < points {
            if !wanted[i] {
                i += 1;
                continue;
            }
            if of_one[i] && before[i] < R::FAR {
                let goes_on = |&other: &usize| of_one[other] && anchors[other].is(anchors[i]);
                let run = (i..points).take_while(goes_on).count();
                self.bring_from_one(floor, line, span, first, i..i + run, scan);
                i += run;
                continue;
            }
            let [row, col] = further(first, i, scan);
            let point = line.place.edges.chart().entry_index(row, col);
            if floor.has(point) {
                let arrival = reach(floor, line, point, scan);
                (self.times[i], self.anchors[i]) = (arrival.time, arrival.carried);
            }
            i += 1;
        }
    }

    /// Computes the fronts at points whose neighbours behind all have one anchor and no hole near.
    #[inline(always)]
    fn bring_from_one(
        &mut self,
        floor: &Floor<R>,
        line: &AnchoredLine<R>,
        span: &AnchoredSpan<R>,
        first: [usize; 2],
        points: Range<usize>,
        scan: Scan,
    ) {
        let i = points.start;
        let (ahead, along) = (scan.ahead(), if scan.by_rows() { [0, 1] } else { [1, 0] });
        let rays = floor.rays(further(first, i, scan), ahead, along, |x| line.front(x));
        self.anchors[points.clone()].fill(span.carried_behind[0][i]);
        let beside = &span.times_behind[1][points.clone()];
        for (i, (time, &behind)) in self.times[points].iter_mut().zip(beside).enumerate() {
            *time = rays.time(i, behind);
        }
    }
}

/// Returns the position of the point that is `by` points further along a line.
#[inline(always)]
fn further([row, col]: [usize; 2], by: usize, scan: Scan) -> [usize; 2] {
    if scan.by_rows() { [row, col + by] } else { [row + by, col] }
}

/// Returns the front that reaches a single point from the line behind on the shortest path.
#[inline(never)]
fn reach<R: Real>(
    floor: &Floor<R>,
    line: &AnchoredLine<R>,
    point: usize,
    scan: Scan,
) -> KeptAnchored<R> {
    let way = floor.reach(point, scan.back() as usize, |x| line.front(x));
    StoredFront { time: way.time, carried: Anchor::new(way.anchor) }
}

//! What a solver asks of a kind of front.

use std::borrow::Cow;
use std::ops::Range;

use bytemuck::Pod;

use crate::cpu::behind::{Behind, TriangleSlots};
use crate::cpu::line::GridLines;
use crate::cpu::line_update::{How, Updated};
use crate::cpu::scan::Scan;
use crate::cpu::stretch::{Before, Stretch};
use crate::surface::{Chart, Direction, EdgeLengths, Part, Real, Seed};
use crate::update::{Carried, Kept, Triangle};

/// The front that a point keeps, by the kind of front.
pub(in crate::cpu) type KeptBy<'a, R, K> = Kept<R, <K as FrontKind<'a, R>>::Carried>;
/// [`GridLines`], likewise.
pub(in crate::cpu) type LinesOf<'l, 'a, R, K> =
    GridLines<'l, R, <K as FrontKind<'a, R>>::Carried, <K as FrontKind<'a, R>>::Ground>;
/// [`Stretch`], likewise.
pub(in crate::cpu) type StretchOf<'l, 'a, R, K> =
    Stretch<'l, R, <K as FrontKind<'a, R>>::Carried, <K as FrontKind<'a, R>>::Ground>;
/// [`Before`], likewise.
pub(in crate::cpu) type BeforeOf<'l, 'a, R, K> =
    Before<'l, R, <K as FrontKind<'a, R>>::Carried, <K as FrontKind<'a, R>>::Ground>;

/// A kind of front over the surface whose edges live for `'a`: what its points carry, what it needs of the
/// surface, and how it starts, goes on, and is compared. The first half is for solvers that update points one
/// by one, the second for those that update lines in lanes.
pub(in crate::cpu) trait FrontKind<'a, R: Real>:
    Clone + std::fmt::Debug + Send + Sync
{
    /// What the front at a point carries beside its arrival time.
    type Carried: Carried;

    /// What comes to a point.
    type Arrival: Copy;

    /// Whether fronts that have been accepted may be taken back for later ones, and seeds that were later be lost with
    /// them ([`Seed::is_lost`]).
    const TAKES_BACK: bool = false;

    /// Tells of all seeds that are about to be added, before the first of them is.
    fn expect(&mut self, _: &[Seed]) {}

    /// What comes from a seed.
    fn arrival_of_seed(&mut self, seed: &Seed) -> Self::Arrival;

    /// The same front, which those of sources that are added later may replace ([`Seed::exact`]).
    fn released(carried: Self::Carried) -> Self::Carried {
        carried
    }

    /// Forgets the seeds of the last map.
    fn forget(&mut self) {}

    /// The first that comes to a point through the triangles behind it, with the fronts at other points
    /// seen through `seen`.
    fn reach(
        &self,
        edges: &EdgeLengths<R>,
        point: usize,
        behind: &Behind,
        seen: impl Fn(usize) -> KeptBy<'a, R, Self>,
    ) -> Self::Arrival;

    /// The front at a point after one of the scans, numbered from 1, has brought something to it: that, if it
    /// is the first, or if the scan `renews` what it has brought before.
    fn accept(
        kept: KeptBy<'a, R, Self>,
        arrival: Self::Arrival,
        scan: u8,
        renews: bool,
    ) -> KeptBy<'a, R, Self>;

    /// The first of two fronts at a point.
    fn first(a: KeptBy<'a, R, Self>, b: KeptBy<'a, R, Self>) -> KeptBy<'a, R, Self>;

    /// How much a front has changed, in units of its arrival time ([`Real::units_between`]).
    fn change(before: KeptBy<'a, R, Self>, after: KeptBy<'a, R, Self>) -> R::Bits;

    /// What is needed of each point of the surface.
    type Ground: Pod + Send + Sync + std::fmt::Debug;

    /// Whether edges are needed in lanes.
    const NEEDS_EDGES: bool = true;

    /// What is needed of the surface, as a bordered array.
    fn ground(&self, chart: Chart) -> Cow<'a, [Self::Ground]>;

    /// Bytes held, beside that.
    fn bytes(&self) -> usize {
        0
    }

    /// Updates points of a line from the line behind, and marks which stretches of
    /// [`TILE`](crate::cpu::tiles::TILE) points have changed.
    fn update(
        &self,
        lines: &mut LinesOf<'_, 'a, R, Self>,
        line: usize,
        points: &Range<usize>,
        how: How,
        changed: &mut [bool],
    ) -> Updated<R::Bits>;

    /// Whether a scan leaves so many points in a row, of which this is the first, as they are. To be
    /// inlined into lanes.
    fn leaves(
        &self,
        before: &BeforeOf<'_, 'a, R, Self>,
        first: usize,
        stretch: StretchOf<'_, 'a, R, Self>,
        points: usize,
        how: How,
    ) -> bool;
}

/// A kind of front of which the update of a single triangle is known.
pub(in crate::cpu) trait TriangleKind<'a, R: Real>: FrontKind<'a, R> {
    /// What comes to a point x0 through the triangle with x1 and x2, whose fronts carry this; see
    /// [`crate::update::Bends`] for `alone`.
    fn arrival(
        &self,
        corners: [usize; 3],
        triangle: Triangle<R>,
        carried: [Self::Carried; 2],
        alone: bool,
    ) -> Self::Arrival;

    /// The same through the face of one of a point's triangles, or along its edges alone if it is obtuse.
    #[inline]
    fn face_arrival(
        &self,
        corners: [usize; 3],
        triangle: Triangle<R>,
        carried: [Self::Carried; 2],
        alone: bool,
    ) -> Self::Arrival {
        let c = if self.is_obtuse(corners, triangle) { R::FAR } else { triangle.c };
        self.arrival(corners, Triangle { c, ..triangle }, carried, alone)
    }

    /// The same over a slowness at x0, x1 and x2 by which the lengths are weighted, whatever is known of the points.
    /// Fronts that look at lengths alone need none.
    fn arrival_over(
        &self,
        corners: [usize; 3],
        triangle: Triangle<R>,
        carried: [Self::Carried; 2],
        _slowness: [R; 3],
    ) -> Self::Arrival {
        self.arrival(corners, triangle, carried, false)
    }

    /// Whether a triangle is obtuse at x0.
    fn is_obtuse(&self, _corners: [usize; 3], triangle: Triangle<R>) -> bool {
        triangle.is_obtuse()
    }

    /// When it comes.
    fn time(arrival: Self::Arrival) -> R;

    /// The first of two that come to a point.
    fn earlier(a: Self::Arrival, b: Self::Arrival) -> Self::Arrival;

    /// What comes to a point through the parts of its triangle between two neighbours, if that is obtuse
    /// ([`EdgeLengths::split`]).
    fn through_parts(
        &self,
        edges: &EdgeLengths<R>,
        point: usize,
        directions: [Direction; 2],
        seen: impl Fn(usize) -> KeptBy<'a, R, Self>,
    ) -> Option<Self::Arrival> {
        let mut first: Option<Self::Arrival> = None;
        edges.split(point, directions, |[x1, x2], [l1, l2, c], slowness| {
            let [a, b] = [x1, x2].map(&seen);
            let triangle = Triangle { t1: a.time, t2: b.time, l1, l2, c };
            let carried = [a.carried, b.carried];
            let arrival = self.arrival_over([point, x1, x2], triangle, carried, slowness);
            first = Some(first.map_or(arrival, |first| Self::earlier(first, arrival)));
        });
        first
    }

    /// What comes to the points of a line that have obtuse triangles behind them, by their places in it, through the
    /// parts of these, if there are any. None if no triangle there is obtuse.
    fn splits_of_line(
        &self,
        lines: &LinesOf<'_, 'a, R, Self>,
        line: usize,
        points: &Range<usize>,
        scan: Scan,
    ) -> Option<Splits<Self::Arrival>> {
        let edges = lines.place.edges;
        edges.obtuse_triangles()?;
        let [row, col] = lines.position(line, points.start, scan);
        let (of_line, first) = if scan.by_rows() { (row, col) } else { (col, row) };
        let Some(side) = edges.parts_on_side(scan.back()) else {
            return Some(self.splits_found_now(lines, [row, col], points.len(), scan));
        };
        let triangles = side.within(of_line, first..first + points.len());
        if triangles.is_empty() {
            return None;
        }
        let chart = edges.chart();
        let mut found: Splits<Self::Arrival> = Vec::new();
        for (place, parts) in triangles.parts() {
            let (row, col) = scan.lines().place(of_line, place);
            let point = chart.entry_index(row, col);
            let arrivals = parts.map(|Part { corners: [x1, x2], lengths, slowness }| {
                let [a, b] = [x1, x2].map(|x| lines.front(x));
                let [l1, l2, c] = lengths;
                let triangle = Triangle { t1: a.time, t2: b.time, l1, l2, c };
                let carried = [a.carried, b.carried];
                self.arrival_over([point, x1, x2], triangle, carried, slowness)
            });
            let arrival = arrivals.reduce(Self::earlier);
            match found.last_mut() {
                // The point's other triangle.
                Some((last, other)) if *last == place - first => {
                    *other = [*other, arrival].into_iter().flatten().reduce(Self::earlier);
                }
                _ => found.push((place - first, arrival)),
            }
        }
        Some(found)
    }

    /// The same from a point on, of parts that are not kept.
    fn splits_found_now(
        &self,
        lines: &LinesOf<'_, 'a, R, Self>,
        [row, col]: [usize; 2],
        points: usize,
        scan: Scan,
    ) -> Splits<Self::Arrival> {
        let mut found = Vec::new();
        let edges = lines.place.edges;
        let Some(obtuse) = edges.obtuse_triangles() else { return found };
        let (chart, by_rows) = (edges.chart(), scan.by_rows());
        let behind = Behind::of(chart, scan);
        let (of_line, first) = if by_rows { (row, col) } else { (col, row) };
        for &at in edges.obtuse_points(by_rows, of_line, first..first + points) {
            let at = at as usize;
            let (row, col) = scan.lines().place(of_line, at);
            let point = chart.entry_index(row, col);
            if obtuse[point] & behind.bits() == 0 {
                continue;
            }
            let of_point =
                behind.triangles().iter().filter(|slots| obtuse[point] & slots.bit() != 0);
            let arrivals = of_point.filter_map(|slots| {
                self.through_parts(edges, point, slots.directions(), |x| lines.front(x))
            });
            found.push((at - first, arrivals.reduce(Self::earlier)));
        }
        found
    }

    /// The same through one of a point's triangles.
    #[inline]
    fn through(
        &self,
        edges: &EdgeLengths<R>,
        point: usize,
        slots: &TriangleSlots,
        seen: impl Fn(usize) -> KeptBy<'a, R, Self>,
    ) -> Self::Arrival {
        let [x1, x2] = slots.corners(point);
        let kept = [x1, x2].map(&seen);
        let triangle = slots.triangle(edges, point, kept.map(|front| front.time));
        let carried = kept.map(|front| front.carried);
        let alone = slots.is_alone(triangle);
        let arrival = self.face_arrival([point, x1, x2], triangle, carried, alone);
        if !self.is_obtuse([point, x1, x2], triangle) {
            return arrival;
        }
        let parts = self.through_parts(edges, point, slots.directions(), seen);
        parts.map_or(arrival, |parts| Self::earlier(arrival, parts))
    }

    /// The curvature of a front; of one that carries none, that of a circle around its source.
    fn curvature(kept: KeptBy<'a, R, Self>) -> R;

    /// What a circle of some radius carries over a plane.
    fn circle(radius: R) -> Self::Carried;
}

/// Points of a line that have obtuse triangles, in their order, by their places in it, with what comes through parts of
/// these.
pub(super) type Splits<A> = Vec<(usize, Option<A>)>;

/// Of what comes to some points of a line, in their order, that which comes to so many from one on.
#[inline(always)]
pub(super) fn in_stretch<A>(found: &[(usize, A)], start: usize, points: usize) -> &[(usize, A)] {
    let before = |end: usize| found.partition_point(|&(place, _)| place < end);
    if found.is_empty() { found } else { &found[before(start)..before(start + points)] }
}

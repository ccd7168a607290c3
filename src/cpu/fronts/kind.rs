//! Defines what solvers require of a kind of front.

use std::ops::Range;

use bytemuck::Pod;

use super::surface_array::SurfaceArray;
use crate::cpu::behind::{Behind, TriangleSlots};
use crate::cpu::rotated::line::GridLines;
use crate::cpu::rotated::line_update::{Changed, UpdateOptions, Updated};
use crate::cpu::rotated::span::{Before, Span};
use crate::cpu::scan::Scan;
use crate::surface::{Chart, Direction, EdgeLengths, Part, Real, Seed};
use crate::update::{Carried, Kept, Triangle};

/// A kind of front over a surface. It defines what points carry, what is needed of
/// the surface, and how fronts start, continue and are compared. The first half is for solvers that update
/// points one by one, the second half for those that update lines in SIMD lanes.
pub(in crate::cpu) trait FrontKind<R: Real>:
    Clone + std::fmt::Debug + Send + Sync + 'static
{
    /// Data that the front at a point carries beside its arrival time.
    type Carried: Carried;

    /// A front that arrives at a point.
    type Arrival: Copy;

    /// Whether accepted fronts may be taken back for later ones. Seeds that were later may then be lost with
    /// them ([`Seed::is_lost`]).
    const TAKES_BACK: bool = false;

    /// Announces all seeds that are about to be added, before the first one is added.
    fn expect(&mut self, _: &[Seed]) {}

    /// Returns the front that a seed starts.
    fn arrival_of_seed(&mut self, seed: &Seed) -> Self::Arrival;

    /// Returns the same front, as one that may be replaced by those of sources that are added later
    /// ([`Seed::exact`]).
    fn released(carried: Self::Carried) -> Self::Carried {
        carried
    }

    /// Forgets the seeds of the last map.
    fn forget(&mut self) {}

    /// Returns the first front that reaches a point through the triangles behind it. `seen` gives the fronts
    /// at other points.
    fn reach(
        &self,
        edges: &EdgeLengths<R>,
        point: usize,
        behind: &Behind,
        seen: impl Fn(usize) -> Kept<R, Self::Carried>,
    ) -> Self::Arrival;

    /// Returns the front at a point after `arrival` has reached it, brought by `scan` (numbered from one).
    /// The arrival is taken if it is the first, or if the scan `renews` a front that it brought earlier.
    fn accept(
        kept: Kept<R, Self::Carried>,
        arrival: Self::Arrival,
        scan: u8,
        renews: bool,
    ) -> Kept<R, Self::Carried>;

    /// Returns the front at a point as one that arrives at a copy of the point, on a glued surface.
    fn arrival_of_front(kept: Kept<R, Self::Carried>) -> Self::Arrival;

    /// Returns the first of two fronts at a point.
    fn first(a: Kept<R, Self::Carried>, b: Kept<R, Self::Carried>) -> Kept<R, Self::Carried>;

    /// Returns how much a front has changed, in units of its arrival time ([`Real::units_between`]).
    fn change(before: Kept<R, Self::Carried>, after: Kept<R, Self::Carried>) -> R::Bits;

    /// Data that is needed of each point of the surface.
    type SurfaceData: Pod + Send + Sync + std::fmt::Debug;

    /// Whether updates in SIMD lanes need edge lengths.
    const NEEDS_EDGES: bool = true;

    /// Returns the data of the surface, as a bordered array.
    fn surface_data(&self, chart: Chart) -> SurfaceArray<Self::SurfaceData>;

    /// Returns the number of bytes held, without the data of the surface.
    fn bytes(&self) -> usize {
        0
    }

    /// Updates points of a line from the line behind, and marks the spans of
    /// [`TILE`](crate::cpu::rotated::tiles::TILE) points that have changed.
    fn update(
        &self,
        lines: &mut GridLines<'_, R, Self::Carried, Self::SurfaceData>,
        line: usize,
        points: &Range<usize>,
        options: UpdateOptions,
        changed: &mut [Changed],
    ) -> Updated<R::Bits>;

    /// Returns whether a scan leaves `points` points in a row unchanged, starting with the point `first`. It
    /// must be inlined into loops over SIMD lanes.
    fn leaves(
        &self,
        before: &Before<'_, R, Self::Carried, Self::SurfaceData>,
        first: usize,
        span: Span<'_, R, Self::Carried, Self::SurfaceData>,
        points: usize,
        options: UpdateOptions,
    ) -> bool;
}

/// A kind of front that can be updated from a single triangle.
pub(in crate::cpu) trait TriangleKind<R: Real>: FrontKind<R> {
    /// Returns the front that reaches x0 through the triangle with x1 and x2. `carried` is the data of the
    /// fronts there. See [`crate::update::Curvatures`] for `alone`.
    fn arrival(
        &self,
        corners: [usize; 3],
        triangle: Triangle<R>,
        carried: [Self::Carried; 2],
        alone: bool,
    ) -> Self::Arrival;

    /// Returns the same through the face of one of a point's triangles. Of an obtuse one only the edges are
    /// used.
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

    /// Returns the same with an explicit slowness at x0, x1 and x2, by which the lengths are weighted,
    /// instead of the slowness of the points. Fronts that depend on lengths alone ignore it.
    fn arrival_over(
        &self,
        corners: [usize; 3],
        triangle: Triangle<R>,
        carried: [Self::Carried; 2],
        _slowness: [R; 3],
    ) -> Self::Arrival {
        self.arrival(corners, triangle, carried, false)
    }

    /// Returns whether a triangle is obtuse at x0.
    fn is_obtuse(&self, _corners: [usize; 3], triangle: Triangle<R>) -> bool {
        triangle.is_obtuse()
    }

    /// Returns the arrival time.
    fn time(arrival: Self::Arrival) -> R;

    /// Returns the first of two fronts that arrive at a point.
    fn earlier(a: Self::Arrival, b: Self::Arrival) -> Self::Arrival;

    /// Returns the first front that reaches a point through the parts of its triangle between two neighbours,
    /// if that triangle is obtuse ([`EdgeLengths::split`]).
    fn through_parts(
        &self,
        edges: &EdgeLengths<R>,
        point: usize,
        directions: [Direction; 2],
        seen: impl Fn(usize) -> Kept<R, Self::Carried>,
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

    /// Finds the fronts that reach the points of a line through parts of obtuse triangles behind them.
    /// Returns them by the points' places in the line, or `None` if no triangle there is obtuse.
    fn splits_of_line(
        &self,
        lines: &GridLines<'_, R, Self::Carried, Self::SurfaceData>,
        line: usize,
        points: &Range<usize>,
        scan: Scan,
    ) -> Option<Splits<Self::Arrival>> {
        let edges = lines.place.edges;
        edges.obtuse_triangles()?;
        let [row, col] = lines.position(line, points.start, scan);
        let (of_line, first) = if scan.by_rows() { (row, col) } else { (col, row) };
        let Some(side) = edges.stored_parts_on_side(scan.back()) else {
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

    /// Finds the same fronts for parts that are not stored, from a point on.
    fn splits_found_now(
        &self,
        lines: &GridLines<'_, R, Self::Carried, Self::SurfaceData>,
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

    /// Returns the front through one of a point's triangles, including the parts of an obtuse one.
    #[inline]
    fn through(
        &self,
        edges: &EdgeLengths<R>,
        point: usize,
        slots: &TriangleSlots,
        seen: impl Fn(usize) -> Kept<R, Self::Carried>,
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

    /// Returns the curvature of a front. If the front carries none, this is the curvature of a circle around
    /// its source.
    fn curvature(kept: Kept<R, Self::Carried>) -> R;

    /// Returns the data that a circular front of the given radius carries over a plane.
    fn circle(radius: R) -> Self::Carried;
}

/// The points of a line that have obtuse triangles, in order, by their places in the line. Each has the front
/// that arrives through parts of these triangles, if any.
pub(super) type Splits<A> = Vec<(usize, Option<A>)>;

/// Returns the entries for `points` points from `start` on, out of entries for points of a line in order.
#[inline(always)]
pub(super) fn in_span<A>(found: &[(usize, A)], start: usize, points: usize) -> &[(usize, A)] {
    let before = |end: usize| found.partition_point(|&(place, _)| place < end);
    if found.is_empty() { found } else { &found[before(start)..before(start + points)] }
}

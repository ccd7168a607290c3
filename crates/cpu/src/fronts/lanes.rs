//! Defines the interface between solvers and kinds of fronts whose lines are updated in SIMD lanes.

use std::ops::Range;

use bytemuck::Pod;

use super::kind::{PointKind, TriangleFronts, TriangleKind};
use super::surface_array::SurfaceArray;
use crate::behind::Behind;
use crate::lines::line::{GridLines, ScanLine};
use crate::lines::span::{Before, LargestChanges, Span};
use crate::scan::{Scan, UpdateOptions};
use geosweep_surface::update::Triangle;
use geosweep_surface::{Chart, Real, SplitPart};

/// A kind of front whose points can be updated line by line, in SIMD lanes.
pub(crate) trait LaneKind<R: Real>: PointKind<R> {
    /// Data of a point of the surface that updates read.
    type SurfaceData: Pod + Send + Sync + std::fmt::Debug;

    /// Whether updates in SIMD lanes need edge lengths.
    const NEEDS_EDGES: bool = true;

    /// Whether updates report changes of curvature ([`LargestChanges::note_bend`]).
    const TELLS_BENDS: bool = false;

    /// Returns the data of the surface, as a bordered array.
    fn surface_data(&self, chart: Chart) -> SurfaceArray<Self::SurfaceData>;

    /// Returns the memory in bytes, without the data of the surface.
    fn bytes(&self) -> usize {
        0
    }

    /// Data that updates of a line's spans read from the kind of front.
    type OfLine<'k>;

    /// Prepares the update of a line, given the row and column of its first point, counted from the border.
    fn of_line(&self, first: [usize; 2], scan: Scan) -> Self::OfLine<'_>;

    /// Updates some points of a line, given the first of them, their number, and the `splits` among them. Returns
    /// whether any front or tag has changed, or `None` if all points are settled. Implementations must be inlined
    /// into loops over SIMD lanes.
    fn update_span(
        of_line: &Self::OfLine<'_>,
        line: &mut ScanLine<'_, '_, R, Self::Carried, Self::SurfaceData>,
        span: [usize; 2],
        splits: &[(usize, Option<Self::Arrival>)],
        options: UpdateOptions,
        changes: &mut LargestChanges<R>,
    ) -> Option<bool>;

    /// Returns whether a scan leaves `points` adjacent points of a row unchanged, from the point `first` on.
    /// Implementations must be inlined into loops over SIMD lanes.
    fn leaves(
        &self,
        before: &Before<'_, R, Self::Carried, Self::SurfaceData>,
        first: usize,
        span: Span<'_, R, Self::Carried, Self::SurfaceData>,
        points: usize,
        options: UpdateOptions,
    ) -> bool;
}

/// Finds the fronts that reach the points of a line through parts of obtuse triangles behind them. Returns them with
/// the points' positions in the line, or `None` if no triangle there is obtuse.
pub(super) fn splits_of_line<R: Real, K: TriangleKind<R>, G>(
    kind: &K,
    lines: &GridLines<'_, R, K::Carried, G>,
    line: usize,
    points: &Range<usize>,
) -> Option<Splits<K::Arrival>> {
    let (edges, scan) = (lines.place.edges, lines.place.scan);
    edges.obtuse_triangles()?;
    let [row, col] = lines.place.position(line, points.start);
    let (of_line, first) = if scan.by_rows() { (row, col) } else { (col, row) };
    let Some(side) = edges.stored_parts_on_side(scan.back()) else {
        return Some(splits_found_now(kind, lines, [row, col], points.len()));
    };
    let triangles = side.within(of_line, first..first + points.len());
    if triangles.is_empty() {
        return None;
    }
    let chart = edges.chart();
    let mut found: Splits<K::Arrival> = Vec::new();
    for (place, parts) in triangles.parts() {
        let (row, col) = scan.lines().place(of_line, place);
        let point = chart.entry_index(row, col);
        let arrivals = parts.map(|SplitPart { corners: [x1, x2], lengths, slowness }| {
            let [a, b] = [x1, x2].map(|x| lines.front(x));
            let [l1, l2, c] = lengths;
            let triangle = Triangle { t1: a.time, t2: b.time, l1, l2, c };
            let carried = [a.carried, b.carried];
            kind.arrival_over([point, x1, x2], triangle, carried, slowness)
        });
        let arrival = arrivals.reduce(K::Carried::earlier);
        match found.last_mut() {
            // The previous entry is the other triangle of the same point.
            Some((last, other)) if *last == place - first => {
                *other = [*other, arrival].into_iter().flatten().reduce(K::Carried::earlier);
            }
            _ => found.push((place - first, arrival)),
        }
    }
    Some(found)
}

/// Finds the fronts through parts of obtuse triangles that are not stored and have to be searched, for `points` points
/// of a line from a row and column on.
fn splits_found_now<R: Real, K: TriangleKind<R>, G>(
    kind: &K,
    lines: &GridLines<'_, R, K::Carried, G>,
    [row, col]: [usize; 2],
    points: usize,
) -> Splits<K::Arrival> {
    let mut found = Vec::new();
    let (edges, scan) = (lines.place.edges, lines.place.scan);
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
        let of_point = behind.triangles().iter().filter(|slots| obtuse[point] & slots.bit() != 0);
        let arrivals = of_point.filter_map(|slots| {
            kind.through_parts(edges, point, slots.directions(), |x| lines.front(x))
        });
        found.push((at - first, arrivals.reduce(K::Carried::earlier)));
    }
    found
}

/// Points of a line that have obtuse triangles, in ascending order of their positions. Each entry has the front that
/// arrives through parts of these triangles, if any.
pub(crate) type Splits<A> = Vec<(usize, Option<A>)>;

//! Implements planar fronts over an uneven slowness.

use std::ops::Range;
use std::sync::Arc;

use super::kind::{FrontKind, TriangleKind, in_span};
use super::slowed::{Seen, TimeChanges};
use super::surface_array::SurfaceArray;
use crate::cpu::behind::Behind;
use crate::cpu::rotated::line::{GridLines, ScanLine};
use crate::cpu::rotated::line_update::{Changed, LineUpdate, Spans, UpdateOptions, Updated};
use crate::cpu::rotated::span::{Before, Span};
use crate::cpu::rotated::tiles::TILE;
use crate::surface::{Chart, EdgeLengths, Real, Seed, min};
use crate::update::{Kept, Triangle, is_settled_slowed, planar_slowed};

/// The front of [`crate::Wavefront::Planar`] over a surface with an uneven slowness.
#[derive(Clone, Debug)]
pub(in crate::cpu) struct SlowedPlanar<R> {
    /// Slowness at each point of the bordered array.
    slowness: Arc<Vec<R>>,
}

impl<R: Real> SlowedPlanar<R> {
    /// Creates the front for a surface with this slowness.
    pub(in crate::cpu) fn new(slowness: Arc<Vec<R>>) -> Self {
        Self { slowness }
    }
}

impl<R: Real> FrontKind<R> for SlowedPlanar<R> {
    type Carried = ();
    type Arrival = R;
    type SurfaceData = R;

    fn arrival_of_seed(&mut self, seed: &Seed) -> R {
        R::of(seed.time)
    }

    #[inline]
    fn reach(
        &self,
        edges: &EdgeLengths<R>,
        point: usize,
        behind: &Behind,
        seen: impl Fn(usize) -> Kept<R, ()>,
    ) -> R {
        let [a, b] =
            behind.triangles().each_ref().map(|slots| self.through(edges, point, slots, &seen));
        min(a, b)
    }

    #[inline(always)]
    fn accept(kept: Kept<R, ()>, time: R, _: u8, _: bool) -> Kept<R, ()> {
        Kept { time: min(kept.time, time), carried: () }
    }

    fn arrival_of_front(kept: Kept<R, ()>) -> R {
        kept.time
    }

    #[inline(always)]
    fn first(a: Kept<R, ()>, b: Kept<R, ()>) -> Kept<R, ()> {
        Kept { time: min(a.time, b.time), carried: () }
    }

    #[inline(always)]
    fn change(before: Kept<R, ()>, after: Kept<R, ()>) -> R::Bits {
        before.time.units_between(after.time)
    }

    fn surface_data(&self, _: Chart) -> SurfaceArray<R> {
        SurfaceArray::OfEdges(self.slowness.clone())
    }

    fn update(
        &self,
        lines: &mut GridLines<'_, R, Self::Carried, Self::SurfaceData>,
        line: usize,
        points: &Range<usize>,
        options: UpdateOptions,
        changed: &mut [Changed],
    ) -> Updated<R::Bits> {
        let splits = self.splits_of_line(lines, line, points, options.scan).unwrap_or_default();
        let parts: Vec<_> = splits.into_iter().filter_map(|(at, some)| Some((at, some?))).collect();
        let line = PlanarLine { line: lines.line(line, points, options.scan), parts: &parts };
        options.instructions.run(LineUpdate { line, options, changed })
    }

    #[inline(always)]
    fn leaves(
        &self,
        before: &Before<'_, R, Self::Carried, Self::SurfaceData>,
        first: usize,
        span: Span<'_, R, Self::Carried, Self::SurfaceData>,
        points: usize,
        options: UpdateOptions,
    ) -> bool {
        if span.leads(points) {
            return true;
        }
        let behind = Behind::of(before.edges.chart(), options.scan);
        let at = behind.points().map(|offset| first.wrapping_add_signed(offset));
        let slowness_behind = at.map(|at| &before.surface_data[at..][..points]);
        stays(
            &Seen {
                span: &span,
                own: |i: usize| span.surface_data[i],
                behind: |k: usize, i: usize| slowness_behind[k][i],
            },
            points,
            options.limit,
        )
    }
}

impl<R: Real> TriangleKind<R> for SlowedPlanar<R> {
    #[inline]
    fn arrival(&self, corners: [usize; 3], triangle: Triangle<R>, _: [(); 2], _: bool) -> R {
        planar_slowed(triangle, corners.map(|corner| self.slowness[corner]))
    }

    fn arrival_over(
        &self,
        _: [usize; 3],
        triangle: Triangle<R>,
        _: [(); 2],
        slowness: [R; 3],
    ) -> R {
        planar_slowed(triangle, slowness)
    }

    fn is_obtuse(&self, corners: [usize; 3], triangle: Triangle<R>) -> bool {
        triangle.is_obtuse_on_surface(corners.map(|corner| self.slowness[corner]))
    }

    fn time(arrival: R) -> R {
        arrival
    }

    fn earlier(a: R, b: R) -> R {
        min(a, b)
    }

    fn curvature(kept: Kept<R, Self::Carried>) -> R {
        kept.time.recip()
    }

    fn circle(_: R) {}
}

/// Returns whether no front arrives earlier at any of the points.
#[inline(always)]
fn stays<R: Real, O: Fn(usize) -> R, B: Fn(usize, usize) -> R>(
    seen: &Seen<'_, R, (), R, O, B>,
    points: usize,
    limit: f64,
) -> bool {
    let (mut settled, limit) = (true, R::of(limit));
    for i in 0..points {
        let now = min(seen.span.times[i], limit);
        let (left, left_slowness) = seen.seen_from_beside::<true>(i);
        let (right, right_slowness) = seen.seen_from_beside::<false>(i);
        settled &= is_settled_slowed(left, None, left_slowness, now)
            & is_settled_slowed(right, None, right_slowness, now);
    }
    settled
}

/// A line while a scan updates it.
struct PlanarLine<'a, R> {
    line: ScanLine<'a, R, (), R>,
    /// Arrival times through parts of obtuse triangles, by the point's place in the line.
    parts: &'a [(usize, R)],
}

impl<R: Real> Spans for PlanarLine<'_, R> {
    type Changes = TimeChanges<R>;
    type Bits = R::Bits;

    #[inline(always)]
    fn points(&self) -> usize {
        self.line.times.len()
    }

    #[inline(always)]
    fn prefetch_next(&self, start: usize) {
        self.line.prefetch_next(start);
    }

    #[inline(always)]
    fn is_beyond(&self, start: usize, points: usize, limit: f64) -> bool {
        limit < f64::INFINITY && self.line.span(start, points).is_beyond(points, limit)
    }

    #[inline(always)]
    fn update(
        &mut self,
        start: usize,
        points: usize,
        options: UpdateOptions,
        changes: &mut TimeChanges<R>,
    ) -> Option<Changed> {
        let span = self.line.span(start, points);
        let behind = self.line.ground_behind(start, points);
        let seen = Seen {
            span: &span,
            own: |i: usize| span.surface_data[i],
            behind: |k: usize, i: usize| behind[k][i],
        };
        let parts = in_span(self.parts, start, points);
        if parts.is_empty() && (span.leads(points) || stays(&seen, points, options.limit)) {
            return None;
        }
        let mut after = [R::zero(); TILE];
        for (i, after) in after[..points].iter_mut().enumerate() {
            let (left, left_slowness) = seen.triangle::<true>(i);
            let (right, right_slowness) = seen.triangle::<false>(i);
            let time =
                min(planar_slowed(left, left_slowness), planar_slowed(right, right_slowness));
            *after = min(span.times[i], time);
        }
        for &(point, time) in parts {
            after[point - start] = min(after[point - start], time);
        }
        let any = changes.note(span.times, &after[..points]);
        let first = |i: usize| (after[i] < span.times[i]).then_some(after[i]);
        let changed = Changed::of(any, options.limit, points, first);
        self.line.times[start..][..points].copy_from_slice(&after[..points]);
        Some(changed)
    }

    #[inline(always)]
    fn largest(changes: TimeChanges<R>) -> R::Bits {
        changes.largest()
    }
}

//! Implements planar fronts over an uneven slowness.

use std::ops::Range;
use std::sync::Arc;

use super::kind::{FrontKind, TriangleKind, Triangular};
use super::lanes::{LaneKind, Splits, splits_of_line};
use super::slowed::Seen;
use super::surface_array::SurfaceArray;
use crate::behind::Behind;
use crate::lines::line::{GridLines, ScanLine};
use crate::lines::span::{Before, LargestChanges, Span, TILE};
use crate::scan::{Scan, UpdateOptions};
use geosweep_surface::update::{Kept, Triangle, is_settled_slowed, planar_slowed};
use geosweep_surface::{Chart, Real, Seed, min};

/// The front of [`geosweep_surface::Wavefront::Planar`] over a surface with an uneven slowness.
#[derive(Clone, Debug)]
pub(crate) struct SlowedPlanar<R> {
    /// Slowness at each point of the bordered array.
    slowness: Arc<Vec<R>>,
}

impl<R: Real> SlowedPlanar<R> {
    /// Creates the front for a surface with this slowness.
    pub(crate) fn new(slowness: Arc<Vec<R>>) -> Self {
        Self { slowness }
    }
}

impl<R: Real> FrontKind<R> for SlowedPlanar<R> {
    type Carried = ();
    type Arrival = R;

    fn arrival_of_seed(&mut self, seed: &Seed) -> R {
        R::of(seed.time)
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
}

impl<R: Real> LaneKind<R> for SlowedPlanar<R> {
    type SurfaceData = R;
    type OfLine<'k> = ();

    fn surface_data(&self, _: Chart) -> SurfaceArray<R> {
        SurfaceArray::OfEdges(self.slowness.clone())
    }

    fn of_line(&self, _: [usize; 2], _: Scan) {}

    fn splits(
        &self,
        lines: &GridLines<'_, R, Self::Carried, Self::SurfaceData>,
        line: usize,
        points: &Range<usize>,
    ) -> Option<Splits<Self::Arrival>> {
        splits_of_line(self, lines, line, points)
    }

    #[inline(always)]
    fn update_span(
        _: &(),
        line: &mut ScanLine<'_, '_, R, Self::Carried, Self::SurfaceData>,
        [start, points]: [usize; 2],
        splits: &[(usize, Option<Self::Arrival>)],
        options: UpdateOptions,
        changes: &mut LargestChanges<R>,
    ) -> Option<bool> {
        let span = line.span(start, points);
        let behind = line.surface_behind(start, points);
        let seen = Seen {
            span: &span,
            own: |i: usize| span.surface_data[i],
            behind: |k: usize, i: usize| behind[k][i],
        };
        let is_alone = splits.iter().all(|(_, time)| time.is_none());
        if is_alone && (span.leads(points) || stays(&seen, points, options.limit)) {
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
        for &(point, time) in splits {
            if let Some(time) = time {
                after[point - start] = min(after[point - start], time);
            }
        }
        let any = changes.note_times(span.times, &after[..points]);
        line.set(start, &after[..points], &[]);
        Some(any)
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
        let at = behind.points().map(|offset| offset.from(first));
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

impl<R> Triangular for SlowedPlanar<R> {}

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

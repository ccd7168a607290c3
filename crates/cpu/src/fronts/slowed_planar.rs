//! Implements planar fronts over an uneven slowness.

use std::sync::Arc;

use super::kind::{FrontKind, TriangleKind, Triangular};
use super::lanes::LaneKind;
use super::slowed::Seen;
use super::surface_array::SurfaceArray;
use crate::lines::line::ScanLine;
use crate::lines::span::{Before, LargestChanges, Span, TILE};
use crate::scan::{Scan, UpdateOptions};
use geosweep_surface::update::{Triangle, is_settled_slowed, planar_slowed};
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
}

impl<R: Real> LaneKind<R> for SlowedPlanar<R> {
    type SurfaceData = R;
    type OfLine<'k> = ();

    fn surface_data(&self, _: Chart) -> SurfaceArray<R> {
        SurfaceArray::OfEdges(self.slowness.clone())
    }

    fn of_line(&self, _: [usize; 2], _: Scan) {}

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
        let seen = Seen { span: &span, behind, slowness: |slowness| slowness };
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
        let seen = Seen::before(before, first, &span, points, options.scan, |slowness| slowness);
        span.leads(points) || stays(&seen, points, options.limit)
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
}

/// Returns whether no front arrives earlier at any of the points.
#[inline(always)]
fn stays<R: Real>(seen: &Seen<'_, R, (), R, impl Fn(R) -> R>, points: usize, limit: f64) -> bool {
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

//! Implements planar fronts over an uneven slowness.

use std::sync::Arc;

use super::kind::{FrontKind, TriangleKind, Triangular};
use super::lanes::LaneKind;
use super::pulled::{MOST, Pulled, prefetch_rows};
use super::slowed::Seen;
use super::surface_array::SurfaceArray;
use crate::lines::line::ScanLine;
use crate::lines::span::{Before, LargestChanges, Span, TILE};
use crate::scan::{Scan, UpdateOptions};
use geosweep_surface::update::{Triangle, is_uneven, planar_slowed, planar_slowed_at};
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
    /// With lanes of 64 bits, LLVM 22 fails to allocate the registers of AVX-512 in loops as long as these.
    const AVX512: bool = size_of::<R>() == size_of::<f32>();

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
        _: UpdateOptions,
        changes: &mut LargestChanges<R>,
    ) -> Option<bool> {
        let span = line.span(start, points);
        let behind = line.surface_behind(start, points);
        let seen = Seen::new(&span, behind, points, numbers);
        let is_alone = splits.iter().all(|(_, time)| time.is_none());
        if is_alone && span.leads(points) {
            return None;
        }
        let mut after = through_both(&span, &seen, points);
        for &(point, time) in splits {
            if let Some(time) = time {
                let i = point - start;
                after[i] = first(after[i], time);
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
        let seen = Seen::before(before, first, &span, points, options.scan, numbers);
        span.leads(points) || stays(&span, &seen, points, options.limit)
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

    #[inline(always)]
    fn arrivals(&self, triangles: &Pulled<R, ()>, arrivals: &mut [R; MOST]) {
        for start in (0..triangles.count).step_by(TILE) {
            let slowness = triangles.at_corners(start, &self.slowness);
            let mut uneven = false;
            let [s0, s1, s2] = &slowness;
            for ((&s0, &s1), &s2) in s0.iter().zip(s1).zip(s2) {
                uneven |= is_uneven([s0, s1, s2]);
            }
            let times = if uneven {
                times_of::<R, true>(triangles, start, &slowness)
            } else {
                times_of::<R, false>(triangles, start, &slowness)
            };
            arrivals[start..start + TILE].copy_from_slice(&times);
        }
    }

    #[inline(always)]
    fn prefetch(&self, points: [usize; 3]) {
        prefetch_rows(&self.slowness, points);
    }

    fn is_obtuse(&self, corners: [usize; 3], triangle: Triangle<R>) -> bool {
        triangle.is_obtuse_on_surface(corners.map(|corner| self.slowness[corner]))
    }
}

/// Returns the numbers of [`Seen`] in the data of a point.
#[inline(always)]
fn numbers<R: Real>(slowness: &R) -> [R; 2] {
    [R::zero(), *slowness]
}

/// Returns the times of fronts through [`TILE`] triangles.
#[inline(always)]
fn times_of<R: Real, const UNEVEN: bool>(
    triangles: &Pulled<R, ()>,
    start: usize,
    [s0, s1, s2]: &[[R; TILE]; 3],
) -> [R; TILE] {
    let lanes = triangles.lanes(start);
    let mut times = [R::zero(); TILE];
    for (k, time) in times.iter_mut().enumerate() {
        let slowness = [s0[k], s1[k], s2[k]];
        *time = planar_slowed_at::<R, UNEVEN, true>(lanes.triangle(k), slowness);
    }
    times
}

/// Returns the earlier of the present time and that of an arriving front. Gains within rounding are ignored. Otherwise a
/// change of the last digit would spread from point to point, and all these points would be visited again.
#[inline(always)]
fn first<R: Real>(now: R, time: R) -> R {
    let is_earlier = time < now - now * (R::of(GAIN) * R::epsilon());
    if is_earlier { time } else { now }
}

/// Least gain of an arrival time, in units of its rounding.
const GAIN: f64 = 2.0;

/// Returns the times of the points after an update from both of their triangles.
#[inline(always)]
fn through_both<R: Real>(span: &Span<'_, R, (), R>, seen: &Seen<R>, points: usize) -> [R; TILE] {
    if seen.is_uneven(points) {
        updated::<R, true>(span, seen, points)
    } else {
        updated::<R, false>(span, seen, points)
    }
}

#[inline(always)]
fn updated<R: Real, const UNEVEN: bool>(
    span: &Span<'_, R, (), R>,
    seen: &Seen<R>,
    points: usize,
) -> [R; TILE] {
    let mut after = [R::zero(); TILE];
    for (i, after) in after[..points].iter_mut().enumerate() {
        let (triangle, slowness) = seen.triangle::<(), R, true>(span, i);
        *after = planar_slowed_at::<R, UNEVEN, true>(triangle, slowness);
    }
    for (i, after) in after[..points].iter_mut().enumerate() {
        let (triangle, slowness) = seen.triangle::<(), R, false>(span, i);
        let time = planar_slowed_at::<R, UNEVEN, true>(triangle, slowness);
        *after = first(span.times[i], min(*after, time));
    }
    after
}

/// Returns whether no front arrives earlier at any of the points. The update itself takes hardly longer than a bound of
/// its time.
#[inline(always)]
fn stays<R: Real>(span: &Span<'_, R, (), R>, seen: &Seen<R>, points: usize, limit: f64) -> bool {
    let (after, limit) = (through_both(span, seen, points), R::of(limit));
    let mut stays = true;
    for (i, &after) in after[..points].iter().enumerate() {
        stays &= (after >= span.times[i]) | (after > limit);
    }
    stays
}

//! Implements planar and circular fronts, which carry nothing besides their arrival time.

use super::kind::{FrontKind, Fronts, TriangleFronts, TriangleKind, Triangular};
use super::lanes::LaneKind;
use super::pulled::{MOST, Pulled};
use super::surface_array::SurfaceArray;
use crate::lines::line::ScanLine;
use crate::lines::settled::Visited;
use crate::lines::span::{Before, LargestChanges, Span, TILE};
use crate::scan::{Scan, UpdateOptions};
use geosweep_surface::update::{StoredFront, Triangle};
use geosweep_surface::{Chart, Origins, Real, Seed, min};

/// The operations in which planar and circular fronts differ.
pub(crate) trait Straight: Copy + std::fmt::Debug + Send + Sync + 'static {
    /// Returns the record of the map's origins, if updates depend on whether fronts can meet.
    fn origins(&mut self) -> Option<&mut Origins> {
        None
    }

    /// Returns the arrival time through a triangle.
    fn time<R: Real>(self, triangle: Triangle<R>) -> R;

    /// Returns the arrival time at a point after an update through a triangle, in SIMD lanes. Circular fronts ignore
    /// gains within rounding.
    fn earlier<R: Real>(self, now: R, triangle: Triangle<R>) -> R;

    /// Returns the arrival time at a point after a front arrives at `time`, by the rule of [`Straight::earlier`].
    fn first<R: Real>(now: R, time: R) -> R;

    /// Returns whether a cheap test finds that no front arrives through a triangle earlier than `now`. The test may
    /// miss some settled points.
    fn is_settled<R: Real>(triangle: Triangle<R>, now: R) -> bool;
}

#[inline(always)]
fn at<R>(time: R) -> StoredFront<R, ()> {
    StoredFront { time, carried: () }
}

impl<R: Real> Fronts<R> for () {
    type Arrival = R;

    #[inline(always)]
    fn accept(kept: StoredFront<R, ()>, time: R, _: u8, _: bool) -> StoredFront<R, ()> {
        at(min(kept.time, time))
    }

    fn arrival_of_front(kept: StoredFront<R, ()>) -> R {
        kept.time
    }

    #[inline(always)]
    fn first(a: StoredFront<R, ()>, b: StoredFront<R, ()>) -> StoredFront<R, ()> {
        at(min(a.time, b.time))
    }

    #[inline(always)]
    fn change(before: StoredFront<R, ()>, after: StoredFront<R, ()>) -> R::Bits {
        before.time.units_between(after.time)
    }
}

impl<R: Real> TriangleFronts<R> for () {
    fn time(arrival: R) -> R {
        arrival
    }

    fn earlier(a: R, b: R) -> R {
        min(a, b)
    }

    fn curvature(kept: StoredFront<R, ()>) -> R {
        kept.time.recip()
    }

    fn circle(_: R) {}
}

impl<R: Real, S: Straight> FrontKind<R> for S {
    type Carried = ();
    type Arrival = R;

    fn arrival_of_seed(&mut self, seed: &Seed) -> R {
        if let Some(origins) = self.origins() {
            origins.add(seed);
        }
        R::of(seed.time)
    }

    fn forget(&mut self) {
        if let Some(origins) = self.origins() {
            origins.forget();
        }
    }
}

impl<R: Real, S: Straight> LaneKind<R> for S {
    type SurfaceData = ();
    type OfLine<'k> = S;

    fn surface_data(&self, chart: Chart) -> SurfaceArray<()> {
        SurfaceArray::Own(vec![(); chart.bordered_points()])
    }

    fn of_line(&self, _: [usize; 2], _: Scan) -> S {
        *self
    }

    #[inline(always)]
    fn update_span(
        kind: &S,
        line: &mut ScanLine<'_, '_, R, Self::Carried, Self::SurfaceData>,
        [start, points]: [usize; 2],
        splits: &[(usize, Option<Self::Arrival>)],
        options: UpdateOptions,
        changes: &mut LargestChanges<R>,
    ) -> Option<bool> {
        let span = line.span(start, points);
        let mut before = [R::zero(); TILE];
        before[..points].copy_from_slice(span.times);
        let after = if splits.is_empty() {
            if span.leads(points) {
                return None;
            }
            // Unreached points are about to be reached, unless the map has a limit. Testing whether they are settled
            // would only cost time.
            let is_new = options.limit == f64::INFINITY && span.is_unreached(points);
            if !is_new && stays::<R, S, false>(&span, points, options.limit) {
                return None;
            }
            through_both::<R, S, false>(*kind, &span, &before, points)
        } else {
            let (mut now, mut any) = (before, false);
            for &(point, time) in splits {
                if let Some(time) = time {
                    let i = point - start;
                    now[i] = S::first(now[i], time);
                    any |= now[i] < before[i];
                }
            }
            if !any && (span.leads(points) || stays::<R, S, true>(&span, points, options.limit)) {
                return None;
            }
            through_both::<R, S, true>(*kind, &span, &now, points)
        };
        let any = changes.note_times(&before[..points], &after[..points]);
        line.set(start, &after[..points], &[]);
        Some(any)
    }

    #[inline(always)]
    fn leaves(
        &self,
        _: &Before<'_, R, Self::Carried, Self::SurfaceData>,
        _: usize,
        span: Span<'_, R, Self::Carried, Self::SurfaceData>,
        points: usize,
        options: UpdateOptions,
    ) -> bool {
        span.leads(points) || stays::<R, S, false>(&span, points, options.limit)
    }
}

impl<S: Straight> Triangular for S {}

impl<R: Real, S: Straight> TriangleKind<R> for S {
    #[inline]
    fn arrival(&self, _: [usize; 3], triangle: Triangle<R>, _: [(); 2], _: bool) -> R {
        Straight::time(*self, triangle)
    }

    #[inline(always)]
    fn arrivals(&self, triangles: &Pulled<R, ()>, arrivals: &mut [R; MOST]) {
        for start in (0..triangles.count).step_by(TILE) {
            let lanes = triangles.lanes(start);
            for (k, time) in arrivals[start..start + TILE].iter_mut().enumerate() {
                *time = Straight::time(*self, lanes.triangle(k).without_obtuse_face());
            }
        }
    }
}

/// Returns whether tests find that no front arrives earlier at any of the points.
#[inline(always)]
fn stays<R: Real, S: Straight, const SPLIT: bool>(
    span: &Span<R, (), ()>,
    points: usize,
    limit: f64,
) -> bool {
    let (mut settled, limit) = (true, R::of(limit));
    for i in 0..points {
        let visited: Visited<R> = span.visited::<SPLIT>(i, limit);
        let [left, right] = visited.triangles;
        let of = [S::is_settled(left, visited.now), S::is_settled(right, visited.now)];
        settled &= visited.stays(of);
    }
    settled
}

/// Returns, for each point, the earlier of the arrival time `now` and the arrival time through one of the point's two
/// triangles. Compilers keep the resulting array in registers. If this function wrote to the line, compilers would
/// store each value in memory.
#[inline(always)]
fn earlier<R: Real, S: Straight, const LEFT: bool, const SPLIT: bool>(
    kind: S,
    span: &Span<R, (), ()>,
    now: &[R; TILE],
    points: usize,
) -> [R; TILE] {
    let mut times = [R::zero(); TILE];
    for i in 0..points {
        times[i] = kind.earlier(now[i], span.triangle::<LEFT, SPLIT>(i));
    }
    times
}

/// Updates points from both of their triangles. `SPLIT` tells whether some of these may be obtuse.
#[inline(always)]
fn through_both<R: Real, S: Straight, const SPLIT: bool>(
    kind: S,
    span: &Span<R, (), ()>,
    now: &[R; TILE],
    points: usize,
) -> [R; TILE] {
    if span.comes_from_left(points) {
        updated::<R, S, true, false, SPLIT>(kind, span, now, points)
    } else {
        updated::<R, S, false, true, SPLIT>(kind, span, now, points)
    }
}

/// Updates points from the triangle through which the front most likely comes. Updates them from the other one too,
/// unless a test finds that no front arrives earlier through it.
#[inline(always)]
fn updated<
    R: Real,
    S: Straight,
    const FIRST_LEFT: bool,
    const SECOND_LEFT: bool,
    const SPLIT: bool,
>(
    kind: S,
    span: &Span<R, (), ()>,
    now: &[R; TILE],
    points: usize,
) -> [R; TILE] {
    let first = earlier::<R, S, FIRST_LEFT, SPLIT>(kind, span, now, points);
    let mut settled = true;
    for (i, &time) in first[..points].iter().enumerate() {
        settled &= S::is_settled(span.seen_from_beside::<SECOND_LEFT, SPLIT>(i), time);
    }
    if settled { first } else { earlier::<R, S, SECOND_LEFT, SPLIT>(kind, span, &first, points) }
}

//! Implements fronts that carry their curvature over an uneven slowness.

use std::ops::Range;
use std::sync::Arc;

use super::curved::{FirstFronts, KeptCurved, accept, first};
use super::kind::{FrontKind, TriangleKind, in_span};
use super::slowed::Seen;
use super::surface_array::SurfaceArray;
use crate::cpu::behind::Behind;
use crate::cpu::bend_units;
use crate::cpu::rotated::line::{GridLines, ScanLine};
use crate::cpu::rotated::line_update::{Changed, LineUpdate, Spans, UpdateOptions, Updated};
use crate::cpu::rotated::span::{Before, Span};
use crate::cpu::rotated::tiles::TILE;
use crate::surface::{Chart, EdgeLengths, Origins, Real, Seed, min};
use crate::update::{
    Curvature, Curvatures, Front, Kept, Triangle, curved_slowed, is_settled_slowed,
};

/// The front of [`crate::Wavefront::Curved`] over a surface with an uneven slowness.
#[derive(Clone, Debug)]
pub(in crate::cpu) struct SlowedCurved<R> {
    /// The Gaussian curvature of the surface's metric weighted by the slowness, with a tag where waves
    /// diffract; and the slowness.
    gaussian: Arc<Vec<R>>,
    slowness: Arc<Vec<R>>,
    origins: Origins,
}

/// Surface data of a point: [`GAUSSIAN`] and [`SLOWNESS`].
type SurfaceData<R> = [R; 2];
const GAUSSIAN: usize = 0;
const SLOWNESS: usize = 1;

impl<R: Real> SlowedCurved<R> {
    /// Creates the front for a surface with these edges and this slowness.
    pub(in crate::cpu) fn new(edges: &EdgeLengths<R>, slowness: Arc<Vec<R>>) -> Self {
        let origins = Origins::none(edges.front_meets_itself());
        Self { gaussian: edges.shared_gaussian_curvature(), slowness, origins }
    }
}

impl<R: Real> FrontKind<R> for SlowedCurved<R> {
    type Carried = Curvature<R>;
    type Arrival = Front<R>;
    type SurfaceData = SurfaceData<R>;
    const TAKES_BACK: bool = true;

    fn arrival_of_seed(&mut self, seed: &Seed) -> Front<R> {
        self.origins.add(seed);
        Front { time: seed.start_of_curved(), curvature: R::of(seed.curvature), whole: true }
    }

    fn forget(&mut self) {
        self.origins.forget();
    }

    #[inline]
    fn reach(
        &self,
        edges: &EdgeLengths<R>,
        point: usize,
        behind: &Behind,
        seen: impl Fn(usize) -> KeptCurved<R>,
    ) -> Front<R> {
        let [a, b] =
            behind.triangles().each_ref().map(|slots| self.through(edges, point, slots, &seen));
        Front::first(a, b)
    }

    fn released(carried: Curvature<R>) -> Curvature<R> {
        carried.released()
    }

    #[inline(always)]
    fn accept(kept: KeptCurved<R>, arrival: Front<R>, scan: u8, renews: bool) -> KeptCurved<R> {
        accept(kept, arrival, scan, renews)
    }

    fn arrival_of_front(kept: KeptCurved<R>) -> Front<R> {
        kept.carried.front(kept.time)
    }

    #[inline(always)]
    fn first(a: KeptCurved<R>, b: KeptCurved<R>) -> KeptCurved<R> {
        first(a, b)
    }

    #[inline(always)]
    fn change(before: KeptCurved<R>, after: KeptCurved<R>) -> R::Bits {
        let bend = (after.carried.value() - before.carried.value()).abs() * after.time;
        before.time.units_between(after.time).max(bend_units(bend))
    }

    fn surface_data(&self, _: Chart) -> SurfaceArray<SurfaceData<R>> {
        let points = self.gaussian.iter().zip(&*self.slowness);
        SurfaceArray::Own(points.map(|(&gaussian, &slowness)| [gaussian, slowness]).collect())
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
        let line = lines.line(line, points, options.scan);
        let line = CurvedLine { line, parts: &parts, causal: self.origins.are_causal() };
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
        let behind = Behind::of(before.edges.chart(), options.scan);
        let at = behind.points().map(|offset| first.wrapping_add_signed(offset));
        let surface_data = at.map(|at| &before.surface_data[at..][..points]);
        let seen = Seen {
            span: &span,
            own: |i: usize| span.surface_data[i][SLOWNESS],
            behind: |k: usize, i: usize| surface_data[k][i][SLOWNESS],
        };
        leaves(&seen, points, options)
    }
}

impl<R: Real> SlowedCurved<R> {
    fn bends(&self, corners: [usize; 3], carried: [Curvature<R>; 2], alone: bool) -> Curvatures<R> {
        let fronts = carried.map(Curvature::value);
        let surface = corners.map(|corner| self.gaussian[corner]);
        Curvatures { fronts, surface, alone, causal: self.origins.are_causal() }
    }
}

impl<R: Real> TriangleKind<R> for SlowedCurved<R> {
    #[inline]
    fn arrival(
        &self,
        corners: [usize; 3],
        triangle: Triangle<R>,
        carried: [Curvature<R>; 2],
        alone: bool,
    ) -> Front<R> {
        let slowness = corners.map(|corner| self.slowness[corner]);
        curved_slowed(triangle, self.bends(corners, carried, alone), slowness)
    }

    fn arrival_over(
        &self,
        corners: [usize; 3],
        triangle: Triangle<R>,
        carried: [Curvature<R>; 2],
        slowness: [R; 3],
    ) -> Front<R> {
        curved_slowed(triangle, self.bends(corners, carried, false), slowness)
    }

    fn is_obtuse(&self, corners: [usize; 3], triangle: Triangle<R>) -> bool {
        triangle.is_obtuse_on_surface(corners.map(|corner| self.slowness[corner]))
    }

    fn time(arrival: Front<R>) -> R {
        arrival.time
    }

    fn earlier(a: Front<R>, b: Front<R>) -> Front<R> {
        Front::first(a, b)
    }

    fn curvature(kept: Kept<R, Self::Carried>) -> R {
        kept.carried.value()
    }

    fn circle(radius: R) -> Curvature<R> {
        let front = Front { time: radius, curvature: radius.recip(), whole: false };
        Curvature::of(front, crate::update::SEED)
    }
}

/// Returns whether a scan leaves a span of points unchanged.
#[inline(always)]
fn leaves<R: Real, O: Fn(usize) -> R, B: Fn(usize, usize) -> R>(
    seen: &Seen<'_, R, Curvature<R>, SurfaceData<R>, O, B>,
    points: usize,
    options: UpdateOptions,
) -> bool {
    let span = seen.span;
    if span.is_renewed(points, options) {
        return false;
    }
    if span.leads(points) {
        return true;
    }
    let [before, beside, after] = span.carried_behind;
    let (mut settled, limit) = (true, R::of(options.limit));
    for i in 0..points {
        let now = min(span.times[i], limit);
        let beside = beside[i].value();
        let (left, left_slowness) = seen.seen_from_beside::<true>(i);
        let (right, right_slowness) = seen.seen_from_beside::<false>(i);
        let [of_left, of_right] = [before[i].value(), after[i].value()];
        settled &= is_settled_slowed(left, Some([of_left, beside]), left_slowness, now)
            & is_settled_slowed(right, Some([of_right, beside]), right_slowness, now);
    }
    settled
}

/// The largest changes, by their place in the span: of arrival times, and of curvatures times the arrival
/// time.
struct Changes<R: Real> {
    times: [R::Bits; TILE],
    bends: [R::Bits; TILE],
}

impl<R: Real> Default for Changes<R> {
    #[inline(always)]
    fn default() -> Self {
        let none = [R::Bits::default(); TILE];
        Self { times: none, bends: none }
    }
}

impl<R: Real> Changes<R> {
    /// Notes the change of point `i`. Returns whether the front has changed at all.
    #[inline(always)]
    fn note(&mut self, i: usize, before: KeptCurved<R>, after: KeptCurved<R>) -> bool {
        let [bent_before, bent] = [before.carried.value(), after.carried.value()];
        let change = before.time.units_between(after.time);
        self.times[i] = change.max(self.times[i]);
        // As integers, whose maximum compilers find in SIMD lanes.
        let bend = (bent - bent_before).abs() * after.time;
        self.bends[i] = R::zero().units_between(bend).max(self.bends[i]);
        change.max(bent_before.units_between(bent)) > R::Bits::default()
    }
}

/// A line while a scan updates it.
struct CurvedLine<'a, R> {
    line: ScanLine<'a, R, Curvature<R>, SurfaceData<R>>,
    /// Fronts that arrive through parts of obtuse triangles, by the point's place in the line.
    parts: &'a [(usize, Front<R>)],
    /// See [`Curvatures::causal`].
    causal: bool,
}

impl<R: Real> Spans for CurvedLine<'_, R> {
    type Changes = Changes<R>;
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
        changes: &mut Changes<R>,
    ) -> Option<Changed> {
        let span = self.line.span(start, points);
        let surface_data = self.line.ground_behind(start, points);
        let seen = Seen {
            span: &span,
            own: |i: usize| span.surface_data[i][SLOWNESS],
            behind: |k: usize, i: usize| surface_data[k][i][SLOWNESS],
        };
        let parts = in_span(self.parts, start, points);
        if parts.is_empty() && leaves(&seen, points, options) {
            return None;
        }
        let mut first = FirstFronts::default();
        for (i, own) in span.surface_data[..points].iter().enumerate() {
            let k = [0, 1, 2].map(|at| span.carried_behind[at][i].value());
            let g = [0, 1, 2].map(|at| surface_data[at][i][GAUSSIAN]);
            let own = own[GAUSSIAN];
            let (alone, causal) = (span.is_alone(i), self.causal);
            let (triangle, slowness) = seen.triangle::<true>(i);
            let bends =
                Curvatures { fronts: [k[0], k[1]], surface: [own, g[0], g[1]], alone, causal };
            let left = curved_slowed(triangle, bends, slowness);
            let (triangle, slowness) = seen.triangle::<false>(i);
            let bends =
                Curvatures { fronts: [k[1], k[2]], surface: [own, g[1], g[2]], alone, causal };
            first.set(i, Front::first(left, curved_slowed(triangle, bends, slowness)));
        }
        for &(point, front) in parts {
            let i = point - start;
            first.set(i, Front::first(first.get(i), front));
        }
        let (mut times, mut curvatures) = ([R::zero(); TILE], [Curvature::default(); TILE]);
        let mut any = false;
        for i in 0..points {
            let before = Kept { time: span.times[i], carried: span.carried[i] };
            let after = accept(before, first.get(i), options.scan.0, options.renews);
            (times[i], curvatures[i]) = (after.time, after.carried);
            any |= changes.note(i, before, after);
        }
        let first = |i: usize| {
            let differs = times[i] != span.times[i] || curvatures[i] != span.carried[i];
            differs.then(|| min(times[i], span.times[i]))
        };
        let changed = Changed::of(any, options.limit, points, first);
        self.line.times[start..][..points].copy_from_slice(&times[..points]);
        self.line.carried[start..][..points].copy_from_slice(&curvatures[..points]);
        Some(changed)
    }

    #[inline(always)]
    fn largest(changes: Changes<R>) -> R::Bits {
        let largest = |of: [R::Bits; TILE]| of.into_iter().max().unwrap_or_default();
        largest(changes.times).max(bend_units(R::from_bits(largest(changes.bends))))
    }
}

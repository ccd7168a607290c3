//! Implements fronts that carry their curvature over an uneven slowness.

use std::sync::Arc;

use super::curved::{Accepted, FirstFronts, accept_all};
use super::kind::{FrontKind, TriangleKind, Triangular};
use super::lanes::LaneKind;
use super::pulled::{MOST, Pulled, prefetch_rows};
use super::slowed::Seen;
use super::surface_array::SurfaceArray;
use crate::lines::line::ScanLine;
use crate::lines::span::{Before, LargestChanges, Span, TILE};
use crate::scan::{Scan, UpdateOptions};
use geosweep_surface::update::{
    Curvature, Curvatures, Front, Triangle, curved_slowed, curved_slowed_at, is_settled_slowed,
    is_uneven as corners_are_uneven,
};
use geosweep_surface::{Chart, EdgeLengths, Origins, Real, Seed, jumps, min};

/// The front of [`geosweep_surface::Wavefront::Curved`] over a surface with an uneven slowness.
#[derive(Clone, Debug)]
pub(crate) struct SlowedCurved<R> {
    /// Gaussian curvature of the metric in which lengths are travel times: the surface's metric times the squared
    /// slowness. It has a tag where fronts diffract.
    gaussian: Arc<Vec<R>>,
    slowness: Arc<Vec<R>>,
    origins: Origins,
}

/// Surface data of a point: the Gaussian curvature, and the slowness.
type SurfaceData<R> = [R; 2];

type CurvedSpan<'s, R> = Span<'s, R, Curvature<R>, SurfaceData<R>>;

impl<R: Real> SlowedCurved<R> {
    /// Creates the front for a surface with these edges and this slowness.
    pub(crate) fn new(edges: &EdgeLengths<R>, slowness: Arc<Vec<R>>) -> Self {
        let origins = Origins::none(edges.front_meets_itself());
        Self { gaussian: edges.shared_gaussian_curvature(), slowness, origins }
    }
}

impl<R: Real> FrontKind<R> for SlowedCurved<R> {
    type Carried = Curvature<R>;
    type Arrival = Front<R>;
    /// With lanes of 64 bits, LLVM 22 fails to allocate the registers of AVX-512 in loops as long as these.
    const AVX512: bool = size_of::<R>() == size_of::<f32>();

    fn arrival_of_seed(&mut self, seed: &Seed) -> Front<R> {
        self.origins.add(seed);
        Front { time: seed.start_of_curved(), curvature: R::of(seed.curvature), whole: true }
    }

    fn forget(&mut self) {
        self.origins.forget();
    }
}

impl<R: Real> LaneKind<R> for SlowedCurved<R> {
    type SurfaceData = SurfaceData<R>;
    /// Value of [`Curvatures::causal`].
    type OfLine<'k> = bool;
    const TELLS_BENDS: bool = true;

    fn surface_data(&self, _: Chart) -> SurfaceArray<SurfaceData<R>> {
        let points = self.gaussian.iter().zip(&*self.slowness);
        SurfaceArray::Own(points.map(|(&gaussian, &slowness)| [gaussian, slowness]).collect())
    }

    fn of_line(&self, _: [usize; 2], _: Scan) -> bool {
        self.origins.are_causal()
    }

    #[inline(always)]
    fn update_span(
        &causal: &bool,
        line: &mut ScanLine<'_, '_, R, Self::Carried, Self::SurfaceData>,
        [start, points]: [usize; 2],
        splits: &[(usize, Option<Self::Arrival>)],
        options: UpdateOptions,
        changes: &mut LargestChanges<R>,
    ) -> Option<bool> {
        let span = line.span(start, points);
        let surface_data = line.surface_behind(start, points);
        let seen = Seen::new(&span, surface_data, points, numbers);
        let uneven = is_uneven(&seen, points);
        let is_alone = splits.iter().all(|(_, front)| front.is_none());
        if is_alone && leaves(&span, &seen, uneven, points, options) {
            return None;
        }
        let mut first = if uneven {
            earliest::<R, true>(&span, &seen, causal, points)
        } else {
            earliest::<R, false>(&span, &seen, causal, points)
        };
        first.lower(splits, start);
        let Accepted { times, curvatures, any } =
            accept_all(&span, points, &first, options, changes);
        line.set(start, &times[..points], &curvatures[..points]);
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
        leaves(&span, &seen, is_uneven(&seen, points), points, options)
    }
}

impl<R: Real> SlowedCurved<R> {
    fn bends(&self, corners: [usize; 3], carried: [Curvature<R>; 2], alone: bool) -> Curvatures<R> {
        let fronts = carried.map(Curvature::value);
        let surface = corners.map(|corner| self.gaussian[corner]);
        Curvatures { fronts, surface, alone, causal: self.origins.are_causal() }
    }
}

impl<R> Triangular for SlowedCurved<R> {}

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

    #[inline(always)]
    fn arrivals(&self, triangles: &Pulled<R, Curvature<R>>, arrivals: &mut [Front<R>; MOST]) {
        let causal = self.origins.are_causal();
        for start in (0..triangles.count).step_by(TILE) {
            let slowness = triangles.at_corners(start, &self.slowness);
            let gaussian = triangles.at_corners(start, &self.gaussian);
            let mut uneven = false;
            let [s0, s1, s2] = &slowness;
            for ((&s0, &s1), &s2) in s0.iter().zip(s1).zip(s2) {
                uneven |= corners_are_uneven([s0, s1, s2]) | jumps(s0) | jumps(s1) | jumps(s2);
            }
            let first = if uneven {
                fronts_of::<R, true>(triangles, start, &slowness, &gaussian, causal)
            } else {
                fronts_of::<R, false>(triangles, start, &slowness, &gaussian, causal)
            };
            for (k, arrival) in arrivals[start..start + TILE].iter_mut().enumerate() {
                *arrival = first.get(k);
            }
        }
    }

    #[inline(always)]
    fn prefetch(&self, points: [usize; 3]) {
        prefetch_rows(&self.slowness, points);
        prefetch_rows(&self.gaussian, points);
    }

    fn is_obtuse(&self, corners: [usize; 3], triangle: Triangle<R>) -> bool {
        triangle.is_obtuse_on_surface(corners.map(|corner| self.slowness[corner]))
    }
}

/// Returns the fronts through [`TILE`] triangles.
#[inline(always)]
fn fronts_of<R: Real, const UNEVEN: bool>(
    triangles: &Pulled<R, Curvature<R>>,
    start: usize,
    [s0, s1, s2]: &[[R; TILE]; 3],
    [g0, g1, g2]: &[[R; TILE]; 3],
    causal: bool,
) -> FirstFronts<R> {
    let lanes = triangles.lanes(start);
    let mut first = FirstFronts::default();
    for (k, &own) in s0.iter().enumerate() {
        let [k1, k2] = [lanes.carried[0][k].value(), lanes.carried[1][k].value()];
        let surface = [g0[k], g1[k], g2[k]];
        let bends = Curvatures { fronts: [k1, k2], surface, alone: lanes.alone[k], causal };
        let slowness = [own, s1[k], s2[k]];
        first.set(k, curved_slowed_at::<R, UNEVEN, true>(lanes.triangle(k), bends, slowness));
    }
    first
}

/// Returns the numbers of [`Seen`] in the data of a point. They are not copied together: compilers would copy them as one
/// number.
#[inline(always)]
fn numbers<R: Real>(data: &SurfaceData<R>) -> [R; 2] {
    [data[0], data[1]]
}

/// Returns whether the slowness jumps or is uneven in any triangle of the points.
#[inline(always)]
fn is_uneven<R: Real>(seen: &Seen<R>, points: usize) -> bool {
    let (mut jumping, [before, beside, after]) = (false, &seen.behind);
    for i in 0..points {
        jumping |= jumps(seen.own.slowness[i]) | jumps(before.slowness[i]);
        jumping |= jumps(beside.slowness[i]) | jumps(after.slowness[i]);
    }
    jumping | seen.is_uneven(points)
}

/// Returns the earliest front at each point, from both of its triangles. Each kind of update appears only once in this
/// code: more copies make functions so large that compilers fail.
#[inline(always)]
fn earliest<R: Real, const UNEVEN: bool>(
    span: &CurvedSpan<'_, R>,
    seen: &Seen<R>,
    causal: bool,
    points: usize,
) -> FirstFronts<R> {
    let mut first = FirstFronts::default();
    for i in 0..points {
        first.set(i, front::<R, true, UNEVEN>(span, seen, causal, i));
    }
    for i in 0..points {
        let other = front::<R, false, UNEVEN>(span, seen, causal, i);
        first.set(i, Front::first(first.get(i), other));
    }
    first
}

/// Returns the front through one of the two triangles of point `i`.
#[inline(always)]
fn front<R: Real, const LEFT: bool, const UNEVEN: bool>(
    span: &CurvedSpan<'_, R>,
    seen: &Seen<R>,
    causal: bool,
    i: usize,
) -> Front<R> {
    let x1 = if LEFT { 0 } else { 1 };
    let [k1, k2] = [span.carried_behind[x1][i].value(), span.carried_behind[x1 + 1][i].value()];
    let [g1, g2] = [seen.behind[x1].gaussian[i], seen.behind[x1 + 1].gaussian[i]];
    let surface = [seen.own.gaussian[i], g1, g2];
    let bends = Curvatures { fronts: [k1, k2], surface, alone: span.is_alone(i), causal };
    let (triangle, slowness) = seen.triangle::<_, _, LEFT>(span, i);
    curved_slowed_at::<R, UNEVEN, true>(triangle, bends, slowness)
}

/// Returns whether a bound shows that no front through one of the two triangles of point `i` arrives at `now` or before.
#[inline(always)]
fn is_settled<R: Real, const LEFT: bool, const UNEVEN: bool>(
    span: &CurvedSpan<'_, R>,
    seen: &Seen<R>,
    i: usize,
    now: R,
) -> bool {
    let [before, beside, after] = span.carried_behind;
    let across = if LEFT { before[i].value() } else { after[i].value() };
    let (triangle, slowness) = seen.seen_from_across::<_, _, LEFT>(span, i);
    let fronts = [across, beside[i].value()];
    is_settled_slowed::<R, UNEVEN>(triangle, fronts, slowness, now)
}

/// Returns whether a scan leaves a span of points unchanged.
#[inline(always)]
fn leaves<R: Real>(
    span: &CurvedSpan<'_, R>,
    seen: &Seen<R>,
    uneven: bool,
    points: usize,
    options: UpdateOptions,
) -> bool {
    if span.is_renewed(points, options) {
        return false;
    }
    if span.leads(points) {
        return true;
    }
    if uneven {
        are_settled::<R, true>(span, seen, points, options.limit)
    } else {
        are_settled::<R, false>(span, seen, points, options.limit)
    }
}

/// Returns whether bounds show that no front arrives at any of the points before the present one.
#[inline(always)]
fn are_settled<R: Real, const UNEVEN: bool>(
    span: &CurvedSpan<'_, R>,
    seen: &Seen<R>,
    points: usize,
    limit: f64,
) -> bool {
    let (mut settled, limit) = (true, R::of(limit));
    for i in 0..points {
        let now = min(span.times[i], limit);
        settled &= is_settled::<R, true, UNEVEN>(span, seen, i, now)
            & is_settled::<R, false, UNEVEN>(span, seen, i, now);
    }
    settled
}

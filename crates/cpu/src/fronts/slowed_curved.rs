//! Implements fronts that carry their curvature over an uneven slowness.

use std::sync::Arc;

use super::curved::{Accepted, FirstFronts, accept_all};
use super::kind::{FrontKind, TriangleKind, Triangular};
use super::lanes::LaneKind;
use super::slowed::Seen;
use super::surface_array::SurfaceArray;
use crate::lines::line::ScanLine;
use crate::lines::span::{Before, LargestChanges, Span};
use crate::scan::{Scan, UpdateOptions};
use geosweep_surface::update::{
    Curvature, Curvatures, Front, Triangle, curved_slowed, is_settled_slowed,
};
use geosweep_surface::{Chart, EdgeLengths, Origins, Real, Seed, min};

/// The front of [`geosweep_surface::Wavefront::Curved`] over a surface with an uneven slowness.
#[derive(Clone, Debug)]
pub(crate) struct SlowedCurved<R> {
    /// Gaussian curvature of the metric in which lengths are travel times: the surface's metric times the squared
    /// slowness. It has a tag where fronts diffract.
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
    pub(crate) fn new(edges: &EdgeLengths<R>, slowness: Arc<Vec<R>>) -> Self {
        let origins = Origins::none(edges.front_meets_itself());
        Self { gaussian: edges.shared_gaussian_curvature(), slowness, origins }
    }
}

impl<R: Real> FrontKind<R> for SlowedCurved<R> {
    type Carried = Curvature<R>;
    type Arrival = Front<R>;

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
        let slowness = |data: SurfaceData<R>| data[SLOWNESS];
        let seen = Seen { span: &span, behind: surface_data, slowness };
        let is_alone = splits.iter().all(|(_, front)| front.is_none());
        if is_alone && leaves(&seen, points, options) {
            return None;
        }
        let mut first = FirstFronts::default();
        for (i, own) in span.surface_data[..points].iter().enumerate() {
            let k = [0, 1, 2].map(|at| span.carried_behind[at][i].value());
            let g = [0, 1, 2].map(|at| surface_data[at][i][GAUSSIAN]);
            let (own, alone) = (own[GAUSSIAN], span.is_alone(i));
            let (triangle, slowness) = seen.triangle::<true>(i);
            let bends =
                Curvatures { fronts: [k[0], k[1]], surface: [own, g[0], g[1]], alone, causal };
            let left = curved_slowed(triangle, bends, slowness);
            let (triangle, slowness) = seen.triangle::<false>(i);
            let bends =
                Curvatures { fronts: [k[1], k[2]], surface: [own, g[1], g[2]], alone, causal };
            first.set(i, Front::first(left, curved_slowed(triangle, bends, slowness)));
        }
        first.lower(splits, start);
        let Accepted { times, curvatures, any } =
            accept_all(&span, points, &first, options, false, changes);
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
        let slowness = |data: SurfaceData<R>| data[SLOWNESS];
        leaves(&Seen::before(before, first, &span, points, options.scan, slowness), points, options)
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

    fn is_obtuse(&self, corners: [usize; 3], triangle: Triangle<R>) -> bool {
        triangle.is_obtuse_on_surface(corners.map(|corner| self.slowness[corner]))
    }
}

/// Returns whether a scan leaves a span of points unchanged.
#[inline(always)]
fn leaves<R: Real>(
    seen: &Seen<'_, R, Curvature<R>, SurfaceData<R>, impl Fn(SurfaceData<R>) -> R>,
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

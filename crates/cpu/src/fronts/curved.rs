//! Implements fronts that carry their curvature.

use std::sync::Arc;

use super::kind::{FrontKind, Fronts, TriangleFronts, TriangleKind, Triangular};
use super::lanes::LaneKind;
use super::surface_array::SurfaceArray;
use crate::bend_units;
use crate::lines::line::ScanLine;
use crate::lines::settled::{Visited, from_curved};
use crate::lines::span::{Before, LargestChanges, Span, TILE};
use crate::scan::{Scan, UpdateOptions};
use geosweep_surface::update::{
    Carried, Curvature, Curvatures, EXACT, Front, SEED, StoredFront, Triangle, curved, curved_at,
};
use geosweep_surface::{Chart, EdgeLengths, LACKING, Origins, Real, Seed, Tagged, min};

/// The front of [`geosweep_surface::Wavefront::Curved`].
#[derive(Clone, Debug)]
pub(crate) struct Curved<R> {
    /// The surface's Gaussian curvature, with a tag where fronts diffract.
    gaussian: Arc<Vec<R>>,
    origins: Origins,
}

/// A front stored at a point.
type KeptCurved<R> = StoredFront<R, Curvature<R>>;

impl<R: Real> Curved<R> {
    pub(crate) fn new(edges: &EdgeLengths<R>) -> Self {
        Self {
            gaussian: edges.shared_gaussian_curvature(),
            origins: Origins::none(edges.front_meets_itself()),
        }
    }
}

impl<R: Real> FrontKind<R> for Curved<R> {
    type Carried = Curvature<R>;
    type Arrival = Front<R>;

    fn expect(&mut self, seeds: &[Seed]) {
        seeds.iter().for_each(|seed| self.origins.add(seed));
    }

    fn arrival_of_seed(&mut self, seed: &Seed) -> Front<R> {
        Front { time: seed.start_of_curved(), curvature: R::of(seed.curvature), whole: true }
    }

    fn forget(&mut self) {
        self.origins.forget();
    }
}

impl<R: Real> LaneKind<R> for Curved<R> {
    type SurfaceData = R;
    type OfLine<'k> = CurvedLine;
    const TELLS_BENDS: bool = true;

    fn surface_data(&self, _: Chart) -> SurfaceArray<R> {
        SurfaceArray::OfEdges(self.gaussian.clone())
    }

    fn of_line(&self, _: [usize; 2], _: Scan) -> CurvedLine {
        CurvedLine { causal: self.origins.are_causal() }
    }

    #[inline(always)]
    fn update_span(
        of_line: &CurvedLine,
        line: &mut ScanLine<'_, '_, R, Self::Carried, Self::SurfaceData>,
        [start, points]: [usize; 2],
        splits: &[(usize, Option<Self::Arrival>)],
        options: UpdateOptions,
        changes: &mut LargestChanges<R>,
    ) -> Option<bool> {
        let span = line.span(start, points);
        let first = if splits.is_empty() {
            if leaves::<_, false>(&span, points, options) {
                return None;
            }
            of_line.first_fronts::<_, false>(line, [start, points], span, options)
        } else {
            let is_alone = splits.iter().all(|(_, front)| front.is_none());
            if is_alone && leaves::<_, true>(&span, points, options) {
                return None;
            }
            let mut first = of_line.first_fronts::<_, true>(line, [start, points], span, options);
            first.lower(splits, start);
            first
        };
        let Accepted { times, curvatures, any } =
            accept_all(&span, points, &first, options, changes);
        line.set(start, &times[..points], &curvatures[..points]);
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
        leaves::<_, false>(&span, points, options)
    }
}

impl<R> Triangular for Curved<R> {}

impl<R: Real> TriangleKind<R> for Curved<R> {
    #[inline]
    fn arrival(
        &self,
        corners: [usize; 3],
        triangle: Triangle<R>,
        carried: [Curvature<R>; 2],
        alone: bool,
    ) -> Front<R> {
        let fronts = carried.map(Curvature::value);
        let surface = corners.map(|corner| self.gaussian[corner]);
        let bends = Curvatures { fronts, surface, alone, causal: self.origins.are_causal() };
        curved(triangle, bends)
    }
}

impl<R: Real> Fronts<R> for Curvature<R> {
    type Arrival = Front<R>;
    const TAKES_BACK: bool = true;

    fn released(self) -> Self {
        Curvature::released(self)
    }

    /// Returns the front at a point after a scan has brought `front` to it.
    ///
    /// The new front is accepted in three cases:
    ///
    /// - It arrives earlier than the present one.
    /// - It arrives together with the present one, and is preferred ([`Front::replaces`]).
    /// - The scan `renews`, and the same scan brought the present front. The new front may then be earlier or later.
    ///   Both came through the same triangles, whose fronts have changed in between. So no front stays that was computed
    ///   from a preliminary curvature. A difference within rounding is no change ([`Front::is_same_as`]). Otherwise the
    ///   last digits of a distant front would spread from point to point, and all these points would be visited again.
    ///
    /// In all other cases the present front stays. Otherwise scans whose fronts arrive together would replace each
    /// other's fronts forever.
    #[inline(always)]
    fn accept(kept: KeptCurved<R>, front: Front<R>, scan: u8, renews: bool) -> KeptCurved<R> {
        let StoredFront { time, carried: curvature } = kept;
        let before = curvature.front(time);
        let brought = Curvature::of(front, scan);
        let front = Front { curvature: brought.value(), ..front };
        let was_reached = time < R::FAR;
        let together = was_reached & front.arrives_with(before);
        let first = if together { front.replaces(before) } else { front.time < time };
        let is_new = !(together & front.is_same_as(before));
        // Exact seeds stay: where two fronts meet, an update may take them for one front, which arrives too early.
        let held = was_reached & curvature.is_from(EXACT);
        let accepted = (first & !held) | (was_reached & renews & curvature.is_from(scan) & is_new);
        let arrival = if together { min(time, front.time) } else { front.time };
        StoredFront {
            time: if accepted { arrival } else { time },
            carried: if accepted { brought } else { curvature },
        }
    }

    fn arrival_of_front(kept: KeptCurved<R>) -> Front<R> {
        kept.carried.front(kept.time)
    }

    /// Returns the earlier front. If both arrive together, [`Front::first`] decides.
    #[inline(always)]
    fn first(a: KeptCurved<R>, b: KeptCurved<R>) -> KeptCurved<R> {
        let (of_a, of_b) = (a.carried.front(a.time), b.carried.front(b.time));
        let time = min(a.time, b.time);
        let second =
            if of_a.arrives_with(of_b) { of_b.knows_better(of_a) } else { of_b.time < of_a.time };
        StoredFront { time, carried: if second { b.carried } else { a.carried } }
    }

    /// Returns the larger of the changes of arrival time and curvature.
    #[inline(always)]
    fn change(before: KeptCurved<R>, after: KeptCurved<R>) -> R::Bits {
        let bend = (after.carried.value() - before.carried.value()).abs() * after.time;
        before.time.units_between(after.time).max(bend_units(bend))
    }
}

impl<R: Real> TriangleFronts<R> for Curvature<R> {
    fn time(arrival: Front<R>) -> R {
        arrival.time
    }

    fn earlier(a: Front<R>, b: Front<R>) -> Front<R> {
        Front::first(a, b)
    }

    fn curvature(kept: KeptCurved<R>) -> R {
        kept.carried.value()
    }

    fn circle(radius: R) -> Self {
        let front = Front { time: radius, curvature: radius.recip(), whole: false };
        Curvature::of(front, SEED)
    }
}

/// Returns whether a scan leaves a span of points unchanged. `SPLIT` tells whether some of their triangles
/// may be obtuse.
#[inline(always)]
fn leaves<R: Real, const SPLIT: bool>(
    span: &Span<R, Curvature<R>, R>,
    points: usize,
    options: UpdateOptions,
) -> bool {
    if span.is_renewed(points, options) {
        return false;
    }
    if span.leads(points) {
        return true;
    }
    let [before, beside, after] = span.carried_behind;
    let (mut settled, limit) = (true, R::of(options.limit));
    for i in 0..points {
        let visited: Visited<R> = span.visited::<SPLIT>(i, limit);
        let [left, right] = visited.triangles;
        let [k_before, k_beside, k_after] =
            [before[i].value(), beside[i].value(), after[i].value()];
        let of = [
            from_curved(left, [k_before, k_beside], visited.now),
            from_curved(right, [k_after, k_beside], visited.now),
        ];
        settled &= visited.stays(of);
    }
    settled
}

/// Data of curved fronts that the update of a line needs.
pub(crate) struct CurvedLine {
    /// Value of [`Curvatures::causal`].
    causal: bool,
}

impl CurvedLine {
    /// Returns the first fronts to reach a span of points. `SPLIT` tells whether some of their triangles
    /// are obtuse.
    #[inline(always)]
    fn first_fronts<R: Real, const SPLIT: bool>(
        &self,
        line: &ScanLine<'_, '_, R, Curvature<R>, R>,
        [start, points]: [usize; 2],
        span: Span<'_, R, Curvature<R>, R>,
        options: UpdateOptions,
    ) -> FirstFronts<R> {
        let (gaussian_behind, causal) = (line.surface_behind(start, points), self.causal);
        let mut at_border = false;
        for gaussian in &span.surface_data[..points] {
            at_border |= gaussian.tag_has(LACKING, LACKING);
        }
        // Spans with obtuse triangles are few.
        if SPLIT || at_border {
            Bent::<_, SPLIT, true> { span, gaussian_behind, causal }.earliest(points, options)
        } else {
            Bent::<_, SPLIT, false> { span, gaussian_behind, causal }.earliest(points, options)
        }
    }
}

/// Fronts at the points of a span after an update.
pub(super) struct Accepted<R> {
    pub times: [R; TILE],
    pub curvatures: [Curvature<R>; TILE],
    /// Whether any of them has changed.
    pub any: bool,
}

/// Accepts the first fronts to reach a span of points.
#[inline(always)]
pub(super) fn accept_all<R: Real, G>(
    span: &Span<'_, R, Curvature<R>, G>,
    points: usize,
    first: &FirstFronts<R>,
    options: UpdateOptions,
    changes: &mut LargestChanges<R>,
) -> Accepted<R> {
    let (mut times, mut curvatures) = ([R::zero(); TILE], [Curvature::default(); TILE]);
    let mut any = false;
    for i in 0..points {
        let before = StoredFront { time: span.times[i], carried: span.carried[i] };
        let after = Curvature::accept(before, first.get(i), options.scan.0, options.renews);
        (times[i], curvatures[i]) = (after.time, after.carried);
        let [bent_before, bent] = [before.carried.value(), after.carried.value()];
        let change = before.time.units_between(after.time);
        any |= change.max(bent_before.units_between(bent)) > R::Bits::default();
        changes.note(i, change);
        changes.note_bend(i, (bent - bent_before).abs() * after.time);
    }
    Accepted { times, curvatures, any }
}

/// A span of points, and the Gaussian curvature behind them. `BORDER` is false if none of the points lies beside a hole or
/// at the border.
struct Bent<'a, R, const SPLIT: bool, const BORDER: bool> {
    span: Span<'a, R, Curvature<R>, R>,
    gaussian_behind: [&'a [R]; 3],
    causal: bool,
}

impl<R: Real, const SPLIT: bool, const BORDER: bool> Bent<'_, R, SPLIT, BORDER> {
    /// Returns the first fronts to reach the points.
    #[inline(always)]
    fn earliest(&self, points: usize, options: UpdateOptions) -> FirstFronts<R> {
        if self.span.comes_from_left(points) {
            earliest_of_both::<R, true, false, SPLIT, BORDER>(self, points, options)
        } else {
            earliest_of_both::<R, false, true, SPLIT, BORDER>(self, points, options)
        }
    }

    /// Returns the curvatures of the fronts at x1 and x2 of one of the two triangles of point `i`.
    #[inline(always)]
    fn fronts<const LEFT: bool>(&self, i: usize) -> [R; 2] {
        let behind = &self.span.carried_behind;
        let x1 = if LEFT { 0 } else { 1 };
        [behind[x1][i].value(), behind[x1 + 1][i].value()]
    }

    #[inline(always)]
    fn bends<const LEFT: bool>(&self, i: usize) -> Curvatures<R> {
        let (span, x1) = (&self.span, if LEFT { 0 } else { 1 });
        let gaussian = &self.gaussian_behind;
        let surface = [span.surface_data[i], gaussian[x1][i], gaussian[x1 + 1][i]];
        let (fronts, alone) = (self.fronts::<LEFT>(i), span.is_alone(i));
        Curvatures { fronts, surface, alone, causal: self.causal }
    }

    /// Returns the front through one of the two triangles of point `i`.
    #[inline(always)]
    fn front<const LEFT: bool>(&self, i: usize) -> Front<R> {
        curved_at::<R, BORDER>(self.span.triangle::<LEFT, SPLIT>(i), self.bends::<LEFT>(i))
    }
}

/// Returns the earliest front at each point of a span. The triangle through which the front more likely comes is
/// computed first. The other one is computed only if its front might be earlier, since that test costs less than an
/// update.
#[inline(always)]
fn earliest_of_both<
    R: Real,
    const LIKELY_LEFT: bool,
    const OTHER_LEFT: bool,
    const SPLIT: bool,
    const BORDER: bool,
>(
    bent: &Bent<R, SPLIT, BORDER>,
    points: usize,
    options: UpdateOptions,
) -> FirstFronts<R> {
    let span = &bent.span;
    let mut first = FirstFronts::default();
    for i in 0..points {
        first.set(i, bent.front::<LIKELY_LEFT>(i));
    }
    let mut settled = true;
    for i in 0..points {
        // A renewed front may come later than before.
        let renewed = options.renews & span.carried[i].is_from(options.scan.0);
        let now = if renewed { first.times[i] } else { min(span.times[i], first.times[i]) };
        let other = span.seen_from_beside::<OTHER_LEFT, SPLIT>(i);
        settled &= from_curved(other, bent.fronts::<OTHER_LEFT>(i), now);
    }
    if !settled {
        for i in 0..points {
            first.set(i, Front::first(first.get(i), bent.front::<OTHER_LEFT>(i)));
        }
    }
    first
}

/// The first front to reach each point of a span.
pub(super) struct FirstFronts<R> {
    times: [R; TILE],
    curvatures: [R; TILE],
    /// Flags, 1 where the front is whole. They are as wide as the numbers in the other arrays, as SIMD lanes require.
    whole: [R; TILE],
}

impl<R: Real> Default for FirstFronts<R> {
    #[inline(always)]
    fn default() -> Self {
        let none = [R::zero(); TILE];
        Self { times: none, curvatures: none, whole: none }
    }
}

impl<R: Real> FirstFronts<R> {
    #[inline(always)]
    pub(super) fn get(&self, i: usize) -> Front<R> {
        let whole = self.whole[i] > R::zero();
        Front { time: self.times[i], curvature: self.curvatures[i], whole }
    }

    /// Replaces fronts by earlier ones through parts of obtuse triangles, in the span that begins at point `start` of
    /// the line.
    #[inline(always)]
    pub(super) fn lower(&mut self, splits: &[(usize, Option<Front<R>>)], start: usize) {
        for &(point, front) in splits {
            if let Some(front) = front {
                let i = point - start;
                self.set(i, Front::first(self.get(i), front));
            }
        }
    }

    #[inline(always)]
    pub(super) fn set(&mut self, i: usize, front: Front<R>) {
        (self.times[i], self.curvatures[i]) = (front.time, front.curvature);
        self.whole[i] = if front.whole { R::one() } else { R::zero() };
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns the front at a point after another front has arrived. The present front has time 1.5 and curvature 0.3.
    /// Scan 2 brought it from a whole triangle.
    fn after<R: Real>([time, curvature]: [f64; 2], scan: u8, renews: bool) -> KeptCurved<R> {
        let whole = true;
        let old = Curvature::of(Front { time: R::of(1.5), curvature: R::of(0.3), whole }, 2);
        let front = Front { time: R::of(time), curvature: R::of(curvature), whole };
        Curvature::accept(StoredFront { time: R::of(1.5), carried: old }, front, scan, renews)
    }

    fn assert_renews_but_for_rounding<R: Real>() {
        let kept = after::<R>([2.0, 0.3], 1, true);
        assert_eq!(kept.time, R::of(1.5));
        let digit = R::epsilon().wide();
        let is_kept = |front, scan, renews| after::<R>(front, scan, renews) == kept;
        // The present front's own scan brings it again.
        assert!(is_kept([1.5 + digit, 0.3], 2, true));
        assert!(is_kept([1.5 - digit, 0.3 * (1.0 + 64.0 * digit)], 2, true));
        for changed in [[1.5 + 4.0 * digit, 0.3], [1.5, 0.3 * (1.0 + 4096.0 * digit)]] {
            assert_eq!(after::<R>(changed, 2, true).time, R::of(changed[0]));
            assert!(!is_kept(changed, 2, true) && is_kept(changed, 2, false));
            assert!(is_kept(changed, 1, true));
        }
        // A front of another scan replaces the present one if it arrives at the same time and is clearly flatter, or if
        // it is clearly earlier.
        assert!(is_kept([1.5 - digit, 0.299], 1, true));
        assert!(!is_kept([1.5 - digit, 0.29], 1, true));
        assert!(!is_kept([1.5 - 4.0 * digit, 0.299], 1, true));
    }

    #[test]
    fn fronts_that_come_again_are_renewed_but_for_rounding() {
        assert_renews_but_for_rounding::<f32>();
        assert_renews_but_for_rounding::<f64>();
    }
}

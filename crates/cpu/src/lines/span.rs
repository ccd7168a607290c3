//! Defines spans: adjacent points with their own data and the data of the points behind them, which an update takes as
//! its input. Also defines the steps that the updates of all kinds of fronts share.

use super::settled::Visited;
use super::window::Fronts;
use crate::behind::Behind;
use crate::bend_units;
use crate::scan::UpdateOptions;
use geosweep_surface::lanes::prefetch;
use geosweep_surface::update::{Carried, StoredFront, Triangle};
use geosweep_surface::{EdgeLengths, Offset, Real, min};

/// Number of points on a side of a tile. For each line that a scan passes, a front moves by at most one point along the
/// line. So within a band of `TILE` lines it reaches the neighbouring tile at most.
pub(crate) const TILE: usize = 16;

/// A span of adjacent points of a row or column, the neighbours behind each of them, and the triangles between.
///
/// All slices have one entry per point, unless their entries have no size. So the compiler sees that indices are within
/// bounds. `C` is the data that fronts carry besides their arrival times, `G` the data of the surface.
#[derive(Clone, Copy)]
pub(crate) struct Span<'a, R, C, G> {
    pub times: &'a [R],
    pub carried: &'a [C],
    pub surface_data: &'a [G],
    /// Data at the neighbours behind each point: the one before it, the one beside it, the one after it.
    pub times_behind: [&'a [R]; 3],
    pub carried_behind: [&'a [C]; 3],
    /// Lengths of the edges to the neighbours behind, and of the edges between these.
    pub edges: [&'a [R]; 3],
    pub bases: [&'a [R]; 2],
}

impl<'a, R: Real, C: Carried, G> Span<'a, R, C, G> {
    /// Returns part of the span.
    #[inline(always)]
    pub(crate) fn part(&self, start: usize, points: usize) -> Self {
        Self {
            times: part(self.times, start, points),
            carried: part(self.carried, start, points),
            surface_data: part(self.surface_data, start, points),
            times_behind: parts(self.times_behind, start, points),
            carried_behind: parts(self.carried_behind, start, points),
            edges: parts(self.edges, start, points),
            bases: [part(self.bases[0], start, points), part(self.bases[1], start, points)],
        }
    }

    /// Returns whether point `i` has no neighbour beside it on the line behind; see [`geosweep_surface::update::Curvatures`].
    #[inline(always)]
    pub(crate) fn is_alone(&self, i: usize) -> bool {
        self.edges[1][i] >= R::FAR
    }

    /// Returns one of the two triangles of point `i`: the left one, with the neighbours behind that lie before and
    /// beside the point, or the right one, with the neighbours behind that lie beside and after it. If the span may
    /// have obtuse triangles (`SPLIT`), an obtuse one is reduced to its edges.
    #[inline(always)]
    pub(crate) fn triangle<const LEFT: bool, const SPLIT: bool>(&self, i: usize) -> Triangle<R> {
        let triangle = self.weighted_triangle::<LEFT>(i);
        if SPLIT { triangle.without_obtuse_face() } else { triangle }
    }

    /// Returns the triangle of [`Self::triangle`] without reducing an obtuse one to its edges.
    #[inline(always)]
    pub(crate) fn weighted_triangle<const LEFT: bool>(&self, i: usize) -> Triangle<R> {
        let x1 = if LEFT { 0 } else { 1 };
        Triangle {
            t1: self.times_behind[x1][i],
            t2: self.times_behind[x1 + 1][i],
            l1: self.edges[x1][i],
            l2: self.edges[x1 + 1][i],
            c: self.bases[x1][i],
        }
    }

    /// Returns the triangle of [`Self::triangle`], with the neighbour beside point `i` as x1.
    #[inline(always)]
    pub(crate) fn seen_from_beside<const LEFT: bool, const SPLIT: bool>(
        &self,
        i: usize,
    ) -> Triangle<R> {
        let triangle = self.triangle::<LEFT, SPLIT>(i);
        if LEFT { triangle.mirrored() } else { triangle }
    }

    /// Returns point `i` before its update, for the test whether it is settled. Its time is at most `limit`, since
    /// fronts after that are ignored.
    #[inline(always)]
    pub(crate) fn visited<const SPLIT: bool>(&self, i: usize, limit: R) -> Visited<R> {
        let triangles =
            [self.triangle::<true, SPLIT>(i), self.triangle::<false, SPLIT>(i).mirrored()];
        Visited { now: min(self.times[i], limit), triangles }
    }

    /// Returns whether every point is reached no later than its neighbours behind.
    #[inline(always)]
    pub(crate) fn leads(&self, points: usize) -> bool {
        let [before, beside, after] = self.times_behind;
        let mut leads = true;
        for i in 0..points {
            leads &= min(before[i], min(beside[i], after[i])) >= self.times[i];
        }
        leads
    }

    /// Returns whether none of the points has been reached.
    #[inline(always)]
    pub(crate) fn is_unreached(&self, points: usize) -> bool {
        let mut unreached = true;
        for i in 0..points {
            unreached &= self.times[i] >= R::FAR;
        }
        unreached
    }

    /// Returns whether all these points and all those behind them are reached after `limit` or not at all. Updates then
    /// bring no front before the limit.
    #[inline(always)]
    pub(crate) fn is_beyond(&self, points: usize, limit: f64) -> bool {
        let [before, beside, after] = self.times_behind;
        let mut first = R::FAR;
        for i in 0..points {
            first = min(first, min(self.times[i], min(before[i], min(beside[i], after[i]))));
        }
        first.wide() > limit
    }

    /// Returns whether the scan renews fronts and one of these fronts, no later than the limit, is its own.
    #[inline(always)]
    pub(crate) fn is_renewed(&self, points: usize, options: UpdateOptions) -> bool {
        let UpdateOptions { scan, renews, limit, .. } = options;
        let (mut renewed, limit) = (false, R::of(limit));
        for i in 0..points {
            renewed |= renews & self.carried[i].is_from(scan.0) & (self.times[i] <= limit);
        }
        renewed
    }

    /// Returns whether fronts reach the neighbour behind and before the first point no later than the neighbour behind
    /// and after the last point.
    #[inline(always)]
    pub(crate) fn comes_from_left(&self, points: usize) -> bool {
        self.times_behind[0][0] <= self.times_behind[2][points - 1]
    }
}

/// Largest changes of a line's fronts, one for each position in a span, since these positions are SIMD lanes. The
/// changes are integers, whose maximum compilers compute in SIMD lanes.
pub(crate) struct LargestChanges<R: Real> {
    /// Changes of arrival times ([`Real::units_between`]).
    times: [R::Bits; TILE],
    /// Changes of curvature, times the arrival time, as integers: the count of representable numbers from zero to the
    /// product.
    bends: [R::Bits; TILE],
}

impl<R: Real> Default for LargestChanges<R> {
    #[inline(always)]
    fn default() -> Self {
        let none = [R::Bits::default(); TILE];
        Self { times: none, bends: none }
    }
}

impl<R: Real> LargestChanges<R> {
    /// Notes the changes of arrival times of a span. Returns whether any time has changed.
    #[inline(always)]
    pub(crate) fn note_times(&mut self, before: &[R], after: &[R]) -> bool {
        let after = &after[..before.len()];
        let mut any = false;
        for (i, largest) in self.times[..before.len()].iter_mut().enumerate() {
            let change = before[i].units_between(after[i]);
            any |= change > R::Bits::default();
            *largest = change.max(*largest);
        }
        any
    }

    /// Notes a change of the front at point `i` of a span, in units of the last place of the arrival time.
    #[inline(always)]
    pub(crate) fn note(&mut self, i: usize, change: R::Bits) {
        self.times[i] = change.max(self.times[i]);
    }

    /// Notes a change of curvature, times the arrival time.
    #[inline(always)]
    pub(crate) fn note_bend(&mut self, i: usize, bend: R) {
        self.bends[i] = R::zero().units_between(bend).max(self.bends[i]);
    }

    /// Returns the largest change, in units of the last place of the arrival time. `bends` tells whether changes of
    /// curvature were noted.
    #[inline(always)]
    pub(crate) fn largest(self, bends: bool) -> R::Bits {
        let largest = |of: [R::Bits; TILE]| of.into_iter().max().unwrap_or_default();
        let times = largest(self.times);
        if bends { times.max(bend_units(R::from_bits(largest(self.bends)))) } else { times }
    }
}

/// Returns `points` entries of an array. If entries have no size, returns the whole array, which saves bounds checks.
#[inline(always)]
pub(crate) fn part<T>(array: &[T], start: usize, points: usize) -> &[T] {
    if size_of::<T>() == 0 { array } else { &array[start..][..points] }
}

#[inline(always)]
fn parts<T>([a, b, c]: [&[T]; 3], start: usize, points: usize) -> [&[T]; 3] {
    [part(a, start, points), part(b, start, points), part(c, start, points)]
}

/// The fronts from which scans start, at all points of a window.
#[derive(Clone, Copy)]
pub(crate) struct Before<'a, R, C, G> {
    pub edges: &'a EdgeLengths<R>,
    pub fronts: Fronts<'a, R, C>,
    /// The fronts of the whole grid, if the window is smaller.
    pub far: Option<Fronts<'a, R, C>>,
    pub surface_data: &'a [G],
}

impl<'a, R: Real, C: Carried, G> Before<'a, R, C, G> {
    /// Returns the span of `points` points of a row from a column on. Parameters give the neighbours behind in the
    /// grid, and as offsets in the window ([`super::window::Window::behind`]).
    pub(crate) fn span(
        &self,
        (behind, in_window): (&Behind, [Offset; 3]),
        [row, col]: [usize; 2],
        points: usize,
    ) -> Span<'a, R, C, G> {
        let Fronts { window, times, carried } = self.fronts;
        let (here, first) = (window.index(row, col), window.grid().bordered(row, col));
        let at = in_window.map(|offset| offset.from(here));
        Span {
            times: part(times, here, points),
            carried: part(carried, here, points),
            surface_data: part(self.surface_data, first, points),
            times_behind: at.map(|at| part(times, at, points)),
            carried_behind: at.map(|at| part(carried, at, points)),
            edges: behind.edges().map(|slot| self.edges.row(first, slot, points)),
            bases: behind.bases().map(|slot| self.edges.row(first, slot, points)),
        }
    }

    /// Returns the front at a point of the grid's bordered array.
    pub(crate) fn front(&self, point: usize) -> StoredFront<R, C> {
        let Fronts { times, carried, .. } = self.fronts;
        let Some(far) = &self.far else {
            return StoredFront { time: times[point], carried: carried[point] };
        };
        let entry = self.edges.chart().entry(point);
        self.fronts.at(entry).or_else(|| far.at(entry)).expect("the grid has all fronts")
    }
}

/// Prefetches the data that the check of a span's next row needs, from the point `start` on. For fronts this is the row
/// after the next one, since the check of the present row has already read the fronts of the next row. `strides` are
/// the offsets to the next row of the fronts and of the surface's data.
#[inline(always)]
pub(crate) fn prefetch_next_row<R: Real, C: Carried, G>(
    span: &Span<R, C, G>,
    [stride, on_surface]: [isize; 2],
    start: usize,
    looks_at_edges: bool,
) {
    let place = on_surface + start as isize;
    prefetch(span.times, 2 * stride + start as isize);
    prefetch(span.carried, 2 * stride + start as isize);
    if looks_at_edges {
        span.edges.iter().for_each(|edges| prefetch(edges, place));
        prefetch(span.bases[1], place);
    } else {
        prefetch(span.surface_data, place);
    }
}

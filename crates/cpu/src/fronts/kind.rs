//! Defines the interface between solvers and kinds of fronts, and the interfaces of kinds whose points are updated one
//! by one.

use std::ops::Range;

use super::lanes::{Splits, splits_of_line};
use super::pulled::{MOST, Pulled};
use crate::behind::{Behind, TriangleSlots};
use crate::lines::line::GridLines;
use geosweep_surface::update::{Carried, StoredFront, Triangle, tag_of};
use geosweep_surface::{Chart, Direction, EdgeLengths, Real, Seed};

/// A kind of front over a surface. It defines the data that fronts carry, and how fronts start. Updates are defined by
/// [`PointKind`] for solvers that update points one by one, and by [`LaneKind`](super::LaneKind) for those that update
/// lines in SIMD lanes.
pub(crate) trait FrontKind<R: Real>:
    Clone + std::fmt::Debug + Send + Sync + 'static
{
    /// Data that the front at a point carries besides its arrival time.
    type Carried: Fronts<R, Arrival = Self::Arrival>;

    /// A front that arrives at a point.
    type Arrival: Copy;

    /// Whether loops over fronts are compiled for AVX-512 too ([`Loop::AVX512`](geosweep_surface::lanes::Loop::AVX512)).
    const AVX512: bool = true;

    /// Receives all seeds of a map before the first one is added.
    fn expect(&mut self, _: &[Seed]) {}

    /// Returns the front that a seed starts.
    fn arrival_of_seed(&mut self, seed: &Seed) -> Self::Arrival;

    /// Forgets the seeds of the last map.
    fn forget(&mut self) {}

    /// Starts the fronts of seeds, in bordered arrays of arrival times and of the data that fronts carry. Calls
    /// `started` with each seed, its point in the arrays, and the fronts there before and after.
    fn start(
        &mut self,
        chart: Chart,
        seeds: &[Seed],
        (times, carried): (&mut [R], &mut [Self::Carried]),
        mut started: impl FnMut(&Seed, usize, [StoredFront<R, Self::Carried>; 2]),
    ) {
        self.expect(seeds);
        for seed in seeds {
            let point = chart.bordered(seed.row, seed.col);
            let arrival = self.arrival_of_seed(seed);
            let before = StoredFront { time: times[point], carried: carried[point] };
            let after = Self::Carried::accept(before, arrival, tag_of(seed), false);
            (times[point], carried[point]) = (after.time, after.carried);
            started(seed, point, [before, after]);
        }
    }

    /// Returns whether a seed is lost ([`Seed::is_lost`]), given arrival times as a bordered array.
    fn has_lost(chart: Chart, seeds: &[Seed], times: &[R]) -> bool {
        let is_lost = |seed: &Seed| seed.is_lost(times[chart.bordered(seed.row, seed.col)]);
        Self::Carried::TAKES_BACK && seeds.iter().any(is_lost)
    }
}

/// Data that fronts carry, with the rules by which such fronts are accepted and compared. Several kinds of fronts share
/// one type.
pub(crate) trait Fronts<R: Real>: Carried {
    /// A front that arrives at a point.
    type Arrival: Copy;

    /// Whether a scan may replace its own earlier front by one that arrives later. A seed that the first of these
    /// fronts replaced is then lost ([`Seed::is_lost`]).
    const TAKES_BACK: bool = false;

    /// Returns this data without the mark of an exact seed ([`Seed::exact`]), so that fronts of sources that are added
    /// later can replace the front.
    fn released(self) -> Self {
        self
    }

    /// Returns the front at a point after `arrival` has reached it, brought by `scan` (numbered from one).
    /// The arrival is accepted if it is earlier than the present front, or if the scan `renews` a front that the same
    /// scan brought before.
    fn accept(
        kept: StoredFront<R, Self>,
        arrival: Self::Arrival,
        scan: u8,
        renews: bool,
    ) -> StoredFront<R, Self>;

    /// Converts the front at a point to an arrival at another copy of the point, on a glued surface.
    fn arrival_of_front(kept: StoredFront<R, Self>) -> Self::Arrival;

    /// Returns the first of two fronts at a point.
    fn first(a: StoredFront<R, Self>, b: StoredFront<R, Self>) -> StoredFront<R, Self>;

    /// Returns the change of a front, in units of the last place of its arrival time ([`Real::units_between`]).
    fn change(before: StoredFront<R, Self>, after: StoredFront<R, Self>) -> R::Bits;
}

/// Data of fronts that can be updated from a single triangle.
pub(crate) trait TriangleFronts<R: Real>: Fronts<R> {
    /// Returns the arrival time.
    fn time(arrival: Self::Arrival) -> R;

    /// Returns the first of two fronts that arrive at a point.
    fn earlier(a: Self::Arrival, b: Self::Arrival) -> Self::Arrival;

    /// Returns the curvature of a front. For fronts without curvature, returns that of a circle around the source.
    fn curvature(kept: StoredFront<R, Self>) -> R;

    /// Returns the data that a circular front of the given radius carries over a plane.
    fn circle(radius: R) -> Self;
}

/// A kind of front whose points can be updated one by one.
pub(crate) trait PointKind<R: Real>: FrontKind<R> {
    /// Returns the first front that reaches a point through the triangles behind it. `seen` gives the fronts
    /// at other points.
    fn reach(
        &self,
        edges: &EdgeLengths<R>,
        point: usize,
        behind: &Behind,
        seen: impl Fn(usize) -> StoredFront<R, Self::Carried>,
    ) -> Self::Arrival;

    /// Finds the fronts that reach the points of a line through parts of obtuse triangles behind them.
    /// Returns `None` if no triangle there is obtuse.
    fn splits<G>(
        &self,
        _lines: &GridLines<'_, R, Self::Carried, G>,
        _line: usize,
        _points: &Range<usize>,
    ) -> Option<Splits<Self::Arrival>> {
        None
    }
}

/// A kind of front that can be updated from a single triangle.
pub(crate) trait TriangleKind<R: Real>:
    FrontKind<R, Carried: TriangleFronts<R>> + Triangular
{
    /// Returns the front that reaches x0 through the triangle with x1 and x2. `carried` is the data of the fronts at x1
    /// and x2. See [`geosweep_surface::update::Curvatures`] for `alone`.
    fn arrival(
        &self,
        corners: [usize; 3],
        triangle: Triangle<R>,
        carried: [Self::Carried; 2],
        alone: bool,
    ) -> Self::Arrival;

    /// Returns the front through the face of one of a point's triangles. For an obtuse triangle, only its edges count.
    #[inline]
    fn face_arrival(
        &self,
        corners: [usize; 3],
        triangle: Triangle<R>,
        carried: [Self::Carried; 2],
        alone: bool,
    ) -> Self::Arrival {
        let c = if self.is_obtuse(corners, triangle) { R::FAR } else { triangle.c };
        self.arrival(corners, Triangle { c, ..triangle }, carried, alone)
    }

    /// Returns the front through a triangle whose lengths are weighted by the given slowness at x0, x1 and x2,
    /// instead of the slowness of the points. Fronts that depend on lengths alone ignore it.
    fn arrival_over(
        &self,
        corners: [usize; 3],
        triangle: Triangle<R>,
        carried: [Self::Carried; 2],
        _slowness: [R; 3],
    ) -> Self::Arrival {
        self.arrival(corners, triangle, carried, false)
    }

    /// Computes the fronts that arrive at x0 of triangles, as [`Self::face_arrival`] does. Implementations must be inlined
    /// into loops over SIMD lanes.
    #[inline(always)]
    fn arrivals(&self, triangles: &Pulled<R, Self::Carried>, arrivals: &mut [Self::Arrival; MOST]) {
        triangles.one_by_one(self, arrivals);
    }

    /// Prefetches the data of the surface at three points and at those beside them.
    #[inline(always)]
    fn prefetch(&self, _points: [usize; 3]) {}

    /// Returns whether a triangle is obtuse at x0.
    fn is_obtuse(&self, _corners: [usize; 3], triangle: Triangle<R>) -> bool {
        triangle.is_obtuse()
    }

    /// Returns the first front that reaches a point through the parts of its triangle between two neighbours,
    /// if that triangle is obtuse ([`EdgeLengths::split`]).
    fn through_parts(
        &self,
        edges: &EdgeLengths<R>,
        point: usize,
        directions: [Direction; 2],
        seen: impl Fn(usize) -> StoredFront<R, Self::Carried>,
    ) -> Option<Self::Arrival> {
        let mut first: Option<Self::Arrival> = None;
        edges.split(point, directions, |[x1, x2], [l1, l2, c], slowness| {
            let [a, b] = [x1, x2].map(&seen);
            let triangle = Triangle { t1: a.time, t2: b.time, l1, l2, c };
            let carried = [a.carried, b.carried];
            let arrival = self.arrival_over([point, x1, x2], triangle, carried, slowness);
            first = Some(first.map_or(arrival, |first| Self::Carried::earlier(first, arrival)));
        });
        first
    }

    /// Returns the front through one of a point's triangles, including the parts of an obtuse one.
    #[inline]
    fn through(
        &self,
        edges: &EdgeLengths<R>,
        point: usize,
        slots: &TriangleSlots,
        seen: impl Fn(usize) -> StoredFront<R, Self::Carried>,
    ) -> Self::Arrival {
        let [x1, x2] = slots.corners(point);
        let kept = [x1, x2].map(&seen);
        let triangle = slots.triangle(edges, point, kept.map(|front| front.time));
        let carried = kept.map(|front| front.carried);
        let alone = slots.is_alone(triangle);
        let arrival = self.face_arrival([point, x1, x2], triangle, carried, alone);
        if !self.is_obtuse([point, x1, x2], triangle) {
            return arrival;
        }
        let parts = self.through_parts(edges, point, slots.directions(), seen);
        parts.map_or(arrival, |parts| Self::Carried::earlier(arrival, parts))
    }
}

/// Marker of each [`TriangleKind`]. Without a type parameter, it lets the compiler distinguish these kinds from others
/// in the blanket implementation of [`PointKind`].
pub(crate) trait Triangular {}

impl<R: Real, K: TriangleKind<R> + Triangular> PointKind<R> for K {
    #[inline]
    fn reach(
        &self,
        edges: &EdgeLengths<R>,
        point: usize,
        behind: &Behind,
        seen: impl Fn(usize) -> StoredFront<R, K::Carried>,
    ) -> K::Arrival {
        let [a, b] =
            behind.triangles().each_ref().map(|slots| self.through(edges, point, slots, &seen));
        Self::Carried::earlier(a, b)
    }

    fn splits<G>(
        &self,
        lines: &GridLines<'_, R, Self::Carried, G>,
        line: usize,
        points: &Range<usize>,
    ) -> Option<Splits<Self::Arrival>> {
        splits_of_line(self, lines, line, points)
    }
}

//! Fronts at all points of a bordered array, updated one by one.

use crate::behind::Behind;
#[cfg(any(test, feature = "twins"))]
use crate::fronts::exchange::exchange;
use crate::fronts::{Fronts, PointKind};
use crate::solution::Solution;
#[cfg(any(test, feature = "twins"))]
use geosweep_surface::update::Carried;
use geosweep_surface::update::StoredFront;
use geosweep_surface::{EdgeLengths, Real, Seed};

/// Fronts at all points while a solver updates them.
#[derive(Clone)]
pub(crate) struct PointFronts<R: Real, K: PointKind<R>> {
    pub edges: EdgeLengths<R>,
    pub kind: K,
    /// Time after which fronts do not matter. Later fronts are not propagated.
    #[cfg(any(test, feature = "twins"))]
    limit: R,
    times: Vec<R>,
    carried: Vec<K::Carried>,
}

impl<R: Real, K: PointKind<R>> PointFronts<R, K> {
    /// Creates fronts where only the seeds are reached.
    pub(crate) fn start(edges: &EdgeLengths<R>, kind: K, seeds: &[Seed]) -> Self {
        let points = edges.chart().bordered_points();
        let (times, carried) = (vec![R::FAR; points], vec![K::Carried::default(); points]);
        let mut fronts = Self {
            edges: edges.clone(),
            kind,
            #[cfg(any(test, feature = "twins"))]
            limit: R::infinity(),
            times,
            carried,
        };
        fronts.seed(seeds);
        fronts
    }

    fn seed(&mut self, seeds: &[Seed]) {
        let fronts = (self.times.as_mut_slice(), self.carried.as_mut_slice());
        self.kind.start(self.edges.chart(), seeds, fronts, |_, _, _| ());
    }

    /// Restores seeds that are lost ([`Seed::is_lost`]). Returns whether there were any.
    pub(crate) fn restore(&mut self, seeds: &[Seed]) -> bool {
        let any = K::has_lost(self.edges.chart(), seeds, &self.times);
        if any {
            self.seed(seeds);
        }
        any
    }

    /// Returns the front at a point.
    #[inline]
    pub(crate) fn at(&self, point: usize) -> StoredFront<R, K::Carried> {
        StoredFront { time: self.times[point], carried: self.carried[point] }
    }

    fn set(&mut self, point: usize, front: StoredFront<R, K::Carried>) {
        (self.times[point], self.carried[point]) = (front.time, front.carried);
    }

    /// Returns the first of the fronts that reach a point through the two triangles of a scan.
    #[inline]
    pub(crate) fn reach(&self, point: usize, behind: &Behind) -> K::Arrival {
        self.reach_seen(point, behind, |x| self.at(x))
    }

    /// Returns the front of [`Self::reach`], with the fronts at other points given by `seen`.
    #[inline]
    pub(crate) fn reach_seen(
        &self,
        point: usize,
        behind: &Behind,
        seen: impl Fn(usize) -> StoredFront<R, K::Carried>,
    ) -> K::Arrival {
        self.kind.reach(&self.edges, point, behind, seen)
    }

    /// Accepts a front that a scan, numbered from 1, brings to a point
    /// ([`accept`](crate::fronts::Fronts::accept)). Returns the change of the front.
    #[inline]
    pub(crate) fn accept(
        &mut self,
        point: usize,
        arrival: K::Arrival,
        scan: u8,
        renews: bool,
    ) -> R::Bits {
        let before = self.at(point);
        let after = K::Carried::accept(before, arrival, scan, renews);
        #[cfg(any(test, feature = "twins"))]
        if before.time >= R::FAR && after.time > self.limit {
            return R::Bits::default();
        }
        self.set(point, after);
        self.change(before, after)
    }

    /// Returns how much a front has changed, or 0 if it was later than the limit before and after.
    #[inline]
    fn change(
        &self,
        before: StoredFront<R, K::Carried>,
        after: StoredFront<R, K::Carried>,
    ) -> R::Bits {
        #[cfg(any(test, feature = "twins"))]
        if before.time.min(after.time) > self.limit {
            return R::Bits::default();
        }
        K::Carried::change(before, after)
    }

    pub(crate) fn finish(self, iterations: u32, residual: f64) -> Solution<R> {
        Solution::new(self.edges.chart(), self.times, iterations, residual)
    }
}

/// Further methods for the shaders' twins.
#[cfg(any(test, feature = "twins"))]
impl<R: Real, K: PointKind<R>> PointFronts<R, K> {
    /// Creates the fronts of the seeds within a radius. Points beyond the radius are never reached.
    pub(crate) fn start_within(
        edges: &EdgeLengths<R>,
        kind: K,
        seeds: &[Seed],
        radius: f64,
    ) -> Self {
        let seeds: Vec<_> = seeds.iter().filter(|seed| seed.time <= radius).copied().collect();
        Self { limit: R::of(radius), ..Self::start(edges, kind, &seeds) }
    }

    /// Returns the arrival time at a point.
    pub(crate) fn time(&self, point: usize) -> R {
        self.times[point]
    }

    /// Returns the time after which fronts do not matter.
    pub(crate) fn limit(&self) -> R {
        self.limit
    }

    /// Returns the change of the front at a point since `before`, as [`Self::accept`] measures it.
    pub(crate) fn change_from(&self, before: &Self, point: usize) -> R::Bits {
        self.change(before.at(point), self.at(point))
    }

    /// Copies the front at a point from `from`.
    pub(crate) fn copy_point(&mut self, from: &Self, point: usize) {
        self.set(point, from.at(point));
    }

    /// Gives all copies of each point of a glued surface the earliest front among them. Calls `changed` with
    /// each point whose front changes, and the fronts there before and after. Returns the largest change.
    pub(crate) fn exchange(
        &mut self,
        renews: bool,
        mut changed: impl FnMut((usize, usize), [StoredFront<R, K::Carried>; 2]),
    ) -> R::Bits {
        let (mut largest, edges) = (R::Bits::default(), self.edges.clone());
        let at = |map: &Self, point| (map.at(point), renews);
        exchange::<R, K, _>(&edges, self, at, |map, point, [before, after]| {
            map.set(point, after);
            largest = largest.max(K::Carried::change(before, after));
            changed(edges.chart().bordered_position(point), [before, after]);
        });
        largest
    }

    /// Stores the earliest of a point's fronts in `copies`, and returns the change. `copies` are all fronts after each
    /// of four scans, in the order of the scans. If fronts record their scan, a copy contributes only a front that its
    /// own scan has brought. If no copy contributes, the present front stays, or becomes unreached if a scan has made
    /// the point unreached in its copy.
    pub(crate) fn take_first(&mut self, copies: &[Self; 4], point: usize) -> R::Bits {
        let before = self.at(point);
        let (mut taken, mut left): (Option<StoredFront<R, K::Carried>>, _) = (None, before);
        for (copy, scan) in copies.iter().zip(1..) {
            let other = copy.at(point);
            if other.time >= R::FAR {
                left = other;
            } else if !K::Carried::TELLS_SCANS || other.carried.is_from(scan) {
                taken = Some(taken.map_or(other, |taken| K::Carried::first(taken, other)));
            }
        }
        let after = taken.unwrap_or(left);
        self.set(point, after);
        self.change(before, after)
    }
}

//! The fronts at all points of a bordered array, updated one by one.

use super::behind::Behind;
use super::fronts::{FrontKind, KeptBy};
use super::solution::Solution;
use crate::surface::{EdgeLengths, Real, Seed};
#[cfg(feature = "twins")]
use crate::update::Carried;
use crate::update::{Kept, SEED, tag_of};

/// The fronts at all points while a solver works on them.
#[derive(Clone)]
pub(super) struct PointFronts<'a, R: Real, K: FrontKind<'a, R>> {
    pub edges: &'a EdgeLengths<R>,
    pub kind: K,
    times: Vec<R>,
    carried: Vec<K::Carried>,
}

impl<'a, R: Real, K: FrontKind<'a, R>> PointFronts<'a, R, K> {
    /// No point reached but the seeds.
    pub(super) fn start(edges: &'a EdgeLengths<R>, kind: K, seeds: &[Seed]) -> Self {
        let points = edges.chart().bordered_points();
        let (times, carried) = (vec![R::FAR; points], vec![K::Carried::default(); points]);
        let mut fronts = Self { edges, kind, times, carried };
        fronts.seed(seeds);
        fronts
    }

    fn seed(&mut self, seeds: &[Seed]) {
        self.kind.expect(seeds);
        for seed in seeds {
            let arrival = self.kind.arrival_of_seed(seed);
            self.accept(
                self.edges.chart().bordered(seed.row, seed.col),
                arrival,
                tag_of(seed),
                false,
            );
        }
    }

    /// Starts again from seeds that are lost ([`Seed::is_lost`]); returns whether there were any.
    pub(super) fn restore(&mut self, seeds: &[Seed]) -> bool {
        let chart = self.edges.chart();
        let is_lost = |seed: &Seed| seed.is_lost(self.time(chart.bordered(seed.row, seed.col)));
        let any = K::TAKES_BACK && seeds.iter().any(is_lost);
        if any {
            self.seed(seeds);
        }
        any
    }

    /// Arrival time at a point.
    #[inline]
    pub(super) fn time(&self, point: usize) -> R {
        self.times[point]
    }

    /// The front at a point.
    #[inline]
    pub(super) fn at(&self, point: usize) -> KeptBy<'a, R, K> {
        Kept { time: self.times[point], carried: self.carried[point] }
    }

    fn set(&mut self, point: usize, front: KeptBy<'a, R, K>) {
        (self.times[point], self.carried[point]) = (front.time, front.carried);
    }

    /// The first of the fronts that reach a point through the two triangles of a scan.
    #[inline]
    pub(super) fn reach(&self, point: usize, behind: &Behind) -> K::Arrival {
        self.reach_seen(point, behind, |x| self.at(x))
    }

    /// The same, with the fronts at other points seen through `seen`.
    #[inline]
    pub(super) fn reach_seen(
        &self,
        point: usize,
        behind: &Behind,
        seen: impl Fn(usize) -> KeptBy<'a, R, K>,
    ) -> K::Arrival {
        self.kind.reach(self.edges, point, behind, seen)
    }

    /// Accepts a front at a point if it is the first; returns the change of the time.
    #[inline]
    pub(super) fn lower(&mut self, point: usize, arrival: K::Arrival) -> R::Bits {
        self.accept(point, arrival, SEED, false)
    }

    /// Accepts a front that one of the scans, numbered from 1, brings to a point
    /// ([`FrontKind::accept`]); returns the change of the front.
    #[inline]
    pub(super) fn accept(
        &mut self,
        point: usize,
        arrival: K::Arrival,
        scan: u8,
        renews: bool,
    ) -> R::Bits {
        let before = self.at(point);
        let after = K::accept(before, arrival, scan, renews);
        self.set(point, after);
        K::change(before, after)
    }

    pub(super) fn finish(self, iterations: u32, residual: f64) -> Solution<R> {
        Solution::new(self.edges.chart(), self.times, iterations, residual)
    }
}

/// What the shaders' twins need beside that.
#[cfg(any(test, feature = "twins"))]
impl<'a, R: Real, K: FrontKind<'a, R>> PointFronts<'a, R, K> {
    /// How much the front at a point has changed since, as from [`Self::accept`].
    pub(super) fn change_from(&self, before: &Self, point: usize) -> R::Bits {
        K::change(before.at(point), self.at(point))
    }

    /// Takes over the front at a point.
    pub(super) fn copy_point(&mut self, from: &Self, point: usize) {
        self.set(point, from.at(point));
    }

    /// Takes the first of the fronts that copies have at a point after scans of their own, numbered
    /// from 1 in their order; returns the change. A front that the copy's own scan has not brought
    /// stands for nothing but the one that is here; if that has been taken back, none is left.
    pub(super) fn take_first(&mut self, copies: &[Self; 4], point: usize) -> R::Bits {
        let before = self.at(point);
        let (mut taken, mut left): (Option<KeptBy<'a, R, K>>, _) = (None, before);
        for (copy, scan) in copies.iter().zip(1..) {
            let other = copy.at(point);
            if other.time >= R::FAR {
                left = other;
            } else if !K::Carried::TELLS_SCANS || other.carried.is_from(scan) {
                taken = Some(taken.map_or(other, |taken| K::first(taken, other)));
            }
        }
        let after = taken.unwrap_or(left);
        self.set(point, after);
        K::change(before, after)
    }
}

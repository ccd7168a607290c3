//! Triangles through which fronts arrive at points, collected for SIMD lanes.

use super::kind::TriangleKind;
use crate::lines::span::TILE;
use geosweep_surface::Real;
use geosweep_surface::lanes::prefetch;
use geosweep_surface::update::{Carried, Triangle};

/// Number of points whose fronts are computed together. That hides the latency of memory and of divisions.
pub(crate) const BATCH: usize = 16;

/// Largest number of triangles of such points: two for each of eight neighbours.
pub(crate) const MOST: usize = 16 * BATCH;

/// Triangles of a batch of points.
pub(crate) struct Pulled<R, C> {
    pub count: usize,
    /// The corners x0, x1 and x2, as indices into bordered arrays.
    pub corners: [[u32; MOST]; 3],
    /// Arrival times at x1 and x2, and the data of the fronts there.
    pub times: [[R; MOST]; 2],
    pub carried: [[C; MOST]; 2],
    /// Lengths of x0 x1, x0 x2 and x1 x2.
    pub lengths: [[R; MOST]; 3],
    /// See [`geosweep_surface::update::Curvatures`].
    pub alone: [bool; MOST],
}

impl<R: Real, C: Carried> Pulled<R, C> {
    pub(crate) fn new() -> Self {
        Self {
            count: 0,
            corners: [[0; MOST]; 3],
            times: [[R::zero(); MOST]; 2],
            carried: [[C::default(); MOST]; 2],
            lengths: [[R::one(); MOST]; 3],
            alone: [false; MOST],
        }
    }

    #[inline(always)]
    pub(crate) fn add(
        &mut self,
        corners: [usize; 3],
        Triangle { t1, t2, l1, l2, c }: Triangle<R>,
        [c1, c2]: [C; 2],
        alone: bool,
    ) {
        let k = self.count;
        let [x0, x1, x2] = &mut self.corners;
        (x0[k], x1[k], x2[k]) = (corners[0] as u32, corners[1] as u32, corners[2] as u32);
        (self.times[0][k], self.times[1][k]) = (t1, t2);
        (self.carried[0][k], self.carried[1][k]) = (c1, c2);
        (self.lengths[0][k], self.lengths[1][k], self.lengths[2][k]) = (l1, l2, c);
        self.alone[k] = alone;
        self.count += 1;
    }

    /// Returns the [`TILE`] triangles from `start` on. Those after the last one are left over from another batch.
    #[inline(always)]
    pub(super) fn lanes(&self, start: usize) -> Lanes<'_, R, C> {
        let [t1, t2] = &self.times;
        let [l1, l2, c] = &self.lengths;
        let [c1, c2] = &self.carried;
        Lanes {
            times: [lanes(t1, start), lanes(t2, start)],
            lengths: [lanes(l1, start), lanes(l2, start), lanes(c, start)],
            carried: [lanes(c1, start), lanes(c2, start)],
            alone: lanes(&self.alone, start),
        }
    }

    /// Returns the entries of a bordered array at x0, x1 and x2 of the [`TILE`] triangles from `start` on.
    #[inline(always)]
    pub(crate) fn at_corners<G: Copy + Default>(
        &self,
        start: usize,
        array: &[G],
    ) -> [[G; TILE]; 3] {
        let mut found = [[G::default(); TILE]; 3];
        let [x0, x1, x2] = &self.corners;
        for k in 0..TILE.min(self.count - start) {
            found[0][k] = array[x0[start + k] as usize];
            found[1][k] = array[x1[start + k] as usize];
            found[2][k] = array[x2[start + k] as usize];
        }
        found
    }

    /// Computes the fronts that arrive at x0 one by one.
    #[inline(never)]
    pub(super) fn one_by_one<K: TriangleKind<R, Carried = C>>(
        &self,
        kind: &K,
        arrivals: &mut [K::Arrival],
    ) {
        for (k, arrival) in arrivals[..self.count].iter_mut().enumerate() {
            let corners = self.corners.each_ref().map(|corners| corners[k] as usize);
            let carried = [self.carried[0][k], self.carried[1][k]];
            let lanes = self.lanes(k / TILE * TILE);
            let triangle = lanes.triangle(k % TILE);
            *arrival = kind.face_arrival(corners, triangle, carried, self.alone[k]);
        }
    }
}

/// [`TILE`] triangles of [`Pulled`].
pub(super) struct Lanes<'a, R, C> {
    times: [&'a [R; TILE]; 2],
    lengths: [&'a [R; TILE]; 3],
    pub(super) carried: [&'a [C; TILE]; 2],
    pub(super) alone: &'a [bool; TILE],
}

impl<R: Real, C> Lanes<'_, R, C> {
    /// Returns triangle `k`.
    #[inline(always)]
    pub(super) fn triangle(&self, k: usize) -> Triangle<R> {
        Triangle {
            t1: self.times[0][k],
            t2: self.times[1][k],
            l1: self.lengths[0][k],
            l2: self.lengths[1][k],
            c: self.lengths[2][k],
        }
    }
}

/// Prefetches the entries of a bordered array at three points.
#[inline(always)]
pub(crate) fn prefetch_rows<T>(array: &[T], points: [usize; 3]) {
    for point in points {
        prefetch(array, point as isize);
    }
}

#[inline(always)]
fn lanes<T>(of: &[T; MOST], start: usize) -> &[T; TILE] {
    of[start..].first_chunk().expect("batches have whole tiles")
}

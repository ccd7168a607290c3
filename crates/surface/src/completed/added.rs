//! Computes missing points of a grid from its given points.

use glam::DVec3;

/// A point of the surface that is computed from given points. Points are named by their row-major indices.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Added {
    /// The copies of the point on the completed grid.
    pub at: Vec<usize>,
    /// The given points around the point: a ring next to it (`near`), and a ring beyond that (`far`). Opposite points
    /// are half a ring apart. With a single given point in `near` and none in `far`, the point is a copy of that given
    /// point.
    pub near: Vec<usize>,
    pub far: Vec<usize>,
}

/// Smallest ratio of the radii, `far` to `near`, with which the middle is computed from both rings. At smaller ratios
/// the rings do not surround a point.
const LEAST_RATIO: f64 = 1.2;

impl Added {
    /// Returns a copy of a given point.
    pub(super) fn copy(at: usize, of: usize) -> Self {
        Self { at: vec![at], near: vec![of], far: Vec::new() }
    }

    /// Returns the given point of which this point is a copy, or `None` if it is not a copy.
    pub(super) fn copied(&self) -> Option<usize> {
        (self.near.len() == 1 && self.far.is_empty()).then(|| self.near[0])
    }

    /// Returns the mean of the finite values around the point, or NaN if there are none.
    pub(super) fn mean(&self, values: &[f64]) -> f64 {
        let known = self.near.iter().map(|&point| values[point]).filter(|value| value.is_finite());
        known.clone().sum::<f64>() / known.count() as f64
    }

    /// Returns the position of the point, or `None` at a hole.
    ///
    /// Along a line through the middle of the rings, the position is a constant plus a term with the square of the
    /// distance from the middle, plus odd terms, which cancel between opposite points. So the means of both rings give
    /// the middle to third order. Where points of a ring are missing, the opposite points are left out too. A ring with
    /// an odd number of points has no opposite points, so all of its points are needed.
    pub(super) fn position(&self, position: impl Fn(usize) -> Option<DVec3>) -> Option<DVec3> {
        let mean = |points: &[DVec3]| points.iter().sum::<DVec3>() / points.len() as f64;
        if self.far.is_empty() {
            let known: Vec<_> = self.near.iter().filter_map(|&point| position(point)).collect();
            return (!known.is_empty()).then(|| mean(&known));
        }
        let count = self.near.len();
        let of = |k: usize| Some([position(self.near[k])?, position(self.far[k])?]);
        let is_whole = || (0..count).all(|k| of(k).is_some());
        let is_used = |k: usize| match count % 2 {
            0 => of((k + count / 2) % count).is_some(),
            _ => is_whole(),
        };
        let used = (0..count).filter(|&k| is_used(k)).filter_map(of);
        let (near, far): (Vec<_>, Vec<_>) = used.map(|[near, far]| (near, far)).unzip();
        if near.is_empty() {
            return None;
        }
        let [near, far] = [near, far].map(|ring| {
            let middle = mean(&ring);
            let radius = ring.iter().map(|at| at.distance(middle)).sum::<f64>() / ring.len() as f64;
            (middle, radius)
        });
        Some(middle(near, far))
    }
}

/// Returns the middle of two rings, each given by its mean and its radius.
pub(super) fn middle((near, inner): (DVec3, f64), (far, outer): (DVec3, f64)) -> DVec3 {
    if outer < LEAST_RATIO * inner {
        return near;
    }
    let (inner, outer) = (inner * inner, outer * outer);
    (outer * near - inner * far) / (outer - inner)
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use super::*;

    /// Computes a pole of the unit sphere from rings at half a step and one and a half steps from it.
    #[test]
    fn a_pole_is_found_from_the_rings_around_it() {
        let at = |ring: f64, k: usize, count: usize| {
            let (angle, turn) = (0.1 * (ring + 0.5), TAU * k as f64 / count as f64);
            DVec3::new(angle.sin() * turn.cos(), angle.sin() * turn.sin(), angle.cos())
        };
        for count in [12, 15] {
            let near = (0..count).collect();
            let added = Added { at: vec![0], near, far: (count..2 * count).collect() };
            let position = |point: usize| Some(at((point / count) as f64, point % count, count));
            let pole = added.position(position).unwrap();
            // The mean of the nearer ring is off by 1.2e-3. The term of fourth order that is left is an eighth of the
            // product of the rings' squared radii, 7.03e-6.
            assert!(pole.distance(DVec3::Z) < 7.2e-6, "{pole}");
            let holed = added.position(|point| position(point).filter(|_| point != 2));
            match count % 2 {
                0 => assert!(holed.unwrap().distance(DVec3::Z) < 7.2e-6, "{holed:?}"),
                _ => assert_eq!(holed, None),
            }
            assert_eq!(added.position(|_| None), None);
        }
    }
}

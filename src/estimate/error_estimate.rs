//! Defines a map with an estimate of its error.

use std::time::Duration;

use crate::DistanceMap;
use crate::surface::Real;

/// A map with an estimate of its error at each point.
#[derive(Clone, Debug)]
pub struct ErrorEstimate<R = f32> {
    /// The map itself.
    pub map: DistanceMap<R>,
    /// Estimate of |distance - exact distance| at each point, row-major, rounding included, in the unit of
    /// the distances. It is +infinity where the map is +infinity, and where no coarser grid reaches.
    pub errors: Vec<R>,
    /// The map minus its estimated error, sign included (Richardson's extrapolation). It is often much nearer to the
    /// exact distances; see [`estimate_error`](super::estimate_error). Where there is no estimate, it equals the map.
    pub extrapolated: Vec<R>,
    /// The observed order p: over the whole map, changes from grid to grid are proportional to h^p, where h
    /// is the distance between grid points. It needs three grids. On smooth surfaces it is 1.2 to 2 for
    /// circular fronts, about 2 for curved ones, and near 0.5 for planar ones from points. It is lower where
    /// the surface is rough on the grid or has holes, and where only rounding is left. It is `None` for
    /// anchored fronts that are compared with a finer grid.
    pub observed_order: Option<f64>,
    /// Number of grids that were compared, the map's own included: 2 or 3.
    pub grids: u32,
    /// Time of the solves on the other grids.
    pub further_solve_time: Duration,
}

impl<R: Real> ErrorEstimate<R> {
    /// Returns the mean and the largest estimate relative to the distance, over the points that have an
    /// estimate and are not sources.
    pub fn relative(&self) -> (f64, f64) {
        let pairs = self.errors.iter().zip(&self.map.distances);
        let known = pairs.filter(|(error, distance)| error.is_finite() && **distance > R::zero());
        let relative = known.map(|(error, distance)| error.wide() / distance.wide());
        let (sum, largest, count) =
            relative.fold((0.0, 0.0f64, 0u32), |(sum, max, n), e| (sum + e, max.max(e), n + 1));
        (sum / f64::from(count.max(1)), largest)
    }

    /// Returns the number of points that are reached and have no estimate.
    pub fn unknown(&self) -> usize {
        let pairs = self.errors.iter().zip(&self.map.distances);
        pairs.filter(|(error, distance)| error.is_infinite() && distance.is_finite()).count()
    }

    /// Returns the map with the extrapolated distances in place of its own.
    pub fn into_extrapolated_map(self) -> DistanceMap<R> {
        let finite = self.extrapolated.iter().filter(|distance| distance.is_finite());
        let max_distance = finite.fold(f64::NEG_INFINITY, |max, distance| max.max(distance.wide()));
        let mut map = self.map;
        map.distances = self.extrapolated;
        map.report.max_distance = max_distance;
        map
    }
}

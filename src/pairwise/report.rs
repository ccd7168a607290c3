//! Reports how rows of the matrix were computed.

use std::time::Duration;

use crate::{UsedEngine, Wavefront};

/// A report on the computation of rows of a distance matrix.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct PairwiseReport {
    /// Engine that computed the rows.
    pub engine: UsedEngine,
    /// The name of the Vulkan device, if one was used.
    pub device: Option<String>,
    /// The shape of the wavefront assumed inside a triangle.
    pub wavefront: Wavefront,
    /// The number of rows.
    pub rows: usize,
    /// The number of grid points, which is the number of columns.
    pub points: usize,
    /// The largest number of iterations that a map took, of four scans each.
    pub iterations: u32,
    /// The largest of the maps' residuals; see [`Report::residual`](crate::Report::residual).
    pub residual: f64,
    /// The tolerance that the residual had to meet.
    pub tolerance: f64,
    /// The time from the start of the first map to the end of the last one. It includes the handling of rows in
    /// between.
    pub solve_time: Duration,
}

impl PairwiseReport {
    /// Returns whether all maps met the tolerance before the limit of iterations was reached.
    pub fn converged(&self) -> bool {
        self.residual <= self.tolerance
    }

    /// Returns the number of distances per second.
    pub fn distances_per_second(&self) -> f64 {
        (self.rows * self.points) as f64 / self.solve_time.as_secs_f64()
    }
}

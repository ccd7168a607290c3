//! How rows of the matrix were computed.

use std::time::Duration;

use crate::Wavefront;

/// How rows of a distance matrix were computed.
#[derive(Clone, Debug, PartialEq)]
pub struct PairwiseReport {
    /// `vulkan`, `cpu` or `fast-marching`.
    pub engine: &'static str,
    /// Name of the Vulkan device.
    pub device: Option<String>,
    /// The front assumed inside a triangle.
    pub wavefront: Wavefront,
    /// Number of rows.
    pub rows: usize,
    /// Number of grid points, which is that of columns.
    pub points: usize,
    /// Iterations of four scans of the map that took most.
    pub iterations: u32,
    /// The largest of the maps' residuals; see [`Report::residual`](crate::Report::residual).
    pub residual: f64,
    /// What the residual had to meet.
    pub tolerance: f64,
    /// From the first map's start to the last one's end, with what was done with rows in between.
    pub solve_time: Duration,
}

impl PairwiseReport {
    /// Whether all maps met the tolerance before the iterations ran out.
    pub fn converged(&self) -> bool {
        self.residual <= self.tolerance
    }

    /// Distances a second.
    pub fn distances_per_second(&self) -> f64 {
        (self.rows * self.points) as f64 / self.solve_time.as_secs_f64()
    }
}

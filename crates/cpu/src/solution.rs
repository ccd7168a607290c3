//! Distance maps that CPU solvers return.

use rayon::prelude::*;

use geosweep_surface::{Chart, Real};

/// A distance map, as a CPU solver returns it.
#[derive(Clone, Debug)]
pub struct Solution<R> {
    chart: Chart,
    times: Vec<R>,
    /// Latest time with distances; points reached later have none.
    end: f64,
    /// Number of iterations of four scans. The order of time counts as one iteration.
    pub iterations: u32,
    /// Largest relative change of an arrival time in the last iteration, rounded up by at most a factor of
    /// two. A point that was first reached in the last iteration counts as 1.
    pub residual: f64,
}

impl<R: Real> Solution<R> {
    /// Creates a solution from the arrival times of a bordered array.
    pub(super) fn new(chart: Chart, times: Vec<R>, iterations: u32, residual: f64) -> Self {
        Self { chart, times, end: f64::INFINITY, iterations, residual }
    }

    /// Returns the same map, without the distances after a time.
    pub(super) fn ending_at(self, end: f64) -> Self {
        Self { end, ..self }
    }

    /// Returns the distances, row-major. They are +infinity where the sources do not reach.
    pub fn distances(&self) -> Vec<R> {
        distances(self.chart, &self.times, self.end)
    }
}

/// Converts the arrival times of a bordered array to distances, row-major. Times later than `end` and unreached points
/// become +infinity.
pub(super) fn distances<R: Real>(chart: Chart, times: &[R], end: f64) -> Vec<R> {
    let mut distances = vec![R::zero(); chart.points()];
    distances.par_chunks_mut(chart.cols).enumerate().for_each(|(row, distances)| {
        for (distance, &time) in distances.iter_mut().zip(chart.row_of(times, row)) {
            *distance = if time < R::FAR && time.wide() <= end { time } else { R::infinity() };
        }
    });
    distances
}

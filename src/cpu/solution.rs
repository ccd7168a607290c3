//! Distance maps as solvers leave them.

use rayon::prelude::*;

use crate::surface::{Chart, Real};

/// A distance map as a CPU solver leaves it.
#[derive(Clone, Debug)]
pub struct Solution<R> {
    chart: Chart,
    times: Vec<R>,
    /// Iterations of four scans; fast marching counts as one.
    pub iterations: u32,
    /// Largest relative change of an arrival time in the last iteration, to within a factor of two
    /// upwards; a point that was reached in it counts as 1.
    pub residual: f64,
}

impl<R: Real> Solution<R> {
    /// From the arrival times of a bordered array.
    pub(super) fn new(chart: Chart, times: Vec<R>, iterations: u32, residual: f64) -> Self {
        Self { chart, times, iterations, residual }
    }

    /// The distances, row-major, +infinity where the sources do not reach.
    pub fn distances(&self) -> Vec<R> {
        distances(self.chart, &self.times)
    }
}

/// The arrival times of a bordered array as distances, row-major.
pub(super) fn distances<R: Real>(chart: Chart, times: &[R]) -> Vec<R> {
    let mut distances = vec![R::zero(); chart.points()];
    distances.par_chunks_mut(chart.cols).enumerate().for_each(|(row, distances)| {
        for (distance, &time) in distances.iter_mut().zip(chart.row_of(times, row)) {
            *distance = if time < R::FAR { time } else { R::infinity() };
        }
    });
    distances
}

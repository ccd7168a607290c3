//! The geodesic distances between points of a surface.

use rayon::prelude::*;

use super::CanonicalError;
use crate::cpu::{RotatedScan, Stop};
use crate::surface::{EdgeLengths, Seed, Surface};
use crate::update::Wavefront;

/// Computes the distances between some of a surface's points, given by their row-major indices:
/// an n x n matrix, row-major, whose row i holds the distances from the i-th of them, +infinity
/// where it does not reach, and throughout for a hole. Calls `done` after each row, from any
/// thread.
///
/// # Errors
/// If an edge of the surface is too long or too short.
///
/// # Panics
/// If the surface's grid does not have a point.
pub fn geodesic_distances(
    surface: &Surface,
    points: &[usize],
    wavefront: Wavefront,
    stop: Stop,
    done: impl Fn(usize) + Sync,
) -> Result<Vec<f32>, CanonicalError> {
    let edges = EdgeLengths::<f32>::new(surface)?;
    let mut matrix = vec![f32::INFINITY; points.len() * points.len()];
    let rows = matrix.par_chunks_mut(points.len().max(1)).zip(points);
    rows.for_each_init(
        || RotatedScan::new(&edges, wavefront),
        |solver, (row, &source)| {
            if surface.present()[source] {
                let (at_row, at_col) = surface.chart().position(source);
                solver.solve(&[Seed::at_source(at_row, at_col, 0.0)], stop);
                let distances = solver.distances();
                for (distance, &point) in row.iter_mut().zip(points) {
                    *distance = distances[point];
                }
            }
            done(source);
        },
    );
    Ok(matrix)
}

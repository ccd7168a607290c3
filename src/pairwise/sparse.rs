//! Computes sparse rows of the distance matrix: the distances to all points within a radius.

use std::time::Instant;

use rayon::prelude::*;

use super::PairwiseReport;
use super::engine::seeds_of;
use crate::cpu::{Order, RotatedScan, SparseRows};
use crate::surface::{EdgeLengths, Seed, SolverGrid, Surface};
use crate::{Convergence, Engine, Error, Options, Stop, UsedEngine, Wavefront};

/// Computes the distances from each given point (a grid index) to all points within the radius of `options`. The work
/// is proportional to the sum, over all rows, of the area within the radius. Rows are computed by all of rayon's
/// threads.
///
/// The options have the same meaning as for [`Pairwise`](super::Pairwise). The rows are those of the matrix
/// of [`Pairwise`](super::Pairwise), without distances beyond the radius.
///
/// ```
/// use geosweep::pairwise::pairs_within;
/// use geosweep::{Options, Spacing, Surface};
///
/// let surface = Surface::from_heights(5, 5, vec![0.0; 25], Spacing::square(1.0))?;
/// let (pairs, report) = pairs_within(&surface, &[0, 12], &Options::default().with_radius(1.0))?;
/// assert!(report.converged());
/// // The corner has two neighbours, and the middle four.
/// assert_eq!(pairs.indptr, [0, 3, 8]);
/// assert_eq!(pairs.indices, [0, 1, 5, 7, 11, 12, 13, 17]);
/// assert_eq!(pairs.data[..3], [0.0, 1.0, 1.0]);
/// # Ok::<(), geosweep::Error>(())
/// ```
///
/// # Errors
/// If there is no radius or it is not positive, another option is out of range, targets or a schedule are set,
/// an engine other than the CPU's raster scans is requested, a source is outside the grid, or an edge of the
/// surface is too long or too short for single precision.
pub fn pairs_within(
    surface: &Surface,
    sources: &[usize],
    options: &Options,
) -> Result<(SparseRows, PairwiseReport), Error> {
    let fault = |message: String| Err(Error::Options(message));
    let (stop, radius) =
        (options.stop(surface, crate::DEFAULT_TOLERANCE)?, options.checked_radius()?);
    if radius.is_infinite() {
        return fault("sparse rows need a radius; give one, or compute whole rows".into());
    }
    options.check_for_rows()?;
    if !matches!(options.engine, Engine::Auto | Engine::Cpu) {
        return fault("sparse rows are computed by the CPU engine; leave the engine out".into());
    }
    let points = surface.chart().points();
    if let Some(outside) = sources.iter().find(|&&source| source >= points) {
        let message =
            format!("there is no point {outside}; the grid has points 0 to {}", points - 1);
        return fault(message);
    }
    let (wavefront, monitor) = (options.wavefront_of_rows(surface)?, options.monitor());
    let grid = surface.solver_grid();
    let edges = EdgeLengths::measured(grid.surface(), || Ok::<_, Error>(monitor.check()?))?;
    let start = Instant::now();
    let solver = || {
        let solver = RotatedScan::in_order(&edges, wavefront, Order::Lines);
        let mut solver = solver.with_monitor(monitor.clone());
        solver.set_radius(radius);
        solver
    };
    let row = |solver: &mut RotatedScan<f32>, &source: &usize| {
        monitor.check()?;
        Ok::<_, Error>(sparse_row(solver, (&grid, wavefront), source, stop))
    };
    let solved: Vec<_> = sources.par_iter().map_init(solver, row).collect::<Result<_, _>>()?;
    monitor.check()?;
    let (mut rows, mut convergence) = (SparseRows::with_cols(points), Convergence::NONE);
    for (row, of_row) in solved {
        convergence = convergence.worse(of_row);
        rows.push(row);
    }
    let report = PairwiseReport {
        engine: UsedEngine::Cpu,
        device: None,
        wavefront,
        rows: sources.len(),
        points,
        iterations: convergence.iterations,
        residual: convergence.residual,
        tolerance: stop.tolerance,
        solve_time: start.elapsed(),
    };
    Ok((rows, report))
}

/// Returns the entries of a row in order.
fn sparse_row(
    solver: &mut RotatedScan<f32>,
    (grid, wavefront): (&SolverGrid, Wavefront),
    source: usize,
    stop: Stop,
) -> (Vec<(usize, f32)>, Convergence) {
    let (row, col) = grid.chart().position(source);
    if grid.points(&[source]) == [None] {
        return (Vec::new(), Convergence::NONE);
    }
    let seeds = seeds_of(wavefront, grid, Seed::at_source(row, col, 0.0));
    let convergence = solver.solve(&seeds, stop);
    let reached = solver.reached().into_iter();
    (reached.filter_map(|(index, time)| Some((grid.own(index)?, time))).collect(), convergence)
}

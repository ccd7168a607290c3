//! Solves by four directed raster scans, row by row (Algorithm 3).

use super::point_fronts::PointFronts;
use crate::Progress;
use crate::behind::Behind;
use crate::fronts::{PointKind, for_kind};
use crate::solution::Solution;
use geosweep_surface::Stop;
use geosweep_surface::update::Wavefront;
use geosweep_surface::{Direction, EdgeLengths, Real, Seed};

/// Solves by directed raster scans in the paper's order (Algorithm 3; figure 3, first row). A point is
/// updated from the three neighbours that its scan has just passed.
pub fn raster_scan<R: Real>(
    edges: &EdgeLengths<R>,
    seeds: &[Seed],
    wavefront: Wavefront,
    stop: Stop,
) -> Solution<R> {
    for_kind!(edges, wavefront, kind => solve(PointFronts::start(edges, kind, seeds), seeds, stop))
}

fn solve<R: Real, K: PointKind<R>>(
    mut fronts: PointFronts<R, K>,
    seeds: &[Seed],
    stop: Stop,
) -> Solution<R> {
    use Direction::*;
    let chart = fronts.edges.chart();
    let behind = [
        [North, NorthWest, West],
        [East, NorthEast, North],
        [West, SouthWest, South],
        [South, SouthEast, East],
    ]
    .map(|behind| Behind::new(chart, behind));
    let [right_down, left_down, right_up, left_up] = [1, 2, 3, 4];

    let mut progress = Progress::new(stop);
    loop {
        let (mut change, renews) = (R::Bits::default(), progress.renews());
        let mut update = |row: usize, col: usize, scan: u8| {
            let point = chart.bordered(row, col);
            let front = fronts.reach(point, &behind[usize::from(scan) - 1]);
            change = change.max(fronts.accept(point, front, scan, renews));
        };
        for row in 0..chart.rows {
            (0..chart.cols).for_each(|col| update(row, col, right_down));
            (0..chart.cols).rev().for_each(|col| update(row, col, left_down));
        }
        for row in (0..chart.rows).rev() {
            (0..chart.cols).for_each(|col| update(row, col, right_up));
            (0..chart.cols).rev().for_each(|col| update(row, col, left_up));
        }
        if progress.is_done::<R>(change) && (progress.is_last() || !fronts.restore(seeds)) {
            return fronts.finish(progress.iterations, progress.residual);
        }
    }
}

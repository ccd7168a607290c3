//! Rotated raster scans one after another, point by point. The twin of `glsl/scan.comp`.

use super::state::{Fronts, Solution, TriangleSlots};
use super::{Progress, Stop};
use crate::surface::{Direction, EdgeLengths, Real, Seed};
use crate::update::Wavefront;

/// The four scans of an iteration, numbered from 1: the three neighbours a scan has just passed,
/// across the scan from west to east or from north to south.
const SCANS: [[Direction; 3]; 4] = [
    [Direction::NorthWest, Direction::North, Direction::NorthEast],
    [Direction::SouthWest, Direction::South, Direction::SouthEast],
    [Direction::NorthWest, Direction::West, Direction::SouthWest],
    [Direction::NorthEast, Direction::East, Direction::SouthEast],
];

/// Solves by the scans rotated by 45 degrees (figure 3, second row), down, up, right and left, each
/// after the one before: iteration by iteration what the shader does. [`super::rotated_scan`]
/// converges to the same map, many times faster.
pub fn scan_in_turn<R: Real>(
    edges: &EdgeLengths<R>,
    seeds: &[Seed],
    wavefront: Wavefront,
    stop: Stop,
) -> Solution<R> {
    let chart = edges.chart();
    let (rows, cols) = (chart.rows, chart.cols);
    let triangles =
        SCANS.map(|[a, b, c]| [TriangleSlots::new(chart, a, b), TriangleSlots::new(chart, b, c)]);

    let mut fronts = Fronts::start(edges, seeds, wavefront);
    let mut progress = Progress::new(stop);
    loop {
        let (mut change, renews) = (R::Bits::default(), progress.renews());
        let mut update = |row: usize, col: usize, scan: u8| {
            let point = chart.bordered(row, col);
            let front = fronts.through(point, &triangles[usize::from(scan) - 1]);
            change = change.max(fronts.accept(point, front, scan, renews));
        };
        (0..rows).for_each(|row| (0..cols).for_each(|col| update(row, col, 1)));
        (0..rows).rev().for_each(|row| (0..cols).for_each(|col| update(row, col, 2)));
        (0..cols).for_each(|col| (0..rows).for_each(|row| update(row, col, 3)));
        (0..cols).rev().for_each(|col| (0..rows).for_each(|row| update(row, col, 4)));
        if progress.is_done::<R>(change) {
            return fronts.finish(progress.iterations, progress.residual);
        }
    }
}

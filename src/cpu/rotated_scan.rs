//! Rotated raster scans: whole rows, then whole columns. The twin of `glsl/scan.comp`.

use super::Stop;
use super::state::{Fronts, Solution, TriangleSlots};
use crate::surface::{Direction, EdgeLengths, Real, Seed};
use crate::update::Wavefront;

/// The four scans of an iteration, numbered from 1: the three neighbours a scan has just passed, across the scan
/// from west to east or from north to south.
const SCANS: [[Direction; 3]; 4] = [
    [Direction::NorthWest, Direction::North, Direction::NorthEast],
    [Direction::SouthWest, Direction::South, Direction::SouthEast],
    [Direction::NorthWest, Direction::West, Direction::SouthWest],
    [Direction::NorthEast, Direction::East, Direction::SouthEast],
];

/// Solves by the scans rotated by 45 degrees (figure 3, second row), down, up, right and left:
/// all points of a row or column could be updated at once.
pub fn rotated_scan<R: Real>(
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
    let mut iterations = 0;
    loop {
        let mut change = R::zero();
        let mut update = |row: usize, col: usize, scan: u8| {
            let point = chart.bordered(row, col);
            let front = fronts.through(point, &triangles[usize::from(scan) - 1]);
            change = change.max(fronts.accept(point, front, scan));
        };
        (0..rows).for_each(|row| (0..cols).for_each(|col| update(row, col, 1)));
        (0..rows).rev().for_each(|row| (0..cols).for_each(|col| update(row, col, 2)));
        (0..cols).for_each(|col| (0..rows).for_each(|row| update(row, col, 3)));
        (0..cols).rev().for_each(|col| (0..rows).for_each(|row| update(row, col, 4)));
        iterations += 1;
        if stop.done(iterations, change.wide()) {
            return fronts.finish(iterations, change.wide());
        }
    }
}

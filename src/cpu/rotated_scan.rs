//! Rotated raster scans: whole rows, then whole columns. The twin of `glsl/scan.comp`.

use super::Stop;
use super::state::{Solution, TriangleSlots};
use crate::surface::{Direction, EdgeLengths, Real, Seed};
use crate::update::Wavefront;

/// The four scans of an iteration: the three neighbours a scan has just passed, across the scan
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
    let [down, up, right, left] =
        SCANS.map(|[a, b, c]| [TriangleSlots::new(chart, a, b), TriangleSlots::new(chart, b, c)]);

    let mut solution = Solution::start(chart, seeds);
    loop {
        let mut change = R::zero();
        let mut update = |row: usize, col: usize, triangles: &[TriangleSlots; 2]| {
            let point = chart.bordered(row, col);
            let arrival = |triangle: &TriangleSlots| {
                triangle.load(edges, point, |point| solution.times[point]).update(wavefront)
            };
            let time = arrival(&triangles[0]).min(arrival(&triangles[1]));
            change = change.max(solution.lower(point, time));
        };
        (0..rows).for_each(|row| (0..cols).for_each(|col| update(row, col, &down)));
        (0..rows).rev().for_each(|row| (0..cols).for_each(|col| update(row, col, &up)));
        (0..cols).for_each(|col| (0..rows).for_each(|row| update(row, col, &right)));
        (0..cols).rev().for_each(|col| (0..rows).for_each(|row| update(row, col, &left)));
        solution.iterations += 1;
        solution.residual = change.wide();
        if stop.done(solution.iterations, solution.residual) {
            return solution;
        }
    }
}

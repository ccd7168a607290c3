//! Finds curves at a map's largest distance. No point is farther, so no edge crosses that level; the curves
//! connect the points that have the largest distance.

use super::Curve;
use super::arrivals::Arrivals;
use super::chains::ways;
use geosweep_surface::Direction::{East, North, South, SouthEast, West};
use geosweep_surface::{Cell, Direction};

/// The rounding error of a largest distance in single precision that accumulates along the path, as a
/// fraction of the distance since the start.
const ON_THE_WAY: f64 = 2e-6;
/// The rounding error of the stored value, as a fraction of that value.
const OF_DIGITS: f64 = 4.0 * f32::EPSILON as f64;

/// Returns the largest difference from the largest distance at which a distance counts as equal to it.
pub(super) fn rounding(start: f64, largest: f64) -> f64 {
    let rounding = ON_THE_WAY * (largest - start) + OF_DIGITS * largest.abs().max(start.abs());
    if rounding.is_finite() { rounding.max(0.0) } else { 0.0 }
}

/// Returns the curves along grid edges between points whose distance is at least `least`. If nearer points
/// lie on one side of a curve only, that side is the left.
pub(super) fn curves(arrivals: &Arrivals, least: f64) -> Vec<Curve> {
    let chart = arrivals.chart;
    let is_top = |index: usize| {
        let time = f64::from(arrivals.time(index));
        time.is_finite() && time >= least
    };
    let top = |(row, col): (usize, usize)| is_top(chart.index(row, col));
    // Whether a corner of the cell to the south-east of a point is nearer than `least`. Only edges at the border of a
    // plateau are used.
    let falls = |at: Option<(usize, usize)>| {
        let whole = at.filter(|&(row, col)| chart.neighbour(row, col, SouthEast).is_some());
        let corners = whole.map(|at| Cell::of(at).corners());
        corners.into_iter().flatten().any(|(row, col)| {
            let time = f64::from(arrivals.time(chart.index(row, col)));
            time.is_finite() && time < least
        })
    };
    let mut edges = Vec::new();
    let number = |(row, col): (usize, usize)| chart.index(row, col) as u64;
    for here in chart.places() {
        let to = |way| chart.neighbour(here.0, here.1, way);
        let is_border = |other: Direction| falls(Some(here)) || falls(to(other));
        let beside = [(East, North), (South, West)];
        for (end, other) in beside.into_iter().filter_map(|(way, other)| Some((to(way)?, other))) {
            if top(here) && top(end) && is_border(other) {
                edges.push([here, end].map(number));
            }
        }
        if to(SouthEast).is_some() && falls(Some(here)) {
            // Diagonals are used only where no path along the sides of the cell exists.
            let corners @ [_, east, south, across] = Cell::of(here).corners();
            match corners.map(top) {
                [true, false, false, true] => edges.push([here, across].map(number)),
                [false, true, true, false] => edges.push([east, south].map(number)),
                _ => (),
            }
        }
    }
    ways(&edges).into_iter().map(|way| curve(arrivals, &way)).collect()
}

fn curve(arrivals: &Arrivals, way: &[u64]) -> Curve {
    let chart = arrivals.chart;
    let mut points: Vec<_> = way.iter().map(|&point| chart.position(point as usize)).collect();
    let closed = points.len() > 3 && points.first() == points.last();
    if !is_left_nearer(arrivals, &points) {
        points.reverse();
    }
    if closed {
        points.pop();
    }
    let vertices = points.into_iter().map(|(row, col)| [row as f64, col as f64]).collect();
    Curve { vertices, closed }
}

/// Returns whether the points to the left are nearer overall than the points to the right, as seen on the
/// grid with rows downwards.
fn is_left_nearer(arrivals: &Arrivals, points: &[(usize, usize)]) -> bool {
    let chart = arrivals.chart;
    let mut balance = 0.0;
    for step in points.windows(2) {
        let [(row, col), (next_row, next_col)] =
            [step[0], step[1]].map(|(row, col)| (row as isize, col as isize));
        let (down, right) = (next_row - row, next_col - col);
        let at = |down: isize, right: isize| {
            let (row, col) = chart.at(row + down, col + right)?;
            let time = f64::from(arrivals.time(chart.index(row, col)));
            time.is_finite().then_some(time)
        };
        let here = at(0, 0).unwrap_or(0.0);
        let nearer = |time: Option<f64>| time.map_or(0.0, |time| here - time);
        balance += nearer(at(-right, down)) - nearer(at(right, -down));
    }
    balance >= 0.0
}

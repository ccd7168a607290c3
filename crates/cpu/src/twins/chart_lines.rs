//! Adds fronts at the points around a source inside a skewed cell or over a slowness. The twin of
//! `glsl/passes/chart_lines.glsl`.

use glam::DVec2;

use super::surroundings::CentralSource;
use geosweep_surface::{
    Block, Direction, EdgeLengths, Heading, Real, Seed, corner_weights, grid_crossings,
    splits_within,
};

/// Limit of the squares of a triangle's sides for which any obtuse angle counts, but for rounding.
const EXACTLY: f64 = 1.0 - 1e-5;

/// Returns seeds at the points of a window, at most as far from a source's cell as points that split the triangles
/// around it, if rays `bend` around the points beside the source. They hold the lengths of straight lines of the chart.
pub(super) fn along_lines<R: Real>(
    edges: &EdgeLengths<R>,
    source: &CentralSource,
    window: &Block,
    bends: bool,
) -> Vec<Seed> {
    let from = source.at;
    if !bends {
        return Vec::new();
    }
    let around = edges.chart().around_place(from, 1);
    let skew = around.places().map(|at| skew_at(edges, at)).max().unwrap_or(1);
    if skew == 1 && edges.slowness().is_none() {
        return Vec::new();
    }
    let seed = |(row, col): (usize, usize)| {
        let to = DVec2::new(row as f64, col as f64);
        let beyond = (from.floor() - to).max(to - from.ceil());
        let is_near = beyond.max_element() <= skew as f64;
        let away = if is_near { length_of_line(edges, from, to)? } else { return None };
        if away == 0.0 {
            return None;
        }
        Some(Seed {
            row,
            col,
            time: source.start + away,
            curvature: 1.0 / away,
            from: Some(from),
            origin: None,
            exact: false,
            heading: Heading::Along(to - from),
            source: 0,
        })
    };
    window.places().filter_map(seed).collect()
}

/// Returns the distance of the farthest point that splits a triangle of a point, in half of its directions.
fn skew_at<R: Real>(edges: &EdgeLengths<R>, (row, col): (usize, usize)) -> usize {
    let skew = |to: Direction| {
        let (beside_row, beside_col) = edges.chart().neighbour(row, col, to)?;
        let length = |at, to| length_on_surface(edges, at, to).map(R::of).unwrap_or(R::FAR);
        let beside = (beside_row, beside_col);
        let lengths = [((row, col), to), ((row, col), to.next()), (beside, to.base())];
        let squares = lengths.map(|(at, to)| length(at, to)).map(|length| length * length);
        Some(splits_within([to, to.next()].map(Direction::vector), squares, EXACTLY))
    };
    Direction::ALL[..4].iter().filter_map(|&to| skew(to)).max().unwrap_or(1)
}

/// Returns the length of an edge on the surface, or `None` if there is none.
fn length_on_surface<R: Real>(
    edges: &EdgeLengths<R>,
    (row, col): (usize, usize),
    to: Direction,
) -> Option<f64> {
    let length = edges.length(row, col, to).wide();
    let other = edges.chart().neighbour(row, col, to).filter(|_| length < R::FAR.wide())?;
    let mean = 0.5 * (slowness_at(edges, (row, col)) + slowness_at(edges, other));
    Some(length / mean)
}

/// Returns the slowness of a point, 1 without a slowness.
fn slowness_at<R: Real>(edges: &EdgeLengths<R>, (row, col): (usize, usize)) -> f64 {
    let point = edges.chart().bordered(row, col);
    edges.slowness().map_or(1.0, |slowness| slowness[point].wide())
}

/// Returns the slowness at a place of the cell with a given north-western corner.
fn slowness_in_cell<R: Real>(edges: &EdgeLengths<R>, cell: DVec2, place: DVec2) -> f64 {
    let weights = corner_weights([true; 4], place - cell).expect("no corner is missing");
    let (row, col) = (cell.x as usize, cell.y as usize);
    let corners = [(row, col), (row, col + 1), (row + 1, col), (row + 1, col + 1)];
    weights.iter().zip(corners).map(|(weight, at)| weight * slowness_at(edges, at)).sum()
}

/// Returns the length on the surface of a step inside the cell with a given north-western corner, or `None` if the cell is
/// not whole.
fn length_in_cell<R: Real>(edges: &EdgeLengths<R>, cell: DVec2, step: DVec2) -> Option<f64> {
    let square = |down: usize, right: usize, to: Direction| {
        let at = (cell.x as usize + down, cell.y as usize + right);
        length_on_surface(edges, at, to).map(|length| length * length)
    };
    let along_cols = square(0, 0, Direction::East)? + square(1, 0, Direction::East)?;
    let along_rows = square(0, 0, Direction::South)? + square(0, 1, Direction::South)?;
    let [falling, rising] =
        [square(0, 0, Direction::SouthEast)?, square(1, 0, Direction::NorthEast)?];
    let DVec2 { x: down, y: right } = step;
    let sum = along_cols * right * right + along_rows * down * down;
    Some((0.5 * (sum + (falling - rising) * down * right)).max(0.0).sqrt())
}

/// Returns the length of the straight line of the chart between two places, or `None` if a point is missing beside it.
/// Over a slowness, its part in a cell costs its length times the mean slowness of its ends, as in the updates.
fn length_of_line<R: Real>(edges: &EdgeLengths<R>, from: DVec2, to: DVec2) -> Option<f64> {
    let chart = edges.chart();
    let last = DVec2::new(chart.rows as f64 - 2.0, chart.cols as f64 - 2.0);
    let part = |ends: &[f64]| {
        let [a, b] = [ends[0], ends[1]].map(|share| from.lerp(to, share));
        let cell = a.midpoint(b).floor().min(last);
        let length = (cell.min_element() >= 0.0).then(|| length_in_cell(edges, cell, b - a))??;
        let slowness = slowness_in_cell(edges, cell, a) + slowness_in_cell(edges, cell, b);
        Some(0.5 * slowness * length)
    };
    grid_crossings(from, to).windows(2).map(part).sum()
}

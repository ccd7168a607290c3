//! Adds fronts at the points around a source inside a skewed cell. The twin of `glsl/passes/chart_lines.glsl`.

use glam::DVec2;

use super::surroundings::CentralSource;
use geosweep_surface::{Block, Direction, EdgeLengths, Heading, Real, Seed, splits_within};

/// Number of pieces of a line per row or column, whose lengths are added up.
const PIECES: f64 = 4.0;
/// Limit of the squares of a triangle's sides for which any obtuse angle counts, but for rounding.
const EXACTLY: f64 = 1.0 - 1e-5;

/// Returns seeds at the points of a window, at most as far from a source's cell as points that split the triangles
/// around it. They hold the lengths of straight lines of the chart.
pub(super) fn along_lines<R: Real>(
    edges: &EdgeLengths<R>,
    source: &CentralSource,
    window: &Block,
) -> Vec<Seed> {
    let from = source.at;
    if edges.slowness().is_some() || from.fract() == DVec2::ZERO {
        return Vec::new();
    }
    let around = edges.chart().around_place(from, 1);
    let skew = around.places().map(|at| skew_at(edges, at)).max().unwrap_or(1);
    if skew == 1 {
        return Vec::new();
    }
    let seed = |(row, col): (usize, usize)| {
        let to = DVec2::new(row as f64, col as f64);
        let beyond = (from.floor() - to).max(to - from.ceil());
        let is_near = beyond.max_element() <= skew as f64;
        let away = if is_near { length_of_line(edges, from, to)? } else { return None };
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
        let lengths = [
            edges.length(row, col, to),
            edges.length(row, col, to.next()),
            edges.length(beside_row, beside_col, to.base()),
        ];
        let squares = lengths.map(|length| length * length);
        Some(splits_within([to, to.next()].map(Direction::vector), squares, EXACTLY))
    };
    Direction::ALL[..4].iter().filter_map(|&to| skew(to)).max().unwrap_or(1)
}

/// Returns the length of a step inside the cell with a given north-western corner, or `None` if the cell is not whole.
fn length_in_cell<R: Real>(edges: &EdgeLengths<R>, cell: DVec2, step: DVec2) -> Option<f64> {
    let square = |down: usize, right: usize, to: Direction| {
        let length = edges.length(cell.x as usize + down, cell.y as usize + right, to).wide();
        (length < R::FAR.wide()).then_some(length * length)
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
fn length_of_line<R: Real>(edges: &EdgeLengths<R>, from: DVec2, to: DVec2) -> Option<f64> {
    let chart = edges.chart();
    let last = DVec2::new(chart.rows as f64 - 2.0, chart.cols as f64 - 2.0);
    let pieces = ((to - from).abs().max_element() * PIECES).ceil();
    let length = |piece: usize| {
        let middle = from.lerp(to, (piece as f64 + 0.5) / pieces);
        let cell = middle.floor().min(last);
        (cell.min_element() >= 0.0).then(|| length_in_cell(edges, cell, (to - from) / pieces))?
    };
    (0..pieces as usize).map(length).sum()
}

//! Computes shortest paths over a flat grid with holes, by a visibility graph.
//!
//! This computation is independent of the solvers. A shortest path between obstacles with straight sides is a
//! chain of straight lines that bends only at the obstacles' corners.

use std::iter::Peekable;
use std::ops::Range;

use glam::DVec2;
use rayon::prelude::*;

use crate::{Chart, Direction, is_corner};

/// A flat grid with missing points. Its floor is the union of the triangles of three neighbouring points that
/// are all present, and of the edges between two points that are present. A cell with one corner missing
/// keeps its half on the other side of the diagonal.
pub struct FloorPlan {
    chart: Chart,
    floor: Vec<bool>,
    /// Distance between rows and between columns.
    spacing: DVec2,
}

/// Distance in cells below which two positions count as one.
const NEAR: f64 = 1e-9;

impl FloorPlan {
    #[doc(hidden)]
    pub fn new(rows: usize, cols: usize, floor: Vec<bool>, spacing: DVec2) -> Self {
        Self { chart: Chart { rows, cols }, floor, spacing }
    }

    fn has(&self, row: usize, col: usize) -> bool {
        row < self.chart.rows && col < self.chart.cols && self.floor[self.chart.index(row, col)]
    }

    fn neighbour(&self, row: usize, col: usize, to: Direction) -> bool {
        self.chart.neighbour(row, col, to).is_some_and(|(row, col)| self.has(row, col))
    }

    /// Returns the length of a straight line between two places.
    fn length(&self, a: DVec2, b: DVec2) -> f64 {
        ((b - a) * self.spacing).length()
    }

    /// Returns the points at which a shortest path can bend.
    fn corners(&self) -> Vec<DVec2> {
        let Chart { rows, cols } = self.chart;
        (0..rows)
            .flat_map(|row| (0..cols).map(move |col| (row, col)))
            .filter(|&(row, col)| {
                let there = || Direction::ALL.map(|to| self.neighbour(row, col, to));
                self.has(row, col) && is_corner(there())
            })
            .map(|(row, col)| DVec2::new(row as f64, col as f64))
            .collect()
    }

    /// Returns whether the straight line between two places stays on the floor.
    fn sees(&self, a: DVec2, b: DVec2) -> bool {
        let shortest = NEAR / (b - a).length().max(NEAR);
        let mut rows = crossings(a.x, b.x).peekable();
        let mut cols = crossings(a.y, b.y).peekable();
        let mut from = 0.0;
        while from < 1.0 {
            let next = |cuts: &mut Peekable<_>| cuts.peek().copied().unwrap_or(1.0);
            let (row, col) = (next(&mut rows), next(&mut cols));
            let to = row.min(col);
            if row <= col {
                rows.next()
            } else {
                cols.next()
            };
            if to - from >= shortest {
                if !self.has_piece(a.lerp(b, from), a.lerp(b, to)) {
                    return false;
                }
                from = to;
            } else if to >= 1.0 {
                break;
            }
        }
        true
    }

    /// Returns whether a piece of a line lies on the floor. The piece does not cross a row or column inside.
    fn has_piece(&self, a: DVec2, b: DVec2) -> bool {
        let middle = 0.5 * (a + b);
        let (rows, cols) = (span(middle.x), span(middle.y));
        match (rows.len(), cols.len()) {
            (1, 1) | (1, 2) | (2, 1) => {
                let mut points = rows.flat_map(|row| cols.clone().map(move |col| (row, col)));
                points.all(|(row, col)| self.has(row, col))
            }
            _ => {
                let corner = |k: usize| (rows.start + k / 2, cols.start + k % 2);
                let mut missing = (0..4).map(corner).filter(|&(row, col)| !self.has(row, col));
                match (missing.next(), missing.next()) {
                    (None, _) => true,
                    (Some((row, col)), None) => {
                        let hole = DVec2::new(row as f64, col as f64);
                        let beyond = |x: DVec2| (x - hole).abs().element_sum() >= 1.0 - NEAR;
                        beyond(a) && beyond(b)
                    }
                    _ => false,
                }
            }
        }
    }
}

/// Returns the grid line that a coordinate lies on, or the two grid lines that it lies between.
fn span(x: f64) -> Range<usize> {
    let nearest = x.round();
    if (x - nearest).abs() < NEAR {
        nearest as usize..nearest as usize + 1
    } else {
        x as usize..x as usize + 2
    }
}

/// Returns the parameters between 0 and 1, in order, at which a line passes whole coordinates.
fn crossings(from: f64, to: f64) -> impl Iterator<Item = f64> {
    let (first, last) = (from.min(to).floor() as usize + 1, from.max(to).ceil() as usize);
    let count = last.saturating_sub(first);
    (0..count).map(move |k| {
        let line = if from < to { first + k } else { last - 1 - k };
        (line as f64 - from) / (to - from)
    })
}

/// Distances over a floor from one place.
pub struct FlatPaths {
    plan: FloorPlan,
    /// The source and all reachable corners, with their distances.
    anchors: Vec<(DVec2, f64)>,
}

impl FlatPaths {
    /// Computes the distances to all corners by Dijkstra's algorithm over the source and the corners.
    #[doc(hidden)]
    pub fn new(plan: FloorPlan, from: [f64; 2]) -> Self {
        let from = DVec2::from_array(from);
        let mut open: Vec<_> = plan.corners().into_iter().map(|at| (at, f64::INFINITY)).collect();
        let mut anchors = Vec::new();
        let mut next = plan.has_piece(from, from).then_some((from, 0.0));
        while let Some((at, distance)) = next {
            anchors.push((at, distance));
            for (corner, best) in &mut open {
                let through = distance + plan.length(at, *corner);
                if through < *best && plan.sees(at, *corner) {
                    *best = through;
                }
            }
            next = (0..open.len())
                .min_by(|&i, &j| open[i].1.total_cmp(&open[j].1))
                .filter(|&nearest| open[nearest].1.is_finite())
                .map(|nearest| open.swap_remove(nearest));
        }
        Self { plan, anchors }
    }

    /// Returns the distance to a place, given by fractional row and column. It is infinite if the place
    /// cannot be reached.
    pub(crate) fn distance_to(&self, to: [f64; 2]) -> f64 {
        let to = DVec2::from_array(to);
        if !self.plan.has_piece(to, to) {
            return f64::INFINITY;
        }
        let through = |&(at, distance): &(DVec2, f64)| (distance + self.plan.length(at, to), at);
        let mut ways: Vec<_> = self.anchors.iter().map(through).collect();
        ways.sort_by(|a, b| a.0.total_cmp(&b.0));
        ways.into_iter().find(|&(_, at)| self.plan.sees(at, to)).map_or(f64::INFINITY, |way| way.0)
    }

    /// Returns the distances to all grid points, row-major.
    #[doc(hidden)]
    pub fn distances(&self) -> Vec<f64> {
        let chart = self.plan.chart;
        let distance = |index| {
            let (row, col) = chart.position(index);
            self.distance_to([row as f64, col as f64])
        };
        (0..chart.points()).into_par_iter().map(distance).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Computes the paths over a picture's floor, marked by dots.
    fn paths(picture: &[&str], from: [f64; 2]) -> FlatPaths {
        let floor = picture.iter().flat_map(|row| row.chars().map(|c| c == '.')).collect();
        FlatPaths::new(FloorPlan::new(picture.len(), picture[0].len(), floor, DVec2::ONE), from)
    }

    #[test]
    fn nothing_in_the_way_is_a_straight_line() {
        let paths = paths(&["....", "....", "...."], [0.25, 0.5]);
        approx::assert_relative_eq!(paths.distance_to([1.75, 2.5]), 2.5);
        assert_eq!(paths.distance_to([0.25, 0.5]), 0.0);
    }

    #[test]
    fn one_missing_point_is_a_diamond() {
        let paths = paths(&[".....", ".....", "..#..", ".....", "....."], [2.0, 0.0]);
        // The path over the diamond's tip at (1, 2) consists of two straight lines.
        approx::assert_relative_eq!(paths.distance_to([2.0, 4.0]), 2.0 * 5f64.sqrt());
        // The path past the diamond's side runs along a diagonal of the grid.
        approx::assert_relative_eq!(paths.distance_to([0.0, 2.0]), 8f64.sqrt());
        assert_eq!(paths.distance_to([2.0, 2.0]), f64::INFINITY);
        assert_eq!(paths.distance_to([2.25, 2.25]), f64::INFINITY);
        assert!(paths.distance_to([2.5, 2.5]).is_finite());
    }

    #[test]
    fn a_wall_is_walked_around() {
        let paths = paths(&[".....", ".....", "###..", ".....", "....."], [4.0, 0.0]);
        // The path bends at the corners of the wall's end, at (3, 2), (2, 3) and (1, 2).
        let exact = 5f64.sqrt() + 2.0 * 2f64.sqrt() + 5f64.sqrt();
        approx::assert_relative_eq!(paths.distance_to([0.0, 0.0]), exact);
    }

    #[test]
    fn a_corridor_one_point_wide_is_walked_along_its_edges() {
        let paths = paths(&["...", "##.", "##.", "##."], [0.0, 0.0]);
        approx::assert_relative_eq!(paths.distance_to([3.0, 2.0]), 3.0 + 2f64.sqrt());
        let turn = self::paths(&["..##", "#.##", "#...", "####"], [0.0, 0.0]);
        // The half cells beside the corridor allow the path to cut off both bends.
        approx::assert_relative_eq!(turn.distance_to([2.0, 3.0]), 1.0 + 2.0 * 2f64.sqrt());
    }

    #[test]
    fn holes_that_touch_at_a_corner_let_nothing_through() {
        let paths = paths(&[".#", "#."], [0.0, 0.0]);
        assert_eq!(paths.distance_to([1.0, 1.0]), f64::INFINITY);
    }
}

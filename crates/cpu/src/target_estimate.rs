//! Estimates the times at which fronts reach given points, from a few points of the grid.
//!
//! Planar fronts march over the points on every eighth row and column. The path from one of these points to the next is
//! the line of grid edges between them, so holes and slowness count, and every path found exists on the grid. The
//! estimate only sets the first limit of a map. The map itself does not depend on it.

use std::cmp::{Ordering, Reverse};
use std::collections::BinaryHeap;

use geosweep_surface::Targets;
use geosweep_surface::update::{Triangle, planar};
use geosweep_surface::{Chart, Direction, EdgeLengths, Real, Seed};

/// Number of rows and columns from one point to the next, where the grid is large enough.
const LARGEST_STEP: usize = 8;
/// Minimum number of points on the longer side if the step is larger than 1.
const LEAST_POINTS: usize = 24;

/// Estimates the time at which fronts of the seeds have reached the targets. Also returns the number of visited points.
/// The time is not finite if no path was found on any of the grids.
pub fn estimate_targets<R: Real>(
    edges: &EdgeLengths<R>,
    seeds: &[Seed],
    targets: &Targets,
) -> (f64, u64) {
    let chart = edges.chart();
    let mut step = LARGEST_STEP;
    while step > 1 && chart.rows.max(chart.cols) / step < LEAST_POINTS {
        step /= 2;
    }
    let mut visits = 0;
    loop {
        let mut march = March::new(edges, step, seeds);
        let time = march.run(seeds, targets);
        visits += march.visits;
        // Narrow passages may lie between the points.
        if time.is_finite() || step == 1 {
            return (time, visits);
        }
        step /= 2;
    }
}

/// A march of fronts over some of a grid's points, in the order of time.
struct March<'a, R> {
    edges: &'a EdgeLengths<R>,
    step: usize,
    /// The first of these points' rows and columns.
    first: (usize, usize),
    /// The chart of these points alone.
    coarse: Chart,
    times: Vec<f64>,
    fixed: Vec<bool>,
    /// Lengths of the paths to the neighbours in the directions of `STORED`; NaN where not measured yet.
    ways: Vec<[f64; 4]>,
    heap: BinaryHeap<Reverse<Arrival>>,
    visits: u64,
}

/// A point of the front, ordered by arrival time. The index makes the order total.
#[derive(Clone, Copy, PartialEq)]
struct Arrival {
    time: f64,
    point: usize,
}

impl Eq for Arrival {}

impl PartialOrd for Arrival {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Arrival {
    fn cmp(&self, other: &Self) -> Ordering {
        self.time.total_cmp(&other.time).then(self.point.cmp(&other.point))
    }
}

/// Directions whose paths are stored at a point. A path in another direction is stored at its end.
const STORED: [Direction; 4] =
    [Direction::East, Direction::North, Direction::NorthEast, Direction::NorthWest];

impl<'a, R: Real> March<'a, R> {
    fn new(edges: &'a EdgeLengths<R>, step: usize, seeds: &[Seed]) -> Self {
        let chart = edges.chart();
        let first = seeds.first().map_or((0, 0), |seed| (seed.row % step, seed.col % step));
        let points = |length: usize, first: usize| (length - 1 - first) / step + 1;
        // A side may be shorter than the step.
        let first = (first.0.min(chart.rows - 1), first.1.min(chart.cols - 1));
        let coarse = Chart { rows: points(chart.rows, first.0), cols: points(chart.cols, first.1) };
        Self {
            edges,
            step,
            first,
            coarse,
            times: vec![f64::INFINITY; coarse.points()],
            fixed: vec![false; coarse.points()],
            ways: vec![[f64::NAN; 4]; coarse.points()],
            heap: BinaryHeap::new(),
            visits: 0,
        }
    }

    /// Marches until no front can reach the targets earlier, and returns the time by which the targets are reached.
    fn run(&mut self, seeds: &[Seed], targets: &Targets) -> f64 {
        for seed in seeds {
            for point in self.around([seed.row, seed.col]) {
                let time = seed.time + self.way(point, [seed.row, seed.col]);
                self.lower(point, time);
            }
        }
        let near: Vec<_> = targets
            .points()
            .iter()
            .map(|&target| {
                let ways = self.around(target).into_iter();
                let ways = ways.map(|point| (point, self.way(point, target)));
                let own = seeds.iter().filter(|seed| [seed.row, seed.col] == target);
                let own = own.map(|seed| seed.time).fold(f64::INFINITY, f64::min);
                (target, own, ways.collect::<Vec<_>>())
            })
            .collect();
        loop {
            let last = targets.last(|target| {
                let same = near.iter().find(|(other, ..)| *other == target);
                same.map_or(f64::INFINITY, |(_, own, ways)| {
                    ways.iter().map(|&(point, way)| self.times[point] + way).fold(*own, f64::min)
                })
            });
            // Several points are passed between two evaluations of `last`, which take long if there are many targets.
            for _ in 0..near.len().max(1) {
                let Some(Reverse(Arrival { time, point })) = self.heap.pop() else { return last };
                if time >= last {
                    return last;
                }
                if !std::mem::replace(&mut self.fixed[point], true) {
                    self.pass(point);
                }
            }
        }
    }

    /// Passes the front on from a point that has been fixed.
    fn pass(&mut self, point: usize) {
        self.visits += 1;
        let (row, col) = self.coarse.position(point);
        for to in Direction::ALL {
            let Some(x0) = self.coarse.neighbour(row, col, to) else { continue };
            let at = self.coarse.index(x0.0, x0.1);
            let l1 = self.length((row, col), to);
            if self.fixed[at] || !l1.is_finite() {
                continue;
            }
            let mut time = self.times[point] + l1;
            let back = to.opposite();
            for beside in [back.next(), back.previous()] {
                let Some(x2) = self.coarse.neighbour(x0.0, x0.1, beside) else { continue };
                let other = self.coarse.index(x2.0, x2.1);
                let base = Direction::ALL
                    .into_iter()
                    .find(|&base| self.coarse.neighbour(row, col, base) == Some(x2));
                let Some(base) = base.filter(|_| self.fixed[other]) else { continue };
                let (l2, c) = (self.length(x0, beside), self.length((row, col), base));
                if l2.is_finite() && c.is_finite() {
                    let (t1, t2) = (self.times[point], self.times[other]);
                    time = time.min(planar(Triangle { t1, t2, l1, l2, c }));
                }
            }
            self.lower(at, time);
        }
    }

    fn lower(&mut self, point: usize, time: f64) {
        if time < self.times[point] {
            self.times[point] = time;
            self.heap.push(Reverse(Arrival { time, point }));
        }
    }

    /// Returns the position on the grid of one of the points.
    fn place(&self, (row, col): (usize, usize)) -> (usize, usize) {
        (self.first.0 + row * self.step, self.first.1 + col * self.step)
    }

    /// Returns the points of the coarse chart around a point of the grid: one, two or four.
    fn around(&self, [row, col]: [usize; 2]) -> Vec<usize> {
        let span = |at: usize, first: usize, points: usize| {
            let low = (at.saturating_sub(first) / self.step).min(points - 1);
            let exact = first + low * self.step == at || at < first;
            low..(low + if exact { 1 } else { 2 }).min(points)
        };
        let cols = span(col, self.first.1, self.coarse.cols);
        span(row, self.first.0, self.coarse.rows)
            .flat_map(|row| cols.clone().map(move |col| (row, col)))
            .map(|(row, col)| self.coarse.index(row, col))
            .collect()
    }

    /// Returns the length of the path from one of the points to its neighbour.
    fn length(&mut self, (row, col): (usize, usize), to: Direction) -> f64 {
        let stored = STORED.iter().position(|&stored| stored == to);
        let Some(stored) = stored else {
            let Some(end) = self.coarse.neighbour(row, col, to) else { return f64::INFINITY };
            return self.length(end, to.opposite());
        };
        let point = self.coarse.index(row, col);
        if self.ways[point][stored].is_nan() {
            let (row, col) = self.place((row, col));
            self.ways[point][stored] = self.along((row, col), to, self.step);
        }
        self.ways[point][stored]
    }

    /// Returns the total length of `steps` successive edges in one direction, or +infinity if an edge is missing.
    fn along(&self, (row, col): (usize, usize), to: Direction, steps: usize) -> f64 {
        let chart = self.edges.chart();
        let (mut at, mut length) = ((row, col), 0.0);
        for _ in 0..steps {
            let edge = self.edges.length(at.0, at.1, to);
            let Some(next) = chart.neighbour(at.0, at.1, to).filter(|_| edge < R::FAR) else {
                return f64::INFINITY;
            };
            (at, length) = (next, length + edge.wide());
        }
        length
    }

    /// Returns the length of a path along the grid from one of the points to a point of the grid, or +infinity if a
    /// hole interrupts it.
    fn way(&self, point: usize, [row, col]: [usize; 2]) -> f64 {
        let (from_row, from_col) = self.place(self.coarse.position(point));
        let steps = [row.abs_diff(from_row), col.abs_diff(from_col)];
        let signs = [
            (row as isize - from_row as isize).signum(),
            (col as isize - from_col as isize).signum(),
        ];
        let toward = |step: [isize; 2]| {
            Direction::ALL.into_iter().find(|to| <[isize; 2]>::from(to.step()) == step)
        };
        let (diagonal, straight) = (steps[0].min(steps[1]), steps[0].abs_diff(steps[1]));
        let ahead = if steps[0] > steps[1] { [signs[0], 0] } else { [0, signs[1]] };
        let mut length = 0.0;
        if let Some(to) = toward(signs).filter(|_| diagonal > 0) {
            length += self.along((from_row, from_col), to, diagonal);
        }
        let by = |from: usize, sign: isize| from.wrapping_add_signed(sign * diagonal as isize);
        if let Some(to) = toward(ahead).filter(|_| straight > 0) {
            let turn = (by(from_row, signs[0]), by(from_col, signs[1]));
            length += self.along(turn, to, straight);
        }
        length
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rotated_scan;
    use geosweep_surface::builtin::Builtin;
    use geosweep_surface::{DEFAULT_TOLERANCE, Sources, Stop, Wavefront};

    /// Returns the ratio of the estimate to the distance for a target, and the number of visited points.
    fn estimate(builtin: Builtin, side: usize, from: [usize; 2], to: [usize; 2]) -> (f64, u64) {
        let surface = builtin.surface(side, side).unwrap();
        let edges = EdgeLengths::<f32>::new(&surface).unwrap();
        let sources = Sources::point(from[0] as f64, from[1] as f64);
        let seeds = sources.seeds(&surface).unwrap();
        let (time, visits) = estimate_targets(&edges, &seeds, &Targets::all([to]));
        let stop = Stop::settled(&surface, DEFAULT_TOLERANCE);
        let map = rotated_scan(&edges, &seeds, Wavefront::Curved, stop).distances();
        (time / f64::from(map[surface.chart().index(to[0], to[1])]), visits)
    }

    #[test]
    fn the_estimate_is_near_the_distance() {
        for builtin in [Builtin::Plane, Builtin::Sphere, Builtin::Peaks] {
            for to in [[150, 30], [120, 100], [199, 199]] {
                let (ratio, visits) = estimate(builtin, 200, [100, 91], to);
                // The coarse triangles are flat, and the last part of the path to a target follows edges, which
                // lengthens short paths most.
                assert!((0.97..1.1).contains(&ratio), "{builtin} {to:?}: {ratio}");
                assert!(visits <= 26 * 26, "{visits}");
            }
        }
    }

    #[test]
    fn narrow_passages_are_found_on_a_finer_grid() {
        let (ratio, _) = estimate(Builtin::Maze, 90, [0, 0], [89, 89]);
        assert!((0.97..1.2).contains(&ratio), "{ratio}");
    }
}

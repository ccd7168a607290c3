//! Algorithm 1: fast marching with a heap, the sequential reference.

use std::cmp::{Ordering, Reverse};
use std::collections::BinaryHeap;

use super::Connections;
use super::across::Quad;
use super::state::{Fronts, Solution};
use crate::surface::{Direction, EdgeLengths, EdgeSlot, Real, Seed};
use crate::update::{Triangle, Wavefront};

/// Solves by fast marching (Algorithm 1): points are fixed in the order in which the front
/// reaches them, and a point is updated from fixed points only.
///
/// With the planar wavefront and no obtuse triangle this is the raster scans' converged map; where
/// triangles are obtuse a point can be fixed too early, and the map is an upper bound of it; see
/// [`fast_marching_with`]. Circular and curved fronts that are fixed too early can err either way.
pub fn fast_marching<R: Real>(
    edges: &EdgeLengths<R>,
    seeds: &[Seed],
    wavefront: Wavefront,
) -> Solution<R> {
    fast_marching_with(edges, &Connections::eight(edges.chart()), seeds, wavefront)
}

/// [`fast_marching`] with connections to further neighbours, which mend the order in which points
/// are fixed where triangles are obtuse.
pub fn fast_marching_with<R: Real>(
    edges: &EdgeLengths<R>,
    connections: &Connections<R>,
    seeds: &[Seed],
    wavefront: Wavefront,
) -> Solution<R> {
    let chart = edges.chart();
    // For each direction from a fixed point to a neighbour: the edge, and the two triangles of
    // the neighbour that contain the fixed point.
    let spokes = Direction::ALL.map(|to| {
        let back = to.opposite();
        (
            chart.offset(to),
            EdgeSlot::new(chart, 0, to),
            [Quad::new(chart, back, back.next()), Quad::new(chart, back.previous(), back)],
        )
    });

    let mut fronts = Fronts::start(edges, seeds, wavefront);
    let mut fixed = vec![false; chart.bordered_points()];
    let mut heap: BinaryHeap<_> = seeds
        .iter()
        .map(|seed| chart.bordered(seed.row, seed.col))
        .map(|point| Reverse(Arrival { time: fronts.time(point), point }))
        .collect();
    while let Some(Reverse(Arrival { point, .. })) = heap.pop() {
        // A point stays in the heap under its earlier, larger times too.
        if std::mem::replace(&mut fixed[point], true) {
            continue;
        }
        for (offset, edge, triangles) in &spokes {
            let neighbour = point.wrapping_add_signed(*offset);
            if fixed[neighbour] || edges.at(point, *edge) >= R::FAR {
                continue;
            }
            for quad in triangles {
                let known = |point: usize| if fixed[point] { fronts.time(point) } else { R::FAR };
                let front = fronts.through_quad(neighbour, quad, known);
                if fronts.lower(neighbour, front) > R::Bits::default() {
                    heap.push(Reverse(Arrival { time: front.time, point: neighbour }));
                }
            }
        }
        for (x0, [x1, x2], lengths) in connections.around(point) {
            if fixed[x0] {
                continue;
            }
            let known = |point: usize| if fixed[point] { fronts.time(point) } else { R::FAR };
            let triangle = Triangle { t1: known(x1), t2: known(x2), ..lengths };
            let front = fronts.arrival(x0, [x1, x2], triangle, false);
            if fronts.lower(x0, front) > R::Bits::default() {
                heap.push(Reverse(Arrival { time: front.time, point: x0 }));
            }
        }
    }
    fronts.finish(1, 0.0)
}

/// A point of the front, ordered by arrival time; the index makes the order total.
#[derive(Clone, Copy, PartialEq)]
pub(super) struct Arrival<R> {
    pub time: R,
    pub point: usize,
}

impl<R: Real> Eq for Arrival<R> {}

impl<R: Real> PartialOrd for Arrival<R> {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl<R: Real> Ord for Arrival<R> {
    fn cmp(&self, other: &Self) -> Ordering {
        let by_time = self.time.partial_cmp(&other.time).expect("arrival times are never NaN");
        by_time.then(self.point.cmp(&other.point))
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec2;

    use super::*;
    use crate::accuracy::Errors;
    use crate::surface::builtin::{FlatPaths, FloorPlan};
    use crate::surface::{Spacing, Surface};
    use crate::{Sources, cpu};

    /// Square holes in the plane, where the shortest paths are polygons around their corners. The mean
    /// relative error of marching and of scans alike is 0.4 to 3.6e-5, nearly all of it where fronts from
    /// both sides of a hole meet; that of fronts with the mean of both arcs is ten times as large.
    #[test]
    fn arcs_are_exact_around_corners_but_where_fronts_meet() {
        let (rows, cols, side) = (97, 61, 8);
        let mut state = 7u64;
        let mut below = |most: usize| {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            (state >> 33) as usize % most
        };
        let mut ratios = Vec::new();
        for _ in 0..6 {
            let source = (rows / 2, cols / 2);
            let mut floor = vec![true; rows * cols];
            for _ in 0..9 {
                let (row, col) = (below(rows - side), below(cols - side));
                let near = |from: usize, at: usize| from <= at + 1 && at <= from + side;
                if near(row, source.0) && near(col, source.1) {
                    continue;
                }
                for row in row..row + side {
                    floor[row * cols + col..][..side].fill(false);
                }
            }
            let heights = vec![0.0; rows * cols];
            let plane = Surface::from_heights(rows, cols, heights, Spacing::square(1.0)).unwrap();
            let edges = EdgeLengths::<f64>::new(&plane.with_mask(&floor).unwrap()).unwrap();
            let seeds = [Seed::at_source(source.0, source.1, 0.0)];
            let plan = FloorPlan::new(rows, cols, floor, DVec2::ONE);
            let exact = FlatPaths::new(plan, [source.0 as f64, source.1 as f64]).distances();
            let error = |map: Solution<f64>| Errors::of(&map.distances(), &exact).mean_relative;
            let marched = error(fast_marching(&edges, &seeds, Wavefront::Arcs));
            let stop = cpu::Stop { tolerance: 1e-13, iterations: 1000 };
            let [scanned, mean] = [Wavefront::Arcs, Wavefront::Curved]
                .map(|wavefront| error(cpu::rotated_scan(&edges, &seeds, wavefront, stop)));
            println!("marching {marched:.1e}, scans {scanned:.1e}, mean of both arcs {mean:.1e}");
            assert!(marched < 5e-5, "{marched:e}");
            assert!(scanned < 5e-5, "{scanned:e}");
            ratios.push(marched / mean);
        }
        assert!(ratios.iter().sum::<f64>() < 0.1 * ratios.len() as f64, "{ratios:?}");
    }

    /// The maze has corners, and no two fronts meet in it: the map is exact to rounding. Far from corners,
    /// as they are in larger ones, two arcs are about the same and count as one.
    #[test]
    fn arcs_are_exact_in_the_maze() {
        use crate::surface::builtin::Builtin;
        for (points, bar) in [(65, 1e-12), (129, 1e-12), (257, 1e-7)] {
            let surface = Builtin::Maze.surface(points, points).unwrap();
            let exact = Builtin::Maze.exact_distances(points, points, [2.0, 3.0]).unwrap();
            let seeds = Sources::point(2.0, 3.0).seeds(&surface).unwrap();
            let edges = EdgeLengths::<f64>::new(&surface).unwrap();
            let map = fast_marching(&edges, &seeds, Wavefront::Arcs).distances();
            let single = EdgeLengths::<f32>::new(&surface).unwrap();
            let single = fast_marching(&single, &seeds, Wavefront::Arcs).distances();
            let errors = [Errors::of(&map, &exact), Errors::of(&single, &exact)];
            println!("{points}: {errors:?}");
            assert!(errors[0].max_relative < bar, "{points}: {:e}", errors[0].max_relative);
            // Some hundred steps, each rounded.
            assert!(errors[1].mean_relative < 1e-6, "{points}: {:e}", errors[1].mean_relative);
        }
    }
}

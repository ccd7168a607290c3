//! Algorithm 1: fast marching with a heap, the sequential reference.

use std::cmp::{Ordering, Reverse};
use std::collections::BinaryHeap;

use super::Connections;
use super::state::{Solution, TriangleSlots};
use crate::surface::{Direction, EdgeLengths, EdgeSlot, Real, Seed};
use crate::update::Wavefront;

/// Solves by fast marching (Algorithm 1): points are fixed in the order in which the front
/// reaches them, and a point is updated from fixed points only.
///
/// With the planar wavefront and no obtuse triangle this is the raster scans' converged map.
/// Where triangles are obtuse, or fronts circular, a point can be fixed too early, and the map
/// is an upper bound of the converged one; see [`fast_marching_with`].
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
            [
                TriangleSlots::new(chart, back, back.next()),
                TriangleSlots::new(chart, back.previous(), back),
            ],
        )
    });

    let mut solution = Solution::start(chart, seeds);
    let mut fixed = vec![false; chart.bordered_points()];
    let mut front: BinaryHeap<_> = seeds
        .iter()
        .map(|seed| chart.bordered(seed.row, seed.col))
        .map(|point| Reverse(Arrival { time: solution.times[point], point }))
        .collect();
    while let Some(Reverse(Arrival { point, .. })) = front.pop() {
        // A point stays in the heap under its earlier, larger times too.
        if std::mem::replace(&mut fixed[point], true) {
            continue;
        }
        for (offset, edge, triangles) in &spokes {
            let neighbour = point.wrapping_add_signed(*offset);
            if fixed[neighbour] || edges.at(point, *edge) >= R::FAR {
                continue;
            }
            let known = |point: usize| if fixed[point] { solution.times[point] } else { R::FAR };
            let time = triangles
                .map(|triangle| triangle.load(edges, neighbour, known).update(wavefront))
                .into_iter()
                .fold(R::FAR, R::min);
            if solution.lower(neighbour, time) > R::zero() {
                front.push(Reverse(Arrival { time, point: neighbour }));
            }
        }
        let known = |times: &[R], point: usize| if fixed[point] { times[point] } else { R::FAR };
        let arrivals: Vec<_> = connections
            .around(point, |point| known(&solution.times, point))
            .filter(|&(x0, _)| !fixed[x0])
            .map(|(x0, triangle)| Arrival { time: triangle.update(wavefront), point: x0 })
            .collect();
        for arrival in arrivals {
            if solution.lower(arrival.point, arrival.time) > R::zero() {
                front.push(Reverse(arrival));
            }
        }
    }
    solution.iterations = 1;
    solution.residual = 0.0;
    solution
}

/// A point of the front, ordered by arrival time; the index makes the order total.
#[derive(Clone, Copy, PartialEq)]
struct Arrival<R> {
    time: R,
    point: usize,
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

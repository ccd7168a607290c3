//! Algorithm 1: fast marching with a heap, the sequential reference.

use std::cmp::{Ordering, Reverse};
use std::collections::BinaryHeap;

use super::Connections;
use super::anchored::march_by_anchors;
use super::state::{Fronts, Solution, TriangleSlots};
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
/// are fixed where triangles are obtuse. Of no account for the anchored wavefront, whose triangles are not.
pub fn fast_marching_with<R: Real>(
    edges: &EdgeLengths<R>,
    connections: &Connections<R>,
    seeds: &[Seed],
    wavefront: Wavefront,
) -> Solution<R> {
    if wavefront.over(edges) == Wavefront::Anchored {
        return march_by_anchors(edges, seeds);
    }
    let chart = edges.chart();
    // For each direction from a fixed point to a neighbour: the edge, and the two triangles of
    // the neighbour that contain the fixed point.
    let spokes = Direction::ALL.map(|to| {
        let back = to.opposite();
        (
            chart.offset(to),
            EdgeSlot::new(chart, 0, to),
            [(back, back.next()), (back.previous(), back)]
                .map(|(first, second)| TriangleSlots::new(chart, first, second)),
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
            for slots in triangles {
                let known = |point: usize| if fixed[point] { fronts.time(point) } else { R::FAR };
                let front = fronts.through_known(neighbour, slots, known);
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

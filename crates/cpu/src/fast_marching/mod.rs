//! Solves by fast marching with a heap (Algorithm 1), the sequential reference.

mod connections;

pub use connections::Connections;

use std::cmp::{Ordering, Reverse};
use std::collections::{BinaryHeap, HashSet};

use super::behind::Behind;
use super::fronts::{Anchored, FrontOver, Fronts, PointKind, TriangleFronts, TriangleKind};
use super::limit::Limit;
use super::points::PointFronts;
use super::solution::Solution;
use geosweep_surface::update::{StoredFront, Triangle, Wavefront};
use geosweep_surface::{Chart, Direction, EdgeLengths, EdgeSlot, Offset, Real, Seed};

/// Solves by fast marching (Algorithm 1). Points are fixed in the order in which the front reaches them. A
/// point is updated from fixed points only.
///
/// With the planar wavefront and no obtuse triangle, the result is the converged map of the raster scans.
/// Where triangles are obtuse, a point can be fixed too early, and the map is an upper bound of the converged
/// one; see [`fast_marching_with`]. Circular and curved fronts that are fixed too early can err either way.
pub fn fast_marching<R: Real>(
    edges: &EdgeLengths<R>,
    seeds: &[Seed],
    wavefront: Wavefront,
) -> Solution<R> {
    fast_marching_with(edges, &Connections::eight(edges.chart()), seeds, wavefront)
}

/// Runs [`fast_marching`] with connections to farther neighbours. They correct the order in which points are
/// fixed where triangles are obtuse. The anchored wavefront does not use them, since its triangles are not
/// obtuse.
pub fn fast_marching_with<R: Real>(
    edges: &EdgeLengths<R>,
    connections: &Connections<R>,
    seeds: &[Seed],
    wavefront: Wavefront,
) -> Solution<R> {
    limited_march(edges, connections, seeds, wavefront, Limit::NONE)
}

/// Runs [`fast_marching_with`] up to a limit. Later times are provisional.
pub fn limited_march<R: Real>(
    edges: &EdgeLengths<R>,
    connections: &Connections<R>,
    seeds: &[Seed],
    wavefront: Wavefront,
    limit: Limit,
) -> Solution<R> {
    match FrontOver::new(edges, wavefront) {
        FrontOver::Planar(kind) => by_triangles(edges, connections, seeds, kind, limit),
        FrontOver::Circular(kind) => by_triangles(edges, connections, seeds, kind, limit),
        FrontOver::Curved(kind) => by_triangles(edges, connections, seeds, kind, limit),
        FrontOver::Rays(kind) => by_triangles(edges, connections, seeds, kind, limit),
        FrontOver::SlowedPlanar(kind) => by_triangles(edges, connections, seeds, kind, limit),
        FrontOver::SlowedCurved(kind) => by_triangles(edges, connections, seeds, kind, limit),
        FrontOver::Anchored(kind) => by_anchors(edges, seeds, kind, limit),
    }
}

/// Returns, for each neighbour of a fixed point, the offset to the neighbour, the edge to it, and the neighbour's two
/// triangles that have the fixed point as a corner.
fn neighbours(chart: Chart) -> [(Offset, EdgeSlot, Behind); 8] {
    Direction::ALL.map(|to| {
        let back = to.opposite();
        let behind = Behind::new(chart, [back.previous(), back, back.next()]);
        (chart.offset(to), EdgeSlot::of(chart, to), behind)
    })
}

fn by_triangles<R: Real, K: TriangleKind<R>>(
    edges: &EdgeLengths<R>,
    connections: &Connections<R>,
    seeds: &[Seed],
    kind: K,
    limit: Limit,
) -> Solution<R> {
    let neighbours = neighbours(edges.chart());
    let mut march = March::start(PointFronts::start(edges, kind, seeds), seeds, limit);
    while let Some(point) = march.next() {
        // Copies are neighbours at distance 0.
        let copies = edges.copies().and_then(|groups| groups.around(point)).into_iter().flatten();
        for &x0 in copies.filter(|&&x0| x0 as usize != point) {
            let arrival = K::Carried::arrival_of_front(march.known(point));
            march.lower(x0 as usize, arrival, K::Carried::time(arrival));
        }
        for (offset, edge, behind) in &neighbours {
            let x0 = offset.from(point);
            if march.is_fixed(x0) || edges.at(point, *edge) >= R::FAR {
                continue;
            }
            let [before, after] = behind.triangles();
            for slots in [after, before] {
                let fronts = &march.fronts;
                let arrival = fronts.kind.through(edges, x0, slots, |x| march.known(x));
                march.lower(x0, arrival, K::Carried::time(arrival));
            }
        }
        for (x0, [x1, x2], lengths, slowness) in connections.around(point) {
            if march.is_fixed(x0) {
                continue;
            }
            let [a, b] = [x1, x2].map(|x| march.known(x));
            let triangle = Triangle { t1: a.time, t2: b.time, ..lengths };
            let carried = [a.carried, b.carried];
            let kind = &march.fronts.kind;
            let arrival = kind.arrival_over([x0, x1, x2], triangle, carried, [slowness; 3]);
            march.lower(x0, arrival, K::Carried::time(arrival));
        }
    }
    march.fronts.finish(1, 0.0)
}

/// Solves a floor plan exactly: each fixed point is reached on its shortest path and passes its anchor on to its
/// neighbours. See `update/anchored.rs`.
fn by_anchors<R: Real>(
    edges: &EdgeLengths<R>,
    seeds: &[Seed],
    kind: Anchored<R>,
    limit: Limit,
) -> Solution<R> {
    let neighbours = neighbours(edges.chart());
    let mut march = March::start(PointFronts::start(edges, kind, seeds), seeds, limit);
    while let Some(point) = march.next() {
        for (offset, edge, behind) in &neighbours {
            let x0 = offset.from(point);
            if march.is_fixed(x0) || edges.at(point, *edge) >= R::FAR {
                continue;
            }
            let arrival = march.fronts.reach_seen(x0, behind, |x| march.known(x));
            march.lower(x0, arrival, arrival.time);
        }
    }
    march.fronts.finish(1, 0.0)
}

/// State of a march: the fronts, flags of the fixed points, and a heap of the points that may be fixed next.
struct March<R: Real, K: PointKind<R>> {
    fronts: PointFronts<R, K>,
    fixed: Vec<bool>,
    heap: BinaryHeap<Reverse<Arrival<R>>>,
    limit: Limit,
    /// The targets of the limit, as indices of the bordered array.
    targets: HashSet<usize>,
}

impl<R: Real, K: PointKind<R>> March<R, K> {
    fn start(fronts: PointFronts<R, K>, seeds: &[Seed], limit: Limit) -> Self {
        let chart = fronts.edges.chart();
        let heap = seeds
            .iter()
            .map(|seed| chart.bordered(seed.row, seed.col))
            .map(|point| Reverse(Arrival { time: fronts.time(point), point }))
            .collect();
        let targets = limit.targets().iter().map(|&[row, col]| chart.bordered(row, col)).collect();
        Self { fronts, fixed: vec![false; chart.bordered_points()], heap, limit, targets }
    }

    /// Fixes the earliest point that is not fixed yet, and returns it. Returns `None` after the last one, and
    /// at the limit.
    fn next(&mut self) -> Option<usize> {
        loop {
            let Reverse(Arrival { point, time }) = self.heap.pop()?;
            if time.wide() > self.limit.time() {
                return None;
            }
            // A point also stays in the heap with its previous, larger times.
            if !std::mem::replace(&mut self.fixed[point], true) {
                if self.targets.contains(&point) {
                    let chart = self.fronts.edges.chart();
                    let (fixed, fronts) = (&self.fixed, &self.fronts);
                    self.limit.lower(|[row, col]| {
                        let target = chart.bordered(row, col);
                        if fixed[target] { fronts.time(target).wide() } else { f64::INFINITY }
                    });
                }
                return Some(point);
            }
        }
    }

    fn is_fixed(&self, point: usize) -> bool {
        self.fixed[point]
    }

    /// Returns the front at a fixed point, or an unreached front if the point is not fixed.
    fn known(&self, point: usize) -> StoredFront<R, K::Carried> {
        let front = self.fronts.at(point);
        StoredFront { time: if self.fixed[point] { front.time } else { R::FAR }, ..front }
    }

    /// Offers a front that arrives at `time` to a point.
    fn lower(&mut self, point: usize, arrival: K::Arrival, time: R) {
        if self.fronts.lower(point, arrival) > R::Bits::default() {
            self.heap.push(Reverse(Arrival { time, point }));
        }
    }
}

/// A point of the front, ordered by arrival time. The index makes the order total.
#[derive(Clone, Copy, PartialEq)]
pub(super) struct Arrival<R> {
    pub(super) time: R,
    pub(super) point: usize,
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

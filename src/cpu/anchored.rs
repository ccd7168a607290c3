//! Fast marching over floor plans, exact by anchors: see `update/anchored.rs`.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use super::fast_marching::Arrival;
use super::state::{Behind, Fronts, Solution};
use crate::surface::{Direction, EdgeLengths, EdgeSlot, Real, Seed};
use crate::update::Wavefront;

/// Solves over the edges of a floor plan: what is fixed has been reached on its shortest way, and has told its
/// neighbours of its anchor.
pub(super) fn march_by_anchors<R: Real>(edges: &EdgeLengths<R>, seeds: &[Seed]) -> Solution<R> {
    let chart = edges.chart();
    let spokes = Direction::ALL.map(|to| {
        let back = to.opposite();
        let behind = Behind::new(chart, [back.previous(), back, back.next()]);
        (chart.offset(to), EdgeSlot::new(chart, 0, to), behind)
    });
    let mut fronts = Fronts::start(edges, seeds, Wavefront::Anchored);
    let mut fixed = vec![false; chart.bordered_points()];
    let arrival = |fronts: &Fronts<R>, point| Reverse(Arrival { time: fronts.time(point), point });
    let mut heap: BinaryHeap<_> =
        seeds.iter().map(|seed| arrival(&fronts, chart.bordered(seed.row, seed.col))).collect();
    while let Some(Reverse(Arrival { point, .. })) = heap.pop() {
        // A point stays in the heap under its earlier, larger times too.
        if std::mem::replace(&mut fixed[point], true) {
            continue;
        }
        for (offset, edge, behind) in &spokes {
            let x0 = point.wrapping_add_signed(*offset);
            if fixed[x0] || edges.at(point, *edge) >= R::FAR {
                continue;
            }
            let known = |x| if fixed[x] { fronts.at(x) } else { [R::FAR, R::zero()] };
            let front = fronts.through_seen(x0, behind, known);
            if fronts.lower(x0, front) > R::Bits::default() {
                heap.push(arrival(&fronts, x0));
            }
        }
    }
    fronts.finish(1, 0.0)
}

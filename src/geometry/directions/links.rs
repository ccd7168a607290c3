//! Finds the next grid point on the way back from each grid point.
//!
//! A link leads to an earlier neighbour, so that no walk runs in a circle. Among the earlier neighbours it is
//! the one in whose direction the shortest path leaves the point. A point without an earlier neighbour is the
//! end of a walk if a source is beside it. Others are minima by rounding, such as the points of a pole, which
//! coincide. Walks leave them over their lowest rim, as water leaves a lake (priority-flood: Barnes, Lehman
//! and Mulla, "Priority-flood: An optimal depression-filling and watershed-labeling algorithm for digital
//! elevation models", Computers & Geosciences 62, 2014).

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use glam::DVec2;
use rayon::prelude::*;

use super::frame::Frame;
use super::ways::Way;
use crate::geometry::order::rank;
use crate::surface::{Direction, Surface};

/// The back link of a point that no source reaches.
pub const NO_LINK: i8 = -1;

/// The directions of the codes 1 to 8: clockwise from east.
const CODES: [Direction; 8] = [
    Direction::East,
    Direction::SouthEast,
    Direction::South,
    Direction::SouthWest,
    Direction::West,
    Direction::NorthWest,
    Direction::North,
    Direction::NorthEast,
];

/// Returns the links, row-major. `times` is a bordered array of arrival times; `is_beside_source` tells
/// whether a source touches a cell of the point with an index in that array.
pub(super) fn links(
    surface: &Surface,
    times: &[f32],
    ways: &[Way],
    is_beside_source: impl Fn(usize) -> bool + Sync,
) -> Vec<i8> {
    let chart = surface.chart();
    let link = |index: usize| -> Option<i8> {
        let (row, col) = chart.position(index);
        let point = chart.bordered(row, col);
        let (step, to_source) = match ways[index] {
            Way::Unreached => return Some(NO_LINK),
            Way::AtSource if is_beside_source(point) => return Some(0),
            Way::AtSource => (DVec2::ZERO, false),
            Way::Along { step, to_source } => (step.as_dvec2(), to_source),
        };
        let frame = Frame::at_point(surface, row, col);
        let alike = |to: &usize| {
            let cosine = frame.cosine(step, CODES[*to].vector());
            if cosine.is_nan() { -1.0 } else { cosine }
        };
        let is_earlier = |to: &usize| {
            let there = times[chart.beside(point, CODES[*to])];
            there < times[point] && surface.has_edge(row, col, CODES[*to])
        };
        let next = (0..8).filter(is_earlier).max_by(|a, b| alike(a).total_cmp(&alike(b)));
        // The source lies less than half-way to that neighbour: this point stands for the source.
        let is_end =
            |to: usize| to_source && frame.length(step) <= 0.5 * frame.length(CODES[to].vector());
        match next {
            Some(to) if is_end(to) => Some(0),
            Some(to) => Some(to as i8 + 1),
            None => is_beside_source(point).then_some(0),
        }
    };
    let found: Vec<Option<i8>> = (0..chart.points()).into_par_iter().map(link).collect();
    if let Some(all) = found.iter().copied().collect() {
        all
    } else {
        flooded(surface, times, found)
    }
}

/// Links the points without a link, and those whose walks end at them, to points from which walks arrive.
fn flooded(surface: &Surface, times: &[f32], mut links: Vec<Option<i8>>) -> Vec<i8> {
    let chart = surface.chart();
    let next = |index: usize, link: i8| {
        let (row, col) = chart.position(index);
        let (row, col) = chart.neighbour(row, col, CODES[link as usize - 1])?;
        Some(chart.index(row, col))
    };
    // Walks descend, so a point's successor is visited before it in the order of arrival.
    let time = |index: usize| {
        let (row, col) = chart.position(index);
        times[chart.bordered(row, col)]
    };
    let mut order: Vec<usize> = (0..links.len()).filter(|&at| links[at] != Some(NO_LINK)).collect();
    order.par_sort_by(|&a, &b| time(a).total_cmp(&time(b)));
    let mut arrives = vec![false; links.len()];
    for &index in &order {
        arrives[index] = match links[index] {
            Some(0) => true,
            Some(link) => next(index, link).is_some_and(|next| arrives[next]),
            None => false,
        };
    }
    let entry = |index: usize| Reverse((rank(time(index), 0), index));
    let mut open: BinaryHeap<_> =
        order.iter().filter(|&&index| arrives[index]).map(|&index| entry(index)).collect();
    while let Some(Reverse((_, index))) = open.pop() {
        let (row, col) = chart.position(index);
        for (code, to) in CODES.into_iter().enumerate() {
            let Some((r, c)) = chart.neighbour(row, col, to) else { continue };
            let there = chart.index(r, c);
            let is_lost = !arrives[there] && links[there] != Some(NO_LINK);
            if is_lost && surface.has_edge(row, col, to) {
                arrives[there] = true;
                links[there] = Some(((code + 4) % 8) as i8 + 1);
                open.push(entry(there));
            }
        }
    }
    // A point that the map reaches and the links do not belongs to another map's sources.
    links.into_iter().map(|link| link.unwrap_or(NO_LINK)).collect()
}

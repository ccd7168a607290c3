//! Finds the next grid point on the walk from each grid point back to its source.
//!
//! A link leads to an earlier neighbour, so that no walk runs in a circle. Of the earlier neighbours, it is the one
//! closest to the direction in which the shortest path leaves the point. A point without an earlier neighbour is the
//! end of a walk if a source is beside it. Other points without an earlier neighbour are minima by rounding, such as
//! the points of a pole, which coincide. Walks leave such minima over their lowest rim, as water leaves a lake
//! (priority-flood: Barnes, Lehman and Mulla, "Priority-flood: An optimal depression-filling and watershed-labeling
//! algorithm for digital elevation models", Computers & Geosciences 62, 2014).

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use glam::DVec2;
use rayon::prelude::*;

use super::frame::Frame;
use super::ways::Way;
use crate::copies::Copies;
use crate::order::rank;
use geosweep_surface::{Direction, Surface};

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

/// The points and edges along which links lead.
pub(super) struct Links<'a> {
    pub surface: &'a Surface,
    pub copies: &'a Copies,
    /// The arrival times, a bordered array.
    pub times: &'a [f32],
}

/// A neighbour to which a link may lead.
struct Next {
    link: i8,
    /// The cosine of the angle between the back direction and the edge to the neighbour.
    alike: f64,
    /// Whether the path leads to a source that is at most half as far as the neighbour. The point then stands for the
    /// source.
    is_end: bool,
}

impl Links<'_> {
    /// Returns the links, row-major. Copies of a point have one link, which leads from the copy that has the chosen
    /// neighbour. `is_beside_source` tells whether a source touches a cell of the point with an index in a bordered
    /// array.
    pub(super) fn find(
        &self,
        ways: &[Way],
        is_beside_source: impl Fn(usize) -> bool + Sync,
    ) -> Vec<i8> {
        let link = |index: usize| -> Option<i8> {
            let point = self.point(index);
            let is_beside_source = || self.copies.all(point).any(&is_beside_source);
            match ways[index] {
                Way::Unreached => return Some(NO_LINK),
                Way::AtSource if is_beside_source() => return Some(0),
                _ if self.copies.first(point) != point => return Some(NO_LINK),
                _ => {}
            }
            let all = self.copies.all(point).flat_map(|copy| self.earlier(copy, ways));
            match all.max_by(|a, b| a.alike.total_cmp(&b.alike)) {
                Some(next) if next.is_end => Some(0),
                Some(next) => Some(next.link),
                None => is_beside_source().then_some(0),
            }
        };
        let points = 0..self.surface.chart().points();
        let found: Vec<Option<i8>> = points.into_par_iter().map(link).collect();
        let all: Option<Vec<i8>> = found.iter().copied().collect();
        let mut links = all.unwrap_or_else(|| self.flooded(found));
        for group in self.copies.groups() {
            let link = links[self.index(group[0] as usize)];
            group.iter().for_each(|&copy| links[self.index(copy as usize)] = link);
        }
        links
    }

    /// Returns the earlier neighbours of a point.
    fn earlier(&self, point: usize, ways: &[Way]) -> impl Iterator<Item = Next> {
        let (row, col) = self.surface.chart().bordered_position(point);
        let (step, to_source) = match ways[self.index(point)] {
            Way::Along { step, to_source } => (step.as_dvec2(), to_source),
            _ => (DVec2::ZERO, false),
        };
        let frame = Frame::at_point(self.surface, row, col);
        (1..).zip(CODES).filter_map(move |(link, to)| {
            let there = self.times[self.surface.chart().beside(point, to)];
            if there >= self.times[point] || !self.surface.has_edge(row, col, to) {
                return None;
            }
            let cosine = frame.cosine(step, to.vector());
            let alike = if cosine.is_nan() { -1.0 } else { cosine };
            let is_end = to_source && frame.length(step) <= 0.5 * frame.length(to.vector());
            Some(Next { link, alike, is_end })
        })
    }

    /// Returns the indices of the points that the walk from a point along `links` visits. Where the walk passes a seam,
    /// it lists two copies of a point in succession.
    pub(super) fn walk(&self, links: &[i8], from: usize) -> Vec<usize> {
        let mut way = vec![from];
        let mut at = from;
        while let Some([copy, next]) = self.next(at, links[at]).filter(|_| way.len() <= links.len())
        {
            way.extend([copy, next].into_iter().filter(|&point| point != at));
            at = next;
        }
        way
    }

    /// Returns the index of the copy of a point from which a link leads, and the index of the neighbour to which it
    /// leads. This is the earliest neighbour that any copy has in the direction of the link.
    fn next(&self, index: usize, link: i8) -> Option<[usize; 2]> {
        let to = *CODES.get(usize::try_from(link).ok()?.checked_sub(1)?)?;
        let beside = |copy: usize| {
            let chart = self.surface.chart();
            let (row, col) = chart.bordered_position(copy);
            let is_edge = self.surface.has_edge(row, col, to);
            is_edge.then(|| [copy, chart.beside(copy, to)])
        };
        let all = self.copies.all(self.point(index)).filter_map(beside);
        let first = all.min_by(|a, b| self.times[a[1]].total_cmp(&self.times[b[1]]))?;
        Some(first.map(|point| self.index(point)))
    }

    fn point(&self, index: usize) -> usize {
        self.surface.chart().bordered_point(index)
    }

    /// Returns the row-major index of a point.
    fn index(&self, point: usize) -> usize {
        self.surface.chart().index_of(point)
    }

    /// Links the points without a link, and the points whose walks end at such points, to points from which walks
    /// arrive at a source. Of the copies of a point only the first is linked.
    fn flooded(&self, mut links: Vec<Option<i8>>) -> Vec<i8> {
        let own = |index: usize| self.index(self.copies.first(self.point(index)));
        // Walks descend, so in the order of arrival a point's successor is visited before the point.
        let time = |index: usize| self.times[self.point(index)];
        let is_linked = |&at: &usize| links[at] != Some(NO_LINK) && own(at) == at;
        let mut order: Vec<usize> = (0..links.len()).filter(is_linked).collect();
        order.par_sort_by(|&a, &b| time(a).total_cmp(&time(b)));
        let mut arrives = vec![false; links.len()];
        for &index in &order {
            arrives[index] = match links[index] {
                Some(0) => true,
                Some(link) => self.next(index, link).is_some_and(|[_, next]| arrives[own(next)]),
                None => false,
            };
        }
        let entry = |index: usize| Reverse((rank(time(index), 0), index));
        let mut open: BinaryHeap<_> =
            order.iter().filter(|&&index| arrives[index]).map(|&index| entry(index)).collect();
        while let Some(Reverse((_, index))) = open.pop() {
            for (copy, code) in self
                .copies
                .all(self.point(index))
                .flat_map(|copy| (0..8).map(move |code| (copy, code)))
            {
                let (row, col) = self.surface.chart().bordered_position(copy);
                if !self.surface.has_edge(row, col, CODES[code]) {
                    continue;
                }
                let there = own(self.index(self.surface.chart().beside(copy, CODES[code])));
                let back = ((code + 4) % 8) as i8 + 1;
                let is_lost = !arrives[there] && links[there] != Some(NO_LINK);
                // Followed from another copy, the link may lead to another point.
                if is_lost && self.next(there, back).is_some_and(|[_, next]| own(next) == index) {
                    arrives[there] = true;
                    links[there] = Some(back);
                    open.push(entry(there));
                }
            }
        }
        // If the map reaches a point from which no walk arrives at a source, the map has other sources.
        links.into_iter().map(|link| link.unwrap_or(NO_LINK)).collect()
    }
}

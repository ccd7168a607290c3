//! Leads paths over the seams of closed surfaces.
//!
//! A path that reaches a side of the grid at a seam goes on from a copy of its place. The copy is a vertex of
//! its own: both vertices are the same place on the surface, at different rows and columns.

use glam::DVec2;

use super::place::Place;
use crate::copies::Copies;
use geosweep_surface::{Chart, Direction, Surface};

/// The difference, in cells, up to which two lengths count as equal.
const ON_LINE: f64 = 1e-9;

impl Copies {
    /// Returns the other places that are the same place of the surface.
    pub(super) fn others(&self, chart: Chart, place: Place) -> Vec<Place> {
        match place {
            Place::Point(point) => {
                self.copies(point).filter(|&copy| copy != point).map(Place::Point).collect()
            }
            Place::Edge { first, along, share } => {
                let ends = [first, chart.beside(first, along)];
                self.edges(chart, ends)
                    .filter(|copy| *copy != ends)
                    .filter_map(|copy| place_between(chart, copy, share))
                    .collect()
            }
            Place::Inside { .. } => Vec::new(),
        }
    }

    /// Returns the edges between copies of the ends of an edge, including the edge itself.
    fn edges(&self, chart: Chart, [first, last]: [usize; 2]) -> impl Iterator<Item = [usize; 2]> {
        let is_edge = move |ends: &[usize; 2]| direction(chart, *ends).is_some();
        // The point in the middle of a folded side has no copies, and stands for itself.
        let lasts = self.all(last);
        self.all(first)
            .flat_map(move |first| lasts.clone().map(move |last| [first, last]))
            .filter(is_edge)
    }
}

/// Returns the direction, along a row or a column, from a point to the next one.
fn direction(chart: Chart, [from, to]: [usize; 2]) -> Option<Direction> {
    let ways = [Direction::East, Direction::South, Direction::West, Direction::North];
    ways.into_iter().find(|&way| chart.beside(from, way) == to)
}

/// Returns the place at the fraction `share` between two neighbours.
fn place_between(chart: Chart, [from, to]: [usize; 2], share: f64) -> Option<Place> {
    match direction(chart, [from, to])? {
        along @ (Direction::East | Direction::South) => {
            Some(Place::Edge { first: from, along, share })
        }
        Direction::West => {
            Some(Place::Edge { first: to, along: Direction::East, share: 1.0 - share })
        }
        _ => Some(Place::Edge { first: to, along: Direction::South, share: 1.0 - share }),
    }
}

/// A segment in one cell, and the part of a source that it represents.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct SourcePart {
    /// The rows and columns of both ends in the cell.
    pub ends: [DVec2; 2],
    /// The rows and columns of both ends on the source that the caller gave. They differ from `ends` if the segment is
    /// a copy.
    pub own: [DVec2; 2],
}

/// Returns a segment of a source and its copies. A segment along a seam has copies between the copies of its
/// ends. Each copy of an end on a seam is also returned, as a segment of length zero.
pub(super) fn parts_of_source(surface: &Surface, own: [DVec2; 2]) -> Vec<SourcePart> {
    let mut parts = vec![SourcePart { ends: own, own }];
    if !surface.is_glued() {
        return parts;
    }
    let copies = own.map(|end| surface.copies_of(end));
    for &first in &copies[0] {
        let whole = copies[1].iter().map(|&last| [first, last]);
        parts
            .extend(whole.filter(|ends| is_alike(ends, &own)).map(|ends| SourcePart { ends, own }));
    }
    for (end, copies) in own.into_iter().zip(&copies) {
        let others = copies.iter().filter(|&&copy| copy != end);
        parts.extend(others.map(|&copy| SourcePart { ends: [copy; 2], own: [end; 2] }));
    }
    parts
}

/// Returns whether two segments run along rows or columns and are equally long.
fn is_alike(a: &[DVec2; 2], b: &[DVec2; 2]) -> bool {
    let [a, b] = [a, b].map(|[first, last]| (*last - *first).abs());
    let is_straight = a.min_element() == 0.0 && b.min_element() == 0.0;
    is_straight && (a.max_element() - b.max_element()).abs() < ON_LINE
}

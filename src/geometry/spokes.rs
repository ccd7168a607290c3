//! The neighbours of a point and the triangles between them, in bordered arrays.

use crate::surface::{Chart, Direction, EdgeLengths, EdgeSlot, Real};

/// Towards one neighbour: where it lies, and the lengths of the edge to it and of the one from it
/// to the next neighbour.
#[derive(Clone, Copy, Debug)]
struct Spoke {
    offset: isize,
    edge: EdgeSlot,
    base: EdgeSlot,
}

/// The eight neighbours of a point, in the order of [`Direction::ALL`].
#[derive(Clone, Debug)]
pub(super) struct Spokes<'a> {
    edges: &'a EdgeLengths<f32>,
    spokes: [Spoke; 8],
}

impl<'a> Spokes<'a> {
    pub(super) fn new(edges: &'a EdgeLengths<f32>) -> Self {
        let chart = edges.chart();
        let spokes = Direction::ALL.map(|to| {
            let offset = chart.offset(to);
            let base = EdgeSlot::new(chart, offset, to.base());
            Spoke { offset, edge: EdgeSlot::new(chart, 0, to), base }
        });
        Self { edges, spokes }
    }

    pub(super) fn chart(&self) -> Chart {
        self.edges.chart()
    }

    /// The index of a neighbour.
    #[inline]
    pub(super) fn neighbour(&self, point: usize, to: usize) -> usize {
        point.wrapping_add_signed(self.spokes[to].offset)
    }

    /// Length of the edge to a neighbour, [`Real::FAR`] if there is none.
    #[inline]
    pub(super) fn length(&self, point: usize, to: usize) -> f64 {
        wide(self.edges.at(point, self.spokes[to].edge))
    }

    /// Length of the edge from a neighbour to the next.
    #[inline]
    pub(super) fn base(&self, point: usize, to: usize) -> f64 {
        wide(self.edges.at(point, self.spokes[to].base))
    }

    /// Length of the longest edge of a point.
    pub(super) fn longest(&self, point: usize) -> f64 {
        let lengths = (0..8).map(|to| self.length(point, to));
        lengths.filter(|&length| length < f64::FAR).fold(0.0, f64::max)
    }
}

/// A length in double precision, in which "no such edge" is another number.
fn wide(length: f32) -> f64 {
    if length < f32::FAR { f64::from(length) } else { f64::FAR }
}

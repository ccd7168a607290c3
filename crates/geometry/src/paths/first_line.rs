//! Finds the first line of the path from a grid point.

use glam::DVec2;

use super::PathTracer;
use super::place::Place;
use super::search::End;

/// The first straight line of a path, across one of the cells beside its start.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct FirstLine {
    /// The point where the line starts. If the point has copies, it is the copy that is a corner of the cell that the
    /// line crosses.
    pub from: usize,
    /// The row and column of the end.
    pub to: DVec2,
    pub end: LineEnd,
}

/// The place at which a line ends. Points are given by their indices in bordered arrays.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum LineEnd {
    /// The source of this index.
    Source(usize),
    Point(usize),
    /// A place on the edge between two points.
    Edge([usize; 2]),
}

impl PathTracer<'_> {
    /// Returns the first line of the path from a point of the bordered array that the map reaches. `zero_time`
    /// is the time that is subtracted before times are squared. Returns `None` if no line descends.
    pub(crate) fn first_line(&self, point: usize, zero_time: f64) -> Option<FirstLine> {
        let tracer = &self.tracer;
        let chart = tracer.chart();
        let line = tracer.line(zero_time, Place::Point(point), tracer.time(point), usize::MAX)?;
        let (to, end) = match line.end {
            End::Source { source, at, .. } => (at, LineEnd::Source(source)),
            End::Place(place @ Place::Point(end)) => (place.at(chart), LineEnd::Point(end)),
            End::Place(place @ Place::Edge { first, along, .. }) => {
                (place.at(chart), LineEnd::Edge([first, chart.beside(first, along)]))
            }
            End::Place(Place::Inside { .. }) => unreachable!("lines end on the sides of cells"),
        };
        let from = match line.copy {
            Some(Place::Point(copy)) => copy,
            _ => point,
        };
        Some(FirstLine { from, to, end })
    }

    /// Returns the first edge of a path along edges to an earlier point. The path starts at a point from which no line
    /// descends, and the edge starts at that point or at one of its copies. Returns `None` if there is no such path.
    pub(crate) fn first_of_detour(&self, point: usize) -> Option<[usize; 2]> {
        let detour = self.tracer.detour(point, self.tracer.time(point))?;
        let is_jump =
            |ends: &&[usize]| self.tracer.seams.copies(ends[0]).any(|copy| copy == ends[1]);
        detour.windows(2).find(|ends| !is_jump(ends)).map(|ends| [ends[0], ends[1]])
    }

    /// Returns whether a point of the bordered array is the corner of a hole.
    pub(crate) fn is_corner(&self, point: usize) -> bool {
        self.tracer.corners.is_corner(point)
    }

    /// Returns whether a source touches one of the cells beside a point of the bordered array.
    pub(crate) fn is_beside_source(&self, point: usize) -> bool {
        let (cells, count) = Place::Point(point).cells(self.tracer.chart());
        cells[..count].iter().any(|&(north_west, _)| self.tracer.goals.touches(north_west))
    }
}

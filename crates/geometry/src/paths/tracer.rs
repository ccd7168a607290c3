//! Holds the data through which paths are traced: a map, the lengths of edges, and the places where paths
//! bend and end.

use glam::DVec2;

use super::cell::{CellLengths, NO_EDGE, corner_alone};
use super::corners::Corners;
use super::goals::Goals;
use super::linked_path::SharedParts;
use super::place::Place;
use crate::copies::Copies;
use geosweep_surface::{Chart, Direction, EdgeLengths, EdgeSlot, corner_weights};

/// A map prepared for tracing.
#[derive(Clone, Debug)]
pub(super) struct Tracer<'a> {
    pub edges: &'a EdgeLengths<f32>,
    /// The arrival times in a bordered array, infinite where no wavefront arrives.
    pub times: Vec<f32>,
    /// The smallest initial value of the sources.
    pub start: f64,
    pub goals: Goals,
    pub corners: Corners,
    /// Whether paths are shortened beyond what the map alone gives.
    pub shortens: bool,
    pub shared_parts: SharedParts,
    pub seams: Copies,
}

impl Tracer<'_> {
    pub(super) fn chart(&self) -> Chart {
        self.edges.chart()
    }

    pub(super) fn time(&self, point: usize) -> f64 {
        self.times[point].into()
    }

    pub(super) fn is_reached(&self, point: usize) -> bool {
        self.times[point] < f32::INFINITY
    }

    /// Returns whether the place is on the surface and a wavefront reaches it. The place must be inside the
    /// grid.
    pub(super) fn reaches(&self, at: DVec2) -> bool {
        self.place(at).is_some()
    }

    /// Returns the place at a row and column, if a wavefront reaches it.
    pub(super) fn place(&self, at: DVec2) -> Option<Place> {
        let (row, col) = (at.x as usize, at.y as usize);
        let (v, u) = (at.x.fract(), at.y.fract());
        let north_west = self.chart().bordered(row, col);
        let reached = |point: usize| self.is_reached(point).then_some(point);
        let edge = |along, share| {
            let first = reached(north_west)?;
            reached(self.chart().beside(first, along))?;
            Some(Place::Edge { first, along, share })
        };
        match (v > 0.0, u > 0.0) {
            (false, false) => Some(Place::Point(reached(north_west)?)),
            (false, true) => edge(Direction::East, u),
            (true, false) => edge(Direction::South, v),
            (true, true) => {
                let there = self.chart().bordered_corners(north_west).map(|c| self.is_reached(c));
                let weights = corner_weights(there, DVec2::new(v, u))?;
                Some(Place::Inside { north_west, weights })
            }
        }
    }

    /// Returns the row and column of a place.
    pub(super) fn at(&self, place: Place) -> DVec2 {
        place.at(self.chart())
    }

    /// Returns the reached corners of the cells that contain a place, and their distances from it.
    pub(super) fn corners(&self, place: Place) -> impl Iterator<Item = (usize, f64)> {
        let (cells, count) = place.cells(self.chart());
        cells.into_iter().take(count).flat_map(|(north_west, weights)| {
            let cell = CellLengths::new(self.edges, north_west);
            let squares = cell.from(&weights);
            (0..4)
                .filter(move |&corner| squares[corner] < NO_EDGE)
                .map(move |corner| {
                    let cost = cell.cost(squares[corner], &weights, &corner_alone(corner));
                    (cell.corners[corner], cost)
                })
                .filter(|&(corner, _)| self.is_reached(corner))
        })
    }

    /// Returns the arrival times at the ends of an edge and at the next points on the same line: four points
    /// in a row.
    #[inline]
    pub(super) fn times_along(&self, [first, last]: [usize; 2]) -> [f64; 4] {
        let step = last - first;
        [first - step, first, last, last + step].map(|point| self.time(point))
    }

    /// Returns the lengths on the surface of the edges before and behind an edge on the same line, as parts of the
    /// edge's own length. They are not finite numbers where an edge is missing or has no length.
    #[inline]
    pub(super) fn ratios_along(&self, [first, last]: [usize; 2]) -> [f64; 2] {
        let step = last - first;
        let plane = usize::from(step > 1);
        // An edge to the south is stored at its southern end, as the edge to the north.
        let lengths = &self.edges.planes()[plane];
        let length = |from: usize| -> f64 { lengths[from + plane * step].into() };
        let slowness = self.edges.slowness();
        let on_surface = |from: usize| match slowness {
            Some(slowness) => length(from) / f64::from(slowness[from] + slowness[from + step]),
            None => length(from),
        };
        let own = on_surface(first);
        [first - step, last].map(|from| on_surface(from) / own)
    }

    /// Returns the length of the edge between two neighbours. It is zero between copies of a point.
    pub(super) fn length(&self, a: usize, b: usize) -> f64 {
        let to = Direction::ALL.into_iter().find(|&to| self.chart().beside(a, to) == b);
        to.map_or(0.0, |to| self.edges.at(a, EdgeSlot::of(self.chart(), to)).into())
    }

    /// Returns the earliest of the grid points of the edge or cell in which the place lies.
    pub(super) fn lower_end(&self, place: Place) -> usize {
        let (cells, _) = place.cells(self.chart());
        let (north_west, weights) = cells[0];
        let corners = self.chart().bordered_corners(north_west);
        let own = corners.into_iter().zip(weights).filter(|(_, weight)| *weight > 0.0);
        own.map(|(corner, _)| corner)
            .min_by(|&a, &b| self.times[a].total_cmp(&self.times[b]))
            .expect("a place has weights")
    }
}

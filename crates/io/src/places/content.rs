//! Defines the content of a file of places, in the file's own coordinates.

use std::borrow::Cow;

use super::super::Grid;
use super::frame::MapCoordinates;
use geosweep_surface::shown::exact;

#[derive(Clone, Debug)]
pub(super) enum Content {
    Curves(FileCurves),
    /// Row-major indices of grid points.
    Indices(Vec<f64>),
    /// A raster over the surface. Cells other than 0 and NaN are points.
    Raster(Grid<f64>),
}

/// The curves of a file, in the file's own coordinates.
#[derive(Clone, Debug, Default)]
pub(super) struct FileCurves {
    pub curves: Vec<FileCurve>,
    pub coordinates: Coordinates,
    /// Columns or properties that are not used.
    pub unused: Vec<String>,
    /// Whether a column or property gives start values.
    pub has_starts: bool,
    /// The unit by which vertices are numbered, such as `line`.
    pub numbered: &'static str,
    /// Number of features without a geometry.
    pub empty: usize,
}

#[derive(Clone, Debug)]
pub(super) struct FileCurve {
    pub vertices: Vec<Vertex>,
    pub kind: CurveKind,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum CurveKind {
    /// Points or a curve: the format does not distinguish them.
    Any,
    /// Points or a curve, as in [`Self::Any`]. The last vertex is followed by the first.
    Closed,
    /// Points that do not form a curve.
    Points,
    /// A line.
    Line,
    /// The outer ring of a polygon. The last vertex is followed by the first.
    Ring,
    /// The ring of a hole in a polygon. The last vertex is followed by the first.
    Hole,
}

impl CurveKind {
    pub fn is_closed(self) -> bool {
        matches!(self, Self::Closed | Self::Ring | Self::Hole)
    }

    /// Returns whether this is a ring of a polygon.
    pub fn is_ring(self) -> bool {
        matches!(self, Self::Ring | Self::Hole)
    }
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Vertex {
    pub place: [f64; 2],
    pub start: f64,
    /// Number of the line or feature, from 1, or of the row of the array, from 0.
    pub number: usize,
    /// The value of the cell of a raster.
    pub value: Option<f64>,
}

#[derive(Clone, Debug, Default, PartialEq)]
pub(super) enum Coordinates {
    /// Row and column.
    #[default]
    Grid,
    Map(MapCoordinates),
}

impl FileCurves {
    /// Formats a vertex in the file's own coordinates.
    pub fn shown(&self, vertex: &Vertex) -> String {
        let [first, second] = vertex.place.map(exact);
        match self.coordinates {
            Coordinates::Grid => format!("row {first}, column {second}"),
            Coordinates::Map(_) => format!("{first},{second}"),
        }
    }
}

impl FileCurve {
    /// Returns the vertices in an order in which the inside of a polygon lies to the left of its rings on the map,
    /// whichever way the file runs around them. `turn` is the full turn of longitudes, by which vertices of a ring may
    /// jump.
    pub fn with_inside_on_the_left(&self, turn: Option<f64>) -> Cow<'_, [Vertex]> {
        let is_clockwise = || area(&self.vertices, turn) < 0.0;
        match self.kind.is_ring() && is_clockwise() != (self.kind == CurveKind::Hole) {
            true => self.vertices.iter().rev().copied().collect(),
            false => self.vertices[..].into(),
        }
    }

    /// Returns the vertices, without the last one if it repeats the first.
    pub fn once(&self) -> &[Vertex] {
        match &self.vertices[..] {
            [first, around @ .., last] if around.len() > 1 && first.place == last.place => {
                &self.vertices[..self.vertices.len() - 1]
            }
            all => all,
        }
    }
}

/// Returns the area that a ring surrounds on a map, positive if it runs counter-clockwise.
fn area(ring: &[Vertex], turn: Option<f64>) -> f64 {
    let (mut from, mut sum) = ([0.0; 2], 0.0);
    for ends in ring.windows(2) {
        let [mut east, north] = [0, 1].map(|k| ends[1].place[k] - ends[0].place[k]);
        if let Some(turn) = turn {
            east -= turn * (east / turn).round();
        }
        let to = [from[0] + east, from[1] + north];
        sum += from[0] * to[1] - from[1] * to[0];
        from = to;
    }
    0.5 * sum
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    proptest! {
        /// A star around a place, which may lie at the antimeridian.
        #[test]
        fn rings_have_the_inside_on_the_left(
            radii in prop::collection::vec(0.2..1.0f64, 3..12),
            middle in prop::array::uniform2(-180.0..180.0f64),
            first in 0..12usize,
            reversed: bool,
            is_hole: bool,
        ) {
            let count = radii.len();
            let wrapped = |longitude: f64| (longitude + 180.0).rem_euclid(360.0) - 180.0;
            let vertex = |k: usize| {
                let angle = std::f64::consts::TAU * k as f64 / count as f64;
                let place = [wrapped(middle[0] + radii[k] * angle.cos()), middle[1] + radii[k] * angle.sin()];
                Vertex { place, start: 0.0, number: k, value: None }
            };
            let mut vertices: Vec<_> = (0..count).map(|k| vertex((k + first) % count)).collect();
            if reversed {
                vertices.reverse();
            }
            let kind = if is_hole { CurveKind::Hole } else { CurveKind::Ring };
            let ring = FileCurve { vertices, kind };
            let found = ring.with_inside_on_the_left(Some(360.0));
            let next = (found[0].number + if is_hole { count - 1 } else { 1 }) % count;
            prop_assert_eq!(found[1].number, next);
        }
    }
}

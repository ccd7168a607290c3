//! Defines the content of a file of places, in the file's own coordinates.

use super::super::Grid;
use super::frame::MapCoordinates;
use geosweep_surface::shown::exact;

#[derive(Clone, Debug)]
pub(super) enum Content {
    Curves(FileCurves),
    /// Row-major indices of grid points.
    Indices(Vec<f64>),
    /// A raster over the surface, true at each point that it selects.
    Raster(Grid<bool>),
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
    /// The ring of a polygon. The last vertex is followed by the first.
    Ring,
}

impl CurveKind {
    pub fn is_closed(self) -> bool {
        matches!(self, Self::Closed | Self::Ring)
    }
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Vertex {
    pub place: [f64; 2],
    pub start: f64,
    /// Number of the line or feature, from 1, or of the row of the array, from 0.
    pub number: usize,
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

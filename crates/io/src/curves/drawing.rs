//! Describes the curves of a file, with their attributes, positions and colours.

use std::fmt;

use glam::DVec3;

use crate::Georeference;
use geosweep_geometry::{Curve, CurveError};
use geosweep_surface::{Chart, Surface};

/// A curve on a surface with its attributes.
#[derive(Clone, Debug, PartialEq)]
pub struct Polyline {
    /// The kind of curve, such as `contour`. It is one word.
    pub kind: &'static str,
    /// Numbers and names that describe the curve. All curves of a file have attributes of
    /// the same names, in the same order.
    pub attributes: Vec<(&'static str, Attribute)>,
    /// The curve in the parameter domain.
    pub curve: Curve,
    /// Positions of the vertices in space. Empty if the surface is given only by its metric.
    pub positions: Vec<DVec3>,
    /// Red, green and blue, for formats that show colours.
    pub color: [u8; 3],
    /// The vertices at which the curve jumps over a seam of a closed surface ([`Curve::jumps`]).
    pub jumps: Vec<usize>,
}

/// The value of an attribute of a curve.
#[derive(Clone, Debug, PartialEq)]
pub enum Attribute {
    /// A level or a length.
    Number(f64),
    /// A count or an index.
    Index(i64),
    /// A name.
    Name(&'static str),
}

/// The curves of one surface, with the additional data that formats need.
#[derive(Clone, Debug)]
pub struct Drawing {
    /// Size of the grid.
    pub chart: Chart,
    /// Location of the grid on the Earth.
    pub georeference: Option<Georeference>,
    /// Whether the third coordinate of a position is a height above its map coordinates.
    pub has_heights: bool,
    /// Names of the curves' attributes. A CSV table has a column for each of them, even if there are no curves.
    pub attributes: Vec<&'static str>,
    /// The curves, in order.
    pub polylines: Vec<Polyline>,
}

impl Polyline {
    /// Makes a black curve on a surface. Its positions are those of [`Curve::lift`].
    ///
    /// # Errors
    /// If a vertex lies off the surface.
    pub fn new(kind: &'static str, curve: Curve, surface: &Surface) -> Result<Self, CurveError> {
        let has_positions = surface.geometry().has_positions();
        let positions = if has_positions { curve.lift(surface)? } else { Vec::new() };
        let jumps = curve.jumps(surface);
        Ok(Self { kind, attributes: Vec::new(), curve, positions, color: [0; 3], jumps })
    }

    /// Adds an attribute.
    pub fn with(mut self, name: &'static str, value: Attribute) -> Self {
        self.attributes.push((name, value));
        self
    }

    /// Returns the vertices with their positions, which are NaN where there is none.
    pub(super) fn vertices(&self) -> impl Iterator<Item = ([f64; 2], DVec3)> + Clone {
        let position = |index| self.positions.get(index).copied().unwrap_or(DVec3::NAN);
        let vertices = self.curve.vertices.iter().enumerate();
        vertices.map(move |(index, &vertex)| (vertex, position(index)))
    }

    /// Returns the vertices with their positions, and the first one again at the end of a closed curve.
    pub(super) fn around(&self) -> impl Iterator<Item = ([f64; 2], DVec3)> + Clone {
        self.vertices().chain(self.vertices().take(usize::from(self.curve.closed)))
    }
}

impl fmt::Display for Attribute {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Number(number) => number.fmt(f),
            Self::Index(index) => index.fmt(f),
            Self::Name(name) => name.fmt(f),
        }
    }
}

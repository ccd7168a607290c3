//! Writes curves to files: contours, paths, borders and offset curves.

mod geojson;
mod space;
mod svg;
mod table;

use std::fmt;
use std::io::{self, Write};
use std::path::Path;

use glam::DVec3;

use super::{Georeference, IoError, extension};
use crate::Surface;
use crate::geometry::{Curve, CurveError};
use crate::surface::Chart;

/// A curve on a surface with its attributes.
#[derive(Clone, Debug, PartialEq)]
pub struct Polyline {
    /// The kind of curve, such as `contour`. It is one word.
    pub kind: &'static str,
    /// Numbers and names that describe the curve. All curves of a file have the same ones.
    pub attributes: Vec<(&'static str, Attribute)>,
    /// The curve in the parameter domain.
    pub curve: Curve,
    /// Positions of the vertices in space. Empty if the surface is given only by its metric.
    pub positions: Vec<DVec3>,
    /// Red, green and blue, for formats that show colours.
    pub color: [u8; 3],
    /// Where the curve passes seams of a closed surface ([`Curve::jumps`]).
    pub jumps: Vec<usize>,
}

/// The value of an attribute of a curve.
#[derive(Clone, Debug, PartialEq)]
pub enum Attribute {
    /// A level or a length.
    Number(f64),
    /// A count or an index.
    Index(usize),
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
    /// Names of the curves' attributes. They are the columns of a table, even of one without curves.
    pub attributes: Vec<&'static str>,
    /// The curves, in order.
    pub polylines: Vec<Polyline>,
}

/// A file format for curves.
///
/// | extension | content |
/// |---|---|
/// | `.npy` | float64 (K, 5): row, column, x, y, z of each vertex |
/// | `.csv` | a line per vertex: `curve` (from 0), `kind`, attributes, `closed`, `row`, `col`, x, y, z |
/// | `.svg` | the parameter domain, columns to the right and rows down, one unit a grid step |
/// | `.geojson` | a LineString a curve, with heights, in the coordinates of the surface's GeoTIFF |
/// | `.ply` | binary, vertices with colours, and edges |
/// | `.obj` | a line element a curve |
///
/// In a `.npy`, closed curves end with their first vertex, and a row of NaN separates curves, unless all are
/// single points. A `.csv` does not repeat the first vertex.
///
/// The values x, y, z are NaN or empty for a surface that is given only by its metric. PLY and OBJ require
/// them.
///
/// GeoJSON on WGS 84 (EPSG:4326) follows RFC 7946. In any other coordinate system the file has the member
/// `crs` of the format's 2008 version, which GDAL and QGIS read. No coordinate is converted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CurveFormat {
    /// NumPy array.
    Npy,
    /// Comma-separated values.
    Csv,
    /// Scalable Vector Graphics.
    Svg,
    /// GeoJSON.
    GeoJson,
    /// Polygon file.
    Ply,
    /// Wavefront object.
    Obj,
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
    fn vertices(&self) -> impl Iterator<Item = ([f64; 2], DVec3)> + Clone {
        let position = |index| self.positions.get(index).copied().unwrap_or(DVec3::NAN);
        let vertices = self.curve.vertices.iter().enumerate();
        vertices.map(move |(index, &vertex)| (vertex, position(index)))
    }

    /// Returns the vertices with their positions, and the first one again at the end of a closed curve.
    fn around(&self) -> impl Iterator<Item = ([f64; 2], DVec3)> + Clone {
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

impl CurveFormat {
    /// Returns the format for the extension of a file name.
    ///
    /// # Errors
    /// If no format has this extension. The error lists the supported ones.
    pub fn of(path: &Path) -> Result<Self, IoError> {
        match extension(path).as_str() {
            "npy" => Ok(Self::Npy),
            "csv" => Ok(Self::Csv),
            "svg" => Ok(Self::Svg),
            "geojson" => Ok(Self::GeoJson),
            "ply" => Ok(Self::Ply),
            "obj" => Ok(Self::Obj),
            _ => {
                let supported = ".npy, .csv, .svg, .geojson, .ply or .obj";
                Err(IoError::extension(path, "a set of curves", supported))
            }
        }
    }

    /// Returns whether the format cannot hold curves without positions.
    pub fn needs_positions(self) -> bool {
        matches!(self, Self::Ply | Self::Obj)
    }

    /// Writes curves.
    ///
    /// # Errors
    /// The errors of the writer. For GeoJSON, also a drawing without a georeference. For PLY and OBJ, curves
    /// without positions. For PLY, more vertices than 32-bit indices can distinguish.
    pub fn write(self, writer: &mut impl Write, drawing: &Drawing) -> io::Result<()> {
        let lacks = |polyline: &Polyline| polyline.positions.len() != polyline.curve.vertices.len();
        if self.needs_positions() && drawing.polylines.iter().any(lacks) {
            return Err(io::Error::other("a surface known only by its metric has no positions"));
        }
        match self {
            Self::Npy => table::write_npy(writer, drawing),
            Self::Csv => table::write_csv(writer, drawing),
            Self::Svg => svg::write(writer, drawing),
            Self::GeoJson => geojson::write(writer, drawing),
            Self::Ply => space::write_ply(writer, drawing),
            Self::Obj => space::write_obj(writer, drawing),
        }
    }
}

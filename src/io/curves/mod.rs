//! Curves as files: contours, paths, borders and offset curves.

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

/// A curve on a surface with what is known of it.
#[derive(Clone, Debug, PartialEq)]
pub struct Polyline {
    /// What it is, such as `contour`; one word.
    pub kind: &'static str,
    /// Numbers and names that belong to it, the same ones in all curves of a file.
    pub attributes: Vec<(&'static str, Attribute)>,
    /// In the parameter domain.
    pub curve: Curve,
    /// The vertices in space; empty if the surface is known only by its metric.
    pub positions: Vec<DVec3>,
    /// Red, green and blue, for formats that show one.
    pub color: [u8; 3],
}

/// What is known of a curve.
#[derive(Clone, Debug, PartialEq)]
pub enum Attribute {
    /// A level or a length.
    Number(f64),
    /// A count or an index.
    Index(usize),
    /// A name.
    Name(&'static str),
}

/// Curves of one surface, and what formats need beside them.
#[derive(Clone, Debug)]
pub struct Drawing {
    /// The grid.
    pub chart: Chart,
    /// Where it lies on the Earth.
    pub georeference: Option<Georeference>,
    /// Names of the curves' attributes: columns of a table, of one without curves too.
    pub attributes: Vec<&'static str>,
    /// The curves, in their order.
    pub polylines: Vec<Polyline>,
}

/// A format of curves.
///
/// | extension | content |
/// |---|---|
/// | `.npy` | float64 (K, 5): row, column, x, y, z of each vertex; a row of NaN between curves, unless all are single points; closed curves end where they begin |
/// | `.csv` | a line per vertex: `curve` (from 0), `kind`, the attributes, `closed`, `row`, `col`, `x`, `y`, `z`; the first vertex is not repeated |
/// | `.svg` | the parameter domain, columns to the right and rows down, one unit a grid step |
/// | `.geojson` | a LineString a curve, with heights, in the coordinates of the GeoTIFF that the surface comes from |
/// | `.ply` | binary, vertices with colours, and edges |
/// | `.obj` | a line element a curve |
///
/// x, y, z are NaN or empty for a surface that is known only by its metric; PLY and OBJ need them.
///
/// GeoJSON on WGS 84 (EPSG:4326) follows RFC 7946. In any other coordinate system the file has the
/// member `crs` of the format's 2008 version, which GDAL and QGIS read: no coordinate is converted.
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
    /// A black curve on a surface, whose positions are those of [`Curve::lift`].
    ///
    /// # Errors
    /// If a vertex lies off the surface.
    pub fn new(kind: &'static str, curve: Curve, surface: &Surface) -> Result<Self, CurveError> {
        let has_positions = surface.geometry().has_positions();
        let positions = if has_positions { curve.lift(surface)? } else { Vec::new() };
        Ok(Self { kind, attributes: Vec::new(), curve, positions, color: [0; 3] })
    }

    /// With another attribute.
    pub fn with(mut self, name: &'static str, value: Attribute) -> Self {
        self.attributes.push((name, value));
        self
    }

    /// Vertices with their positions, NaN where there is none.
    fn vertices(&self) -> impl Iterator<Item = ([f64; 2], DVec3)> + Clone {
        let position = |index| self.positions.get(index).copied().unwrap_or(DVec3::NAN);
        let vertices = self.curve.vertices.iter().enumerate();
        vertices.map(move |(index, &vertex)| (vertex, position(index)))
    }

    /// Those, with the first again at the end of a closed curve.
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
    /// The format that a name's extension stands for.
    ///
    /// # Errors
    /// If it stands for none, with a list of those that would do.
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

    /// Whether curves without positions cannot be written.
    pub fn needs_positions(self) -> bool {
        matches!(self, Self::Ply | Self::Obj)
    }

    /// Writes curves.
    ///
    /// # Errors
    /// Those of the writer; for GeoJSON also a drawing without a georeference, for PLY and OBJ
    /// curves without positions, for PLY more vertices than its 32-bit indices tell apart.
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

//! Writes curves to files: contours, paths, borders and offset curves.

mod antimeridian;
mod drawing;
mod geojson;
mod space;
mod svg;
mod table;

use std::io::{self, Write};
use std::path::Path;

pub use drawing::{Attribute, Drawing, Polyline};

use super::{IoError, extension};

/// A file format for curves.
///
/// | extension | content |
/// |---|---|
/// | `.npy` | float64 (K, 5): row, column, x, y, z of each vertex |
/// | `.csv` | a line per vertex: `curve` (from 0), `kind`, attributes, `closed`, `row`, `col`, x, y, z |
/// | `.svg` | the parameter domain, columns to the right and rows down, one unit a grid step |
/// | `.geojson` | a LineString a curve, with heights if there are any, in the coordinates of the surface's GeoTIFF |
/// | `.ply` | binary, vertices with colours, and edges |
/// | `.obj` | a line element a curve |
///
/// In a `.npy`, closed curves end with their first vertex, and a row of NaN separates curves, unless all are
/// single points. A `.csv` does not repeat the first vertex.
///
/// The values x, y, z are NaN or empty for a surface that is given only by its metric. PLY and OBJ require
/// them.
///
/// GeoJSON on WGS 84 (EPSG:4326) follows RFC 7946. Longitudes run from -180 to 180, and a curve that passes the
/// antimeridian is a MultiLineString, divided there. In any other coordinate system the file has the member
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

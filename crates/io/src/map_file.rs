//! Writes and reads distance maps as files.

use std::fmt;
use std::io::{self, Seek, Write};
use std::path::Path;

use ::tiff::encoder::colortype::{Gray32Float, Gray64Float, GrayI32};

use super::arrays::{matrix, read_array};
use super::npy::NpyElement;
use super::tiff::{self, GeoTags};
use super::{Grid, IoError, exr, extension, raster, read_bytes, write_npy};

/// A format that holds a map without loss: one float32 per point, or one float64 for a map in double
/// precision. Points that no source reaches are +infinity.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MapFormat {
    /// NumPy array (M, N).
    Npy,
    /// One grey channel, uncompressed, with +infinity as GDAL's no-data value.
    Tiff,
    /// One channel `Y`, compressed, in single precision only.
    Exr,
}

impl MapFormat {
    /// Returns the format for the extension of a file name.
    ///
    /// # Errors
    /// If no format has this extension. The error lists the supported ones.
    pub fn of(path: &Path) -> Result<Self, IoError> {
        match extension(path).as_str() {
            "npy" => Ok(Self::Npy),
            "tif" | "tiff" => Ok(Self::Tiff),
            "exr" => Ok(Self::Exr),
            _ => Err(IoError::extension(path, "a distance map", ".npy, .tif or .exr")),
        }
    }

    /// Returns whether the format can hold a map in double precision.
    pub fn holds_double(self) -> bool {
        self != Self::Exr
    }

    /// Writes a map of `rows` x `cols` values, row-major. A GeoTIFF carries `geo_tags`, the tags of the
    /// surface's file ([`SurfaceFile::geo_tags`](super::SurfaceFile::geo_tags)).
    ///
    /// # Errors
    /// The errors of the writer. It is also an error if the format cannot hold a map of this size, or in
    /// double precision.
    pub fn write<T: MapValue>(
        self,
        writer: &mut (impl Write + Seek),
        rows: usize,
        cols: usize,
        distances: &[T],
        geo_tags: Option<&GeoTags>,
    ) -> io::Result<()> {
        match (self, T::values(distances)) {
            (Self::Npy, _) => write_npy(writer, &[rows, cols], distances),
            (Self::Tiff, MapValues::Single(distances)) => {
                tiff::encode::<Gray32Float>(writer, [rows, cols], distances, UNREACHED, geo_tags)
            }
            (Self::Tiff, MapValues::Double(distances)) => {
                tiff::encode::<Gray64Float>(writer, [rows, cols], distances, UNREACHED, geo_tags)
            }
            (Self::Exr, MapValues::Single(distances)) => exr::encode(writer, rows, cols, distances),
            (Self::Exr, MapValues::Double(_)) => Err(io::Error::new(
                io::ErrorKind::Unsupported,
                "OpenEXR has no channels of double precision",
            )),
        }
    }
}

/// A precision of maps in files: f32 or f64.
pub trait MapValue: NpyElement {
    /// Wraps values, tagged with their precision.
    fn values(values: &[Self]) -> MapValues<'_>;
}

/// The values of a map in either precision.
#[derive(Clone, Copy, Debug)]
pub enum MapValues<'a> {
    /// In single precision.
    Single(&'a [f32]),
    /// In double precision.
    Double(&'a [f64]),
}

impl MapValue for f32 {
    fn values(values: &[Self]) -> MapValues<'_> {
        MapValues::Single(values)
    }
}

impl MapValue for f64 {
    fn values(values: &[Self]) -> MapValues<'_> {
        MapValues::Double(values)
    }
}

impl fmt::Display for MapFormat {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Npy => ".npy",
            Self::Tiff => ".tif",
            Self::Exr => ".exr",
        })
    }
}

/// GDAL's no-data value in maps: +infinity, as C writes it.
const UNREACHED: &str = "inf";

/// Writes labels as a GeoTIFF of 32-bit integers. Points without a label are -1, which is the no-data value.
///
/// # Errors
/// The errors of the writer.
pub fn write_labels_tiff(
    writer: &mut (impl Write + Seek),
    rows: usize,
    cols: usize,
    labels: &[i32],
    geo_tags: Option<&GeoTags>,
) -> io::Result<()> {
    tiff::encode::<GrayI32>(writer, [rows, cols], labels, "-1", geo_tags)
}

/// Writes bearings as a GeoTIFF of single precision. Points without a bearing are -1, which is the no-data
/// value.
///
/// # Errors
/// The errors of the writer.
pub fn write_bearings_tiff(
    writer: &mut (impl Write + Seek),
    rows: usize,
    cols: usize,
    bearings: &[f32],
    geo_tags: Option<&GeoTags>,
) -> io::Result<()> {
    tiff::encode::<Gray32Float>(writer, [rows, cols], bearings, "-1", geo_tags)
}

/// Writes vectors as a GeoTIFF of two channels in single precision. Points without a vector are NaN, which is
/// the no-data value.
///
/// # Errors
/// The errors of the writer.
pub fn write_vectors_tiff(
    writer: &mut (impl Write + Seek),
    rows: usize,
    cols: usize,
    vectors: &[[f32; 2]],
    geo_tags: Option<&GeoTags>,
) -> io::Result<()> {
    tiff::encode::<tiff::Pair32Float>(writer, [rows, cols], vectors.as_flattened(), "nan", geo_tags)
}

/// Reads a map, or any other grid of numbers. The file has one of the formats of [`MapFormat`], or is an
/// `.npz` with one array (or one named `map` or `distances` among several), or an ESRI ASCII grid.
///
/// # Errors
/// If the file cannot be read or does not hold a single grid of numbers.
pub fn read_map(path: &Path) -> Result<Grid<f64>, IoError> {
    let content = |reason| IoError::content(path, reason);
    match extension(path).as_str() {
        "npy" | "npz" => matrix(path, read_array(path, &["map", "distances"])?, "a map"),
        "tif" | "tiff" | "asc" => {
            let raster = raster::read_values(path)?;
            // In maps of this crate, the no-data value marks points that no source reaches.
            let unreached = |value: f64| if value.is_nan() { f64::INFINITY } else { value };
            Ok(if raster.unreached { raster.grid.map(unreached) } else { raster.grid })
        }
        "exr" => match exr::decode(&read_bytes(path)?).map_err(content)? {
            exr::Pixels::Single(grid) => Ok(grid),
            exr::Pixels::Positions(_) => {
                Err(content("holds positions; a map is a single channel".into()))
            }
        },
        _ => Err(IoError::extension(path, "a distance map", ".npy, .npz, .tif, .asc or .exr")),
    }
}

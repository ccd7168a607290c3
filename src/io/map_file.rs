//! Distance maps as files.

use std::fmt;
use std::io::{self, Seek, Write};
use std::path::Path;

use ::tiff::encoder::colortype::{Gray32Float, Gray64Float, GrayI32};

use super::arrays::{matrix, read_array};
use super::npy::NpyElement;
use super::tiff::{self, GeoTags};
use super::{Grid, IoError, exr, extension, raster, read_bytes, write_npy};

/// A format that holds a map without loss: one float32 per point, or one float64 of a map in double
/// precision; +infinity where no source reaches.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MapFormat {
    /// NumPy array (M, N).
    Npy,
    /// One grey channel, uncompressed, with +infinity as GDAL's no-data value.
    Tiff,
    /// One channel `Y`, compressed; single precision only.
    Exr,
}

impl MapFormat {
    /// The format that a name's extension stands for.
    ///
    /// # Errors
    /// If it stands for none, with a list of those that would do.
    pub fn of(path: &Path) -> Result<Self, IoError> {
        match extension(path).as_str() {
            "npy" => Ok(Self::Npy),
            "tif" | "tiff" => Ok(Self::Tiff),
            "exr" => Ok(Self::Exr),
            _ => Err(IoError::extension(path, "a distance map", ".npy, .tif or .exr")),
        }
    }

    /// Whether it can hold a map in double precision.
    pub fn holds_double(self) -> bool {
        self != Self::Exr
    }

    /// Writes a map of `rows` x `cols` values, row-major. A GeoTIFF carries `geo_tags`, those of the
    /// surface's file ([`SurfaceFile::geo_tags`](super::SurfaceFile::geo_tags)).
    ///
    /// # Errors
    /// Those of the writer, and of formats that cannot hold so large a map or none in double
    /// precision.
    pub fn write<T: MapValue>(
        self,
        writer: &mut (impl Write + Seek),
        rows: usize,
        cols: usize,
        distances: &[T],
        geo_tags: Option<&GeoTags>,
    ) -> io::Result<()> {
        match self {
            Self::Npy => write_npy(writer, &[rows, cols], distances),
            Self::Tiff => T::write_tiff(writer, [rows, cols], distances, geo_tags),
            Self::Exr => match T::as_single(distances) {
                Some(distances) => exr::encode(writer, rows, cols, distances),
                None => Err(io::Error::new(
                    io::ErrorKind::Unsupported,
                    "OpenEXR has no channels of double precision",
                )),
            },
        }
    }
}

/// A precision of maps in files: f32 or f64.
pub trait MapValue: NpyElement {
    /// Writes a grey channel of its own type.
    fn write_tiff(
        writer: &mut (impl Write + Seek),
        size: [usize; 2],
        values: &[Self],
        geo_tags: Option<&GeoTags>,
    ) -> io::Result<()>;

    /// The values, if they are of single precision.
    fn as_single(values: &[Self]) -> Option<&[f32]>;
}

impl MapValue for f32 {
    fn write_tiff(
        writer: &mut (impl Write + Seek),
        size: [usize; 2],
        values: &[Self],
        geo_tags: Option<&GeoTags>,
    ) -> io::Result<()> {
        tiff::encode::<Gray32Float>(writer, size, values, UNREACHED, geo_tags)
    }

    fn as_single(values: &[Self]) -> Option<&[f32]> {
        Some(values)
    }
}

impl MapValue for f64 {
    fn write_tiff(
        writer: &mut (impl Write + Seek),
        size: [usize; 2],
        values: &[Self],
        geo_tags: Option<&GeoTags>,
    ) -> io::Result<()> {
        tiff::encode::<Gray64Float>(writer, size, values, UNREACHED, geo_tags)
    }

    fn as_single(_: &[Self]) -> Option<&[f32]> {
        None
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

/// Writes labels, -1 where there is none, as a GeoTIFF of 32-bit integers with the no-data value -1.
///
/// # Errors
/// Returns the writer's errors.
pub fn write_labels_tiff(
    writer: &mut (impl Write + Seek),
    rows: usize,
    cols: usize,
    labels: &[i32],
    geo_tags: Option<&GeoTags>,
) -> io::Result<()> {
    tiff::encode::<GrayI32>(writer, [rows, cols], labels, "-1", geo_tags)
}

/// Reads a map, or any other grid of numbers: in one of the formats of [`MapFormat`], an array of an
/// `.npz` (named `map` or `distances` if it holds several) or an ESRI ASCII grid.
///
/// # Errors
/// If the file cannot be read or holds no single grid of numbers.
pub fn read_map(path: &Path) -> Result<Grid<f64>, IoError> {
    let content = |reason| IoError::content(path, reason);
    match extension(path).as_str() {
        "npy" | "npz" => matrix(path, read_array(path, &["map", "distances"])?, "a map"),
        "tif" | "tiff" | "asc" => {
            let raster = raster::read_values(path)?;
            // Our own maps mark by it what no source reaches.
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

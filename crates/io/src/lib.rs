//! Reads surfaces, masks, slowness, metrics and curves from files, and writes distance maps, matrices and
//! curves.
//!
//! Arrays are NumPy `.npy` and `.npz` files, row first. Grids of numbers are also read from GeoTIFF, ESRI
//! ASCII grids (`.asc`) and grey PNG; geometry images and heights are read from EXR. NaN marks points without a
//! surface. The extension of a file's name selects the format. Output files appear with their complete content or not
//! at all ([`OutputFile`]).
//!
//! The content of files is not trusted. Declared sizes are checked against the data before memory is allocated for them
//! (`limits.rs`), and at most [`MAX_POINTS`] points are accepted.

mod arrays;
mod ascii_grid;
mod atomic;
mod curves;
mod error;
mod exr;
mod file_spacing;
mod grid;
mod limits;
mod map_file;
mod matrix_file;
mod no_data;
mod npy;
mod npz;
mod places;
mod ply;
mod png;
mod raster;
mod sidecars;
mod sparse_file;
mod surface_file;
mod tiff;

pub use arrays::{read_mask, read_metric, read_slowness};
pub use atomic::{OutputFile, StagedFile};
pub use curves::{Attribute, CurveFormat, Drawing, Polyline};
pub use error::IoError;
pub use geosweep_crs::{CoordinateSystem, Georeference, MapScale, Orientation, SystemUnits};
pub use grid::Grid;
pub use limits::{MAX_POINTS, checked_points};
pub use map_file::{
    MapFormat, MapValue, MapValues, read_map, write_bearings_tiff, write_labels_tiff,
    write_vectors_tiff,
};
pub use matrix_file::{
    Element, MatrixFile, MatrixLayout, Provenance, SquareMatrix, is_distance_matrix, read_matrix,
    surface_checksum,
};
pub use npy::write_npy;
pub use places::{GridFrame, Misplaced, PlaceFile, PlacedCurve, PlacedPoint, misplaced};
pub use ply::write_ply;
pub use sparse_file::write_sparse_npz;
pub use surface_file::SurfaceFile;
pub use tiff::GeoTags;

use std::fs;
use std::path::{Path, PathBuf};

/// Checks that the path is a regular file, since devices and pipes may never end. Returns its size in bytes.
fn check_regular(path: &Path) -> Result<u64, IoError> {
    let read_error = |source| IoError::Read { path: path.to_owned(), source };
    let metadata = fs::metadata(path).map_err(read_error)?;
    if !metadata.is_file() {
        let what = if metadata.is_dir() { "a folder" } else { "not a regular file" };
        return Err(IoError::content(path, format!("is {what}; give a file")));
    }
    Ok(metadata.len())
}

/// Returns the bytes of a file.
fn read_bytes(path: &Path) -> Result<Vec<u8>, IoError> {
    check_regular(path)?;
    let read_error = |source| IoError::Read { path: path.to_owned(), source };
    let bytes = fs::read(path).map_err(read_error)?;
    if bytes.is_empty() {
        return Err(IoError::content(path, "the file is empty"));
    }
    Ok(bytes)
}

/// Returns the content of a file beside another one, or `None` if there is no such file.
fn read_beside(path: &Path) -> Result<Option<Vec<u8>>, IoError> {
    if path.is_file() { read_bytes(path).map(Some) } else { Ok(None) }
}

/// Returns the extension of a name in lower case, or an empty string.
fn extension(path: &Path) -> String {
    path.extension().map(|e| e.to_string_lossy().to_lowercase()).unwrap_or_default()
}

/// Returns the path with a suffix after its name.
fn with_suffix(path: &Path, suffix: &str) -> PathBuf {
    let mut name = path.as_os_str().to_owned();
    name.push(suffix);
    name.into()
}

//! Reads the arrays that accompany a surface: masks, slowness, metrics.

use std::path::Path;

use super::npy::{NpyArray, shape_text};
use super::{Grid, IoError, checked_points, extension, npz, raster, read_bytes};
use geosweep_surface::{Chart, MetricTensor};

/// Reads a mask, true where the surface is present: an array (M, N) of booleans or integers (`.npy`, or
/// `.npz` with the name `mask`), a grey PNG of at most 8 bits, a GeoTIFF or an ESRI ASCII grid. Values other
/// than zero and no-data are true.
///
/// # Errors
/// If the file cannot be read or has none of these formats.
pub fn read_mask(path: &Path) -> Result<Grid<bool>, IoError> {
    Ok(read_mask_values(path)?.map(|value| value != 0.0 && !value.is_nan()))
}

/// Reads the numbers of a mask, NaN where the file has no data.
pub(super) fn read_mask_values(path: &Path) -> Result<Grid<f64>, IoError> {
    let grid = match extension(path).as_str() {
        "npy" | "npz" => {
            let array = read_array(path, &["mask"])?;
            if array.dtype.kind == b'f' {
                let reason = "a mask is an array of booleans or integers; this one holds \
                              floating-point numbers: use mask.astype(bool), if none is NaN";
                return Err(IoError::content(path, reason));
            }
            matrix(path, array, "a mask")?
        }
        "tif" | "tiff" | "asc" | "png" => raster::read_mask(path)?,
        _ => return Err(IoError::extension(path, "a mask", ".npy, .npz, .png, .tif or .asc")),
    };
    Ok(grid)
}

/// Reads a slowness (reciprocal speed): an array (M, N) (`.npy`, or `.npz` with the name `slowness`), a
/// GeoTIFF or an ESRI ASCII grid. The slowness is infinite where a GeoTIFF or an ESRI ASCII grid has no data.
///
/// # Errors
/// If the file cannot be read or has none of these formats.
pub fn read_slowness(path: &Path) -> Result<Grid<f64>, IoError> {
    match extension(path).as_str() {
        "npy" | "npz" => matrix(path, read_array(path, &["slowness"])?, "a slowness"),
        "tif" | "tiff" | "asc" => {
            let wall = |value: f64| if value.is_nan() { f64::INFINITY } else { value };
            Ok(raster::read_values(path)?.grid.map(wall))
        }
        _ => Err(IoError::extension(path, "a slowness", ".npy, .npz, .tif or .asc")),
    }
}

/// Reads a metric: an array (M, N, 2, 2) (`.npy`, or `.npz` with the name `metric`) of symmetric matrices in
/// index coordinates. Axis 0 is the row. A step of `dr` rows and `dc` columns has the squared length `g[0,0]
/// dr^2 + (g[0,1] + g[1,0]) dr dc + g[1,1] dc^2`. NaN marks holes.
///
/// # Errors
/// If the file cannot be read or is not such an array.
pub fn read_metric(path: &Path) -> Result<Grid<MetricTensor>, IoError> {
    if !is_array(path) {
        return Err(IoError::extension(path, "a metric", ".npy or .npz"));
    }
    let array = read_array(path, &["metric"])?;
    match *array.shape {
        [_, _, 2, 2] => metric(array).map_err(|reason| IoError::content(path, reason)),
        _ => Err(wrong_shape(path, &array, "a metric has shape (M, N, 2, 2)")),
    }
}

/// Returns whether a file name has the extension of a NumPy array (`.npy`) or of an archive of arrays (`.npz`).
pub(super) fn is_array(path: &Path) -> bool {
    matches!(&extension(path)[..], "npy" | "npz")
}

/// Returns the array of an `.npy` file. From an `.npz` it returns the only array, or among several the one whose name
/// comes first in `names`.
pub(super) fn read_array(path: &Path, names: &[&str]) -> Result<NpyArray, IoError> {
    let bytes = read_bytes(path)?;
    let array = match &extension(path)[..] {
        "npz" => npz::decode(&bytes, names),
        _ => NpyArray::decode(&bytes),
    };
    array.map_err(|reason| IoError::content(path, reason))
}

pub(super) fn wrong_shape(path: &Path, array: &NpyArray, expected: &str) -> IoError {
    let shape = shape_text(&array.shape);
    IoError::content(path, format!("is an array of shape {shape}; {expected}"))
}

/// Converts an array (M, N) to a grid.
pub(super) fn matrix(path: &Path, array: NpyArray, what: &str) -> Result<Grid<f64>, IoError> {
    let [rows, cols] = *array.shape else {
        return Err(wrong_shape(path, &array, &format!("{what} has shape (M, N)")));
    };
    checked_points(rows, cols).map_err(|reason| IoError::content(path, reason))?;
    Ok(Grid::new(rows, cols, array.values))
}

/// Converts an array (M, N, 2, 2) to a metric.
pub(super) fn metric(array: NpyArray) -> Result<Grid<MetricTensor>, String> {
    let (rows, cols) = (array.shape[0], array.shape[1]);
    checked_points(rows, cols)?;
    let tensor = |(index, &[rr, rc, cr, cc]): (usize, &[f64; 4])| {
        // Rounding in single precision may leave a small asymmetry.
        if (rc - cr).abs() > 1e-5 * (rr.abs() + cc.abs()) {
            let (row, col) = Chart { rows, cols }.position(index);
            return Err(format!(
                "the metric at row {row}, column {col} is not symmetric: its mixed entries are {rc} and {cr}"
            ));
        }
        Ok(MetricTensor { rr, rc: 0.5 * (rc + cr), cc })
    };
    let values =
        array.values.as_chunks().0.iter().enumerate().map(tensor).collect::<Result<_, _>>()?;
    Ok(Grid::new(rows, cols, values))
}

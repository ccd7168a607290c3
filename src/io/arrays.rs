//! What accompanies a surface: masks, slowness, metrics.

use std::path::Path;

use super::npy::{Dtype, NpyArray, shape_text};
use super::{IoError, checked_points, extension, png, read_bytes};
use crate::surface::{Chart, MetricTensor};

/// One value per grid point, row-major.
#[derive(Clone, Debug, PartialEq)]
pub struct Grid<T> {
    /// Number of rows.
    pub rows: usize,
    /// Number of columns.
    pub cols: usize,
    /// `rows * cols` values.
    pub values: Vec<T>,
}

impl<T> Grid<T> {
    /// The values, if the grid has this size; otherwise says both sizes.
    pub fn fit(self, path: &Path, rows: usize, cols: usize) -> Result<Vec<T>, IoError> {
        if (self.rows, self.cols) == (rows, cols) {
            return Ok(self.values);
        }
        let (own_rows, own_cols) = (self.rows, self.cols);
        let reason = format!(
            "has {own_rows} x {own_cols} values, the surface {rows} x {cols} points; both must agree"
        );
        Err(IoError::content(path, reason))
    }

    pub(super) fn map<U>(self, f: impl FnMut(T) -> U) -> Grid<U> {
        Grid { rows: self.rows, cols: self.cols, values: self.values.into_iter().map(f).collect() }
    }
}

/// Reads a mask, true where the surface is: an `.npy` array (M, N) of booleans or integers of any
/// size, or a grey PNG of at most 8 bits, non-zero where the surface is.
pub fn read_mask(path: &Path) -> Result<Grid<bool>, IoError> {
    let grid = match extension(path).as_str() {
        "npy" => {
            let array = read_npy(path)?;
            let Dtype { kind, .. } = array.dtype;
            if !matches!(kind, b'b' | b'i' | b'u') {
                let reason = "a mask is an array of booleans or integers; this one holds \
                              floating-point numbers: use mask.astype(bool), if none is NaN";
                return Err(IoError::content(path, reason));
            }
            matrix(path, array, "a mask")?
        }
        "png" => {
            let reason = |reason| IoError::content(path, reason);
            let picture = png::decode(&read_bytes(path)?).map_err(reason)?;
            if picture.bits > 8 {
                return Err(reason("a mask is an 8-bit grey picture; this one has 16 bits".into()));
            }
            picture.grid
        }
        _ => return Err(IoError::extension(path, "a mask", ".npy or .png")),
    };
    Ok(grid.map(|value| value != 0.0))
}

/// Reads a slowness (reciprocal speed): an `.npy` array (M, N).
pub fn read_slowness(path: &Path) -> Result<Grid<f64>, IoError> {
    match extension(path).as_str() {
        "npy" => matrix(path, read_npy(path)?, "a slowness"),
        _ => Err(IoError::extension(path, "a slowness", ".npy")),
    }
}

/// Reads a metric: an `.npy` array (M, N, 2, 2) of symmetric matrices in index coordinates,
/// axis 0 being the row. A step of `dr` rows and `dc` columns has squared length
/// `g[0,0] dr^2 + (g[0,1] + g[1,0]) dr dc + g[1,1] dc^2`. NaN marks holes.
pub fn read_metric(path: &Path) -> Result<Grid<MetricTensor>, IoError> {
    if extension(path) != "npy" {
        return Err(IoError::extension(path, "a metric", ".npy"));
    }
    let array = read_npy(path)?;
    match *array.shape {
        [_, _, 2, 2] => metric(array).map_err(|reason| IoError::content(path, reason)),
        _ => Err(wrong_shape(path, &array, "a metric has shape (M, N, 2, 2)")),
    }
}

pub(super) fn read_npy(path: &Path) -> Result<NpyArray, IoError> {
    NpyArray::decode(&read_bytes(path)?).map_err(|reason| IoError::content(path, reason))
}

pub(super) fn wrong_shape(path: &Path, array: &NpyArray, expected: &str) -> IoError {
    let shape = shape_text(&array.shape);
    IoError::content(path, format!("is an array of shape {shape}; {expected}"))
}

/// An array (M, N) as a grid.
pub(super) fn matrix(path: &Path, array: NpyArray, what: &str) -> Result<Grid<f64>, IoError> {
    let [rows, cols] = *array.shape else {
        return Err(wrong_shape(path, &array, &format!("{what} has shape (M, N)")));
    };
    checked_points(rows, cols).map_err(|reason| IoError::content(path, reason))?;
    Ok(Grid { rows, cols, values: array.values })
}

/// An array (M, N, 2, 2) as a metric.
pub(super) fn metric(array: NpyArray) -> Result<Grid<MetricTensor>, String> {
    let (rows, cols) = (array.shape[0], array.shape[1]);
    checked_points(rows, cols)?;
    let tensor = |(index, &[rr, rc, cr, cc]): (usize, &[f64; 4])| {
        // Rounding in single precision may leave a little asymmetry.
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
    Ok(Grid { rows, cols, values })
}

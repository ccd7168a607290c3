//! Reads places from NumPy arrays.

use std::path::Path;

use super::super::IoError;
use super::super::arrays::{read_array, wrong_shape};
use super::content::{Content, Coordinates, CurveKind, FileCurve, FileCurves, Vertex};
use geosweep_surface::shown::exact;

const SHAPES: &str = "places have shape (K, 2): row, column; (K, 3): row, column, start value; or \
                      (K, 5) as the tool writes curves. Rows of a matrix may have shape (K,)";

/// Reads an array. An `.npz` must hold one array, or one that is named for this purpose.
pub(super) fn read(path: &Path) -> Result<Content, IoError> {
    let array = read_array(path, &["sources", "points", "curves"])?;
    let width = match array.shape[..] {
        [_] => return Ok(Content::Indices(array.values)),
        [_, width @ (2 | 3 | 5)] => width,
        _ => return Err(wrong_shape(path, &array, SHAPES)),
    };
    let has_starts = width == 3;
    let mut curves = Vec::new();
    let mut vertices = Vec::new();
    let mut end = |vertices: &mut Vec<Vertex>| {
        if !vertices.is_empty() {
            curves.push(FileCurve { vertices: std::mem::take(vertices), kind: CurveKind::Any });
        }
    };
    for (index, row) in array.values.chunks_exact(width).enumerate() {
        // Other columns are not read. They are NaN for a curve on a surface given by its metric, which has no
        // positions.
        let read = &row[..if has_starts { 3 } else { 2 }];
        if read.iter().all(|value| value.is_nan()) {
            end(&mut vertices);
            continue;
        }
        if let Some(value) = read.iter().find(|value| !value.is_finite()) {
            let reason = format!(
                "row {index} of the array holds {}, which is not a finite number; only a row with nothing \
                 but NaN separates curves",
                exact(*value)
            );
            return Err(IoError::content(path, reason));
        }
        let start = if has_starts { row[2] } else { 0.0 };
        vertices.push(Vertex { place: [row[0], row[1]], start, number: index, value: None });
    }
    end(&mut vertices);
    Ok(Content::Curves(FileCurves {
        curves,
        coordinates: Coordinates::Grid,
        has_starts,
        numbered: "row of the array",
        ..FileCurves::default()
    }))
}

//! Defines the errors of surfaces.

use super::chart::{Chart, Direction};
use super::gluing::GluingError;
use super::real::{LONGEST_EDGE, SHORTEST_EDGE};

/// The reason why an array is not a surface.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum SurfaceError {
    /// An array's length is not rows x columns.
    #[error("{what}: {found} values do not fill a grid of {rows} x {cols} points")]
    Shape {
        /// Name of the array.
        what: &'static str,
        /// Length of the array.
        found: usize,
        /// Number of rows of the grid.
        rows: usize,
        /// Number of columns of the grid.
        cols: usize,
    },
    /// The grid has no row or no column.
    #[error("a grid of {rows} x {cols} points is empty; give at least one row and one column")]
    Empty {
        /// Number of rows of the grid.
        rows: usize,
        /// Number of columns of the grid.
        cols: usize,
    },
    /// The grid cannot be coarsened.
    #[error(
        "a grid of {rows} x {cols} points has no coarser grid of every second point: each side needs at least three points, or one if the other side has three, and some of the points kept must not be holes"
    )]
    TooSmall {
        /// Number of rows of the grid.
        rows: usize,
        /// Number of columns of the grid.
        cols: usize,
    },
    /// Every point is a hole.
    #[error("no point of the surface is left: all are NaN or masked out")]
    NoPoint,
    /// A value is infinite where only finite values and NaN (a hole) are valid.
    #[error("{what} at row {row}, column {col} is infinite; use NaN to mark a hole")]
    Infinite {
        /// Name of the array.
        what: &'static str,
        /// Row of the value.
        row: usize,
        /// Column of the value.
        col: usize,
    },
    /// A spacing is zero, negative or not finite.
    #[error("spacing {dx} x {dy} is not usable: both must be positive and finite")]
    Spacing {
        /// Spacing between columns.
        dx: f64,
        /// Spacing between rows.
        dy: f64,
    },
    /// A slowness is negative.
    #[error(
        "slowness {value} at row {row}, column {col} is negative; 0 is free travel, and infinity or NaN a wall that nothing passes"
    )]
    Slowness {
        /// The negative value.
        value: f64,
        /// Row of the value.
        row: usize,
        /// Column of the value.
        col: usize,
    },
    /// A metric tensor is not positive definite.
    #[error(
        "metric at row {row}, column {col} is not positive definite: [[{rr}, {rc}], [{rc}, {cc}]]; its diagonal and its determinant must be positive"
    )]
    Metric {
        /// Row of the tensor.
        row: usize,
        /// Column of the tensor.
        col: usize,
        /// The tensor's entry for rows.
        rr: f64,
        /// The tensor's mixed entry.
        rc: f64,
        /// The tensor's entry for columns.
        cc: f64,
    },
    /// A coordinate makes edges too long for single precision.
    #[error(
        "{what} at row {row}, column {col}: {value:e} is too large, as edges may be no longer than {LONGEST_EDGE:e} units; if it stands for no data, make it NaN, mask it out or name it as the file's no-data value, else choose a larger unit of length"
    )]
    TooLarge {
        /// Name of the array.
        what: &'static str,
        /// The value.
        value: f64,
        /// Row of the value.
        row: usize,
        /// Column of the value.
        col: usize,
    },
    /// The surface cannot be glued, or something is not available on glued surfaces.
    #[error(transparent)]
    Gluing(#[from] GluingError),
    /// An edge is too long or too short for single precision.
    #[error(
        "the edge from row {row}, column {col} to its {direction:?} neighbour is {length:e} units long; choose a unit of length in which edges lie between {SHORTEST_EDGE:e} and {LONGEST_EDGE:e}"
    )]
    EdgeLength {
        /// Row of the edge's first end.
        row: usize,
        /// Column of the edge's first end.
        col: usize,
        /// Direction from the first end to the other.
        direction: Direction,
        /// Length of the edge.
        length: f64,
    },
}

/// Checks that an array has a value for each grid point. `what` names the array.
pub(super) fn check_shape(
    what: &'static str,
    found: usize,
    chart: Chart,
) -> Result<(), SurfaceError> {
    let Chart { rows, cols } = chart;
    if rows.checked_mul(cols) == Some(found) {
        Ok(())
    } else {
        Err(SurfaceError::Shape { what, found, rows, cols })
    }
}

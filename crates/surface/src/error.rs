//! Defines the errors of surfaces.

use super::chart::{Chart, Direction};
use super::floor_plan::AROUND;
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
    /// The grid has too many points for 32-bit indices.
    #[error(
        "a grid of {rows} x {cols} points is too large: with {AROUND} lines on each side, it may have at most {} points; take a coarser grid or a part of the surface",
        u32::MAX
    )]
    TooManyPoints {
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

/// Checks that 32-bit indices suffice for the points of a grid and of the lines that engines store around it.
pub(super) fn check_size(Chart { rows, cols }: Chart) -> Result<(), SurfaceError> {
    let around = |lines: usize| lines.checked_add(2 * AROUND);
    let points = around(rows).zip(around(cols)).and_then(|(rows, cols)| rows.checked_mul(cols));
    match points {
        Some(points) if u32::try_from(points).is_ok() => Ok(()),
        _ => Err(SurfaceError::TooManyPoints { rows, cols }),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Spacing, Surface};

    #[test]
    fn grids_with_more_points_than_32_bit_numbers_are_refused() {
        let error = |rows, cols| {
            Surface::from_heights(rows, cols, Vec::new(), Spacing::square(1.0)).unwrap_err()
        };
        // With the lines around it, the first grid has 2^32 - 2^16 points and the second 2^32.
        let side = (1 << 16) - 2 * AROUND;
        assert!(matches!(error(side - 1, side), SurfaceError::Shape { found: 0, .. }));
        for (rows, cols) in [(side, side), (usize::MAX, 1), (1, usize::MAX), (1 << 31, 1 << 31)] {
            assert_eq!(error(rows, cols), SurfaceError::TooManyPoints { rows, cols });
        }
        let message = error(side, side).to_string();
        assert!(message.contains("65504 x 65504") && message.contains("4294967295"), "{message}");
    }
}

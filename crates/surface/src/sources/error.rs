//! Defines the errors of sources. Each message says what to do.

use crate::FAR;
use crate::shown::exact;

/// Upper limit of the magnitude of initial values. The difference of two of them lies below [`FAR`].
pub(super) const LARGEST_INITIAL: f64 = 0.5 * FAR;

/// The reason why a source cannot be used.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum SourceError {
    /// No source was given.
    #[error("no source given; a distance map needs at least one")]
    None,
    /// The source lies off the grid.
    #[error(
        "source {},{} lies outside the grid: rows run from 0 to {last_row}, columns from 0 to {last_col}",
        exact(*row),
        exact(*col)
    )]
    Outside {
        /// Row of the source.
        row: f64,
        /// Column of the source.
        col: f64,
        /// The grid's last row.
        last_row: usize,
        /// The grid's last column.
        last_col: usize,
    },
    /// The source lies in a hole.
    #[error(
        "source {row},{col} lies in a hole of the surface (NaN or masked out); move it to a point of the surface"
    )]
    Hole {
        /// Row of the source.
        row: f64,
        /// Column of the source.
        col: f64,
    },
    /// The grid of every second row and column has no point beside the source.
    #[error(
        "the grid of every second row and column has only holes around the source near row {row}, column {col}, so the error of its distances cannot be estimated"
    )]
    NotOnCoarseGrid {
        /// Row of a point beside the source.
        row: usize,
        /// Column of that point.
        col: usize,
    },
    /// The curvature of a front at its source is not usable.
    #[error(
        "the curvature {curvature} of source {row},{col} is negative, infinite or NaN; give 0 for a point"
    )]
    Curvature {
        /// Row of the source.
        row: f64,
        /// Column of the source.
        col: f64,
        /// The given curvature.
        curvature: f64,
    },
    /// An initial value is NaN, infinite or too large for single precision.
    #[error(
        "the initial value {} of source {row},{col} is not a finite number below {LARGEST_INITIAL:e} in size; subtract the smallest initial value from all, or choose a larger unit",
        exact(*initial)
    )]
    Initial {
        /// Row of the source.
        row: f64,
        /// Column of the source.
        col: f64,
        /// The initial value.
        initial: f64,
    },
    /// A curve has no vertex.
    #[error("a source curve has no vertex; give at least one row and column")]
    EmptyCurve,
}

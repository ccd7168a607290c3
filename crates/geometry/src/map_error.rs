//! Defines the errors of distance maps that are given as inputs.

use geosweep_surface::{GluingError, SourceError};

/// The reason why distances and sources cannot be the map of a surface.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum MapError {
    /// A source does not lie on the surface.
    #[error(transparent)]
    Source(#[from] SourceError),
    /// The computation does not pass the seams of this surface.
    #[error(transparent)]
    Glued(#[from] GluingError),
    /// The number of distances differs from the number of grid points.
    #[error("{found} distances do not fill a grid of {rows} x {cols} points")]
    Shape {
        /// Number of distances.
        found: usize,
        /// Rows of the grid.
        rows: usize,
        /// Columns of the grid.
        cols: usize,
    },
    /// The angle from which on wavefronts make a ridge is none.
    #[error("a least angle of {0} degrees is not above 0 and up to 180")]
    Angle(f64),
}

//! What can be wrong with a map that something is to be made of.

use crate::surface::SourceError;

/// Why distances and sources cannot be the map of a surface.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum MapError {
    /// A source does not lie on the surface.
    #[error(transparent)]
    Source(#[from] SourceError),
    /// The distances are not those of the surface's points.
    #[error("{found} distances do not fill a grid of {rows} x {cols} points")]
    Shape {
        /// How many there are.
        found: usize,
        /// Rows of the grid.
        rows: usize,
        /// Columns of the grid.
        cols: usize,
    },
}

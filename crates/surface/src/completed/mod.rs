//! Completes grids of closed surfaces that do not repeat the samples of a seam.
//!
//! Gluing needs the samples of a seam on both of its sides. [`CompletedGrid`] adds the lines that a grid lacks, glues
//! the surface, and removes these lines from maps. [`grid`] does that for known lines: [`axis`] converts rows and
//! columns, and [`added`] computes points. [`layout`] and [`lines`] find the missing lines, and [`cube`] finds those of
//! the faces of a cube.

mod added;
mod axis;
mod cube;
mod grid;
mod layout;
mod lines;

pub use grid::CompletedGrid;
pub use layout::Layout;
pub(super) use lines::completed;

use super::{Chart, GluingError, Seam, Surface, SurfaceError};

impl CompletedGrid {
    /// Finds the lines that the grid of an open surface lacks. A line that the grid has is not added: positions tell
    /// which lines coincide. Opposite sides of heights or a metric are one line if all their values are equal.
    ///
    /// # Errors
    /// [`GluingError`], in [`SurfaceError::Gluing`], if sides are neither the same line nor neighbours, the first or last
    /// row surrounds no pole, the faces of a cube do not meet, or the grid is too small.
    pub fn new(surface: &Surface, layout: Layout) -> Result<Self, SurfaceError> {
        surface
            .check_open("the completion of a grid", "complete the surface before it is glued")?;
        Ok(match layout.seams(surface)? {
            Some(seams) => Self::with_seams(surface.chart(), &seams)?,
            None => cube::completed(surface)?,
        })
    }

    /// Completes a grid with named seams: [`Seam::Neighbours`] and [`Seam::Ring`] add a line, at [`Seam::Sides`]
    /// between opposite sides and at [`Seam::Pole`] the grid has all lines. Whether positions agree is not checked.
    ///
    /// # Errors
    /// If the grid has fewer than four rows or columns, or if the seams are not supported: a reversed seam beside lines
    /// that are added at the other sides, a fold, a seam between a row and a column, a pole at a column, or a seam
    /// between rows that are poles.
    pub fn with_seams(chart: Chart, seams: &[Seam]) -> Result<Self, GluingError> {
        lines::completed(chart, seams, [0.5, 0.5], 1.0)
    }
}

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
pub use layout::{LastLine, Layout};
pub(super) use lines::completed;

use super::{Chart, GluingError, Seam, Surface, SurfaceError};

impl CompletedGrid {
    /// Finds the lines that the grid of an open surface lacks. A line that the grid has is not added: positions tell
    /// which lines coincide. Opposite sides of heights or a metric with different values, holes or slowness are two
    /// lines.
    ///
    /// # Errors
    /// [`GluingError`], in [`SurfaceError::Gluing`], if sides are neither the same line nor neighbours, the first or last
    /// row surrounds no pole, the faces of a cube do not meet, or the grid is too small. Also if opposite sides of
    /// heights or a metric are equal, so that they may be one line or two: [`Self::with_last_line`] says which.
    pub fn new(surface: &Surface, layout: Layout) -> Result<Self, SurfaceError> {
        Self::find(surface, layout, None)
    }

    /// Finds the lines that the grid of an open surface lacks, as [`Self::new`] does, but is told whether the last line
    /// repeats the first one.
    ///
    /// # Errors
    /// The errors of [`Self::new`], except for equal sides. It is also an error if positions contradict `last`.
    pub fn with_last_line(
        surface: &Surface,
        layout: Layout,
        last: LastLine,
    ) -> Result<Self, SurfaceError> {
        Self::find(surface, layout, Some(last))
    }

    fn find(
        surface: &Surface,
        layout: Layout,
        last: Option<LastLine>,
    ) -> Result<Self, SurfaceError> {
        surface
            .check_open("the completion of a grid", "complete the surface before it is glued")?;
        Ok(match layout.seams(surface, last)? {
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

//! Represents values at the points of a grid, as read from files.

use std::path::Path;

use super::{Georeference, IoError};

/// One value per grid point, row-major.
#[derive(Clone, Debug, PartialEq)]
pub struct Grid<T> {
    /// Number of rows.
    pub rows: usize,
    /// Number of columns.
    pub cols: usize,
    /// `rows * cols` values.
    pub values: Vec<T>,
    /// Location of the points, if the file gives it.
    pub georeference: Option<Georeference>,
}

impl<T> Grid<T> {
    /// Makes a grid of values, row-major, without a location.
    pub fn new(rows: usize, cols: usize, values: Vec<T>) -> Self {
        Self { rows, cols, values, georeference: None }
    }

    /// Returns the values, if the grid has this size. Otherwise the error names both sizes.
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

    /// Returns the values, if the grid has this size and the same location as the surface. The location is
    /// checked if both files give it.
    ///
    /// # Errors
    /// If the sizes differ, if a corner lies more than a tenth of a cell elsewhere, or if the coordinate
    /// reference systems differ.
    pub fn fit_surface(
        self,
        path: &Path,
        rows: usize,
        cols: usize,
        surface: Option<&Georeference>,
    ) -> Result<Vec<T>, IoError> {
        let own = self.georeference;
        let values = self.fit(path, rows, cols)?;
        if let Some((own, surface)) = own.as_ref().zip(surface) {
            own.agrees(surface, rows, cols).map_err(|reason| {
                IoError::content(path, format!("{reason}; gdalwarp -t_srs and -te move it there"))
            })?;
        }
        Ok(values)
    }

    pub(super) fn map<U>(self, f: impl FnMut(T) -> U) -> Grid<U> {
        let Self { rows, cols, values, georeference } = self;
        Grid { rows, cols, values: values.into_iter().map(f).collect(), georeference }
    }
}

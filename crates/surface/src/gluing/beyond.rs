//! Continuation of a grid beyond its sides, in the terms of `glsl/shared/lattice.glsl`.

use super::Lattice;
use crate::Chart;
use crate::constants::{GOES_ON, GRID_ENDS, REVERSES, SEAM_HALO};

impl Lattice {
    /// Returns the shaders' codes for the continuation of the grid beyond its columns and beyond its rows.
    #[doc(hidden)]
    pub fn codes(self) -> [i32; 2] {
        [self.cols, self.rows].map(|reversed| match reversed {
            None => GRID_ENDS as i32,
            Some(false) => GOES_ON as i32,
            Some(true) => REVERSES as i32,
        })
    }

    /// Returns the numbers of columns and rows of points beyond each side that are measured with a grid.
    #[doc(hidden)]
    pub fn halo(self) -> [usize; 2] {
        [self.cols, self.rows].map(|side| side.map_or(0, |_| SEAM_HALO as usize))
    }

    /// Returns the values of `copy` in `sources.comp`: 0 for the sources, and the others for the copies of sources on
    /// seams.
    #[doc(hidden)]
    pub fn copies(self) -> impl Iterator<Item = i32> {
        let over = i32::from(self.cols.is_some()) + 2 * i32::from(self.rows.is_some());
        (0..4).filter(move |copy| copy & !over == 0)
    }

    /// Returns the grid with the columns beyond its sides.
    #[doc(hidden)]
    pub fn with_halo(self, chart: Chart) -> Chart {
        let [cols, _] = self.halo();
        Chart { cols: chart.cols + 2 * cols, ..chart }
    }
}

//! Maps grid points to texels of the images. The twin of `glsl/shared/chart.glsl`.

use std::ops::Range;

use ash::vk;

use crate::constants::BORDER;
use crate::surface::Chart;

/// Size of the images of fronts. A texel holds 2 x 2 grid points. The images have a border of texels that are
/// never reached.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct TexelChart {
    /// Number of rows of texels, with the border.
    pub rows: u32,
    /// Number of columns of texels, with the border.
    pub cols: u32,
}

impl TexelChart {
    /// Number of rows, and of columns, before the grid's first one in an image with one texel a point.
    pub(crate) const POINTS_BEFORE: u32 = 2 * BORDER;

    /// Returns the texels of a grid; `None` if they cannot be counted in 31 bits.
    pub fn new(chart: Chart) -> Option<Self> {
        let texels = |points: usize| {
            let points = u32::try_from(points).ok().filter(|&points| points < 1 << 30)?;
            Some(points.div_ceil(2) + 2 * BORDER)
        };
        Some(Self { rows: texels(chart.rows)?, cols: texels(chart.cols)? })
    }

    /// Returns the rows of texels that contain grid points.
    pub fn inner_rows(self) -> Range<u32> {
        BORDER..self.rows - BORDER
    }

    /// Returns the columns of texels that contain grid points.
    pub fn inner_cols(self) -> Range<u32> {
        BORDER..self.cols - BORDER
    }

    /// Returns the row and column of the texel of a grid point, and the point's component in it.
    pub fn texel_of(row: usize, col: usize) -> (u32, u32, usize) {
        (row as u32 / 2 + BORDER, col as u32 / 2 + BORDER, 2 * (row % 2) + col % 2)
    }

    /// Returns the number of columns and rows of texels that contain grid points.
    pub(crate) fn inner(self) -> [u32; 2] {
        [self.cols - 2 * BORDER, self.rows - 2 * BORDER]
    }

    /// Returns the number of texels that contain grid points.
    pub(crate) fn all(self) -> u64 {
        self.inner().map(u64::from).iter().product()
    }

    /// Returns the number of columns and rows of tiles with `points` points on a side.
    pub(crate) fn tiles(self, points: u32) -> [u32; 2] {
        self.inner().map(|texels| (2 * texels).div_ceil(points))
    }

    /// Returns the number of blocks that are stored for a scan: a block for every `lines` rows or columns of
    /// texels, whichever are more, and one more block on each side of the grid.
    pub(crate) fn block_pitch(self, lines: u32) -> u32 {
        let [cols, rows] = self.inner();
        cols.max(rows).div_ceil(lines) + 2
    }

    /// Returns the extent of an image with one texel for 2 x 2 points.
    pub fn fronts_extent(self) -> vk::Extent3D {
        vk::Extent3D { width: self.cols, height: self.rows, depth: 1 }
    }

    /// Returns the extent of an image with one texel a point.
    pub fn edges_extent(self) -> vk::Extent3D {
        vk::Extent3D { width: 2 * self.cols, height: 2 * self.rows, depth: 1 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn odd_grids_fill_the_last_texel_in_part() {
        let texels = TexelChart::new(Chart { rows: 3, cols: 1 }).unwrap();
        assert_eq!((texels.inner_rows(), texels.inner_cols()), (1..3, 1..2));
        assert_eq!(TexelChart::texel_of(2, 0), (2, 1, 0));
        assert_eq!(TexelChart::texel_of(1, 3), (1, 2, 3));
    }

    #[test]
    fn absurd_sizes_are_refused() {
        assert_eq!(TexelChart::new(Chart { rows: 1, cols: usize::MAX }), None);
    }
}

//! Lays out arrays with a border: a missing point before and after each row and column of the grid, so that
//! no access to a neighbour needs a bounds check.

use std::ops::Range;

use glam::DVec2;
use rayon::prelude::*;

#[cfg(any(test, feature = "twins"))]
use super::Block;
use super::{Chart, Direction};

impl Chart {
    /// Returns the distance between rows of a bordered array.
    #[doc(hidden)]
    #[inline]
    pub const fn stride(self) -> usize {
        self.cols + 2
    }

    /// Returns the number of entries of a bordered array.
    #[doc(hidden)]
    #[inline]
    pub const fn bordered_points(self) -> usize {
        (self.rows + 2) * self.stride()
    }

    /// Returns the index of a grid point in a bordered array.
    #[doc(hidden)]
    #[inline]
    pub const fn bordered(self, row: usize, col: usize) -> usize {
        self.entry_index(row + 1, col + 1)
    }

    /// Returns row and column of a grid point, given its index in a bordered array.
    #[doc(hidden)]
    #[inline]
    pub const fn bordered_position(self, point: usize) -> (usize, usize) {
        let (row, col) = self.entry(point);
        (row - 1, col - 1)
    }

    /// Returns the index in a bordered array of a grid point, given its row-major index.
    #[doc(hidden)]
    pub const fn bordered_point(self, index: usize) -> usize {
        let (row, col) = self.position(index);
        self.bordered(row, col)
    }

    /// Returns the row-major index of a grid point, given its index in a bordered array.
    #[doc(hidden)]
    pub const fn index_of(self, point: usize) -> usize {
        let (row, col) = self.bordered_position(point);
        self.index(row, col)
    }

    /// Returns row and column of a point of a bordered array, counted from the border. The point may be one
    /// of the border.
    #[inline(always)]
    #[doc(hidden)]
    pub const fn entry(self, point: usize) -> (usize, usize) {
        (point / self.stride(), point % self.stride())
    }

    /// Returns [`Self::entry`] of an index below 2^32, by a faster division.
    #[inline(always)]
    #[doc(hidden)]
    pub const fn short_entry(self, point: u32) -> (u32, u32) {
        (point / self.stride() as u32, point % self.stride() as u32)
    }

    /// Returns the index of a point of a bordered array, given its row and column, counted from the border.
    #[inline(always)]
    #[doc(hidden)]
    pub const fn entry_index(self, row: usize, col: usize) -> usize {
        row * self.stride() + col
    }

    /// Returns row and column of a point of a bordered array, counted from the grid's first point. The point
    /// may be one of the border.
    #[doc(hidden)]
    #[inline]
    pub fn bordered_place(self, point: usize) -> DVec2 {
        let (row, col) = self.entry(point);
        DVec2::new(row as f64 - 1.0, col as f64 - 1.0)
    }

    /// Returns the index in a bordered array of the point at a row and column. The point may be one of the
    /// border.
    #[doc(hidden)]
    #[inline]
    pub fn bordered_at(self, place: DVec2) -> usize {
        (place.x + 1.0) as usize * self.stride() + (place.y + 1.0) as usize
    }

    /// Returns the indices in a bordered array of the corners of the cell to the south-east of a point:
    /// north-west, north-east, south-west and south-east.
    #[inline(always)]
    #[doc(hidden)]
    pub const fn bordered_corners(self, north_west: usize) -> [usize; 4] {
        let south_west = self.beside(north_west, Direction::South);
        [
            north_west,
            self.beside(north_west, Direction::East),
            south_west,
            self.beside(south_west, Direction::East),
        ]
    }

    /// Returns the grid's rows in a bordered array, each with a point of the border at either end.
    #[inline]
    pub(crate) fn bordered_rows_mut<T: Send>(
        self,
        array: &mut [T],
    ) -> impl IndexedParallelIterator<Item = &mut [T]> {
        array.par_chunks_exact_mut(self.stride()).skip(1).take(self.rows)
    }

    /// Returns the grid's rows in a bordered array, without the border.
    #[doc(hidden)]
    #[inline]
    pub fn rows_mut<T: Send>(
        self,
        array: &mut [T],
    ) -> impl IndexedParallelIterator<Item = &mut [T]> {
        self.bordered_rows_mut(array).map(move |row| &mut row[1..=self.cols])
    }

    /// Returns the grid's rows in a bordered array in bands of `rows` rows, with their points of the border.
    #[doc(hidden)]
    #[inline]
    pub fn bands_mut<T: Send>(
        self,
        array: &mut [T],
        rows: usize,
    ) -> impl IndexedParallelIterator<Item = &mut [T]> {
        let stride = self.stride();
        array[stride..][..self.rows * stride].par_chunks_mut(rows * stride)
    }

    /// Returns the indices, in a band, of some columns of a row. Rows are counted from the band's first one.
    #[doc(hidden)]
    #[inline]
    pub const fn in_band(self, row: usize, cols: &Range<usize>) -> Range<usize> {
        let first = row * self.stride() + 1;
        first + cols.start..first + cols.end
    }

    /// Returns a row of the grid in a bordered array.
    #[doc(hidden)]
    #[inline]
    pub fn row_of<T>(self, array: &[T], row: usize) -> &[T] {
        &array[self.bordered(row, 0)..][..self.cols]
    }

    /// Returns a mutable row of the grid in a bordered array.
    #[doc(hidden)]
    #[inline]
    pub fn row_of_mut<T>(self, array: &mut [T], row: usize) -> &mut [T] {
        &mut array[self.bordered(row, 0)..][..self.cols]
    }

    /// Returns a row of the grid in a bordered array, with the rows before and after it. Each of the three
    /// has an additional point at either end, so the neighbours of the row's point c are at c, c + 1
    /// and c + 2.
    #[inline(always)]
    #[doc(hidden)]
    pub fn rows_around<T>(self, array: &[T], row: usize) -> [&[T]; 3] {
        let first = row * self.stride();
        [0, 1, 2].map(|line| &array[first + line * self.stride()..][..self.stride()])
    }

    /// Fills the rows of a bordered array before the grid's first and after its last row.
    #[doc(hidden)]
    #[inline]
    pub fn fill_border_rows<T: Copy>(self, array: &mut [T], value: T) {
        let last = array.len() - self.stride();
        array[..self.stride()].fill(value);
        array[last..].fill(value);
    }

    /// Returns the indices in a bordered array of the points of a block and its halo, the points around it.
    /// Points of the halo may belong to the border.
    #[cfg(any(test, feature = "twins"))]
    #[doc(hidden)]
    pub fn with_halo(self, block: &Block) -> impl Iterator<Item = usize> + use<> {
        let Block { rows, cols } = block.clone();
        let lines = rows.start..rows.end + 2;
        lines.flat_map(move |line| {
            (cols.start..cols.end + 2).map(move |at| line * self.stride() + at)
        })
    }

    /// Returns whether a point of a bordered array lies in a block or its halo.
    #[cfg(any(test, feature = "twins"))]
    #[doc(hidden)]
    #[inline]
    pub fn is_near(self, block: &Block, point: usize) -> bool {
        let (row, col) = self.entry(point);
        let near = |lines: &Range<usize>, at: usize| (lines.start..lines.end + 2).contains(&at);
        near(&block.rows, row) && near(&block.cols, col)
    }

    /// Converts a row-major array to a bordered one. Entries of the border have the value `border`.
    #[doc(hidden)]
    pub fn with_border<T: Copy>(self, values: &[T], border: T) -> Vec<T> {
        let mut bordered = vec![border; self.bordered_points()];
        for (row, values) in values.chunks_exact(self.cols).enumerate() {
            self.row_of_mut(&mut bordered, row).copy_from_slice(values);
        }
        bordered
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const CHART: Chart = Chart { rows: 4, cols: 5 };

    #[test]
    fn entries_agree_with_bordered_indices() {
        for direction in Direction::ALL {
            let (row, col) = CHART.neighbour(2, 2, direction).unwrap();
            let there = CHART.bordered(row, col);
            assert_eq!(CHART.bordered_position(there), (row, col));
            let (row, col) = CHART.entry(there);
            assert_eq!(CHART.entry_index(row, col), there);
            assert_eq!(CHART.short_entry(there as u32), (row as u32, col as u32));
            let place = DVec2::new(2.0, 2.0) + direction.vector();
            assert_eq!((CHART.bordered_place(there), CHART.bordered_at(place)), (place, there));
        }
    }

    #[test]
    fn rows_know_their_neighbours_and_the_border() {
        let values: Vec<_> = (0..CHART.points()).collect();
        let mut array = CHART.with_border(&values, usize::MAX);
        for (row, col) in CHART.places() {
            assert_eq!(CHART.row_of(&array, row)[col], CHART.index(row, col));
            for to in Direction::ALL {
                let (down, right) = to.step();
                let line = CHART.rows_around(&array, row)[1usize.wrapping_add_signed(down)];
                let index = CHART.neighbour(row, col, to).map(|(r, c)| CHART.index(r, c));
                let found = line[(col + 1).wrapping_add_signed(right)];
                assert_eq!(found, index.unwrap_or(usize::MAX));
                assert_eq!(found, array[CHART.beside(CHART.bordered(row, col), to)]);
            }
        }
        CHART.rows_mut(&mut array).for_each(|row| row.fill(7));
        assert_eq!(array, CHART.with_border(&[7; 20], usize::MAX));
        CHART.bordered_rows_mut(&mut array).for_each(|row| row.fill(8));
        CHART.fill_border_rows(&mut array, 8);
        assert!(array.iter().all(|&value| value == 8));
    }

    #[test]
    fn bands_are_rows_of_the_grid() {
        let (mut array, cols) = (vec![0; CHART.bordered_points()], 1..4);
        CHART.bands_mut(&mut array, 3).enumerate().for_each(|(band, points)| {
            for row in 3 * band..CHART.rows.min(3 * band + 3) {
                points[CHART.in_band(row - 3 * band, &cols)].fill(row + 1);
            }
        });
        for (row, col) in CHART.places() {
            let expected = if cols.contains(&col) { row + 1 } else { 0 };
            assert_eq!(array[CHART.bordered(row, col)], expected);
        }
        assert_eq!(array.iter().filter(|&&value| value > 0).count(), 12);
    }

    #[test]
    fn halos_are_all_neighbours_of_a_block() {
        for block in [CHART.around((0, 3), 1), CHART.around((2, 2), 0), CHART.around((3, 4), 9)] {
            let mut expected: Vec<usize> = block
                .places()
                .map(|(row, col)| CHART.bordered(row, col))
                .flat_map(|here| Direction::ALL.map(|to| CHART.beside(here, to)))
                .chain(block.places().map(|(row, col)| CHART.bordered(row, col)))
                .collect();
            expected.sort_unstable();
            expected.dedup();
            assert!(CHART.with_halo(&block).eq(expected.iter().copied()));
            let near = (0..CHART.bordered_points()).filter(|&point| CHART.is_near(&block, point));
            assert!(near.eq(expected));
        }
    }

    #[test]
    fn corners_are_those_of_the_cell() {
        for row in CHART.rows_of_cells() {
            for cell in CHART.cells_of_row(row) {
                let corners = cell.corners().map(|(row, col)| CHART.bordered(row, col));
                assert_eq!(CHART.bordered_corners(corners[0]), corners);
            }
        }
    }
}

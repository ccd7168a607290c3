//! Continuation of the grid beyond its sides.

use super::super::{Chart, GridSide, Seam};

/// The sides at which the grid continues on the opposite side: from the last column to the first one, and from
/// the last row to the first one. Each value says whether it continues in reverse order.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[doc(hidden)]
pub struct Lattice {
    pub cols: Option<bool>,
    pub rows: Option<bool>,
    /// Numbers of rows and of columns by which the grid extends beyond each seam. These lines repeat lines of the
    /// opposite side.
    pub overlap: [usize; 2],
    /// Whether sides are folded, as on octahedral maps. Grid lines then have corners inside the grid, where the lengths of
    /// their steps jump.
    pub is_folded: bool,
}

impl Lattice {
    /// Returns the continuation of the grid over a seam.
    pub(in super::super) fn of(seam: &Seam) -> Self {
        use GridSide::{FirstColumn, FirstRow, LastColumn, LastRow};
        match *seam {
            Seam::Sides {
                sides: [FirstColumn, LastColumn] | [LastColumn, FirstColumn],
                reversed,
            } => Self { cols: Some(reversed), ..Self::default() },
            Seam::Sides { sides: [FirstRow, LastRow] | [LastRow, FirstRow], reversed } => {
                Self { rows: Some(reversed), ..Self::default() }
            }
            Seam::Fold(_) => Self { is_folded: true, ..Self::default() },
            _ => Self::default(),
        }
    }

    pub(in super::super) fn and(self, other: Self) -> Self {
        Self {
            cols: self.cols.or(other.cols),
            rows: self.rows.or(other.rows),
            overlap: self.overlap,
            is_folded: self.is_folded || other.is_folded,
        }
    }

    /// Returns the grid point at a row and column, which may lie beyond the sides, or `None` where the grid does not
    /// continue.
    pub(super) fn at(self, chart: Chart, row: isize, col: isize) -> Option<(usize, usize)> {
        let (last_row, last_col) = (chart.rows as isize - 1, chart.cols as isize - 1);
        let (mut row, mut col) = (row, col);
        let [turn_of_rows, turn_of_cols] = [(last_row, 0), (last_col, 1)]
            .map(|(last, axis)| last - 2 * self.overlap[axis] as isize);
        // Every iteration of the loop moves the row or the column closer to the grid.
        loop {
            if let Some(at) = chart.at(row, col) {
                return Some(at);
            }
            if let Some(reversed) = self.cols.filter(|_| !(0..=last_col).contains(&col)) {
                col += if col < 0 { turn_of_cols } else { -turn_of_cols };
                row = if reversed { last_row - row } else { row };
            } else if let Some(reversed) = self.rows.filter(|_| !(0..=last_row).contains(&row)) {
                row += if row < 0 { turn_of_rows } else { -turn_of_rows };
                col = if reversed { last_col - col } else { col };
            } else {
                return None;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_grid_goes_on_beyond_its_seams() {
        let chart = Chart { rows: 5, cols: 7 };
        let at =
            |cols, rows, row, col| Lattice { cols, rows, ..Lattice::default() }.at(chart, row, col);
        assert_eq!(at(None, None, 2, -1), None);
        assert_eq!(at(Some(false), None, 2, -1), Some((2, 5)));
        assert_eq!(at(Some(false), None, 2, 7), Some((2, 1)));
        assert_eq!(at(Some(false), None, 5, 7), None);
        assert_eq!(at(Some(true), None, 1, -2), Some((3, 4)));
        assert_eq!(at(Some(false), Some(false), -1, 8), Some((3, 2)));
        assert_eq!(at(Some(false), Some(true), 6, 1), Some((2, 5)));
        assert_eq!(at(Some(true), Some(false), 6, 7), Some((2, 1)));
        // A row and two columns are repeated at each side: there are two steps from row 1 to its copy in row 3.
        let overlapping = |reversed, row, col| {
            let rows = Some(false);
            let lattice = Lattice { cols: Some(reversed), rows, overlap: [1, 2], is_folded: false };
            lattice.at(chart, row, col)
        };
        assert_eq!(overlapping(false, -1, 3), Some((1, 3)));
        assert_eq!(overlapping(false, 6, -1), Some((4, 1)));
        assert_eq!(overlapping(true, 1, -1), Some((3, 1)));
    }
}

//! Names the sides of the grid.

use std::fmt::{self, Display, Formatter};

use super::{Chart, Direction};

/// A side of the grid.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum GridSide {
    /// Row 0.
    FirstRow,
    /// The last row.
    LastRow,
    /// Column 0.
    FirstColumn,
    /// The last column.
    LastColumn,
}

impl GridSide {
    /// Returns row and column of the side's points, from the first row or column on.
    pub(crate) fn places(self, chart: Chart) -> impl Iterator<Item = (usize, usize)> {
        let (last_row, last_col) = chart.last();
        let (from, along) = match self {
            Self::FirstRow => ((0, 0), Direction::East),
            Self::LastRow => ((last_row, 0), Direction::East),
            Self::FirstColumn => ((0, 0), Direction::South),
            Self::LastColumn => ((0, last_col), Direction::South),
        };
        chart.walk(from, along)
    }

    /// Returns the direction from the side into the grid.
    pub(crate) fn inwards(self) -> Direction {
        match self {
            Self::FirstRow => Direction::South,
            Self::LastRow => Direction::North,
            Self::FirstColumn => Direction::East,
            Self::LastColumn => Direction::West,
        }
    }

    /// Returns whether the side is a row.
    #[inline]
    pub(crate) fn is_row(self) -> bool {
        matches!(self, Self::FirstRow | Self::LastRow)
    }

    /// Returns whether this is the first of two opposite sides, and `other` the last.
    #[inline]
    pub(crate) fn is_opposite(self, other: Self) -> bool {
        use GridSide::{FirstColumn, FirstRow, LastColumn, LastRow};
        matches!((self, other), (FirstRow, LastRow) | (FirstColumn, LastColumn))
    }
}

impl Display for GridSide {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::FirstRow => "first row",
            Self::LastRow => "last row",
            Self::FirstColumn => "first column",
            Self::LastColumn => "last column",
        })
    }
}

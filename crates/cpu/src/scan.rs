//! The four scans of an iteration: their lines, the order of these lines, and the points behind a point.

use std::ops::Range;

use geosweep_surface::lanes::Instructions;
use geosweep_surface::{Direction, Lines};

/// One of the four scans of an iteration, numbered from 1: down, up, right and left.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Scan(pub u8);

impl Scan {
    pub(super) const DOWN: Self = Self(1);
    pub(super) const UP: Self = Self(2);
    pub(super) const RIGHT: Self = Self(3);
    pub(super) const LEFT: Self = Self(4);
    pub(super) const ALL: [Self; 4] = [Self::DOWN, Self::UP, Self::RIGHT, Self::LEFT];

    /// Returns whether lines are rows.
    pub(super) fn by_rows(self) -> bool {
        self.0 <= 2
    }

    /// Returns the kind of lines that the scan passes one after another.
    pub(super) fn lines(self) -> Lines {
        if self.by_rows() { Lines::Rows } else { Lines::Cols }
    }

    /// Returns whether the scan passes lines in ascending order of their index.
    pub(super) fn is_forward(self) -> bool {
        self.0 % 2 == 1
    }

    /// Returns whether another scan passes the same lines in the opposite order.
    #[cfg(any(test, feature = "twins"))]
    pub(super) fn is_opposite(self, other: Self) -> bool {
        self != other && self.by_rows() == other.by_rows()
    }

    /// Returns a range of lines, or of bands of lines, in the order of the scan.
    pub(super) fn in_order(
        self,
        Range { start, end }: Range<usize>,
    ) -> impl Iterator<Item = usize> + use<> {
        (start..end).map(move |k| if self.is_forward() { k } else { start + end - 1 - k })
    }

    /// Returns the index of the line behind a line.
    #[inline(always)]
    pub(super) fn line_behind(self, line: usize) -> usize {
        if self.is_forward() { line - 1 } else { line + 1 }
    }

    /// Returns the step from a line to the next, in rows and columns.
    pub(super) fn ahead(self) -> [isize; 2] {
        let (row, col) = self.back().opposite().step();
        [row, col]
    }

    /// Returns the direction from a point to its neighbour on the line behind.
    pub(super) fn back(self) -> Direction {
        match self {
            Self::DOWN => Direction::North,
            Self::UP => Direction::South,
            Self::RIGHT => Direction::West,
            _ => Direction::East,
        }
    }

    /// Returns the directions from a point to the three neighbours that the scan has just passed. Their order
    /// is that of the points on their line.
    pub(super) fn behind(self) -> [Direction; 3] {
        let back = self.back();
        match self {
            Self::DOWN | Self::LEFT => [back.next(), back, back.previous()],
            _ => [back.previous(), back, back.next()],
        }
    }

    /// Returns the scan by rows that passes lines in the same order, for columns that are turned into rows.
    pub(super) fn over_lines(self) -> Self {
        if self.is_forward() { Self::DOWN } else { Self::UP }
    }

    /// Returns the flag of this scan.
    pub(super) fn bit(self) -> u8 {
        1 << self.0
    }
}

/// Options of the updates of a scan. `renews`: whether a scan may replace a front that the same scan direction
/// brought earlier. `limit`: the time after which fronts do not matter, or +infinity. Points that only later fronts
/// reach are not updated, and changes of later fronts are not passed on.
#[derive(Clone, Copy, Debug)]
pub(super) struct UpdateOptions {
    pub scan: Scan,
    pub renews: bool,
    pub limit: f64,
    pub instructions: Instructions,
}

#[cfg(test)]
mod tests {
    use super::*;
    use Direction::*;

    #[test]
    fn lines_come_after_those_behind_them() {
        for scan in Scan::ALL {
            let (down, right) = scan.back().opposite().step();
            let (line, along) = scan.lines().place(down as usize, right as usize);
            assert_eq!((line as isize, along), (if scan.is_forward() { 1 } else { -1 }, 0));
            let lines: Vec<_> = scan.in_order(3..6).collect();
            assert_eq!(lines, if scan.is_forward() { [3, 4, 5] } else { [5, 4, 3] });
        }
    }

    #[test]
    fn scans_have_passed_what_lies_behind_in_the_order_of_their_lines() {
        let behind = Scan::ALL.map(Scan::behind);
        assert_eq!(behind[0], [NorthWest, North, NorthEast]);
        assert_eq!(behind[1], [SouthWest, South, SouthEast]);
        assert_eq!(behind[2], [NorthWest, West, SouthWest]);
        assert_eq!(behind[3], [NorthEast, East, SouthEast]);
    }
}

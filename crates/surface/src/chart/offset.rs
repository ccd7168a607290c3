//! Offsets in a bordered array from a point to its neighbours, and to points farther away.

use super::{Chart, Direction};

/// Offset in a bordered array from any point to the point some rows and columns away.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Offset(isize);

impl Offset {
    /// Offset from a point to itself.
    pub(crate) const NONE: Self = Self(0);

    /// Returns the index of the point at this offset from `point`.
    #[inline(always)]
    #[doc(hidden)]
    pub const fn from(self, point: usize) -> usize {
        point.wrapping_add_signed(self.0)
    }

    /// Returns the distance between the indices of the two points.
    #[inline]
    pub(crate) const fn distance(self) -> usize {
        self.0.unsigned_abs()
    }

    /// Returns the sum of this offset and `other`.
    #[inline(always)]
    pub(crate) const fn and(self, other: Self) -> Self {
        Self(self.0 + other.0)
    }
}

impl Chart {
    /// Returns the offset to a neighbour.
    #[inline(always)]
    #[doc(hidden)]
    pub const fn offset(self, to: Direction) -> Offset {
        self.offset_by(to.step())
    }

    /// Returns the offset by some rows to the south and columns to the east. The target must be a point of the array.
    #[inline(always)]
    pub(crate) const fn offset_by(self, (down, right): (isize, isize)) -> Offset {
        Offset(down * self.stride() as isize + right)
    }

    /// Returns the index of a point's neighbour in a bordered array.
    #[inline(always)]
    #[doc(hidden)]
    pub const fn beside(self, point: usize, to: Direction) -> usize {
        self.offset(to).from(point)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn offsets_agree_with_bordered_indices() {
        let chart = Chart { rows: 4, cols: 5 };
        let here = chart.bordered(2, 2);
        for direction in Direction::ALL {
            let (row, col) = chart.neighbour(2, 2, direction).unwrap();
            let there = chart.bordered(row, col);
            assert_eq!(chart.offset(direction).from(here), there);
            assert_eq!(chart.beside(here, direction), there);
            let back = chart.offset(direction).and(chart.offset(direction.opposite()));
            assert_eq!(back, Offset::NONE);
        }
        assert_eq!(chart.offset_by((-2, 2)).from(here), chart.bordered(0, 4));
    }
}

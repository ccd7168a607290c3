//! Defines the directions to the eight neighbours of a grid point, and the turns between them.

use glam::DVec2;

/// A direction to one of the eight neighbours of a grid point, counter-clockwise from east.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[allow(missing_docs)]
pub enum Direction {
    East,
    NorthEast,
    North,
    NorthWest,
    West,
    SouthWest,
    South,
    SouthEast,
}

impl Direction {
    /// All eight directions, counter-clockwise from east.
    pub const ALL: [Self; 8] = [
        Self::East,
        Self::NorthEast,
        Self::North,
        Self::NorthWest,
        Self::West,
        Self::SouthWest,
        Self::South,
        Self::SouthEast,
    ];

    /// Returns the step to the neighbour, in rows and columns.
    pub const fn step(self) -> (isize, isize) {
        match self {
            Self::East => (0, 1),
            Self::NorthEast => (-1, 1),
            Self::North => (-1, 0),
            Self::NorthWest => (-1, -1),
            Self::West => (0, -1),
            Self::SouthWest => (1, -1),
            Self::South => (1, 0),
            Self::SouthEast => (1, 1),
        }
    }

    /// Returns the step to the neighbour as a vector of rows and columns.
    #[doc(hidden)]
    #[inline]
    pub const fn vector(self) -> DVec2 {
        let (down, right) = self.step();
        DVec2::new(down as f64, right as f64)
    }

    /// Returns whether the neighbour lies in another row and another column.
    #[doc(hidden)]
    #[inline]
    pub const fn is_diagonal(self) -> bool {
        self as usize % 2 == 1
    }

    /// Returns the opposite direction.
    #[inline]
    pub const fn opposite(self) -> Self {
        Self::ALL[ring::opposite(self as usize)]
    }

    /// Returns the direction of the next neighbour counter-clockwise. Both neighbours and the point itself
    /// span a triangle.
    #[inline]
    pub const fn next(self) -> Self {
        Self::ALL[ring::next(self as usize)]
    }

    /// Returns the direction from this neighbour to the next one counter-clockwise: the base of their
    /// triangle.
    #[inline]
    pub const fn base(self) -> Self {
        Self::ALL[((self as usize).div_ceil(2) * 2 + 2) % 8]
    }

    /// Returns the direction of the next neighbour clockwise.
    #[inline]
    pub const fn previous(self) -> Self {
        Self::ALL[ring::previous(self as usize)]
    }
}

/// Turns of directions that are given by their numbers in [`Direction::ALL`], for loops over all eight.
#[doc(hidden)]
pub mod ring {
    /// Returns the next direction counter-clockwise.
    #[inline(always)]
    #[doc(hidden)]
    pub const fn next(direction: usize) -> usize {
        (direction + 1) % 8
    }

    /// Returns the next direction clockwise.
    #[inline(always)]
    #[doc(hidden)]
    pub const fn previous(direction: usize) -> usize {
        (direction + 7) % 8
    }

    /// Returns the opposite direction.
    #[inline(always)]
    #[doc(hidden)]
    pub const fn opposite(direction: usize) -> usize {
        (direction + 4) % 8
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn opposite_directions_cancel() {
        for direction in Direction::ALL {
            assert_eq!(direction.vector() + direction.opposite().vector(), DVec2::ZERO);
            assert_eq!(direction.next().previous(), direction);
        }
    }

    #[test]
    fn bases_lead_from_a_neighbour_to_the_next() {
        for direction in Direction::ALL {
            let (from, to) = (direction.vector(), direction.next().vector());
            assert_eq!(direction.base().vector(), to - from);
            assert_eq!(direction.is_diagonal(), from.x != 0.0 && from.y != 0.0);
        }
    }
}

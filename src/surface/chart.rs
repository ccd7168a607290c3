//! The chart: an M x N grid of points, rows first, and which point lies where.
//!
//! North is towards smaller rows and east towards larger columns, as in a picture. Engines keep
//! their arrays with a border of missing points around the grid, so that no neighbour needs a
//! bounds test. All index arithmetic over neighbours is in this file; surfaces glued along
//! their borders would change nothing else.

/// The eight neighbours of a grid point, counter-clockwise from east.
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
    /// All eight, counter-clockwise from east.
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

    /// The step to the neighbour, in rows and columns.
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

    /// The direction that goes back.
    pub const fn opposite(self) -> Self {
        Self::ALL[(self as usize + 4) % 8]
    }

    /// The next neighbour counter-clockwise; the two and the point itself span a triangle.
    pub const fn next(self) -> Self {
        Self::ALL[(self as usize + 1) % 8]
    }

    /// From this neighbour to the next one counter-clockwise: the base of their triangle.
    pub const fn base(self) -> Self {
        Self::ALL[((self as usize).div_ceil(2) * 2 + 2) % 8]
    }

    /// The next neighbour clockwise.
    pub const fn previous(self) -> Self {
        Self::ALL[(self as usize + 7) % 8]
    }
}

/// Size of the grid, and the layout of the bordered arrays that the CPU engine works on.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Chart {
    /// Number of rows, M.
    pub rows: usize,
    /// Number of columns, N.
    pub cols: usize,
}

impl Chart {
    /// Number of grid points, holes included.
    pub const fn points(self) -> usize {
        self.rows * self.cols
    }

    /// Index of a grid point in a row-major array without border.
    pub const fn index(self, row: usize, col: usize) -> usize {
        row * self.cols + col
    }

    /// Row and column of an index into a row-major array without border.
    pub const fn position(self, index: usize) -> (usize, usize) {
        (index / self.cols, index % self.cols)
    }

    /// The neighbour of a grid point, if the grid has it.
    pub fn neighbour(self, row: usize, col: usize, to: Direction) -> Option<(usize, usize)> {
        let (down, right) = to.step();
        let (row, col) = (row.checked_add_signed(down)?, col.checked_add_signed(right)?);
        (row < self.rows && col < self.cols).then_some((row, col))
    }

    /// Distance between rows of a bordered array.
    pub(crate) const fn stride(self) -> usize {
        self.cols + 2
    }

    /// Number of entries of a bordered array.
    pub(crate) const fn bordered_points(self) -> usize {
        (self.rows + 2) * self.stride()
    }

    /// Index of a grid point in a bordered array.
    pub(crate) const fn bordered(self, row: usize, col: usize) -> usize {
        (row + 1) * self.stride() + col + 1
    }

    /// From a point's index to its neighbour's, both in a bordered array.
    pub(crate) const fn offset(self, to: Direction) -> isize {
        let (down, right) = to.step();
        down * self.stride() as isize + right
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn opposite_directions_cancel() {
        for direction in Direction::ALL {
            let ((a, b), (c, d)) = (direction.step(), direction.opposite().step());
            assert_eq!((a + c, b + d), (0, 0));
        }
    }

    #[test]
    fn bases_lead_from_a_neighbour_to_the_next() {
        for direction in Direction::ALL {
            let (from, to, base) =
                (direction.step(), direction.next().step(), direction.base().step());
            assert_eq!(base, (to.0 - from.0, to.1 - from.1));
        }
    }

    #[test]
    fn neighbours_end_at_the_border() {
        let chart = Chart { rows: 2, cols: 3 };
        assert_eq!(chart.neighbour(0, 0, Direction::North), None);
        assert_eq!(chart.neighbour(1, 2, Direction::East), None);
        assert_eq!(chart.neighbour(1, 2, Direction::NorthWest), Some((0, 1)));
        assert_eq!(chart.position(chart.index(1, 2)), (1, 2));
    }

    #[test]
    fn offsets_agree_with_bordered_indices() {
        let chart = Chart { rows: 4, cols: 5 };
        for direction in Direction::ALL {
            let (row, col) = chart.neighbour(2, 2, direction).unwrap();
            let offset = chart.bordered(row, col) as isize - chart.bordered(2, 2) as isize;
            assert_eq!(offset, chart.offset(direction));
        }
    }
}

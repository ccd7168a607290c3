//! Presents the chart as lines that are processed one after another: its rows, or its columns.

use super::{Block, Chart, Direction};

/// The orientation of the lines.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[doc(hidden)]
pub enum Lines {
    Rows,
    Cols,
}

impl Lines {
    /// Returns row and column of a point of a line. Given a row and a column, it returns the line and the
    /// point.
    #[inline(always)]
    #[doc(hidden)]
    pub const fn place(self, line: usize, point: usize) -> (usize, usize) {
        match self {
            Self::Rows => (line, point),
            Self::Cols => (point, line),
        }
    }

    /// Returns the direction to the next point of a line.
    pub(crate) const fn along(self) -> Direction {
        match self {
            Self::Rows => Direction::East,
            Self::Cols => Direction::South,
        }
    }

    /// Returns the number of points of a line that come before the point `index` of the chart in row-major
    /// order.
    #[doc(hidden)]
    pub const fn before(self, chart: Chart, line: usize, index: usize) -> usize {
        match self {
            Self::Rows => index.saturating_sub(chart.index(line, 0)),
            Self::Cols => index.saturating_sub(line).div_ceil(chart.cols),
        }
    }
}

impl Chart {
    /// Returns the chart whose rows are this one's columns.
    #[doc(hidden)]
    #[inline]
    pub const fn transposed(self) -> Self {
        Self { rows: self.cols, cols: self.rows }
    }

    /// Returns the distance in a bordered array from a point of a line to the next one.
    #[doc(hidden)]
    #[inline]
    pub const fn stride_along(self, lines: Lines) -> usize {
        self.offset(lines.along()).distance()
    }

    /// Returns the chart whose rows are this one's lines.
    #[doc(hidden)]
    pub const fn by(self, lines: Lines) -> Self {
        match lines {
            Lines::Rows => self,
            Lines::Cols => self.transposed(),
        }
    }
}

impl Block {
    /// Returns the block whose rows are this one's lines.
    #[doc(hidden)]
    pub fn by(self, lines: Lines) -> Self {
        match lines {
            Lines::Rows => self,
            Lines::Cols => Self { rows: self.cols, cols: self.rows },
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const CHART: Chart = Chart { rows: 4, cols: 5 };

    #[test]
    fn points_of_lines_are_those_of_the_chart() {
        for lines in [Lines::Rows, Lines::Cols] {
            let turned = CHART.by(lines);
            for (line, point) in turned.places() {
                let (row, col) = lines.place(line, point);
                assert!(row < CHART.rows && col < CHART.cols);
                assert_eq!(lines.place(row, col), (line, point));
                let next = turned.neighbour(line, point, Direction::East);
                let next = next.map(|(line, point)| lines.place(line, point));
                assert_eq!(next, CHART.neighbour(row, col, lines.along()));
            }
            let block = CHART.around((1, 4), 1);
            let turned: Vec<_> = block.clone().by(lines).places().collect();
            assert_eq!(turned.len(), 6);
            assert!(turned.into_iter().all(|(line, at)| block.has(lines.place(line, at))));
        }
    }

    #[test]
    fn lines_know_how_much_of_them_comes_before_a_point() {
        for (lines, index) in [Lines::Rows, Lines::Cols]
            .into_iter()
            .flat_map(|lines| (0..=CHART.points()).map(move |index| (lines, index)))
        {
            let turned = CHART.by(lines);
            for line in 0..turned.rows {
                let comes_before = |&point: &usize| {
                    let (row, col) = lines.place(line, point);
                    CHART.index(row, col) < index
                };
                let count = (0..turned.cols).filter(comes_before).count();
                assert_eq!(lines.before(CHART, line, index).min(turned.cols), count);
            }
        }
    }
}

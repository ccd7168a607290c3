//! Converts rows, or columns, of a given grid to those of the completed one.

/// The rows or the columns of a grid: blocks of given lines, with lines that are added before and after each block. A
/// grid is one block, unless it holds several charts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Axis {
    /// Number of blocks.
    pub blocks: usize,
    /// Number of given lines of a block.
    pub lines: usize,
    /// Number of given lines between two blocks. Between completed blocks there is one line.
    pub gap: usize,
    /// Distances of the lines that are added before and after a block, in steps between given lines. A distance is 0
    /// where no line is added.
    pub margins: [f64; 2],
}

/// Part of a step by which a row or column may be wrong because of rounding.
const ROUNDING: f64 = 1e-9;

impl Axis {
    /// Returns an axis of one block.
    pub(super) fn single(lines: usize, margins: [f64; 2]) -> Self {
        Self { blocks: 1, lines, gap: 0, margins }
    }

    /// Returns the number of given lines.
    pub(super) fn given(self) -> usize {
        self.blocks * (self.lines + self.gap) - self.gap
    }

    /// Returns the number of lines of the completed grid.
    pub(super) fn completed(self) -> usize {
        self.blocks * (self.length() + 1) - 1
    }

    /// Returns the number of lines of a completed block.
    fn length(self) -> usize {
        self.before() + self.lines + usize::from(self.margins[1] > 0.0)
    }

    /// Returns the number of lines that are added before a block.
    pub(super) fn before(self) -> usize {
        usize::from(self.margins[0] > 0.0)
    }

    /// Returns whether lines are added.
    pub(super) fn is_extended(self) -> bool {
        self.margins != [0.0; 2]
    }

    /// Converts a line of the completed grid to its index on the given grid, or `None` for an added line.
    pub(super) fn given_of(self, line: usize) -> Option<usize> {
        let (block, local) = (line / (self.length() + 1), line % (self.length() + 1));
        let local = local.checked_sub(self.before()).filter(|&local| local < self.lines)?;
        Some(block * (self.lines + self.gap) + local)
    }

    /// Returns the line of the completed grid that lies `local` lines after the first given line of a block.
    pub(super) fn line(self, block: usize, local: isize) -> usize {
        ((block * (self.length() + 1) + self.before()) as isize + local) as usize
    }

    /// Returns the line of the completed grid for each given line. Given lines between two blocks have the line between
    /// the two completed blocks.
    pub(super) fn lines_of_given(self) -> Vec<usize> {
        let pitch = self.lines + self.gap;
        let line = |given: usize| match given % pitch {
            local if local < self.lines => self.line(given / pitch, local as isize),
            _ => (given / pitch + 1) * (self.length() + 1) - 1,
        };
        (0..self.given()).map(line).collect()
    }

    /// Returns whether a place on the given grid, which may lie beyond a block by up to the margins, lies on the surface.
    pub(super) fn holds(self, at: f64) -> bool {
        let (_, local) = self.in_block(at);
        let [before, after] = self.margins.map(|margin| margin + ROUNDING);
        (-before..=self.last() + after).contains(&local)
    }

    /// Returns the line, which may be fractional, of the completed grid at a place on the given one. A place off the
    /// surface is moved to the end of its block.
    pub(super) fn to_completed(self, at: f64) -> f64 {
        let (block, local) = self.in_block(at);
        let local = self.stretched(local, self.margins.map(f64::recip)) + self.before() as f64;
        // A place on a line stays exactly on it in spite of rounding.
        let is_line = (local - local.round()).abs() <= ROUNDING;
        let local = if is_line { local.round() } else { local };
        (block * (self.length() + 1)) as f64 + local.clamp(0.0, (self.length() - 1) as f64)
    }

    /// Returns the position on the given grid of a line of the completed one: the inverse of [`Self::to_completed`].
    pub(super) fn to_given(self, at: f64) -> f64 {
        let block = block_of(at + 0.5, self.length() + 1, self.blocks);
        let local = at - (block * (self.length() + 1) + self.before()) as f64;
        (block * (self.lines + self.gap)) as f64 + self.stretched(local, self.margins)
    }

    /// Returns the block of a place on the given grid, and the place as counted from the block's first line.
    fn in_block(self, at: f64) -> (usize, f64) {
        let pitch = self.lines + self.gap;
        let block = block_of(at + 0.5, pitch, self.blocks);
        (block, at - (block * pitch) as f64)
    }

    fn last(self) -> f64 {
        (self.lines - 1) as f64
    }

    /// Multiplies the part of a place that lies beyond the first or the last given line by the factor for that end.
    fn stretched(self, at: f64, factors: [f64; 2]) -> f64 {
        match at {
            ..0.0 => at * factors[0],
            _ if at > self.last() => self.last() + (at - self.last()) * factors[1],
            _ => at,
        }
    }
}

/// Returns the index of the block that contains a position, of `blocks` blocks of `lines` lines.
fn block_of(at: f64, lines: usize, blocks: usize) -> usize {
    // A negative number is converted to 0.
    ((at / lines as f64) as usize).min(blocks - 1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_go_there_and_back() {
        let cells = Axis::single(18, [0.5, 0.5]);
        let column = Axis::single(36, [0.0, 1.0]);
        let faces = Axis { blocks: 3, lines: 5, gap: 0, margins: [0.5; 2] };
        let apart = Axis { gap: 1, ..faces };
        for (axis, given, completed) in
            [(cells, 18, 20), (column, 36, 37), (faces, 15, 23), (apart, 17, 23)]
        {
            assert_eq!([axis.given(), axis.completed()], [given, completed]);
            let lines = (0..completed).filter_map(|line| Some((line, axis.given_of(line)?)));
            assert_eq!(lines.clone().count(), axis.blocks * axis.lines);
            for (line, given) in lines {
                assert_eq!(axis.to_completed(given as f64), line as f64);
                assert_eq!(axis.to_given(line as f64), given as f64);
                let beside = given as f64 + 0.25;
                assert!((axis.to_given(axis.to_completed(beside)) - beside).abs() < 1e-12);
            }
        }
        assert_eq!([cells.to_completed(-0.25), cells.to_completed(17.5)], [0.5, 19.0]);
        assert_eq!(faces.to_given(8.0), 4.5);
        assert_eq!(apart.to_given(8.0), 5.5);
        assert!(cells.holds(-0.5) && !cells.holds(-0.51) && cells.holds(17.5));
        assert!(column.holds(36.0) && !column.holds(-0.1) && !column.holds(36.1));
        assert!(apart.holds(4.5) && !apart.holds(5.0) && apart.holds(5.5) && faces.holds(4.6));
    }
}

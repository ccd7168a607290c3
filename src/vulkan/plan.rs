//! The list of passes of a recording, as plain values that need no device: [`super::Schedule::plan`].
//!
//! An iteration of the raster schedule is four rotated scans; a scan is one dispatch for each
//! block of lines (rows or columns) of texels, each followed by a barrier. In the first iteration
//! from sources that the host knows, bounds play the part of the paper's scissor test: what lies
//! outside the box that the fronts can have reached is infinite before and after, and is not visited.
//! All other passes are dispatched indirectly, by arguments that the device sets: a scan visits the
//! blocks in which, or on the line behind which, something has changed since its last visit
//! (`glsl/blocks.glsl`), and nothing once the map has converged. No host reads anything for it.

use std::ops::Range;

use super::TexelChart;

/// The four rotated raster scans (paper, figure 3, second row), in the order of an iteration.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Scan {
    /// Towards larger rows.
    Down,
    /// Towards smaller rows.
    Up,
    /// Towards larger columns.
    Right,
    /// Towards smaller columns.
    Left,
}

impl Scan {
    /// All four, in the order of an iteration.
    pub const ALL: [Self; 4] = [Self::Down, Self::Up, Self::Right, Self::Left];

    /// The scan's direction as a step in x (columns) and y (rows).
    pub fn ahead(self) -> (i32, i32) {
        match self {
            Self::Down => (0, 1),
            Self::Up => (0, -1),
            Self::Right => (1, 0),
            Self::Left => (-1, 0),
        }
    }

    /// The name used in reports.
    pub fn name(self) -> &'static str {
        match self {
            Self::Down => "down",
            Self::Up => "up",
            Self::Right => "right",
            Self::Left => "left",
        }
    }
}

/// A block of lines of texels of a scan, or those of its lines that lie within bounds. Blocks follow one
/// another from the first row, or column, of the grid on, whichever way the scan goes. Rows and columns
/// of texels count the images' border.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct ScanPass {
    /// The scan.
    pub scan: Scan,
    /// The first row (down, up) or column (right, left) of texels, in the order of the scan.
    pub line: u32,
    /// How many of them.
    pub lines: u32,
    /// The texels visited in each.
    pub texels: Range<u32>,
    /// Which of the two images of fronts the scan writes; it reads the other.
    pub writes: usize,
    /// Whether the pass is dispatched in any case, as in the first iteration, or only if something can
    /// change in the block and the map has not converged.
    pub always: bool,
}

/// A step of a recording. After each, what it has written is visible to those that follow, and what it
/// has read may be overwritten.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub enum Step {
    /// A block of lines of a scan.
    Scan(ScanPass),
    /// All points at once.
    AllPoints {
        /// Which of the two images of fronts is written; the other is read.
        writes: usize,
    },
    /// The tiles on the list of a round.
    Tiles {
        /// Counted from 0 in the recording.
        round: u32,
    },
    /// Brings all tiles back to image 0, and decides whether more rounds follow.
    Settle {
        /// In the recording.
        rounds: u32,
    },
    /// Decides whether another iteration follows.
    Count,
}

/// A box of texels outside which nothing has been reached.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct Reached {
    /// Rows of texels.
    pub rows: Range<u32>,
    /// Columns of texels.
    pub cols: Range<u32>,
}

impl Reached {
    /// The smallest box around texels, given by row and column; `None` if there is none.
    pub fn around(texels: impl IntoIterator<Item = (u32, u32)>) -> Option<Self> {
        let point = |(row, col): (u32, u32)| Self { rows: row..row + 1, cols: col..col + 1 };
        texels.into_iter().map(point).reduce(|a, b| Self {
            rows: a.rows.start.min(b.rows.start)..a.rows.end.max(b.rows.end),
            cols: a.cols.start.min(b.cols.start)..a.cols.end.max(b.cols.end),
        })
    }

    /// The whole grid.
    pub fn everywhere(texels: TexelChart) -> Self {
        Self { rows: texels.inner_rows(), cols: texels.inner_cols() }
    }
}

/// In how large portions the grid is visited; see [`super::Tuning`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Portions {
    /// Lines of texels in a dispatch of a scan.
    pub lines: u32,
    /// Iterations of four scans in a recording, at most.
    pub iterations: u32,
    /// Points on a side of a tile.
    pub tile: u32,
    /// Rounds of tiles in a recording, at most; by default by the number of tiles.
    pub rounds: Option<u32>,
}

/// Number of iterations, or rounds of tiles, that the steps make.
pub fn iterations(steps: &[Step]) -> u32 {
    let counts = |step: &&Step| matches!(step, Step::Count | Step::Tiles { .. });
    steps.iter().filter(counts).count() as u32
}

/// Number of texels that the scans among the steps visit, as far as they are dispatched.
pub fn texels_scanned(steps: &[Step]) -> u64 {
    let visited = |step: &Step| match step {
        Step::Scan(pass) => u64::from(pass.lines) * pass.texels.len() as u64,
        _ => 0,
    };
    steps.iter().map(visited).sum()
}

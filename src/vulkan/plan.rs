//! The list of passes of a recording, as plain values that need no device.
//!
//! An iteration of the raster schedule is four rotated scans; a scan is one dispatch for each
//! block of lines (rows or columns) of texels, each followed by a barrier. In the first iteration
//! from sources that the host knows, bounds play the part of the paper's scissor test: what lies
//! outside the box that the fronts can have reached is infinite before and after, and is not visited.
//! All other passes are dispatched indirectly, by arguments that the device sets: a scan visits the
//! blocks in which, or on the line behind which, something has changed since its last visit
//! (`glsl/blocks.glsl`), and nothing once the map has converged. No host reads anything for it.

use std::ops::Range;

use super::{Schedule, TexelChart};
use crate::constants::ROUNDS;

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

/// A step of a recording.
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
    /// What the passes before have written is visible to those that follow, and what they have
    /// read may be overwritten.
    Barrier,
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

/// Iterations of two updates of all points in a recording, at most.
const ALL_POINTS_ITERATIONS: u32 = 32;

/// The steps of a recording: as many iterations (or rounds of tiles) as are worth submitting
/// together, and no more than `most`. Before and after it, all fronts are in image 0.
///
/// If the map has just been started, `reached` is the box around its sources. `lines` is
/// [`super::Tuning::scan_lines`], `tile` the number of points on a side of a tile.
///
/// ```
/// use geosweep::surface::Chart;
/// use geosweep::vulkan::{Schedule, TexelChart, plan};
/// let texels = TexelChart::new(Chart { rows: 64, cols: 64 }).unwrap();
/// let source = plan::Reached { rows: 1..2, cols: 1..2 };
/// let portions = plan::Portions { lines: 1, iterations: 4, tile: 16 };
/// let steps = plan::recording(Schedule::Raster, texels, portions, Some(source), 100);
/// // From a corner, the first scan visits about half of the texels.
/// assert!(plan::texels_scanned(&steps[..64]) < 32 * 32 * 6 / 10);
/// ```
pub fn recording(
    schedule: Schedule,
    texels: TexelChart,
    portions: Portions,
    reached: Option<Reached>,
    most: u32,
) -> Vec<Step> {
    let mut steps = Vec::new();
    match schedule {
        Schedule::Raster => {
            let mut always = reached.is_some();
            let mut reached = reached.unwrap_or_else(|| Reached::everywhere(texels));
            for _ in 0..most.min(portions.iterations) {
                for (index, scan) in Scan::ALL.into_iter().enumerate() {
                    let passes = scan_passes(texels, scan, portions.lines, &mut reached);
                    for pass in passes {
                        let writes = 1 - index % 2;
                        let pass = ScanPass { always, writes, ..pass };
                        steps.extend([Step::Scan(pass), Step::Barrier]);
                    }
                }
                steps.extend([Step::Count, Step::Barrier]);
                (always, reached) = (false, Reached::everywhere(texels));
            }
        }
        Schedule::AllPoints => {
            for _ in 0..most.min(ALL_POINTS_ITERATIONS) {
                for writes in [1, 0] {
                    steps.extend([Step::AllPoints { writes }, Step::Barrier]);
                }
                steps.extend([Step::Count, Step::Barrier]);
            }
        }
        Schedule::Tiles => {
            let across: u32 = texels.tiles(portions.tile).iter().sum();
            let rounds = across.clamp(8, ROUNDS).next_multiple_of(2).min(most);
            for round in 0..rounds {
                steps.extend([Step::Tiles { round }, Step::Barrier]);
            }
            steps.extend([Step::Settle { rounds }, Step::Barrier]);
        }
    }
    steps
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

/// The passes of one scan, and the box that can have been reached after it.
///
/// A line of texels is two of points, and a front advances by one point along a line for each
/// line of points that the scan passes: one texel for each line of texels.
fn scan_passes(texels: TexelChart, scan: Scan, block: u32, reached: &mut Reached) -> Vec<ScanPass> {
    let (inner_rows, inner_cols) = (texels.inner_rows(), texels.inner_cols());
    let (lines, inner_lines, along, inner_along) = match scan {
        Scan::Down | Scan::Up => (&mut reached.rows, inner_rows, &mut reached.cols, inner_cols),
        Scan::Right | Scan::Left => (&mut reached.cols, inner_cols, &mut reached.rows, inner_rows),
    };
    let forward = matches!(scan, Scan::Down | Scan::Right);
    let visited = if forward { lines.start..inner_lines.end } else { inner_lines.start..lines.end };
    let mut passes = Vec::with_capacity(visited.len().div_ceil(block as usize));
    let mut passed = 0;
    while passed < visited.len() as u32 {
        let left = visited.len() as u32 - passed;
        let line = if forward { visited.start + passed } else { visited.end - 1 - passed };
        // Blocks lie where they would if all lines were visited.
        let in_block = (line - inner_lines.start) % block;
        let count = if forward { block - in_block } else { in_block + 1 }.min(left);
        along.start = along.start.saturating_sub(count).max(inner_along.start);
        along.end = (along.end + count).min(inner_along.end);
        let texels = along.clone();
        passes.push(ScanPass { scan, line, lines: count, texels, writes: 1, always: true });
        passed += count;
    }
    lines.start = lines.start.min(visited.start);
    lines.end = lines.end.max(visited.end);
    passes
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::surface::Chart;

    fn texels(rows: usize, cols: usize) -> TexelChart {
        TexelChart::new(Chart { rows, cols }).unwrap()
    }

    const POINTS: Portions = Portions { lines: 1, iterations: 4, tile: 16 };

    fn scans(steps: &[Step]) -> impl Iterator<Item = &ScanPass> {
        steps.iter().filter_map(|step| if let Step::Scan(pass) = step { Some(pass) } else { None })
    }

    fn raster(texels: TexelChart, lines: u32, reached: Option<Reached>) -> Vec<Step> {
        recording(Schedule::Raster, texels, Portions { lines, ..POINTS }, reached, 1)
    }

    #[test]
    fn an_iteration_without_bounds_visits_every_texel_four_times() {
        for lines in [1, 3, 8] {
            assert_eq!(texels_scanned(&raster(texels(7, 10), lines, None)), 4 * 4 * 5);
        }
    }

    #[test]
    fn bounds_widen_by_a_texel_a_line() {
        let reached = Reached { rows: 3..4, cols: 5..6 };
        let steps = raster(texels(12, 20), 1, Some(reached.clone()));
        let passes: Vec<_> = scans(&steps).take(2).collect();
        assert_eq!((passes[0].line, passes[0].texels.clone()), (3, 4..7));
        assert_eq!((passes[1].line, passes[1].texels.clone()), (4, 3..8));
        let steps = raster(texels(12, 20), 3, Some(reached));
        // The third line is the last of a block.
        let passes: Vec<_> = scans(&steps).take(2).collect();
        assert_eq!((passes[0].line, passes[0].lines, passes[0].texels.clone()), (3, 1, 4..7));
        assert_eq!((passes[1].line, passes[1].lines, passes[1].texels.clone()), (4, 3, 1..10));
    }

    #[test]
    fn blocks_of_all_scans_lie_on_one_another() {
        let texels = texels(27, 38);
        let bounds = Reached { rows: 6..8, cols: 10..11 };
        for reached in [None, Some(bounds)] {
            for pass in scans(&raster(texels, 4, reached)) {
                let (x, y) = pass.scan.ahead();
                let ends = [0, pass.lines as i32 - 1].map(|k| pass.line as i32 + k * (x + y) - 1);
                assert_eq!(ends[0] / 4, ends[1] / 4, "{pass:?}");
            }
        }
    }

    #[test]
    fn every_pass_is_followed_by_a_barrier_and_fronts_end_in_image_0() {
        for schedule in Schedule::ALL {
            let steps = recording(schedule, texels(5, 6), POINTS, None, 3);
            assert!(
                steps.chunks(2).all(|pair| pair[0] != Step::Barrier && pair[1] == Step::Barrier)
            );
        }
        let steps = raster(texels(5, 6), 2, None);
        let mut writes: Vec<_> = scans(&steps).map(|pass| (pass.scan, pass.writes)).collect();
        writes.dedup();
        assert_eq!(writes, [(Scan::Down, 1), (Scan::Up, 0), (Scan::Right, 1), (Scan::Left, 0)]);
    }

    #[test]
    fn no_more_is_recorded_than_asked_for() {
        let count = |schedule, wanted: fn(&Step) -> bool| {
            let steps = recording(schedule, texels(500, 600), POINTS, None, 3);
            steps.iter().filter(|step| wanted(step)).count()
        };
        assert_eq!(count(Schedule::Raster, |step| *step == Step::Count), 3);
        assert_eq!(count(Schedule::AllPoints, |step| *step == Step::Count), 3);
        assert_eq!(count(Schedule::Tiles, |step| matches!(step, Step::Tiles { .. })), 3);
    }

    /// Marks what a front can reach, point by point, by the scans' own neighbourhoods.
    #[test]
    fn nothing_outside_the_bounds_can_be_reached() {
        let (rows, cols) = (13usize, 18usize);
        let texels = texels(rows, cols);
        let sources = [(0, 0), (6, 9), (12, 17), (3, 16)];
        for (source, lines) in sources.into_iter().flat_map(|source| [(source, 1), (source, 4)]) {
            let (row, col, _) = TexelChart::texel_of(source.0, source.1);
            let reached = Reached::around([(row, col)]);
            let mut points = vec![vec![false; cols]; rows];
            points[source.0][source.1] = true;
            for pass in scans(&raster(texels, lines, reached)) {
                let (dx, dy) = pass.scan.ahead();
                let forward = dx + dy > 0;
                // All points of the line's two rows or columns, in bounds or not.
                for half in 0..2 * pass.lines as usize {
                    let first = 2 * (pass.line as usize - 1);
                    let line = if forward { first + half } else { first + 1 - half };
                    let length = if dy != 0 { cols } else { rows };
                    for k in 0..length {
                        let (row, col) = if dy != 0 { (line, k) } else { (k, line) };
                        let reachable = (-1..=1).any(|side| {
                            let row = row as i32 - dy + if dx != 0 { side } else { 0 };
                            let col = col as i32 - dx + if dy != 0 { side } else { 0 };
                            (0..rows as i32).contains(&row)
                                && (0..cols as i32).contains(&col)
                                && points[row as usize][col as usize]
                        });
                        if reachable && row < rows && col < cols {
                            points[row][col] = true;
                            let along = (k / 2 + 1) as u32;
                            assert!(
                                pass.texels.contains(&along),
                                "{source:?} {pass:?} {row},{col}"
                            );
                        }
                    }
                }
            }
            assert!(points.iter().flatten().all(|&reached| reached));
        }
    }
}

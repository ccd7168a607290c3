//! The list of passes of an iteration, as plain values that need no device.
//!
//! An iteration is four rotated scans; a scan is one dispatch for each line (row or column) of
//! texels, each followed by a barrier. Bounds play the part of the paper's scissor test: what
//! lies outside the box that the fronts can have reached is infinite before and after, and is
//! not visited.

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

/// One line of texels of a scan. Rows and columns of texels count the images' border.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct ScanPass {
    /// The scan.
    pub scan: Scan,
    /// The row (down, up) or column (right, left) of texels.
    pub line: u32,
    /// The texels visited in it.
    pub texels: Range<u32>,
    /// Which of the two images of arrival times the scan writes; it reads the other.
    pub writes: usize,
}

/// A step of a recording.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub enum Step {
    /// A dispatch.
    Pass(ScanPass),
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

/// The steps of one iteration, which starts and ends in image 0 of the arrival times; `reached`
/// grows to the box that can have been reached after it.
///
/// ```
/// use geosweep::surface::Chart;
/// use geosweep::vulkan::{TexelChart, plan};
/// let texels = TexelChart::new(Chart { rows: 64, cols: 64 }).unwrap();
/// let mut reached = plan::Reached { rows: 1..2, cols: 1..2 };
/// let steps = plan::iteration(texels, &mut reached);
/// assert_eq!(reached, plan::Reached::everywhere(texels));
/// // From a corner, the first scan visits about half of the texels.
/// assert!(plan::texels_visited(&steps[..64]) < 32 * 32 * 6 / 10);
/// ```
pub fn iteration(texels: TexelChart, reached: &mut Reached) -> Vec<Step> {
    let passes = Scan::ALL
        .into_iter()
        .enumerate()
        .flat_map(|(index, scan)| scan_passes(texels, scan, 1 - index % 2, reached));
    passes.flat_map(|pass| [Step::Pass(pass), Step::Barrier]).collect()
}

/// Number of texels that the passes among the steps visit.
pub fn texels_visited(steps: &[Step]) -> u64 {
    let visited = |step: &Step| match step {
        Step::Pass(pass) => u64::from(pass.texels.end - pass.texels.start),
        Step::Barrier => 0,
    };
    steps.iter().map(visited).sum()
}

/// The passes of one scan, and the box that can have been reached after it.
///
/// A line of texels is two of points, and a front advances by one point along a line for each
/// line of points that the scan passes: one texel for each line of texels.
fn scan_passes(
    texels: TexelChart,
    scan: Scan,
    writes: usize,
    reached: &mut Reached,
) -> Vec<ScanPass> {
    let (inner_rows, inner_cols) = (texels.inner_rows(), texels.inner_cols());
    let (lines, inner_lines, along, inner_along) = match scan {
        Scan::Down | Scan::Up => (&mut reached.rows, inner_rows, &mut reached.cols, inner_cols),
        Scan::Right | Scan::Left => (&mut reached.cols, inner_cols, &mut reached.rows, inner_rows),
    };
    let visited: Vec<u32> = match scan {
        Scan::Down | Scan::Right => (lines.start..inner_lines.end).collect(),
        Scan::Up | Scan::Left => (inner_lines.start..lines.end).rev().collect(),
    };
    let mut passes = Vec::with_capacity(visited.len());
    for line in visited {
        along.start = along.start.saturating_sub(1).max(inner_along.start);
        along.end = (along.end + 1).min(inner_along.end);
        lines.start = lines.start.min(line);
        lines.end = lines.end.max(line + 1);
        passes.push(ScanPass { scan, line, texels: along.clone(), writes });
    }
    passes
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::surface::Chart;

    fn texels(rows: usize, cols: usize) -> TexelChart {
        TexelChart::new(Chart { rows, cols }).unwrap()
    }

    #[test]
    fn an_iteration_without_bounds_visits_every_texel_four_times() {
        let texels = texels(7, 10);
        let steps = iteration(texels, &mut Reached::everywhere(texels));
        assert_eq!(texels_visited(&steps), 4 * 4 * 5);
    }

    #[test]
    fn bounds_widen_by_a_texel_a_line() {
        let mut reached = Reached { rows: 3..4, cols: 5..6 };
        let steps = iteration(texels(12, 20), &mut reached);
        let Step::Pass(first) = &steps[0] else { panic!("an iteration starts with a pass") };
        assert_eq!((first.line, first.texels.clone()), (3, 4..7));
        let Step::Pass(second) = &steps[2] else { panic!("passes and barriers take turns") };
        assert_eq!((second.line, second.texels.clone()), (4, 3..8));
    }

    #[test]
    fn every_pass_is_followed_by_a_barrier_and_scans_take_turns_between_the_images() {
        let texels = texels(5, 6);
        let steps = iteration(texels, &mut Reached::everywhere(texels));
        assert!(steps.chunks(2).all(|pair| matches!(pair, [Step::Pass(_), Step::Barrier])));
        let mut writes: Vec<_> = steps
            .iter()
            .filter_map(|step| match step {
                Step::Pass(pass) => Some((pass.scan, pass.writes)),
                Step::Barrier => None,
            })
            .collect();
        writes.dedup();
        assert_eq!(writes, [(Scan::Down, 1), (Scan::Up, 0), (Scan::Right, 1), (Scan::Left, 0)]);
    }

    /// Marks what a front can reach, point by point, by the scans' own neighbourhoods.
    #[test]
    fn nothing_outside_the_bounds_can_be_reached() {
        let (rows, cols) = (13usize, 18usize);
        let texels = texels(rows, cols);
        for source in [(0, 0), (6, 9), (12, 17), (3, 16)] {
            let (row, col, _) = TexelChart::texel_of(source.0, source.1);
            let mut reached = Reached::around([(row, col)]).unwrap();
            let mut points = vec![vec![false; cols]; rows];
            points[source.0][source.1] = true;
            for step in iteration(texels, &mut reached) {
                let Step::Pass(pass) = step else { continue };
                let (dx, dy) = pass.scan.ahead();
                let forward = dx + dy > 0;
                // All points of the line's two rows or columns, in bounds or not.
                for half in if forward { [0, 1] } else { [1, 0] } {
                    let line = 2 * (pass.line as usize - 1) + half;
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

//! Lists the passes of a recording as plain values that need no device: [`crate::vulkan::Schedule::plan`].
//!
//! An iteration of the raster schedule consists of four rotated scans. A scan consists of dispatches, one for each
//! block of lines (rows or columns) of texels, each followed by a barrier. Scans run one after another, or two opposite
//! scans run as a pair, each in one half of the grid. In a pair, a barrier follows after one dispatch of each scan.
//!
//! In the first iteration from sources that the host knows, bounds replace the paper's scissor test. Outside the
//! rectangle that the fronts can have reached, all points stay unreached, and are not visited. In further iterations
//! each block is dispatched indirectly, with arguments that the device sets. A scan then visits a block if a front in
//! it, or on the line behind it, has changed since the last visit (`glsl/passes/blocks.glsl`). It visits nothing once
//! the map has converged. The host needs no readback for this.
//!
//! A pair of scans has two phases. In the first one, both scans move from the ends of the grid to its middle. In the
//! second one, each continues into the other half. Both write the same image of fronts, at different texels. Neither
//! reads what the other one writes in the phase: beyond the middle, each reads the fronts from before the phase.
//!
//! If a line fits a workgroup, one dispatch takes many blocks in turn, since dispatches that wait for one another are
//! the main cost on small grids. The workgroup checks for each block whether it is due, and barriers inside the
//! workgroup replace those between dispatches. Such scans have no bounds. Bounds save workgroups, and here a dispatch
//! has a single one.

use std::ops::Range;

use crate::vulkan::TexelChart;

/// One of the four rotated raster scans (paper, figure 3, second row), in the order of an iteration.
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
    /// All four scans, in the order of an iteration.
    pub const ALL: [Self; 4] = [Self::Down, Self::Up, Self::Right, Self::Left];

    /// Returns the scan's direction as a step in x (columns) and y (rows).
    pub fn ahead(self) -> (i32, i32) {
        match self {
            Self::Down => (0, 1),
            Self::Up => (0, -1),
            Self::Right => (1, 0),
            Self::Left => (-1, 0),
        }
    }

    /// Returns the name used in reports.
    pub fn name(self) -> &'static str {
        match self {
            Self::Down => "down",
            Self::Up => "up",
            Self::Right => "right",
            Self::Left => "left",
        }
    }
}

/// Two opposite scans that run as a pair.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum ScanPair {
    /// [`Scan::Down`] and [`Scan::Up`].
    DownUp,
    /// [`Scan::Right`] and [`Scan::Left`].
    RightLeft,
}

impl ScanPair {
    /// All pairs, in the order of an iteration.
    pub const ALL: [Self; 2] = [Self::DownUp, Self::RightLeft];

    /// Returns the pair that a scan belongs to.
    pub fn of(scan: Scan) -> Self {
        match scan {
            Scan::Down | Scan::Up => Self::DownUp,
            Scan::Right | Scan::Left => Self::RightLeft,
        }
    }

    /// Returns the scan towards larger rows or columns, then the opposite one.
    pub fn scans(self) -> [Scan; 2] {
        match self {
            Self::DownUp => [Scan::Down, Scan::Up],
            Self::RightLeft => [Scan::Right, Scan::Left],
        }
    }
}

/// Pass of a scan over a block of lines of texels, over the part of a block within bounds, or over several blocks in
/// turn. Blocks are counted from the grid's first row or column, for scans in either direction. Rows and columns of
/// texels include the border of the images.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct ScanPass {
    /// Scan to which the pass belongs.
    pub scan: Scan,
    /// First row (down, up) or column (right, left) of texels, in the order of the scan.
    pub line: u32,
    /// Number of lines.
    pub lines: u32,
    /// Texels visited in each line.
    pub texels: Range<u32>,
    /// Number of the image of fronts that the scan writes. It reads the other of the two images.
    pub writes: usize,
    /// Whether the pass visits its block unconditionally, as in the first iteration. Otherwise it visits the block only
    /// if the block is due and the map has not converged.
    pub always: bool,
    /// Whether one workgroup takes several blocks of lines, one after the other, and skips those that are not due.
    pub in_turn: bool,
    /// Number of the scan's lines before this pass that lie outside the bounds.
    pub left_out: u32,
    /// First row or column of texels of the grid's last half, if the scan runs in a pair with the opposite one.
    pub middle: Option<u32>,
    /// Whether the next pass belongs to the opposite scan and runs at the same time as this one. Neither pass depends
    /// on the other, and there is no barrier between them.
    pub beside_next: bool,
}

impl ScanPass {
    /// Returns the pair of scans to which the pass belongs, if any.
    pub(in crate::vulkan) fn pair(&self) -> Option<ScanPair> {
        self.middle.map(|_| ScanPair::of(self.scan))
    }

    /// Returns the number of blocks of `lines` lines in the pass.
    pub(in crate::vulkan) fn blocks(&self, lines: u32) -> u32 {
        if self.in_turn { self.lines.div_ceil(lines) } else { 1 }
    }

    /// Returns the number of texels that the pass visits, if it is dispatched.
    fn visits(&self) -> u64 {
        u64::from(self.lines) * self.texels.len() as u64
    }
}

/// Step of a recording. After each step its writes are visible to the following steps, which may overwrite the data
/// that it has read. The exception is a pass of a scan in a pair, which may run at the same time as the next step:
/// [`ScanPass::beside_next`].
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub enum Step {
    /// Updates a block of lines of a scan.
    Scan(ScanPass),
    /// Updates the tiles on the list of a round.
    Tiles {
        /// Number of the round in the recording, counted from 0.
        round: u32,
    },
    /// Brings all tiles back to image 0, and decides whether more rounds follow.
    Settle {
        /// Number of rounds in the recording.
        rounds: u32,
    },
    /// Gives all copies of each point of a glued surface the earliest front among them.
    Exchange {
        /// Number of the image of fronts that was written last. After a round of tiles it is 0.
        image: usize,
        /// Number of the next round of tiles in the recording, if the exchange follows a round of tiles.
        next_round: Option<u32>,
    },
    /// Decides whether another iteration follows.
    Count,
}

impl Step {
    /// Returns whether the next step runs at the same time.
    fn is_beside_next(&self) -> bool {
        matches!(self, Self::Scan(pass) if pass.beside_next)
    }
}

/// Returns the steps that run at the same time, in the order of the plan. A barrier follows each group.
pub(in crate::vulkan) fn at_once(steps: &[Step]) -> impl Iterator<Item = &[Step]> {
    steps.chunk_by(|step, _| step.is_beside_next())
}

/// Returns the steps of a map of a glued surface: `steps` with an exchange of fronts across seams after each scan, each
/// phase of a pair of scans and each round of tiles. Scans must have no bounds, since bounds do not account for fronts
/// that pass a seam.
///
/// ```
/// use geosweep::Wavefront;
/// use geosweep::surface::Chart;
/// use geosweep::vulkan::{Schedule, TexelChart, Tuning, plan};
/// let texels = TexelChart::new(Chart { rows: 200, cols: 200 }).unwrap();
/// let portions = Tuning::ON_CPU.portions(Wavefront::Planar, texels);
/// let steps = plan::with_exchanges(Schedule::Raster.plan(texels, portions, None, 1));
/// let exchanges = steps.iter().filter(|step| matches!(step, plan::Step::Exchange { .. }));
/// assert_eq!(exchanges.count(), 4);
/// ```
pub fn with_exchanges(steps: Vec<Step>) -> Vec<Step> {
    let mut all = Vec::with_capacity(steps.len() + steps.len() / 2);
    let mut steps = steps.into_iter().peekable();
    while let Some(step) = steps.next() {
        let exchange = match (&step, steps.peek()) {
            // Scans, or phases of pairs, write the two images alternately. Adjacent passes that write the same image
            // belong to the same scan or phase.
            (Step::Scan(pass), Some(Step::Scan(next))) if pass.writes == next.writes => None,
            (&Step::Scan(ScanPass { writes: image, .. }), _) => {
                Some(Step::Exchange { image, next_round: None })
            }
            (Step::Tiles { round }, _) => {
                Some(Step::Exchange { image: 0, next_round: Some(round + 1) })
            }
            (Step::Settle { .. } | Step::Exchange { .. } | Step::Count, _) => None,
        };
        all.push(step);
        all.extend(exchange);
    }
    all
}

/// Rectangle of texels outside which no point has been reached.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct Reached {
    /// Rows of texels.
    pub rows: Range<u32>,
    /// Columns of texels.
    pub cols: Range<u32>,
}

impl Reached {
    /// Returns the smallest rectangle around texels, given by row and column; `None` if there are no texels.
    pub fn around(texels: impl IntoIterator<Item = (u32, u32)>) -> Option<Self> {
        let point = |(row, col): (u32, u32)| Self { rows: row..row + 1, cols: col..col + 1 };
        texels.into_iter().map(point).reduce(|a, b| a.around_both(&b))
    }

    /// Returns the smallest rectangle around this one and another.
    pub(super) fn around_both(&self, other: &Self) -> Self {
        let around = |a: &Range<u32>, b: &Range<u32>| a.start.min(b.start)..a.end.max(b.end);
        Self { rows: around(&self.rows, &other.rows), cols: around(&self.cols, &other.cols) }
    }

    /// Returns the rectangle of the whole grid.
    pub fn everywhere(texels: TexelChart) -> Self {
        Self { rows: texels.inner_rows(), cols: texels.inner_cols() }
    }
}

/// Sizes of the portions in which a grid is updated; see [`crate::vulkan::Tuning`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Portions {
    /// Number of lines of texels in a block of a scan.
    pub lines: u32,
    /// Largest length of a line, in texels, at which one dispatch takes many blocks in turn. With 0 every dispatch
    /// takes one block.
    pub across: u32,
    /// Whether opposite scans run in pairs: [`crate::vulkan::Tuning::scan_pairs`].
    pub pairs: bool,
    /// Largest number of iterations of four scans in a recording.
    pub iterations: u32,
    /// Number of points on a side of a tile.
    pub tile: u32,
    /// Largest number of rounds of tiles in a recording. `None` selects it by the number of tiles.
    pub rounds: Option<u32>,
    /// Largest number of texels that a submission visits. The iterations of a recording visit no more texels than this,
    /// but a recording has at least one iteration, which [`parts`] cuts. A single step may still visit more.
    pub visits: u64,
}

impl Portions {
    /// Returns the number of iterations in a recording: at most `wanted`, and no more than [`Portions::visits`] allows,
    /// but at least one. An iteration visits the whole grid `visits` times.
    pub(in crate::vulkan) fn iterations_of(
        &self,
        visits: u64,
        texels: TexelChart,
        wanted: u32,
    ) -> u32 {
        (self.visits / (visits * texels.all())).clamp(1, wanted.into()) as u32
    }
}

/// Cuts the steps of a recording into several parts if they visit more than `visits` texels. Each part visits at most
/// half of `visits`, unless it is a single step, so that a submission is also a small share of an iteration. Rounds of
/// tiles are not cut, since only the device knows which tiles they visit. [`Portions::visits`] limits the number of
/// rounds in a recording instead.
///
/// ```
/// use geosweep::surface::Chart;
/// use geosweep::vulkan::{Schedule, TexelChart, plan};
/// let texels = TexelChart::new(Chart { rows: 8192, cols: 8192 }).unwrap();
/// let visits = 1 << 22;
/// let (lines, across, pairs) = (8, 0, false);
/// let portions = plan::Portions { lines, across, pairs, iterations: 4, tile: 16, rounds: None, visits };
/// let steps = Schedule::Raster.plan(texels, portions, None, 100);
/// // One iteration, in eighths of scans.
/// assert_eq!(plan::iterations(&steps), 1);
/// assert_eq!(plan::parts(&steps, visits).len(), 32);
/// ```
pub fn parts(steps: &[Step], visits: u64) -> Vec<&[Step]> {
    let visits_of = |step: &Step| match step {
        Step::Scan(pass) => pass.visits(),
        Step::Tiles { .. } | Step::Settle { .. } | Step::Exchange { .. } | Step::Count => 0,
    };
    if steps.iter().map(visits_of).sum::<u64>() <= visits {
        return vec![steps];
    }
    let mut parts = Vec::new();
    let (mut start, mut end, mut visited) = (0, 0, 0);
    for together in at_once(steps) {
        let more: u64 = together.iter().map(visits_of).sum();
        if visited > 0 && more > 0 && visited + more > visits / 2 {
            parts.push(&steps[start..end]);
            (start, visited) = (end, 0);
        }
        visited += more;
        end += together.len();
    }
    parts.push(&steps[start..]);
    parts
}

/// Returns the number of iterations, or of rounds of tiles, in the steps.
pub fn iterations(steps: &[Step]) -> u32 {
    let counts = |step: &&Step| matches!(step, Step::Count | Step::Tiles { .. });
    steps.iter().filter(counts).count() as u32
}

/// Returns the number of texels that the scans among the steps visit if all of their passes are dispatched.
pub fn texels_scanned(steps: &[Step]) -> u64 {
    let visited = |step: &Step| match step {
        Step::Scan(pass) => pass.visits(),
        _ => 0,
    };
    steps.iter().map(visited).sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Wavefront;
    use crate::surface::Chart;
    use crate::vulkan::{Schedule, Tuning};

    const TUNING: Tuning = Tuning::ON_CPU;

    fn texels(side: usize) -> TexelChart {
        TexelChart::new(Chart { rows: side, cols: side }).unwrap()
    }

    /// At 8192 points per side, a submission is a thirty-second of an iteration that visits everything.
    #[test]
    fn a_submission_is_a_small_share_of_a_large_map() {
        for (side, shares) in [(1024, 1), (2048, 1), (4096, 8), (6000, 17), (8192, 32)] {
            let texels = texels(side);
            let portions = TUNING.portions(Wavefront::Curved, texels);
            let corner = Reached::around([(1, 1)]);
            for reached in [None, corner] {
                let steps = Schedule::Raster.plan(texels, portions, reached.clone(), 100);
                assert_eq!(iterations(&steps), if side == 1024 { 4 } else { 1 });
                let parts = parts(&steps, portions.visits);
                assert_eq!(parts.concat(), steps);
                let most = parts.iter().map(|part| texels_scanned(part)).max().unwrap();
                assert!(
                    most <= portions.visits
                        && most * shares <= 4 * texels.all() * u64::from(iterations(&steps))
                );
                assert!(reached.is_some() || parts.len() as u64 >= shares, "{}", parts.len());
            }
        }
    }

    /// The two scans of a pair run at the same time, so they are cut only between groups of two blocks, one of each
    /// scan.
    #[test]
    fn steps_of_a_pair_are_not_cut_apart() {
        let texels = texels(64);
        let portions = Portions {
            visits: 1,
            across: 0,
            pairs: true,
            ..TUNING.portions(Wavefront::Planar, texels)
        };
        let steps = Schedule::Raster.plan(texels, portions, None, 1);
        let parts: Vec<_> = parts(&steps, 1).iter().map(|part| part.len()).collect();
        // Eight blocks are four steps in each phase of both pairs.
        assert_eq!(parts, [vec![2; 15], vec![3]].concat());
        assert_eq!(at_once(&steps).count(), 16 + 1);
    }

    /// Eight rows of texels are two blocks, and so are the columns. Scans of a pair have two phases.
    #[test]
    fn fronts_pass_seams_after_each_scan_phase_and_round() {
        let texels = texels(16);
        let exchanges = |schedule: Schedule, pairs: bool| {
            let portions =
                Portions { pairs, across: 0, ..TUNING.portions(Wavefront::Planar, texels) };
            let steps = with_exchanges(schedule.plan(texels, portions, None, 2));
            let place = |(place, step): (usize, &Step)| match *step {
                Step::Exchange { image, next_round } => Some((place, image, next_round)),
                _ => None,
            };
            let found: Vec<_> = steps.iter().enumerate().filter_map(place).collect();
            (steps.len(), found)
        };
        let of_scans = |exchanges: [usize; 8]| {
            let images = exchanges.into_iter().zip([1, 0].into_iter().cycle());
            images.map(|(place, image)| (place, image, None)).collect::<Vec<_>>()
        };
        let scans = of_scans([2, 5, 8, 11, 15, 18, 21, 24]);
        for pairs in [false, true] {
            assert_eq!(exchanges(Schedule::Raster, pairs), (2 * 13, scans.clone()));
        }
        assert_eq!(exchanges(Schedule::Tiles, false), (5, vec![(1, 0, Some(1)), (3, 0, Some(2))]));
    }

    #[test]
    fn steps_are_not_cut() {
        let texels = texels(64);
        let tiny = Portions { visits: 1, across: 0, ..TUNING.portions(Wavefront::Planar, texels) };
        let cut = |schedule: Schedule| {
            let steps = schedule.plan(texels, tiny, None, 100);
            let parts: Vec<_> = parts(&steps, 1).iter().map(|part| part.len()).collect();
            parts
        };
        // Raster scans have four times eight blocks, and the last part also has the count.
        let blocks = [vec![1; 31], vec![2]].concat();
        assert_eq!(cut(Schedule::Raster), blocks);
        assert_eq!(cut(Schedule::Tiles).len(), 1);
        assert_eq!(Schedule::Tiles.together(texels, tiny), 2);
    }
}

//! Plans and records the raster schedule: four rotated scans over the whole grid, in blocks of lines.

use super::iteration::{Iteration, along, block_number, lines_of, middle_block};
use super::order::{ScheduleKind, Steps};
use super::plan::{Portions, Reached, Scan, ScanPass, Step};
use crate::vulkan::device::passes::SCANS;
use crate::vulkan::device::shaders::progress::Push as Halves;
use crate::vulkan::device::shaders::scan::Push;
use crate::vulkan::record::{Groups, Recorder};
use crate::vulkan::{TexelChart, Tuning};

pub(super) struct Raster;

/// Number of blocks of lines whose dispatch arguments one update of a buffer writes: 3 KiB.
const BLOCKS_TOGETHER: usize = 256;

impl ScheduleKind for Raster {
    fn passes(&self) -> &'static [usize] {
        const PASSES: [usize; 4] =
            [SCANS[0].number(), SCANS[1].number(), SCANS[2].number(), SCANS[3].number()];
        &PASSES
    }

    fn gains_by_surroundings(&self) -> bool {
        // In other schedules fronts do not have to wait for the next scan in their direction.
        true
    }

    fn has_rounds(&self) -> bool {
        false
    }

    fn plan(
        &self,
        texels: TexelChart,
        portions: Portions,
        reached: Option<Reached>,
        most: u32,
    ) -> Vec<Step> {
        let mut steps = Vec::new();
        let in_turn = Scan::ALL.map(|scan| along(texels, scan).len() as u32 <= portions.across);
        let reached = reached.filter(|_| !in_turn.contains(&true));
        let mut always = reached.is_some();
        let mut reached = reached.unwrap_or_else(|| Reached::everywhere(texels));
        let visits = Scan::ALL.len() as u64;
        let order = Iteration { texels, lines: portions.lines, in_turn, pairs: portions.pairs };
        for _ in 0..most.min(portions.iterations_of(visits, texels, portions.iterations)) {
            let passes = order.passes(&mut reached);
            steps.extend(passes.into_iter().map(|pass| Step::Scan(ScanPass { always, ..pass })));
            steps.push(Step::Count);
            (always, reached) = (false, Reached::everywhere(texels));
        }
        steps
    }

    /// Returns the number of words of the dispatch arguments of all blocks of lines in all scans, including the blocks
    /// beyond the grid.
    fn start_words(&self, recorder: &Recorder) -> u64 {
        let pitch = recorder.grid.texels.block_pitch(recorder.pipelines.tuning.scan_lines);
        3 * Scan::ALL.len() as u64 * u64::from(pitch)
    }

    /// Writes the dispatch arguments of all blocks of lines. If sources are added to a map (`is_added`), all blocks
    /// are due in all scans: the two images of fronts may differ after the last map, and other schedules do not track
    /// blocks.
    fn start(&self, recorder: &Recorder, is_added: bool) {
        let (tuning, texels) = (recorder.pipelines.tuning, recorder.grid.texels);
        let groups = texels.inner().map(|length| length.div_ceil(tuning.scan_texels()));
        let both = 2 * u64::from(texels.block_pitch(tuning.scan_lines));
        // The first element of `groups` is the number of workgroups for a row, for the scans down and up.
        for (first, groups) in [0, both].into_iter().zip(groups) {
            let blocks = [[groups, is_added.into(), 1]; BLOCKS_TOGETHER];
            for from in (0..both).step_by(BLOCKS_TOGETHER) {
                let count = BLOCKS_TOGETHER.min((both - from) as usize);
                let bytes = bytemuck::cast_slice(&blocks[..count]);
                let offset = (first + from) * size_of::<[u32; 3]>() as u64;
                recorder.update(recorder.grid.blocks.buffer, offset, bytes);
            }
        }
    }

    fn record(&self, recording: &mut Steps, step: &Step) {
        let Step::Scan(pass) = step else { return };
        let recorder = recording.recorder;
        let (tuning, texels) = (recorder.pipelines.tuning, recorder.grid.texels);
        let number = recording.scans;
        recording.scans += pass.blocks(tuning.scan_lines);
        let note = if recording.scans <= recording.notes { number as i32 } else { -1 };
        let block = Push { note, ..block_of(pass, texels, tuning.scan_lines) };
        let groups = if pass.in_turn {
            Groups::line(1)
        } else if pass.always {
            Groups::line((pass.texels.len() as u32).div_ceil(tuning.scan_texels()))
        } else {
            let number = 1 + block_number(pass, tuning.scan_lines);
            let number = pass.scan as u32 * texels.block_pitch(tuning.scan_lines) + number;
            let offset = u64::from(number) * size_of::<[u32; 3]>() as u64;
            Groups::From(recorder.grid.blocks.buffer, offset)
        };
        recording.dispatch(SCANS[pass.scan as usize], pass.writes, &block, groups);
    }
}

/// Returns the push constants of the count that ends an iteration.
pub(super) fn halves_of(texels: TexelChart, tuning: Tuning) -> Halves {
    let lines = tuning.scan_lines;
    let of = [Scan::Down, Scan::Right].map(|scan| lines_of(texels, scan));
    let middle = of.map(|of| middle_block(&of, lines) as i32);
    Halves { middle, pitch: texels.block_pitch(lines) as i32 }
}

/// Returns the push constants of a pass over a block. The pass does not note its visit.
pub(crate) fn block_of(pass: &ScanPass, texels: TexelChart, lines: u32) -> Push {
    let last = along(texels, pass.scan).end - 1;
    Push {
        line: pass.line as i32,
        lines: pass.lines as i32,
        first: pass.texels.start as i32,
        count: pass.texels.len() as i32,
        last: last as i32,
        pitch: texels.block_pitch(lines) as i32,
        note: -1,
        in_turn: pass.in_turn.into(),
        middle: pass.middle.unwrap_or(0) as i32,
    }
}

/// Returns simultaneous steps of a plan in the order in which they are recorded. Tests also reverse this order: a
/// device that runs the steps one after another would hide that a step depends on an earlier one.
pub(super) fn in_order(together: &[Step]) -> impl Iterator<Item = &Step> {
    #[cfg(test)]
    let is_reversed = tests::PAIRS_ARE_REVERSED.get();
    #[cfg(not(test))]
    let is_reversed = false;
    let last = together.len() - 1;
    (0..together.len()).map(move |k| &together[if is_reversed { last - k } else { k }])
}

#[cfg(test)]
pub(in crate::vulkan) mod tests {
    use super::*;
    use std::cell::Cell;

    use super::super::plan;
    use crate::surface::Chart;
    use crate::vulkan::schedules::plan::{ScanPair, texels_scanned};

    thread_local! {
        /// Whether scans of a pair are recorded in the opposite order.
        pub(in crate::vulkan) static PAIRS_ARE_REVERSED: Cell<bool> = const { Cell::new(false) };
    }

    fn texels(rows: usize, cols: usize) -> TexelChart {
        TexelChart::new(Chart { rows, cols }).unwrap()
    }

    const POINTS: Portions = Portions {
        lines: 1,
        across: 0,
        pairs: false,
        iterations: 4,
        tile: 16,
        rounds: None,
        visits: u64::MAX,
    };

    fn scans(steps: &[Step]) -> impl Iterator<Item = &ScanPass> {
        steps.iter().filter_map(|step| if let Step::Scan(pass) = step { Some(pass) } else { None })
    }

    fn raster(texels: TexelChart, lines: u32, reached: Option<Reached>) -> Vec<Step> {
        Raster.plan(texels, Portions { lines, ..POINTS }, reached, 1)
    }

    fn in_pairs(texels: TexelChart, lines: u32, reached: Option<Reached>) -> Vec<Step> {
        Raster.plan(texels, Portions { lines, pairs: true, ..POINTS }, reached, 1)
    }

    #[test]
    fn an_iteration_without_bounds_visits_every_texel_four_times() {
        for lines in [1, 3, 8] {
            assert_eq!(texels_scanned(&raster(texels(7, 10), lines, None)), 4 * 4 * 5);
            assert_eq!(texels_scanned(&in_pairs(texels(7, 10), lines, None)), 4 * 4 * 5);
        }
    }

    /// Four rows of texels in blocks of three are two blocks, and nine columns are three.
    #[test]
    fn scans_of_a_pair_go_in_opposite_halves() {
        let steps = in_pairs(texels(8, 18), 3, None);
        let groups: Vec<Vec<_>> = plan::at_once(&steps)
            .map(|together| {
                scans(together).map(|pass| (pass.scan, pass.line, pass.lines)).collect()
            })
            .collect();
        use Scan::*;
        let expected: [&[_]; 7] = [
            &[(Down, 1, 3), (Up, 4, 1)],
            &[(Down, 4, 1), (Up, 3, 3)],
            &[(Right, 1, 3), (Left, 9, 3)],
            &[(Right, 4, 3)],
            &[(Right, 7, 3), (Left, 6, 3)],
            &[(Left, 3, 3)],
            // The count.
            &[],
        ];
        assert_eq!(groups, expected);
        for pass in scans(&steps) {
            let middle = if pass.pair() == Some(ScanPair::DownUp) { 4 } else { 7 };
            assert_eq!(pass.middle, Some(middle));
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
        let of_both =
            |of: Option<Reached>| [raster, in_pairs].map(|plan| plan(texels, 4, of.clone()));
        for steps in [None, Some(bounds)].into_iter().flat_map(of_both) {
            for pass in scans(&steps) {
                let (x, y) = pass.scan.ahead();
                let ends = [0, pass.lines as i32 - 1].map(|k| pass.line as i32 + k * (x + y) - 1);
                assert_eq!(ends[0] / 4, ends[1] / 4, "{pass:?}");
            }
        }
    }

    /// Marks the points that a front can reach, one by one, by the neighbourhoods of the scans. Of two scans that run
    /// at the same time, neither sees the points that the other one reaches. The image that a scan, or a phase of two
    /// scans, writes must have all points that had been reached before.
    #[test]
    fn nothing_outside_the_bounds_can_be_reached_and_nothing_reached_is_left_out() {
        let (rows, cols) = (13usize, 18usize);
        let texels = texels(rows, cols);
        let sources = [(0, 0), (6, 9), (12, 17), (3, 16), (7, 3)];
        for (source, lines) in sources.into_iter().flat_map(|source| [1, 2, 4].map(|l| (source, l)))
        {
            let (row, col, _) = TexelChart::texel_of(source.0, source.1);
            for plan in [raster, in_pairs] {
                let steps = plan(texels, lines, Reached::around([(row, col)]));
                let passes: Vec<_> = scans(&steps).collect();
                let mut points = vec![vec![false; cols]; rows];
                points[source.0][source.1] = true;
                let phases = passes.chunk_by(|a, b| a.writes == b.writes);
                for phase in phases {
                    let before = points.clone();
                    let mut written = vec![vec![false; cols]; rows];
                    for pass in phase {
                        reach(pass, &mut points, &before, &mut written);
                    }
                    for (before, written) in before.iter().flatten().zip(written.iter().flatten()) {
                        assert!(written >= before, "{source:?} {phase:?}");
                    }
                }
                assert!(points.iter().flatten().all(|&reached| reached));
            }
        }
    }

    /// Marks the points that a pass reaches and the points that it writes. Asserts that the pass writes every point
    /// that it reaches.
    fn reach(
        pass: &ScanPass,
        points: &mut [Vec<bool>],
        before: &[Vec<bool>],
        written: &mut [Vec<bool>],
    ) {
        let (rows, cols) = (points.len(), points[0].len());
        let (dx, dy) = pass.scan.ahead();
        let forward = dx + dy > 0;
        let is_first_half = |line: u32| pass.middle.is_some_and(|middle| line < middle);
        // These are all points of the line's two rows or columns, in bounds or not.
        for half in 0..2 * pass.lines as usize {
            let first = 2 * (pass.line as usize - 1);
            let line = if forward { first + half } else { first + 1 - half };
            let length = if dy != 0 { cols } else { rows };
            for k in 0..length {
                let (row, col) = if dy != 0 { (line, k) } else { (k, line) };
                if row >= rows || col >= cols {
                    continue;
                }
                let reachable = (-1..=1).any(|side| {
                    let row = row as i32 - dy + if dx != 0 { side } else { 0 };
                    let col = col as i32 - dx + if dy != 0 { side } else { 0 };
                    if !(0..rows as i32).contains(&row) || !(0..cols as i32).contains(&col) {
                        return false;
                    }
                    let behind = if dy != 0 { row } else { col } as u32 / 2 + 1;
                    let is_across = is_first_half(behind) != is_first_half(pass.line);
                    let seen = if is_across { before } else { &*points };
                    seen[row as usize][col as usize]
                });
                let along = (k / 2 + 1) as u32;
                written[row][col] |= pass.texels.contains(&along);
                if reachable {
                    points[row][col] = true;
                    assert!(pass.texels.contains(&along), "{pass:?} {row},{col}");
                }
            }
        }
    }

    /// The 70 columns of 60 texels fit a workgroup. The 60 rows of 70 texels do not.
    #[test]
    fn a_dispatch_takes_blocks_in_turn_where_lines_fit_a_workgroup() {
        let texels = texels(120, 140);
        let bounds = Reached { rows: 6..8, cols: 10..11 };
        let portions = Portions { lines: 6, across: 60, ..POINTS };
        let steps = Raster.plan(texels, portions, Some(bounds), 1);
        assert!(scans(&steps).all(|pass| !pass.always));
        let of = |scan| {
            let passes = scans(&steps).filter(move |pass| pass.scan == scan);
            passes.map(|pass| (pass.in_turn, pass.line, pass.lines, pass.blocks(6)))
        };
        assert_eq!(of(Scan::Down).count(), 10);
        assert!(
            of(Scan::Up).all(|(in_turn, _, lines, blocks)| !in_turn && lines == 6 && blocks == 1)
        );
        // Seventy lines are ten blocks in one dispatch, and a whole and a partial block in another.
        assert!(of(Scan::Right).eq([(true, 1, 60, 10), (true, 61, 10, 2)]));
        assert!(of(Scan::Left).eq([(true, 70, 10, 2), (true, 60, 60, 10)]));
        assert_eq!(texels_scanned(&steps), 4 * 60 * 70);
        // In pairs they are six blocks in each half.
        let steps = Raster.plan(texels, Portions { pairs: true, ..portions }, None, 1);
        let of = |scan| {
            let passes = scans(&steps).filter(move |pass| pass.scan == scan);
            passes.map(|pass| (pass.in_turn, pass.line, pass.lines, pass.blocks(6)))
        };
        assert!(of(Scan::Right).eq([(true, 1, 36, 6), (true, 37, 34, 6)]));
        assert!(of(Scan::Left).eq([(true, 70, 34, 6), (true, 36, 36, 6)]));
        assert_eq!(of(Scan::Up).count(), 10);
        assert_eq!(texels_scanned(&steps), 4 * 60 * 70);
    }

    #[test]
    fn fronts_end_in_image_0() {
        let steps = raster(texels(5, 6), 2, None);
        let mut writes: Vec<_> = scans(&steps).map(|pass| (pass.scan, pass.writes)).collect();
        writes.dedup();
        assert_eq!(writes, [(Scan::Down, 1), (Scan::Up, 0), (Scan::Right, 1), (Scan::Left, 0)]);
        let steps = in_pairs(texels(5, 6), 1, None);
        let mut writes: Vec<_> = scans(&steps).map(|pass| (pass.pair(), pass.writes)).collect();
        writes.dedup();
        let [rows, cols] = ScanPair::ALL.map(Some);
        assert_eq!(writes, [(rows, 1), (rows, 0), (cols, 1), (cols, 0)]);
    }
}

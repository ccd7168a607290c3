//! Plans and records the raster schedule: four rotated scans over the whole grid, in blocks of lines.

use std::ops::Range;

use super::order::{Order, Steps};
use super::plan::{Portions, Reached, Scan, ScanPass, Step};
use crate::constants::{BORDER, SCANS_FOLLOW};
use crate::vulkan::TexelChart;
use crate::vulkan::device::passes::SCANS;
use crate::vulkan::device::shaders::scan::Push;
use crate::vulkan::profile::{Area, Blocks, PassKind, PassRecord, Presence, StepCounter, Work};
use crate::vulkan::record::{Groups, Recorder};

pub(super) struct Raster;

/// Largest number of lines that a dispatch takes in turn, unless a single block has more. Mesa 22.3's
/// lavapipe ends loops of shaders after 65,535 trips, counted over all loops of an invocation. The parts of
/// obtuse triangles may take 784 trips a line.
const LINES_IN_TURN: u32 = 64;

/// Number of blocks of lines that one update of a buffer starts: 3 KiB.
const BLOCKS_TOGETHER: usize = 256;

impl Order for Raster {
    fn passes(&self) -> &'static [usize] {
        const PASSES: [usize; 4] =
            [SCANS[0].number(), SCANS[1].number(), SCANS[2].number(), SCANS[3].number()];
        &PASSES
    }

    fn follows(&self) -> u32 {
        SCANS_FOLLOW
    }

    fn gains_by_surroundings(&self) -> bool {
        // In other schedules no scan has to wait for another scan's next iteration.
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
        let in_turn = |scan| along(texels, scan).len() as u32 <= portions.across;
        let reached = reached.filter(|_| !Scan::ALL.into_iter().any(in_turn));
        let mut always = reached.is_some();
        let mut reached = reached.unwrap_or_else(|| Reached::everywhere(texels));
        let visits = Scan::ALL.len() as u64;
        for _ in 0..most.min(portions.iterations_of(visits, texels, portions.iterations)) {
            for (index, scan) in Scan::ALL.into_iter().enumerate() {
                let (in_turn, writes) = (in_turn(scan), 1 - index % 2);
                let together = if in_turn { (LINES_IN_TURN / portions.lines).max(1) } else { 1 };
                let lines = together * portions.lines;
                let passes = scan_passes(texels, scan, lines, &mut reached);
                let passes =
                    passes.into_iter().map(|pass| ScanPass { always, writes, in_turn, ..pass });
                steps.extend(passes.map(Step::Scan));
            }
            steps.push(Step::Count);
            (always, reached) = (false, Reached::everywhere(texels));
        }
        steps
    }

    /// Returns the numbers of the dispatch arguments of all blocks of lines in all scans, with the blocks
    /// beyond the grid.
    fn start_words(&self, recorder: &Recorder) -> u64 {
        let pitch = recorder.grid.texels.block_pitch(recorder.pipelines.tuning.scan_lines);
        3 * Scan::ALL.len() as u64 * u64::from(pitch)
    }

    /// Writes the dispatch arguments of all blocks of lines. Of a map to which something is added all blocks
    /// are due in all scans: the two images of fronts may differ where the map has converged, and other
    /// schedules do not track blocks.
    fn start(&self, recorder: &Recorder, is_added: bool) {
        let (tuning, texels) = (recorder.pipelines.tuning, recorder.grid.texels);
        let groups = texels.inner().map(|length| length.div_ceil(tuning.scan_texels()));
        let both = 2 * u64::from(texels.block_pitch(tuning.scan_lines));
        // Rows are as long as there are columns.
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

    fn account(&self, counter: &mut StepCounter, step: &Step) -> (PassRecord, Presence) {
        let Step::Scan(pass) = step else { return counter.count() };
        let (inner_rows, inner_cols) = (counter.texels.inner_rows(), counter.texels.inner_cols());
        let forward = matches!(pass.scan, Scan::Down | Scan::Right);
        let block = if forward {
            pass.line..pass.line + pass.lines
        } else {
            pass.line + 1 - pass.lines..pass.line + 1
        };
        let by_rows = matches!(pass.scan, Scan::Down | Scan::Up);
        let (inner_lines, length) = if by_rows {
            (inner_rows, inner_cols.len() as u64)
        } else {
            (inner_cols, inner_rows.len() as u64)
        };
        let is_first = counter.last != Some((counter.iteration, pass.scan));
        counter.last = Some((counter.iteration, pass.scan));
        let passed_over = match is_first {
            false => 0,
            true if forward => block.start - inner_lines.start,
            true => inner_lines.end - block.end,
        };
        let visited = u64::from(pass.lines) * pass.texels.len() as u64;
        let skipped = length * u64::from(pass.lines + passed_over) - visited;
        let area = if by_rows {
            Area::new(block, pass.texels.clone())
        } else {
            Area::new(pass.texels.clone(), block)
        };
        let width = |range: &std::ops::Range<u32>| range.len() as u32;
        // Passes that are dispatched indirectly have the workgroups of a whole line.
        let along = if pass.always { width(&pass.texels) } else { length as u32 };
        let count = pass.blocks(counter.tuning.scan_lines);
        let record = PassRecord {
            iteration: Some(counter.iteration),
            area: Some(area),
            groups: Some([along.div_ceil(counter.tuning.scan_texels()), 1, 1]),
            work: Work::of_scan(visited, skipped, counter.curved),
            ..PassRecord::new(PassKind::Scan(pass.scan))
        };
        let (texels, tuning, curved) = (counter.texels, counter.tuning, counter.curved);
        let (scan, block) = (pass.scan, block_number(pass, tuning.scan_lines));
        let first = counter.scans;
        counter.scans += count;
        let mut in_turn = [false; 4];
        in_turn[scan as usize] = pass.in_turn;
        let presence = match pass.always {
            true => Presence::Always,
            false => Presence::Scans(Blocks {
                texels,
                tuning,
                curved,
                scan,
                block,
                in_turn,
                first,
                count,
            }),
        };
        (record, presence)
    }
}

/// Returns the texels of a line of a scan.
fn along(texels: TexelChart, scan: Scan) -> Range<u32> {
    match scan {
        Scan::Down | Scan::Up => texels.inner_cols(),
        Scan::Right | Scan::Left => texels.inner_rows(),
    }
}

/// Returns the number of a pass's first block of lines, counted from the start of the grid.
fn block_number(pass: &ScanPass, lines: u32) -> u32 {
    (pass.line - BORDER) / lines
}

/// Returns the push constants of the pass over a block that notes no visit.
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
    }
}

/// Returns the passes of one scan, and widens `reached` to the box that can have been reached after it.
///
/// A line of texels holds two lines of points. For each line of points that the scan passes, a front advances
/// by one point along the line. That is one texel for each line of texels.
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
        // Blocks have the same places as if all lines were visited.
        let in_block = (line - inner_lines.start) % block;
        let count = if forward { block - in_block } else { in_block + 1 }.min(left);
        along.start = along.start.saturating_sub(count).max(inner_along.start);
        along.end = (along.end + count).min(inner_along.end);
        let texels = along.clone();
        passes.push(ScanPass {
            scan,
            line,
            lines: count,
            texels,
            writes: 1,
            always: true,
            in_turn: false,
        });
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
    use crate::vulkan::schedules::plan::texels_scanned;

    fn texels(rows: usize, cols: usize) -> TexelChart {
        TexelChart::new(Chart { rows, cols }).unwrap()
    }

    const POINTS: Portions =
        Portions { lines: 1, across: 0, iterations: 4, tile: 16, rounds: None, visits: u64::MAX };

    fn scans(steps: &[Step]) -> impl Iterator<Item = &ScanPass> {
        steps.iter().filter_map(|step| if let Step::Scan(pass) = step { Some(pass) } else { None })
    }

    fn raster(texels: TexelChart, lines: u32, reached: Option<Reached>) -> Vec<Step> {
        Raster.plan(texels, Portions { lines, ..POINTS }, reached, 1)
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

    /// Marks the points that a front can reach, one by one, by the neighbourhoods of the scans.
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
                // These are all points of the line's two rows or columns, in bounds or not.
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

    /// Lines of 60 texels, of which there are 70, fit a workgroup. Lines of 70 texels, of which there are 60,
    /// do not.
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
        // Seventy lines are ten blocks, then one and a part of one.
        assert!(of(Scan::Right).eq([(true, 1, 60, 10), (true, 61, 10, 2)]));
        assert!(of(Scan::Left).eq([(true, 70, 10, 2), (true, 60, 60, 10)]));
        assert_eq!(texels_scanned(&steps), 4 * 60 * 70);
    }

    #[test]
    fn fronts_end_in_image_0() {
        let steps = raster(texels(5, 6), 2, None);
        let mut writes: Vec<_> = scans(&steps).map(|pass| (pass.scan, pass.writes)).collect();
        writes.dedup();
        assert_eq!(writes, [(Scan::Down, 1), (Scan::Up, 0), (Scan::Right, 1), (Scan::Left, 0)]);
    }
}

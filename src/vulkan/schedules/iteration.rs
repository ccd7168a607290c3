//! Cuts an iteration of raster scans into passes over blocks of lines.

use std::ops::Range;

use super::plan::{Reached, Scan, ScanPair, ScanPass};
use crate::constants::BORDER;
use crate::vulkan::TexelChart;

/// Largest number of lines of a dispatch that takes several blocks, one after another. A single block may have more.
/// Mesa 22.3's lavapipe ends the loops of a shader after 65,535 iterations, counted over all loops of an invocation.
/// The parts of obtuse triangles may take 784 of them for each line.
const LINES_IN_TURN: u32 = 64;

/// Order of the passes of an iteration.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Iteration {
    pub(crate) texels: TexelChart,
    /// Number of lines in a block.
    pub(crate) lines: u32,
    /// Whether each of the four scans takes several blocks in a dispatch, one after another.
    pub(crate) in_turn: [bool; 4],
    /// Whether opposite scans go in pairs.
    pub(crate) pairs: bool,
}

impl Iteration {
    /// Returns the passes of the iteration, and widens `reached` to a box that contains all texels that fronts can
    /// have reached when the iteration ends.
    pub(super) fn passes(&self, reached: &mut Reached) -> Vec<ScanPass> {
        let mut all = Vec::new();
        if !self.pairs {
            for (index, scan) in Scan::ALL.into_iter().enumerate() {
                let lines = lines_of(self.texels, scan);
                all.extend(self.scan_passes(scan, lines, 1 - index % 2, None, reached));
            }
        } else {
            for pair in ScanPair::ALL {
                let lines = lines_of(self.texels, pair.scans()[0]);
                let middle = lines.start + middle_block(&lines, self.lines) * self.lines;
                let middle = middle.min(lines.end);
                let halves = [lines.start..middle, middle..lines.end];
                for phase in 0..2 {
                    // Neither scan sees the points that the other one reaches in the same phase.
                    let mut found = [reached.clone(), reached.clone()];
                    let [mut forth, mut back] = [0, 1].map(|way| {
                        let (scan, half) = (pair.scans()[way], halves[way ^ phase].clone());
                        let writes = 1 - phase;
                        let found = &mut found[way];
                        self.scan_passes(scan, half, writes, Some(middle), found).into_iter()
                    });
                    *reached = found[0].around_both(&found[1]);
                    loop {
                        let step = [forth.next(), back.next()];
                        let beside_next = step.iter().all(Option::is_some);
                        let [forth, back] = step;
                        if forth.is_none() && back.is_none() {
                            break;
                        }
                        all.extend(forth.map(|pass| ScanPass { beside_next, ..pass }));
                        all.extend(back);
                    }
                }
            }
        }
        let mut has_begun = [false; 4];
        for pass in &mut all {
            let lines = lines_of(self.texels, pass.scan);
            if !std::mem::replace(&mut has_begun[pass.scan as usize], true) {
                let forward = matches!(pass.scan, Scan::Down | Scan::Right);
                pass.left_out =
                    if forward { pass.line - lines.start } else { lines.end - 1 - pass.line };
            }
        }
        all
    }

    /// Returns the scan and the number of each block of an iteration that visits the whole grid, in the order in
    /// which the blocks are recorded.
    pub(crate) fn blocks(&self) -> Vec<(Scan, u32)> {
        let passes = self.passes(&mut Reached::everywhere(self.texels));
        let blocks = passes.iter().flat_map(|pass| {
            let first = block_number(pass, self.lines);
            let forward = matches!(pass.scan, Scan::Down | Scan::Right);
            let number = move |k| if forward { first + k } else { first - k };
            (0..pass.blocks(self.lines)).map(move |k| (pass.scan, number(k)))
        });
        blocks.collect()
    }

    /// Returns the passes of a scan over its lines in `half`, which may be the whole grid, and widens
    /// `reached` to a box that contains all texels that fronts can have reached when these passes end.
    ///
    /// A line of texels holds two lines of points. For each line of points that the scan passes, a front
    /// advances by one point along the line. That is one texel for each line of texels.
    fn scan_passes(
        &self,
        scan: Scan,
        half: Range<u32>,
        writes: usize,
        middle: Option<u32>,
        reached: &mut Reached,
    ) -> Vec<ScanPass> {
        let in_turn = self.in_turn[scan as usize];
        let together = if in_turn { (LINES_IN_TURN / self.lines).max(1) } else { 1 };
        let block = together * self.lines;
        let inner_along = along(self.texels, scan);
        let (lines, along) = match ScanPair::of(scan) {
            ScanPair::DownUp => (&mut reached.rows, &mut reached.cols),
            ScanPair::RightLeft => (&mut reached.cols, &mut reached.rows),
        };
        let forward = matches!(scan, Scan::Down | Scan::Right);
        let visited = if forward {
            lines.start.max(half.start)..half.end
        } else {
            half.start..lines.end.min(half.end)
        };
        let mut passes = Vec::with_capacity(visited.len().div_ceil(block as usize));
        if visited.is_empty() {
            return passes;
        }
        let mut passed = 0;
        while passed < visited.len() as u32 {
            let left = visited.len() as u32 - passed;
            let line = if forward { visited.start + passed } else { visited.end - 1 - passed };
            // Bounds do not move blocks: blocks begin at the same lines as if all lines were visited.
            let in_block = (line - half.start) % block;
            let count = if forward { block - in_block } else { in_block + 1 }.min(left);
            along.start = along.start.saturating_sub(count).max(inner_along.start);
            along.end = (along.end + count).min(inner_along.end);
            let texels = along.clone();
            passes.push(ScanPass {
                scan,
                line,
                lines: count,
                texels,
                writes,
                always: true,
                in_turn,
                left_out: 0,
                middle,
                beside_next: false,
            });
            passed += count;
        }
        lines.start = lines.start.min(visited.start);
        lines.end = lines.end.max(visited.end);
        passes
    }
}

/// Returns the lines of texels that a scan passes: rows or columns.
pub(super) fn lines_of(texels: TexelChart, scan: Scan) -> Range<u32> {
    match ScanPair::of(scan) {
        ScanPair::DownUp => texels.inner_rows(),
        ScanPair::RightLeft => texels.inner_cols(),
    }
}

/// Returns the number of the first block in the last half of a scan's lines.
pub(super) fn middle_block(lines: &Range<u32>, block: u32) -> u32 {
    (lines.len() as u32).div_ceil(block).div_ceil(2)
}

/// Returns the texels of a line of a scan.
pub(in crate::vulkan) fn along(texels: TexelChart, scan: Scan) -> Range<u32> {
    match ScanPair::of(scan) {
        ScanPair::DownUp => texels.inner_cols(),
        ScanPair::RightLeft => texels.inner_rows(),
    }
}

/// Returns the number of a pass's first block of lines, counted from the start of the grid.
pub(in crate::vulkan) fn block_number(pass: &ScanPass, lines: u32) -> u32 {
    (pass.line - BORDER) / lines
}

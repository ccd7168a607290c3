//! Which blocks of lines the scans of a recording have visited.

use super::pass::{PassKind, PassRecord};
use super::work::Work;
use crate::vulkan::plan::Scan;
use crate::vulkan::progress::VISITS;
use crate::vulkan::{TexelChart, Tuning};

/// Indirect dispatches of scans that follow one another in an iteration, each for a whole block.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Blocks {
    pub(crate) texels: TexelChart,
    pub(crate) tuning: Tuning,
    pub(crate) curved: bool,
    /// The scan of the first of these, and its block's number from the start of the grid.
    pub(crate) scan: Scan,
    pub(crate) block: u32,
    /// Whether each scan among these takes blocks in turn: by one workgroup a dispatch, which is there in any case.
    pub(crate) in_turn: [bool; 4],
    /// Number of the first in the recording.
    pub(crate) first: u32,
    pub(crate) count: u32,
}

impl Blocks {
    /// Takes the dispatches in that follow.
    pub(super) fn absorb(&mut self, next: Self) {
        self.count += next.count;
        for (scan, in_turn) in self.in_turn.iter_mut().enumerate() {
            *in_turn |= next.in_turn[scan];
        }
    }

    /// Groups of a scan beyond convergence.
    pub(super) fn beyond(&self, record: &PassRecord) -> u32 {
        match record.kind {
            PassKind::Scan(scan) if self.in_turn[scan as usize] => record.dispatches,
            _ => 0,
        }
    }

    /// The record of these as if all had visited their blocks, less those that have not; `None` if the
    /// device has not noted as many.
    pub(super) fn visited(&self, record: PassRecord, visits: &[u32]) -> Option<PassRecord> {
        let numbers = self.first..self.first + self.count;
        if numbers.end > VISITS {
            return None;
        }
        let has_visited = |number: u32| visits[number as usize / 32] >> (number % 32) & 1 != 0;
        let (mut texels, mut groups) = (0, 0);
        let place = self.place();
        for number in numbers.filter(|&number| !has_visited(number)) {
            let (of_block, along) = self.block(place + number - self.first);
            texels += of_block;
            groups += along;
        }
        let work = record.work.without(Work::of_scan(texels, 0, self.curved));
        let groups = record.groups.map(|[x, y, z]| [x - groups, y, z]);
        Some(PassRecord { groups, work, ..record })
    }

    /// Lines of a scan and their length in texels, and its blocks.
    fn of_scan(&self, scan: Scan) -> (u32, u32, u32) {
        let [cols, rows] = self.texels.inner();
        let by_rows = matches!(scan, Scan::Down | Scan::Up);
        let (lines, length) = if by_rows { (rows, cols) } else { (cols, rows) };
        (lines, length, lines.div_ceil(self.tuning.scan_lines))
    }

    /// Where in its scan's order a block comes, or the block that comes there.
    fn in_order(scan: Scan, block: u32, blocks: u32) -> u32 {
        let forward = matches!(scan, Scan::Down | Scan::Right);
        if forward { block } else { blocks - 1 - block }
    }

    /// Where in the iteration the first of these comes, counted in the order of its scans.
    fn place(&self) -> u32 {
        let blocks = |scan| self.of_scan(scan).2;
        let before = Scan::ALL.into_iter().take(self.scan as usize).map(blocks);
        before.sum::<u32>() + Self::in_order(self.scan, self.block, blocks(self.scan))
    }

    /// Texels and groups of the block that comes there, as far as these are not there in any case.
    fn block(&self, mut place: u32) -> (u64, u32) {
        let block = self.tuning.scan_lines;
        for scan in Scan::ALL {
            let (lines, length, blocks) = self.of_scan(scan);
            if place < blocks {
                let number = Self::in_order(scan, place, blocks);
                let lines = block.min(lines - number * block);
                let groups = match self.in_turn[scan as usize] {
                    true => 0,
                    false => length.div_ceil(self.tuning.scan_texels()),
                };
                return (u64::from(lines) * u64::from(length), groups);
            }
            place -= blocks;
        }
        (0, 0)
    }
}

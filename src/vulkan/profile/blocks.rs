//! Counts which blocks of lines the scans of a recording visited.

use super::pass::PassRecord;
use super::work::Work;
use crate::vulkan::record::PassKind;
use crate::vulkan::schedules::iteration::Iteration;
use crate::vulkan::schedules::plan::{Scan, ScanPair};
use crate::vulkan::schedules::progress::VISITS;

/// Consecutive blocks of lines in the scans of one iteration. The device decides which of them are due.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Blocks {
    /// Order of the blocks. A scan that takes several blocks in a dispatch has a single workgroup, which runs even if
    /// no block is due.
    pub(super) order: Iteration,
    /// Number of texels of a line that a workgroup visits.
    pub(super) group: u32,
    pub(super) curved: bool,
    /// Scan of the first block. `block` is that block's number from the start of the grid.
    pub(super) scan: Scan,
    pub(super) block: u32,
    /// Number of the first block in the recording.
    pub(super) first: u32,
    pub(super) count: u32,
}

impl Blocks {
    /// Adds the blocks of the dispatches that follow.
    pub(super) fn absorb(&mut self, next: Self) {
        self.count += next.count;
        for (scan, in_turn) in self.order.in_turn.iter_mut().enumerate() {
            *in_turn |= next.order.in_turn[scan];
        }
    }

    /// Returns the number of workgroups of a scan that runs after the map has converged.
    pub(super) fn beyond(&self, record: &PassRecord) -> u32 {
        match record.kind {
            PassKind::Scan(scan) if self.order.in_turn[scan as usize] => record.dispatches,
            PassKind::Pair(pair) if self.order.in_turn[pair.scans()[0] as usize] => {
                record.dispatches
            }
            _ => 0,
        }
    }

    /// Returns the record of these blocks without the work of blocks that the device has not visited.
    /// `record` counts all blocks as visited. Returns `None` if the device cannot note this many blocks.
    pub(super) fn visited(&self, record: PassRecord, visits: &[u32]) -> Option<PassRecord> {
        let numbers = self.first..self.first + self.count;
        if numbers.end > VISITS {
            return None;
        }
        let has_visited = |number: u32| visits[number as usize / 32] >> (number % 32) & 1 != 0;
        let (mut texels, mut groups) = (0, 0);
        let blocks =
            self.order.blocks().into_iter().skip_while(|&block| block != (self.scan, self.block));
        for (_, block) in numbers.zip(blocks).filter(|&(number, _)| !has_visited(number)) {
            let (of_block, along) = self.block(block);
            texels += of_block;
            groups += along;
        }
        let work = record.work.without(Work::of_scan(texels, 0, self.curved));
        let groups = record.groups.map(|[x, y, z]| [x - groups, y, z]);
        Some(PassRecord { groups, work, ..record })
    }

    /// Returns the texels and workgroups of a block of a scan. Workgroups that are dispatched even if the
    /// block is not due do not count.
    fn block(&self, (scan, number): (Scan, u32)) -> (u64, u32) {
        let [cols, rows] = self.order.texels.inner();
        let by_rows = ScanPair::of(scan) == ScanPair::DownUp;
        let (lines, length) = if by_rows { (rows, cols) } else { (cols, rows) };
        let block = self.order.lines;
        let lines = block.min(lines - number * block);
        let groups = match self.order.in_turn[scan as usize] {
            true => 0,
            false => length.div_ceil(self.group),
        };
        (u64::from(lines) * u64::from(length), groups)
    }
}

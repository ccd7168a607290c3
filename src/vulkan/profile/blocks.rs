//! Counts which blocks of lines the scans of a recording visited.

use super::pass::{PassKind, PassRecord};
use super::work::Work;
use crate::vulkan::schedules::Iteration;
use crate::vulkan::schedules::plan::{Scan, ScanPair};
use crate::vulkan::schedules::progress::VISITS;
use crate::vulkan::{TexelChart, Tuning};

/// Consecutive blocks of lines in the scans of one iteration. The device decides which of them are due.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Blocks {
    pub(crate) texels: TexelChart,
    pub(crate) tuning: Tuning,
    pub(crate) curved: bool,
    /// Whether opposite scans go in pairs.
    pub(crate) pairs: bool,
    /// Scan of the first block. `block` is that block's number from the start of the grid.
    pub(crate) scan: Scan,
    pub(crate) block: u32,
    /// Whether each of the four scans takes several blocks in a dispatch. The dispatch then has a single
    /// workgroup, which runs even if no block is due.
    pub(crate) in_turn: [bool; 4],
    /// Number of the first block in the recording.
    pub(crate) first: u32,
    pub(crate) count: u32,
}

impl Blocks {
    /// Adds the blocks of the dispatches that follow.
    pub(super) fn absorb(&mut self, next: Self) {
        self.count += next.count;
        for (scan, in_turn) in self.in_turn.iter_mut().enumerate() {
            *in_turn |= next.in_turn[scan];
        }
    }

    /// Returns the number of workgroups of a scan that runs after the map has converged.
    pub(super) fn beyond(&self, record: &PassRecord) -> u32 {
        match record.kind {
            PassKind::Scan(scan) if self.in_turn[scan as usize] => record.dispatches,
            PassKind::Pair(pair) if self.in_turn[pair.scans()[0] as usize] => record.dispatches,
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
        let &Self { texels: grid, pairs, in_turn, .. } = self;
        let lines = self.tuning.scan_lines;
        let order = Iteration { texels: grid, lines, in_turn, pairs }.blocks();
        let blocks = order.into_iter().skip_while(|&block| block != (self.scan, self.block));
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
        let [cols, rows] = self.texels.inner();
        let by_rows = ScanPair::of(scan) == ScanPair::DownUp;
        let (lines, length) = if by_rows { (rows, cols) } else { (cols, rows) };
        let block = self.tuning.scan_lines;
        let lines = block.min(lines - number * block);
        let groups = match self.in_turn[scan as usize] {
            true => 0,
            false => length.div_ceil(self.tuning.scan_texels()),
        };
        (u64::from(lines) * u64::from(length), groups)
    }
}

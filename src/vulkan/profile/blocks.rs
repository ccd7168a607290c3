//! Counts which blocks of lines the scans of a recording visited.

use super::pass::{PassKind, PassRecord};
use super::work::Work;
use crate::vulkan::schedules::plan::Scan;
use crate::vulkan::schedules::progress::VISITS;
use crate::vulkan::{TexelChart, Tuning};

/// Consecutive blocks of lines in the scans of one iteration. The device decides which of them are due.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Blocks {
    pub(crate) texels: TexelChart,
    pub(crate) tuning: Tuning,
    pub(crate) curved: bool,
    /// Scan of the first block. `block` is that block's number from the start of the grid.
    pub(crate) scan: Scan,
    pub(crate) block: u32,
    /// Whether each of the four scans takes its blocks in turn: by one workgroup per dispatch, which runs
    /// even if no block is due.
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

    /// Returns the number of workgroups of a scan that lies beyond convergence.
    pub(super) fn beyond(&self, record: &PassRecord) -> u32 {
        match record.kind {
            PassKind::Scan(scan) if self.in_turn[scan as usize] => record.dispatches,
            _ => 0,
        }
    }

    /// Returns the record of these blocks without those that the device has not visited. `record` counts all
    /// of them as visited. Returns `None` if the device cannot note this many blocks.
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

    /// Returns the number of lines of a scan, their length in texels, and the number of its blocks.
    fn of_scan(&self, scan: Scan) -> (u32, u32, u32) {
        let [cols, rows] = self.texels.inner();
        let by_rows = matches!(scan, Scan::Down | Scan::Up);
        let (lines, length) = if by_rows { (rows, cols) } else { (cols, rows) };
        (lines, length, lines.div_ceil(self.tuning.scan_lines))
    }

    /// Returns the position of `block` in the order of its scan. Given a position, it returns the block
    /// there.
    fn in_order(scan: Scan, block: u32, blocks: u32) -> u32 {
        let forward = matches!(scan, Scan::Down | Scan::Right);
        if forward { block } else { blocks - 1 - block }
    }

    /// Returns the position of the first block in the iteration, counted in the order of its scans.
    fn place(&self) -> u32 {
        let blocks = |scan| self.of_scan(scan).2;
        let before = Scan::ALL.into_iter().take(self.scan as usize).map(blocks);
        before.sum::<u32>() + Self::in_order(self.scan, self.block, blocks(self.scan))
    }

    /// Returns the texels and workgroups of the block at `place`. Workgroups that are dispatched in any case
    /// do not count.
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

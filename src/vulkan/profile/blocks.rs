//! Which blocks of lines the scans of a recording have visited.

use super::pass::PassRecord;
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
    /// Number of the first scan's first dispatch in the recording.
    pub(crate) iteration: u32,
    /// That of the first of these.
    pub(crate) first: u32,
    pub(crate) count: u32,
}

impl Blocks {
    /// Takes the dispatches in that follow.
    pub(super) fn absorb(&mut self, next: Self) {
        self.count += next.count;
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
        for number in numbers.filter(|&number| !has_visited(number)) {
            let (of_block, along) = self.block(number - self.iteration);
            texels += of_block;
            groups += along;
        }
        let work = record.work.without(Work::of_scan(texels, 0, self.curved));
        let groups = record.groups.map(|[x, y, z]| [x - groups, y, z]);
        Some(PassRecord { groups, work, ..record })
    }

    /// Texels and groups of a block of an iteration, counted in the order of its scans.
    fn block(&self, mut place: u32) -> (u64, u32) {
        let [cols, rows] = self.texels.inner();
        let block = self.tuning.scan_lines;
        for scan in Scan::ALL {
            let by_rows = matches!(scan, Scan::Down | Scan::Up);
            let (lines, length) = if by_rows { (rows, cols) } else { (cols, rows) };
            let blocks = lines.div_ceil(block);
            if place < blocks {
                let forward = matches!(scan, Scan::Down | Scan::Right);
                let number = if forward { place } else { blocks - 1 - place };
                let lines = block.min(lines - number * block);
                return (
                    u64::from(lines) * u64::from(length),
                    length.div_ceil(self.tuning.scan_texels()),
                );
            }
            place -= blocks;
        }
        (0, 0)
    }
}

//! Copies the decisions of the device while steps are recorded, and reads them back.

use ash::vk;

use crate::constants::{ROUNDS, VISIT_WORDS};
use crate::vulkan::device::barrier::{PASS, PASS_AND_HOST, TRANSFER, TRANSFER_READ};
use crate::vulkan::record::{Commands, PassKind};
use crate::vulkan::schedules::plan::Step;
use crate::vulkan::schedules::progress;
use crate::vulkan::schedules::progress::{Outcome, VISITS, offset};

/// Bytes of the copies for a portion of steps: the outcome of the iterations before the portion, then the
/// whole progress after it.
pub(super) const BYTES: u64 = BEFORE + progress::BYTES;
/// Bytes of the copy before the portion.
const BEFORE: u64 = size_of::<Outcome>() as u64;

/// Decisions of the device in a portion of steps.
pub(super) struct Decisions {
    /// Number of iterations of the map before the portion.
    pub(super) before: u32,
    /// Number of iterations of the map after the portion.
    pub(super) after: u32,
    /// Whether the map is done after the portion.
    pub(super) is_done: bool,
    /// For each round of the portion, the number of tiles on its list, and the number of those tiles that
    /// waited for the next round.
    pub(super) rounds: Vec<[u32; 2]>,
    /// Number of texels that were brought back to one image after the rounds.
    pub(super) settled: u32,
    /// A bit for each block of lines in the scans of the portion. It says whether the scan visited the block.
    pub(super) visits: Vec<u32>,
}

impl Decisions {
    /// Reads the decisions from the bytes of a portion.
    pub(super) fn read(bytes: &[u8]) -> Self {
        let (before, after) = bytes.split_at(BEFORE as usize);
        let outcome =
            |bytes: &[u8]| -> Outcome { bytemuck::pod_read_unaligned(&bytes[..BEFORE as usize]) };
        let number = |offset: u64| {
            let at = offset as usize;
            u32::from_ne_bytes(after[at..at + 4].try_into().expect("these are four bytes"))
        };
        let (before, after) = (outcome(before).iterations, outcome(after));
        Self {
            before,
            after: after.iterations.max(before),
            is_done: after.is_done(),
            rounds: (0..ROUNDS)
                .map(|round| [offset::listed(round), offset::waited(round)].map(number))
                .collect(),
            settled: number(offset::SETTLED),
            visits: (0..VISIT_WORDS).map(|k| number(offset::VISITS + 4 * u64::from(k))).collect(),
        }
    }
}

/// Returns the number of blocks of scans whose visits the device notes, which is limited.
pub(super) fn visits_noted(steps: &[Step], lines: u32) -> u32 {
    let blocks = steps.iter().map(|step| match step {
        Step::Scan(pass) => pass.blocks(lines),
        _ => 0,
    });
    blocks.sum::<u32>().min(VISITS)
}

/// Returns the size in bytes of the notes of visits to blocks.
fn bytes_of(visits: u32) -> u64 {
    u64::from(visits.div_ceil(32)) * size_of::<u32>() as u64
}

/// Copies the outcome of the iterations so far, and clears the notes of visits to blocks.
pub(super) fn copy_before(
    commands: &Commands,
    progress: vk::Buffer,
    to: (vk::Buffer, u64),
    visits: u32,
) {
    let _pass = commands.pass(PassKind::Decisions);
    commands.barrier(PASS, TRANSFER);
    commands.copy((progress, 0), to, BEFORE);
    if visits > 0 {
        commands.fill(progress, offset::VISITS, bytes_of(visits));
    }
    commands.barrier(TRANSFER, PASS_AND_HOST);
}

/// Copies the device's decisions, with the notes of visits to blocks.
pub(super) fn copy_after(
    commands: &Commands,
    progress: vk::Buffer,
    (to, start): (vk::Buffer, u64),
    visits: u32,
) {
    let _pass = commands.pass(PassKind::Decisions);
    let size = offset::VISITS + bytes_of(visits);
    copy_for_host(commands, (progress, 0), (to, start + BEFORE), size);
}

/// Copies data that passes have written into a buffer that the host reads while later passes of the map run.
pub(super) fn copy_for_host(
    commands: &Commands,
    from: (vk::Buffer, u64),
    to: (vk::Buffer, u64),
    size: u64,
) {
    commands.barrier(PASS, TRANSFER_READ);
    commands.copy(from, to, size);
    commands.barrier(TRANSFER, PASS_AND_HOST);
}

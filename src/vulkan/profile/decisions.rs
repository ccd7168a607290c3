//! Reads the device's decisions from the copies that a recording makes of them.

use super::presence::Decisions;
use crate::constants::{ROUNDS, VISIT_WORDS};
use crate::vulkan::schedules::progress;
use crate::vulkan::schedules::progress::{Outcome, offset};

/// Bytes of the copies for a portion of steps: the outcome of the iterations before the portion, then the
/// whole progress after it.
pub(crate) const BYTES: u64 = BEFORE + progress::BYTES;
/// Bytes of the copy before the portion.
pub(crate) const BEFORE: u64 = size_of::<Outcome>() as u64;

/// Decisions of a portion, read back from the device.
pub(crate) struct ReadBack {
    before: u32,
    after: u32,
    is_done: bool,
    rounds: Vec<[u32; 2]>,
    settled: u32,
    visits: Vec<u32>,
}

impl ReadBack {
    /// Reads the decisions from the bytes of a portion.
    pub(crate) fn new(bytes: &[u8]) -> Self {
        let (before, after) = bytes.split_at(BEFORE as usize);
        let outcome =
            |bytes: &[u8]| -> Outcome { bytemuck::pod_read_unaligned(&bytes[..BEFORE as usize]) };
        let number = |offset: u64| {
            let at = offset as usize;
            u32::from_ne_bytes(after[at..at + 4].try_into().expect("these are four bytes"))
        };
        Self {
            before: outcome(before).iterations,
            after: outcome(after).iterations,
            is_done: outcome(after).is_done(),
            rounds: (0..ROUNDS)
                .map(|round| [offset::listed(round), offset::waited(round)].map(number))
                .collect(),
            settled: number(offset::SETTLED),
            visits: (0..VISIT_WORDS).map(|k| number(offset::VISITS + 4 * u64::from(k))).collect(),
        }
    }

    pub(crate) fn decisions(&self) -> Decisions<'_> {
        let Self { before, after, is_done, ref rounds, settled, ref visits } = *self;
        Decisions { before, after: after.max(before), is_done, rounds, settled, visits }
    }
}

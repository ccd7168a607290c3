//! Turns the results of queries, and what a profile knows of passes, into records.

use ash::vk;

use super::clock::Clock;
use super::decisions::Decisions;
use super::pass::PassRecord;
use super::presence::decided;
use super::recorded::{Entry, Profile, Taken};
use super::slots::{QueryRange, Slots};
use crate::vulkan::VulkanError;

/// Records of a recording, read back.
#[derive(Clone, Debug, PartialEq)]
pub struct Resolved {
    /// Passes in the order of recording.
    pub passes: Vec<PassRecord>,
    /// Device's time at the start of the recording, in ticks of its clock.
    pub start: Option<u64>,
    /// Number of passes for which there was no room.
    pub left_out: u32,
}

impl Profile {
    /// Returns the records of the last recording; `Ok(None)` if the device has not reached its end. This call
    /// does not wait. `decisions` are the contents of [`Slots::decisions`] from its offset on. Read them once
    /// the fence of the submission is signalled. Without them the device's decisions stay unknown.
    ///
    /// # Errors
    /// If the device is lost.
    pub fn resolve(
        &self,
        device: &ash::Device,
        clock: Option<Clock>,
        decisions: Option<&[u8]>,
    ) -> Result<Option<Resolved>, VulkanError> {
        let taken = self.taken();
        let Taken { entries, timestamps, portions: ended, left_out, .. } = &*taken;
        let times = match self.slots.timestamps {
            Some(range) => results(device, range, *timestamps as usize + 1)?,
            None => Some(Vec::new()),
        };
        let invocations = match self.slots.statistics {
            Some(range) => results(device, range, entries.len())?,
            None => Some(Vec::new()),
        };
        let Some((times, invocations)) = times.zip(invocations) else { return Ok(None) };
        let room = self.slots.decisions.map_or(0, |decided| decided.portions);
        let portions: Vec<_> = decisions
            .map(|bytes| bytes.chunks_exact(Slots::DECISION_BYTES as usize))
            .into_iter()
            .flatten()
            .take(room.min(*ended) as usize)
            .map(Decisions::read)
            .collect();
        let with_invocations = |(number, entry): (usize, &Entry)| {
            let found = portions.get(entry.portion as usize);
            let record = decided(entry.record, entry.presence, found);
            PassRecord { invocations: invocations.get(number).copied(), ..record }
        };
        let found: Vec<_> = entries.iter().enumerate().map(with_invocations).collect();
        let mut rest = &found[..];
        let passes = entries.chunk_by(|a, b| a.timestamp == b.timestamp).map(|entries| {
            let (passes, following) = rest.split_at(entries.len());
            rest = following;
            let number = entries[0].timestamp as usize;
            let time = |number: usize| times.get(number).copied();
            let at = |number: usize| Some(clock?.nanoseconds(time(0)?, time(number)?));
            let (begin, end) = (at(number - 1), at(number));
            let record = match passes {
                [pass] => *pass,
                passes => PassRecord::of_portion(passes),
            };
            PassRecord {
                begin,
                nanoseconds: begin.zip(end).map(|(begin, end)| end.saturating_sub(begin)),
                ..record
            }
        });
        let passes = passes.collect();
        let start = clock.and(times.first().copied());
        Ok(Some(Resolved { passes, start, left_out: *left_out }))
    }
}

/// Returns the results of the first `count` queries of a range; `None` if some are not available yet.
pub(super) fn results(
    device: &ash::Device,
    range: QueryRange,
    count: usize,
) -> Result<Option<Vec<u64>>, VulkanError> {
    // Each result is followed by its availability.
    let mut results = vec![[0u64; 2]; count];
    if results.is_empty() {
        return Ok(Some(Vec::new()));
    }
    let flags = vk::QueryResultFlags::TYPE_64 | vk::QueryResultFlags::WITH_AVAILABILITY;
    // SAFETY: the queries are the host's, and a result is two 64-bit numbers.
    let read =
        unsafe { device.get_query_pool_results(range.pool, range.first, &mut results, flags) };
    match read {
        Ok(()) | Err(vk::Result::NOT_READY) => {}
        Err(result) => return Err(VulkanError::Call { call: "vkGetQueryPoolResults", result }),
    }
    let all = results.iter().all(|[_, available]| *available != 0);
    Ok(all.then(|| results.into_iter().map(|[result, _]| result).collect()))
}

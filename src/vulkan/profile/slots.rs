//! The host's queries that a recording fills, and what becomes of them frames later.

use std::sync::{Mutex, MutexGuard, PoisonError};

use ash::vk;

use super::clock::Clock;
use super::decisions::{self, ReadBack};
use super::pass::{Grain, PassKind, PassRecord};
use super::presence::{Presence, decided};
use crate::vulkan::VulkanError;

/// A range of a query pool of the host's.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct QueryRange {
    /// The pool.
    pub pool: vk::QueryPool,
    /// Its first query that we may use.
    pub first: u32,
    /// How many.
    pub count: u32,
}

/// What a profile may use of the host's. All parts are optional: what is missing is not in the
/// records.
///
/// For `passes` passes in a recording:
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Slots {
    /// `passes + 1` queries of a pool of type `TIMESTAMP`: the first at the start of the recording,
    /// the next at the end of each pass in turn; with [`Grain::Portions`] the last ones stay unused.
    pub timestamps: Option<QueryRange>,
    /// `passes` queries of a pool of type `PIPELINE_STATISTICS` with the one statistic
    /// `COMPUTE_SHADER_INVOCATIONS`, one for each pass; the device feature `pipelineStatisticsQuery`
    /// must be enabled. They may make passes slower: count in other frames than those you time.
    pub statistics: Option<QueryRange>,
    /// A buffer with usage `TRANSFER_DST`, which the host can read, with
    /// [`Slots::DECISION_BYTES`] for each call of [`super::super::embed::Recording::solve`], `add`
    /// or `resume` in a recording, from an offset that is a multiple of 4: what the device has
    /// decided, such as the tiles that it has visited.
    pub decisions: Option<Decided>,
    /// Of the tiles that each round has visited their numbers, row by row of tiles: `None` unless
    /// you want to draw them, since the copies take time. A buffer like the last, with four bytes
    /// for each tile of the grid and each round of the plan; only the last portion is kept.
    pub tile_lists: Option<(vk::Buffer, u64)>,
}

/// A buffer for what the device decides.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Decided {
    /// The buffer.
    pub buffer: vk::Buffer,
    /// In bytes.
    pub offset: u64,
    /// For how many portions it has room.
    pub portions: u32,
}

impl Slots {
    /// Bytes of a portion of steps in [`Slots::decisions`].
    pub const DECISION_BYTES: u64 = decisions::BYTES;
}

/// The passes of one recording as they are recorded, and where their times will be.
///
/// Made once for each frame in flight; recording into it allocates nothing. One recording at a time.
pub struct Profile {
    slots: Slots,
    grain: Grain,
    /// Passes that there is room for.
    room: usize,
    taken: Mutex<Taken>,
}

/// What has been taken down so far.
struct Taken {
    entries: Vec<Entry>,
    /// Timestamps after the first.
    timestamps: u32,
    /// Whether the last entries still wait for theirs.
    waits: bool,
    /// Ended.
    portions: u32,
    /// Passes without room.
    left_out: u32,
}

#[derive(Clone, Copy)]
struct Entry {
    record: PassRecord,
    presence: Presence,
    /// That it belongs to.
    portion: u32,
    /// The number of the one at its end, of the first entry of a recording 1. Entries that are one
    /// record share it.
    timestamp: u32,
}

/// What a recording has taken, read back.
#[derive(Clone, Debug, PartialEq)]
pub struct Resolved {
    /// The passes in their order.
    pub passes: Vec<PassRecord>,
    /// The device's time at the start of the recording, in ticks of its clock.
    pub start: Option<u64>,
    /// Passes for which there was no room.
    pub left_out: u32,
}

impl Profile {
    /// With room for so many records of this grain, and so many queries in each range (see [`Slots`]):
    /// [`super::super::embed::Solver::passes_of_frame`] says how many a frame takes.
    pub fn new(passes: u32, grain: Grain, slots: Slots) -> Self {
        // An empty range is none.
        let usable = |range: Option<QueryRange>| range.filter(|range| range.count > 0);
        let slots = Slots {
            timestamps: usable(slots.timestamps),
            statistics: usable(slots.statistics),
            ..slots
        };
        let fits = |range: Option<QueryRange>, more: u32| {
            range.map_or(passes, |range| range.count.saturating_sub(more))
        };
        let room = passes.min(fits(slots.timestamps, 1)).min(fits(slots.statistics, 0)) as usize;
        Self {
            slots,
            grain,
            room,
            taken: Mutex::new(Taken {
                entries: Vec::with_capacity(room),
                timestamps: 0,
                waits: false,
                portions: 0,
                left_out: 0,
            }),
        }
    }

    fn taken(&self) -> MutexGuard<'_, Taken> {
        self.taken.lock().unwrap_or_else(PoisonError::into_inner)
    }

    pub(crate) fn grain(&self) -> Grain {
        self.grain
    }

    /// Starts anew, in a command buffer outside a render pass.
    pub(crate) fn begin(&self, device: &ash::Device, commands: vk::CommandBuffer) {
        let mut taken = self.taken();
        taken.entries.clear();
        (taken.timestamps, taken.waits) = (0, false);
        (taken.portions, taken.left_out) = (0, 0);
        drop(taken);
        for range in [self.slots.timestamps, self.slots.statistics].into_iter().flatten() {
            // SAFETY: the host has given us this range of a pool of this device.
            unsafe {
                device.cmd_reset_query_pool(commands, range.pool, range.first, range.count);
            }
        }
        self.write_timestamp(device, commands, 0);
    }

    /// Before a pass of a kind: its number, if there is room for it.
    pub(crate) fn open(
        &self,
        device: &ash::Device,
        commands: vk::CommandBuffer,
        kind: PassKind,
    ) -> Option<usize> {
        let mut taken = self.taken();
        // How the iterations of a portion have gone belongs to it, if it has not ended.
        if !matches!(kind, PassKind::Portion | PassKind::Outcome) {
            self.end_record(device, commands, &mut taken);
        }
        let number = taken.entries.len();
        if number == self.room {
            taken.left_out += 1;
            return None;
        }
        drop(taken);
        if let Some(QueryRange { pool, first, .. }) = self.slots.statistics {
            let (query, flags) = (first + number as u32, vk::QueryControlFlags::empty());
            // SAFETY: the query is the host's, was reset at the beginning, and is not active.
            unsafe { device.cmd_begin_query(commands, pool, query, flags) };
        }
        Some(number)
    }

    /// After it.
    pub(crate) fn close(
        &self,
        device: &ash::Device,
        commands: vk::CommandBuffer,
        number: usize,
        (record, presence): (PassRecord, Presence),
    ) {
        if let Some(QueryRange { pool, first, .. }) = self.slots.statistics {
            // SAFETY: the query was begun by `open`.
            unsafe { device.cmd_end_query(commands, pool, first + number as u32) };
        }
        // The steps of a portion come before the copy of what was decided in it.
        let mut taken = self.taken();
        let (portion, timestamp) = (taken.portions, taken.timestamps + 1);
        taken.entries.push(Entry { record, presence, portion, timestamp });
        taken.waits = true;
        if record.kind != PassKind::Portion {
            self.end_record(device, commands, &mut taken);
        }
    }

    /// After the last of the entries that are one record.
    fn end_record(&self, device: &ash::Device, commands: vk::CommandBuffer, taken: &mut Taken) {
        if std::mem::take(&mut taken.waits) {
            taken.timestamps += 1;
            self.write_timestamp(device, commands, taken.timestamps);
        }
    }

    /// Where to copy the decisions of this portion, if there is room.
    pub(crate) fn decisions(&self) -> Option<(vk::Buffer, u64)> {
        let Decided { buffer, offset, portions } = self.slots.decisions?;
        let number = self.taken().portions;
        let at = offset + u64::from(number) * Slots::DECISION_BYTES;
        (number < portions).then_some((buffer, at))
    }

    /// Where to copy the lists of tiles.
    pub(crate) fn tile_lists(&self) -> Option<(vk::Buffer, u64)> {
        self.slots.tile_lists
    }

    /// After a portion of steps.
    pub(crate) fn end_portion(&self, device: &ash::Device, commands: vk::CommandBuffer) {
        self.end(device, commands);
        self.taken().portions += 1;
    }

    /// After the last pass.
    pub(super) fn end(&self, device: &ash::Device, commands: vk::CommandBuffer) {
        self.end_record(device, commands, &mut self.taken());
    }

    fn write_timestamp(&self, device: &ash::Device, commands: vk::CommandBuffer, number: u32) {
        let Some(QueryRange { pool, first, .. }) = self.slots.timestamps else { return };
        let stage = vk::PipelineStageFlags::BOTTOM_OF_PIPE;
        // SAFETY: the query is the host's, and was reset at the beginning.
        unsafe { device.cmd_write_timestamp(commands, stage, pool, first + number) };
    }

    /// What the last recording has taken; `Ok(None)` if the device has not come to its end. Waits
    /// for nothing. `decisions` is what [`Slots::decisions`] holds, from its offset on, to be read
    /// once the fence of the submission is signalled; without it, what the device has decided
    /// stays unknown.
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
        let portions: Vec<ReadBack> = decisions
            .map(|bytes| bytes.chunks_exact(Slots::DECISION_BYTES as usize))
            .into_iter()
            .flatten()
            .take(room.min(*ended) as usize)
            .map(ReadBack::new)
            .collect();
        let with_invocations = |(number, entry): (usize, &Entry)| {
            let found = portions.get(entry.portion as usize).map(ReadBack::decisions);
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

/// The results of the first queries of a range; `None` if some are not there yet.
pub(super) fn results(
    device: &ash::Device,
    range: QueryRange,
    count: usize,
) -> Result<Option<Vec<u64>>, VulkanError> {
    // Each with whether it is there.
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

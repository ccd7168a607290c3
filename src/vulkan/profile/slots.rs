//! Fills the host's queries while recording, and turns their results into records frames later.

use std::sync::{Mutex, MutexGuard, PoisonError};

use ash::vk;

use super::clock::Clock;
use super::decisions::{self, ReadBack};
use super::pass::{Grain, PassKind, PassRecord};
use super::presence::{Presence, decided};
use crate::vulkan::VulkanError;

/// Range of a query pool of the host.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct QueryRange {
    /// Query pool.
    pub pool: vk::QueryPool,
    /// First query of the range.
    pub first: u32,
    /// Number of queries.
    pub count: u32,
}

/// Queries and buffers of the host that a profile may use. All of them are optional. The records lack the
/// values of those that are missing.
///
/// The sizes are for `passes` passes in a recording.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct Slots {
    /// `passes + 1` queries of a pool of type `TIMESTAMP`. The first is written at the start of the
    /// recording, and the following ones at the end of each pass in turn. With [`Grain::Portions`] the last
    /// ones stay unused.
    pub timestamps: Option<QueryRange>,
    /// `passes` queries, one for each pass, of a pool of type `PIPELINE_STATISTICS` with the single statistic
    /// `COMPUTE_SHADER_INVOCATIONS`. The device feature `pipelineStatisticsQuery` must be enabled. These
    /// queries may make passes slower, so count invocations in other frames than those that you time.
    pub statistics: Option<QueryRange>,
    /// Buffer for the device's decisions, such as the tiles that it has visited. The buffer must have the
    /// usage `TRANSFER_DST` and be readable by the host. It has [`Slots::DECISION_BYTES`] for each call of
    /// [`super::super::embed::Recording::solve`], `add` or `resume` in a recording, from an offset that is a
    /// multiple of 4.
    pub decisions: Option<Decided>,
    /// Buffer, and offset in it, for the numbers of the tiles that each round has visited, row by row of
    /// tiles. Leave it `None` unless you want to draw the tiles, since the copies take time. The buffer must
    /// be like that of `decisions`, with four bytes for each tile of the grid and each round of the plan.
    /// Only the last portion is kept.
    pub tile_lists: Option<(vk::Buffer, u64)>,
}

/// Buffer for the device's decisions.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Decided {
    /// Buffer.
    pub buffer: vk::Buffer,
    /// Offset in the buffer, in bytes.
    pub offset: u64,
    /// Number of portions for which the buffer has room.
    pub portions: u32,
}

impl Slots {
    /// Bytes of a portion of steps in [`Slots::decisions`].
    pub const DECISION_BYTES: u64 = decisions::BYTES;

    /// Sets [`Slots::timestamps`].
    pub fn with_timestamps(self, range: QueryRange) -> Self {
        Self { timestamps: Some(range), ..self }
    }

    /// Sets [`Slots::statistics`].
    pub fn with_statistics(self, range: QueryRange) -> Self {
        Self { statistics: Some(range), ..self }
    }

    /// Sets [`Slots::decisions`].
    pub fn with_decisions(self, decided: Decided) -> Self {
        Self { decisions: Some(decided), ..self }
    }

    /// Sets [`Slots::tile_lists`].
    pub fn with_tile_lists(self, buffer: vk::Buffer, offset: u64) -> Self {
        Self { tile_lists: Some((buffer, offset)), ..self }
    }
}

/// Passes of one recording, and the queries that will hold their times.
///
/// Create one for each frame in flight. Recording into it allocates nothing. It serves one recording at a
/// time.
pub struct Profile {
    slots: Slots,
    grain: Grain,
    /// Number of passes for which there is room.
    room: usize,
    taken: Mutex<Taken>,
}

/// State of the recording so far.
struct Taken {
    entries: Vec<Entry>,
    /// Number of timestamps written after the first.
    timestamps: u32,
    /// Whether the last entries still lack their timestamp.
    waits: bool,
    /// Number of portions that have ended.
    portions: u32,
    /// Number of passes for which there was no room.
    left_out: u32,
}

#[derive(Clone, Copy)]
struct Entry {
    record: PassRecord,
    presence: Presence,
    /// Number of the portion to which the entry belongs.
    portion: u32,
    /// Number of the timestamp at the end of the entry. It is 1 for the first entry of a recording. Entries
    /// that form one record share it.
    timestamp: u32,
}

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
    /// Creates a profile with room for `passes` records of the grain `grain`. Each range must have the number
    /// of queries that [`Slots`] states; a smaller range reduces the room.
    /// [`super::super::embed::Solver::passes_of_frame`] returns the number of records of a frame.
    pub fn new(passes: u32, grain: Grain, slots: Slots) -> Self {
        // An empty range counts as none.
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

    /// Begins a new recording. The command buffer must be outside a render pass.
    pub(crate) fn begin(&self, device: &ash::Device, commands: vk::CommandBuffer) {
        let mut taken = self.taken();
        taken.entries.clear();
        (taken.timestamps, taken.waits) = (0, false);
        (taken.portions, taken.left_out) = (0, 0);
        drop(taken);
        for range in [self.slots.timestamps, self.slots.statistics].into_iter().flatten() {
            // SAFETY: the host has given the profile this range of a pool of this device.
            unsafe {
                device.cmd_reset_query_pool(commands, range.pool, range.first, range.count);
            }
        }
        self.write_timestamp(device, commands, 0);
    }

    /// Opens a pass of kind `kind`, and returns its number if there is room for it.
    pub(crate) fn open(
        &self,
        device: &ash::Device,
        commands: vk::CommandBuffer,
        kind: PassKind,
    ) -> Option<usize> {
        let mut taken = self.taken();
        // The outcome of a portion's iterations belongs to the portion's record, if that has not ended.
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

    /// Closes the pass with this number.
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
        // The steps of a portion are recorded before the portion ends, so `portions` is still the number of
        // their portion.
        let mut taken = self.taken();
        let (portion, timestamp) = (taken.portions, taken.timestamps + 1);
        taken.entries.push(Entry { record, presence, portion, timestamp });
        taken.waits = true;
        if record.kind != PassKind::Portion {
            self.end_record(device, commands, &mut taken);
        }
    }

    /// Writes the timestamp after the last of the entries that form one record.
    fn end_record(&self, device: &ash::Device, commands: vk::CommandBuffer, taken: &mut Taken) {
        if std::mem::take(&mut taken.waits) {
            taken.timestamps += 1;
            self.write_timestamp(device, commands, taken.timestamps);
        }
    }

    /// Returns the place to which the decisions of this portion are copied, if there is room.
    pub(crate) fn decisions(&self) -> Option<(vk::Buffer, u64)> {
        let Decided { buffer, offset, portions } = self.slots.decisions?;
        let number = self.taken().portions;
        let at = offset + u64::from(number) * Slots::DECISION_BYTES;
        (number < portions).then_some((buffer, at))
    }

    /// Returns the place to which the lists of tiles are copied.
    pub(crate) fn tile_lists(&self) -> Option<(vk::Buffer, u64)> {
        self.slots.tile_lists
    }

    /// Ends a portion of steps.
    pub(crate) fn end_portion(&self, device: &ash::Device, commands: vk::CommandBuffer) {
        self.end(device, commands);
        self.taken().portions += 1;
    }

    /// Ends the recording after its last pass.
    pub(super) fn end(&self, device: &ash::Device, commands: vk::CommandBuffer) {
        self.end_record(device, commands, &mut self.taken());
    }

    fn write_timestamp(&self, device: &ash::Device, commands: vk::CommandBuffer, number: u32) {
        let Some(QueryRange { pool, first, .. }) = self.slots.timestamps else { return };
        let stage = vk::PipelineStageFlags::BOTTOM_OF_PIPE;
        // SAFETY: the query is the host's, and was reset at the beginning.
        unsafe { device.cmd_write_timestamp(commands, stage, pool, first + number) };
    }

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

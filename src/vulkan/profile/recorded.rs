//! Observes a recording: writes timestamps at the ends of its passes and stores what is known of their work.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use ash::vk;

use super::decisions;
use super::pass::{Grain, PassRecord};
use super::presence::Presence;
use super::slots::{Decided, QueryRange, Slots};
use super::steps::StepCounter;
use super::work::Work;
use crate::vulkan::VulkanError;
use crate::vulkan::flight::{Flight, half};
use crate::vulkan::record::{Commands, Moved, Observer, PassKind, PlannedSteps, StepsOf};
use crate::vulkan::schedules::plan::Step;

/// Passes of one recording, and the queries that will hold their times.
///
/// Create one profile for each frame in flight, since it serves one recording at a time. Recording into it allocates
/// nothing.
pub struct Profile {
    pub(super) slots: Slots,
    grain: Grain,
    /// Capacity in passes.
    room: usize,
    taken: Mutex<Taken>,
    last: Mutex<Option<LastUse>>,
}

/// Last recording with a profile.
struct LastUse {
    /// Recordings of the surface.
    flight: Arc<Flight>,
    serial: u32,
    /// Hash of the command buffer's handle.
    commands: u32,
}

/// State of the recording so far.
#[derive(Default)]
pub(super) struct Taken {
    pub(super) entries: Vec<Entry>,
    open: Option<Open>,
    steps: Option<StepsTaken>,
    /// Number of timestamps written after the first.
    pub(super) timestamps: u32,
    /// Whether the last entries still lack their timestamp.
    waits: bool,
    /// Number of portions that have ended.
    pub(super) portions: u32,
    /// Number of passes for which there was no room.
    pub(super) left_out: u32,
}

/// Pass that is being recorded.
struct Open {
    record: PassRecord,
    presence: Presence,
    /// Commands that count towards the record of the pass.
    counts: Counts,
    /// Number of the pass in the profile, if that has room.
    number: Option<u32>,
}

/// Commands that count towards the record of a pass.
#[derive(Clone, Copy, PartialEq)]
enum Counts {
    /// Dispatches, and the bytes of copies, fills and updates.
    All,
    /// Dispatches. The recorder has stated the bytes.
    Dispatches,
    /// No command: the pass is a step, whose work the counter of steps states.
    Nothing,
}

/// Steps that are being recorded.
struct StepsTaken {
    counter: StepCounter,
    /// Buffers of the map with its progress and its lists of tiles; `None` for a batch.
    buffers: Option<[vk::Buffer; 2]>,
    /// Bytes of a list of tiles.
    list: u64,
    /// Round of tiles whose list has not been copied yet.
    round: Option<u32>,
    /// Number of blocks for which the device notes its visits.
    visits: u32,
}

#[derive(Clone, Copy)]
pub(super) struct Entry {
    pub(super) record: PassRecord,
    pub(super) presence: Presence,
    /// Number of the portion to which the entry belongs.
    pub(super) portion: u32,
    /// Number of the timestamp at the end of the entry. It is 1 for the first entry of a recording. Entries
    /// that form one record share it.
    pub(super) timestamp: u32,
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
            taken: Mutex::new(Taken { entries: Vec::with_capacity(room), ..Taken::default() }),
            last: Mutex::new(None),
        }
    }

    fn last(&self) -> MutexGuard<'_, Option<LastUse>> {
        self.last.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Returns whether a tracked recording with this profile may still be pending. The profile's queries and buffers
    /// must not be destroyed then. Recordings with an outcome are tracked, and with
    /// [`super::super::embed::Tools::checks`] all recordings.
    pub fn is_in_flight(&self) -> bool {
        self.last().as_ref().is_some_and(|last| last.flight.waits_for(last.serial))
    }

    /// Returns an error if a recording into another command buffer uses the profile and may still be pending. An
    /// earlier recording into the same command buffer no longer exists.
    pub(in crate::vulkan) fn check_use(
        &self,
        commands: vk::CommandBuffer,
    ) -> Result<(), VulkanError> {
        let is_elsewhere = |last: &LastUse| last.commands != half(commands);
        let is_elsewhere = self.last().as_ref().is_some_and(is_elsewhere);
        match is_elsewhere && self.is_in_flight() {
            true => Err(VulkanError::ProfileInFlight),
            false => Ok(()),
        }
    }

    /// Notes that the recording with this serial uses the profile.
    pub(in crate::vulkan) fn is_used(
        &self,
        flight: &Arc<Flight>,
        serial: u32,
        commands: vk::CommandBuffer,
    ) {
        *self.last() =
            Some(LastUse { flight: Arc::clone(flight), serial, commands: half(commands) });
    }

    pub(super) fn taken(&self) -> MutexGuard<'_, Taken> {
        self.taken.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Begins a new recording. The command buffer must be outside a render pass.
    pub(crate) fn start(&self, device: &ash::Device, commands: vk::CommandBuffer) {
        let mut taken = self.taken();
        let mut entries = std::mem::take(&mut taken.entries);
        entries.clear();
        *taken = Taken { entries, ..Taken::default() };
        drop(taken);
        for range in [self.slots.timestamps, self.slots.statistics].into_iter().flatten() {
            // SAFETY: the host has given the profile this range of a pool of this device.
            unsafe {
                device.cmd_reset_query_pool(commands, range.pool, range.first, range.count);
            }
        }
        self.write_timestamp(device, commands, 0);
    }

    /// Ends the open pass, if any, and opens another.
    fn open(&self, commands: &Commands, taken: &mut Taken, mut open: Open) {
        let &Commands { device, buffer, .. } = commands;
        self.close(commands, taken);
        // The outcome of a portion's iterations belongs to the portion's record, if that has not ended.
        if !matches!(open.record.kind, PassKind::Portion | PassKind::Outcome) {
            self.end_record(device, buffer, taken);
        }
        if taken.entries.len() < self.room {
            let number = taken.entries.len() as u32;
            open.number = Some(number);
            if let Some(QueryRange { pool, first, .. }) = self.slots.statistics {
                let flags = vk::QueryControlFlags::empty();
                // SAFETY: the query is the host's, was reset at the beginning, and is not active.
                unsafe { device.cmd_begin_query(buffer, pool, first + number, flags) };
            }
        } else {
            taken.left_out += 1;
        }
        taken.open = Some(open);
    }

    /// Ends the open pass, if there is one.
    fn close(&self, commands: &Commands, taken: &mut Taken) {
        let Some(Open { record, presence, number, .. }) = taken.open.take() else { return };
        let Some(number) = number else { return };
        let &Commands { device, buffer, .. } = commands;
        if let Some(QueryRange { pool, first, .. }) = self.slots.statistics {
            // SAFETY: the query was begun by `open`.
            unsafe { device.cmd_end_query(buffer, pool, first + number) };
        }
        // The steps of a portion are recorded before the portion ends, so `portions` is still the number of
        // their portion.
        let (portion, timestamp) = (taken.portions, taken.timestamps + 1);
        taken.entries.push(Entry { record, presence, portion, timestamp });
        taken.waits = true;
        if record.kind != PassKind::Portion {
            self.end_record(device, buffer, taken);
        }
    }

    /// Writes the timestamp after the last of the entries that form one record.
    fn end_record(&self, device: &ash::Device, commands: vk::CommandBuffer, taken: &mut Taken) {
        if std::mem::take(&mut taken.waits) {
            taken.timestamps += 1;
            self.write_timestamp(device, commands, taken.timestamps);
        }
    }

    /// Returns the buffer and the offset to which the decisions of this portion are copied, if they fit.
    fn decisions(&self) -> Option<(vk::Buffer, u64)> {
        let Decided { buffer, offset, portions } = self.slots.decisions?;
        let number = self.taken().portions;
        let at = offset + u64::from(number) * Slots::DECISION_BYTES;
        (number < portions).then_some((buffer, at))
    }

    /// Copies the list of tiles of the last round, if that has not been done.
    fn copy_tile_list(&self, commands: &Commands) {
        let Some((buffer, offset)) = self.slots.tile_lists else { return };
        let found = self.taken().steps.as_mut().and_then(|steps| {
            let (round, [_, tiles]) = (steps.round.take()?, steps.buffers?);
            Some((u64::from(round), tiles, steps.list))
        });
        let Some((round, tiles, list)) = found else { return };
        let (from, to) = ((tiles, (2 + round % 2) * list), (buffer, offset + round * list));
        decisions::copy_for_host(commands, from, to, list);
    }

    /// Ends the recording after its last pass.
    pub(super) fn finish(&self, device: &ash::Device, commands: vk::CommandBuffer) {
        self.end_record(device, commands, &mut self.taken());
    }

    /// Returns whether lists of tiles are copied.
    pub(super) fn lists_tiles(&self) -> bool {
        self.slots.tile_lists.is_some()
    }

    fn write_timestamp(&self, device: &ash::Device, commands: vk::CommandBuffer, number: u32) {
        let Some(QueryRange { pool, first, .. }) = self.slots.timestamps else { return };
        let stage = vk::PipelineStageFlags::BOTTOM_OF_PIPE;
        // SAFETY: the query is the host's, and was reset at the beginning.
        unsafe { device.cmd_write_timestamp(commands, stage, pool, first + number) };
    }
}

impl Observer for Profile {
    fn begin(&self, commands: &Commands, kind: PassKind, moved: Option<Moved>) {
        let counts = if moved.is_none() { Counts::All } else { Counts::Dispatches };
        let [bytes_read, bytes_written] = moved.unwrap_or_default();
        let work = Work { bytes_read, bytes_written, ..Work::default() };
        let record = PassRecord { work, ..PassRecord::new(self.grain.kind(kind)) };
        let pass = Open { record, presence: Presence::Always, counts, number: None };
        self.open(commands, &mut self.taken(), pass);
    }

    fn end(&self, commands: &Commands) {
        self.close(commands, &mut self.taken());
    }

    fn dispatched(&self, groups: [u32; 3]) {
        if let Some(Open { record, counts: Counts::All | Counts::Dispatches, .. }) =
            &mut self.taken().open
        {
            let groups = Some(groups);
            record.absorb(&PassRecord { dispatches: 1, groups, ..PassRecord::new(record.kind) });
        }
    }

    fn transferred(&self, read: u64, written: u64) {
        if let Some(Open { record, counts: Counts::All, .. }) = &mut self.taken().open {
            let work = Work::of_bytes(read, written);
            record.absorb(&PassRecord { work, ..PassRecord::new(record.kind) });
        }
    }

    fn begin_steps(&self, commands: &Commands, steps: PlannedSteps) -> u32 {
        let to = self.decisions();
        let (mut buffers, mut visits) = (None, 0);
        if let StepsOf::Map(grid) = steps.of {
            buffers = Some([grid.progress.buffer, grid.tiles.buffer]);
            if let Some(to) = to {
                visits = decisions::visits_noted(steps.steps, steps.tuning.scan_lines);
                decisions::copy_before(commands, grid.progress.buffer, to, visits);
            }
        }
        let tile = steps.tuning.on_grid(steps.texels).tile;
        let tiles: u32 = steps.texels.tiles(tile).iter().product();
        let list = u64::from(tiles) * size_of::<u32>() as u64;
        let counter = StepCounter::new(&steps);
        self.taken().steps = Some(StepsTaken { counter, buffers, list, round: None, visits });
        visits
    }

    fn step(&self, commands: &Commands, step: &Step) {
        self.copy_tile_list(commands);
        let mut taken = self.taken();
        let Some(steps) = &mut taken.steps else { return };
        let (mut record, presence) = steps.counter.next(step);
        record.kind = self.grain.kind(record.kind);
        if let &Step::Tiles { round } = step {
            steps.round = Some(round);
        }
        let open = taken.open.as_mut().filter(|open| {
            open.counts == Counts::Nothing
                && self.grain.gathers(record.kind)
                && (open.record.kind, open.record.iteration) == (record.kind, record.iteration)
        });
        if let Some(open) = open {
            open.record.absorb(&record);
            open.presence.absorb(presence);
        } else {
            let pass = Open { record, presence, counts: Counts::Nothing, number: None };
            self.open(commands, &mut taken, pass);
        }
    }

    fn end_steps(&self, commands: &Commands) {
        self.end(commands);
        let steps = self.taken().steps.take();
        let Some(StepsTaken { buffers: Some([progress, _]), visits, .. }) = steps else { return };
        if let Some(to) = self.decisions() {
            decisions::copy_after(commands, progress, to, visits);
        }
    }

    fn end_portion(&self, commands: &Commands) {
        self.finish(commands.device, commands.buffer);
        self.taken().portions += 1;
    }
}

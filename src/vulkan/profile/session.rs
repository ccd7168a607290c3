//! Profiles a map on a device of this crate's own, submission by submission.

use std::sync::Arc;
use std::time::{Duration, Instant};

use ash::vk;
use gpu_allocator::MemoryLocation;

use super::calibration::Calibration;
use super::capabilities::Capabilities;
use super::pass::{Grain, PassRecord};
use super::recorded::Profile;
use super::resolved::{Resolved, results};
use super::slots::{Decided, QueryRange, Slots};
use crate::constants::{HAS_WAITED, ROUNDS};
use crate::vulkan::VulkanError;
use crate::vulkan::device::labels::Labels;
use crate::vulkan::device::memory::{Buffer, BufferInfo};
use crate::vulkan::headless::context::{CommandBuffer, Context, Submitter};
use crate::vulkan::record::{Observer, PassKind};

/// Choice of observations of a map in addition to times.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Detail {
    /// Coarseness of the records.
    pub grain: Grain,
    /// Whether invocations are counted, where the device can count them.
    pub invocations: bool,
    /// Whether the tiles that each round visits are recorded. They are unknown for records of whole portions.
    pub tiles: bool,
    /// Whether each submission is also timed as a whole, by two timestamps around those of the passes. The
    /// time between the two includes the time that the timestamps of the passes take.
    pub whole: bool,
}

/// Profile of the computation of a map.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SolveProfile {
    /// Submissions in their order.
    pub submissions: Vec<SubmissionRecord>,
    /// Time by the host's clock from the first submission to the end of the last submission before the map is
    /// read back. For many maps at once, it lasts until all distances have been read back.
    pub time: Duration,
}

/// Record of a command buffer that was submitted and waited for.
#[derive(Clone, Debug, PartialEq)]
pub struct SubmissionRecord {
    /// Time of the submission since the start of the map, by the host's clock.
    pub submitted: Duration,
    /// Time since the start of the map at which the host knew that the submission had ended.
    pub ended: Duration,
    /// Start of the submission on the device, in nanoseconds since the start of the map by the host's clock.
    /// It requires calibrated timestamps.
    pub begin: Option<f64>,
    /// Nanoseconds from the submission's first command to its last. Without [`Detail::whole`], the
    /// nanoseconds from the start of the first pass to the end of the last one.
    pub nanoseconds: Option<u64>,
    /// Nanoseconds from the submission's first command to the first pass; 0 without [`Detail::whole`].
    pub lead: Option<u64>,
    /// Records of the passes.
    pub passes: Vec<PassRecord>,
    /// Numbers of the tiles that each round visited, row by row of tiles. The list is empty unless it was
    /// requested.
    pub tiles: Vec<Vec<u32>>,
}

impl SolveProfile {
    /// Returns the records of all passes.
    pub fn passes(&self) -> impl Iterator<Item = &PassRecord> {
        self.submissions.iter().flat_map(|submission| &submission.passes)
    }

    /// Returns the nanoseconds of all passes together, if they were measured.
    pub fn pass_nanoseconds(&self) -> Option<u64> {
        self.passes().map(|pass| pass.nanoseconds).sum()
    }

    /// Returns the nanoseconds of all command buffers together, if they were measured.
    pub fn nanoseconds(&self) -> Option<u64> {
        self.submissions.iter().map(|submission| submission.nanoseconds).sum()
    }
}

/// Queries and buffers of a profiled map.
pub(crate) struct Session {
    context: Arc<Context>,
    capabilities: Capabilities,
    pools: Vec<vk::QueryPool>,
    profile: Profile,
    /// Range whose first and last query are the timestamps around the whole submission, if requested.
    around: Option<QueryRange>,
    buffer: Option<Buffer>,
    /// Number of tiles of the grid.
    tile_count: usize,
    start: Instant,
    calibration: Option<Calibration>,
    found: SolveProfile,
}

impl Session {
    /// Creates a session for submissions of at most `passes` passes, on a grid of `tile_count` tiles.
    pub(crate) fn new(
        context: &Arc<Context>,
        capabilities: &Capabilities,
        passes: u32,
        tile_count: usize,
        detail: Detail,
    ) -> Result<Self, VulkanError> {
        let mut new = Self {
            context: Arc::clone(context),
            capabilities: capabilities.clone(),
            pools: Vec::new(),
            profile: Profile::new(0, detail.grain, Slots::default()),
            around: None,
            buffer: None,
            tile_count,
            start: Instant::now(),
            calibration: None,
            found: SolveProfile::default(),
        };
        let mut slots = Slots::default();
        if capabilities.timestamps.is_ok() {
            let none = vk::QueryPipelineStatisticFlags::empty();
            let pool = new.pool(vk::QueryType::TIMESTAMP, passes + 3, none)?;
            slots.timestamps = Some(QueryRange { pool, first: 1, count: passes + 1 });
            let around = QueryRange { pool, first: 0, count: passes + 3 };
            new.around = detail.whole.then_some(around);
        }
        if detail.invocations && capabilities.statistics.is_ok() {
            let kind = vk::QueryPipelineStatisticFlags::COMPUTE_SHADER_INVOCATIONS;
            let pool = new.pool(vk::QueryType::PIPELINE_STATISTICS, passes, kind)?;
            slots.statistics = Some(QueryRange { pool, first: 0, count: passes });
        }
        let lists = if detail.tiles { (tile_count * 4) as u64 * u64::from(ROUNDS) } else { 0 };
        let size = Slots::DECISION_BYTES + lists;
        let info = BufferInfo { name: "decisions", size, location: MemoryLocation::GpuToCpu };
        let buffer = Buffer::new(&context.device, &mut context.allocator(), info)?;
        if capabilities.labels.is_ok() {
            let labels = Labels::new(&context.instance.handle, &context.device);
            labels.name(buffer.buffer, info.name);
        }
        slots.decisions = Some(Decided { buffer: buffer.buffer, offset: 0, portions: 1 });
        slots.tile_lists = detail.tiles.then_some((buffer.buffer, Slots::DECISION_BYTES));
        new.buffer = Some(buffer);
        new.profile = Profile::new(passes, detail.grain, slots);
        new.start = Instant::now();
        if let (Ok(clock), Ok(extension)) = (capabilities.timestamps, capabilities.calibration) {
            let instance = &context.instance.handle;
            let found = Calibration::new(instance, &context.device, extension, clock)?;
            new.calibration = Some(found);
        }
        Ok(new)
    }

    fn pool(
        &mut self,
        kind: vk::QueryType,
        count: u32,
        statistics: vk::QueryPipelineStatisticFlags,
    ) -> Result<vk::QueryPool, VulkanError> {
        let info = vk::QueryPoolCreateInfo::default()
            .query_type(kind)
            .query_count(count)
            .pipeline_statistics(statistics);
        // SAFETY: the device has the feature that the kind of query needs.
        let pool = unsafe { self.context.device.create_query_pool(&info, None) }
            .map_err(VulkanError::from_call("vkCreateQueryPool"))?;
        self.pools.push(pool);
        Ok(pool)
    }

    /// Writes the beginning of a command buffer.
    fn open(&self, device: &ash::Device, commands: vk::CommandBuffer) {
        if let Some(QueryRange { pool, first, count }) = self.around {
            // SAFETY: the session owns the pool, and the pool's last results have been read.
            unsafe { device.cmd_reset_query_pool(commands, pool, first, count) };
            self.write(device, commands, first);
        }
        self.profile.start(device, commands);
    }

    /// Writes the end of a command buffer.
    fn close(&self, device: &ash::Device, commands: vk::CommandBuffer) {
        self.profile.finish(device, commands);
        if let Some(QueryRange { first, count, .. }) = self.around {
            self.write(device, commands, first + count - 1);
        }
    }

    fn write(&self, device: &ash::Device, commands: vk::CommandBuffer, query: u32) {
        let Some(QueryRange { pool, .. }) = self.around else { return };
        let stage = vk::PipelineStageFlags::BOTTOM_OF_PIPE;
        // SAFETY: the session owns the pool, and the query was reset at the beginning.
        unsafe { device.cmd_write_timestamp(commands, stage, pool, query) };
    }

    fn watch(&mut self, commands: &CommandBuffer) -> Result<(), VulkanError> {
        let submitted = self.start.elapsed();
        commands.submit_and_wait()?;
        let ended = self.start.elapsed();
        let device = &self.context.device;
        let clock = self.capabilities.timestamps.ok();
        let bytes = self.buffer.as_ref().expect("it is there from the start").read();
        let (decisions, lists) = bytes.split_at(Slots::DECISION_BYTES as usize);
        let resolved = self.profile.resolve(device, clock, Some(decisions))?;
        // The submission has been waited for, so a missing result is the driver's fault.
        let missing =
            VulkanError::Call { call: "vkGetQueryPoolResults", result: vk::Result::NOT_READY };
        let Resolved { passes, start, left_out } = resolved.ok_or(missing)?;
        debug_assert_eq!(left_out, 0, "the session has room for all passes");
        let around = match self.around {
            Some(range) => {
                let last = QueryRange { first: range.first + range.count - 1, count: 1, ..range };
                let first = results(device, range, 1)?;
                first.zip(results(device, last, 1)?).map(|(first, last)| [first[0], last[0]])
            }
            None => None,
        };
        let since = |from: u64, to: u64| Some(clock?.nanoseconds(from, to));
        let of_passes = || match passes.last() {
            Some(last) => Some(last.begin? + last.nanoseconds?),
            None => start.and(Some(0)),
        };
        let nanoseconds = match around {
            Some([first, last]) => since(first, last),
            None => of_passes(),
        };
        let first = around.map(|[first, _]| first).or(start);
        let tiles = match self.profile.lists_tiles() {
            true => self.tiles(&passes, lists),
            false => Vec::new(),
        };
        self.found.submissions.push(SubmissionRecord {
            submitted,
            ended,
            begin: self
                .calibration
                .zip(first)
                .map(|(calibration, first)| calibration.since(self.start, first)),
            nanoseconds,
            lead: first.zip(start).and_then(|(first, start)| since(first, start)),
            passes,
            tiles,
        });
        Ok(())
    }

    fn tiles(&self, passes: &[PassRecord], lists: &[u8]) -> Vec<Vec<u32>> {
        let rounds = passes.iter().filter(|pass| pass.kind == PassKind::Tiles);
        let list = |(pass, bytes): (&PassRecord, &[u8])| {
            let count = pass.groups.map_or(0, |groups| groups[0] as usize);
            let number =
                |bytes: &[u8]| u32::from_ne_bytes(bytes.try_into().expect("these are four bytes"));
            let listed = bytes.chunks_exact(4).take(count).map(number);
            listed.filter(|number| number & HAS_WAITED == 0).collect()
        };
        rounds.zip(lists.chunks(4 * self.tile_count)).map(list).collect()
    }

    /// Ends the session. `time` is the time that the map took.
    pub(crate) fn finish(mut self, time: Duration) -> SolveProfile {
        let found = std::mem::take(&mut self.found);
        SolveProfile { time, ..found }
    }
}

/// Surrounds each recording with queries, and reads their results after each submission.
impl Submitter for Session {
    fn record(
        &self,
        commands: &CommandBuffer,
        append: impl FnOnce(&ash::Device, vk::CommandBuffer, Option<&dyn Observer>),
    ) -> Result<(), VulkanError> {
        commands.record(|device, buffer| {
            self.open(device, buffer);
            append(device, buffer, Some(&self.profile));
            self.close(device, buffer);
        })
    }

    fn submit(&mut self, commands: &CommandBuffer) -> Result<(), VulkanError> {
        self.watch(commands)
    }

    fn restart(&mut self) {
        self.start = Instant::now();
    }

    fn is_watching(&self) -> bool {
        true
    }

    fn last(&mut self) -> Option<&mut [PassRecord]> {
        self.found.submissions.last_mut().map(|last| last.passes.as_mut_slice())
    }
}

impl Drop for Session {
    fn drop(&mut self) {
        let device = &self.context.device;
        for &pool in &self.pools {
            // SAFETY: all submissions have been waited for.
            unsafe { device.destroy_query_pool(pool, None) };
        }
        if let Some(buffer) = &mut self.buffer {
            buffer.destroy(device, &mut self.context.allocator());
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Stop;
    use crate::surface::{Sources, Spacing, Surface};
    use crate::update::Wavefront;
    use crate::vulkan::DeviceChoice;
    use crate::vulkan::profile::Capability;
    use crate::vulkan::{HeadlessSolver, Method, Schedule};

    /// Checks that queries, copies of decisions and lists, labels and names cause no message of the
    /// validation layers, with synchronization validation. Whatever is left out, the map is the same to the
    /// last bit.
    #[test]
    fn profiles_leave_no_message_and_no_trace_in_the_map() {
        let heights = (0..75 * 90).map(|i| f64::from(i % 7 + i / 270).sin()).collect();
        let surface = Surface::from_heights(75, 90, heights, Spacing::square(1.0)).unwrap();
        let seeds = Sources::point(3.0, 20.5).seeds(&surface).unwrap();
        let device = std::env::var("GEOSWEEP_TEST_DEVICE").unwrap_or_default();
        let choice = DeviceChoice::Name(device);
        let left_out: [&[Capability]; 3] = [&[], &[Capability::Labels], &Capability::ALL];
        for left_out in left_out {
            let context = Context::open(&choice, true, Some(left_out)).unwrap();
            let mut solver = HeadlessSolver::with(context).unwrap();
            let mut on_device = solver.upload(&surface).unwrap();
            for schedule in Schedule::ALL {
                let stop = Stop::within(1e-6).or_after(300);
                let wavefront = Wavefront::Curved;
                let method = Method::new(wavefront, stop).with_schedule(schedule);
                let plain = solver.solve(&mut on_device, &seeds, method).unwrap();
                let all =
                    Detail { invocations: true, tiles: true, whole: true, ..Detail::default() };
                let of = |grain| Detail { grain, ..all };
                let details = Grain::ALL.map(of).into_iter().chain([Detail::default()]);
                for detail in details {
                    let watched = solver.profile(&mut on_device, &seeds, method, detail);
                    let (watched, profile) = watched.unwrap();
                    assert_eq!(watched.distances, plain.distances);
                    assert_eq!(watched.iterations, plain.iterations);
                    // Every recording reports its outcome, and then the map is read back.
                    let ends = match detail.grain {
                        Grain::Portions => PassKind::Portion,
                        _ => PassKind::Outcome,
                    };
                    let recordings = profile.passes().filter(|pass| pass.kind == ends).count();
                    assert!(recordings >= 1 && profile.submissions.len() == recordings + 1);
                }
                // A solve without a profile does not submit a recording with queries again.
                let again = solver.solve(&mut on_device, &seeds, method).unwrap();
                assert_eq!(again.distances, plain.distances);
            }
            let log = solver.validation_log().unwrap().clone();
            drop((on_device, solver));
            assert_eq!(log.messages(), Vec::<String>::new());
        }
    }
}

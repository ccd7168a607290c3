//! Measures the best performance of a device. A comparison of a map's time with these ceilings shows what
//! bounds the time. Solvers do not use the ceilings.

use std::sync::Arc;
use std::time::{Duration, Instant};

use ash::vk;
use gpu_allocator::MemoryLocation;

use super::context::{CommandBuffer, Context};
use crate::constants::LAYERS;
use crate::surface::Chart;
use crate::update::Wavefront;
use crate::vulkan::DeviceChoice;
use crate::vulkan::device::barrier::{HOST_READ, PASS, TRANSFER_READ, TRANSFER_WRITE};
use crate::vulkan::device::memory::{Buffer, BufferInfo};
use crate::vulkan::device::passes::{CEILING_COPY, CEILING_UPDATES};
use crate::vulkan::device::pipelines::Pipeline;
use crate::vulkan::device::requirements;
use crate::vulkan::device::shaders::{ceiling_copy, ceiling_updates};
use crate::vulkan::grid_images::{GridImages, Purpose};
use crate::vulkan::profile::Clock;
use crate::vulkan::record::{Commands, Groups, Recorder};
use crate::vulkan::{VulkanError, embed};

/// Best performance of a device, by the host's clock.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DeviceCeilings {
    /// Bytes a second, read plus written, of a pass that copies one image to another. It moves 64 MiB, which
    /// may fit a large cache.
    pub copy: f64,
    /// Number of updates per second, each from one triangle, by wavefront ([`Wavefront::FOR_ANY_SURFACE`]),
    /// with all data in registers.
    pub triangles: [f64; Wavefront::FOR_ANY_SURFACE.len()],
    /// Time of an empty dispatch of one workgroup with the barrier after it.
    pub dispatch: Duration,
    /// Time of the same dispatch if it is indirect, with the number of workgroups from a buffer.
    pub indirect_dispatch: Duration,
    /// Time of an indirect dispatch of no workgroup with the barrier after it. It is the cost of a pass that
    /// is recorded beyond convergence.
    pub skipped_dispatch: Duration,
    /// Time of a barrier alone.
    pub barrier: Duration,
    /// Time that a timestamp adds to a dispatch and its barrier; `None` if queues for compute write no
    /// timestamps.
    pub timestamp: Option<Duration>,
    /// Time from an empty submission until the host knows that it has ended.
    pub submission: Duration,
    /// Bytes a second from the device's memory into an array of the host.
    pub read_back: f64,
}

/// Points on a side of the grid whose fronts are copied. Each image takes half of the bytes that the copy
/// moves.
const SIDE: usize = 2048;
/// Texels on a side of the grid on which updates are computed.
const COMPUTED: u32 = 512;
/// Number of bytes read back.
const READ_BACK: usize = 16 << 20;
/// Minimum time of a recording. Shorter recordings are lengthened.
const LONG_ENOUGH: Duration = Duration::from_millis(20);
/// Largest number of repetitions in a recording. Lavapipe ends loops after 65 535 trips.
const MOST: u32 = 1 << 14;
/// Number of timestamps in a recording.
const TIMESTAMPS: u32 = 128;
/// Offset of the zeros in the buffer of workgroup counts.
const NO_GROUP: u64 = 0;
/// Offset of the ones in this buffer.
const ONE_GROUP: u64 = 64;
/// Number of times each recording is submitted. The shortest time counts, since other work can only add to
/// it.
const TRIES: usize = 5;
/// Message of panics about missing images and pipelines of the probe.
const MADE: &str = "a probe is made with its images and pipelines";

impl DeviceCeilings {
    /// Measures a device, in about a second.
    ///
    /// # Errors
    /// If there is no such device, or a Vulkan call on it fails.
    pub fn measure(choice: &DeviceChoice) -> Result<Self, VulkanError> {
        let context = Arc::new(Context::new(choice, false)?);
        let mut probe = Probe::new(&context)?;
        probe.measure()
    }
}

/// Resources for the measurements. Dropping the value frees them.
struct Probe<'a> {
    context: &'a Arc<Context>,
    solver: embed::Solver,
    images: Option<GridImages>,
    /// Buffer in device memory, and buffer that the host reads.
    buffers: Vec<Buffer>,
    copy: Option<Pipeline<ceiling_copy::Push>>,
    /// Pipelines of the updates, by wavefront.
    updates: Vec<Pipeline<ceiling_updates::Push>>,
    commands: CommandBuffer,
    /// Query pool; null if the queue writes no timestamps.
    timestamps: vk::QueryPool,
}

impl<'a> Probe<'a> {
    fn new(context: &'a Arc<Context>) -> Result<Self, VulkanError> {
        let (instance, device) = (&context.instance.handle, &context.device);
        let mut new = Self {
            context,
            solver: embed::Solver::new(instance, context.physical_device, device, &[])?,
            images: None,
            buffers: Vec::new(),
            copy: None,
            updates: Vec::new(),
            commands: CommandBuffer::kept(context)?,
            timestamps: vk::QueryPool::null(),
        };
        let chart = Chart { rows: SIDE, cols: SIDE };
        let sizes = (chart, new.solver.limits.texels(chart)?);
        let pipelines = &new.solver.pipelines;
        let allocator = &mut context.allocator();
        let images =
            GridImages::new(device, allocator, pipelines, sizes, Purpose::headless(false))?;
        new.images = Some(images);
        for (name, location) in
            [("copied", MemoryLocation::GpuOnly), ("read", MemoryLocation::GpuToCpu)]
        {
            let info = BufferInfo { name, size: READ_BACK as u64, location };
            new.buffers.push(Buffer::new(device, allocator, info)?);
        }
        new.copy = Some(pipelines.make(device, CEILING_COPY, Wavefront::Planar)?);
        for wavefront in Wavefront::FOR_ANY_SURFACE {
            new.updates.push(pipelines.make(device, CEILING_UPDATES, wavefront)?);
        }
        let family = requirements::compute_queue_family(instance, context.physical_device)
            .expect("a context's device meets the requirements");
        if Clock::of(instance, context.physical_device, family).is_some() {
            let info = vk::QueryPoolCreateInfo::default()
                .query_type(vk::QueryType::TIMESTAMP)
                .query_count(TIMESTAMPS);
            // SAFETY: the device's queue writes timestamps.
            new.timestamps = unsafe { device.create_query_pool(&info, None) }
                .map_err(VulkanError::from_call("vkCreateQueryPool"))?;
        }
        Ok(new)
    }

    fn measure(&mut self) -> Result<DeviceCeilings, VulkanError> {
        self.prepare()?;
        let texels = [SIDE as u32 / 2; 2];
        let copied = 2 * texels[0] * texels[1] * LAYERS * 16;
        let copy = self.each(|probe, commands| {
            probe.copy(commands, texels, Groups::of(texels));
            probe.barrier(commands);
        })?;
        let mut triangles = [0.0; Wavefront::FOR_ANY_SURFACE.len()];
        for (wavefront, triangles) in Wavefront::FOR_ANY_SURFACE.into_iter().zip(&mut triangles) {
            let repeated = self.repeated(|probe, commands, repeats| {
                let update = probe.updates[wavefront as usize];
                probe.update(commands, update, [COMPUTED; 2], repeats);
            })?;
            *triangles = f64::from(4 * COMPUTED * COMPUTED) / repeated.as_secs_f64();
        }
        let one_group = |probe: &Self, commands| {
            probe.copy(commands, [1, 1], Groups::line(1));
            probe.barrier(commands);
        };
        let dispatch = self.each(one_group)?;
        Ok(DeviceCeilings {
            copy: f64::from(copied) / copy.as_secs_f64(),
            triangles,
            dispatch,
            indirect_dispatch: self.each(|probe, commands| {
                probe.copy(commands, [1, 1], Groups::From(probe.buffers[0].buffer, ONE_GROUP));
                probe.barrier(commands);
            })?,
            skipped_dispatch: self.each(|probe, commands| {
                probe.copy(commands, [0, 1], Groups::From(probe.buffers[0].buffer, NO_GROUP));
                probe.barrier(commands);
            })?,
            barrier: self.each(Self::barrier)?,
            timestamp: self.timestamp(one_group)?,
            submission: self.time(|_, _| {})?,
            read_back: self.read_back()?,
        })
    }

    /// Transitions images into their layout, writes workgroup counts to the buffer, and lets the driver
    /// compile the shaders.
    fn prepare(&self) -> Result<(), VulkanError> {
        let grid = self.grid();
        self.context.run(|device, commands| {
            let recorder = self.recording(commands);
            Recorder { commands: recorder, grid }.prepare();
            let groups = self.buffers[0].buffer;
            // SAFETY: the buffer is this probe's, and nothing else uses it.
            unsafe {
                device.cmd_fill_buffer(commands, groups, 0, ONE_GROUP, 0);
                device.cmd_fill_buffer(commands, groups, ONE_GROUP, vk::WHOLE_SIZE, 1);
            }
            recorder.barrier(TRANSFER_WRITE, PASS);
            for &update in &self.updates {
                self.update(commands, update, [1, 1], 1);
                self.barrier(commands);
            }
            self.copy(commands, [1, 1], Groups::line(1));
            self.barrier(commands);
        })
    }

    fn recording(&self, commands: vk::CommandBuffer) -> Commands<'_> {
        Commands::new(&self.context.device, commands, &self.solver.pipelines)
    }

    fn grid(&self) -> &GridImages {
        self.images.as_ref().expect(MADE)
    }

    /// Returns the time of one of many equal parts of a recording.
    fn each(&self, one: impl Fn(&Self, vk::CommandBuffer)) -> Result<Duration, VulkanError> {
        self.repeated(|probe, commands, count| (0..count).for_each(|_| one(probe, commands)))
    }

    /// Returns the time of one repetition in a recording of many. The time of a recording without repetitions
    /// is subtracted.
    fn repeated(
        &self,
        record: impl Fn(&Self, vk::CommandBuffer, u32),
    ) -> Result<Duration, VulkanError> {
        let time = |count| self.time(|probe, commands| record(probe, commands, count));
        let nothing = time(0)?;
        let (mut count, mut all) = (1, time(1)?);
        while all < LONG_ENOUGH && count < MOST {
            count *= 2;
            all = time(count)?;
        }
        // Other work on the machine may have delayed the recording without repetitions, so at most half of
        // the time is subtracted.
        Ok((all - nothing.min(all / 2)).max(Duration::from_nanos(1)) / count)
    }

    /// Returns the shortest time of a recording.
    fn time(&self, record: impl Fn(&Self, vk::CommandBuffer)) -> Result<Duration, VulkanError> {
        self.commands.record(|_, commands| record(self, commands))?;
        let mut shortest = Duration::MAX;
        for _ in 0..TRIES {
            let start = Instant::now();
            self.commands.submit_and_wait()?;
            shortest = shortest.min(start.elapsed());
        }
        Ok(shortest)
    }

    /// Returns the bytes a second of a read-back.
    fn read_back(&mut self) -> Result<f64, VulkanError> {
        let (from, to) = (self.buffers[0].buffer, self.buffers[1].buffer);
        self.commands.record(|_, commands| {
            let recorder = self.recording(commands);
            recorder.barrier(PASS, TRANSFER_READ);
            recorder.copy((from, 0), (to, 0), READ_BACK as u64);
            recorder.barrier(TRANSFER_WRITE, HOST_READ);
        })?;
        let (mut shortest, mut array) = (Duration::MAX, vec![0; READ_BACK]);
        for _ in 0..TRIES {
            let start = Instant::now();
            self.commands.submit_and_wait()?;
            array.copy_from_slice(&self.buffers[1].mapped()[..READ_BACK]);
            shortest = shortest.min(start.elapsed());
        }
        std::hint::black_box(&array);
        Ok(READ_BACK as f64 / shortest.as_secs_f64())
    }

    fn barrier(&self, commands: vk::CommandBuffer) {
        self.recording(commands).barrier(PASS, PASS);
    }

    /// Returns the time that a timestamp after each of many dispatches adds to one dispatch.
    fn timestamp(
        &self,
        one: impl Fn(&Self, vk::CommandBuffer),
    ) -> Result<Option<Duration>, VulkanError> {
        if self.timestamps == vk::QueryPool::null() {
            return Ok(None);
        }
        let [mut without, mut with] = [Duration::MAX; 2];
        // The two recordings alternate: their difference is small, and other work comes and goes.
        for _ in 0..TRIES {
            without = without.min(self.time(|probe, commands| {
                (0..TIMESTAMPS).for_each(|_| one(probe, commands));
            })?);
            with = with.min(self.time(|probe, commands| {
                let device = &probe.context.device;
                // SAFETY: the pool holds this many queries, which no other submission uses.
                unsafe { device.cmd_reset_query_pool(commands, probe.timestamps, 0, TIMESTAMPS) };
                for query in 0..TIMESTAMPS {
                    one(probe, commands);
                    probe.write_timestamp(commands, query);
                }
            })?);
        }
        Ok(Some(with.saturating_sub(without) / TIMESTAMPS))
    }

    fn write_timestamp(&self, commands: vk::CommandBuffer, query: u32) {
        let stage = vk::PipelineStageFlags::BOTTOM_OF_PIPE;
        // SAFETY: the query is the pool's, and was reset at the beginning.
        unsafe {
            self.context.device.cmd_write_timestamp(commands, stage, self.timestamps, query);
        }
    }

    /// Records a copy of a part of the fronts.
    fn copy(&self, commands: vk::CommandBuffer, texels: [u32; 2], groups: Groups) {
        let (recorder, copy) = (self.recording(commands), self.copy.expect(MADE));
        recorder.bind(copy, self.grid().sets.writing[1]);
        let push = ceiling_copy::Push { texels: texels.map(|texels| texels as i32) };
        recorder.dispatch(copy, &push, groups);
    }

    /// Records updates of texels from four triangles, repeated.
    fn update(
        &self,
        commands: vk::CommandBuffer,
        update: Pipeline<ceiling_updates::Push>,
        texels: [u32; 2],
        repeats: u32,
    ) {
        let recorder = self.recording(commands);
        recorder.bind(update, self.grid().sets.writing[1]);
        let push = ceiling_updates::Push { texels: texels.map(|texels| texels as i32), repeats };
        recorder.dispatch(update, &push, Groups::of(texels));
    }
}

impl Drop for Probe<'_> {
    fn drop(&mut self) {
        let (device, allocator) = (&self.context.device, &mut self.context.allocator());
        // SAFETY: all submissions have been waited for; a null handle is allowed.
        unsafe { device.destroy_query_pool(self.timestamps, None) };
        self.images.iter_mut().for_each(|images| images.destroy(device, allocator));
        self.buffers.iter_mut().for_each(|buffer| buffer.destroy(device, allocator));
        self.solver.destroy(device);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ceilings_are_measured_without_a_message_and_are_those_of_some_device() {
        let context = Context::new(&super::super::testing::device(), true).unwrap();
        let context = Arc::new(context);
        let ceilings = Probe::new(&context).unwrap().measure().unwrap();
        context.check_validation().unwrap();
        // The range is wide enough for any device, and narrow enough to detect a wrong unit.
        for rate in [&ceilings.triangles[..], &[ceilings.copy, ceilings.read_back]].concat() {
            assert!((1e6..1e14).contains(&rate), "{ceilings:?}");
        }
        let DeviceCeilings { dispatch, indirect_dispatch, skipped_dispatch, .. } = ceilings;
        let DeviceCeilings { barrier, timestamp, submission, .. } = ceilings;
        let times = [dispatch, indirect_dispatch, skipped_dispatch, barrier, submission];
        for time in times.into_iter().chain(timestamp) {
            assert!(time < Duration::from_millis(100), "{ceilings:?}");
        }
    }
}

//! Provides a renderer without a screen: a device, a queue, an allocator, a command buffer and two
//! timestamps.

use std::error::Error;
use std::time::{Duration, Instant};

use geosweep::ash::{self, vk};
use geosweep::gpu_allocator::MemoryLocation;
use geosweep::gpu_allocator::vulkan::{
    Allocation, AllocationCreateDesc, AllocationScheme, Allocator, AllocatorCreateDesc,
};
use geosweep::vulkan::requirements;

/// A headless renderer. Dropping it waits for the device and frees everything.
pub struct Host {
    pub device: ash::Device,
    pub physical_device: vk::PhysicalDevice,
    pub instance: ash::Instance,
    /// The allocator; `None` after it was dropped.
    allocator: Option<Allocator>,
    queue: vk::Queue,
    pool: vk::CommandPool,
    commands: vk::CommandBuffer,
    fence: vk::Fence,
    /// The timestamps; null if the queue does not support them.
    timestamps: vk::QueryPool,
    /// The nanoseconds per tick, and the mask of valid bits.
    tick: (f64, u64),
    _entry: ash::Entry,
}

/// A buffer with its memory.
pub struct Buffer {
    pub handle: vk::Buffer,
    allocation: Allocation,
}

/// The times of a frame.
#[derive(Clone, Copy, Debug)]
pub struct Times {
    pub record: Duration,
    /// The time from the submission to its end.
    pub host: Duration,
    /// The time between the timestamps.
    pub device: Option<Duration>,
}

impl Host {
    /// Opens the device with the index `index` in [`geosweep::vulkan::devices`].
    pub fn new(index: usize) -> Result<Self, Box<dyn Error>> {
        // SAFETY: the loader is loaded once and outlives everything created from it. Everything is destroyed
        // in `drop`.
        unsafe {
            let entry = ash::Entry::load()?;
            let application = vk::ApplicationInfo::default().api_version(requirements::API_VERSION);
            let info = vk::InstanceCreateInfo::default().application_info(&application);
            let instance = entry.create_instance(&info, None)?;
            Self::of_instance(entry, instance.clone(), index)
                .inspect_err(|_| instance.destroy_instance(None))
        }
    }

    /// Opens the device with the index `index` of an instance.
    ///
    /// # Safety
    /// `instance` was created from `entry`. On an error the caller must destroy `instance`.
    unsafe fn of_instance(
        entry: ash::Entry,
        instance: ash::Instance,
        index: usize,
    ) -> Result<Self, Box<dyn Error>> {
        // SAFETY: all handles belong to this instance and device. All created objects are stored in the result.
        unsafe {
            let found = instance.enumerate_physical_devices()?;
            let physical_device = *found.get(index).ok_or("the device is gone")?;
            let family = requirements::compute_queue_family(&instance, physical_device)
                .ok_or("the device has no queue for compute")?;
            let queues = [vk::DeviceQueueCreateInfo::default()
                .queue_family_index(family)
                .queue_priorities(&[1.0])];
            let info = vk::DeviceCreateInfo::default().queue_create_infos(&queues);
            let device = instance.create_device(physical_device, &info, None)?;
            let queue = device.get_device_queue(family, 0);
            let allocator = Allocator::new(&AllocatorCreateDesc {
                instance: instance.clone(),
                device: device.clone(),
                physical_device,
                debug_settings: Default::default(),
                buffer_device_address: false,
                allocation_sizes: Default::default(),
            })?;
            let info = vk::CommandPoolCreateInfo::default()
                .queue_family_index(family)
                .flags(vk::CommandPoolCreateFlags::RESET_COMMAND_BUFFER);
            let pool = device.create_command_pool(&info, None)?;
            let info =
                vk::CommandBufferAllocateInfo::default().command_pool(pool).command_buffer_count(1);
            let commands = device.allocate_command_buffers(&info)?[0];
            let fence = device.create_fence(&Default::default(), None)?;
            let families = instance.get_physical_device_queue_family_properties(physical_device);
            let bits = families[family as usize].timestamp_valid_bits;
            let info = vk::QueryPoolCreateInfo::default()
                .query_type(vk::QueryType::TIMESTAMP)
                .query_count(2);
            let timestamps = match bits {
                0 => vk::QueryPool::null(),
                _ => device.create_query_pool(&info, None)?,
            };
            let limits = instance.get_physical_device_properties(physical_device).limits;
            let mask = u64::MAX.checked_shr(64 - bits.min(64)).unwrap_or(0);
            Ok(Self {
                device,
                physical_device,
                instance,
                allocator: Some(allocator),
                queue,
                pool,
                commands,
                fence,
                timestamps,
                tick: (limits.timestamp_period.into(), mask),
                _entry: entry,
            })
        }
    }

    pub fn allocator(&mut self) -> &mut Allocator {
        self.allocator.as_mut().expect("it is alive until it is dropped")
    }

    /// Records a command buffer, submits it and waits for its end.
    pub fn run(
        &self,
        record: impl FnOnce(vk::CommandBuffer) -> Result<(), Box<dyn Error>>,
    ) -> Result<Times, Box<dyn Error>> {
        let Self { device, commands, fence, timestamps, .. } = self;
        let has_timestamps = *timestamps != vk::QueryPool::null();
        // SAFETY: the handles belong to this host. The command buffer is not in use, since each run waits for
        // its end.
        unsafe {
            let begin = Instant::now();
            let info = vk::CommandBufferBeginInfo::default()
                .flags(vk::CommandBufferUsageFlags::ONE_TIME_SUBMIT);
            device.begin_command_buffer(*commands, &info)?;
            let stage = vk::PipelineStageFlags::BOTTOM_OF_PIPE;
            if has_timestamps {
                device.cmd_reset_query_pool(*commands, *timestamps, 0, 2);
                device.cmd_write_timestamp(*commands, stage, *timestamps, 0);
            }
            let recorded = record(*commands);
            if has_timestamps {
                device.cmd_write_timestamp(*commands, stage, *timestamps, 1);
            }
            device.end_command_buffer(*commands)?;
            recorded?;
            let record = begin.elapsed();
            let begin = Instant::now();
            let buffers = [*commands];
            let info = vk::SubmitInfo::default().command_buffers(&buffers);
            device.queue_submit(self.queue, &[info], *fence)?;
            device.wait_for_fences(&[*fence], true, u64::MAX)?;
            let host = begin.elapsed();
            device.reset_fences(&[*fence])?;
            let mut ticks = [0u64; 2];
            if has_timestamps {
                let flags = vk::QueryResultFlags::TYPE_64 | vk::QueryResultFlags::WAIT;
                device.get_query_pool_results(*timestamps, 0, &mut ticks, flags)?;
            }
            let (nanoseconds, mask) = self.tick;
            let passed = (ticks[1].wrapping_sub(ticks[0]) & mask) as f64 * nanoseconds;
            let device = has_timestamps.then(|| Duration::from_secs_f64(1e-9 * passed));
            Ok(Times { record, host, device })
        }
    }

    /// Creates a device-local buffer with the given bytes.
    pub fn buffer_of(&mut self, bytes: &[u8]) -> Result<Buffer, Box<dyn Error>> {
        use vk::BufferUsageFlags as Usage;
        let size = bytes.len() as u64;
        let mut staging = self.buffer(size, Usage::TRANSFER_SRC, MemoryLocation::CpuToGpu)?;
        let mapped = staging.allocation.mapped_slice_mut().ok_or("the memory is not mapped")?;
        mapped[..bytes.len()].copy_from_slice(bytes);
        let usage = Usage::STORAGE_BUFFER | Usage::TRANSFER_DST;
        let made = self.buffer(size, usage, MemoryLocation::GpuOnly)?;
        let regions = [vk::BufferCopy::default().size(size)];
        self.run(|commands| {
            // SAFETY: both buffers are alive until the run has ended.
            unsafe {
                self.device.cmd_copy_buffer(commands, staging.handle, made.handle, &regions);
            };
            Ok(())
        })?;
        self.free(staging)?;
        Ok(made)
    }

    fn buffer(
        &mut self,
        size: u64,
        usage: vk::BufferUsageFlags,
        location: MemoryLocation,
    ) -> Result<Buffer, Box<dyn Error>> {
        let info = vk::BufferCreateInfo::default().size(size).usage(usage);
        // SAFETY: the device is alive.
        let (handle, requirements) = unsafe {
            let handle = self.device.create_buffer(&info, None)?;
            (handle, self.device.get_buffer_memory_requirements(handle))
        };
        let allocation = self.allocator().allocate(&AllocationCreateDesc {
            name: "vertices",
            requirements,
            location,
            linear: true,
            allocation_scheme: AllocationScheme::GpuAllocatorManaged,
        })?;
        // SAFETY: the memory meets the buffer's requirements.
        unsafe {
            self.device.bind_buffer_memory(handle, allocation.memory(), allocation.offset())?;
        }
        Ok(Buffer { handle, allocation })
    }

    /// Frees a buffer that no command uses any more.
    pub fn free(&mut self, buffer: Buffer) -> Result<(), Box<dyn Error>> {
        // SAFETY: all runs have ended, so no command uses the buffer.
        unsafe { self.device.destroy_buffer(buffer.handle, None) };
        Ok(self.allocator().free(buffer.allocation)?)
    }
}

impl Drop for Host {
    fn drop(&mut self) {
        // SAFETY: each handle is destroyed once, after the device has become idle, and the instance last.
        unsafe {
            // A lost device is idle too, so the error is ignored.
            let _ = self.device.device_wait_idle();
            self.device.destroy_query_pool(self.timestamps, None);
            self.device.destroy_fence(self.fence, None);
            self.device.destroy_command_pool(self.pool, None);
            drop(self.allocator.take());
            self.device.destroy_device(None);
            self.instance.destroy_instance(None);
        }
    }
}

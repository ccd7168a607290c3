//! Opens a device of this crate's own with one queue, for use without a renderer, and records and submits command
//! buffers on it.

use std::mem::ManuallyDrop;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use ash::{khr, vk};
use gpu_allocator::vulkan::{Allocator, AllocatorCreateDesc};

use crate::vulkan::device::instance::Instance;
use crate::vulkan::device::validation::ValidationLog;
use crate::vulkan::device::{devices, requirements};
use crate::vulkan::profile::{Capabilities, Capability, PassRecord};
use crate::vulkan::record::Observer;
use crate::vulkan::{DeviceChoice, DeviceInfo, VulkanError};

/// Device with one compute queue and an allocator. Several threads may use it.
pub(crate) struct Context {
    pub(crate) device: ash::Device,
    pub(crate) info: DeviceInfo,
    pub(crate) physical_device: vk::PhysicalDevice,
    /// Profiling capabilities, if the device was opened for profiling.
    pub(crate) capabilities: Option<Capabilities>,
    /// Number of the queue's family.
    family: u32,
    /// Compute queue. Vulkan lets one thread submit to it at a time.
    queue: Mutex<vk::Queue>,
    allocator: ManuallyDrop<Mutex<Allocator>>,
    // Fields are dropped after `drop` has destroyed the device, so the instance outlives it.
    pub(crate) instance: Instance,
}

impl Context {
    pub(crate) fn new(choice: &DeviceChoice, validate: bool) -> Result<Self, VulkanError> {
        Self::open(choice, validate, None)
    }

    /// Opens a device. With `left_out`, everything that profiling uses and the device offers is enabled, except for the
    /// capabilities listed there. Without it, nothing is enabled for profiling.
    pub(crate) fn open(
        choice: &DeviceChoice,
        validate: bool,
        left_out: Option<&[Capability]>,
    ) -> Result<Self, VulkanError> {
        let labels = left_out.is_some_and(|left_out| !left_out.contains(&Capability::Labels));
        let instance = Instance::open(validate, labels)?;
        let (info, physical_device) = devices::choose(&instance, choice)?;
        let family = requirements::compute_queue_family(&instance.handle, physical_device)
            .expect("a chosen device meets the requirements");
        let queues = [vk::DeviceQueueCreateInfo::default()
            .queue_family_index(family)
            .queue_priorities(&[1.0])];
        let capabilities = left_out.map(|left_out| {
            let debug_utils = instance.debug_utils;
            Capabilities::of(&instance.handle, physical_device, family, debug_utils)
                .without(left_out)
        });
        let wanted = capabilities.as_ref();
        let extensions = wanted.map_or(Vec::new(), Capabilities::device_extensions);
        let mut extensions: Vec<_> = extensions.iter().map(|name| name.as_ptr()).collect();
        if requirements::is_portable_subset(&instance.handle, physical_device) {
            extensions.push(khr::portability_subset::NAME.as_ptr());
        }
        let features = vk::PhysicalDeviceFeatures::default()
            .pipeline_statistics_query(wanted.is_some_and(|wanted| wanted.statistics.is_ok()));
        let mut executables = vk::PhysicalDevicePipelineExecutablePropertiesFeaturesKHR::default()
            .pipeline_executable_info(true);
        let mut create = vk::DeviceCreateInfo::default()
            .queue_create_infos(&queues)
            .enabled_extension_names(&extensions)
            .enabled_features(&features);
        if wanted.is_some_and(|wanted| wanted.executables.is_ok()) {
            create = create.push_next(&mut executables);
        }
        // SAFETY: the physical device has this queue family.
        let device = unsafe { instance.handle.create_device(physical_device, &create, None) }
            .map_err(VulkanError::from_call("vkCreateDevice"))?;
        let allocator = Allocator::new(&AllocatorCreateDesc {
            instance: instance.handle.clone(),
            device: device.clone(),
            physical_device,
            debug_settings: Default::default(),
            buffer_device_address: false,
            allocation_sizes: Default::default(),
        });
        let allocator = match allocator {
            Ok(allocator) => ManuallyDrop::new(Mutex::new(allocator)),
            Err(source) => {
                // SAFETY: nothing was made from the device.
                unsafe { device.destroy_device(None) };
                return Err(VulkanError::Allocation { what: "the allocator", source });
            }
        };
        // SAFETY: the family's first queue was created with the device.
        let queue = unsafe { device.get_device_queue(family, 0) };
        let queue = Mutex::new(queue);
        Ok(Self { device, info, physical_device, capabilities, family, queue, allocator, instance })
    }

    pub(crate) fn allocator(&self) -> MutexGuard<'_, Allocator> {
        self.allocator.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Records commands, submits them and waits for their end.
    pub(crate) fn run(
        self: &Arc<Self>,
        append: impl FnOnce(&ash::Device, vk::CommandBuffer),
    ) -> Result<(), VulkanError> {
        let commands = CommandBuffer::new(self)?;
        commands.record(append)?;
        commands.submit_and_wait()
    }

    /// Returns an error if the validation layers have reported anything.
    pub(crate) fn check_validation(&self) -> Result<(), VulkanError> {
        let messages = self.instance.validation_log().map_or(Vec::new(), ValidationLog::messages);
        if messages.is_empty() { Ok(()) } else { Err(VulkanError::Validation(messages)) }
    }
}

impl Drop for Context {
    fn drop(&mut self) {
        // SAFETY: the device is alive; its other children are gone, since they borrow or share
        // the context. The allocator is not used after it is dropped.
        unsafe {
            let _ = self.device.device_wait_idle();
            ManuallyDrop::drop(&mut self.allocator);
            self.device.destroy_device(None);
        }
    }
}

/// Records and submits command buffers, and waits for them.
pub(crate) trait Submitter {
    /// Records a command buffer. Its earlier contents are replaced.
    fn record(
        &self,
        commands: &CommandBuffer,
        append: impl FnOnce(&ash::Device, vk::CommandBuffer, Option<&dyn Observer>),
    ) -> Result<(), VulkanError>;

    /// Submits the recorded commands and waits for their end.
    fn submit(&mut self, commands: &CommandBuffer) -> Result<(), VulkanError>;

    /// Submits recorded commands that [`Flight::wait`] waits for. A submitter may wait for them at once.
    fn start(&mut self, flight: &mut Flight) -> Result<(), VulkanError> {
        self.submit(&flight.commands)
    }

    /// Notes that a map begins. A profile counts its time from now on.
    fn restart(&mut self) {}

    /// Returns whether the submitter records passes for a profile.
    fn is_watching(&self) -> bool {
        false
    }

    /// Returns the records of the passes submitted last, if the submitter records passes for a profile.
    fn last(&mut self) -> Option<&mut [PassRecord]> {
        None
    }
}

/// Submitter that does not record passes for a profile.
pub(crate) struct Unwatched;

impl Submitter for Unwatched {
    fn record(
        &self,
        commands: &CommandBuffer,
        append: impl FnOnce(&ash::Device, vk::CommandBuffer, Option<&dyn Observer>),
    ) -> Result<(), VulkanError> {
        commands.record(|device, buffer| append(device, buffer, None))
    }

    fn submit(&mut self, commands: &CommandBuffer) -> Result<(), VulkanError> {
        commands.submit_and_wait()
    }

    fn start(&mut self, flight: &mut Flight) -> Result<(), VulkanError> {
        flight.start()
    }
}

/// Command buffer that can be recorded again. If `new` has made it, a recording is submitted once. If `kept` has made
/// it, a recording is submitted any number of times, each after the last submission has ended.
///
/// Each command buffer has its own pool and fence: Vulkan lets one thread use a pool at a time, and command buffers of
/// one device may be recorded and dropped on several threads.
pub(crate) struct CommandBuffer {
    context: Arc<Context>,
    pool: vk::CommandPool,
    buffer: vk::CommandBuffer,
    fence: vk::Fence,
    usage: vk::CommandBufferUsageFlags,
}

impl CommandBuffer {
    /// Allocates a command buffer whose recordings are submitted once.
    pub(crate) fn new(context: &Arc<Context>) -> Result<Self, VulkanError> {
        Self::with(context, vk::CommandBufferUsageFlags::ONE_TIME_SUBMIT)
    }

    /// Allocates a command buffer whose recordings may be submitted any number of times.
    pub(crate) fn kept(context: &Arc<Context>) -> Result<Self, VulkanError> {
        Self::with(context, vk::CommandBufferUsageFlags::empty())
    }

    fn with(
        context: &Arc<Context>,
        usage: vk::CommandBufferUsageFlags,
    ) -> Result<Self, VulkanError> {
        let (pool, buffer, fence) = Default::default();
        let mut new = Self { context: Arc::clone(context), pool, buffer, fence, usage };
        let device = &context.device;
        let pool = vk::CommandPoolCreateInfo::default()
            .flags(vk::CommandPoolCreateFlags::RESET_COMMAND_BUFFER)
            .queue_family_index(context.family);
        // SAFETY: the device was created with this queue family.
        new.pool = unsafe { device.create_command_pool(&pool, None) }
            .map_err(VulkanError::from_call("vkCreateCommandPool"))?;
        let info = vk::CommandBufferAllocateInfo::default()
            .command_pool(new.pool)
            .level(vk::CommandBufferLevel::PRIMARY)
            .command_buffer_count(1);
        // SAFETY: the pool is new, and no other thread knows it.
        let buffers = unsafe { device.allocate_command_buffers(&info) }
            .map_err(VulkanError::from_call("vkAllocateCommandBuffers"))?;
        new.buffer = buffers[0];
        // SAFETY: nothing is borrowed beyond the call.
        new.fence = unsafe { device.create_fence(&vk::FenceCreateInfo::default(), None) }
            .map_err(VulkanError::from_call("vkCreateFence"))?;
        Ok(new)
    }

    /// Records the command buffer. Its earlier contents are replaced.
    pub(crate) fn record(
        &self,
        append: impl FnOnce(&ash::Device, vk::CommandBuffer),
    ) -> Result<(), VulkanError> {
        let device = &self.context.device;
        let begin = vk::CommandBufferBeginInfo::default().flags(self.usage);
        // SAFETY: submissions have been waited for, and its pool lets buffers be reset.
        unsafe { device.begin_command_buffer(self.buffer, &begin) }
            .map_err(VulkanError::from_call("vkBeginCommandBuffer"))?;
        append(device, self.buffer);
        // SAFETY: the buffer is being recorded.
        unsafe { device.end_command_buffer(self.buffer) }
            .map_err(VulkanError::from_call("vkEndCommandBuffer"))
    }

    pub(crate) fn submit_and_wait(&self) -> Result<(), VulkanError> {
        self.submit()?;
        self.wait()
    }

    fn submit(&self) -> Result<(), VulkanError> {
        let Context { device, queue, .. } = &*self.context;
        let buffers = [self.buffer];
        let submit = vk::SubmitInfo::default().command_buffers(&buffers);
        let queue = queue.lock().unwrap_or_else(PoisonError::into_inner);
        // SAFETY: the buffer is recorded and not pending, the fence is unsignalled, and the queue is locked.
        unsafe { device.queue_submit(*queue, &[submit], self.fence) }
            .map_err(VulkanError::from_call("vkQueueSubmit"))
    }

    /// Waits for the fence of a submission, and resets it.
    fn wait(&self) -> Result<(), VulkanError> {
        let (device, fence) = (&self.context.device, self.fence);
        // SAFETY: the fence was submitted.
        unsafe { device.wait_for_fences(&[fence], true, u64::MAX) }
            .map_err(VulkanError::from_call("vkWaitForFences"))?;
        // SAFETY: the fence is signalled.
        unsafe { device.reset_fences(&[fence]) }.map_err(VulkanError::from_call("vkResetFences"))
    }
}

impl Drop for CommandBuffer {
    fn drop(&mut self) {
        let device = &self.context.device;
        // SAFETY: submissions have been waited for; after a lost device nothing is pending. The pool frees its command
        // buffer; null handles are allowed.
        unsafe {
            device.destroy_fence(self.fence, None);
            device.destroy_command_pool(self.pool, None);
        }
    }
}

/// Command buffer that the device may run while the program does other work.
pub(crate) struct Flight {
    /// Command buffer, to be recorded only after [`Flight::wait`].
    pub(crate) commands: CommandBuffer,
    is_pending: bool,
}

impl Flight {
    pub(crate) fn new(context: &Arc<Context>) -> Result<Self, VulkanError> {
        Ok(Self { commands: CommandBuffer::new(context)?, is_pending: false })
    }

    /// Submits the recorded commands. The caller has waited for the last submission.
    fn start(&mut self) -> Result<(), VulkanError> {
        self.commands.submit()?;
        self.is_pending = true;
        Ok(())
    }

    /// Waits for the last submission, if the device may still run it.
    pub(crate) fn wait(&mut self) -> Result<(), VulkanError> {
        match std::mem::take(&mut self.is_pending) {
            true => self.commands.wait(),
            false => Ok(()),
        }
    }
}

impl Drop for Flight {
    fn drop(&mut self) {
        // If waiting fails since the device is lost, nothing is pending.
        let _ = self.wait();
    }
}

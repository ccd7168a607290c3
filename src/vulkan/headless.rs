//! An instance, a device and a queue of our own, for use without a renderer.

use std::mem::ManuallyDrop;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use ash::{ext, vk};
use gpu_allocator::vulkan::{Allocator, AllocatorCreateDesc};

use super::profile::{Capabilities, Capability};
use super::requirements::API_VERSION;
use super::validation::{self, Messenger, ValidationLog};
use super::{DeviceInfo, VulkanError, devices, requirements};
use crate::vulkan::DeviceChoice;

/// The loader and an instance, with the validation layers if asked for.
pub(crate) struct Instance {
    // The entry keeps the loader's library in memory.
    _entry: ash::Entry,
    pub(crate) handle: ash::Instance,
    messenger: Option<Messenger>,
    /// Whether tools can be shown labels and names.
    debug_utils: bool,
}

impl Instance {
    pub(crate) fn new(validate: bool) -> Result<Self, VulkanError> {
        Self::open(validate, false)
    }

    /// With labels and names for tools, where the loader offers them.
    fn open(validate: bool, labels: bool) -> Result<Self, VulkanError> {
        // SAFETY: the loader's library is the system's own and is kept loaded by the entry.
        let entry = unsafe { ash::Entry::load() }
            .map_err(|error| VulkanError::NoLoader(error.to_string()))?;
        let application = vk::ApplicationInfo::default()
            .application_name(c"geosweep")
            .engine_name(c"geosweep")
            .api_version(API_VERSION);
        let mut features =
            vk::ValidationFeaturesEXT::default().enabled_validation_features(&validation::FEATURES);
        let layers = [validation::LAYER.as_ptr()];
        let extensions = [ext::debug_utils::NAME.as_ptr(), ext::validation_features::NAME.as_ptr()];
        // SAFETY: no layer's extensions are asked for.
        let offered = unsafe { entry.enumerate_instance_extension_properties(None) };
        let debug_utils = labels
            && offered
                .unwrap_or_default()
                .iter()
                .any(|extension| extension.extension_name_as_c_str() == Ok(ext::debug_utils::NAME));
        let mut info = vk::InstanceCreateInfo::default().application_info(&application);
        if validate {
            info = info
                .enabled_layer_names(&layers)
                .enabled_extension_names(&extensions)
                .push_next(&mut features);
        } else if debug_utils {
            info = info.enabled_extension_names(&extensions[..1]);
        }
        // SAFETY: all that the structures point to is alive.
        let handle = match unsafe { entry.create_instance(&info, None) } {
            Ok(handle) => handle,
            Err(vk::Result::ERROR_LAYER_NOT_PRESENT) => return Err(VulkanError::NoValidationLayer),
            Err(vk::Result::ERROR_INCOMPATIBLE_DRIVER) => return Err(VulkanError::NoDevice),
            Err(result) => return Err(VulkanError::Call { call: "vkCreateInstance", result }),
        };
        let mut new = Self { _entry: entry, handle, messenger: None, debug_utils };
        if validate {
            new.messenger = Some(Messenger::new(&new._entry, &new.handle)?);
        }
        Ok(new)
    }

    pub(crate) fn validation_log(&self) -> Option<&ValidationLog> {
        self.messenger.as_ref().map(Messenger::log)
    }
}

impl Drop for Instance {
    fn drop(&mut self) {
        if let Some(messenger) = &mut self.messenger {
            messenger.destroy();
        }
        // SAFETY: everything made from the instance is gone.
        unsafe { self.handle.destroy_instance(None) };
    }
}

/// A device with one compute queue, an allocator and command buffers.
pub(crate) struct Context {
    pub(crate) device: ash::Device,
    pub(crate) info: DeviceInfo,
    pub(crate) physical_device: vk::PhysicalDevice,
    /// For profiling, if the device was opened for that.
    pub(crate) capabilities: Option<Capabilities>,
    queue: vk::Queue,
    allocator: ManuallyDrop<Mutex<Allocator>>,
    pool: vk::CommandPool,
    fence: vk::Fence,
    // Last, so that it is dropped last.
    pub(crate) instance: Instance,
}

impl Context {
    pub(crate) fn new(choice: &DeviceChoice, validate: bool) -> Result<Self, VulkanError> {
        Self::open(choice, validate, None)
    }

    /// With all that profiling takes, but for what is left out, if that is given.
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
        let extensions: Vec<_> = extensions.iter().map(|name| name.as_ptr()).collect();
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
        let mut new = Self {
            device,
            info,
            physical_device,
            capabilities,
            queue,
            allocator,
            pool: vk::CommandPool::null(),
            fence: vk::Fence::null(),
            instance,
        };
        let pool = vk::CommandPoolCreateInfo::default()
            .flags(vk::CommandPoolCreateFlags::RESET_COMMAND_BUFFER)
            .queue_family_index(family);
        // SAFETY: the device was created with this queue family.
        new.pool = unsafe { new.device.create_command_pool(&pool, None) }
            .map_err(VulkanError::from_call("vkCreateCommandPool"))?;
        // SAFETY: nothing is borrowed beyond the call.
        new.fence = unsafe { new.device.create_fence(&vk::FenceCreateInfo::default(), None) }
            .map_err(VulkanError::from_call("vkCreateFence"))?;
        Ok(new)
    }

    pub(crate) fn allocator(&self) -> MutexGuard<'_, Allocator> {
        self.allocator.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Records, submits and waits.
    pub(crate) fn run(
        self: &Arc<Self>,
        append: impl FnOnce(&ash::Device, vk::CommandBuffer),
    ) -> Result<(), VulkanError> {
        let commands = Commands::new(self)?;
        commands.record(append)?;
        commands.submit_and_wait()
    }

    /// An error if the validation layers have found anything.
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
            self.device.destroy_fence(self.fence, None);
            self.device.destroy_command_pool(self.pool, None);
            ManuallyDrop::drop(&mut self.allocator);
            self.device.destroy_device(None);
        }
    }
}

/// A command buffer that can be recorded anew and submitted many times, one submission at a time.
pub(crate) struct Commands {
    context: Arc<Context>,
    buffer: vk::CommandBuffer,
}

impl Commands {
    pub(crate) fn new(context: &Arc<Context>) -> Result<Self, VulkanError> {
        let info = vk::CommandBufferAllocateInfo::default()
            .command_pool(context.pool)
            .level(vk::CommandBufferLevel::PRIMARY)
            .command_buffer_count(1);
        // SAFETY: the pool is alive and used by one thread at a time, since it is not shared.
        let buffers = unsafe { context.device.allocate_command_buffers(&info) }
            .map_err(VulkanError::from_call("vkAllocateCommandBuffers"))?;
        Ok(Self { context: Arc::clone(context), buffer: buffers[0] })
    }

    /// Records it, in place of what it held.
    pub(crate) fn record(
        &self,
        append: impl FnOnce(&ash::Device, vk::CommandBuffer),
    ) -> Result<(), VulkanError> {
        let device = &self.context.device;
        // SAFETY: submissions have been waited for, and its pool lets buffers be reset.
        unsafe { device.begin_command_buffer(self.buffer, &vk::CommandBufferBeginInfo::default()) }
            .map_err(VulkanError::from_call("vkBeginCommandBuffer"))?;
        append(device, self.buffer);
        // SAFETY: the buffer is being recorded.
        unsafe { device.end_command_buffer(self.buffer) }
            .map_err(VulkanError::from_call("vkEndCommandBuffer"))
    }

    pub(crate) fn submit_and_wait(&self) -> Result<(), VulkanError> {
        let Context { device, queue, fence, .. } = &*self.context;
        let buffers = [self.buffer];
        let submit = vk::SubmitInfo::default().command_buffers(&buffers);
        // SAFETY: the buffer is recorded and not pending, and the fence is unsignalled.
        unsafe { device.queue_submit(*queue, &[submit], *fence) }
            .map_err(VulkanError::from_call("vkQueueSubmit"))?;
        // SAFETY: the fence was submitted above.
        unsafe { device.wait_for_fences(&[*fence], true, u64::MAX) }
            .map_err(VulkanError::from_call("vkWaitForFences"))?;
        // SAFETY: the fence is signalled.
        unsafe { device.reset_fences(&[*fence]) }.map_err(VulkanError::from_call("vkResetFences"))
    }
}

impl Drop for Commands {
    fn drop(&mut self) {
        // SAFETY: submissions have been waited for; after a lost device nothing is pending.
        unsafe { self.context.device.free_command_buffers(self.context.pool, &[self.buffer]) };
    }
}

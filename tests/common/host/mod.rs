//! A minimal renderer: an instance, a device, an allocator, a main queue, a second queue for compute, and its
//! own compute passes in WGSL.

#![allow(dead_code)] // each test binary uses its part

use std::ffi::{CStr, c_void};
use std::ops::{Deref, DerefMut};

use geosweep::ash::{self, vk};
use geosweep::gpu_allocator::MemoryLocation;

#[path = "../../../examples/shared/context.rs"]
mod context;
mod images;
#[path = "../../../examples/shared/memory.rs"]
mod memory;
mod passes;
pub mod queues;

use context::{Context, Instance, LAYER, SYNCHRONIZATION};
pub use memory::{Buffer as HostBuffer, Image as HostImage};
use memory::{ImageUse, whole, whole_copy};
use queues::{HostQueue, Place};

/// The renderer.
pub struct Host {
    context: Context,
    /// Main queue, for compute and graphics.
    pub queue: vk::Queue,
    /// Pool for command buffers of the main queue.
    pub pool: vk::CommandPool,
    /// Second queue, of another family if the device has one. It may be the main queue itself.
    pub compute: HostQueue,
}

impl Deref for Host {
    type Target = Context;

    fn deref(&self) -> &Context {
        &self.context
    }
}

impl DerefMut for Host {
    fn deref_mut(&mut self) -> &mut Context {
        &mut self.context
    }
}

/// An image as the target of a render pass.
pub struct Target {
    pass: vk::RenderPass,
    framebuffer: vk::Framebuffer,
    extent: vk::Extent2D,
}

/// A picture with a depth image, and the render pass that draws it.
pub struct Canvas {
    target: Target,
    picture: HostImage,
    depths: HostImage,
}

/// A pass of the host that has storage buffers and may have an image after them, with a sampler at the last binding.
pub struct HostPass {
    pipeline: vk::Pipeline,
    layout: vk::PipelineLayout,
    set_layout: vk::DescriptorSetLayout,
    descriptors: vk::DescriptorPool,
    set: vk::DescriptorSet,
    /// Linear sampler that clamps to the edge, for a pass with an image.
    sampler: Option<vk::Sampler>,
}

impl Host {
    /// Creates a host under the validation layers.
    pub fn new() -> Self {
        let all = [
            vk::ValidationFeatureEnableEXT::SYNCHRONIZATION_VALIDATION,
            vk::ValidationFeatureEnableEXT::GPU_ASSISTED,
        ];
        // Layers 1.3.275 add code to shaders that reads a missing descriptor on lavapipe of Mesa 25.2. The tests
        // trust no version from 1.3.240 until before 1.4.0.
        let is_sound = !(vk::make_api_version(0, 1, 3, 240)..vk::make_api_version(0, 1, 4, 0))
            .contains(&layers_version());
        let disabled = std::env::var("VK_LAYER_DISABLES").unwrap_or_default();
        let wanted = !disabled.contains("VK_VALIDATION_FEATURE_DISABLE_SHADERS_EXT");
        Self::open(if is_sound && wanted { &all } else { &all[..1] })
    }

    /// Creates a host under the validation layers, without their checks in shaders: these take long for many
    /// pixels.
    pub fn with_synchronization_validation() -> Self {
        Self::open(SYNCHRONIZATION)
    }

    /// Creates a host without validation layers: for timings, and for faults that the layers would rightly
    /// report.
    pub fn without_validation() -> Self {
        Self::open(&[])
    }

    fn open(checks: &[vk::ValidationFeatureEnableEXT]) -> Self {
        let instance = Instance::new(Vec::new(), checks).unwrap();
        let wanted = std::env::var("GEOSWEEP_TEST_DEVICE").unwrap_or_default();
        let (physical_device, ()) = instance
            .choose(&wanted, |_| Ok(()))
            .expect("the tests need a Vulkan device; ci/setup installs lavapipe");
        let places = queues::of(&instance.handle, physical_device);
        let priorities = [1.0; 2];
        let queues = queues::counts(places).map(|(family, count)| {
            vk::DeviceQueueCreateInfo::default()
                .queue_family_index(family)
                .queue_priorities(&priorities[..count])
        });
        let queues: Vec<_> = queues.collect();
        let context = Context::new(instance, physical_device, &queues, &[]).unwrap();
        let [main, compute] = places.map(|place| HostQueue::new(&context.device, place));
        Self { context, queue: main.handle, pool: main.pool, compute }
    }

    /// Returns the number of allocations.
    pub fn allocations(&self) -> usize {
        self.allocator.as_ref().unwrap().generate_report().allocations.len()
    }

    /// Returns whether the device computes on the processor's cores.
    pub fn is_processor(&self) -> bool {
        self.properties().device_type == vk::PhysicalDeviceType::CPU
    }

    /// Allocates a command buffer for the main queue.
    pub fn commands(&self) -> vk::CommandBuffer {
        self.commands_from(self.pool)
    }

    /// Allocates a command buffer from a pool.
    pub fn commands_from(&self, pool: vk::CommandPool) -> vk::CommandBuffer {
        let info =
            vk::CommandBufferAllocateInfo::default().command_pool(pool).command_buffer_count(1);
        unsafe { self.device.allocate_command_buffers(&info) }.unwrap()[0]
    }

    pub fn begin(&self, commands: vk::CommandBuffer) {
        let info = vk::CommandBufferBeginInfo::default();
        unsafe { self.device.begin_command_buffer(commands, &info) }.unwrap();
    }

    pub fn end(&self, commands: vk::CommandBuffer) {
        unsafe { self.device.end_command_buffer(commands) }.unwrap();
    }

    pub fn submit(&self, commands: vk::CommandBuffer, fence: vk::Fence) {
        unsafe {
            let commands = [commands];
            let info = vk::SubmitInfo::default().command_buffers(&commands);
            self.device.queue_submit(self.queue, &[info], fence).unwrap();
        }
    }

    /// Records, submits and waits.
    pub fn run<T>(&self, record: impl FnOnce(vk::CommandBuffer) -> T) -> T {
        self.record_for(true, record)
    }

    /// Records, then discards the recording.
    pub fn discard<T>(&self, record: impl FnOnce(vk::CommandBuffer) -> T) -> T {
        self.record_for(false, record)
    }

    fn record_for<T>(&self, runs: bool, record: impl FnOnce(vk::CommandBuffer) -> T) -> T {
        let commands = self.commands();
        self.begin(commands);
        let result = record(commands);
        self.end(commands);
        if runs {
            self.submit(commands, vk::Fence::null());
        }
        unsafe {
            self.device.queue_wait_idle(self.queue).unwrap();
            self.device.free_command_buffers(self.pool, &[commands]);
        }
        result
    }

    /// Records a barrier for all memory.
    pub fn barrier(
        &self,
        commands: vk::CommandBuffer,
        before: geosweep::vulkan::embed::Access,
        after: geosweep::vulkan::embed::Access,
    ) {
        let barrier = vk::MemoryBarrier::default()
            .src_access_mask(before.access)
            .dst_access_mask(after.access);
        let none = vk::DependencyFlags::empty();
        unsafe {
            let (from, to) = (before.stages, after.stages);
            self.device.cmd_pipeline_barrier(commands, from, to, none, &[barrier], &[], &[]);
        }
    }

    /// Returns the device with some functions replaced: those for which `replace` returns another function.
    pub fn device_with(
        &self,
        replace: impl Fn(&CStr) -> Option<extern "system" fn() -> vk::Result>,
    ) -> ash::Device {
        let handle = self.device.handle();
        let load = |name: &CStr| match replace(name) {
            // The function has no parameters. The calling convention allows arguments in a call of such a function.
            Some(function) => function as *const c_void,
            None => unsafe {
                std::mem::transmute::<vk::PFN_vkVoidFunction, *const c_void>((self
                    .instance
                    .fp_v1_0()
                    .get_device_proc_addr)(
                    handle,
                    name.as_ptr(),
                ))
            },
        };
        unsafe { ash::Device::load_with(load, handle) }
    }
}

impl Drop for Host {
    fn drop(&mut self) {
        self.wait();
        unsafe {
            self.device.destroy_command_pool(self.pool, None);
            self.device.destroy_command_pool(self.compute.pool, None);
        }
        self.context.close_device();
        self.context.root.close();
        if !std::thread::panicking() {
            // Messages while the device is destroyed are about objects that were left behind.
            let left: Vec<_> =
                self.messages().into_iter().filter(|m| m.contains("vkDestroyDevice")).collect();
            assert_eq!(left, Vec::<String>::new());
        }
    }
}

/// Returns the family of the main queue.
pub fn family(instance: &ash::Instance, physical_device: vk::PhysicalDevice) -> u32 {
    let [Place { family, .. }, _] = queues::of(instance, physical_device);
    family
}

/// Returns the version of the validation layers.
pub fn layers_version() -> u32 {
    // SAFETY: the process loads its own loader, as in [`Host`].
    let entry = unsafe { ash::Entry::load() }.unwrap();
    // SAFETY: this needs only the loader.
    let layers = unsafe { entry.enumerate_instance_layer_properties() }.unwrap();
    let is_validation = |layer: &&vk::LayerProperties| layer.layer_name_as_c_str() == Ok(LAYER);
    layers.iter().find(is_validation).expect("the validation layers are installed").spec_version
}

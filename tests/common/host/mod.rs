//! A minimal renderer: an instance, a device, an allocator, a main queue, a second queue for compute, and its
//! own compute passes in WGSL.

#![allow(dead_code)] // each test binary uses its part

use std::ffi::{CStr, c_void};
use std::sync::Mutex;

use geosweep::ash::{self, ext, vk};
use geosweep::gpu_allocator::MemoryLocation;
use geosweep::gpu_allocator::vulkan::{
    Allocation, AllocationCreateDesc, AllocationScheme, Allocator, AllocatorCreateDesc,
};
use geosweep::vulkan::requirements;

mod memory;
mod passes;
pub mod queues;

use queues::{HostQueue, Place};

const LAYER: &CStr = c"VK_LAYER_KHRONOS_validation";

/// The renderer.
pub struct Host {
    pub device: ash::Device,
    pub allocator: Option<Allocator>,
    pub physical_device: vk::PhysicalDevice,
    /// Main queue, for compute and graphics.
    pub queue: vk::Queue,
    /// Pool for command buffers of the main queue.
    pub pool: vk::CommandPool,
    /// Second queue, of another family if the device has one. It may be the main queue itself.
    pub compute: HostQueue,
    pub instance: ash::Instance,
    messenger: Option<(ext::debug_utils::Instance, vk::DebugUtilsMessengerEXT)>,
    log: Box<Mutex<Vec<String>>>,
    _entry: ash::Entry,
}

/// A buffer with its memory.
pub struct HostBuffer {
    pub handle: vk::Buffer,
    allocation: Allocation,
}

/// An image with its memory, with one texel per grid point.
pub struct HostImage {
    pub image: vk::Image,
    pub view: vk::ImageView,
    allocation: Allocation,
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
        Self::open(&[vk::ValidationFeatureEnableEXT::SYNCHRONIZATION_VALIDATION])
    }

    /// Creates a host without validation layers: for timings, and for faults that the layers would rightly
    /// report.
    pub fn without_validation() -> Self {
        Self::open(&[])
    }

    fn open(enabled: &[vk::ValidationFeatureEnableEXT]) -> Self {
        let validate = !enabled.is_empty();
        let entry = unsafe { ash::Entry::load() }.unwrap();
        let application = vk::ApplicationInfo::default().api_version(requirements::API_VERSION);
        let mut features =
            vk::ValidationFeaturesEXT::default().enabled_validation_features(enabled);
        let layers = [LAYER.as_ptr()];
        let mut extensions =
            vec![ext::debug_utils::NAME.as_ptr(), ext::validation_features::NAME.as_ptr()];
        // Newer layers report hazards of shaders only on request. Older ones do not have the setting.
        let of_layer = unsafe { entry.enumerate_instance_extension_properties(Some(LAYER)) };
        let takes_settings = of_layer
            .unwrap_or_default()
            .iter()
            .any(|extension| extension.extension_name_as_c_str() == Ok(ext::layer_settings::NAME));
        let mut setting = vk::LayerSettingEXT::default()
            .layer_name(LAYER)
            .setting_name(c"syncval_shader_accesses_heuristic")
            .ty(vk::LayerSettingTypeEXT::BOOL32);
        (setting.value_count, setting.p_values) = (1, std::ptr::from_ref(&vk::TRUE).cast());
        let settings = [setting];
        let mut settings = vk::LayerSettingsCreateInfoEXT::default().settings(&settings);
        let mut info = vk::InstanceCreateInfo::default().application_info(&application);
        if validate {
            if takes_settings {
                extensions.push(ext::layer_settings::NAME.as_ptr());
                info = info.push_next(&mut settings);
            }
            info = info
                .enabled_layer_names(&layers)
                .enabled_extension_names(&extensions)
                .push_next(&mut features);
        }
        let instance = unsafe { entry.create_instance(&info, None) }
            .expect("the tests need the validation layers; ci/setup installs them");
        let log = Box::new(Mutex::new(Vec::new()));
        let messenger = validate.then(|| listen(&entry, &instance, &log));

        let wanted = std::env::var("GEOSWEEP_TEST_DEVICE").unwrap_or_default().to_lowercase();
        let physical_device = unsafe { instance.enumerate_physical_devices() }
            .unwrap()
            .into_iter()
            .find(|&device| {
                let properties = unsafe { instance.get_physical_device_properties(device) };
                let name = properties.device_name_as_c_str().unwrap().to_string_lossy();
                name.to_lowercase().contains(&wanted)
                    && requirements::unmet(&instance, device).is_empty()
            })
            .expect("the tests need a Vulkan device; ci/setup installs lavapipe");
        let places = queues::of(&instance, physical_device);
        let priorities = [1.0; 2];
        let queues = queues::counts(places).map(|(family, count)| {
            vk::DeviceQueueCreateInfo::default()
                .queue_family_index(family)
                .queue_priorities(&priorities[..count])
        });
        let queues: Vec<_> = queues.collect();
        let features = requirements::features();
        let info =
            vk::DeviceCreateInfo::default().queue_create_infos(&queues).enabled_features(&features);
        let device = unsafe { instance.create_device(physical_device, &info, None) }.unwrap();
        let allocator = Allocator::new(&AllocatorCreateDesc {
            instance: instance.clone(),
            device: device.clone(),
            physical_device,
            debug_settings: Default::default(),
            buffer_device_address: false,
            allocation_sizes: Default::default(),
        });
        let [main, compute] = places.map(|place| HostQueue::new(&device, place));
        Self {
            device,
            allocator: Some(allocator.unwrap()),
            physical_device,
            queue: main.handle,
            pool: main.pool,
            compute,
            instance,
            messenger,
            log,
            _entry: entry,
        }
    }

    pub fn allocator(&mut self) -> &mut Allocator {
        self.allocator.as_mut().unwrap()
    }

    /// Returns the number of allocations.
    pub fn allocations(&self) -> usize {
        self.allocator.as_ref().unwrap().generate_report().allocations.len()
    }

    /// Returns whether the device computes on the processor's cores.
    pub fn is_processor(&self) -> bool {
        // SAFETY: the physical device is from this instance.
        let properties =
            unsafe { self.instance.get_physical_device_properties(self.physical_device) };
        properties.device_type == vk::PhysicalDeviceType::CPU
    }

    /// Returns all messages of the validation layers so far.
    pub fn messages(&self) -> Vec<String> {
        self.log.lock().unwrap().clone()
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
        unsafe {
            let _ = self.device.device_wait_idle();
            self.device.destroy_command_pool(self.pool, None);
            self.device.destroy_command_pool(self.compute.pool, None);
            self.allocator = None;
            self.device.destroy_device(None);
            if let Some((loader, messenger)) = &self.messenger {
                loader.destroy_debug_utils_messenger(*messenger, None);
            }
            self.instance.destroy_instance(None);
        }
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

type Messenger = (ext::debug_utils::Instance, vk::DebugUtilsMessengerEXT);

fn listen(entry: &ash::Entry, instance: &ash::Instance, log: &Mutex<Vec<String>>) -> Messenger {
    let loader = ext::debug_utils::Instance::new(entry, instance);
    let info = vk::DebugUtilsMessengerCreateInfoEXT::default()
        .message_severity(
            vk::DebugUtilsMessageSeverityFlagsEXT::WARNING
                | vk::DebugUtilsMessageSeverityFlagsEXT::ERROR,
        )
        .message_type(vk::DebugUtilsMessageTypeFlagsEXT::VALIDATION)
        .pfn_user_callback(Some(collect))
        .user_data(std::ptr::from_ref(log).cast_mut().cast());
    let messenger = unsafe { loader.create_debug_utils_messenger(&info, None) }.unwrap();
    (loader, messenger)
}

unsafe extern "system" fn collect(
    severity: vk::DebugUtilsMessageSeverityFlagsEXT,
    _kind: vk::DebugUtilsMessageTypeFlagsEXT,
    data: *const vk::DebugUtilsMessengerCallbackDataEXT<'_>,
    log: *mut c_void,
) -> vk::Bool32 {
    let id = unsafe { (*data).message_id_name_as_c_str() }.unwrap_or(c"").to_string_lossy();
    let text = unsafe { (*data).message_as_c_str() }.unwrap_or(c"").to_string_lossy();
    // Messages of the layers about their own set-up are not findings.
    let is_warning = severity == vk::DebugUtilsMessageSeverityFlagsEXT::WARNING;
    if !(is_warning && id.contains("GPU-Assisted")) {
        let text = format!("[ {id} ] {text}");
        // Objects that a failing test leaves behind are expected, and reporting them would hide its cause.
        if !std::thread::panicking() {
            eprintln!("validation: {text}");
        }
        unsafe { &*log.cast::<Mutex<Vec<String>>>() }.lock().unwrap().push(text);
    }
    vk::FALSE
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

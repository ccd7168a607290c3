//! Instance, device, queue and allocator of the renderer.

use std::ffi::CStr;

use geosweep::ash::{self, ext, khr, vk};
use geosweep::gpu_allocator::vulkan::{Allocator, AllocatorCreateDesc};
use geosweep::vulkan::requirements;
use winit::raw_window_handle::{HasDisplayHandle, HasWindowHandle};
use winit::window::Window;

use crate::Result;
use crate::validation::{self, Messenger};

pub struct Gpu {
    _entry: ash::Entry,
    pub instance: ash::Instance,
    messenger: Option<Messenger>,
    pub surfaces: khr::surface::Instance,
    pub surface: vk::SurfaceKHR,
    pub physical_device: vk::PhysicalDevice,
    pub properties: vk::PhysicalDeviceProperties,
    /// Family of the only queue, for graphics, compute and the window.
    pub family: u32,
    pub device: ash::Device,
    pub queue: vk::Queue,
    pub swapchains: khr::swapchain::Device,
    /// Allocator; `None` only while the device is destroyed.
    allocator: Option<Allocator>,
}

impl Gpu {
    pub fn new(window: &Window, wanted: Option<&str>, validate: bool) -> Result<Self> {
        let display = window.display_handle()?.as_raw();
        // SAFETY: the entry is kept as long as the objects that it loads.
        let entry = unsafe { ash::Entry::load() }
            .map_err(|error| format!("no Vulkan loader on this system: {error}"))?;
        let mut extensions = ash_window::enumerate_required_extensions(display)?.to_vec();
        let instance = instance(&entry, &mut extensions, validate)?;
        let messenger = validate.then(|| Messenger::new(&entry, &instance)).transpose()?;
        let surfaces = khr::surface::Instance::new(&entry, &instance);
        // SAFETY: the window outlives the surface; `Gpu` is dropped before it.
        let surface = unsafe {
            let handle = window.window_handle()?.as_raw();
            ash_window::create_surface(&entry, &instance, display, handle, None)?
        };
        let (physical_device, family) = choose(&instance, &surfaces, surface, wanted)?;
        // SAFETY: the physical device is from this instance, and so are the objects created from it.
        let properties = unsafe { instance.get_physical_device_properties(physical_device) };
        let device = unsafe {
            let queues = [vk::DeviceQueueCreateInfo::default()
                .queue_family_index(family)
                .queue_priorities(&[1.0])];
            let extensions: Vec<_> = [khr::swapchain::NAME]
                .iter()
                .chain(requirements::DEVICE_EXTENSIONS)
                .map(|name| name.as_ptr())
                .collect();
            let features = requirements::features();
            let info = vk::DeviceCreateInfo::default()
                .queue_create_infos(&queues)
                .enabled_extension_names(&extensions)
                .enabled_features(&features);
            instance.create_device(physical_device, &info, None)?
        };
        let allocator = Allocator::new(&AllocatorCreateDesc {
            instance: instance.clone(),
            device: device.clone(),
            physical_device,
            debug_settings: Default::default(),
            buffer_device_address: false,
            allocation_sizes: Default::default(),
        })?;
        let queue = unsafe { device.get_device_queue(family, 0) };
        let swapchains = khr::swapchain::Device::new(&instance, &device);
        Ok(Self {
            _entry: entry,
            instance,
            messenger,
            surfaces,
            surface,
            physical_device,
            properties,
            family,
            device,
            queue,
            swapchains,
            allocator: Some(allocator),
        })
    }

    pub fn device_name(&self) -> String {
        name(&self.properties)
    }

    pub fn allocator(&mut self) -> &mut Allocator {
        self.allocator.as_mut().expect("the allocator lives as long as the device")
    }

    /// Waits until the device is idle: when the window's size changes and at the end, but never in a usual
    /// frame.
    pub fn wait(&self) {
        // SAFETY: the device is alive. If it is lost, there is nothing to wait for.
        let _ = unsafe { self.device.device_wait_idle() };
    }

    /// Destroys everything. Returns an error if memory was left behind, or if the validation layers have reported
    /// anything.
    pub fn destroy(mut self) -> Result<()> {
        let left = self.allocator().generate_report().allocations;
        self.allocator = None;
        // SAFETY: nothing is in flight, and all objects created from the device and the instance are destroyed. If
        // any is not, the validation layers report it.
        let messages = unsafe {
            self.device.destroy_device(None);
            self.surfaces.destroy_surface(self.surface, None);
            let messages = self.messenger.take().map_or(0, Messenger::destroy);
            self.instance.destroy_instance(None);
            messages
        };
        if !left.is_empty() {
            let names: Vec<_> = left.iter().map(|allocation| allocation.name.as_str()).collect();
            return Err(format!("memory was left behind: {}", names.join(", ")).into());
        }
        if messages > 0 {
            return Err(format!("{messages} messages of the validation layers, see above").into());
        }
        Ok(())
    }
}

fn instance(
    entry: &ash::Entry,
    extensions: &mut Vec<*const std::ffi::c_char>,
    validate: bool,
) -> Result<ash::Instance> {
    let application = vk::ApplicationInfo::default()
        .application_name(c"geosweep viewer")
        .api_version(requirements::API_VERSION);
    let layers = [validation::LAYER.as_ptr()];
    let mut features =
        vk::ValidationFeaturesEXT::default().enabled_validation_features(&validation::ENABLED);
    if validate {
        extensions
            .extend([ext::debug_utils::NAME, ext::validation_features::NAME].map(CStr::as_ptr));
    }
    let mut info = vk::InstanceCreateInfo::default()
        .application_info(&application)
        .enabled_extension_names(extensions);
    if validate {
        info = info.enabled_layer_names(&layers).push_next(&mut features);
    }
    // SAFETY: everything that the info points to is alive.
    unsafe { entry.create_instance(&info, None) }.map_err(|error| match error {
        vk::Result::ERROR_LAYER_NOT_PRESENT => {
            "the validation layers are not installed; leave --validate out".into()
        }
        error => format!("no Vulkan instance for this window: {error}").into(),
    })
}

fn name(properties: &vk::PhysicalDeviceProperties) -> String {
    properties.device_name_as_c_str().unwrap_or(c"unnamed").to_string_lossy().into_owned()
}

/// Chooses a device that supports everything, the first of the best kind: discrete GPUs before integrated ones, and
/// CPUs last.
fn choose(
    instance: &ash::Instance,
    surfaces: &khr::surface::Instance,
    surface: vk::SurfaceKHR,
    wanted: Option<&str>,
) -> Result<(vk::PhysicalDevice, u32)> {
    let wanted = wanted.unwrap_or_default().to_lowercase();
    let mut lacking = Vec::new();
    let mut usable = Vec::new();
    // SAFETY: the physical devices and the surface are from this instance.
    for device in unsafe { instance.enumerate_physical_devices()? } {
        let properties = unsafe { instance.get_physical_device_properties(device) };
        let name = name(&properties);
        if !name.to_lowercase().contains(&wanted) {
            lacking.push(format!("{name} is not the device asked for"));
            continue;
        }
        let unmet = requirements::unmet(instance, device);
        if !unmet.is_empty() {
            lacking.push(format!("{name}: {}", unmet.join("; ")));
        } else if let Some(family) = queue_family(instance, surfaces, surface, device) {
            let rank = match properties.device_type {
                vk::PhysicalDeviceType::DISCRETE_GPU => 0,
                vk::PhysicalDeviceType::INTEGRATED_GPU => 1,
                vk::PhysicalDeviceType::CPU => 3,
                _ => 2,
            };
            usable.push((rank, device, family));
        } else {
            lacking.push(format!("{name} has no queue for graphics, compute and this window"));
        }
    }
    let best = usable.into_iter().min_by_key(|(rank, ..)| *rank);
    let (_, device, family) =
        best.ok_or_else(|| format!("no Vulkan device can be used: {}", lacking.join(", ")))?;
    Ok((device, family))
}

fn queue_family(
    instance: &ash::Instance,
    surfaces: &khr::surface::Instance,
    surface: vk::SurfaceKHR,
    device: vk::PhysicalDevice,
) -> Option<u32> {
    let both = vk::QueueFlags::GRAPHICS | vk::QueueFlags::COMPUTE;
    // SAFETY: as in `choose`.
    let families = unsafe { instance.get_physical_device_queue_family_properties(device) };
    let presents = |family| unsafe {
        surfaces.get_physical_device_surface_support(device, family, surface).unwrap_or(false)
    };
    (0..).zip(families).find_map(|(index, family)| {
        (family.queue_flags.contains(both) && presents(index)).then_some(index)
    })
}

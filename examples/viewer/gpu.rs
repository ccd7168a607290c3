//! Device and queue of the renderer, and the surface of its window.

use std::ops::{Deref, DerefMut};

use geosweep::ash::{self, khr, vk};
use geosweep::vulkan::requirements;
use winit::raw_window_handle::{HasDisplayHandle, HasWindowHandle};
use winit::window::Window;

use crate::Result;
use crate::context::{self, Context, Instance, SYNCHRONIZATION};

pub struct Gpu {
    context: Context,
    pub surfaces: khr::surface::Instance,
    pub surface: vk::SurfaceKHR,
    pub properties: vk::PhysicalDeviceProperties,
    /// Family of the only queue, for graphics, compute and the window.
    pub family: u32,
    pub queue: vk::Queue,
    pub swapchains: khr::swapchain::Device,
}

impl Deref for Gpu {
    type Target = Context;

    fn deref(&self) -> &Context {
        &self.context
    }
}

impl DerefMut for Gpu {
    fn deref_mut(&mut self) -> &mut Context {
        &mut self.context
    }
}

impl Gpu {
    pub fn new(window: &Window, wanted: Option<&str>, validate: bool) -> Result<Self> {
        let display = window.display_handle()?.as_raw();
        let extensions = ash_window::enumerate_required_extensions(display)?.to_vec();
        let instance = Instance::new(extensions, if validate { SYNCHRONIZATION } else { &[] })?;
        let surfaces = khr::surface::Instance::new(&instance.entry, &instance.handle);
        // SAFETY: the window outlives the surface; `Gpu` is dropped before it.
        let surface = unsafe {
            let (handle, entry) = (window.window_handle()?.as_raw(), &instance.entry);
            ash_window::create_surface(entry, &instance.handle, display, handle, None)?
        };
        let (physical_device, family) = instance.choose(wanted.unwrap_or_default(), |device| {
            queue_family(&instance.handle, &surfaces, surface, device)
                .ok_or_else(|| "has no queue for graphics, compute and this window".into())
        })?;
        let queues = [vk::DeviceQueueCreateInfo::default()
            .queue_family_index(family)
            .queue_priorities(&[1.0])];
        let extensions = [khr::swapchain::NAME].iter().chain(requirements::DEVICE_EXTENSIONS);
        let extensions: Vec<_> = extensions.map(|name| name.as_ptr()).collect();
        let context = Context::new(instance, physical_device, &queues, &extensions)?;
        // SAFETY: the device was created with this queue.
        let queue = unsafe { context.device.get_device_queue(family, 0) };
        let swapchains = khr::swapchain::Device::new(&context.instance, &context.device);
        let properties = context.properties();
        Ok(Self { context, surfaces, surface, properties, family, queue, swapchains })
    }

    pub fn device_name(&self) -> String {
        context::name(&self.properties)
    }

    /// Destroys everything. Returns an error if memory was left behind, or if the validation layers have reported
    /// anything.
    pub fn destroy(mut self) -> Result<()> {
        let left = self.context.close_device();
        // SAFETY: the swapchains of the surface are destroyed. If any is not, the validation layers report it.
        unsafe { self.surfaces.destroy_surface(self.surface, None) };
        self.context.root.close();
        if !left.is_empty() {
            return Err(format!("memory was left behind: {}", left.join(", ")).into());
        }
        match self.context.messages().len() {
            0 => Ok(()),
            count => Err(format!("{count} messages of the validation layers, see above").into()),
        }
    }
}

fn queue_family(
    instance: &ash::Instance,
    surfaces: &khr::surface::Instance,
    surface: vk::SurfaceKHR,
    device: vk::PhysicalDevice,
) -> Option<u32> {
    let both = vk::QueueFlags::GRAPHICS | vk::QueueFlags::COMPUTE;
    // SAFETY: the physical devices and the surface are from this instance.
    let families = unsafe { instance.get_physical_device_queue_family_properties(device) };
    let presents = |family| unsafe {
        surfaces.get_physical_device_surface_support(device, family, surface).unwrap_or(false)
    };
    (0..).zip(families).find_map(|(index, family)| {
        (family.queue_flags.contains(both) && presents(index)).then_some(index)
    })
}

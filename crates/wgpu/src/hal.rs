//! The one file that knows wgpu-hal: handles of Vulkan behind wgpu's objects, and textures of wgpu around images.

use std::any::Any;

use geosweep::ash::{self, ext, vk};
use geosweep::vulkan::requirements;
use wgpu::hal::api::Vulkan;

use crate::Error;

/// Returns the requirements of maps that an adapter does not meet. An empty list means that maps run on it.
/// The device needs no features or limits beyond wgpu's own.
pub fn unmet(adapter: &wgpu::Adapter) -> Vec<String> {
    // SAFETY: no object of wgpu is destroyed.
    match unsafe { adapter.as_hal::<Vulkan>() } {
        Some(adapter) => requirements::unmet(
            adapter.shared_instance().raw_instance(),
            adapter.raw_physical_device(),
        ),
        None => vec![Error::NotVulkan.to_string()],
    }
}

/// Vulkan's handles behind a device of wgpu. They live as long as that device.
pub(crate) struct RawDevice {
    pub instance: ash::Instance,
    pub physical_device: vk::PhysicalDevice,
    pub device: ash::Device,
    /// Whether debugging tools and validation layers read names of objects.
    pub labels: bool,
}

impl RawDevice {
    pub fn of(device: &wgpu::Device) -> Result<Self, Error> {
        // SAFETY: no object of wgpu is destroyed.
        let hal = unsafe { device.as_hal::<Vulkan>() }.ok_or(Error::NotVulkan)?;
        let instance = hal.shared_instance();
        Ok(Self {
            instance: instance.raw_instance().clone(),
            physical_device: hal.raw_physical_device(),
            device: hal.raw_device().clone(),
            labels: instance.extensions().contains(&ext::debug_utils::NAME),
        })
    }
}

/// Returns Vulkan's handle of a buffer, which errors call `name`.
pub(crate) fn raw_buffer(buffer: &wgpu::Buffer, name: &'static str) -> Result<vk::Buffer, Error> {
    // SAFETY: the buffer is not destroyed.
    let hal = unsafe { buffer.as_hal::<Vulkan>() }.ok_or(Error::DestroyedBuffer(name))?;
    // SAFETY: as above.
    Ok(unsafe { hal.raw_handle() })
}

/// Records into an encoder's command buffer.
pub(crate) fn with_commands<T>(
    encoder: &mut wgpu::CommandEncoder,
    record: impl FnOnce(vk::CommandBuffer) -> T,
) -> Result<T, Error> {
    // SAFETY: commands are only recorded into the command buffer, and wgpu ends it.
    unsafe {
        encoder
            .as_hal_mut::<Vulkan, _, _>(|hal| Ok(record(hal.ok_or(Error::NotVulkan)?.raw_handle())))
    }
}

/// Wraps an image as a texture that pipelines can bind. wgpu takes it to be in the layout of a resource from the start,
/// and drops `owner` when it has released the texture.
///
/// # Safety
/// The image exists as long as `owner`, and has this size, this format and the usage `SAMPLED`. It is in the layout
/// `SHADER_READ_ONLY_OPTIMAL` whenever wgpu reads it.
pub(crate) unsafe fn texture(
    device: &wgpu::Device,
    (image, label): (vk::Image, &'static str),
    [width, height]: [u32; 2],
    format: wgpu::TextureFormat,
    owner: impl Any + Send + Sync,
) -> Result<wgpu::Texture, Error> {
    let size = wgpu::Extent3d { width, height, depth_or_array_layers: 1 };
    let descriptor = wgpu::TextureDescriptor {
        label: Some(label),
        size,
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format,
        // No other usage: wgpu would change the image's layout without the map's knowledge.
        usage: wgpu::TextureUsages::TEXTURE_BINDING,
        view_formats: &[],
    };
    let hal_descriptor = wgpu::hal::TextureDescriptor {
        label: descriptor.label,
        size,
        mip_level_count: 1,
        sample_count: 1,
        dimension: descriptor.dimension,
        format,
        usage: wgpu::TextureUses::RESOURCE,
        memory_flags: wgpu::hal::MemoryFlags::empty(),
        view_formats: Vec::new(),
    };
    // SAFETY: the caller promises that the image is as described.
    unsafe {
        let hal = device.as_hal::<Vulkan>().ok_or(Error::NotVulkan)?;
        let hal_texture = hal.texture_from_raw(
            image,
            &hal_descriptor,
            Some(Box::new(move || drop(owner))),
            wgpu::hal::vulkan::TextureMemory::External,
        );
        drop(hal);
        // In the state UNINITIALIZED wgpu would throw the first map away, after it was written.
        let state = wgpu::TextureUses::RESOURCE;
        Ok(device.create_texture_from_hal::<Vulkan>(hal_texture, &descriptor, state))
    }
}

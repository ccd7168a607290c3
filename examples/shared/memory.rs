//! Buffers and images with their memory.

use geosweep::ash::vk;
use geosweep::gpu_allocator::MemoryLocation;
use geosweep::gpu_allocator::vulkan::{Allocation, AllocationCreateDesc, AllocationScheme};

use super::context::{Context, Result};

/// A buffer. [`Buffer::destroy`] frees it.
pub struct Buffer {
    pub handle: vk::Buffer,
    allocation: Option<Allocation>,
}

/// An image with a view of all of it. [`Image::destroy`] frees it.
pub struct Image {
    pub image: vk::Image,
    pub view: vk::ImageView,
    allocation: Option<Allocation>,
}

/// Use of an image.
pub struct ImageUse {
    pub format: vk::Format,
    pub usage: vk::ImageUsageFlags,
    pub aspect: vk::ImageAspectFlags,
    pub samples: vk::SampleCountFlags,
}

/// Returns the range of a whole image with one level and one layer.
pub fn whole(aspect: vk::ImageAspectFlags) -> vk::ImageSubresourceRange {
    vk::ImageSubresourceRange::default().aspect_mask(aspect).level_count(1).layer_count(1)
}

/// Returns the copy of a whole color image to the beginning of a buffer.
pub fn whole_copy(extent: vk::Extent2D) -> vk::BufferImageCopy {
    let layers = vk::ImageSubresourceLayers::default()
        .aspect_mask(vk::ImageAspectFlags::COLOR)
        .layer_count(1);
    vk::BufferImageCopy::default().image_subresource(layers).image_extent(extent.into())
}

impl Buffer {
    pub fn new(
        context: &mut Context,
        name: &str,
        bytes: u64,
        usage: vk::BufferUsageFlags,
        location: MemoryLocation,
    ) -> Result<Self> {
        let info = vk::BufferCreateInfo::default().size(bytes).usage(usage);
        Self::of(context, name, &info, location)
    }

    /// Creates a buffer by its info.
    pub fn of(
        context: &mut Context,
        name: &str,
        info: &vk::BufferCreateInfo,
        location: MemoryLocation,
    ) -> Result<Self> {
        // SAFETY: the memory is bound before anything uses the buffer.
        unsafe {
            let handle = context.device.create_buffer(info, None)?;
            let requirements = context.device.get_buffer_memory_requirements(handle);
            let allocation = allocate(context, name, requirements, location, true)?;
            context.device.bind_buffer_memory(handle, allocation.memory(), allocation.offset())?;
            Ok(Self { handle, allocation: Some(allocation) })
        }
    }

    /// Creates a buffer that the program fills now and shaders read.
    pub fn filled(
        context: &mut Context,
        name: &str,
        content: &[u8],
        usage: vk::BufferUsageFlags,
    ) -> Result<Self> {
        let location = MemoryLocation::CpuToGpu;
        let mut buffer = Self::new(context, name, content.len() as u64, usage, location)?;
        buffer.bytes_mut()[..content.len()].copy_from_slice(content);
        Ok(buffer)
    }

    /// Returns the mapped memory.
    pub fn bytes(&self) -> &[u8] {
        let allocation = self.allocation.as_ref().expect("the buffer has not been destroyed");
        allocation.mapped_slice().expect("the buffer was made to be mapped")
    }

    /// Returns the mapped memory. No submitted work may be using it.
    pub fn bytes_mut(&mut self) -> &mut [u8] {
        let allocation = self.allocation.as_mut().expect("the buffer has not been destroyed");
        allocation.mapped_slice_mut().expect("the buffer was made to be mapped")
    }

    /// Returns the mapped memory as floats.
    pub fn floats(&self) -> &[f32] {
        let bytes = self.bytes();
        bytemuck::cast_slice(&bytes[..bytes.len() / 4 * 4])
    }

    /// Returns the mapped memory as floats. No submitted work may be using it.
    pub fn floats_mut(&mut self) -> &mut [f32] {
        let bytes = self.bytes_mut();
        let words = bytes.len() / 4 * 4;
        bytemuck::cast_slice_mut(&mut bytes[..words])
    }

    pub fn destroy(&mut self, context: &mut Context) {
        if let Some(allocation) = self.allocation.take() {
            // SAFETY: nothing is in flight.
            unsafe { context.device.destroy_buffer(self.handle, None) };
            let _ = context.allocator().free(allocation);
        }
    }
}

impl Image {
    pub fn new(
        context: &mut Context,
        name: &str,
        size: vk::Extent2D,
        with: &ImageUse,
    ) -> Result<Self> {
        let info = vk::ImageCreateInfo::default()
            .image_type(vk::ImageType::TYPE_2D)
            .format(with.format)
            .extent(size.into())
            .mip_levels(1)
            .array_layers(1)
            .samples(with.samples)
            .usage(with.usage);
        // SAFETY: the memory is bound before anything uses the image.
        unsafe {
            let image = context.device.create_image(&info, None)?;
            let requirements = context.device.get_image_memory_requirements(image);
            let location = MemoryLocation::GpuOnly;
            let allocation = allocate(context, name, requirements, location, false)?;
            context.device.bind_image_memory(image, allocation.memory(), allocation.offset())?;
            let view = vk::ImageViewCreateInfo::default()
                .image(image)
                .view_type(vk::ImageViewType::TYPE_2D)
                .format(with.format)
                .subresource_range(whole(with.aspect));
            let view = context.device.create_image_view(&view, None)?;
            Ok(Self { image, view, allocation: Some(allocation) })
        }
    }

    pub fn destroy(&mut self, context: &mut Context) {
        if let Some(allocation) = self.allocation.take() {
            // SAFETY: nothing is in flight.
            unsafe {
                context.device.destroy_image_view(self.view, None);
                context.device.destroy_image(self.image, None);
            }
            let _ = context.allocator().free(allocation);
        }
    }
}

fn allocate(
    context: &mut Context,
    name: &str,
    requirements: vk::MemoryRequirements,
    location: MemoryLocation,
    linear: bool,
) -> Result<Allocation> {
    Ok(context.allocator().allocate(&AllocationCreateDesc {
        name,
        requirements,
        location,
        linear,
        allocation_scheme: AllocationScheme::GpuAllocatorManaged,
    })?)
}

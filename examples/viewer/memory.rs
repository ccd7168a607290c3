//! Buffers and images with their memory.

use geosweep::ash::vk;
use geosweep::gpu_allocator::MemoryLocation;
use geosweep::gpu_allocator::vulkan::{Allocation, AllocationCreateDesc, AllocationScheme};

use crate::Result;
use crate::gpu::Gpu;

pub struct Buffer {
    pub handle: vk::Buffer,
    allocation: Option<Allocation>,
}

pub struct Image {
    pub handle: vk::Image,
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

impl Buffer {
    pub fn new(
        gpu: &mut Gpu,
        name: &str,
        bytes: u64,
        usage: vk::BufferUsageFlags,
        location: MemoryLocation,
    ) -> Result<Self> {
        let info = vk::BufferCreateInfo::default().size(bytes).usage(usage);
        // SAFETY: the memory is bound before anything uses the buffer.
        unsafe {
            let handle = gpu.device.create_buffer(&info, None)?;
            let requirements = gpu.device.get_buffer_memory_requirements(handle);
            let allocation = allocate(gpu, name, requirements, location, true)?;
            gpu.device.bind_buffer_memory(handle, allocation.memory(), allocation.offset())?;
            Ok(Self { handle, allocation: Some(allocation) })
        }
    }

    /// Creates a buffer that the program fills now and shaders read.
    pub fn filled(
        gpu: &mut Gpu,
        name: &str,
        content: &[u8],
        usage: vk::BufferUsageFlags,
    ) -> Result<Self> {
        let location = MemoryLocation::CpuToGpu;
        let mut buffer = Self::new(gpu, name, content.len() as u64, usage, location)?;
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

    pub fn destroy(&mut self, gpu: &mut Gpu) {
        if let Some(allocation) = self.allocation.take() {
            // SAFETY: nothing is in flight.
            unsafe { gpu.device.destroy_buffer(self.handle, None) };
            let _ = gpu.allocator().free(allocation);
        }
    }
}

impl Image {
    pub fn new(gpu: &mut Gpu, name: &str, size: vk::Extent2D, with: &ImageUse) -> Result<Self> {
        let info = vk::ImageCreateInfo::default()
            .image_type(vk::ImageType::TYPE_2D)
            .format(with.format)
            .extent(size.into())
            .mip_levels(1)
            .array_layers(1)
            .samples(with.samples)
            .tiling(vk::ImageTiling::OPTIMAL)
            .usage(with.usage);
        // SAFETY: the memory is bound before anything uses the image.
        unsafe {
            let handle = gpu.device.create_image(&info, None)?;
            let requirements = gpu.device.get_image_memory_requirements(handle);
            let location = MemoryLocation::GpuOnly;
            let allocation = allocate(gpu, name, requirements, location, false)?;
            gpu.device.bind_image_memory(handle, allocation.memory(), allocation.offset())?;
            let view = vk::ImageViewCreateInfo::default()
                .image(handle)
                .view_type(vk::ImageViewType::TYPE_2D)
                .format(with.format)
                .subresource_range(whole(with.aspect));
            let view = gpu.device.create_image_view(&view, None)?;
            Ok(Self { handle, view, allocation: Some(allocation) })
        }
    }

    pub fn destroy(&mut self, gpu: &mut Gpu) {
        if let Some(allocation) = self.allocation.take() {
            // SAFETY: nothing is in flight.
            unsafe {
                gpu.device.destroy_image_view(self.view, None);
                gpu.device.destroy_image(self.handle, None);
            }
            let _ = gpu.allocator().free(allocation);
        }
    }
}

fn allocate(
    gpu: &mut Gpu,
    name: &str,
    requirements: vk::MemoryRequirements,
    location: MemoryLocation,
    linear: bool,
) -> Result<Allocation> {
    Ok(gpu.allocator().allocate(&AllocationCreateDesc {
        name,
        requirements,
        location,
        linear,
        allocation_scheme: AllocationScheme::GpuAllocatorManaged,
    })?)
}

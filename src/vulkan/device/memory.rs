//! Creates images and buffers with their memory, from the caller's device and allocator.

use ash::vk;
use gpu_allocator::MemoryLocation;

use super::barrier;
use super::device_memory::{DeviceMemory, MemoryBlock, MemoryRequest};
use crate::vulkan::VulkanError;

/// Format of a grid's images. A texel holds 2 x 2 points, or the four edges of one point.
pub(crate) const FORMAT: vk::Format = vk::Format::R32G32B32A32_SFLOAT;
/// Format of images of distances.
pub(crate) const RESULT_FORMAT: vk::Format = vk::Format::R32_SFLOAT;
/// Format of images of directions.
pub(crate) const DIRECTION_FORMAT: vk::Format = vk::Format::R16G16_SFLOAT;
/// Format of images of log maps.
pub(crate) const LOG_MAP_FORMAT: vk::Format = vk::Format::R32G32_SFLOAT;
/// Usage of images that shaders write. It lets hosts sample them and copy from them.
pub(crate) const IMAGE_USAGE: vk::ImageUsageFlags = vk::ImageUsageFlags::from_raw(
    vk::ImageUsageFlags::STORAGE.as_raw()
        | vk::ImageUsageFlags::SAMPLED.as_raw()
        | vk::ImageUsageFlags::TRANSFER_SRC.as_raw()
        | vk::ImageUsageFlags::TRANSFER_DST.as_raw(),
);

/// Parameters of an image to create.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ImageInfo<'a> {
    pub(crate) name: &'static str,
    pub(crate) format: vk::Format,
    pub(crate) extent: vk::Extent3D,
    pub(crate) layers: u32,
    /// Queue families that use the image concurrently, if there is more than one.
    pub(crate) families: &'a [u32],
}

/// Parameters of a [`Buffer`] to create.
#[derive(Clone, Copy, Debug)]
pub struct BufferInfo {
    /// Name of the buffer for reports, such as "points".
    pub name: &'static str,
    /// Size in bytes; positive.
    pub size: u64,
    /// Location of the memory, which says whether the program reads or writes it.
    pub location: MemoryLocation,
}

/// Storage image in device memory, with its view.
#[derive(Debug)]
pub(crate) struct Image {
    pub(crate) image: vk::Image,
    pub(crate) view: vk::ImageView,
    block: Option<MemoryBlock>,
}

/// Buffer with its memory, for instance for points that the program writes. Shaders can read and write it, and it can
/// be copied, drawn from and read by indirect commands.
///
/// Dropping a buffer frees nothing. The host calls [`Buffer::destroy`].
#[derive(Debug)]
pub struct Buffer {
    /// Buffer handle.
    pub buffer: vk::Buffer,
    block: Option<MemoryBlock>,
}

impl Image {
    pub(crate) fn new(
        device: &ash::Device,
        allocator: &mut dyn DeviceMemory,
        info: ImageInfo,
    ) -> Result<Self, VulkanError> {
        let image = info.create(device)?;
        let mut new = Self { image, view: vk::ImageView::null(), block: None };
        let backed = new.back(device, allocator, info);
        backed.inspect_err(|_| new.destroy(device, allocator))?;
        Ok(new)
    }

    fn back(
        &mut self,
        device: &ash::Device,
        allocator: &mut dyn DeviceMemory,
        ImageInfo { name, format, layers, .. }: ImageInfo,
    ) -> Result<(), VulkanError> {
        // SAFETY: the image is from this device.
        let requirements = unsafe { device.get_image_memory_requirements(self.image) };
        let location = MemoryLocation::GpuOnly;
        let wanted = MemoryRequest { name, requirements, location, is_buffer: false };
        let (memory, offset) = allocate(allocator, wanted, &mut self.block)?;
        // SAFETY: the memory was allocated for this image's requirements.
        unsafe { device.bind_image_memory(self.image, memory, offset) }
            .map_err(VulkanError::from_call("vkBindImageMemory"))?;
        let kind =
            if layers > 1 { vk::ImageViewType::TYPE_2D_ARRAY } else { vk::ImageViewType::TYPE_2D };
        let info = vk::ImageViewCreateInfo::default()
            .image(self.image)
            .view_type(kind)
            .format(format)
            .subresource_range(barrier::COLOR);
        // SAFETY: the image is bound to memory and has this format.
        self.view = unsafe { device.create_image_view(&info, None) }
            .map_err(VulkanError::from_call("vkCreateImageView"))?;
        Ok(())
    }

    pub(crate) fn bytes(&self) -> u64 {
        self.block.as_ref().map_or(0, MemoryBlock::size)
    }

    pub(crate) fn destroy(&mut self, device: &ash::Device, allocator: &mut dyn DeviceMemory) {
        // SAFETY: the caller has made sure that no submitted work uses the image; null handles
        // are allowed.
        unsafe {
            device.destroy_image_view(std::mem::take(&mut self.view), None);
            device.destroy_image(std::mem::take(&mut self.image), None);
        }
        self.block.take().into_iter().for_each(|block| allocator.free(block));
    }
}

impl Buffer {
    /// Creates a buffer.
    ///
    /// # Errors
    /// If memory runs out, or a Vulkan call fails. Nothing is left behind then.
    pub fn new(
        device: &ash::Device,
        allocator: &mut dyn DeviceMemory,
        info: BufferInfo,
    ) -> Result<Self, VulkanError> {
        let mut new = Self { buffer: info.create(device)?, block: None };
        let backed = new.back(device, allocator, info);
        backed.inspect_err(|_| new.destroy(device, allocator))?;
        Ok(new)
    }

    fn back(
        &mut self,
        device: &ash::Device,
        allocator: &mut dyn DeviceMemory,
        BufferInfo { name, location, .. }: BufferInfo,
    ) -> Result<(), VulkanError> {
        // SAFETY: the buffer is from this device.
        let requirements = unsafe { device.get_buffer_memory_requirements(self.buffer) };
        let wanted = MemoryRequest { name, requirements, location, is_buffer: true };
        let (memory, offset) = allocate(allocator, wanted, &mut self.block)?;
        // SAFETY: the memory was allocated for this buffer's requirements.
        unsafe { device.bind_buffer_memory(self.buffer, memory, offset) }
            .map_err(VulkanError::from_call("vkBindBufferMemory"))
    }

    /// Returns the number of bytes taken from the allocator's memory blocks.
    pub fn bytes(&self) -> u64 {
        self.block.as_ref().map_or(0, MemoryBlock::size)
    }

    /// Returns the buffer's memory for reading. No submitted work may write it.
    ///
    /// # Panics
    /// If the memory's location is not one that the program reads or writes.
    pub fn read(&self) -> &[u8] {
        let bytes = self.block.as_ref().and_then(MemoryBlock::bytes);
        bytes.expect("only buffers made host-visible are mapped")
    }

    /// Returns the buffer's memory for writing. No submitted work may use it.
    ///
    /// # Panics
    /// If the memory's location is not one that the program reads or writes.
    pub fn mapped(&mut self) -> &mut [u8] {
        let bytes = self.block.as_mut().and_then(MemoryBlock::bytes_mut);
        bytes.expect("only buffers made host-visible are mapped")
    }

    /// Frees the buffer and its memory. No submitted work may still use them. A second call does nothing.
    pub fn destroy(&mut self, device: &ash::Device, allocator: &mut dyn DeviceMemory) {
        // SAFETY: the caller has made sure that no submitted work uses the buffer.
        unsafe { device.destroy_buffer(std::mem::take(&mut self.buffer), None) };
        self.block.take().into_iter().for_each(|block| allocator.free(block));
    }
}

/// Allocates memory into `block`, and returns the place of the memory.
fn allocate(
    allocator: &mut dyn DeviceMemory,
    wanted: MemoryRequest,
    block: &mut Option<MemoryBlock>,
) -> Result<(vk::DeviceMemory, u64), VulkanError> {
    let what = wanted.name;
    let new = allocator.allocate(&wanted);
    let new = new.map_err(|source| VulkanError::Allocation { what, source })?;
    Ok(block.insert(new).place())
}

/// Returns the usage of images of a format. Not all devices let shaders write images of two components, so
/// such images are filled by copies from buffers.
fn usage(format: vk::Format) -> vk::ImageUsageFlags {
    match format {
        FORMAT | RESULT_FORMAT => IMAGE_USAGE,
        _ => IMAGE_USAGE & !vk::ImageUsageFlags::STORAGE,
    }
}

impl ImageInfo<'_> {
    fn create(&self, device: &ash::Device) -> Result<vk::Image, VulkanError> {
        let mut info = vk::ImageCreateInfo::default()
            .image_type(vk::ImageType::TYPE_2D)
            .format(self.format)
            .extent(self.extent)
            .mip_levels(1)
            .array_layers(self.layers)
            .samples(vk::SampleCountFlags::TYPE_1)
            .tiling(vk::ImageTiling::OPTIMAL)
            .usage(usage(self.format));
        if self.families.len() > 1 {
            info =
                info.sharing_mode(vk::SharingMode::CONCURRENT).queue_family_indices(self.families);
        }
        // SAFETY: the extent lies within the device's limits, which the caller has checked.
        unsafe { device.create_image(&info, None) }.map_err(VulkanError::from_call("vkCreateImage"))
    }

    /// Returns the number of bytes that the image will take.
    pub(crate) fn bytes(&self, device: &ash::Device) -> Result<u64, VulkanError> {
        let image = self.create(device)?;
        // SAFETY: the image is from this device, and nothing has used it.
        unsafe {
            let requirements = device.get_image_memory_requirements(image);
            device.destroy_image(image, None);
            Ok(requirements.size)
        }
    }
}

impl BufferInfo {
    fn create(&self, device: &ash::Device) -> Result<vk::Buffer, VulkanError> {
        let usage = vk::BufferUsageFlags::STORAGE_BUFFER
            | vk::BufferUsageFlags::INDIRECT_BUFFER
            | vk::BufferUsageFlags::VERTEX_BUFFER
            | vk::BufferUsageFlags::TRANSFER_SRC
            | vk::BufferUsageFlags::TRANSFER_DST;
        let info = vk::BufferCreateInfo::default().size(self.size).usage(usage);
        // SAFETY: the size is positive.
        unsafe { device.create_buffer(&info, None) }
            .map_err(VulkanError::from_call("vkCreateBuffer"))
    }

    /// Returns the number of bytes that the buffer will take.
    ///
    /// # Errors
    /// If a Vulkan call fails.
    pub fn bytes(&self, device: &ash::Device) -> Result<u64, VulkanError> {
        let buffer = self.create(device)?;
        // SAFETY: the buffer is from this device, and nothing has used it.
        unsafe {
            let requirements = device.get_buffer_memory_requirements(buffer);
            device.destroy_buffer(buffer, None);
            Ok(requirements.size)
        }
    }
}

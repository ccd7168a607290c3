//! Buffers and images of the renderer.

use super::*;

impl Host {
    /// Creates a storage buffer on the device. With `mapped`, the program can read and write it.
    pub fn buffer(&mut self, bytes: u64, mapped: bool) -> HostBuffer {
        self.shared_buffer(bytes, mapped, &[])
    }

    /// Creates a buffer that these queue families share, if there are several.
    pub fn shared_buffer(&mut self, bytes: u64, mapped: bool, families: &[u32]) -> HostBuffer {
        let usage = vk::BufferUsageFlags::STORAGE_BUFFER
            | vk::BufferUsageFlags::TRANSFER_SRC
            | vk::BufferUsageFlags::TRANSFER_DST;
        let mut info = vk::BufferCreateInfo::default().size(bytes).usage(usage);
        if families.len() > 1 {
            info = info.sharing_mode(vk::SharingMode::CONCURRENT).queue_family_indices(families);
        }
        let handle = unsafe { self.device.create_buffer(&info, None) }.unwrap();
        let requirements = unsafe { self.device.get_buffer_memory_requirements(handle) };
        let location = if mapped { MemoryLocation::GpuToCpu } else { MemoryLocation::GpuOnly };
        let allocation = self.allocate(requirements, location, true);
        unsafe {
            let (memory, offset) = (allocation.memory(), allocation.offset());
            self.device.bind_buffer_memory(handle, memory, offset).unwrap();
        }
        HostBuffer { handle, allocation }
    }

    /// Creates a mapped buffer with these contents.
    pub fn buffer_of(&mut self, contents: &[f32]) -> HostBuffer {
        let mut buffer = self.buffer(size_of_val(contents) as u64, true);
        buffer.floats_mut()[..contents.len()].copy_from_slice(contents);
        buffer
    }

    /// Creates a sampled image with these contents, `components` floats per texel.
    pub fn image_of(
        &mut self,
        width: u32,
        height: u32,
        components: usize,
        contents: &[f32],
    ) -> HostImage {
        let format = match components {
            1 => vk::Format::R32_SFLOAT,
            4 => vk::Format::R32G32B32A32_SFLOAT,
            _ => panic!("no such format here"),
        };
        let extent = vk::Extent2D { width, height };
        let usage = vk::ImageUsageFlags::SAMPLED
            | vk::ImageUsageFlags::TRANSFER_DST
            | vk::ImageUsageFlags::COLOR_ATTACHMENT;
        let new = self.image(extent, format, usage, vk::ImageAspectFlags::COLOR);
        let image = new.image;
        let range = vk::ImageSubresourceRange::default()
            .aspect_mask(vk::ImageAspectFlags::COLOR)
            .level_count(1)
            .layer_count(1);
        let staging = self.buffer_of(contents);
        self.run(|commands| unsafe {
            let barrier = vk::ImageMemoryBarrier::default()
                .image(image)
                .subresource_range(range)
                .new_layout(vk::ImageLayout::GENERAL)
                .dst_access_mask(vk::AccessFlags::TRANSFER_WRITE);
            let none = vk::DependencyFlags::empty();
            let (from, to) =
                (vk::PipelineStageFlags::TOP_OF_PIPE, vk::PipelineStageFlags::TRANSFER);
            self.device.cmd_pipeline_barrier(commands, from, to, none, &[], &[], &[barrier]);
            let layers = vk::ImageSubresourceLayers::default()
                .aspect_mask(vk::ImageAspectFlags::COLOR)
                .layer_count(1);
            let copy = vk::BufferImageCopy::default()
                .image_subresource(layers)
                .image_extent(extent.into());
            let layout = vk::ImageLayout::GENERAL;
            self.device.cmd_copy_buffer_to_image(commands, staging.handle, image, layout, &[copy]);
        });
        self.free(staging);
        new
    }

    pub(super) fn image(
        &mut self,
        extent: vk::Extent2D,
        format: vk::Format,
        usage: vk::ImageUsageFlags,
        aspect: vk::ImageAspectFlags,
    ) -> HostImage {
        let info = vk::ImageCreateInfo::default()
            .image_type(vk::ImageType::TYPE_2D)
            .format(format)
            .extent(extent.into())
            .mip_levels(1)
            .array_layers(1)
            .samples(vk::SampleCountFlags::TYPE_1)
            .usage(usage);
        let image = unsafe { self.device.create_image(&info, None) }.unwrap();
        let requirements = unsafe { self.device.get_image_memory_requirements(image) };
        let allocation = self.allocate(requirements, MemoryLocation::GpuOnly, false);
        unsafe {
            let (memory, offset) = (allocation.memory(), allocation.offset());
            self.device.bind_image_memory(image, memory, offset).unwrap();
        }
        let range =
            vk::ImageSubresourceRange::default().aspect_mask(aspect).level_count(1).layer_count(1);
        let info = vk::ImageViewCreateInfo::default()
            .image(image)
            .view_type(vk::ImageViewType::TYPE_2D)
            .format(format)
            .subresource_range(range);
        let view = unsafe { self.device.create_image_view(&info, None) }.unwrap();
        HostImage { image, view, allocation }
    }

    fn allocate(
        &mut self,
        requirements: vk::MemoryRequirements,
        location: MemoryLocation,
        linear: bool,
    ) -> Allocation {
        self.allocator()
            .allocate(&AllocationCreateDesc {
                name: "the host's",
                requirements,
                location,
                linear,
                allocation_scheme: AllocationScheme::GpuAllocatorManaged,
            })
            .unwrap()
    }

    pub fn free(&mut self, buffer: HostBuffer) {
        unsafe { self.device.destroy_buffer(buffer.handle, None) };
        self.allocator().free(buffer.allocation).unwrap();
    }

    pub fn free_image(&mut self, image: HostImage) {
        unsafe {
            self.device.destroy_image_view(image.view, None);
            self.device.destroy_image(image.image, None);
        }
        self.allocator().free(image.allocation).unwrap();
    }
}

impl HostBuffer {
    pub fn floats(&self) -> &[f32] {
        let bytes = self.allocation.mapped_slice().expect("the buffer was made to be mapped");
        bytemuck::cast_slice(&bytes[..bytes.len() / 4 * 4])
    }

    pub fn floats_mut(&mut self) -> &mut [f32] {
        let bytes = self.allocation.mapped_slice_mut().expect("the buffer was made to be mapped");
        let words = bytes.len() / 4 * 4;
        bytemuck::cast_slice_mut(&mut bytes[..words])
    }

    pub fn bytes(&self) -> &[u8] {
        bytemuck::cast_slice(self.floats())
    }
}

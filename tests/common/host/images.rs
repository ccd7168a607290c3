//! Buffers and images of the renderer.

use geosweep::vulkan::embed::{Access, ResultImage};

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
        let location = if mapped { MemoryLocation::GpuToCpu } else { MemoryLocation::GpuOnly };
        HostBuffer::of(self, "the host's", &info, location).unwrap()
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
        let staging = self.buffer_of(contents);
        self.run(|commands| unsafe {
            let barrier = vk::ImageMemoryBarrier::default()
                .image(image)
                .subresource_range(whole(vk::ImageAspectFlags::COLOR))
                .new_layout(vk::ImageLayout::GENERAL)
                .dst_access_mask(vk::AccessFlags::TRANSFER_WRITE);
            let none = vk::DependencyFlags::empty();
            let (from, to) =
                (vk::PipelineStageFlags::TOP_OF_PIPE, vk::PipelineStageFlags::TRANSFER);
            self.device.cmd_pipeline_barrier(commands, from, to, none, &[], &[], &[barrier]);
            let copy = whole_copy(extent);
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
        let samples = vk::SampleCountFlags::TYPE_1;
        let with = ImageUse { format, usage, aspect, samples };
        HostImage::new(self, "the host's", extent, &with).unwrap()
    }

    /// Records a copy of an image of results, which was left to be copied, and lets the program read the copy.
    pub fn copy_image(&self, commands: vk::CommandBuffer, from: ResultImage, to: &HostBuffer) {
        let copy = whole_copy(from.extent);
        let (image, to) = (from.image, to.handle);
        unsafe { self.device.cmd_copy_image_to_buffer(commands, image, from.layout, to, &[copy]) };
        self.barrier(commands, Access::TRANSFER_WRITE, Access::HOST_READ);
    }

    /// Records a copy of the first bytes of a buffer, and lets the program read the copy.
    pub fn copy_buffer(
        &self,
        commands: vk::CommandBuffer,
        from: vk::Buffer,
        to: &HostBuffer,
        bytes: u64,
    ) {
        let all = [vk::BufferCopy::default().size(bytes)];
        unsafe { self.device.cmd_copy_buffer(commands, from, to.handle, &all) };
        self.barrier(commands, Access::TRANSFER_WRITE, Access::HOST_READ);
    }

    pub fn free(&mut self, mut buffer: HostBuffer) {
        buffer.destroy(self);
    }

    pub fn free_image(&mut self, mut image: HostImage) {
        image.destroy(self);
    }
}

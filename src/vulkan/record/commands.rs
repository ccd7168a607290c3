//! The commands that all recordings are made of.

use ash::vk;
use bytemuck::{NoUninit, bytes_of};

use super::{Recorder, groups};
use crate::vulkan::barrier;

impl Recorder<'_> {
    /// Runs a pass that also sees something of the host's: so many invocations wide and high.
    pub(crate) fn host_pass(
        &self,
        pipeline: vk::Pipeline,
        set: vk::DescriptorSet,
        constants: &impl NoUninit,
        invocations: [u32; 2],
    ) {
        let (compute, stages) = (vk::PipelineBindPoint::COMPUTE, vk::ShaderStageFlags::COMPUTE);
        // The set that writes image 1 reads image 0.
        let (layout, sets) = (self.pipelines.host_layout, [self.grid.sets[1], set]);
        // SAFETY: pipeline, layout and sets belong together and are alive, and the layout has
        // room for the constants.
        unsafe {
            self.device.cmd_bind_pipeline(self.commands, compute, pipeline);
            self.device.cmd_bind_descriptor_sets(self.commands, compute, layout, 0, &sets, &[]);
            let constants = bytes_of(constants);
            self.device.cmd_push_constants(self.commands, layout, stages, 0, constants);
            let [x, y, z] = groups(invocations);
            self.device.cmd_dispatch(self.commands, x, y, z);
        }
    }

    pub(super) fn bind(&self, pipeline: vk::Pipeline, writes: usize) {
        let compute = vk::PipelineBindPoint::COMPUTE;
        let (layout, sets) = (self.pipelines.layout, [self.grid.sets[writes]]);
        // SAFETY: pipeline, layout and set belong together and are alive.
        unsafe {
            self.device.cmd_bind_pipeline(self.commands, compute, pipeline);
            self.device.cmd_bind_descriptor_sets(self.commands, compute, layout, 0, &sets, &[]);
        }
    }

    /// Dispatches so many invocations wide and high, in groups along the width.
    pub(super) fn dispatch(&self, constants: &impl NoUninit, invocations: [u32; 2]) {
        self.push(constants);
        let [x, y, z] = groups(invocations);
        // SAFETY: a pipeline with the common layout is bound.
        unsafe { self.device.cmd_dispatch(self.commands, x, y, z) };
    }

    pub(super) fn dispatch_groups(&self, constants: &impl NoUninit, groups: u32) {
        self.push(constants);
        // SAFETY: a pipeline with the common layout is bound.
        unsafe { self.device.cmd_dispatch(self.commands, groups, 1, 1) };
    }

    /// Dispatches as many groups as a buffer says here.
    pub(super) fn dispatch_while(
        &self,
        constants: &impl NoUninit,
        buffer: vk::Buffer,
        offset: u64,
    ) {
        self.push(constants);
        // SAFETY: a pipeline with the common layout is bound, and three numbers are at the offset.
        unsafe { self.device.cmd_dispatch_indirect(self.commands, buffer, offset) };
    }

    fn push(&self, constants: &impl NoUninit) {
        let (layout, stages) = (self.pipelines.layout, vk::ShaderStageFlags::COMPUTE);
        // SAFETY: the layout has room for the constants of every pass.
        unsafe {
            self.device.cmd_push_constants(self.commands, layout, stages, 0, bytes_of(constants));
        }
    }

    pub(crate) fn barrier(&self, before: barrier::Access, after: barrier::Access) {
        barrier::memory(self.device, self.commands, before, after);
    }

    /// Brings an image from one layout into another between two kinds of access.
    pub(crate) fn image_barrier(
        &self,
        image: vk::Image,
        before: barrier::Access,
        after: barrier::Access,
        layouts: (vk::ImageLayout, vk::ImageLayout),
    ) {
        barrier::image(self.device, self.commands, image, before, after, layouts);
    }

    /// Fills a layer of an image.
    pub(super) fn clear(&self, image: vk::Image, layer: u32, value: f64) {
        let value = vk::ClearColorValue { float32: [value as f32; 4] };
        let range =
            vk::ImageSubresourceRange { base_array_layer: layer, layer_count: 1, ..barrier::COLOR };
        // SAFETY: the image has the layer, is in this layout, and the layer is used by nothing else
        // until the next barrier.
        unsafe {
            let layout = vk::ImageLayout::GENERAL;
            self.device.cmd_clear_color_image(self.commands, image, layout, &value, &[range]);
        }
    }

    /// Zeroes part of a buffer.
    pub(crate) fn fill(&self, buffer: vk::Buffer, offset: u64, size: u64) {
        // SAFETY: the part lies in the buffer, which nothing else uses until the next barrier.
        unsafe { self.device.cmd_fill_buffer(self.commands, buffer, offset, size, 0) };
    }

    /// Writes part of the progress.
    pub(super) fn write(&self, offset: u64, bytes: &[u8]) {
        self.update(self.grid.progress.buffer, offset, bytes);
    }

    /// Writes part of a buffer, which has room for it; no more than 65 536 bytes, a multiple of 4.
    pub(crate) fn update(&self, buffer: vk::Buffer, offset: u64, bytes: &[u8]) {
        // SAFETY: the part lies in the buffer, which nothing else uses until the next barrier.
        unsafe { self.device.cmd_update_buffer(self.commands, buffer, offset, bytes) };
    }

    /// Copies part of a buffer to one that has room for it there, and does not overlap it.
    pub(crate) fn copy(&self, from: (vk::Buffer, u64), to: (vk::Buffer, u64), size: u64) {
        let copy = [vk::BufferCopy::default().src_offset(from.1).dst_offset(to.1).size(size)];
        // SAFETY: both buffers hold so many bytes there, of the host's as the host has promised.
        unsafe { self.device.cmd_copy_buffer(self.commands, from.0, to.0, &copy) };
    }

    /// Copies the start of a buffer, row after row, to a part of an image's first layer.
    pub(super) fn copy_to_image(
        &self,
        from: vk::Buffer,
        to: vk::Image,
        (offset, extent): (vk::Offset3D, vk::Extent3D),
    ) {
        let layer = vk::ImageSubresourceLayers {
            aspect_mask: vk::ImageAspectFlags::COLOR,
            mip_level: 0,
            base_array_layer: 0,
            layer_count: 1,
        };
        let copy = vk::BufferImageCopy::default()
            .image_subresource(layer)
            .image_offset(offset)
            .image_extent(extent);
        let layout = vk::ImageLayout::GENERAL;
        // SAFETY: the buffer holds so many texels, the part lies in the image, which is in this layout, and
        // nothing else uses either until the next barrier.
        unsafe { self.device.cmd_copy_buffer_to_image(self.commands, from, to, layout, &[copy]) };
    }
}

//! Records single commands, of which all recordings consist.

use std::ffi::CStr;

use ash::vk;
use bytemuck::{Pod, bytes_of};

use super::observer::Observer;
use super::turn::Turn;
use crate::constants::{MOST_GROUPS, WORKGROUP};
use crate::vulkan::device::barrier;
use crate::vulkan::device::descriptors::Sets;
use crate::vulkan::device::labels::Group;
use crate::vulkan::device::limits::column_of;
use crate::vulkan::device::passes::PUSH_CONSTANT_BYTES;
use crate::vulkan::device::pipelines::{Pipeline, Pipelines};

/// Command buffer that is being recorded.
#[derive(Clone, Copy)]
pub(crate) struct Commands<'a> {
    /// Device to which everything else belongs.
    pub(crate) device: &'a ash::Device,
    /// Command buffer. It has been begun, on a queue family for compute, outside a render pass.
    pub(crate) buffer: vk::CommandBuffer,
    /// Pipelines, which stay alive until the commands have run.
    pub(crate) pipelines: &'a Pipelines,
    /// Observer of the passes, if there is one.
    pub(crate) observer: Option<&'a dyn Observer>,
    /// Turn that decides which part is recorded, if the recording shares its barriers with others ([`Turn`]). Such
    /// recordings have no labels and are not observed.
    pub(crate) turn: Option<&'a Turn>,
}

/// Number of workgroups of a dispatch.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Groups {
    /// Number of workgroups in each dimension.
    These([u32; 3]),
    /// Buffer that holds these three numbers, and their offset in it.
    From(vk::Buffer, u64),
}

impl Groups {
    /// Returns the workgroups of a dispatch of `width` x `height` invocations. A workgroup is [`WORKGROUP`] invocations
    /// wide and one high.
    pub(crate) fn of([width, height]: [u32; 2]) -> Self {
        Self::These([width.div_ceil(WORKGROUP), height, 1])
    }

    /// Returns `count` workgroups in a line.
    pub(crate) fn line(count: u32) -> Self {
        Self::These([count, 1, 1])
    }

    /// Returns at least `count` workgroups in columns, for any count. The last column may extend beyond `count`.
    /// Shaders find the index of a workgroup by `place_in_dispatch` in `glsl/passes/tiles.glsl`.
    pub(crate) fn in_columns(count: u32) -> Self {
        let column = column_of(count);
        Self::These([count.div_ceil(column), column, 1])
    }
}

impl<'a> Commands<'a> {
    /// Returns commands without an observer.
    pub(crate) fn new(
        device: &'a ash::Device,
        buffer: vk::CommandBuffer,
        pipelines: &'a Pipelines,
    ) -> Self {
        Self { device, buffer, pipelines, observer: None, turn: None }
    }

    /// Opens a label over commands. It ends when the returned value is dropped.
    pub(crate) fn group(&self, label: &CStr) -> Option<Group<'a>> {
        self.pipelines.labels.as_ref().map(|labels| labels.group(self.buffer, label))
    }

    /// Returns whether commands are skipped, since another part of the recording is being appended.
    fn is_skipped(&self) -> bool {
        self.turn.is_some_and(|turn| !turn.is_now())
    }

    /// Tells the observer about bytes that a command reads and writes.
    fn note_transfer(&self, read: u64, written: u64) {
        if let Some(observer) = self.observer {
            observer.transferred(read, written);
        }
    }

    /// Binds a pipeline and the sets that it uses.
    pub(crate) fn bind<P: Pod>(&self, pipeline: Pipeline<P>, sets: Sets) {
        self.bind_handle(pipeline.handle, pipeline.layout, sets);
    }

    fn bind_handle(&self, pipeline: vk::Pipeline, layout: vk::PipelineLayout, sets: Sets) {
        if self.is_skipped() {
            return;
        }
        // SAFETY: the pipeline was made with the layout, which the sets fit, and all are alive.
        unsafe {
            self.device.cmd_bind_pipeline(self.buffer, vk::PipelineBindPoint::COMPUTE, pipeline);
            sets.bind(self.device, self.buffer, layout);
        }
    }

    /// Dispatches the bound pipeline.
    pub(crate) fn dispatch<P: Pod>(&self, pipeline: Pipeline<P>, constants: &P, groups: Groups) {
        if self.is_skipped() {
            return;
        }
        if let (Some(observer), Groups::These(groups)) = (self.observer, groups) {
            observer.dispatched(groups);
        }
        let bytes = bytes_of(constants);
        // SAFETY: a pipeline with this layout is bound, the layout has room for the constants of every pass,
        // and the buffer holds three numbers at the offset.
        unsafe {
            if !bytes.is_empty() {
                let stages = vk::ShaderStageFlags::COMPUTE;
                self.device.cmd_push_constants(self.buffer, pipeline.layout, stages, 0, bytes);
            }
            match groups {
                Groups::These(groups @ [x, y, z]) => {
                    debug_assert!(groups.into_iter().all(|count| count <= MOST_GROUPS));
                    self.device.cmd_dispatch(self.buffer, x, y, z);
                }
                Groups::From(buffer, offset) => {
                    self.device.cmd_dispatch_indirect(self.buffer, buffer, offset);
                }
            }
        }
    }

    /// Dispatches zero workgroups of a pipeline, since drivers may compile it at its first dispatch.
    pub(crate) fn warm_up(
        &self,
        pipeline: vk::Pipeline,
        (layout, pushed): (vk::PipelineLayout, u32),
        sets: Sets,
    ) {
        let constants = &[0; PUSH_CONSTANT_BYTES as usize][..pushed as usize];
        let stages = vk::ShaderStageFlags::COMPUTE;
        self.bind_handle(pipeline, layout, sets);
        // SAFETY: the layout has room for this many bytes.
        unsafe {
            if pushed > 0 {
                self.device.cmd_push_constants(self.buffer, layout, stages, 0, constants);
            }
            self.device.cmd_dispatch(self.buffer, 0, 1, 1);
        }
    }

    /// Records a memory barrier between two kinds of access. In a turn, it ends the current part instead.
    pub(crate) fn barrier(&self, before: barrier::Access, after: barrier::Access) {
        match self.turn {
            None => barrier::memory(self.device, self.buffer, before, after),
            Some(turn) => turn.barrier(before, after),
        }
    }

    /// Records a barrier that transitions an image from one layout into another, between two kinds of access.
    pub(crate) fn image_barrier(
        &self,
        image: vk::Image,
        before: barrier::Access,
        after: barrier::Access,
        layouts: (vk::ImageLayout, vk::ImageLayout),
    ) {
        let image = barrier::ImageBarrier { image, before, after, layouts };
        match self.turn {
            None => barrier::image(self.device, self.buffer, image),
            Some(turn) => turn.image_barrier(image),
        }
    }

    /// Fills a layer of an image.
    pub(crate) fn clear(&self, image: vk::Image, layer: u32, value: f64) {
        if self.is_skipped() {
            return;
        }
        let value = vk::ClearColorValue { float32: [value as f32; 4] };
        let range =
            vk::ImageSubresourceRange { base_array_layer: layer, layer_count: 1, ..barrier::COLOR };
        // SAFETY: the image has the layer, is in this layout, and the layer is used by nothing else
        // until the next barrier.
        unsafe {
            let layout = vk::ImageLayout::GENERAL;
            self.device.cmd_clear_color_image(self.buffer, image, layout, &value, &[range]);
        }
    }

    /// Fills part of a buffer with zeros.
    pub(crate) fn fill(&self, buffer: vk::Buffer, offset: u64, size: u64) {
        self.fill_with(buffer, offset, size, 0);
    }

    /// Fills part of a buffer with a number.
    pub(crate) fn fill_with(&self, buffer: vk::Buffer, offset: u64, size: u64, number: u32) {
        if self.is_skipped() {
            return;
        }
        self.note_transfer(0, size);
        // SAFETY: the part lies in the buffer, which nothing else uses until the next barrier.
        unsafe { self.device.cmd_fill_buffer(self.buffer, buffer, offset, size, number) };
    }

    /// Writes part of a buffer, which must have room for it. The number of bytes is a multiple of 4 and at
    /// most 65 536.
    pub(crate) fn update(&self, buffer: vk::Buffer, offset: u64, bytes: &[u8]) {
        if self.is_skipped() {
            return;
        }
        self.note_transfer(0, bytes.len() as u64);
        // SAFETY: the part lies in the buffer, which nothing else uses until the next barrier.
        unsafe { self.device.cmd_update_buffer(self.buffer, buffer, offset, bytes) };
    }

    /// Copies `size` bytes between two places, each given by a buffer and an offset. Both buffers must hold this many
    /// bytes there, and the two parts must not overlap.
    pub(crate) fn copy(&self, from: (vk::Buffer, u64), to: (vk::Buffer, u64), size: u64) {
        let part = vk::BufferCopy::default().src_offset(from.1).dst_offset(to.1).size(size);
        self.copy_parts(from.0, to.0, &[part]);
    }

    /// Copies several parts of a buffer.
    pub(crate) fn copy_parts(&self, from: vk::Buffer, to: vk::Buffer, parts: &[vk::BufferCopy]) {
        if self.is_skipped() {
            return;
        }
        let bytes = parts.iter().map(|part| part.size).sum();
        self.note_transfer(bytes, bytes);
        // SAFETY: both buffers hold this many bytes there. For the host's buffers, the host has promised this.
        unsafe { self.device.cmd_copy_buffer(self.buffer, from, to, parts) };
    }

    /// Copies part of a buffer, row after row, to a part of an image's first layer.
    pub(crate) fn copy_to_image(
        &self,
        (from, start): (vk::Buffer, u64),
        (to, layout): (vk::Image, vk::ImageLayout),
        (offset, extent): (vk::Offset3D, vk::Extent3D),
    ) {
        let layer = vk::ImageSubresourceLayers {
            aspect_mask: vk::ImageAspectFlags::COLOR,
            mip_level: 0,
            base_array_layer: 0,
            layer_count: 1,
        };
        let copy = vk::BufferImageCopy::default()
            .buffer_offset(start)
            .image_subresource(layer)
            .image_offset(offset)
            .image_extent(extent);
        // SAFETY: the buffer holds this many texels, the part lies in the image, which is in this layout, and
        // nothing else uses either until the next barrier.
        unsafe { self.device.cmd_copy_buffer_to_image(self.buffer, from, to, layout, &[copy]) };
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_of_workgroups_are_no_more_than_devices_take() {
        // The counts are those of tiles of 16 points on 4112 x 4112 points, and of 8 points on the largest
        // images.
        for (count, wanted) in [
            (1, [1, 1, 1]),
            (65_535, [65_535, 1, 1]),
            (66_049, [33_025, 2, 1]),
            (4096 * 4096, [65_281, 257, 1]),
        ] {
            let Groups::These(groups) = Groups::in_columns(count) else { unreachable!() };
            assert_eq!(groups, wanted);
            let all = groups.map(u64::from).into_iter().product::<u64>();
            assert!((u64::from(count)..).contains(&all), "{groups:?}");
        }
    }
}

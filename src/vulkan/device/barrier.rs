//! Records barriers. Each kind of access is named by the hazard that it covers.

use ash::vk;

/// Largest number of recordings that share barriers. Each brings at most one image to a barrier.
pub const MOST_TOGETHER: usize = 64;

/// One side of a barrier: pipeline stages, and the kinds of access in them.
pub(crate) type Access = (vk::PipelineStageFlags, vk::AccessFlags);

pub(crate) const NOTHING: Access = (vk::PipelineStageFlags::TOP_OF_PIPE, vk::AccessFlags::NONE);
pub(crate) const TRANSFER_WRITE: Access =
    (vk::PipelineStageFlags::TRANSFER, vk::AccessFlags::TRANSFER_WRITE);
pub(crate) const TRANSFER_READ: Access =
    (vk::PipelineStageFlags::TRANSFER, vk::AccessFlags::TRANSFER_READ);
/// Clears, copies and updates.
pub(crate) const TRANSFER: Access = (
    vk::PipelineStageFlags::TRANSFER,
    vk::AccessFlags::from_raw(
        vk::AccessFlags::TRANSFER_READ.as_raw() | vk::AccessFlags::TRANSFER_WRITE.as_raw(),
    ),
);
pub(crate) const SHADER_WRITE: Access =
    (vk::PipelineStageFlags::COMPUTE_SHADER, vk::AccessFlags::SHADER_WRITE);
pub(crate) const SHADER: Access = (
    vk::PipelineStageFlags::COMPUTE_SHADER,
    vk::AccessFlags::from_raw(
        vk::AccessFlags::SHADER_READ.as_raw() | vk::AccessFlags::SHADER_WRITE.as_raw(),
    ),
);
/// A pass that may be dispatched indirectly.
pub(crate) const PASS: Access = (
    vk::PipelineStageFlags::from_raw(
        vk::PipelineStageFlags::COMPUTE_SHADER.as_raw()
            | vk::PipelineStageFlags::DRAW_INDIRECT.as_raw(),
    ),
    vk::AccessFlags::from_raw(
        vk::AccessFlags::SHADER_READ.as_raw()
            | vk::AccessFlags::SHADER_WRITE.as_raw()
            | vk::AccessFlags::INDIRECT_COMMAND_READ.as_raw(),
    ),
);
pub(crate) const HOST_READ: Access = (vk::PipelineStageFlags::HOST, vk::AccessFlags::HOST_READ);

/// Passes and the host, after a copy that the host reads while the map continues.
pub(crate) const PASS_AND_HOST: Access = (
    vk::PipelineStageFlags::from_raw(PASS.0.as_raw() | HOST_READ.0.as_raw()),
    vk::AccessFlags::from_raw(PASS.1.as_raw() | HOST_READ.1.as_raw()),
);

/// Makes the writes of `before` visible to `after`.
pub(crate) fn memory(
    device: &ash::Device,
    commands: vk::CommandBuffer,
    before: Access,
    after: Access,
) {
    #[cfg(test)]
    if tests::is_left_out(before, after) {
        return;
    }
    let all = vk::MemoryBarrier::default().src_access_mask(before.1).dst_access_mask(after.1);
    let none = vk::DependencyFlags::empty();
    // SAFETY: the command buffer is being recorded on this device.
    unsafe {
        device.cmd_pipeline_barrier(commands, before.0, after.0, none, &[all], &[], &[]);
    }
}

/// Transitions an image from one layout into another.
pub(crate) fn image(device: &ash::Device, commands: vk::CommandBuffer, image: ImageBarrier) {
    let none = vk::AccessFlags::NONE;
    merged(device, commands, (image.before.0, none), (image.after.0, none), &[image]);
}

/// Barrier of an image with a transition of its layout.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct ImageBarrier {
    pub(crate) image: vk::Image,
    pub(crate) before: Access,
    pub(crate) after: Access,
    pub(crate) layouts: (vk::ImageLayout, vk::ImageLayout),
}

impl ImageBarrier {
    fn info(&self) -> vk::ImageMemoryBarrier<'static> {
        vk::ImageMemoryBarrier::default()
            .src_access_mask(self.before.1)
            .dst_access_mask(self.after.1)
            .old_layout(self.layouts.0)
            .new_layout(self.layouts.1)
            .src_queue_family_index(vk::QUEUE_FAMILY_IGNORED)
            .dst_queue_family_index(vk::QUEUE_FAMILY_IGNORED)
            .image(self.image)
            .subresource_range(COLOR)
    }
}

/// Records several barriers as one, with the stages of all barriers, their accesses to memory, and their images.
pub(crate) fn merged(
    device: &ash::Device,
    commands: vk::CommandBuffer,
    before: Access,
    after: Access,
    images: &[ImageBarrier],
) {
    if images.is_empty() {
        return memory(device, commands, before, after);
    }
    let all = vk::MemoryBarrier::default().src_access_mask(before.1).dst_access_mask(after.1);
    let all = [all];
    // Barriers of images alone do not concern other memory.
    let all = if (before.1 | after.1).is_empty() { &all[..0] } else { &all[..] };
    let mut infos = [vk::ImageMemoryBarrier::default(); MOST_TOGETHER];
    for (info, image) in infos.iter_mut().zip(images) {
        *info = image.info();
    }
    let images = &infos[..images.len()];
    let none = vk::DependencyFlags::empty();
    // SAFETY: the command buffer is being recorded on the device that the images are from.
    unsafe {
        device.cmd_pipeline_barrier(commands, before.0, after.0, none, all, &[], images);
    }
}

/// All layers of a colour image without mip levels.
pub(crate) const COLOR: vk::ImageSubresourceRange = vk::ImageSubresourceRange {
    aspect_mask: vk::ImageAspectFlags::COLOR,
    base_mip_level: 0,
    level_count: 1,
    base_array_layer: 0,
    layer_count: vk::REMAINING_ARRAY_LAYERS,
};

/// Checks that the validation layers are active, by leaving out barriers on purpose.
#[cfg(test)]
pub(crate) mod tests {
    use std::cell::RefCell;

    use super::Access;

    type Choice = Box<dyn FnMut(Access, Access) -> bool>;

    thread_local! {
        static LEFT_OUT: RefCell<Option<Choice>> = const { RefCell::new(None) };
    }

    pub(in crate::vulkan) fn is_left_out(before: Access, after: Access) -> bool {
        let choose = |choice: &mut Choice| choice(before, after);
        LEFT_OUT.with_borrow_mut(|choice| choice.as_mut().is_some_and(choose))
    }

    /// Calls `record` without the memory barriers for which `chosen` returns true.
    pub(crate) fn without<T>(
        chosen: impl FnMut(Access, Access) -> bool + 'static,
        record: impl FnOnce() -> T,
    ) -> T {
        LEFT_OUT.set(Some(Box::new(chosen)));
        let done = record();
        LEFT_OUT.set(None);
        done
    }

    /// Returns a function that chooses the barrier with this number, counted from 0.
    pub(crate) fn number(which: usize) -> impl FnMut(Access, Access) -> bool {
        let mut numbers = 0..;
        move |_, _| numbers.next() == Some(which)
    }
}

//! How the host uses what it shares with us, as the two sides of a barrier.

use ash::vk;

use crate::vulkan::barrier;

/// Pipeline stages and the kinds of access in them.
///
/// ```
/// use geosweep::vulkan::embed::Access;
/// // Positions come from a compute shader, sources from a copy.
/// let before = Access::COMPUTE_WRITE.and(Access::TRANSFER_WRITE);
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Access {
    /// In which stages.
    pub stages: vk::PipelineStageFlags,
    /// Of which kinds.
    pub access: vk::AccessFlags,
}

impl Access {
    /// Nothing to wait for.
    pub const NONE: Self = Self::new(vk::PipelineStageFlags::TOP_OF_PIPE, vk::AccessFlags::NONE);
    /// Written by a compute shader.
    pub const COMPUTE_WRITE: Self =
        Self::new(vk::PipelineStageFlags::COMPUTE_SHADER, vk::AccessFlags::SHADER_WRITE);
    /// Read by a compute shader. So do we read the host's points, sources and places: before it
    /// overwrites them, the host waits for this.
    pub const COMPUTE_READ: Self =
        Self::new(vk::PipelineStageFlags::COMPUTE_SHADER, vk::AccessFlags::SHADER_READ);
    /// Written by a copy.
    pub const TRANSFER_WRITE: Self =
        Self::new(vk::PipelineStageFlags::TRANSFER, vk::AccessFlags::TRANSFER_WRITE);
    /// Read by a copy.
    pub const TRANSFER_READ: Self =
        Self::new(vk::PipelineStageFlags::TRANSFER, vk::AccessFlags::TRANSFER_READ);
    /// Read by a vertex shader.
    pub const VERTEX_READ: Self =
        Self::new(vk::PipelineStageFlags::VERTEX_SHADER, vk::AccessFlags::SHADER_READ);
    /// Read by a fragment shader.
    pub const FRAGMENT_READ: Self =
        Self::new(vk::PipelineStageFlags::FRAGMENT_SHADER, vk::AccessFlags::SHADER_READ);
    /// Drawn by `vkCmdDrawIndirect` from a vertex buffer.
    pub const DRAW: Self = Self::new(
        vk::PipelineStageFlags::from_raw(
            vk::PipelineStageFlags::DRAW_INDIRECT.as_raw()
                | vk::PipelineStageFlags::VERTEX_INPUT.as_raw(),
        ),
        vk::AccessFlags::from_raw(
            vk::AccessFlags::INDIRECT_COMMAND_READ.as_raw()
                | vk::AccessFlags::VERTEX_ATTRIBUTE_READ.as_raw(),
        ),
    );
    /// Read through mapped memory, after the fence of the submission.
    pub const HOST_READ: Self = Self::new(vk::PipelineStageFlags::HOST, vk::AccessFlags::HOST_READ);

    /// These stages and kinds.
    pub const fn new(stages: vk::PipelineStageFlags, access: vk::AccessFlags) -> Self {
        Self { stages, access }
    }

    /// This and another.
    pub fn and(self, other: Self) -> Self {
        Self::new(self.stages | other.stages, self.access | other.access)
    }

    pub(super) fn side(self) -> barrier::Access {
        (self.stages, self.access)
    }
}

/// How the host reads an image of distances, this frame and whenever it read that image before.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Reader {
    /// In which stages, and how.
    pub access: Access,
    /// The layout in which we leave the image.
    pub layout: vk::ImageLayout,
}

impl Reader {
    /// Sampled by a fragment shader.
    pub const FRAGMENT: Self = Self::sampled(Access::FRAGMENT_READ);
    /// Sampled by a vertex shader.
    pub const VERTEX: Self = Self::sampled(Access::VERTEX_READ);
    /// Sampled by a compute shader.
    pub const COMPUTE: Self = Self::sampled(Access::COMPUTE_READ);
    /// Copied from.
    pub const COPY: Self =
        Self { access: Access::TRANSFER_READ, layout: vk::ImageLayout::TRANSFER_SRC_OPTIMAL };

    /// Sampled on another queue, after a semaphore: nothing on ours waits for it. The stages of the
    /// readers may be none that our queue has.
    pub const OTHER_QUEUE: Self = Self::sampled(Access::NONE);

    /// Sampled in these stages.
    pub const fn sampled(access: Access) -> Self {
        Self { access, layout: vk::ImageLayout::SHADER_READ_ONLY_OPTIMAL }
    }
}

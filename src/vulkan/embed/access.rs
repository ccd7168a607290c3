//! Describes how the host uses shared resources, as one side of a barrier.

use ash::vk;

use crate::vulkan::device::barrier;

/// Pipeline stages, and the kinds of memory access in them.
///
/// ```
/// use geosweep::vulkan::embed::Access;
/// // Positions come from a compute shader, sources from a copy.
/// let before = Access::COMPUTE_WRITE.and(Access::TRANSFER_WRITE);
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Access {
    /// Pipeline stages that access the resource.
    pub stages: vk::PipelineStageFlags,
    /// Kinds of access in these stages.
    pub access: vk::AccessFlags,
}

impl Access {
    /// Empty access: there is nothing to wait for.
    pub const NONE: Self = Self::new(vk::PipelineStageFlags::TOP_OF_PIPE, vk::AccessFlags::NONE);
    /// Writes by a compute shader.
    pub const COMPUTE_WRITE: Self =
        Self::new(vk::PipelineStageFlags::COMPUTE_SHADER, vk::AccessFlags::SHADER_WRITE);
    /// Reads by a compute shader. The passes of a recording read the host's points, sources and places with
    /// this access. The host must wait for it before it overwrites them.
    pub const COMPUTE_READ: Self =
        Self::new(vk::PipelineStageFlags::COMPUTE_SHADER, vk::AccessFlags::SHADER_READ);
    /// Writes by a copy command.
    pub const TRANSFER_WRITE: Self =
        Self::new(vk::PipelineStageFlags::TRANSFER, vk::AccessFlags::TRANSFER_WRITE);
    /// Reads by a copy command.
    pub const TRANSFER_READ: Self =
        Self::new(vk::PipelineStageFlags::TRANSFER, vk::AccessFlags::TRANSFER_READ);
    /// Reads by a vertex shader.
    pub const VERTEX_READ: Self =
        Self::new(vk::PipelineStageFlags::VERTEX_SHADER, vk::AccessFlags::SHADER_READ);
    /// Reads by a fragment shader.
    pub const FRAGMENT_READ: Self =
        Self::new(vk::PipelineStageFlags::FRAGMENT_SHADER, vk::AccessFlags::SHADER_READ);
    /// Reads of draw arguments and vertices by `vkCmdDrawIndirect` with a vertex buffer.
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
    /// Reads by the program through mapped memory, after the fence of the submission.
    pub const HOST_READ: Self = Self::new(vk::PipelineStageFlags::HOST, vk::AccessFlags::HOST_READ);

    /// Returns the access with these stages and kinds.
    pub const fn new(stages: vk::PipelineStageFlags, access: vk::AccessFlags) -> Self {
        Self { stages, access }
    }

    /// Returns the union of this access and another.
    pub fn and(self, other: Self) -> Self {
        Self::new(self.stages | other.stages, self.access | other.access)
    }

    pub(super) fn side(self) -> barrier::Access {
        (self.stages, self.access)
    }
}

/// Access and layout with which the host reads an image of distances, in this frame and in all earlier reads of the
/// image.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Reader {
    /// Stages and kinds of the reads.
    pub access: Access,
    /// Layout in which the recording leaves the image.
    pub layout: vk::ImageLayout,
}

impl Reader {
    /// Sampling in a fragment shader.
    pub const FRAGMENT: Self = Self::sampled(Access::FRAGMENT_READ);
    /// Sampling in a vertex shader.
    pub const VERTEX: Self = Self::sampled(Access::VERTEX_READ);
    /// Sampling in a compute shader.
    pub const COMPUTE: Self = Self::sampled(Access::COMPUTE_READ);
    /// Copies from the image.
    pub const COPY: Self =
        Self { access: Access::TRANSFER_READ, layout: vk::ImageLayout::TRANSFER_SRC_OPTIMAL };

    /// Sampling on another queue, after a semaphore. Commands on the recording queue do not wait for these reads, since
    /// that queue may lack the stages of the readers.
    pub const OTHER_QUEUE: Self = Self::sampled(Access::NONE);

    /// Returns a reader that samples the image in these stages.
    pub const fn sampled(access: Access) -> Self {
        Self { access, layout: vk::ImageLayout::SHADER_READ_ONLY_OPTIMAL }
    }
}

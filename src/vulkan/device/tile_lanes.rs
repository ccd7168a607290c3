//! States how the invocations of a workgroup share a tile.

use ash::vk;

/// Number of points of a tile's line that each invocation of a workgroup updates. The map is the same for each
/// choice, up to the device's rounding.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum TileLanes {
    /// Two neighbouring points for each invocation. Best on CPUs, where a barrier costs time for each invocation.
    Pairs,
    /// One point for each invocation. Neighbours pass their results through shared memory.
    Points,
    /// One point for each invocation. Neighbours pass their results by shuffles within a subgroup, and through shared
    /// memory between subgroups. The device must be able to shuffle within subgroups.
    Shuffled,
}

impl TileLanes {
    /// Returns the size of a workgroup divided by the number of points on a side of the tile. Four scans run at once,
    /// each with invocations of its own.
    pub(in crate::vulkan) fn invocations(self) -> u32 {
        if self == Self::Pairs { 2 } else { 4 }
    }

    /// Returns the choice for GPUs. `shuffles` is the result of the function [`shuffles`].
    pub(in crate::vulkan) fn of_gpu(shuffles: bool) -> Self {
        if shuffles { Self::Shuffled } else { Self::Points }
    }
}

/// Returns whether a device has, in compute shaders, the subgroup operations of `glsl/passes/tiles_shuffled.comp`:
/// basic ones and relative shuffles. The instance must be for Vulkan 1.1 or later.
pub(in crate::vulkan) fn shuffles(
    instance: &ash::Instance,
    physical_device: vk::PhysicalDevice,
) -> bool {
    let mut subgroups = vk::PhysicalDeviceSubgroupProperties::default();
    let mut properties = vk::PhysicalDeviceProperties2::default().push_next(&mut subgroups);
    // SAFETY: the physical device is from this instance.
    unsafe { instance.get_physical_device_properties2(physical_device, &mut properties) };
    let needed = vk::SubgroupFeatureFlags::BASIC | vk::SubgroupFeatureFlags::SHUFFLE_RELATIVE;
    subgroups.supported_operations.contains(needed)
        && subgroups.supported_stages.contains(vk::ShaderStageFlags::COMPUTE)
}

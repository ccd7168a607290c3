//! States how the invocations of a workgroup share a tile.

use ash::vk;

/// Division of the points of a line of a tile among invocations. All divisions lead to the same map.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum TileLanes {
    /// Two neighbouring points for each invocation. On CPUs a barrier costs time for each invocation.
    Pairs,
    /// One point for each invocation. Neighbours see each other's results in shared memory.
    Points,
    /// One point for each invocation. Neighbours see each other's results in registers. The device must
    /// shuffle within subgroups.
    Shuffled,
}

impl TileLanes {
    /// Returns the number of invocations for each point of a side of a tile, of all four scans together.
    pub(in crate::vulkan) fn invocations(self) -> u32 {
        if self == Self::Pairs { 2 } else { 4 }
    }

    /// Returns what suits a device that is no CPU.
    pub(in crate::vulkan) fn of_gpu(shuffles: bool) -> Self {
        if shuffles { Self::Shuffled } else { Self::Points }
    }
}

/// Returns whether compute shaders of a device may use what `glsl/passes/tiles_shuffled.comp` uses of
/// subgroups. The instance must be for Vulkan 1.1 or later.
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

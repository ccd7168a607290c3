//! Recognizes devices that have memory of their own, by their memory types.

use ash::vk;

/// Returns whether shaders should access the device's memory in place of the host's, with copies between the
/// two.
///
/// A device with memory of its own reaches the host's memory over a bus. The cached memory from which the
/// program reads is the host's, and not local to the device. Devices that share the host's memory have cached
/// memory that is local to both.
pub(in crate::vulkan) fn need_staging(memory: &vk::PhysicalDeviceMemoryProperties) -> bool {
    use vk::MemoryPropertyFlags as Flags;
    let types = memory.memory_types_as_slice();
    let has = |with: Flags, without: Flags| {
        let mut flags = types.iter().map(|kind| kind.property_flags);
        flags.any(|flags| flags.contains(with) && !flags.intersects(without))
    };
    let cached = Flags::HOST_VISIBLE | Flags::HOST_COHERENT | Flags::HOST_CACHED;
    has(Flags::DEVICE_LOCAL, Flags::HOST_VISIBLE)
        && !has(cached | Flags::DEVICE_LOCAL, Flags::empty())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The memory types are those that drivers report.
    #[test]
    fn devices_with_memory_of_their_own_are_known_by_their_memory_types() {
        use vk::MemoryPropertyFlags as Flags;
        let own = Flags::DEVICE_LOCAL;
        let written = Flags::HOST_VISIBLE | Flags::HOST_COHERENT;
        let cached = written | Flags::HOST_CACHED;
        let need_staging = |types: &[Flags]| {
            let mut memory = vk::PhysicalDeviceMemoryProperties {
                memory_type_count: types.len() as u32,
                ..Default::default()
            };
            for (kind, &property_flags) in memory.memory_types.iter_mut().zip(types) {
                kind.property_flags = property_flags;
            }
            super::need_staging(&memory)
        };
        // Discrete GPUs, without and with all of their memory visible to the host.
        assert!(need_staging(&[Flags::empty(), own, written, cached]));
        assert!(need_staging(&[Flags::empty(), own, written, cached, own | written]));
        // Devices that share the host's memory: lavapipe, integrated GPUs (some set memory aside), and
        // Apple's GPUs.
        assert!(!need_staging(&[own | cached]));
        assert!(!need_staging(&[own, own | written, own | cached]));
        assert!(!need_staging(&[own, own | cached]));
        // A device that has only the host's memory.
        assert!(!need_staging(&[cached]));
    }
}

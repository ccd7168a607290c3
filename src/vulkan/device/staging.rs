//! Passes data between the program's memory and that of a device which has its own.

use ash::vk;
use gpu_allocator::MemoryLocation::GpuToCpu;
use rayon::prelude::*;

use super::device_memory::DeviceMemory;
use super::memory::{Buffer, BufferInfo};
use super::pipelines::Pipelines;
use crate::vulkan::VulkanError;

/// Returns whether shaders should access the device's memory in place of the host's, with copies between the
/// two.
///
/// On a device with memory of its own, what the program reads lies beyond a bus: the host's cached memory is
/// not local to the device. Devices that share the host's memory have cached memory that is local to both.
pub(in crate::vulkan) fn is_needed(memory: &vk::PhysicalDeviceMemoryProperties) -> bool {
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

/// Number of parts of a staging buffer. The program works on one part while the device copies the other.
pub(crate) const HALVES: usize = 2;

/// Buffer in the host's memory with a part for each of two bands, which copies fill or empty.
#[derive(Debug)]
pub(crate) struct Staging {
    buffer: Buffer,
    /// Bytes of a half.
    half: usize,
}

impl Staging {
    /// Allocates the halves, and `further` bytes after them.
    pub(crate) fn new(
        device: &ash::Device,
        allocator: &mut dyn DeviceMemory,
        pipelines: &Pipelines,
        name: &'static str,
        (half, further): (usize, usize),
    ) -> Result<Self, VulkanError> {
        // The processor writes through its cache too: memory without one may lie beyond the bus.
        let size = (HALVES * half + further) as u64;
        let info = BufferInfo { name, size, location: GpuToCpu };
        let buffer = Buffer::new(device, allocator, info)?;
        pipelines.name(name, buffer.buffer);
        Ok(Self { buffer, half })
    }

    /// Returns a half as the source or the target of a copy.
    pub(crate) fn at(&self, half: usize) -> (vk::Buffer, u64) {
        (self.buffer.buffer, (half * self.half) as u64)
    }

    /// Returns what lies after the halves as the source of a copy.
    pub(crate) fn further_at(&self) -> (vk::Buffer, u64) {
        self.at(HALVES)
    }

    pub(crate) fn read(&self, half: usize) -> &[u8] {
        &self.buffer.read()[half * self.half..][..self.half]
    }

    pub(crate) fn write(&mut self, half: usize) -> &mut [u8] {
        &mut self.buffer.mapped()[half * self.half..][..self.half]
    }

    pub(crate) fn write_further(&mut self) -> &mut [u8] {
        &mut self.buffer.mapped()[HALVES * self.half..]
    }

    pub(crate) fn bytes(&self) -> u64 {
        self.buffer.bytes()
    }

    /// Frees the buffer. No submitted work may still use it.
    pub(crate) fn destroy(&mut self, device: &ash::Device, allocator: &mut dyn DeviceMemory) {
        self.buffer.destroy(device, allocator);
    }
}

/// Number of bytes that a thread copies at a time. It takes a thread some 50 microseconds.
const COPIED_TOGETHER: usize = 512 << 10;

/// Copies bytes, on several threads where there are many of them: one thread alone does not reach the rate of
/// the memory, and new memory is first touched here.
pub(crate) fn copy_in_parallel(from: &[u8], to: &mut [u8]) {
    let parts = to.par_chunks_mut(COPIED_TOGETHER).zip(from.par_chunks(COPIED_TOGETHER));
    parts.for_each(|(to, from)| to.copy_from_slice(from));
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
        let is_needed = |types: &[Flags]| {
            let mut memory = vk::PhysicalDeviceMemoryProperties {
                memory_type_count: types.len() as u32,
                ..Default::default()
            };
            for (kind, &property_flags) in memory.memory_types.iter_mut().zip(types) {
                kind.property_flags = property_flags;
            }
            super::is_needed(&memory)
        };
        // Discrete GPUs, without and with all of their memory visible to the host.
        assert!(is_needed(&[Flags::empty(), own, written, cached]));
        assert!(is_needed(&[Flags::empty(), own, written, cached, own | written]));
        // lavapipe; an integrated GPU; one that sets memory aside; Apple's.
        assert!(!is_needed(&[own | cached]));
        assert!(!is_needed(&[own, own | written, own | cached]));
        assert!(!is_needed(&[own, own | cached]));
        // Nothing but the host's memory.
        assert!(!is_needed(&[cached]));
    }
}

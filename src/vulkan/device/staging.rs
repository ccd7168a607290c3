//! Transfers data between the program's memory and a device that has memory of its own.

use ash::vk;
use gpu_allocator::MemoryLocation::GpuToCpu;
use rayon::prelude::*;

use super::device_memory::DeviceMemory;
use super::memory::{Buffer, BufferInfo};
use super::pipelines::Pipelines;
use crate::vulkan::VulkanError;

/// Number of parts of a staging buffer. The program works on one part while the device copies the other.
pub(crate) const HALVES: usize = 2;

/// Buffer in the host's memory with a part for each of two bands. Copies fill or empty the parts.
#[derive(Debug)]
pub(crate) struct Staging {
    buffer: Buffer,
    /// Size of a half in bytes.
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
        // Uploads use cached memory too, since uncached memory may be the device's, beyond the bus.
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

    /// Returns the buffer and the offset of the bytes after the halves, as the source of a copy.
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

/// Number of bytes that a thread copies at a time. Copying them takes some 50 microseconds.
const COPIED_TOGETHER: usize = 512 << 10;

/// Copies bytes, on several threads if there are many bytes. One thread alone does not reach the bandwidth of
/// the memory, and the first access to new memory, which takes longer, happens here.
pub(crate) fn copy_in_parallel(from: &[u8], to: &mut [u8]) {
    let parts = to.par_chunks_mut(COPIED_TOGETHER).zip(from.par_chunks(COPIED_TOGETHER));
    parts.for_each(|(to, from)| to.copy_from_slice(from));
}

//! Where the memory of images and buffers comes from.

use std::ptr::NonNull;
use std::sync::MutexGuard;

use ash::vk;
use gpu_allocator::vulkan::{Allocation, AllocationCreateDesc, AllocationScheme, Allocator};
use gpu_allocator::{AllocationError, MemoryLocation};

/// Gives device memory to surfaces, contours, paths and regions: gpu-allocator's [`Allocator`], or a renderer's own
/// allocator behind the same two calls.
pub trait DeviceMemory {
    /// Finds room for an image or a buffer.
    ///
    /// # Errors
    /// If there is none, or a call of Vulkan's fails.
    fn allocate(&mut self, wanted: &MemoryRequest) -> Result<MemoryBlock, AllocationError>;

    /// Takes a block back that it has given. Nothing uses it any more.
    fn free(&mut self, block: MemoryBlock);
}

/// What memory is wanted for.
#[derive(Clone, Copy, Debug)]
#[non_exhaustive]
pub struct MemoryRequest {
    /// For reports, such as "edge lengths".
    pub name: &'static str,
    /// Of the image or buffer.
    pub requirements: vk::MemoryRequirements,
    /// Whether the program reads or writes it. Such memory is coherent, and stays mapped.
    pub location: MemoryLocation,
    /// What it is for: a buffer, or an image with optimal tiling.
    pub is_buffer: bool,
}

impl MemoryRequest {
    /// What the memory's type has to have, and what it should have.
    pub fn properties(&self) -> [vk::MemoryPropertyFlags; 2] {
        use vk::MemoryPropertyFlags as Flags;
        let mapped = Flags::HOST_VISIBLE | Flags::HOST_COHERENT;
        match self.location {
            MemoryLocation::CpuToGpu => [mapped, mapped | Flags::DEVICE_LOCAL],
            MemoryLocation::GpuToCpu => [mapped, mapped | Flags::HOST_CACHED],
            MemoryLocation::GpuOnly | MemoryLocation::Unknown => [Flags::DEVICE_LOCAL; 2],
        }
    }
}

/// A part of device memory.
#[derive(Debug)]
pub struct MemoryBlock {
    memory: vk::DeviceMemory,
    offset: u64,
    size: u64,
    mapped: Option<NonNull<u8>>,
    origin: Origin,
}

/// By what its giver knows it.
#[derive(Debug)]
enum Origin {
    GpuAllocator(Allocation),
    Number(u64),
}

// SAFETY: mapped memory belongs to no thread; who has the block has it to itself.
unsafe impl Send for MemoryBlock {}
// SAFETY: a shared block only reads it.
unsafe impl Sync for MemoryBlock {}

impl MemoryBlock {
    /// A block with a number by which its giver knows it.
    ///
    /// # Safety
    /// The memory is of the device, holds so many bytes from the offset on, which nothing else uses until the
    /// block is freed, and if they are mapped, then there.
    pub unsafe fn new(
        memory: vk::DeviceMemory,
        (offset, size): (u64, u64),
        mapped: Option<NonNull<u8>>,
        number: u64,
    ) -> Self {
        Self { memory, offset, size, mapped, origin: Origin::Number(number) }
    }

    /// The number that it was made with; `None` if it is of gpu-allocator's.
    pub fn number(&self) -> Option<u64> {
        match self.origin {
            Origin::Number(number) => Some(number),
            Origin::GpuAllocator(_) => None,
        }
    }

    /// The memory, and where the block begins in it.
    pub fn place(&self) -> (vk::DeviceMemory, u64) {
        (self.memory, self.offset)
    }

    /// Bytes.
    pub fn size(&self) -> u64 {
        self.size
    }

    /// What is mapped of it.
    pub(crate) fn bytes(&self) -> Option<&[u8]> {
        // SAFETY: its maker has promised that it is mapped there.
        self.mapped.map(|at| unsafe { std::slice::from_raw_parts(at.as_ptr(), self.size as usize) })
    }

    /// The same, to be written.
    pub(crate) fn bytes_mut(&mut self) -> Option<&mut [u8]> {
        let size = self.size as usize;
        // SAFETY: its maker has promised that it is mapped there, and nothing else uses it.
        self.mapped.map(|at| unsafe { std::slice::from_raw_parts_mut(at.as_ptr(), size) })
    }
}

impl DeviceMemory for Allocator {
    fn allocate(&mut self, wanted: &MemoryRequest) -> Result<MemoryBlock, AllocationError> {
        let allocation = Allocator::allocate(
            self,
            &AllocationCreateDesc {
                name: wanted.name,
                requirements: wanted.requirements,
                location: wanted.location,
                linear: wanted.is_buffer,
                allocation_scheme: AllocationScheme::GpuAllocatorManaged,
            },
        )?;
        Ok(MemoryBlock {
            // SAFETY: it is freed by the block's end alone.
            memory: unsafe { allocation.memory() },
            offset: allocation.offset(),
            size: allocation.size(),
            mapped: allocation.mapped_ptr().map(|at| at.cast()),
            origin: Origin::GpuAllocator(allocation),
        })
    }

    fn free(&mut self, block: MemoryBlock) {
        if let Origin::GpuAllocator(allocation) = block.origin {
            // An allocation of another allocator is the only reason to fail.
            let freed = Allocator::free(self, allocation);
            debug_assert!(freed.is_ok(), "{freed:?}");
        }
    }
}

/// That of others behind a mutex.
impl<M: DeviceMemory> DeviceMemory for MutexGuard<'_, M> {
    fn allocate(&mut self, wanted: &MemoryRequest) -> Result<MemoryBlock, AllocationError> {
        M::allocate(self, wanted)
    }

    fn free(&mut self, block: MemoryBlock) {
        M::free(self, block);
    }
}

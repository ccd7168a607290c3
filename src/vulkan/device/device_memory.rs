//! Allocates the memory of images and buffers through a trait that hosts can implement.

use std::ptr::NonNull;
use std::sync::MutexGuard;

use ash::vk;
use gpu_allocator::vulkan::{Allocation, AllocationCreateDesc, AllocationScheme, Allocator};
use gpu_allocator::{AllocationError, MemoryLocation};

/// Allocator of device memory for surfaces, contours, paths and regions. It is gpu-allocator's [`Allocator`],
/// or a renderer's own allocator behind the same two calls.
pub trait DeviceMemory {
    /// Allocates memory for an image or a buffer.
    ///
    /// # Errors
    /// If memory runs out, or a Vulkan call fails.
    fn allocate(&mut self, wanted: &MemoryRequest) -> Result<MemoryBlock, AllocationError>;

    /// Frees a block that this allocator has returned. Nothing uses the block any more.
    fn free(&mut self, block: MemoryBlock);
}

/// Request for the memory of an image or a buffer.
#[derive(Clone, Copy, Debug)]
#[non_exhaustive]
pub struct MemoryRequest {
    /// Name of the resource for reports, such as "edge lengths".
    pub name: &'static str,
    /// Memory requirements of the image or buffer.
    pub requirements: vk::MemoryRequirements,
    /// Location of the memory, which says whether the program reads or writes it. Memory that the program
    /// accesses is coherent and stays mapped.
    pub location: MemoryLocation,
    /// Whether the memory is for a buffer. Otherwise it is for an image with optimal tiling.
    pub is_buffer: bool,
}

impl MemoryRequest {
    /// Returns the properties that the memory type must have, and those that it should have.
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

/// Range of device memory.
#[derive(Debug)]
pub struct MemoryBlock {
    memory: vk::DeviceMemory,
    offset: u64,
    size: u64,
    mapped: Option<NonNull<u8>>,
    origin: Origin,
}

/// Identity of a block in the allocator that returned it.
#[derive(Debug)]
enum Origin {
    GpuAllocator(Allocation),
    Number(u64),
}

// SAFETY: mapped memory belongs to no thread, and the owner of a block has exclusive access to it.
unsafe impl Send for MemoryBlock {}
// SAFETY: a shared block is only read.
unsafe impl Sync for MemoryBlock {}

impl MemoryBlock {
    /// Creates a block. Its allocator identifies it by `number`.
    ///
    /// # Safety
    /// `memory` was allocated from the device, has at least `size` bytes after `offset`, and nothing else
    /// uses this range until the block is freed. If `mapped` is given, this range is mapped at that address.
    pub unsafe fn new(
        memory: vk::DeviceMemory,
        (offset, size): (u64, u64),
        mapped: Option<NonNull<u8>>,
        number: u64,
    ) -> Self {
        Self { memory, offset, size, mapped, origin: Origin::Number(number) }
    }

    /// Returns the number that the block was created with; `None` if it comes from gpu-allocator.
    pub fn number(&self) -> Option<u64> {
        match self.origin {
            Origin::Number(number) => Some(number),
            Origin::GpuAllocator(_) => None,
        }
    }

    /// Returns the memory, and the offset of the block in it.
    pub fn place(&self) -> (vk::DeviceMemory, u64) {
        (self.memory, self.offset)
    }

    /// Returns the size of the block in bytes.
    pub fn size(&self) -> u64 {
        self.size
    }

    /// Returns the mapped bytes of the block; `None` if it is not mapped.
    pub(crate) fn bytes(&self) -> Option<&[u8]> {
        // SAFETY: the creator of the block has promised that it is mapped at this address.
        self.mapped.map(|at| unsafe { std::slice::from_raw_parts(at.as_ptr(), self.size as usize) })
    }

    /// Returns the mapped bytes of the block for writing; `None` if it is not mapped.
    pub(crate) fn bytes_mut(&mut self) -> Option<&mut [u8]> {
        let size = self.size as usize;
        // SAFETY: the creator of the block has promised that it is mapped at this address and that nothing
        // else uses it.
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
            // SAFETY: the memory is freed only when the block is freed.
            memory: unsafe { allocation.memory() },
            offset: allocation.offset(),
            size: allocation.size(),
            mapped: allocation.mapped_ptr().map(|at| at.cast()),
            origin: Origin::GpuAllocator(allocation),
        })
    }

    fn free(&mut self, block: MemoryBlock) {
        if let Origin::GpuAllocator(allocation) = block.origin {
            // Freeing fails only for an allocation of another allocator.
            let freed = Allocator::free(self, allocation);
            debug_assert!(freed.is_ok(), "{freed:?}");
        }
    }
}

/// Forwards to the allocator behind a mutex.
impl<M: DeviceMemory> DeviceMemory for MutexGuard<'_, M> {
    fn allocate(&mut self, wanted: &MemoryRequest) -> Result<MemoryBlock, AllocationError> {
        M::allocate(self, wanted)
    }

    fn free(&mut self, block: MemoryBlock) {
        M::free(self, block);
    }
}

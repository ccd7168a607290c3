//! Device memory in the solver's own blocks, or from an allocator of the program.

use std::ffi::{CString, c_char, c_void};
use std::ptr::{NonNull, null_mut};

use ash::vk;
use gpu_allocator::AllocationError;
use gpu_allocator::vulkan::Allocator;

use super::status::Failure;
use geosweep::vulkan::embed::{DeviceMemory, MemoryBlock, MemoryRequest};

/// Requirements of an image or a buffer.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct GeosweepMemoryRequest {
    /// Size, alignment and memory types.
    pub requirements: vk::MemoryRequirements,
    /// Properties that the memory type must have: device-local, or host-visible and host-coherent.
    pub required: vk::MemoryPropertyFlags,
    /// Properties that the memory type should have too.
    pub preferred: vk::MemoryPropertyFlags,
    /// Whether the memory is for a buffer. Otherwise it is for an image with optimal tiling.
    pub is_buffer: bool,
    /// Purpose of the memory, such as "edge lengths". The text is valid during the call alone.
    pub name: *const c_char,
}

/// A block of device memory.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct GeosweepMemory {
    /// The device memory that contains the block.
    pub memory: vk::DeviceMemory,
    /// Offset of the block in `memory` in bytes; a multiple of the alignment.
    pub offset: u64,
    /// Address at which the block is mapped until it is freed. It may be null if the block need not be
    /// host-visible.
    pub mapped: *mut c_void,
    /// Your own handle of the block, for instance a `VmaAllocation`.
    pub handle: *mut c_void,
}

/// Your own allocator for surfaces, contours, paths, regions, directions and log maps. Its functions are
/// called by one thread at a time, in calls that create and destroy these objects. They must not call
/// functions of geosweep.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct GeosweepAllocator {
    /// Pointer that both functions receive.
    pub user: *mut c_void,
    /// Allocates memory and writes the block to `memory`, which is all zero before the call. Returns
    /// `VK_SUCCESS` if it succeeds.
    pub allocate: Option<
        unsafe extern "C" fn(
            user: *mut c_void,
            request: *const GeosweepMemoryRequest,
            memory: *mut GeosweepMemory,
        ) -> vk::Result,
    >,
    /// Frees a block that `allocate` has returned.
    pub free: Option<unsafe extern "C" fn(user: *mut c_void, memory: *const GeosweepMemory)>,
}

/// Source of the memory for a solver's surfaces and other objects.
pub(super) enum Memory {
    /// The solver's own blocks.
    Own(Box<Allocator>),
    Hosts(HostsMemory),
}

/// Allocator of the program, and the blocks that it has allocated.
pub(super) struct HostsMemory {
    allocator: GeosweepAllocator,
    /// Blocks that were allocated and not freed yet. A block's number is its index here.
    given: Vec<Option<GeosweepMemory>>,
    bytes: u64,
}

// SAFETY: the program promises that any thread may call its functions, one at a time.
unsafe impl Send for HostsMemory {}

impl HostsMemory {
    pub(super) fn new(allocator: GeosweepAllocator) -> Result<Self, Failure> {
        for (function, is_there) in
            [("allocate", allocator.allocate.is_some()), ("free", allocator.free.is_some())]
        {
            if !is_there {
                return Err(Failure::argument(&format!("info->allocator->{function}"), "is null"));
            }
        }
        Ok(Self { allocator, given: Vec::new(), bytes: 0 })
    }
}

impl DeviceMemory for HostsMemory {
    fn allocate(&mut self, wanted: &MemoryRequest) -> Result<MemoryBlock, AllocationError> {
        let name = CString::new(wanted.name).expect("names in this library contain no zero byte");
        let [required, preferred] = wanted.properties();
        let requirements = wanted.requirements;
        let (is_buffer, name) = (wanted.is_buffer, name.as_ptr());
        let request = GeosweepMemoryRequest { requirements, required, preferred, is_buffer, name };
        let mut memory = GeosweepMemory {
            memory: vk::DeviceMemory::null(),
            offset: 0,
            mapped: null_mut(),
            handle: null_mut(),
        };
        let allocate = self.allocator.allocate.expect("the solver's creation has checked it");
        // SAFETY: the program's promise; both structs are alive.
        match unsafe { allocate(self.allocator.user, &request, &mut memory) } {
            vk::Result::SUCCESS => {}
            vk::Result::ERROR_OUT_OF_HOST_MEMORY | vk::Result::ERROR_OUT_OF_DEVICE_MEMORY => {
                return Err(AllocationError::OutOfMemory);
            }
            result => {
                let text = format!("your allocator has returned {result}");
                return Err(AllocationError::Internal(text));
            }
        }
        if memory.memory == vk::DeviceMemory::null() {
            return Err(AllocationError::Internal("your allocator has given no memory".into()));
        }
        let mapped = NonNull::new(memory.mapped.cast());
        let must_be_mapped = required.contains(vk::MemoryPropertyFlags::HOST_VISIBLE);
        let reason = if !memory.offset.is_multiple_of(requirements.alignment) {
            Some(
                "your allocator has given memory at an offset that is no multiple of the alignment",
            )
        } else if must_be_mapped && mapped.is_none() {
            Some(
                "your allocator has given memory that is not mapped, where the program reads or writes",
            )
        } else {
            None
        };
        let number = self.given.iter().position(Option::is_none).unwrap_or(self.given.len());
        if number == self.given.len() {
            self.given.push(None);
        }
        self.given[number] = Some(memory);
        self.bytes += requirements.size;
        let place = (memory.offset, requirements.size);
        let mapped = mapped.filter(|_| must_be_mapped);
        // SAFETY: the program's promise.
        let block = unsafe { MemoryBlock::new(memory.memory, place, mapped, number as u64) };
        match reason {
            None => Ok(block),
            Some(reason) => {
                self.free(block);
                Err(AllocationError::Internal(reason.into()))
            }
        }
    }

    fn free(&mut self, block: MemoryBlock) {
        let place = block.number().and_then(|number| self.given.get_mut(number as usize));
        let Some(memory) = place.and_then(Option::take) else { return };
        self.bytes -= block.size();
        let free = self.allocator.free.expect("the solver's creation has checked it");
        // SAFETY: the program's promise; the struct is alive.
        unsafe { free(self.allocator.user, &memory) };
    }
}

impl Memory {
    /// Returns the bytes that the solver holds.
    pub(super) fn bytes(&self) -> u64 {
        match self {
            Self::Own(allocator) => allocator.capacity(),
            Self::Hosts(memory) => memory.bytes,
        }
    }
}

impl DeviceMemory for Memory {
    fn allocate(&mut self, wanted: &MemoryRequest) -> Result<MemoryBlock, AllocationError> {
        match self {
            Self::Own(allocator) => DeviceMemory::allocate(&mut **allocator, wanted),
            Self::Hosts(memory) => memory.allocate(wanted),
        }
    }

    fn free(&mut self, block: MemoryBlock) {
        match self {
            Self::Own(allocator) => DeviceMemory::free(&mut **allocator, block),
            Self::Hosts(memory) => memory.free(block),
        }
    }
}

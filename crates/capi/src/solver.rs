//! Pipelines of a device, and the memory of all surfaces on it.

use std::sync::{Arc, Mutex};

use ash::vk;
use gpu_allocator::AllocationSizes;
use gpu_allocator::vulkan::{Allocator, AllocatorCreateDesc};

use super::arguments::{Output, list, optional, reference, write};
use super::choices::{ScheduleNumber, WavefrontNumber, choose};
use super::loader::{self, GetInstanceProcAddr};
use super::memory::{GeosweepAllocator, HostsMemory, Memory};
use super::objects::{hand_out, kind_of_object, object, take};
use super::shared::Shared;
use super::status::{Failure, calls};
use geosweep::vulkan::{Schedule, VulkanError, embed};

/// Version of this header, which `geosweep_solver_create` compares with the library's. It grows with each
/// change that makes programs compile or run differently.
pub const GEOSWEEP_HEADER_VERSION: u32 = 9;

/// Flag for `GeosweepSolverInfo::flags` that adds checks during development, at a small cost. With this flag,
/// it is an error to record for one of several slots while the slot's last recording has not run, to destroy
/// an object that such a recording uses, to write points that such a recording reads, and to use an object
/// that was destroyed. The library keeps a few bytes of each destroyed object for this. Each recording gets
/// one more fill and two more barriers.
pub const GEOSWEEP_SOLVER_CHECKS: u32 = 1;

/// Largest count of passes that is accepted. Only nine passes differ.
const MOST_PASSES: usize = 64;
/// Size in bytes of the first blocks of memory. A larger allocation gets its own block.
const BLOCK_BYTES: u64 = 4 << 20;

/// A schedule together with a wavefront.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct GeosweepPasses {
    /// Any schedule but `GEOSWEEP_SCHEDULE_BEST`.
    pub schedule: ScheduleNumber,
    /// The wavefront.
    pub wavefront: WavefrontNumber,
}

/// Parameters of a solver. All handles remain yours and must outlive the solver.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct GeosweepSolverInfo {
    /// `GEOSWEEP_HEADER_VERSION`.
    pub header_version: u32,
    /// The loader's `vkGetInstanceProcAddr` or your replacement of it. All Vulkan functions are found through
    /// it.
    pub get_instance_proc_addr: GetInstanceProcAddr,
    /// An instance created for Vulkan 1.1 or later.
    pub instance: vk::Instance,
    /// A physical device that `geosweep_check_device` accepts.
    pub physical_device: vk::PhysicalDevice,
    /// A device created on `physical_device`, with what `geosweep_requirements` returns.
    pub device: vk::Device,
    /// Schedules and wavefronts for which pipelines are created: those that plans will request. Compiling
    /// them takes a while.
    pub passes: *const GeosweepPasses,
    /// Number of entries in `passes`.
    pub pass_count: u32,
    /// Cache for creating pipelines, or null. You fill, save and destroy it. It must be alive whenever the
    /// solver creates pipelines: now, with the first surface that has a slowness or a small grid, and with
    /// the first contours, paths, regions (of each wavefront), directions and log map.
    /// `geosweep_solver_set_pipeline_cache` replaces or removes it. Pipelines do not need it once they are
    /// created. The solver uses it on one thread at a time. If you use it at the same time, the rules of
    /// `vkCreateComputePipelines` apply.
    pub pipeline_cache: vk::PipelineCache,
    /// `GEOSWEEP_SOLVER_CHECKS`, or 0.
    pub flags: u32,
    /// Your own allocator, or null for the solver's own blocks. The struct is not needed after the call.
    pub allocator: *const GeosweepAllocator,
}

kind_of_object! { GeosweepSolver, solver: Arc<Shared> }

/// Pipelines of a device, shared by all its surfaces. Any number of threads may use it at the same time.
pub struct GeosweepSolver(());

/// Creates the shared state of a solver.
///
/// # Safety
/// The handles are null or alive and belong together.
unsafe fn shared(info: &GeosweepSolverInfo) -> Result<Shared, Failure> {
    let GeosweepSolverInfo { header_version, physical_device, .. } = *info;
    if header_version != GEOSWEEP_HEADER_VERSION {
        let reason = format!(
            "is {header_version}, and this library was built with header \
             {GEOSWEEP_HEADER_VERSION}: compile with the library's own geosweep.h"
        );
        return Err(Failure::argument("info->header_version", reason));
    }
    // SAFETY: the caller's promise.
    let (instance, device, asked) = unsafe {
        let get = info.get_instance_proc_addr;
        let instance = loader::instance(get, info.instance, physical_device)?;
        let device = loader::device(&instance, info.device)?;
        let count = info.pass_count;
        (instance, device, list(info.passes, count, MOST_PASSES, "info->passes")?)
    };
    let mut passes = Vec::new();
    for (index, asked) in asked.iter().enumerate() {
        let name = |field| format!("info->passes[{index}].{field}");
        let schedule =
            choose::<Option<Schedule>>(asked.schedule, &name("schedule"))?.ok_or_else(|| {
                let reason = "is GEOSWEEP_SCHEDULE_BEST, which depends on the grid: name others";
                Failure::argument(&name("schedule"), reason)
            })?;
        passes.push((schedule, choose(asked.wavefront, &name("wavefront"))?));
    }
    if info.flags & !GEOSWEEP_SOLVER_CHECKS != 0 {
        let reason = format!("is {:#x}, and has bits that mean nothing", info.flags);
        return Err(Failure::argument("info->flags", reason));
    }
    let checks = info.flags & GEOSWEEP_SOLVER_CHECKS != 0;
    // SAFETY: the caller's promise.
    let of_host = unsafe { optional(info.allocator, "info->allocator") }?;
    let of_host = of_host.map(|&allocator| HostsMemory::new(allocator)).transpose()?;
    // SAFETY: the caller's promise.
    let labels = unsafe { loader::has_labels(info.get_instance_proc_addr, &instance, &device) };
    let tools = embed::Tools { labels, checks, ..embed::Tools::default() };
    let cache = info.pipeline_cache;
    let mut solver =
        embed::Solver::with_cache(&instance, physical_device, &device, &passes, tools, cache)?;
    let of_its_own = || {
        Allocator::new(&AllocatorCreateDesc {
            instance: instance.clone(),
            device: device.clone(),
            physical_device,
            debug_settings: Default::default(),
            buffer_device_address: false,
            allocation_sizes: AllocationSizes::new(BLOCK_BYTES, BLOCK_BYTES),
        })
    };
    let memory = match of_host {
        Some(memory) => Ok(Memory::Hosts(memory)),
        None => of_its_own().map(|allocator| Memory::Own(Box::new(allocator))),
    };
    match memory {
        Ok(memory) => {
            let allocator = Mutex::new(memory);
            Ok(Shared { instance, physical_device, device, solver, allocator, checks })
        }
        Err(source) => {
            solver.destroy(&device);
            Err(VulkanError::Allocation { what: "the allocator", source }.into())
        }
    }
}

calls! {
    /// Creates a solver. `geosweep_solver_destroy` destroys it.
    fn geosweep_solver_create(info: *const GeosweepSolverInfo, solver: *mut *mut GeosweepSolver) {
        let output = Output::new(solver, "solver")?;
        hand_out(output, Arc::new(shared(reference(info, "info")?)?));
    }

    /// Sets the cache for creating pipelines from now on, or none if it is null. `GeosweepSolverInfo` documents
    /// how it is used.
    fn geosweep_solver_set_pipeline_cache(solver: *const GeosweepSolver, cache: vk::PipelineCache) {
        object(solver)?.solver.set_pipeline_cache(cache);
    }

    /// Returns the bytes of device memory that the solver holds for its surfaces, contours, paths, regions,
    /// directions and log maps. Since it allocates them in blocks, they are a little more than the sum of what
    /// `geosweep_surface_bytes` and the similar calls return.
    fn geosweep_solver_bytes(solver: *const GeosweepSolver, bytes: *mut u64) {
        write(bytes, "bytes", object(solver)?.allocator().bytes())?;
    }

    /// Destroys a solver. Its surfaces, plans, contours, paths, regions, directions, log maps and profiles must
    /// be destroyed first; otherwise the call fails. Null is allowed.
    fn geosweep_solver_destroy(solver: *mut GeosweepSolver) {
        let check = |shared: &Arc<Shared>| match Arc::strong_count(shared) - 1 {
            0 => Ok(()),
            others => {
                let reason = format!(
                    "still has {others} surfaces, plans, contours, paths, regions, directions, log maps or \
                     profiles: destroy them first"
                );
                Err(Failure::argument("solver", reason))
            }
        };
        let shared = take(solver, check)?.and_then(Arc::into_inner);
        if let Some(Shared { device, mut solver, allocator, .. }) = shared {
            solver.destroy(&device);
            // This frees the solver's own blocks.
            drop(allocator);
        }
    }
}

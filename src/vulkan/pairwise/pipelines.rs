//! Makes the pipelines for the maps of a batch.

use super::layout::{BatchLayout, Workgroup};
use crate::vulkan::VulkanError;
use crate::vulkan::device::passes::{
    KnownSize, MapSize, PAIRWISE_COUNT, PAIRWISE_EXCHANGE, PAIRWISE_FANS, PAIRWISE_SCANS,
    PAIRWISE_SHARED, PAIRWISE_START, Variant,
};
use crate::vulkan::device::pipelines::{InUse, Pipeline, Pipelines};
use crate::vulkan::device::shaders::{
    pairwise_count, pairwise_exchange, pairwise_fans, pairwise_scan, pairwise_shared,
    pairwise_start,
};

/// Pipelines of a batch, which depend on the memory that holds its maps.
#[derive(Debug)]
pub(super) enum BatchPipelines {
    SharedMemory {
        /// Pipeline that arranges the surface's fans.
        fans: Pipeline<pairwise_fans::Push>,
        maps: Pipeline<pairwise_shared::Push>,
        /// Guard that keeps the pipeline `maps` alive. That pipeline is made for one size of maps, or for the
        /// room that maps take in shared memory.
        _in_use: InUse,
    },
    Images {
        start: Pipeline<pairwise_start::Push>,
        /// Pipelines of the scans, in the order of an iteration.
        scans: [Pipeline<pairwise_scan::Push>; 4],
        count: Pipeline<pairwise_count::Push>,
        /// Pipeline that exchanges fronts between copies of points, if the surface is glued.
        exchange: Option<Pipeline<pairwise_exchange::Push>>,
    },
}

impl BatchPipelines {
    /// Makes the pipelines that do not exist yet. The pipeline of exchanges is among them if the surface
    /// `is_glued`.
    pub(super) fn new(
        device: &ash::Device,
        pipelines: &Pipelines,
        layout: &BatchLayout,
        variant: Variant,
        is_glued: bool,
    ) -> Result<Self, VulkanError> {
        let wavefront = layout.wavefront;
        if let Some(workgroup) = layout.workgroup {
            let Workgroup { room, invocations, pitch, iterations, is_known } = workgroup;
            let [rows, cols] = [layout.chart.rows, layout.chart.cols].map(|points| points as u32);
            let known = match is_known {
                true => KnownSize { rows, cols, pitch, iterations },
                false => KnownSize::default(),
            };
            let size = MapSize { room, invocations, known };
            let fans = pipelines.make(device, PAIRWISE_FANS, wavefront)?;
            let (maps, _in_use) = pipelines.make_sized(device, PAIRWISE_SHARED, wavefront, size)?;
            return Ok(Self::SharedMemory { fans, maps, _in_use });
        }
        let [down, up, right, left] = PAIRWISE_SCANS;
        let scan = |pass| pipelines.make(device, pass, variant);
        Ok(Self::Images {
            start: pipelines.make(device, PAIRWISE_START, wavefront)?,
            scans: [scan(down)?, scan(up)?, scan(right)?, scan(left)?],
            count: pipelines.make(device, PAIRWISE_COUNT, wavefront)?,
            exchange: match is_glued {
                true => Some(pipelines.make(device, PAIRWISE_EXCHANGE, wavefront)?),
                false => None,
            },
        })
    }
}

#[cfg(test)]
mod tests {
    use std::ffi::{CStr, c_void};
    use std::sync::OnceLock;
    use std::sync::atomic::{AtomicU32, Ordering};

    use ash::vk;

    use crate::surface::{Spacing, Surface};
    use crate::update::Wavefront;
    use crate::vulkan::headless::context::Context;
    use crate::vulkan::headless::testing;
    use crate::vulkan::{HeadlessSolver, PairwiseSchedule};

    static REAL: OnceLock<vk::PFN_vkCreateComputePipelines> = OnceLock::new();
    static MADE: AtomicU32 = AtomicU32::new(0);

    /// Counts the pipelines, and lets the driver create them.
    unsafe extern "system" fn create_and_count(
        device: vk::Device,
        cache: vk::PipelineCache,
        count: u32,
        infos: *const vk::ComputePipelineCreateInfo<'_>,
        allocator: *const vk::AllocationCallbacks<'_>,
        pipelines: *mut vk::Pipeline,
    ) -> vk::Result {
        MADE.fetch_add(count, Ordering::Relaxed);
        let create = REAL.get().expect("it was set before");
        // SAFETY: the arguments are the caller's.
        unsafe { create(device, cache, count, infos, allocator, pipelines) }
    }

    /// Returns a solver whose pipelines are counted.
    fn counted() -> HeadlessSolver {
        let mut context = Context::new(&testing::device(), true).unwrap();
        REAL.get_or_init(|| context.device.fp_v1_0().create_compute_pipelines);
        let get = context.instance.handle.fp_v1_0().get_device_proc_addr;
        let handle = context.device.handle();
        let load = |name: &CStr| {
            if name == c"vkCreateComputePipelines" {
                return create_and_count as *const c_void;
            }
            // SAFETY: the device is alive, and each function is called with the type that belongs to its
            // name.
            unsafe {
                std::mem::transmute::<vk::PFN_vkVoidFunction, *const c_void>(get(
                    handle,
                    name.as_ptr(),
                ))
            }
        };
        // SAFETY: each function is the device's own or behaves like it.
        context.device = unsafe { ash::Device::load_with(load, handle) };
        HeadlessSolver::with(context).unwrap()
    }

    /// Checks that a second matrix of the same size creates no pipelines, and that one of another size creates at most
    /// the one for maps in shared memory. Of the pipelines for maps in shared memory, a limited number stays, and those
    /// in use always stay.
    #[test]
    fn matrices_share_the_pipelines_of_the_device() {
        let solver = counted();
        assert!(MADE.swap(0, Ordering::Relaxed) > 0, "those of every surface");
        let flat = |rows: usize, cols: usize| {
            Surface::from_heights(rows, cols, vec![0.0; rows * cols], Spacing::square(1.0)).unwrap()
        };
        let made_for = |surface: &Surface, wavefront, schedule| {
            let on_device = solver.upload(surface).unwrap();
            drop(solver.pairwise(&on_device, wavefront, Some(schedule)).unwrap());
            MADE.swap(0, Ordering::Relaxed)
        };
        for schedule in [PairwiseSchedule::SharedMemory, PairwiseSchedule::Images] {
            for wavefront in Wavefront::FOR_ANY_SURFACE {
                assert!(made_for(&flat(20, 30), wavefront, schedule) > 0, "{schedule}");
                assert_eq!(made_for(&flat(20, 30), wavefront, schedule), 0, "{schedule}");
            }
            let of_another_size = made_for(&flat(29, 17), Wavefront::Curved, schedule);
            let is_sized = schedule == PairwiseSchedule::SharedMemory;
            assert_eq!(of_another_size, u32::from(is_sized), "{schedule}");
        }
        let shared = PairwiseSchedule::SharedMemory;
        let kept = flat(3, 3);
        let on_device = solver.upload(&kept).unwrap();
        let in_use = solver.pairwise(&on_device, Wavefront::Planar, Some(shared)).unwrap();
        MADE.store(0, Ordering::Relaxed);
        for cols in 4..30 {
            assert!(made_for(&flat(3, cols), Wavefront::Planar, shared) > 0, "{cols}");
        }
        assert_eq!(made_for(&kept, Wavefront::Planar, shared), 0, "it is in use");
        assert_eq!(made_for(&flat(3, 29), Wavefront::Planar, shared), 0, "it is the last");
        assert_eq!(made_for(&flat(3, 4), Wavefront::Planar, shared), 1, "it was dropped");
        drop(in_use);
        solver.context.check_validation().unwrap();
    }
}

//! Pipeline caches of the program, through the functions of C.

use std::ffi::CStr;
use std::sync::{Mutex, OnceLock};

use geosweep::ash::vk::{self, Handle};
use geosweep_capi::*;

use crate::host::Host;
use crate::session::{
    Replacement, Session, frame, height_points, method, ok, replaced, solver_info, surface_info,
};

static CREATE: OnceLock<vk::PFN_vkCreateComputePipelines> = OnceLock::new();
/// The cache with which each pipeline was created, in the order of creation.
static CACHES: Mutex<Vec<vk::PipelineCache>> = Mutex::new(Vec::new());

unsafe extern "system" fn create_and_note(
    device: vk::Device,
    cache: vk::PipelineCache,
    count: u32,
    infos: *const vk::ComputePipelineCreateInfo<'_>,
    allocator: *const vk::AllocationCallbacks<'_>,
    pipelines: *mut vk::Pipeline,
) -> vk::Result {
    CACHES.lock().unwrap().extend((0..count).map(|_| cache));
    unsafe { (CREATE.get().unwrap())(device, cache, count, infos, allocator, pipelines) }
}

struct Noting;

impl Replacement for Noting {
    fn of_device(name: &CStr) -> Option<vk::PFN_vkVoidFunction> {
        // SAFETY: the function is called with the type of its name.
        (name == c"vkCreateComputePipelines").then(|| unsafe {
            std::mem::transmute::<vk::PFN_vkCreateComputePipelines, vk::PFN_vkVoidFunction>(
                create_and_note,
            )
        })
    }
}

fn made_with() -> Vec<vk::PipelineCache> {
    std::mem::take(&mut CACHES.lock().unwrap())
}

/// A program fills a cache, saves it, and starts again with the saved one. Pipelines are created with the
/// cache that the solver has at that time. Both runs give the same map.
#[test]
fn a_saved_cache_serves_the_next_solver() {
    let mut host = Host::new();
    let device = host.device.clone();
    CREATE.get_or_init(|| device.fp_v1_0().create_compute_pipelines);
    let properties = unsafe { host.instance.get_physical_device_properties(host.physical_device) };
    let heights: Vec<f32> = (0..9 * 12).map(|point| (0.3 * point as f32).sin()).collect();
    let points = [height_points(&heights)];

    let (mut saved, mut runs) = (Vec::new(), Vec::new());
    for _ in 0..2 {
        let info = vk::PipelineCacheCreateInfo::default().initial_data(&saved);
        let cache = unsafe { device.create_pipeline_cache(&info, None) }.unwrap();
        let info = GeosweepSolverInfo {
            get_instance_proc_addr: Some(replaced::<Noting>),
            pipeline_cache: cache,
            ..solver_info(&host)
        };
        let mut solver = std::ptr::null_mut();
        ok(unsafe { geosweep_solver_create(&info, &mut solver) });
        let of_solver = made_with();
        assert!(!of_solver.is_empty() && of_solver.iter().all(|&with| with == cache));

        let mut session = Session { host, solver };
        let surface = session.surface(&surface_info(9, 12, &points));
        assert_eq!(made_with(), [], "surfaces make none");
        // The cache is taken away before the contours' pipelines are created, and given back before the paths'
        // pipelines are created.
        let (mut contours, mut paths) = (std::ptr::null_mut(), std::ptr::null_mut());
        let null = vk::PipelineCache::null();
        ok(unsafe { geosweep_solver_set_pipeline_cache(solver, null) });
        ok(unsafe { geosweep_contours_create(surface, 100, &mut contours) });
        let of_contours = made_with();
        assert!(!of_contours.is_empty() && of_contours.iter().all(|with| with.is_null()));
        ok(unsafe { geosweep_solver_set_pipeline_cache(solver, cache) });
        ok(unsafe { geosweep_paths_create(surface, 1, 100, &mut paths) });
        let of_paths = made_with();
        assert!(!of_paths.is_empty() && of_paths.iter().all(|&with| with == cache));

        saved = unsafe { device.get_pipeline_cache_data(cache) }.unwrap();
        // The cache's header names the device. The driver decides what follows it.
        let [vendor, of_device] = [8, 12].map(|at| {
            u32::from_ne_bytes(saved[at..at + 4].try_into().expect("the header has 32 bytes"))
        });
        assert_eq!((vendor, of_device), (properties.vendor_id, properties.device_id));
        assert_eq!(saved[16..32], properties.pipeline_cache_uuid);
        // The pipelines no longer need the cache.
        unsafe { device.destroy_pipeline_cache(cache, None) };

        let plan = session.plan(9, 12, &method(GeosweepWavefront::Curved, 50));
        let map = session.map(surface, &frame(plan, &[geosweep_source_at(4.0, 3.5)]));
        runs.push((of_solver.len(), of_contours.len(), of_paths.len(), map));
        unsafe {
            ok(geosweep_contours_destroy(contours));
            ok(geosweep_paths_destroy(paths));
            ok(geosweep_surface_destroy(surface));
            ok(geosweep_plan_destroy(plan));
            ok(geosweep_solver_destroy(solver));
        }
        host = session.host;
    }
    assert!(runs[0] == runs[1], "other pipelines or another map");
    assert!(runs[0].3.iter().all(|distance| distance.is_finite()));
    assert_eq!((host.messages(), host.allocations()), (Vec::new(), 0));
}

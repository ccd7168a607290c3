//! Pipelines of a device: created once, with the host's cache if it has one.

use std::ffi::{CStr, c_void};
use std::sync::OnceLock;
use std::sync::atomic::{AtomicU32, AtomicU64, Ordering};

use ash::vk::{self, Handle};
use geosweep::Wavefront;
use geosweep::surface::Chart;
use geosweep::vulkan::Schedule;
use geosweep::vulkan::embed::{
    PathsInfo, PointKind, PointMemory, Points, Solver, SurfaceInfo, Tools,
};

use crate::host::Host;

static REAL: OnceLock<vk::PFN_vkCreateComputePipelines> = OnceLock::new();
static MADE: AtomicU32 = AtomicU32::new(0);
static MADE_BY_CACHE: AtomicU32 = AtomicU32::new(0);
/// The host's cache.
static CACHE: AtomicU64 = AtomicU64::new(0);

/// Counts the call and passes it to the driver.
unsafe extern "system" fn create_and_count(
    device: vk::Device,
    cache: vk::PipelineCache,
    count: u32,
    infos: *const vk::ComputePipelineCreateInfo<'_>,
    allocator: *const vk::AllocationCallbacks<'_>,
    pipelines: *mut vk::Pipeline,
) -> vk::Result {
    MADE.fetch_add(count, Ordering::Relaxed);
    if !cache.is_null() {
        assert_eq!(cache.as_raw(), CACHE.load(Ordering::Relaxed), "another cache");
        MADE_BY_CACHE.fetch_add(count, Ordering::Relaxed);
    }
    unsafe { REAL.get().unwrap()(device, cache, count, infos, allocator, pipelines) }
}

fn made() -> [u32; 2] {
    [&MADE, &MADE_BY_CACHE].map(|count| count.swap(0, Ordering::Relaxed))
}

/// Contours, paths and regions of further surfaces create no pipeline, with or without a cache. All pipelines are
/// created with the cache that the solver has at that time.
#[test]
fn pipelines_are_made_once_and_by_the_hosts_cache() {
    let mut host = Host::new();
    REAL.get_or_init(|| host.device.fp_v1_0().create_compute_pipelines);
    let device = host.device_with(|name: &CStr| {
        (name == c"vkCreateComputePipelines").then(|| unsafe {
            std::mem::transmute::<*const c_void, extern "system" fn() -> vk::Result>(
                create_and_count as *const c_void,
            )
        })
    });
    let info = vk::PipelineCacheCreateInfo::default();
    let cache = unsafe { device.create_pipeline_cache(&info, None) }.unwrap();
    CACHE.store(cache.as_raw(), Ordering::Relaxed);
    let chart = Chart { rows: 9, cols: 12 };
    let points = host.buffer_of(&[0.0; 9 * 12]);
    let memory = PointMemory::Buffer { buffer: points.handle, offset: 0, stride: 4 };
    let kind = PointKind::Heights(geosweep::Spacing::square(1.0));
    let points_of = [Points { memory, kind, slowness: None }];
    let surface_info = SurfaceInfo::new(chart).with_points(&points_of);

    let passes = [(Schedule::Raster, Wavefront::Curved)];
    let (instance, physical_device) = (host.instance.clone(), host.physical_device);
    let tools = Tools::default();
    let mut solver =
        Solver::with_cache(&instance, physical_device, &device, &passes, tools, cache).unwrap();
    // These are the pipelines of every surface, of four scans and of the surroundings of sources.
    assert_eq!(made(), [18 + 4 + 1; 2]);
    solver.add_passes(&device, Schedule::Raster, Wavefront::Curved).unwrap();
    solver.add_passes(&device, Schedule::Raster, Wavefront::Anchored).unwrap();
    assert_eq!(made(), [0; 2]);
    solver.add_passes(&device, Schedule::Tiles, Wavefront::Planar).unwrap();
    assert_eq!(made(), [1; 2]);

    let allocator = host.allocator();
    let mut all = Vec::new();
    for number in 0..3 {
        // From the third surface on, the solver no longer has a cache.
        if number == 2 {
            solver.set_pipeline_cache(vk::PipelineCache::null());
        }
        let surface = solver.surface(&device, allocator, &surface_info).unwrap();
        assert_eq!(made(), [0; 2]);
        let first = |count: u32| [if number == 0 { count } else { 0 }; 2];
        let contours = solver.contours(&device, allocator, &surface, 100).unwrap();
        // The count includes the pipeline that lifts contours.
        assert_eq!(made(), first(3 + 1));
        let info = PathsInfo::new(1, 10);
        let paths = solver.paths(&device, allocator, &surface, info).unwrap();
        assert_eq!(made(), first(2));
        let regions = solver.regions(&device, allocator, &surface, Wavefront::Curved).unwrap();
        assert_eq!(made(), first(4));
        all.push((surface, contours, paths, regions));
    }
    // Two of these pipelines depend on the wavefront.
    let regions = solver.regions(&device, allocator, &all[0].0, Wavefront::Planar);
    let [count, by_cache] = made();
    assert!((1..4).contains(&count) && by_cache == 0, "{count}, {by_cache}");

    regions.unwrap().destroy(&device, allocator);
    for (mut surface, mut contours, mut paths, mut regions) in all {
        contours.destroy(&device, allocator);
        paths.destroy(&device, allocator);
        regions.destroy(&device, allocator);
        surface.destroy(&device, allocator);
    }
    solver.destroy(&device);
    unsafe { device.destroy_pipeline_cache(cache, None) };
    host.free(points);
    assert_eq!(host.messages(), Vec::<String>::new());
}

/// A plan returns the wavefront of its maps. It is curved if anchored fronts are requested, since it cannot be known
/// whether fronts on a surface whose points are on the device can have anchors.
#[test]
fn plans_name_the_wavefront_of_their_maps() {
    let host = Host::without_validation();
    let passes = [(Schedule::Raster, Wavefront::Anchored), (Schedule::Raster, Wavefront::Planar)];
    let (instance, physical_device) = (&host.instance, host.physical_device);
    let mut solver = Solver::new(instance, physical_device, &host.device, &passes).unwrap();
    let stop = geosweep::Stop::within(1e-6).or_after(10);
    for (asked, resolved) in
        [(Wavefront::Anchored, Wavefront::Curved), (Wavefront::Planar, Wavefront::Planar)]
    {
        let method = geosweep::vulkan::Method::new(asked, stop);
        let plan = solver.plan(Chart { rows: 5, cols: 5 }, method, 2).unwrap();
        assert_eq!((plan.wavefront(), plan.schedule()), (resolved, Schedule::Raster));
    }
    solver.destroy(&host.device);
}

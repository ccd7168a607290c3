//! Solvers that are created while a renderer runs: again with a filled cache, and on another thread.

use std::collections::HashMap;
use std::ffi::c_void;
use std::hash::{DefaultHasher, Hash, Hasher};
use std::slice::from_raw_parts;
use std::sync::{Mutex, OnceLock};

use geosweep::Wavefront;
use geosweep::ash::{
    self,
    vk::{self, Handle},
};
use geosweep::surface::Chart;
use geosweep::vulkan::Schedule;
use geosweep::vulkan::embed::{self, PathsInfo, Points, SourceInput, SurfaceInfo, Tools};

use crate::embed::stage::{Stage, source, vertices};
use crate::host::Host;

const CHART: Chart = Chart { rows: 33, cols: 40 };
const PASSES: [(Schedule, Wavefront); 2] =
    [(Schedule::Raster, Wavefront::Curved), (Schedule::Tiles, Wavefront::Planar)];

static REAL: OnceLock<ash::Device> = OnceLock::new();
/// Contents of modules, by their handles.
static CONTENTS: Mutex<Option<HashMap<u64, u64>>> = Mutex::new(None);
/// Contents of pipelines, in the order of their creation, with their caches.
static PIPELINES: Mutex<Vec<(u64, vk::PipelineCache)>> = Mutex::new(Vec::new());

fn hash(of: impl Hash) -> u64 {
    let mut hasher = DefaultHasher::new();
    of.hash(&mut hasher);
    hasher.finish()
}

fn note(handle: u64, contents: u64) {
    CONTENTS.lock().unwrap().get_or_insert_default().insert(handle, contents);
}

fn contents(handle: u64) -> u64 {
    CONTENTS.lock().unwrap().as_ref().unwrap()[&handle]
}

type Callbacks<'a> = *const vk::AllocationCallbacks<'a>;

unsafe extern "system" fn module(
    device: vk::Device,
    info: *const vk::ShaderModuleCreateInfo<'_>,
    callbacks: Callbacks<'_>,
    made: *mut vk::ShaderModule,
) -> vk::Result {
    unsafe {
        let real = REAL.get().unwrap().fp_v1_0().create_shader_module;
        let result = real(device, info, callbacks, made);
        note((*made).as_raw(), hash(from_raw_parts((*info).p_code, (*info).code_size / 4)));
        result
    }
}

unsafe extern "system" fn pipelines(
    device: vk::Device,
    cache: vk::PipelineCache,
    count: u32,
    infos: *const vk::ComputePipelineCreateInfo<'_>,
    callbacks: Callbacks<'_>,
    made: *mut vk::Pipeline,
) -> vk::Result {
    unsafe {
        for info in from_raw_parts(infos, count as usize) {
            let constants = &*info.stage.p_specialization_info;
            let data = from_raw_parts(constants.p_data.cast::<u8>(), constants.data_size);
            let entries = constants.map_entry_count as usize;
            let entries = match entries {
                0 => &[],
                _ => from_raw_parts(constants.p_map_entries, entries),
            };
            let of = |e: &vk::SpecializationMapEntry| (e.constant_id, e.offset, e.size);
            let entries: Vec<_> = entries.iter().map(of).collect();
            let module = contents(info.stage.module.as_raw());
            let contents = hash((module, info.flags, entries, data));
            PIPELINES.lock().unwrap().push((contents, cache));
        }
        let real = REAL.get().unwrap().fp_v1_0().create_compute_pipelines;
        real(device, cache, count, infos, callbacks, made)
    }
}

/// A second solver with the same cache makes, with all objects that it creates, exactly the pipelines that the
/// first solver has put into the cache. So a driver that keeps pipelines in its cache compiles nothing. Drivers
/// need not report whether they compile, and lavapipe keeps no pipelines.
#[test]
fn a_second_solver_makes_nothing_that_the_cache_does_not_hold() {
    let mut host = Host::without_validation();
    REAL.get_or_init(|| host.device.clone());
    let device = host.device_with(|name| {
        let own = match name.to_bytes() {
            b"vkCreateShaderModule" => module as *const c_void,
            b"vkCreateComputePipelines" => pipelines as *const c_void,
            _ => return None,
        };
        // SAFETY: the function is called with the type of its name.
        Some(unsafe {
            std::mem::transmute::<*const c_void, extern "system" fn() -> vk::Result>(own)
        })
    });
    let points = host.buffer_of(&vertices(CHART, 0.3));
    let inputs = [Points::positions(points.handle, 32)];
    let info = SurfaceInfo::new(CHART).with_points(&inputs);
    let cache_info = vk::PipelineCacheCreateInfo::default();
    let cache = unsafe { device.create_pipeline_cache(&cache_info, None) }.unwrap();
    let (instance, physical_device) = (host.instance.clone(), host.physical_device);
    let mut runs = Vec::new();
    for _ in 0..2 {
        let tools = Tools::default();
        let solver =
            embed::Solver::with_cache(&instance, physical_device, &device, &PASSES, tools, cache);
        let mut solver = solver.unwrap();
        let allocator = host.allocator();
        let mut surface = solver.surface(&device, allocator, &info).unwrap();
        let mut contours = solver.contours(&device, allocator, &surface, 100).unwrap();
        let paths = PathsInfo::new(1, 10);
        let mut paths = solver.paths(&device, allocator, &surface, paths).unwrap();
        let mut regions = solver.regions(&device, allocator, &surface, Wavefront::Curved).unwrap();
        contours.destroy(&device, allocator);
        paths.destroy(&device, allocator);
        regions.destroy(&device, allocator);
        surface.destroy(&device, allocator);
        solver.destroy(&device);
        runs.push(std::mem::take(&mut *PIPELINES.lock().unwrap()));
    }
    let [first, second] = &mut runs[..] else { unreachable!("there were two") };
    assert!(first.len() > 25, "{}", first.len());
    assert!(first.iter().chain(&*second).all(|&(_, by)| by == cache));
    for made in [&mut *first, second] {
        made.sort_unstable_by_key(|&(contents, _)| contents);
    }
    assert_eq!(first, second);
    // No pipeline is compiled twice.
    first.dedup();
    assert_eq!(first.len(), second.len());
    unsafe { device.destroy_pipeline_cache(cache, None) };
    host.free(points);
}

/// A solver that is created on another thread gives the same maps as the solver that is in use. Both fill the
/// same cache at the same time. The validation layers check the use of threads too.
#[test]
fn a_solver_is_made_on_another_thread_while_frames_go_on() {
    let mut host = Host::new();
    let points = host.buffer_of(&vertices(CHART, 0.3));
    let inputs = [Points::positions(points.handle, 32)];
    let info = SurfaceInfo::new(CHART).with_points(&inputs);
    let device = host.device.clone();
    let cache_info = vk::PipelineCacheCreateInfo::default();
    let cache = unsafe { device.create_pipeline_cache(&cache_info, None) }.unwrap();
    let mut stage = Stage::new(host, &PASSES[..1], &info);
    stage.solver.set_pipeline_cache(cache);
    let plan = stage.plan(Schedule::Raster, Wavefront::Curved, 8);
    let source = source(12.25, 20.5);
    let (instance, physical_device) = (stage.host.instance.clone(), stage.host.physical_device);
    let (made, frames) = std::thread::scope(|threads| {
        let (device, instance) = (&device, &instance);
        let made = threads.spawn(move || {
            let tools = Tools::default();
            embed::Solver::with_cache(instance, physical_device, device, &PASSES, tools, cache)
        });
        let mut frames = vec![stage.map(0, SourceInput::Inline(&source), &plan)];
        // This thread creates pipelines with the same cache.
        stage.solver.add_passes(device, Schedule::Raster, Wavefront::Planar).unwrap();
        while frames.len() < 2 || !made.is_finished() {
            frames.push(stage.map(0, SourceInput::Inline(&source), &plan));
        }
        (made.join().unwrap().unwrap(), frames)
    });
    assert!(frames.iter().all(|frame| *frame == frames[0]), "frames differ");
    let mut first = std::mem::replace(&mut stage.solver, made);
    // The surface moves to the new solver, whose layouts are the same.
    let mut surface = stage.solver.surface(&device, stage.host.allocator(), &info).unwrap();
    std::mem::swap(&mut surface, &mut stage.surface);
    stage.host.run(|commands| stage.solver.record(&device, commands, &stage.surface).prepare());
    let plan = stage.plan(Schedule::Raster, Wavefront::Curved, 8);
    assert!(stage.map(0, SourceInput::Inline(&source), &plan) == frames[0], "another map");
    surface.destroy(&device, stage.host.allocator());
    first.destroy(&device);
    stage.solver.set_pipeline_cache(vk::PipelineCache::null());
    unsafe { device.destroy_pipeline_cache(cache, None) };
    stage.end([points]);
}

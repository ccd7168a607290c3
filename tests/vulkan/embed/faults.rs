//! Errors: devices that lack something, calls that fail, memory that is left, and bad input.

use std::ffi::CStr;

use geosweep::ash::{self, vk};
use geosweep::surface::{Chart, SourceError};
use geosweep::vulkan::embed::{
    self, Access, Frame, Lookup, PathsInfo, PointKind, PointMemory, PointSource, Points, Reader,
    Recording, SourceBuffer, SourceInput, SurfaceInfo,
};
use geosweep::vulkan::{Method, Schedule, VulkanError, requirements};
use geosweep::{Spacing, Wavefront};

use crate::embed::stage::{RASTER, STOP, Stage, source, vertices};
use crate::host::{self, Host};

const CHART: Chart = Chart { rows: 9, cols: 13 };

extern "system" fn out_of_memory() -> vk::Result {
    vk::Result::ERROR_OUT_OF_DEVICE_MEMORY
}

extern "system" fn lost() -> vk::Result {
    vk::Result::ERROR_DEVICE_LOST
}

/// The function that the test replaces. The replacement calls it first.
static PROPERTIES: std::sync::OnceLock<vk::PFN_vkGetPhysicalDeviceProperties> =
    std::sync::OnceLock::new();

unsafe extern "system" fn little(
    physical_device: vk::PhysicalDevice,
    properties: *mut vk::PhysicalDeviceProperties,
) {
    let ask = PROPERTIES.get().expect("it was set before this function was installed");
    unsafe {
        ask(physical_device, properties);
        let properties = &mut *properties;
        properties.api_version = vk::API_VERSION_1_0;
        properties.limits.max_compute_work_group_invocations = 32;
        // Each limit is one less than Vulkan guarantees.
        properties.limits.max_per_stage_descriptor_storage_images = 3;
        properties.limits.max_per_stage_descriptor_storage_buffers = 3;
        properties.limits.max_compute_work_group_count[1] = 65_534;
        properties.limits.max_compute_work_group_size[0] = 127;
        properties.limits.max_compute_shared_memory_size = 16_383;
        properties.limits.max_bound_descriptor_sets = 2;
    }
}

extern "system" fn no_format() -> vk::Result {
    vk::Result::ERROR_FORMAT_NOT_SUPPORTED
}

/// Requirements that a device lacks can be asked for before it is created. The error of a solver for it names them too.
#[test]
fn all_that_a_device_lacks_is_named() {
    let host = Host::without_validation();
    let real = host.instance.fp_v1_0();
    PROPERTIES.set(real.get_physical_device_properties).expect("no other test sets it");
    let entry = unsafe { ash::Entry::load() }.unwrap();
    let lesser = unsafe {
        let handle = host.instance.handle();
        let load = |name: &CStr| match name.to_bytes() {
            b"vkGetPhysicalDeviceProperties" => little as *const std::ffi::c_void,
            b"vkGetPhysicalDeviceImageFormatProperties" => no_format as *const std::ffi::c_void,
            _ => std::mem::transmute::<vk::PFN_vkVoidFunction, *const std::ffi::c_void>(
                entry.get_instance_proc_addr(handle, name.as_ptr()),
            ),
        };
        ash::Instance::load_with(load, handle)
    };
    let unmet = requirements::unmet(&lesser, host.physical_device);
    for (word, needed) in [
        ("Vulkan 1.0", "1.1"),
        ("32 invocations", "128"),
        ("127 invocations wide", "128"),
        ("16383 bytes", "16384"),
        ("65534 workgroups", "65535"),
        ("2 descriptor sets", "3"),
        ("3 storage images", "4"),
        ("3 storage buffers", "4"),
        ("four 32-bit floats", ""),
        ("one 32-bit float", ""),
    ] {
        let named = |entry: &String| entry.contains(word) && entry.contains(needed);
        assert_eq!(unmet.iter().filter(|entry| named(entry)).count(), 1, "{word}: {unmet:?}");
    }
    assert_eq!(unmet.len(), 10, "{unmet:?}");
    let error = embed::Solver::new(&lesser, host.physical_device, &host.device, &RASTER);
    let error = error.unwrap_err();
    assert!(matches!(&error, VulkanError::Unusable { .. }), "{error}");
    assert!(unmet.iter().all(|entry| error.to_string().contains(entry)), "{error}");
}

/// Each call that creates something fails once. The error names the call, and nothing is left behind.
#[test]
fn calls_that_fail_are_errors_and_leave_nothing_behind() {
    let mut host = Host::without_validation();
    let points = host.buffer_of(&vertices(CHART, 0.0));
    let inputs = [Points::positions(points.handle, 32)];
    let info = SurfaceInfo::new(CHART).with_slots(2).with_points(&inputs);
    let held = host.allocations();
    let device = host.device.clone();
    let new = |device: &ash::Device| {
        embed::Solver::new(&host.instance, host.physical_device, device, &RASTER)
    };
    for (result, fail) in [
        (vk::Result::ERROR_OUT_OF_DEVICE_MEMORY, out_of_memory as extern "system" fn() -> _),
        (vk::Result::ERROR_DEVICE_LOST, lost),
    ] {
        for call in [
            c"vkCreateDescriptorSetLayout",
            c"vkCreatePipelineLayout",
            c"vkCreateShaderModule",
            c"vkCreateComputePipelines",
        ] {
            let failing = host.device_with(|name| (name == call).then_some(fail));
            let error = new(&failing).unwrap_err();
            assert_names(&error, call, result);
        }
    }
    let mut solver = new(&device).unwrap();
    for (result, fail) in [
        (vk::Result::ERROR_OUT_OF_DEVICE_MEMORY, out_of_memory as extern "system" fn() -> _),
        (vk::Result::ERROR_DEVICE_LOST, lost),
    ] {
        for call in [
            c"vkCreateImage",
            c"vkCreateBuffer",
            c"vkBindImageMemory",
            c"vkBindBufferMemory",
            c"vkCreateImageView",
            c"vkCreateDescriptorPool",
            c"vkAllocateDescriptorSets",
        ] {
            let failing = host.device_with(|name| (name == call).then_some(fail));
            let error = solver.surface(&failing, host.allocator(), &info).unwrap_err();
            assert_names(&error, call, result);
            assert_eq!(host.allocations(), held, "{call:?}");
        }
    }
    let mut surface = solver.surface(&device, host.allocator(), &info).unwrap();
    let held = host.allocations();
    for call in [
        c"vkCreateBuffer",
        c"vkBindBufferMemory",
        c"vkCreateDescriptorPool",
        c"vkAllocateDescriptorSets",
        c"vkCreateShaderModule",
        c"vkCreateComputePipelines",
    ] {
        let failing = host.device_with(|name| (name == call).then_some(lost as _));
        let room = PathsInfo::new(3, 40);
        let allocator = host.allocator();
        let errors = [
            solver.contours(&failing, allocator, &surface, 100).unwrap_err(),
            solver.paths(&failing, allocator, &surface, room).unwrap_err(),
        ];
        for error in errors {
            assert_names(&error, call, vk::Result::ERROR_DEVICE_LOST);
        }
        assert_eq!(host.allocations(), held, "{call:?}");
    }
    surface.destroy(&device, host.allocator());
    solver.destroy(&device);
    host.free(points);
}

fn assert_names(error: &VulkanError, call: &CStr, result: vk::Result) {
    let text = error.to_string();
    assert!(text.starts_with(&format!("{} failed: {result}", call.to_str().unwrap())), "{text}");
}

/// The allocator itself runs out of memory.
#[test]
fn an_allocator_without_memory_is_an_error() {
    let mut host = Host::without_validation();
    let device = host.device.clone();
    let solver = embed::Solver::new(&host.instance, host.physical_device, &device, &[]);
    let mut solver = solver.unwrap();
    let name = c"vkAllocateMemory";
    let poor = host.device_with(|wanted| (wanted == name).then_some(out_of_memory as _));
    let desc = geosweep::gpu_allocator::vulkan::AllocatorCreateDesc {
        instance: host.instance.clone(),
        device: poor,
        physical_device: host.physical_device,
        debug_settings: Default::default(),
        buffer_device_address: false,
        allocation_sizes: Default::default(),
    };
    let mut allocator = geosweep::gpu_allocator::vulkan::Allocator::new(&desc).unwrap();
    let error = solver.surface(&device, &mut allocator, &SurfaceInfo::new(CHART)).unwrap_err();
    assert!(error.to_string().starts_with("cannot allocate edge lengths"), "{error}");
    assert!(allocator.generate_report().allocations.is_empty());
    drop(allocator);
    solver.destroy(&device);
    assert_eq!(host.allocations(), 0);
    assert!(host.allocator().generate_report().blocks.is_empty());
}

/// The memory that is computed in advance equals the memory that is allocated. A surface that is dropped
/// without being destroyed remains in the allocator's report, with the names of its parts.
#[test]
fn memory_is_as_stated_and_shows_until_it_is_freed() {
    let mut host = Host::new();
    let device = host.device.clone();
    let solver = embed::Solver::new(&host.instance, host.physical_device, &device, &[]);
    let mut solver = solver.unwrap();
    // Reader and writer may have the same family.
    let family = host::family(&host.instance, host.physical_device);
    for (slots, chart) in [(1, CHART), (3, Chart { rows: 301, cols: 257 })] {
        let queue_families = &[family; 2];
        let info = SurfaceInfo::new(chart).with_slots(slots).with_queue_families(queue_families);
        let stated = solver.bytes_for(&device, &info).unwrap();
        let mut surface = solver.surface(&device, host.allocator(), &info).unwrap();
        let report = host.allocator().generate_report();
        let taken: u64 = report.allocations.iter().map(|allocation| allocation.size).sum();
        assert_eq!(stated, surface.bytes());
        // The allocator rounds each allocation up to keep apart what may lie beside it.
        let properties =
            unsafe { host.instance.get_physical_device_properties(host.physical_device) };
        let each = properties.limits.buffer_image_granularity.max(256);
        assert!((stated..stated + each * report.allocations.len() as u64).contains(&taken));
        let distances = report.allocations.iter().filter(|a| a.name == "distances").count();
        assert_eq!(distances, slots);
        surface.destroy(&device, host.allocator());
        surface.destroy(&device, host.allocator());
        assert_eq!(host.allocations(), 0);
    }
    // The bytes include the map that the host reads. GPUs pad images, and small images the most.
    let most = if host.is_processor() { 48 } else { 66 };
    // The last size is the largest that every device accepts.
    for side in [900, 1200, 4092] {
        let chart = Chart { rows: side, cols: side };
        let stated = solver.bytes_for(&device, &SurfaceInfo::new(chart)).unwrap();
        assert!(stated <= most * chart.points() as u64, "{side}: {stated}");
    }
    solver.destroy(&device);
    assert_eq!(host.messages(), Vec::<String>::new());
}

#[test]
fn a_surface_that_is_not_destroyed_is_reported() {
    let mut host = Host::without_validation();
    let device = host.device.clone();
    let solver = embed::Solver::new(&host.instance, host.physical_device, &device, &[]);
    let mut solver = solver.unwrap();
    let surface = solver.surface(&device, host.allocator(), &SurfaceInfo::new(CHART)).unwrap();
    let held = host.allocations();
    drop(surface);
    assert!(held > 0 && host.allocations() == held);
    let report = host.allocator().generate_report();
    assert!(report.allocations.iter().any(|allocation| allocation.name == "edge lengths"));
    solver.destroy(&device);
}

#[test]
fn bad_input_is_an_error_before_anything_is_recorded() {
    let mut host = Host::new();
    let points = host.buffer_of(&vertices(CHART, 0.0));
    let handle = points.handle;
    let inputs = [Points::positions(handle, 32)];
    let info = SurfaceInfo::new(CHART).with_points(&inputs);
    let mut stage = Stage::new(host, &RASTER, &info);
    let plan = stage.plan(Schedule::Raster, Wavefront::Curved, 4);

    // Plans.
    let method = |schedule, wavefront| Method::new(wavefront, STOP).with_schedule(schedule);
    let tiles = stage.solver.plan(CHART, method(Schedule::Tiles, Wavefront::Curved), 4);
    assert!(tiles.unwrap_err().to_string().contains("tiles with curved fronts"));
    let raster = method(Schedule::Raster, Wavefront::Curved);
    let other = stage.solver.plan(Chart { rows: 90, cols: 13 }, raster, 4).unwrap();
    let large = stage.solver.plan(Chart { rows: 1, cols: 1 << 20 }, raster, 4);
    assert!(matches!(large, Err(VulkanError::TooLarge { .. })));

    // Recordings.
    let frame = Frame::new(&plan, SourceInput::Inline(&[]), Reader::COPY)
        .with_points(0)
        .with_unreached(-1.0);
    let error = |attempt: &dyn Fn(Recording) -> Result<(), VulkanError>| {
        let device = &stage.host.device;
        let record = |commands| attempt(stage.solver.record(device, commands, &stage.surface));
        stage.host.run(record).unwrap_err()
    };
    let no_such = |error: VulkanError, what: &str| {
        assert!(matches!(error, VulkanError::NoSuch { .. }), "{error}");
        assert!(error.to_string().contains(what), "{error}");
    };
    no_such(error(&|r| r.frame(&frame.with_points(1)).map(drop)), "1 point inputs");
    no_such(error(&|r| r.frame(&frame.with_slot(1)).map(drop)), "1 slots");
    let from_buffer = frame.with_sources(SourceInput::Buffer(0));
    no_such(error(&|r| r.frame(&from_buffer).map(drop)), "0 source buffers");
    no_such(error(&|r| r.lookup(0, 0.0, Access::NONE, Access::NONE)), "0 lookups");
    no_such(error(&|r| r.outcome(7)), "number 7");
    assert!(matches!(error(&|r| r.resume(&other)), VulkanError::OtherGrid));
    let many = vec![PointSource::at(1.0, 1.0); 1025];
    let many = frame.with_sources(SourceInput::Inline(&many));
    let refused = error(&|r| r.frame(&many).map(drop));
    assert!(matches!(refused, VulkanError::TooManySources { given: 1025, most: 1024 }));
    for (row, col, time) in [
        (9.0, 0.0, 0.0),
        (-0.1, 0.0, 0.0),
        (f32::NAN, 0.0, 0.0),
        (0.0, 0.0, f32::NAN),
        (0.0, 0.0, 1e30),
    ] {
        let bad = [PointSource { time, ..PointSource::at(row, col) }];
        let frame = frame.with_sources(SourceInput::Inline(&bad));
        let refused = error(&|r| r.frame(&frame).map(drop));
        let expected = match refused {
            VulkanError::Source(SourceError::Initial { .. }) => time.is_nan() || time >= 1e30,
            VulkanError::Source(SourceError::Outside { .. }) => time < 1e30,
            _ => false,
        };
        assert!(expected, "{row},{col},{time}");
    }

    // Surfaces.
    let device = stage.host.device.clone();
    let held = stage.host.allocations();
    let view = vk::ImageView::null();
    let image = PointMemory::Image { view, layout: vk::ImageLayout::GENERAL };
    let buffer = |buffer, offset, stride| PointMemory::Buffer { buffer, offset, stride };
    let of = |memory| Points { memory, kind: PointKind::Positions, slowness: None };
    let heights = PointKind::Heights(Spacing::square(1.0));
    for (points, reason) in [
        (of(image), "null handle"),
        (of(buffer(vk::Buffer::null(), 0, 12)), "null handle"),
        (of(buffer(handle, 2, 12)), "offset 2"),
        (of(buffer(handle, 0, 13)), "stride of 13"),
        (of(buffer(handle, 0, 0)), "stride of 0"),
        (of(buffer(handle, 0, 1 << 40)), "bytes"),
        (Points { kind: heights, slowness: Some(4), ..of(image) }, "beyond"),
    ] {
        let points = [points];
        let info = SurfaceInfo::new(CHART).with_points(&points);
        let error = stage.solver.surface(&device, stage.host.allocator(), &info).unwrap_err();
        assert!(matches!(error, VulkanError::HostBuffer { what: "points", .. }), "{error}");
        assert!(error.to_string().contains(reason), "{error}");
    }
    let sources = [SourceBuffer { buffer: handle, offset: 0, count: 0 }];
    let lookups = [Lookup {
        places: handle,
        places_offset: 0,
        distances: handle,
        distances_offset: 3,
        count: 1,
    }];
    let many = [SourceBuffer { buffer: handle, offset: 0, count: u32::MAX }];
    for (info, reason) in [
        (SurfaceInfo::new(CHART).with_sources(&sources), "its count is 0"),
        (SurfaceInfo::new(CHART).with_sources(&many), "4294967295 entries are more"),
        (SurfaceInfo::new(CHART).with_lookups(&lookups), "offset 3"),
        (SurfaceInfo::new(Chart { rows: 0, cols: 3 }), "empty"),
        (SurfaceInfo::new(Chart { rows: 1, cols: 1 << 20 }), "too large"),
    ] {
        let error = stage.solver.surface(&device, stage.host.allocator(), &info).unwrap_err();
        assert!(error.to_string().contains(reason), "{error}");
    }
    assert_eq!(stage.host.allocations(), held);
    stage.end([points]);
}

/// Threads may share solvers and surfaces, and these may move between threads.
#[test]
fn threads_record_at_once_for_surfaces_of_their_own() {
    fn shared<T: Send + Sync>() {}
    shared::<embed::Solver>();
    shared::<embed::FrameSurface>();
    shared::<embed::Plan>();
    shared::<Recording>();

    let mut host = Host::new();
    let buffers = [0.3, 1.9].map(|phase| host.buffer_of(&vertices(CHART, phase)));
    let device = host.device.clone();
    let passes = [(Schedule::Raster, Wavefront::Circular)];
    let solver = embed::Solver::new(&host.instance, host.physical_device, &device, &passes);
    let mut solver = solver.unwrap();
    let mut surfaces = [0, 1].map(|index: usize| {
        let points = [Points::positions(buffers[index].handle, 32)];
        let info = SurfaceInfo::new(CHART).with_points(&points);
        solver.surface(&device, host.allocator(), &info).unwrap()
    });
    let method = Method::new(Wavefront::Circular, STOP);
    let plan = solver.plan(CHART, method, 4).unwrap();
    // A command pool belongs to one thread at a time.
    let family = host::family(&host.instance, host.physical_device);
    let info = vk::CommandPoolCreateInfo::default().queue_family_index(family);
    let pools = [0, 1].map(|_| unsafe { device.create_command_pool(&info, None) }.unwrap());
    let recorded: Vec<_> = std::thread::scope(|scope| {
        let (solver, plan, device) = (&solver, &plan, &device);
        let threads: Vec<_> = surfaces
            .iter()
            .zip(pools)
            .map(|(surface, pool)| {
                let record = move || {
                    let info = vk::CommandBufferAllocateInfo::default()
                        .command_pool(pool)
                        .command_buffer_count(1);
                    let commands = unsafe { device.allocate_command_buffers(&info) }.unwrap()[0];
                    let begin = vk::CommandBufferBeginInfo::default();
                    unsafe { device.begin_command_buffer(commands, &begin) }.unwrap();
                    let recording = solver.record(device, commands, surface);
                    recording.prepare();
                    recording
                        .frame(
                            &Frame::new(plan, SourceInput::Inline(&source(4.0, 4.0)), Reader::COPY)
                                .with_points(0)
                                .with_unreached(-1.0),
                        )
                        .unwrap();
                    commands
                };
                scope.spawn(record)
            })
            .collect();
        threads.into_iter().map(|thread| thread.join().unwrap()).collect()
    });
    for commands in recorded {
        host.end(commands);
        host.submit(commands, vk::Fence::null());
    }
    unsafe { device.device_wait_idle() }.unwrap();
    for surface in &mut surfaces {
        assert!(surface.outcome(0).unwrap().converged);
        surface.destroy(&device, host.allocator());
    }
    for pool in pools {
        unsafe { device.destroy_command_pool(pool, None) };
    }
    solver.destroy(&device);
    buffers.into_iter().for_each(|buffer| host.free(buffer));
    assert_eq!((host.allocations(), host.messages()), (0, Vec::new()));
}

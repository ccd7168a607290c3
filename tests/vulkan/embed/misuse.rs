//! Mistakes of a renderer: each is an error or shows in the outcome, and none gives a map that looks right.
//! `tests/capi/misuse.rs` and `states.rs` test the same through the functions of C.

use geosweep::ash::{self, vk};
use geosweep::surface::{Chart, SourceError};
use geosweep::vulkan::embed::{
    self, Access, ContourFrame, Frame, LevelInput, Lookup, Outcome, PathFrame, PathsInfo,
    PointKind, PointMemory, PointSource, Points, Reader, Recording, RegionFrame, SourceBuffer,
    SourceInput, StartInput, SurfaceInfo,
};
use geosweep::vulkan::{Schedule, VulkanError};
use geosweep::{Spacing, Surface, Wavefront};

use crate::embed::stage::{Kept, RASTER, Stage, numbers_of, source, vertices};
use crate::host::Host;

pub const CHART: Chart = Chart { rows: 17, cols: 21 };

/// Returns a frame of `plan` for slot 0, which measures the first input of points.
pub fn frame<'a>(plan: &'a embed::Plan, sources: &'a [PointSource]) -> Frame<'a> {
    Frame::new(plan, SourceInput::Inline(sources), Reader::COPY).with_points(0)
}

/// Returns a stage with a surface of `slots` slots.
pub fn stage(slots: usize) -> Stage {
    Stage::of_waves(Kept::watched(), &RASTER, SurfaceInfo::new(CHART).with_slots(slots), 0.3)
}

impl Stage {
    /// Runs `record` with a recording that is discarded, and returns its result.
    pub fn attempt<T>(&self, record: impl FnOnce(Recording) -> T) -> T {
        let commands = self.host.commands();
        self.host.begin(commands);
        let result = record(self.solver.record(&self.host.device, commands, &self.surface));
        self.host.end(commands);
        result
    }

    /// Records, submits and waits.
    pub fn submit(&self, record: impl FnOnce(Recording)) {
        let device = &self.host.device;
        self.host.run(|commands| record(self.solver.record(device, commands, &self.surface)));
    }
}

macro_rules! assert_all {
    ($error:pat, $($call:expr),* $(,)?) => {
        $(match $call {
            Err($error) => {}
            other => panic!("{}: {other:?}", stringify!($call)),
        })*
    };
}

#[test]
fn an_unprepared_surface_takes_nothing() {
    let mut stage = stage(1);
    let device = stage.host.device.clone();
    let points = stage.host.buffer_of(&vertices(CHART, 0.3));
    let inputs = [Points::positions(points.handle, 32)];
    let info = SurfaceInfo::new(CHART).with_points(&inputs);
    let new = stage.solver.surface(&device, stage.host.allocator(), &info).unwrap();
    let prepared = std::mem::replace(&mut stage.surface, new);
    let plan = stage.plan(Schedule::Raster, Wavefront::Curved, 4);
    let sources = source(3.0, 4.0);
    stage.attempt(|r| {
        assert_all!(
            VulkanError::NotPrepared,
            r.frame(&frame(&plan, &sources)),
            r.frame(&frame(&plan, &sources).with_points(None)),
            r.measure(0),
            r.solve(SourceInput::Inline(&sources), &plan),
            r.result(0, Reader::COPY, 1.0),
            r.outcome(0),
        );
    });
    let mut destroyed = std::mem::replace(&mut stage.surface, prepared);
    destroyed.destroy(&device, stage.host.allocator());
    let kept = std::mem::replace(&mut stage.surface, destroyed);
    stage.attempt(|r| {
        assert_all!(VulkanError::Destroyed, r.frame(&frame(&plan, &sources)), r.measure(0));
    });
    stage.surface = kept;
    stage.end([points]);
}

/// A frame that measures no points is refused if the points were never measured. With curved fronts the frame is also
/// refused if the solver had no curved fronts when it measured the points, since it then measured no curvatures.
#[test]
fn maps_need_measured_edges() {
    let mut stage = Stage::of_waves(Host::new(), &RASTER[..1], SurfaceInfo::new(CHART), 0.3);
    let planar = stage.plan(Schedule::Raster, Wavefront::Planar, 4);
    let sources = source(3.0, 4.0);
    let unchanged = |plan| frame(plan, &sources).with_points(None);
    stage.attempt(|r| {
        assert_all!(
            VulkanError::NotMeasured,
            r.frame(&unchanged(&planar)),
            r.solve(SourceInput::Inline(&sources), &planar),
        );
        r.measure(0).unwrap();
        r.frame(&unchanged(&planar)).unwrap();
        r.prepare();
        assert_all!(VulkanError::NotMeasured, r.frame(&unchanged(&planar)));
        r.measure(0).unwrap();
    });
    let device = stage.host.device.clone();
    stage.solver.add_passes(&device, Schedule::Raster, Wavefront::Curved).unwrap();
    let curved = stage.plan(Schedule::Raster, Wavefront::Curved, 4);
    stage.attempt(|r| {
        r.frame(&unchanged(&planar)).unwrap();
        assert_all!(VulkanError::NotMeasured, r.frame(&unchanged(&curved)));
        r.frame(&frame(&curved, &sources)).unwrap();
        r.frame(&unchanged(&curved)).unwrap();
    });
    stage.end([]);
}

#[test]
fn missing_and_other_maps_are_not_read() {
    let mut host = Kept::watched();
    let points = host.buffer_of(&vertices(CHART, 0.3));
    let (places, to) = (host.buffer_of(&[1.0, 2.0]), host.buffer(80, true));
    let inputs = [Points::positions(points.handle, 32)];
    let lookup = Lookup {
        places: places.handle,
        places_offset: 0,
        distances: to.handle,
        distances_offset: 0,
        count: 1,
    };
    let lookup_buffers = [lookup];
    let info = SurfaceInfo::new(CHART).with_points(&inputs).with_lookups(&lookup_buffers);
    let mut stage = Stage::new(host, &RASTER, &info);
    let device = stage.host.device.clone();
    stage.solver.add_passes(&device, Schedule::Tiles, Wavefront::Planar).unwrap();
    let (solver, surface) = (&stage.solver, &stage.surface);
    let allocator = stage.host.allocator();
    let mut contours = solver.contours(&device, allocator, surface, 100).unwrap();
    let room = PathsInfo::new(1, 50);
    let mut paths = solver.paths(&device, allocator, surface, room).unwrap();
    let mut regions = solver.regions(&device, allocator, surface, Wavefront::Curved).unwrap();
    let plan = stage.plan(Schedule::Raster, Wavefront::Curved, 4);
    let planar = stage.plan(Schedule::Raster, Wavefront::Planar, 4);
    let tiles = stage.plan(Schedule::Tiles, Wavefront::Planar, 4);
    let sources = source(3.0, 4.0);
    let inline = SourceInput::Inline(&sources);
    let (none, read) = (Access::NONE, Access::DRAW);
    let levels = LevelInput::Spacing { step: 1.0, count: 3 };
    let contour_frame = ContourFrame::new(levels, read);
    let starts = StartInput::Inline(&[[9.0, 9.0]]);
    let path_frame = PathFrame::new(starts, inline, read).with_before(none);
    let region_frame = RegionFrame::new(inline, read).with_before(none);
    stage.attempt(|r| {
        for _ in 0..2 {
            assert_all!(
                VulkanError::NoMap,
                r.add(inline, &plan),
                r.resume(&plan),
                r.outcome(0),
                r.outcome_to(to.handle, 0, read),
                r.result(0, Reader::COPY, 1.0),
                r.lookup(0, 1.0, none, none),
                r.contours(&contours, &contour_frame),
                r.paths(&paths, &path_frame),
                r.regions(&regions, &region_frame),
            );
            // A new measurement has no map either.
            r.measure(0).unwrap();
            r.solve(inline, &plan).unwrap();
            r.measure(0).unwrap();
        }
        r.solve(inline, &planar).unwrap();
        assert_all!(
            VulkanError::OtherMap,
            r.add(inline, &plan),
            r.resume(&plan),
            r.resume(&tiles),
            r.regions(&regions, &region_frame),
        );
        r.resume(&planar).unwrap();
        r.add(inline, &tiles).unwrap();
        r.resume(&tiles).unwrap();
        r.paths(&paths, &path_frame).unwrap();
        let others = source(5.0, 6.0);
        let of_others = PathFrame::new(starts, SourceInput::Inline(&others), read);
        assert_all!(VulkanError::OtherSources { what: "paths" }, r.paths(&paths, &of_others));
        r.add(SourceInput::Inline(&others), &tiles).unwrap();
        assert_all!(VulkanError::OtherSources { what: "paths" }, r.paths(&paths, &path_frame));
    });
    let allocator = stage.host.allocator();
    contours.destroy(&device, allocator);
    paths.destroy(&device, allocator);
    regions.destroy(&device, allocator);
    stage.end([points, places, to]);
}

#[test]
fn ranges_beyond_a_buffer_are_refused() {
    let mut stage = stage(1);
    let device = stage.host.device.clone();
    let points = stage.host.buffer_of(&vertices(CHART, 0.3));
    // A buffer of 96 bytes, which drivers may round up.
    let (small, count) = (stage.host.buffer_of(&[0.0; 24]), CHART.points() as u64);
    let handle = small.handle;
    let beyond = |result: Result<(), VulkanError>, what: &str| {
        let error = result.unwrap_err();
        let VulkanError::HostBuffer { what: of, ref reason } = error else { panic!("{error}") };
        assert!(of == what && reason.contains("but has"), "{error}");
    };
    let stride = 64 * 1024;
    let positions = [Points::positions(points.handle, stride)];
    let memory = PointMemory::Buffer { buffer: points.handle, offset: 32 * count, stride: 32 };
    let behind = [Points { memory, ..Points::positions(points.handle, 32) }];
    let sources = [SourceBuffer { buffer: handle, offset: 4, count: 65_536 / 16 }];
    let mut lookup = Lookup {
        places: handle,
        places_offset: 0,
        distances: handle,
        distances_offset: 0,
        count: 65_536 / 8,
    };
    let none = SurfaceInfo::new(CHART);
    let mut surface =
        |info: &SurfaceInfo| stage.solver.surface(&device, stage.host.allocator(), info).map(drop);
    beyond(surface(&none.with_points(&positions)), "points");
    beyond(surface(&none.with_points(&behind)), "points");
    beyond(surface(&none.with_sources(&sources)), "sources");
    beyond(surface(&none.with_lookups(&[lookup])), "places");
    lookup.places = points.handle;
    lookup.count = 1000;
    lookup.distances_offset = 65_536;
    beyond(surface(&none.with_lookups(&[lookup])), "distances");

    let plan = stage.plan(Schedule::Raster, Wavefront::Planar, 2);
    let room = PathsInfo::new(10_000, 2);
    let allocator = stage.host.allocator();
    let mut paths = stage.solver.paths(&device, allocator, &stage.surface, room).unwrap();
    let sources = source(3.0, 4.0);
    stage.attempt(|r| {
        r.frame(&frame(&plan, &sources)).unwrap();
        beyond(r.outcome_to(handle, 65_536, Access::NONE), "the outcome");
        let null = r.outcome_to(vk::Buffer::null(), 0, Access::NONE).unwrap_err();
        assert!(null.to_string().contains("null handle"), "{null}");
        let starts = StartInput::Buffer { buffer: handle, offset: 0, count: 10_000 };
        let sources = SourceInput::Inline(&sources);
        let (before, reader) = (Access::NONE, Access::DRAW);
        let traced = PathFrame::new(starts, sources, reader).with_before(before);
        beyond(r.paths(&paths, &traced).map(drop), "starts");
    });
    paths.destroy(&device, stage.host.allocator());
    stage.end([points, small]);
}

/// The instance's devices know no function of 1.1, whatever the driver supports. Some loaders return the
/// driver's functions anyway.
#[test]
fn an_instance_for_vulkan_1_0_is_refused() {
    let entry = unsafe { ash::Entry::load() }.unwrap();
    let application = vk::ApplicationInfo::default().api_version(vk::API_VERSION_1_0);
    let info = vk::InstanceCreateInfo::default().application_info(&application);
    let instance = unsafe { entry.create_instance(&info, None) }.unwrap();
    let physical = unsafe { instance.enumerate_physical_devices() }.unwrap();
    let wanted = std::env::var("GEOSWEEP_TEST_DEVICE").unwrap_or_default().to_lowercase();
    let named = |&device: &vk::PhysicalDevice| {
        let properties = unsafe { instance.get_physical_device_properties(device) };
        let name = properties.device_name_as_c_str().unwrap().to_string_lossy();
        name.to_lowercase().contains(&wanted)
    };
    let physical = physical.into_iter().find(named).unwrap();
    let priorities = [1.0];
    let queues = [vk::DeviceQueueCreateInfo::default().queue_priorities(&priorities)];
    let info = vk::DeviceCreateInfo::default().queue_create_infos(&queues);
    let device = unsafe { instance.create_device(physical, &info, None) }.unwrap();
    match embed::Solver::new(&instance, physical, &device, &RASTER) {
        Ok(mut solver) => {
            let properties = unsafe { instance.get_physical_device_properties(physical) };
            assert_ne!(properties.device_type, vk::PhysicalDeviceType::CPU);
            solver.destroy(&device);
        }
        Err(error) => {
            let said = error.to_string();
            assert!(said.contains("was created for Vulkan 1.0, but 1.1 is needed"), "{error}");
        }
    }
    unsafe {
        device.destroy_device(None);
        instance.destroy_instance(None);
    }
}

/// An invalid curvature is refused if the program gives it, and clamped if a shader may have written it.
#[test]
fn an_invalid_curvature_does_not_change_the_map() {
    let mut host = Kept::watched();
    let points = host.buffer_of(&vertices(CHART, 0.3));
    let bad = [f32::INFINITY, f32::NAN, -1.0, f32::NEG_INFINITY, -0.0];
    let entries: Vec<f32> =
        [0.0, 1e18, 1e30].into_iter().chain(bad).flat_map(|k| [8.0, 9.0, 0.0, k]).collect();
    let entries = host.buffer_of(&entries);
    let inputs = [Points::positions(points.handle, 32)];
    let each = |at: u64| SourceBuffer { buffer: entries.handle, offset: 16 * at, count: 1 };
    let sources: Vec<_> = (0..3 + bad.len() as u64).map(each).collect();
    let info = SurfaceInfo::new(CHART).with_points(&inputs).with_sources(&sources);
    let stage = Stage::new(host, &RASTER, &info);
    let plan = stage.plan(Schedule::Raster, Wavefront::Curved, 8);
    let right = stage.map(0, SourceInput::Inline(&source(8.0, 9.0)), &plan);
    let zero = PointSource { row: 8.0, col: 9.0, ..PointSource::default() };
    assert!(
        stage.map(0, SourceInput::Inline(&[zero]), &plan) == right,
        "a struct that starts from zero"
    );
    for (number, _) in sources.iter().enumerate() {
        let map = stage.map(0, SourceInput::Buffer(number), &plan);
        assert!(map == right, "entry {number}");
    }
    for curvature in &bad[..4] {
        let bad = [PointSource { curvature: *curvature, ..zero }];
        let refused = stage.attempt(|r| r.frame(&frame(&plan, &bad)).unwrap_err());
        assert!(
            matches!(refused, VulkanError::Source(SourceError::Curvature { .. })),
            "{curvature}: {refused}"
        );
    }
    let straight = [PointSource { curvature: PointSource::STRAIGHT, ..zero }];
    assert!(stage.map(0, SourceInput::Inline(&straight), &plan) != right, "that it counts");
    stage.end([points, entries]);
}

/// The device counts sources that start nothing and points that are holes, from buffers and images.
#[test]
fn facts_that_only_the_device_knows_are_in_the_outcome() {
    let mut host = Kept::watched();
    let mut given = vertices(CHART, 0.3);
    for (hole, value) in [(8 * 40, f32::NAN), (8 * 41 + 2, f32::INFINITY), (8 * 300 + 1, -2e12)] {
        given[hole] = value;
    }
    let points = host.buffer_of(&given);
    let [hole_row, hole_col] = [40 / CHART.cols, 40 % CHART.cols].map(|at| at as f32);
    let entries = host.buffer_of(
        &[
            [5.0, 5.5, 0.0, 0.0],           // starts something
            [f32::NAN, 5.0, 0.0, 0.0],      // unused
            [17.0, 5.0, 0.0, 0.0],          // off the grid
            [hole_row, hole_col, 0.0, 0.0], // in a hole
            [5.0, 6.0, f32::INFINITY, 0.0], // never
            [5.0, 6.0, 1e30, 0.0],          // not before 1e30
            [16.0, 20.0, 0.0, 0.0],         // starts something, in the corner
            [15.5, 19.5, 0.0, 0.0],         // the same, in the last cell
        ]
        .concat(),
    );
    // The image lacks two columns and a row.
    let texels: Vec<f32> = (0..19 * 16).flat_map(|_| [1.0; 4]).collect();
    let image = host.image_of(19, 16, 4, &texels);
    let memory = PointMemory::Image { view: image.view, layout: vk::ImageLayout::GENERAL };
    let kind = PointKind::Heights(Spacing::square(1.0));
    let inputs = [Points::positions(points.handle, 32), Points { memory, kind, slowness: None }];
    let sources = [SourceBuffer { buffer: entries.handle, offset: 0, count: 8 }];
    let info = SurfaceInfo::new(CHART).with_points(&inputs).with_sources(&sources);
    let mut stage = Stage::new(host, &RASTER, &info);
    let plan = stage.plan(Schedule::Raster, Wavefront::Curved, 12);
    stage.map(0, SourceInput::Buffer(0), &plan);
    let outcome = stage.surface.outcome(0).unwrap();
    assert_eq!((outcome.holes, outcome.passed_over, outcome.measured), (3, 5, true));
    // A source that is added to a map counts with the others. A map that starts anew counts anew.
    let in_hole = source(hole_row, hole_col);
    let record = stage.host.buffer(4 + Outcome::BYTES as u64, true);
    stage.submit(|r| {
        r.begin(Access::NONE);
        r.add(SourceInput::Inline(&in_hole), &plan).unwrap();
        r.outcome(0).unwrap();
        r.outcome_to(record.handle, 4, Access::HOST_READ).unwrap();
    });
    let outcome = stage.surface.outcome(0).unwrap();
    assert_eq!((outcome.holes, outcome.passed_over), (3, 6));
    let bytes = record.bytes()[4..][..Outcome::BYTES].try_into().unwrap();
    assert_eq!(stage.surface.outcome_from(bytes).unwrap(), outcome);
    stage.map(1, SourceInput::Inline(&source(5.0, 5.0)), &plan);
    let outcome = stage.surface.outcome(0).unwrap();
    assert_eq!((outcome.holes, outcome.passed_over), (2 * 16 + 21, 0));
    stage.host.free_image(image);
    stage.end([points, entries, record]);
}

/// On a surface that is measured in bands, each point counts once.
#[test]
fn holes_of_bands_count_once() {
    let chart = Chart { rows: 700, cols: 500 };
    let holes =
        [0, 499, 500 * 233, 500 * 234 + 3, 500 * 235, 500 * 466 + 1, 500 * 467, 500 * 700 - 1];
    let mut heights = vec![1.0; chart.points()];
    holes.iter().for_each(|&hole| heights[hole] = f64::NAN);
    let surface = Surface::from_heights(chart.rows, chart.cols, heights, Spacing::square(1.0));
    let surface = surface.unwrap();
    let (host, numbers) = (Kept::unwatched(), numbers_of(&surface));
    let stage = Stage::on(host, &RASTER[..1], (&surface, None), numbers);
    let plan = stage.plan(Schedule::Raster, Wavefront::Planar, 1);
    let sources = source(3.0, 4.0);
    stage.submit(|r| {
        r.frame(&frame(&plan, &sources)).unwrap();
    });
    assert_eq!(stage.surface.outcome(0).unwrap().holes, holes.len() as u32);
    stage.end([]);
}

/// The recording that measures is discarded, and the recording after it runs.
#[test]
fn edges_that_were_never_measured_on_the_device_show() {
    let stage = stage(1);
    let plan = stage.plan(Schedule::Raster, Wavefront::Curved, 4);
    let sources = source(3.0, 4.0);
    stage.attempt(|r| r.measure(0)).unwrap();
    stage.submit(|r| {
        r.frame(&frame(&plan, &sources).with_points(None)).unwrap();
    });
    let outcome = stage.surface.outcome(0).unwrap();
    assert!(!outcome.measured && !outcome.converged, "{outcome:?}");
    assert_eq!(outcome.unresolved, None);
    stage.end([]);
}

/// No Vulkan call returns the state of a command buffer, but the layers report it. A recording into a command
/// buffer that was not begun never runs, and its outcome shows that.
#[test]
fn a_recording_at_the_wrong_place_is_reported_by_the_layers() {
    let mut host = Host::new();
    if !host.is_processor() {
        // The layers report a call and pass it on, and drivers of GPUs may end the process.
        return;
    }
    let image = host.image_of(8, 8, 1, &[0.0; 64]);
    let target = host.target(&image, 8, 8);
    let mut stage = Stage::of_waves(host, &RASTER[..1], SurfaceInfo::new(CHART), 0.3);
    let plan = stage.plan(Schedule::Raster, Wavefront::Planar, 2);
    let sources = source(3.0, 4.0);
    let said = |commands| {
        let before = stage.host.messages().len();
        let recording = stage.solver.record(&stage.host.device, commands, &stage.surface);
        recording.frame(&frame(&plan, &sources)).unwrap();
        stage.host.messages().split_off(before)
    };
    let never_begun = said(stage.host.commands());
    assert!(never_begun.iter().any(|m| m.contains("vkBeginCommandBuffer")), "{never_begun:?}");
    assert!(matches!(stage.surface.outcome(0), Err(VulkanError::NotRun { slot: 0 })));
    let commands = stage.host.commands();
    stage.host.begin(commands);
    let inside = stage.host.in_pass(commands, &target, 0.0, || said(commands));
    assert!(inside.iter().any(|m| m.contains("renderpass")), "{inside:?}");
    stage.host.end(commands);
    stage.host.free_target(target);
    stage.host.free_image(image);
    stage.take_down([]);
}

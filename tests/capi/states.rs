//! Calls that come at the wrong time: a surface without edges or a map, a slot in flight, a destroyed object.
//! Each gives an error or a value in the outcome. `tests/vulkan/embed/misuse.rs` tests the same in Rust.

use std::ptr::{null, null_mut};

use geosweep::ash::vk;
use geosweep_capi::*;

use crate::host::Host;
use crate::session::{
    COPY, Session, all_wrong, destroy, frame, get_instance_proc_addr, height_points, method, ok,
    refused, solver_info, surface_info, wrong, zero,
};

const ROWS: u32 = 12;
const COLS: u32 = 17;

#[test]
fn calls_before_their_prerequisites_are_refused() {
    let session = Session::new(Host::new());
    let data = [0.5f32; (ROWS * COLS) as usize];
    let points = [height_points(&data)];
    let info = surface_info(ROWS, COLS, &points);
    let mut surface = null_mut();
    ok(unsafe { geosweep_surface_create(session.solver, &info, &mut surface) });
    let plan = session.plan(ROWS, COLS, &method(GeosweepWavefront::Curved, 6));
    let planar = session.plan(ROWS, COLS, &method(GeosweepWavefront::Planar, 6));
    let (mut contours, mut paths, mut regions) = (null_mut(), null_mut(), null_mut());
    unsafe {
        ok(geosweep_contours_create(surface, 100, &mut contours));
        ok(geosweep_paths_create(surface, 1, 60, &mut paths));
        let curved = GeosweepWavefront::Curved as i32;
        ok(geosweep_regions_create(surface, curved, &mut regions));
        wrong(geosweep_regions_create(surface, 9, &mut regions), "wavefront is 9");
    }
    let sources = [geosweep_source_at(3.0, 4.0)];
    let good = frame(plan, &sources);
    let unchanged = GeosweepFrame { points: GEOSWEEP_POINTS_UNCHANGED, ..good };
    let commands = session.host.commands();
    session.host.begin(commands);
    let record = |frame: &GeosweepFrame| unsafe {
        geosweep_record_frame(surface, commands, frame, null_mut())
    };
    let contour_frame = GeosweepContourFrame { level_count: 3, step: 1.0, ..zero() };
    let starts = [7.0, 8.0];
    let (starts, start_count) = (starts.as_ptr(), 1);
    let path_frame = GeosweepPathFrame { starts, start_count, sources: good.sources, ..zero() };
    let region_frame = GeosweepRegionFrame { sources: good.sources, ..zero() };
    let no_map = |words: &str| unsafe {
        for status in [
            geosweep_record_add(surface, commands, &good.sources, plan),
            geosweep_record_resume(surface, commands, plan),
            geosweep_record_outcome(surface, commands, 0),
            geosweep_record_result(surface, commands, 0, COPY, -1.0, null_mut()),
            geosweep_record_contours(surface, commands, contours, &contour_frame, null_mut()),
            geosweep_record_paths(surface, commands, paths, &path_frame, null_mut()),
            geosweep_record_regions(surface, commands, regions, &region_frame, null_mut()),
        ] {
            wrong(status, words);
        }
    };
    let not_prepared = "geosweep_record_prepare comes once, before anything else";
    no_map(not_prepared);
    all_wrong! {
        record(&good) => "geosweep_record_prepare",
        record(&unchanged) => "geosweep_record_prepare",
        unsafe { geosweep_record_measure(surface, commands, 0, 0) } => "geosweep_record_prepare",
    }
    ok(unsafe { geosweep_record_prepare(surface, commands) });
    no_map("geosweep_record_frame or geosweep_record_solve comes before this");
    all_wrong! {
        record(&unchanged) => "GeosweepFrame::points is a number of its points in the first frame",
        unsafe { geosweep_record_solve(surface, commands, &good.sources, plan) } => "never measured",
    }
    let (no_count, two_places) = (&sources[..0], GeosweepSources { buffer: 1, ..good.sources });
    all_wrong! {
        record(&frame(plan, no_count)) => "frame->sources.count is 0, and sources is not null",
        record(&GeosweepFrame { sources: two_places, ..good }) => "frame->sources.buffer is 1, and the sources are",
    }
    let bad = [f32::INFINITY, f32::NAN, -1.0]
        .map(|curvature| [GeosweepSource { curvature, ..sources[0] }]);
    for bad in &bad {
        wrong(record(&frame(plan, bad)), "give 0 for a point");
    }
    // All calls succeed once there is a map, except for those with another wavefront.
    ok(record(&good));
    ok(record(&unchanged));
    all_wrong! {
        unsafe { geosweep_record_add(surface, commands, &good.sources, planar) } => "another wavefront",
        unsafe { geosweep_record_resume(surface, commands, planar) } => "another wavefront",
    }
    unsafe {
        ok(geosweep_record_contours(surface, commands, contours, &contour_frame, null_mut()));
        ok(geosweep_record_paths(surface, commands, paths, &path_frame, null_mut()));
        ok(geosweep_record_regions(surface, commands, regions, &region_frame, null_mut()));
    }
    session.host.end(commands);
    let early = unsafe { geosweep_surface_outcome(surface, 0, &mut zero()) };
    refused(early, GeosweepStatus::NotReady, "slot 0 has not run");
    session.submit(commands);
    let outcome = session.outcome(surface);
    assert!(outcome.converged && outcome.measured, "{outcome:?}");
    assert_eq!((outcome.holes, outcome.passed_over), (0, 0));
    unsafe {
        ok(geosweep_contours_destroy(contours));
        ok(geosweep_paths_destroy(paths));
        ok(geosweep_regions_destroy(regions));
        ok(geosweep_surface_destroy(surface));
        ok(geosweep_plan_destroy(plan));
        ok(geosweep_plan_destroy(planar));
    }
    session.end([]);
}

/// A wrong kind of object is always detected. A destroyed object is detected with checks.
#[test]
fn destroyed_and_wrong_objects_are_named() {
    let session = Session::with_checks(Host::new());
    let data = [0.5f32; (ROWS * COLS) as usize];
    let points = [height_points(&data)];
    let surface = session.surface(&surface_info(ROWS, COLS, &points));
    let plan = session.plan(ROWS, COLS, &method(GeosweepWavefront::Curved, 6));
    let commands = session.host.commands();
    unsafe {
        wrong(geosweep_plan_destroy(surface.cast()), "plan is no GeosweepPlan");
        wrong(geosweep_record_prepare(plan.cast(), commands), "surface is no GeosweepSurface");
        ok(geosweep_surface_destroy(surface));
        ok(geosweep_plan_destroy(plan));
        let mut iterations = 0;
        all_wrong! {
            geosweep_surface_destroy(surface) => "surface was destroyed before",
            geosweep_plan_destroy(plan) => "plan was destroyed before",
            geosweep_plan_iterations(plan, &mut iterations) => "plan was destroyed before",
            geosweep_record_prepare(surface, commands) => "surface was destroyed before",
        }
        let solver = session.solver;
        let bad = GeosweepSolverInfo { flags: 6, ..solver_info(&session.host) };
        wrong(geosweep_solver_create(&bad, &mut null_mut()), "info->flags is 0x6");
        session.end([]);
        wrong(geosweep_solver_destroy(solver), "solver was destroyed before");
    }
}

#[test]
fn checks_look_at_slots_in_flight() {
    let session = Session::with_checks(Host::new());
    let data = [0.5f32; (ROWS * COLS) as usize];
    let points = [height_points(&data)];
    let info = GeosweepSurfaceInfo { slots: 2, ..surface_info(ROWS, COLS, &points) };
    let surface = session.surface(&info);
    let plan = session.plan(ROWS, COLS, &method(GeosweepWavefront::Curved, 6));
    let sources = [geosweep_source_at(3.0, 4.0)];
    let good = frame(plan, &sources);
    let [first, second] = [(); 2].map(|()| session.host.commands());
    let record = |commands, frame: &GeosweepFrame| {
        session.host.begin(commands);
        let status = unsafe { geosweep_record_frame(surface, commands, frame, null_mut()) };
        session.host.end(commands);
        status
    };
    ok(record(first, &good));
    wrong(record(second, &good), "slot 0 is recorded again");
    ok(record(second, &GeosweepFrame { slot: 1, ..good }));
    session.submit(first);
    unsafe {
        wrong(geosweep_surface_destroy(surface), "its last recording for slot 1 has not run");
        wrong(geosweep_surface_discard(surface, 2), "number 2");
        ok(geosweep_surface_discard(surface, 1));
        ok(geosweep_surface_destroy(surface));
        ok(geosweep_plan_destroy(plan));
    }
    session.end([]);
}

/// Parts of a buffer are selected by an offset, and other buffers replace those with which a surface was
/// created.
#[test]
fn inputs_change_from_frame_to_frame() {
    let mut session = Session::new(Host::with_synchronization_validation());
    let count = (ROWS * COLS) as usize;
    // Each plane rises by `steep` from one row to the next.
    let plane = |steep: f32| (0..count as u32).map(move |index| steep * (index / COLS) as f32);
    let ring: Vec<f32> = plane(0.0).chain(plane(1.0)).collect();
    let ring = session.host.buffer_of(&ring);
    let other = session.host.buffer_of(&plane(3.0).collect::<Vec<_>>());
    let entries = session.host.buffer_of(&[0.0, 4.0, 0.0, 0.0, 11.0, 4.0, 0.0, 0.0]);
    let points = [GeosweepPoints { data: null(), buffer: ring.handle, ..height_points(&[]) }];
    let buffers = [GeosweepSourceBuffer { buffer: entries.handle, count: 1, ..zero() }];
    let info = GeosweepSurfaceInfo {
        sources: buffers.as_ptr(),
        source_count: 1,
        ..surface_info(ROWS, COLS, &points)
    };
    let surface = session.surface(&info);
    let plan = session.plan(ROWS, COLS, &method(GeosweepWavefront::Curved, 12));
    let good = GeosweepFrame { sources: zero(), ..frame(plan, &[]) };
    // Checks the distance from the source, which lies in column 4, to another row of this column.
    let mut along = |points_offset, source, row: u32, words: f32| {
        let sources = GeosweepSources { offset: source, ..zero() };
        let map = session.map(surface, &GeosweepFrame { points_offset, sources, ..good });
        let found = map[(row * COLS + 4) as usize];
        assert!((found - words).abs() < 1e-4, "{found}, not {words}");
    };
    let part = 4 * count as u64;
    along(0, 0, 11, 11.0);
    along(part, 0, 11, 11.0 * 2.0_f32.sqrt());
    along(part, 16, 0, 11.0 * 2.0_f32.sqrt());
    let replaced = GeosweepPoints { buffer: other.handle, ..points[0] };
    ok(unsafe { geosweep_surface_set_points(surface, 0, &replaced) });
    along(0, 0, 11, 11.0 * 10.0_f32.sqrt());
    let later = GeosweepSourceBuffer { offset: 16, ..buffers[0] };
    ok(unsafe { geosweep_surface_set_sources(surface, 0, &later) });
    along(0, 0, 0, 11.0 * 10.0_f32.sqrt());
    let flat = GeosweepFrame { points_offset: 1 << 30, ..good };
    let astray = GeosweepFrame { points_offset: 2, ..good };
    let inline = [geosweep_source_at(3.0, 4.0)];
    let both = GeosweepFrame {
        sources: GeosweepSources { sources: inline.as_ptr(), count: 1, buffer: 0, offset: 16 },
        ..good
    };
    let commands = session.host.commands();
    session.host.begin(commands);
    let record = |frame: &GeosweepFrame| unsafe {
        geosweep_record_frame(surface, commands, frame, null_mut())
    };
    let in_program =
        GeosweepPoints { buffer: vk::Buffer::null(), data: inline.as_ptr().cast(), ..points[0] };
    unsafe {
        all_wrong! {
            record(&flat) => "offset 1073741824 is beyond the",
            record(&astray) => "offset 2 is no multiple of 4",
            record(&both) => "frame->sources.offset is 16",
            geosweep_surface_set_points(null_mut(), 0, &replaced) => "surface is null",
            geosweep_surface_set_points(surface, 0, null_mut()) => "points is null",
            geosweep_surface_set_points(surface, 1, &replaced) => "number 1",
            geosweep_surface_set_points(surface, 0, &in_program) => "points->data is not null",
            geosweep_surface_set_points(surface, 0, &GeosweepPoints { stride: 2, ..replaced }) => "points.stride is 2",
            geosweep_surface_set_sources(surface, 1, &later) => "number 1",
            geosweep_surface_set_sources(surface, 0, null_mut()) => "sources is null",
            geosweep_surface_set_sources(surface, 0, &zero()) => "its count is 0",
        }
    }
    session.host.end(commands);
    unsafe {
        ok(geosweep_surface_destroy(surface));
        ok(geosweep_plan_destroy(plan));
    }
    session.end([ring, other, entries]);
}

/// Images and buffers of the program. They are refused if they are null, too few, or not the program's to replace.
#[test]
fn the_program_may_provide_outputs() {
    let mut session = Session::new(Host::with_synchronization_validation());
    let data = [0.5f32; (ROWS * COLS) as usize];
    let points = [height_points(&data)];
    let surface = session.surface(&surface_info(ROWS, COLS, &points));
    let curved = GeosweepWavefront::Curved as i32;
    let mut bytes = [0; 3];
    unsafe {
        ok(geosweep_contours_buffer_bytes(200, &mut bytes[0]));
        ok(geosweep_paths_buffer_bytes(1, 60, &mut bytes[1]));
        ok(geosweep_regions_buffer_bytes(ROWS, COLS, &mut bytes[2]));
    }
    assert_eq!(bytes, [36 + 200 * 24, 104 + 60 * 24, 24 * u64::from(ROWS * COLS)]);
    let buffers = bytes.map(|bytes| session.host.buffer(bytes, false));
    let [first, second, third] = buffers.each_ref().map(|buffer| buffer.handle);
    let (mut contours, mut paths, mut regions) = (null_mut(), null_mut(), null_mut());
    let (mut curves, mut labels) = (zero::<GeosweepCurves>(), zero::<GeosweepLabels>());
    let none = vk::Buffer::null();
    let image = GeosweepHostImage { image: vk::Image::null(), view: vk::ImageView::null() };
    let images = GeosweepSurfaceInfo {
        results: &image,
        result_count: 1,
        ..surface_info(ROWS, COLS, &points)
    };
    unsafe {
        ok(geosweep_contours_create_into(surface, 200, first, &mut contours));
        ok(geosweep_paths_create_into(surface, 1, 60, second, &mut paths));
        ok(geosweep_regions_create_into(surface, curved, third, &mut regions));
        ok(geosweep_contours_curves(contours, &mut curves));
        ok(geosweep_regions_labels(regions, &mut labels));
        assert_eq!((curves.buffer, labels.buffer), (first, third));
        ok(geosweep_contours_set_buffer(contours, surface, third));
        ok(geosweep_contours_curves(contours, &mut curves));
        assert_eq!(curves.buffer, third);
        let mut own = null_mut();
        ok(geosweep_contours_create(surface, 200, &mut own));
        let mut other = null_mut();
        all_wrong! {
            geosweep_contours_set_buffer(own, surface, first) => "a buffer of their own",
            geosweep_contours_set_buffer(contours, surface, none) => "null handle",
            geosweep_paths_set_buffer(paths, null_mut(), second) => "surface is null",
            geosweep_regions_create_into(surface, curved, none, &mut null_mut()) => "null handle",
            geosweep_regions_set_buffer(null_mut(), surface, third) => "regions is null",
            geosweep_surface_set_result(surface, 0, &image) => "GeosweepSurfaceInfo::results",
            geosweep_surface_set_result(surface, 1, &image) => "number 1",
            geosweep_surface_create(session.solver, &images, &mut other) => "the image is the null handle",
            geosweep_surface_create(session.solver, &GeosweepSurfaceInfo { slots: 2, ..images }, &mut other) => "1 results are given for 2 slots",
        }
        ok(geosweep_contours_destroy(own));
        ok(geosweep_contours_destroy(contours));
        ok(geosweep_paths_destroy(paths));
        ok(geosweep_regions_destroy(regions));
        ok(geosweep_surface_destroy(surface));
    }
    session.end(buffers);
}

/// The best schedule for a device and a grid, for which a solver should be created if its plans use
/// `GEOSWEEP_SCHEDULE_BEST`.
#[test]
fn the_best_schedule_is_known_before_the_solver() {
    let host = Host::without_validation();
    let (get, instance) = (get_instance_proc_addr(), host.instance.handle());
    for (rows, cols) in [(9, 9), (200, 300)] {
        let mut schedule = -1;
        let device = host.physical_device;
        ok(unsafe { geosweep_best_schedule(get, instance, device, rows, cols, &mut schedule) });
        let wavefront = GeosweepWavefront::Planar as i32;
        let passes = [GeosweepPasses { schedule, wavefront }];
        let info =
            GeosweepSolverInfo { passes: passes.as_ptr(), pass_count: 1, ..solver_info(&host) };
        let mut solver = null_mut();
        ok(unsafe { geosweep_solver_create(&info, &mut solver) });
        let mut plan = null_mut();
        let method = method(GeosweepWavefront::Planar, 4);
        ok(unsafe { geosweep_plan_create(solver, rows, cols, &method, &mut plan) });
        let mut of_plan = -1;
        ok(unsafe { geosweep_plan_schedule(plan, &mut of_plan) });
        assert_eq!(of_plan, schedule);
        ok(unsafe { geosweep_plan_destroy(plan) });
        ok(unsafe { geosweep_solver_destroy(solver) });
    }
    let mut schedule = -1;
    let device = host.physical_device;
    wrong(
        unsafe { geosweep_best_schedule(get, instance, device, 0, 9, &mut schedule) },
        "rows is 0",
    );
}

/// On a plane, labels name the nearest of two sources, directions lead straight to a source, and the log map is the
/// offset of each point from the source.
#[test]
fn labels_directions_and_log_maps_of_a_plane() {
    let mut session = Session::new(Host::new());
    let data = [0.5f32; (ROWS * COLS) as usize];
    let points = [height_points(&data)];
    let surface = session.surface(&surface_info(ROWS, COLS, &points));
    let plan = session.plan(ROWS, COLS, &method(GeosweepWavefront::Curved, 12));
    let sources = [geosweep_source_at(2.0, 3.0), geosweep_source_at(9.0, 13.0)];
    let (mut regions, mut directions, mut log_map) = (null_mut(), null_mut(), null_mut());
    let (mut stated, mut taken) = ([0; 3], [0; 3]);
    let (solver, mut labels) = (session.solver, zero::<GeosweepLabels>());
    let curved = GeosweepWavefront::Curved as i32;
    unsafe {
        ok(geosweep_regions_create(surface, curved, &mut regions));
        ok(geosweep_directions_create(surface, null(), &mut directions));
        ok(geosweep_log_map_create(surface, null(), &mut log_map));
        ok(geosweep_regions_bytes_for(solver, ROWS, COLS, &mut stated[0]));
        ok(geosweep_directions_bytes_for(solver, ROWS, COLS, &mut stated[1]));
        ok(geosweep_log_map_bytes_for(solver, ROWS, COLS, &mut stated[2]));
        ok(geosweep_regions_bytes(regions, &mut taken[0]));
        ok(geosweep_directions_bytes(directions, &mut taken[1]));
        ok(geosweep_log_map_bytes(log_map, &mut taken[2]));
        ok(geosweep_regions_labels(regions, &mut labels));
        let none: GeosweepHostImage = zero();
        wrong(geosweep_directions_create(surface, &none, &mut null_mut()), "null handle");
        wrong(geosweep_log_map_set_image(log_map, &none), "belongs to the library");
    }
    assert_eq!(stated, taken);
    assert_eq!(labels.bytes, u64::from(4 * ROWS * COLS));

    let to = session.host.buffer(labels.bytes, true);
    let both = frame(plan, &sources);
    let one = frame(plan, &sources[..1]);
    let device = session.host.device.clone();
    session.read(1, |commands, image| unsafe {
        ok(geosweep_record_frame(surface, commands, &both, image));
        let reader = COPY.access;
        let of = GeosweepRegionFrame { sources: both.sources, reader, ..zero() };
        let mut found = zero::<GeosweepLabels>();
        ok(geosweep_record_regions(surface, commands, regions, &of, &mut found));
        assert_eq!((found.buffer, found.bytes), (labels.buffer, labels.bytes));
        let copy = vk::BufferCopy::default().size(found.bytes);
        device.cmd_copy_buffer(commands, found.buffer, to.handle, &[copy]);
        GeosweepStatus::Success
    });
    // Two numbers of half precision in the place of a float.
    let of_directions = session.read(1, |commands, image| unsafe {
        ok(geosweep_record_frame(surface, commands, &one, null_mut()));
        let of = GeosweepDirectionFrame { sources: one.sources, reader: COPY, ..zero() };
        geosweep_record_directions(surface, commands, directions, &of, image)
    });
    let of_log_map = session.read(2, |commands, image| unsafe {
        ok(geosweep_record_frame(surface, commands, &one, null_mut()));
        let unreached = f32::INFINITY;
        let of = GeosweepLogMapFrame { sources: one.sources, reader: COPY, unreached, ..zero() };
        for (unreached, radius) in [(0.0, 0.0), (0.3, 0.0), (-9.0, 0.0), (0.0, 2.0), (-1.9, 2.0)] {
            let place = GeosweepLogMapFrame { unreached, radius, ..of };
            let refused = geosweep_record_log_map(surface, commands, log_map, &place, null_mut());
            wrong(refused, "which may be a coordinate");
        }
        let negative = GeosweepLogMapFrame { radius: -1.0, ..of };
        let refused = geosweep_record_log_map(surface, commands, log_map, &negative, null_mut());
        wrong(refused, "not positive");
        ok(geosweep_record_log_map(surface, commands, log_map, &of, image));
        let mut same = zero::<GeosweepImage>();
        ok(geosweep_log_map_image(log_map, COPY.layout, &mut same));
        assert_eq!(image.image, same.image);
        GeosweepStatus::Success
    });
    let half = |bits: u32| {
        let size = f32::from_bits((bits & 0x7fff) << 13) * 2f32.powi(112);
        if bits & 0x8000 == 0 { size } else { -size }
    };
    let ways = of_directions.iter().map(|texel| [texel.to_bits(), texel.to_bits() >> 16].map(half));
    let pairs = ways.zip(of_log_map.chunks(2));
    for ((index, label), (way, found)) in to.bytes().chunks(4).enumerate().zip(pairs) {
        let label = u32::from_ne_bytes(label.try_into().unwrap());
        let (row, col) = ((index as u32 / COLS) as f32, (index as u32 % COLS) as f32);
        let away = |source: &GeosweepSource| [col - source.col, row - source.row];
        let [near, far] = [0, 1].map(|k| f32::hypot(away(&sources[k])[0], away(&sources[k])[1]));
        // Points near the border are not compared.
        if (near - far).abs() > 1.0 {
            assert_eq!(label, u32::from(far < near), "{row},{col}");
        }
        let [right, down] = away(&sources[0]);
        assert!(f32::hypot(found[0] - right, found[1] - down) < 1e-3, "{found:?} at {row},{col}");
        let off = f32::hypot(way[0] + right / near, way[1] + down / near);
        assert!(near == 0.0 || off < 2e-3, "{way:?} at {row},{col}");
    }
    destroy!(
        geosweep_regions_destroy(regions),
        geosweep_directions_destroy(directions),
        geosweep_log_map_destroy(log_map),
        geosweep_surface_destroy(surface),
        geosweep_plan_destroy(plan),
    );
    session.end([to]);
}

/// Outputs are for the sources of the map. Their order does not matter, and sources that were added count.
#[test]
fn outputs_for_other_sources_are_refused() {
    let mut session = Session::new(Host::new());
    let floats = [4.0f32, 5.0, 0.0, 0.0, 4.0, 5.0, 0.0, 0.0];
    let ring = session.host.buffer_of(&floats);
    let buffers =
        [0, 16].map(|offset| GeosweepSourceBuffer { buffer: ring.handle, offset, count: 1 });
    let data = [0.5f32; (ROWS * COLS) as usize];
    let points = [height_points(&data)];
    let (sources, source_count) = (buffers.as_ptr(), 2);
    let info = GeosweepSurfaceInfo { sources, source_count, ..surface_info(ROWS, COLS, &points) };
    let surface = session.surface(&info);
    let plan = session.plan(ROWS, COLS, &method(GeosweepWavefront::Curved, 6));
    let (mut regions, mut directions, mut log_map, mut paths) =
        (null_mut(), null_mut(), null_mut(), null_mut());
    unsafe {
        ok(geosweep_regions_create(surface, GeosweepWavefront::Curved as i32, &mut regions));
        ok(geosweep_directions_create(surface, null(), &mut directions));
        ok(geosweep_log_map_create(surface, null(), &mut log_map));
        ok(geosweep_paths_create(surface, 1, 60, &mut paths));
    }
    let commands = session.host.commands();
    session.host.begin(commands);
    let starts = [7.0, 8.0];
    let outputs = |sources: GeosweepSources| unsafe {
        let of_paths =
            GeosweepPathFrame { starts: starts.as_ptr(), start_count: 1, sources, ..zero() };
        let of_regions = GeosweepRegionFrame { sources, ..zero() };
        let of_directions = GeosweepDirectionFrame { sources, reader: COPY, ..zero() };
        let unreached = f32::INFINITY;
        let of_log_map = GeosweepLogMapFrame { sources, reader: COPY, unreached, ..zero() };
        [
            geosweep_record_paths(surface, commands, paths, &of_paths, null_mut()),
            geosweep_record_regions(surface, commands, regions, &of_regions, null_mut()),
            geosweep_record_directions(surface, commands, directions, &of_directions, null_mut()),
            geosweep_record_log_map(surface, commands, log_map, &of_log_map, null_mut()),
        ]
    };
    let all =
        [geosweep_source_at(2.0, 3.0), geosweep_source_at(9.0, 13.0), geosweep_source_at(5.5, 1.0)];
    let array = |sources: &[GeosweepSource]| frame(plan, sources).sources;
    let refuse = |sources| {
        for status in outputs(sources) {
            wrong(status, "are not those of the map: give all sources of the map");
        }
    };
    let accept = |sources| outputs(sources).map(ok);
    ok(unsafe { geosweep_record_frame(surface, commands, &frame(plan, &all[..2]), null_mut()) });
    accept(array(&all[..2]));
    accept(array(&[all[1], all[0]]));
    let later = [all[0], GeosweepSource { time: 1.0, ..all[1] }];
    for others in [&all[..1], &all[1..], &all, &later] {
        refuse(array(others));
    }
    ok(unsafe { geosweep_record_add(surface, commands, &array(&all[2..]), plan) });
    accept(array(&all));
    refuse(array(&all[..2]));
    // Buffers are told apart by their place. Their contents are not known.
    let [first, second] = [0, 1].map(|buffer| GeosweepSources { buffer, ..zero() });
    let of_buffer = GeosweepFrame { sources: first, ..frame(plan, &[]) };
    ok(unsafe { geosweep_record_frame(surface, commands, &of_buffer, null_mut()) });
    accept(first);
    refuse(second);
    accept(array(&[geosweep_source_at(4.0, 5.0)]));
    session.host.end(commands);
    session.submit(commands);
    destroy!(
        geosweep_regions_destroy(regions),
        geosweep_directions_destroy(directions),
        geosweep_log_map_destroy(log_map),
        geosweep_paths_destroy(paths),
        geosweep_surface_destroy(surface),
        geosweep_plan_destroy(plan),
    );
    session.end([ring]);
}

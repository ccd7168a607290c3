//! Wrong arguments: each gives a status and a message that names it.

use std::ptr::{null, null_mut};

use geosweep::ash::vk;
use geosweep::ash::vk::Handle;
use geosweep_capi::*;

use crate::host::Host;
use crate::session::{
    COPY, Session, all_wrong, frame, get_instance_proc_addr, height_points, method, ok, refused,
    solver_info, surface_info, wrong, zero,
};

const ROWS: u32 = 9;
const COLS: u32 = 13;
const POINTS: usize = (ROWS * COLS) as usize;

#[test]
fn null_is_named_wherever_it_is_given() {
    let session = Session::new(Host::new());
    let get = get_instance_proc_addr();
    let (instance, device) = (session.host.instance.handle(), session.host.physical_device);
    let data = [0.0; POINTS];
    let points = [height_points(&data)];
    let info = surface_info(ROWS, COLS, &points);
    let surface = session.surface(&info);
    let method = method(GeosweepWavefront::Planar, 2);
    let plan = session.plan(ROWS, COLS, &method);
    let frame = frame(plan, &[]);
    let access: GeosweepAccess = zero();
    let sources: GeosweepSources = zero();
    let solver = session.solver;
    let none: *const GeosweepSurface = null();
    let commands = session.host.commands();
    session.host.begin(commands);
    let (no_commands, no_buffer) = (vk::CommandBuffer::null(), vk::Buffer::null());
    let (no_instance, no_device) = (vk::Instance::null(), vk::PhysicalDevice::null());
    let (mut made, mut image, mut bytes) = (null_mut(), zero::<GeosweepImage>(), 0);
    unsafe {
        all_wrong! {
            geosweep_requirements(null_mut()) => "requirements is null",
            geosweep_check_device(None, instance, device) => "get_instance_proc_addr is null",
            geosweep_check_device(get, no_instance, device) => "instance is the null handle",
            geosweep_check_device(get, instance, no_device) => "physical_device is the null",
            geosweep_compute_queue_family(get, instance, device, null_mut()) => "family is null",
            geosweep_solver_create(null(), &mut null_mut()) => "info is null",
            geosweep_solver_create(&solver_info(&session.host), null_mut()) => "solver is null",
            geosweep_solver_bytes(null(), &mut bytes) => "solver is null",
            geosweep_solver_bytes(solver, null_mut()) => "bytes is null",
            geosweep_plan_create(null(), 1, 1, &method, &mut null_mut()) => "solver is null",
            geosweep_plan_create(solver, 1, 1, null(), &mut null_mut()) => "method is null",
            geosweep_plan_create(solver, 1, 1, &method, null_mut()) => "plan is null",
            geosweep_plan_iterations(null(), &mut 0) => "plan is null",
            geosweep_plan_iterations(plan, null_mut()) => "iterations is null",
            geosweep_plan_wavefront(null(), &mut 0) => "plan is null",
            geosweep_plan_wavefront(plan, null_mut()) => "wavefront is null",
            geosweep_solver_set_pipeline_cache(null(), vk::PipelineCache::null()) => "solver is null",
            geosweep_surface_bytes_for(null(), &info, &mut bytes) => "solver is null",
            geosweep_surface_bytes_for(solver, null(), &mut bytes) => "info is null",
            geosweep_surface_bytes_for(solver, &info, null_mut()) => "bytes is null",
            geosweep_surface_create(null(), &info, &mut made) => "solver is null",
            geosweep_surface_create(solver, null(), &mut made) => "info is null",
            geosweep_surface_create(solver, &info, null_mut()) => "surface is null",
            geosweep_surface_bytes(none, &mut bytes) => "surface is null",
            geosweep_surface_bytes(surface, null_mut()) => "bytes is null",
            geosweep_surface_write_points(null_mut(), 0, null(), null()) => "surface is null",
            geosweep_surface_result(none, 0, COPY.layout, &mut image) => "surface is null",
            geosweep_surface_result(surface, 0, COPY.layout, null_mut()) => "result is null",
            geosweep_surface_packed(none, &mut zero()) => "surface is null",
            geosweep_surface_packed(surface, null_mut()) => "packed is null",
            geosweep_surface_outcome(none, 0, &mut zero()) => "surface is null",
            geosweep_surface_outcome(surface, 0, null_mut()) => "outcome is null",
            geosweep_outcome_from_bytes(surface, null(), &mut zero()) => "bytes is null",
            geosweep_outcome_from_bytes(surface, [0; 80].as_ptr(), null_mut()) => "outcome is null",
            geosweep_record_prepare(none, commands) => "surface is null",
            geosweep_record_prepare(surface, no_commands) => "commands is the null handle",
            geosweep_record_frame(none, commands, &frame, &mut image) => "surface is null",
            geosweep_record_frame(surface, commands, null(), &mut image) => "frame is null",
            geosweep_record_begin(none, commands, access) => "surface is null",
            geosweep_record_measure(none, commands, 0, 0) => "surface is null",
            geosweep_record_solve(none, commands, &sources, plan) => "surface is null",
            geosweep_record_solve(surface, commands, null(), plan) => "sources is null",
            geosweep_record_solve(surface, commands, &sources, null()) => "plan is null",
            geosweep_record_add(surface, commands, null(), plan) => "sources is null",
            geosweep_record_add(surface, commands, &sources, null()) => "plan is null",
            geosweep_record_resume(surface, commands, null()) => "plan is null",
            geosweep_record_outcome(none, commands, 0) => "surface is null",
            geosweep_record_outcome_to(surface, commands, no_buffer, 0, access) => "it is the null handle",
            geosweep_record_result(none, commands, 0, COPY, 1.0, &mut image) => "surface is null",
            geosweep_record_lookup(none, commands, 0, 1.0, access, access) => "surface is null",
            geosweep_record_end(none, commands, access) => "surface is null",
        }
        ok(geosweep_solver_destroy(null_mut()));
        ok(geosweep_plan_destroy(null_mut()));
        ok(geosweep_surface_destroy(null_mut()));
        ok(geosweep_surface_destroy(surface));
        ok(geosweep_plan_destroy(plan));
    }
    session.host.end(commands);
    session.end([]);
}

#[test]
fn unusable_arguments_of_a_solver_are_refused() {
    let host = Host::without_validation();
    let good = solver_info(&host);
    let pass = |schedule, wavefront| GeosweepPasses { schedule, wavefront };
    let bad_passes = [pass(1, 0), pass(0, 0), pass(1, 5), pass(7, 0)];
    let with = |first: usize| GeosweepSolverInfo {
        passes: bad_passes[first..].as_ptr(),
        pass_count: 1,
        ..good
    };
    let create = |info: &GeosweepSolverInfo| {
        let mut solver = null_mut();
        let status = unsafe { geosweep_solver_create(info, &mut solver) };
        assert!(solver.is_null());
        status
    };
    all_wrong! {
        create(&zero()) => "info->header_version is 0, and this library was built with header 9",
        create(&GeosweepSolverInfo { get_instance_proc_addr: None, ..good }) => "is null",
        create(&GeosweepSolverInfo { instance: vk::Instance::null(), ..good }) => "instance is",
        create(&GeosweepSolverInfo { device: vk::Device::null(), ..good }) => "device is the null",
        create(&GeosweepSolverInfo { passes: null(), ..good }) => "passes is null, and is said to have 4",
        create(&GeosweepSolverInfo { pass_count: u32::MAX, ..good }) => "4294967295 entries; at most 64",
        create(&with(1)) => "info->passes[0].schedule is GEOSWEEP_SCHEDULE_BEST",
        create(&with(2)) => "info->passes[0].wavefront is 5, which is no GeosweepWavefront",
        create(&with(3)) => "info->passes[0].schedule is 7, which is no GeosweepSchedule",
    }
    // The pointer is badly aligned, as may happen in C.
    let bytes = [0u64; 32];
    let astray = unsafe { bytes.as_ptr().cast::<u8>().add(1).cast::<GeosweepSolverInfo>() };
    wrong(unsafe { geosweep_solver_create(astray, &mut null_mut()) }, "not aligned to 8 bytes");
}

#[test]
fn unusable_arguments_of_a_plan_are_refused() {
    let session = Session::new(Host::new());
    let good = method(GeosweepWavefront::Curved, 4);
    let create = |rows, cols, method: &GeosweepMethod| {
        let mut plan = null_mut();
        let status = unsafe { geosweep_plan_create(session.solver, rows, cols, method, &mut plan) };
        assert!(plan.is_null());
        status
    };
    all_wrong! {
        create(0, 5, &good) => "rows is 0",
        create(5, 0, &good) => "cols is 0",
        create(5, 5, &GeosweepMethod { wavefront: -1, ..good }) => "method->wavefront is -1",
        create(5, 5, &GeosweepMethod { schedule: 4, ..good }) => "method->schedule is 4",
        create(5, 5, &GeosweepMethod { schedule: 3, ..good }) => "no pipelines for the schedule tiles with curved fronts: name both in GeosweepSolverInfo::passes",
        create(5, 5, &GeosweepMethod { tolerance: f64::NAN, ..good }) => "tolerance is NaN",
        create(5, 5, &GeosweepMethod { tolerance: -1e-5, ..good }) => "tolerance is -0.00001",
        create(5, 5, &GeosweepMethod { most_iterations: 0, ..good }) => "most_iterations is 0",
        create(5, 5, &GeosweepMethod { iterations: 0, ..good }) => "iterations is 0",
        create(5, 5, &GeosweepMethod { iterations: 257, ..good }) => "iterations is 257",
    }
    refused(create(1, u32::MAX, &good), GeosweepStatus::TooLarge, "too large");
    session.end([]);
}

#[test]
fn unusable_arguments_of_a_surface_are_refused() {
    let mut session = Session::new(Host::new());
    let buffer = session.host.buffer_of(&[0.0; 4 * POINTS]);
    let solver = session.solver;
    let data = [0.0f32; 4 * POINTS];
    let flat = [height_points(&data)];
    let good = surface_info(ROWS, COLS, &flat);
    let create = |info: &GeosweepSurfaceInfo| {
        let mut surface = null_mut();
        let status = unsafe { geosweep_surface_create(solver, info, &mut surface) };
        assert!(surface.is_null());
        status
    };
    let null_buffer = [GeosweepSourceBuffer { count: 1, ..zero() }];
    let no_sources = [GeosweepSourceBuffer { buffer: buffer.handle, ..zero() }];
    let sources = |sources: &[GeosweepSourceBuffer]| GeosweepSurfaceInfo {
        sources: sources.as_ptr(),
        source_count: 1,
        ..good
    };
    let (places, distances) = (buffer.handle, buffer.handle);
    let astray = [GeosweepLookup { places, distances, distances_offset: 3, count: 1, ..zero() }];
    let lookups = GeosweepSurfaceInfo { lookups: astray.as_ptr(), lookup_count: 1, ..good };
    all_wrong! {
        create(&zero()) => "info->slots is 0",
        create(&GeosweepSurfaceInfo { slots: 65, ..good }) => "info->slots is 65",
        create(&GeosweepSurfaceInfo { rows: 0, ..good }) => "rows is 0",
        create(&GeosweepSurfaceInfo { cols: 0, ..good }) => "cols is 0",
        create(&GeosweepSurfaceInfo { edge_rule: 2, ..good }) => "info->edge_rule is 2",
        create(&GeosweepSurfaceInfo { points: null(), ..good }) => "info->points is null",
        create(&GeosweepSurfaceInfo { point_count: 1025, ..good }) => "1025 entries; at most 1024",
        create(&GeosweepSurfaceInfo { queue_family_count: 2, ..good }) => "info->queue_families is null",
        create(&GeosweepSurfaceInfo { source_count: 2, ..good }) => "info->sources is null",
        create(&GeosweepSurfaceInfo { lookup_count: 2, ..good }) => "info->lookups is null",
        create(&GeosweepSurfaceInfo { queue_families: &7777, queue_family_count: 1, ..good })
            => "info->queue_families has 7777, and the device has",
        create(&sources(&null_buffer)) => "null handle",
        create(&sources(&no_sources)) => "its count is 0",
        create(&lookups) => "offset 3",
    }
    let info = GeosweepSurfaceInfo { rows: u32::MAX, cols: u32::MAX, ..good };
    refused(create(&info), GeosweepStatus::TooLarge, "too large");

    let positions = |stride| GeosweepPoints { data: data.as_ptr(), stride, ..zero() };
    let metric = |values: &[f32; 4 * POINTS]| GeosweepPoints {
        kind: 2,
        data: values.as_ptr(),
        ..positions(12)
    };
    let on_device = GeosweepPoints { data: null(), buffer: buffer.handle, ..positions(12) };
    let no_mask = [0u8; POINTS];
    let masked = GeosweepPoints { mask: no_mask.as_ptr(), ..height_points(&data) };
    let mut huge = [1.0; 4 * POINTS];
    huge[3] = 1e13;
    let negative = [-1.0; 4 * POINTS];
    // The second float of each point is a slowness.
    let slow = GeosweepPoints { slowness: 1, stride: 8, ..height_points(&negative) };
    let with = |points: GeosweepPoints| {
        let points = [points];
        create(&GeosweepSurfaceInfo { points: points.as_ptr(), ..good })
    };
    let layout = vk::ImageLayout::GENERAL;
    let view = vk::ImageView::from_raw(1);
    all_wrong! {
        with(zero()) => "info->points[0] must name exactly one of buffer, view and data",
        with(GeosweepPoints { data: data.as_ptr(), ..on_device }) => "must name exactly one",
        with(GeosweepPoints { kind: 3, ..positions(12) }) => "info->points[0].kind is 3",
        with(positions(8)) => "stride is 8: it is a multiple of 4, and a point has 12 bytes",
        with(positions(13)) => "stride is 13",
        with(positions(0)) => "stride is 0",
        with(positions(u64::MAX / 4 * 4)) => "larger than memory",
        with(GeosweepPoints { offset: 2, ..positions(12) }) => "offset is 2",
        with(GeosweepPoints { slowness: 2, ..positions(12) }) => "slowness is 2",
        with(GeosweepPoints { slowness: 3, ..positions(12) }) => "a point has 16 bytes",
        with(GeosweepPoints { slowness: u32::MAX, ..positions(12) }) => "stride is 12",
        with(GeosweepPoints { stride: 8, ..on_device }) => "stride is 8",
        with(GeosweepPoints { offset: 2, ..on_device }) => "offset is 2",
        with(GeosweepPoints { slowness: 5, view, layout, ..zero() }) => "four components",
        with(GeosweepPoints { dx: 0.0, ..height_points(&data) }) => "info->points[0].dx or dy",
        with(GeosweepPoints { dx: 0.5, dy: 0.5, ..positions(12) }) => "dx or dy is not 0, and only heights",
        with(GeosweepPoints { mask: no_mask.as_ptr(), ..on_device }) => "mask is for points in data",
        with(GeosweepPoints { view, layout, mask: no_mask.as_ptr(), ..zero() }) => "mask is for points in data",
        with(GeosweepPoints { view, layout, stride: 16, ..zero() }) => "offset or stride is not 0",
        with(GeosweepPoints { view, ..zero() }) => "layout is 0, in which no image can be read",
        with(GeosweepPoints { dy: f64::NAN, ..height_points(&data) }) => "NaN",
        with(slow) => "slowness -1 at row 0, column 0",
        with(masked) => "no point of the surface is left",
        with(metric(&data)) => "row 0, column 0 is not positive definite",
        with(metric(&huge)) => "data has an entry beyond 1e12 at row 0, column 1",
        with(height_points(&huge)) => "height at row 0, column 3",
    }
    let mut held = 0;
    ok(unsafe { geosweep_solver_bytes(solver, &mut held) });
    // Refused calls hold no memory. A block that was needed once may be kept.
    assert!(held <= 8 << 20, "{held}");
    session.end([buffer]);
}

#[test]
fn refused_calls_record_nothing() {
    let session = Session::new(Host::new());
    let other = {
        let mut solver = null_mut();
        ok(unsafe { geosweep_solver_create(&solver_info(&session.host), &mut solver) });
        solver
    };
    let data = [0.0f32; POINTS];
    let points = [height_points(&data)];
    let surface = session.surface(&surface_info(ROWS, COLS, &points));
    let method = method(GeosweepWavefront::Planar, 4);
    let plan = session.plan(ROWS, COLS, &method);
    let larger = session.plan(ROWS + 2, COLS, &method);
    let mut foreign = null_mut();
    ok(unsafe { geosweep_plan_create(other, ROWS, COLS, &method, &mut foreign) });

    let commands = session.host.commands();
    session.host.begin(commands);
    let at = |row, col| [geosweep_source_at(row, col)];
    let inside = at(1.0, 1.0);
    let good = frame(plan, &inside);
    let record = |frame: GeosweepFrame| unsafe {
        geosweep_record_frame(surface, commands, &frame, null_mut())
    };
    let many = [geosweep_source_at(1.0, 1.0); 1025];
    let outside = at(9.0, 1.0);
    let nowhere = at(f32::NAN, 1.0);
    let late = [GeosweepSource { time: f32::INFINITY, ..inside[0] }];
    let sources = |sources: &[GeosweepSource]| frame(plan, sources).sources;
    let null_sources = GeosweepSources { sources: null(), count: 2, ..zero() };
    let undefined = GeosweepReader { layout: vk::ImageLayout::UNDEFINED, ..COPY };
    let none: GeosweepAccess = zero();
    all_wrong! {
        record(GeosweepFrame { points: 1, ..good }) => "1 point inputs",
        record(GeosweepFrame { slot: 1, ..good }) => "1 slots",
        record(GeosweepFrame { plan: null(), ..good }) => "frame->plan is null",
        record(GeosweepFrame { plan: larger, ..good }) => "another size",
        record(GeosweepFrame { plan: foreign, ..good }) => "another solver",
        record(GeosweepFrame { reader: undefined, ..good }) => "frame->reader.layout is 0",
        record(GeosweepFrame { unreached: 0.0, ..good }) => "frame->unreached is 0",
        record(GeosweepFrame { unreached: f32::NAN, ..good }) => "frame->unreached is NaN",
        record(GeosweepFrame { unreached: 0.3, ..good }) => "frame->unreached is 0.3, which may be a distance",
        record(GeosweepFrame { targets_needed: 7, ..good }) => "frame->targets_needed is 7, and there are 0 targets",
        record(GeosweepFrame { sources: zero(), ..good }) => "0 source buffers",
        record(GeosweepFrame { sources: null_sources, ..good }) => "frame->sources.sources is null",
        record(GeosweepFrame { sources: sources(&many), ..good }) => "1025 entries; at most 1024",
        record(GeosweepFrame { sources: sources(&outside), ..good }) => "9",
        record(GeosweepFrame { sources: sources(&nowhere), ..good }) => "NaN",
        record(GeosweepFrame { sources: sources(&late), ..good }) => "inf",
    }
    unsafe {
        all_wrong! {
            geosweep_record_measure(surface, commands, 3, 0) => "number 3",
            geosweep_record_solve(surface, commands, &null_sources, plan) => "sources->sources is null",
            geosweep_record_solve(surface, commands, &good.sources, larger) => "another size",
            geosweep_record_add(surface, commands, &sources(&outside), plan) => "9",
            geosweep_record_resume(surface, commands, foreign) => "another solver",
            geosweep_record_outcome(surface, commands, 1) => "1 slots",
            geosweep_record_result(surface, commands, 1, COPY, f32::INFINITY, null_mut()) => "1 slots",
            geosweep_record_result(surface, commands, 0, undefined, 1.0, null_mut()) => "layout",
            geosweep_record_result(surface, commands, 0, COPY, 0.0, null_mut()) => "unreached",
            geosweep_record_lookup(surface, commands, 0, -1.0, none, none) => "0 lookups",
            geosweep_surface_result(surface, 1, COPY.layout, &mut zero()) => "1 slots",
            geosweep_surface_outcome(surface, 1, &mut zero()) => "1 slots",
        }
    }
    // A frame can still be recorded into the same command buffer.
    ok(record(good));
    session.host.end(commands);
    session.submit(commands);
    assert!(session.outcome(surface).converged);

    unsafe {
        ok(geosweep_surface_destroy(surface));
        for plan in [plan, larger, foreign] {
            ok(geosweep_plan_destroy(plan));
        }
        ok(geosweep_solver_destroy(other));
    }
    session.end([]);
}

//! Contours and paths: a program in C is compared with [`geosweep::vulkan::embed`] on the same surface. Wrong
//! arguments are refused.

use std::fs;
use std::path::Path;
use std::ptr::{null, null_mut};

use geosweep::Stop;
use geosweep::ash::vk;
use geosweep::capi::*;
use geosweep::surface::Chart;
use geosweep::vulkan::embed::{
    self, Access, ContourFrame, CurveBuffer, CurveRecord, CurveStatus, CurveVertex, Frame,
    LevelInput, PathFrame, PathsInfo, PointKind, PointSource, Points, Reader, SourceInput,
    StartInput, SurfaceInfo,
};
use geosweep::vulkan::{Method, Schedule};
use geosweep::{Spacing, Wavefront};

use crate::build::{Linkage, ROOT, compile, scratch, validated};
use crate::host::{Host, HostBuffer};
use crate::session::{Session, all_wrong, frame, method, ok, surface_info, wrong, zero};

/// Size of the grid in examples/embed.c and tests/capi/curves.c.
const CHART: Chart = Chart { rows: 120, cols: 160 };
const SPACING: f64 = 0.5;
const ROOM: u32 = 6000;
const PATHS: PathsInfo = PathsInfo::new(4, 400);

/// Returns a saddle with a hole. Single precision holds its heights exactly.
fn heights() -> Vec<f32> {
    let height = |index: usize| {
        let (row, col) = CHART.position(index);
        let hole = (70..75).contains(&row) && (60..90).contains(&col);
        let exact = (row as i32 - 60) as f32 * (col as i32 - 80) as f32 / 256.0;
        if hole { f32::NAN } else { exact }
    };
    (0..CHART.points()).map(height).collect()
}

/// Appends the lines that the program in C prints for these curves.
fn lines(name: &str, curves: CurveBuffer, copy: &HostBuffer, expected: &mut Vec<Vec<f32>>) {
    let (records, vertices) = copy.bytes().split_at(curves.vertices_offset as usize);
    for number in 0..curves.curves as usize {
        let record = &records[number * CurveRecord::BYTES as usize..];
        let record: CurveRecord =
            bytemuck::pod_read_unaligned(&record[..CurveRecord::BYTES as usize]);
        let status = match record.status() {
            CurveStatus::Complete => 0,
            CurveStatus::OutOfRoom => 1,
            CurveStatus::Unreached => 2,
            CurveStatus::Outside => 3,
            CurveStatus::Lost => 4,
        };
        println!("{name} {number}: {record:?}");
        let source = record.source().unwrap_or(GEOSWEEP_NO_SOURCE);
        let counts = [status, record.vertex_count, record.first_vertex, record.vertices, source];
        let floats = [record.distance, record.length];
        expected.push(counts.map(|count| count as f32).into_iter().chain(floats).collect());
        let drawn = vertices.chunks_exact(size_of::<CurveVertex>());
        let drawn = drawn.skip(record.first_vertex as usize).take(record.vertex_count as usize);
        for vertex in drawn.map(bytemuck::pod_read_unaligned::<CurveVertex>) {
            let CurveVertex { position: [x, y, z], time, row, col } = vertex;
            expected.push(vec![x, y, z, time, row, col]);
        }
    }
}

/// Returns the records of contours and paths, each followed by its vertices, from the interface in Rust.
fn embedded() -> Vec<Vec<f32>> {
    let mut host = Host::new();
    let device = host.device.clone();
    let passes = [(Schedule::Raster, Wavefront::Curved)];
    let solver = embed::Solver::new(&host.instance, host.physical_device, &device, &passes);
    let mut solver = solver.unwrap();
    let heights = host.buffer_of(&heights());
    let kind = PointKind::Heights(Spacing::square(SPACING));
    let points = [Points { kind, ..Points::positions(heights.handle, 4) }];
    let info = SurfaceInfo::new(CHART).with_points(&points);
    let mut surface = solver.surface(&device, host.allocator(), &info).unwrap();
    let stop = Stop::within(1e-6).or_after(100);
    let method = Method::new(Wavefront::Curved, stop);
    let plan = solver.plan(CHART, method, 12).unwrap();
    let mut contours = solver.contours(&device, host.allocator(), &surface, ROOM).unwrap();
    let mut paths = solver.paths(&device, host.allocator(), &surface, PATHS).unwrap();
    let curves = [contours.curves(), paths.curves()];
    let bytes = curves.map(|curves| {
        let vertices = u64::from(curves.curves * curves.capacity * CurveVertex::BYTES);
        curves.vertices_offset + vertices
    });
    let copies = bytes.map(|bytes| host.buffer(bytes, true));

    let sources = [PointSource::at(100.0, 70.5)];
    let sources = SourceInput::Inline(&sources);
    host.run(|commands| {
        let recording = solver.record(&device, commands, &surface);
        recording.prepare();
        let frame = Frame::new(&plan, sources, Reader::COPY).with_points(0);
        recording.frame(&frame).unwrap();
        let reader = Access::TRANSFER_READ;
        let levels = LevelInput::Spacing { step: 11.5, count: 7 };
        let frame = ContourFrame::new(levels, reader);
        recording.contours(&contours, &frame).unwrap();
        let starts = StartInput::Inline(&[[20.25, 81.5], [0.0, 159.0], [-3.0, 5.0]]);
        let frame = PathFrame::new(starts, sources, reader);
        recording.paths(&paths, &frame).unwrap();
        for (k, copy) in copies.iter().enumerate() {
            let all = [vk::BufferCopy::default().size(bytes[k])];
            unsafe { device.cmd_copy_buffer(commands, curves[k].buffer, copy.handle, &all) };
        }
        host.barrier(commands, Access::TRANSFER_WRITE, Access::HOST_READ);
    });
    let mut expected = Vec::new();
    lines("contours", curves[0], &copies[0], &mut expected);
    lines("path", curves[1], &copies[1], &mut expected);
    contours.destroy(&device, host.allocator());
    paths.destroy(&device, host.allocator());
    surface.destroy(&device, host.allocator());
    solver.destroy(&device);
    copies.into_iter().chain([heights]).for_each(|buffer| host.free(buffer));
    assert_eq!((host.messages(), host.allocations()), (Vec::new(), 0));
    expected
}

/// Both run the same passes, so the results agree to the last digit.
#[test]
fn a_program_in_c_finds_the_contours_and_paths_of_the_rust_side() {
    let folder = scratch("curves");
    let source = fs::read_to_string(Path::new(ROOT).join("tests/capi/curves.c")).unwrap();
    let source = source.replace("examples/embed.c", &format!("{ROOT}/examples/embed.c"));
    fs::write(folder.join("curves.c"), source).unwrap();
    compile(&folder.join("curves.c"), &folder.join("curves"), Linkage::Shared);
    let run = validated(&folder.join("curves"));
    assert_eq!(run.findings, Vec::<String>::new());
    let printed: Vec<Vec<f32>> = run
        .printed
        .lines()
        .filter(|line| ["contours ", "path ", "vertex "].iter().any(|name| line.starts_with(name)))
        .map(|line| line.split(' ').skip(1).map(|number| number.parse().unwrap()).collect())
        .collect();
    let expected = embedded();
    // The records are those of the contours, two paths, a path that starts outside, and a path without a start.
    let records: Vec<_> = expected.iter().filter(|line| line.len() == 7).collect();
    let statuses: Vec<_> = records.iter().map(|record| record[0]).collect();
    assert_eq!(statuses, [0.0, 0.0, 0.0, 3.0, 3.0]);
    assert!(records[0][1] > 1000.0 && records[1][1] > 80.0, "{records:?}");
    assert_eq!(printed.len(), expected.len());
    for (k, (printed, expected)) in printed.iter().zip(&expected).enumerate() {
        assert_eq!(printed, expected, "line {k}");
    }
}

const ROWS: u32 = 9;
const COLS: u32 = 13;

/// Returns flat heights in the program's memory.
fn flat(data: &[f32]) -> GeosweepPoints {
    let kind = GeosweepPointKind::Heights as i32;
    GeosweepPoints { kind, dx: 1.0, dy: 1.0, data: data.as_ptr(), stride: 4, ..zero() }
}

fn copied_from() -> GeosweepAccess {
    let Access { stages, access } = Access::TRANSFER_READ;
    GeosweepAccess { stages, access }
}

/// Each wrong argument gives a status and a message that names it, and records nothing.
#[test]
fn unusable_arguments_are_named() {
    let session = Session::new(Host::new());
    let solver = session.solver;
    let data = [0.0f32; (ROWS * COLS) as usize];
    let points = [flat(&data)];
    let surface = session.surface(&surface_info(ROWS, COLS, &points));
    let other = session.surface(&surface_info(ROWS, COLS, &points));
    let (mut contours, mut paths) = (null_mut(), null_mut());
    let (mut none, mut nothing) = (null_mut(), null_mut());
    let (mut bytes, mut curves, mut record) = (0, zero(), zero());
    let no_surface: *const GeosweepSurface = null();
    unsafe {
        ok(geosweep_contours_create(surface, 100, &mut contours));
        ok(geosweep_paths_create(surface, 2, 50, &mut paths));
        all_wrong! {
            geosweep_contours_bytes_for(null(), 9, 9, 10, &mut bytes) => "solver is null",
            geosweep_contours_bytes_for(solver, 0, 9, 10, &mut bytes) => "rows is 0",
            geosweep_contours_bytes_for(solver, 9, 9, 1, &mut bytes) => "too few for a line",
            geosweep_contours_bytes_for(solver, 9, 9, 10, null_mut()) => "bytes is null",
            geosweep_contours_create(no_surface, 100, &mut none) => "surface is null",
            geosweep_contours_create(surface, 100, null_mut()) => "contours is null",
            geosweep_contours_create(surface, 1, &mut none) => "too few for a line",
            geosweep_contours_create(surface, u32::MAX, &mut none) => "shaders see",
            geosweep_contours_bytes(null(), &mut bytes) => "contours is null",
            geosweep_contours_bytes(contours, null_mut()) => "bytes is null",
            geosweep_contours_curves(null(), &mut curves) => "contours is null",
            geosweep_contours_curves(contours, null_mut()) => "curves is null",
            geosweep_paths_bytes_for(null(), 1, 9, &mut bytes) => "solver is null",
            geosweep_paths_bytes_for(solver, 0, 9, &mut bytes) => "number of paths is 0",
            geosweep_paths_bytes_for(solver, 1, 9, null_mut()) => "bytes is null",
            geosweep_paths_create(no_surface, 1, 9, &mut nothing) => "surface is null",
            geosweep_paths_create(surface, 1, 9, null_mut()) => "paths is null",
            geosweep_paths_create(surface, 65_536, 9, &mut nothing) => "number of paths is 65536",
            geosweep_paths_create(surface, 1, 1, &mut nothing) => "too few for a line",
            geosweep_paths_bytes(null(), &mut bytes) => "paths is null",
            geosweep_paths_bytes(paths, null_mut()) => "bytes is null",
            geosweep_paths_curves(null(), &mut curves) => "paths is null",
            geosweep_paths_curves(paths, null_mut()) => "curves is null",
            geosweep_curve_record_from_bytes(null(), &mut record) => "bytes is null",
            geosweep_curve_record_from_bytes([0; 36].as_ptr(), null_mut()) => "record is null",
        }
        ok(geosweep_contours_destroy(null_mut()));
        ok(geosweep_paths_destroy(null_mut()));
    }
    assert!(none.is_null() && nothing.is_null());
    let too_large = unsafe { geosweep_contours_bytes_for(solver, u32::MAX, 9, 10, &mut bytes) };
    assert_eq!(too_large, GeosweepStatus::TooLarge);

    let plan = session.plan(ROWS, COLS, &method(GeosweepWavefront::Curved, 6));
    let source = [geosweep_source_at(4.0, 6.0)];
    let frame = frame(plan, &source);
    let commands = session.host.commands();
    session.host.begin(commands);
    ok(unsafe { geosweep_record_frame(surface, commands, &frame, null_mut()) });
    let list = [1.0, 2.0];
    let falling = [2.0, 1.0];
    let (levels, level_count) = (list.as_ptr(), 2);
    let good = GeosweepContourFrame { levels, level_count, reader: copied_from(), ..zero() };
    let contour = |frame: GeosweepContourFrame| unsafe {
        geosweep_record_contours(surface, commands, contours, &frame, null_mut())
    };
    let spaced = GeosweepContourFrame { levels: null(), ..good };
    let places = [4.0, 0.0, 1.5, f32::NAN];
    let sources = frame.sources;
    let (starts, start_count) = (places.as_ptr(), 2);
    let path_frame =
        GeosweepPathFrame { starts, start_count, sources, reader: copied_from(), ..zero() };
    let path = |frame: GeosweepPathFrame| unsafe {
        geosweep_record_paths(surface, commands, paths, &frame, null_mut())
    };
    unsafe { ok(geosweep_contours_curves(contours, &mut curves)) };
    let start_buffer = curves.buffer;
    let in_buffer = GeosweepPathFrame { starts: null(), start_buffer, ..path_frame };
    let no_sources = GeosweepSources { sources: null(), count: 2, ..zero() };
    let (record_contours, record_paths) = (geosweep_record_contours, geosweep_record_paths);
    unsafe {
        all_wrong! {
            record_contours(null(), commands, contours, &good, &mut curves) => "surface is null",
            record_contours(surface, commands, null(), &good, &mut curves) => "contours is null",
            record_contours(surface, commands, contours, null(), &mut curves) => "frame is null",
            record_contours(other, commands, contours, &good, &mut curves) => "another surface",
            contour(GeosweepContourFrame { step: 1.0, ..good }) => "frame->step is 1",
            contour(GeosweepContourFrame { step: f32::NAN, ..spaced }) => "NaN apart",
            contour(spaced) => "2 levels cannot be 0 apart",
            contour(GeosweepContourFrame { level_count: 1025, ..good }) => "1025 entries",
            contour(GeosweepContourFrame { level_count: 1025, step: 1.0, ..spaced }) => "1025",
            contour(GeosweepContourFrame { levels: falling.as_ptr(), ..good }) => "comes before 1",
            contour(GeosweepContourFrame { points: 1, ..good }) => "number 1",
            record_paths(null(), commands, paths, &path_frame, &mut curves) => "surface is null",
            record_paths(surface, commands, null(), &path_frame, &mut curves) => "paths is null",
            record_paths(surface, commands, paths, null(), &mut curves) => "frame is null",
            record_paths(other, commands, paths, &path_frame, &mut curves) => "another surface",
            path(GeosweepPathFrame { starts: null(), ..path_frame }) => "frame->starts is null",
            path(GeosweepPathFrame { start_count: 3, ..path_frame }) => "3 starts",
            path(GeosweepPathFrame { start_count: 8193, ..path_frame }) => "8193 entries",
            path(GeosweepPathFrame { start_buffer, ..path_frame }) => "frame->start_buffer are both",
            path(GeosweepPathFrame { start_offset: 2, ..in_buffer }) => "offset 2",
            path(GeosweepPathFrame { sources: no_sources, ..path_frame }) => "sources is null",
            path(GeosweepPathFrame { points: 1, ..path_frame }) => "number 1",
        }
    }
    // Valid calls can still use the same command buffer.
    ok(contour(good));
    ok(path(path_frame));
    ok(contour(GeosweepContourFrame { step: 0.5, ..spaced }));
    ok(path(GeosweepPathFrame { starts: null(), start_count: 0, ..path_frame }));
    session.host.end(commands);
    session.host.submit(commands, vk::Fence::null());
    unsafe { session.host.device.device_wait_idle() }.unwrap();
    assert!(session.outcome(surface).converged);
    unsafe {
        ok(geosweep_surface_destroy(surface));
        ok(geosweep_surface_destroy(other));
        ok(geosweep_plan_destroy(plan));
        wrong(
            geosweep_solver_destroy(solver),
            "still has 2 surfaces, plans, contours, paths, regions, directions, log maps or profiles",
        );
        ok(geosweep_contours_destroy(contours));
        ok(geosweep_paths_destroy(paths));
    }
    session.end([]);
}

/// Starts that shaders or copies have written to a buffer lead to the same paths as an array.
#[test]
fn starts_come_from_a_buffer_too() {
    let mut session = Session::new(Host::new());
    let data = [0.0f32; (ROWS * COLS) as usize];
    let points = [flat(&data)];
    let surface = session.surface(&surface_info(ROWS, COLS, &points));
    let mut paths = null_mut();
    ok(unsafe { geosweep_paths_create(surface, 2, 50, &mut paths) });
    let plan = session.plan(ROWS, COLS, &method(GeosweepWavefront::Curved, 6));
    let source = [geosweep_source_at(4.0, 6.0)];
    let frame = frame(plan, &source);
    let places = [0.0, 1.0, 8.0, 12.0];
    let buffer = session.host.buffer_of(&[9.0, places[0], places[1], places[2], places[3]]);
    let inline = GeosweepPathFrame {
        starts: places.as_ptr(),
        start_count: 2,
        sources: frame.sources,
        reader: copied_from(),
        ..zero()
    };
    let (start_buffer, start_offset) = (buffer.handle, 4);
    let in_buffer = GeosweepPathFrame { starts: null(), start_buffer, start_offset, ..inline };
    let copy = session.host.buffer(2 * u64::from(GEOSWEEP_CURVE_RECORD_BYTES), true);
    let host = &session.host;
    for path_frame in [inline, in_buffer] {
        host.run(|commands| unsafe {
            let mut strips: GeosweepCurves = zero();
            ok(geosweep_record_frame(surface, commands, &frame, null_mut()));
            ok(geosweep_record_paths(surface, commands, paths, &path_frame, &mut strips));
            assert_eq!((strips.curves, strips.capacity), (2, 50));
            let records = [vk::BufferCopy::default().size(72)];
            host.device.cmd_copy_buffer(commands, strips.buffer, copy.handle, &records);
            host.barrier(commands, Access::TRANSFER_WRITE, Access::HOST_READ);
        });
        for (number, place) in places.chunks(2).enumerate() {
            let bytes = &copy.bytes()[36 * number..];
            let mut record: GeosweepCurveRecord = zero();
            ok(unsafe { geosweep_curve_record_from_bytes(bytes.as_ptr(), &mut record) });
            assert_eq!((record.status, record.source), (GeosweepCurveStatus::Complete, 0));
            let exact = f32::hypot(place[0] - 4.0, place[1] - 6.0);
            assert!((record.length - exact).abs() < 1e-4 * exact, "{record:?}");
            assert!((record.distance - exact).abs() < 1e-4 * exact, "{record:?}");
        }
    }
    unsafe {
        ok(geosweep_paths_destroy(paths));
        ok(geosweep_surface_destroy(surface));
        ok(geosweep_plan_destroy(plan));
    }
    session.end([buffer, copy]);
}

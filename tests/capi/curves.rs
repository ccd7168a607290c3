//! Contours and paths on a plane, from a program's arrays and buffers. Wrong arguments are refused.

use std::ptr::{null, null_mut};

use geosweep::ash::vk;
use geosweep::vulkan::embed::Access;
use geosweep_capi::*;

use crate::host::{Host, HostBuffer};
use crate::session::{
    COPY, Session, all_wrong, destroy, frame, height_points, method, ok, surface_info, wrong, zero,
};

const ROWS: u32 = 9;
const COLS: u32 = 13;

/// Each wrong argument gives a status and a message that names it, and records nothing.
#[test]
fn unusable_arguments_are_named() {
    let session = Session::new(Host::new());
    let solver = session.solver;
    let data = [0.0f32; (ROWS * COLS) as usize];
    let points = [height_points(&data)];
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
    let good = GeosweepContourFrame { levels, level_count, reader: COPY.access, ..zero() };
    let contour = |frame: GeosweepContourFrame| unsafe {
        geosweep_record_contours(surface, commands, contours, &frame, null_mut())
    };
    let spaced = GeosweepContourFrame { levels: null(), ..good };
    let places = [4.0, 0.0, 1.5, f32::NAN];
    let sources = frame.sources;
    let (starts, start_count) = (places.as_ptr(), 2);
    let path_frame =
        GeosweepPathFrame { starts, start_count, sources, reader: COPY.access, ..zero() };
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
            contour(GeosweepContourFrame { step: 1.0, start: f32::NAN, ..spaced }) => "start NaN of the map is not finite",
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
    session.submit(commands);
    assert!(session.outcome(surface).converged);
    destroy!(
        geosweep_surface_destroy(surface),
        geosweep_surface_destroy(other),
        geosweep_plan_destroy(plan),
    );
    wrong(unsafe { geosweep_solver_destroy(solver) }, "still has 2 surfaces, plans, contours");
    destroy!(geosweep_contours_destroy(contours), geosweep_paths_destroy(paths));
    session.end([]);
}

/// Returns a record and its vertices: x, y, z, time, row and column.
fn curve(
    curves: &GeosweepCurves,
    copy: &HostBuffer,
    number: usize,
) -> (GeosweepCurveRecord, Vec<[f32; 6]>) {
    let bytes = &copy.bytes()[GEOSWEEP_CURVE_RECORD_BYTES as usize * number..];
    let mut record: GeosweepCurveRecord = zero();
    ok(unsafe { geosweep_curve_record_from_bytes(bytes.as_ptr(), &mut record) });
    // A record begins with the arguments of its draw.
    let draw = bytemuck::pod_read_unaligned::<[u32; 4]>(&bytes[..16]);
    assert_eq!(draw, [record.vertex_count, 1, record.first_vertex, 0]);
    let vertices = copy.bytes()[curves.vertices_offset as usize..].chunks_exact(24);
    let own = vertices.skip(record.first_vertex as usize).take(record.vertex_count as usize);
    (record, own.map(bytemuck::pod_read_unaligned).collect())
}

/// Paths start at places in an array or in a buffer. Curves lie in buffers of the stated sizes, as records and vertices.
#[test]
fn curves_of_a_plane_are_circles_and_rays() {
    let mut session = Session::new(Host::new());
    let data = [0.0f32; (ROWS * COLS) as usize];
    let points = [height_points(&data)];
    let surface = session.surface(&surface_info(ROWS, COLS, &points));
    let (mut contours, mut paths) = (null_mut(), null_mut());
    let (mut lines, mut strips) = (zero::<GeosweepCurves>(), zero::<GeosweepCurves>());
    let (mut stated, mut taken) = ([0; 2], [0; 2]);
    unsafe {
        ok(geosweep_contours_create(surface, 300, &mut contours));
        ok(geosweep_paths_create(surface, 3, 50, &mut paths));
        ok(geosweep_contours_bytes_for(session.solver, ROWS, COLS, 300, &mut stated[0]));
        ok(geosweep_paths_bytes_for(session.solver, 3, 50, &mut stated[1]));
        ok(geosweep_contours_bytes(contours, &mut taken[0]));
        ok(geosweep_paths_bytes(paths, &mut taken[1]));
        ok(geosweep_contours_curves(contours, &mut lines));
        ok(geosweep_paths_curves(paths, &mut strips));
    }
    assert!(stated == taken && stated[0] > 0, "{stated:?} {taken:?}");
    assert_eq!((strips.curves, strips.capacity, lines.capacity), (3, 50, 300));
    let plan = session.plan(ROWS, COLS, &method(GeosweepWavefront::Curved, 6));
    let source = [geosweep_source_at(4.0, 6.0)];
    let frame = frame(plan, &source);
    let places = [0.0, 1.0, 8.0, 12.0];
    let buffer = session.host.buffer_of(&[9.0, places[0], places[1], places[2], places[3]]);
    let inline = GeosweepPathFrame {
        starts: places.as_ptr(),
        start_count: 2,
        sources: frame.sources,
        reader: COPY.access,
        ..zero()
    };
    let (start_buffer, start_offset) = (buffer.handle, 4);
    let in_buffer = GeosweepPathFrame { starts: null(), start_buffer, start_offset, ..inline };
    let levels = [1.5, 2.5];
    let contour_frame = GeosweepContourFrame {
        levels: levels.as_ptr(),
        level_count: 2,
        reader: COPY.access,
        ..zero()
    };
    let sizes = [lines, strips].map(|curves| {
        curves.vertices_offset + 24 * u64::from(curves.curves) * u64::from(curves.capacity)
    });
    let copies = sizes.map(|bytes| session.host.buffer(bytes, true));
    for path_frame in [inline, in_buffer] {
        session.host.run(|commands| unsafe {
            ok(geosweep_record_frame(surface, commands, &frame, null_mut()));
            ok(geosweep_record_contours(surface, commands, contours, &contour_frame, &mut lines));
            ok(geosweep_record_paths(surface, commands, paths, &path_frame, &mut strips));
            for (k, curves) in [lines, strips].iter().enumerate() {
                let all = [vk::BufferCopy::default().size(sizes[k])];
                let (from, to) = (curves.buffer, copies[k].handle);
                session.host.device.cmd_copy_buffer(commands, from, to, &all);
            }
            session.host.barrier(commands, Access::TRANSFER_WRITE, Access::HOST_READ);
        });
        let near = |found: f32, exact: f32, most: f32| {
            assert!((found - exact).abs() < most, "{found} {exact}");
        };
        // Contours are segments of all levels.
        let (record, vertices) = curve(&lines, &copies[0], 0);
        assert!(
            record.status == GeosweepCurveStatus::Complete && vertices.len() > 20,
            "{record:?}"
        );
        for [x, y, z, time, row, col] in vertices {
            near(x, col, 1e-5);
            near(y, row, 1e-5);
            assert!(z == 0.0 && levels.contains(&time), "{z} {time}");
            near(f32::hypot(row - 4.0, col - 6.0), time, 0.1);
        }
        for (number, place) in places.chunks(2).enumerate() {
            let (record, vertices) = curve(&strips, &copies[1], number);
            assert_eq!((record.status, record.source), (GeosweepCurveStatus::Complete, 0));
            assert_eq!(vertices[0][4..], *place);
            assert_eq!(vertices[vertices.len() - 1][4..], [4.0, 6.0]);
            let exact = f32::hypot(place[0] - 4.0, place[1] - 6.0);
            near(record.length, exact, 1e-3);
            near(record.distance, exact, 1e-3);
        }
        // The third path has no start.
        assert_eq!(curve(&strips, &copies[1], 2).0.status, GeosweepCurveStatus::Outside);
    }
    destroy!(
        geosweep_contours_destroy(contours),
        geosweep_paths_destroy(paths),
        geosweep_surface_destroy(surface),
        geosweep_plan_destroy(plan),
    );
    session.end([buffer].into_iter().chain(copies));
}

//! Maps through the functions of C are compared with the CPU engine on the same surface, for all kinds of
//! points. Nothing is left behind after a map.

use geosweep::ash::vk;
use geosweep::capi::*;
use geosweep::glam::DVec3;
use geosweep::surface::{Chart, Geometry};
use geosweep::{MetricTensor, Sources, Spacing, Surface, Wavefront};

use crate::common::parts::assert_is_part;
use crate::common::{CONVERGED, difference, on_cpu};
use crate::host::Host;
use crate::session::{
    COPY, Session, frame, last_error, method, ok, refused, surface_info, wrong, zero,
};

const CHART: Chart = Chart { rows: 31, cols: 45 };
const ROWS: u32 = CHART.rows as u32;
const COLS: u32 = CHART.cols as u32;
/// Rounding between engines, as in the tests of the headless solver.
const SAME: f64 = 1e-5;
const WAVEFRONTS: [(GeosweepWavefront, Wavefront); 4] = [
    (GeosweepWavefront::Planar, Wavefront::Planar),
    (GeosweepWavefront::Circular, Wavefront::Circular),
    (GeosweepWavefront::Curved, Wavefront::Curved),
    (GeosweepWavefront::Anchored, Wavefront::Anchored),
];
/// Index of a point in a hole of the mask.
const MASKED: usize = 12 * CHART.cols + 20;

/// Returns a wavy surface with five floats per point, after three other floats: a position, an unused float
/// and a slowness.
fn vertices() -> Vec<f32> {
    let vertex = |index: usize| {
        let (row, col) = CHART.position(index);
        let (x, y) = (col as f32, 1.2 * row as f32);
        let z = 2.0 * (0.3 * x).sin() * (0.2 * y).cos();
        [x, y, z, f32::NAN, 1.0 + 0.02 * (index % 7) as f32]
    };
    let vertices = (0..CHART.points()).flat_map(vertex);
    [9.0; 3].into_iter().chain(vertices).collect()
}

fn mask() -> Vec<u8> {
    (0..CHART.points()).map(|index| u8::from(index != MASKED)).collect()
}

fn positions(vertices: &[f32]) -> Surface {
    let position = |v: &[f32]| DVec3::new(v[0].into(), v[1].into(), v[2].into());
    let positions = vertices[3..].chunks(5).map(position).collect();
    let slowness = vertices[3..].chunks(5).map(|v| v[4].into()).collect();
    let surface = Surface::from_positions(CHART.rows, CHART.cols, positions).unwrap();
    let mask: Vec<_> = mask().iter().map(|&keep| keep != 0).collect();
    surface.with_mask(&mask).unwrap().with_slowness(slowness).unwrap()
}

/// Points of all kinds in the program's memory, and positions in a buffer, with a mask, a slowness, an
/// offset, a stride and all wavefronts. Other points replace them afterwards.
#[test]
fn all_kinds_of_points_give_the_map_of_the_cpu() {
    let mut vertices = vertices();
    let mask = mask();
    let heights: Vec<_> = vertices[3..].chunks(5).map(|v| v[2]).collect();
    let tensor = |index: usize| {
        let (row, col) = CHART.position(index);
        let rr = if index == MASKED { f32::NAN } else { 1.0 + 0.02 * row as f32 };
        [rr, 0.3 * (0.1 * col as f32).sin(), 2.0 - 0.03 * col as f32]
    };
    let metric: Vec<_> = (0..CHART.points()).flat_map(tensor).collect();

    let mut session = Session::new(Host::new());
    let on_device: Vec<_> = {
        let mut on_device = vertices.clone();
        on_device[3 + 5 * MASKED] = f32::NAN;
        on_device
    };
    let buffer = session.host.buffer_of(&on_device);
    let points = [
        GeosweepPoints {
            kind: GeosweepPointKind::Positions as i32,
            slowness: 4,
            data: vertices.as_ptr(),
            mask: mask.as_ptr(),
            offset: 12,
            stride: 20,
            ..zero()
        },
        GeosweepPoints { slowness: 4, buffer: buffer.handle, offset: 12, stride: 20, ..zero() },
        GeosweepPoints {
            kind: GeosweepPointKind::Heights as i32,
            dx: 0.7,
            dy: 1.1,
            data: heights.as_ptr(),
            stride: 4,
            ..zero()
        },
        GeosweepPoints {
            kind: GeosweepPointKind::Metric as i32,
            data: metric.as_ptr(),
            stride: 12,
            ..zero()
        },
    ];
    let spacing = Spacing { dx: 0.7, dy: 1.1 };
    let as_heights = heights.iter().map(|&height| height.into()).collect();
    let as_metric = metric.chunks(3).map(|m| {
        let [rr, rc, cc] = [m[0], m[1], m[2]].map(f64::from);
        MetricTensor { rr, rc, cc }
    });
    let surfaces = [
        positions(&vertices),
        positions(&vertices),
        Surface::from_heights(CHART.rows, CHART.cols, as_heights, spacing).unwrap(),
        Surface::from_metric(CHART.rows, CHART.cols, as_metric.collect()).unwrap(),
    ];
    let info = surface_info(ROWS, COLS, &points);
    let surface = session.surface(&info);
    let sources = [geosweep_source_at(3.0, 40.0)];
    let compare = |session: &mut Session, number: usize, truth: &Surface| {
        for (ours, wavefront) in WAVEFRONTS {
            let plan = session.plan(ROWS, COLS, &method(ours, 12));
            let frame = GeosweepFrame { points: number as u32, ..frame(plan, &sources) };
            let map = session.map(surface, &frame);
            assert!(session.outcome(surface).converged);
            let seeds = Sources::point(3.0, 40.0).seeds(truth).unwrap();
            // If a surface has points with a slowness, planar fronts take the place of circular ones.
            let is_circular = wavefront == Wavefront::Circular;
            let solved = if is_circular { Wavefront::Planar } else { wavefront };
            let exact = on_cpu(truth, &seeds, solved, CONVERGED);
            let difference = difference(&map, &exact);
            // In a frame, the curvature of a metric is computed from edges and not from its tensors.
            let is_metric = matches!(truth.geometry(), Geometry::Metric(_));
            let most = if is_metric && !is_circular { 1e-4 } else { SAME };
            assert!(difference < most, "{number}, {wavefront}: {difference}");
            ok(unsafe { geosweep_plan_destroy(plan) });
        }
    };
    for (number, truth) in surfaces.iter().enumerate() {
        compare(&mut session, number, truth);
    }

    // The arrays are not needed after the call that takes them.
    for vertex in vertices[3..].chunks_mut(5) {
        vertex[2] *= -2.0;
    }
    ok(unsafe { geosweep_surface_write_points(surface, 0, vertices.as_ptr(), mask.as_ptr()) });
    compare(&mut session, 0, &positions(&vertices));
    vertices[3] = f32::INFINITY;
    let write = |number, data| unsafe {
        geosweep_surface_write_points(surface, number, data, mask.as_ptr())
    };
    wrong(write(0, vertices.as_ptr()), "row 0, column 0 is infinite");
    wrong(write(0, std::ptr::null()), "data is null");
    wrong(write(1, vertices.as_ptr()), "memory of yours");
    wrong(write(4, vertices.as_ptr()), "there are 4 points");
    // A refused call has changed nothing.
    vertices[3] = 0.0;
    compare(&mut session, 0, &positions(&vertices));

    ok(unsafe { geosweep_surface_destroy(surface) });
    session.end([buffer]);
}

/// A map in parts, over several command buffers, with sources in a buffer, added sources, lookups and a
/// copied outcome.
#[test]
fn a_map_in_parts_is_the_map_of_one_frame() {
    let mut session = Session::new(Host::new());
    let vertices = vertices();
    let host = &mut session.host;
    let buffer = host.buffer_of(&vertices);
    let nan = f32::NAN;
    // The buffer has two sources and an unused entry.
    let first = geosweep_source_at(0.0, 0.0);
    let more = [nan, nan, 0.0, 0.0, 30.0, 44.0, 0.0, first.curvature];
    let more = host.buffer_of(&more);
    let places = host.buffer_of(&[0.0, 44.0, 15.0, 20.0, -1.0, 3.0]);
    let found = host.buffer(12, true);
    let record = host.buffer(u64::from(GEOSWEEP_OUTCOME_BYTES), true);
    let points = [GeosweepPoints { buffer: buffer.handle, offset: 12, stride: 20, ..zero() }];
    let sources = [GeosweepSourceBuffer { buffer: more.handle, offset: 0, count: 2 }];
    let lookups =
        [GeosweepLookup { places: places.handle, distances: found.handle, count: 3, ..zero() }];
    let info = GeosweepSurfaceInfo {
        sources: sources.as_ptr(),
        source_count: 1,
        lookups: lookups.as_ptr(),
        lookup_count: 1,
        ..surface_info(ROWS, COLS, &points)
    };
    let mut bytes = [0; 2];
    ok(unsafe { geosweep_surface_bytes_for(session.solver, &info, &mut bytes[0]) });
    let surface = session.surface(&info);
    ok(unsafe { geosweep_surface_bytes(surface, &mut bytes[1]) });
    assert_eq!(bytes[0], bytes[1]);
    let mut held = 0;
    ok(unsafe { geosweep_solver_bytes(session.solver, &mut held) });
    assert!(held >= bytes[0], "{held} {bytes:?}");

    let both = [first, geosweep_source_at(30.0, 44.0)];
    let whole = session.plan(ROWS, COLS, &method(GeosweepWavefront::Curved, 12));
    let exact = session.map(surface, &frame(whole, &both));
    assert!(session.outcome(surface).converged);

    let single = session.plan(ROWS, COLS, &method(GeosweepWavefront::Curved, 1));
    let mut iterations = 0;
    ok(unsafe { geosweep_plan_iterations(single, &mut iterations) });
    assert_eq!(iterations, 1);
    let anchored = session.plan(ROWS, COLS, &method(GeosweepWavefront::Anchored, 1));
    for plan in [single, anchored] {
        let mut wavefront = -1;
        ok(unsafe { geosweep_plan_wavefront(plan, &mut wavefront) });
        assert_eq!(wavefront, GeosweepWavefront::Curved as i32);
    }
    ok(unsafe { geosweep_plan_destroy(anchored) });
    let none: GeosweepAccess = zero();
    let after =
        GeosweepAccess { stages: vk::PipelineStageFlags::HOST, access: vk::AccessFlags::HOST_READ };
    let inline = GeosweepSources { sources: both.as_ptr(), count: 1, ..zero() };
    let from_buffer: GeosweepSources = zero();
    let (mut parts, mut map) = (0, Vec::new());
    for start in [&inline, &from_buffer] {
        let mut goes_on = false;
        while !goes_on || !session.outcome(surface).converged {
            map = session.read(|commands, image| unsafe {
                ok(geosweep_record_begin(surface, commands, none));
                if goes_on {
                    ok(geosweep_record_resume(surface, commands, single));
                } else if std::ptr::eq(start, &inline) {
                    ok(geosweep_record_measure(surface, commands, 0, 0));
                    ok(geosweep_record_solve(surface, commands, start, single));
                } else {
                    ok(geosweep_record_add(surface, commands, start, single));
                }
                ok(geosweep_record_outcome(surface, commands, 0));
                let (buffer, unreached) = (record.handle, f32::INFINITY);
                ok(geosweep_record_outcome_to(surface, commands, buffer, 0, after));
                ok(geosweep_record_lookup(surface, commands, 0, -1.0, none, after));
                geosweep_record_result(surface, commands, 0, COPY, unreached, image)
            });
            let mut outcome: GeosweepOutcome = zero();
            ok(unsafe {
                geosweep_outcome_from_bytes(surface, record.bytes().as_ptr(), &mut outcome)
            });
            let own = session.outcome(surface);
            assert_eq!((outcome.iterations, outcome.converged), (own.iterations, own.converged));
            (goes_on, parts) = (true, parts + 1);
        }
    }
    assert!(parts > 3, "{parts}");
    // Added sources start on a map that has already converged, so that the last digits may differ.
    let difference = difference(&map, &exact);
    assert!(difference < SAME, "{difference}");
    assert_eq!(&found.floats()[..3], &[map[44], map[15 * CHART.cols + 20], -1.0]);

    // The surface describes the image that recordings return.
    let (mut image, mut packed) = (zero::<GeosweepImage>(), zero::<GeosweepPackedTimes>());
    ok(unsafe { geosweep_surface_result(surface, 0, COPY.layout, &mut image) });
    assert_eq!((image.extent.width, image.extent.height), (COLS, ROWS));
    assert_eq!((image.format, image.layout), (vk::Format::R32_SFLOAT, COPY.layout));
    ok(unsafe { geosweep_surface_packed(surface, &mut packed) });
    assert_eq!(packed.image.format, vk::Format::R32G32B32A32_SFLOAT);
    assert!(packed.image.extent.width >= COLS / 2 + 2 * packed.border);
    session.host.run(|commands| ok(unsafe { geosweep_record_end(surface, commands, after) }));

    // A solver must outlive the objects that it has created.
    let destroy = |solver| unsafe { geosweep_solver_destroy(solver) };
    refused(
        destroy(session.solver),
        GeosweepStatus::InvalidArgument,
        "still has 3 surfaces, plans",
    );
    ok(unsafe { geosweep_plan_destroy(whole) });
    ok(unsafe { geosweep_plan_destroy(single) });
    wrong(destroy(session.solver), "still has 1 surfaces, plans");
    ok(unsafe { geosweep_surface_destroy(surface) });
    assert!(last_error().contains("has 1"), "a success leaves the message");
    session.end([buffer, more, places, found, record]);
}

/// A frame with a radius or with targets gives the part of the whole map within that limit, in no more visits.
#[test]
fn frames_end_at_a_radius_or_at_targets() {
    let mut session = Session::new(Host::new());
    let buffer = session.host.buffer_of(&vertices());
    let points = [GeosweepPoints { buffer: buffer.handle, offset: 12, stride: 20, ..zero() }];
    let surface = session.surface(&surface_info(ROWS, COLS, &points));
    let plan = session.plan(ROWS, COLS, &method(GeosweepWavefront::Planar, 12));
    let sources = [geosweep_source_at(3.0, 40.0)];
    let frame = frame(plan, &sources);
    let whole = session.map(surface, &frame);
    let all = session.outcome(surface).visits;
    let target = GeosweepTarget { row: 9, col: 30 };
    let end = whole[CHART.index(9, 30)];
    let limits = [
        GeosweepFrame { radius: end, ..frame },
        GeosweepFrame { targets: &target, target_count: 1, ..frame },
    ];
    for (limited, what) in limits.iter().zip(["radius", "target"]) {
        let near = session.map(surface, limited);
        assert!(session.outcome(surface).converged, "{what}");
        assert!(session.outcome(surface).visits <= all, "{what}");
        assert_is_part(&near, &whole, end.into(), what);
    }
    let mut refused = |limited: GeosweepFrame, words: &str| {
        let (host, mut image) = (&mut session.host, zero());
        let commands = host.commands();
        host.begin(commands);
        wrong(unsafe { geosweep_record_frame(surface, commands, &limited, &mut image) }, words);
        host.end(commands);
    };
    refused(GeosweepFrame { radius: f32::NAN, ..frame }, "the radius NaN is not positive");
    refused(GeosweepFrame { target_count: 2, ..frame }, "frame->targets is null");
    let target = GeosweepTarget { row: ROWS, col: 0 };
    let off = GeosweepFrame { targets: &target, target_count: 1, ..frame };
    refused(off, "is outside the");
    ok(unsafe { geosweep_plan_destroy(plan) });
    ok(unsafe { geosweep_surface_destroy(surface) });
    session.end([buffer]);
}

//! Maps through the functions of C, for all kinds of points and wavefronts, in parts, and with limits. Nothing is left
//! behind after a map.

use geosweep::ash::vk;
use geosweep_capi::*;

use crate::common::difference;
use crate::common::parts::assert_is_part;
use crate::host::Host;
use crate::session::{
    COPY, Session, all_wrong, frame, height_points, last_error, method, ok, refused, surface_info,
    wrong, zero,
};

const ROWS: u32 = 31;
const COLS: u32 = 45;
const POINTS: usize = (ROWS * COLS) as usize;
/// Rounding between engines, as in the tests of the headless solver.
const SAME: f64 = 1e-5;
const WAVEFRONTS: [GeosweepWavefront; 4] = [
    GeosweepWavefront::Planar,
    GeosweepWavefront::Circular,
    GeosweepWavefront::Curved,
    GeosweepWavefront::Anchored,
];

fn place(index: usize) -> (f32, f32) {
    ((index / COLS as usize) as f32, (index % COLS as usize) as f32)
}

/// Returns a wavy surface with five floats per point, after three other floats: a position, an unused float
/// and a slowness.
fn vertices() -> Vec<f32> {
    let vertex = |index: usize| {
        let (row, col) = place(index);
        let (x, y) = (col, 1.2 * row);
        let z = 2.0 * (0.3 * x).sin() * (0.2 * y).cos();
        [x, y, z, f32::NAN, 1.0 + 0.02 * (index % 7) as f32]
    };
    [9.0; 3].into_iter().chain((0..POINTS).flat_map(vertex)).collect()
}

/// Gives one slope as positions, heights and a metric in the program's memory, and as positions in a buffer, with a mask,
/// a slowness, an offset and a stride. Other points replace them afterwards.
#[test]
fn all_kinds_of_points_and_wavefronts_give_the_map_of_a_slope() {
    const MASKED: usize = 12 * COLS as usize + 20;
    let mask: Vec<u8> = (0..POINTS).map(|index| u8::from(index != MASKED)).collect();
    let slope = |steep: f32, slowness: f32| -> Vec<f32> {
        let vertex = |index| {
            let (row, col) = place(index);
            [col, 1.2 * row, steep * col, f32::NAN, slowness]
        };
        [9.0; 3].into_iter().chain((0..POINTS).flat_map(vertex)).collect()
    };
    let mut vertices = slope(0.5, 2.0);
    let mut on_device = vertices.clone();
    on_device[3 + 5 * MASKED] = f32::NAN;
    let mut heights: Vec<_> = vertices[3..].chunks(5).map(|v| v[2]).collect();
    heights[MASKED] = f32::NAN;
    let mut metric = [1.44, 0.0, 1.25].repeat(POINTS);
    metric[3 * MASKED] = f32::NAN;

    let mut session = Session::new(Host::new());
    let buffer = session.host.buffer_of(&on_device);
    let with_slowness = GeosweepPoints { slowness: 4, offset: 12, stride: 20, ..zero() };
    let points = [
        GeosweepPoints { data: vertices.as_ptr(), mask: mask.as_ptr(), ..with_slowness },
        GeosweepPoints { buffer: buffer.handle, ..with_slowness },
        GeosweepPoints { dy: 1.2, ..height_points(&heights) },
        GeosweepPoints {
            kind: GeosweepPointKind::Metric as i32,
            data: metric.as_ptr(),
            stride: 12,
            ..zero()
        },
    ];
    let surface = session.surface(&surface_info(ROWS, COLS, &points));
    let sources = [geosweep_source_at(3.0, 40.0)];
    let mut check = |number: usize, steep: f32, slowness: f32| {
        for wavefront in WAVEFRONTS {
            let plan = session.plan(ROWS, COLS, &method(wavefront, 12));
            let frame = GeosweepFrame { points: number as u32, ..frame(plan, &sources) };
            let map = session.map(surface, &frame);
            assert!(session.outcome(surface).converged);
            // If a surface has points with a slowness, planar fronts take the place of circular ones.
            let is_planar =
                wavefront == GeosweepWavefront::Planar || wavefront == GeosweepWavefront::Circular;
            let most = if is_planar { 0.08 } else { 1e-3 };
            for (index, found) in map.into_iter().enumerate() {
                let (row, col) = place(index);
                let across = 1f32.hypot(steep) * (col - 40.0);
                let exact = slowness * across.hypot(1.2 * (row - 3.0));
                // Fronts go around the hole, and are bent beside it.
                if index == MASKED {
                    assert_eq!(found, f32::INFINITY);
                } else if row < 11.0 || col > 21.0 {
                    let apart = (found - exact).abs();
                    assert!(apart <= most * exact, "{number}, {wavefront:?}: {found} {exact}");
                }
            }
            ok(unsafe { geosweep_plan_destroy(plan) });
        }
    };
    for (number, slowness) in [(0, 2.0), (1, 2.0), (2, 1.0), (3, 1.0)] {
        check(number, 0.5, slowness);
    }

    // The arrays are not needed after the call that takes them.
    vertices.copy_from_slice(&slope(2.0, 3.0));
    ok(unsafe { geosweep_surface_write_points(surface, 0, vertices.as_ptr(), mask.as_ptr()) });
    check(0, 2.0, 3.0);
    vertices[3] = f32::INFINITY;
    let write = |number, data| unsafe {
        geosweep_surface_write_points(surface, number, data, mask.as_ptr())
    };
    all_wrong! {
        write(0, vertices.as_ptr()) => "row 0, column 0 is infinite",
        write(0, std::ptr::null()) => "data is null",
        write(1, vertices.as_ptr()) => "memory of yours",
        write(4, vertices.as_ptr()) => "there are 4 points",
    }
    // A refused call has changed nothing.
    check(0, 2.0, 3.0);

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
            map = session.read(1, |commands, image| unsafe {
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
    assert_eq!(&found.floats()[..3], &[map[44], map[15 * COLS as usize + 20], -1.0]);

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
    let end = whole[9 * COLS as usize + 30];
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

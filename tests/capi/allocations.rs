//! Recording allocates nothing on the heap, neither through the functions of C nor through those of Rust.

use std::ptr::null_mut;

use geosweep::ash::vk;
use geosweep_capi::*;

use crate::heap::allocations;
use crate::host::Host;
use crate::session::{COPY, Session, frame, height_points, method, ok, surface_info, wrong, zero};

#[test]
fn recording_allocates_nothing() {
    let session = Session::new(Host::without_validation());
    let data = [0.0f32; 40 * 48];
    let points = [height_points(&data)];
    let surface = session.surface(&surface_info(40, 48, &points));
    let plan = session.plan(40, 48, &method(GeosweepWavefront::Curved, 4));
    let sources = [3.0, 7.5].map(|row| geosweep_source_at(row, 4.0));
    let frame = frame(plan, &sources);
    let (mut contours, mut paths) = (null_mut(), null_mut());
    ok(unsafe { geosweep_contours_create(surface, 1000, &mut contours) });
    ok(unsafe { geosweep_paths_create(surface, 1, 100, &mut paths) });
    let contour_frame = GeosweepContourFrame { level_count: 20, step: 2.0, ..zero() };
    let (starts, start_count) = ([30.0, 40.0].as_ptr(), 1);
    let path_frame = GeosweepPathFrame { starts, start_count, sources: frame.sources, ..zero() };
    let record = |commands, frame: &GeosweepFrame| unsafe {
        let mut image = zero();
        ok(geosweep_record_frame(surface, commands, frame, &mut image));
        ok(geosweep_record_resume(surface, commands, plan));
        ok(geosweep_record_add(surface, commands, &frame.sources, plan));
        ok(geosweep_record_outcome(surface, commands, 0));
        ok(geosweep_record_result(surface, commands, 0, COPY, -1.0, null_mut()));
        ok(geosweep_record_contours(surface, commands, contours, &contour_frame, null_mut()));
        ok(geosweep_record_paths(surface, commands, paths, &path_frame, null_mut()));
        ok(geosweep_record_end(surface, commands, zero()));
    };
    for _ in 0..20 {
        let commands = session.host.commands();
        session.host.begin(commands);
        let before = allocations();
        record(commands, &frame);
        assert_eq!(allocations() - before, 0);
        session.host.end(commands);
        session.submit(commands);
    }
    // The counter works: a message allocates a string.
    let before = allocations();
    wrong(unsafe { geosweep_record_prepare(surface, vk::CommandBuffer::null()) }, "commands");
    assert!(allocations() > before);
    unsafe {
        ok(geosweep_contours_destroy(contours));
        ok(geosweep_paths_destroy(paths));
        ok(geosweep_surface_destroy(surface));
        ok(geosweep_plan_destroy(plan));
    }
    session.end([]);
}

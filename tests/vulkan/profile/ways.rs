//! Directions and log maps in a frame.

use geosweep::vulkan::Schedule;
use geosweep::vulkan::embed::{
    Access, DirectionFrame, LogMapFrame, PointSource, Reader, SourceInput,
};
use geosweep::vulkan::profile::{PassKind, PassRecord};

use crate::profile::renderer::{CHART, Renderer};

/// A host that makes room for the reported number of passes has room for exactly all of them.
#[test]
fn a_host_can_size_its_queries_for_directions_and_log_maps() {
    let mut renderer = Renderer::watched(Schedule::Raster);
    let renderer = &mut *renderer;
    let device = renderer.host.device.clone();
    let (solver, surface) = (&renderer.solver, &renderer.surface);
    let allocator = renderer.host.allocator();
    let mut directions = solver.directions(&device, allocator, surface).unwrap();
    let mut log_map = solver.log_map(&device, allocator, surface).unwrap();
    let (profile, pool) = renderer.profile_with(directions.passes() + log_map.passes());

    let sources = [PointSource::at(20.0, 31.5), PointSource::at(200.25, 9.0)];
    renderer.host.run(|commands| {
        let recording = solver.record(&device, commands, surface).profiled(&profile).unwrap();
        let sources = SourceInput::Inline(&sources);
        recording.begin(Access::NONE);
        recording.measure(0).unwrap();
        recording.solve(sources, &renderer.plan).unwrap();
        let frame = DirectionFrame::new(sources, Reader::COMPUTE);
        recording.directions(&directions, &frame).unwrap();
        let frame = LogMapFrame::new(sources, Reader::FRAGMENT).with_radius(40.0);
        recording.log_map(&log_map, &frame).unwrap();
    });
    let found = profile.resolve(&device, Some(renderer.clock), None).unwrap().unwrap();
    assert_eq!(found.left_out, 0);
    let first = found.passes.iter().position(|pass| pass.kind == PassKind::Directions).unwrap();
    let (one, other) = found.passes[first..].split_at(directions.passes() as usize);
    assert_eq!(other.len() as u32, log_map.passes());
    for (passes, kind, texel) in [(one, PassKind::Directions, 4), (other, PassKind::LogMap, 8)] {
        let others: Vec<_> = (0..passes.len()).filter(|&k| passes[k].kind != kind).collect();
        assert_eq!((others, passes[1].kind), (vec![1], PassKind::Sources));
        // Two words of each point and the header are cleared. The image is copied.
        let moved = |pass: &PassRecord| (pass.work.bytes_read, pass.work.bytes_written);
        let points = CHART.points() as u64;
        assert_eq!(moved(&passes[0]), (Some(0), Some(8 * points + 4 * 34)));
        let copied = texel * points;
        assert_eq!(moved(&passes[passes.len() - 1]), (Some(copied), Some(copied)));
        assert!(passes.iter().all(|pass| pass.nanoseconds.is_some()));
    }
    unsafe { device.destroy_query_pool(pool, None) };
    directions.destroy(&device, renderer.host.allocator());
    log_map.destroy(&device, renderer.host.allocator());
}

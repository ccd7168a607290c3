//! Regions in a frame.

use geosweep::Wavefront;
use geosweep::vulkan::Schedule;
use geosweep::vulkan::embed::{Access, PointSource, RegionFrame, SourceInput};
use geosweep::vulkan::profile::{PassKind, PassRecord};

use crate::profile::renderer::{CHART, Renderer};

/// A host that makes room for the reported number of passes has room for exactly all of them.
#[test]
fn a_host_can_size_its_queries_for_regions() {
    let mut renderer = Renderer::watched(Schedule::Raster);
    let renderer = &mut *renderer;
    let device = renderer.host.device.clone();
    let (solver, surface) = (&renderer.solver, &renderer.surface);
    let allocator = renderer.host.allocator();
    let made = solver.regions(&device, allocator, surface, Wavefront::Planar);
    let mut regions = made.unwrap();

    let (profile, pool) = renderer.profile_with(regions.passes());

    let sources = [PointSource::at(20.0, 31.5), PointSource::at(200.25, 9.0)];
    renderer.host.run(|commands| {
        let recording = solver.record(&device, commands, surface).profiled(&profile).unwrap();
        recording.begin(Access::NONE);
        recording.measure(0).unwrap();
        recording.solve(SourceInput::Inline(&sources), &renderer.plan).unwrap();
        let sources = SourceInput::Inline(&sources);
        let frame = RegionFrame::new(sources, Access::VERTEX_READ);
        recording.regions(&regions, &frame).unwrap();
    });
    let found = profile.resolve(&device, Some(renderer.clock), None).unwrap().unwrap();
    assert_eq!(found.left_out, 0);
    let first = found.passes.iter().position(|pass| pass.kind == PassKind::Regions).unwrap();
    let own = &found.passes[first..];
    assert_eq!(own.len() as u32, regions.passes());
    let kinds: Vec<_> = own.iter().map(|pass| pass.kind).collect();
    let others: Vec<_> = (0..kinds.len()).filter(|&k| kinds[k] != PassKind::Regions).collect();
    assert_eq!((others, kinds[1]), (vec![1], PassKind::Sources));
    // Two numbers of each point are cleared. A source has four numbers. For the beginning of a point's way, these two
    // numbers, the point's time and four lengths are read, and three numbers are written.
    let points = 4 * CHART.points() as u64;
    let moved = |pass: &PassRecord| (pass.work.bytes_read, pass.work.bytes_written);
    let bytes: Vec<_> = own[..5].iter().map(moved).collect();
    assert_eq!(
        bytes,
        [
            (Some(0), Some(2 * points)),
            (Some(0), Some(32)),
            (Some(32), None),
            (Some(32), None),
            (Some(7 * points), Some(3 * points)),
        ]
    );
    // For 78 000 points, six passes that make ways eight times as long are enough, then three that follow 63 parents
    // each. A fourth one makes the number of all these passes even.
    assert_eq!(own[5..].len(), 6 + 4);
    assert!(own[5..].iter().all(|pass| moved(pass) == (None, None)));
    for pass in own {
        assert!(pass.nanoseconds.is_some(), "{pass:?}");
        assert_eq!(pass.groups.is_some(), pass.dispatches > 0, "{pass:?}");
    }
    unsafe { device.destroy_query_pool(pool, None) };
    regions.destroy(&device, renderer.host.allocator());
}

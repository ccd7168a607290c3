//! Contours and paths in a frame.

use geosweep::vulkan::Schedule;
use geosweep::vulkan::embed::{
    Access, ContourFrame, LevelInput, PathFrame, PathsInfo, PointSource, SourceInput, StartInput,
};
use geosweep::vulkan::profile::{PassKind, PassRecord};

use crate::profile::renderer::{CHART, Renderer};

/// A host that makes room for the reported number of passes has room for all of them. For paths the number
/// is exact if sources have different start values, since paths are then traced several times.
#[test]
fn a_host_can_size_its_queries_for_contours_and_paths() {
    let mut renderer = Renderer::watched(Schedule::Raster);
    let renderer = &mut *renderer;
    let device = renderer.host.device.clone();
    let (solver, surface) = (&renderer.solver, &renderer.surface);
    let allocator = renderer.host.allocator();
    let mut contours = solver.contours(&device, allocator, surface, 4000).unwrap();
    let info = PathsInfo::new(3, 700);
    let mut paths = solver.paths(&device, allocator, surface, info).unwrap();

    let (profile, pool) = renderer.profile_with(contours.passes() + paths.passes());

    let sources =
        [PointSource::at(20.0, 31.5), PointSource { time: 1.0, ..PointSource::at(9.0, 9.0) }];
    for (sources, traces) in [(&sources[..], 3), (&sources[..1], 1)] {
        renderer.host.run(|commands| {
            let recording = solver.record(&device, commands, surface).profiled(&profile).unwrap();
            recording.begin(Access::NONE);
            recording.measure(0).unwrap();
            recording.solve(SourceInput::Inline(sources), &renderer.plan).unwrap();
            let levels = LevelInput::Spacing { step: 10.0, count: 20 };
            let frame = ContourFrame::new(levels, Access::DRAW);
            recording.contours(&contours, &frame).unwrap();
            let starts = StartInput::Inline(&[[200.5, 250.0], [100.0, 4.0], [250.0, 20.0]]);
            let frame = PathFrame::new(starts, SourceInput::Inline(sources), Access::DRAW);
            recording.paths(&paths, &frame).unwrap();
        });
        let found = profile.resolve(&device, Some(renderer.clock), None).unwrap().unwrap();
        assert_eq!(found.left_out, 0);
        let kinds: Vec<_> = found.passes.iter().map(|pass| pass.kind).collect();
        let place = |kind| kinds.iter().position(|&other| other == kind).unwrap();
        let (first, lift) = (place(PassKind::Contours), place(PassKind::Lift));
        assert_eq!((lift + 1 - first) as u32, contours.passes());
        // All following passes are of the paths: the sources, the start, the continuation, the lift.
        let of_paths = &kinds[lift + 1..];
        let going_on = (paths.passes() - 3) / 3;
        assert_eq!(of_paths.len() as u32, 3 + traces * going_on);
        assert_eq!((of_paths[0], of_paths.last()), (PassKind::Sources, Some(&PassKind::Lift)));
        let moved = |pass: &PassRecord| (pass.work.bytes_read, pass.work.bytes_written);
        // Each point's time is read. A row of cells has a count, and so have its 64 strips; a record is six
        // numbers. The device finds how many segments are written and lifted.
        let (times, rows) = (4 * CHART.points() as u64, CHART.rows as u64 - 1);
        let of_contours: Vec<_> = found.passes[first..=lift].iter().map(moved).collect();
        assert_eq!(
            of_contours,
            [
                (Some(times), Some(4 * 65 * rows)),
                (Some(4 * rows), Some(4 * rows + 4 * 6)),
                (Some(times + 4 * 65 * rows), None),
                (None, None),
            ]
        );
        // Three starts, four times around each, and all sources are read. For each path, nine numbers of a record,
        // fifteen of a state and three of the first vertex are written.
        let all = 16 * sources.len() as u64;
        let of_paths: Vec<_> = found.passes[lift + 1..].iter().map(moved).collect();
        assert_eq!(of_paths[0], (Some(0), Some(all)));
        let begin = (Some(3 * 4 * (2 + 4) + all), Some(3 * 4 * (9 + 15 + 3)));
        assert_eq!(of_paths[1], begin);
        assert!(of_paths[2..].iter().all(|&bytes| bytes == (None, None)));
        for pass in &found.passes[first..] {
            assert!(pass.nanoseconds.is_some(), "{pass:?}");
            assert_eq!(pass.groups.is_some(), pass.dispatches > 0, "{pass:?}");
        }
    }
    unsafe { device.destroy_query_pool(pool, None) };
    contours.destroy(&device, renderer.host.allocator());
    paths.destroy(&device, renderer.host.allocator());
}

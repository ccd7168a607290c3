//! Frames of a host.

use std::sync::atomic::{AtomicU32, Ordering};

use geosweep::Wavefront;
use geosweep::ash::vk;
use geosweep::vulkan::Schedule;
use geosweep::vulkan::embed::Tools;
use geosweep::vulkan::profile::{Grain, PassKind, PassRecord, Profile, QueryRange, Slots, Work};

use crate::host::Host;
use crate::profile::renderer::{CHART, Renderer};

/// The host's own timestamps around a frame give the total. Work between its passes, such as the reset of
/// queries, belongs to no pass. The driver's thread may be interrupted there, but not in all of the attempts.
#[test]
fn the_passes_of_a_frame_add_up_to_its_total() {
    let renderer = Renderer::unwatched(Schedule::Raster);
    let shares: Vec<f64> = (0..5)
        .map(|_| {
            let (total, passes) = renderer.timed_frame();
            let of_passes: u64 = passes.iter().map(|pass| pass.nanoseconds.unwrap()).sum();
            assert!(of_passes <= total, "{of_passes} of {total}");
            of_passes as f64 / total as f64
        })
        .collect();
    let best = shares.iter().copied().fold(0.0, f64::max);
    assert!(best > 0.9, "{shares:?}");
}

/// The frame is profiled under the validation layers, with synchronization validation, labels and names.
#[test]
fn a_frame_is_profiled_pass_by_pass() {
    for schedule in Schedule::ALL {
        let renderer = Renderer::watched(schedule);
        for _ in 0..2 {
            let (_, passes) = renderer.timed_frame();
            let outcome = renderer.surface.outcome(0).unwrap();
            let kinds: Vec<_> = passes.iter().map(|pass| pass.kind).collect();
            assert_eq!(kinds[..2], [PassKind::Points, PassKind::Edges]);
            assert_eq!(kinds[kinds.len() - 2..], [PassKind::Outcome, PassKind::Distances]);
            let most =
                renderer.solver.passes_of_frame(&renderer.surface, &renderer.plan, Grain::Blocks);
            assert!(kinds.len() as u32 <= most);
            let of = |kind: PassKind| {
                let work = passes.iter().find(|pass| pass.kind == kind)?.work;
                work.bytes_read.zip(work.bytes_written)
            };
            // One distance is read and one is written at each point.
            let bytes = passes[kinds.len() - 1].work.bytes();
            assert_eq!(bytes, Some(2 * 4 * CHART.points() as u64));
            // Heights are read and stored with their slowness, and four lengths of edges are measured.
            let points = CHART.points() as u64;
            assert_eq!(of(PassKind::Points), Some((4 * points, 8 * points)));
            assert_eq!(of(PassKind::Edges), Some((8 * points, 16 * points)));
            // One source of four numbers comes with the commands. For each of the four texels around it, ten numbers
            // are written: place, times and curvatures. The seed reads them and both layers of the texels' fronts, and
            // writes these layers.
            assert_eq!(of(PassKind::Sources), Some((0, 16)));
            let find = |pass: &&PassRecord| pass.kind == PassKind::Sources && pass.dispatches > 0;
            let work = passes.iter().find(find).unwrap().work;
            assert_eq!((work.bytes_read, work.bytes_written), (Some(16), Some(4 * 40)));
            assert_eq!(of(PassKind::Seed), Some((4 * (40 + 32), 4 * 32)));
            // Each dispatched pass has a size.
            let sized = passes.iter().filter(|pass| pass.groups.is_some());
            assert!(sized.eq(passes.iter().filter(|pass| pass.dispatches > 0)), "{passes:?}");
            // The records contain exactly the iterations that the device has executed.
            let done = passes
                .iter()
                .filter(|pass| pass.area.is_some() && !pass.is_idle())
                .filter_map(|pass| pass.iteration)
                .max();
            assert_eq!(done, Some(outcome.iterations - 1), "{schedule}");
        }
    }
}

/// The source is between grid points, where circular and curved fronts have surroundings.
#[test]
fn surroundings_are_solved_once_a_source_and_set() {
    for (wavefront, carried) in [(Wavefront::Circular, 1), (Wavefront::Curved, 3)] {
        let host = Host::without_validation();
        let renderer = Renderer::new(host, Schedule::Raster, wavefront, Tools::default());
        let (_, passes) = renderer.timed_frame();
        let first = passes.iter().position(|pass| pass.kind == PassKind::Surroundings).unwrap();
        let kinds: Vec<_> = passes[first - 1..].iter().map(|pass| pass.kind).take(3).collect();
        assert_eq!(kinds, [PassKind::Seed, PassKind::Surroundings, PassKind::Seed]);
        let count = passes.iter().filter(|pass| pass.kind == PassKind::Surroundings).count();
        assert_eq!((count, passes[first].groups), (1, Some([1; 3])));
        // The source is read, and of each texel the times and 16 lengths, with curved fronts also the curvatures of
        // the fronts and of the surface. The place, times and curvatures of each texel are written.
        let Work { bytes_read, bytes_written, .. } = passes[first].work;
        let texels = 100;
        let read = 16 + texels * 16 * (carried + 4);
        assert_eq!((bytes_read, bytes_written), (Some(read), Some(texels * 40)), "{wavefront}");
    }
}

/// Without the device's decisions, the values that depend on them are unknown.
#[test]
fn results_without_a_readback_are_unknown() {
    for schedule in Schedule::ALL {
        let mut renderer = Renderer::unwatched(schedule);
        renderer.timed_frame();
        let device = &renderer.host.device.clone();
        let resolved = renderer.profile.resolve(device, None, None).unwrap().unwrap();
        // A profile without room for queries and decisions leaves these values unknown too.
        renderer.profile = Profile::new(1000, Grain::Blocks, Slots::default());
        renderer.host.run(|commands| renderer.frame(device, commands, true));
        let bytes = renderer.decisions.bytes();
        let without = renderer.profile.resolve(device, None, Some(bytes)).unwrap().unwrap();
        assert_eq!(without.left_out, 0);
        for pass in resolved.passes.iter().chain(&without.passes) {
            assert_eq!((pass.begin, pass.nanoseconds, pass.invocations), (None, None, None));
            // All iterations of a frame's plan are dispatched indirectly.
            if pass.area.is_some() {
                assert_eq!((pass.groups, pass.work), (None, Work::default()));
                assert!(!pass.is_idle());
            }
            if let PassKind::Count | PassKind::Settle = pass.kind {
                assert_eq!(pass.work, Work::default());
            }
        }
    }
}

/// Recording does not wait for the device, nor does reading results too early.
#[test]
fn missing_results_are_not_waited_for() {
    let renderer = Renderer::unwatched(Schedule::Raster);
    let host = &renderer.host;
    // The queries are reset and not written.
    host.run(|commands| unsafe {
        host.device.cmd_reset_query_pool(commands, renderer.pool, 0, 3);
    });
    let commands = host.commands();
    host.begin(commands);
    renderer.frame(&host.device, commands, true);
    host.end(commands);
    let early = renderer.profile.resolve(&host.device, Some(renderer.clock), None).unwrap();
    assert_eq!(early, None);
    host.submit(commands, vk::Fence::null());
    unsafe { host.device.queue_wait_idle(host.queue) }.unwrap();
    let late = renderer.profile.resolve(&host.device, Some(renderer.clock), None).unwrap();
    assert!(late.unwrap().passes.iter().all(|pass| pass.nanoseconds.is_some()));
}

/// A profile that is too small leaves passes out and reports how many.
#[test]
fn passes_without_room_are_counted() {
    let mut renderer = Renderer::watched(Schedule::Raster);
    let all = renderer.timed_frame().1.len() as u32;
    let range = QueryRange { pool: renderer.pool, first: 2, count: 11 };
    let slots = Slots::default().with_timestamps(range);
    renderer.profile = Profile::new(100, Grain::Blocks, slots);
    let device = &renderer.host.device.clone();
    renderer.host.run(|commands| renderer.frame(device, commands, true));
    let found = renderer.profile.resolve(device, Some(renderer.clock), None).unwrap().unwrap();
    // Without a buffer for decisions, the two copies of them are not recorded.
    assert_eq!((found.passes.len(), found.left_out), (10, all - 2 - 10));
    // An empty range counts as none.
    let range = QueryRange { pool: renderer.pool, first: 2, count: 0 };
    let slots = Slots::default().with_timestamps(range);
    renderer.profile = Profile::new(all, Grain::Blocks, slots);
    renderer.host.run(|commands| renderer.frame(device, commands, true));
    let found = renderer.profile.resolve(device, Some(renderer.clock), None).unwrap().unwrap();
    assert_eq!((found.passes.len(), found.left_out), (all as usize - 2, 0));
    assert!(found.passes.iter().all(|pass| pass.nanoseconds.is_none()));
}

/// A frame's map is one record, and only the first timestamps are used.
#[test]
fn a_portion_of_a_frame_is_one_record() {
    for schedule in Schedule::ALL {
        let mut renderer = Renderer::watched(schedule);
        let (_, finer) = renderer.timed_frame();
        renderer.profile = Profile::new(1000, Grain::Portions, renderer.slots);
        let (total, passes) = renderer.timed_frame();
        let kinds: Vec<_> = passes.iter().map(|pass| pass.kind).collect();
        use PassKind::*;
        assert_eq!(kinds, [Points, Edges, Portion, Outcome, Distances], "{schedule}");
        let sum: u64 = passes.iter().map(|pass| pass.nanoseconds.unwrap()).sum();
        assert!(sum <= total, "{schedule}: {sum} of {total}");
        let texels = |passes: &[PassRecord]| -> u64 {
            passes.iter().filter_map(|pass| pass.work.texels).sum()
        };
        assert_eq!(texels(&passes), texels(&finer), "{schedule}");
    }
}

static QUERIES: AtomicU32 = AtomicU32::new(0);

extern "system" fn count_query() -> vk::Result {
    QUERIES.fetch_add(1, Ordering::Relaxed);
    vk::Result::SUCCESS
}

/// The test counts calls of the device's functions that only profiling uses.
#[test]
fn profiling_that_is_off_records_nothing() {
    let renderer = Renderer::unwatched(Schedule::Raster);
    let names =
        [c"vkCmdWriteTimestamp", c"vkCmdResetQueryPool", c"vkCmdBeginQuery", c"vkCmdEndQuery"];
    let counting = renderer.host.device_with(|name| {
        names.contains(&name).then_some(count_query as extern "system" fn() -> vk::Result)
    });
    let count = |watched: bool| {
        QUERIES.store(0, Ordering::Relaxed);
        renderer.host.run(|commands| renderer.frame(&counting, commands, watched));
        QUERIES.load(Ordering::Relaxed)
    };
    assert_eq!(count(false), 0);
    let steps = renderer.plan.steps().len();
    assert!(count(true) > steps as u32);
}

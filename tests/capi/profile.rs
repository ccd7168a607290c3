//! Times of the passes of a frame, through the functions of C.

use std::ffi::CStr;
use std::ptr::null_mut;

use geosweep_capi::*;

use crate::host::{self, Host};
use crate::session::{
    Session, all_wrong, frame, height_points, method, ok, refused, surface_info, wrong, zero,
};

fn name(pass: &GeosweepPass) -> &str {
    unsafe { CStr::from_ptr(pass.name) }.to_str().unwrap()
}

#[test]
fn passes_of_a_frame_are_timed_and_counted() {
    let mut session = Session::new(Host::new());
    let family = host::family(&session.host.instance, session.host.physical_device);
    let heights: Vec<f32> = (0..40 * 48).map(|point| (0.3 * point as f32).sin()).collect();
    let points = [height_points(&heights)];
    let surface = session.surface(&surface_info(40, 48, &points));
    let plan = session.plan(40, 48, &method(GeosweepWavefront::Curved, 50));
    let sources = [geosweep_source_at(4.25, 30.5)];
    let plain = frame(plan, &sources);
    let unwatched = session.map(surface, &plain);
    let iterations = session.outcome(surface).iterations;
    for grain in [
        GeosweepGrain::Scans,
        GeosweepGrain::Blocks,
        GeosweepGrain::Iterations,
        GeosweepGrain::Portions,
    ] {
        let mut profile = null_mut();
        ok(unsafe { geosweep_profile_create(surface, plan, grain as i32, family, &mut profile) });
        let (mut passes, mut count) = (vec![zero::<GeosweepPass>(); 4000], 0);
        let passes_of = |passes: &mut [GeosweepPass], count: &mut u32| unsafe {
            geosweep_profile_passes(profile, passes.as_mut_ptr(), passes.len() as u32, count)
        };
        let not_ready = GeosweepStatus::NotReady;
        refused(passes_of(&mut passes, &mut count), not_ready, "ask after its fence");
        let watched = GeosweepFrame { profile, ..plain };
        // The profile does not contain a frame that was refused.
        let off = [geosweep_source_at(40.0, 0.0)];
        let commands = session.host.commands();
        session.host.begin(commands);
        let refused_frame = GeosweepFrame { profile, ..frame(plan, &off) };
        wrong(
            unsafe { geosweep_record_frame(surface, commands, &refused_frame, null_mut()) },
            "outside the grid",
        );
        session.host.end(commands);
        refused(passes_of(&mut passes, &mut count), not_ready, "ask after its fence");

        assert!(session.map(surface, &watched) == unwatched, "profiles change no map");
        ok(passes_of(&mut passes[..2], &mut count));
        let all = count as usize;
        ok(passes_of(&mut passes, &mut count));
        assert_eq!(count as usize, all);
        passes.truncate(all);
        assert!(passes.iter().all(|pass| pass.nanoseconds != GEOSWEEP_UNKNOWN), "{grain:?}");
        assert!(passes.iter().map(|pass| pass.nanoseconds).sum::<u64>() > 0);
        assert_eq!(name(&passes[all - 1]), "distances");
        assert_eq!(passes[all - 1].bytes_written, 4 * 40 * 48);
        assert_eq!(passes[all - 1].iteration, u32::MAX);
        let of = |wanted: &str| passes.iter().filter(|pass| name(pass).starts_with(wanted)).count();
        match grain {
            GeosweepGrain::Portions => assert_eq!(of("scan down"), 0),
            GeosweepGrain::Iterations => assert_eq!(of("scan down"), 0),
            _ => {
                assert!(of("scan down") > 0);
                let scans = passes.iter().filter(|pass| name(pass).starts_with("scan"));
                let ran = scans.filter(|pass| !pass.is_idle);
                // The last iteration may have nothing left to do.
                let last = ran.map(|pass| pass.iteration + 1).max().unwrap();
                assert!((iterations - 1..=iterations).contains(&last), "{last} of {iterations}");
            }
        }
        ok(unsafe { geosweep_profile_destroy(profile) });
    }
    let create = |grain, family| {
        let mut profile = null_mut();
        unsafe { geosweep_profile_create(surface, plan, grain, family, &mut profile) }
    };
    all_wrong! {
        create(4, family) => "grain is 4, which is no GeosweepGrain",
        unsafe { geosweep_profile_create(surface, plan, 0, family, null_mut()) } => "profile is null",
    }
    let unsupported = GeosweepStatus::Unsupported;
    refused(create(0, 1000), unsupported, "queues of the family 1000 write no timestamps");
    unsafe {
        ok(geosweep_profile_destroy(null_mut()));
        ok(geosweep_surface_destroy(surface));
        ok(geosweep_plan_destroy(plan));
    }
    session.end([]);
}

/// With checks, a profile of a frame that has not run is neither used for another frame nor destroyed.
#[test]
fn a_profile_in_flight_is_kept() {
    let session = Session::with_checks(Host::new());
    let family = host::family(&session.host.instance, session.host.physical_device);
    let heights = [0.5f32; 12 * 15];
    let points = [height_points(&heights)];
    let info = GeosweepSurfaceInfo { slots: 2, ..surface_info(12, 15, &points) };
    let surface = session.surface(&info);
    let plan = session.plan(12, 15, &method(GeosweepWavefront::Curved, 6));
    let sources = [geosweep_source_at(3.0, 4.0)];
    let mut profiles = [null_mut(); 2];
    let grain = GeosweepGrain::Iterations as i32;
    for profile in &mut profiles {
        ok(unsafe { geosweep_profile_create(surface, plan, grain, family, profile) });
    }
    let [first, second] = [(); 2].map(|()| session.host.commands());
    let record = |commands, slot, profile| {
        let frame = GeosweepFrame { slot, profile, ..frame(plan, &sources) };
        unsafe { geosweep_record_frame(surface, commands, &frame, null_mut()) }
    };
    session.host.begin(first);
    session.host.begin(second);
    let longer = session.plan(12, 15, &method(GeosweepWavefront::Curved, 40));
    let of_longer = GeosweepFrame { profile: profiles[0], ..frame(longer, &sources) };
    wrong(
        unsafe { geosweep_record_frame(surface, first, &of_longer, null_mut()) },
        "create it with the surface and the plan of the frame",
    );
    ok(unsafe { geosweep_plan_destroy(longer) });
    ok(record(first, 0, profiles[0]));
    wrong(record(second, 1, profiles[0]), "use a profile for each frame in flight");
    wrong(
        unsafe { geosweep_profile_destroy(profiles[0]) },
        "profile is destroyed and a recording of it",
    );
    ok(record(second, 1, profiles[1]));
    for commands in [first, second] {
        session.host.end(commands);
        session.submit(commands);
    }
    // Both frames have run.
    session.host.begin(first);
    ok(record(first, 0, profiles[1]));
    session.host.end(first);
    session.submit(first);
    // A frame that was discarded will never run.
    session.host.begin(second);
    ok(record(second, 1, profiles[0]));
    session.host.end(second);
    wrong(unsafe { geosweep_profile_destroy(profiles[0]) }, "has not run");
    ok(unsafe { geosweep_surface_discard(surface, 1) });
    ok(unsafe { geosweep_surface_discard_commands(surface, second) });
    // The profile outlives its surface.
    ok(unsafe { geosweep_surface_destroy(surface) });
    for profile in profiles {
        ok(unsafe { geosweep_profile_destroy(profile) });
    }
    ok(unsafe { geosweep_plan_destroy(plan) });
    session.end([]);
}

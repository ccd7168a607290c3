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

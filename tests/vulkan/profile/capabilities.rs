//! Capabilities that a device lacks are reported and not used.

use geosweep::Wavefront;
use geosweep::vulkan::Schedule;
use geosweep::vulkan::profile::{Capabilities, Capability, Clock, Detail, Grain};

use crate::host::Host;
use crate::profile::bench::{Bench, method};

/// The map is the same to the last bit, whatever is profiled and whatever the device lacks. Missing
/// capabilities are reported.
#[test]
fn a_device_that_lacks_something_still_gives_the_rest() {
    let all = Capability::ALL;
    let singles = all.map(|one| vec![one]);
    for left_out in [vec![], all.to_vec()].into_iter().chain(singles) {
        let mut bench = Bench::without(40, 33, &left_out);
        let found = bench.solver.capabilities().unwrap().clone();
        for capability in all {
            let reason = found.reason(capability);
            if left_out.contains(&capability) {
                let text = reason.unwrap().to_string();
                assert_eq!(text, "not available on this device (left out as asked)");
            } else if let Some(reason) = reason {
                assert!(reason.to_string().starts_with("not available on this device ("));
            }
        }
        // A single capability adds the same with every schedule.
        let schedules = if left_out.len() == 1 { &[Schedule::Tiles][..] } else { &Schedule::ALL };
        for &schedule in schedules {
            let method = method(Wavefront::Curved, schedule);
            let Bench { seeds, solver, on_device, .. } = &mut bench;
            let plain = solver.solve(on_device, seeds, method).unwrap();
            let detail =
                Detail { grain: Grain::Blocks, invocations: true, tiles: true, whole: true };
            let (watched, profile) = solver.profile(on_device, seeds, method, detail).unwrap();
            assert_eq!(watched.distances, plain.distances);
            assert_eq!((watched.iterations, watched.residual), (plain.iterations, plain.residual));
            for pass in profile.passes() {
                assert_eq!(pass.nanoseconds.is_some(), found.timestamps.is_ok(), "{pass:?}");
                assert_eq!(pass.begin.is_some(), found.timestamps.is_ok());
                assert_eq!(pass.invocations.is_some(), found.statistics.is_ok());
            }
            // Counts need no capability.
            let in_iterations: Vec<_> = profile.passes().filter(|p| p.area.is_some()).collect();
            assert!(in_iterations.len() > 2);
            assert!(in_iterations.iter().all(|pass| pass.work.texels.is_some()));
            let aligned = found.calibration.is_ok() && found.timestamps.is_ok();
            for submission in &profile.submissions {
                assert_eq!(submission.nanoseconds.is_some(), found.timestamps.is_ok());
                assert_eq!(submission.begin.is_some(), aligned);
                assert!(submission.submitted <= submission.ended);
            }
        }
        let executables = bench.solver.executables().unwrap();
        assert_eq!(!executables.is_empty(), found.executables.is_ok());
    }
}

/// A host queries the capabilities before it creates its device.
#[test]
fn capabilities_say_what_there_is() {
    let host = Host::without_validation();
    let family = crate::host::family(&host.instance, host.physical_device);
    let found = Capabilities::of(&host.instance, host.physical_device, family, false);
    let clock = Clock::of(&host.instance, host.physical_device, family);
    assert_eq!(found.timestamps.ok(), clock);
    assert!(found.labels.unwrap_err().to_string().contains("VK_EXT_debug_utils"));
    let none = found.clone().without(&Capability::ALL);
    assert_eq!(none.device_extensions(), Vec::<&std::ffi::CStr>::new());
}

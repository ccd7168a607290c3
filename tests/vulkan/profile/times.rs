//! Times at which passes ran.

use geosweep::Wavefront;
use geosweep::vulkan::Schedule;
use geosweep::vulkan::profile::{Detail, Grain};

use crate::profile::bench::{Bench, method};

/// The device starts a submission after the host has submitted it, and ends it before the host notices. Calibrated
/// timestamps bring both times to one clock.
#[test]
fn calibrated_times_lie_between_submission_and_its_end() {
    let mut bench = Bench::new(80, 80);
    let profile = bench.profile(method(Wavefront::Planar, Schedule::Raster), Detail::default());
    if bench.solver.capabilities().unwrap().calibration.is_err() {
        assert!(profile.submissions.iter().all(|found| found.begin.is_none()));
        return;
    }
    // Error of reading both clocks, in nanoseconds. It is larger for a host that is interrupted in all attempts.
    let slack = 2e6;
    for found in &profile.submissions {
        let (begin, taken) = (found.begin.unwrap(), found.nanoseconds.unwrap() as f64);
        assert!(begin > found.submitted.as_nanos() as f64 - slack, "{found:?}");
        assert!(begin + taken < found.ended.as_nanos() as f64 + slack, "{found:?}");
    }
}

#[test]
fn passes_follow_one_another_inside_their_submission() {
    let mut bench = Bench::new(50, 50);
    let details = Grain::ALL
        .into_iter()
        .flat_map(|grain| [true, false].map(|whole| Detail { grain, whole, ..Detail::default() }));
    for (schedule, detail) in details.flat_map(|detail| Schedule::ALL.map(|of| (of, detail))) {
        let profile = bench.profile(method(Wavefront::Planar, schedule), detail);
        for submission in &profile.submissions {
            let mut end = 0;
            for pass in &submission.passes {
                assert_eq!(pass.begin, Some(end));
                end += pass.nanoseconds.unwrap();
            }
            let (lead, whole) = (submission.lead.unwrap(), submission.nanoseconds.unwrap());
            match detail.whole {
                true => assert!(lead + end <= whole),
                false => assert_eq!((lead, end), (0, whole)),
            }
        }
        assert!(profile.pass_nanoseconds().unwrap() <= profile.nanoseconds().unwrap());
    }
}

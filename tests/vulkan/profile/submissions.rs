//! Maps whose iterations are cut into several submissions, since a submission may visit a limited number of texels.

use geosweep::vulkan::profile::{Detail, Grain, PassKind, SolveProfile, SubmissionRecord};
use geosweep::vulkan::{HeadlessSolution, Method, Schedule, Tuning, plan};
use geosweep::{Stop, Wavefront};

use crate::common::{rough, seeds_at, some_point, tuned, vulkan_solver};
use crate::profile::bench::{Bench, method};

/// Largest number of texels that a submission may visit. It is a third of the number of texels of these tests' grid, so
/// that iterations are cut into parts, each of which visits at most half of it.
const VISITS: u64 = 1600;
/// Rows and columns of the grid. It has 65 x 75 texels, so that no line fits a workgroup.
const SIZE: (usize, usize) = (130, 150);

/// Returns a tuning that is the same on every device.
fn whole(old: Tuning) -> Tuning {
    Tuning { scan_width: 64, scan_lines: 4, scan_pairs: false, ..old }
}

fn in_parts(old: Tuning) -> Tuning {
    Tuning { visits: Some(VISITS), ..whole(old) }
}

fn texels(submission: &SubmissionRecord) -> u64 {
    submission.passes.iter().map(|pass| pass.work.texels.unwrap_or(0)).sum()
}

/// Returns, for each scan, the texels that it has visited and skipped and the bytes that it has moved, over all
/// submissions.
fn scans(profile: &SolveProfile) -> Vec<(u32, PassKind, u64, u64, u64)> {
    let mut scans: Vec<(u32, PassKind, u64, u64, u64)> = Vec::new();
    for pass in profile.passes().filter(|pass| matches!(pass.kind, PassKind::Scan(_))) {
        let [texels, skipped, bytes] =
            [pass.work.texels, pass.work.skipped, pass.work.bytes()].map(Option::unwrap);
        match scans.last_mut() {
            Some(last) if (last.0, last.1) == (pass.iteration.unwrap(), pass.kind) => {
                (last.2, last.3, last.4) = (last.2 + texels, last.3 + skipped, last.4 + bytes);
            }
            _ => scans.push((pass.iteration.unwrap(), pass.kind, texels, skipped, bytes)),
        }
    }
    scans
}

fn profiled(bench: &mut Bench, method: Method, grain: Grain) -> (HeadlessSolution, SolveProfile) {
    let Bench { seeds, solver, on_device, .. } = bench;
    solver.profile(on_device, seeds, method, Detail { grain, ..Detail::default() }).unwrap()
}

/// An iteration of raster scans does the same in two dozen submissions as in one, block by block.
#[test]
fn iterations_are_cut_where_a_submission_would_visit_more_than_it_may() {
    let mut whole = Bench::tuned(SIZE.0, SIZE.1, whole);
    let mut cut = Bench::tuned(SIZE.0, SIZE.1, in_parts);
    for wavefront in [Wavefront::Planar, Wavefront::Curved] {
        let method = method(wavefront, Schedule::Raster);
        for grain in Grain::ALL {
            let (in_one, expected) = profiled(&mut whole, method, grain);
            let (in_parts, found) = profiled(&mut cut, method, grain);
            assert_eq!(in_parts.distances, in_one.distances);
            assert_eq!(in_parts.iterations, in_one.iterations);
            let most = found.submissions.iter().map(texels).max().unwrap();
            assert!((VISITS / 4..=VISITS / 2).contains(&most), "{most} of {VISITS}");
            let all = |profile: &SolveProfile| profile.submissions.iter().map(texels).sum::<u64>();
            // Iterations that were recorded beyond convergence visit nothing.
            assert_eq!(all(&found), all(&expected));
            let dispatches =
                |profile: &SolveProfile| profile.passes().map(|pass| pass.dispatches).sum::<u32>();
            assert!(dispatches(&found) <= dispatches(&expected));
            if matches!(grain, Grain::Scans | Grain::Blocks) {
                let iterations = in_one.iterations;
                let in_one = scans(&expected).into_iter().filter(|scan| scan.0 < iterations);
                assert_eq!(scans(&found), in_one.collect::<Vec<_>>());
            }
            // The first iteration is bounded. One more submission reads the map back.
            let (_, steps) = cut.steps(method, in_one.iterations as usize);
            let parts = steps.iter().map(|steps| plan::parts(steps, VISITS).len());
            assert_eq!(found.submissions.len(), parts.sum::<usize>() + 1);
        }
    }
}

/// A round visits an unknown number of tiles, so that a submission has few rounds.
#[test]
fn recordings_of_tiles_have_fewer_rounds() {
    let mut cut = Bench::tuned(SIZE.0, SIZE.1, in_parts);
    let method = method(Wavefront::Curved, Schedule::Tiles);
    let (solution, profile) = profiled(&mut cut, method, Grain::Scans);
    for submission in &profile.submissions {
        let rounds = submission.passes.iter().filter(|pass| pass.kind == PassKind::Tiles).count();
        assert!(rounds <= 2, "{rounds}");
    }
    let rounds = profile.passes().filter(|pass| pass.kind == PassKind::Tiles && !pass.is_idle());
    assert_eq!(rounds.count(), solution.iterations as usize);
}

/// With all wavefronts, and with added sources, small submissions give the maps of large ones
/// to the last bit. A message of the validation layers would fail the call.
#[test]
fn maps_in_small_submissions_are_those_of_large_ones() {
    let surface = rough(SIZE.0, SIZE.1, 9);
    let seeds = seeds_at(&surface, some_point(&surface));
    let more = seeds_at(&surface, (0, 0));
    let mut whole = vulkan_solver();
    let mut cut = tuned(in_parts);
    let mut on_device = [whole.upload(&surface).unwrap(), cut.upload(&surface).unwrap()];
    for wavefront in Wavefront::FOR_ANY_SURFACE {
        let method = method(wavefront, Schedule::Raster);
        // The last recording of a map has fewer iterations than the others, so that it has another plan.
        for stop in [Stop::after(3), method.stop] {
            let method = method.with_stop(stop);
            let maps = [&mut *whole, &mut cut].into_iter().zip(&mut on_device).map(
                |(solver, on_device)| {
                    let map = solver.solve(on_device, &seeds, method).unwrap();
                    let both = solver.add(on_device, &more, method).unwrap();
                    [map, both].map(|map| (map.distances, map.iterations))
                },
            );
            let maps: Vec<_> = maps.collect();
            assert!(maps[0] == maps[1], "{wavefront}");
        }
    }
}

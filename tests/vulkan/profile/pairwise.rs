//! Maps of many sources at once.

use geosweep::Stop;
use geosweep::Wavefront;
use geosweep::vulkan::PairwiseSchedule;
use geosweep::vulkan::plan::{self, Portions, Reached, Step};
use geosweep::vulkan::profile::{Capability, Detail, Grain, PassKind, PassRecord};
use geosweep::vulkan::{Schedule, TexelChart};

use crate::common::CONVERGED;
use crate::profile::bench::{Bench, of_kind, sum};

/// Returns the number of texels that each iteration of a plan scans. No step follows the last count.
fn of_iterations(steps: &[Step]) -> Vec<u64> {
    let iterations = steps.split(|step| *step == Step::Count);
    iterations.filter(|steps| !steps.is_empty()).map(plan::texels_scanned).collect()
}

/// Maps in images are compared with the plan of each recording, and with the number of iterations of each
/// single map.
#[test]
fn each_iteration_visits_the_maps_that_have_not_converged() {
    let mut bench = Bench::new(41, 36);
    let chart = bench.surface.chart();
    let texels = TexelChart::new(chart).unwrap();
    let tuning = bench.solver.tuning();
    let sources = [Some(chart.index(20, 18)), None, Some(chart.index(1, 1)), Some(0)];
    let Bench { solver, on_device, .. } = &mut bench;
    let counts = solver.capabilities().unwrap().statistics.is_ok();
    for wavefront in Wavefront::FOR_ANY_SURFACE {
        let images = Some(PairwiseSchedule::Images);
        let mut pairwise = solver.pairwise(on_device, wavefront, images).unwrap();
        assert!(pairwise.batch() >= sources.len());
        let alone = sources.map(|source| {
            let mut row = vec![0.0; chart.points()];
            let source = [source];
            pairwise.solve(solver, on_device, &source, CONVERGED, &mut row).unwrap().iterations
        });
        let mut plain = vec![0.0; sources.len() * chart.points()];
        pairwise.solve(solver, on_device, &sources, CONVERGED, &mut plain).unwrap();

        // In the first recording, scans are bounded by what the fronts of all sources can have reached.
        let sizes = Portions { across: 0, pairs: false, ..tuning.portions(wavefront, texels) };
        let places = sources.iter().flatten().map(|&source| {
            let (row, col) = chart.position(source);
            let (row, col, _) = TexelChart::texel_of(row, col);
            (row, col)
        });
        let plan = |reached| {
            let most = CONVERGED.iterations;
            of_iterations(&Schedule::Raster.plan(texels, sizes, reached, most))
        };
        let mut expected = plan(Reached::around(places));
        let most = alone.into_iter().max().unwrap() as usize;
        while expected.len() < most {
            expected.extend(plan(None));
        }
        let everywhere = 4 * (texels.inner_rows().len() * texels.inner_cols().len()) as u64;

        for grain in Grain::ALL {
            let detail = Detail { grain, invocations: true, ..Detail::default() };
            let mut rows = vec![0.0; plain.len()];
            let (convergence, profile) = pairwise
                .profile(solver, on_device, &sources, CONVERGED, &mut rows, detail)
                .unwrap();
            assert_eq!(rows, plain, "{wavefront}");
            assert_eq!(convergence.iterations as usize, most);
            for (number, &texels) in expected.iter().enumerate() {
                let passes: Vec<_> = profile
                    .passes()
                    .filter(|pass| pass.iteration == Some(number as u32) && pass.area.is_some())
                    .collect();
                let going = alone.iter().filter(|&&count| count > number as u32).count() as u64;
                assert_eq!(sum(&passes, |pass| pass.work.texels), going * texels, "{number}");
                let skipped = sources.len() as u64 * everywhere - going * texels;
                assert_eq!(sum(&passes, |pass| pass.work.skipped), skipped, "{number}");
                let idle = passes.iter().all(|pass| pass.is_idle());
                assert_eq!(idle, going == 0, "{number}");
                let curved = u64::from(wavefront == Wavefront::Curved);
                let bytes = going * texels * (32 + 64 + curved * (32 + 16));
                // For each map that was not done before, the count reads seven numbers and writes five. If the map
                // has now converged, the count also writes that the map is done, and reads and writes the number of
                // pending maps. With the last pending map, it sets the groups of rows and columns to zero. For a
                // map that was done before, the count only reads that it is.
                let now = alone.iter().filter(|&&count| count == number as u32 + 1).count() as u64;
                let groups = if now > 0 && now == going { 2 } else { 0 };
                let over = sources.len() as u64 - going;
                let of_count = 4 * ((7 + 5) * going + 3 * now + groups + over);
                let all = profile.passes().filter(|pass| pass.iteration == Some(number as u32));
                let found: u64 = all.map(|pass| pass.work.bytes().unwrap()).sum();
                assert_eq!(found, bytes + of_count, "{grain:?}, {number}");
                assert_eq!(sum(&passes, |pass| pass.work.triangles), going * texels * 8);
            }
            if grain == Grain::Blocks {
                for pass in profile.passes().filter(|pass| pass.area.is_some()) {
                    let groups: u32 = pass.groups.unwrap().iter().product();
                    let invocations = u64::from(groups * tuning.scan_width);
                    assert_eq!(pass.invocations, counts.then_some(invocations));
                }
            }
            let kinds = [PassKind::Start, PassKind::Seed, PassKind::Unpack];
            assert!(kinds.into_iter().all(|kind| of_kind(&profile, kind).count() == 1));
            assert!(profile.passes().all(|pass| pass.nanoseconds.is_some()));
            assert!(profile.pass_nanoseconds() <= profile.nanoseconds());
        }
    }
}

/// The grid has seven by four points. The scans of the first iteration lead away from (2, 1): four lines down and two
/// lines up, of four points in two pairs each, then two lines to the right and one to the left, of seven points in four
/// pairs each. A scan updates a point from two triangles, and reads nine lengths for a pair.
#[test]
fn maps_in_shared_memory_agree_with_a_count_by_hand() {
    let bench = Bench::new(7, 4);
    let Bench { solver, on_device, surface, .. } = &bench;
    let chart = surface.chart();
    let shared = Some(PairwiseSchedule::SharedMemory);
    let mut pairwise = solver.pairwise(on_device, Wavefront::Planar, shared).unwrap();
    let once = Stop::within(0.0).or_after(1);
    let detail = Detail { invocations: true, ..Detail::default() };
    let mut workgroups = |sources: &[Option<usize>], stop| {
        let mut rows = vec![0.0; sources.len() * 28];
        let found = pairwise.profile(solver, on_device, sources, stop, &mut rows, detail);
        let (convergence, profile) = found.unwrap();
        let of_kind: Vec<PassRecord> = of_kind(&profile, PassKind::Workgroups).copied().collect();
        assert_eq!(of_kind.len(), 1);
        (convergence.iterations, of_kind[0])
    };
    let source = chart.index(2, 1);
    let (_, one) = workgroups(&[Some(source)], once);
    assert_eq!(one.work.triangles, Some(2 * (4 * 4 + 2 * 4 + 2 * 7 + 7)));
    assert_eq!(one.work.bytes_read, Some(4 * 9 * (4 * 2 + 2 * 2 + 2 * 4 + 4)));
    assert_eq!((one.work.bytes_written, one.work.texels), (Some(4 * 28), None));
    assert_eq!((one.groups, one.iteration), (Some([1, 1, 1]), Some(0)));
    // Holes take a workgroup that does nothing.
    let (_, with_hole) = workgroups(&[None, Some(source), None], once);
    assert_eq!((with_hole.work, with_hole.groups), (one.work, Some([3, 1, 1])));
    assert_eq!(one.invocations.is_some(), solver.capabilities().unwrap().statistics.is_ok());
    assert_eq!(with_hole.invocations, one.invocations.map(|one| 3 * one));
    // Later iterations visit all lines.
    let (iterations, all) = workgroups(&[Some(source)], CONVERGED);
    assert!(iterations > 1);
    let later = u64::from(iterations - 1) * 2 * (2 * 6 * 4 + 2 * 3 * 7);
    assert_eq!(all.work.triangles, one.work.triangles.map(|first| first + later));
}

/// The rows are the same with and without a profile, also on a device that lacks all capabilities.
#[test]
fn the_rows_are_the_same_with_and_without() {
    for left_out in [vec![], Capability::ALL.to_vec()] {
        let bench = Bench::without(30, 21, &left_out);
        let Bench { solver, on_device, .. } = &bench;
        let sources: Vec<_> = (0..70).map(|source| Some(9 * source)).collect();
        for schedule in PairwiseSchedule::ALL {
            let mut pairwise =
                solver.pairwise(on_device, Wavefront::Circular, Some(schedule)).unwrap();
            let [mut plain, mut watched] = [0.0, 1.0].map(|fill| vec![fill; 70 * 630]);
            pairwise.solve(solver, on_device, &sources, CONVERGED, &mut plain).unwrap();
            let detail = Detail::default();
            let found =
                pairwise.profile(solver, on_device, &sources, CONVERGED, &mut watched, detail);
            let (_, profile) = found.unwrap();
            assert_eq!(watched, plain);
            let timed = profile.passes().all(|pass| pass.nanoseconds.is_some());
            assert_eq!(timed, left_out.is_empty());
            assert!(profile.passes().any(|pass| pass.work.triangles.is_some_and(|n| n > 0)));
        }
    }
}

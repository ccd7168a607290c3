//! Raster scans that go in pairs, on any device, against scans in turn and against the twin.

use geosweep::surface::builtin::Builtin;
use geosweep::vulkan::{HeadlessSolver, Method, Schedule, Tuning};
use geosweep::{Sources, Stop, Surface, Wavefront};

use crate::common::*;
use crate::headless::assert_schedule_twins;
use crate::tile_lanes::{Problem, assert_nothing_said, problems};

/// Largest difference of converged maps, relative to the largest distance.
const AGREEMENT: f64 = 1e-6;

/// Widths of workgroups, and lines in a block. Of the problems' grids, lines fit a workgroup of 64 texels, which
/// takes blocks in turn, and they do not fit the others. The parts of obtuse triangles see up to three blocks
/// of one line past the middle.
const FORMS: [(u32, u32); 4] = [(64, 4), (16, 4), (16, 1), (32, 8)];

fn solver((scan_width, scan_lines): (u32, u32), scan_pairs: bool) -> HeadlessSolver {
    let solver = HeadlessSolver::with_validation(&device_choice()).unwrap();
    let tuning = Tuning { scan_width, scan_lines, scan_pairs, ..solver.tuning() };
    solver.with_tuning(tuning).unwrap()
}

fn raster(wavefront: Wavefront, stop: Stop) -> Method {
    Method::new(wavefront, stop).with_schedule(Schedule::Raster)
}

/// Returns a surface of obtuse triangles whose fronts come from all sides.
fn obtuse() -> Problem {
    let surface = Builtin::ShearedPlane { degrees: 60.0 }.surface(47, 38).unwrap();
    let sources = Sources::point(20.0, 11.25).and_point(44.0, 30.0, 2.0);
    let seeds = sources.seeds(&surface).unwrap();
    let wavefronts = &[Wavefront::Planar, Wavefront::Circular, Wavefront::Curved];
    Problem { what: "obtuse", surface, seeds, wavefronts }
}

/// The surfaces have holes, obtuse triangles, an uneven slowness, several origins and anchors.
#[test]
fn pairs_lead_to_the_map_of_scans_in_turn() {
    let problems: Vec<_> = problems().into_iter().chain([obtuse()]).collect();
    for form in FORMS {
        let [mut in_turn, mut in_pairs] = [false, true].map(|pairs| solver(form, pairs));
        for problem in &problems {
            for &wavefront in problem.wavefronts {
                let method = raster(wavefront, CONVERGED);
                let what = format!("{}, {wavefront}, {form:?}", problem.what);
                let [wanted, found] = [&mut in_turn, &mut in_pairs].map(|solver| {
                    let mut on_device = solver.upload(&problem.surface).unwrap();
                    let found = solver.solve(&mut on_device, &problem.seeds, method).unwrap();
                    let again = solver.solve(&mut on_device, &problem.seeds, method).unwrap();
                    assert_eq!(found.distances, again.distances, "{what}");
                    found
                });
                let difference = difference(&wanted.distances, &found.distances);
                assert!(difference < AGREEMENT, "{what}: {difference:e}");
                assert!(found.residual <= CONVERGED.tolerance, "{what}");
                let apart = wanted.iterations.abs_diff(found.iterations);
                assert!(apart <= 2, "{what}: {} and {}", wanted.iterations, found.iterations);
            }
        }
        assert_nothing_said(&in_pairs);
    }
}

/// Some iterations are in a second recording.
#[test]
fn every_iteration_of_pairs_is_one_of_its_twin() {
    let maze = Builtin::Maze.surface(71, 84).unwrap();
    let (sphere, holes) = (rough(75, 62, 0), rough(64, 81, 4));
    let cases: [(&Surface, _); 3] =
        [(&maze, (0, 0)), (&sphere, (50, 13)), (&holes, some_point(&holes))];
    for form in [FORMS[0], FORMS[2]] {
        let mut solver = solver(form, true);
        for (surface, source) in cases {
            assert_schedule_twins(&mut solver, surface, source, Schedule::Raster, [1, 2, 3, 6]);
        }
        assert_nothing_said(&solver);
    }
}

#[test]
fn sources_can_be_added_to_maps_of_pairs() {
    for form in [FORMS[0], FORMS[1]] {
        let [mut in_turn, mut in_pairs] = [false, true].map(|pairs| solver(form, pairs));
        for problem in problems() {
            let others = Sources::point(1.0, 2.0).seeds(&problem.surface);
            let Ok(others) = others else { continue };
            for &wavefront in problem.wavefronts {
                let method = raster(wavefront, CONVERGED);
                let [wanted, found] = [&mut in_turn, &mut in_pairs].map(|solver| {
                    let mut on_device = solver.upload(&problem.surface).unwrap();
                    solver.solve(&mut on_device, &problem.seeds, method).unwrap();
                    solver.add(&mut on_device, &others, method).unwrap().distances
                });
                let difference = difference(&wanted, &found);
                let what = format!("{}, {wavefront}, {form:?}", problem.what);
                assert!(difference < AGREEMENT, "{what}: {difference:e}");
            }
        }
        assert_nothing_said(&in_pairs);
    }
}

/// Prints barriers and iterations. The grid has `GEOSWEEP_SIDE` points per side, or 140, of which lines do not
/// fit a workgroup.
#[test]
fn pairs_take_half_the_barriers_and_as_many_iterations() {
    let side = std::env::var("GEOSWEEP_SIDE").map_or(140, |side| side.parse().unwrap());
    for builtin in [Builtin::Sphere, Builtin::Peaks, Builtin::Maze] {
        let surface = builtin.surface(side, side).unwrap();
        let seeds = seeds_at(&surface, some_point(&surface));
        for wavefront in [Wavefront::Planar, Wavefront::Curved] {
            let found = [false, true].map(|pairs| {
                let mut solver = HeadlessSolver::new(&device_choice()).unwrap();
                let tuning = Tuning { scan_pairs: pairs, ..solver.tuning() };
                solver = solver.with_tuning(tuning).unwrap();
                let mut on_device = solver.upload(&surface).unwrap();
                let method = raster(wavefront, CONVERGED);
                let map = solver.solve(&mut on_device, &seeds, method).unwrap();
                (map.iterations, map.distances)
            });
            let [(before, in_turn), (after, in_pairs)] = &found;
            println!("{builtin}, {wavefront}: {before} iterations in turn, {after} in pairs");
            assert!(difference(in_turn, in_pairs) < AGREEMENT, "{builtin}, {wavefront}");
            assert!(*after <= before + 1, "{builtin}, {wavefront}");
        }
    }
}

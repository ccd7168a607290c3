//! Raster scans that go in pairs, on any device, against scans in turn and against the twin.

use geosweep::surface::builtin::Builtin;
use geosweep::vulkan::{HeadlessSolver, Method, Schedule, Tuning};
use geosweep::{Sources, Stop, Surface, Wavefront};

use crate::common::*;
use crate::headless::assert_schedule_twins;
use crate::tile_lanes::{Problem, problems};

/// Largest difference of converged maps, relative to the largest distance.
const AGREEMENT: f64 = 1e-6;

/// Widths of workgroups, and numbers of lines in a block. The lines of the problems' grids fit a workgroup of 64
/// texels, which takes blocks in turn. They do not fit a workgroup of 16 texels. Updates of the parts of obtuse
/// triangles read up to three blocks of one line past the middle.
const FORMS: [(u32, u32); 2] = [(64, 4), (16, 1)];

fn in_pairs((scan_width, scan_lines): (u32, u32)) -> HeadlessSolver {
    tuned(|old| Tuning { scan_width, scan_lines, scan_pairs: true, ..old })
}

fn raster(wavefront: Wavefront, stop: Stop) -> Method {
    Method::new(wavefront, stop).with_schedule(Schedule::Raster)
}

/// Returns a problem with a surface of obtuse triangles and fronts from all sides.
fn obtuse() -> Problem {
    let surface = Builtin::ShearedPlane { degrees: 60.0 }.surface(47, 38).unwrap();
    let sources = Sources::point(20.0, 11.25).and_point(44.0, 30.0, 2.0);
    let seeds = sources.seeds(&surface).unwrap();
    let wavefronts = &[Wavefront::Planar, Wavefront::Circular, Wavefront::Curved];
    Problem { what: "obtuse", surface, seeds, wavefronts }
}

/// The surfaces have holes, obtuse triangles, an uneven slowness, several origins and anchors. Then a source is
/// added to each map.
#[test]
fn pairs_lead_to_the_map_of_scans_in_turn() {
    let mut in_turn = vulkan_solver();
    let mut forms = FORMS.map(|form| (form, in_pairs(form)));
    for problem in problems().into_iter().chain([obtuse()]) {
        let added = Sources::point(1.0, 2.0).seeds(&problem.surface).ok();
        for &wavefront in problem.wavefronts {
            let method = raster(wavefront, CONVERGED);
            let solve = |solver: &mut HeadlessSolver| {
                let mut on_device = solver.upload(&problem.surface).unwrap();
                let map = solver.solve(&mut on_device, &problem.seeds, method).unwrap();
                let again = solver.solve(&mut on_device, &problem.seeds, method).unwrap();
                assert_eq!(map.distances, again.distances, "{}, {wavefront}", problem.what);
                let both = added.as_ref().map(|seeds| solver.add(&mut on_device, seeds, method));
                (map, both.map(|both| both.unwrap().distances))
            };
            let (wanted, both_wanted) = solve(&mut in_turn);
            for (form, in_pairs) in &mut forms {
                let (found, both) = solve(in_pairs);
                let what = format!("{}, {wavefront}, {form:?}", problem.what);
                let apart = difference(&wanted.distances, &found.distances);
                assert!(apart < AGREEMENT, "{what}: {apart:e}");
                assert!(found.residual <= CONVERGED.tolerance, "{what}");
                let more = wanted.iterations.abs_diff(found.iterations);
                assert!(more <= 2, "{what}: {} and {}", wanted.iterations, found.iterations);
                let Some((wanted, found)) = both_wanted.as_ref().zip(both) else { continue };
                let apart = difference(wanted, &found);
                assert!(apart < AGREEMENT, "{what}, added: {apart:e}");
            }
        }
    }
    forms.iter().for_each(|(_, solver)| assert_nothing_said(solver));
}

/// Some iterations are in a second recording.
#[test]
fn every_iteration_of_pairs_is_one_of_its_twin() {
    let maze = Builtin::Maze.surface(71, 84).unwrap();
    let (sphere, holes) = (rough(75, 62, 0), rough(64, 81, 4));
    let cases: [(&Surface, _); 3] =
        [(&maze, (0, 0)), (&sphere, (50, 13)), (&holes, some_point(&holes))];
    for form in FORMS {
        let mut solver = in_pairs(form);
        for (surface, source) in cases {
            assert_schedule_twins(&mut solver, surface, source, Schedule::Raster, [1, 2, 6]);
        }
        assert_nothing_said(&solver);
    }
}

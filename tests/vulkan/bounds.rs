//! Bounds that hold for any map, on surfaces on which nothing was tuned: with each schedule, and compared
//! with the CPU engine.

use geosweep::Wavefront;
use geosweep::cpu;
use geosweep::surface::EdgeLengths;
use geosweep::vulkan::{HeadlessSolver, Method, Schedule};

use crate::common::bounds::{APART, Case, SETTLED, cases};
use crate::common::vulkan_solver;

/// Returns the failures, and the wavefronts that have converged to another result than the CPU's.
fn solve(solver: &mut HeadlessSolver, case: &Case) -> (Vec<String>, Vec<String>) {
    let bounds = case.bounds();
    let edges = EdgeLengths::<f32>::new(&case.surface).unwrap();
    let mut on_device = solver.upload(&case.surface).unwrap();
    let (mut failures, mut apart) = (Vec::new(), Vec::new());
    for wavefront in case.wavefronts() {
        let seeds = case.starts(wavefront);
        let of_cpu = cpu::rotated_scan(&edges, &seeds, wavefront, SETTLED);
        let settled_on_cpu = of_cpu.residual <= SETTLED.tolerance;
        let of_cpu = of_cpu.distances();
        for schedule in Schedule::ALL {
            let what = format!("{}, {wavefront}, {schedule}", case.name);
            let method = Method::new(wavefront, SETTLED).with_schedule(schedule);
            let found = solver.solve(&mut on_device, &seeds, method).unwrap();
            if let Err(error) = bounds.check(&found.distances) {
                failures.push(format!("{what}: {error}"));
                continue;
            }
            if found.residual > SETTLED.tolerance {
                failures.push(format!("{what}: not settled"));
                continue;
            }
            let most = bounds.difference(&of_cpu, &found.distances);
            if settled_on_cpu && most > APART {
                let of = if wavefront == Wavefront::Planar { &mut failures } else { &mut apart };
                of.push(format!("{what}: {most:.1e} from the CPU's"));
            }
        }
    }
    (failures, apart)
}

fn check(usual: u64, case: impl Fn(u64) -> Case) {
    let mut solver = vulkan_solver();
    let cases = cases(usual);
    let count = (cases.end - cases.start) as usize;
    let (failures, apart): (Vec<_>, Vec<_>) =
        cases.map(|number| solve(&mut solver, &case(number))).unzip();
    let [failures, apart] = [failures, apart].map(|of| of.concat());
    for line in failures.iter().chain(&apart) {
        println!("{line}");
    }
    assert!(failures.is_empty(), "{} failures in {count} cases", failures.len());
    assert!(apart.len() <= 1 + count / 200, "{} maps apart in {count} cases", apart.len());
}

#[test]
fn maps_keep_their_bounds_on_any_surface() {
    check(40, Case::new);
}

#[test]
fn maps_keep_their_bounds_over_patches_of_slowness() {
    check(40, Case::patches);
}

#[test]
fn maps_keep_their_bounds_on_irregular_grids() {
    check(40, Case::irregular);
}

#[test]
fn maps_keep_their_bounds_around_clusters_of_sources() {
    check(10, Case::clusters);
}

/// A part of an obtuse triangle ends on the line that a scan of a tile is updating.
#[test]
fn tiles_see_changes_on_the_line_itself() {
    let (failures, apart) = solve(&mut vulkan_solver(), &Case::new(7100));
    assert_eq!([failures, apart].concat(), [""; 0]);
}

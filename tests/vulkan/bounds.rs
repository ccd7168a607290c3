//! Bounds that any map keeps, on surfaces that nothing was tuned on: each schedule, and against the CPU engine.

use geosweep::Wavefront;
use geosweep::cpu;
use geosweep::surface::EdgeLengths;
use geosweep::vulkan::{Method, Schedule, Solver};

use crate::common::bounds::{Case, SETTLED, cases};
use crate::common::vulkan_solver;

fn failures(solver: &mut Solver, case: &Case) -> Vec<String> {
    let seeds = case.seeds();
    let bounds = case.bounds();
    let edges = EdgeLengths::<f32>::new(&case.surface).unwrap();
    let mut on_device = solver.upload(&case.surface).unwrap();
    let mut failures = Vec::new();
    for wavefront in Wavefront::ALL {
        if wavefront == Wavefront::PointSource && !case.sources.are_points() {
            continue;
        }
        let of_cpu = cpu::rotated_scan(&edges, &seeds, wavefront, SETTLED);
        let settled_on_cpu = of_cpu.residual <= SETTLED.tolerance;
        let of_cpu = of_cpu.distances();
        for schedule in Schedule::ALL {
            let what = format!("{}, {wavefront}, {schedule}", case.name);
            let method = Method { wavefront, schedule: Some(schedule), stop: SETTLED };
            let found = solver.solve(&mut on_device, &seeds, method).unwrap();
            if let Err(error) = bounds.check(&found.distances) {
                failures.push(format!("{what}: {error}"));
                continue;
            }
            if found.residual > SETTLED.tolerance {
                failures.push(format!("{what}: not settled"));
                continue;
            }
            let apart = |(a, b): (&f32, &f32)| if a.is_finite() { (a - b).abs() } else { 0.0 };
            let most = of_cpu.iter().zip(&found.distances).map(apart).fold(0.0, f32::max);
            let most = f64::from(most) / bounds.largest;
            if settled_on_cpu && most > 1e-4 {
                failures.push(format!("{what}: {most:.1e} from the CPU's"));
            }
        }
    }
    failures
}

#[test]
fn maps_keep_their_bounds_on_any_surface() {
    let mut solver = vulkan_solver();
    let cases = cases(60);
    let count = cases.end - cases.start;
    let failures: Vec<_> =
        cases.flat_map(|number| failures(&mut solver, &Case::new(number))).collect();
    for failure in &failures {
        println!("{failure}");
    }
    assert!(failures.is_empty(), "{} failures in {count} cases", failures.len());
}

//! Bounds that any map keeps, on surfaces that nothing was tuned on.

use geosweep::cpu::{self, twins};
use geosweep::surface::{EdgeLengths, Real};
use geosweep::{Wavefront, cpu::Solution};

use crate::common::bounds::{Case, SETTLED, cases};

fn checked<R: Real>(case: &Case, what: &str, solution: &Solution<R>) -> Result<Vec<f64>, String> {
    let distances = solution.distances();
    case.bounds().check(&distances).map_err(|error| format!("{}, {what}: {error}", case.name))?;
    if solution.residual > SETTLED.tolerance {
        return Err(format!("{}, {what}: not settled", case.name));
    }
    Ok(distances.iter().map(|distance| distance.wide()).collect())
}

fn failures(case: &Case) -> Vec<String> {
    let seeds = case.seeds();
    let edges = EdgeLengths::<f32>::new(&case.surface).unwrap();
    let mut failures = Vec::new();
    for wavefront in Wavefront::ALL {
        if wavefront == Wavefront::PointSource && !case.sources.are_points() {
            continue;
        }
        let rotated = cpu::rotated_scan(&edges, &seeds, wavefront, SETTLED);
        let in_turn = twins::scan_in_turn(&edges, &seeds, wavefront, SETTLED);
        let maps = [("rotated scans", rotated), ("scans in turn", in_turn)]
            .map(|(what, solution)| checked(case, &format!("{wavefront}, {what}"), &solution));
        failures.extend(maps.iter().filter_map(|map| map.clone().err()));
        let [Ok(a), Ok(b)] = maps else { continue };
        let apart = |(a, b): (&f64, &f64)| if a.is_finite() { (a - b).abs() } else { 0.0 };
        let most = a.iter().zip(&b).map(apart).fold(0.0, f64::max) / case.bounds().largest;
        if most > 1e-4 {
            failures.push(format!("{}, {wavefront}: {most:.1e} apart", case.name));
        }
    }
    failures
}

#[test]
fn maps_keep_their_bounds_on_any_surface() {
    let cases = cases(400);
    let count = cases.end - cases.start;
    let failures: Vec<_> = cases.flat_map(|number| failures(&Case::new(number))).collect();
    for failure in &failures {
        println!("{failure}");
    }
    assert!(failures.is_empty(), "{} failures in {count} cases", failures.len());
}

//! Bounds that hold for any map, on surfaces on which nothing was tuned.

use geosweep::cpu::{self, Order, RotatedScan, twins};
use geosweep::surface::{EdgeLengths, Real, Seed};
use geosweep::{Sources, Spacing, Surface, Wavefront, cpu::Solution};

use crate::common::bounds::{APART, Case, SETTLED, cases};
use crate::common::rotated;

fn checked<R: Real>(case: &Case, what: &str, solution: &Solution<R>) -> Result<Vec<f64>, String> {
    let distances = solution.distances();
    case.bounds().check(&distances).map_err(|error| format!("{}, {what}: {error}", case.name))?;
    if solution.residual > SETTLED.tolerance {
        return Err(format!("{}, {what}: not settled", case.name));
    }
    Ok(distances.iter().map(|distance| distance.wide()).collect())
}

/// Checks the map that is solved by patches. A patch has only 16 points a side, so that many of these small grids have
/// several patches.
fn by_patches(
    case: &Case,
    edges: &EdgeLengths<f32>,
    seeds: &[Seed],
    wavefront: Wavefront,
) -> Result<(), String> {
    let mut solver = RotatedScan::in_order(edges, wavefront, Order::Patches { side: 16 });
    let settled = solver.solve(seeds, SETTLED).residual <= SETTLED.tolerance;
    let named = |error: &str| format!("{}, {wavefront}, patches: {error}", case.name);
    case.bounds().check(&solver.distances()).map_err(|error| named(&error.to_string()))?;
    if settled { Ok(()) } else { Err(named("not settled")) }
}

/// Returns messages on the failures, and messages on the maps that the two orders of scans have brought to different
/// results. Such a difference of planar maps is a failure.
fn solve(case: &Case) -> (Vec<String>, Vec<String>) {
    let edges = EdgeLengths::<f32>::new(&case.surface).unwrap();
    let (mut failures, mut apart) = (Vec::new(), Vec::new());
    for wavefront in case.wavefronts() {
        let seeds = case.starts(wavefront);
        let rotated = cpu::rotated_scan(&edges, &seeds, wavefront, SETTLED);
        let in_turn = twins::scan_in_turn(&edges, &seeds, wavefront, SETTLED);
        let maps = [("rotated scans", rotated), ("scans in turn", in_turn)]
            .map(|(what, solution)| checked(case, &format!("{wavefront}, {what}"), &solution));
        failures.extend(maps.iter().filter_map(|map| map.clone().err()));
        failures.extend(by_patches(case, &edges, &seeds, wavefront).err());
        let [Ok(a), Ok(b)] = maps else { continue };
        let most = case.bounds().difference(&a, &b);
        if most > APART {
            let of = if wavefront == Wavefront::Planar { &mut failures } else { &mut apart };
            of.push(format!("{}, {wavefront}: {most:.1e} apart", case.name));
        }
    }
    (failures, apart)
}

/// Checks that the bounds always hold, that planar maps do not depend on the order of scans, and that at most
/// `most_apart` of the other maps do.
fn check(case: impl Fn(u64) -> Case, most_apart: impl Fn(usize) -> usize) {
    let cases = cases(400);
    let count = (cases.end - cases.start) as usize;
    let (failures, apart): (Vec<_>, Vec<_>) = cases.map(|number| solve(&case(number))).unzip();
    let [failures, apart] = [failures, apart].map(|of| of.concat());
    for line in failures.iter().chain(&apart) {
        println!("{line}");
    }
    assert!(failures.is_empty(), "{} failures in {count} cases", failures.len());
    assert!(apart.len() <= most_apart(count), "{} maps apart in {count} cases", apart.len());
}

#[test]
fn maps_keep_their_bounds_on_any_surface() {
    check(Case::new, |count| 1 + count / 1000);
}

#[test]
fn maps_keep_their_bounds_over_patches_of_slowness() {
    check(Case::patches, |count| 1 + count / 1000);
}

#[test]
fn maps_keep_their_bounds_on_irregular_grids() {
    check(Case::irregular, |count| 1 + count / 400);
}

#[test]
fn maps_keep_their_bounds_around_clusters_of_sources() {
    check(Case::clusters, |count| 1 + count / 500);
}

/// A front that starts on a curve also arrives at the seeds of that curve. It arrives there at the start times of
/// these seeds, up to rounding, but the surface has changed its curvature. Here the surface is white noise.
#[test]
fn rounding_does_not_choose_between_a_curve_and_what_leaves_it() {
    let case = Case::new(20187);
    let single = EdgeLengths::<f32>::new(&case.surface).unwrap();
    let double = EdgeLengths::<f64>::new(&case.surface).unwrap();
    let single = cpu::rotated_scan(&single, &case.seeds(), Wavefront::Curved, SETTLED);
    let double = cpu::rotated_scan(&double, &case.seeds(), Wavefront::Curved, SETTLED);
    let most = case.bounds().difference(&single.distances(), &double.distances());
    assert!(most < 1e-5, "{most:.1e} apart");
}

/// A front that leaves a straight curve is not bent around the curve's ends, which lie on the border here.
#[test]
fn a_straight_curve_from_border_to_border_is_exact() {
    let surface = Surface::from_heights(9, 9, vec![0.0; 81], Spacing::square(1.0)).unwrap();
    let sources = Sources::curve([[0.0, 2.0], [8.0, 2.0]]);
    let map = rotated::<f32>(&surface, &sources, Wavefront::Curved, SETTLED).distances();
    for (index, distance) in map.into_iter().enumerate() {
        let exact = (index as f32 % 9.0 - 2.0).abs();
        approx::assert_abs_diff_eq!(distance, exact, epsilon = 1e-5);
    }
}

//! Maps that are solved patch by patch, with any number of threads, compared with maps by scans of the whole grid.

use geosweep::cpu::{Order, PatchCounts, RotatedScan};
use geosweep::surface::builtin::{Builtin, Closed};
use geosweep::surface::{EdgeLengths, Real, Seed};
use geosweep::{Convergence, Sources, Stop, Surface, Wavefront};

use crate::common::closed::{cube, flat, globe, octahedral};
use crate::common::{CONVERGED, CONVERGED_F64, at, difference, off_centre, points, rough};

/// A solved map, its convergence, and the counts of its visits to patches.
type Solved<R> = (Vec<R>, Convergence, Option<PatchCounts>);

fn solved<R: Real>(
    edges: &EdgeLengths<R>,
    seeds: &[Seed],
    wavefront: Wavefront,
    order: Order,
    stop: Stop,
) -> Solved<R> {
    let mut solver = RotatedScan::in_order(edges, wavefront, order);
    let convergence = solver.solve(seeds, stop);
    (solver.distances(), convergence, solver.patches())
}

/// Patches of 32 points a side.
const PATCHES: Order = Order::Patches { side: 32 };

/// Returns surfaces whose sides are mostly no multiples of a patch's side: flat, round, with obtuse triangles,
/// with holes.
fn surfaces() -> Vec<(&'static str, Surface)> {
    let built = |builtin: Builtin, rows, cols| builtin.surface(rows, cols).unwrap();
    vec![
        ("plane", built(Builtin::Plane, 100, 131)),
        ("sphere", built(Builtin::Sphere, 97, 96)),
        ("peaks", built(Builtin::Peaks, 120, 90)),
        ("face", built(Builtin::Face, 110, 110)),
        ("maze", built(Builtin::Maze, 150, 110)),
        ("sheared plane", built(Builtin::ShearedPlane { degrees: 60.0 }, 90, 100)),
        ("rough with holes", rough(101, 77, 9)),
    ]
}

/// Returns glued surfaces whose copies lie in several patches, with a source on a seam or beside one.
fn closed_surfaces() -> Vec<(&'static str, Surface, Sources)> {
    vec![
        ("torus", Closed::Torus.surface(70, 101).unwrap(), at([0.0, 100.0])),
        ("globe", globe(61, 121), at([20.0, 2.0])),
        ("octahedral", octahedral(40), at([0.0, 25.0])),
        ("cube", cube(31), at([3.0, 1.0])),
    ]
}

fn source(name: &str, surface: &Surface) -> Sources {
    if name == "maze" { at([0.0, 0.0]) } else { at(off_centre(surface.rows(), surface.cols())) }
}

#[test]
fn every_number_of_threads_gives_the_same_map_to_the_bit() {
    for (name, surface) in surfaces() {
        let edges = EdgeLengths::<f32>::new(&surface).unwrap();
        let seeds = source(name, &surface).seeds(&surface).unwrap();
        for wavefront in Wavefront::ALL {
            let with = |threads| {
                let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
                pool.install(|| solved(&edges, &seeds, wavefront, PATCHES, CONVERGED))
            };
            let alone = with(1);
            for threads in [2, 4, 16] {
                assert!(with(threads) == alone, "{name} {wavefront}, {threads} threads");
            }
        }
    }
}

/// Returns the largest difference between maps by patches and by lines, relative to the largest distance.
fn apart<R: Real>(surface: &Surface, seeds: &[Seed], wavefront: Wavefront, stop: Stop) -> f64 {
    let edges = EdgeLengths::<R>::new(surface).unwrap();
    let (by_lines, ..) = solved(&edges, seeds, wavefront, Order::Lines, stop);
    let mut most = 0.0f64;
    for side in [16, 32, 80] {
        let order = Order::Patches { side };
        let (map, convergence, _) = solved(&edges, seeds, wavefront, order, stop);
        assert!(convergence.residual <= stop.tolerance, "{wavefront}, {side}: {convergence:?}");
        most = most.max(difference(&map, &by_lines));
    }
    most
}

/// Returns a corridor that winds through every patch several times.
fn serpentine() -> Surface {
    let is_wall = |row: usize, col: usize| {
        let opening = if (row / 10).is_multiple_of(2) { 119 } else { 0 };
        row % 10 == 9 && col != opening
    };
    let mask: Vec<_> = (0..130 * 120).map(|k| !is_wall(k / 120, k % 120)).collect();
    flat(130, 120).with_mask(&mask).unwrap()
}

/// Checks maps by patches, in single precision (unless the bound is infinite) and in double precision.
fn check(name: &str, surface: &Surface, sources: &Sources, fronts: &[Wavefront], most: [f64; 2]) {
    let seeds = sources.seeds(surface).unwrap();
    for &wavefront in fronts {
        let single = match most[0].is_finite() {
            true => apart::<f32>(surface, &seeds, wavefront, CONVERGED),
            false => 0.0,
        };
        let double = apart::<f64>(surface, &seeds, wavefront, CONVERGED_F64);
        println!("{name} {wavefront}: {single:.1e} {double:.1e}");
        // Directions of rays are rounded, so their fronts differ by more in the last digits.
        let most = if wavefront == Wavefront::Rays { [4.0 * most[0], 1e-7] } else { most };
        assert!(single < most[0] && double < most[1], "{name} {wavefront}: {single:e} {double:e}");
    }
}

#[test]
fn patches_give_the_map_of_scans_of_the_whole_grid() {
    for (name, surface) in surfaces() {
        // On rough surfaces, rays that diffract at every hole settle in one of several ways.
        let fronts = if name.starts_with("rough") { &Wavefront::ALL[..4] } else { &Wavefront::ALL };
        check(name, &surface, &source(name, &surface), fronts, [3e-6, 1e-12]);
    }
    check("serpentine", &serpentine(), &at([0.0, 0.0]), &Wavefront::ALL, [f64::INFINITY, 1e-9]);
    // Fronts pass seams between patches.
    for (name, surface, sources) in closed_surfaces() {
        check(name, &surface, &sources, &Wavefront::FOR_ANY_SURFACE, [3e-6, 1e-12]);
    }
    for [rows, cols] in [[1, 1], [1, 90], [90, 1], [2, 2], [17, 33], [33, 16], [5, 100]] {
        let (name, surface) = (format!("{rows} x {cols}"), rough(rows, cols, 0));
        check(&name, &surface, &at([0.0; 2]), &Wavefront::FOR_ANY_SURFACE, [f64::INFINITY, 1e-6]);
    }
    let few = [Wavefront::Planar, Wavefront::Curved];
    let peaks = Builtin::Peaks.surface(120, 100).unwrap();
    // Points beside a corner where four patches meet, on a patch's border and inside a cell; and a line across many
    // patches.
    let line: Vec<_> = (0..90).map(|k| [10.0 + f64::from(k), 50.0]).collect();
    for places in [&[[31.0, 31.0], [63.5, 64.0], [100.3, 10.6]][..], &line] {
        check("several sources", &peaks, &points(places), &few, [f64::INFINITY, 1e-7]);
    }
    let slowness = (0..90 * 100).map(|k| if k % 100 / 30 == 1 { 3.0 } else { 1.0 });
    let plane = Builtin::Plane.surface(90, 100).unwrap();
    let slowed = plane.with_slowness(slowness.collect()).unwrap();
    check("slowness", &slowed, &at([10.0, 10.0]), &few, [f64::INFINITY, 1e-6]);
}

#[test]
fn added_sources_give_the_map_of_all_sources() {
    let surface = Builtin::Sphere.surface(150, 130).unwrap();
    let edges = EdgeLengths::<f64>::new(&surface).unwrap();
    let seeds = |point| at(point).seeds(&surface).unwrap();
    let (first, second) = (seeds([20.0, 20.0]), seeds([127.0, 95.0]));
    for wavefront in Wavefront::FOR_ANY_SURFACE {
        let mut solver = RotatedScan::in_order(&edges, wavefront, PATCHES);
        let visits = |solver: &RotatedScan<f64>| solver.patches().unwrap().visits;
        solver.solve(&first, CONVERGED_F64);
        let of_first = visits(&solver);
        let added = solver.add(&second, CONVERGED_F64);
        assert!(added.residual <= CONVERGED_F64.tolerance);
        let visited = visits(&solver);
        assert!(visited > of_first && visited < 3 * of_first, "{wavefront}: {of_first}, {visited}");
        let both = [first.clone(), second.clone()].concat();
        let mut lines = RotatedScan::in_order(&edges, wavefront, Order::Lines);
        lines.solve(&first, CONVERGED_F64);
        lines.add(&second, CONVERGED_F64);
        let apart = difference(&solver.distances(), &lines.distances());
        assert!(apart < 1e-7, "{wavefront}: {apart:e}");
        // No front of these sources comes earlier than the map's, so no patch is visited.
        solver.add(&both, CONVERGED_F64);
        assert_eq!(visits(&solver), visited, "{wavefront}");
    }
}

/// If the limit of iterations has stopped a map, adding its own sources again continues it until it has converged.
#[test]
fn adding_to_a_stopped_map_goes_on_with_it() {
    let surface = Builtin::Maze.surface(150, 110).unwrap();
    let edges = EdgeLengths::<f64>::new(&surface).unwrap();
    let seeds = source("maze", &surface).seeds(&surface).unwrap();
    for wavefront in [Wavefront::Planar, Wavefront::Curved] {
        let mut solver = RotatedScan::in_order(&edges, wavefront, PATCHES);
        let stopped = solver.solve(&seeds, CONVERGED_F64.or_after(1));
        assert!(stopped.residual > CONVERGED_F64.tolerance, "{wavefront}: {stopped:?}");
        let added = solver.add(&seeds, CONVERGED_F64);
        assert!(added.residual <= CONVERGED_F64.tolerance, "{wavefront}: {added:?}");
        let (whole, ..) = solved(&edges, &seeds, wavefront, Order::Lines, CONVERGED_F64);
        let apart = difference(&solver.distances(), &whole);
        assert!(apart < 1e-7, "{wavefront}: {apart:e}");
    }
}

#[test]
fn a_solver_forgets_the_map_before() {
    let surface = rough(120, 110, 11);
    let edges = EdgeLengths::<f32>::new(&surface).unwrap();
    for wavefront in Wavefront::ALL {
        let mut used = RotatedScan::in_order(&edges, wavefront, PATCHES);
        for point in [[60.0, 3.0], [119.0, 109.0], [7.0, 50.0]] {
            let Ok(seeds) = at(point).seeds(&surface) else { continue };
            let convergence = used.solve(&seeds, CONVERGED);
            let fresh = solved(&edges, &seeds, wavefront, PATCHES, CONVERGED);
            assert!((used.distances(), convergence, used.patches()) == fresh, "{wavefront}");
        }
    }
}

#[test]
fn maps_that_have_not_converged_say_so() {
    let surface = Builtin::Maze.surface(150, 110).unwrap();
    let edges = EdgeLengths::<f32>::new(&surface).unwrap();
    let seeds = at([0.0, 0.0]).seeds(&surface).unwrap();
    for wavefront in Wavefront::ALL {
        let limit = |iterations| {
            let stop = CONVERGED.or_after(iterations);
            solved(&edges, &seeds, wavefront, PATCHES, stop).1
        };
        let settled = limit(10_000);
        assert!(settled.residual <= CONVERGED.tolerance && settled.iterations > 2);
        let cut = limit(1);
        assert!(cut.residual > CONVERGED.tolerance && cut.iterations == 1, "{cut:?}");
        assert_eq!(limit(settled.iterations + 1), settled, "{wavefront}");
        // There is at least one iteration, as with scans of the whole grid.
        assert!(limit(0).residual > CONVERGED.tolerance);
    }
    let none = solved(&edges, &[], Wavefront::Planar, PATCHES, CONVERGED);
    assert_eq!((none.1.iterations, none.1.residual), (1, 0.0));
    assert!(none.0.iter().all(|distance| distance.is_infinite()));
}

/// Checks two means for smooth fronts: the number of threads that a round keeps busy, and the number of visits to a
/// patch.
#[test]
fn rounds_leave_room_for_many_threads() {
    let surface = Builtin::Sphere.surface(2048, 2048).unwrap();
    let edges = EdgeLengths::<f32>::new(&surface).unwrap();
    let seeds = Sources::point(1023.0, 1023.0).seeds(&surface).unwrap();
    for wavefront in [Wavefront::Planar, Wavefront::Curved] {
        let (by_lines, ..) = solved(&edges, &seeds, wavefront, Order::Lines, CONVERGED);
        let [small, large] = [64, 256].map(|side| {
            let order = Order::Patches { side };
            let (map, convergence, counts) = solved(&edges, &seeds, wavefront, order, CONVERGED);
            assert!(convergence.residual <= CONVERGED.tolerance);
            let apart = difference(&map, &by_lines);
            println!("{wavefront}, {side}: {apart:.1e} apart, {counts:?}");
            assert!(apart < 1e-5, "{wavefront}, {side}: {apart:e}");
            counts.unwrap()
        });
        let busy = small.visits as f64 / small.rounds as f64;
        let visits = large.visits as f64 / large.patches as f64;
        println!("{wavefront}: {busy:.1} threads, {visits:.2} visits");
        assert!(busy >= 10.0, "{wavefront}: {busy}");
        assert!(visits <= 3.0, "{wavefront}: {visits}");
    }
}

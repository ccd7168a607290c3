//! Maps that end at a radius or at targets: their distances are those of the whole map, and their work is that
//! of the area they reach.

use geosweep::cpu::{Order, RotatedScan};
use geosweep::surface::builtin::Builtin;
use geosweep::surface::{EdgeLengths, Real, Seed};
use geosweep::{Engine, Error, Options, Sources, Spacing, Surface, Targets, Wavefront};
use geosweep::{distance_map, distance_map_f64};

use crate::common::parts::{assert_is_part, assert_targets_end_maps, farthest, reached};
use crate::common::{CONVERGED, at, rough};

/// Patches of 32 points a side.
const PATCHES: Order = Order::Patches { side: 32 };

/// Returns surfaces with a source near the middle, or at a corner of the maze: flat, round, hilly, with obtuse
/// triangles, with holes.
fn surfaces([rows, cols]: [usize; 2]) -> Vec<(&'static str, Surface, [usize; 2])> {
    let built = |builtin: Builtin| builtin.surface(rows, cols).unwrap();
    let middle = [rows * 4 / 10, cols * 45 / 100];
    vec![
        ("plane", built(Builtin::Plane), middle),
        ("sphere", built(Builtin::Sphere), middle),
        ("peaks", built(Builtin::Peaks), middle),
        ("face", built(Builtin::Face), middle),
        ("maze", built(Builtin::Maze), [0, 0]),
        ("sheared plane", built(Builtin::ShearedPlane { degrees: 60.0 }), middle),
        ("rough with holes", rough(rows, cols, 9), {
            let rough = rough(rows, cols, 9);
            let near = |col: &usize| rough.has(middle[0], *col);
            [middle[0], (middle[1]..cols).find(near).unwrap()]
        }),
    ]
}

fn source([row, col]: [usize; 2]) -> Sources {
    at([row as f64, col as f64])
}

/// Returns a solved map and its number of visits.
fn solved<R: Real>(
    (edges, wavefront, order): (&EdgeLengths<R>, Wavefront, Order),
    seeds: &[Seed],
    stop: geosweep::Stop,
    radius: f64,
) -> (Vec<R>, u64) {
    let mut solver = RotatedScan::in_order(edges, wavefront, order);
    solver.set_radius(radius);
    solver.solve(seeds, stop);
    (solver.distances(), solver.visits())
}

#[test]
fn distances_within_a_radius_are_those_of_the_whole_map() {
    for (name, surface, from) in surfaces([101, 130]) {
        let edges = EdgeLengths::<f32>::new(&surface).unwrap();
        let seeds = source(from).seeds(&surface).unwrap();
        // On rough surfaces, rays that diffract at every hole settle in one of several ways.
        let has_rays = name != "rough with holes";
        for wavefront in Wavefront::ALL.into_iter().filter(|&w| has_rays || w != Wavefront::Rays) {
            for order in [Order::Lines, PATCHES] {
                let on = (&edges, wavefront, order);
                let (whole, _) = solved(on, &seeds, CONVERGED, f64::INFINITY);
                for share in [0.04, 0.3, 0.8] {
                    let radius = share * farthest(&whole);
                    let (near, _) = solved(on, &seeds, CONVERGED, radius);
                    let what = format!("{name}, {wavefront}, {order:?}, {share}");
                    assert_is_part(&near, &whole, radius, &what);
                }
            }
        }
    }
}

#[test]
fn double_precision_and_fast_marching_end_at_a_radius() {
    for (name, surface, from) in surfaces([60, 71]) {
        let sources = source(from);
        for wavefront in Wavefront::FOR_ANY_SURFACE {
            let options =
                |engine: Engine| Options::default().with_engine(engine).with_wavefront(wavefront);
            for engine in [Engine::Cpu, Engine::FastMarching] {
                let options = options(engine.clone());
                let whole = distance_map_f64(&surface, &sources, &options).unwrap();
                let radius = 0.4 * whole.report.max_distance;
                let options = options.with_radius(radius);
                let near = distance_map_f64(&surface, &sources, &options).unwrap();
                let what = format!("{name}, {wavefront}, {engine}");
                assert_is_part(&near.distances, &whole.distances, radius, &what);
                let single = distance_map(&surface, &sources, &options).unwrap();
                assert_eq!(single.report.reached, near.report.reached, "{what}");
            }
        }
    }
}

/// Compares a map that ends at a radius with the whole map. The radius is the fraction `share` of the farthest
/// distance. Returns the fraction of the points that the map reaches, and the fraction of the visits that it takes.
fn shares(
    (edges, wavefront, order): (&EdgeLengths<f32>, Wavefront, Order),
    seeds: &[Seed],
    share: f64,
) -> [f64; 2] {
    let (whole, all) = solved((edges, wavefront, order), seeds, CONVERGED, f64::INFINITY);
    let radius = share * farthest(&whole);
    let (near, visits) = solved((edges, wavefront, order), seeds, CONVERGED, radius);
    [reached(&near) as f64 / reached(&whole) as f64, visits as f64 / all as f64]
}

/// The radius is 40 to 90 points. A span of sixteen points is visited as a whole, so smaller discs cost more. Over
/// hills the source's front is renewed in more iterations than elsewhere, so the test uses a larger disc there: with a
/// radius of 45 points, curved fronts visit 2.36 times the area.
#[test]
fn visits_are_those_of_the_area_within_the_radius() {
    for (builtin, side) in [(Builtin::Plane, 1025), (Builtin::Sphere, 1025), (Builtin::Peaks, 2049)]
    {
        let surface = builtin.surface(side, side).unwrap();
        let edges = EdgeLengths::<f32>::new(&surface).unwrap();
        let seeds = source([side * 2 / 5, side * 9 / 20]).seeds(&surface).unwrap();
        for wavefront in [Wavefront::Planar, Wavefront::Curved] {
            let [area, visits] = shares((&edges, wavefront, Order::Lines), &seeds, 0.05);
            let ratio = visits / area;
            println!("{builtin} {wavefront}: area {area:.4}, visits {ratio:.2} times");
            assert!(ratio <= 2.2, "{builtin} {wavefront}: {ratio:.2} times");
        }
    }
}

#[test]
fn targets_cost_little_more_than_the_radius_that_they_need() {
    for (name, surface, from) in surfaces([400, 400]) {
        let edges = EdgeLengths::<f32>::new(&surface).unwrap();
        let seeds = source(from).seeds(&surface).unwrap();
        for wavefront in [Wavefront::Planar, Wavefront::Curved] {
            for order in [Order::Lines, PATCHES] {
                let on = (&edges, wavefront, order);
                let (whole, _) = solved(on, &seeds, CONVERGED, f64::INFINITY);
                for [row, col] in [[200, 220], [70, 130], [390, 50], [60, 380]] {
                    let is_there =
                        |&col: &usize| whole[surface.chart().index(row, col)].is_finite();
                    let Some(col) = (col..400).find(is_there).or((0..col).rev().find(is_there))
                    else {
                        continue;
                    };
                    let target = [row, col];
                    let distance = f64::from(whole[surface.chart().index(target[0], target[1])]);
                    let (_, needed) = solved(on, &seeds, CONVERGED, distance);
                    let mut solver = RotatedScan::in_order(&edges, wavefront, order);
                    solver.solve_to(&seeds, &Targets::all([target]), CONVERGED);
                    let what = format!("{name} {wavefront} {order:?} {target:?}");
                    assert_is_part(&solver.distances(), &whole, distance, &what);
                    let ratio = solver.visits() as f64 / needed as f64;
                    println!("{what}: {ratio:.3} times the visits");
                    // A patch is visited as a whole, so patches come near the bound: 1.299 on the sheared plane.
                    assert!(ratio <= 1.3, "{what}: {ratio:.3} times the visits");
                }
            }
        }
    }
}

#[test]
fn the_nearest_or_the_farthest_target_ends_the_map() {
    for engine in [Engine::Cpu, Engine::FastMarching] {
        assert_targets_end_maps(&Options::default().with_engine(engine));
    }
}

/// Start values count: a source that starts after the radius reaches nothing.
#[test]
fn start_values_count_for_the_radius() {
    let surface = Surface::from_heights(30, 90, vec![0.0; 2700], Spacing::square(1.0)).unwrap();
    let sources = at([15.0, 10.0]).and_point(15.0, 50.0, 104.0).and_point(15.0, 80.0, 120.0);
    let early = Sources::default().and_point(15.0, 10.0, 100.0);
    let sources = [early.and_point(15.0, 50.0, 104.0).and_point(15.0, 80.0, 120.0), sources];
    for (sources, radius) in sources.iter().zip([110.0, 7.0]) {
        let options = Options::default().with_engine(Engine::Cpu);
        let whole = distance_map(&surface, sources, &options).unwrap();
        let near = distance_map(&surface, sources, &options.with_radius(radius)).unwrap();
        assert_is_part(&near.distances, &whole.distances, radius, "several sources");
        assert!(near.distance(15, 80).is_infinite());
    }
    let late = Sources::default().and_point(15.0, 10.0, 9.0);
    let options = Options::default().with_engine(Engine::Cpu).with_radius(5.0);
    let none = distance_map(&surface, &late, &options).unwrap();
    assert_eq!(none.report.reached, 0);
}

#[test]
fn targets_that_cannot_be_reached_leave_the_map_whole() {
    // A wall through the whole grid.
    let mask: Vec<_> = (0..40 * 50).map(|index| index % 50 != 30).collect();
    let surface = Surface::from_heights(40, 50, vec![0.0; 2000], Spacing::square(1.0)).unwrap();
    let surface = surface.with_mask(&mask).unwrap();
    for engine in [Engine::Cpu, Engine::FastMarching] {
        let options = Options::default().with_engine(engine);
        let sources = at([20.0, 20.0]);
        let whole = distance_map(&surface, &sources, &options).unwrap();
        let targets = options.clone().with_targets(Targets::all([[20, 22], [20, 45]]));
        let map = distance_map(&surface, &sources, &targets).unwrap();
        assert_eq!((map.report.ends_at, map.distances), (None, whole.distances));
        let hole = options.with_targets(Targets::any([[20, 22], [7, 30]]));
        let error = distance_map(&surface, &sources, &hole).unwrap_err();
        assert!(error.to_string().contains("(7, 30) is in a hole"), "{error}");
    }
}

#[test]
fn a_solver_is_used_again_with_another_radius() {
    let surface = Builtin::Peaks.surface(90, 120).unwrap();
    let edges = EdgeLengths::<f32>::new(&surface).unwrap();
    let mut solver = RotatedScan::in_order(&edges, Wavefront::Curved, Order::Lines);
    for (from, radius) in [([20, 30], 1.0), ([70, 100], f64::INFINITY), ([45, 60], 0.5)] {
        let seeds = source(from).seeds(&surface).unwrap();
        solver.set_radius(radius);
        solver.solve(&seeds, CONVERGED);
        let (fresh, _) =
            solved((&edges, Wavefront::Curved, Order::Lines), &seeds, CONVERGED, radius);
        assert!(solver.distances() == fresh, "{radius}");
        let reached = solver.reached();
        assert_eq!(reached.len(), fresh.iter().filter(|distance| distance.is_finite()).count());
        assert!(reached.iter().all(|&(point, distance)| fresh[point] == distance));
    }
}

#[test]
fn limits_that_cannot_be_are_refused() {
    let surface = Surface::from_heights(9, 9, vec![0.0; 81], Spacing::square(1.0)).unwrap();
    let refused = |options: Options, part: &str| {
        let error = distance_map(&surface, &at([4.0, 4.0]), &options).unwrap_err();
        assert!(matches!(error, Error::Options(_)) && error.to_string().contains(part), "{error}");
    };
    for radius in [0.0, -1.0, f64::NAN] {
        refused(Options::default().with_radius(radius), "not a positive number");
    }
    refused(Options::default().with_targets(Targets::all([[9, 2]])), "(9, 2) is outside the grid");
    refused(Options::default().with_targets(Targets::any([])), "no target");
    let options = Options::default().with_radius(f64::INFINITY);
    let map = distance_map(&surface, &at([4.0, 4.0]), &options).unwrap();
    assert_eq!((map.report.reached, map.report.ends_at), (81, None));
}

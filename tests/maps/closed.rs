//! Closed surfaces: fronts pass the seams where sides of the grid are glued.

use std::f64::consts::{PI, TAU};

use geosweep::accuracy::Errors;
use geosweep::geometry::{Curve, PathTracer, contours, join_over_seams};
use geosweep::glam::DVec3;
use geosweep::surface::{EdgeLengths, Gluing, GluingError, GridSide, Run, Seam, SurfaceError};
use geosweep::{Engine, Options, Sources, Surface, Wavefront, distance_map, distance_map_f64};

use crate::common::closed::*;
use crate::common::curved;

/// Checks the errors of a curved map, relative to the distance: their mean, that at points with copies, and the largest
/// up to the distance `far`.
fn check(name: &str, surface: &Surface, source: [f64; 2], exact: &[f64], far: f64, most: [f64; 3]) {
    let map = distance_map(surface, &Sources::point(source[0], source[1]), &curved()).unwrap();
    assert!(map.report.converged && map.report.seams.is_empty(), "{name}: {:?}", map.report);
    let of = |counts: &dyn Fn(usize) -> bool| {
        let counted = |index| if counts(index) { exact[index] } else { f64::NAN };
        Errors::of(&map.distances, &(0..exact.len()).map(counted).collect::<Vec<_>>())
    };
    let copies = surface.copies().unwrap().members();
    let all = of(&|index| exact[index] > 1e-9);
    let on_seams = of(&|index| exact[index] > 1e-9 && copies.contains(&(index as u32)));
    let near = of(&|index| (1e-9..far).contains(&exact[index]));
    let iterations = map.report.iterations;
    println!("{name} from {source:?}: {all}; on seams {on_seams}; {iterations} iterations");
    let found = [all.mean_relative, on_seams.mean_relative, near.max_relative];
    assert!(found.iter().zip(most).all(|(found, most)| *found < most), "{name}: {found:?}");
    assert!(on_seams.mean_relative < 4.0 * all.mean_relative + 1e-6, "{name}: {found:?}");
    assert!(iterations <= 16, "{name}: {iterations}");
}

/// Returns the lengths of the shortest ways from a place to all points.
fn lengths(shape: Flat, from: [f64; 2]) -> Vec<f64> {
    let length = |index: usize| {
        let to = [(index / 65) as f64, (index % 65) as f64];
        shape.way(from, to).length()
    };
    (0..41 * 65).map(length).collect()
}

#[test]
fn unrolled_surfaces_are_exact_up_to_rounding() {
    let most = [4e-7, 6e-7, 3e-6];
    for (name, gluing, shape) in shapes() {
        let surface = flat(41, 65).with_gluing(gluing).unwrap();
        let exact = lengths(shape, [13.0, 3.0]);
        check(name, &surface, [13.0, 3.0], &exact, f64::INFINITY, most);
    }
    let (step, (_, _, shape)) = (TAU / 64.0, shapes()[0].clone());
    let exact: Vec<_> = lengths(shape, [13.0, 3.0]).iter().map(|length| step * length).collect();
    check("tube", &tube(41, 65), [13.0, 3.0], &exact, f64::INFINITY, most);
}

#[test]
fn spheres_are_whole_across_poles_folds_and_corners() {
    type Places = [[usize; 2]; 5];
    let globes: Places = [[50, 70], [40, 0], [0, 17], [1, 60], [100, 100]];
    let folded: Places = [[60, 60], [40, 75], [0, 60], [0, 30], [0, 0]];
    for (name, sphere, sources, [mean, largest]) in [
        ("globe", globe(101, 201), &globes[..], [2e-5, 5e-4]),
        ("octahedral", octahedral(60), &folded, [4.5e-5, 1e-3]),
        ("equal-area", equal_area(60), &folded, [4.5e-5, 1e-3]),
        ("cube", cube(51), &[[25, 25], [10, 33], [0, 20], [0, 0]], [3e-5, 1e-3]),
    ] {
        for &source in sources {
            let exact = on_sphere(&sphere, source);
            let most = [mean, f64::INFINITY, largest];
            check(name, &sphere, source.map(|at| at as f64), &exact, PI - 0.1, most);
        }
    }
}

/// Copies of a source are one source. Fast marching gives the same map as scans.
#[test]
fn copies_of_a_source_are_one_source() {
    let globe = globe(31, 61);
    for wavefront in [Wavefront::Planar, Wavefront::Circular, Wavefront::Curved] {
        let options = curved().with_wavefront(wavefront);
        let map = |sources: &Sources| distance_map(&globe, sources, &options).unwrap();
        let one = map(&Sources::point(12.5, 0.0));
        let other = map(&Sources::point(12.5, 60.0));
        let both = map(&Sources::point(12.5, 0.0).and_point(12.5, 60.0, 0.0));
        // If two sources are given, curved fronts replace circular ones, even if both sources are one point.
        let both = Some(&both).filter(|_| wavefront != Wavefront::Circular);
        for (name, map) in [("other", Some(&other)), ("both", both)] {
            let Some(map) = map else { continue };
            let pairs = one.distances.iter().zip(&map.distances);
            let apart = pairs.map(|(a, b)| (a - b).abs() / b).fold(0.0, f32::max);
            assert!(apart == 0.0, "{wavefront} {name}: {apart:e}");
        }
        for group in globe.copies().unwrap().iter() {
            let first = one.distances[group[0] as usize];
            assert!(group.iter().all(|&k| one.distances[k as usize] == first), "{wavefront}");
        }
    }
    let planar = curved().with_wavefront(Wavefront::Planar);
    let source = Sources::point(0.0, 5.0);
    let scans = distance_map(&globe, &source, &planar).unwrap();
    let marched = distance_map(&globe, &source, &planar.with_engine(Engine::FastMarching)).unwrap();
    for (a, b) in scans.distances.iter().zip(&marched.distances) {
        assert!((a - b).abs() <= 1e-5 * b, "{a} {b}");
    }
}

#[test]
fn sides_that_do_not_coincide_are_refused() {
    let refused = |surface: Surface, gluing: Gluing| match surface.with_gluing(gluing) {
        Err(SurfaceError::Gluing(error)) => error,
        other => panic!("{other:?}"),
    };
    let arc = |rows, cols| grid(rows, cols, |row, col| DVec3::new(col as f64, row as f64, 0.0));
    let apart = refused(arc(9, 9), Gluing::columns());
    assert!(matches!(apart, GluingError::Apart { apart: 8.0, edge: 1.0, .. }), "{apart}");
    assert!(apart.to_string().contains("row 0, column 0 and row 0, column 8"), "{apart}");
    let pole = Gluing::Seams(vec![Seam::Pole { side: GridSide::FirstRow, exact: true }]);
    assert!(matches!(refused(arc(9, 9), pole.clone()), GluingError::Apart { .. }));
    assert!(matches!(refused(flat(9, 9), pole), GluingError::NoPositions { .. }));
    assert!(matches!(refused(arc(9, 9), Gluing::Charts), GluingError::Nothing));
    assert!(matches!(refused(flat(2, 3), Gluing::columns()), GluingError::TooSmall { .. }));
    let run = |row, points| Run { from: (row, 0), to: geosweep::surface::Direction::East, points };
    let runs = |a, b| Gluing::Runs(vec![[a, b]]);
    assert!(matches!(refused(flat(5, 5), runs(run(0, 9), run(4, 9))), GluingError::Outside { .. }));
    assert!(matches!(refused(flat(5, 5), runs(run(0, 5), run(4, 4))), GluingError::Runs { .. }));
    let tube = flat(5, 5).with_gluing(Gluing::rows()).unwrap();
    assert!(matches!(refused(tube, Gluing::rows()), GluingError::Twice { .. }));
    let two = Gluing::Runs(vec![[run(0, 5), run(4, 5)]; 2]);
    assert!(matches!(refused(flat(5, 5), two), GluingError::Twice { .. }));
}

/// Traces paths from some places and compares their lengths with closed forms. Returns the number of paths that
/// jump over a seam.
fn trace(
    name: &str,
    surface: &Surface,
    source: [f64; 2],
    exact: impl Fn([f64; 2]) -> f64,
) -> usize {
    let sources = Sources::point(source[0], source[1]);
    let map = distance_map(surface, &sources, &curved()).unwrap();
    let edges = EdgeLengths::new(surface).unwrap();
    let paths = PathTracer::new(surface, &edges, &sources, &map.distances).unwrap();
    let chart = surface.chart();
    let places = (1..=150).map(|k| {
        let share = |by: f64| (f64::from(k) * by).fract();
        [share(0.618_034) * (chart.rows - 1) as f64, share(0.754_878) * (chart.cols - 1) as f64]
    });
    let (mut jumping, mut sum, mut largest, mut count) = (0, 0.0, 0f64, 0);
    for start in places {
        let [row, col] = start.map(|at| at as usize);
        if ![(0, 0), (0, 1), (1, 0), (1, 1)].iter().all(|(r, c)| surface.has(row + r, col + c)) {
            continue;
        }
        let path = paths.trace(start).unwrap_or_else(|error| panic!("{name}: {error}"));
        let vertices = &path.curve.vertices;
        assert_eq!(vertices.first(), Some(&start), "{name}");
        assert_eq!(vertices.last(), Some(&source), "{name} from {start:?}");
        let excess = (path.length - exact(start)).abs() / exact(start);
        (sum, largest, count) = (sum + excess, largest.max(excess), count + 1);
        let (jumps, steps) = (path.curve.jumps(surface), vertices.windows(2).enumerate());
        jumping += usize::from(!jumps.is_empty());
        for (index, step) in steps.filter(|(index, _)| !jumps.contains(&(index + 1))) {
            let apart = (step[1][0] - step[0][0]).abs().max((step[1][1] - step[0][1]).abs());
            assert!(apart <= 1.0 + 1e-9, "{name}: a step of {apart} cells at vertex {index}");
        }
        let parts = path.curve.parts(surface);
        let along: f64 = parts.iter().map(|part| part.length(surface).unwrap()).sum();
        assert!((along - path.curve.length(surface).unwrap()).abs() <= 1e-9 * along, "{name}");
    }
    let mean = sum / f64::from(count);
    println!("{name}: {jumping} of {count} paths jump, mean {mean:.1e}, largest {largest:.1e}");
    assert!(mean < 2e-4 && largest < 2e-3, "{name}: mean {mean:e}, largest {largest:e}");
    jumping
}

#[test]
fn paths_pass_seams() {
    for (name, gluing, shape) in shapes() {
        let surface = flat(41, 65).with_gluing(gluing).unwrap();
        // From the seam, paths from either side end at the place that was given.
        for source in [[12.0, 5.0], [20.0, 64.0]] {
            let exact = |at| shape.way(source, at).length();
            assert!(trace(name, &surface, source, exact) > 40);
        }
    }

    let on_sphere = |name, surface: &Surface, source: [usize; 2]| {
        let place = |at: [f64; 2]| {
            let curve = Curve { vertices: vec![at], closed: false };
            curve.lift(surface).unwrap()[0].normalize()
        };
        let source = source.map(|at| at as f64);
        let from = place(source);
        let exact = |at| angle(place(at), from);
        trace(name, surface, source, exact)
    };
    assert!(on_sphere("globe", &globe(81, 161), [30, 10]) > 30);
    assert!(on_sphere("globe from a pole", &globe(81, 161), [0, 40]) > 100);
    assert!(on_sphere("octahedral map", &octahedral(40), [30, 20]) > 30);
    assert!(on_sphere("cube", &cube(31), [10, 20]) > 60);
}

/// The middle of a folded side has no copy but itself. Paths cross the side there too, on the shortest way.
#[test]
fn paths_cross_a_folded_side_beside_its_middle() {
    let sphere = octahedral(20);
    let edges = EdgeLengths::new(&sphere).unwrap();
    let place = |at: [f64; 2]| {
        let curve = Curve { vertices: vec![at], closed: false };
        curve.lift(&sphere).unwrap()[0].normalize()
    };
    // The first row is folded at column 20, and the first column at row 20.
    let cases = [
        ([0.35, 19.1], [0.35, 20.9]),
        ([0.5, 20.75], [0.25, 19.4]),
        ([1.0, 18.0], [1.0, 22.0]),
        ([20.8, 0.3], [19.3, 0.4]),
    ];
    for (start, source) in cases {
        let sources = Sources::point(source[0], source[1]);
        let map = distance_map_f64(&sphere, &sources, &Options::default()).unwrap();
        let distances: Vec<f32> = map.distances.iter().map(|&at| at as f32).collect();
        let tracer = PathTracer::new(&sphere, &edges, &sources, &distances).unwrap();
        let path = tracer.trace(start).unwrap();
        let exact = place(start).dot(place(source)).acos();
        let vertices = &path.curve.vertices;
        let jumps = vertices.windows(2).filter(|pair| {
            let apart = [0, 1].map(|k| (pair[0][k] - pair[1][k]).abs());
            let lifted = place(pair[0]).distance(place(pair[1]));
            apart[0].max(apart[1]) > 0.1 && lifted < 1e-9
        });
        let jumps = jumps.count();
        println!("{start:?} to {source:?}: {} of {exact}, {jumps} crossings", path.length);
        // Cells beside a corner of the octahedron are far from parallelograms. Lengths inside these cells, which follow
        // from the lengths of their edges, are up to 11 % off.
        assert!((path.length / exact - 1.0).abs() < 0.15, "{start:?}: {} {exact}", path.length);
        assert_eq!(jumps, 1, "{start:?}: {vertices:?}");
    }
}

#[test]
fn contours_close_over_seams() {
    type Circle = fn(f64) -> f64;
    let (on_plane, on_sphere): (Circle, Circle) = (|radius| radius, f64::sin);
    let check = |name: &str,
                 surface: &Surface,
                 source: [usize; 2],
                 levels: &[f64],
                 radius: Circle| {
        let sources = Sources::point(source[0] as f64, source[1] as f64);
        let map = distance_map(surface, &sources, &curved()).unwrap();
        for contour in contours(&map, &sources, levels) {
            let count = contour.curves.len();
            let curves = join_over_seams(contour.curves, surface);
            let length: f64 = curves.iter().map(|curve| curve.length(surface).unwrap()).sum();
            let expected = TAU * radius(contour.level);
            println!(
                "{name} at {}: {count} parts, {} curves, {length}",
                contour.level,
                curves.len()
            );
            assert_eq!((curves.len(), curves[0].closed), (1, true), "{name} at {}", contour.level);
            assert!((length - expected).abs() < 5e-3 * expected, "{name}: {length} {expected}");
            for line in curves[0].lift(surface).unwrap().windows(2) {
                assert!(line[0].distance(line[1]) < 0.15, "{name}");
            }
        }
    };
    check("tube", &tube(61, 97), [30, 2], &[0.3, 1.0, 1.5], on_plane);
    check("globe", &globe(81, 161), [30, 3], &[0.4, 1.0, 1.6, 2.5], on_sphere);
    check("octahedral map", &octahedral(40), [25, 18], &[0.4, 1.0, 1.6, 2.5], on_sphere);
    check("equal-area map", &equal_area(40), [25, 18], &[0.4, 1.0, 1.6, 2.5], on_sphere);
    check("cube", &cube(31), [10, 20], &[0.4, 1.0, 1.6, 2.5], on_sphere);
}

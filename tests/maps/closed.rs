//! Closed surfaces: fronts pass the seams where sides of the grid are glued.

use std::f64::consts::{PI, TAU};

use geosweep::geometry::{Curve, PathTracer, contours, join_over_seams};
use geosweep::glam::DVec3;
use geosweep::surface::{EdgeLengths, Gluing, GluingError, GridSide, Run, Seam, SurfaceError};
use geosweep::{Engine, Options, Sources, Surface, Wavefront, distance_map, distance_map_f64};

use crate::common::closed::*;

fn curved() -> Options {
    Options::default().with_engine(Engine::Cpu).with_wavefront(Wavefront::Curved)
}

/// Errors of a map, relative to the distance: their mean, the mean at points that have copies, and the largest at
/// distances for which `is_usual` of [`errors`] is true.
struct Errors {
    mean: f64,
    on_seams: f64,
    largest: f64,
    iterations: u32,
}

fn errors(
    name: &str,
    surface: &Surface,
    source: [f64; 2],
    exact: impl Fn(usize, usize) -> f64,
    is_usual: impl Fn(f64) -> bool,
) -> Errors {
    let map = distance_map(surface, &Sources::point(source[0], source[1]), &curved()).unwrap();
    let copies = surface.copies().unwrap().members();
    let (mut sum, mut count, mut on_seams, mut of_seams, mut largest) = (0.0, 0, 0.0, 0, 0f64);
    for index in 0..surface.chart().points() {
        let (row, col) = surface.chart().position(index);
        let distance = exact(row, col);
        if !surface.has(row, col) || distance < 1e-9 {
            continue;
        }
        let error = (f64::from(map.distances[index]) - distance).abs() / distance;
        (sum, count) = (sum + error, count + 1);
        if copies.contains(&(index as u32)) {
            (on_seams, of_seams) = (on_seams + error, of_seams + 1);
        }
        if is_usual(distance) {
            largest = largest.max(error);
        }
    }
    assert!(map.report.converged && map.report.seams.is_empty(), "{name}: {:?}", map.report);
    let (mean, on_seams) = (sum / f64::from(count), on_seams / f64::from(of_seams));
    let iterations = map.report.iterations;
    println!(
        "{name}: {count} points, mean {mean:.1e}, on seams {on_seams:.1e}, largest {largest:.1e}, {iterations} iterations"
    );
    Errors { mean, on_seams, largest, iterations }
}

#[test]
fn unrolled_surfaces_are_exact_up_to_rounding() {
    let (rows, cols) = (61, 97);
    let step = TAU / 96.0;
    let round = |a: f64, b: f64, n: f64| (a - b).abs().min(n - (a - b).abs());
    let (row, col) = (20.0, 3.0);
    let all = |_| true;

    let cylinder = tube(rows, cols);
    let exact = |r: usize, c: usize| step * round(c as f64, col, 96.0).hypot(r as f64 - row);
    let found = errors("cylinder", &cylinder, [row, col], exact, all);
    assert!(found.mean < 4e-7 && found.on_seams < 6e-7 && found.largest < 3e-6);

    let torus = flat(rows, cols).with_gluing(Gluing::both()).unwrap();
    let exact = |r: usize, c: usize| round(c as f64, col, 96.0).hypot(round(r as f64, row, 60.0));
    let found = errors("flat torus", &torus, [row, col], exact, all);
    assert!(found.mean < 4e-7 && found.on_seams < 6e-7 && found.largest < 3e-6);

    let moebius = flat(rows, cols).with_gluing(Gluing::flipped_columns()).unwrap();
    let exact = |r: usize, c: usize| {
        let images = [(r, 0.0), (60 - r, 96.0), (60 - r, -96.0)];
        let images = images.map(|(r, by)| (c as f64 + by - col).hypot(r as f64 - row));
        images.into_iter().fold(f64::INFINITY, f64::min)
    };
    let found = errors("Moebius strip", &moebius, [row, col], exact, all);
    assert!(found.mean < 4e-7 && found.on_seams < 6e-7 && found.largest < 3e-6);
}

fn sphere_errors(name: &str, surface: &Surface, source: [usize; 2]) -> Errors {
    let from = surface.position(source[0], source[1]).unwrap();
    let exact = |row, col| {
        let Some(at) = surface.position(row, col) else { return 0.0 };
        at.cross(from).length().atan2(at.dot(from))
    };
    let away = |distance| distance < PI - 0.1;
    errors(&format!("{name} from {source:?}"), surface, source.map(|at| at as f64), exact, away)
}

#[test]
fn a_globe_is_whole_across_its_poles_and_its_date_line() {
    let globe = globe(101, 201);
    for source in [[50, 70], [40, 0], [0, 17], [1, 60], [100, 100]] {
        let found = sphere_errors("globe", &globe, source);
        assert!(found.mean < 2e-5 && found.largest < 5e-4 && found.iterations <= 16);
        assert!(found.on_seams < 4.0 * found.mean + 1e-6);
    }
}

#[test]
fn an_octahedral_map_is_a_whole_sphere() {
    for (name, sphere) in [("octahedral", octahedral(60)), ("equal-area", equal_area(60))] {
        for source in [[60, 60], [40, 75], [0, 60], [0, 30], [0, 0]] {
            let found = sphere_errors(name, &sphere, source);
            assert!(found.mean < 4.5e-5 && found.largest < 1e-3 && found.iterations <= 16);
            assert!(found.on_seams < 4.0 * found.mean + 1e-6);
        }
    }
}

#[test]
fn the_faces_of_a_cube_are_a_whole_sphere() {
    let sphere = cube(51);
    for source in [[25, 25], [10, 33], [0, 20], [0, 0]] {
        let found = sphere_errors("cube", &sphere, source);
        assert!(found.mean < 3e-5 && found.largest < 1e-3 && found.iterations <= 16);
        assert!(found.on_seams < 4.0 * found.mean + 1e-6);
    }
}

/// A torus whose columns are rolled and mirrored is the same torus.
#[test]
fn rolling_and_mirroring_changes_nothing_but_rounding() {
    let (rows, cols, source) = (41, 61, [7, 2]);
    let torus = |by: usize, mirrored: bool| {
        grid(rows, cols, move |row, col| {
            let col = if mirrored { 2 * (cols - 1) - col } else { col };
            let turn = |k: usize, n: usize| TAU * (k % n) as f64 / n as f64;
            let (u, v) = (turn(col + by, cols - 1), turn(row, rows - 1));
            let radius = 2.0 + v.cos();
            DVec3::new(radius * u.cos(), radius * u.sin(), v.sin())
        })
        .with_gluing(Gluing::both())
        .unwrap()
    };
    let map = |surface: &Surface, col: usize| {
        let source = Sources::point(source[0] as f64, col as f64);
        distance_map_f64(surface, &source, &curved()).unwrap()
    };
    let n = cols - 1;
    let plain = map(&torus(0, false), source[1]);
    for by in [1, 17, 59] {
        let rolled = map(&torus(by, false), (source[1] + n - by) % n);
        let mirrored = map(&torus(by, true), (by + n - source[1]) % n);
        for row in 0..rows {
            for col in 0..cols {
                let expected = plain.distance(row, col);
                let pairs = [
                    rolled.distance(row, (col + n - by) % n),
                    mirrored.distance(row, (by + n - col % n) % n),
                ];
                for found in pairs {
                    assert!(
                        (found - expected).abs() <= 1e-9 * expected,
                        "{by} {row},{col}: {found} {expected}"
                    );
                }
            }
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
        assert!((a - b).abs() <= 1e-4 * b, "{a} {b}");
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
    let round = |a: f64, b: f64, n: f64| (a - b).abs().min(n - (a - b).abs());
    let tube = flat(41, 65).with_gluing(Gluing::columns()).unwrap();
    let exact = |[r, c]: [f64; 2]| round(c, 5.0, 64.0).hypot(r - 20.0);
    assert!(trace("tube", &tube, [20.0, 5.0], exact) > 40);
    // The source is on the seam: paths from either side end at the place that was given.
    let exact = |[r, c]: [f64; 2]| round(c, 64.0, 64.0).hypot(r - 20.0);
    assert!(trace("tube from its seam", &tube, [20.0, 64.0], exact) > 40);

    let moebius = flat(41, 65).with_gluing(Gluing::flipped_columns()).unwrap();
    let exact = |[r, c]: [f64; 2]| {
        let images = [(r, 0.0), (40.0 - r, 64.0), (40.0 - r, -64.0)];
        let images = images.map(|(r, by)| (c + by - 5.0).hypot(r - 12.0));
        images.into_iter().fold(f64::INFINITY, f64::min)
    };
    assert!(trace("Moebius strip", &moebius, [12.0, 5.0], exact) > 40);

    let on_sphere = |name, surface: &Surface, source: [usize; 2]| {
        let place = |at: [f64; 2]| {
            let curve = Curve { vertices: vec![at], closed: false };
            curve.lift(surface).unwrap()[0].normalize()
        };
        let source = source.map(|at| at as f64);
        let from = place(source);
        let exact = |at| place(at).cross(from).length().atan2(place(at).dot(from));
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

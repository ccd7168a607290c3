//! Geodesic paths around holes, compared with exact polygons.

use geosweep::geometry::{Curve, Path, PathTracer};
use geosweep::glam::DVec2;
use geosweep::surface::EdgeLengths;
use geosweep::surface::builtin::Builtin;
use geosweep::{Sources, Spacing, Surface, Wavefront};

use crate::common::{CONVERGED, Random, at, off_centre, rotated};

/// Returns the paths that are pulled taut around corners, and the paths that follow the map alone.
fn both(surface: &Surface, sources: &Sources, map: &[f32], starts: &[[f64; 2]]) -> [Vec<Path>; 2] {
    let edges = EdgeLengths::new(surface).unwrap();
    let paths = PathTracer::new(surface, &edges, sources, map).unwrap();
    [paths.clone(), paths.along_the_map()]
        .map(|paths| paths.trace_all(starts).into_iter().map(Result::unwrap).collect())
}

/// Returns a thousand random places of a square grid that do not lie in holes.
fn starts_on(surface: &Surface, seed: u64) -> Vec<[f64; 2]> {
    let mut random = Random::new(seed);
    let last = (surface.rows() - 1) as f64;
    let is_on = |place| Curve { vertices: vec![place], closed: false }.lift(surface).is_ok();
    std::iter::from_fn(|| Some([0; 2].map(|_| last * random.next())))
        .filter(|&start| is_on(start))
        .take(1000)
        .collect()
}

fn converged(surface: &Surface, sources: &Sources) -> Vec<f32> {
    rotated::<f32>(surface, sources, Wavefront::Curved, CONVERGED).distances()
}

/// Returns four means of relative errors of the lengths of paths in the maze. Taut paths are compared first with
/// the exact polygon, and second with the map. Third, taut paths on a map of exact distances are compared with
/// the exact polygon. Fourth, paths along the map are compared with the exact polygon. Starts are at the same
/// places on all grids.
fn errors_in_the_maze(points: usize, wavefront: Wavefront) -> [f64; 4] {
    let surface = Builtin::Maze.surface(points, points).unwrap();
    let exact = Builtin::Maze.exact_distances(points, points, [0.0; 2]).unwrap();
    let mut random = Random::new(5);
    let mut place = || (32.0 * random.next()).floor() / 32.0 * (points - 1) as f64;
    let distance = |start: &[f64; 2]| exact[start[0] as usize * points + start[1] as usize];
    let starts: Vec<_> = (0..2000)
        .map(|_| [place(), place()])
        .filter(|start| distance(start).is_finite() && distance(start) > 0.0)
        .collect();
    let mean = |error: &dyn Fn(&Path, f64) -> f64, paths: &[Path]| {
        let errors = paths.iter().zip(&starts).map(|(path, start)| error(path, distance(start)));
        errors.sum::<f64>() / starts.len() as f64
    };
    let of_truth = |path: &Path, exact: f64| (path.length - exact).abs() / exact;
    let of_map = |path: &Path, _| (path.length - path.distance).abs() / path.distance;
    let sources = at([0.0; 2]);
    let map = rotated::<f32>(&surface, &sources, wavefront, CONVERGED).distances();
    let [taut, along] = both(&surface, &sources, &map, &starts);
    let truth: Vec<_> = exact.iter().map(|&distance| distance as f32).collect();
    let [on_truth, _] = both(&surface, &sources, &truth, &starts);
    [
        mean(&of_truth, &taut),
        mean(&of_map, &taut),
        mean(&of_truth, &on_truth),
        mean(&of_truth, &along),
    ]
}

/// Paths in the maze are straight from corner to corner, and as long as the exact polygons: within 5e-8
/// measured, the rounding of single precision. Paths along the map are 2.3e-5 too long at 65 points per side
/// and 3.6e-6 at 513, of order 0.89. Lengths differ from the map's values by the error of the map: by 1.8e-5
/// and 2.8e-6, of order 0.89.
#[test]
fn paths_in_the_maze_are_exact() {
    let (mut coarsest, mut before): (_, Option<[f64; 4]>) = (None, None);
    for points in [65, 129, 257, 513] {
        let errors = errors_in_the_maze(points, Wavefront::Curved);
        let order = |before: [f64; 4]| std::array::from_fn(|k| (before[k] / errors[k]).log2());
        let orders = before.map(order);
        let errors_here = errors.map(|error| format!("{error:.1e}")).join(", ");
        println!("{points}: {errors_here}; of order {:.2?}", orders.unwrap_or([0.0f64; 4]));
        let [truth, of_map, on_truth, along] = errors;
        let coarsest = *coarsest.get_or_insert(of_map);
        assert!(truth < 5e-7, "{points} points: {truth:e}");
        assert!(on_truth < 2e-7, "{points} points: {on_truth:e}");
        assert!(along > 5.0 * truth, "{points} points: {along:e} {truth:e}");
        let order = (coarsest / of_map).log2() / 3.0;
        assert!(points < 513 || order > 0.85, "{coarsest:e} {of_map:e}");
        before = Some(errors);
    }
}

/// On maps with anchors, lengths differ from the map's values only by the rounding of the map.
#[test]
fn paths_in_the_maze_are_as_long_as_anchors_say() {
    for points in [65, 129, 257, 513] {
        let [truth, of_map, ..] = errors_in_the_maze(points, Wavefront::Anchored);
        println!("{points}, anchors: {truth:.1e}, {of_map:.1e}");
        assert!(truth < 5e-7, "{points} points: {truth:e}");
        assert!(of_map < 1e-6, "{points} points: {of_map:e}");
    }
}

/// Returns the length of the shortest path past a convex polygon: straight, or around the convex hull of the
/// path's ends and the polygon, in either direction.
fn around(polygon: &[DVec2], ends: [DVec2; 2]) -> f64 {
    let mut points = polygon.to_vec();
    points.extend(ends);
    points.sort_by(|a, b| a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)));
    let half = |points: &mut dyn Iterator<Item = DVec2>| {
        let mut hull: Vec<DVec2> = Vec::new();
        for point in points {
            while let [.., a, b] = hull[..]
                && (b - a).perp_dot(point - b) <= 0.0
            {
                hull.pop();
            }
            hull.push(point);
        }
        hull.pop();
        hull
    };
    let mut hull = half(&mut points.iter().copied());
    hull.extend(half(&mut points.iter().rev().copied()));
    let on_hull = ends.map(|end| hull.iter().position(|vertex| *vertex == end));
    let [Some(a), Some(b)] = on_hull else { return ends[0].distance(ends[1]) };
    // If all of the polygon is on one side, one of the directions is the straight line.
    let length = |from: usize, to: usize| -> f64 {
        let count = (to + hull.len() - from) % hull.len();
        let at = |k: usize| hull[(from + k) % hull.len()];
        (0..count).map(|k| at(k).distance(at(k + 1))).sum()
    };
    length(a, b).min(length(b, a))
}

/// A flat floor has a square hole off its middle. Starts and sources lie between grid points. The mean error
/// measured is 1.0e-6 at 33 points per side and 4.6e-7 at 257; along the map it is 7.3e-5 and 6.9e-6. The
/// remaining errors come from the map where a path only just misses a corner. They are at most 1.2e-4 and
/// 9.8e-5.
#[test]
fn paths_around_a_square_are_exact() {
    for (points, [north, south, west, east]) in [
        (17, [7, 9, 6, 8]),
        (33, [11, 18, 13, 20]),
        (65, [21, 38, 27, 44]),
        (129, [43, 76, 53, 86]),
        (257, [87, 152, 107, 172]),
    ] {
        let is_floor = |row: usize, col: usize| {
            !((north..=south).contains(&row) && (west..=east).contains(&col))
        };
        let mask: Vec<_> = (0..points * points).map(|i| is_floor(i / points, i % points)).collect();
        let heights = vec![0.0; points * points];
        let surface = Surface::from_heights(points, points, heights, Spacing::square(1.0)).unwrap();
        let surface = surface.with_mask(&mask).unwrap();
        // The square's corners are cut off.
        let (n, s, w, e) = (north as f64, south as f64, west as f64, east as f64);
        let ring = [
            [n - 1.0, w],
            [n - 1.0, e],
            [n, e + 1.0],
            [s, e + 1.0],
            [s + 1.0, e],
            [s + 1.0, w],
            [s, w - 1.0],
            [n, w - 1.0],
        ];
        let hole = ring.map(DVec2::from_array);
        let last = (points - 1) as f64;
        let source = [0.07 * last + 0.375, 0.31 * last];
        let starts = starts_on(&surface, 8);
        let sources = at(source);
        let map = converged(&surface, &sources);
        let [taut, along] = both(&surface, &sources, &map, &starts);
        let [mut sum, mut largest, mut before] = [0.0, 0.0f64, 0.0];
        for (start, (path, along)) in starts.iter().zip(taut.iter().zip(&along)) {
            let exact = around(&hole, [DVec2::from_array(*start), DVec2::from_array(source)]);
            assert!(path.length <= along.length);
            let error = (path.length - exact).abs() / exact;
            sum += error / 1000.0;
            before += (along.length - exact).abs() / exact / 1000.0;
            largest = largest.max(error);
        }
        println!("{points}: mean {sum:.1e}, largest {largest:.1e}; along the map {before:.1e}");
        // The width of a cell, as a fraction of the grid's side. The bounds are proportional to it.
        let cell = 1.0 / points as f64;
        assert!(sum < 3e-4 * cell && largest < 0.1 * cell, "{points}: {sum:e} {largest:e}");
        assert!(sum < 0.2 * before, "{points}: {sum:e} {before:e}");
    }
}

/// No path leads through a hole in the sphere, and all are as long as the map says, to first order: within
/// 2.9e-3 measured at 65 points per side, 1.3e-3 at 129 and 7.6e-4 at 257.
#[test]
fn paths_around_a_hole_in_the_sphere_are_the_distances() {
    for points in [65, 129, 257] {
        let middle = 0.55 * (points - 1) as f64;
        let radius = 0.15 * (points - 1) as f64;
        let mask = |i: usize| {
            let (row, col) = ((i / points) as f64, (i % points) as f64);
            (row - middle).abs().max((col - middle).abs()) > radius
        };
        let mask: Vec<_> = (0..points * points).map(mask).collect();
        let surface = Builtin::Sphere.surface(points, points).unwrap().with_mask(&mask).unwrap();
        let source = off_centre(points, points);
        let starts = starts_on(&surface, 9);
        let sources = at(source);
        let map = converged(&surface, &sources);
        let [taut, along] = both(&surface, &sources, &map, &starts);
        let [mut largest, mut saved] = [0.0f64; 2];
        for (start, (path, along)) in starts.iter().zip(taut.iter().zip(&along)) {
            let Curve { vertices, .. } = &path.curve;
            assert_eq!((vertices[0], vertices[vertices.len() - 1]), (*start, source));
            assert!(path.length <= along.length, "{start:?}");
            assert!(path.curve.length(&surface).is_ok(), "{start:?}");
            let off = (path.length - path.distance).abs() / path.distance;
            largest = largest.max(off);
            saved = saved.max(1.0 - path.length / along.length);
        }
        println!("{points}: {largest:.1e} from the map, shorter by up to {saved:.1e}");
        assert!(largest < 0.25 / points as f64, "{points}: {largest:e}");
        assert!(saved > 1e-4, "{points}: {saved:e}");
    }
}

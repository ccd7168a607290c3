//! Sources that are added to a map, the farthest point, and farthest-point sampling.

use geosweep::Stop;
use geosweep::cpu::RotatedScan;
use geosweep::geometry::{Farthest, FarthestPoints, farthest};
use geosweep::surface::builtin::Builtin;
use geosweep::surface::{Chart, EdgeLengths, Real};
use geosweep::{Sources, Spacing, Surface, Wavefront};

use crate::common::closed::flat;
use crate::common::{CONVERGED, CONVERGED_F64, Random, difference, points};

/// Returns the map of all sources at once, and the map to which they were added one after another.
fn both_ways<R: Real>(
    surface: &Surface,
    places: &[[f64; 2]],
    wavefront: Wavefront,
    stop: Stop,
) -> [Vec<R>; 2] {
    let edges = EdgeLengths::new(surface).unwrap();
    let seeds = |places: &[[f64; 2]]| points(places).seeds(surface).unwrap();
    let mut at_once = RotatedScan::<R>::new(&edges, wavefront);
    at_once.solve(&seeds(places), stop);
    let mut added = RotatedScan::<R>::new(&edges, wavefront);
    for point in places {
        let before = added.distances();
        added.add(&seeds(&[*point]), stop);
        // A curved front may be later after it is renewed.
        let mut pairs = added.distances().into_iter().zip(before);
        assert!(wavefront == Wavefront::Curved || pairs.all(|(after, before)| after <= before));
    }
    [at_once.distances(), added.distances()]
}

const SMOOTH: [Builtin; 5] =
    [Builtin::Plane, Builtin::Sphere, Builtin::Cylinder, Builtin::Torus, Builtin::Peaks];

const POINTS: [[f64; 2]; 5] = [[3.0, 4.0], [60.0, 44.0], [10.5, 30.25], [60.0, 41.0], [35.0, 20.0]];

/// A planar front's map is the only fixed point of a monotone update, so the order of sources cannot matter. The updates
/// of other fronts use more than the arrival time. The first source's front is alone at first, so its updates are not
/// causal. This changes the rounding. Such updates are also more accurate from sources inside stretched cells.
#[test]
fn added_sources_give_the_map_of_all() {
    for builtin in SMOOTH {
        let surface = builtin.surface(70, 50).unwrap();
        let [at_once, added] =
            both_ways::<f64>(&surface, &POINTS, Wavefront::Planar, CONVERGED_F64);
        assert!(difference(&at_once, &added) < 1e-12, "{builtin}");
        for wavefront in Wavefront::FOR_ANY_SURFACE {
            let [at_once, added] = both_ways::<f32>(&surface, &POINTS, wavefront, CONVERGED);
            let difference = difference(&at_once, &added);
            let most = if wavefront == Wavefront::Planar { 1e-6 } else { 1e-5 };
            assert!(difference < most, "{builtin} {wavefront}: {difference:e}");
        }
    }
}

/// On rough surfaces with holes, fronts meet everywhere. Measured: 2e-8.
#[test]
fn sources_added_to_a_rough_map_give_the_map_of_all() {
    let mut random = Random::new(8);
    for _ in 0..20 {
        let heights = (0..70 * 50).map(|_| 1.5 * random.next()).collect();
        let surface = Surface::from_heights(70, 50, heights, Spacing::square(1.0)).unwrap();
        let mut mask: Vec<bool> = (0..70 * 50).map(|_| random.next() > 0.1).collect();
        let around = |[row, col]: [f64; 2]| {
            let (row, col) = (row as usize, col as usize);
            [(row, col), (row, col + 1), (row + 1, col), (row + 1, col + 1)]
        };
        POINTS.into_iter().flat_map(around).for_each(|(row, col)| mask[row * 50 + col] = true);
        let surface = surface.with_mask(&mask).unwrap();
        for wavefront in Wavefront::FOR_ANY_SURFACE {
            let [at_once, added] = both_ways::<f32>(&surface, &POINTS, wavefront, CONVERGED);
            let difference = difference(&at_once, &added);
            assert!(difference < 1e-6, "{wavefront}: {difference:e}");
        }
    }
}

#[test]
fn a_seed_behind_the_map_changes_nothing() {
    let surface = Builtin::Sphere.surface(40, 40).unwrap();
    let edges = EdgeLengths::<f32>::new(&surface).unwrap();
    for wavefront in Wavefront::FOR_ANY_SURFACE {
        let mut solver = RotatedScan::new(&edges, wavefront);
        solver.solve(&Sources::point(20.0, 20.0).seeds(&surface).unwrap(), CONVERGED);
        let before = solver.distances();
        let late = Sources::default().and_point(2.0, 3.0, 100.0).seeds(&surface).unwrap();
        let convergence = solver.add(&late, CONVERGED);
        assert_eq!((convergence.iterations, convergence.residual), (1, 0.0));
        assert_eq!(solver.distances(), before);
    }
}

#[test]
fn the_farthest_point_is_the_opposite_corner() {
    let surface = flat(21, 33);
    let edges = EdgeLengths::<f32>::new(&surface).unwrap();
    let mut solver = RotatedScan::new(&edges, Wavefront::Curved);
    solver.solve(&Sources::point(4.0, 10.0).seeds(&surface).unwrap(), CONVERGED);
    let far = farthest(surface.chart(), &solver.distances()).unwrap();
    assert_eq!((far.row, far.col), (20, 32));
    approx::assert_relative_eq!(far.distance, f32::hypot(16.0, 22.0), max_relative = 1e-6);
    let chart = Chart { rows: 1, cols: 2 };
    assert_eq!(farthest(chart, &[f32::INFINITY; 2]), None);
    let one = farthest(chart, &[f32::INFINITY, 0.0]);
    assert_eq!(one, Some(Farthest { row: 0, col: 1, distance: 0.0 }));
}

/// From a corner of a square, samples are the opposite corner, the other two corners, the middle, and then
/// the middles of the sides, which are equally far.
#[test]
fn samples_of_a_square_are_where_they_should_be() {
    let (surface, side) = (flat(65, 65), 64f32);
    let edges = EdgeLengths::<f32>::new(&surface).unwrap();
    let mut points = FarthestPoints::new(&surface, &edges, &Sources::point(0.0, 0.0)).unwrap();
    let samples: Vec<Farthest> = points.by_ref().take(8).collect();
    let places: Vec<_> = samples.iter().map(|sample| (sample.row, sample.col)).collect();
    assert_eq!(places[0], (64, 64));
    assert!(places[1..3].contains(&(0, 64)) && places[1..3].contains(&(64, 0)));
    assert_eq!(places[3], (32, 32));
    for place in [(0, 32), (32, 0), (32, 64), (64, 32)] {
        assert!(places[4..].contains(&place), "{place:?}");
    }
    let half = side / 2.0;
    let exact = [side * 2f32.sqrt(), side, side, half * 2f32.sqrt(), half, half, half, half];
    for (sample, exact) in samples.iter().zip(exact) {
        approx::assert_relative_eq!(sample.distance, exact, max_relative = 1e-4);
    }
    approx::assert_relative_eq!(points.radius(), half / 2f32.sqrt(), max_relative = 1e-4);
    assert_eq!(points.sources().iter().count(), 9);
}

/// Radii never grow. Every point lies within the last radius of a sample, and samples are at least the
/// previous radius apart, up to the error of the map where several fronts meet, which is where samples lie.
/// Measured: 0.11 cells.
#[test]
fn samples_cover_a_surface_and_lie_apart() {
    const SIDE: usize = 65;
    let surface = Builtin::Cylinder.surface(SIDE, SIDE).unwrap();
    let edges = EdgeLengths::<f32>::new(&surface).unwrap();
    let mut points = FarthestPoints::new(&surface, &edges, &Sources::point(5.5, 7.25)).unwrap();
    let samples: Vec<Farthest> = points.by_ref().take(40).collect();
    let radius = f64::from(points.radius());
    // A fifth of the longer side of a cell.
    let tolerance = 1.5 * std::f64::consts::PI / (SIDE - 1) as f64 / 5.0;
    let mut places = vec![[5.5, 7.25]];
    for pair in samples.windows(2) {
        assert!(pair[1].distance <= pair[0].distance * 1.0001);
    }
    let exact = |a, b| Builtin::Cylinder.exact_distance(SIDE, SIDE, a, b).unwrap();
    for sample in &samples {
        let at = [sample.row as f64, sample.col as f64];
        let nearest = places.iter().map(|&other| exact(other, at)).fold(f64::INFINITY, f64::min);
        approx::assert_abs_diff_eq!(nearest, f64::from(sample.distance), epsilon = tolerance);
        places.push(at);
    }
    for index in 0..SIDE * SIDE {
        let at = [(index / SIDE) as f64, (index % SIDE) as f64];
        let nearest = places.iter().map(|&other| exact(other, at)).fold(f64::INFINITY, f64::min);
        assert!(nearest < radius + tolerance);
    }
}

#[test]
fn parts_that_no_sample_reaches_come_first_and_holes_never() {
    let mask: Vec<bool> = (0..12 * 20).map(|i| i % 20 != 9 && i % 20 != 15).collect();
    let surface = flat(12, 20).with_mask(&mask).unwrap();
    let edges = EdgeLengths::<f32>::new(&surface).unwrap();
    let mut points = FarthestPoints::new(&surface, &edges, &Sources::point(0.0, 12.0)).unwrap();
    assert_eq!(points.radius(), f32::INFINITY);
    let first: Vec<_> = points.by_ref().take(2).map(|sample| (sample.row, sample.col)).collect();
    assert_eq!(first, [(0, 0), (0, 16)]);
    assert!(points.radius() < 20.0);
    // Every point becomes a sample once, and then none is left.
    let rest = points.by_ref().count();
    assert_eq!(rest + 3, surface.points());
    assert_eq!((points.next(), points.radius()), (None, 0.0));
    let holes = points.distances().iter().filter(|distance| distance.is_infinite()).count();
    assert_eq!(holes, 24);
}

#[test]
fn one_point_two_rows_and_a_source_off_the_surface() {
    let (one, two) = (flat(1, 1), flat(2, 9));
    let edges = EdgeLengths::<f32>::new(&one).unwrap();
    let mut points = FarthestPoints::new(&one, &edges, &Sources::point(0.0, 0.0)).unwrap();
    assert_eq!((points.next(), points.radius()), (None, 0.0));
    let edges = EdgeLengths::<f32>::new(&two).unwrap();
    let from = Sources::default().and_point(0.0, 0.0, 3.0);
    let mut points = FarthestPoints::new(&two, &edges, &from).unwrap();
    let sample = points.next().unwrap();
    assert_eq!((sample.row, sample.col), (1, 8));
    approx::assert_relative_eq!(sample.distance, 3.0 + f32::hypot(1.0, 8.0), max_relative = 1e-6);
    assert!(FarthestPoints::new(&two, &edges, &Sources::point(0.0, 9.0)).is_err());
    assert!(FarthestPoints::new(&two, &edges, &Sources::default()).is_err());
}

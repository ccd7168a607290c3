//! Maps of lone sources on planes whose cells are alike and far from square: sheared, or by a metric with long axes.

use geosweep::glam::DVec2;
use geosweep::surface::MetricTensor;
use geosweep::{Engine, Options, Sources, Surface, Wavefront, distance_map, distance_map_f64};

use crate::common::Random;

/// Returns a surface in whose cells a step along columns is `right` and one along rows is `down`, by its metric.
fn skewed(rows: usize, cols: usize, [right, down]: [DVec2; 2]) -> Surface {
    let tensor = MetricTensor { rr: down.dot(down), rc: down.dot(right), cc: right.dot(right) };
    Surface::from_metric(rows, cols, vec![tensor; rows * cols]).unwrap()
}

/// Returns the largest error of a map from a source, relative to the distance, but for points beside the source.
fn error(distances: &[f64], cols: usize, source: DVec2, [right, down]: [DVec2; 2]) -> f64 {
    let errors = distances.iter().enumerate().map(|(index, found)| {
        let step = DVec2::new((index / cols) as f64, (index % cols) as f64) - source;
        let exact = (step.x * down + step.y * right).length();
        (found - exact).abs() / exact.max(1e-3 * right.length().min(down.length()))
    });
    errors.fold(0.0, f64::max)
}

/// Metrics with axes of 1 to 100, turned by any angle, and cells sheared by up to 85 degrees.
fn cells() -> Vec<(String, [DVec2; 2])> {
    let mut random = Random::new(69);
    let mut all = Vec::new();
    for ratio in [1.5, 3.0, 5.0, 8.0, 10.0, 15.0, 30.0, 100.0] {
        for _ in 0..3 {
            let axis = DVec2::from_angle(3.2 * random.next());
            let stretched = |v: DVec2| v + axis * (ratio - 1.0) * axis.dot(v);
            all.push((format!("axes 1:{ratio}"), [DVec2::X, DVec2::Y].map(stretched)));
        }
    }
    for degrees in [20.0, 46.0, 55.0, 60.0, 70.0, 80.0, 85.0f64] {
        for side in [1.0, -1.0, 0.3f64] {
            let down = DVec2::new(side.signum() * degrees.to_radians().tan(), 1.0);
            all.push((format!("sheared by {degrees}"), [DVec2::X, side.abs() * down]));
        }
    }
    all
}

#[test]
fn lone_sources_are_exact_in_cells_of_any_shape() {
    let mut random = Random::new(70);
    for (name, cell) in cells() {
        let (rows, cols) = (31, 43);
        let surface = skewed(rows, cols, cell);
        let at_point = DVec2::new(12.0, 20.0);
        let inside = DVec2::new(30.0 * random.next(), 42.0 * random.next());
        for source in [at_point, inside] {
            let sources = Sources::point(source.x, source.y);
            let options = Options::default().with_wavefront(Wavefront::Curved);
            let map = distance_map_f64(&surface, &sources, &options).unwrap();
            let found = error(&map.distances, cols, source, cell);
            assert!(found < 1e-6, "{name}, {source}: {found:.1e}");
            let map = distance_map(&surface, &sources, &options).unwrap();
            let wide: Vec<f64> = map.distances.iter().map(|&d| f64::from(d)).collect();
            let found = error(&wide, cols, source, cell);
            // Lengths of edges are rounded, and along the long axis the distance is their small difference.
            assert!(found < 1e-3, "{name}, {source}, single: {found:.1e}");
        }
    }
}

#[test]
fn points_that_neighbours_are_far_from_are_reached_in_a_straight_line() {
    // The second row is shifted by seven columns.
    let surface = skewed(2, 8, [DVec2::X, DVec2::new(-7.0, 1.0)]);
    for engine in [Engine::Cpu, Engine::Auto] {
        let options = Options::default().with_engine(engine);
        let map = distance_map(&surface, &Sources::point(0.0, 0.0), &options).unwrap();
        assert!((map.distances[15] - 1.0).abs() < 1e-5, "{}", map.distances[15]);
    }
}

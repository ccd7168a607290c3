//! Paths over a slowness that jumps or changes within a few cells cost what the map says, and refract where it does.

use geosweep::geometry::PathTracer;
use geosweep::surface::EdgeLengths;
use geosweep::surface::builtin::Builtin;
use geosweep::{Options, Sources, Spacing, Surface, distance_map};

use crate::common::Random;

fn plane(rows: usize, cols: usize, slowness: impl Fn(usize, usize) -> f64) -> Surface {
    let flat = Surface::from_heights(rows, cols, vec![0.0; rows * cols], Spacing::square(1.0));
    let slowness = (0..rows * cols).map(|k| slowness(k / cols, k % cols)).collect();
    flat.unwrap().with_slowness(slowness).unwrap()
}

/// Returns the value of the map at a place, the cost of the path from there, and the path's largest distance in rows from
/// the source's row.
fn path(surface: &Surface, from: [f64; 2], to: [f64; 2]) -> [f64; 3] {
    let sources = Sources::point(from[0], from[1]);
    let map = distance_map(surface, &sources, &Options::default()).unwrap();
    let edges = EdgeLengths::new(surface).unwrap();
    let tracer = PathTracer::new(surface, &edges, &sources, &map.distances).unwrap();
    let path = tracer.trace(to).unwrap();
    let beside = path.curve.vertices.iter().map(|at| (at[0] - from[0]).abs());
    [path.distance, path.length, beside.fold(0.0, f64::max)]
}

#[test]
fn paths_through_a_wall_run_straight_and_cost_its_slowness() {
    for wall in [2.0, 4.0, 10.0, 100.0, 1000.0] {
        let surface = plane(41, 61, |_, col| if col == 30 { wall } else { 1.0 });
        let [map, cost, beside] = path(&surface, [20.0, 5.0], [20.0, 55.0]);
        let exact = 49.0 + wall;
        assert!((map - exact).abs() < 1e-3 * exact, "{wall}: {map}");
        assert!((cost - exact).abs() < 2e-3 * exact && beside < 0.1, "{wall}: {cost} {beside}");
    }
    let thick = plane(41, 61, |_, col| if (30..40).contains(&col) { 100.0 } else { 1.0 });
    let [_, cost, _] = path(&thick, [20.0, 5.0], [20.0, 55.0]);
    assert!((cost - 1040.0).abs() < 2.0, "{cost}");
    let small = plane(2, 3, |_, col| if col == 1 { 100.0 } else { 1.0 });
    let [_, cost, _] = path(&small, [1.0, 0.0], [1.0, 2.0]);
    assert!((cost - 101.0).abs() < 0.1, "{cost}");
}

#[test]
fn paths_cost_what_the_map_says() {
    let mut random = Random::new(5);
    let classes: Vec<f64> =
        (0..100).map(|_| [1.0, 2.0, 5.0, 10.0][(4.0 * random.next()) as usize]).collect();
    let blocks = |row: usize, col: usize| classes[row / 9 * 10 + col / 9];
    let ridge = |_: usize, col: usize| 1.0 + 99.0 * (-(col as f64 / 2.0 - 15.0).powi(2)).exp();
    let smooth =
        |row: usize, col: usize| 1.5 + (0.1 * row as f64).sin() * (0.13 * col as f64).cos();
    let peaks = Builtin::Peaks.surface(61, 81).unwrap();
    let slowed: Vec<f64> = (0..61 * 81).map(|k| blocks(k / 81, k % 81)).collect();
    let cases = [
        ("blocks", plane(61, 81, blocks)),
        ("ridge", plane(61, 81, ridge)),
        ("smooth", plane(61, 81, smooth)),
        ("blocks on peaks", peaks.with_slowness(slowed).unwrap()),
    ];
    for (name, surface) in cases {
        let mut errors = Vec::new();
        for _ in 0..30 {
            let mut place = || [(61.0 * random.next()).floor(), (81.0 * random.next()).floor()];
            let [from, to] = [place(), place()];
            if from == to {
                continue;
            }
            let [map, cost, _] = path(&surface, from, to);
            errors.push((cost / map - 1.0).abs());
        }
        errors.sort_by(f64::total_cmp);
        let [median, largest] = [errors[errors.len() / 2], errors[errors.len() - 1]];
        println!("{name}: median {median:.1e}, largest {largest:.1e}");
        assert!(median < 8e-3 && largest < 3e-2, "{name}: {median:e} {largest:e}");
    }
}

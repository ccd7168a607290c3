//! Distances around borders that bend away from the front, where the way follows the border: the inner rims of an annulus
//! and of a cone, with cells of many shapes.

use std::f64::consts::TAU;

use geosweep::glam::DVec3;
use geosweep::surface::Gluing;
use geosweep::{Engine, Options, Sources, Surface, Wavefront, distance_map};

use crate::common::closed::grid;

/// The radius of the inner rim. The outer one has radius 1.5.
const INNER: f64 = 0.5;

/// Returns an annulus in the plane (`turn` 1) or a truncated cone, which unrolls to the part `turn` of an annulus. Rows
/// are circles, columns rays.
fn annulus(rows: usize, cols: usize, turn: f64) -> Surface {
    let annulus = grid(rows, cols, |row, col| {
        let radius = INNER + row as f64 / (rows - 1) as f64;
        let angle = TAU * (col % (cols - 1)) as f64 / (cols - 1) as f64;
        let out = turn * radius;
        DVec3::new(out * angle.cos(), out * angle.sin(), radius * (1.0 - turn * turn).sqrt())
    });
    annulus.with_gluing(Gluing::columns()).unwrap()
}

/// Returns the length of the shortest way outside the inner rim between points at two radii, seen from the middle at this
/// angle: straight, or two tangents and an arc.
fn exact([r1, r2]: [f64; 2], angle: f64) -> f64 {
    let arc = angle - (INNER / r1).min(1.0).acos() - (INNER / r2).min(1.0).acos();
    let tangent = |r: f64| ((r - INNER) * (r + INNER)).max(0.0).sqrt();
    match arc > 0.0 {
        true => tangent(r1) + tangent(r2) + INNER * arc,
        false => (r1 - r2).hypot(2.0 * (r1 * r2).sqrt() * (0.5 * angle).sin()),
    }
}

/// Returns the mean relative errors of all points, and of those behind the rim.
fn errors(surface: &Surface, turn: f64, row: usize, engine: &Engine) -> [f64; 2] {
    let (rows, cols) = (surface.rows(), surface.cols());
    let options = Options::default().with_engine(engine.clone()).with_wavefront(Wavefront::Curved);
    let map = distance_map(surface, &Sources::point(row as f64, 5.0), &options).unwrap();
    let radius = |row: usize| INNER + row as f64 / (rows - 1) as f64;
    let (mut sums, mut counts) = ([0.0; 2], [0.0; 2]);
    for (index, &found) in map.distances.iter().enumerate() {
        let (to, col) = (index / cols, index % cols);
        let around = col.abs_diff(5).min((cols - 1) - col.abs_diff(5));
        let angle = turn * TAU * around as f64 / (cols - 1) as f64;
        let exact = exact([radius(row), radius(to)], angle);
        if exact > 0.0 {
            let error = (f64::from(found) - exact).abs() / exact;
            let straight = [row, to].map(|row| (INNER / radius(row)).acos()).iter().sum::<f64>();
            let is_behind = angle > straight;
            for (k, _) in [true, is_behind].iter().enumerate().filter(|(_, counts)| **counts) {
                sums[k] += error;
                counts[k] += 1.0;
            }
        }
    }
    [0, 1].map(|k| sums[k] / counts[k])
}

#[test]
fn ways_along_a_rim_are_accurate_in_cells_of_any_shape() {
    let cases = [
        // Turn, rows and columns, the source's row, and both errors. Before fans had the width of their cells, errors
        // behind the rim were 4 to 30 times as large. Rays have up to three times the errors of curved fronts there.
        (0.5, [101, 101], 38, [2.2e-6, 1.5e-4]),
        (0.5, [101, 401], 38, [4.6e-6, 2e-4]),
        (0.5, [101, 401], 2, [5e-5, 2e-4]),
        (0.5, [401, 101], 150, [2e-6, 4e-5]),
        (1.0, [101, 201], 38, [6e-5, 2e-4]),
        (1.0, [101, 201], 2, [1.5e-4, 2e-4]),
        (0.8, [201, 301], 10, [5e-5, 2e-4]),
    ];
    for (turn, [rows, cols], row, bounds) in cases {
        let plain = annulus(rows, cols, turn);
        let slowed = annulus(rows, cols, turn).with_slowness(vec![1.0; rows * cols]).unwrap();
        for (name, surface) in [("plain", plain), ("slowness 1", slowed)] {
            let found = errors(&surface, turn, row, &Engine::Cpu);
            println!("{turn} {rows} x {cols} {row} {name}: {:.1e} {:.1e}", found[0], found[1]);
            assert!(found[0] < bounds[0] && found[1] < bounds[1], "{found:?} {bounds:?}");
        }
    }
}

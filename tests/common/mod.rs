//! What the integration tests share.

#![allow(dead_code)] // each test file uses its part

use geosweep::Stop;
use geosweep::cpu;
use geosweep::surface::{EdgeLengths, Seed};
use geosweep::vulkan::{Method, Solver};
use geosweep::{DeviceChoice, Sources, Spacing, Surface, Wavefront};

/// Until f32 converges.
pub const CONVERGED: Stop = Stop { tolerance: 1e-6, iterations: 1000 };

/// The device that `GEOSWEEP_TEST_DEVICE` names, under the validation layers: a call that leaves
/// a validation message fails. No device is a failure too, not a reason to skip.
pub fn vulkan_solver() -> Solver {
    let device = std::env::var("GEOSWEEP_TEST_DEVICE").unwrap_or_default();
    Solver::with_validation(&DeviceChoice::Name(device))
        .expect("the tests need a Vulkan device and the validation layers; ci/setup installs them")
}

/// The CPU engine's map.
pub fn on_cpu(surface: &Surface, seeds: &[Seed], wavefront: Wavefront, stop: Stop) -> Vec<f32> {
    let edges = EdgeLengths::<f32>::new(surface).unwrap();
    cpu::rotated_scan(&edges, seeds, wavefront, stop).distances()
}

/// The Vulkan engine's map.
pub fn on_vulkan(
    solver: &mut Solver,
    surface: &Surface,
    seeds: &[Seed],
    wavefront: Wavefront,
    stop: Stop,
) -> Vec<f32> {
    let mut on_device = solver.upload(surface).unwrap();
    let method = Method { wavefront, schedule: None, stop };
    solver.solve(&mut on_device, seeds, method).unwrap().distances
}

/// Largest difference of two maps over the largest distance; the maps must reach the same points.
pub fn relative_difference(a: &[f32], b: &[f32]) -> f32 {
    assert_eq!(a.len(), b.len());
    let mut difference = 0.0f32;
    let mut largest = 0.0f32;
    for (index, (&a, &b)) in a.iter().zip(b).enumerate() {
        assert!(!a.is_nan() && !b.is_nan(), "NaN at {index}");
        assert_eq!(a.is_finite(), b.is_finite(), "one map reaches {index}: {a} {b}");
        if a.is_finite() {
            difference = difference.max((a - b).abs());
            largest = largest.max(a.abs());
        }
    }
    if largest > 0.0 { difference / largest } else { difference }
}

/// A height field without symmetry, with holes where a cheap hash says so: about one point in
/// `one_hole_in`, none for 0.
pub fn rough(rows: usize, cols: usize, one_hole_in: u64) -> Surface {
    let hash = |index: usize| (index as u64 + 1).wrapping_mul(0x9e37_79b9_7f4a_7c15) >> 40;
    let heights = (0..rows * cols)
        .map(|index| {
            let (row, col) = ((index / cols) as f64, (index % cols) as f64);
            let hole = one_hole_in > 0 && hash(index).is_multiple_of(one_hole_in);
            if hole { f64::NAN } else { 2.0 * (0.31 * row).sin() * (0.23 * col + 0.1 * row).cos() }
        })
        .collect();
    Surface::from_heights(rows, cols, heights, Spacing { dx: 1.0, dy: 1.3 }).unwrap()
}

/// The first point of a surface from the middle on.
pub fn some_point(surface: &Surface) -> (usize, usize) {
    let chart = surface.chart();
    let points = chart.points();
    let index = (0..points)
        .map(|offset| (points / 2 + offset) % points)
        .find(|&index| surface.present()[index])
        .expect("a surface has a point");
    chart.position(index)
}

/// Seeds of a source at a grid point.
pub fn seeds_at(surface: &Surface, (row, col): (usize, usize)) -> Vec<Seed> {
    Sources::point(row as f64, col as f64).seeds(surface).unwrap()
}

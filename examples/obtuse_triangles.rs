//! Measures errors over obtuse triangles, which are split: the tables of `docs/obtuse-triangles.md`.
//!
//!     cargo run --release --example obtuse_triangles
//!
//! The surface is a plane sheared by an angle, x = u + v tan(angle), y = v, whose exact distances are the
//! lengths of straight lines. Beyond 45 degrees, two of the eight triangles around a point are obtuse.

use geosweep::Stop;
use geosweep::cpu;
use geosweep::glam::DVec2;
use geosweep::surface::EdgeLengths;
use geosweep::surface::builtin::Builtin;
use geosweep::{Sources, Wavefront};

const ANGLES: [f64; 9] = [0.0, 15.0, 30.0, 45.0, 50.0, 60.0, 70.0, 75.0, 80.0];

fn main() {
    for points in [257, 513] {
        println!("### The raster scans, {points} x {points} points\n");
        engine_table(points);
    }
}

/// Returns the mean and the largest relative error.
fn errors(map: &[f64], exact: &[f64]) -> (f64, f64) {
    let relative = map.iter().zip(exact).filter(|(_, exact)| **exact > 0.0);
    let relative: Vec<_> = relative.map(|(found, exact)| (found - exact).abs() / exact).collect();
    (relative.iter().sum::<f64>() / relative.len() as f64, relative.into_iter().fold(0.0, f64::max))
}

/// Returns a grid point off every line of symmetry.
fn source(points: usize) -> [usize; 2] {
    [3 * (points - 1) / 10, 2 * (points - 1) / 5]
}

/// Prints errors of the converged map in single precision, for planar and circular fronts from a point,
/// and for planar fronts from exact values in a disc of radius 0.1.
fn engine_table(points: usize) {
    println!(
        "| shear | largest angle | planar: mean | max | planar from a disc: mean | max | circular: mean | max |"
    );
    println!("|---:|---:|---:|---:|---:|---:|---:|---:|");
    for degrees in ANGLES {
        let builtin = Builtin::ShearedPlane { degrees };
        let surface = builtin.surface(points, points).unwrap();
        let edges = EdgeLengths::<f32>::new(&surface).unwrap();
        let from = source(points).map(|x| x as f64);
        let exact = builtin.exact_distances(points, points, from).unwrap();
        let disc = (0..exact.len()).filter(|&index| exact[index] <= 0.1).fold(
            Sources::default(),
            |sources, index| {
                let (row, col) = surface.chart().position(index);
                sources.and_point(row as f64, col as f64, exact[index])
            },
        );
        let point = Sources::point(from[0], from[1]);
        print!("| {degrees} | {:.0} ", largest_angle(degrees));
        for (sources, wavefront) in
            [(&point, Wavefront::Planar), (&disc, Wavefront::Planar), (&point, Wavefront::Circular)]
        {
            let stop = Stop::within(1e-6).or_after(1000);
            let seeds = sources.seeds(&surface).unwrap();
            let map = cpu::rotated_scan(&edges, &seeds, wavefront, stop).distances();
            let map: Vec<_> = map.into_iter().map(f64::from).collect();
            let (mean, max) = errors(&map, &exact);
            print!("| {mean:.1e} | {max:.1e} ");
        }
        println!("|");
    }
    println!();
}

/// Returns the largest of the eight angles around a point of the plane, in degrees.
fn largest_angle(degrees: f64) -> f64 {
    let ring = [[0, 1], [-1, 1], [-1, 0], [-1, -1], [0, -1], [1, -1], [1, 0], [1, 1]];
    let vector = |[row, col]: [i32; 2]| {
        DVec2::new(f64::from(col) + f64::from(row) * degrees.to_radians().tan(), row.into())
    };
    let angle = |k: usize| vector(ring[k]).angle_to(vector(ring[(k + 1) % 8])).abs().to_degrees();
    (0..8).map(angle).fold(0.0, f64::max)
}

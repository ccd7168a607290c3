//! Errors that the tool estimates, and distances that it extrapolates.

use std::path::Path;

use crate::workbench::{Workbench, json, map, stderr};
use geosweep::surface::builtin::Builtin;

#[test]
fn errors_are_estimated_on_request() {
    let bench = Workbench::new();
    let surface = "builtin:sphere:65x65";
    let words = "-s 20,26 --wavefront planar --json -o";
    let plain = json(&bench.distance(surface, &format!("{words} map.npy")));
    for key in ["mean_relative_error", "max_relative_error"] {
        assert!(plain.as_object().unwrap()[key].is_null(), "{plain}");
    }
    assert_eq!(plain["extrapolated"], false);

    let output = bench.distance(surface, &format!("{words} same.npy --error error.tif"));
    let report = json(&output);
    assert!(stderr(&output).contains("estimated relative error: mean"), "{}", stderr(&output));
    assert_eq!(bench.outputs(), ["error.tif", "map.npy", "same.npy"]);
    let (same, errors) = (bench.map("same.npy"), bench.map("error.tif"));
    assert_eq!(same, bench.map("map.npy"));
    let relative: Vec<_> =
        errors.iter().zip(&same).filter(|(_, map)| **map > 0.0).map(|(e, map)| e / map).collect();
    let mean = relative.iter().sum::<f64>() / relative.len() as f64;
    let max = relative.iter().copied().fold(0.0, f64::max);
    approx::assert_relative_eq!(
        report["mean_relative_error"].as_f64().unwrap(),
        mean,
        epsilon = 1e-9
    );
    approx::assert_relative_eq!(
        report["max_relative_error"].as_f64().unwrap(),
        max,
        epsilon = 1e-9
    );

    let output = bench.distance(surface, &format!("{words} best.npy --extrapolate"));
    let report = json(&output);
    assert_eq!(report["extrapolated"], true);
    assert!(report["mean_relative_error"].as_f64().unwrap() > 0.5 * mean);
    let said = stderr(&output);
    assert!(said.contains("before extrapolation") && !said.contains("holes"), "{said}");
    let best = bench.map("best.npy");
    let largest = best.iter().copied().fold(0.0, f64::max);
    approx::assert_relative_eq!(report["max_distance"].as_f64().unwrap(), largest, epsilon = 1e-6);
    let exact = Builtin::Sphere.exact_distances(65, 65, [20.0, 26.0]).unwrap();
    let sum = |map: &[f64]| map.iter().zip(&exact).map(|(a, b)| (a - b).abs()).sum::<f64>();
    assert!(sum(&best) < 0.15 * sum(&same), "{} {}", sum(&best), sum(&same));
}

#[test]
fn estimates_that_cannot_be_made_or_written_are_refused() {
    let bench = Workbench::new();
    let flat = bench.flat(2, 9);
    for (surface, words, parts) in [
        (&*flat, "--wavefront curved -o map.npy --error error.npy", &["2 x 9", "three"][..]),
        (&flat, "--wavefront planar -o map.npy --extrapolate", &["2 x 9", "three"]),
        ("missing.npy", "-o map.npy --error error.txt", &["error.txt", ".npy, .tif or .exr"]),
        ("missing.npy", "-o map.npy --error no/error.npy", &["no/error.npy", "no folder"]),
        ("missing.npy", "-o map.npy --error map.npy", &["map.npy", "another name"]),
        ("missing.npy", "-o map.npy --error ./map.npy", &["map.npy", "another name"]),
        (&flat, &format!("-o map.npy --error {flat}"), &["flat.npy", "also an input"]),
    ] {
        bench.refuses(&bench.distance(surface, &format!("-s 0,0 {words}")), parts);
    }
    assert_eq!(map(Path::new(&flat)), [0.0; 18]);
}

#[test]
fn floor_plans_of_two_rows_have_estimates() {
    let bench = Workbench::new();
    let words = "-s 0,0 --json -o map.npy --error error.npy";
    let report = json(&bench.distance(&bench.flat(2, 9), words));
    let (map, errors) = (bench.map("map.npy"), bench.map("error.npy"));
    for (index, (distance, error)) in map.iter().zip(&errors).enumerate() {
        let exact = f64::hypot((index / 9) as f64, (index % 9) as f64);
        // The estimate is one of rounding here, which is known only up to a factor. So the bound is twice the
        // estimate.
        assert!((distance - exact).abs() <= 2.0 * error, "{index}: {distance} {error}");
        assert!(*error <= 1e-6 * exact, "{index}: {error}");
    }
    assert!(report["max_relative_error"].as_f64().unwrap() <= 1e-6, "{report}");
}

#[test]
fn a_note_says_that_extrapolation_beside_holes_is_worse() {
    let bench = Workbench::new();
    for (wavefront, is_worse) in [("curved", true), ("anchored", false)] {
        let words = format!("-s 1,1 --wavefront {wavefront} --extrapolate -o {wavefront}.npy");
        let output = bench.distance("builtin:maze:65x65", &words);
        assert!(output.status.success(), "{}", stderr(&output));
        assert_eq!(stderr(&output).contains("around holes"), is_worse, "{}", stderr(&output));
    }
}

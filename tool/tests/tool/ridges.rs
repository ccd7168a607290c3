//! Ridges through the tool, compared with a bisector; the farthest point in reports; and errors.

use std::fs;

use crate::workbench::Workbench;
use serde_json::Value;

/// Returns rows and columns of all vertices in a .csv of curves.
fn places(bench: &Workbench, name: &str) -> Vec<[f64; 2]> {
    let mut table = csv::Reader::from_path(bench.output(name)).unwrap();
    let header = ["kind", "length", "least_angle", "largest_angle", "closed", "row", "col"];
    assert_eq!(table.headers().unwrap().iter().skip(1).take(7).collect::<Vec<_>>(), header);
    let places = table.records().map(|row| {
        let row = row.unwrap();
        assert_eq!(&row[1], "ridge");
        [6, 7].map(|column| row[column].parse().unwrap())
    });
    places.collect()
}

/// Between two sources in a column, 25 rows apart, the ridge is the line half-way between them, as far as the angle
/// between the fronts is at least the default or the requested one.
#[test]
fn ridges_are_the_bisector_as_far_as_the_angle_is_wide() {
    let bench = Workbench::new();
    let line = "ridges builtin:plane:65x65 -s 20,32 -s 45,32 --engine cpu --json";
    for (angle, half) in [("", 32.0), ("--least-angle 90", 12.5)] {
        let report = bench.json(format!("{line} {angle} -o r.csv"));
        let [ridge] = &report["ridges"].as_array().unwrap()[..] else { panic!("{report}") };
        let number = |key: &str| ridge[key].as_f64().unwrap();
        let places = places(&bench, "r.csv");
        assert_eq!(ridge["vertices"], places.len());
        assert_eq!(ridge["closed"], false);
        let cols = || places.iter().map(|at| at[1]);
        let (low, high) = (cols().fold(64.0, f64::min), cols().fold(0.0, f64::max));
        // The direction of a ray is computed in a triangle of the grid, and is off by some degrees.
        let slack = if angle.is_empty() { 1e-9 } else { 2.0 };
        assert!((low - 32.0 + half).abs() <= slack && (high - 32.0 - half).abs() <= slack);
        for [row, col] in places {
            assert!((row - 32.5).abs() < 0.05, "{row},{col}");
        }
        approx::assert_relative_eq!(number("length"), (high - low) / 64.0, max_relative = 1e-3);
        let least = 2.0 * f64::atan2(12.5, half).to_degrees();
        assert!((number("least_angle") - least).abs() < 8.0, "{report}");
        assert!(number("largest_angle") > 175.0, "{report}");
    }
}

#[test]
fn ridges_come_in_every_format_and_as_a_picture() {
    let bench = Workbench::new();
    let line = "ridges builtin:peaks:65x65 -s 8,8 --engine cpu --least-angle 25 --json \
                -o r.npy -o r.svg -o r.ply -o r.obj -o r.csv --picture r.png";
    let report = bench.json(line);
    let count = report["ridges"].as_array().unwrap().len();
    assert!(count > 0, "fronts meet behind the hills");
    let files = ["r.csv", "r.npy", "r.obj", "r.ply", "r.png", "r.svg"];
    assert_eq!(bench.outputs(), files);
    let text = |name: &str| fs::read_to_string(bench.output(name)).unwrap();
    assert_eq!(text("r.svg").matches("class=\"ridge\"").count(), count);
    assert_eq!(text("r.obj").lines().filter(|line| line.starts_with("l ")).count(), count);
    assert!(fs::read(bench.output("r.png")).unwrap().starts_with(b"\x89PNG"));

    let none = bench.json("ridges builtin:plane:17x17 -s 8,8 --engine cpu --json -o n.svg");
    assert_eq!(none["ridges"], Value::from(Vec::<Value>::new()));
    assert!(!text("n.svg").contains("<path"));
}

/// The report of every command on a map has the largest distance (a source's eccentricity) and the place of that point.
#[test]
fn reports_have_the_farthest_point() {
    let bench = Workbench::new();
    for line in ["contours builtin:plane:17x17 --count 3", "ridges builtin:plane:17x17"] {
        let report = bench.json(format!("{line} -s 2,3 --engine cpu --json"));
        assert_eq!(report["farthest"], serde_json::json!([16, 16]));
        let exact = 14f64.hypot(13.0) / 16.0;
        let farthest = report["max_distance"].as_f64().unwrap();
        approx::assert_relative_eq!(farthest, exact, max_relative = 1e-5);
    }
}

#[test]
fn invalid_requests_for_ridges_are_refused() {
    let bench = Workbench::new();
    for (words, parts) in [
        ("--least-angle 0 -o r.csv", ["`0`", "180"]),
        ("--least-angle=-5 -o r.csv", ["`-5`", "180"]),
        ("--least-angle nan -o r.csv", ["`nan`", "180"]),
        ("--least-angle 181 -o r.csv", ["`181`", "180"]),
        ("", ["--output", "required"]),
        ("-o r.txt", ["r.txt", ".npy"]),
        ("-o r.csv -o r.geojson", ["r.geojson", "georeferenced"]),
        ("-o r.csv --picture missing/r.png", ["missing", "no folder"]),
    ] {
        let output = bench.run(format!("ridges builtin:plane:17x17 -s 2,2 {words}"));
        bench.refuses(&output, &parts);
    }
}

//! Closed surfaces: the warning where they are cut open, and the options that glue their sides.

use crate::workbench::{Workbench, json, notes, stderr};
use serde_json::Value;

#[test]
fn a_closed_surface_is_not_silently_cut_open() {
    let bench = Workbench::new();
    let tube = bench.tube();
    let output = bench.distance(&tube, "-s 4,0 --json");
    let said = notes(&output);
    let seam = "its first column and its last column coincide";
    assert_eq!(json(&output)["seams"], serde_json::json!([seam]));
    for part in [
        "geosweep: warning: the surface is closed: ",
        seam,
        "No path crosses",
        "--glue auto",
        "--mask",
    ] {
        assert!(said.contains(part), "`{part}` is missing in: {said}");
    }
    assert_eq!(said.lines().count(), 1, "{said}");
    // Other commands read surfaces too.
    let output = bench.run(format!("pairwise {tube} --wavefront planar --json"));
    assert!(stderr(&output).contains(seam), "{}", stderr(&output));
    // As advised: without the second of two equal columns, each point has one distance.
    let mask: Vec<f64> = (0..9 * 33).map(|index| f64::from(index % 33 != 32)).collect();
    let bytes: Vec<u8> = mask.iter().map(|&there| there as u8).collect();
    let mut file = b"\x93NUMPY\x01\x00\x46\x00".to_vec();
    let header = "{'descr': '|u1', 'fortran_order': False, 'shape': (9, 33), }";
    file.extend(format!("{header:<69}\n").bytes().chain(bytes));
    let mask = bench.input("mask.npy", file);
    let output = bench.distance(&tube, &format!("-s 4,0 --mask {mask} --json"));
    assert_eq!((json(&output)["seams"].clone(), notes(&output)), (Value::Array(vec![]), "".into()));
}

/// The warning advises `--glue auto`. Both copies of a point are then one, and the way over the seam is one step.
#[test]
fn glued_sides_have_one_distance() {
    let bench = Workbench::new();
    let tube = bench.tube();
    let output = bench.distance(&tube, "-s 4,0 --glue auto --json -o map.npy");
    assert_eq!((json(&output)["seams"].clone(), notes(&output)), (Value::Array(vec![]), "".into()));
    let map = bench.map("map.npy");
    let step = std::f64::consts::TAU / 32.0;
    assert_eq!(map[4 * 33 + 32], 0.0);
    assert!((map[4 * 33 + 31] - step).abs() < 1e-5 * step, "{}", map[4 * 33 + 31]);
    for (way, part) in [("rows", "apart on average"), ("octahedral", "differ by")] {
        let output = bench.distance(&tube, &format!("-s 4,0 --glue {way} --json"));
        assert!(!output.status.success() && stderr(&output).contains(part), "{}", stderr(&output));
        assert!(stderr(&output).contains(&format!("--glue {way}: ")), "{}", stderr(&output));
    }
    let words = "-s 4,0 --glue columns --engine vulkan --json -o device.npy";
    let output = bench.run(format!("distance {tube} {words}"));
    assert_eq!((json(&output)["engine"].as_str(), notes(&output)), (Some("vulkan"), "".into()));
    let on_device = bench.map("device.npy");
    for (on_device, on_cpu) in on_device.iter().zip(&map) {
        assert!((on_device - on_cpu).abs() <= 1e-6 * on_cpu, "{on_device} {on_cpu}");
    }
}

#[test]
fn directions_and_regions_pass_glued_sides() {
    let bench = Workbench::new();
    let tube = bench.tube();
    let line = "-s 4,2 --glue columns -o map.npy --back-direction way.npy --back-link link.tif \
                --nearest nearest.tif --log-map log.npy --direction-picture ways.png";
    let output = bench.distance(&tube, line);
    assert!(output.status.success(), "{}", stderr(&output));
    let outputs = ["link.tif", "log.npy", "map.npy", "nearest.tif", "way.npy", "ways.png"];
    assert_eq!(bench.outputs(), outputs);
    // The ways back lead east on both sides of the seam, and on both copies of the points on the seam.
    let way = bench.map("way.npy");
    for col in [28, 32, 0, 1] {
        assert!((way[4 * 33 + col] - 90.0).abs() < 1e-3, "{col}: {}", way[4 * 33 + col]);
    }
    let step = std::f64::consts::TAU / 32.0;
    let log = bench.read("log.npy");
    let log: Vec<f64> = log[log.len() - 4 * 2 * 9 * 33..]
        .as_chunks()
        .0
        .iter()
        .map(|bytes| f32::from_le_bytes(*bytes).into())
        .collect();
    let [link, nearest] = ["link.tif", "nearest.tif"].map(|name| bench.map(name));
    // The link to the east is 1, the link to the west is 5.
    for (col, steps, to) in [(28, -6.0, 1.0), (32, -2.0, 1.0), (0, -2.0, 1.0), (5, 3.0, 5.0)] {
        let point = 4 * 33 + col;
        assert_eq!([link[point], nearest[point]], [to, 0.0], "{col}");
        let [east, up] = [0, 1].map(|k| log[2 * point + k]);
        assert!((east - steps * step).abs() < 1e-5 && up.abs() < 1e-5, "{col}: {east} {up}");
    }
    let line = format!("voronoi {tube} -s 4,2 -s 4,18 --glue columns --json");
    let report = bench.json(&line);
    assert_eq!(report["neighbours"], serde_json::json!([[0, 1]]));
    let area = |region: usize| report["regions"][region]["area"].as_f64().unwrap();
    assert!((area(0) - area(1)).abs() < 1e-3 * area(0), "{} {}", area(0), area(1));
}

/// Fronts from one source meet on the line opposite the source.
#[test]
fn ridges_offsets_errors_and_matrices_pass_glued_sides() {
    let bench = Workbench::new();
    let tube = bench.tube();
    let line = format!("ridges {tube} -s 4,16 --glue columns -o ridges.npy --json");
    let report = bench.json(&line);
    let [ridge] = &report["ridges"].as_array().unwrap()[..] else { panic!("{report}") };
    assert!(ridge["least_angle"].as_f64().unwrap() > 120.0, "{report}");
    let [ridge] = &bench.curves("ridges.npy")[..] else { panic!("one ridge") };
    assert!(ridge.iter().all(|at| at[1].min(32.0 - at[1]) < 0.5), "{ridge:?}");
    // A circle around the tube has one offset curve on each side.
    let around = bench.input("around.csv", "row,col\n4,0\n4,16\n4,32\n");
    let words = format!("--source-curve {around} --glue columns --distances 0.5 --side left");
    let report = bench.json(format!("offset {tube} {words} -o left.npy --json"));
    assert_eq!([&report["levels"][0]["curves"], &report["levels"][0]["closed"]], [1, 1]);
    let length = report["levels"][0]["length"].as_f64().unwrap();
    assert!((length - std::f64::consts::TAU).abs() < 0.05, "{report}");
    let line = "-s 4,2 --glue columns -o map.npy --error error.npy --json";
    let report = json(&bench.distance(&tube, line));
    assert!(report["mean_relative_error"].as_f64().unwrap() < 1e-3, "{report}");
    let [distances, errors] = ["map.npy", "error.npy"].map(|name| bench.map(name));
    assert!(errors.iter().all(|error| error.is_finite()));
    let words =
        format!("pairwise {tube} --glue columns --sources 134..135 --engine vulkan -o row.npy");
    let output = bench.run(&words);
    assert!(output.status.success(), "{}", stderr(&output));
    for (found, distance) in bench.map("row.npy").iter().zip(&distances) {
        assert!((found - distance).abs() < 1e-5, "{found} {distance}");
    }
}

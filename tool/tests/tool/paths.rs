//! Paths, and starts without a path.

use geosweep::surface::builtin::Builtin;

use crate::workbench::{Workbench, json, stderr};

#[test]
fn paths_run_from_their_starts_to_the_source() {
    let bench = Workbench::new();
    let starts = bench.input("starts.csv", "row,col\n3.5,50\n60,60.25\n");
    let line = format!(
        "path builtin:sphere:65x65 -s 30,20 --from 10,40 --from 30,20 --from-file {starts} \
         --engine cpu --json -o p.npy -o p.csv"
    );
    let report = bench.json(&line);
    let paths = bench.curves("p.npy");
    let starts = [[10.0, 40.0], [30.0, 20.0], [3.5, 50.0], [60.0, 60.25]];
    assert_eq!(paths.len(), starts.len());
    let surface = Builtin::Sphere.surface(65, 65).unwrap();
    let source = surface.position(30, 20).unwrap();
    for ((path, start), row) in paths.iter().zip(starts).zip(report["paths"].as_array().unwrap()) {
        assert_eq!(path[0][..2], start);
        assert_eq!(path.last().unwrap()[..2], [30.0, 20.0]);
        assert_eq!(path.last().unwrap()[2..], source.to_array());
        assert_eq!(row["vertices"], path.len());
        assert_eq!(row["source"], 0);
        let exact = Builtin::Sphere.exact_distance(65, 65, start, [30.0, 20.0]).unwrap();
        let (length, distance) =
            (row["length"].as_f64().unwrap(), row["distance"].as_f64().unwrap());
        // Paths consist of straight steps as long as cells, which makes errors of a few 1e-4 at 65 points.
        assert!((length - exact).abs() <= 2e-3 * exact, "{length} {exact}");
        assert!((distance - exact).abs() <= 2e-3 * exact, "{distance} {exact}");
    }
    assert_eq!(paths[1].len(), 1, "a start at the source");
    let single = "path builtin:plane:17x17 -s 3,3 --from 12,9 --engine cpu -o one.npy";
    bench.done(single);
    let one = bench.curves("one.npy");
    assert_eq!(one.len(), 1, "one path is one array without NaN");
    for [row, col, ..] in &one[0] {
        let across = (row - 3.0) * 6.0 - (col - 3.0) * 9.0;
        assert!(across.abs() / 6f64.hypot(9.0) < 0.02, "a straight line: {row},{col}");
    }
}

#[test]
fn impossible_starts_are_refused() {
    let bench = Workbench::new();
    let mut heights = vec![0.0; 9 * 9];
    (0..9).for_each(|row| heights[row * 9 + 5] = f64::NAN);
    let cut = bench.array("cut.npy", &[9, 9], &heights);
    for (from, parts) in [
        ("2,7", ["2,7", "cannot be reached"]),
        ("9.5,1", ["9.5,1", "outside the grid"]),
        ("-1,1", ["-1,1", "outside the grid"]),
        ("4,5", ["4,5", "hole"]),
    ] {
        let line = format!(
            "path {cut} --spacing 1 -s 2,2 --from 1,1 --from {from} -o p.npy -o p.svg \
             --picture p.png --engine cpu"
        );
        let output = bench.run(&line);
        bench.refuses(&output, &parts);
    }
    let line = format!("path {cut} --spacing 1 -s 2,2 -o p.npy");
    bench.refuse(&line, &["--from"]);
    let line = format!("path {cut} --spacing 1 -s 2,2 --from 1 -o p.npy");
    bench.refuse(&line, &["R,C"]);
}

/// With a slowness, a path's length is a travel time, and its length on the surface is reported too.
#[test]
fn paths_tell_lengths_and_travel_times() {
    let bench = Workbench::new();
    let flat = bench.flat(21, 31);
    for slow in [0.5, 3.0] {
        let slowness = bench.array("slowness.npy", &[21, 31], &[slow; 21 * 31]);
        let line = format!(
            "path {flat} --spacing 2 --slowness {slowness} -s 3,4,1.5 --from 15,20 --from 3,24 --engine cpu \
             --json -o p.csv"
        );
        let output = bench.done(&line);
        let report = json(&output);
        let table = bench.text("p.csv");
        let mut rows = table.lines().skip(1).map(|line| line.split(',').collect::<Vec<_>>());
        let exact = [20.0 * 2.0, 2.0 * 12f64.hypot(16.0)];
        for (index, exact) in [(0, exact[1]), (1, exact[0])] {
            let path = &report["paths"][index];
            let number = |name: &str| path[name].as_f64().unwrap();
            let near = |found: f64, expected: f64| (found - expected).abs() < 2e-3 * expected;
            assert!(near(number("surface_length"), exact), "{path}");
            assert!(near(number("length"), slow * exact), "{path}");
            assert_eq!(number("time"), number("length"));
            assert!(near(number("distance"), 1.5 + slow * exact), "{path}");
            let row = rows.find(|row| row[0] == index.to_string()).unwrap();
            let told = |column: usize| row[column].parse::<f64>().unwrap();
            let names = ["distance", "length", "surface_length"];
            assert_eq!([told(2), told(3), told(4)], names.map(number), "{row:?}");
        }
        let said = stderr(&output);
        assert!(
            said.contains("2 paths of length ") && said.contains(" and travel time "),
            "{said}"
        );
    }
    let report = bench.json(format!("path {flat} --spacing 1 -s 3,4 --from 3,9 --json"));
    let path = &report["paths"][0];
    assert!(path["time"].is_null() && path["surface_length"] == path["length"], "{path}");
}

/// In double precision, the map from which paths and regions are computed has no rounding of single
/// precision.
#[test]
fn maps_of_paths_and_regions_come_in_double_precision() {
    let bench = Workbench::new();
    for words in
        ["path builtin:plane:30x40 -s 3,4 --from 29,39", "voronoi builtin:plane:30x40 -s 3,4"]
    {
        let report = |precision: &str| {
            bench.json(format!("{words} --engine cpu --json --precision {precision}"))
        };
        let (single, double) = (report("single"), report("double"));
        assert_eq!(
            (&single["precision"], &double["precision"]),
            (&"single".into(), &"double".into())
        );
        let exact = Builtin::Plane.exact_distance(30, 40, [3.0, 4.0], [29.0, 39.0]).unwrap();
        let error = |value: &serde_json::Value| (value.as_f64().unwrap() - exact).abs();
        assert!(error(&double["max_distance"]) < 1e-13, "{double}");
        if words.starts_with("path") {
            assert!(error(&double["paths"][0]["distance"]) < 1e-13, "{double}");
            assert!(error(&single["paths"][0]["distance"]) > 1e-13, "{single}");
        }
        let line = format!("{words} --precision double --engine vulkan --json");
        assert!(!bench.run(&line).status.success(), "shaders compute in single precision");
    }
}

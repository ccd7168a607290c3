//! Farthest points, and curves and samples as inputs.

use geosweep::io::read_map;
use serde_json::Value;

use crate::workbench::{Workbench, json, stderr};

#[test]
fn samples_are_far_from_one_another() {
    let bench = Workbench::new();
    let flat = bench.flat(21, 21);
    let line = format!(
        "sample {flat} --spacing 1 -k 5 -o s.npy -o s.csv -o s.ply --labels l.npy \
         --picture s.png --json"
    );
    let report = bench.json(&line);
    assert_eq!(bench.outputs(), ["l.npy", "s.csv", "s.npy", "s.ply", "s.png"]);
    let samples = &bench.curves("s.npy")[0];
    // The middle, then the corners in some order.
    assert_eq!(samples[0][..2], [10.0, 10.0]);
    let mut corners: Vec<_> = samples[1..].iter().map(|s| [s[0] as i32, s[1] as i32]).collect();
    corners.sort_unstable();
    assert_eq!(corners, [[0, 0], [0, 20], [20, 0], [20, 20]]);
    assert!(report["samples"][0]["radius"].is_null());
    approx::assert_relative_eq!(
        report["samples"][1]["radius"].as_f64().unwrap(),
        200f64.sqrt(),
        max_relative = 1e-5
    );
    // The radius is the distance from the middle of a side to the middle of the grid or to a corner.
    approx::assert_relative_eq!(report["radius"].as_f64().unwrap(), 10.0, max_relative = 1e-5);
    let labels = read_map(&bench.output("l.npy")).unwrap();
    assert_eq!(labels.values[10 * 21 + 10], 0.0);
    assert!(labels.values.iter().all(|label| (0.0..5.0).contains(label)));

    let line = "sample builtin:plane:2x2 -k 9 --first 0,0 -o few.npy --json";
    let output = bench.done(line);
    assert!(stderr(&output).contains("only 4 samples, not 9"), "{}", stderr(&output));
    assert_eq!(json(&output)["samples"].as_array().unwrap().len(), 4);

    let bench = Workbench::new();
    for (rest, part) in [
        ("-k 0", "give 1 or more"),
        ("-k 3 --first 30,2", "--first 30,2 lies outside the grid"),
        ("-k 3 --first 3", "R,C"),
        ("", "--count"),
    ] {
        let line = format!("sample {flat} --spacing 1 {rest} -o s.npy");
        bench.refuse(&line, &[part]);
    }
}

/// Commands can read what other commands write.
#[test]
fn samples_and_curves_are_inputs_too() {
    let bench = Workbench::new();
    let plane = "builtin:plane:17x19 --engine cpu";
    bench.done("sample builtin:plane:17x19 -k 5 -o s.csv -o s.npy");
    let samples = bench.curves("s.npy").concat();
    assert_eq!(samples.len(), 5);

    // Samples of a table are points.
    let words: Vec<_> = samples.iter().map(|v| format!("-s {},{}", v[0], v[1])).collect();
    bench.done(format!("distance {plane} -o points.npy {}", words.join(" ")));
    bench.done(format!("distance {plane} -o table.npy --source-curve s.csv"));
    let points = bench.map("points.npy");
    assert_eq!(points, bench.map("table.npy"));
    for format in ["csv", "npy"] {
        bench.done(format!("distance {plane} -o {format}.npy --source-points s.{format}"));
        assert_eq!(points, bench.map(&format!("{format}.npy")), "{format}");
    }

    let ends = |file: &str| {
        let line = format!("path {plane} -s 8,9 -o p.npy --json --from-file {file}");
        let report = bench.json(&line);
        report["paths"].as_array().unwrap().iter().map(|path| path["from"].clone()).collect()
    };
    let [from_csv, from_npy]: [Vec<Value>; 2] = ["s.csv", "s.npy"].map(ends);
    assert_eq!((from_csv.len(), &from_csv), (5, &from_npy));
    for format in ["csv", "npy"] {
        let line = format!("pairwise builtin:plane:17x19 --sources s.{format} -o {format}-d.npy");
        bench.done(&line);
    }
    assert_eq!(bench.map("csv-d.npy"), bench.map("npy-d.npy"));

    // Curves stay apart: no point between two circles is a source.
    bench.done(format!("contours {plane} -s 4,4 -s 12,14 --levels 0.1 -o c.csv -o c.npy"));
    for format in ["csv", "npy"] {
        bench.done(format!("distance {plane} --source-curve c.{format} -o {format}.npy"));
    }
    let distances = bench.map("csv.npy");
    assert_eq!(distances, bench.map("npy.npy"));
    assert!(distances[8 * 19 + 9] > 0.2, "{}", distances[8 * 19 + 9]);
    let bench = Workbench::new();
    let named = bench.input("xy.csv", "x,y\n1,2\n");
    let refused = bench.run(format!("distance {plane} --source-curve {named} -o d.npy"));
    bench.refuses(&refused, &["xy.csv", "map coordinates", "georeferenced"]);
    let named = bench.input("ab.csv", "a,b\n1,2\n");
    let refused = bench.run(format!("distance {plane} --source-curve {named} -o d.npy"));
    bench.refuses(&refused, &["ab.csv", "header `a,b`", "row and col"]);
}

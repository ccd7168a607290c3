//! `geosweep canonical` and the figure of forms: files, reports and refusals.

use std::fs;

use crate::workbench::{Workbench, json, stderr};
use geosweep::geometry::canonical::align;
use geosweep::io::SurfaceFile;

#[test]
fn the_form_is_a_surface_of_its_own() {
    let bench = Workbench::new();
    let line = "canonical builtin:sphere:12x15 -o form.npy --picture form.png --json";
    let report = bench.json(line);
    assert_eq!(bench.outputs(), ["form.npy", "form.png"]);
    assert_eq!((&report["rows"], &report["cols"]), (&12.into(), &15.into()));
    assert_eq!((&report["placed"], &report["left_out"]), (&180.into(), &0.into()));
    assert_eq!(report["converged"], true);
    assert!(report["stress_1"].as_f64().unwrap() < 0.03, "{report}");
    assert!(report["raw_stress"].as_f64() < report["start_stress"].as_f64(), "{report}");
    let form = SurfaceFile::read(&bench.output("form.npy")).unwrap().into_surface(None).unwrap();
    assert_eq!((form.rows(), form.cols(), form.points()), (12, 15, 180));
}

#[test]
fn holes_come_back_as_nan() {
    let bench = Workbench::new();
    // A hole, and a corner that is cut off by a diagonal of holes.
    let mut heights = vec![0.0; 9 * 8];
    for hole in [4 * 8 + 4, 2, 8 + 1, 2 * 8, 8 + 2, 2 * 8 + 1] {
        heights[hole] = f64::NAN;
    }
    let surface = bench.array("holes.npy", &[9, 8], &heights);
    let output =
        bench.run_args(["canonical", &surface, "--spacing", "1", "-o", "form.npy", "--json"]);
    assert!(stderr(&output).contains("3 points are left out"), "{}", stderr(&output));
    assert_eq!(json(&output)["placed"], 9 * 8 - 6 - 3);
    let form = SurfaceFile::read(&bench.output("form.npy")).unwrap().into_surface(None).unwrap();
    for (index, present) in form.present().iter().enumerate() {
        assert_eq!(*present, !heights[index].is_nan() && ![0, 1, 8].contains(&index), "{index}");
    }
}

#[test]
fn large_grids_are_thinned_and_meshes_written() {
    let bench = Workbench::new();
    let line = "canonical builtin:plane:41x21 --points 100 --dimensions 2 -o form.ply --json";
    let output = bench.run(line);
    assert!(stderr(&output).contains("14 x 7 of the 41 x 21 points"), "{}", stderr(&output));
    assert!(json(&output)["stress_1"].as_f64().unwrap() < 1e-4);
    let bytes = fs::read(bench.output("form.ply")).unwrap();
    let header = String::from_utf8_lossy(&bytes[..200]);
    assert!(header.contains("element vertex 98\n") && header.contains("element face 156\n"));
}

#[test]
fn a_matrix_of_distances_is_taken() {
    let bench = Workbench::new();
    let places = [[0.0, 0.0], [3.0, 0.0], [3.0, 4.0], [0.0, 4.0], [1.0, 1.0]];
    let distance = |a: [f64; 2], b: [f64; 2]| f64::hypot(a[0] - b[0], a[1] - b[1]);
    // The third point is a hole.
    let numbers = [Some(0), Some(1), None, Some(2), Some(3), Some(4)];
    let matrix: Vec<f64> = numbers
        .iter()
        .flat_map(|a| numbers.map(|b| a.zip(b)))
        .map(|pair| pair.map_or(f64::INFINITY, |(a, b)| distance(places[a], places[b])))
        .collect();
    let above = (0..6).flat_map(|row| (row + 1..6).map(move |col| row * 6 + col));
    let above: Vec<f64> = above.map(|index| matrix[index]).collect();
    let matrix = bench.array("distances.npy", &[6, 6], &matrix);
    let above = bench.array("above.npy", &[15], &above);
    // With the option, and without it.
    for (matrix, said) in [(&matrix, true), (&matrix, false), (&above, false)] {
        let args = ["canonical", matrix, "--dimensions", "2", "-o", "form.npy"].into_iter();
        let output = bench.run_args(args.chain(said.then_some("--matrix")));
        assert!(output.status.success(), "{}", stderr(&output));
        assert_eq!(stderr(&output).contains("taken as a matrix"), !said, "{}", stderr(&output));
        let form = geosweep::io::read_map(&bench.output("form.npy")).unwrap();
        assert_eq!((form.rows, form.cols), (6, 2));
        assert!(form.values[4..6].iter().all(|coordinate| coordinate.is_nan()));
        let found: Vec<f64> = form.values.into_iter().filter(|c| !c.is_nan()).collect();
        assert!(align(&found, places.as_flattened(), 2).deviation < 1e-5);
    }
    let args = ["canonical", &matrix, "--dimensions", "2", "-o", "f.npy", "--picture", "f.png"];
    assert!(bench.run_args(args).status.success() && bench.output("f.png").exists());
    // A square array of heights is not taken as a matrix.
    let heights: Vec<f64> = (0..36).map(|i| f64::from(i % 7) * 0.1 + 1.0).collect();
    let heights = bench.array("heights.npy", &[6, 6], &heights);
    let output =
        bench.run_args(["canonical", &heights, "--spacing", "1", "-o", "form.npy", "--json"]);
    assert_eq!(json(&output)["rows"], 6);
}

#[test]
fn bad_input_is_refused_and_nothing_written() {
    let bench = Workbench::new();
    let refused = |name: &str, shape: &[usize], values: &[f64], parts: &[&str]| {
        let matrix = bench.array(name, shape, values);
        let args = ["canonical", &matrix, "--matrix", "-o", "form.npy", "--dimensions", "1"];
        bench.refuses(&bench.run_args(args), parts);
    };
    refused("wide.npy", &[2, 3], &[0.0; 6], &["square", "(2, 3)"]);
    refused("nan.npy", &[2, 2], &[0.0, f64::NAN, 1.0, 0.0], &["point 0 to point 1 is NaN"]);
    refused("negative.npy", &[2, 2], &[0.0, 1.0, -1.0, 0.0], &["is negative: -1"]);
    refused("asymmetric.npy", &[2, 2], &[0.0, 1.0, 2.0, 0.0], &["but 2 in the other direction"]);
    refused("diagonal.npy", &[2, 2], &[1.0; 4], &["to itself is 1"]);
    refused("zero.npy", &[2, 2], &[0.0; 4], &["all distances are zero"]);
    let run = |line: &str| bench.run(line);
    // Noise of a hundred grid steps.
    let heights: Vec<_> = (0..21 * 21).map(|i| (i * i * 7919 % 1009) as f64 / 10.0).collect();
    let noise = bench.array("noise.npy", &[21, 21], &heights);
    let rough = format!("canonical {noise} --spacing 1 -o form.npy");
    bench.refuses(&run(&rough), &["too rough", "finer grid"]);
    bench.refuses(&run("canonical builtin:plane:1x3 -o form.npy"), &["3 points", "at least 4"]);
    bench.refuses(&run("canonical builtin:plane:3x3 -o form.obj"), &[".npy or .ply"]);
    let ply = "canonical builtin:plane:3x3 -o form.ply --dimensions 4";
    bench.refuses(&run(ply), &["2 or 3 dimensions"]);
    bench.refuses(&run("canonical builtin:plane:3x3 -o f.npy --tolerance -1"), &["0 to 1"]);
    bench
        .refuses(&run("canonical builtin:plane:3x3 -o f.npy --wavefront round"), &["no wavefront"]);
    bench.refuses(&run("canonical builtin:plane:3x3 --matrix -o f.npy"), &["built-in"]);
}

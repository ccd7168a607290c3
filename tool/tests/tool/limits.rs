//! Maps within a radius and as far as targets, and sparse pairs, through the tool.

use std::fs;

use crate::workbench::{Workbench, json, notes, stderr};

/// Returns the distances of a map and the number of reached points.
fn reached(bench: &Workbench, file: &str) -> (Vec<f64>, usize) {
    let map = bench.map(file);
    let count = map.iter().filter(|distance| distance.is_finite()).count();
    (map, count)
}

#[test]
fn a_radius_cuts_the_map_and_what_is_made_of_it() {
    let bench = Workbench::new();
    let flat = bench.flat(41, 41);
    let line = format!("distance {flat} --spacing 1 -s 20,20 --engine cpu");
    bench.done(format!("{line} -o whole.npy --back-link whole-links.npy"));
    let outputs = "-o near.npy --back-link links.npy --log-map log.npy --picture near.png \
                   --error error.npy --nearest nearest.npy --json";
    let output = bench.run(format!("{line} --radius 8 {outputs}"));
    let report = json(&output);
    assert!(stderr(&output).contains("beyond the part that was asked for"), "{}", stderr(&output));
    let (whole, _) = reached(&bench, "whole.npy");
    let (near, count) = reached(&bench, "near.npy");
    assert_eq!(report["reached"], count);
    assert_eq!(report["max_distance"], 8.0);
    for (near, whole) in near.iter().zip(&whole) {
        assert_eq!(*near, if *whole <= 8.0 { *whole } else { f64::INFINITY });
    }
    let links = ["whole-links.npy", "links.npy"].map(|file| bench.map(file));
    for ((of_whole, of_near), distance) in links[0].iter().zip(&links[1]).zip(&near) {
        assert_eq!(of_near, if distance.is_finite() { of_whole } else { &-1.0 });
    }
}

#[test]
fn a_map_ends_at_its_targets() {
    let bench = Workbench::new();
    let flat = bench.flat(41, 41);
    let file = bench.input("targets.csv", "row,col\n20,32\n");
    let line = format!("distance {flat} --spacing 1 -s 20,20 -o map.npy");
    for (options, largest) in [
        ("--target 20,25", 5.0),
        ("--target 20,25 --target 10,20", 10.0),
        ("--target 20,25 --target 10,20 --target-mode any", 5.0),
        (&format!("--targets {file}"), 12.0),
        ("--target 20,25 --engine fast-marching", 5.0),
        ("--target 20,25 --radius 3", 3.0),
    ] {
        let report = bench.json(format!("{line} --json {options}"));
        assert_eq!(report["max_distance"], largest, "{options}");
    }
    let output = bench.run(format!("{line} --target 20,25 --radius 3"));
    let said = notes(&output);
    assert!(said.contains("the target 20,25 is not reached within the radius"), "{said}");
}

#[test]
fn limits_that_cannot_be_are_refused() {
    let bench = Workbench::new();
    let flat = bench.flat(21, 21);
    let mask: String =
        (0..21).map(|row| format!("{}\n", if row == 5 { "0 " } else { "1 " }.repeat(21))).collect();
    let header = "ncols 21\nnrows 21\nxllcorner 0\nyllcorner 0\ncellsize 1\n";
    let mask = bench.input("mask.asc", format!("{header}{mask}"));
    for (options, parts) in [
        ("--radius 0", ["radius", "positive"]),
        ("--radius -3", ["radius", "positive"]),
        ("--radius NaN", ["radius", "positive"]),
        ("--target 30,2", ["(30, 2)", "outside the grid"]),
        ("--target 5,2", ["(5, 2)", "in a hole"]),
        ("--target 5.5,2", ["--target", "whole numbers"]),
    ] {
        let line = format!("distance {flat} --mask {mask} -s 2,2 --engine cpu -o d.npy {options}");
        bench.refuse(&line, &parts);
    }
    let none = bench.run(format!("distance {flat} --mask {mask} -s 2,2 -o d.npy --target 9,9"));
    let said = notes(&none);
    assert!(said.contains("9,9 is not reached by any path"), "{said}");
}

#[test]
fn sparse_pairs_are_those_of_the_whole_rows() {
    let bench = Workbench::new();
    let surface = "builtin:sphere:12x15";
    bench.done(format!("pairwise {surface} -o whole.npy --radius 0.4"));
    let line = format!("pairwise {surface} --radius 0.4 --format csr --json");
    let report = bench.json(format!("{line} -o near.npz"));
    let (whole, stored) = reached(&bench, "whole.npy");
    assert_eq!(whole.len(), 180 * 180);
    // Whole rows are computed in other lanes, which round differently. So a pair at the radius may be stored in one of
    // the files only.
    let found = report["stored"].as_u64().unwrap() as usize;
    assert!(found.abs_diff(stored) <= 4 && found > 2 * 180, "{found} of {stored}");
    assert_eq!((&report["matrix_rows"], &report["matrix_cols"]), (&180.into(), &180.into()));
    let archive = fs::read(bench.output("near.npz")).unwrap();
    for name in ["indices.npy", "indptr.npy", "format.npy", "shape.npy", "data.npy"] {
        let name = name.as_bytes();
        assert!(archive.windows(name.len()).any(|window| window == name));
    }
    // Refused commands write nothing, which a new folder shows.
    let bench = Workbench::new();
    bench.refuse(format!("pairwise {surface} --format csr -o d.npz"), &["--radius"]);
    bench.refuse(format!("{line} -o d.npy"), &[".npz"]);
    bench.refuse(format!("{line} -o d.npz --upper"), &["--upper"]);
}

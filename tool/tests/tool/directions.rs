//! Directions, links, nearest sources, log maps and signed distances through the tool.

use std::fs::File;

use geosweep::io::{SurfaceFile, read_map};
use tiff::decoder::{Decoder, DecodingResult};

use crate::workbench::Workbench;

#[test]
fn directions_are_written_where_the_surface_lies() {
    let bench = Workbench::new();
    let mut text = String::from("ncols 9\nnrows 7\nxllcorner 500\nyllcorner 900\ncellsize 10\n");
    (0..7).for_each(|_| text += "5 5 5 5 5 5 5 5 5\n");
    let dem = bench.input("dem.asc", text);
    let place = SurfaceFile::read(dem.as_ref()).unwrap().georeference().unwrap();
    bench.done(format!(
        "distance {dem} -s 3,4 -s 6,8 --engine cpu --back-direction b.tif --back-link l.tif \
             --nearest n.tif --source-direction s.tif --log-map u.npy --direction-picture p.png"
    ));
    assert_eq!(bench.outputs(), ["b.tif", "l.tif", "n.tif", "p.png", "s.tif", "u.npy"]);
    for file in ["b.tif", "l.tif", "n.tif", "s.tif"] {
        let written = SurfaceFile::read(&bench.output(file)).unwrap();
        assert_eq!(written.georeference().unwrap(), place, "{file}");
    }
    let at = |file: &str, row: usize, col: usize| bench.map(file)[row * 9 + col];
    let west = [at("b.tif", 3, 1), at("l.tif", 3, 1), at("n.tif", 3, 1), at("s.tif", 3, 1)];
    for (found, expected) in west.into_iter().zip([90.0, 1.0, 0.0, 270.0]) {
        approx::assert_abs_diff_eq!(found, expected, epsilon = 1e-3);
    }
    assert_eq!([at("b.tif", 6, 8), at("l.tif", 6, 8), at("n.tif", 6, 8)], [0.0, 0.0, 1.0]);

    let vectors = "--direction-format vector --back-direction v.tif --log-map u.tif";
    bench.done(format!("distance {dem} -s 3,4 --engine cpu {vectors}"));
    for (file, at, expected) in [("v.tif", (3, 1), [0.0, 1.0]), ("u.tif", (5, 7), [30.0, 20.0])] {
        let (row, col) = at;
        let mut decoder = Decoder::new(File::open(bench.output(file)).unwrap()).unwrap();
        let DecodingResult::F32(bands) = decoder.read_image().unwrap() else { panic!("{file}") };
        let found = [bands[2 * (9 * row + col)], bands[2 * (9 * row + col) + 1]];
        approx::assert_abs_diff_eq!(found.as_slice(), expected.as_slice(), epsilon = 1e-3);
    }

    let grass = "--direction-format grass --back-direction g.npy";
    bench.done(format!("distance {dem} -s 3,4 --engine cpu {grass}"));
    approx::assert_abs_diff_eq!(at("g.npy", 3, 1), 360.0, epsilon = 1e-3);
}

#[test]
fn signed_distances_are_negative_inside() {
    let bench = Workbench::new();
    let flat = bench.flat(21, 21);
    let curve = bench.input("square.csv", "5,5\n15,5\n15,15\n5,15\n5,5\n");
    let line = format!("distance {flat} --spacing 1 --source-curve {curve} --engine cpu --signed");
    bench.done(format!("{line} -o d.npy"));
    let signed = read_map(&bench.output("d.npy")).unwrap().values;
    approx::assert_abs_diff_eq!(signed[10 * 21 + 8], -3.0, epsilon = 1e-4);
    approx::assert_abs_diff_eq!(signed[10 * 21 + 1], 4.0, epsilon = 1e-4);
}

#[test]
fn invalid_requests_for_directions_are_refused() {
    let bench = Workbench::new();
    let flat = bench.flat(21, 21);
    for (words, parts) in [
        ("--back-direction b.png", ["b.png", ".npy or .tif"]),
        ("--direction-format vector --back-direction b.csv", ["b.csv", ".npy or .tif"]),
        ("--log-map l.png", ["l.png", ".npy or .tif"]),
        ("--back-link b.npy --nearest b.npy", ["b.npy", "two outputs"]),
        ("--signed -o d.npy", ["source 0 is a point", "closed curves"]),
        ("--signed", ["--output", "required"]),
    ] {
        let output = bench.run(format!("distance {flat} -s 2,2 --engine cpu {words}"));
        bench.refuses(&output, &parts);
    }
}

#[test]
fn values_between_grid_points_are_printed() {
    let bench = Workbench::new();
    let flat = bench.flat(21, 21);
    let line = format!("value {flat} --spacing 1 -s 2,2 --engine cpu --at 5,6 --at 5.5,2");
    let output = bench.done(&line);
    let text = String::from_utf8(output.stdout).unwrap();
    let value = |line: &str| line.rsplit(',').next().unwrap().parse::<f64>().unwrap();
    let values: Vec<f64> = text.lines().map(value).collect();
    approx::assert_abs_diff_eq!(values[0], 5.0, epsilon = 1e-5);
    approx::assert_abs_diff_eq!(values[1], 3.5, epsilon = 1e-4);
    let report = bench.json(format!("{line} --json"));
    let told = [0, 1].map(|k| report["values"][k]["distance"].as_f64().unwrap() as f32);
    assert_eq!(told, [values[0] as f32, values[1] as f32]);
    assert_eq!(report["values"][1]["row"], 5.5);
    let outside = bench.run(format!("value {flat} --spacing 1 -s 2,2 --engine cpu --at 30,2"));
    bench.refuses(&outside, &["30,2", "outside the grid"]);
}

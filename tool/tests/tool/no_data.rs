//! Values that mean "no data", in every format.

use geosweep::io::write_npy;

use crate::workbench::{Workbench, notes};

fn holes(bench: &Workbench, line: &str) -> Vec<usize> {
    bench.done(format!("distance {line} --spacing 1 -s 0,0 --engine cpu -o d.npy"));
    let found = bench.map("d.npy").into_iter().enumerate();
    found.filter(|(_, distance)| distance.is_infinite()).map(|(index, _)| index).collect()
}

#[test]
fn ascii_grids_have_the_holes_that_gdal_sees() {
    for (value, no_data, is_hole) in [
        ("-3.4028234663852886e+38", "-3.4e38", true),
        ("-3.402823e+38", "-3.4028235e+38", true),
        ("-9999", "-9999.0", true),
        ("-9999.0", "-9999", true),
        ("-32768", "-32767", false),
    ] {
        let bench = Workbench::new();
        let header = "ncols 3\nnrows 3\nxllcorner 1000\nyllcorner 2000\ncellsize 1";
        let text = format!("{header}\nNODATA_value {no_data}\n1 1 1\n1 {value} 1\n1 1 1\n");
        let grid = bench.input("a.asc", text);
        let found = holes(&bench, &grid);
        assert_eq!(found, if is_hole { vec![4] } else { vec![] }, "{value} {no_data}");
    }
}

#[test]
fn a_value_for_holes_is_given_to_formats_that_cannot_say_it() {
    let bench = Workbench::new();
    let mut heights = [5.0; 12];
    (heights[3], heights[10]) = (-9999.0, -9999.0);
    let mut single = Vec::new();
    write_npy(&mut single, &[3, 4], &heights.map(|height| height as f32)).unwrap();
    let mut integers = Vec::new();
    write_npy(&mut integers, &[3, 4], &heights.map(|height| height as i32)).unwrap();
    for file in [
        bench.array("double.npy", &[3, 4], &heights),
        bench.input("single.npy", single),
        bench.input("integers.npy", integers),
    ] {
        assert_eq!(holes(&bench, &format!("{file} --nodata=-9999")), [3, 10], "{file}");
    }
    let points = (0..12).flat_map(|k| match k {
        5 => [0.0; 3],
        _ => [1.0 + (k % 4) as f64, (k / 4) as f64, 0.0],
    });
    let points = bench.array("points.npy", &[3, 4, 3], &points.collect::<Vec<_>>());
    bench.done(format!("distance {points} --nodata 0 -s 0,0 --engine cpu -o p.npy"));
    let found = bench.map("p.npy");
    assert!(found.iter().enumerate().all(|(index, d)| d.is_infinite() == (index == 5)));

    let none = bench.array("none.npy", &[3, 4], &[5.0; 12]);
    let output = bench.done(format!("distance {none} --nodata=-1 -s 0,0 --engine cpu -o n.npy"));
    assert!(notes(&output).contains("no point has the value -1"), "{}", notes(&output));
    let fresh = Workbench::new();
    fresh
        .refuse("distance builtin:plane:9x9 --nodata 0 -s 0,0 -o d.npy", &["--nodata", "built-in"]);
}

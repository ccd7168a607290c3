//! Rasters in every role: surface, mask, slowness, sources, and outputs.

use geosweep::io::{SurfaceFile, read_map};

use crate::workbench::{Workbench, stderr};

const ROWS: usize = 12;
const COLS: usize = 17;

/// Returns an ESRI ASCII grid in cells of 10 m.
fn asc(corner: [f64; 2], value: impl Fn(usize, usize) -> f64) -> String {
    let [x, y] = corner;
    let mut text = format!(
        "ncols {COLS}\nnrows {ROWS}\nxllcorner {x}\nyllcorner {y}\ncellsize 10\nNODATA_value -1\n"
    );
    for row in 0..ROWS {
        let values: Vec<_> = (0..COLS).map(|col| value(row, col).to_string()).collect();
        text += &(values.join(" ") + "\n");
    }
    text
}

const CORNER: [f64; 2] = [5e5, 4e6];

fn run(bench: &Workbench, line: &str) -> Vec<f64> {
    let output = bench.run(line);
    assert!(output.status.success(), "{line}: {}", stderr(&output));
    let file = line.split_whitespace().last().unwrap();
    read_map(&bench.output(file)).unwrap().values
}

#[test]
fn rasters_are_surface_mask_slowness_and_sources() {
    let bench = Workbench::new();
    let flat = bench.input("flat.asc", asc(CORNER, |_, _| 5.0));
    let plain = run(&bench, &format!("distance {flat} -s 3,4 -o d.npy"));
    assert!((plain[3 * COLS + 14] - 100.0).abs() < 1e-3);

    let twice = bench.input("twice.asc", asc(CORNER, |_, _| 2.0));
    let times = run(&bench, &format!("distance {flat} --slowness {twice} -s 3,4 -o t.npy"));
    assert!(times.iter().zip(&plain).all(|(t, d)| (t - 2.0 * d).abs() < 1e-3));

    // 0 and no-data are holes.
    let mask = bench
        .input("mask.asc", asc(CORNER, |row, _| [1.0, 0.0, -1.0][row.saturating_sub(9).min(2)]));
    let masked = run(&bench, &format!("distance {flat} --mask {mask} -s 3,4 -o m.npy"));
    assert!(masked.iter().enumerate().all(|(index, d)| d.is_finite() == (index / COLS < 10)));

    let sources = bench.input(
        "sources.asc",
        asc(CORNER, |row, col| {
            if (row, col) == (3, 4) || (row, col) == (10, 2) { 7.0 } else { [0.0, -1.0][col % 2] }
        }),
    );
    let both = run(&bench, &format!("distance {flat} -s 3,4 -s 10,2 -o b.npy"));
    for option in ["--source-points", "--source-curve"] {
        let found = run(&bench, &format!("distance {flat} {option} {sources} -o s.npy"));
        assert_eq!(found, both, "{option}");
    }
}

#[test]
fn rasters_that_lie_elsewhere_are_refused() {
    let bench = Workbench::new();
    let flat = bench.input("flat.asc", asc(CORNER, |_, _| 5.0));
    let shifted = bench.input("shifted.asc", asc([5e5 + 10.0, 4e6], |_, _| 1.0));
    for line in [
        format!("--mask {shifted} -s 3,4"),
        format!("--slowness {shifted} -s 3,4"),
        format!("--source-points {shifted}"),
    ] {
        let output = bench.run(format!("distance {flat} {line} -o d.npy"));
        bench.refuses(&output, &["shifted.asc", "row 0, column 0", "gdalwarp"]);
    }
    let empty = bench.input("empty.asc", asc(CORNER, |_, _| 0.0));
    let output = bench.run(format!("distance {flat} --source-points {empty} -o d.npy"));
    bench.refuses(&output, &["empty.asc", "no source"]);
}

#[test]
fn written_rasters_lie_where_the_surface_does() {
    let bench = Workbench::new();
    let wall = |_: usize, col: usize| if col == 8 { -1.0 } else { 5.0 };
    let dem = bench.input("dem.asc", asc(CORNER, wall));
    let place = SurfaceFile::read(dem.as_ref()).unwrap().georeference().unwrap();
    let distances = run(&bench, &format!("distance {dem} -s 3,4 -o d.tif"));
    assert_eq!(distances.iter().filter(|d| d.is_infinite()).count(), 9 * ROWS);
    run(&bench, &format!("voronoi {dem} -s 3,4 -s 8,2 -o v.tif"));
    run(&bench, &format!("sample {dem} -k 3 --labels l.tif"));
    for file in ["d.tif", "v.tif", "l.tif"] {
        let written = SurfaceFile::read(&bench.output(file)).unwrap();
        assert_eq!(written.georeference().unwrap(), place, "{file}");
    }
}

//! Outputs of grids that go round the Earth: regions, ridges, one-sided offsets, estimated errors and matrices.

use crate::geodetic::{GLOBE, Grid};
use crate::workbench::{Workbench, map, stderr};

/// Returns the rows of a matrix in a .npy file.
fn matrix(bench: &Workbench, name: &str, cols: usize) -> Vec<Vec<f64>> {
    let file = bench.output(name);
    let values = map(&file);
    assert!(values.len().is_multiple_of(cols), "{name}: {} values", values.len());
    values.chunks_exact(cols).map(<[f64]>::to_vec).collect()
}

#[test]
fn matrices_leave_added_lines_out() {
    let bench = Workbench::new();
    let cells = bench.array("cells.npy", &[18, 36], &vec![0.0; 18 * 36]);
    bench.done(format!("distance {cells} {GLOBE} pixel -s 5,35 -o map.npy"));
    let source = 5 * 36 + 35;
    let range = format!("{source}..{}", source + 2);
    let words = format!("pairwise {cells} {GLOBE} pixel --sources {range} --json -o rows.npy");
    let said = bench.json(&words);
    assert_eq!([&said["matrix_cols"], &said["points"]], [18 * 36, 18 * 36]);
    let rows = matrix(&bench, "rows.npy", 18 * 36);
    assert_eq!((rows.len(), rows[0][source], rows[1][source + 1]), (2, 0.0, 0.0));
    // Rows have curved fronts, and maps those that carry their ray. Cells are 10 degrees wide.
    for (found, exact) in rows[0].iter().zip(bench.map("map.npy")) {
        assert!((found - exact).abs() < 2e-3 * exact + 1.0, "{found} {exact}");
    }
    assert!((rows[0][source + 1] - rows[1][source]).abs() < 1e-3 * rows[1][source]);
    let said = bench.json(format!("canonical {cells} {GLOBE} pixel --json -o form.npy"));
    assert_eq!([&said["rows"], &said["cols"]], [18, 36]);
}

#[test]
fn regions_and_pairs_are_those_of_the_cells_of_the_file() {
    let bench = Workbench::new();
    let cells = Grid::new([-175.0, 36.0], [85.0, 18.0, -10.0]);
    let file = cells.file(&bench, "cells.npy", false);
    let sources = "--source-lonlat -175,5 --source-lonlat 5,5";
    let line = format!("voronoi {file} {GLOBE} pixel {sources} -o regions.npy --json");
    let said = bench.json(&line);
    let regions = bench.map("regions.npy");
    let count = |region: f64| regions.iter().filter(|&&found| found == region).count() as u64;
    for (region, place) in [(0, [-155.0, 25.0]), (1, [15.0, 85.0]), (0, [175.0, -75.0])] {
        let index = cells.places().position(|other| other == place).unwrap();
        assert_eq!(regions[index], f64::from(region), "{place:?}");
        assert_eq!(said["regions"][region as usize]["points"], count(f64::from(region)));
    }
    let areas = [0, 1].map(|region| said["regions"][region]["area"].as_f64().unwrap());
    assert!((areas[0] - areas[1]).abs() < 1e-2 * areas[0], "{areas:?}");
    assert!((areas[0] + areas[1] - 5.10066e14).abs() < 5e12, "{areas:?}");
    bench.done(format!("sample {file} {GLOBE} pixel -k 5 --labels labels.npy --picture s.png"));
    assert_eq!(bench.map("labels.npy").len(), 18 * 36);

    let all = format!("pairwise {file} {GLOBE} pixel --wavefront curved");
    let said = bench.json(format!("{all} -o d.npy --sources 323..326 --json"));
    assert_eq!([&said["matrix_rows"], &said["matrix_cols"], &said["points"]], [3, 648, 648]);
    let rows = bench.map("d.npy");
    let row = format!("distance {file} {GLOBE} pixel --precision single -s 8,36 -o row.npy");
    let outside = bench.run(&row);
    assert!(outside.status.success(), "the column that is added is a place: {}", stderr(&outside));
    bench.done(row.replace("8,36", "8,35").replace("row.npy", "other.npy"));
    let row = bench.map("other.npy");
    assert_eq!(rows.len(), 3 * 648);
    for (found, exact) in rows[..648].iter().zip(&row) {
        // Rows have curved fronts, and the map those that carry their ray.
        assert!((found - exact).abs() < 4e-3 * exact.max(1e6), "{found} {exact}");
    }
    let line = format!("{all} -o near.npz --format csr --radius 1.5e6 --sources 323..324 --json");
    let said = bench.json(&line);
    let near = row.iter().filter(|&&distance| distance <= 1.5e6).count() as u64;
    assert_eq!((&said["stored"], &said["matrix_cols"]), (&near.into(), &648.into()));
}

#[test]
fn regions_and_directions_pass_the_date_line() {
    let bench = Workbench::new();
    let lines = bench.flat(37, 73);
    for west in [-180.0, -0.7] {
        let earth =
            format!("--geodetic --extent={west},-90,{},90 --registration gridline", west + 360.0);
        // Sources at opposite places of the equator.
        let [near, far] = [west + 355.0, west + 175.0];
        let sources = format!("--source-lonlat {near},0 --source-lonlat {far},0");
        let line = format!("voronoi {lines} {earth} {sources} -o regions.npy --json");
        let said = bench.json(&line);
        let area = |region: usize| said["regions"][region]["area"].as_f64().unwrap();
        // The ellipsoid has 5.10066e14 square metres.
        assert!((area(0) - area(1)).abs() < 1e-3 * area(0), "{} {}", area(0), area(1));
        assert!((area(0) + area(1) - 5.10066e14).abs() < 5e12, "{}", area(0) + area(1));
        let line = format!("distance {lines} {earth} {sources} --back-direction way.npy");
        bench.done(format!("{line} --nearest nearest.npy --log-map log.npy"));
        let [regions, nearest, way] =
            ["regions.npy", "nearest.npy", "way.npy"].map(|name| bench.map(name));
        for col in [0, 1, 8, 64, 71, 72] {
            assert_eq!([regions[18 * 73 + col], nearest[18 * 73 + col]], [0.0; 2], "{west} {col}");
            let wanted = if (36..71).contains(&col) { 90.0 } else { 270.0 };
            assert!(
                col == 71 || (way[18 * 73 + col] - wanted).abs() < 1.0,
                "{west} {col}: {}",
                way[18 * 73 + col]
            );
        }
        bench.done(format!("sample {lines} {earth} -k 5 --labels labels.npy --picture s.png"));
        let labels = bench.map("labels.npy");
        assert!((0..5).all(|label| labels.contains(&f64::from(label))));
        assert!((0..37).all(|row| labels[row * 73] == labels[row * 73 + 72]), "{labels:?}");
    }
}

/// A grid that has lines at the poles and on both sides of the seam needs no added lines, so that matrices and samples
/// are possible on it.
#[test]
fn grids_with_all_lines_have_matrices() {
    let bench = Workbench::new();
    let lines = bench.flat(13, 25);
    let earth = "--geodetic --extent 0,-90,360,90 --registration gridline";
    bench.done(format!("pairwise {lines} {earth} --sources 156..157 -o rows.npy"));
    let row = bench.map("rows.npy");
    // From the equator at 90 degrees east to both poles, by a quarter of a meridian, and to the same place at 0 and
    // 360 degrees, by a quarter of the equator.
    let quarter = 10_001_966.0;
    for (point, exact) in [(0, quarter), (324, quarter), (150, 10_018_754.0), (174, 10_018_754.0)] {
        assert!((row[point] - exact).abs() < 2e-3 * exact, "{point}: {}", row[point]);
    }
    let said = bench.json(format!("sample {lines} {earth} -k 2 -o s.geojson --json"));
    assert_eq!(said["samples"][0]["row"], 6.0);
}

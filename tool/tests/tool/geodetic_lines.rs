//! Ridges, one-sided offsets, estimated errors and matrices of grids that go round the Earth.

use crate::vincenty::vincenty;
use crate::workbench::{Workbench, done, json, map};

/// Grids of cells lack the poles and a column at the seam, which the surface has in addition.
const CELLS: &str = "--geodetic --extent -180,-90,180,90 --registration pixel";

/// Returns the rows of a matrix in a .npy file.
fn matrix(bench: &Workbench, name: &str, cols: usize) -> Vec<Vec<f64>> {
    let file = bench.output(name);
    let values = map(&file);
    assert!(values.len().is_multiple_of(cols), "{name}: {} values", values.len());
    values.chunks_exact(cols).map(<[f64]>::to_vec).collect()
}

#[test]
fn estimates_of_errors_go_round_the_earth() {
    let bench = Workbench::new();
    let cells = bench.array("cells.npy", &[60, 120], &vec![0.0; 60 * 120]);
    let line = format!("distance {cells} {CELLS} -s 20,3 -o map.npy --error error.npy --json");
    let said = json(&done(&bench, &line));
    let mean = said["mean_relative_error"].as_f64().unwrap();
    let [distances, errors] = ["map.npy", "error.npy"].map(|name| map(&bench.output(name)));
    assert_eq!([distances.len(), errors.len()], [60 * 120; 2]);
    let place =
        |index: usize| [-178.5 + 3.0 * (index % 120) as f64, 88.5 - 3.0 * (index / 120) as f64];
    let source = place(20 * 120 + 3);
    let (mut true_mean, mut estimated, mut within, mut count) = (0.0, 0.0, 0.0, 0.0);
    for (index, (&found, &bound)) in distances.iter().zip(&errors).enumerate() {
        let Some(exact) =
            vincenty(source, place(index)).filter(|exact| (1.0..1.9e7).contains(exact))
        else {
            continue;
        };
        let error = (found - exact).abs();
        (true_mean, estimated) = (true_mean + error, estimated + bound);
        within += f64::from(u8::from(error <= 2.0 * bound));
        count += 1.0;
    }
    let (ratio, within) = (estimated / true_mean, within / count);
    println!("estimate over error {ratio:.2}, within twice {within:.3}, mean {mean:.1e}");
    assert!((0.5..4.0).contains(&ratio) && within > 0.9, "{ratio} {within}");
}

#[test]
fn ridges_and_offsets_go_round_the_earth() {
    let bench = Workbench::new();
    let cells = bench.array("cells.npy", &[60, 120], &vec![0.0; 60 * 120]);
    // The bisector of two places on one parallel is a meridian and its opposite, over both poles.
    let sources = "--source-lonlat 160,20 --source-lonlat -160,20";
    let line = format!("ridges {cells} {CELLS} {sources} --json -o ridges.geojson");
    let said = json(&done(&bench, &line));
    let length: f64 = said["ridges"]
        .as_array()
        .unwrap()
        .iter()
        .map(|ridge| ridge["length"].as_f64().unwrap())
        .sum();
    // A meridian and its opposite are 40,008 km long. On some of it fronts include less than 30 degrees.
    assert!(length > 2e7 && length < 4.05e7, "{said}");
    // A line of latitude across the seam, with an offset on its north. It has a vertex at the grid's first column, which
    // the surface has again after its last one.
    let curve = r#"{"type":"LineString","coordinates":[[170,0],[-178.5,0],[-170,0]]}"#;
    let curve = bench.input("curve.geojson", curve);
    let line = format!("offset {cells} {CELLS} --source-curve {curve} --distances 1e6 --side left");
    let said = json(&done(&bench, &format!("{line} --json -o left.geojson")));
    let length = said["levels"][0]["length"].as_f64().unwrap();
    // The equator is 40,075 km long. The offset lies 9 degrees north of it, and ends in two quarters of a circle.
    let exact = 20.0 / 360.0 * 4.0075e7 * 9f64.to_radians().cos() + 3.1416e6;
    assert!((length - exact).abs() < 0.03 * exact, "{length} {exact}");
}

#[test]
fn matrices_leave_added_lines_out() {
    let bench = Workbench::new();
    let cells = bench.array("cells.npy", &[18, 36], &vec![0.0; 18 * 36]);
    done(&bench, &format!("distance {cells} {CELLS} -s 5,35 -o map.npy"));
    let source = 5 * 36 + 35;
    let range = format!("{source}..{}", source + 2);
    let words = format!("pairwise {cells} {CELLS} --sources {range} --json -o rows.npy");
    let said = json(&done(&bench, &words));
    assert_eq!([&said["matrix_cols"], &said["points"]], [18 * 36, 18 * 36]);
    let rows = matrix(&bench, "rows.npy", 18 * 36);
    assert_eq!((rows.len(), rows[0][source], rows[1][source + 1]), (2, 0.0, 0.0));
    for (found, exact) in rows[0].iter().zip(map(&bench.output("map.npy"))) {
        assert!((found - exact).abs() < 1e-4 * exact + 1.0, "{found} {exact}");
    }
    assert!((rows[0][source + 1] - rows[1][source]).abs() < 1e-3 * rows[1][source]);
    let said = json(&done(&bench, &format!("canonical {cells} {CELLS} --json -o form.npy")));
    assert_eq!([&said["rows"], &said["cols"]], [18, 36]);
}

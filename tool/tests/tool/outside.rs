//! Sources outside the surface, in its holes, and in the outer half of its border cells.

use crate::workbench::{Workbench, notes};

/// Writes a raster of 9 x 13 cells of 10 m with a hole at row 4, columns 5 to 7.
fn raster(bench: &Workbench) -> String {
    let mut text = String::from("ncols 13\nnrows 9\nxllcorner 5000\nyllcorner 9000\ncellsize 10\n");
    for row in 0..9 {
        let value = |col: usize| if row == 4 && (5..8).contains(&col) { "-9999 " } else { "0 " };
        text += &(0..13).map(value).collect::<String>();
        text += "\n";
    }
    bench.input("a.asc", text)
}

#[test]
fn border_cells_reach_to_their_outer_edges() {
    let bench = Workbench::new();
    let grid = raster(&bench);
    for (x, y, at) in [
        (5002.0, 9045.0, [4, 0]),
        (5128.0, 9045.0, [4, 12]),
        (5065.0, 9088.0, [0, 6]),
        (5129.9, 9000.1, [8, 12]),
    ] {
        bench.done(format!("distance {grid} --source-xy {x},{y} --engine cpu -o d.npy"));
        assert_eq!(bench.map("d.npy")[at[0] * 13 + at[1]], 0.0, "{x},{y}");
    }
    let fresh = Workbench::new();
    let grid = raster(&fresh);
    for place in ["4999,9045", "5131,9045", "5065,9091", "5065,8999"] {
        let line = format!("distance {grid} --source-xy {place} -o d.npy");
        fresh.refuse(&line, &["lies outside the grid", "--sources-outside"]);
    }
}

#[test]
fn sources_elsewhere_are_refused_skipped_or_snapped() {
    let bench = Workbench::new();
    let grid = raster(&bench);
    let places: Vec<_> = (0..7).map(|k| format!("{},9055", 4900 - k)).collect();
    // One on the surface, one in the hole, and seven outside.
    let table = format!("x,y\n5015,9075\n5065,9045\n{}\n", places.join("\n"));
    let table = bench.input("wells.csv", table);
    let line = format!("distance {grid} --source-points {table} --engine cpu -o d.npy");
    bench.refuse(
        &line,
        &["8 places are not on the surface", "line 4", "line 7", "and 3 more", "skip"],
    );

    let skipped = bench.done(format!("{line} --sources-outside skip"));
    assert!(notes(&skipped).contains("8 sources outside the surface left out"));
    let sources = |bench: &Workbench| {
        let found = bench.map("d.npy").into_iter().enumerate();
        found.filter(|(_, d)| *d == 0.0).map(|(k, _)| [k / 13, k % 13]).collect::<Vec<_>>()
    };
    assert_eq!(sources(&bench), [[1, 1]]);
    let snapped = bench.done(format!("{line} --sources-outside snap"));
    assert!(notes(&snapped).contains("8 sources moved"), "{}", notes(&snapped));
    assert_eq!(sources(&bench), [[1, 1], [3, 0], [3, 6]]);

    let fresh = Workbench::new();
    let grid = raster(&fresh);
    for source in ["-s 4,6", "-s 4,99", "--source-xy 5065,9045"] {
        let line = format!("distance {grid} {source} --sources-outside skip -o d.npy");
        fresh.refuse(&line, &["no source lies on the surface"]);
        fresh.refuse(format!("distance {grid} {source} -o d.npy"), &["--sources-outside"]);
    }
}

#[test]
fn cells_of_a_raster_bring_their_labels() {
    let bench = Workbench::new();
    let grid = raster(&bench);
    let mut text = String::from("ncols 13\nnrows 9\nxllcorner 5000\nyllcorner 9000\ncellsize 10\n");
    for row in 0..9 {
        let label = |col: usize| match (row, col) {
            (1, 1 | 2) => "7 ",
            (7, 11) => "3 ",
            _ => "0 ",
        };
        text += &(0..13).map(label).collect::<String>();
        text += "\n";
    }
    let labels = bench.input("l.asc", text);
    bench.done(format!("distance {grid} --source-points {labels} --engine cpu --nearest n.tif"));
    bench.done(format!("distance {grid} --source-curve {labels} --engine cpu --nearest c.npy"));
    let found = bench.json(format!("voronoi {grid} --source-points {labels} -o v.npy --json"));
    let nearest = bench.map("n.tif");
    assert_eq!([nearest[0], nearest[13 + 2], nearest[8 * 13 + 12]], [7.0, 7.0, 3.0]);
    for other in ["c.npy", "v.npy"] {
        // Holes are no-data in a TIFF.
        let is_hole = |label: f64| label == -1.0 || label.is_nan();
        let same = bench.map(other).iter().zip(&nearest).all(|(a, b)| a == b || is_hole(*b));
        assert!(same, "{other}");
    }
    assert_eq!(found["neighbours"], serde_json::json!([[3, 7]]));
    let regions = found["regions"].as_array().unwrap();
    assert_eq!([&regions[0]["source"], &regions[1]["source"]], [3, 7]);
    let path = bench.json(format!("path {grid} --source-points {labels} --from 0,0 --json"));
    assert_eq!(path["paths"][0]["source"], 7);
}

//! Voronoi regions through the tool.

use geosweep::io::read_map;

use crate::workbench::{Workbench, json, stderr};

#[test]
fn regions_contain_the_nearest_points() {
    let bench = Workbench::new();
    let flat = bench.flat(33, 41);
    let sources = [[8.0, 10.0], [20.0, 30.0], [28.0, 6.0]];
    let line = format!(
        "voronoi {flat} --spacing 1 -s 8,10 -s 20,30 -s 28,6 --engine cpu -o labels.npy \
         --borders b.npy --borders b.csv --picture v.png --json"
    );
    let report = bench.json(&line);
    assert_eq!(bench.outputs(), ["b.csv", "b.npy", "labels.npy", "v.png"]);
    let labels = read_map(&bench.output("labels.npy")).unwrap();
    let far = |row: f64, col: f64, [r, c]: [f64; 2]| (row - r).hypot(col - c);
    let mut points = [0; 3];
    for (index, label) in labels.values.iter().enumerate() {
        let (row, col) = ((index / 41) as f64, (index % 41) as f64);
        let distances = sources.map(|source| far(row, col, source));
        let nearest = distances.iter().copied().fold(f64::INFINITY, f64::min);
        points[*label as usize] += 1;
        assert!(distances[*label as usize] < nearest + 1e-3, "{row},{col}: {label}");
    }
    for (index, region) in report["regions"].as_array().unwrap().iter().enumerate() {
        assert_eq!((&region["source"], &region["points"]), (&index.into(), &points[index].into()));
    }
    assert_eq!(report["neighbours"], serde_json::json!([[0, 1], [0, 2], [1, 2]]));
    approx::assert_relative_eq!(report["area"].as_f64().unwrap(), 32.0 * 40.0, max_relative = 1e-9);

    let mut table = csv::Reader::from_path(bench.output("b.csv")).unwrap();
    assert_eq!(&table.headers().unwrap().iter().collect::<Vec<_>>()[2..4], ["left", "right"]);
    let rows: Vec<_> = table.records().map(Result::unwrap).collect();
    let borders = bench.curves("b.npy");
    assert_eq!(borders.len(), 3);
    assert_eq!(rows.len(), borders.iter().map(Vec::len).sum::<usize>());
    for row in &rows {
        let number = |k: usize| row[k].parse::<f64>().unwrap();
        let [left, right] = [2, 3].map(|k| {
            let source = sources[row[k].parse::<usize>().unwrap()];
            far(number(6), number(7), source)
        });
        // Moving a vertex by half a cell changes the difference of its distances by at most a cell. Junctions are
        // within a cell.
        assert!((left - right).abs() < 1.0, "{row:?}");
    }
}

#[test]
fn unreached_points_have_no_region() {
    let bench = Workbench::new();
    let mut heights = vec![0.0; 9 * 12];
    (0..9).for_each(|row| heights[row * 12 + 7] = f64::NAN);
    let cut = bench.array("cut.npy", &[9, 12], &heights);
    let line =
        format!("voronoi {cut} --spacing 1 -s 4,1 -s 4,1 -s 4,5 --engine cpu -o l.npy --json");
    let output = bench.done(&line);
    assert!(stderr(&output).contains("cannot be reached"), "{}", stderr(&output));
    let labels = read_map(&bench.output("l.npy")).unwrap();
    for (index, label) in labels.values.iter().enumerate() {
        let expected = if index % 12 >= 7 { -1.0 } else { *label };
        assert!(*label == expected && *label != 1.0, "{index}: {label}");
    }
    // The first of two sources at one point gets the whole region.
    let report = json(&output);
    assert_eq!(report["regions"][1]["points"], 0);
    assert_eq!(report["regions"][1]["area"], 0.0);
    let line = format!("voronoi {cut} --spacing 1 -s 4,1 -o l.png");
    let bench = Workbench::new();
    bench.refuse(&line, &["l.png", ".npy or .tif"]);
}

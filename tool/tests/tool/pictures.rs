//! Pictures of curves, and the figures.

use std::io::Cursor;

use crate::workbench::Workbench;

#[test]
fn pictures_come_in_both_views() {
    let bench = Workbench::new();
    for (view, name) in [("map", "map.png"), ("shaded", "shaded.png")] {
        let line = format!(
            "contours builtin:face:61x51 -s 34,25 --every 20 --unit mm --engine cpu \
             --view {view} --picture {name}"
        );
        bench.done(&line);
        let picture = png::Decoder::new(Cursor::new(bench.read(name))).read_info().unwrap();
        let info = picture.info();
        assert!(info.width.min(info.height) > 500, "{view}: {} x {}", info.width, info.height);
    }
    assert_ne!(bench.read("map.png"), bench.read("shaded.png"));
    let metric = bench.array("metric.npy", &[5, 5, 2, 2], &[1.0, 0.0, 0.0, 1.0].repeat(25));
    bench.done(format!("path {metric} -s 0,0 --from 4,4 --picture m.png -o m.npy -o m.svg"));
    let path = &bench.curves("m.npy")[0];
    assert!(path.iter().all(|row| row[2].is_nan() && row[1].is_finite()));

    let bench = Workbench::new();
    let metric = bench.array("metric.npy", &[5, 5, 2, 2], &[1.0, 0.0, 0.0, 1.0].repeat(25));
    for (rest, parts) in [
        ("-o m.obj", ["m.obj", "metric"]),
        ("-o m.ply", ["m.ply", "metric"]),
        ("--picture m.png --view shaded", ["metric", "--view map"]),
        ("-o m.txt", ["m.txt", ".geojson"]),
        ("-o m.csv -o m.csv", ["m.csv", "two outputs"]),
        ("--picture m.jpg", ["m.jpg", ".png"]),
        ("--picture m.png --toward 0,0,0", ["--toward", "direction"]),
        ("", ["--output", "PATHS"]),
    ] {
        let line = format!("path {metric} -s 0,0 --from 4,4 --engine cpu {rest}");
        bench.refuse(&line, &parts);
    }
}

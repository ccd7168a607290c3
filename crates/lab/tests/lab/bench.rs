//! The speed of engines and schedules.

use crate::workbench::{Workbench, stderr};

/// The numbers depend on the machine, but they exist, are consistent with one another, and the counts are
/// right.
#[test]
fn a_bench_counts_right_and_its_numbers_fit() {
    let bench = Workbench::new();
    let report = bench.json(
        "bench --sizes 40,17,24 --surfaces sphere,terrain --engines \
                cpu,vulkan,fast-marching --wavefront planar,curved --quick --json --plot speed.png \
                --schedules raster,tiles",
    );
    let maps = report["maps"].as_array().unwrap();
    // Two surfaces, two wavefronts, three sizes, four methods.
    assert_eq!(maps.len(), 2 * 2 * 3 * 4);
    for map in maps {
        let number = |name: &str| map[name].as_f64().unwrap_or_else(|| panic!("{name}: {map}"));
        assert_eq!(map["converged"], true, "{map}");
        assert!(number("best_seconds") > 0.0 && number("set_up_seconds") > 0.0, "{map}");
        assert!(number("best_seconds") <= number("median_seconds"), "{map}");
        let rate = number("points") / number("median_seconds");
        approx::assert_relative_eq!(number("points_per_second"), rate, max_relative = 1e-9);
        assert!(number("points") <= number("rows") * number("cols"), "{map}");
        // Each of an iteration's four scans visits two of a point's triangles.
        let all_scans = 4.0 * 2.0 * number("iterations");
        let texels = (number("rows") / 2.0).ceil() * (number("cols") / 2.0).ceil();
        let (work, shares) = (&map["work"], &map["shares"]);
        let triangles = work["triangles"].as_f64();
        match map["schedule"].as_str().unwrap() {
            // This method skips points that cannot change.
            "rotated-scan" => {
                let all = all_scans * number("rows") * number("cols");
                assert!(triangles.unwrap() > 0.1 * all && triangles.unwrap() <= all, "{map}");
                assert!(shares["data"].as_f64().unwrap() > 0.0, "{map}");
                assert!(shares["arithmetic"].as_f64().unwrap() > 0.0, "{map}");
                assert!(number("bytes") < 400.0 * number("points"), "{map}");
            }
            "raster" => {
                // The first iteration is bounded around the source.
                assert!(triangles.unwrap() < all_scans * 4.0 * texels, "{map}");
                assert!(work["dispatches"].as_f64().unwrap() > number("iterations"), "{map}");
                for part in ["data", "arithmetic", "dispatches"] {
                    assert!(shares[part].as_f64().unwrap() > 0.0, "{map}");
                }
            }
            "tiles" => {
                assert!(work["dispatches"].as_f64().unwrap() > number("iterations"), "{map}");
                assert!(shares["data"].as_f64().unwrap() > 0.0, "{map}");
                assert!(work["triangles"].is_null() && shares["arithmetic"].is_null(), "{map}");
            }
            "order-of-time" => {
                assert!(number("iterations") == 1.0, "{map}");
                // Few points are computed twice, from two triangles or more.
                let points = number("points");
                assert!(triangles.unwrap() > points && triangles.unwrap() < 8.0 * points, "{map}");
            }
            other => panic!("{other}: {map}"),
        }
    }
    let sizes: Vec<_> = maps[..12].iter().map(|map| map["rows"].as_u64().unwrap()).collect();
    assert_eq!(sizes, [[17; 4], [24; 4], [40; 4]].concat());
    let growth = report["growth"].as_array().unwrap();
    assert_eq!(growth.len(), 2 * 2 * 4);
    assert!(growth.iter().all(|found| found["exponent"].is_f64()));
    assert!(report["cpu"]["copy"].as_f64().unwrap() > 0.0);
    assert!(report["device"]["ceilings"]["dispatch"].as_f64().unwrap() > 0.0);
    assert!(bench.outputs() == ["speed.png"]);
}

#[test]
fn a_bench_of_a_file_has_its_size_and_empty_ones_are_refused() {
    let bench = Workbench::new();
    let flat = bench.flat(30, 50);
    let output = bench.run(format!("bench --surfaces {flat} --engines cpu --quick -o speed.md"));
    assert!(output.status.success() && output.stdout.is_empty(), "{}", stderr(&output));
    let report = std::fs::read_to_string(bench.output("speed.md")).unwrap();
    assert!(report.contains("30 x 50") && report.contains("flat.npy, curved"), "{report}");
    std::fs::remove_file(bench.output("speed.md")).unwrap();
    for (line, parts) in [
        ("bench --surfaces teapot", ["teapot", "terrain"]),
        ("bench --sizes 1", ["`1`", "points per side"]),
        ("bench --wavefront square", ["square", "curved"]),
        ("bench --limit=-1", ["--limit", "-1"]),
        ("bench --quick --plot speed.jpg", ["speed.jpg", ".png"]),
        ("bench --quick --device nonesuch", ["nonesuch", "available"]),
    ] {
        bench.refuse(line, &parts);
    }
}

//! Tuning for a device: portions, schedules, frames.

use serde_json::Value;

use crate::workbench::{Workbench, json, stderr};

const QUICK: &str = "tune --quick --sizes 33 --surfaces sphere --json";

fn rows<'a>(report: &'a Value, schedule: &'a str) -> impl Iterator<Item = &'a Value> {
    let rows = report["rows"].as_array().unwrap();
    rows.iter().filter(move |row| row["schedule"] == schedule)
}

/// Other portions give the same map, and the times in the report are consistent.
#[test]
fn a_sweep_finds_the_same_maps_and_suggests_among_what_it_tried() {
    let bench = Workbench::new();
    // A busy machine needs longer than the default budget.
    let report = bench.json(QUICK.replace("--json", "--budget 600 --json"));
    let mut tried = Vec::new();
    for schedule in ["raster", "tiles"] {
        let of_schedule: Vec<_> = rows(&report, schedule).collect();
        let untuned = of_schedule[0];
        assert_eq!((&untuned["knob"], &untuned["ratio"]), (&"untuned".into(), &1.0.into()));
        assert!(of_schedule.len() > 3, "{report}");
        for row in &of_schedule {
            assert!(row["refused"].is_null(), "{row}");
            let maps = row["maps"].as_array().unwrap();
            assert_eq!(maps.len(), 1, "{row}");
            assert!(maps[0]["difference"].as_f64().unwrap() <= 1e-5, "{row}");
            assert!(maps[0]["iterations"].as_u64().unwrap() > 1, "{row}");
            let seconds = |name: &str| maps[0][name].as_f64().unwrap();
            let ratio = seconds("best_seconds") / seconds("untuned_seconds");
            approx::assert_relative_eq!(row["ratio"].as_f64().unwrap(), ratio, max_relative = 1e-9);
            tried.push((row["knob"].as_str().unwrap().to_owned(), row["value"].as_u64().unwrap()));
        }
    }
    // Each suggested value was tried, or is the untuned one.
    for (name, knob) in [
        ("scan_lines", "lines a block"),
        ("scan_width", "invocations a group"),
        ("tile", "points a tile's side"),
        ("inner", "iterations in a tile"),
    ] {
        let value = report["suggested"][name].as_u64().unwrap();
        let is_as_before = report["suggested"][name] == report["untuned"][name];
        assert!(is_as_before || tried.contains(&(knob.into(), value)), "{name}: {report}");
    }
    assert_eq!(report["schedules"][0]["rows"], 33);
    assert!(["raster", "tiles"].contains(&report["schedules"][0]["best"].as_str().unwrap()));
    assert_eq!(report["left_out"].as_array().unwrap().len(), 0, "{report}");
}

#[test]
fn a_sweep_without_time_says_what_it_leaves_out() {
    let bench = Workbench::new();
    let line = QUICK.replace("--json", "--budget 0 -o tuning.md");
    let said = stderr(&bench.done(&line));
    assert!(
        said.contains("left out: raster, sphere 33 x 33") && said.contains("--budget"),
        "{said}"
    );
    let report = std::fs::read_to_string(bench.output("tuning.md")).unwrap();
    for part in ["Nothing was measured", "Left out:", "tiles, sphere 33 x 33", "as it is"] {
        assert!(report.contains(part), "{part}: {report}");
    }
}

/// With fewer lines in each dispatch, there are more dispatches if no line fits a workgroup. With fewer iterations in
/// each submission, there are more submissions.
#[test]
fn a_bench_with_other_portions_counts_other_dispatches() {
    let bench = Workbench::new();
    let work = |tuning: &str| {
        let report = bench.json(format!(
            "bench --quick --limit 60 --sizes 257 --surfaces sphere --engines vulkan --schedules raster --json \
             --tuning {tuning}"
        ));
        let work = &report["maps"][0]["work"];
        let count = |name: &str| work[name].as_u64().unwrap();
        (count("dispatches") + count("skipped_dispatches"), count("submissions"))
    };
    let (many, _) = work("64,2,16,4");
    let (few, together) = work("64,8,16,4");
    assert!(many > 2 * few, "{many} {few}");
    let (_, apart) = work("64,8,16,4,1");
    assert!(apart > together, "{apart} {together}");
}

#[test]
fn a_bench_without_time_says_what_it_leaves_out() {
    let bench = Workbench::new();
    let output =
        bench.run("bench --quick --sizes 9,17 --surfaces sphere --engines cpu --budget 0 --json");
    assert_eq!(json(&output)["maps"].as_array().unwrap().len(), 0);
    let said = stderr(&output);
    assert!(said.contains("sphere of 17 x 17 points is left out"), "{said}");
}

#[test]
fn frames_of_a_moving_surface_are_timed() {
    let bench = Workbench::new();
    let report = bench.json("frames --sizes 48,33 --frames 3 --limit 600 --iterations 20 --schedules raster,tiles --json");
    let frames = report["frames"].as_array().unwrap();
    let found: Vec<_> =
        frames.iter().map(|frame| (frame["rows"].as_u64(), frame["schedule"].as_str())).collect();
    let wanted = [(33, "raster"), (33, "tiles"), (48, "raster"), (48, "tiles")];
    assert_eq!(found, wanted.map(|(side, schedule)| (Some(side), Some(schedule))));
    for frame in frames {
        let number = |name: &str| frame[name].as_f64().unwrap_or_else(|| panic!("{name}: {frame}"));
        assert_eq!((number("frames"), number("converged")), (3.0, 3.0), "{frame}");
        assert!(number("iterations") > 1.0, "{frame}");
        assert!(number("host_seconds") > 0.0 && number("record_seconds") > 0.0, "{frame}");
        assert!(number("worst_seconds") >= number("host_seconds"), "{frame}");
        if let Some(device) = frame["device_seconds"].as_f64() {
            assert!(device > 0.0 && device < number("worst_seconds"), "{frame}");
        }
    }
}

#[test]
fn unsuitable_tunings_are_refused() {
    let bench = Workbench::new();
    let vulkan = "bench --quick --sizes 9 --engines vulkan";
    for (line, parts) in [
        (format!("{vulkan} --tuning 64,0,16,4"), ["0 lines", "from 1 to 32"]),
        (format!("{vulkan} --tuning 64,4,16,4,0"), ["submission", "at least one iteration"]),
        (format!("{vulkan} --tuning 8,8,16,4"), ["8 invocations", "8 lines"]),
        (format!("{vulkan} --tuning 64,4,16"), ["--tuning", "128,8,16,4"]),
        ("tune --device nonesuch".into(), ["nonesuch", "available"]),
        ("frames --device nonesuch".into(), ["nonesuch", "available"]),
        ("frames --frames 0".into(), ["--frames", "0"]),
        ("tune -o tuning.txt".into(), ["tuning.txt", ".md"]),
    ] {
        bench.refuse(&line, &parts);
    }
}

//! Committed figures that do not depend on the machine equal those of this engine: errors, iterations, bytes.
//! `ci/figures` writes them anew.

use serde_json::Value;

use crate::workbench::Workbench;

const ACCURACY: &str = include_str!("../../../../docs/figures/accuracy.md");
const ACCURACY_DOUBLE: &str = include_str!("../../../../docs/accuracy-double.md");
const TABLE_2: &str = include_str!("../../../../docs/figures/table-2.md");

/// Returns the cells of a line of a Markdown table.
fn cells(line: &str) -> Vec<&str> {
    line.trim_matches('|').split('|').map(str::trim).collect()
}

/// Returns whether two errors are the same. Built-in surfaces depend on the mathematical library, whose
/// rounding differs. Errors below `least` are only rounding.
fn is_same(found: f64, committed: f64, least: f64) -> bool {
    (found - committed).abs() <= 0.02 * committed.max(least)
}

#[test]
fn committed_errors_are_those_of_this_engine() {
    compare("docs/figures/accuracy.md", ACCURACY, "accuracy --sizes 33,65,129 --json", 1e-6);
}

#[test]
fn committed_errors_in_double_precision_are_those_of_this_engine() {
    let line = "accuracy --sizes 33,65,129 --precision double --json";
    compare("docs/accuracy-double.md", ACCURACY_DOUBLE, line, 1e-12);
}

/// Compares a page's tables of errors with the output of a command.
fn compare(page: &str, text: &str, line: &str, least: f64) {
    let bench = Workbench::new();
    let report = bench.json(line);
    let maps = report["maps"].as_array().unwrap();
    let mut compared = 0;
    for of_surface in text.split("\n## ").skip(1) {
        let surface = of_surface.lines().next().unwrap();
        for line in of_surface.lines().filter(|line| line.starts_with('|')) {
            let [wavefront, side, mean, rms, max, _, iterations, _] = cells(line)[..] else {
                continue;
            };
            let is_meant = |map: &&Value| {
                map["surface"] == surface
                    && map["wavefront"] == wavefront
                    && map["side"].as_u64() == side.parse().ok()
            };
            let Some(map) = maps.iter().find(is_meant) else { continue };
            let committed = [mean, rms, max].map(|text| text.parse::<f64>().unwrap());
            let names = ["mean_relative_error", "rms_relative_error", "max_relative_error"];
            for (name, committed) in names.into_iter().zip(committed) {
                let found = map[name].as_f64().unwrap();
                assert!(
                    is_same(found, committed, least),
                    "{surface}, {wavefront}, {side}: {name} is {found:e}, {page} has {committed:e}; run ci/figures"
                );
            }
            assert_eq!(map["iterations"].to_string(), iterations, "{surface}, {wavefront}, {side}");
            compared += 1;
        }
    }
    assert_eq!(compared, maps.len());
}

#[test]
fn committed_memory_and_iterations_are_those_of_this_engine() {
    let bench = Workbench::new();
    let report = bench.json("figure table-2 --sizes 150,400 --json");
    let mut compared = 0;
    for size in report["sizes"].as_array().unwrap().iter().filter(|size| size["engine"] == "cpu") {
        let points = format!("{} x {}", size["rows"], size["cols"]);
        let line =
            TABLE_2.lines().map(cells).find(|line| line[0] == points && line[1] == "cpu").unwrap();
        let megabytes = |name: &str| format!("{:.1}", 1e-6 * size[name].as_f64().unwrap());
        assert_eq!(megabytes("iteration_bytes"), line[3], "{points}; run ci/figures");
        assert_eq!(megabytes("converged_bytes"), line[6], "{points}; run ci/figures");
        let iterations = format!("({})", size["converged_iterations"]);
        assert!(
            line[5].ends_with(&iterations),
            "{points}: {iterations}, {}; run ci/figures",
            line[5]
        );
        compared += 1;
    }
    assert_eq!(compared, 2);
}

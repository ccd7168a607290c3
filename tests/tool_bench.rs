//! Schedules, devices and their speed as a user meets them.
#![cfg(feature = "cli")]

mod bench;

use bench::{Bench, json, stderr};

/// The tool with the words of a command line.
fn run(bench: &Bench, line: &str) -> std::process::Output {
    bench.run(line.split_whitespace())
}

#[test]
fn every_schedule_gives_the_same_map() {
    let bench = Bench::new();
    let map = |schedule: &str| {
        let line = format!(
            "distance builtin:maze:61x67 --source 0,0 --schedule {schedule} -o {schedule}.npy --json"
        );
        json(&run(&bench, &line))["schedule"].as_str().unwrap().to_owned()
    };
    for schedule in ["raster", "all-points", "tiles"] {
        assert_eq!(map(schedule), schedule);
    }
    assert!(["raster", "tiles"].contains(&map("auto").as_str()));
    // Tolerances are relative to the largest distance; each map stops at changes of 1e-6.
    for schedule in ["auto", "all-points", "tiles"] {
        let compared = run(&bench, &format!("compare {schedule}.npy raster.npy --tolerance 1e-5"));
        assert!(compared.status.success(), "{schedule}: {}", stderr(&compared));
    }
}

#[test]
fn a_schedule_is_for_vulkan_alone() {
    let bench = Bench::new();
    for engine in ["cpu", "fast-marching"] {
        let line = format!(
            "distance builtin:plane:9x9 -s 1,1 --engine {engine} --schedule tiles -o map.npy"
        );
        bench.refuses(&run(&bench, &line), &["--schedule", "--engine vulkan"]);
    }
    let wrong = "distance builtin:plane:9x9 -s 1,1 --schedule spiral -o map.npy";
    bench.refuses(&run(&bench, wrong), &["spiral", "all-points"]);
    let options = geosweep::Options {
        engine: geosweep::Engine::Cpu,
        schedule: Some(geosweep::vulkan::Schedule::Tiles),
        ..Default::default()
    };
    let surface = geosweep::surface::builtin::Builtin::Plane.surface(9, 9).unwrap();
    let source = geosweep::Sources::point(1.0, 1.0);
    let error = geosweep::distance_map(&surface, &source, &options).unwrap_err();
    assert!(error.to_string().contains("schedule"), "{error}");
}

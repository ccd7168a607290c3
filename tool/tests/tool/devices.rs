//! Schedules, devices and their speed, through the tool.

use crate::workbench::{Workbench, stderr};

#[test]
fn every_schedule_gives_the_same_map() {
    let bench = Workbench::new();
    let map = |schedule: &str| {
        let line = format!(
            "distance builtin:maze:61x67 --source 0,0 --engine vulkan --schedule {schedule} \
             -o {schedule}.npy --json"
        );
        bench.json(&line)["schedule"].as_str().unwrap().to_owned()
    };
    for schedule in ["raster", "tiles"] {
        assert_eq!(map(schedule), schedule);
    }
    assert!(["raster", "tiles"].contains(&map("auto").as_str()));
    // Tolerances are relative to the largest distance. Each map stops at changes of 1e-6.
    for schedule in ["auto", "tiles"] {
        let compared = bench.run(format!("compare {schedule}.npy raster.npy --tolerance 1e-5"));
        assert!(compared.status.success(), "{schedule}: {}", stderr(&compared));
    }
}

#[test]
fn a_schedule_is_for_vulkan_alone() {
    let bench = Workbench::new();
    for engine in ["cpu", "fast-marching"] {
        let line = format!(
            "distance builtin:plane:9x9 -s 1,1 --engine {engine} --schedule tiles -o map.npy"
        );
        bench.refuse(&line, &["--schedule", "--engine vulkan"]);
    }
    let wrong = "distance builtin:plane:9x9 -s 1,1 --schedule spiral -o map.npy";
    bench.refuse(wrong, &["spiral", "tiles"]);
    let options = geosweep::Options::default()
        .with_engine(geosweep::Engine::Cpu)
        .with_schedule(geosweep::vulkan::Schedule::Tiles);
    let surface = geosweep::surface::builtin::Builtin::Plane.surface(9, 9).unwrap();
    let source = geosweep::Sources::point(1.0, 1.0);
    let error = geosweep::distance_map(&surface, &source, &options).unwrap_err();
    assert!(error.to_string().contains("schedule"), "{error}");
}

#[test]
fn devices_tell_their_limits() {
    let bench = Workbench::new();
    let output = bench.run("devices --limits");
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    let devices = geosweep::vulkan::devices().unwrap();
    for device in &devices {
        assert!(text.contains(&format!("| device | {} |", device.name)), "{text}");
    }
    assert_eq!(text.matches("| shared memory | ").count(), devices.len(), "{text}");
}

#[test]
fn devices_are_measured() {
    let bench = Workbench::new();
    let measured = bench.json("devices --measure --json");
    let positive = |ceilings: &serde_json::Value, names: &[&str]| {
        for name in names {
            assert!(ceilings[name].as_f64().unwrap() > 0.0, "{name}: {ceilings}");
        }
        for wavefront in geosweep::Wavefront::FOR_ANY_SURFACE {
            let rate = ceilings["triangles"][wavefront.name()].as_f64().unwrap();
            assert!(rate > 0.0, "{wavefront}: {ceilings}");
        }
    };
    let usable: Vec<_> = measured["devices"]
        .as_array()
        .unwrap()
        .iter()
        .filter(|device| device["unmet"].as_array().unwrap().is_empty())
        .collect();
    assert!(!usable.is_empty());
    for device in usable {
        let times = ["dispatch", "indirect_dispatch", "skipped_dispatch", "barrier", "submission"];
        positive(&device["ceilings"], &[&times[..], &["copy", "read_back"]].concat());
    }
    let cpu = measured["cpu"].as_array().unwrap();
    assert_eq!(cpu[0]["threads"], 1);
    cpu.iter().for_each(|ceilings| positive(ceilings, &["copy"]));
    let text = bench.run("devices --measure");
    assert!(String::from_utf8_lossy(&text.stdout).contains("triangles a second"));
}

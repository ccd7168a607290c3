//! The tool through its command line: the files that it writes for given arguments, and its messages.

use std::process::Output;

use std::ffi::OsStr;
use std::fs;

use crate::workbench::{Workbench, json, notes, printed_json, stderr};
use geosweep::surface::builtin::Builtin;
use serde_json::Value;

#[test]
fn a_plane_has_straight_distances() {
    let bench = Workbench::new();
    let (rows, cols) = (21, 31);
    let surface = bench.flat(rows, cols);
    let output = bench.distance(&surface, "-s 4,5 --spacing 2,3 --json -o map.npy");
    let report = json(&output);
    assert_eq!(bench.outputs(), ["map.npy"]);
    let map = bench.map("map.npy");
    for (index, &distance) in map.iter().enumerate() {
        let (row, col) = ((index / cols) as f64, (index % cols) as f64);
        let exact = (3.0 * (row - 4.0)).hypot(2.0 * (col - 5.0));
        approx::assert_relative_eq!(distance, exact, max_relative = 1e-5);
    }
    assert_eq!(map[4 * cols + 5], 0.0);
    assert_eq!(report["engine"], "cpu");
    assert_eq!(report["device"], Value::Null);
    assert!(report["schedule"].is_string());
    assert_eq!(report["wavefront"], "anchored");
    assert_eq!(report["converged"], true);
    assert_eq!(report["iteration_bound"], 1);
    assert_eq!(report["points"], rows * cols);
    assert_eq!(report["reached"], rows * cols);
    assert!(report["iterations"].as_u64().unwrap() >= 1);
    assert!(report["residual"].as_f64().unwrap() <= 1e-6);
    assert!(report["solve_seconds"].as_f64().unwrap() > 0.0);
    let max = map.iter().copied().fold(0.0, f64::max);
    approx::assert_relative_eq!(report["max_distance"].as_f64().unwrap(), max, epsilon = 1e-6);
}

#[test]
fn maps_in_double_precision_are_written_whole() {
    let bench = Workbench::new();
    let exact = Builtin::Plane.exact_distances(30, 40, [3.0, 4.0]).unwrap();
    for file in ["map.npy", "map.tif"] {
        let words =
            format!("-s 3,4 --precision double --error e.npy --picture m.png --json -o {file}");
        let report = json(&bench.distance("builtin:plane:30x40", &words));
        assert_eq!((&report["precision"], &report["engine"]), (&"double".into(), &"cpu".into()));
        assert!(report["residual"].as_f64().unwrap() <= 1e-13);
        let found = bench.map(file);
        let largest = found.iter().copied().fold(0.0, f64::max);
        assert_eq!(report["max_distance"].as_f64().unwrap(), largest, "{file}");
        for (found, exact) in found.iter().zip(&exact) {
            approx::assert_relative_eq!(found, exact, max_relative = 1e-13);
        }
        assert!(bench.map("e.npy").iter().all(|&error| error < 1e-12), "{file}");
    }
    let single = json(&bench.distance("builtin:plane:30x40", "-s 3,4 --json -o map.npy"));
    assert_eq!(single["precision"], "single");
    let found = bench.map("map.npy");
    assert!(found.iter().zip(&exact).any(|(found, exact)| (found - exact).abs() > 1e-9));
    // A start value for which single precision has few digits left loses no digits.
    let output = bench.distance("builtin:plane:30x40", "-s 1,2,1e6 --precision double -o map.npy");
    assert!(output.status.success() && notes(&output).is_empty(), "{}", stderr(&output));
}

#[test]
fn start_values_have_digits_left_for_distances() {
    let bench = Workbench::new();
    for start in ["1e39", "-1e39", "1e30"] {
        let output = bench.distance("builtin:plane:30x40", &format!("-s 1,2,{start} -o map.npy"));
        bench.refuses(&output, &["initial value", "source 1,2", "5e29", "subtract the smallest"]);
    }
    let said = |words: &str| {
        let output = bench.distance("builtin:plane:30x40", &format!("{words} -o map.npy"));
        assert!(output.status.success(), "{}", stderr(&output));
        notes(&output)
    };
    let all = said("-s 1,2,1e8 -s 3,4,100000001");
    assert!(all.contains("note: distances beyond a start value of 100000001"), "{all}");
    assert!(all.contains("subtract the smallest, 100000000, from all"), "{all}");
    let one = said("-s 1,2 -s 3,4,1e8");
    assert!(one.contains("rounded") && !one.contains("subtract"), "{one}");
    // Points are a 39th apart, and 12.5 is rounded by 7e-7.
    assert_eq!(said("-s 1,2,12.5 -s 3,4"), "");
}

#[test]
fn engines_and_fronts_can_be_chosen() {
    let bench = Workbench::new();
    for (words, key, value) in [
        ("--engine fast-marching", "engine", "fast-marching"),
        ("--engine cpu --wavefront planar", "wavefront", "planar"),
        ("--engine cpu --wavefront point", "wavefront", "circular"),
    ] {
        let words = format!("distance builtin:sphere:33x33 -s 3,4 --json -o map.npy {words}");
        let report = bench.json(&words);
        assert_eq!(report[key], value, "{words}");
        let exact = Builtin::Sphere.exact_distances(33, 33, [3.0, 4.0]).unwrap();
        for (distance, exact) in bench.map("map.npy").iter().zip(exact) {
            assert!((distance - exact).abs() < 0.03, "{words}: {distance} {exact}");
        }
    }
}

#[test]
fn circular_fronts_for_several_sources_are_replaced_with_a_note() {
    let bench = Workbench::new();
    let words =
        "distance builtin:sphere:33x33 -s 3,4 -s 20,20 --json -o map.npy --wavefront circular";
    let output = bench.run(words);
    let said =
        "geosweep: note: solved with rays fronts, since circular ones are early where fronts meet";
    assert!(stderr(&output).contains(said), "{}", stderr(&output));
    assert_eq!(json(&output)["wavefront"], "rays");
}

/// Along chords, the length around a cylinder is too short by a 24th of the squared angle between points.
#[test]
fn edges_can_be_arcs_or_chords() {
    let bench = Workbench::new();
    let exact = Builtin::Cylinder.exact_distances(33, 33, [16.0, 16.0]).unwrap();
    let errors = ["", "--edges arc", "--edges chord"].map(|edges| {
        let words =
            format!("distance builtin:cylinder:33x33 -s 16,16 --engine cpu -o map.npy {edges}");
        assert!(bench.run(&words).status.success(), "{words}");
        let map = bench.map("map.npy");
        let errors = map.iter().zip(&exact).map(|(distance, exact)| distance - exact);
        errors.sum::<f64>() / exact.iter().sum::<f64>()
    });
    println!("{errors:?}");
    assert_eq!(errors[0], errors[1], "arcs are the default");
    assert!(errors[1].abs() < 0.1 * errors[2].abs() && errors[2] < -1e-4, "{errors:?}");
    let words = "distance builtin:plane:9x9 -s 1,1 -o map.npy --edges round";
    let wrong = bench.run(words);
    assert!(!wrong.status.success() && stderr(&wrong).contains("chord"), "{}", stderr(&wrong));
}

#[test]
fn holes_masks_and_walls_are_respected() {
    let bench = Workbench::new();
    // A wall from top to bottom, half of it NaN and half masked, and a masked point.
    let mut heights = vec![0.0; 6 * 9];
    let mut mask = vec![255u8; 6 * 9];
    for row in 0..6 {
        if row < 3 {
            heights[row * 9 + 5] = f64::NAN;
        } else {
            mask[row * 9 + 5] = 0;
        }
    }
    mask[9] = 0;
    let surface = bench.array("heights.npy", &[6, 9], &heights);
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, 9, 6);
    encoder.set_color(png::ColorType::Grayscale);
    encoder.write_header().unwrap().write_image_data(&mask).unwrap();
    let mask = bench.input("mask.png", bytes);
    let words = format!("-s 0,0 --mask {mask} --spacing 1 --json -o map.tif");
    let output = bench.distance(&surface, &words);
    let report = json(&output);
    assert_eq!((&report["points"], &report["reached"]), (&47.into(), &29.into()));
    assert!(report["iteration_bound"].is_null());
    assert!(
        stderr(&output).contains("47 points, 18 of them cannot be reached"),
        "{}",
        stderr(&output)
    );
    let map = bench.map("map.tif");
    for (index, distance) in map.iter().enumerate() {
        assert_eq!(distance.is_finite(), index % 9 < 5 && index != 9, "{index}");
    }
}

#[test]
fn slowness_and_metric_weigh_lengths() {
    let bench = Workbench::new();
    let surface = bench.flat(11, 11);
    let slowness = bench.array("slowness.npy", &[11, 11], &[2.5; 121]);
    let metric = bench.array("metric.npy", &[11, 11, 2, 2], &[9.0, 0.0, 0.0, 4.0].repeat(121));
    let (dr, dc) = (3.0, 7.0f64);
    for (surface, words, exact) in [
        (&surface, format!("--slowness {slowness}"), 2.5 * dc.hypot(dr)),
        (&surface, format!("--metric {metric}"), (2.0 * dc).hypot(3.0 * dr)),
        (&metric, String::new(), (2.0 * dc).hypot(3.0 * dr)),
    ] {
        let output = bench.distance(surface, &format!("-s 2,1 -o map.exr {words}"));
        assert!(output.status.success(), "{}", stderr(&output));
        let found = bench.map("map.exr")[5 * 11 + 8];
        approx::assert_relative_eq!(found, exact, max_relative = 1e-5);
    }
}

#[test]
fn a_missing_spacing_and_missing_convergence_are_reported() {
    let bench = Workbench::new();
    let output = bench.distance(&bench.flat(5, 5), "-s 0,0 -o map.npy");
    assert!(output.status.success() && output.stdout.is_empty());
    let stderr_text = stderr(&output);
    assert!(stderr_text.contains("geosweep: note:") && stderr_text.contains("--spacing"));

    // There is no warning if the user has limited the iterations.
    let output = bench.distance("builtin:maze:65x65", "-s 1,1 --iterations 1 --json -o map.npy");
    assert_eq!(json(&output)["converged"], false);
    assert_eq!(notes(&output), "");
    assert!(
        stderr(&output).contains("; not converged after 1 iteration in "),
        "{}",
        stderr(&output)
    );
}

#[test]
fn pictures_show_the_map_and_have_a_sensible_size() {
    let bench = Workbench::new();
    let words = "-s 3,0 -o map.npy --picture map.png";
    let hill = |i: usize| 8.0 * (-((i / 10) as f64 - 25.0).powi(2) / 50.0).exp();
    let hill = bench.array("hill.npy", &[51, 10], &(0..510).map(hill).collect::<Vec<_>>());
    // A single column is a strip that is still visible.
    for (surface, widths) in [(&*hill, 250..400), ("builtin:plane:30x1", 100..250)] {
        let output = bench.distance(surface, words);
        assert!(output.status.success(), "{}", stderr(&output));
        assert_eq!(bench.outputs(), ["map.npy", "map.png"]);
        let bytes = fs::read(bench.output("map.png")).unwrap();
        let mut reader = png::Decoder::new(std::io::Cursor::new(bytes)).read_info().unwrap();
        let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
        let info = reader.next_frame(&mut pixels).unwrap();
        assert!((800..2500).contains(&info.height), "{surface}: {info:?}");
        assert!(widths.contains(&info.width), "{surface}: {info:?}");
        // Both ends of the colour scale occur: dark violet at the source, yellow far away.
        let near = |color: [i32; 3]| {
            let distance = |p: &[u8]| (0..3).map(|k| (i32::from(p[k]) - color[k]).abs()).max();
            pixels.chunks(3).filter(|pixel| distance(pixel) < Some(12)).count()
        };
        assert!(near([68, 1, 84]) > 20 && near([253, 231, 37]) > 20, "{surface}");
    }
}

#[test]
fn a_map_is_written_only_on_request() {
    let bench = Workbench::new();
    let report = json(&bench.distance("builtin:plane:9x9", "-s 1,1 --json"));
    assert_eq!(report["reached"], 81);
    assert_eq!(bench.outputs(), [""; 0]);
    for (unit, picture) in [("", "bare.png"), ("--unit furlongs", "named.png")] {
        let words = format!("-s 1,1 --picture {picture} {unit}");
        let output = bench.distance("builtin:plane:9x9", &words);
        assert!(output.status.success(), "{}", stderr(&output));
    }
    assert_eq!(bench.outputs(), ["bare.png", "named.png"]);
    // The legend contains the unit's name, which makes it wider.
    let width = |name: &str| {
        let bytes = fs::read(bench.output(name)).unwrap();
        png::Decoder::new(std::io::Cursor::new(bytes)).read_info().unwrap().info().width
    };
    assert!(width("named.png") > width("bare.png"));
}

#[test]
fn compare_measures_and_its_status_tells() {
    let bench = Workbench::new();
    let inf = f64::INFINITY;
    let a = bench.array("a.npy", &[2, 3], &[0.0, 1.0, 2.0, 3.5, inf, inf]);
    let b = bench.array("b.npy", &[2, 3], &[0.0, 1.0, 2.0, 4.0, inf, 1.0]);
    let c = bench.array("c.npy", &[2, 3], &[0.0, 1.0, 2.0, 4.0, inf, inf]);
    let other = bench.array("other.npy", &[3, 2], &[0.0; 6]);

    let output = bench.run_args(["compare", &a, &b, "--json"]);
    assert_eq!(output.status.code(), Some(1));
    let found = printed_json(&output);
    let expected = serde_json::json!({
        "version": 1, "command": "compare",
        "max_difference": 0.125, "mean_difference": 0.125 / 4.0, "at": [1, 0], "scale": 4.0,
        "compared": 4, "only_in_a": 0, "only_in_b": 1, "equal": false,
    });
    assert_eq!(found, expected);

    for (words, status) in [
        (vec!["compare", &*a, &*c], 1),
        (vec!["compare", &a, &c, "--tolerance", "0.125"], 0),
        (vec!["compare", &a, &b, "--tolerance", "0.125"], 1),
        (vec!["compare", &b, &b, "--tolerance", "0"], 0),
    ] {
        let output = bench.run_args(&words);
        assert_eq!(output.status.code(), Some(status), "{words:?}: {}", stderr(&output));
        assert!(!output.stdout.is_empty());
    }
    bench.refuses(&bench.run_args(["compare", &a, &other]), &["2 x 3", "3 x 2"]);
    bench.refuses(&bench.run_args(["compare", &a, "missing.npy"]), &["missing.npy"]);
    for (name, value) in [("nan.npy", f64::NAN), ("below.npy", -inf)] {
        let wrong = bench.array(name, &[2, 3], &[0.0, 1.0, 2.0, 4.0, value, inf]);
        for pair in [[&wrong, &a], [&a, &wrong], [&wrong, &wrong]] {
            let output = bench.run_args(["compare"].into_iter().chain(pair.map(|name| &**name)));
            bench.refuses(&output, &[name, "row 1, column 1", "+infinity"]);
        }
    }
    // There is no scale, since no point is reached or all distances are 0.
    let none = bench.array("none.npy", &[2, 3], &[inf; 6]);
    let zero = bench.array("zero.npy", &[2, 3], &[0.0; 6]);
    for (pair, status, part) in [
        ([&none, &none], 0, "equal: neither map reaches any point"),
        ([&none, &zero], 1, "no point is finite in both"),
        ([&zero, &none], 1, "in A: 6, in B: 0"),
        ([&zero, &zero], 0, "over 6 points"),
        ([&a, &zero], 1, "3.500e0 (at row 1, column 0)"),
    ] {
        let output = bench.run_args(["compare"].into_iter().chain(pair.map(|name| &**name)));
        let text = String::from_utf8(output.stdout).unwrap();
        assert_eq!(output.status.code(), Some(status), "{text}");
        assert!(text.contains(part) && !text.contains(" of "), "{text}");
    }
    let found = json(&bench.run_args(["compare", &none, &none, "--json"]));
    assert_eq!((&found["at"], &found["scale"]), (&Value::Null, &Value::Null));
    bench.refuses(&bench.run_args(["compare", &a, &b, "--tolerance", "nan"]), &["tolerance"]);
}

#[test]
fn builtin_surfaces_become_files_that_are_surfaces() {
    let bench = Workbench::new();
    let output = bench.run_args(["builtin", "maze:65x65", "-o", "maze.npy"]);
    assert!(output.status.success(), "{}", stderr(&output));
    let words = ["-s 1,1 --json -o from-file.npy", "-s 1,1 --json -o from-name.npy"];
    let from_file = json(&bench.distance("maze.npy", words[0]));
    let from_name = json(&bench.distance("builtin:maze:65x65", words[1]));
    assert!(from_file["points"].as_u64().unwrap() < 65 * 65);
    assert_eq!(from_file["points"], from_name["points"]);
    assert_eq!(bench.map("from-file.npy"), bench.map("from-name.npy"));
}

#[test]
fn builtin_refuses_other_formats_and_sizes() {
    let bench = Workbench::new();
    for (words, part) in [
        ("builtin plane:5x5 -o plane.obj", ".npy"),
        ("builtin plane:0x5 -o plane.npy", "empty"),
        ("builtin plane:65536x65536 -o plane.npy", "too large"),
        ("builtin plane -o plane.npy", "ROWSxCOLS"),
    ] {
        bench.refuse(words, &[part]);
    }
    bench.refuse("sing", &["sing"]);
}

/// Runs `geosweep distance` with an engine and one variable of the environment changed.
fn with_environment(
    bench: &Workbench,
    surface: &str,
    engine: &str,
    variable: (&str, &OsStr),
) -> Output {
    bench
        .command()
        .args(["distance", surface, "--source", "0,0", "-o", "map.npy"])
        .args(["--engine", engine, "--json"])
        .env(variable.0, variable.1)
        .env("GEOSWEEP_PIPELINES", bench.inputs.path())
        // The older name of the same variable would take precedence if it is set.
        .env_remove("VK_ICD_FILENAMES")
        .output()
        .unwrap()
}

/// A surface large enough for a GPU whose pipelines are kept.
const LARGE: &str = "builtin:plane:4096x4096";

#[test]
fn without_a_driver_vulkan_is_refused_and_auto_is_the_cpu_and_says_why() {
    let bench = Workbench::new();
    let no_driver = ("VK_DRIVER_FILES", OsStr::new("/nonexistent"));
    let refused = with_environment(&bench, LARGE, "vulkan", no_driver);
    bench.refuses(&refused, &["driver", "CPU engine"]);
    let summary = json(&with_environment(&bench, LARGE, "auto", no_driver));
    assert_eq!((&summary["engine"], &summary["fallback"]), (&"cpu".into(), &Value::Null));
    let reason = summary["reason"].as_str().unwrap();
    assert!(reason.contains("no GPU") && reason.contains("driver"), "{summary}");
    assert_eq!(bench.outputs(), ["map.npy"]);
}

/// A file in the loader's place that is not a library stands for a machine without one.
#[test]
#[cfg(target_os = "linux")]
fn without_a_loader_vulkan_is_refused_and_auto_is_the_cpu_and_says_why() {
    let bench = Workbench::new();
    bench.input("libvulkan.so.1", "no library");
    let no_loader = ("LD_LIBRARY_PATH", bench.inputs.path().as_os_str());
    bench.refuses(&with_environment(&bench, LARGE, "gpu", no_loader), &["no Vulkan loader"]);
    let summary = json(&with_environment(&bench, LARGE, "auto", no_loader));
    assert_eq!((&summary["engine"], &summary["fallback"]), (&"cpu".into(), &Value::Null));
    assert!(summary["reason"].as_str().unwrap().contains("loader"), "{summary}");
}

/// Lavapipe uses the same cores less directly. The drivers' variable stays unchanged here, so that a machine
/// with a GPU uses it.
#[test]
fn auto_takes_no_vulkan_device_that_is_a_cpu() {
    let bench = Workbench::new();
    let kinds = |name: &str| {
        let listed = json(&bench.run_args(["devices", "--json"]));
        let of = listed["devices"].as_array().unwrap().iter().find(|device| device["name"] == name);
        of.unwrap()["kind"].as_str().unwrap().to_owned()
    };
    let mut large = bench.command();
    large.args(["distance", LARGE, "-s", "0,0", "--json"]);
    large.env("GEOSWEEP_PIPELINES", bench.inputs.path());
    let report = json(&large.output().unwrap());
    match report["device"].as_str() {
        Some(device) => assert_ne!(kinds(device), "CPU"),
        None => assert!(report["reason"].as_str().unwrap().contains("is a CPU"), "{report}"),
    }
    // A small map does not use Vulkan, whatever devices there are.
    let report = bench.json("distance builtin:plane:33x33 -s 0,0 --json");
    assert_eq!(report["engine"], "cpu");
    assert!(report["reason"].as_str().unwrap().contains("1089 points"), "{report}");
    // If the engine is named, it is used.
    let report = bench.json("distance builtin:plane:33x33 -s 0,0 --engine gpu --json");
    assert_eq!((&report["engine"], &report["reason"]), (&"vulkan".into(), &Value::Null));
}

#[test]
fn devices_are_listed_and_unknown_ones_refused() {
    let bench = Workbench::new();
    let listed: Value = json(&bench.run_args(["devices", "--json"]));
    let name = listed["devices"][0]["name"].as_str().unwrap();
    let surface = bench.flat(5, 5);
    let distance = |device: &str| {
        let args = ["distance", &surface, "--spacing", "1", "--source", "1,1", "-o", "map.npy"];
        bench.run_args(args.into_iter().chain(["--engine", "vulkan", "--device", device]))
    };
    bench.refuses(&distance("no such device"), &["no such device", name]);
    bench.refuses(&distance("99"), &["99", name]);
    assert!(distance(name).status.success());
}

/// One line at the end names what was computed and on what, how it ended, and which files were written.
#[test]
fn a_line_says_what_was_done() {
    let bench = Workbench::new();
    let output = bench.distance("builtin:sphere:33x33", "-s 3,4 -o map.npy --picture map.png");
    assert!(output.status.success() && output.stdout.is_empty());
    let said = stderr(&output);
    assert_eq!(said.lines().count(), 1, "{said}");
    for part in [
        "geosweep: done: CPU; 1089 points, all reached; converged after ",
        " iterations in ",
        "; largest distance 1.",
        "; wrote map.npy, map.png\n",
    ] {
        assert!(said.contains(part), "`{part}` is missing in: {said}");
    }
    let words = "-s 3,4 --engine fast-marching --json";
    let said = stderr(&bench.run(format!("distance builtin:sphere:33x33 {words}")));
    assert!(said.contains("done: fast marching; ") && said.contains("; one pass in "), "{said}");
    // Travel times are not distances.
    let slow = bench.array("slow.npy", &[5, 5], &[2.0; 25]);
    let words = format!("-s 0,0 --spacing 1 --slowness {slow} --json");
    let said = stderr(&bench.distance(&bench.flat(5, 5), &words));
    assert!(said.contains("; largest travel time 11.3"), "{said}");
    for quiet in ["-q", "--quiet"] {
        let output = bench.distance("builtin:sphere:33x33", &format!("-s 3,4 --json {quiet}"));
        assert!(output.status.success() && output.stderr.is_empty(), "{}", stderr(&output));
    }
    // Necessary warnings are printed in any case.
    let output = bench.distance(&bench.tube(), "-s 3,4 --json -q");
    assert!(stderr(&output).contains("geosweep: warning: "), "{}", stderr(&output));
}

#[test]
fn without_arguments_there_is_help_and_no_error() {
    let bench = Workbench::new();
    let output = bench.run("");
    let help = String::from_utf8(output.stdout.clone()).unwrap();
    assert!(output.status.success() && stderr(&output).is_empty(), "{}", stderr(&output));
    assert!(help.contains("Usage: geosweep") && !help.contains("error:"), "{help}");
}

//! Profiles through the tool.

use std::collections::BTreeMap;
use std::process::Output;

use crate::workbench::{Workbench, json, stderr};
use serde_json::Value;

/// Runs the tool with the words of a command line, under the validation layers, whose messages are errors.
fn run(bench: &Workbench, line: &str) -> Output {
    let words = line.split_whitespace();
    bench.command().env("GEOSWEEP_VALIDATION", "1").args(words).output().unwrap()
}

fn numbers(value: &Value) -> Vec<f64> {
    value.as_array().unwrap().iter().map(|number| number.as_f64().unwrap()).collect()
}

fn sum(kinds: &[&Value], name: &str) -> u64 {
    kinds.iter().map(|kind| kind[name].as_u64().unwrap_or_else(|| panic!("{name}: {kind}"))).sum()
}

/// The grid has 31 x 25 texels. The library's tests hold the work of each pass against the plan.
#[test]
fn a_profile_sums_the_passes_of_each_kind() {
    let bench = Workbench::new();
    for (schedule, grain, kind, count) in [
        ("raster", "scans", "scan ", 4),
        ("raster", "blocks", "scan ", 4),
        ("raster", "iterations", "iteration", 1),
        ("raster", "portions", "portion", 1),
        ("tiles", "scans", "tiles", 1),
    ] {
        let line = format!(
            "profile builtin:sphere:61x50 --source 30,20 --wavefront planar --schedule {schedule} \
             --repeat 3 --json --grain {grain}"
        );
        let report = json(&run(&bench, &line));
        assert_eq!((&report["rows"], &report["cols"]), (&61.into(), &50.into()));
        assert_eq!((&report["schedule"], &report["runs"]), (&schedule.into(), &3.into()));
        assert_eq!(report["converged"], true);
        let kinds = report["kinds"].as_array().unwrap();
        let visiting: Vec<_> = kinds.iter().filter(|kind| kind["texels"].is_u64()).collect();
        let is_meant = |found: &&Value| found["name"].as_str().unwrap().starts_with(kind);
        let meant: Vec<_> = visiting.iter().copied().filter(is_meant).collect();
        assert_eq!(meant.len(), count, "{grain}");
        let (visited, skipped) = (sum(&visiting, "texels"), sum(&visiting, "skipped"));
        if schedule == "raster" {
            assert_eq!((visited + skipped) % (31 * 25), 0);
            assert_eq!(sum(&meant, "triangles"), visited * 8);
            assert!(sum(&meant, "bytes_read") >= visited * 80, "{grain}");
        } else {
            // Rounds of 4 x 4 tiles of 8 x 8 texels.
            assert_eq!((visited % 64, (visited + skipped) % (16 * 64)), (0, 0));
            assert!(meant[0]["triangles"].is_null(), "the device does not tell: {report}");
        }
        times_fit(&report);
    }
    assert_eq!(bench.outputs(), [""; 0]);
}

/// A batch has room for the maps of all points of a small grid.
#[test]
fn maps_of_many_sources_are_profiled_at_once() {
    let bench = Workbench::new();
    let line = "profile builtin:sphere:20x30 --wavefront circular --repeat 2 --json";
    for (more, part) in [("--source 1,1", "--source"), ("--picture a.png", "--picture")] {
        bench.refuses(&run(&bench, &format!("{line} --pairwise {more}")), &[part, "--pairwise"]);
    }
    for (place, schedule, kind) in
        [("", "pairwise shared memory", "workgroups"), ("=images", "pairwise images", "scan left")]
    {
        let output = run(&bench, &format!("{line} --pairwise{place} --trace trace.json"));
        let report = json(&output);
        assert_eq!((&report["maps"], &report["schedule"]), (&600.into(), &schedule.into()));
        assert_eq!(report["converged"], true);
        let kinds = report["kinds"].as_array().unwrap();
        let found = kinds.iter().find(|found| found["name"] == kind).unwrap();
        assert!(found["triangles"].as_u64().unwrap() > 600 * 600, "{found}");
        assert_eq!(found["texels"].is_u64(), schedule.ends_with("images"), "{found}");
        times_fit(&report);
        let tracks = tracks(&std::fs::read_to_string(bench.output("trace.json")).unwrap());
        let device = tracks.iter().find(|(name, _)| name.starts_with("device: ")).unwrap().1;
        assert_eq!(depths(device).len(), device.len());
        assert!(device.iter().any(|event| event.name == kind));
    }
}

/// Asserts that the times of the kinds add up to those of the passes, run by run, and that these are within
/// the times of the command buffers.
fn times_fit(report: &Value) {
    let kinds = report["kinds"].as_array().unwrap();
    for (number, passes) in numbers(&report["total"]["passes"]).into_iter().enumerate() {
        let of_kinds: f64 = kinds.iter().map(|kind| numbers(&kind["seconds"])[number]).sum();
        approx::assert_relative_eq!(of_kinds, passes, max_relative = 1e-9);
        assert!(passes > 0.0);
    }
    let share = report["total"]["share_of_command_buffers"].as_f64().unwrap();
    assert!(share > 0.0 && share <= 1.0, "{share}");
    for kind in kinds {
        for share in ["data", "arithmetic", "dispatches"] {
            let share = &kind["shares"][share];
            assert!(share.is_null() || share.as_f64().unwrap() > 0.0, "{kind}");
        }
    }
}

#[test]
fn the_table_says_what_is_missing() {
    let bench = Workbench::new();
    let line =
        "profile builtin:plane:30x30 --source 1,1 --schedule raster --repeat 2 --grain scans";
    let text = |more: &str| {
        let output = run(&bench, &format!("{line} {more}"));
        assert!(output.status.success(), "{}", stderr(&output));
        String::from_utf8(output.stdout).unwrap()
    };
    let all = text("");
    for part in ["scan down", "M texels/s", "On the device: passes", "without profiling in"] {
        assert!(all.contains(part), "{part}: {all}");
    }
    let none = text("--without timestamps,statistics,executables,calibration,labels");
    assert_eq!(none.matches("not available on this device (left out as asked)").count(), 5);
    assert!(none.contains("scan down") && !none.contains("On the device: passes"), "{none}");
    let report = json(&run(&bench, &format!("{line} --json --without timestamps")));
    let reason = "not available on this device (left out as asked)";
    assert_eq!(report["capabilities"]["timestamps"], reason);
    assert_eq!(numbers(&report["total"]["passes"]), [0.0; 0]);
    assert!(report["kinds"].as_array().unwrap().iter().all(|kind| kind["share"].is_null()));
}

/// A complete event of a trace, with times in nanoseconds.
#[derive(Clone, Debug)]
struct Event {
    name: String,
    category: String,
    begin: i64,
    end: i64,
    args: Value,
}

/// Returns the tracks of a trace by their names, with the events in the order of the file. Checks the Trace
/// Event Format: an object with `traceEvents`, whose metadata events name the tracks. Complete events have a
/// name, a category, a process and a thread that have been named, and times in microseconds.
///
/// Reads as Perfetto's trace processor does (`src/trace_processor/importers/json` of its sources): processes
/// and threads are 32-bit numbers, only metadata has no time, times are truncated to whole nanoseconds and
/// not negative, no event has an array next to its own values, and details are numbers.
fn tracks(text: &str) -> BTreeMap<String, Vec<Event>> {
    let trace: Value = serde_json::from_str(text).unwrap();
    assert!(["ns", "ms"].contains(&trace["displayTimeUnit"].as_str().unwrap()));
    let mut names = BTreeMap::new();
    let mut tracks: BTreeMap<String, Vec<Event>> = BTreeMap::new();
    for event in trace["traceEvents"].as_array().unwrap() {
        let text = |name: &str| event[name].as_str().unwrap_or_else(|| panic!("{event}"));
        let number =
            |name: &str| event[name].as_u64().and_then(|number| u32::try_from(number).ok());
        let process = number("pid").unwrap();
        assert!(event.as_object().unwrap().values().all(|value| !value.is_array()), "{event}");
        match text("ph") {
            "M" => {
                let name = event["args"]["name"].as_str().unwrap().to_owned();
                match text("name") {
                    "process_name" => assert!(event["tid"].is_null()),
                    "thread_name" => {
                        let thread = number("tid").unwrap();
                        assert!(names.insert((process, thread), name).is_none(), "{event}");
                    }
                    other => panic!("{other}: {event}"),
                }
            }
            "X" => {
                let time = |name: &str| {
                    let microseconds = event[name].as_f64().unwrap_or_else(|| panic!("{event}"));
                    (microseconds * 1000.0) as i64
                };
                let (begin, taken) = (time("ts"), time("dur"));
                assert!(begin >= 0 && taken >= 0, "{event}");
                let details = event["args"].as_object().unwrap();
                assert!(details.values().all(Value::is_u64), "{event}");
                let track = &names[&(process, number("tid").unwrap())];
                let (name, category) = (text("name").to_owned(), text("cat").to_owned());
                let args = event["args"].clone();
                let end = begin + taken;
                let event = Event { name, category, begin, end, args };
                tracks.entry(track.clone()).or_default().push(event);
            }
            other => panic!("{other}: {event}"),
        }
    }
    tracks
}

/// Returns the depth of each event of a track. Asserts that events are in the order of their beginnings, and
/// that each lies inside or after those before it, to the nanosecond.
fn depths(events: &[Event]) -> Vec<usize> {
    let mut open: Vec<&Event> = Vec::new();
    let mut last = i64::MIN;
    let depth = |event| {
        let event: &Event = event;
        assert!(event.begin >= last, "{event:?} begins before {last}");
        last = event.begin;
        while open.last().is_some_and(|outer| outer.end <= event.begin) {
            open.pop();
        }
        if let Some(outer) = open.last() {
            assert!(event.end <= outer.end, "{event:?} leaves {outer:?}");
        }
        open.push(event);
        open.len()
    };
    events.iter().map(depth).collect()
}

#[test]
fn a_trace_is_one_of_the_chrome_format() {
    let bench = Workbench::new();
    let line = "profile builtin:maze:80x70 --source 0,0 --repeat 3";
    for (more, with_device, placed) in [
        ("--grain scans", true, "timestamps"),
        ("--grain scans --schedule tiles", true, "timestamps"),
        ("--schedule raster --grain blocks", true, "timestamps"),
        ("--schedule raster --grain iterations", true, "timestamps"),
        ("--grain scans --without calibration", true, "no calibrated"),
        ("--without timestamps", false, "no timestamps"),
    ] {
        let output = run(&bench, &format!("{line} {more} --trace trace.json --csv passes.csv"));
        assert!(output.status.success(), "{}", stderr(&output));
        let text = std::fs::read_to_string(bench.output("trace.json")).unwrap();
        let tracks = tracks(&text);
        assert!(text.contains(placed), "{more}");
        let host = &tracks["host: submissions"];
        assert!(depths(host).iter().all(|&depth| depth == 1), "{host:?}");
        let device = tracks.iter().find(|(name, _)| name.starts_with("device: "));
        assert_eq!(device.is_some(), with_device, "{more}");
        let mut csv = csv_lines(&std::fs::read_to_string(bench.output("passes.csv")).unwrap());
        if let Some((_, device)) = device {
            let depths = depths(device);
            for (event, depth) in device.iter().zip(depths) {
                let outermost = event.category == "submission";
                assert_eq!(depth == 1, outermost, "{event:?}");
                assert!(event.category != "iteration" || depth == 2, "{event:?}");
                assert!(event.category != "pass" || depth >= 2, "{event:?}");
            }
            let of = |category: &'static str| device.iter().filter(move |e| e.category == category);
            assert_eq!(of("submission").count(), host.len());
            assert!(of("iteration").any(|event| event.name == "iteration 1"));
            // The table has the same passes with the same numbers.
            for (event, line) in of("pass").zip(csv.drain(..)) {
                assert_eq!(event.name, line["pass"]);
                assert_eq!((event.end - event.begin).to_string(), line["nanoseconds"]);
                let texels = event.args["texels"].as_u64();
                assert_eq!(texels.map_or(String::new(), |n| n.to_string()), line["texels"]);
            }
        } else {
            assert!(csv.iter().all(|line| line["nanoseconds"].is_empty()));
            assert!(csv.iter().any(|line| !line["texels"].is_empty()));
        }
    }
}

/// Returns the lines of a table by the names of its columns.
fn csv_lines(text: &str) -> Vec<BTreeMap<String, String>> {
    let mut lines = text.lines().map(|line| line.split(',').map(str::to_owned));
    let heads: Vec<String> = lines.next().unwrap().collect();
    lines.map(|cells| heads.iter().cloned().zip(cells).collect()).collect()
}

/// [`depths`] refuses a trace whose events do not nest.
#[test]
#[should_panic(expected = "leaves")]
fn a_trace_that_does_not_nest_is_refused() {
    let event = |begin, end| Event {
        name: String::new(),
        category: String::new(),
        begin,
        end,
        args: Value::Null,
    };
    depths(&[event(0, 2), event(1, 3)]);
}

/// The picture has the colours of texels that are visited now, that were visited before, and that were not.
#[test]
fn a_picture_shows_what_is_visited() {
    let bench = Workbench::new();
    for (schedule, colors) in [
        ("tiles", [[219, 107, 46], [168, 204, 224], [204, 204, 207]]),
        ("raster", [[68, 1, 84], [253, 231, 37], [204, 204, 207]]),
    ] {
        let line = format!(
            "profile builtin:plane:120x90 --source 10,10 --schedule {schedule} --repeat 1 \
             --picture visits.png"
        );
        let output = run(&bench, &line);
        assert!(output.status.success(), "{}", stderr(&output));
        let file =
            std::io::BufReader::new(std::fs::File::open(bench.output("visits.png")).unwrap());
        let mut reader = png::Decoder::new(file).read_info().unwrap();
        let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
        reader.next_frame(&mut pixels).unwrap();
        for color in colors {
            let near = |pixel: &[u8]| {
                pixel
                    .iter()
                    .zip(color)
                    .all(|(&found, wanted)| i32::abs_diff(found.into(), wanted) < 3)
            };
            let count = pixels.chunks(3).filter(|pixel| near(pixel)).count();
            assert!(count > 500, "{schedule}, {color:?}: {count}");
        }
    }
    assert_eq!(bench.outputs(), ["visits.png"]);
}

/// Returns the report of a profile with the times of all runs multiplied by `by`.
fn scaled(report: &Value, by: f64) -> String {
    let mut report = report.clone();
    let scale = |seconds: &mut Value| {
        let scaled: Vec<f64> = numbers(seconds).into_iter().map(|one| by * one).collect();
        *seconds = scaled.into();
    };
    for kind in report["kinds"].as_array_mut().unwrap() {
        scale(&mut kind["seconds"]);
    }
    scale(&mut report["total"]["passes"]);
    scale(&mut report["total"]["host"]);
    report.to_string()
}

#[test]
fn slower_passes_are_distinguished_from_noise() {
    let bench = Workbench::new();
    let line = "profile builtin:sphere:40x40 --source 5,5 --repeat 4";
    let report = json(&run(&bench, &format!("{line} --json")));
    // Factors of a thousandth and a thousand are beyond any noise.
    for (by, verdict) in [(1e-3, "slower"), (1e3, "faster")] {
        let earlier = bench.input("earlier.json", scaled(&report, by));
        let now = json(&run(&bench, &format!("{line} --json --against {earlier}")));
        let against = &now["against"];
        assert_eq!(against["differences"], Value::Array(Vec::new()));
        for change in against["changes"].as_array().unwrap() {
            if change["now_seconds"].as_f64().is_some_and(|seconds| seconds > 0.0) {
                assert_eq!(change["verdict"], verdict, "{change}");
                let (before, now) = (&change["before_seconds"], &change["now_seconds"]);
                let ratio = now.as_f64().unwrap() / before.as_f64().unwrap();
                let found = change["change"].as_f64().unwrap();
                approx::assert_relative_eq!(found, ratio - 1.0, max_relative = 1e-9);
            }
        }
    }
    // A single run has no noise to compare with, and another size cannot be compared.
    let earlier = bench.input("earlier.json", report.to_string());
    let other = "profile builtin:sphere:30x40 --source 5,5 --repeat 1";
    let output = run(&bench, &format!("{other} --against {earlier}"));
    let text = String::from_utf8_lossy(&output.stdout);
    assert!(
        text.contains("The profiles differ: 40 x 40 points before, 30 x 40 points now"),
        "{text}"
    );
    assert!(text.contains("one run: noise unknown"), "{text}");
}

#[test]
fn unsupported_profiles_are_refused() {
    let bench = Workbench::new();
    let nonsense = bench.input("nonsense.json", "{\"rows\": 3}");
    for (words, parts) in [
        ("--engine cpu", vec!["Vulkan", "geosweep-lab bench"]),
        ("--renderdoc", vec!["RenderDoc is not loaded", "renderdoccmd"]),
        ("--repeat 0", vec!["--repeat", "0"]),
        ("--trace trace.txt", vec!["trace.txt", ".json"]),
        ("--csv passes.tsv", vec!["passes.tsv", ".csv"]),
        ("--picture visits.jpg", vec!["visits.jpg", ".png"]),
        ("--without clocks", vec!["clocks", "timestamps"]),
        ("--against nowhere.json", vec!["nowhere.json"]),
        ("--device nonesuch", vec!["nonesuch", "available"]),
        (&format!("--against {nonsense}"), vec!["nonsense.json", "not a profile"]),
    ] {
        let line = format!("profile builtin:plane:9x9 --source 1,1 {words}");
        bench.refuses(&run(&bench, &line), &parts);
    }
    let same = "profile builtin:plane:9x9 --source 1,1 --against a.json --trace a.json";
    std::fs::write(bench.output("a.json"), "{}").unwrap();
    let output = run(&bench, same);
    assert!(stderr(&output).contains("a.json is also an input"), "{}", stderr(&output));
}

/// A library takes RenderDoc's place, loaded into the tool before it starts.
#[cfg(target_os = "linux")]
#[test]
fn renderdoc_captures_one_map() {
    const LIBRARY: &str = r#"
        use std::ffi::c_void;
        use std::sync::atomic::{AtomicU32, Ordering::SeqCst};
        static STARTED: AtomicU32 = AtomicU32::new(0);
        static ENDED: AtomicU32 = AtomicU32::new(0);
        static PATH: &[u8] = b"/captures/one.rdc\0";
        extern "C" fn nothing() {}
        extern "C" fn start(_: *const c_void, _: *const c_void) { STARTED.fetch_add(1, SeqCst); }
        extern "C" fn end(_: *const c_void, _: *const c_void) -> u32 { ENDED.fetch_add(1, SeqCst); 1 }
        extern "C" fn count() -> u32 { STARTED.load(SeqCst).min(ENDED.load(SeqCst)) }
        extern "C" fn capture(index: u32, path: *mut u8, length: *mut u32, time: *mut u64) -> u32 {
            if index != 0 { return 0; }
            unsafe {
                if !length.is_null() { *length = PATH.len() as u32; }
                if !time.is_null() { *time = 1; }
                if !path.is_null() { path.copy_from(PATH.as_ptr(), PATH.len()); }
            }
            1
        }
        #[unsafe(no_mangle)]
        pub extern "C" fn RENDERDOC_GetAPI(_: i32, out: *mut *const c_void) -> i32 {
            // The members of RENDERDOC_API_1_0_0 in the order of renderdoc_app.h.
            let mut table = [nothing as *const c_void; 32];
            table[13] = count as *const c_void;
            table[14] = capture as *const c_void;
            table[19] = start as *const c_void;
            table[21] = end as *const c_void;
            unsafe { *out = Box::leak(Box::new(table)).as_ptr().cast() };
            1
        }"#;
    let bench = Workbench::new();
    let source = bench.input("renderdoc.rs", LIBRARY);
    let library = bench.inputs.path().join("librenderdoc.so");
    let compiler = std::env::var("RUSTC").unwrap_or_else(|_| "rustc".into());
    let built = std::process::Command::new(compiler)
        .args(["--edition", "2024", "--crate-type", "cdylib", &source, "-o"])
        .arg(&library)
        .args(["-C", "link-arg=-Wl,-soname,librenderdoc.so"])
        .output()
        .unwrap();
    assert!(built.status.success(), "{}", String::from_utf8_lossy(&built.stderr));
    let line = "profile builtin:plane:20x20 --source 1,1 --repeat 1 --renderdoc";
    let output =
        bench.command().env("LD_PRELOAD", &library).args(line.split_whitespace()).output().unwrap();
    assert!(output.status.success(), "{}", stderr(&output));
    let said = stderr(&output);
    assert!(said.contains("RenderDoc has captured a map: /captures/one.rdc"), "{said}");
}

//! `geosweep pairwise`: matrices as files, in whole and in part, interrupted and resumed.

use std::fs;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use crate::workbench::{Workbench, json, stderr};
use assert_cmd::cargo::cargo_bin;
use geosweep::io::{read_map, read_matrix};

/// 12 x 15 points of a sphere.
const SPHERE: &str = "builtin:sphere:12x15";
const POINTS: usize = 12 * 15;

#[test]
fn the_matrix_holds_the_maps_of_all_points() {
    let bench = Workbench::new();
    for wavefront in ["planar", "circular", "curved"] {
        let line = format!("pairwise {SPHERE} -o d.npy --wavefront {wavefront} --json");
        let report = bench.json(&line);
        assert_eq!(bench.outputs(), ["d.npy"]);
        assert_eq!((&report["matrix_rows"], &report["points"]), (&POINTS.into(), &POINTS.into()));
        assert_eq!((&report["engine"], &report["converged"]), (&"cpu".into(), &true.into()));
        assert_eq!(report["wavefront"], wavefront);
        assert_eq!(report["disk_bytes"], fs::metadata(bench.output("d.npy")).unwrap().len());
        let seconds = report["solve_seconds"].as_f64().unwrap();
        let rate = report["distances_per_second"].as_f64().unwrap();
        approx::assert_relative_eq!(rate * seconds, (POINTS * POINTS) as f64, max_relative = 1e-6);

        let matrix = read_map(&bench.output("d.npy")).unwrap();
        let line = format!("-s 3,4 --wavefront {wavefront} -o map.npy");
        assert!(bench.distance(SPHERE, &line).status.success());
        let map = read_map(&bench.output("map.npy")).unwrap().values;
        let row = &matrix.values[(3 * 15 + 4) * POINTS..][..POINTS];
        for (found, expected) in row.iter().zip(&map) {
            approx::assert_relative_eq!(found, expected, max_relative = 2e-5);
        }
        fs::remove_file(bench.output("map.npy")).unwrap();
    }
}

#[test]
fn the_solver_is_timed_alone() {
    let bench = Workbench::new();
    let report = bench.json(format!("pairwise {SPHERE} --json"));
    assert_eq!((&report["matrix_rows"], &report["disk_bytes"]), (&POINTS.into(), &0.into()));
    assert_eq!(bench.outputs(), [""; 0]);
    bench.refuse(format!("pairwise {SPHERE}"), &["--output"]);
    bench.refuse(format!("pairwise {SPHERE} --json --resume"), &["--output"]);
}

#[test]
fn rows_triangles_halves_and_means_fit_together() {
    let bench = Workbench::new();
    let run = |options: &str| {
        let line = format!("pairwise {SPHERE} --wavefront circular {options}");
        let output = bench.run(&line);
        assert!(output.status.success(), "{}", stderr(&output));
        assert!(stderr(&output).contains("on disk"), "{}", stderr(&output));
    };
    let read = |name: &str| read_matrix(&bench.output(name)).unwrap().distances;
    run("-o whole.npy");
    let whole = read("whole.npy");

    run("--sources 20..50 -o range.npy");
    let range = read_map(&bench.output("range.npy")).unwrap();
    assert_eq!((range.rows, range.cols), (30, POINTS));
    let same = range.values.iter().zip(&whole[20 * POINTS..]).all(|(a, b)| *a == f64::from(*b));
    assert!(same, "a range of rows is, to the bit, that of the matrix");

    let listed = bench.input("sources.csv", "row,col\n11,14\n0,0\n3,4\n");
    run(&format!("--sources {listed} -o listed.npy"));
    let places = [[11.0, 14.0], [0.0, 0.0], [3.0, 4.0]];
    let listed = bench.array("sources.npy", &[3, 2], places.as_flattened());
    run(&format!("--sources {listed} -o placed.npy"));
    let numbers = bench.array("numbers.npy", &[3], &[179.0, 0.0, 49.0]);
    run(&format!("--sources {numbers} -o numbered.npy"));
    let [listed, placed, numbered] = ["listed.npy", "placed.npy", "numbered.npy"]
        .map(|name| read_map(&bench.output(name)).unwrap().values);
    assert!(listed == placed && placed == numbered);
    approx::assert_relative_eq!(
        listed[2 * POINTS + 7],
        f64::from(whole[49 * POINTS + 7]),
        max_relative = 1e-5
    );

    let mean = |i: usize, j: usize| 0.5 * (whole[i * POINTS + j] + whole[j * POINTS + i]);
    run("--symmetrize -o symmetric.npy");
    run("--symmetrize --upper -o upper.npy");
    let (symmetric, upper) = (read("symmetric.npy"), read("upper.npy"));
    for (i, j) in (0..POINTS).flat_map(|i| (0..POINTS).map(move |j| (i, j))) {
        assert_eq!(symmetric[i * POINTS + j], mean(i, j));
    }
    assert!(upper == symmetric, "what lies above the diagonal says all");
    let bytes = fs::metadata(bench.output("upper.npy")).unwrap().len();
    assert_eq!(bytes, (128 + POINTS * (POINTS - 1) / 2 * 4) as u64);

    run("--numbers float16 -o half.npy");
    for (half, whole) in read("half.npy").iter().zip(&whole) {
        approx::assert_relative_eq!(half, whole, max_relative = 4.9e-4);
    }
    run("--from-symmetry -o from-symmetry.npy");
    for (found, expected) in read("from-symmetry.npy").iter().zip(&whole) {
        approx::assert_relative_eq!(found, expected, max_relative = 1e-2);
    }
    let left: Vec<_> = bench.outputs().into_iter().filter(|name| name.contains("part")).collect();
    assert_eq!(left, [""; 0]);
}

#[test]
fn an_interrupted_matrix_is_resumed_to_the_same_bytes() {
    let bench = Workbench::new();
    // The slowest engine, so that there is time to interrupt it.
    let line = "pairwise builtin:peaks:40x40 --engine fast-marching --wavefront circular -o";
    let start = |name: &str| {
        let mut command = Command::new(cargo_bin!("geosweep"));
        command.current_dir(bench.outputs.path()).args(line.split_whitespace()).arg(name);
        command.stderr(Stdio::piped());
        command
    };
    let run = |command: &mut Command| command.output().unwrap();
    assert!(run(&mut start("at-once.npy")).status.success());

    let interrupted = |mut child: Child, signal: &str| {
        let part = bench.output("d.npy.part");
        let begun = fs::metadata(&part).map_or(0, |part| part.len());
        let patience = Instant::now();
        while fs::metadata(&part).map_or(0, |part| part.len()) < begun + 200_000 {
            assert!(child.try_wait().unwrap().is_none(), "it ended before it was interrupted");
            assert!(patience.elapsed() < Duration::from_secs(100), "no row in 100 s");
            std::thread::sleep(Duration::from_millis(1));
        }
        let pid = child.id().to_string();
        assert!(Command::new("kill").args([signal, &pid]).status().unwrap().success());
        child.wait_with_output().unwrap()
    };
    let output = interrupted(start("d.npy").spawn().unwrap(), "-INT");
    assert_eq!(output.status.code(), Some(2));
    assert!(stderr(&output).contains("--resume continues"), "{}", stderr(&output));
    assert_eq!(bench.outputs(), ["at-once.npy", "d.npy.part", "d.npy.part.json"]);

    // Without --resume, the command does not start anew by mistake. With --resume, it does not continue with other
    // options.
    let output = run(&mut start("d.npy"));
    assert!(stderr(&output).contains("unfinished matrix"), "{}", stderr(&output));
    let output = run(start("d.npy").args(["--resume", "--numbers", "float16"]));
    let message = stderr(&output);
    assert!(message.contains("numbers float32, not float16"), "{message}");
    let output = run(start("d.npy").args(["--resume", "--spacing", "2"]));
    assert_eq!(output.status.code(), Some(2));

    // A power failure leaves rows after the last checkpoint, one of them in part.
    let output = interrupted(start("d.npy").arg("--resume").spawn().unwrap(), "-KILL");
    assert!(!output.status.success());
    let mut part = fs::read(bench.output("d.npy.part")).unwrap();
    part.extend_from_slice(&[7; 1000]);
    fs::write(bench.output("d.npy.part"), part).unwrap();

    let report = json(&run(start("d.npy").args(["--resume", "--json"]).stdout(Stdio::piped())));
    assert!(report["resumed_rows"].as_u64().unwrap() > 0, "{report}");
    assert_eq!(report["matrix_rows"], 1600);
    assert_eq!(bench.outputs(), ["at-once.npy", "d.npy"]);
    let [resumed, at_once] =
        ["d.npy", "at-once.npy"].map(|name| fs::read(bench.output(name)).unwrap());
    assert!(resumed == at_once);
}

/// A matrix in memory cannot be resumed, and leaves nothing behind.
#[test]
fn an_interrupted_matrix_from_symmetry_leaves_nothing() {
    let bench = Workbench::new();
    let line =
        "pairwise builtin:sphere:80x80 --wavefront circular --from-symmetry --symmetrize -o d.npy";
    let mut command = Command::new(cargo_bin!("geosweep"));
    command.current_dir(bench.outputs.path()).args(line.split_whitespace()).stderr(Stdio::piped());
    let mut child = command.spawn().unwrap();
    // The file exists after the handler of interruptions is installed.
    while !bench.output("d.npy.part").exists() {
        assert!(child.try_wait().unwrap().is_none(), "it ended before it began");
        std::thread::sleep(Duration::from_millis(1));
    }
    let pid = child.id().to_string();
    assert!(Command::new("kill").args(["-INT", &pid]).status().unwrap().success());
    let output = child.wait_with_output().unwrap();
    assert_eq!(output.status.code(), Some(2));
    assert!(stderr(&output).contains("interrupted"), "{}", stderr(&output));
    assert_eq!(bench.outputs(), [""; 0]);
}

/// The matrix has 340 MB, and the whole process has only 250 MB of address space.
#[test]
#[cfg(target_os = "linux")]
fn a_matrix_larger_than_memory_is_written() {
    let bench = Workbench::new();
    let tool = cargo_bin!("geosweep");
    let line = "pairwise builtin:sphere:96x96 -o d.npy --wavefront planar --iterations 1 \
                --tolerance 0.5 --json";
    let limited = |kibibytes: usize, options: &str| {
        let tool = tool.display();
        let mut shell = Command::new("sh");
        shell.current_dir(bench.outputs.path()).env("MALLOC_ARENA_MAX", "1");
        let command = format!("ulimit -v {kibibytes}; exec {tool} {line} {options}");
        shell.args(["-c", &command]).output().unwrap()
    };
    let report = json(&limited(250_000, ""));
    assert_eq!(report["matrix_rows"], 9216);
    assert!(report["memory_bytes"].as_u64().unwrap() < 40_000_000, "{report}");
    fs::remove_file(bench.output("d.npy")).unwrap();
    // Options that need the matrix in memory fail before any work.
    let output = limited(250_000, "--from-symmetry");
    assert!(stderr(&output).contains("324 MiB of memory"), "{}", stderr(&output));
    bench.refuses(&output, &["324 MiB"]);
}

#[test]
fn invalid_requests_for_a_matrix_are_refused() {
    let bench = Workbench::new();
    let refuses = |options: &str, parts: &[&str]| {
        let line = format!("pairwise {SPHERE} {options}");
        bench.refuse(&line, parts);
    };
    refuses("-o d.tif", &["d.tif", ".npy"]);
    refuses("-o d.npy --sources 7..7", &["empty range"]);
    refuses("-o d.npy --sources 170..181", &["170..181", "180 points"]);
    for range in ["3..", "..3", "-1..3", "a..b"] {
        refuses(&format!("-o d.npy --sources={range}"), &[range, "0..100"]);
    }
    refuses("-o d.npy --sources ../nowhere.txt", &["../nowhere.txt", "cannot be read"]);
    refuses("-o d.npy --sources nowhere.txt", &["nowhere.txt"]);
    refuses("-o d.npy --sources 0..9 --upper", &["--upper"]);
    refuses("-o d.npy --sources 0..9 --symmetrize", &["--symmetrize"]);
    refuses("-o d.npy --wavefront curved --from-symmetry", &["circular"]);
    refuses("-o d.npy --schedule tiles", &["schedule", "single maps", "leave"]);
    refuses("-o d.npy --engine vulkan --schedule raster", &["schedule", "single maps"]);
    refuses("-o d.npy --engine fast-marching --from-symmetry", &["CPU"]);
    let off = bench.input("off.txt", "3,15\n");
    refuses(&format!("-o d.npy --sources {off}"), &["off.txt", "15", "0 to 14"]);
    let between = bench.input("between.txt", "3.5,1\n");
    refuses(&format!("-o d.npy --sources {between}"), &["3.5"]);
    let cube = bench.array("points.npy", &[2, 3, 1], &[0.0; 6]);
    refuses(&format!("-o d.npy --sources {cube}"), &["points.npy", "(2, 3, 1)", "(K,)"]);
    refuses("-o d.npy --sample 0", &["`0` is not a number of samples"]);
    refuses("-o d.npy --sample 3 --sources 0..9", &["--sources"]);
    refuses("-o d.npy --labels labels.npy", &["--sample"]);
    refuses("-o d.npy --sample 3 --labels d.npy", &["d.npy", "two outputs"]);

    // 64 TB are more than any disk here has. This is reported before anything is computed.
    let line = "pairwise builtin:plane:2000x2000 -o d.npy --wavefront curved";
    bench.refuse(line, &["d.npy", "61035157 MiB", "are free"]);

    // Distances beyond half precision.
    let flat = bench.flat(9, 9);
    let line = format!("pairwise {flat} --spacing 20000 --numbers float16 -o d.npy");
    bench.refuse(&line, &["float16", "65504"]);
}

#[test]
fn samples_have_rows_and_regions() {
    let bench = Workbench::new();
    let line = format!("pairwise {SPHERE} --sample 9 --labels labels.npy -o rows.npy --json");
    let report = bench.json(&line);
    assert_eq!(bench.outputs(), ["labels.npy", "rows.npy"]);
    let places: Vec<usize> = report["samples"]
        .as_array()
        .unwrap()
        .iter()
        .map(|place| place[0].as_u64().unwrap() * 15 + place[1].as_u64().unwrap())
        .map(|point| point as usize)
        .collect();
    assert_eq!(places.len(), 9);
    let [rows, labels] =
        ["rows.npy", "labels.npy"].map(|name| read_map(&bench.output(name)).unwrap());
    assert_eq!((rows.rows, rows.cols), (9, POINTS));
    assert_eq!((labels.rows, labels.cols), (12, 15));
    for (point, label) in labels.values.iter().enumerate() {
        let own = rows.values[*label as usize * POINTS + point];
        // The map of all samples and that of one sample differ by rounding.
        let nearest = (0..9).map(|k| rows.values[k * POINTS + point]).fold(f64::INFINITY, f64::min);
        assert!(own <= nearest + 1e-5, "{point}: {own} to {label}, {nearest} to another");
    }
    // The output of `sample` names the same rows.
    assert!(bench.run(format!("sample {SPHERE} -k 9 -o samples.npy")).status.success());
    let line = format!("pairwise {SPHERE} --sources samples.npy -o again.npy");
    assert!(bench.run(&line).status.success());
    let [rows, again] = ["rows.npy", "again.npy"].map(|name| fs::read(bench.output(name)).unwrap());
    assert!(rows == again);
}

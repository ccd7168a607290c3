//! The figures and the accuracy report show what the library computes.

use std::fs;
use std::io::Cursor;

use crate::workbench::{Workbench, stderr};
use geosweep::Stop;
use geosweep::accuracy::{Errors, exact_disc};
use geosweep::cpu::raster_scan;
use geosweep::cpu::twins::scan_in_turn;
use geosweep::surface::EdgeLengths;
use geosweep::surface::builtin::Builtin;
use geosweep::{DistanceMap, Engine, Options, Sources, Wavefront, distance_map};
use serde_json::Value;

/// Returns the width and height of a picture. Asserts that it can be read and has more than one colour.
fn picture_size(bench: &Workbench, name: &str) -> (u32, u32) {
    let bytes = fs::read(bench.output(name)).unwrap();
    let mut reader = png::Decoder::new(Cursor::new(bytes)).read_info().unwrap();
    let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
    let info = reader.next_frame(&mut pixels).unwrap();
    assert!(pixels.iter().any(|&byte| byte < 100) && pixels.contains(&255), "{name} is blank");
    (info.width, info.height)
}

fn wavefront(name: &str) -> Wavefront {
    Wavefront::ALL.into_iter().find(|wavefront| wavefront.name() == name).unwrap()
}

/// Returns the CPU engine's map of a surface with `points` x `points` points, and its errors.
fn solve(
    builtin: Builtin,
    points: usize,
    source: [f64; 2],
    wavefront: Wavefront,
) -> (DistanceMap, Errors) {
    let surface = builtin.surface(points, points).unwrap();
    let exact = builtin.reference_distances(points, points, source);
    let options = Options::default().with_engine(Engine::Cpu).with_wavefront(wavefront);
    let map = distance_map(&surface, &Sources::point(source[0], source[1]), &options).unwrap();
    let errors = Errors::of(&map.distances, &exact);
    (map, errors)
}

/// Returns the errors after one iteration of directed scans with the planar front, from a disc of exact
/// values.
fn errors_after_one_iteration(
    builtin: Builtin,
    points: usize,
    source: [f64; 2],
    radius: f64,
) -> Errors {
    let surface = builtin.surface(points, points).unwrap();
    let exact = builtin.reference_distances(points, points, source);
    let seeds = exact_disc(surface.chart(), &exact, radius).seeds(&surface).unwrap();
    let edges = EdgeLengths::<f32>::new(&surface).unwrap();
    let solution = raster_scan(&edges, &seeds, Wavefront::Planar, Stop::after(1));
    Errors::of(&solution.distances(), &exact)
}

/// Asserts that two numbers are equal except for the last digit, which is lost when JSON is read.
fn assert_same(found: &Value, expected: f64) {
    approx::assert_relative_eq!(found.as_f64().unwrap(), expected, max_relative = 1e-15);
}

#[test]
fn convergence_shows_what_the_library_computes() {
    let bench = Workbench::new();
    let rows = bench.json("figure convergence --sizes 33,17 --json --csv table.csv -o figure.png");
    assert_eq!(bench.outputs(), ["figure.png", "table.csv"]);
    let (width, height) = picture_size(&bench, "figure.png");
    assert!((1500..2500).contains(&width) && (500..1200).contains(&height), "{width} x {height}");

    let rows = rows["maps"].as_array().unwrap();
    // Three surfaces from two starts, then five with every other wavefront, at two sizes.
    assert_eq!(rows.len(), 2 * (3 * 2 + 5 * (Wavefront::FOR_ANY_SURFACE.len() - 1)));
    let table = fs::read_to_string(bench.output("table.csv")).unwrap();
    let mut lines = table.lines();
    assert_eq!(lines.next(), Some("surface,wavefront,source,iterations,side,mean_relative_error"));
    for row in rows {
        let text = |key: &str| row[key].as_str().unwrap();
        let points = row["side"].as_u64().unwrap() as usize;
        let last = (points - 1) as f64;
        let radius = if text("source") == "disc" { 0.15 } else { 0.0 };
        let source = [0.25 * last, 0.375 * last];
        let builtin = Builtin::parse(text("surface")).unwrap();
        let wavefront = wavefront(text("wavefront"));
        let (iterations, errors) = if wavefront == Wavefront::Planar {
            (1, errors_after_one_iteration(builtin, points, source, radius))
        } else {
            let (map, errors) = solve(builtin, points, source, wavefront);
            (map.report.iterations, errors)
        };
        assert_same(&row["mean_relative_error"], errors.mean_relative);
        assert_eq!(row["iterations"], iterations);

        let cells: Vec<_> = lines.next().unwrap().split(',').collect();
        assert_eq!(cells[..3], [text("surface"), text("wavefront"), text("source")]);
        assert_eq!(cells[3..5].join(","), format!("{iterations},{points}"));
        assert_eq!(cells[5].parse(), Ok(errors.mean_relative));
    }
    assert_eq!(lines.next(), None);
}

#[test]
fn the_maze_is_shown_iteration_by_iteration() {
    let bench = Workbench::new();
    let stages = bench.json("figure maze --size 65 --json -o maze.png");
    let (width, height) = picture_size(&bench, "maze.png");
    assert!((1800..2600).contains(&width) && (500..800).contains(&height), "{width} x {height}");

    let surface = Builtin::Maze.surface(65, 65).unwrap();
    let edges = EdgeLengths::<f32>::new(&surface).unwrap();
    let seeds = Sources::point(0.0, 0.0).seeds(&surface).unwrap();
    let stages = stages["stages"].as_array().unwrap();
    assert_eq!(stages.len(), 4);
    for (stage, iterations) in stages.iter().zip([1, 2, 3, 100]) {
        let stop = Stop::within(1e-6).or_after(iterations);
        let solution = scan_in_turn(&edges, &seeds, Wavefront::Circular, stop);
        let reached = solution.distances().iter().filter(|d| d.is_finite()).count();
        assert_eq!(stage["iterations"], solution.iterations);
        assert_eq!(stage["reached"], reached);
        assert_eq!(stage["points"], surface.points());
        assert_eq!(stage["converged"], iterations == 100);
    }
    assert_eq!(stages[3]["reached"], surface.points());

    // Without walls, one iteration is enough.
    let stages = bench.json("figure maze --size 9 --json -o open.png");
    assert!(stages["stages"].as_array().unwrap().len() < 4, "{stages}");
}

/// Table 2 comes from the code with which `geosweep-lab bench` measures. Of the paper's rows, it has only the row of a
/// requested size.
#[test]
fn table_2_has_an_iteration_and_a_converged_map_beside_the_papers() {
    let bench = Workbench::new();
    let line = "figure table-2 --sizes 150,33 --surface maze --json --machine toaster -o t.md";
    let rows = bench.json(line);
    let rows = rows["sizes"].as_array().unwrap();
    let on_cpu: Vec<_> = rows.iter().filter(|row| row["engine"] == "cpu").collect();
    assert_eq!(on_cpu.len(), 2);
    for (row, side) in on_cpu.iter().zip([33, 150]) {
        assert_eq!((&row["rows"], &row["cols"]), (&side.into(), &side.into()));
        let surface = Builtin::Maze.surface(side, side).unwrap();
        let wavefront = Some(Wavefront::Curved);
        let options = Options::default().with_engine(Engine::Cpu).with_wavefront(wavefront);
        let report = distance_map(&surface, &Sources::point(0.0, 0.0), &options).unwrap().report;
        assert_eq!(row["converged_iterations"], report.iterations);
        assert_eq!(row["points"], surface.points());
        for key in ["iteration_seconds", "converged_seconds"] {
            assert!(row[key].as_f64().unwrap() > 0.0, "{row}");
        }
        let [once, converged] =
            ["iteration_bytes", "converged_bytes"].map(|key| row[key].as_u64().unwrap());
        // The curved front stores its curvatures and the surface's.
        assert!(once > 16 * (side * side) as u64 && converged > once, "{row}");
    }
    let table = fs::read_to_string(bench.output("t.md")).unwrap();
    for part in ["toaster", "7950 GT", "of the maze", "| 33 x 33 | cpu |", "| 150 x 150 | cpu |"] {
        assert!(table.contains(part), "`{part}` is missing in:\n{table}");
    }
    let paper = table.lines().filter(|line| line.ends_with("| 111 | 1.6 |"));
    assert_eq!(paper.count(), rows.len() / 2, "{table}");
    assert!(table.lines().any(|line| line.starts_with("| 33") && line.ends_with("|  |  |")));
}

#[test]
fn the_accuracy_report_says_what_the_library_computes() {
    let bench = Workbench::new();
    let line = "accuracy --sizes 33,65 --json -o report.md --plots . --machine toaster --peers";
    let peers = "surface,size,solver,seconds,mean_error\nsphere,65,walker,0.25,1.5e-3\n";
    let peers = bench.input("peers.csv", peers);
    let rows = bench.json(format!("{line} {peers}"));
    assert_eq!(bench.outputs(), ["accuracy-size.png", "accuracy-time.png", "report.md"]);
    for name in ["accuracy-size.png", "accuracy-time.png"] {
        let (width, height) = picture_size(&bench, name);
        assert!((1500..2500).contains(&width) && (800..2400).contains(&height), "{name}");
    }
    let report = fs::read_to_string(bench.output("report.md")).unwrap();
    for part in [
        "toaster",
        "](accuracy-size.png)",
        "\n## maze\n",
        "\n## peaks\n",
        "| surface | wavefront | mean | RMS | largest |",
        "| sphere | walker | 65 | 1.50e-3 | 250 |",
        "--sizes 33,65 --engine cpu",
        "on\nthe CPU by",
    ] {
        assert!(report.contains(part), "`{part}` is missing in:\n{report}");
    }

    let rows = rows["maps"].as_array().unwrap();
    // Anchored fronts are for floor plans.
    let anchored: Vec<_> = rows.iter().filter(|row| row["wavefront"] == "anchored").collect();
    let is_plan = |builtin: &Builtin| builtin.surface(33, 33).unwrap().is_floor_plan();
    let plans: Vec<_> =
        Builtin::measurable().filter(is_plan).map(|plan| plan.to_string()).collect();
    assert!(plans.contains(&"maze".to_owned()) && anchored.len() == 2 * plans.len(), "{plans:?}");
    let is_of_plan = |row: &&Value| plans.iter().any(|plan| row["surface"] == plan.as_str());
    assert!(anchored.iter().all(|&row| is_of_plan(&row)), "{anchored:?}");
    let all = Builtin::measurable().count() * 2 * Wavefront::FOR_ANY_SURFACE.len() + anchored.len();
    assert_eq!(rows.len(), all);
    for row in rows {
        let builtin = Builtin::parse(row["surface"].as_str().unwrap()).unwrap();
        let points = row["side"].as_u64().unwrap() as usize;
        let at = |fraction: f64| fraction * (points - 1) as f64;
        let source = if builtin == Builtin::Maze { [0.0; 2] } else { [at(0.3125), at(0.40625)] };
        let wavefront = wavefront(row["wavefront"].as_str().unwrap());
        let (map, errors) = solve(builtin, points, source, wavefront);
        assert_same(&row["mean_relative_error"], errors.mean_relative);
        assert_same(&row["rms_relative_error"], errors.rms_relative);
        assert_same(&row["max_relative_error"], errors.max_relative);
        assert_eq!(row["iterations"], map.report.iterations);
        assert!(row["solve_seconds"].as_f64().unwrap() > 0.0);
    }
    // The second grid is twice as fine: the order is the binary logarithm of the ratio.
    for pair in rows.chunks(2) {
        let [coarse, fine] = [0, 1].map(|k| pair[k]["mean_relative_error"].as_f64().unwrap());
        assert_eq!(pair[0]["order"], Value::Null);
        let order = pair[1]["order"].as_f64().unwrap();
        approx::assert_relative_eq!(order, (coarse / fine).log2(), max_relative = 1e-12);
    }
}

#[test]
fn a_report_without_a_file_goes_to_standard_output() {
    let bench = Workbench::new();
    let output =
        bench.run("accuracy --sizes 9 --surfaces sheared-plane@30,sphere --wavefronts planar");
    let report = String::from_utf8(output.stdout.clone()).unwrap();
    assert!(output.status.success() && stderr(&output).is_empty(), "{}", stderr(&output));
    let command = "accuracy --sizes 9 --engine cpu --surfaces sheared-plane@30,sphere \
                   --wavefronts planar`";
    assert!(report.contains(command), "{report}");
    assert!(report.contains("\n## sheared-plane@30\n") && report.contains("\n## sphere\n"));
    assert!(!report.contains("point |") && !report.contains(".png"), "{report}");
    assert_eq!(bench.outputs(), [""; 0]);
}

#[test]
fn wrong_arguments_are_refused() {
    let bench = Workbench::new();
    for (line, parts) in [
        ("figure convergence", &["--output"][..]),
        ("figure convergence -o figure.jpg", &["figure.jpg", ".png"]),
        ("figure convergence -o missing/figure.png", &["missing", "no folder"]),
        ("figure convergence -o figure.png --csv table.txt", &["table.txt", ".csv"]),
        ("figure convergence -o figure.png --csv missing/table.csv", &["missing", "no folder"]),
        ("figure convergence -o figure.png --sizes 0", &["`0`", "from 2 to 16384"]),
        ("figure convergence -o figure.png --sizes 9,x", &["`x`", "points per side"]),
        ("figure maze -o maze.png --size 0", &["`0`", "from 2 to 16384"]),
        ("figure maze -o maze.png --size 99999", &["`99999`", "from 2 to 16384"]),
        ("figure maze -o missing/maze.png", &["missing", "no folder"]),
        ("figure table-2 --sizes 1", &["`1`", "from 2 to 16384"]),
        ("figure table-2 --surface teapot", &["teapot", "sphere"]),
        ("figure table-2 -o table.txt", &["table.txt", ".md"]),
        ("accuracy --sizes 0", &["`0`", "from 2 to 16384"]),
        ("accuracy --surfaces teapot", &["teapot", "sphere"]),
        ("accuracy --wavefronts square", &["`square`", "planar, circular"]),
        ("accuracy --engine abacus", &["abacus", "vulkan"]),
        ("accuracy -o report.txt", &["report.txt", ".md"]),
        ("accuracy -o missing/report.md", &["missing", "no folder"]),
        ("accuracy --peers missing.csv", &["missing.csv"]),
        ("accuracy --plots missing -o report.md", &["missing", "no folder"]),
    ] {
        bench.refuse(line, parts);
    }
}

#[test]
fn table_1_is_a_table() {
    let bench = Workbench::new();
    let line = "figure table-1 --sizes 8,32 --runs 3 --json -o table.md";
    let rows = bench.json(line);
    let rows = rows["sizes"].as_array().unwrap();
    assert_eq!(
        rows.iter().map(|row| row["vertices"].as_u64()).collect::<Vec<_>>(),
        [Some(64), Some(1024)]
    );
    for row in rows {
        let number = |name: &str| row[name].as_f64().unwrap();
        let ratio = number("fast_marching_seconds") / number("planar_seconds");
        approx::assert_relative_eq!(ratio, number("speed_up"), max_relative = 1e-9);
        let rate = number("distances") / number("circular_seconds");
        let told = number("circular_distances_per_second");
        approx::assert_relative_eq!(rate, told, max_relative = 1e-9);
    }
    let table = fs::read_to_string(bench.output("table.md")).unwrap();
    let lines: Vec<_> = table.lines().filter(|line| line.starts_with('|')).collect();
    assert_eq!(lines.len(), 4, "{table}");
    let columns = |line: &&str| line.matches('|').count();
    assert!(lines.iter().all(|line| columns(line) == 12), "{table}");
    // The paper's figures are next to its own sizes only.
    assert!(lines[2].ends_with("|  |  |  |") && lines[3].ends_with("| 0.15 | 1.3 | 8.3 |"));
}

#[test]
fn the_figures_bendings_share_a_form() {
    let bench = Workbench::new();
    let rows = bench.json("figure canonical --size 17 --json -o figure.png");
    assert_eq!(bench.outputs(), ["figure.png"]);
    let deviations: Vec<_> =
        rows["surfaces"].as_array().unwrap().iter().map(|row| row["deviation"].as_f64()).collect();
    let [None, None, Some(between), Some(catenoid)] = deviations[..] else { panic!("{rows}") };
    // The deviations are due to the errors of the distances on such a coarse grid.
    assert!(between.max(catenoid) < 2e-3, "{rows}");
}

#[test]
fn the_face_is_drawn() {
    let bench = Workbench::new();
    bench.done("figure face -o face.png");
    assert!(picture_size(&bench, "face.png").0 >= 1500);
    std::fs::remove_file(bench.output("face.png")).unwrap();
    bench.refuse("figure face -o face.gif", &["face.gif", ".png"]);
}

//! Closed surfaces whose files do not repeat the samples of a seam. Outputs have the size of the file.

use std::f64::consts::{PI, TAU};

use serde_json::Value;

use crate::workbench::{Workbench, json, notes, stderr};

/// Writes positions at rows and columns.
fn surface(
    bench: &Workbench,
    name: &str,
    [rows, cols]: [usize; 2],
    at: impl Fn(f64, f64) -> [f64; 3],
) -> String {
    let places = (0..rows * cols).map(|index| [index / cols, index % cols]);
    let values: Vec<f64> = places.flat_map(|[row, col]| at(row as f64, col as f64)).collect();
    bench.array(name, &[rows, cols, 3], &values)
}

/// Writes a tube of 9 x 32 points, without a last column that repeats the first.
fn tube(bench: &Workbench) -> String {
    surface(bench, "open.npy", [9, 32], |row, col| {
        let (sin, cos) = (TAU * col / 32.0).sin_cos();
        [cos, sin, row * TAU / 32.0]
    })
}

/// Writes a sphere of 45 x 90 points at the middles of cells.
fn globe(bench: &Workbench) -> String {
    surface(bench, "cells.npy", [45, 90], |row, col| {
        let [(sin, cos), (out, up)] =
            [TAU * (col + 0.5) / 90.0, PI * (row + 0.5) / 45.0].map(f64::sin_cos);
        [out * cos, out * sin, up]
    })
}

/// Writes the six faces of a sphere on a cube, of 12 x 12 texels each, one below the other.
fn cube(bench: &Workbench) -> String {
    surface(bench, "cube.npy", [72, 12], |row, col| {
        let [u, v] =
            [col, row % 12.0].map(|at| ((2.0 * at + 1.0) / 12.0 - 1.0) * PI / 4.0).map(f64::tan);
        let length = (1.0 + u * u + v * v).sqrt();
        let [u, v, w] = [u, v, 1.0].map(|at| at / length);
        match (row / 12.0) as u8 {
            0 => [w, -v, -u],
            1 => [-w, -v, u],
            2 => [u, w, v],
            3 => [u, -w, -v],
            4 => [u, -v, w],
            _ => [-u, -v, -w],
        }
    })
}

/// Returns the distance on the tube between two points of its file.
fn on_tube(a: usize, b: usize) -> f64 {
    let around = (a % 32).abs_diff(b % 32);
    let rows = (a / 32).abs_diff(b / 32);
    TAU / 32.0 * (around.min(32 - around) as f64).hypot(rows as f64)
}

#[test]
fn a_tube_needs_no_second_column() {
    let bench = Workbench::new();
    let given = tube(&bench);
    let warned = bench.distance(&given, "-s 4,1 --json");
    assert!(notes(&warned).contains("neighbours one cell apart"), "{}", notes(&warned));
    assert!(notes(&warned).contains("unless --glue auto joins its sides"), "{}", notes(&warned));
    for (number, words) in ["--glue auto", "--glue columns", "--wrap columns"].iter().enumerate() {
        let name = format!("map{number}.npy");
        let output = bench.distance(&given, &format!("-s 4,1 {words} --json -o {name}"));
        let said = json(&output);
        assert_eq!(said["seams"], Value::Array(vec![]));
        let sizes = ["rows", "cols", "points", "reached"].map(|name| said[name].as_u64().unwrap());
        assert_eq!(sizes, [9, 32, 288, 288]);
        let said = notes(&output);
        assert!(said.contains("9 x 32") && said.contains("9 x 33"), "{words}: {said}");
        assert_eq!(said.lines().count(), 1, "{said}");
        let found = bench.map(&name);
        assert_eq!(found.len(), 9 * 32);
        for (index, found) in found.iter().enumerate() {
            let exact = on_tube(index, 4 * 32 + 1);
            assert!((found - exact).abs() <= 3e-6 * exact, "{words} {index}: {found} {exact}");
        }
    }
}

#[test]
fn outputs_have_the_places_of_the_file() {
    let bench = Workbench::new();
    let given = tube(&bench);
    let step = TAU / 32.0;
    // Places between the last column and the first one have columns beyond the last one.
    let line =
        format!("value {given} -s 4,1 --wrap columns --at 4,31 --at 4,31.5 --at 4,32 --json");
    let said = bench.json(&line);
    let found = said["values"].as_array().unwrap().iter().map(|value| value["distance"].as_f64());
    for (found, steps) in found.zip([2.0, 1.5, 1.0]) {
        assert!((found.unwrap() - steps * step).abs() < 1e-5, "{found:?} {steps}");
    }
    let line = format!("path {given} -s 4,1 --wrap columns --from 4,29 -o path.npy --json");
    let said = bench.json(&line);
    let length = said["paths"][0]["length"].as_f64().unwrap();
    assert!((length - 4.0 * step).abs() < 1e-5, "{length}");
    let path = &bench.curves("path.npy")[0];
    assert!(path.iter().all(|vertex| (0.0..=32.0).contains(&vertex[1])), "{path:?}");
    assert_eq!([path[0][1], path[path.len() - 1][1]], [29.0, 1.0]);
    let line = format!("contours {given} -s 4,1 --wrap columns --levels 0.7 -o c.csv --json");
    assert_eq!(bench.json(&line)["levels"][0]["closed"], 1);
    assert!(bench.text("c.csv").lines().count() > 20);

    let line = "-s 4,2 --glue columns -o map.npy --back-direction way.npy --back-link link.tif \
                --nearest nearest.tif --log-map log.npy --direction-picture ways.png";
    let output = bench.distance(&given, line);
    assert!(output.status.success(), "{}", stderr(&output));
    let way = bench.map("way.npy");
    assert_eq!(way.len(), 9 * 32);
    for (col, wanted) in [(28, 90.0), (31, 90.0), (0, 90.0), (5, 270.0)] {
        assert!((way[4 * 32 + col] - wanted).abs() < 1e-3, "{col}: {}", way[4 * 32 + col]);
    }
    let line = format!("voronoi {given} -s 4,2 -s 4,18 --wrap columns -o regions.npy --json");
    let said = bench.json(&line);
    let regions = bench.map("regions.npy");
    let near = |col: usize| if (11..26).contains(&col) { 1.0 } else { 0.0 };
    assert!((0..288).all(|k| [10, 26].contains(&(k % 32)) || regions[k] == near(k % 32)));
    let points = |region: usize| said["regions"][region]["points"].as_u64().unwrap();
    assert_eq!(points(0) + points(1), 288);
}

#[test]
fn all_pairs_are_those_of_the_points_of_the_file() {
    let bench = Workbench::new();
    let given = tube(&bench);
    for (name, words) in [("curved.npy", "curved"), ("circular.npy", "circular")] {
        let line = format!("pairwise {given} --wrap columns --wavefront {words} -o {name} --json");
        let said = bench.json(&line);
        assert_eq!([&said["matrix_rows"], &said["matrix_cols"]], [288, 288]);
        let found = bench.map(name);
        assert_eq!(found.len(), 288 * 288);
        for (index, found) in found.iter().enumerate() {
            let exact = on_tube(index / 288, index % 288);
            assert!((found - exact).abs() <= 1e-3 * exact, "{name} {index}: {found} {exact}");
        }
    }
}

/// Samples of a matrix are points of the file, also where the farthest points of the surface are poles or lie between
/// faces.
#[test]
fn samples_of_a_matrix_are_points_of_the_file() {
    let bench = Workbench::new();
    let files = [tube(&bench), globe(&bench), cube(&bench)];
    let kinds = [("columns", [9, 32]), ("globe", [45, 90]), ("cube", [72, 12])];
    for (given, (glue, [rows, cols])) in files.into_iter().zip(kinds) {
        let line =
            format!("pairwise {given} --glue {glue} --sample 9 -o m.npy --labels l.npy --json");
        let said = bench.json(&line);
        assert_eq!([&said["matrix_rows"], &said["matrix_cols"]], [9, rows * cols], "{glue}");
        let samples: Vec<usize> = (0..9)
            .map(|k| {
                let at = |n: usize| said["samples"][k][n].as_u64().unwrap() as usize;
                at(0) * cols + at(1)
            })
            .collect();
        let matrix = bench.map("m.npy");
        let labels = bench.map("l.npy");
        assert_eq!((matrix.len(), labels.len()), (9 * rows * cols, rows * cols));
        for (k, &sample) in samples.iter().enumerate() {
            assert_eq!(matrix[k * rows * cols + sample], 0.0, "{glue} {k}");
            assert_eq!(labels[sample], k as f64, "{glue} {k}");
            // Each sample was the point farthest from those before it, so that others are as far apart.
            let apart = |other: &usize| matrix[k * rows * cols + other];
            assert!(samples.iter().filter(|&other| *other != sample).all(|at| apart(at) > 0.5));
        }
    }
}

/// A circle around a pole that the file lacks divides the surface.
#[test]
fn signed_distances_pass_seams() {
    let bench = Workbench::new();
    let given = globe(&bench);
    let latitude: String = (0..=90).map(|col| format!("9.5,{col}\n")).collect();
    let curve = bench.input("latitude.csv", &latitude);
    let line = format!("--glue globe --source-curve {curve} --signed -o signed.npy");
    assert!(bench.distance(&given, &line).status.success());
    for (index, found) in bench.map("signed.npy").into_iter().enumerate() {
        let exact = ((index / 90) as f64 - 9.5) * PI / 45.0;
        assert!((found - exact).abs() < 1e-3, "{index}: {found} {exact}");
    }
}

#[test]
fn a_globe_of_cells_is_whole() {
    let bench = Workbench::new();
    let given = globe(&bench);
    let exact = |a: [f64; 2], b: [f64; 2]| {
        let [(p, q), (s, t)] =
            [a, b].map(|[row, col]| (PI * (row + 0.5) / 45.0, TAU * (col + 0.5) / 90.0));
        (p.cos() * s.cos() + p.sin() * s.sin() * (q - t).cos()).clamp(-1.0, 1.0).acos()
    };
    for (number, words) in ["--glue globe", "--wrap columns --poles"].iter().enumerate() {
        let name = format!("map{number}.npy");
        let output = bench.distance(&given, &format!("-s 8,88 {words} -o {name} --picture p.png"));
        assert!(output.status.success(), "{}", stderr(&output));
        assert!(notes(&output).contains("45 x 90") && notes(&output).contains("47 x 91"));
        let found = bench.map(&name);
        assert_eq!(found.len(), 45 * 90);
        for (index, found) in found.iter().enumerate() {
            let at = [(index / 90) as f64, (index % 90) as f64];
            let exact = exact([8.0, 88.0], at);
            // Measured: 3.1e-4. Towards the antipode, fronts from all sides meet.
            assert!(
                exact > PI - 0.2 || (found - exact).abs() < 2e-3 * exact.max(0.1),
                "{at:?}: {found} {exact}"
            );
        }
        std::fs::remove_file(bench.output("p.png")).unwrap();
    }
    // The pole lies half a row before the first one.
    let line = format!("value {given} -s=-0.5,3 --glue globe --at 44.5,0 --at 22,7 --json");
    let said = bench.json(&line);
    for (value, wanted) in [(0, PI), (1, PI / 2.0)] {
        let found = said["values"][value]["distance"].as_f64().unwrap();
        assert!((found - wanted).abs() < 1e-3, "{found}");
    }
    let bench = Workbench::new();
    let refused = bench.distance(&globe(&bench), "-s 8,88 --glue globe --back-link link.npy");
    bench.refuses(&refused, &["--back-link", "lines that the grid lacks"]);
    // A tube has no poles.
    let refused = bench.distance(&tube(&bench), "-s 1,1 --wrap columns --poles -o map.npy");
    bench.refuses(&refused, &["--glue globe", "surround one", "first row"]);
}

/// `--glue auto` adds no poles, since a tube that narrows looks the same. It says how to add them.
#[test]
fn a_globe_glued_by_itself_has_a_note_about_its_poles() {
    let bench = Workbench::new();
    for (file, is_globe) in [(globe(&bench), true), (tube(&bench), false)] {
        let output = bench.distance(&file, "-s 5,5 --glue auto --json");
        assert_eq!(notes(&output).contains("--glue globe"), is_globe, "{}", notes(&output));
        let output = bench.distance(&file, "-s 5,5 --glue auto --json --quiet");
        assert_eq!(notes(&output), "");
    }
}

/// Six faces of 12 x 12 texels, one below the other.
#[test]
fn a_cube_map_is_a_sphere() {
    let bench = Workbench::new();
    let faces = cube(&bench);
    let output =
        bench.distance(&faces, "-s 5.5,5.5 --layout cube -o map.npy --json --picture c.png");
    let said = json(&output);
    assert_eq!([&said["rows"], &said["cols"], &said["reached"]], [72, 12, 864]);
    assert!(
        notes(&output).contains("72 x 12") && notes(&output).contains("89 x 14"),
        "{}",
        notes(&output)
    );
    let found = bench.map("map.npy");
    for (row, col, wanted) in [(17, 5, PI), (29, 5, PI / 2.0), (53, 6, PI / 2.0)] {
        // The middle of a face lies between its four middle texels, a twelfth of a quarter turn apart.
        assert!(
            (found[row * 12 + col] - wanted).abs() < 0.2,
            "{row},{col}: {}",
            found[row * 12 + col]
        );
    }
    let line = format!("value {faces} -s 5.5,5.5 --glue cube --at 29.5,5.5 --at 17.5,5.5 --json");
    let said = bench.json(&line);
    for (value, wanted) in [(0, PI / 2.0), (1, PI)] {
        let found = said["values"][value]["distance"].as_f64().unwrap();
        assert!((found - wanted).abs() < 2e-2, "{value}: {found}");
    }
}

#[test]
fn names_that_contradict_each_other_are_refused() {
    let bench = Workbench::new();
    let given = tube(&bench);
    for (words, parts) in [
        ("--glue columns --wrap columns", &["--glue", "--wrap"][..]),
        ("--wrap rows --layout cube", &["--wrap", "--layout"]),
        ("--flip", &["--wrap"]),
        ("--wrap columns --flip --poles", &["--flip", "--poles"]),
        ("--wrap rows --poles", &["--poles", "--wrap columns"]),
        ("--wrap both --flip", &["--flip", "--wrap columns or rows"]),
        ("--wrap rows", &["--glue rows", "first row", "last row", "apart on average"]),
        ("--wrap columns --flip", &["--glue flipped-columns", "apart on average"]),
        ("--layout cube", &["--glue cube", "9 x 32", "six square faces"]),
        ("--glue columns -s 4,32.5", &["4,32.5 lies outside the grid"]),
    ] {
        let output = bench.distance(&given, &format!("-s 4,1 {words} -o map.npy"));
        bench.refuses(&output, parts);
    }
}

/// Estimates of errors and canonical forms leave out the column that is added.
#[test]
fn errors_and_forms_are_those_of_the_points_of_the_file() {
    let bench = Workbench::new();
    let given = tube(&bench);
    bench.done(format!("distance {given} -s 4,1 --glue columns -o map.npy --error errors.npy"));
    let errors = bench.map("errors.npy");
    assert_eq!(errors.len(), 9 * 32);
    assert!(errors.iter().all(|error| error.abs() < 1e-2), "{errors:?}");
    let said = bench.json(format!("canonical {given} --glue columns -o form.npy --json"));
    assert_eq!([&said["rows"], &said["cols"], &said["placed"]], [9, 32, 288]);
}

/// Flat heights do not show whether the last line is the first one again.
#[test]
fn whether_the_last_line_repeats_the_first_is_told() {
    const SIZE: [usize; 2] = [12, 20];
    let [rows, cols] = SIZE;
    let bench = Workbench::new();
    let flat = bench.array("flat.npy", &SIZE, &vec![0.0; rows * cols]);
    let mut bump = vec![0.0; rows * cols];
    bump[cols * 4] = 1e-9;
    let rounded = bench.array("rounded.npy", &SIZE, &bump);
    let metric: Vec<f64> = (0..rows * cols).flat_map(|_| [1.0, 0.0, 0.0, 1.0]).collect();
    let metric = bench.array("metric.npy", &[rows, cols, 2, 2], &metric);
    for (surface, words) in [(&flat, "--spacing 1"), (&rounded, "--spacing 1"), (&metric, "")] {
        for sides in ["columns", "rows", "both"] {
            let line = format!("distance {surface} {words} -s 3,0 --wrap {sides} -o map.npy");
            bench.refuse(&line, &["may be one line", "columns:repeated", "columns:apart"]);
        }
    }
    for (surface, words) in [(&flat, "--spacing 1"), (&rounded, "--spacing 1"), (&metric, "")] {
        for (last, period) in [("apart", 20), ("repeated", 19)] {
            let line = format!("{words} -s 3,0 --wrap cols:{last} -o map.npy");
            assert!(bench.distance(surface, &line).status.success());
            for (index, found) in bench.map("map.npy").into_iter().enumerate() {
                let (row, col) = (index / cols, index % cols);
                let across = col.min(period - col) as f64;
                let exact = across.hypot((row as f64 - 3.0).abs());
                assert!((found - exact).abs() < 1e-4, "{surface} {last} {row},{col}: {found}");
            }
        }
    }
    std::fs::remove_file(bench.output("map.npy")).unwrap();
    // Lines that differ in their holes, their slowness or clearly in their heights are apart.
    let mut mask = vec![1.0; rows * cols];
    mask[5 * cols] = 0.0;
    let text: String = mask
        .chunks(cols)
        .map(|row| row.iter().map(|v| format!("{v} ")).collect::<String>() + "\n")
        .collect();
    let header = format!("ncols {cols}\nnrows {rows}\nxllcorner 0\nyllcorner 0\ncellsize 1\n");
    let mask = bench.input("mask.asc", header + &text);
    let slowness: Vec<f64> =
        (0..rows * cols).map(|k| 1.0 + 0.04 * (k % cols) as f64 / 20.0).collect();
    let slowness = bench.array("slowness.npy", &SIZE, &slowness);
    for (words, nearest) in
        [(format!("--mask {mask}"), 1.0), (format!("--slowness {slowness}"), 1.02)]
    {
        let line = format!("--spacing 1 {words} -s 3,0 --wrap columns -o map.npy");
        let output = bench.distance(&flat, &line);
        assert!(output.status.success(), "{}", stderr(&output));
        let found = bench.map("map.npy");
        assert!((found[3 * cols + cols - 1] - nearest).abs() < 1e-2, "{words}");
        assert_eq!(
            found.iter().filter(|d| d.is_infinite()).count(),
            usize::from(words.contains("mask"))
        );
    }
    let line = format!(
        "distance {flat} --spacing 1 --slowness {slowness} -s 3,0 --wrap columns:repeated -o n.npy"
    );
    let fresh = Workbench::new();
    fresh.refuse(&line, &["slowness of 1 and of 1.038", "columns:apart"]);
}

#[test]
fn built_in_surfaces_take_the_gluing_that_they_have() {
    for (surface, glue) in [
        ("closed-cylinder:21x31", "columns"),
        ("closed-torus:21x31", "both"),
        ("moebius-strip:21x31", "flipped-columns"),
        ("globe:21x31", "globe"),
        ("octahedral-sphere:21x21", "octahedral"),
        ("cube-sphere:13x20", "charts"),
        ("closed-cone:21x31", "auto"),
    ] {
        let bench = Workbench::new();
        bench.done(format!("distance builtin:{surface} -s 3,4 --engine cpu -o a.npy"));
        bench
            .done(format!("distance builtin:{surface} --glue {glue} -s 3,4 --engine cpu -o b.npy"));
        assert_eq!(bench.map("a.npy"), bench.map("b.npy"), "{surface}");
    }
    let bench = Workbench::new();
    let line = "distance builtin:closed-cylinder:21x31 --glue rows -s 3,4 -o map.npy";
    bench.refuse(line, &["closed already", "leave --glue out"]);
}

#[test]
fn a_pole_of_holes_is_named() {
    let bench = Workbench::new();
    let points = surface(&bench, "poles.npy", [21, 31], |row, col| {
        let [(sin, cos), (out, up)] =
            [TAU * (col % 30.0) / 30.0, PI * row / 20.0].map(f64::sin_cos);
        [out * cos, out * sin, up]
    });
    for row in [0, 20] {
        let header = "ncols 31\nnrows 21\nxllcorner 0\nyllcorner 0\ncellsize 1\n";
        let line = |at: usize| (if at == row { "0 " } else { "1 " }).repeat(31) + "\n";
        let mask =
            bench.input("mask.asc", format!("{header}{}", (0..21).map(line).collect::<String>()));
        let line = format!("distance {points} --mask {mask} -s 10,5 --glue globe -o map.npy");
        bench.refuse(&line, &["has only holes"]);
    }
}

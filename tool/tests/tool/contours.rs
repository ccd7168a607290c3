//! Contours compared with the truth, and levels without a contour.

use serde_json::Value;

use crate::workbench::{Workbench, json, notes, stderr};

#[test]
fn levels_that_the_map_lacks_have_no_curves() {
    let bench = Workbench::new();
    let line = "contours builtin:plane:17x17 -s 8,8 --levels=-1,0.2,99 --engine cpu --json \
                -o c.npy -o c.csv -o c.svg -o c.obj -o c.ply";
    let output = bench.done(line);
    assert!(stderr(&output).contains("no curve at -1, 99"), "{}", stderr(&output));
    let report = json(&output);
    let curves: Vec<_> =
        report["levels"].as_array().unwrap().iter().map(|l| &l["curves"]).collect();
    assert_eq!(curves, [&Value::from(0), &Value::from(1), &Value::from(0)]);
    let none = "contours builtin:plane:17x17 -s 8,8 --levels 99 --engine cpu -o n.npy -o n.csv";
    bench.done(none);
    assert!(bench.curves("n.npy").concat().is_empty());
    let wide = "contours builtin:plane:17x17 -s 8,8 --every 1e9 --engine cpu -o n.npy";
    let said = stderr(&bench.done(wide));
    assert!(said.contains("no curve: the distances on the grid run from 0 to 0.7"), "{said}");

    let bench = Workbench::new();
    for (levels, part) in [
        ("--levels nan", "finite"),
        ("--every 0", "positive"),
        ("--every=-2", "positive"),
        ("--every 1e-9", "too many"),
        ("--count 100000", "too many"),
        ("--count 0", "give 1 or more"),
        ("--count 3 --every 2", "cannot be used with"),
        ("", "--levels"),
    ] {
        let line = format!("contours builtin:plane:17x17 -s 8,8 {levels} -o c.npy --engine cpu");
        bench.refuse(&line, &[part]);
    }
}

#[test]
fn a_table_without_curves_has_the_header_of_one_with_them() {
    let bench = Workbench::new();
    for (command, none, some) in [
        ("contours builtin:plane:9x9 -s 4,4 -o", "--levels 99", "--levels 0.2"),
        ("offset builtin:plane:9x9 -s 4,4 -o", "--distances 99", "--distances 0.2"),
        ("voronoi builtin:plane:9x9 -s 4,1 --borders", "", "-s 4,7"),
        ("ridges builtin:plane:9x9 -s 4,1 -o", "--least-angle 170", "-s 4,7"),
    ] {
        let header = |words: &str| {
            bench.done(format!("{command} c.csv {words} --engine cpu"));
            let table = bench.text("c.csv");
            (table.lines().next().unwrap().to_owned(), table.lines().count())
        };
        let ((none, lines), (some, more)) = (header(none), header(some));
        assert_eq!((&none, lines), (&some, 1), "{command}");
        assert!(more > 1, "{command}");
    }
}

#[test]
fn levels_without_a_curve_get_a_reason() {
    let bench = Workbench::new();
    let said = |words: &str| notes(&bench.done(format!("contours {words} --engine cpu -o c.csv")));
    for shape in [[1, 20], [20, 1]] {
        let strip = bench.array("strip.npy", &shape, &[0.0; 20]);
        let line = if shape[0] == 1 { "row" } else { "column" };
        let said = said(&format!("{strip} --spacing 1 -s 0,0 --levels 4.75"));
        assert!(said.contains(&format!("no curve at 4.75: a grid of one {line}")), "{said}");
    }
    let flat = bench.flat(9, 9);
    let corner = said(&format!("{flat} --spacing 1 -s 0,0 --levels 11.31370849898476"));
    assert!(corner.contains("11.31371 is the largest distance"), "{corner}");
    let curve = bench.input("line.csv", "0,0\n8,0\n");
    let border = said(&format!("{flat} --spacing 1 --source-curve {curve} --levels 8"));
    assert_eq!(border, "");
}

#[test]
fn curves_cut_beside_a_source_are_reported() {
    let bench = Workbench::new();
    let plane = bench.flat(9, 9);
    let said = |line: &str| {
        let line = line.replace("PLANE", &format!("{plane} --spacing 1 --engine cpu --json"));
        let output = bench.done(&line);
        let curves = json(&output)["levels"][0]["curves"].as_u64().unwrap();
        assert!(!String::from_utf8(output.stdout.clone()).unwrap().contains("-0.0"));
        (curves, notes(&output))
    };
    // The corners of the source's cell are 0.42 to 0.99 away.
    let (none, text) = said("contours PLANE -s 4.3,4.3 --levels 0.1");
    assert!(none == 0 && text.contains("no curve at 0.1: the distances on the grid run from 0.42"));
    let (some, text) = said("contours PLANE -s 4.3,4.3 --levels 0.6");
    assert!(some > 0 && text.contains("the curves at 0.6 run between"), "{some} {text}");
    assert_eq!(said("contours PLANE -s 4.3,4.3 --levels 1"), (1, String::new()));
    // Around a grid point, circles are whole however small.
    assert_eq!(said("contours PLANE -s 4,4 --levels 0.001"), (1, String::new()));
    let line = bench.input("line.csv", "4.2,1.5\n4.2,6.5\n");
    let near = format!("offset PLANE --source-curve {line} --distances 0.3");
    let (_, text) = said(&near);
    assert!(text.contains("the curves at 0.3 run between"), "{text}");
    assert_eq!(said(&near.replace("0.3", "1.5")).1, "");

    let bench = Workbench::new();
    let before = format!("offset {plane} -s 4,4 --engine cpu --distances 1,-1 -o c.npy");
    bench.refuse(&before, &["--distances -1", "nearer than the sources"]);
}

#[test]
fn strips_are_drawn_in_both_views() {
    let bench = Workbench::new();
    for (rows, cols, source) in [(2, 9, "1,0"), (9, 2, "0,1"), (2, 2, "0,0"), (1, 9, "0,2")] {
        let flat = bench.array("strip.npy", &[rows, cols], &vec![0.0; rows * cols]);
        for view in ["map", "shaded"] {
            let line = format!(
                "contours {flat} --spacing 1 -s {source} --levels 0.5 --engine cpu -o s.csv \
                 --picture s.png --view {view}"
            );
            bench.done(&line);
            let line = format!(
                "path {flat} --spacing 1 -s {source} --from {},{} --engine cpu -o p.npy \
                 --picture p.png --view {view}",
                rows - 1,
                cols - 1
            );
            bench.done(&line);
        }
    }
}

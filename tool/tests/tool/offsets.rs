//! Offset curves through the tool.

use crate::workbench::Workbench;

#[test]
fn offsets_keep_to_their_side() {
    let bench = Workbench::new();
    let flat = bench.flat(41, 61);
    // The line runs from west to east, so that north is on its left.
    let line = bench.input("line.csv", "20,15\n20,45\n");
    let offset = |rest: &str| {
        let line = format!(
            "offset {flat} --spacing 1 --source-curve {line} --distances 8 --engine cpu --json \
             -o o.npy -o o.csv {rest}"
        );
        let level = bench.json(&line)["levels"][0].clone();
        assert_eq!((&level["level"], &level["curves"]), (&8.0.into(), &1.into()), "{rest}");
        (bench.curves("o.npy").remove(0), level)
    };
    let half = 30.0 + std::f64::consts::PI * 8.0;
    let (all, level) = offset("");
    assert_eq!(level["closed"], 1);
    // Within a cell an offset curve is straight and cuts off bends of the front, so its length is approximate.
    assert!((level["length"].as_f64().unwrap() - 2.0 * half).abs() < 0.02 * half, "{level}");
    assert_eq!(all.first(), all.last());
    for (side, sign) in [("left", 1.0), ("right", -1.0)] {
        let (curve, level) = offset(&format!("--side {side}"));
        assert_eq!(level["closed"], 0);
        assert!((level["length"].as_f64().unwrap() - half).abs() < 0.02 * half, "{level}");
        for [row, col, ..] in curve {
            assert!(sign * (20.0 - row) > -0.1, "{side}: {row},{col}");
            let beyond = (15.0 - col).max(col - 45.0).max(0.0);
            // Around the ends of a curve, where its front turns abruptly, the map itself is 0.17 of a cell
            // off (measured, with any wavefront).
            let tolerance = if beyond > 0.0 { 0.2 } else { 0.1 };
            assert!(((row - 20.0).hypot(beyond) - 8.0).abs() < tolerance, "{side}: {row},{col}");
        }
        let table = bench.text("o.csv");
        let header = table.lines().next().unwrap();
        assert!(header.contains(",level,length,side,"), "{header}");
        assert!(table.lines().nth(1).unwrap().contains(&format!(",{side},")));
    }

    // Two curves that are not connected, one of them closed.
    let loops = bench.input("loop.csv", "5,50\n5,56\n11,56\n11,50\n5,50\n");
    let line = format!(
        "offset {flat} --spacing 1 --source-curve {line} --source-curve {loops} --distances 2,3.5 \
         --engine cpu --json -o two.svg --picture two.png"
    );
    let report = bench.json(&line);
    // At distance 2 there is a closed curve around the line, one outside the square and one inside it. At distance 3.5
    // the one inside is missing, since the middle of the square is only 3 away from its sides.
    assert_eq!(report["levels"][0]["closed"], 3);
    assert_eq!(report["levels"][1]["closed"], 2);

    let bench = Workbench::new();
    for (rest, part) in [
        ("-s 3,3 --distances 2 --side left", "side"),
        ("-s 3,3", "--distances"),
        ("-s 3,3 --distances nan", "finite"),
        ("--distances 3", "--source"),
        ("--source-curve nowhere.csv --distances 3", "nowhere.csv"),
    ] {
        let line = format!("offset {flat} --spacing 1 {rest} --engine cpu -o o.npy");
        bench.refuse(&line, &[part]);
    }
}

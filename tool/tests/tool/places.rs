//! Sources and starts in the files that people have: tables with start values, arrays, map coordinates,
//! GeoJSON.

use geosweep::io::read_map;
use serde_json::{Value, json};

use crate::formats::geotiff;
use crate::workbench::{Workbench, json, notes, stderr};

const CORNER: [f64; 6] = [0.0, 0.0, 0.0, 500_000.0, 4_000_000.0, 0.0];
const UTM: [u16; 12] = [1024, 0, 1, 1, 3072, 0, 1, 32616, 3076, 0, 1, 9001];

/// Returns the middle of a pixel of a [`geotiff`].
fn coordinates(row: f64, col: f64) -> [f64; 2] {
    [500_000.0 + (col + 0.5) * 30.0, 4_000_000.0 - (row + 0.5) * 20.0]
}

/// Start values count in files of any kind, in all commands that read sources.
#[test]
fn start_values_of_files_are_those_of_options() {
    let bench = Workbench::new();
    let flat = bench.flat(11, 13);
    let sources = [[5.0, 2.0, 0.5], [3.0, 10.0, 4.0]];
    let files = [
        bench.input("named.csv", "id,t0,col,row\na,0.5,2,5\nb,4,10,3\n"),
        bench.input("excel.csv", "\u{feff}row;col;Start\r\n5;2;0,5\r\n3;10;4\r\n"),
        bench.input("pandas.csv", ",row,col,time\n0,5.0,2,0.5\n1,3.0,10,4.0\n"),
        bench.input("r.csv", "\"\",\"row\",\"col\",\"initial\"\n\"1\",5,2,0.5\n\"2\",3,10,4\n"),
        bench.input("savetxt.txt", "# row col t0\n5 2 0.5\n3 10 4\n"),
        bench.array("sources.npy", &[2, 3], sources.as_flattened()),
    ];
    let said = sources.map(|[row, col, start]| format!("-s {row},{col},{start}")).join(" ");
    let tail = "--spacing 1 --engine cpu";
    bench.done(format!("distance {flat} {said} {tail} -o expected.npy"));
    bench.done(format!("voronoi {flat} {said} {tail} -o labels.npy"));
    bench.done(format!("contours {flat} {said} {tail} --levels 3,5 -o contours.csv"));
    let path = format!("path {flat} {said} {tail} --from 9,9 --json");
    let path = bench.json(&path)["paths"].clone();
    for file in &files {
        let given = format!("--source-points {file} {tail}");
        let output = bench.done(format!("distance {flat} {given} -o found.npy"));
        assert_eq!(bench.read("found.npy"), bench.read("expected.npy"), "{file}");
        let unused = file.ends_with("named.csv");
        assert_eq!(
            notes(&output).contains("named.csv: the column id is not used"),
            unused,
            "{file}"
        );
        bench.done(format!("voronoi {flat} {given} -o found.npy"));
        assert_eq!(bench.read("found.npy"), bench.read("labels.npy"), "{file}");
        bench.done(format!("contours {flat} {given} --levels 3,5 -o found.csv"));
        assert_eq!(bench.text("found.csv"), bench.text("contours.csv"), "{file}");
        let found = bench.json(format!("path {flat} {given} --from 9,9 --json"));
        assert_eq!(found["paths"], path, "{file}");

        // Rows of a matrix start with the start value too.
        let line = format!("pairwise {flat} --spacing 1 --engine cpu --sources {file} -o rows.npy");
        bench.done(&line);
        let rows = read_map(&bench.output("rows.npy")).unwrap();
        for ([row, col, start], found) in sources.iter().zip(rows.values.chunks(11 * 13)) {
            for (index, distance) in found.iter().enumerate() {
                let (r, c) = ((index / 13) as f64, (index % 13) as f64);
                let exact = start + (r - row).hypot(c - col);
                assert!((distance - exact).abs() < 1e-4, "{file}: {distance} {exact}");
            }
        }
    }
}

#[test]
fn curves_start_with_one_value() {
    let bench = Workbench::new();
    let flat = bench.flat(9, 9);
    let line = |curve: &str| {
        format!("distance {flat} --spacing 1 --engine cpu --source-curve {curve} -o map.npy")
    };
    let curve = bench.input("curve.csv", "curve,row,col,t0\n0,0,0,2\n0,8,0,2\n1,0,8,5\n1,8,8,5\n");
    let array = bench.array(
        "curve.npy",
        &[5, 3],
        &[0., 0., 2., 8., 0., 2., f64::NAN, f64::NAN, f64::NAN, 0., 8., 5., 8., 8., 5.],
    );
    for file in [curve, array] {
        bench.done(line(&file));
        for (index, distance) in bench.map("map.npy").iter().enumerate() {
            let col = (index % 9) as f64;
            let exact = (2.0 + col).min(5.0 + 8.0 - col);
            assert!((distance - exact).abs() < 1e-4, "{file} {index}: {distance} {exact}");
        }
    }
    let bench = Workbench::new();
    let differing = bench.input("differing.csv", "row,col,t0\n0,0,2\n4,0,2\n8,0,3\n");
    let line = format!("distance {} --source-curve {differing} -o map.npy", bench.flat(9, 9));
    bench.refuse(&line, &["differing.csv", "line 4", "--source-points"]);
}

/// The places are the same by row and column, in map coordinates, in tables of map coordinates and in GeoJSON.
#[test]
fn map_coordinates_are_places_on_the_grid() {
    let bench = Workbench::new();
    let dem = bench.input("dem.tif", geotiff(21, 31, CORNER, &UTM));
    let places = [([4.0, 6.0], 0.0), ([15.25, 20.5], 100.0)];
    let [a, b] = places.map(|([row, col], _)| coordinates(row, col));
    let rows = "-s 4,6 -s 15.25,20.5,100";
    let point = |[x, y]: [f64; 2], start: f64| {
        json!({"type": "Feature", "properties": {"t0": start, "name": "a"},
               "geometry": {"type": "Point", "coordinates": [x, y, 99.0]}})
    };
    let collection = |crs: Value| {
        json!({"type": "FeatureCollection", "crs": crs, "features": [point(a, 0.0), point(b, 100.0)]})
            .to_string()
    };
    let named = json!({"type": "name", "properties": {"name": "urn:ogc:def:crs:EPSG::32616"}});
    let table = |names: &str| format!("{names},t0\n{},{},0\n{},{},100\n", a[0], a[1], b[0], b[1]);
    bench.done(format!("distance {dem} {rows} --engine cpu -o expected.npy"));
    for (given, note) in [
        (format!("--source-xy {},{} --source-xy {},{},100", a[0], a[1], b[0], b[1]), ""),
        (format!("--source-points {}", bench.input("xy.csv", table("x,y"))), ""),
        (format!("--source-points {}", bench.input("en.csv", table("Easting,Northing"))), ""),
        (
            format!("--source-points {}", bench.input("named.geojson", collection(named))),
            "property name",
        ),
        (
            format!("--source-points {}", bench.input("bare.json", collection(Value::Null))),
            "taken as the surface's, EPSG:32616",
        ),
        (
            format!("--source-curve {}", bench.input("points.geojson", collection(Value::Null))),
            "EPSG:32616",
        ),
    ] {
        let output = bench.done(format!("distance {dem} {given} --engine cpu -o found.npy"));
        assert_eq!(bench.read("found.npy"), bench.read("expected.npy"), "{given}");
        assert!(notes(&output).contains(note), "{given}: {}", notes(&output));
    }

    let path = |words: &str| bench.json(format!("path {dem} {rows} {words} --json"));
    let expected = path("--from 15.25,20.5")["paths"].clone();
    let xy = format!("--from-xy {},{}", b[0], b[1]);
    let file = bench.input("start.csv", format!("x,y\n{},{}\n", b[0], b[1]));
    assert_eq!(path(&xy)["paths"], expected);
    assert_eq!(path(&format!("--from-file {file}"))["paths"], expected);
}

/// Lines and the rings of polygons are curves. Contours as GeoJSON are sources again.
#[test]
fn lines_and_polygons_are_curves() {
    let bench = Workbench::new();
    let dem = bench.input("dem.tif", geotiff(21, 31, CORNER, &UTM));
    let places = [[4.0, 6.0], [4.0, 20.0], [15.0, 20.0]];
    let line = places.map(|[row, col]| coordinates(row, col));
    let ring = [line[0], line[1], line[2], line[0]];
    for (kind, coordinates, rows) in [
        ("LineString", json!(line), "4,6\n4,20\n15,20\n"),
        ("MultiLineString", json!([line]), "4,6\n4,20\n15,20\n"),
        ("Polygon", json!([ring]), "4,6\n4,20\n15,20\n4,6\n"),
        ("MultiPolygon", json!([[ring]]), "4,6\n4,20\n15,20\n4,6\n"),
    ] {
        let curve = bench.input("curve.csv", rows);
        let json = json!({"type": kind, "coordinates": coordinates}).to_string();
        let json = bench.input("curve.geojson", json);
        bench.done(format!("distance {dem} --source-curve {curve} --engine cpu -o a.npy"));
        bench.done(format!("distance {dem} --source-curve {json} --engine cpu -o b.npy"));
        assert_eq!(bench.read("a.npy"), bench.read("b.npy"), "{kind}");
        let vertices = bench.done(format!("distance {dem} --source-points {json} -o c.npy"));
        assert!(notes(&vertices).contains("only the vertices"), "{}", notes(&vertices));
    }
    bench.done(format!("contours {dem} -s 10,15 --levels 100 --engine cpu -o c.geojson -o c.csv"));
    for file in ["c.geojson", "c.csv"] {
        let curve = bench.output(file);
        let curve = curve.to_str().unwrap();
        bench.done(format!("distance {dem} --source-curve {curve} --engine cpu -o {file}.npy"));
    }
    let [a, b] = ["c.geojson.npy", "c.csv.npy"].map(|name| bench.map(name));
    assert!(
        a.iter().zip(&b).all(|(a, b)| (a - b).abs() < 1e-3),
        "GeoJSON has tenths of millimetres"
    );
}

#[test]
fn impossible_places_are_refused_with_the_extent() {
    let bench = Workbench::new();
    let dem = bench.input("dem.tif", geotiff(21, 31, CORNER, &UTM));
    let flat = bench.flat(9, 9);
    let degrees = r#"{"type":"Point","coordinates":[-86.9,36.1]}"#;
    let degrees = bench.input("degrees.geojson", degrees);
    let other = r#"{"type":"FeatureCollection","crs":{"type":"name","properties":{"name":"EPSG:3857"}},
                   "features":[{"type":"Feature","properties":{},"geometry":{"type":"Point","coordinates":[1,2]}}]}"#;
    let other = bench.input("other.geojson", other);
    let lonlat = bench.input("lonlat.csv", "lon,lat\n-86.9,36.1\n");
    let xy = bench.input("xy.csv", "x,y\n1,2\n");
    let extent = "500015 to 500915 and from y 3999590 to 3999990";
    for (surface, words, parts) in [
        (
            &dem,
            "--source-xy 400000,3999800".into(),
            &["400000,3999800", "outside the grid", extent, "EPSG:32616"][..],
        ),
        (&dem, "--source-xy -86.9,36.1".into(), &["longitude and latitude", "ogr2ogr", extent]),
        (&dem, "--source-xy 1".into(), &["X,Y[,T0]"]),
        (&dem, "--source-xy 1,x".into(), &["finite number"]),
        (
            &dem,
            format!("--source-points {degrees}"),
            &["degrees.geojson", "feature 1", "-86.9", extent],
        ),
        (&dem, format!("--source-points {other}"), &["other.geojson", "EPSG:3857", "EPSG:32616"]),
        (
            &dem,
            format!("--source-curve {lonlat}"),
            &["lonlat.csv", "longitude and latitude", "EPSG:32616"],
        ),
        (&dem, format!("--source-points {xy}"), &["xy.csv", "line 2", extent]),
        (&flat, format!("--source-points {xy}"), &["xy.csv", "georeferenced"]),
        (&flat, "--source-xy 1,2".into(), &["--source-xy 1,2", "georeferenced"]),
    ] {
        bench.refuses(&bench.distance(surface, &format!("{words} -o map.npy")), parts);
    }
    let line = format!("pairwise {dem} --sources {xy} -o d.npy");
    bench.refuse(&line, &["xy.csv", "outside the grid"]);
    let [x, y] = coordinates(3.5, 4.0);
    let between = bench.input("between.csv", format!("x,y\n{x},{y}\n"));
    let line = format!("pairwise {dem} --sources {between} -o d.npy");
    bench.refuse(&line, &["between.csv", "between points of the grid"]);
}

/// A message stays short, whatever it quotes from a file or an argument.
#[test]
fn messages_quote_excerpts() {
    let bench = Workbench::new();
    let long = "1,2".repeat(200_000);
    let features =
        r#"{"type":"Feature","properties":{},"geometry":{"type":"Point","coordinates":[1,2]}}"#;
    let features = vec![features; 20_000].join(",");
    let collection = format!(r#"{{"type":"FeatureCollection","features":[{features}]}}"#);
    let files = [
        ("big.geojson", collection.clone()),
        ("big.json", format!("{collection}x")),
        ("big.csv", collection[1..].into()),
        ("line.csv", long.clone()),
        ("header.csv", format!("{}\n1,2\n", "name,".repeat(100_000))),
        ("names.csv", format!("row,col,{}\n1,2\n", "name,".repeat(100_000))),
        ("field.csv", format!("row,col\n1,{}\n", "9".repeat(500_000))),
        ("big.xml", format!("<gpx>{}</gpx>", "<wpt/>".repeat(100_000))),
    ];
    for (name, content) in files {
        let file = bench.input(name, content);
        for option in ["--source-points", "--source-curve"] {
            let output = bench.distance("builtin:plane:9x9", &format!("{option} {file} -o o.npy"));
            bench.refuses(&output, &[name]);
            assert!(stderr(&output).len() < 1000, "{name}: {} bytes", stderr(&output).len());
        }
    }
    let long = "1,".repeat(30_000) + "x";
    for line in [
        format!("distance builtin:plane:9x9 -o o.npy -s {long}"),
        format!("distance builtin:plane:9x9 -o o.npy --source-xy {long}"),
        format!("distance builtin:plane:9x9 -o o.npy -s 1,1 --wavefront {long}"),
        format!("distance builtin:{long} -o o.npy -s 1,1"),
        format!("distance {long} -o o.npy -s 1,1"),
        format!("distance builtin:plane:9x9 -s 1,1 -o {long}"),
        format!("distance builtin:plane:9x9 -o o.npy -s 1,1 --{long}"),
        format!("contours builtin:plane:9x9 -o o.npy -s 1,1 --levels {long}"),
        format!("contours builtin:plane:9x9 -o o.npy -s 1,1 --count {long}"),
        format!("path builtin:plane:9x9 -o o.npy -s 1,1 --from {long}"),
        format!("pairwise builtin:plane:9x9 -o o.npy --sources 1..{long}"),
        format!("sample builtin:plane:9x9 -o o.npy -k {long}"),
        long.clone(),
    ] {
        let output = bench.run(&line);
        bench.refuses(&output, &[]);
        assert!(stderr(&output).len() < 2000, "{}: {}", &line[..60], stderr(&output).len());
    }
}

#[test]
fn masks_of_integers_are_taken() {
    let bench = Workbench::new();
    let flat = bench.flat(2, 3);
    let masks: [(&str, Vec<u8>); 4] = [
        ("<i8", [1i64, 0, -1, 1, 7, 256].iter().flat_map(|v| v.to_le_bytes()).collect()),
        (">i4", [1i32, 0, -1, 1, 7, 256].iter().flat_map(|v| v.to_be_bytes()).collect()),
        ("<u2", [1u16, 0, 65535, 1, 7, 256].iter().flat_map(|v| v.to_le_bytes()).collect()),
        ("|b1", vec![1, 0, 1, 1, 1, 1]),
    ];
    for (descr, data) in masks {
        let header = format!("{{'descr': '{descr}', 'fortran_order': False, 'shape': (2, 3)}}");
        let length = [header.len() as u8, 0];
        let bytes = [b"\x93NUMPY\x01\x00", &length[..], header.as_bytes(), &data].concat();
        let mask = bench.input("mask.npy", bytes);
        let report =
            json(&bench.distance(&flat, &format!("-s 0,0 --spacing 1 --mask {mask} --json")));
        assert_eq!(report["points"], 5, "{descr}");
    }
}

/// A front does not pass along a line of points that touch only at their corners, as --mask and limits.md
/// say. It passes along points side by side.
#[test]
fn lines_of_a_mask_are_passed_along_sides_alone() {
    let bench = Workbench::new();
    for size in [5usize, 12, 23] {
        let flat = bench.flat(size, size);
        let diagonal = |width: usize| {
            let there = |index: usize| (index / size).abs_diff(index % size) < width;
            let mask: Vec<u8> = (0..size * size).map(|index| u8::from(there(index))).collect();
            let mut bytes = Vec::new();
            let mut encoder = png::Encoder::new(&mut bytes, size as u32, size as u32);
            encoder.set_color(png::ColorType::Grayscale);
            encoder.write_header().unwrap().write_image_data(&mask).unwrap();
            bench.input("mask.png", bytes)
        };
        let reached = |width| {
            let mask = diagonal(width);
            let words = format!("-s 0,0 --spacing 1 --mask {mask} --json");
            let report = json(&bench.distance(&flat, &words));
            (report["reached"].as_u64().unwrap(), report["points"].as_u64().unwrap())
        };
        assert_eq!(reached(1), (1, size as u64));
        let line = format!("distance {flat} -s 0,0 --spacing 1 --mask {} --json", diagonal(1));
        let said = notes(&bench.done(&line));
        assert!(
            said.contains("1 point is not reached") && said.contains("only at a corner"),
            "{said}"
        );
        let (reached, points) = reached(2);
        assert_eq!(reached, points);
    }
    let help = String::from_utf8(bench.run("distance --help").stdout).unwrap();
    let words = help.split_whitespace().collect::<Vec<_>>().join(" ");
    assert!(words.contains("touch only at a corner"), "{help}");
}

#[test]
fn numbers_in_messages_have_few_digits() {
    let bench = Workbench::new();
    for (spacing, largest) in [
        ("1e-9", "1.131371e-8"),
        ("1e-4", "0.001131371"),
        ("1", "11.31371"),
        ("1e6", "11313708"),
        ("1e10", "1.131371e11"),
    ] {
        let flat = bench.flat(9, 9);
        let output = bench.distance(&flat, &format!("-s 0,0 --spacing {spacing} -o map.npy"));
        assert!(
            stderr(&output).contains(&format!("largest distance {largest};")),
            "{}",
            stderr(&output)
        );
    }
    let bench = Workbench::new();
    let mut heights = vec![0.0; 11 * 11];
    for (row, col, height) in [(5, 5, 1e200), (0, 10, 1e38), (10, 3, -1e300)] {
        heights[row * 11 + col] = height;
        let far = bench.array("far.npy", &[11, 11], &heights);
        heights[row * 11 + col] = 0.0;
        let output = bench.distance(&far, "-s 0,0 --spacing 1 -o map.npy");
        bench.refuses(&output, &[&format!("row {row}, column {col}: {height:e}")]);
    }
    let output = bench.distance("builtin:plane:9x9", "-s 1e38,0 -o map.npy");
    bench.refuses(&output, &["source 1e38,0"]);
}

//! Curves by the tool: contours and paths in every format, against truth, and refusals.
#![cfg(feature = "cli")]

mod bench;

use std::fs;
use std::io::Cursor;
use std::process::Output;

use bench::{Bench, json, map, stderr};
use geosweep::glam::{DVec2, DVec3};
use geosweep::io::read_map;
use geosweep::surface::builtin::Builtin;
use serde_json::Value;

fn run(bench: &Bench, line: &str) -> Output {
    bench.run(line.split_whitespace())
}

/// Runs a line that must succeed.
fn done(bench: &Bench, line: &str) -> Output {
    let output = run(bench, line);
    assert!(output.status.success(), "{line}: {}", stderr(&output));
    output
}

/// The rows of a float64 array (K, 5), split where they are NaN.
fn curves(bytes: &[u8]) -> Vec<Vec<[f64; 5]>> {
    let length = u16::from_le_bytes([bytes[8], bytes[9]]) as usize;
    let header = std::str::from_utf8(&bytes[10..10 + length]).unwrap();
    assert!(header.contains("'descr': '<f8'") && header.contains(", 5)"), "{header}");
    let values: Vec<f64> =
        bytes[10 + length..].as_chunks().0.iter().map(|bytes| f64::from_le_bytes(*bytes)).collect();
    let rows = values.as_chunks::<5>().0;
    rows.split(|row| row[0].is_nan()).map(<[_]>::to_vec).collect()
}

fn read(bench: &Bench, name: &str) -> Vec<u8> {
    fs::read(bench.output(name)).unwrap()
}

fn text(bench: &Bench, name: &str) -> String {
    String::from_utf8(read(bench, name)).unwrap()
}

/// Great circles: within a tenth of a cell, which is what contours are held to.
#[test]
fn contours_on_the_sphere_are_circles() {
    let bench = Bench::new();
    let (rows, cols, source) = (129, 129, [64, 60]);
    let line = "contours builtin:sphere:129x129 -s 64,60 --levels 0.3,0.6 -o c.npy --engine cpu";
    done(&bench, line);
    let surface = Builtin::Sphere.surface(rows, cols).unwrap();
    let from = surface.position(source[0], source[1]).unwrap();
    let cell = from.distance(surface.position(source[0] + 1, source[1]).unwrap());
    let curves = curves(&read(&bench, "c.npy"));
    assert_eq!(curves.len(), 2);
    for (curve, level) in curves.iter().zip([0.3, 0.6]) {
        assert_eq!(curve.first(), curve.last(), "closed");
        for [_, _, x, y, z] in curve {
            let at = DVec3::new(*x, *y, *z);
            let distance = from.length() * at.angle_between(from);
            assert!((distance - level).abs() < 0.1 * cell, "{distance} {level}");
        }
    }
}

#[test]
fn every_format_holds_the_same_curves() {
    let bench = Bench::new();
    let line = "contours builtin:peaks:41x37 -s 20,18 --count 5 --engine cpu --json \
                -o c.npy -o c.csv -o c.svg -o c.ply -o c.obj";
    let report = json(&done(&bench, line));
    assert_eq!(bench.outputs(), ["c.csv", "c.npy", "c.obj", "c.ply", "c.svg"]);
    let levels = report["levels"].as_array().unwrap();
    assert_eq!(levels.len(), 5);
    let total = |key: &str| levels.iter().map(|level| level[key].as_u64().unwrap()).sum::<u64>();
    let (count, closed, vertices) =
        (total("curves") as usize, total("closed") as usize, total("vertices") as usize);
    assert!(closed >= 1 && count > closed, "{report}");

    let npy = curves(&read(&bench, "c.npy"));
    assert_eq!(npy.len(), count);
    assert_eq!(npy.iter().map(Vec::len).sum::<usize>(), vertices + closed);

    let mut table = csv::Reader::from_path(bench.output("c.csv")).unwrap();
    let header = ["curve", "kind", "level", "length", "closed", "row", "col", "x", "y", "z"];
    assert_eq!(table.headers().unwrap(), &header[..]);
    let rows: Vec<_> = table.records().map(Result::unwrap).collect();
    assert_eq!(rows.len(), vertices);
    for (index, curve) in npy.iter().enumerate() {
        let own: Vec<_> = rows.iter().filter(|row| row[0] == *index.to_string()).collect();
        assert_eq!(own.len() + usize::from(&own[0][4] == "1"), curve.len());
        for (row, expected) in own.iter().zip(curve) {
            let values: Vec<f64> = (5..10).map(|k| row[k].parse().unwrap()).collect();
            assert_eq!(values[..], expected[..], "shortest digits that read back");
        }
    }

    let svg = text(&bench, "c.svg");
    let paths = svg::read(&svg).unwrap().filter_map(|event| match event {
        svg::parser::Event::Tag("path", svg::node::element::tag::Type::Start, attributes) => {
            Some(attributes)
        }
        svg::parser::Event::Error(error) => panic!("{error}"),
        _ => None,
    });
    for (attributes, curve) in paths.zip(&npy) {
        assert_eq!(&*attributes["class"], "contour");
        let data = attributes["d"].trim_end_matches('Z');
        let places: Vec<DVec2> = data
            .split(['M', 'L'])
            .skip(1)
            .map(|pair| pair.split_once(',').unwrap())
            .map(|(x, y)| DVec2::new(x.parse().unwrap(), y.parse().unwrap()))
            .collect();
        let closed = usize::from(attributes["d"].ends_with('Z'));
        assert_eq!(places.len() + closed, curve.len());
        for (place, [row, col, ..]) in places.iter().zip(curve) {
            assert!(place.distance(DVec2::new(*col, *row)) < 1e-4, "columns right, rows down");
        }
    }
    assert_eq!(svg.matches("<path").count(), count);
    // 36 columns and 40 rows of cells in a margin of a fiftieth of 40.
    assert!(svg.contains("viewBox=\"-0.8 -0.8 37.6 41.6\""), "{}", &svg[..200]);

    let obj = text(&bench, "c.obj");
    let places: Vec<Vec<f64>> = obj
        .lines()
        .filter_map(|line| line.strip_prefix("v "))
        .map(|line| line.split(' ').map(|word| word.parse().unwrap()).collect())
        .collect();
    assert_eq!(places.len(), vertices);
    let elements = obj.lines().filter_map(|line| line.strip_prefix("l "));
    for (element, curve) in elements.zip(&npy) {
        let numbers: Vec<usize> = element.split(' ').map(|word| word.parse().unwrap()).collect();
        assert_eq!(numbers.len(), curve.len());
        for (number, expected) in numbers.iter().zip(curve) {
            assert_eq!(places[number - 1][..], expected[2..]);
        }
    }
    assert_eq!(obj.lines().filter(|line| line.starts_with("l ")).count(), count);

    let ply = read(&bench, "c.ply");
    let end = b"end_header\n";
    let data = ply.windows(end.len()).position(|window| window == end).unwrap() + end.len();
    let header = std::str::from_utf8(&ply[..data]).unwrap();
    let edges = vertices - count + closed;
    assert!(header.contains(&format!("element vertex {vertices}\n")), "{header}");
    assert!(header.contains(&format!("element edge {edges}\n")), "{header}");
    assert_eq!(ply.len() - data, vertices * 15 + edges * 8);
    let float = |at: usize| f32::from_le_bytes(ply[at..at + 4].try_into().unwrap());
    for (index, place) in places.iter().enumerate() {
        for (axis, coordinate) in place.iter().enumerate() {
            assert_eq!(float(data + 15 * index + 4 * axis), *coordinate as f32);
        }
    }
}

/// A flat GeoTIFF of 30 x 20 m pixels, with GeoTIFF's keys after the header.
fn geotiff(rows: u32, cols: u32, tie_point: [f64; 6], keys: &[u16]) -> Vec<u8> {
    use tiff::encoder::{TiffEncoder, colortype::GrayI16};
    use tiff::tags::Tag;
    let mut file = Cursor::new(Vec::new());
    let mut encoder = TiffEncoder::new(&mut file).unwrap();
    let mut image = encoder.new_image::<GrayI16>(cols, rows).unwrap();
    let tags = image.encoder();
    tags.write_tag(Tag::ModelPixelScaleTag, &[30.0, 20.0, 0.0][..]).unwrap();
    tags.write_tag(Tag::ModelTiepointTag, &tie_point[..]).unwrap();
    let keys = [&[1, 1, 0, keys.len() as u16 / 4], keys].concat();
    tags.write_tag(Tag::GeoKeyDirectoryTag, &keys[..]).unwrap();
    image.write_data(&vec![250i16; (rows * cols) as usize]).unwrap();
    file.into_inner()
}

#[test]
fn curves_on_a_geotiff_lie_where_it_does() {
    let bench = Bench::new();
    let corner = [0.0, 0.0, 0.0, 500_000.0, 4_000_000.0, 0.0];
    let utm = [1024, 0, 1, 1, 3072, 0, 1, 32616];
    let dem = bench.input("dem.tif", geotiff(41, 31, corner, &utm));
    let line = "-s 20,15 --every 100 -o c.geojson --engine cpu";
    let output = done(&bench, &format!("contours {dem} {line}"));
    assert!(stderr(&output).contains("dem.tif: pixel size and heights are taken as metres"));
    let said =
        bench.input("said.tif", geotiff(41, 31, corner, &[&utm[..], &[3076, 0, 1, 9001]].concat()));
    let output = done(&bench, &format!("contours {said} -s 20,15 --every 100 --json"));
    assert!(!stderr(&output).contains("metres"), "{}", stderr(&output));
    let file: Value = serde_json::from_str(&text(&bench, "c.geojson")).unwrap();
    assert_eq!(file["crs"]["properties"]["name"], "urn:ogc:def:crs:EPSG::32616");
    // Pixels lie by their middles: half a pixel from the corner.
    let source = DVec2::new(500_000.0 + 15.5 * 30.0, 4_000_000.0 - 20.5 * 20.0);
    let features = file["features"].as_array().unwrap();
    assert!(features.len() >= 4, "{}", features.len());
    for feature in features {
        assert_eq!(feature["geometry"]["type"], "LineString");
        assert_eq!(feature["properties"]["kind"], "contour");
        let level = feature["properties"]["level"].as_f64().unwrap();
        for place in feature["geometry"]["coordinates"].as_array().unwrap() {
            let [east, north, height] = [0, 1, 2].map(|k| place[k].as_f64().unwrap());
            let distance = source.distance(DVec2::new(east, north));
            assert!((distance - level).abs() < 0.1 * 20.0, "{distance} {level}");
            assert_eq!(height, 250.0);
        }
    }

    // Degrees: on WGS 84 plain GeoJSON, elsewhere with the system's name.
    for (epsg, named) in [(4326, false), (4269, true)] {
        let degrees = [1024, 0, 1, 2, 2048, 0, 1, epsg];
        let dem = bench.input("degrees.tif", geotiff(41, 31, corner, &degrees));
        done(&bench, &format!("contours {dem} --spacing 1 -s 20,15 --count 2 -o d.geojson"));
        let file: Value = serde_json::from_str(&text(&bench, "d.geojson")).unwrap();
        assert_eq!(!file["crs"].is_null(), named, "{epsg}");
    }
}

#[test]
fn geojson_asks_for_a_georeference() {
    let corner = [0.0; 6];
    for (name, bytes, part) in [
        ("untold.tif", geotiff(9, 9, corner, &[1024, 0, 1, 1]), "ProjectedCRS"),
        ("model.tif", geotiff(9, 9, corner, &[]), "GTModelType"),
    ] {
        let bench = Bench::new();
        let dem = bench.input(name, bytes);
        let line = format!("contours {dem} --spacing 1 -s 4,4 --count 2 -o c.geojson -o c.npy");
        bench.refuses(&run(&bench, &line), &["c.geojson", "georeferenced", part]);
    }
    let bench = Bench::new();
    let line = "path builtin:plane:9x9 -s 4,4 --from 1,1 -o p.geojson";
    bench.refuses(&run(&bench, line), &["p.geojson", "built-in"]);
    let flat = bench.flat(9, 9);
    let line = format!("path {flat} --spacing 1 -s 4,4 --from 1,1 -o p.geojson");
    bench.refuses(&run(&bench, &line), &["p.geojson", "GeoTIFF"]);
}

#[test]
fn paths_run_from_their_starts_to_the_source() {
    let bench = Bench::new();
    let starts = bench.input("starts.csv", "row,col\n3.5,50\n60,60.25\n");
    let line = format!(
        "path builtin:sphere:65x65 -s 30,20 --from 10,40 --from 30,20 --from-file {starts} \
         --engine cpu --json -o p.npy -o p.csv"
    );
    let report = json(&done(&bench, &line));
    let paths = curves(&read(&bench, "p.npy"));
    let starts = [[10.0, 40.0], [30.0, 20.0], [3.5, 50.0], [60.0, 60.25]];
    assert_eq!(paths.len(), starts.len());
    let surface = Builtin::Sphere.surface(65, 65).unwrap();
    let source = surface.position(30, 20).unwrap();
    for ((path, start), row) in paths.iter().zip(starts).zip(report["paths"].as_array().unwrap()) {
        assert_eq!(path[0][..2], start);
        assert_eq!(path.last().unwrap()[..2], [30.0, 20.0]);
        assert_eq!(path.last().unwrap()[2..], source.to_array());
        assert_eq!(row["vertices"], path.len());
        assert_eq!(row["source"], 0);
        let exact = Builtin::Sphere.exact_distance(65, 65, start, [30.0, 20.0]).unwrap();
        let (length, distance) =
            (row["length"].as_f64().unwrap(), row["distance"].as_f64().unwrap());
        // Paths bend by steps as long as cells: a few 1e-4 at 65 points.
        assert!((length - exact).abs() <= 2e-3 * exact, "{length} {exact}");
        assert!((distance - exact).abs() <= 2e-3 * exact, "{distance} {exact}");
    }
    assert_eq!(paths[1].len(), 1, "a start at the source");
    let single = "path builtin:plane:17x17 -s 3,3 --from 12,9 --engine cpu -o one.npy";
    done(&bench, single);
    let one = curves(&read(&bench, "one.npy"));
    assert_eq!(one.len(), 1, "one path is one array without NaN");
    for [row, col, ..] in &one[0] {
        let across = (row - 3.0) * 6.0 - (col - 3.0) * 9.0;
        assert!(across.abs() / 6f64.hypot(9.0) < 0.02, "a straight line: {row},{col}");
    }
}

#[test]
fn starts_that_cannot_be_are_refused() {
    let bench = Bench::new();
    let mut heights = vec![0.0; 9 * 9];
    (0..9).for_each(|row| heights[row * 9 + 5] = f64::NAN);
    let cut = bench.array("cut.npy", &[9, 9], &heights);
    for (from, parts) in [
        ("2,7", ["2,7", "cannot be reached"]),
        ("9.5,1", ["9.5,1", "outside the grid"]),
        ("-1,1", ["-1,1", "outside the grid"]),
        ("4,5", ["4,5", "hole"]),
    ] {
        let line = format!(
            "path {cut} --spacing 1 -s 2,2 --from 1,1 --from {from} -o p.npy -o p.svg \
             --picture p.png --engine cpu"
        );
        let output = run(&bench, &line);
        bench.refuses(&output, &parts);
    }
    let line = format!("path {cut} --spacing 1 -s 2,2 -o p.npy");
    bench.refuses(&run(&bench, &line), &["--from"]);
    let line = format!("path {cut} --spacing 1 -s 2,2 --from 1 -o p.npy");
    bench.refuses(&run(&bench, &line), &["R,C"]);
}

#[test]
fn levels_that_the_map_lacks_have_no_curves() {
    let bench = Bench::new();
    let line = "contours builtin:plane:17x17 -s 8,8 --levels=-1,0.2,99 --engine cpu --json \
                -o c.npy -o c.csv -o c.svg -o c.obj -o c.ply";
    let output = done(&bench, line);
    assert!(stderr(&output).contains("no curve at -1, 99"), "{}", stderr(&output));
    let report = json(&output);
    let curves: Vec<_> =
        report["levels"].as_array().unwrap().iter().map(|l| &l["curves"]).collect();
    assert_eq!(curves, [&Value::from(0), &Value::from(1), &Value::from(0)]);
    let none = "contours builtin:plane:17x17 -s 8,8 --levels 99 --engine cpu -o n.npy -o n.csv";
    done(&bench, none);
    assert!(self::curves(&read(&bench, "n.npy")).concat().is_empty());
    let wide = "contours builtin:plane:17x17 -s 8,8 --every 1e9 --engine cpu -o n.npy";
    let said = stderr(&done(&bench, wide));
    assert!(said.contains("no curve: the distances on the grid run from 0 to 0.7"), "{said}");

    let bench = Bench::new();
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
        bench.refuses(&run(&bench, &line), &[part]);
    }
}

#[test]
fn curves_closer_to_a_source_than_the_grid_are_said_to_be_cut() {
    let bench = Bench::new();
    let plane = bench.flat(9, 9);
    let said = |line: &str| {
        let line = line.replace("PLANE", &format!("{plane} --spacing 1 --engine cpu --json"));
        let output = done(&bench, &line);
        let curves = json(&output)["levels"][0]["curves"].as_u64().unwrap();
        assert!(!String::from_utf8(output.stdout.clone()).unwrap().contains("-0.0"));
        (curves, stderr(&output))
    };
    // The corners of the source's cell are 0.42 to 0.99 away.
    let (none, text) = said("contours PLANE -s 4.3,4.3 --levels 0.1");
    assert!(none == 0 && text.contains("no curve at 0.1: the distances on the grid run from 0.42"));
    let (some, text) = said("contours PLANE -s 4.3,4.3 --levels 0.6");
    assert!(some > 0 && text.contains("the curves at 0.6 run between"), "{some} {text}");
    assert_eq!(said("contours PLANE -s 4.3,4.3 --levels 1"), (1, String::new()));
    // At a point of the grid circles are whole however small.
    assert_eq!(said("contours PLANE -s 4,4 --levels 0.001"), (1, String::new()));
    let line = bench.input("line.csv", "4.2,1.5\n4.2,6.5\n");
    let near = format!("offset PLANE --source-curve {line} --distances 0.3");
    let (_, text) = said(&near);
    assert!(text.contains("the curves at 0.3 run between"), "{text}");
    assert_eq!(said(&near.replace("0.3", "1.5")).1, "");

    let bench = Bench::new();
    let before = format!("offset {plane} -s 4,4 --engine cpu --distances 1,-1 -o c.npy");
    bench.refuses(&run(&bench, &before), &["--distances -1", "nearer than the sources"]);
}

#[test]
fn odd_grids_and_sources_have_contours() {
    let bench = Bench::new();
    // A source on the border: half circles that end there.
    let line = "contours builtin:plane:17x17 -s 0,8 --levels 0.3 --engine cpu --json";
    let report = json(&done(&bench, line));
    assert_eq!(
        (&report["levels"][0]["curves"], &report["levels"][0]["closed"]),
        (&1.into(), &0.into())
    );
    // Two sources at one point are one.
    let twice = "contours builtin:plane:17x17 -s 5,8 -s 5,8 --levels 0.2 --engine cpu -o twice.npy";
    let once = "contours builtin:plane:17x17 -s 5,8 --levels 0.2 --engine cpu -o once.npy";
    done(&bench, twice);
    done(&bench, once);
    let [twice, once] = ["twice.npy", "once.npy"].map(|name| curves(&read(&bench, name)));
    assert_eq!(twice.len(), once.len());
    for (a, b) in twice[0].iter().zip(&once[0]) {
        assert!(DVec2::new(a[0], a[1]).distance(DVec2::new(b[0], b[1])) < 1e-3, "{a:?} {b:?}");
    }
    // Strips, in both views.
    for (rows, cols, source) in [(2, 9, "1,0"), (9, 2, "0,1"), (2, 2, "0,0"), (1, 9, "0,2")] {
        let flat = bench.array("strip.npy", &[rows, cols], &vec![0.0; rows * cols]);
        for view in ["map", "shaded"] {
            let line = format!(
                "contours {flat} --spacing 1 -s {source} --levels 0.5 --engine cpu -o s.csv \
                 --picture s.png --view {view}"
            );
            done(&bench, &line);
            let line = format!(
                "path {flat} --spacing 1 -s {source} --from {},{} --engine cpu -o p.npy \
                 --picture p.png --view {view}",
                rows - 1,
                cols - 1
            );
            done(&bench, &line);
        }
    }
}

#[test]
fn pictures_come_in_both_views() {
    let bench = Bench::new();
    for (view, name) in [("map", "map.png"), ("shaded", "shaded.png")] {
        let line = format!(
            "contours builtin:face:61x51 -s 34,25 --every 20 --unit mm --engine cpu \
             --view {view} --picture {name}"
        );
        done(&bench, &line);
        let picture = png::Decoder::new(Cursor::new(read(&bench, name))).read_info().unwrap();
        let info = picture.info();
        assert!(info.width.min(info.height) > 500, "{view}: {} x {}", info.width, info.height);
    }
    assert_ne!(read(&bench, "map.png"), read(&bench, "shaded.png"));
    let metric = bench.array("metric.npy", &[5, 5, 2, 2], &[1.0, 0.0, 0.0, 1.0].repeat(25));
    done(&bench, &format!("path {metric} -s 0,0 --from 4,4 --picture m.png -o m.npy -o m.svg"));
    let path = &curves(&read(&bench, "m.npy"))[0];
    assert!(path.iter().all(|row| row[2].is_nan() && row[1].is_finite()));

    let bench = Bench::new();
    let metric = bench.array("metric.npy", &[5, 5, 2, 2], &[1.0, 0.0, 0.0, 1.0].repeat(25));
    for (rest, parts) in [
        ("-o m.obj", ["m.obj", "metric"]),
        ("-o m.ply", ["m.ply", "metric"]),
        ("--picture m.png --view shaded", ["metric", "--view map"]),
        ("-o m.txt", ["m.txt", ".geojson"]),
        ("-o m.csv -o m.csv", ["m.csv", "two outputs"]),
        ("--picture m.jpg", ["m.jpg", ".png"]),
        ("--picture m.png --toward 0,0,0", ["--toward", "direction"]),
        ("", ["--output", "PATHS"]),
    ] {
        let line = format!("path {metric} -s 0,0 --from 4,4 --engine cpu {rest}");
        bench.refuses(&run(&bench, &line), &parts);
    }
}

#[test]
fn regions_are_what_is_nearest() {
    let bench = Bench::new();
    let flat = bench.flat(33, 41);
    let sources = [[8.0, 10.0], [20.0, 30.0], [28.0, 6.0]];
    let line = format!(
        "voronoi {flat} --spacing 1 -s 8,10 -s 20,30 -s 28,6 --engine cpu -o labels.npy \
         --borders b.npy --borders b.csv --picture v.png --json"
    );
    let report = json(&done(&bench, &line));
    assert_eq!(bench.outputs(), ["b.csv", "b.npy", "labels.npy", "v.png"]);
    let labels = read_map(&bench.output("labels.npy")).unwrap();
    let far = |row: f64, col: f64, [r, c]: [f64; 2]| (row - r).hypot(col - c);
    let mut points = [0; 3];
    for (index, label) in labels.values.iter().enumerate() {
        let (row, col) = ((index / 41) as f64, (index % 41) as f64);
        let distances = sources.map(|source| far(row, col, source));
        let nearest = distances.iter().copied().fold(f64::INFINITY, f64::min);
        points[*label as usize] += 1;
        assert!(distances[*label as usize] < nearest + 1e-3, "{row},{col}: {label}");
    }
    for (index, region) in report["regions"].as_array().unwrap().iter().enumerate() {
        assert_eq!((&region["source"], &region["points"]), (&index.into(), &points[index].into()));
    }
    assert_eq!(report["neighbours"], serde_json::json!([[0, 1], [0, 2], [1, 2]]));
    approx::assert_relative_eq!(report["area"].as_f64().unwrap(), 32.0 * 40.0, max_relative = 1e-9);

    let mut table = csv::Reader::from_path(bench.output("b.csv")).unwrap();
    assert_eq!(&table.headers().unwrap().iter().collect::<Vec<_>>()[2..4], ["left", "right"]);
    let rows: Vec<_> = table.records().map(Result::unwrap).collect();
    let borders = curves(&read(&bench, "b.npy"));
    assert_eq!(borders.len(), 3);
    assert_eq!(rows.len(), borders.iter().map(Vec::len).sum::<usize>());
    for row in &rows {
        let number = |k: usize| row[k].parse::<f64>().unwrap();
        let [left, right] = [2, 3].map(|k| {
            let source = sources[row[k].parse::<usize>().unwrap()];
            far(number(6), number(7), source)
        });
        // Half a cell either way changes the difference by a cell at most; junctions lie within
        // a cell.
        assert!((left - right).abs() < 1.0, "{row:?}");
    }
}

#[test]
fn what_no_source_reaches_has_no_region() {
    let bench = Bench::new();
    let mut heights = vec![0.0; 9 * 12];
    (0..9).for_each(|row| heights[row * 12 + 7] = f64::NAN);
    let cut = bench.array("cut.npy", &[9, 12], &heights);
    let line =
        format!("voronoi {cut} --spacing 1 -s 4,1 -s 4,1 -s 4,5 --engine cpu -o l.npy --json");
    let output = done(&bench, &line);
    assert!(stderr(&output).contains("cannot be reached"), "{}", stderr(&output));
    let labels = read_map(&bench.output("l.npy")).unwrap();
    for (index, label) in labels.values.iter().enumerate() {
        let expected = if index % 12 >= 7 { -1.0 } else { *label };
        assert!(*label == expected && *label != 1.0, "{index}: {label}");
    }
    // Of two sources at one point the first has it all.
    let report = json(&output);
    assert_eq!(report["regions"][1]["points"], 0);
    assert_eq!(report["regions"][1]["area"], 0.0);
    let line = format!("voronoi {cut} --spacing 1 -s 4,1 -o l.tif");
    let bench = Bench::new();
    bench.refuses(&run(&bench, &line), &["l.tif", ".npy"]);
}

#[test]
fn samples_are_far_from_one_another() {
    let bench = Bench::new();
    let flat = bench.flat(21, 21);
    let line = format!(
        "sample {flat} --spacing 1 -k 5 -o s.npy -o s.csv -o s.ply --labels l.npy \
         --picture s.png --json"
    );
    let report = json(&done(&bench, &line));
    assert_eq!(bench.outputs(), ["l.npy", "s.csv", "s.npy", "s.ply", "s.png"]);
    let samples = &curves(&read(&bench, "s.npy"))[0];
    // The middle, then the corners in some order.
    assert_eq!(samples[0][..2], [10.0, 10.0]);
    let mut corners: Vec<_> = samples[1..].iter().map(|s| [s[0] as i32, s[1] as i32]).collect();
    corners.sort_unstable();
    assert_eq!(corners, [[0, 0], [0, 20], [20, 0], [20, 20]]);
    assert!(report["samples"][0]["radius"].is_null());
    approx::assert_relative_eq!(
        report["samples"][1]["radius"].as_f64().unwrap(),
        200f64.sqrt(),
        max_relative = 1e-5
    );
    // From the middle of a side to the middle or to a corner.
    approx::assert_relative_eq!(report["radius"].as_f64().unwrap(), 10.0, max_relative = 1e-5);
    let labels = read_map(&bench.output("l.npy")).unwrap();
    assert_eq!(labels.values[10 * 21 + 10], 0.0);
    assert!(labels.values.iter().all(|label| (0.0..5.0).contains(label)));

    let line = "sample builtin:plane:2x2 -k 9 --first 0,0 -o few.npy --json";
    let output = done(&bench, line);
    assert!(stderr(&output).contains("4 samples in place of 9"), "{}", stderr(&output));
    assert_eq!(json(&output)["samples"].as_array().unwrap().len(), 4);

    let bench = Bench::new();
    for (rest, part) in [
        ("-k 0", "--count 1"),
        ("-k 3 --first 30,2", "--first 30,2 lies outside the grid"),
        ("-k 3 --first 3", "R,C"),
        ("", "--count"),
    ] {
        let line = format!("sample {flat} --spacing 1 {rest} -o s.npy");
        bench.refuses(&run(&bench, &line), &[part]);
    }
}

/// What one command writes, the others read.
#[test]
fn samples_and_curves_are_inputs_too() {
    let bench = Bench::new();
    let plane = "builtin:plane:17x19 --engine cpu";
    done(&bench, "sample builtin:plane:17x19 -k 5 -o s.csv -o s.npy");
    let samples = curves(&read(&bench, "s.npy")).concat();
    assert_eq!(samples.len(), 5);

    // Samples of a table are points.
    let words: Vec<_> = samples.iter().map(|v| format!("-s {},{}", v[0], v[1])).collect();
    done(&bench, &format!("distance {plane} -o points.npy {}", words.join(" ")));
    done(&bench, &format!("distance {plane} -o table.npy --source-curve s.csv"));
    assert_eq!(map(&bench.output("points.npy")), map(&bench.output("table.npy")));

    let ends = |file: &str| {
        let line = format!("path {plane} -s 8,9 -o p.npy --json --from-file {file}");
        let report = json(&done(&bench, &line));
        report["paths"].as_array().unwrap().iter().map(|path| path["from"].clone()).collect()
    };
    let [from_csv, from_npy]: [Vec<Value>; 2] = ["s.csv", "s.npy"].map(ends);
    assert_eq!((from_csv.len(), &from_csv), (5, &from_npy));
    for format in ["csv", "npy"] {
        let line = format!("pairwise builtin:plane:17x19 --sources s.{format} -o {format}-d.npy");
        done(&bench, &line);
    }
    assert_eq!(map(&bench.output("csv-d.npy")), map(&bench.output("npy-d.npy")));

    // Curves stay apart: nothing between two circles is a source.
    done(&bench, &format!("contours {plane} -s 4,4 -s 12,14 --levels 0.1 -o c.csv -o c.npy"));
    for format in ["csv", "npy"] {
        done(&bench, &format!("distance {plane} --source-curve c.{format} -o {format}.npy"));
    }
    let distances = map(&bench.output("csv.npy"));
    assert_eq!(distances, map(&bench.output("npy.npy")));
    assert!(distances[8 * 19 + 9] > 0.2, "{}", distances[8 * 19 + 9]);
    let bench = Bench::new();
    let named = bench.input("xy.csv", "x,y\n1,2\n");
    let refused = run(&bench, &format!("distance {plane} --source-curve {named} -o d.npy"));
    bench.refuses(&refused, &["xy.csv", "header `x,y`", "row and col"]);
}

#[test]
fn figures_are_drawn() {
    let bench = Bench::new();
    done(&bench, "figure scans -o scans.png");
    done(&bench, "figure face -o face.png");
    assert_eq!(bench.outputs(), ["face.png", "scans.png"]);
    for name in ["scans.png", "face.png"] {
        let picture = png::Decoder::new(Cursor::new(read(&bench, name))).read_info().unwrap();
        assert!(picture.info().width >= 1500, "{name}");
    }
    let bench = Bench::new();
    bench.refuses(&run(&bench, "figure all -o nowhere"), &["nowhere", "create it"]);
    bench.refuses(&run(&bench, "figure face -o face.gif"), &["face.gif", ".png"]);
}

#[test]
fn offsets_keep_to_their_side() {
    let bench = Bench::new();
    let flat = bench.flat(41, 61);
    // From west to east, so that north is on its left.
    let line = bench.input("line.csv", "20,15\n20,45\n");
    let offset = |rest: &str| {
        let line = format!(
            "offset {flat} --spacing 1 --source-curve {line} --distances 8 --engine cpu --json \
             -o o.npy -o o.csv {rest}"
        );
        let level = json(&done(&bench, &line))["levels"][0].clone();
        assert_eq!((&level["level"], &level["curves"]), (&8.0.into(), &1.into()), "{rest}");
        (curves(&read(&bench, "o.npy")).remove(0), level)
    };
    let half = 30.0 + std::f64::consts::PI * 8.0;
    let (all, level) = offset("");
    assert_eq!(level["closed"], 1);
    // Corners of fronts are cut within a cell.
    assert!((level["length"].as_f64().unwrap() - 2.0 * half).abs() < 0.02 * half, "{level}");
    assert_eq!(all.first(), all.last());
    for (side, sign) in [("left", 1.0), ("right", -1.0)] {
        let (curve, level) = offset(&format!("--side {side}"));
        assert_eq!(level["closed"], 0);
        assert!((level["length"].as_f64().unwrap() - half).abs() < 0.02 * half, "{level}");
        for [row, col, ..] in curve {
            assert!(sign * (20.0 - row) > -0.1, "{side}: {row},{col}");
            let beyond = (15.0 - col).max(col - 45.0).max(0.0);
            // Around the ends of a curve, where its front turns at once, the map itself is 0.17 of
            // a cell off (measured, with any wavefront).
            let tolerance = if beyond > 0.0 { 0.2 } else { 0.1 };
            assert!(((row - 20.0).hypot(beyond) - 8.0).abs() < tolerance, "{side}: {row},{col}");
        }
        let table = text(&bench, "o.csv");
        let header = table.lines().next().unwrap();
        assert!(header.contains(",level,length,side,"), "{header}");
        assert!(table.lines().nth(1).unwrap().contains(&format!(",{side},")));
    }

    // Two curves that are not connected, one of them closed.
    let loops = bench.input("loop.csv", "5,50\n5,56\n11,56\n11,50\n5,50\n");
    let line = format!(
        "offset {flat} --spacing 1 --source-curve {line} --source-curve {loops} --distances 2,4 \
         --engine cpu --json -o two.svg --picture two.png"
    );
    let report = json(&done(&bench, &line));
    // Around the line; outside and inside of the square, whose middle is 3 away.
    assert_eq!(report["levels"][0]["closed"], 3);
    assert_eq!(report["levels"][1]["closed"], 2);

    let bench = Bench::new();
    for (rest, part) in [
        ("-s 3,3 --distances 2 --side left", "side"),
        ("-s 3,3", "--distances"),
        ("-s 3,3 --distances nan", "finite"),
        ("--distances 3", "--source"),
        ("--source-curve nowhere.csv --distances 3", "nowhere.csv"),
    ] {
        let line = format!("offset {flat} --spacing 1 {rest} --engine cpu -o o.npy");
        bench.refuses(&run(&bench, &line), &[part]);
    }
}

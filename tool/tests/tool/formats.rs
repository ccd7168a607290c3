//! Curves in every format, and their coordinates on a georeferenced surface.

use std::io::Cursor;

use geosweep::glam::DVec2;
use serde_json::Value;

use crate::workbench::{Workbench, stderr};

#[test]
fn every_format_holds_the_same_curves() {
    let bench = Workbench::new();
    let line = "contours builtin:peaks:41x37 -s 20,18 --count 5 --engine cpu --json \
                -o c.npy -o c.csv -o c.svg -o c.ply -o c.obj";
    let report = bench.json(line);
    assert_eq!(bench.outputs(), ["c.csv", "c.npy", "c.obj", "c.ply", "c.svg"]);
    let levels = report["levels"].as_array().unwrap();
    assert_eq!(levels.len(), 5);
    let total = |key: &str| levels.iter().map(|level| level[key].as_u64().unwrap()).sum::<u64>();
    let (count, closed, vertices) =
        (total("curves") as usize, total("closed") as usize, total("vertices") as usize);
    assert!(closed >= 1 && count > closed, "{report}");

    let npy = bench.curves("c.npy");
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

    let svg = bench.text("c.svg");
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

    let obj = bench.text("c.obj");
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

    let ply = bench.read("c.ply");
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

/// Returns a flat GeoTIFF of 30 x 20 m pixels, with the given GeoTIFF keys after the header.
pub fn geotiff(rows: u32, cols: u32, tie_point: [f64; 6], keys: &[u16]) -> Vec<u8> {
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
    let bench = Workbench::new();
    let corner = [0.0, 0.0, 0.0, 500_000.0, 4_000_000.0, 0.0];
    let utm = [1024, 0, 1, 1, 3072, 0, 1, 32616];
    let dem = bench.input("dem.tif", geotiff(41, 31, corner, &utm));
    let line = "-s 20,15 --every 100 -o c.geojson --engine cpu";
    let output = bench.done(format!("contours {dem} {line}"));
    assert!(stderr(&output).contains("dem.tif: pixel size and heights are taken as metres"));
    let said =
        bench.input("said.tif", geotiff(41, 31, corner, &[&utm[..], &[3076, 0, 1, 9001]].concat()));
    let output = bench.done(format!("contours {said} -s 20,15 --every 100 --json"));
    assert!(!stderr(&output).contains("metres"), "{}", stderr(&output));
    let file: Value = serde_json::from_str(&bench.text("c.geojson")).unwrap();
    assert_eq!(file["crs"]["properties"]["name"], "urn:ogc:def:crs:EPSG::32616");
    // Points are at the middles of pixels, half a pixel from the corner.
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

    // Coordinates are degrees: with WGS 84 in plain GeoJSON, otherwise with the system's name.
    for (epsg, named) in [(4326, false), (4269, true)] {
        let degrees = [1024, 0, 1, 2, 2048, 0, 1, epsg];
        let dem = bench.input("degrees.tif", geotiff(41, 31, corner, &degrees));
        bench.done(format!("contours {dem} --spacing 1 -s 20,15 --count 2 -o d.geojson"));
        let file: Value = serde_json::from_str(&bench.text("d.geojson")).unwrap();
        assert_eq!(!file["crs"].is_null(), named, "{epsg}");
    }
}

#[test]
fn geojson_asks_for_a_georeference() {
    let corner = [0.0; 6];
    for (name, bytes) in [
        ("untold.tif", geotiff(9, 9, corner, &[1024, 0, 1, 1])),
        ("model.tif", geotiff(9, 9, corner, &[])),
    ] {
        let bench = Workbench::new();
        let dem = bench.input(name, bytes);
        let line = format!("contours {dem} --spacing 1 -s 4,4 --count 2 -o c.geojson -o c.npy");
        bench.refuse(&line, &["c.geojson", "georeferenced", "EPSG code"]);
    }
    let bench = Workbench::new();
    let line = "path builtin:plane:9x9 -s 4,4 --from 1,1 -o p.geojson";
    bench.refuse(line, &["p.geojson", "built-in"]);
    let flat = bench.flat(9, 9);
    let line = format!("path {flat} --spacing 1 -s 4,4 --from 1,1 -o p.geojson");
    bench.refuse(&line, &["p.geojson", "GeoTIFF"]);
}

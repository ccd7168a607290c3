//! Directions and sides on rasters whose rows run in any direction of the map.

use std::io::Cursor;

use geosweep::io::{CoordinateSystem, GeoTags, Georeference, MapFormat};

use crate::workbench::Workbench;

const ROWS: usize = 17;
const COLS: usize = 21;
const CELL: f64 = 10.0;
const SOURCE: [usize; 2] = [5, 12];

/// Returns the georeferences of the eight orientations of a raster along the axes of a map, and of one that is turned.
fn orientations() -> Vec<Georeference> {
    let turned = |angle: f64, is_mirrored: bool| {
        let (sine, cosine) = angle.to_radians().sin_cos();
        let sign = if is_mirrored { -1.0 } else { 1.0 };
        Georeference {
            origin: [5e5, 5e6],
            down: [-CELL * sine, -CELL * cosine],
            right: [sign * CELL * cosine, -sign * CELL * sine],
            system: Some(CoordinateSystem::Projected(32633)),
        }
    };
    // Along the axes, sine and cosine are rounded, as in files.
    let along = [0.0, 90.0, 180.0, 270.0].into_iter();
    let along = along.flat_map(|angle| [false, true].map(|is_mirrored| turned(angle, is_mirrored)));
    along.chain([turned(37.0, false), turned(37.0, true)]).collect()
}

/// Writes a flat raster.
fn raster(bench: &Workbench, at: &Georeference) -> String {
    let mut bytes = Cursor::new(Vec::new());
    let tags = GeoTags::new(at);
    MapFormat::Tiff.write(&mut bytes, ROWS, COLS, &[0.0f32; ROWS * COLS], Some(&tags)).unwrap();
    bench.input("flat.tif", bytes.into_inner())
}

fn on_map(at: &Georeference, index: usize) -> [f64; 2] {
    at.coordinates([(index / COLS) as f64, (index % COLS) as f64])
}

/// Returns the difference of two angles in degrees.
fn apart(a: f64, b: f64) -> f64 {
    ((a - b + 180.0).rem_euclid(360.0) - 180.0).abs()
}

#[test]
fn bearings_are_those_of_the_map() {
    for at in orientations() {
        let bench = Workbench::new();
        let flat = raster(&bench, &at);
        let [x, y] = on_map(&at, SOURCE[0] * COLS + SOURCE[1]);
        for format in ["compass", "grass"] {
            bench.done(format!(
                "distance {flat} --source-xy={x:?},{y:?} --engine cpu --direction-format {format} \
                 --back-direction b.npy --source-direction s.npy"
            ));
            let (back, leaving) = (bench.map("b.npy"), bench.map("s.npy"));
            for index in (0..ROWS * COLS).filter(|&index| index != SOURCE[0] * COLS + SOURCE[1]) {
                let [east, north] = [0, 1].map(|k| [x, y][k] - on_map(&at, index)[k]);
                let right = match format {
                    "compass" => east.atan2(north),
                    _ => north.atan2(east),
                };
                let right = right.to_degrees();
                let errors = [apart(back[index], right), apart(leaving[index], right + 180.0)];
                assert!(errors[0] < 0.1 && errors[1] < 0.1, "{at:?} {format} {index}: {errors:?}");
                assert!(back[index] > 0.0 && back[index] <= 360.0);
            }
            assert_eq!(back[SOURCE[0] * COLS + SOURCE[1]], 0.0);
        }
    }
}

#[test]
fn back_links_lead_to_neighbours_on_the_map() {
    let all = orientations();
    for at in &all[..8] {
        let bench = Workbench::new();
        let flat = raster(&bench, at);
        let source = format!("-s {},{}", SOURCE[0], SOURCE[1]);
        bench.done(format!("distance {flat} {source} --engine cpu -o d.npy --back-link l.npy"));
        let (distances, links) = (bench.map("d.npy"), bench.map("l.npy"));
        for (index, &link) in links.iter().enumerate().filter(|(_, link)| **link != 0.0) {
            let turn = std::f64::consts::FRAC_PI_4 * (link - 1.0);
            let [east, south] = [turn.cos(), turn.sin()].map(|step| CELL * step.round());
            let [x, y] = on_map(at, index);
            let [row, col] = at.place([x + east, y - south]).unwrap().map(|at| at.round() as usize);
            assert!(distances[row * COLS + col] < distances[index], "{at:?} {index}: {link}");
        }
    }
    let bench = Workbench::new();
    let flat = raster(&bench, &all[8]);
    let line = format!("distance {flat} -s 3,4 --back-link l.npy");
    bench.refuse(&line, &["--back-link", "eight directions", "gdalwarp"]);
}

/// A square with a hole, in map coordinates, and its outlines in either direction.
fn polygon(middle: [f64; 2], reversed: [bool; 2]) -> String {
    let ring = |half: f64, is_reversed: bool| {
        let corners = [[-half, -half], [half, -half], [half, half], [-half, half], [-half, -half]];
        let mut corners = corners.map(|at| [0, 1].map(|k| middle[k] + at[k]));
        if is_reversed {
            corners.reverse();
        }
        let places: Vec<_> = corners.iter().map(|[x, y]| format!("[{x:?},{y:?}]")).collect();
        format!("[{}]", places.join(","))
    };
    let (outer, hole) = (ring(50.0, reversed[0]), ring(20.0, reversed[1]));
    format!(
        r#"{{"type":"Feature","properties":{{}},"crs":{{"type":"name","properties":{{"name":"EPSG:32633"}}}},
            "geometry":{{"type":"Polygon","coordinates":[{outer},{hole}]}}}}"#
    )
}

#[test]
fn the_inside_of_a_polygon_is_its_own() {
    for at in orientations() {
        let middle = at.coordinates([8.0, 10.0]);
        for reversed in [[false, true], [true, false], [false; 2], [true; 2]] {
            let bench = Workbench::new();
            let flat = raster(&bench, &at);
            let rings = bench.input("p.geojson", polygon(middle, reversed));
            bench.done(format!(
                "distance {flat} --source-curve {rings} --signed --engine cpu -o d.npy"
            ));
            let found = bench.map("d.npy");
            for (index, &found) in found.iter().enumerate() {
                let [x, y] = [0, 1].map(|k| (on_map(&at, index)[k] - middle[k]).abs());
                let [outer, hole] = [50.0, 20.0].map(|half| {
                    let (a, b) = (x - half, y - half);
                    a.max(0.0).hypot(b.max(0.0)) + a.max(b).min(0.0)
                });
                let right = outer.max(-hole);
                assert!(
                    (found - right).abs() < 0.5,
                    "{at:?} {reversed:?} {index}: {found} {right}"
                );
            }
        }
    }
}

#[test]
fn the_left_of_a_line_is_that_of_the_map() {
    for at in orientations() {
        let bench = Workbench::new();
        let flat = raster(&bench, &at);
        let [from, to] = [[8.0, 6.0], [8.0, 14.0]].map(|place| at.coordinates(place));
        let [[a, b], [c, d]] = [from, to];
        let text = format!("x,y\n{a:?},{b:?}\n{c:?},{d:?}\n");
        let line = bench.input("line.csv", text);
        bench.done(format!(
            "offset {flat} --source-curve {line} --distances 25 --side left --engine cpu -o o.csv"
        ));
        // The cross product of the line's direction and that to a point on its left is positive. The curve ends on the
        // line's extension.
        let table = bench.text("o.csv");
        let mut reader = csv::Reader::from_reader(table.as_bytes());
        let names: Vec<_> = reader.headers().unwrap().iter().map(str::to_owned).collect();
        let column = |name: &str| names.iter().position(|found| found == name).unwrap();
        let (row, col) = (column("row"), column("col"));
        let mut count = 0;
        for record in reader.records().map(Result::unwrap) {
            let place = [row, col].map(|k| record[k].parse::<f64>().unwrap());
            let [x, y] = at.coordinates(place);
            let cross = (to[0] - from[0]) * (y - from[1]) - (to[1] - from[1]) * (x - from[0]);
            assert!(cross > -1.0, "{at:?}: {place:?}");
            count += usize::from(cross > 1.0);
        }
        assert!(count > 3);
    }
}

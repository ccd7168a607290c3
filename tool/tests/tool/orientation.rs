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

/// Returns the width of a picture and its pixels.
fn pixels(bench: &Workbench, name: &str) -> (usize, Vec<[u8; 3]>) {
    let mut reader = png::Decoder::new(Cursor::new(bench.read(name))).read_info().unwrap();
    let mut bytes = vec![0; reader.output_buffer_size().unwrap()];
    let info = reader.next_frame(&mut bytes).unwrap();
    let size = bytes.len() / (info.width * info.height) as usize;
    let pixels = bytes.chunks(size).map(|pixel| [pixel[0], pixel[1], pixel[2]]).collect();
    (info.width as usize, pixels)
}

/// Returns the share of pixels that differ visibly.
fn differing(a: impl IntoIterator<Item = [u8; 3]>, b: impl IntoIterator<Item = [u8; 3]>) -> f64 {
    let differ = |(a, b): ([u8; 3], [u8; 3])| (0..3).any(|k| a[k].abs_diff(b[k]) > 40);
    let (mut count, mut all) = (0, 0);
    for pair in a.into_iter().zip(b) {
        all += 1;
        count += usize::from(differ(pair));
    }
    f64::from(count as u32) / f64::from(all)
}

/// A landscape without symmetry looks the same from a side of the map, whichever way the rows of its raster run.
#[test]
fn shaded_views_are_from_a_side_of_the_map() {
    const SIDE: usize = 31;
    let middle = [SIDE as f64 / 2.0 - 0.5; 2];
    for view in ["--toward 0.9,0.3,0.6", "--toward=-0.2,-0.9,0.5", "--view shaded"] {
        let mut first = None;
        for at in &orientations()[..8] {
            let bench = Workbench::new();
            let center = at.coordinates(middle);
            let at = Georeference { origin: [0, 1].map(|k| at.origin[k] - center[k]), ..*at };
            let height = |index: usize| {
                let [x, y] = at.coordinates([(index / SIDE) as f64, (index % SIDE) as f64]);
                let bump = |a: f64, b: f64, size: f64| {
                    size * (-((x - a).powi(2) + (y - b).powi(2)) / 1800.0).exp()
                };
                (bump(-90.0, 60.0, 70.0) + bump(80.0, 90.0, 25.0) - bump(60.0, -80.0, 40.0)) as f32
            };
            let heights: Vec<f32> = (0..SIDE * SIDE).map(height).collect();
            let mut bytes = Cursor::new(Vec::new());
            MapFormat::Tiff
                .write(&mut bytes, SIDE, SIDE, &heights, Some(&GeoTags::new(&at)))
                .unwrap();
            let file = bench.input("land.tif", bytes.into_inner());
            bench.done(format!(
                "contours {file} -s 15,15 --every 60 --engine cpu {view} --picture p.png"
            ));
            let (width, found) = pixels(&bench, "p.png");
            match &first {
                None => first = Some((width, found)),
                Some((of_first, expected)) => {
                    assert_eq!((width, found.len()), (*of_first, expected.len()), "{view} {at:?}");
                    let share = differing(found, expected.iter().copied());
                    assert!(share < 0.02, "{view} {at:?}: {share}");
                }
            }
        }
    }
    let slanted = Georeference {
        origin: [5e5, 5e6],
        down: [3.0, -9.0],
        right: [10.0, 0.0],
        system: Some(CoordinateSystem::Projected(32633)),
    };
    let bench = Workbench::new();
    let flat = raster(&bench, &slanted);
    let line =
        format!("contours {flat} --spacing 10 -s 3,4 --every 30 --toward 1,0,1 --picture p.png");
    bench.refuse(&line, &["--toward", "right angles"]);
    let line = format!("distance {flat} --spacing 10 -s 3,4 --direction-picture p.png");
    bench.refuse(&line, &["--direction-picture", "right angles"]);
}

/// Colours of directions are those of the map: in the picture of a raster whose first row is the southernmost one, the
/// colours of north and south are exchanged.
#[test]
fn colours_of_directions_are_those_of_the_map() {
    const SIDE: usize = 41;
    let picture = |down: f64| {
        let at = Georeference {
            origin: [5e5, 5e6],
            down: [0.0, down],
            right: [10.0, 0.0],
            system: Some(CoordinateSystem::Projected(32633)),
        };
        let bench = Workbench::new();
        let mut bytes = Cursor::new(Vec::new());
        let flat = [0.0f32; SIDE * SIDE];
        MapFormat::Tiff.write(&mut bytes, SIDE, SIDE, &flat, Some(&GeoTags::new(&at))).unwrap();
        let file = bench.input("flat.tif", bytes.into_inner());
        bench.done(format!("distance {file} -s 20,20 --engine cpu --direction-picture p.png"));
        pixels(&bench, "p.png")
    };
    let [(width, north_up), (_, south_up)] = [-10.0, 10.0].map(picture);
    // The map is a square at the left of the picture.
    let height = north_up.len() / width;
    let rows = |pixels: &[[u8; 3]], flipped: bool| -> Vec<[u8; 3]> {
        let row = |row: usize| if flipped { height - 1 - row } else { row };
        (0..height).flat_map(|at| pixels[row(at) * width..][..height / 2].to_vec()).collect()
    };
    let as_on_grid = differing(rows(&north_up, false), rows(&south_up, false));
    let flipped = differing(rows(&north_up, true), rows(&south_up, false));
    assert!(flipped < 0.2 && as_on_grid > 0.5, "{flipped}, {as_on_grid}");
}

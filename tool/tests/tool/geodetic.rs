//! The Earth: grids of heights by longitude and latitude, against geodesics of the ellipsoid and against one another.

use geosweep::io::write_npy;
use serde_json::Value;

use crate::vincenty::vincenty;
use crate::workbench::{Workbench, notes, stderr};

/// Distance, in metres, beyond which Vincenty's formula may fail, since the points are nearly opposite.
const OPPOSITE: f64 = 1.9e7;
/// Degrees between the lines of grids of the whole Earth.
pub const STEP: f64 = 2.0;
pub const GLOBE: &str = "--geodetic --extent -180,-90,180,90 --registration";

/// The places of a grid's points.
pub struct Grid {
    pub longitudes: Vec<f64>,
    pub latitudes: Vec<f64>,
}

impl Grid {
    pub fn new([west, cols]: [f64; 2], [first, rows, step]: [f64; 3]) -> Self {
        let longitudes = (0..cols as usize).map(|col| west + step.abs() * col as f64).collect();
        let latitudes = (0..rows as usize).map(|row| first + step * row as f64).collect();
        Self { longitudes, latitudes }
    }

    pub fn shape(&self) -> [usize; 2] {
        [self.latitudes.len(), self.longitudes.len()]
    }

    pub fn places(&self) -> impl Iterator<Item = [f64; 2]> {
        let row = |&latitude: &f64| self.longitudes.iter().map(move |&lon| [lon, latitude]);
        self.latitudes.iter().flat_map(row)
    }

    /// Returns hills and valleys, which depend on the place on the Earth alone.
    pub fn heights(&self) -> Vec<f64> {
        let height = |[lon, lat]: [f64; 2]| {
            let (lon, lat) = (lon.to_radians(), lat.to_radians());
            4000.0 * (3.0 * lon).sin() * lat.cos().powi(3) * (5.0 * lat).cos()
        };
        self.places().map(height).collect()
    }

    /// Writes a file of these heights, or of heights of 0, which are those of the ellipsoid.
    pub fn file(&self, bench: &Workbench, name: &str, is_hilly: bool) -> String {
        let heights = if is_hilly { self.heights() } else { vec![0.0; self.places().count()] };
        bench.array(name, &self.shape(), &heights)
    }

    /// Returns the mean and the largest relative error of distances on the ellipsoid.
    pub fn errors(&self, source: [f64; 2], found: &[f64]) -> [f64; 2] {
        assert_eq!(found.len(), self.places().count());
        let (mut sum, mut weights, mut largest) = (0.0, 0.0, 0f64);
        for (place, &found) in self.places().zip(found) {
            let Some(exact) = vincenty(source, place) else { continue };
            if (1.0..OPPOSITE).contains(&exact) {
                let (error, weight) = ((found - exact).abs() / exact, place[1].to_radians().cos());
                (sum, weights) = (sum + weight * error, weights + weight);
                largest = largest.max(error);
            }
        }
        [sum / weights, largest]
    }
}

/// Errors measured at 2 degrees: the mean is 8e-8 from a pole, and up to 4.2e-5 from other sources; the largest error
/// is 4.7e-3, beside a source inside a cell.
#[test]
fn maps_of_the_ellipsoid_are_those_of_geodesics() {
    let bench = Workbench::new();
    for (name, grid, tail) in [
        ("lines", Grid::new([-180.0, 181.0], [90.0, 91.0, -STEP]), "-180,-90,180,90 gridline"),
        ("cells", Grid::new([-178.7, 180.0], [89.0, 90.0, -STEP]), "-179.7,-90,180.3,90 pixel"),
        (
            "south",
            Grid::new([-179.6, 180.0], [-89.0, 90.0, STEP]),
            "-180.6,-90,179.4,90 pixel --south-up",
        ),
    ] {
        let file = grid.file(&bench, &format!("{name}.npy"), false);
        // Inside a cell, on the date line, in the cells that close the surface, and on a pole.
        for source in [[13.4, 52.5], [180.0, 10.0], [-179.8, -33.0], [179.9, 65.0], [40.0, 90.0]] {
            let [lon, lat] = source;
            let earth = tail.replacen(' ', " --registration ", 1);
            let earth = format!("--geodetic --extent {earth}");
            let line = format!("distance {file} {earth} --source-lonlat {lon},{lat}");
            let said = bench.json(format!("{line} -o {name}.npy --json"));
            assert_eq!(
                (&said["precision"], &said["seams"]),
                (&"double".into(), &Value::Array(vec![]))
            );
            assert_eq!([&said["rows"], &said["cols"]], grid.shape().map(Value::from).each_ref());
            let [mean, largest] = grid.errors(source, &bench.map(&format!("{name}.npy")));
            println!("{name} from {source:?}: mean {mean:.1e}, largest {largest:.1e}");
            let bound = if lat == 90.0 { 1e-6 } else { 6e-5 };
            assert!(mean < bound && largest < 7e-3, "{name} {source:?}: {mean:e} {largest:e}");
        }
    }
}

/// From New York (JFK) to London (LHR) the geodesic is 5551.7594 km long (documentation of GeographicLib, GeodSolve).
#[test]
fn a_part_of_the_earth_has_known_distances() {
    let bench = Workbench::new();
    let heights = bench.array("part.npy", &[151, 421], &vec![0.0; 151 * 421]);
    let earth = "--geodetic --extent -80,35,4,65 --registration gridline";
    let line = format!("value {heights} {earth} --source-lonlat -73.8,40.6 --at 67,397.5 --json");
    let said = bench.json(&line);
    let found = said["values"][0]["distance"].as_f64().unwrap();
    println!("JFK to LHR: {found}");
    assert!((found - 5_551_759.4).abs() < 60.0, "{found}");
    assert_eq!((said["rows"].as_u64(), said["cols"].as_u64()), (Some(151), Some(421)));
    // Longitudes that differ by full turns name the same places.
    let other = line.replace("-73.8,", "286.2,").replace("--at 67,397.5", "--at-xy 359.5,51.6");
    let mut same = bench.json(&other);
    for place in same["values"].as_array_mut().unwrap() {
        let near = |name: &str, exact: f64| (place[name].as_f64().unwrap() - exact).abs() < 1e-6;
        assert!(near("row", 67.0) && near("col", 397.5), "{place}");
        (place["row"], place["col"]) = (67.0.into(), 397.5.into());
    }
    assert_eq!(same["values"], said["values"]);
}

/// Returns a property of each line of GeoJSON, and the parts of the line.
pub fn parts(geojson: &str, property: &str) -> Vec<(f64, Vec<Vec<[f64; 2]>>)> {
    let collection: Value = serde_json::from_str(geojson).unwrap();
    assert!(collection.get("crs").is_none());
    let place = |place: &Value| {
        assert_eq!(place.as_array().unwrap().len(), 2, "{place}");
        [place[0].as_f64().unwrap(), place[1].as_f64().unwrap()]
    };
    let line = |line: &Value| line.as_array().unwrap().iter().map(place).collect();
    let feature = |feature: &Value| {
        let (geometry, value) = (&feature["geometry"], &feature["properties"][property]);
        let lines = match geometry["type"].as_str().unwrap() {
            "MultiLineString" => {
                geometry["coordinates"].as_array().unwrap().iter().map(line).collect()
            }
            _ => vec![line(&geometry["coordinates"])],
        };
        (value.as_f64().unwrap(), lines)
    };
    collection["features"].as_array().unwrap().iter().map(feature).collect()
}

/// Asserts that a line is divided at the antimeridian, as RFC 7946, section 3.1.9, demands.
pub fn assert_divided(parts: &[Vec<[f64; 2]>]) {
    for part in parts {
        assert!(part.iter().all(|[lon, lat]| lon.abs() <= 180.0 && lat.abs() <= 90.0), "{part:?}");
        assert!(part.windows(2).all(|ends| (ends[0][0] - ends[1][0]).abs() < 180.0), "{part:?}");
    }
}

#[test]
fn contours_are_circles_on_the_earth() {
    let bench = Workbench::new();
    let cells = Grid::new([0.3, 180.0], [89.0, 90.0, -STEP]).file(&bench, "cells.npy", false);
    let source = [170.0, 30.0];
    let earth = "--geodetic --extent=-0.7,-90,359.3,90 --registration pixel --source-lonlat 170,30";
    let line =
        format!("contours {cells} {earth} --levels 5e5,4e6,1e7 -o c.geojson -o c.csv --json");
    let said = bench.json(&line);
    let closed = said["levels"].as_array().unwrap().iter().map(|level| level["closed"].as_u64());
    assert_eq!(closed.collect::<Vec<_>>(), [Some(1); 3]);
    let found = parts(&bench.text("c.geojson"), "level");
    // The first circle stays west of the date line, the second crosses it twice, the third goes round the Earth.
    assert_eq!(found.iter().map(|(_, parts)| parts.len()).collect::<Vec<_>>(), [1, 2, 1]);
    for (level, parts) in &found {
        assert_divided(parts);
        for &place in parts.iter().flatten() {
            let exact = vincenty(source, place).unwrap();
            // Where the curve crosses a cell, distances are interpolated along its sides.
            assert!((exact - level).abs() < 2e-3 * level, "{level} {place:?}: {exact}");
        }
    }
    assert!(bench.text("c.csv").lines().count() > 300);
}

#[test]
fn paths_cross_the_date_line_and_the_pole() {
    let bench = Workbench::new();
    let grids = [
        ("pixel", Grid::new([-179.0, 180.0], [89.0, 90.0, -STEP]), [39.5, 14.5]),
        ("gridline", Grid::new([-180.0, 181.0], [90.0, 91.0, -STEP]), [40.0, 15.0]),
    ];
    let starts = [[-150.0, 10.0], [-10.0, 60.0], [120.0, 0.0]];
    let from: Vec<_> = starts.iter().map(|[lon, lat]| format!("--from-xy {lon},{lat}")).collect();
    for (name, grid, first) in grids {
        let file = grid.file(&bench, "globe.npy", false);
        let line = format!("path {file} {GLOBE} {name} --source-lonlat 170,30 {}", from.join(" "));
        let said = bench.json(format!("{line} -o p.geojson --json"));
        let found = parts(&bench.text("p.geojson"), "length");
        assert_eq!([&found[0], &found[2]].map(|(_, parts)| parts.len()), [2, 1], "{name}");
        for ((length, parts), start) in found.iter().zip(starts) {
            assert_divided(parts);
            let ends = [parts[0][0], *parts[parts.len() - 1].last().unwrap()];
            for (end, wanted) in ends.iter().zip([start, [170.0, 30.0]]) {
                assert!((0..2).all(|k| (end[k] - wanted[k]).abs() < 1e-6), "{name}: {ends:?}");
            }
            let exact = vincenty(start, [170.0, 30.0]).unwrap();
            assert!((length - exact).abs() < 1e-3 * exact, "{name} {start:?}: {length} {exact}");
        }
        // A path that meets the pole is divided there: one part ends at the pole and the other begins at it, on
        // opposite meridians. Between the middles of cells, the path may pass the pole by some kilometres.
        match &found[1].1[..] {
            [before, after] => {
                assert_eq!([before.last().unwrap()[1], after[0][1]], [90.0, 90.0], "{name}");
            }
            [whole] if name == "pixel" => {
                assert!(whole.iter().any(|place| place[1] > 89.9), "{whole:?}");
            }
            _ => panic!("{name}: {found:?}"),
        }
        // The report has the place as a row and column of the file's grid.
        assert_eq!(said["paths"][0]["from"], serde_json::json!(first));
    }
}

#[test]
fn masks_slowness_and_targets_have_the_size_of_the_file() {
    let bench = Workbench::new();
    let grid = Grid::new([-179.0, 180.0], [89.0, 90.0, -STEP]);
    let cells = grid.file(&bench, "cells.npy", true);
    let line = format!("distance {cells} {GLOBE} pixel --source-lonlat 31,-5 -o");
    bench.done(format!("{line} plain.npy"));
    let twice = bench.array("twice.npy", &grid.shape(), &vec![2.0; 90 * 180]);
    bench.done(format!("{line} slow.npy --slowness {twice}"));
    let [plain, slow] = ["plain.npy", "slow.npy"].map(|name| bench.map(name));
    assert!(plain.iter().zip(&slow).all(|(plain, slow)| (slow - 2.0 * plain).abs() <= 1e-9 * slow));
    // Africa and the Arctic are islands.
    let is_africa = |[lon, lat]: [f64; 2]| (lon - 20.0).abs() < 30.0 && lat.abs() < 30.0;
    let is_land = |place: [f64; 2]| i32::from(is_africa(place) || place[1] > 75.0);
    let mask: Vec<_> = grid.places().map(is_land).collect();
    let mut bytes = Vec::new();
    write_npy(&mut bytes, &grid.shape(), &mask).unwrap();
    let africa = bench.input("mask.npy", bytes);
    let said = bench.json(format!("{line} africa.npy --mask {africa} --json"));
    let land = mask.iter().filter(|&&land| land == 1).count() as u64;
    let africa_has = grid.places().filter(|&place| is_africa(place)).count() as u64;
    let counts = [&said["points"], &said["reached"]].map(Value::as_u64);
    assert_eq!(counts, [Some(land), Some(africa_has)]);
    let found = bench.map("africa.npy");
    let is_right = |(place, found): ([f64; 2], &f64)| found.is_finite() == is_africa(place);
    assert!(grid.places().zip(&found).all(is_right));
    for (target, said) in [("47,105", true), ("0,0", false)] {
        let output = bench.done(format!("{line} part.npy --mask {africa} --target {target}"));
        let [row, col] = target.split_once(',').map(|(row, col)| [row, col]).unwrap();
        let at = row.parse::<usize>().unwrap() * 180 + col.parse::<usize>().unwrap();
        assert_eq!(bench.map("part.npy")[at].is_finite(), said);
        let missed = notes(&output).contains(&format!("the target {target} is not reached"));
        assert_eq!(missed, !said, "{}", notes(&output));
    }
    let hole = bench.run(format!("{line} hole.npy --mask {africa} --target 89,0"));
    assert!(stderr(&hole).contains("the target 89,0 is in a hole"), "{}", stderr(&hole));
    let hole = bench.run(format!("{line} hole.npy --mask {africa} --source-lonlat 100,40"));
    assert!(!hole.status.success());
    let said = stderr(&hole);
    assert!(said.contains("--source-lonlat 100,40") && said.contains("hole"), "{said}");
    // A source that is given by row and column is reported with the row of the file, not of the completed surface.
    let hole = bench.run(format!("{line} hole.npy --mask {africa} -s 13,7"));
    assert!(stderr(&hole).contains("source 13,7 lies in a hole"), "{}", stderr(&hole));
}

#[test]
fn curves_are_sources_on_the_seam_but_do_not_leap_over_it() {
    let bench = Workbench::new();
    let grid = Grid::new([0.0, 181.0], [90.0, 91.0, -STEP]);
    let lines = grid.file(&bench, "lines.npy", false);
    let curve = |name: &str, places: &str| {
        let geometry = format!(r#"{{"type":"LineString","coordinates":[{places}]}}"#);
        bench.input(name, geometry)
    };
    let earth = "--geodetic --extent 0,-90,360,90 --registration gridline";
    let line = format!("distance {lines} {earth} -o map.npy --source-curve");
    // The equator up to Greenwich, where the grid begins and ends. Fronts around the ends of a curve err by up to a
    // fifth of a cell, which is 220 km wide.
    let whole = curve("whole.geojson", "[-5,0],[0,0]");
    bench.done(format!("{line} {whole}"));
    let found = bench.map("map.npy");
    for ([lon, lat], found) in grid.places().zip(found) {
        let lon = if lon > 180.0 { lon - 360.0 } else { lon };
        if lon.abs() < 60.0 && lat.abs() < 30.0 {
            let exact = vincenty([lon.clamp(-5.0, 0.0), 0.0], [lon, lat]).unwrap();
            assert!((found - exact).abs() < 4.4e4, "{lon},{lat}: {found} {exact}");
        }
    }
    std::fs::remove_file(bench.output("map.npy")).unwrap();
    let leaping = curve("leaping.geojson", "[-5,0],[5,0]");
    let output = bench.run(format!("{line} {leaping}"));
    bench.refuses(&output, &["leaping.geojson", "half a turn", "divide it"]);
}

#[test]
fn devices_map_the_earth_in_single_precision() {
    let bench = Workbench::new();
    let grid = Grid::new([-179.0, 180.0], [89.0, 90.0, -STEP]);
    let cells = grid.file(&bench, "cells.npy", false);
    let line = format!("distance {cells} {GLOBE} pixel --source-lonlat 13,52 -o map.npy --json");
    let said = bench.json(format!("{line} --engine vulkan"));
    assert_eq!([&said["precision"], &said["engine"]], ["single", "vulkan"]);
    let [mean, largest] = grid.errors([13.0, 52.0], &bench.map("map.npy"));
    println!("on a device: mean {mean:.1e}, largest {largest:.1e}");
    assert!(mean < 4e-5 && largest < 4e-3, "{mean:e} {largest:e}");
    let said = bench.json(format!("{line} --precision single --engine cpu"));
    assert_eq!(said["precision"], "single");
}

#[test]
fn what_the_commands_cannot_do_on_the_earth_is_refused() {
    let bench = Workbench::new();
    let flat = bench.flat(20, 30);
    let whole = format!("{GLOBE} pixel");
    let output = bench.run(format!("distance {flat} {whole} -s 3,3 -o map.exr"));
    bench.refuses(&output, &["single precision only", "--precision single"]);
    let vector = "--back-direction way.npy --direction-format vector";
    let output = bench.run(format!("distance {flat} {whole} -s 3,3 {vector}"));
    bench.refuses(&output, &["--back-direction: the surface has lines that the grid lacks"]);
}

/// The profile is of the completed surface, with rows at the poles and a column that the file lacks.
#[test]
fn maps_of_the_whole_earth_are_profiled() {
    let bench = Workbench::new();
    let cells = bench.flat(18, 36);
    let line = format!("profile {cells} {GLOBE} pixel --source-lonlat 179,-50 --repeat 1 --json");
    let said = bench.json(&line);
    assert_eq!([&said["rows"], &said["cols"]], [20, 37]);
    assert_eq!(said["converged"], true);
}

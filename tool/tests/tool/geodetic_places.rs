//! Places on the Earth: targets, curves and points of files at the seam and at the poles, and how they are reported.

use geosweep::io::{CoordinateSystem, SurfaceFile};

use crate::geodetic::{Grid, assert_divided, parts};
use crate::geodetic_files::{geotiff, geotiff_of_a_map, with_keys};
use crate::vincenty::vincenty;
use crate::workbench::{Workbench, notes, stderr};

/// Writes heights of zero.
fn zeros(bench: &Workbench, [rows, cols]: [usize; 2]) -> String {
    bench.array(&format!("{rows}x{cols}.npy"), &[rows, cols], &vec![0.0; rows * cols])
}

/// Writes a LineString of longitudes and latitudes.
fn line_string(bench: &Workbench, name: &str, places: &[[f64; 2]]) -> String {
    let places: Vec<_> = places.iter().map(|[lon, lat]| format!("[{lon:?},{lat:?}]")).collect();
    let places = places.join(",");
    bench.input(name, format!(r#"{{"type":"LineString","coordinates":[{places}]}}"#))
}

#[test]
fn targets_of_files_lie_on_the_seam_and_at_poles() {
    let bench = Workbench::new();
    for (size, earth, target) in [
        ([19, 36], "-180,-90,170,90 --registration gridline", [180.0, 40.0]),
        ([19, 36], "-180,-90,170,90 --registration gridline", [-180.0, 40.0]),
        ([19, 36], "-179.3,-90,170.7,90 --registration gridline", [180.7, -30.0]),
        ([17, 36], "-180,-80,170,80 --registration gridline", [0.0, 90.0]),
        ([18, 36], "-180,-90,180,90 --registration pixel", [25.0, -90.0]),
        ([18, 36], "-0.1,-90,359.9,90 --registration pixel --south-up", [364.9, -90.0]),
    ] {
        let earth = zeros(&bench, size) + " --geodetic --extent " + earth;
        let [lon, lat] = target;
        for (name, file) in [
            ("t.csv", format!("lon,lat\n{lon:?},{lat:?}\n")),
            ("t.geojson", format!(r#"{{"type":"Point","coordinates":[{lon:?},{lat:?}]}}"#)),
        ] {
            let file = bench.input(name, file);
            let line = format!("distance {earth} --source-lonlat 0,0 --targets {file} --json");
            let ends = bench.json(&line)["max_distance"].as_f64().unwrap();
            let exact = vincenty([0.0, 0.0], target).unwrap();
            println!("{target:?}: the map ends at {ends}, the target is at {exact}");
            // Points of cells beside the pole lie half a step before it.
            assert!(
                ends > exact - 6e5 && ends < exact + 2.5e5,
                "{earth} {target:?}: {ends} {exact}"
            );
        }
    }
}

#[test]
fn targets_between_points_are_refused_with_the_nearest_one() {
    let bench = Workbench::new();
    let cells = zeros(&bench, [18, 36]);
    for (target, near) in [
        ("7,88", "row -0.5, column 18"),
        ("-4,86", "row 0, column 17"),
        ("179,-5", "row 9, column 35"),
        ("-175,-88", "row 17.5, column 0"),
    ] {
        let file = bench.input("t.csv", format!("lon,lat\n{target}\n"));
        let words = "--geodetic --extent -180,-90,180,90 --registration pixel --source-lonlat 5,5";
        let output = bench.run(format!("distance {cells} {words} --targets {file} -o map.npy"));
        bench.refuses(&output, &["t.csv: line 2", "between points", near]);
    }
}

/// The latitude of the south pole is a sum of steps, and rounding makes it inexact.
#[test]
fn paths_over_the_south_pole_have_two_parts() {
    let bench = Workbench::new();
    for rows in [18, 100, 450, 1080] {
        let cells = zeros(&bench, [rows, 20]);
        let earth = "--geodetic --extent -180,-90,180,90 --registration pixel";
        let line = format!("path {cells} {earth} --source-lonlat 9,-80 --from-xy=-171,-80");
        bench.done(format!("{line} -o p.geojson"));
        let found = parts(&bench.text("p.geojson"), "length");
        let [(length, parts)] = &found[..] else { panic!("{found:?}") };
        assert_divided(parts);
        let [to, from] = &parts[..] else { panic!("{rows}: {parts:?}") };
        assert_eq!([to[0], *from.last().unwrap()], [[-171.0, -80.0], [9.0, -80.0]]);
        let (end, begin) = (to.last().unwrap(), from[0]);
        assert_eq!([end[1], begin[1]], [-90.0; 2], "{rows}");
        let is_inside = |part: &[[f64; 2]]| part.iter().all(|[_, lat]| *lat > -90.0);
        assert!(is_inside(&to[..to.len() - 1]) && is_inside(&from[1..]), "{rows}: {parts:?}");
        // Twice 10 degrees of the meridian.
        assert!((length - 2.0 * 1_116_827.0).abs() < 2e4, "{rows}: {length}");
        std::fs::remove_file(bench.output("p.geojson")).unwrap();
    }
}

#[test]
fn lengths_on_a_map_are_no_degrees() {
    let bench = Workbench::new();
    let header = "ncols 36\nnrows 18\nxllcorner 10\nyllcorner 20\ncellsize 2\n";
    let asc = bench.input("map.asc", format!("{header}{}", "0 ".repeat(648)));
    let line = format!("distance {asc} --geodetic --source-lonlat 20,30 -o map.npy");
    // The file's coordinates could be longitudes and latitudes.
    assert!(notes(&bench.done(&line)).contains("names no coordinate system"));
    std::fs::remove_file(bench.output("map.npy")).unwrap();
    for unit in [r#"UNIT["Metre",1]"#, r#"UNIT["Foot_US",0.3048006096]"#] {
        let system = r#"PROJCS["own",GEOGCS["WGS 84",UNIT["Degree",0.0174532925199433]]"#;
        bench.input("map.prj", format!("{system},{unit}]"));
        bench.refuse(&line, &["map.asc", "a length on a map", "not degrees", "gdalwarp"]);
    }
    let grid = Grid::new([0.0, 30.0], [20.0, 20.0, -1.0]);
    // A user-defined system in metres, in feet, or without a unit.
    for (name, keys) in [
        ("metres.tif", [1024, 0, 1, 1, 3072, 0, 1, 32767, 3076, 0, 1, 9001]),
        ("feet.tif", [1024, 0, 1, 1, 3072, 0, 1, 32767, 3076, 0, 1, 9003]),
        ("unnamed.tif", [1024, 0, 1, 1, 1025, 0, 1, 1, 3072, 0, 1, 32767]),
    ] {
        let file = bench.input(name, with_keys(geotiff(&grid, [10.0, 60.0], false), keys));
        let line = format!("distance {file} --geodetic --source-lonlat 20,50 -o map.npy");
        bench.refuse(&line, &[name, "a length on a map", "not degrees"]);
    }
}

#[test]
fn values_are_checked_where_the_file_has_them() {
    let bench = Workbench::new();
    for (size, registration, [row, col]) in [
        ([19, 36], "-180,-90,170,90 --registration gridline", [0, 3]),
        ([19, 36], "-180,-90,170,90 --registration gridline", [18, 35]),
        ([18, 36], "-180,-90,180,90 --registration pixel", [5, 7]),
        ([18, 36], "-180,-90,180,90 --registration pixel", [17, 0]),
    ] {
        let surface = zeros(&bench, size);
        let points = size[0] * size[1];
        let at = row * size[1] + col;
        let words = format!("--geodetic --extent {registration} --source-lonlat 3,4 -o map.npy");
        let mut slowness = vec![2.0; points];
        slowness[at] = -1.0;
        let slow = bench.array("slow.npy", &size, &slowness);
        let output = bench.run(format!("distance {surface} {words} --slowness {slow}"));
        bench.refuses(&output, &["slow.npy", &format!("slowness -1 at row {row}, column {col}")]);
        let mut heights = vec![0.0; points];
        heights[at] = f64::INFINITY;
        let high = bench.array("high.npy", &size, &heights);
        let output = bench.run(format!("distance {high} {words}"));
        bench.refuses(&output, &["high.npy", &format!("at row {row}, column {col} is infinite")]);
        // A hole has no slowness.
        heights[at] = f64::NAN;
        let hole = bench.array("hole.npy", &size, &heights);
        bench.done(format!("distance {hole} {words}"));
        let plain = bench.map("map.npy");
        bench.done(format!("distance {hole} {words} --slowness {slow}"));
        for (slow, plain) in bench.map("map.npy").iter().zip(plain) {
            assert!(*slow == 2.0 * plain || (slow - 2.0 * plain).abs() < 1e-9 * plain, "{slow}");
        }
        std::fs::remove_file(bench.output("map.npy")).unwrap();
    }
}

#[test]
fn values_have_the_precision_of_their_map() {
    let bench = Workbench::new();
    let cells = zeros(&bench, [18, 36]);
    let earth = format!("{cells} --geodetic --extent=-0.1,-90,359.9,90 --registration pixel");
    let earth = format!("{earth} --source-lonlat 23.7,31.9");
    bench.done(format!("distance {earth} -o map.npy"));
    let found = bench.map("map.npy");
    let line = format!("value {earth} --at 4,7 --at 17,35 --at 4.5,7.25");
    let said = bench.json(format!("{line} --json"));
    assert_eq!(said["precision"], "double");
    let at = |index: usize| said["values"][index]["distance"].as_f64().unwrap();
    assert_eq!([at(0), at(1)], [found[4 * 36 + 7], found[17 * 36 + 35]]);
    assert_ne!(at(0), f64::from(at(0) as f32));
    let printed = String::from_utf8(bench.done(&line).stdout).unwrap();
    let printed: Vec<f64> =
        printed.lines().map(|line| line.rsplit(',').next().unwrap().parse().unwrap()).collect();
    assert_eq!(printed, [at(0), at(1), at(2)]);
    let said = bench.json(format!("{line} --engine vulkan --json"));
    assert_eq!(said["precision"], "single");
}

/// Places at the seam and beside the poles have columns and rows beyond those of the file.
#[test]
fn the_tool_reads_its_own_points_and_curves() {
    let bench = Workbench::new();
    let cells = zeros(&bench, [36, 72]);
    for extent in ["-180,-90,180,90", "-100.3,-90,259.7,90"] {
        let earth = format!("{cells} --geodetic --extent {extent} --registration pixel");
        bench.done(format!("sample {earth} -k 9 -o s.csv -o s.npy -o s.geojson"));
        let maps = ["s.csv", "s.npy", "s.geojson"].map(|name| {
            let file = bench.output(name).display().to_string();
            bench.done(format!("distance {earth} --source-points {file} -o map.npy"));
            bench.map("map.npy")
        });
        assert_eq!(maps[0], maps[1], "{extent}");
        let differs = |(a, b): (&f64, &f64)| (a - b).abs() > 1e-3;
        assert!(!maps[0].iter().zip(&maps[2]).any(differs), "{extent}");
        // Circles over the seam, over a pole and round the Earth.
        let source = [178.0, 61.0];
        for level in ["2e6", "4e6", "1.3e7"] {
            let line = format!("contours {earth} --source-lonlat 178,61 --levels {level}");
            bench.done(format!("{line} -o c.csv -o c.npy"));
            for name in ["c.csv", "c.npy"] {
                let file = bench.output(name).display().to_string();
                bench.done(format!("distance {earth} --source-curve {file} -o map.npy"));
                let west: f64 = extent.split(',').next().unwrap().parse().unwrap();
                let grid = Grid::new([west + 2.5, 72.0], [87.5, 36.0, -5.0]);
                let level: f64 = level.parse().unwrap();
                let mut largest = 0f64;
                for (place, found) in grid.places().zip(bench.map("map.npy")) {
                    let Some(far) = vincenty(source, place).filter(|far| *far < 1.9e7) else {
                        continue;
                    };
                    largest = largest.max((found - (far - level).abs()).abs());
                }
                println!("{extent} {level:e} {name}: differs by {largest:.1e}");
                // A third of a cell.
                assert!(largest < 1.8e5, "{extent} {level} {name}: {largest:e}");
            }
        }
    }
}

/// The distances are those on a grid that begins elsewhere, where the curve is on no seam.
#[test]
fn curves_along_the_seam_are_on_the_side_of_their_neighbours() {
    let bench = Workbench::new();
    for seam in [0.0, 0.3] {
        let grid = |west: f64| {
            let (surface, east) = (zeros(&bench, [91, 180]), west + 358.0);
            format!("{surface} --geodetic --extent {west},-90,{east},90 --registration gridline")
        };
        let at = |east: f64, north: f64| [seam + east, north];
        for (name, places) in [
            ("begins", vec![at(0.0, 10.0), at(0.0, 20.0), at(-10.0, 20.0)]),
            ("begins.east", vec![at(0.0, 10.0), at(0.0, 20.0), at(10.0, 20.0)]),
            ("ends", vec![at(-20.0, -30.0), at(0.0, -20.0), at(0.0, 0.0), at(0.0, 20.0)]),
            ("lies", vec![at(0.0, -20.0), at(0.0, 10.0)]),
            ("touches", vec![at(-25.0, 5.0), at(0.0, 10.0), at(0.0, 20.0), at(-15.0, 40.0)]),
            ("crosses", vec![at(-25.0, 5.0), at(0.0, 10.0), at(0.0, 20.0), at(15.0, 40.0)]),
            ("meets", vec![at(10.0, 5.0), at(0.0, 15.0), at(-30.0, 15.0)]),
        ] {
            let file = line_string(&bench, &format!("{name}.geojson"), &places);
            let line = |west: f64| {
                bench.done(format!("distance {} --source-curve {file} -o map.npy", grid(west)));
                bench.map("map.npy")
            };
            let (on_seam, inside) = (line(seam), line(seam - 180.0));
            let mut largest = 0f64;
            for (index, found) in on_seam.iter().enumerate() {
                let (row, col) = (index / 180, index % 180);
                let expected = inside[row * 180 + (col + 90) % 180];
                largest = largest.max((found - expected).abs());
            }
            // The differences are in metres. Where fronts focus, rounding errors grow.
            println!("{name} at {seam}: differs by {largest:.1e}");
            assert!(largest < 1e-3, "{name} at {seam}: {largest:e}");
        }
        let leaping = line_string(&bench, "leaping.geojson", &[at(-10.0, 5.0), at(10.0, 5.0)]);
        let line = format!("distance {} --source-curve {leaping} -o leap.npy", grid(seam));
        let output = bench.run(&line);
        assert!(stderr(&output).contains("half a turn"), "{}", stderr(&output));
    }
}

#[test]
fn maps_of_ascii_grids_name_the_assumed_system() {
    let bench = Workbench::new();
    let header = "ncols 40\nnrows 30\nxllcorner 170.25\nyllcorner 50.1\ncellsize 0.3\n";
    let asc = bench.input("deg.asc", format!("{header}{}", "0 ".repeat(1200)));
    bench.done(format!("distance {asc} --geodetic -s 3,3 -o d.tif"));
    let [given, written] = [asc.as_ref(), bench.output("d.tif").as_path()]
        .map(|path: &std::path::Path| SurfaceFile::read(path).unwrap().georeference().unwrap());
    assert_eq!(written.system, Some(CoordinateSystem::WGS_84));
    for place in [[0.0, 0.0], [29.0, 39.0]] {
        let [given, written] = [given, written].map(|at| at.coordinates(place));
        assert!((0..2).all(|k| (given[k] - written[k]).abs() < 1e-9), "{given:?} {written:?}");
    }
}

#[test]
fn extents_without_a_span_are_refused() {
    let bench = Workbench::new();
    let cells = zeros(&bench, [18, 36]);
    for extent in [
        "0.1,-90,-359.9,90",
        "10,-90,10,90",
        "-30.7,-90,-30.7,90",
        "0,10.3,90,10.3",
        "0,10.3,90,10.300000000000002",
    ] {
        let line = format!("distance {cells} --geodetic --extent={extent} --registration pixel");
        let output = bench.run(format!("{line} -s 3,3 -o map.npy"));
        bench.refuses(&output, &["--extent", "more than 0 degrees"]);
    }
}

#[test]
fn what_is_no_place_on_the_earth_is_refused() {
    let bench = Workbench::new();
    let flat = bench.flat(20, 30);
    let tube = bench.tube();
    let whole = "--geodetic --extent -180,-90,180,90 --registration pixel";
    let part = "--geodetic --extent 170,-20,-170,20 --registration gridline";
    let header = "ncols 30\nnrows 20\nxllcorner 500000\nyllcorner 4000000\ncellsize 30\n";
    let far = bench.input("far.asc", format!("{header}{}", "0 ".repeat(600)));
    let projected = geotiff_of_a_map(&bench);
    for (surface, words, said) in [
        (&flat, format!("{whole} --source-lonlat 13,90.5"), "latitudes lie between -90 and 90"),
        (&flat, format!("{whole} --source-lonlat 13"), "LON,LAT[,T0]"),
        (&flat, format!("{part} --source-lonlat 13,9"), "x 13, y 9 lies outside the grid"),
        (
            &flat,
            format!("{part} -s 20,3"),
            "source 20,3 lies outside the grid: rows run from 0 to 19",
        ),
        (&flat, format!("{part} -s 3,3 --target 3,30"), "target 3,30 lies outside the grid"),
        (&flat, "--source-lonlat 13,9".into(), "--geodetic"),
        (&flat, "--geodetic -s 3,3".into(), "--extent WEST,SOUTH,EAST,NORTH"),
        (&flat, "--geodetic --extent 0,0,9,9 -s 3,3".into(), "--registration"),
        (&flat, "--extent 0,0,9,9 --registration pixel -s 3,3".into(), "--geodetic"),
        (&flat, "--geodetic --registration pixel -s 3,3".into(), "--extent"),
        (&flat, whole.replace("-90,180,90", "90,180,-90") + " -s 3,3", "--south-up"),
        (&flat, whole.replace("180,90", "180,95") + " -s 3,3", "latitude 95"),
        (&flat, whole.replace("-180,-90", "-380,-90") + " -s 3,3", "at most 360 degrees"),
        (&flat, whole.replace("-180,-90", "-181,-90") + " -s 3,3", "at most 360 degrees"),
        (&flat, whole.replace("-180,-90", "180,-90") + " -s 3,3", "more than 0"),
        (&flat, format!("{whole} -s 3,3 --spacing 30"), "--spacing"),
        (&flat, format!("{whole} -s 3,3 --glue globe"), "--glue"),
        (&flat, format!("{whole} -s 3,3 --metric {flat}"), "--metric"),
        (
            &flat,
            format!("{whole} -s 3,3 --back-direction b.npy"),
            "--back-direction: the surface has lines that the grid lacks",
        ),
        (&flat, format!("{whole} -s 3,3 --precision double --engine vulkan"), "double"),
        (&tube, format!("{whole} -s 3,3"), "holds positions, not heights"),
        (&far, "--geodetic -s 3,3".into(), "latitudes lie between -90 and 90 degrees"),
        (&far, format!("{whole} -s 3,3"), "leave --extent out"),
        (&projected, "--geodetic -s 3,3".into(), "EPSG:32616"),
        (&"builtin:sphere:9x9".into(), "--geodetic -s 3,3".into(), "built-in"),
    ] {
        let output = bench.run(format!("distance {surface} {words} -o map.npy"));
        bench.refuses(&output, &[said]);
    }
}

#[test]
fn longitudes_are_the_same_after_any_number_of_turns() {
    let bench = Workbench::new();
    let part = zeros(&bench, [19, 36]) + " --geodetic --registration gridline --extent";
    let map = |extent: &str, source: &str| {
        bench.done(format!("distance {part} {extent} --source-lonlat={source} -o map.npy"));
        bench.map("map.npy")
    };
    let plain = map("10,40,24.2,50", "12.5,44");
    for (extent, source) in [
        ("10,40,24.2,50", "372.5,44"),
        ("10,40,24.2,50", "-1787.5,44"),
        ("370,40,384.2,50", "12.5,44"),
        ("370,40,384.2,50", "732.5,44"),
        ("-350,40,-335.8,50", "12.5,44"),
    ] {
        let turned = map(extent, source);
        assert!(turned.iter().zip(&plain).all(|(a, b)| (a - b).abs() < 1e-3), "{extent} {source}");
    }
}

/// A raster of the Moon, and one in grads.
#[test]
fn ellipsoids_and_angles_are_those_of_the_file() {
    let bench = Workbench::new();
    let header = "ncols 31\nnrows 31\nxllcenter 0\nyllcenter -15\ncellsize 1\n";
    let asc = bench.input("moon.asc", format!("{header}{}", "0 ".repeat(961)));
    let line = format!("distance {asc} --geodetic --source-lonlat 0,0 -o map.npy");
    for (radius, inverse) in
        [(1_737_400.0, 0.0), (3_396_190.0, 169.894), (6_378_137.0, 298.257_223_563)]
    {
        let unit = "UNIT[\"Degree\",0.0174532925199433]";
        let datum = format!("DATUM[\"D\",SPHEROID[\"own\",{radius:?},{inverse:?}]]");
        bench.input("moon.prj", format!("GEOGCS[\"own\",{datum},PRIMEM[\"p\",0],{unit}]"));
        let said = notes(&bench.done(&line));
        assert_eq!(said.contains("own ellipsoid"), radius < 6e6, "{said}");
        // Along the equator, 30 degrees are a twelfth of it.
        let found = bench.map("map.npy")[15 * 31 + 30];
        assert!((found / (radius * std::f64::consts::FRAC_PI_6) - 1.0).abs() < 1e-4, "{found}");
    }
    std::fs::remove_file(bench.output("map.npy")).unwrap();
    let grads = "UNIT[\"Grad\",0.01570796326794897]";
    bench.input(
        "moon.prj",
        format!("GEOGCS[\"NTF\",DATUM[\"D\",SPHEROID[\"C\",6378249.2,293.466]],{grads}]"),
    );
    bench.refuse(&line, &["not in degrees", "gdalwarp"]);
    // GeoTIFF names systems by their number in the EPSG register.
    let cells = Grid::new([1.0, 180.0], [89.0, 90.0, -2.0]);
    for (code, said) in [(4807, Some("not in degrees")), (4277, None), (4326, None)] {
        let keys = [1024, 0, 1, 2, 2048, 0, 1, code, 4099, 0, 1, 9001];
        let file = bench.input("a.tif", with_keys(geotiff(&cells, [0.0, 90.0], false), keys));
        let line = format!("distance {file} --geodetic --source-lonlat 9,1 -o map.npy");
        match said {
            Some(said) => bench.refuse(&line, &[said]),
            None => {
                let said = notes(&bench.done(&line));
                assert_eq!(said.contains("own ellipsoid"), code == 4277, "{said}");
                assert!(!said.contains("taken as those of WGS 84"), "{said}");
                std::fs::remove_file(bench.output("map.npy")).unwrap();
            }
        }
    }
}

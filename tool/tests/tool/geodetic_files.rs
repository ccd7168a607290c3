//! Files of grids on the Earth: the places, units and coordinate systems that they state.

use std::io::Cursor;

use geosweep::io::SurfaceFile;

use crate::geodetic::{Grid, STEP};
use crate::workbench::{Workbench, notes};

/// Returns a GeoTIFF of the grid's heights with coordinates in degrees. Its first pixel lies at `corner`. Its pixels
/// are points if `is_point`, otherwise areas.
pub fn geotiff(grid: &Grid, corner: [f64; 2], is_point: bool) -> Vec<u8> {
    use tiff::encoder::{TiffEncoder, colortype::Gray32Float};
    use tiff::tags::Tag;
    let [rows, cols] = grid.shape().map(|count| count as u32);
    let mut file = Cursor::new(Vec::new());
    let mut encoder = TiffEncoder::new(&mut file).unwrap();
    let mut image = encoder.new_image::<Gray32Float>(cols, rows).unwrap();
    let tags = image.encoder();
    let tie = [0.0, 0.0, 0.0, corner[0], corner[1], 0.0];
    tags.write_tag(Tag::ModelPixelScaleTag, &[STEP, STEP, 0.0][..]).unwrap();
    tags.write_tag(Tag::ModelTiepointTag, &tie[..]).unwrap();
    let raster = if is_point { 2 } else { 1 };
    let keys = [1, 1, 0, 3, 1024, 0, 1, 2, 1025, 0, 1, raster, 2048, 0, 1, 4326u16];
    tags.write_tag(Tag::GeoKeyDirectoryTag, &keys[..]).unwrap();
    let heights: Vec<_> = grid.heights().into_iter().map(|height| height as f32).collect();
    image.write_data(&heights).unwrap();
    file.into_inner()
}

/// Writes a GeoTIFF whose coordinates are metres of a map projection.
pub fn geotiff_of_a_map(bench: &Workbench) -> String {
    let grid = Grid::new([0.0, 30.0], [20.0, 20.0, -1.0]);
    let keys = [1024, 0, 1, 1, 1025, 0, 1, 1, 3072, 0, 1, 32616];
    bench.input("map.tif", with_keys(geotiff(&grid, [5e5, 4e6], false), keys))
}

/// Replaces the three keys of a GeoTIFF in degrees whose pixels are areas.
pub fn with_keys(mut bytes: Vec<u8>, keys: [u16; 12]) -> Vec<u8> {
    let words = |keys: [u16; 12]| keys.map(u16::to_le_bytes).concat();
    let degrees = words([1024, 0, 1, 2, 1025, 0, 1, 1, 2048, 0, 1, 4326]);
    let at = bytes.windows(degrees.len()).position(|window| window == degrees).unwrap();
    bytes[at..at + degrees.len()].copy_from_slice(&words(keys));
    bytes
}

#[test]
fn a_geotiff_in_degrees_says_where_it_lies() {
    let bench = Workbench::new();
    let (cells, lines) = (
        Grid::new([1.0, 180.0], [89.0, 90.0, -STEP]),
        Grid::new([0.0, 181.0], [90.0, 91.0, -STEP]),
    );
    let files = [
        (
            "area.tif",
            &cells,
            geotiff(&cells, [0.0, 90.0], false),
            "0,-90,360,90 --registration pixel",
        ),
        (
            "point.tif",
            &cells,
            geotiff(&cells, [1.0, 89.0], true),
            "0,-90,360,90 --registration pixel",
        ),
        (
            "lines.tif",
            &lines,
            geotiff(&lines, [0.0, 90.0], true),
            "0,-90,360,90 --registration gridline",
        ),
    ];
    for (name, grid, bytes, extent) in files {
        let file = bench.input(name, bytes);
        let refused = bench.run_args(["distance", &file, "-s", "3,4", "-o", "map.tif"]);
        bench.refuses(&refused, &[name, "degrees", "--geodetic", "--spacing"]);
        let output =
            bench.done(format!("distance {file} --geodetic --source-lonlat -20,64 -o map.tif"));
        let said = notes(&output);
        assert!(
            said.contains("ellipsoid") && said.contains("60,000th") && said.contains("double"),
            "{said}"
        );
        assert_eq!(said.lines().count(), 1, "{said}");
        // Single precision of the file's heights changes distances by less than a millimetre.
        let array = grid.file(&bench, "same.npy", true);
        let line = format!("distance {array} --geodetic --extent {extent} --source-lonlat -20,64");
        bench.done(format!("{line} -o same.npy"));
        let found = bench.map("map.tif");
        for (found, expected) in found.iter().zip(bench.map("same.npy")) {
            assert!((found - expected).abs() < 1e-2, "{name}: {found} {expected}");
        }
        let [given, written] = [file.as_ref(), bench.output("map.tif").as_path()]
            .map(|path: &std::path::Path| SurfaceFile::read(path).unwrap().georeference().unwrap());
        assert_eq!(given, written, "{name}");
        std::fs::remove_file(bench.output("map.tif")).unwrap();
        std::fs::remove_file(bench.output("same.npy")).unwrap();
    }
}

#[test]
fn heights_in_feet_become_metres() {
    let bench = Workbench::new();
    let cells = Grid::new([1.0, 180.0], [89.0, 90.0, -STEP]);
    let keys = [1024, 0, 1, 2, 2048, 0, 1, 4326, 4099, 0, 1, 9002];
    let feet = bench.input("feet.tif", with_keys(geotiff(&cells, [0.0, 90.0], false), keys));
    let heights: Vec<_> = cells.heights().iter().map(|height| 0.3048 * height).collect();
    let metres = bench.array("metres.npy", &cells.shape(), &heights);
    let extent = "--extent 0,-90,360,90 --registration pixel";
    for (surface, words, name) in [(feet, "", "feet.npy"), (metres, extent, "metres.npy")] {
        let line = format!("distance {surface} --geodetic {words} --source-lonlat 9,1 -o {name}");
        bench.done(&line);
    }
    let [feet, metres] = ["feet.npy", "metres.npy"].map(|name| bench.map(name));
    assert!(feet.iter().zip(&metres).all(|(feet, metres)| (feet - metres).abs() < 1e-2));
}

#[test]
fn an_ascii_grid_in_degrees_is_a_part_of_the_earth() {
    let bench = Workbench::new();
    let header = "ncols 40\nnrows 30\nxllcorner 170\nyllcorner 50\ncellsize 0.5\n";
    let asc = bench.input("part.asc", format!("{header}{}", "0 ".repeat(1200)));
    bench.refuses(&bench.distance(&asc, "-s 3,3 -o map.npy"), &["degrees", "--geodetic"]);
    let line = format!("distance {asc} --geodetic --source-lonlat -178.75,60.25 -o map.npy");
    let said = notes(&bench.done(&line));
    assert!(said.contains("part.asc names no coordinate system; it is taken as WGS 84"), "{said}");
    let grid = Grid {
        longitudes: (0..40).map(|col| 170.25 + 0.5 * f64::from(col)).collect(),
        latitudes: (0..30).map(|row| 64.75 - 0.5 * f64::from(row)).collect(),
    };
    let [mean, largest] = grid.errors([181.25, 60.25], &bench.map("map.npy"));
    println!("a part by cells of half a degree: mean {mean:.1e}, largest {largest:.1e}");
    assert!(mean < 5e-6 && largest < 2e-5, "{mean:e} {largest:e}");
}

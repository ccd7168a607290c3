//! World files and GDAL's auxiliary metadata beside a raster. The expected values are what GDAL 3.10 reads.

use std::io::Cursor;

use geosweep::io::{CoordinateSystem, GeoTags, Georeference, MapFormat, SurfaceFile};

use crate::workbench::Workbench;

const WORLD: &str = "10\n0\n0\n-10\n500005\n4999995\n";

fn auxiliary(more: &str) -> String {
    format!(
        r#"<PAMDataset><SRS>PROJCS["WGS 84 / UTM zone 33N",UNIT["metre",1],AUTHORITY["EPSG","32633"]]</SRS>
           <GeoTransform> 5.0e+05,  2.0e+01,  0.0e+00,  5.0e+06,  0.0e+00, -2.0e+01</GeoTransform>
           <PAMRasterBand band="1">{more}</PAMRasterBand></PAMDataset>"#
    )
}

/// Writes a raster of 3 x 4 values, 0 to 11.
fn raster(bench: &Workbench, name: &str, tags: Option<&GeoTags>) -> String {
    let values: Vec<f32> = (0..12).map(|value| value as f32).collect();
    let mut bytes = Cursor::new(Vec::new());
    MapFormat::Tiff.write(&mut bytes, 3, 4, &values, tags).unwrap();
    bench.input(name, bytes.into_inner())
}

fn place(file: &str) -> Georeference {
    SurfaceFile::read(file.as_ref()).unwrap().georeference().unwrap()
}

#[test]
fn world_files_place_rasters_that_have_no_place() {
    for extension in ["tfw", "tifw", "wld"] {
        let bench = Workbench::new();
        let file = raster(&bench, "a.tif", None);
        bench.input(&format!("a.{extension}"), WORLD);
        let found = place(&file);
        assert_eq!([found.origin, found.right], [[500_005.0, 4_999_995.0], [10.0, 0.0]]);
        let line = format!("distance {file} --spacing 10 --source-xy 500015,4999985 -o d.npy");
        bench.done(line);
        assert_eq!(bench.map("d.npy")[5], 0.0);
    }
    let own = Georeference {
        origin: [7.0, 8.0],
        down: [0.0, -2.0],
        right: [2.0, 0.0],
        system: Some(CoordinateSystem::Projected(32632)),
    };
    let bench = Workbench::new();
    let file = raster(&bench, "b.tif", Some(&GeoTags::new(&own)));
    bench.input("b.tfw", WORLD);
    assert_eq!(place(&file), own);
    let file = raster(&bench, "c.tif", None);
    bench.input("c.tfw", "10 0 0 x 1 2");
    bench.refuse(format!("distance {file} -s 0,0 -o d.npy"), &["c.tfw", "six numbers"]);
}

#[test]
fn auxiliary_metadata_replace_those_of_the_raster() {
    let own = Georeference {
        origin: [7.0, 8.0],
        down: [0.0, -2.0],
        right: [2.0, 0.0],
        system: Some(CoordinateSystem::Projected(32632)),
    };
    for tags in [None, Some(GeoTags::new(&own))] {
        let bench = Workbench::new();
        let file = raster(&bench, "a.tif", tags.as_ref());
        bench.input("a.tfw", WORLD);
        let more = "<NoDataValue>5</NoDataValue><Offset>7</Offset><Scale>0.5</Scale>";
        bench.input("a.tif.aux.xml", auxiliary(more));
        let found = place(&file);
        assert_eq!([found.origin, found.right], [[500_010.0, 4_999_990.0], [20.0, 0.0]]);
        assert_eq!(found.system, Some(CoordinateSystem::Projected(32633)));
        let heights = SurfaceFile::read(file.as_ref()).unwrap().into_heights().unwrap().values;
        for (index, height) in heights.iter().enumerate() {
            match index {
                5 => assert!(height.is_nan()),
                _ => assert_eq!(*height, 7.0 + 0.5 * index as f64),
            }
        }
        bench.done(format!("distance {file} -s 0,0 --engine cpu -o d.npy"));
        assert!(bench.map("d.npy")[5].is_infinite());
        // The mask and the slowness have such files too.
        let mask = raster(&bench, "m.tif", tags.as_ref());
        bench.input("m.tif.aux.xml", auxiliary("<NoDataValue>6</NoDataValue>"));
        bench.done(format!("distance {file} --mask {mask} -s 0,3 --engine cpu -o m.npy"));
        let found = bench.map("m.npy");
        assert!([0, 5, 6].iter().all(|&hole| found[hole].is_infinite()), "{found:?}");

        bench.input("a.tif.aux.xml", auxiliary("<UnitType>ft</UnitType>"));
        let line = format!("distance {file} -s 0,0 -o e.npy");
        let said = String::from_utf8_lossy(&bench.run(line).stderr).into_owned();
        assert!(said.contains("its heights in a unit other than metres"), "{said}");
        let metres = SurfaceFile::read(file.as_ref()).unwrap().into_heights().unwrap().values;
        assert!((metres[10] - 3.048).abs() < 1e-9);
    }
    let bench = Workbench::new();
    let file = raster(&bench, "n.tif", None);
    bench.input("n.tif.aux.xml", auxiliary("").replace(r#","32633""#, r#","own""#));
    let line = format!("distance {file} -s 0,0 -o d.npy");
    bench.refuse(line, &["n.tif.aux.xml", "without a number", "gdal_translate"]);
}

#[test]
fn ascii_grids_are_scaled_by_auxiliary_metadata() {
    let bench = Workbench::new();
    let header = "ncols 4\nnrows 3\nxllcorner 1000\nyllcorner 2000\ncellsize 10\n";
    let grid = bench.input("h.asc", format!("{header}1 2 3 4 5 6 7 8 9 10 11 12\n"));
    bench.input("h.asc.aux.xml", auxiliary("<Offset>7</Offset><Scale>0.5</Scale>"));
    let file = SurfaceFile::read(grid.as_ref()).unwrap();
    assert_eq!(file.georeference().unwrap().origin, [1005.0, 2025.0]);
    assert_eq!(file.into_heights().unwrap().values[2], 8.5);
}

/// Writes a grey picture of 3 x 4 values, 0 to 11.
fn picture(bench: &Workbench, name: &str, depth: png::BitDepth) -> String {
    let wide = depth == png::BitDepth::Sixteen;
    let values = (0..12u16).flat_map(|value| match wide {
        true => value.to_be_bytes().to_vec(),
        false => vec![value as u8],
    });
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, 4, 3);
    encoder.set_color(png::ColorType::Grayscale);
    encoder.set_depth(depth);
    encoder.write_header().unwrap().write_image_data(&values.collect::<Vec<_>>()).unwrap();
    bench.input(name, bytes)
}

/// Pictures have the files beside them that GDAL reads.
#[test]
fn pictures_are_placed_and_scaled_by_the_files_beside_them() {
    for depth in [png::BitDepth::Eight, png::BitDepth::Sixteen] {
        for extension in ["pgw", "pngw", "wld", "PGW"] {
            let bench = Workbench::new();
            let file = picture(&bench, "a.png", depth);
            assert!(SurfaceFile::read(file.as_ref()).unwrap().georeference().is_err());
            bench.input(&format!("a.{extension}"), WORLD);
            let found = place(&file);
            assert_eq!([found.origin, found.right], [[500_005.0, 4_999_995.0], [10.0, 0.0]]);
            bench.done(format!("distance {file} --spacing 10 --source-xy 500015,4999985 -o d.npy"));
            assert_eq!(bench.map("d.npy")[5], 0.0);
        }
        let bench = Workbench::new();
        let file = picture(&bench, "a.png", depth);
        bench.input("a.pgw", WORLD);
        let more = "<NoDataValue>5</NoDataValue><Offset>7</Offset><Scale>0.5</Scale>";
        bench.input("a.png.aux.xml", auxiliary(more));
        let found = place(&file);
        assert_eq!([found.origin, found.right], [[500_010.0, 4_999_990.0], [20.0, 0.0]]);
        assert_eq!(found.system, Some(CoordinateSystem::Projected(32633)));
        let heights = SurfaceFile::read(file.as_ref()).unwrap().into_heights().unwrap().values;
        assert!(heights[5].is_nan() && heights[4] == 9.0 && heights[11] == 12.5, "{heights:?}");
        // The spacing is that of the file.
        bench.done(format!("distance {file} -s 0,0 --engine cpu -o d.tif"));
        assert_eq!(place(bench.output("d.tif").to_str().unwrap()), found);
    }
    // A mask that GDAL keeps beside a picture, and a mask that is a picture with a no-data value.
    let bench = Workbench::new();
    let file = picture(&bench, "a.png", png::BitDepth::Eight);
    let mut bytes = Cursor::new(Vec::new());
    let shown: Vec<f32> = (0..12).map(|index| f32::from(u8::from(index != 6))).collect();
    MapFormat::Tiff.write(&mut bytes, 3, 4, &shown, None).unwrap();
    bench.input("a.png.msk", bytes.into_inner());
    let mask = picture(&bench, "m.png", png::BitDepth::Eight);
    bench.input("m.png.aux.xml", auxiliary("<NoDataValue>9</NoDataValue>"));
    bench.done(format!("distance {file} --spacing 1 -s 0,1 --mask {mask} --engine cpu -o d.npy"));
    let holes: Vec<_> = (0..12).filter(|&at| bench.map("d.npy")[at].is_infinite()).collect();
    assert_eq!(holes, [0, 6, 9]);
}

/// In well-known text, the system of heights follows that of the map.
#[test]
fn compound_systems_have_a_unit_for_the_map_and_one_for_heights() {
    let bench = Workbench::new();
    let header = "ncols 3\nnrows 2\nxllcorner 1000\nyllcorner 2000\ncellsize 10\n";
    let asc = bench.input("a.asc", format!("{header}0 0 0\n0 0 0\n"));
    let line = format!("distance {asc} -s 0,0 --engine cpu -o m.npy");
    let site = |unit: &str| format!("LOCAL_CS[\"site\",{unit}]");
    let map = |unit: &str| {
        format!("PROJCS[\"A\",GEOGCS[\"B\",UNIT[\"Degree\",0.0174532925199433]],{unit}]")
    };
    let above = |unit| format!("VERT_CS[\"N\",VERT_DATUM[\"N\",2005],{unit}]");
    let [metre, foot] = ["UNIT[\"metre\",1]", "UNIT[\"US survey foot\",0.304800609601219]"];
    for (system, is_usable) in [
        (site(metre), true),
        (site(foot), false),
        (map(metre), true),
        (map(foot), false),
        (format!("COMPD_CS[\"C\",{},{}]", map(metre), above(metre)), true),
        (format!("COMPD_CS[\"C\",{},{}]", map(foot), above(foot)), true),
        (format!("COMPD_CS[\"C\",{},{}]", map(foot), above(metre)), false),
        (format!("{},{}", map(metre), above(foot).replace("VERT_CS", "VERTCS")), false),
    ] {
        bench.input("a.prj", &system);
        if is_usable {
            bench.done(&line);
            assert_eq!(bench.map("m.npy")[1], 10.0, "{system}");
            std::fs::remove_file(bench.output("m.npy")).unwrap();
        } else {
            bench.refuse(&line, &["a.asc", "cell size", "unit", "--spacing"]);
        }
    }
}

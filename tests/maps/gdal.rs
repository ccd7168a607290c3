//! GeoTIFFs are read as GDAL reads them. `gdal/make.py` has written the files with GDAL, and beside them the
//! values that GDAL reads from them.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use geosweep::Spacing;
use geosweep::io::{
    CoordinateSystem, Grid, MapFormat, SurfaceFile, read_map, read_mask, read_slowness,
    write_labels_tiff, write_vectors_tiff,
};
use geosweep::surface::Geometry;
use tiff::decoder::{Decoder, DecodingResult};

fn fixtures() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/maps/gdal")
}

/// Compares every `variant-*.tif` of a folder with the values in the `.npy` file beside it. Returns the number
/// of compared files.
fn check_variants(folder: &Path) -> usize {
    let mut paths: Vec<_> =
        fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    paths.retain(|path| {
        path.extension().is_some_and(|extension| extension == "tif")
            && path.file_name().unwrap().to_string_lossy().starts_with("variant")
    });
    for path in &paths {
        let name = path.display();
        let expected = read_map(&path.with_extension("npy")).unwrap();
        let found = read_map(path).unwrap_or_else(|error| panic!("{error}"));
        assert_eq!((found.rows, found.cols), (expected.rows, expected.cols), "{name}");
        let finite = expected.values.iter().filter(|value| value.is_finite());
        let size = finite.fold(0.0, |size: f64, value| size.max(value.abs()));
        for (index, (found, expected)) in found.values.iter().zip(&expected.values).enumerate() {
            // NumPy may scale with a fused multiplication, or round differently.
            let same = found == expected
                || found.is_nan() && expected.is_nan()
                || (found - expected).abs() <= 1e-12 * size;
            assert!(same, "{name}: {index}: {found} {expected}");
        }
        // Files are read as heights, as a mask and as a slowness, with the same values.
        let heights = SurfaceFile::read(path).unwrap().into_surface(Some(Spacing::square(1.0)));
        if let Ok(surface) = heights {
            assert_eq!(surface.present().len(), expected.values.len(), "{name}");
            let is_hole = |value: &f64| value.is_nan();
            let holes = expected.values.iter().map(is_hole);
            assert!(
                surface.present().iter().zip(holes).all(|(here, hole)| *here != hole),
                "{name}"
            );
        }
        let mask = read_mask(path).unwrap().values;
        let is_there = |value: &f64| !value.is_nan() && *value != 0.0;
        assert!(mask.iter().zip(&expected.values).all(|(a, b)| *a == is_there(b)), "{name}");
        let slowness = read_slowness(path).unwrap().values;
        let wall = |(slow, value): (&f64, &f64)| {
            (value.is_nan() || *value == f64::INFINITY) == (*slow == f64::INFINITY)
        };
        assert!(slowness.iter().zip(&expected.values).all(wall), "{name}");
    }
    paths.len()
}

#[test]
fn values_are_those_that_gdal_reads() {
    assert_eq!(check_variants(&fixtures()), 48);
}

/// Returns the command that runs `make.py`, or `None` if Python lacks rasterio. `GEOSWEEP_PYTHON` names the
/// interpreter; the default is `python3`.
fn rasterio() -> Option<Command> {
    let python = std::env::var("GEOSWEEP_PYTHON").unwrap_or("python3".into());
    let found = Command::new(&python).args(["-c", "import rasterio"]).output();
    let mut command = Command::new(python);
    command.arg(fixtures().join("make.py")).env("PYTHONDONTWRITEBYTECODE", "1");
    found.is_ok_and(|output| output.status.success()).then_some(command)
}

#[test]
fn random_files_are_read_as_gdal_reads_them() {
    let Some(mut make) = rasterio() else { return eprintln!("no rasterio, nothing is compared") };
    let folder = tempfile::tempdir().unwrap();
    let seed = std::process::id().to_string();
    let output = make.arg("random").arg(folder.path()).arg(&seed).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    println!("seed {seed}\n{}", String::from_utf8_lossy(&output.stdout));
    assert_eq!(check_variants(folder.path()), 300);
}

/// Returns the lines of `places.csv`.
fn places() -> Vec<(String, u16, [f64; 6])> {
    let table = fs::read_to_string(fixtures().join("places.csv")).unwrap();
    let line = |line: &str| {
        let fields: Vec<_> = line.split(',').collect();
        let numbers = std::array::from_fn(|k| fields[2 + k].parse().unwrap());
        (fields[0].into(), fields[1].parse().unwrap(), numbers)
    };
    table.lines().map(line).collect()
}

#[test]
fn rasters_lie_where_gdal_places_them() {
    let places = places();
    assert_eq!(places.len(), 12);
    for (name, epsg, expected) in places {
        let file = SurfaceFile::read(&fixtures().join(format!("{name}.tif"))).unwrap();
        let georeference = file.georeference().unwrap();
        let points = [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]].map(|at| georeference.coordinates(at));
        for (found, expected) in points.as_flattened().iter().zip(expected) {
            assert!((found - expected).abs() < 1e-6, "{name}: {points:?} {expected:?}");
        }
        let code = georeference.system.map_or(0, CoordinateSystem::epsg);
        assert_eq!(code, epsg, "{name}");
    }
}

#[test]
fn pixel_sizes_are_lengths_where_they_can_be() {
    let surface =
        |name: &str| SurfaceFile::read(&fixtures().join(name)).unwrap().into_surface(None);
    for name in ["north-up.tif", "south-up.tif", "turned.tif", "mirrored.tif", "albers.tif"] {
        let surface = surface(name).unwrap();
        let Geometry::Heights { heights, spacing } = surface.geometry() else { panic!("{name}") };
        assert!((spacing.dx - 30.0).abs() < 1e-9 && (spacing.dy - 20.0).abs() < 1e-9, "{name}");
        // Rows keep the file's order, whether they run southwards or northwards.
        assert!(
            heights.iter().enumerate().all(|(index, height)| index as f64 == *height),
            "{name}"
        );
    }
    let both = SurfaceFile::read(&fixtures().join("us-feet-both.tif")).unwrap();
    assert_eq!(both.unit(), Some("US ft"));
    assert!(both.into_surface(None).is_ok());
    let given = Spacing { dx: 74.0, dy: 92.0 };
    for (name, part) in [
        ("sheared.tif", "gdalwarp"),
        ("degrees.tif", "degrees"),
        ("us-feet.tif", "unit other than metres"),
        ("metres-and-feet.tif", "unit other than"),
        ("no-system.tif", "does not say in what unit"),
    ] {
        let error = surface(name).unwrap_err().to_string();
        assert!(error.contains(part) && error.contains("--spacing"), "{name}: {error}");
        assert!(error.contains("--geodetic") || part != "degrees", "{error}");
        let file = SurfaceFile::read(&fixtures().join(name)).unwrap();
        let at = file.into_surface(Some(given)).unwrap().position(1, 1).unwrap();
        assert_eq!([at.x, at.y], [74.0, 92.0], "{name}");
    }
}

#[test]
fn unsupported_files_are_refused_with_advice() {
    for (name, parts) in [
        ("zstd.tif", ["ZSTD", "gdal_translate -co COMPRESS=DEFLATE"]),
        ("lerc.tif", ["LERC", "gdal_translate -co COMPRESS=DEFLATE"]),
        ("jpeg.tif", ["JPEG", "gdal_translate -co COMPRESS=DEFLATE"]),
        ("two-bands.tif", ["2 bands", "gdal_translate -b 1"]),
        ("complex.tif", ["complex", "gdal_translate -ot Float64"]),
        ("palette.tif", ["colours", "gdal_calc.py"]),
        ("nonsense-no-data.tif", ["-a2345", "gdal_edit.py -a_nodata"]),
    ] {
        let path = fixtures().join(name);
        let error = SurfaceFile::read(&path).unwrap_err().to_string();
        assert!(parts.iter().all(|part| error.contains(part)), "{error}");
        assert!(error.starts_with(&path.display().to_string()), "{error}");
    }
    // A mask takes a pixel's index in the palette as its value, so index 0 is a hole.
    let mask = read_mask(&fixtures().join("palette.tif")).unwrap().values;
    assert_eq!(mask.iter().filter(|present| !**present).count(), 1);
}

#[test]
fn maps_lie_where_their_surface_does() {
    let folder = tempfile::tempdir().unwrap();
    let mut distances: Vec<f32> = (0..35).map(|index| index as f32).collect();
    distances[3] = f32::INFINITY;
    for (name, _, _) in places() {
        let source = fixtures().join(format!("{name}.tif"));
        let surface = SurfaceFile::read(&source).unwrap();
        let files = ["m.tif", "l.tif", "v.tif"];
        let [map, labels, vectors] = files.map(|file| folder.path().join(file));
        let mut file = fs::File::create(&map).unwrap();
        MapFormat::Tiff.write(&mut file, 5, 7, &distances, surface.geo_tags()).unwrap();
        let mut file = fs::File::create(&labels).unwrap();
        let numbers: Vec<i32> = (-1..34).collect();
        write_labels_tiff(&mut file, 5, 7, &numbers, surface.geo_tags()).unwrap();
        let mut file = fs::File::create(&vectors).unwrap();
        let way = |index| match distances[index] {
            f32::INFINITY => [f32::NAN; 2],
            distance => [distance, -2.0 * distance],
        };
        let ways: Vec<[f32; 2]> = (0..35).map(way).collect();
        write_vectors_tiff(&mut file, 5, 7, &ways, surface.geo_tags()).unwrap();

        let written = SurfaceFile::read(&map).unwrap();
        assert_eq!(written.georeference().unwrap(), surface.georeference().unwrap(), "{name}");
        assert_eq!(written.geo_tags(), surface.geo_tags(), "{name}");
        let Grid { values, .. } = read_map(&map).unwrap();
        assert!(values.iter().zip(&distances).all(|(a, b)| *a == f64::from(*b)), "{name}");
        assert!(!written.into_surface(Some(Spacing::square(1.0))).unwrap().has(0, 3), "{name}");
        let values = read_map(&labels).unwrap().values;
        assert!(values[0].is_nan() && values[1..].iter().zip(0..).all(|(a, b)| *a == f64::from(b)));
        let mut decoder = Decoder::new(fs::File::open(&vectors).unwrap()).unwrap();
        assert_eq!(decoder.dimensions().unwrap(), (7, 5));
        let DecodingResult::F32(bands) = decoder.read_image().unwrap() else {
            panic!("the bands are of single precision")
        };
        let bits = |values: &[f32]| values.iter().map(|value| value.to_bits()).collect::<Vec<_>>();
        assert_eq!(bits(&bands), bits(ways.as_flattened()));

        // GDAL finds the same georeference, and a single point without a value.
        let describe = |path: &Path| {
            let output = rasterio()?.arg("describe").arg(path).output().unwrap();
            Some(String::from_utf8(output.stdout).unwrap())
        };
        let Some(expected) = describe(&source) else { continue };
        let place = expected.lines().next().unwrap();
        assert_eq!(describe(&map).unwrap(), format!("{place}\ninf 1\n"), "{name}");
        assert_eq!(describe(&labels).unwrap(), format!("{place}\n-1.0 1\n"), "{name}");
        // The description lists the scales and the offsets of all bands.
        let place = place.replace("(1.0,) (0.0,)", "(1.0, 1.0) (0.0, 0.0)");
        assert_eq!(describe(&vectors).unwrap(), format!("{place}\nnan 1\n"), "{name}");
    }
}

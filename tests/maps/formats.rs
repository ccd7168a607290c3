//! File formats: readers read what writers write, and refuse files that are cut short. `tests/fuzz` damages
//! files.

use std::fs;
use std::io::Cursor;
use std::path::{Path, PathBuf};

use geosweep::io::{
    Grid, GridFrame, IoError, MapFormat, PlaceFile, SurfaceFile, read_map, read_mask, read_metric,
    read_slowness, write_npy,
};
use geosweep::surface::{Chart, Geometry};
use tempfile::TempDir;

const ROWS: usize = 5;
const COLS: usize = 7;

/// Returns values that reveal a swapped axis, and an infinity.
fn distances() -> Vec<f32> {
    let mut distances: Vec<f32> = (0..ROWS * COLS).map(|i| i as f32 * 0.1).collect();
    distances[11] = f32::INFINITY;
    distances
}

fn encoded(format: MapFormat) -> Vec<u8> {
    let mut file = Cursor::new(Vec::new());
    format.write(&mut file, ROWS, COLS, &distances(), None).unwrap();
    file.into_inner()
}

/// Returns the path of a file that another program has written.
fn fixture(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/maps").join(name)
}

/// Returns the path of an archive that `numpy/make.py` has written with NumPy.
fn archive(name: &str) -> PathBuf {
    fixture("numpy").join(name)
}

fn npy(shape: &[usize], values: &[f64]) -> Vec<u8> {
    let mut bytes = Vec::new();
    write_npy(&mut bytes, shape, values).unwrap();
    bytes
}

fn grey_png(depth: png::BitDepth, data: &[u8]) -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, COLS as u32, ROWS as u32);
    encoder.set_depth(depth);
    encoder.set_color(png::ColorType::Grayscale);
    encoder.write_header().unwrap().write_image_data(data).unwrap();
    bytes
}

struct Folder(TempDir);

impl Folder {
    fn new() -> Self {
        Self(tempfile::tempdir().unwrap())
    }

    fn file(&self, name: &str, bytes: &[u8]) -> PathBuf {
        let path = self.0.path().join(name);
        // Some file systems flush a file to the disk at once if it replaces another file.
        let _ = fs::remove_file(&path);
        fs::write(&path, bytes).unwrap();
        path
    }
}

fn heights(path: &Path) -> Vec<f64> {
    let surface = SurfaceFile::read(path).unwrap().into_surface(None).unwrap();
    assert_eq!((surface.rows(), surface.cols()), (ROWS, COLS));
    match surface.geometry() {
        Geometry::Heights { heights, .. } => heights.to_vec(),
        _ => panic!("{} holds heights", path.display()),
    }
}

#[test]
fn maps_survive_every_format() {
    let folder = Folder::new();
    for (format, name) in
        [(MapFormat::Npy, "m.npy"), (MapFormat::Tiff, "m.TIF"), (MapFormat::Exr, "m.exr")]
    {
        let path = folder.file(name, &encoded(format));
        let Grid { rows, cols, values, .. } = read_map(&path).unwrap();
        assert_eq!((rows, cols), (ROWS, COLS), "{name}");
        assert!(values.iter().zip(distances()).all(|(a, b)| *a == f64::from(b)), "{name}");
    }
}

#[test]
fn heights_come_from_grey_pictures_unscaled() {
    let folder = Folder::new();
    let expected: Vec<f64> = (0..ROWS * COLS).map(|i| (i * 7) as f64).collect();
    let eight: Vec<u8> = expected.iter().map(|h| *h as u8).collect();
    let sixteen: Vec<u8> = expected.iter().flat_map(|h| (*h as u16 * 256).to_be_bytes()).collect();
    let path = folder.file("8.png", &grey_png(png::BitDepth::Eight, &eight));
    assert_eq!(heights(&path), expected);
    let path = folder.file("16.png", &grey_png(png::BitDepth::Sixteen, &sixteen));
    assert_eq!(heights(&path), expected.iter().map(|h| h * 256.0).collect::<Vec<_>>());
}

#[test]
fn a_no_data_value_that_the_type_lacks_makes_no_hole() {
    use tiff::encoder::{TiffEncoder, colortype::Gray8};
    let mut file = Cursor::new(Vec::new());
    let mut encoder = TiffEncoder::new(&mut file).unwrap();
    let mut image = encoder.new_image::<Gray8>(COLS as u32, ROWS as u32).unwrap();
    image.encoder().write_tag(tiff::tags::Tag::GdalNodata, "-9999").unwrap();
    image.write_data(&[0; ROWS * COLS]).unwrap();
    let folder = Folder::new();
    let path = folder.file("flat.tif", &file.into_inner());
    assert_eq!(heights(&path), [0.0; ROWS * COLS]);
}

#[test]
fn every_array_finds_its_meaning() {
    let folder = Folder::new();
    let read = |path: &Path| SurfaceFile::read(path).unwrap().into_surface(None).unwrap();

    let positions: Vec<f64> = (0..ROWS * COLS * 3).map(|i| i as f64).collect();
    let surface = read(&folder.file("p.npy", &npy(&[ROWS, COLS, 3], &positions)));
    assert_eq!(surface.position(1, 2).unwrap().to_array(), [27.0, 28.0, 29.0]);

    let tensors = [4.0, 0.5, 0.5, 1.0].repeat(ROWS * COLS);
    let path = folder.file("g.npy", &npy(&[ROWS, COLS, 2, 2], &tensors));
    let tensor = read_metric(&path).unwrap().values[3];
    assert_eq!((tensor.rr, tensor.rc, tensor.cc), (4.0, 0.5, 1.0));
    assert!(matches!(read(&path).geometry(), Geometry::Metric(_)));

    let path = folder.file("s.npy", &npy(&[ROWS, COLS], &[2.0; ROWS * COLS]));
    assert_eq!(read_slowness(&path).unwrap().values, [2.0; ROWS * COLS]);

    let frame = GridFrame::new(Chart { rows: ROWS, cols: COLS }, Err("none".into()));
    let curves = |path: &Path| {
        let curves = PlaceFile::read(path)?.curves(&frame)?.into_iter();
        Ok::<_, IoError>(curves.map(|curve| (curve.vertices, curve.start)).collect::<Vec<_>>())
    };
    let path = folder.file("c.npy", &npy(&[2, 2], &[1.0, 2.0, 3.0, 4.5]));
    assert_eq!(curves(&path).unwrap(), [(vec![[1.0, 2.0], [3.0, 4.5]], 0.0)]);
    let path = folder.file("s.npy", &npy(&[2, 3], &[1.0, 2.0, 6.5, 3.0, 4.5, 6.5]));
    assert_eq!(curves(&path).unwrap(), [(vec![[1.0, 2.0], [3.0, 4.5]], 6.5)]);
    let mut table = [7.0; 15];
    (table[0], table[1], table[10], table[11]) = (1.0, 2.0, 3.0, 4.5);
    table[5..10].fill(f64::NAN);
    let path = folder.file("t.npy", &npy(&[3, 5], &table));
    assert_eq!(curves(&path).unwrap(), [(vec![[1.0, 2.0]], 0.0), (vec![[3.0, 4.5]], 0.0)]);
    let path = folder.file("w.npy", &npy(&[5, 3, 1], &table));
    assert!(curves(&path).unwrap_err().to_string().contains("(K, 2)"));
    let path = folder.file("n.npy", &npy(&[1, 3], &[1.0, 2.0, f64::NAN]));
    assert!(curves(&path).unwrap_err().to_string().contains("NaN"));
    let path = folder.file("i.npy", &npy(&[2], &[3.0, 34.0]));
    assert!(curves(&path).unwrap_err().to_string().contains("(K, 2)"));
    let points = PlaceFile::read(&path).unwrap().grid_points(&frame).unwrap();
    let points: Vec<_> = points.iter().map(|point| (point.at, point.start)).collect();
    let last = [34 / COLS, 34 % COLS].map(|at| at as f64);
    assert_eq!(points, [([0.0, 3.0], 0.0), (last, 0.0)]);

    let mut pixels = [255; ROWS * COLS];
    pixels[4] = 0;
    let path = folder.file("m.png", &grey_png(png::BitDepth::Eight, &pixels));
    let mask = read_mask(&path).unwrap().values;
    assert_eq!(mask.iter().position(|present| !present), Some(4));
}

#[test]
fn geometry_images_give_positions() {
    use exr::prelude::*;
    let folder = Folder::new();
    for (name, channels) in [("xyz.exr", ["X", "Y", "Z"]), ("rgb.exr", ["R", "G", "B"])] {
        let channel = |axis: usize| {
            let values = (0..ROWS * COLS).map(|i| (10 * i + axis) as f32).collect();
            AnyChannel::new(channels[axis], FlatSamples::F32(values))
        };
        let list = AnyChannels::sort((0..3).map(channel).collect());
        let layer = Layer::new((COLS, ROWS), LayerAttributes::default(), Encoding::default(), list);
        let mut file = Cursor::new(Vec::new());
        Image::from_layer(layer).write().to_buffered(&mut file).unwrap();
        let path = folder.file(name, &file.into_inner());
        let surface = SurfaceFile::read(&path).unwrap().into_surface(None).unwrap();
        assert_eq!(surface.position(1, 2).unwrap().to_array(), [90.0, 91.0, 92.0], "{name}");
    }
}

/// Returns a valid file of each format of surfaces.
fn samples() -> Vec<(&'static str, Vec<u8>)> {
    let pixels: Vec<u8> = (0..2 * ROWS * COLS).map(|i| i as u8).collect();
    vec![
        ("sample.npy", npy(&[ROWS, COLS], &[1.5; ROWS * COLS])),
        ("sample.png", grey_png(png::BitDepth::Sixteen, &pixels)),
        ("sample.tif", fs::read(fixture("gdal/north-up.tif")).unwrap()),
        ("sample.exr", encoded(MapFormat::Exr)),
    ]
}

#[test]
fn a_file_cut_anywhere_is_an_error() {
    let folder = Folder::new();
    for (name, bytes) in samples() {
        assert!(SurfaceFile::read(&folder.file(name, &bytes)).is_ok(), "{name}");
        // PNG's last 12 bytes are an end mark without content, so that a reader may do without them.
        let needed = if name.ends_with("png") { bytes.len() - 12 } else { bytes.len() };
        for length in 0..needed {
            let path = folder.file(name, &bytes[..length]);
            let error = SurfaceFile::read(&path).map(drop).unwrap_err();
            assert!(matches!(error, IoError::Content { .. }), "{name} cut to {length}: {error}");
            assert!(error.to_string().starts_with(&path.display().to_string()), "{error}");
        }
    }
}

#[test]
fn meaningless_shapes_are_refused_with_the_valid_ones() {
    let folder = Folder::new();
    for shape in [&[35][..], &[5, 7, 1], &[7, 5, 1, 1], &[]] {
        let values = vec![0.0; shape.iter().product()];
        let path = folder.file("odd.npy", &npy(shape, &values));
        let error = SurfaceFile::read(&path).map(drop).unwrap_err().to_string();
        assert!(error.contains("(M, N, 3)"), "{shape:?}: {error}");
    }
    let path = folder.file("empty.npy", &npy(&[0, 7], &[]));
    assert!(SurfaceFile::read(&path).unwrap_err().to_string().contains("empty"));
}

#[test]
fn asymmetric_metrics_are_refused_where_they_are() {
    let folder = Folder::new();
    let mut tensors = [1.0, 0.0, 0.0, 1.0].repeat(ROWS * COLS);
    tensors[4 * (2 * COLS + 3) + 1] = 0.5;
    let path = folder.file("g.npy", &npy(&[ROWS, COLS, 2, 2], &tensors));
    let error = read_metric(&path).unwrap_err().to_string();
    assert!(error.contains("row 2, column 3"), "{error}");
}

#[test]
fn archives_hold_one_array_or_one_of_the_right_name() {
    let expected: Vec<f64> = (0..ROWS * COLS).map(|index| index as f64).collect();
    for name in ["one.npz", "one-compressed.npz", "several.npz"] {
        assert_eq!(heights(&archive(name)), expected, "{name}");
        assert_eq!(read_map(&archive(name)).unwrap().values, expected, "{name}");
    }
    let several = archive("several.npz");
    let mask = read_mask(&several).unwrap().values;
    assert!(mask.iter().enumerate().all(|(index, there)| *there == (index % 3 > 0)));
    let slowness = read_slowness(&several).unwrap().values;
    assert!(slowness.iter().zip(&expected).all(|(slow, index)| *slow == 1.0 + index));
    assert_eq!(read_metric(&several).unwrap().values[3].rr, 4.0);
    let unnamed = archive("unnamed.npz");
    for error in [
        SurfaceFile::read(&unnamed).map(drop).unwrap_err(),
        read_mask(&unnamed).map(drop).unwrap_err(),
        read_map(&unnamed).map(drop).unwrap_err(),
    ] {
        let error = error.to_string();
        assert!(error.contains("arr_0, arr_1") && error.contains("2 arrays"), "{error}");
    }
}

#[test]
fn archives_that_are_damaged_are_refused() {
    let folder = Folder::new();
    for name in ["one.npz", "one-compressed.npz"] {
        let bytes = fs::read(archive(name)).unwrap();
        for length in 0..bytes.len() {
            let path = folder.file(name, &bytes[..length]);
            let error = SurfaceFile::read(&path).map(drop).unwrap_err();
            assert!(matches!(error, IoError::Content { .. }), "{name} cut to {length}: {error}");
        }
        // A checksum protects the values. The header's name and times may be anything.
        let whole = heights(&archive(name));
        for at in 0..bytes.len() {
            let mut bytes = bytes.clone();
            bytes[at] ^= 4;
            let path = folder.file(name, &bytes);
            if let Ok(surface) = SurfaceFile::read(&path).and_then(|file| file.into_surface(None)) {
                let Geometry::Heights { heights, .. } = surface.geometry() else { panic!("{at}") };
                assert_eq!(heights[..], whole[..], "{name}: byte {at}");
            }
        }
    }
}

#[test]
fn ascii_grids_are_surfaces_masks_and_slowness() {
    let folder = Folder::new();
    let values: Vec<String> = (0..ROWS * COLS).map(|index| index.to_string()).collect();
    let lines: Vec<String> = values.chunks(COLS).map(|row| row.join(" ")).collect();
    let header = format!(
        "ncols {COLS}\nnrows {ROWS}\nxllcorner 1000\nyllcorner 2000\ncellsize 25\nNODATA_value 3\n"
    );
    let path = folder.file("g.asc", format!("{header}{}\n", lines.join("\n")).as_bytes());
    let file = SurfaceFile::read(&path).unwrap();
    let georeference = file.georeference().unwrap();
    assert_eq!(georeference.coordinates([4.0, 0.0]), [1012.5, 2012.5]);
    assert_eq!(georeference.place([1012.5, 2012.5]), Some([4.0, 0.0]));
    assert!(file.assumes_metres() && !file.lacks_spacing());
    let surface = file.into_surface(None).unwrap();
    assert_eq!(surface.position(1, 2).unwrap().to_array(), [50.0, 25.0, 9.0]);
    assert!(!surface.has(0, 3) && surface.points() == ROWS * COLS - 1);
    let mask = read_mask(&path).unwrap();
    let holes: Vec<_> = (0..ROWS * COLS).filter(|index| !mask.values[*index]).collect();
    assert_eq!(holes, [0, 3]);
    assert_eq!(read_slowness(&path).unwrap().values[3], f64::INFINITY);

    // A mask is refused if its size or its georeference differs from the surface's.
    let place = georeference;
    assert!(mask.clone().fit_surface(&path, ROWS, COLS, Some(&place)).is_ok());
    assert!(mask.clone().fit_surface(&path, COLS, ROWS, Some(&place)).is_err());
    for shift in [[25.0, 0.0], [0.0, -25.0], [5.0, 5.0]] {
        let mut place = place;
        place.origin = [place.origin[0] + shift[0], place.origin[1] + shift[1]];
        let error = mask.clone().fit_surface(&path, ROWS, COLS, Some(&place)).unwrap_err();
        assert!(error.to_string().contains("gdalwarp"), "{error}");
    }
}

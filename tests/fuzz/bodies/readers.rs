//! Files of any content: each reader returns what it reads, or an error that names the file.

use std::fs;
use std::io::Cursor;
use std::path::Path;

use geosweep::io::{
    CoordinateSystem, Element, GeoTags, Georeference, Grid, GridFrame, IoError, MapFormat,
    MatrixFile, MatrixLayout, OutputFile, PlaceFile, Provenance, SurfaceFile, is_distance_matrix,
    read_map, read_mask, read_matrix, read_metric, read_slowness,
};
use geosweep::surface::Chart;
use geosweep::{Engine, Options, Sources, Surface, distance_map};
use tempfile::TempDir;

/// Surfaces of up to this many points are also solved.
const SOLVED: usize = 1 << 10;

pub fn npy(data: &[u8]) {
    with_file("file.npy", data, arrays);
}

pub fn npz(data: &[u8]) {
    with_file("file.npz", data, arrays);
}

fn arrays(path: &Path) {
    rasters(path);
    grid(path, read_metric(path));
}

pub fn png(data: &[u8]) {
    with_file("file.png", data, |path| {
        surface(path);
        grid(path, read_mask(path));
    });
}

pub fn tiff(data: &[u8]) {
    with_file("file.tif", data, rasters);
}

pub fn asc(data: &[u8]) {
    with_file("file.asc", data, rasters);
}

fn rasters(path: &Path) {
    surface(path);
    places(path);
    grid(path, read_map(path));
    grid(path, read_mask(path));
    grid(path, read_slowness(path));
}

pub fn exr(data: &[u8]) {
    with_file("file.exr", data, |path| {
        surface(path);
        grid(path, read_map(path));
    });
}

pub fn table(data: &[u8]) {
    with_file("file.csv", data, places);
    with_file("file.geojson", data, places);
}

pub fn matrix(data: &[u8]) {
    with_file("file.npy", data, |path| {
        is_distance_matrix(path);
        if let Some(matrix) = checked(path, read_matrix(path)) {
            assert_eq!(matrix.distances.len(), matrix.points * matrix.points);
        }
    });
}

/// Takes `data` as a checkpoint, a zero byte and an unfinished matrix, and resumes the matrix unless this is refused.
pub fn checkpoint(data: &[u8]) {
    let Some(end) = data.iter().position(|&byte| byte == 0) else { return };
    let (checkpoint, part) = (&data[..end], &data[end + 1..]);
    let path = FOLDER.with(|folder| folder.path().join("d.npy"));
    let beside = |suffix: &str| path.with_file_name(format!("d.npy{suffix}"));
    write(&beside(".part"), part);
    write(&beside(".part.json"), checkpoint);
    let output = OutputFile::new(&path).unwrap();
    match MatrixFile::resume(output, UNFINISHED, Provenance::new()) {
        Ok(mut matrix) => {
            let missing = UNFINISHED.rows - matrix.rows();
            matrix.append(&vec![1.0; missing * UNFINISHED.cols]).unwrap();
            matrix.finish().unwrap();
            assert_eq!(read_matrix(&path).unwrap().points, UNFINISHED.rows);
            fs::remove_file(&path).unwrap();
        }
        Err(error) => assert!(error.to_string().contains("d.npy.part"), "{error}"),
    }
}

/// Layout of the matrix that checkpoints resume.
pub const UNFINISHED: MatrixLayout =
    MatrixLayout { rows: 4, cols: 4, element: Element::Float32, upper: false, symmetric: false };

fn surface(path: &Path) {
    let surface = SurfaceFile::read(path).and_then(|file| {
        file.georeference().map_or_else(|error| named(path, &error), |_| ());
        assert!(file.geo_tags().is_none_or(|tags| written_again(path, tags)));
        file.into_surface(None)
    });
    let Some(surface) = checked(path, surface) else { return };
    assert!(surface.points() <= surface.chart().points());
    if surface.chart().points() <= SOLVED {
        solved(&surface);
    }
}

/// Checks that a map with the georeference of a file can be written and read again.
fn written_again(path: &Path, tags: &GeoTags) -> bool {
    let map = path.with_file_name("written.tif");
    let mut file = Cursor::new(Vec::new());
    MapFormat::Tiff.write(&mut file, 1, 2, &[1.0f32, f32::INFINITY], Some(tags)).unwrap();
    write(&map, &file.into_inner());
    read_map(&map).is_ok_and(|map| map.values == [1.0, f64::INFINITY])
}

/// Asserts that distances are numbers, unless the lengths are refused.
fn solved(surface: &Surface) {
    let first =
        surface.present().iter().position(|present| *present).expect("a surface has a point");
    let (row, col) = surface.chart().position(first);
    let sources = Sources::point(row as f64, col as f64);
    let options = Options::default().with_engine(Engine::Cpu);
    if let Ok(map) = distance_map(surface, &sources, &options) {
        assert!(map.distances.iter().all(|distance| !distance.is_nan()));
    }
}

fn grid<T>(path: &Path, grid: Result<Grid<T>, IoError>) {
    if let Some(grid) = checked(path, grid) {
        assert_eq!(grid.values.len(), grid.rows * grid.cols);
        assert!(!grid.values.is_empty());
    }
}

/// Asserts that places are on the grid, unless they are refused.
fn places(path: &Path) {
    let Some(file) = checked(path, PlaceFile::read(path)) else { return };
    let chart = Chart { rows: 7, cols: 9 };
    let georeference = Georeference {
        origin: [100.0, 50.0],
        down: [0.0, -1.0],
        right: [1.0, 0.0],
        system: Some(CoordinateSystem::Projected(32616)),
    };
    let frame = GridFrame::new(chart, Ok(georeference));
    let is_on = |&[row, col]: &[f64; 2]| (0.0..=6.0).contains(&row) && (0.0..=8.0).contains(&col);
    if let Some(curves) = checked(path, file.curves(&frame)) {
        assert!(!curves.is_empty() && curves.iter().all(|curve| !curve.vertices.is_empty()));
        assert!(curves.iter().all(|curve| curve.vertices.iter().all(is_on)));
        assert!(curves.iter().all(|curve| curve.start.is_finite()));
    }
    if let Some(points) = checked(path, file.points(&frame)) {
        assert!(points.iter().all(|point| is_on(&point.at) && point.start.is_finite()));
    }
    if let Some(points) = checked(path, file.grid_points(&frame)) {
        let is_point = |&[row, col]: &[f64; 2]| row.fract() == 0.0 && col.fract() == 0.0;
        assert!(points.iter().all(|point| is_on(&point.at) && is_point(&point.at)));
    }
    for remark in file.remarks(&frame) {
        assert!(remark.len() < 1000, "{remark}");
    }
}

fn checked<T>(path: &Path, result: Result<T, IoError>) -> Option<T> {
    result.inspect_err(|error| named(path, error)).ok()
}

fn named(path: &Path, error: &IoError) {
    assert!(error.to_string().len() < 3000, "{error}");
    assert!(error.to_string().starts_with(&path.display().to_string()), "{error}");
}

/// Writes a new file. If a file replaces an old one, some file systems flush it to the disk at once, which takes
/// longer than everything else.
fn write(path: &Path, data: &[u8]) {
    let _ = fs::remove_file(path);
    fs::write(path, data).unwrap();
}

thread_local! {
    static FOLDER: TempDir = tempfile::tempdir().unwrap();
}

fn with_file(name: &str, data: &[u8], read: impl FnOnce(&Path)) {
    let path = FOLDER.with(|folder| folder.path().join(name));
    write(&path, data);
    read(&path);
}

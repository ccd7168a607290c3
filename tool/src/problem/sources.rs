//! Reads the sources of distances.

use std::error::Error;
use std::path::PathBuf;

use geosweep::Sources;
use geosweep::geometry::Curve;
use geosweep::io::{GridFrame, PlaceFile};
use geosweep::shown::exact;

use super::Scene;
use super::geodetic::{check_latitude, check_longitude};
use crate::numbers::{numbers, place_xy};

#[derive(clap::Args)]
#[command(group = clap::ArgGroup::new("sources").required(true).multiple(true))]
pub struct SourceArgs {
    /// Point source: row and column, which may be fractional, and its start value (default 0); repeatable
    #[arg(short, long, value_name = "R,C[,T0]", group = "sources", help_heading = "Sources")]
    #[arg(value_parser = point, allow_hyphen_values = true)]
    source: Vec<[f64; 3]>,
    /// Point source in map coordinates, if SURFACE is georeferenced: easting and northing, or longitude and
    /// latitude, in its coordinate reference system; repeatable
    #[arg(long, value_name = "X,Y[,T0]", group = "sources", help_heading = "Sources")]
    #[arg(value_parser = point_xy, allow_hyphen_values = true)]
    source_xy: Vec<[f64; 3]>,
    /// Point source on the Earth, with --geodetic: longitude and latitude in degrees, and its start value (default
    /// 0); repeatable. Longitudes may differ from the grid's by full turns
    #[arg(long, value_name = "LON,LAT[,T0]", group = "sources", help_heading = "Sources")]
    #[arg(value_parser = point_lonlat, allow_hyphen_values = true, requires = "geodetic")]
    source_lonlat: Vec<[f64; 3]>,
    /// File of curves, every point of which is a source; repeatable. An .npy array is (K, 2) with rows and
    /// columns, (K, 3) with start values too, or (K, 5) as this tool writes curves; rows of NaN separate
    /// curves. A text file has a line `row,col` per vertex (any separator, and decimal commas), or columns
    /// that its first line names: row and col, or map coordinates x and y or lon and lat; start values t0 (or
    /// start, initial, time), equal along a curve; `curve`, whose values separate curves; and `closed`, where
    /// 1 closes them. Other columns are not used, and a note lists them. GeoJSON (.geojson, .json) has
    /// points, lines and polygons, whose rings are sources, in the coordinates of SURFACE, with a property
    /// t0. In a raster of SURFACE's size (.tif, .asc, .png), each cell that is neither 0 nor no-data is a
    /// source
    #[arg(long, value_name = "FILE", group = "sources", help_heading = "Sources")]
    source_curve: Vec<PathBuf>,
    /// File of point sources, as for --source-curve. Every vertex is a source with its own start value;
    /// repeatable
    #[arg(long, value_name = "FILE", group = "sources", help_heading = "Sources")]
    source_points: Vec<PathBuf>,
}

fn point(text: &str) -> Result<[f64; 3], String> {
    let form = "a source is a row and a column, and perhaps a start value: R,C[,T0]";
    with_start(numbers(text)?).ok_or_else(|| form.into())
}

fn point_xy(text: &str) -> Result<[f64; 3], String> {
    let form = "a source is x (easting, longitude) and y (northing, latitude), and perhaps a start \
                value: X,Y[,T0]";
    with_start(numbers(text)?).ok_or_else(|| form.into())
}

fn point_lonlat(text: &str) -> Result<[f64; 3], String> {
    let form = "a source is a longitude and a latitude, and perhaps a start value: LON,LAT[,T0]";
    let [longitude, latitude, start] = with_start(numbers(text)?).ok_or(form)?;
    check_longitude(longitude)?;
    check_latitude(latitude)?;
    Ok([longitude, latitude, start])
}

fn with_start(numbers: Vec<f64>) -> Option<[f64; 3]> {
    match numbers[..] {
        [first, second] => Some([first, second, 0.0]),
        [first, second, start] => Some([first, second, start]),
        _ => None,
    }
}

impl SourceArgs {
    /// Returns the sources on the surface's grid: points as rows and columns, points in map coordinates, points by
    /// longitude and latitude, points of files, then curves.
    pub fn sources(&self, scene: &Scene) -> Result<Sources, Box<dyn Error>> {
        let frame = &scene.frame();
        let mut sources = Sources::default();
        for &[row, col, start] in &self.source {
            let [row, col] = scene.place([row, col]).map_err(|why| format!("source {why}"))?;
            sources = sources.and_point(row, col, start);
        }
        for &[x, y, start] in &self.source_xy {
            let [row, col] = scene.place(place_xy("--source-xy", frame, [x, y])?)?;
            sources = sources.and_point(row, col, start);
        }
        for &[longitude, latitude, start] in &self.source_lonlat {
            let [row, col] = lonlat(scene, [longitude, latitude])?;
            sources = sources.and_point(row, col, start);
        }
        for path in &self.source_points {
            let file = PlaceFile::read(path)?;
            for point in file.points(frame)? {
                let [row, col] = scene.place(point.at)?;
                sources = sources.and_point(row, col, point.start);
            }
            remark(path, &file, frame);
            if file.holds_lines() {
                let name = path.display();
                note!(
                    "{name}: holds lines, of which only the vertices are sources here; with \
                         --source-curve all their points are"
                );
            }
        }
        for path in &self.source_curve {
            let file = PlaceFile::read(path)?;
            for curve in file.curves(frame)? {
                let named = |why| format!("{}: {why}", path.display());
                let vertices = scene.curve(curve.vertices).map_err(named)?;
                sources = match vertices[..] {
                    [[row, col]] => sources.and_point(row, col, curve.start),
                    _ => sources.and_curve(vertices, curve.start),
                };
            }
            remark(path, &file, frame);
        }
        Ok(sources)
    }

    /// Returns the files that sources are read from.
    pub fn files(&self) -> impl Iterator<Item = &PathBuf> {
        self.source_curve.iter().chain(&self.source_points)
    }
}

/// Returns the place on the surface's grid of a longitude and a latitude in degrees.
fn lonlat(scene: &Scene, [longitude, latitude]: [f64; 2]) -> Result<[f64; 2], String> {
    let option = "--source-lonlat";
    let place = scene.place(place_xy(option, &scene.frame(), [longitude, latitude])?)?;
    let point = Curve { vertices: vec![place], closed: false };
    if point.lift(&scene.surface).is_err() {
        return Err(format!(
            "{option} {},{}: lies in a hole of the surface (NaN, no-data or masked out); move it to a point of \
             the surface",
            exact(longitude),
            exact(latitude)
        ));
    }
    Ok(place)
}

/// Prints which parts of a file are not used, and what is assumed about it.
pub fn remark(path: &std::path::Path, file: &PlaceFile, frame: &GridFrame) {
    for remark in file.remarks(frame) {
        note!("{}: {remark}", path.display());
    }
}

//! Reads the sources of distances.

use std::error::Error;
use std::path::PathBuf;

use geosweep::Sources;
use geosweep::io::{GridFrame, PlaceFile};

use crate::numbers::{numbers, place_xy};
use crate::terminal::say;

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

fn with_start(numbers: Vec<f64>) -> Option<[f64; 3]> {
    match numbers[..] {
        [first, second] => Some([first, second, 0.0]),
        [first, second, start] => Some([first, second, start]),
        _ => None,
    }
}

impl SourceArgs {
    /// Returns the sources: points as rows and columns, points in map coordinates, points of files, then
    /// curves.
    pub fn sources(&self, frame: &GridFrame) -> Result<Sources, Box<dyn Error>> {
        let mut sources = Sources::default();
        for &[row, col, start] in &self.source {
            sources = sources.and_point(row, col, start);
        }
        for &[x, y, start] in &self.source_xy {
            let [row, col] = place_xy("--source-xy", frame, [x, y])?;
            sources = sources.and_point(row, col, start);
        }
        for path in &self.source_points {
            let file = PlaceFile::read(path)?;
            for point in file.points(frame)? {
                let [row, col] = point.at;
                sources = sources.and_point(row, col, point.start);
            }
            remark(path, &file, frame);
            if file.holds_lines() {
                let name = path.display();
                say(
                    "note",
                    format_args!(
                        "{name}: holds lines, of which only the vertices are sources here; with \
                         --source-curve all their points are"
                    ),
                );
            }
        }
        for path in &self.source_curve {
            let file = PlaceFile::read(path)?;
            for curve in file.curves(frame)? {
                sources = match curve.vertices[..] {
                    [[row, col]] => sources.and_point(row, col, curve.start),
                    _ => sources.and_curve(curve.vertices, curve.start),
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

/// Prints which parts of a file are not used, and what is assumed about it.
pub fn remark(path: &std::path::Path, file: &PlaceFile, frame: &GridFrame) {
    for remark in file.remarks(frame) {
        say("note", format_args!("{}: {remark}", path.display()));
    }
}

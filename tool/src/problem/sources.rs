//! Reads the sources of distances.

use std::error::Error;
use std::ops::Deref;
use std::path::PathBuf;

use geosweep::Sources;
use geosweep::io::{GridFrame, Misplaced, PlaceFile};
use geosweep::shown::exact;

use super::Scene;
use super::geodetic::check_latitude;
use super::placing::{Outside, Placing};
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
    /// source, and its value is the label of its region
    #[arg(long, value_name = "FILE", group = "sources", help_heading = "Sources")]
    source_curve: Vec<PathBuf>,
    /// File of point sources, as for --source-curve. Every vertex is a source with its own start value;
    /// repeatable
    #[arg(long, value_name = "FILE", group = "sources", help_heading = "Sources")]
    source_points: Vec<PathBuf>,
    /// Sources outside the surface or in its holes
    #[arg(long, value_enum, default_value_t, help_heading = "Sources")]
    sources_outside: Outside,
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

/// The sources of a command, on the surface's grid.
pub struct GivenSources {
    pub sources: Sources,
    /// Whether all sources are rings of polygons.
    pub are_polygons: bool,
    /// The values of the cells that are sources, if all sources are cells of rasters of whole numbers.
    pub labels: Option<Vec<i32>>,
}

impl Deref for GivenSources {
    type Target = Sources;

    fn deref(&self) -> &Sources {
        &self.sources
    }
}

impl GivenSources {
    /// Returns the label of a source in outputs: the value of its cell in a raster, otherwise its index.
    pub fn label(&self, index: usize) -> i32 {
        self.labels.as_ref().map_or(index as i32, |labels| labels[index])
    }

    /// Returns the label of each region, in ascending order. Sources with one label have one region.
    pub fn region_labels(&self) -> Vec<i32> {
        let mut labels: Vec<_> = (0..self.sources.iter().count()).map(|k| self.label(k)).collect();
        labels.sort_unstable();
        labels.dedup();
        labels
    }

    /// Returns the region of each source and the number of regions, if sources have labels.
    pub fn regions(&self) -> Option<(Vec<u32>, usize)> {
        let labels = self.labels.as_ref()?;
        let of_region = self.region_labels();
        let region = |label| of_region.partition_point(|other| other < label) as u32;
        Some((labels.iter().map(region).collect(), of_region.len()))
    }
}

impl SourceArgs {
    /// Returns the sources on the surface's grid: points as rows and columns, points in map coordinates, points by
    /// longitude and latitude, points of files, then curves.
    pub fn sources(&self, scene: &Scene) -> Result<GivenSources, Box<dyn Error>> {
        let frame = &scene.frame();
        let mut placing = Placing::new(scene, self.sources_outside);
        for &[row, col, start] in &self.source {
            placing
                .point(Ok([row, col]), start, || format!("source {},{}", exact(row), exact(col)));
        }
        let on_map = [("--source-xy", &self.source_xy), ("--source-lonlat", &self.source_lonlat)];
        for (option, places) in on_map {
            for &[x, y, start] in places {
                let near = frame.unbounded_place([x, y]);
                let at = place_xy(option, frame, [x, y]);
                let at = at.map_err(|reason| Misplaced { reason, near });
                placing.point(at, start, || format!("{option} {},{}", exact(x), exact(y)));
            }
        }
        for path in &self.source_points {
            let file = PlaceFile::read(path)?;
            for point in file.try_points(frame)? {
                placing.file_point(path, point);
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
            for curve in file.try_curves(frame)? {
                placing.curve(path, curve)?;
            }
            remark(path, &file, frame);
        }
        placing.sources()
    }

    /// Returns the files that sources are read from.
    pub fn files(&self) -> impl Iterator<Item = &PathBuf> {
        self.source_curve.iter().chain(&self.source_points)
    }
}

/// Prints which parts of a file are not used, and what is assumed about it.
pub fn remark(path: &std::path::Path, file: &PlaceFile, frame: &GridFrame) {
    for remark in file.remarks(frame) {
        note!("{}: {remark}", path.display());
    }
}

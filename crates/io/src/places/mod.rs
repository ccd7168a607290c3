//! Reads files of places: points and curves on a grid, from tables, arrays, GeoJSON and rasters.

mod array;
mod columns;
mod content;
mod frame;
mod geojson;
mod records;
mod table;
mod text;

use std::borrow::Cow;
use std::path::{Path, PathBuf};

use super::arrays::read_mask_values;
use super::{IoError, extension, read_bytes};
use content::{Content, Coordinates, CurveKind, FileCurve, FileCurves, Vertex};
pub use frame::GridFrame;
use geosweep_surface::Chart;
use geosweep_surface::shown::{exact, excerpt};

/// A file of points or curves on a surface, with or without start values.
///
/// | file | content |
/// |---|---|
/// | `.npy`, (K, 2) | row, column |
/// | `.npy`, (K, 3) | row, column, start value |
/// | `.npy`, (K, 5) | row, column, x, y, z, as the tool writes curves |
/// | `.npy`, (K,) | row-major indices, for [`PlaceFile::grid_points`] only |
/// | `.npz` | one such array, or among several the first named `sources`, `points` or `curves` |
/// | `.tif`, `.asc`, `.png` | a raster of the surface's size; cells other than 0 and no-data are points |
/// | `.geojson`, `.json`, any text that begins with `{` | GeoJSON in the surface's map coordinates |
/// | any other text | a place on each line; the first line may name the columns |
///
/// In a `.npy`, rows of NaN separate curves. In GeoJSON, Points and MultiPoints are points, LineStrings and
/// MultiLineStrings are curves, and the rings of Polygons and MultiPolygons are closed curves.
///
/// Tables have commas, semicolons, tabs or blanks between their columns. Names and values may be quoted.
/// Numbers may have a decimal comma if commas do not divide the columns. `#` begins a comment. Lines of two
/// numbers without a header are rows and columns. Lines of three numbers are row, column and start value,
/// unless the first is a running number. A header may name the following columns, in any order and in any
/// case:
///
/// | column | content |
/// |---|---|
/// | `row` and `col` or `column` | the place on the grid, from 0 |
/// | otherwise `x` and `y` | the place in the surface's map coordinates |
/// | otherwise `easting` and `northing` (`east`, `north`) | map coordinates on a projected surface |
/// | otherwise `lon` and `lat` (`lng`, `long`, `longitude`, `latitude`) | map coordinates on a geographic surface |
/// | `t0`, `time`, `start`, `start_value` or `start_time` | start value (default 0) |
/// | `initial`, `initial_value` or `initial_time` | start value, under another name |
/// | `curve` | a new value begins another curve |
/// | `closed` | 1 where the curve returns to its first vertex |
///
/// Other columns are not used, and [`PlaceFile::remarks`] names them. A column whose name suggests that it
/// changes distances (`delay`, `weight`, `start_date`) is an error. Properties of GeoJSON features are
/// treated like columns.
#[derive(Clone, Debug)]
pub struct PlaceFile {
    path: PathBuf,
    content: Content,
}

/// A point on a grid.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlacedPoint {
    /// Row and column. They may be fractional.
    pub at: [f64; 2],
    /// Start value.
    pub start: f64,
    /// The value of the cell, if the point comes from a raster.
    pub value: Option<f64>,
}

/// A place of a file that is not on the grid.
#[derive(Clone, Debug, PartialEq)]
pub struct Misplaced {
    /// Description of the place, and why it is not on the grid.
    pub reason: String,
    /// Row and column of a point. A curve, and a point that has no row and column, has `None`.
    pub near: Option<[f64; 2]>,
}

/// A curve on a grid.
#[derive(Clone, Debug, PartialEq)]
pub struct PlacedCurve {
    /// Rows and columns of the vertices. The last one equals the first if the curve is closed.
    pub vertices: Vec<[f64; 2]>,
    /// Start value.
    pub start: f64,
    /// The value of the cell, if the curve is a point that comes from a raster.
    pub value: Option<f64>,
    /// Whether the curve is a ring of a polygon, whose inside lies to the left.
    pub is_ring: bool,
}

impl PlaceFile {
    /// Reads a file.
    ///
    /// # Errors
    /// If the file cannot be read, is not of one of the formats above, or holds no place.
    pub fn read(path: &Path) -> Result<Self, IoError> {
        let content = |reason| IoError::content(path, reason);
        let read = match extension(path).as_str() {
            "npy" | "npz" => array::read(path)?,
            "tif" | "tiff" | "asc" | "png" => Content::Raster(read_mask_values(path)?),
            extension => {
                let text = text::decode(read_bytes(path)?).map_err(content)?;
                let is_json = matches!(extension, "geojson" | "json");
                let curves = match text.trim_start().chars().next() {
                    Some('{' | '[') => geojson::read(&text),
                    _ if is_json => Err(geojson::not_json(&text)),
                    Some('<') => Err("looks like XML or HTML; give a table of row,col or \
                                      GeoJSON (ogr2ogr converts GPX and KML)"
                        .into()),
                    _ => table::read(&text),
                };
                Content::Curves(curves.map_err(content)?)
            }
        };
        let is_empty = match &read {
            Content::Curves(curves) => curves.curves.iter().all(|curve| curve.vertices.is_empty()),
            Content::Indices(indices) => indices.is_empty(),
            Content::Raster(raster) => {
                if !raster.values.iter().any(is_source) {
                    return Err(content("holds no source: all its cells are 0 or no-data".into()));
                }
                false
            }
        };
        if is_empty {
            return Err(content("holds no place; give at least one row,col".into()));
        }
        Ok(Self { path: path.to_owned(), content: read })
    }

    /// Returns remarks for the user: columns that are not used, and the coordinate system that is assumed for
    /// the places.
    pub fn remarks(&self, frame: &GridFrame) -> Vec<String> {
        let Content::Curves(curves) = &self.content else { return Vec::new() };
        let mut remarks = Vec::new();
        let what = if curves.numbered == geojson::FEATURE { "property" } else { "column" };
        remarks.extend(named(what, &curves.unused));
        if curves.empty > 0 {
            remarks.push(format!("{} features have no geometry", curves.empty));
        }
        if let Coordinates::Map(map) = &curves.coordinates {
            remarks.extend(map.assumption(frame));
        }
        remarks
    }

    /// Returns whether the file gives start values.
    pub fn has_starts(&self) -> bool {
        matches!(&self.content, Content::Curves(FileCurves { has_starts: true, .. }))
    }

    /// Returns whether the file states that it holds lines or polygons.
    pub fn holds_lines(&self) -> bool {
        let is_line = |curve: &FileCurve| curve.kind == CurveKind::Line || curve.kind.is_ring();
        matches!(&self.content, Content::Curves(curves) if curves.curves.iter().any(is_line))
    }

    /// Returns the places as points: every vertex once, in the order of the file.
    ///
    /// # Errors
    /// If places lie outside the grid; if places are in map coordinates and the surface has none, or is in another
    /// coordinate system; if the file holds indices.
    pub fn points(&self, frame: &GridFrame) -> Result<Vec<PlacedPoint>, IoError> {
        self.all_placed(self.try_points(frame)?)
    }

    /// Returns the places as points: every vertex once, in the order of the file, or the reason why it is not on the
    /// grid.
    ///
    /// # Errors
    /// If no place can be found: the other errors of [`PlaceFile::points`].
    pub fn try_points(
        &self,
        frame: &GridFrame,
    ) -> Result<Vec<Result<PlacedPoint, Misplaced>>, IoError> {
        Ok(self.placed(&*self.file_curves(frame)?, frame))
    }

    fn placed(
        &self,
        curves: &FileCurves,
        frame: &GridFrame,
    ) -> Vec<Result<PlacedPoint, Misplaced>> {
        let point = |vertex: &Vertex| {
            let at = self.place(curves, vertex, frame)?;
            Ok(PlacedPoint { at, start: vertex.start, value: vertex.value })
        };
        curves.curves.iter().flat_map(FileCurve::once).map(point).collect()
    }

    /// Returns the places as curves. A point of GeoJSON or a cell of a raster is a curve of one vertex.
    ///
    /// The left side of a curve is that in a picture of the grid with rows downwards, if the file gives rows and columns,
    /// and that on the map, if it gives map coordinates: curves on a grid that mirrors the map are reversed. The
    /// inside of a polygon lies to the left of its rings, whichever way the file runs around them.
    ///
    /// # Errors
    /// The errors of [`PlaceFile::points`]. It is also an error if start values differ along a curve.
    pub fn curves(&self, frame: &GridFrame) -> Result<Vec<PlacedCurve>, IoError> {
        self.all_placed(self.try_curves(frame)?)
    }

    /// Returns the places as curves, or the reason why the first misplaced vertex of a curve is not on the grid.
    ///
    /// # Errors
    /// The other errors of [`PlaceFile::curves`].
    pub fn try_curves(
        &self,
        frame: &GridFrame,
    ) -> Result<Vec<Result<PlacedCurve, Misplaced>>, IoError> {
        let file = &*self.file_curves(frame)?;
        let mut placed = Vec::new();
        for curve in &file.curves {
            if curve.kind == CurveKind::Points {
                let point = |vertex: &Vertex| {
                    let vertices = vec![self.place(file, vertex, frame)?];
                    let Vertex { start, value, .. } = *vertex;
                    Ok(PlacedCurve { vertices, start, value, is_ring: false })
                };
                placed.extend(curve.vertices.iter().map(point));
                continue;
            }
            let Some(first) = curve.vertices.first() else { continue };
            if let Some(other) = curve.vertices.iter().find(|vertex| vertex.start != first.start) {
                return Err(self.content(format!(
                    "start values differ along a curve: {} at {what} {}, {} at {what} {}; a curve \
                     starts with one value, points may each have their own (--source-points)",
                    exact(first.start),
                    first.number,
                    exact(other.start),
                    other.number,
                    what = file.numbered,
                )));
            }
            let whole = || {
                let directed = curve.with_inside_on_the_left(frame.turn());
                let place = |vertex| self.place(file, vertex, frame);
                let mut vertices: Vec<_> = directed.iter().map(place).collect::<Result<_, _>>()?;
                if file.coordinates != Coordinates::Grid && frame.is_mirrored() {
                    vertices.reverse();
                }
                if curve.kind.is_closed() {
                    vertices.push(vertices[0]);
                }
                let (start, is_ring) = (first.start, curve.kind.is_ring());
                Ok(PlacedCurve { vertices, start, value: None, is_ring })
            };
            // A curve cannot be moved as a point can.
            placed.push(whole().map_err(|missed| Misplaced { near: None, ..missed }));
        }
        Ok(placed)
    }

    /// Returns what is placed, or an error that names the first places that are not on the grid.
    fn all_placed<T>(&self, placed: Vec<Result<T, Misplaced>>) -> Result<Vec<T>, IoError> {
        let missed: Vec<_> = placed.iter().filter_map(|placed| placed.as_ref().err()).collect();
        match missed[..] {
            [] => Ok(placed.into_iter().flatten().collect()),
            _ => Err(self.content(misplaced(&missed))),
        }
    }

    /// Returns the places as points of the grid, with whole rows and columns. In a frame with margins, a place may also
    /// lie at an end of the surface. Its row or column may then be fractional, negative, or beyond the last one.
    ///
    /// # Errors
    /// The errors of [`PlaceFile::points`]. It is also an error if a place lies between grid points.
    pub fn grid_points(&self, frame: &GridFrame) -> Result<Vec<PlacedPoint>, IoError> {
        if let Content::Indices(indices) = &self.content {
            let points = frame.chart.points();
            let index = |&value: &f64| {
                let fits = value.fract() == 0.0 && (0.0..points as f64).contains(&value);
                let at = || position(frame.chart, value as usize);
                let point = || PlacedPoint { at: at(), start: 0.0, value: None };
                fits.then(point).ok_or_else(|| {
                    let (last, value) = (points - 1, exact(value));
                    self.content(format!(
                        "point {value} is not a point of the grid; these are 0 to {last}"
                    ))
                })
            };
            return indices.iter().map(index).collect();
        }
        let curves = &*self.file_curves(frame)?;
        let points = self.all_placed(self.placed(curves, frame))?;
        let vertices = curves.curves.iter().flat_map(FileCurve::once);
        let is_between = |(_, point): &(&Vertex, &PlacedPoint)| frame.nearest(point.at) != point.at;
        match vertices.zip(&points).find(is_between) {
            None => Ok(points),
            Some((vertex, point)) => {
                let [row, col] = frame.nearest(point.at).map(exact);
                let (what, number) = (curves.numbered, vertex.number);
                Err(self.content(format!(
                    "{what} {number}: {} lies between points of the grid; the nearest has row {row}, \
                     column {col}",
                    curves.shown(vertex),
                )))
            }
        }
    }

    /// Returns the curves of the file. The cells that a raster selects are points; the raster must have the location of
    /// the surface.
    fn file_curves(&self, frame: &GridFrame) -> Result<Cow<'_, FileCurves>, IoError> {
        let raster = match &self.content {
            Content::Curves(curves) => {
                if let Coordinates::Map(map) = &curves.coordinates {
                    map.check(frame).map_err(|reason| self.content(reason))?;
                }
                return Ok(Cow::Borrowed(curves));
            }
            Content::Indices(indices) => {
                return Err(self.content(format!(
                    "is an array of shape ({},); places have shape (K, 2): row, column, (K, 3) with a \
                     start value, or (K, 5) as the tool writes",
                    indices.len()
                )));
            }
            Content::Raster(raster) => raster.clone(),
        };
        let Chart { rows, cols } = frame.chart;
        let cells = raster.fit_surface(&self.path, rows, cols, frame.georeference.as_ref().ok())?;
        let meant = cells.into_iter().enumerate().filter(|(_, value)| is_source(value));
        let vertex = |(number, value)| {
            let place = position(frame.chart, number);
            Vertex { place, start: 0.0, number, value: Some(value) }
        };
        let points = FileCurve { vertices: meant.map(vertex).collect(), kind: CurveKind::Points };
        Ok(Cow::Owned(FileCurves {
            curves: vec![points],
            numbered: "cell",
            ..FileCurves::default()
        }))
    }

    fn place(
        &self,
        curves: &FileCurves,
        vertex: &Vertex,
        frame: &GridFrame,
    ) -> Result<[f64; 2], Misplaced> {
        let is_map = curves.coordinates != Coordinates::Grid;
        let place = if is_map { frame.place(vertex.place) } else { on_grid(vertex.place, frame) };
        place.map_err(|reason| {
            let (what, number) = (curves.numbered, vertex.number);
            let near = match is_map {
                true => frame.unbounded_place(vertex.place),
                false => Some(vertex.place),
            };
            Misplaced { reason: format!("{what} {number}: {reason}"), near }
        })
    }

    fn content(&self, reason: String) -> IoError {
        IoError::content(&self.path, reason)
    }
}

/// Returns whether a cell of a raster is a source: neither 0 nor no-data.
fn is_source(value: &f64) -> bool {
    *value != 0.0 && !value.is_nan()
}

/// Returns a place given by row and column, or an error if it does not lie on the surface.
fn on_grid(place: [f64; 2], frame: &GridFrame) -> Result<[f64; 2], String> {
    frame.within(place).ok_or_else(|| {
        let (last_row, last_col) = frame.chart.last();
        let [row, col] = place.map(exact);
        format!(
            "row {row}, column {col} lies outside the grid: rows run from 0 to {last_row}, columns from 0 \
             to {last_col}"
        )
    })
}

/// The number of places that a message lists.
const MOST_PLACES: usize = 5;

/// Returns a message on places that are not on the grid: the reason for a single one, otherwise how many there are, and
/// the first of them.
pub fn misplaced(places: &[&Misplaced]) -> String {
    if let [only] = places {
        return only.reason.clone();
    }
    let mut said = format!("{} places are not on the surface", places.len());
    for (index, place) in places.iter().take(MOST_PLACES).enumerate() {
        said += if index == 0 { ": " } else { "; " };
        said += &place.reason;
    }
    if places.len() > MOST_PLACES {
        said += &format!("; and {} more", places.len() - MOST_PLACES);
    }
    said
}

/// Returns the row and column of a grid point.
fn position(chart: Chart, index: usize) -> [f64; 2] {
    let (row, col) = chart.position(index);
    [row as f64, col as f64]
}

/// Maximum number of names in one remark.
const MOST_NAMES: usize = 8;

/// Returns a remark on columns or properties that are not used.
fn named(what: &str, unused: &[String]) -> Option<String> {
    let names = unused.iter().take(MOST_NAMES).map(|name| excerpt(name));
    let mut names = names.collect::<Vec<_>>().join(", ");
    if unused.len() > MOST_NAMES {
        names += &format!(" and {} more", unused.len() - MOST_NAMES);
    }
    match (unused.len(), what) {
        (0, _) => None,
        (1, _) => Some(format!("the {what} {names} is not used")),
        (_, "property") => Some(format!("the properties {names} are not used")),
        _ => Some(format!("the {what}s {names} are not used")),
    }
}

//! Reads files of surfaces.

use std::path::{Path, PathBuf};

use glam::DVec3;

use super::arrays::{matrix, metric, read_array, wrong_shape};
use super::file_spacing::FileSpacing;
use super::no_data::means_given_no_data;
use super::tiff::Location;
use super::{
    GeoTags, Georeference, Grid, IoError, checked_points, exr, extension, raster, read_bytes,
};
use geosweep_surface::{Ellipsoid, MetricTensor, Spacing, Surface, SurfaceError};

/// A surface file that has been read: positions, heights or a metric.
///
/// | extension | content |
/// |---|---|
/// | `.npy` | positions (M, N, 3), heights (M, N) or a metric (M, N, 2, 2), of integers or floating-point numbers |
/// | `.npz` | one such array; of several, the first named `surface`, `positions`, `heights` or `metric` |
/// | `.png` | heights, grey, 8 or 16 bits, with the world file (`.pgw`) and the `.aux.xml` that GDAL reads beside it |
/// | `.tif`, `.tiff` | heights, one band, as GDAL reads it: with scale, offset, no-data value and mask |
/// | `.asc` | heights, an ESRI ASCII grid |
/// | `.exr` | positions in channels X, Y, Z or R, G, B, or heights in a single channel or three equal ones |
///
/// Points at which a value is NaN are holes, and pixels of an `.exr` at which the channel A is 0.
#[derive(Clone, Debug)]
pub struct SurfaceFile {
    path: PathBuf,
    content: Content,
    location: Location,
}

#[derive(Clone, Debug)]
enum Content {
    Positions(Grid<DVec3>),
    Heights(Grid<f64>, FileSpacing),
    Metric(Grid<MetricTensor>),
}

impl SurfaceFile {
    /// Reads a file.
    ///
    /// # Errors
    /// If the file cannot be read, or is not of one of the formats above.
    pub fn read(path: &Path) -> Result<Self, IoError> {
        let reason = |reason| IoError::content(path, reason);
        const NOWHERE: &str = "only a GeoTIFF (.tif), an ESRI ASCII grid (.asc) or a PNG with a world file (.pgw) says where it lies";
        let mut location = Location {
            georeference: Err(NOWHERE.into()),
            geo_tags: None,
            ellipsoid: Ok(None),
            metres: Ok(1.0),
        };
        let content = match extension(path).as_str() {
            "npy" | "npz" => array(path)?,
            "tif" | "tiff" | "asc" | "png" => {
                let raster = raster::read_values(path)?;
                location = raster.location;
                Content::Heights(raster.grid, raster.spacing)
            }
            "exr" => match exr::decode(&read_bytes(path)?).map_err(reason)? {
                exr::Pixels::Positions(grid) => Content::Positions(grid),
                exr::Pixels::Single(grid) => heights(grid),
            },
            _ => {
                return Err(IoError::extension(
                    path,
                    "a surface",
                    ".npy, .npz, .png, .tif, .asc or .exr",
                ));
            }
        };
        Ok(Self { path: path.to_owned(), content, location })
    }

    /// Makes holes of the points whose values are `no_data`, for files that cannot say which of their values mean that
    /// there is none. All coordinates of a position, or all entries of a tensor, must have that value. In a file that
    /// has a scale or an offset, the value is compared after both. Returns the number of new holes too.
    pub fn with_no_data(mut self, no_data: f64) -> (Self, usize) {
        let is_meant = |value: f64| !value.is_nan() && means_given_no_data(value, no_data);
        let holes = match &mut self.content {
            Content::Heights(grid, _) => {
                cut(&mut grid.values, f64::NAN, |&height| is_meant(height))
            }
            Content::Positions(grid) => cut(&mut grid.values, DVec3::NAN, |point| {
                point.to_array().into_iter().all(is_meant)
            }),
            Content::Metric(grid) => {
                let hole = MetricTensor { rr: f64::NAN, rc: f64::NAN, cc: f64::NAN };
                cut(&mut grid.values, hole, |it| [it.rr, it.rc, it.cc].into_iter().all(is_meant))
            }
        };
        (self, holes)
    }

    /// Returns whether the file holds heights and gives no distance between its points.
    pub fn lacks_spacing(&self) -> bool {
        matches!(self.content, Content::Heights(_, FileSpacing::Unknown))
    }

    /// Returns whether the file holds heights and a distance between its points on a map, but does not state
    /// that this distance is in metres.
    pub fn assumes_metres(&self) -> bool {
        let Content::Heights(_, FileSpacing::Known(_, unit)) = &self.content else { return false };
        !unit.said
    }

    /// Returns whether the file's map coordinates may be longitudes and latitudes: the file says so, or says nothing
    /// about them, like an ESRI ASCII grid without a .prj.
    pub fn may_be_in_degrees(&self) -> bool {
        let is_projected = self.location.geo_tags.as_ref().is_some_and(GeoTags::is_projected);
        match &self.content {
            Content::Heights(_, FileSpacing::Degrees(_)) => true,
            Content::Heights(_, FileSpacing::Known(_, unit)) => !unit.said && !is_projected,
            _ => false,
        }
    }

    /// Returns the map coordinates of the grid's points.
    ///
    /// # Errors
    /// If the file does not give them. The error says what is missing.
    pub fn georeference(&self) -> Result<Georeference, IoError> {
        self.location.georeference.clone().map_err(|reason| IoError::content(&self.path, reason))
    }

    /// Returns the ellipsoid on which longitudes and latitudes are measured, or `None` if the file does not say it.
    ///
    /// # Errors
    /// If longitudes and latitudes are not in degrees, or the file names an ellipsoid that is not known.
    pub fn ellipsoid(&self) -> Result<Option<Ellipsoid>, IoError> {
        self.location.ellipsoid.clone().map_err(|reason| IoError::content(&self.path, reason))
    }

    /// Returns the fields that give the location of a GeoTIFF, to be written to maps of the same grid. For an ESRI
    /// ASCII grid, equivalent fields are made from its header.
    pub fn geo_tags(&self) -> Option<&GeoTags> {
        self.location.geo_tags.as_ref()
    }

    /// Returns the unit of lengths, if the file has one: `m` for projected GeoTIFFs in metres, `ft` or
    /// `US ft` where pixel sizes and heights are in feet.
    pub fn unit(&self) -> Option<&'static str> {
        let Content::Heights(_, FileSpacing::Known(_, unit)) = &self.content else { return None };
        unit.name
    }

    /// Returns the heights, in metres. If the file names no unit, its numbers count as metres.
    ///
    /// # Errors
    /// If the file holds no heights, or they are in a unit that is not known.
    pub fn into_heights(self) -> Result<Grid<f64>, IoError> {
        let held = match self.content {
            Content::Heights(grid, _) => {
                let metres =
                    self.location.metres.map_err(|why| IoError::content(&self.path, why))?;
                return Ok(grid.map(|height| height * metres));
            }
            Content::Positions(_) => "positions",
            Content::Metric(_) => "metric tensors",
        };
        Err(IoError::content(&self.path, format!("holds {held}, not heights (M, N)")))
    }

    /// Makes the surface. Heights have the given spacing, otherwise the file's, otherwise 1.
    ///
    /// # Errors
    /// If the values do not make a surface; if a spacing is given and the file does not hold heights; if the
    /// file has a spacing that cannot be used and none is given.
    pub fn into_surface(self, spacing: Option<Spacing>) -> Result<Surface, IoError> {
        let Self { path, content, .. } = self;
        let no_spacing_for = |what| match spacing {
            None => Ok(()),
            Some(_) => Err(IoError::content(
                &path,
                format!(
                    "holds {what}, which need no spacing; it is for heights only, leave it out"
                ),
            )),
        };
        let surface = |result: Result<Surface, SurfaceError>| {
            result.map_err(|source| IoError::Surface { path: path.clone(), source })
        };
        match content {
            Content::Positions(Grid { rows, cols, values, .. }) => {
                no_spacing_for("positions")?;
                surface(Surface::from_positions(rows, cols, values))
            }
            Content::Metric(Grid { rows, cols, values, .. }) => {
                no_spacing_for("metric tensors")?;
                surface(Surface::from_metric(rows, cols, values))
            }
            Content::Heights(Grid { rows, cols, values, .. }, from_file) => {
                let spacing = match (spacing, from_file) {
                    (Some(spacing), _) | (None, FileSpacing::Known(spacing, _)) => spacing,
                    (None, FileSpacing::Unknown) => Spacing::square(1.0),
                    (None, FileSpacing::Degrees(why)) => {
                        return Err(IoError::content(
                            &path,
                            format!(
                                "{why}; measure on the Earth, as with the tool's --geodetic, or {GIVE_SPACING}"
                            ),
                        ));
                    }
                    (None, FileSpacing::Unusable(why)) => {
                        return Err(IoError::content(&path, format!("{why}; {GIVE_SPACING}")));
                    }
                };
                surface(Surface::from_heights(rows, cols, values, spacing))
            }
        }
    }
}

/// Advice where the distance between points is not known.
const GIVE_SPACING: &str = "give the spacing in the unit of the heights (metres, usually), as with the tool's \
                            --spacing DX,DY";

/// Replaces the values that are meant by `hole`. Returns their number.
fn cut<T: Copy>(values: &mut [T], hole: T, is_meant: impl Fn(&T) -> bool) -> usize {
    let mut holes = 0;
    for value in values.iter_mut().filter(|value| is_meant(value)) {
        *value = hole;
        holes += 1;
    }
    holes
}

fn heights(grid: Grid<f64>) -> Content {
    Content::Heights(grid, FileSpacing::Unknown)
}

fn array(path: &Path) -> Result<Content, IoError> {
    let array = read_array(path, &["surface", "positions", "heights", "metric"])?;
    let reason = |reason| IoError::content(path, reason);
    if array.dtype.kind == b'b' {
        let why = "holds booleans, which are no surface; a mask is given beside one, as with the tool's --mask";
        return Err(IoError::content(path, why));
    }
    match *array.shape {
        [_, _] => Ok(heights(matrix(path, array, "a height field")?)),
        [rows, cols, 3] => {
            checked_points(rows, cols).map_err(reason)?;
            let values = array.values.as_chunks().0.iter().map(|x| DVec3::from_array(*x)).collect();
            Ok(Content::Positions(Grid::new(rows, cols, values)))
        }
        [_, _, 2, 2] => metric(array).map(Content::Metric).map_err(reason),
        _ => Err(wrong_shape(
            path,
            &array,
            "a surface has shape (M, N, 3) for positions, (M, N) for heights, or (M, N, 2, 2) for a metric",
        )),
    }
}

//! Holds the surface of a command and its place on the Earth. Commands take places on the given grid, which is the grid
//! of the file, and convert them to places on the surface's grid.

use std::borrow::Cow;

use geosweep::geometry::PathError;
use geosweep::io::{GeoTags, Georeference, GridFrame};
use geosweep::surface::{Chart, Real};
use geosweep::{DistanceMap, Surface};

use super::given::GivenGrid;

/// The surface on which the map is computed, and the surface that is drawn.
pub struct Scene {
    /// The surface. If it is closed, its grid may have more rows and columns than the file.
    pub surface: Surface,
    /// The surface that has positions, if lengths come from a separate metric.
    pub(super) shape: Option<Surface>,
    /// The map coordinates of the points, or why they are not known.
    pub georeference: Result<Georeference, String>,
    /// The tags that georeference a GeoTIFF of the same grid.
    pub geo_tags: Option<GeoTags>,
    /// The unit of lengths, if the file has one.
    pub unit: Option<&'static str>,
    /// The grid of the file, if the surface lies on the Earth or has more lines than the file.
    pub(super) grid: Option<GivenGrid>,
    /// Whether the surface lies on the Earth.
    pub(super) is_on_earth: bool,
}

impl Scene {
    /// Returns the map coordinates of places on the surface.
    pub fn frame(&self) -> GridFrame {
        match &self.grid {
            Some(grid) => grid.frame.clone(),
            None => GridFrame::new(self.chart(), self.georeference.clone()),
        }
    }

    /// Returns the size of the given grid.
    pub fn chart(&self) -> Chart {
        self.grid.as_ref().map_or(self.surface.chart(), |grid| grid.chart)
    }

    /// Converts a given place to a place on the surface's grid.
    ///
    /// # Errors
    /// If the place is not on the surface. This is checked only if the surface has more lines than the file or lies on
    /// the Earth. Otherwise the library checks the place later.
    pub fn place(&self, given: [f64; 2]) -> Result<[f64; 2], String> {
        self.grid.as_ref().map_or(Ok(given), |grid| grid.place(given))
    }

    /// Returns the row-major index, on the surface's grid, of the point nearest to a given place.
    ///
    /// # Errors
    /// As for [`Self::place`].
    pub fn index(&self, given: [f64; 2]) -> Result<usize, String> {
        let [row, col] = self.place(given)?;
        Ok(self.surface.chart().index(row.round() as usize, col.round() as usize))
    }

    /// Returns the vertices of a given curve on the surface's grid, where it may jump over seams.
    ///
    /// # Errors
    /// As for [`Self::place`], and if the curve leaps over more than half a turn where columns go round.
    pub fn curve(&self, given: Vec<[f64; 2]>) -> Result<Vec<[f64; 2]>, String> {
        match &self.grid {
            Some(grid) => grid.curve(&given, &self.surface),
            None => Ok(given),
        }
    }

    /// Converts a place on the surface's grid to the given grid, where poles may lie beyond the first and the last row.
    pub fn given(&self, place: [f64; 2]) -> [f64; 2] {
        self.grid.as_ref().map_or(place, |grid| grid.lines.to_given(place))
    }

    /// Returns the values at the given points. `values` has one value for each point of the surface.
    pub fn crop<'a, T: Copy>(&self, values: &'a [T]) -> Cow<'a, [T]> {
        self.extended().map_or(values.into(), |grid| grid.lines.crop(values).into())
    }

    /// Sets the largest distance and the numbers of points in a map's report to those of the given points.
    pub fn count<R: Real>(&self, map: &mut DistanceMap<R>) {
        let Some(grid) = self.extended() else { return };
        let given = grid.lines.crop(&map.distances);
        let given = DistanceMap::new(grid.chart, given, map.report.clone()).report;
        map.report.points = self.points();
        (map.report.reached, map.report.max_distance) = (given.reached, given.max_distance);
    }

    /// Returns the number of given points that are present.
    pub fn points(&self) -> usize {
        self.extended().map_or(self.surface.points(), |grid| grid.points(&self.surface))
    }

    /// Returns the index of each given point on the surface's grid, or `None` if that grid has no added points.
    pub fn given_points(&self) -> Option<Vec<usize>> {
        self.extended().map(|grid| grid.lines.given_points())
    }

    /// Returns whether each point on the surface's grid is a given one, if that grid has more points.
    pub fn is_given(&self) -> Option<Vec<bool>> {
        let points = self.given_points()?;
        let mut is_given = vec![false; self.surface.chart().points()];
        points.into_iter().for_each(|point| is_given[point] = true);
        Some(is_given)
    }

    /// Refuses `what`, which needs all points of the surface, if the given grid lacks some of them.
    pub fn refuse_added_lines(&self, what: &str) -> Result<(), String> {
        match self.extended() {
            None => Ok(()),
            Some(_) => Err(format!(
                "{what}: the surface has lines that the grid lacks, at a pole or at a seam, which cannot be left out \
                 here; give a grid that has these lines, or one without poles and seams"
            )),
        }
    }

    /// Refuses `what`, which gives directions in rows and columns, if on the Earth the rows do not run southwards or
    /// the columns eastwards. Also refuses it if added lines lie a part of a step away from given ones, since the rows
    /// and columns of a direction then differ between the two grids.
    pub fn refuse_directions(&self, what: &str) -> Result<(), String> {
        if self.extended().is_some_and(|grid| grid.lines.has_part_steps()) {
            self.refuse_added_lines(what)?;
        }
        let is_north_up = |at: &Georeference| at.down[1] < 0.0 && at.right[0] > 0.0;
        match self.georeference.as_ref().is_ok_and(is_north_up) || !self.is_on_earth {
            true => Ok(()),
            false => Err(format!(
                "{what}: directions on the Earth need rows from north to south and columns from west to east; \
                 gdalwarp makes such a grid"
            )),
        }
    }

    /// Converts the places in an error to given places.
    pub fn explain(&self, error: geosweep::Error) -> geosweep::Error {
        match (error, &self.grid) {
            (geosweep::Error::Source(error), Some(grid)) => grid.of_sources(error).into(),
            (error, _) => error,
        }
    }

    /// Converts the places in an error on a path to given places.
    pub fn explain_path(&self, error: PathError) -> PathError {
        match &self.grid {
            Some(grid) => grid.of_paths(error),
            None => error,
        }
    }

    /// Returns whether the surface lies on the Earth.
    pub fn is_on_earth(&self) -> bool {
        self.is_on_earth
    }

    /// Returns whether the surface has a grid of its own, to which given places are converted.
    pub fn has_own_grid(&self) -> bool {
        self.grid.is_some()
    }

    fn extended(&self) -> Option<&GivenGrid> {
        self.grid.as_ref().filter(|grid| grid.lines.is_extended())
    }

    pub fn shape(&self) -> &Surface {
        self.shape.as_ref().unwrap_or(&self.surface)
    }

    /// Returns the quantity and unit of the map's values.
    pub fn quantity(&self, unit: Option<&str>) -> String {
        let name = if self.surface.slowness().is_some() { "travel time" } else { "distance" };
        unit.map_or(name.into(), |unit| format!("{name} ({unit})"))
    }
}

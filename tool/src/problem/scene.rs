//! Holds the surface of a command and its place on the Earth. Commands take places on the given grid, which is the grid
//! of the file, and convert them to places on the surface's grid.

use std::borrow::Cow;

use geosweep::geometry::PathError;
use geosweep::io::{GeoTags, Georeference, GridFrame, Orientation};
use geosweep::surface::{Chart, Geometry, Real};
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

    /// Returns the place on the surface's grid of the point of the surface that is nearest to a given place, in steps of
    /// the grid weighted by their lengths on a plane. The place may lie outside the grid or in a hole.
    pub fn snapped(&self, given: [f64; 2]) -> Option<[f64; 2]> {
        let (surface, chart) = (&self.surface, self.surface.chart());
        let (last_row, last_col) = self.chart().last();
        let last = [last_row, last_col].map(|last| last as f64);
        let within: [f64; 2] = std::array::from_fn(|k| given[k].clamp(0.0, last[k]));
        let [row, col] = self.place(within).ok()?;
        let [dy, dx] = match surface.geometry() {
            Geometry::Heights { spacing, .. } => [spacing.dy, spacing.dx],
            _ => [1.0; 2],
        };
        let apart = |(at_row, at_col): (usize, usize)| {
            (dy * (at_row as f64 - row)).hypot(dx * (at_col as f64 - col))
        };
        let present = chart.places().filter(|&(row, col)| surface.has(row, col));
        let nearest = present.min_by(|&a, &b| apart(a).total_cmp(&apart(b)))?;
        Some([nearest.0 as f64, nearest.1 as f64])
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

    /// Refuses `what`, which gives directions, if added lines lie a part of a step away from given ones, since the rows
    /// and columns of a direction then differ between the two grids.
    pub fn refuse_directions(&self, what: &str) -> Result<(), String> {
        match self.extended().is_some_and(|grid| grid.lines.has_part_steps()) {
            true => self.refuse_added_lines(what),
            false => Ok(()),
        }
    }

    /// Returns the orientation of the given grid on its map, or `None` if it has no map coordinates. Then directions
    /// are those of the grid.
    pub fn orientation(&self) -> Result<Option<Orientation>, String> {
        self.georeference.as_ref().ok().map(Georeference::orientation).transpose()
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

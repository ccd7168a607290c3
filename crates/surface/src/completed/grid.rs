//! Converts surfaces, values and positions between a given grid and the completed grid, which has more lines.

use super::super::inputs::Inputs;
use super::super::{Chart, Geometry, Gluing, GluingError, Known, Surface, SurfaceError};
use super::added::Added;
use super::axis::Axis;

/// A grid of a closed surface that lacks lines which gluing needs, and the completed grid that has these lines.
///
/// [`Self::complete`] turns a surface on the given grid, with its holes and slowness, into a surface on the completed
/// grid. Distances are then computed on the completed grid, and [`Self::crop`] returns the distances at the given
/// points.
///
/// - A column or a row is added after the last one, as a copy of the first: [`Seam::Neighbours`].
/// - A row is added at a pole: [`Seam::Ring`]. The position of the pole is extrapolated from the next two rows, to
///   third order in their distance. Its slowness is the mean over the next row.
/// - The faces of a cube with values at the middles of texels get the lines between the faces. A point of these lines
///   lies between two texels, or at a corner between three. It is computed from these texels and the texels behind them
///   as a pole is from two rows.
///
/// An added point is a hole where the points beside it are holes.
///
/// [`Seam::Neighbours`]: crate::Seam::Neighbours
/// [`Seam::Ring`]: crate::Seam::Ring
///
/// ```
/// use geosweep::glam::DVec3;
/// use geosweep::surface::{CompletedGrid, Layout};
/// use geosweep::{Options, Sources, Surface, distance_map};
/// // Longitudes of 0 to 355 degrees, and latitudes at the middles of cells.
/// let point = |index: usize| {
///     let [lat, lon] = [87.5 - 5.0 * (index / 72) as f64, 5.0 * (index % 72) as f64].map(f64::to_radians);
///     DVec3::new(lat.cos() * lon.cos(), lat.cos() * lon.sin(), lat.sin())
/// };
/// let given = Surface::from_positions(36, 72, (0..36 * 72).map(point).collect())?;
/// let grid = CompletedGrid::new(&given, Layout::Globe)?;
/// let globe = grid.complete(&given)?;
/// assert_eq!((globe.rows(), globe.cols()), (38, 73));
/// // From the north pole, half a row before the first one.
/// let [row, col] = grid.to_completed([-0.5, 0.0]).unwrap();
/// let map = distance_map(&globe, &Sources::point(row, col), &Options::default())?;
/// let distances = grid.crop(&map.distances);
/// assert_eq!(distances.len(), 36 * 72);
/// assert!((distances[18 * 72].to_degrees() - 92.5).abs() < 0.01);
/// # Ok::<(), geosweep::Error>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct CompletedGrid {
    pub(super) rows: Axis,
    pub(super) cols: Axis,
    pub(super) added: Vec<Added>,
    pub(super) gluing: Gluing,
}

/// Largest difference between a distance and a whole number of steps that counts as rounding.
const PART: f64 = 1e-6;

impl CompletedGrid {
    /// Returns the given grid's size.
    pub fn given(&self) -> Chart {
        Chart { rows: self.rows.given(), cols: self.cols.given() }
    }

    /// Returns the completed grid's size.
    pub fn chart(&self) -> Chart {
        Chart { rows: self.rows.completed(), cols: self.cols.completed() }
    }

    /// Returns whether the completed grid has points that are not given.
    pub fn is_extended(&self) -> bool {
        self.rows.is_extended() || self.cols.is_extended()
    }

    /// Returns whether lines are added a part of a step away from given ones, as at poles and between faces of a cube.
    pub fn has_part_steps(&self) -> bool {
        let is_part = |step: f64| (step - step.round()).abs() > PART;
        [self.rows, self.cols].iter().flat_map(|axis| axis.margins).any(is_part)
    }

    /// Returns the completed and glued surface of an open surface of the given grid, with its slowness and edge rule.
    ///
    /// # Errors
    /// If the surface has another size, the geometry does not allow the gluing, or glued points do not coincide.
    pub fn complete(&self, surface: &Surface) -> Result<Surface, SurfaceError> {
        surface
            .check_open("the completion of a grid", "complete the surface before it is glued")?;
        let Chart { rows, cols } = self.given();
        if surface.chart() != self.given() {
            let found = surface.chart().points();
            return Err(SurfaceError::Shape { what: "surface", found, rows, cols });
        }
        let is_in_space = surface.geometry().is_in_space();
        if !is_in_space && self.added.iter().any(|added| added.copied().is_none()) {
            return Err(GluingError::NoPositions {
                what: "an added line that is not a copy of another line",
            }
            .into());
        }
        let chart = self.chart();
        let mut points: Vec<_> =
            chart.places().map(|(row, col)| self.given_point(row, col)).collect();
        for added in &self.added {
            added.at.iter().for_each(|&at| points[at] = added.copied());
        }
        let mut inputs = surface.inputs.gathered(points.into_iter());
        self.place_middles(surface, &mut inputs);
        let (edge_rule, known) = (surface.edge_rule, Known::default());
        Surface { chart, inputs, edge_rule, known, glued: None }.with_gluing(self.gluing.clone())
    }

    /// Sets the positions and slowness of added points, except copies.
    fn place_middles(&self, surface: &Surface, inputs: &mut Inputs) {
        let Geometry::Positions(positions) = &inputs.geometry else { return };
        let mut positions = positions.to_vec();
        let position = |point: usize| {
            let (row, col) = self.given().position(point);
            surface.position(row, col)
        };
        let there =
            |(&slowness, &present): (&f64, &bool)| if present { slowness } else { f64::NAN };
        let slowness = surface
            .slowness()
            .map(|slowness| slowness.iter().zip(surface.present()).map(there).collect::<Vec<_>>());
        for added in self.added.iter().filter(|added| added.copied().is_none()) {
            let middle = added.position(position);
            let mean = slowness.as_ref().map(|slowness| added.mean(slowness));
            for &at in &added.at {
                positions[at] = middle.unwrap_or_default();
                inputs.present[at] = middle.is_some();
                if let Some((all, mean)) = inputs.slowness.as_mut().zip(mean) {
                    all[at] = mean;
                }
            }
        }
        inputs.geometry = Geometry::Positions(positions.into());
    }

    /// Returns the row-major index on the given grid of a point of the completed grid, or `None` if that point is not a
    /// given one.
    fn given_point(&self, row: usize, col: usize) -> Option<usize> {
        Some(self.given().index(self.rows.given_of(row)?, self.cols.given_of(col)?))
    }

    /// Returns values at all points of the completed grid, from values at the given points, both row-major. A copy has
    /// the value of its point. Other added points, and given poles, have the mean of the finite values next to them.
    /// Lines of holes between the completed faces of a cube have NaN.
    ///
    /// # Panics
    /// If there is not one value for each given point.
    pub fn extend(&self, values: &[f64]) -> Vec<f64> {
        assert_eq!(values.len(), self.given().points(), "one value for each point");
        let chart = self.chart();
        let value = |(row, col)| self.given_point(row, col).map_or(f64::NAN, |index| values[index]);
        let mut all: Vec<_> = chart.places().map(value).collect();
        for added in &self.added {
            let value = match added.copied() {
                Some(point) => values[point],
                None => added.mean(values),
            };
            added.at.iter().for_each(|&at| all[at] = value);
        }
        all
    }

    /// Returns the values at the given points, from values at all points of the completed grid, both row-major. Given
    /// points between the faces of a cube have the value of a point between completed faces, which is a hole.
    ///
    /// # Panics
    /// If there is not one value for each point of the completed grid.
    pub fn crop<T: Copy>(&self, values: &[T]) -> Vec<T> {
        assert_eq!(values.len(), self.chart().points(), "one value for each point");
        self.given_points().into_iter().map(|index| values[index]).collect()
    }

    /// Returns the row-major index on the completed grid of each given point. A given point between the faces of a cube
    /// has the index of a point between completed faces.
    pub fn given_points(&self) -> Vec<usize> {
        let [rows, cols] = [self.rows, self.cols].map(Axis::lines_of_given);
        let chart = self.chart();
        rows.iter().flat_map(|&row| cols.iter().map(move |&col| chart.index(row, col))).collect()
    }

    /// Returns the extent of the surface before the first given row and after the last one, and then for columns.
    /// Extents are in steps between given lines: with values at the middles of cells, a pole lies at row -0.5.
    pub fn margins(&self) -> [[f64; 2]; 2] {
        [self.rows.margins, self.cols.margins]
    }

    /// Returns the row and column on the completed grid of a place on the given grid, which may lie beyond it by up
    /// to [`Self::margins`]. Returns `None` if the surface does not have the place.
    pub fn to_completed(&self, [row, col]: [f64; 2]) -> Option<[f64; 2]> {
        (self.rows.holds(row) && self.cols.holds(col))
            .then(|| [self.rows.to_completed(row), self.cols.to_completed(col)])
    }

    /// Returns the row and column on the given grid of a place on the completed grid: the inverse of
    /// [`Self::to_completed`].
    pub fn to_given(&self, [row, col]: [f64; 2]) -> [f64; 2] {
        [self.rows.to_given(row), self.cols.to_given(col)]
    }

    /// Returns the seams of the completed grid.
    pub fn gluing(&self) -> &Gluing {
        &self.gluing
    }
}

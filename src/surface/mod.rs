//! Describes surfaces: a grid of points with a geometry, holes and sources.
//!
//! The solvers need only lengths. Whatever the input, a surface becomes the lengths of the edges between
//! neighbouring grid points ([`EdgeLengths`]), and a source becomes initial values at grid points ([`Seed`]).

mod arc;
pub mod builtin;
mod chart;
mod coarsen;
mod corner;
mod edges;
mod even_cells;
mod even_grid;
mod gaussian_curvature;
mod geodetic;
mod geometry;
mod gluing;
mod inputs;
mod iteration_bound;
mod jump;
mod measure;
mod metric_curvature;
mod obtuse;
mod points;
mod real;
mod refine;
mod resolution;
mod seams;
mod sources;
mod tag;
mod unfold;
mod window;

pub use arc::EdgeRule;
pub(crate) use chart::{
    Block, Cell, Edge, EdgeSlot, Lines, Offset, Tiling, corner_weights, grid_crossings, ring,
    triangles,
};
pub use chart::{Chart, Direction};
pub use coarsen::Coarsened;
pub(crate) use corner::{is_corner, is_open};
pub use edges::EdgeLengths;
pub(crate) use even_grid::EvenGrid;
pub(crate) use gaussian_curvature::{DIFFRACTS, LACKING};
pub use geodetic::{GeodeticError, GeodeticGrid};
pub(crate) use geometry::Sample;
pub use geometry::{Geometry, MetricTensor, Spacing, Values};
pub use gluing::{Gluing, GluingError, Groups, Run};
pub(crate) use gluing::{Sheet, UNGLUED};
pub(crate) use jump::jumps;
pub use measure::{LONGEST_EDGE, SHORTEST_EDGE};
pub(crate) use obtuse::{Part, is_obtuse};
pub use real::{FAR, Real};
pub(crate) use real::{max, min, relative_change};
pub use resolution::Resolution;
pub use seams::{GridSide, Seam};
pub(crate) use sources::Origins;
pub(crate) use sources::with_diagonals;
pub use sources::{Origin, Seed, Source, SourceError, Sources};
pub(crate) use tag::{TAG, Tagged};

use std::sync::{Arc, OnceLock};

use glam::DVec3;

use gluing::Glued;
use inputs::Inputs;

/// An M x N grid of points on a surface: positions, heights or a metric, with an optional slowness and holes.
///
/// Values are kept in double precision. In single precision, coordinates far from the origin (such as the
/// eastings of a map projection) would lose the digits of a short edge.
///
/// ```
/// use geosweep::{Surface, Spacing};
/// let heights = vec![0.0; 3 * 4];
/// let surface = Surface::from_heights(3, 4, heights, Spacing { dx: 30.0, dy: 30.0 })?
///     .with_slowness(vec![2.0; 12])?;
/// assert_eq!((surface.rows(), surface.cols(), surface.points()), (3, 4, 12));
/// # Ok::<(), geosweep::surface::SurfaceError>(())
/// ```
#[derive(Clone, Debug)]
pub struct Surface {
    chart: Chart,
    inputs: Inputs,
    edge_rule: EdgeRule,
    /// The grid of a floor plan, once it has been requested.
    floor: OnceLock<Option<EvenGrid>>,
    /// The gluing, if sides of the grid are glued.
    glued: Option<Arc<Glued>>,
}

/// The reason why an array is not a surface.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum SurfaceError {
    /// An array's length is not rows x columns.
    #[error("{what}: {found} values do not fill a grid of {rows} x {cols} points")]
    Shape {
        /// Name of the array.
        what: &'static str,
        /// Length of the array.
        found: usize,
        /// Number of rows of the grid.
        rows: usize,
        /// Number of columns of the grid.
        cols: usize,
    },
    /// The grid has no row or no column.
    #[error("a grid of {rows} x {cols} points is empty; give at least one row and one column")]
    Empty {
        /// Number of rows of the grid.
        rows: usize,
        /// Number of columns of the grid.
        cols: usize,
    },
    /// The grid cannot be coarsened.
    #[error(
        "a grid of {rows} x {cols} points cannot be compared with every second point of it: each side needs one point, or at least three of which some are not holes"
    )]
    TooSmall {
        /// Number of rows of the grid.
        rows: usize,
        /// Number of columns of the grid.
        cols: usize,
    },
    /// Every point is a hole.
    #[error("no point of the surface is left: all are NaN or masked out")]
    NoPoint,
    /// A value is infinite where only finite values and NaN (a hole) are valid.
    #[error("{what} at row {row}, column {col} is infinite; use NaN to mark a hole")]
    Infinite {
        /// Name of the array.
        what: &'static str,
        /// Row of the value.
        row: usize,
        /// Column of the value.
        col: usize,
    },
    /// A spacing is zero, negative or not finite.
    #[error("spacing {dx} x {dy} is not usable: both must be positive and finite")]
    Spacing {
        /// Spacing between columns.
        dx: f64,
        /// Spacing between rows.
        dy: f64,
    },
    /// A slowness is negative.
    #[error(
        "slowness {value} at row {row}, column {col} is negative; 0 is free travel, and infinity or NaN a wall that nothing passes"
    )]
    Slowness {
        /// The negative value.
        value: f64,
        /// Row of the value.
        row: usize,
        /// Column of the value.
        col: usize,
    },
    /// A metric tensor is not positive definite.
    #[error(
        "metric at row {row}, column {col} is not positive definite: [[{rr}, {rc}], [{rc}, {cc}]]; its diagonal and its determinant must be positive"
    )]
    Metric {
        /// Row of the tensor.
        row: usize,
        /// Column of the tensor.
        col: usize,
        /// The tensor's entry for rows.
        rr: f64,
        /// The tensor's mixed entry.
        rc: f64,
        /// The tensor's entry for columns.
        cc: f64,
    },
    /// A coordinate makes edges too long for single precision.
    #[error(
        "{what} at row {row}, column {col}: {value:e} is too large, as edges may be no longer than {LONGEST_EDGE:e} units; if it stands for no data, make it NaN, mask it out or name it as the file's no-data value, else choose a larger unit of length"
    )]
    TooLarge {
        /// Name of the array.
        what: &'static str,
        /// The value.
        value: f64,
        /// Row of the value.
        row: usize,
        /// Column of the value.
        col: usize,
    },
    /// The surface cannot be glued, or something is not available on glued surfaces.
    #[error(transparent)]
    Gluing(#[from] GluingError),
    /// An edge is too long or too short for single precision.
    #[error(
        "the edge from row {row}, column {col} to its {direction:?} neighbour is {length:e} units long; choose a unit of length in which edges lie between {SHORTEST_EDGE:e} and {LONGEST_EDGE:e}"
    )]
    EdgeLength {
        /// Row of the edge's first end.
        row: usize,
        /// Column of the edge's first end.
        col: usize,
        /// Direction from the first end to the other.
        direction: Direction,
        /// Length of the edge.
        length: f64,
    },
}

impl Surface {
    /// Makes a surface from 3D points, row-major. A point with a NaN coordinate is a hole.
    pub fn from_positions(
        rows: usize,
        cols: usize,
        positions: Vec<DVec3>,
    ) -> Result<Self, SurfaceError> {
        Self::new(rows, cols, Geometry::Positions(positions.into()))
    }

    /// Makes a height field from heights, row-major. The point at row r and column c is (c dx, r dy, height).
    /// A NaN height is a hole.
    pub fn from_heights(
        rows: usize,
        cols: usize,
        heights: Vec<f64>,
        spacing: Spacing,
    ) -> Result<Self, SurfaceError> {
        if !spacing.is_usable() {
            return Err(SurfaceError::Spacing { dx: spacing.dx, dy: spacing.dy });
        }
        Self::new(rows, cols, Geometry::Heights { heights: heights.into(), spacing })
    }

    /// Makes a height field as [`Self::from_heights`] does, from heights that stay where they are: in an array
    /// of the program, which the surface and its clones keep. The values must not change meanwhile.
    ///
    /// ```
    /// use std::sync::Arc;
    /// use geosweep::{Spacing, Surface};
    ///
    /// let heights = Arc::new(vec![0.0; 3 * 4]);
    /// let surface = Surface::from_shared_heights(3, 4, heights.clone(), Spacing::square(1.0))?;
    /// assert_eq!((surface.points(), Arc::strong_count(&heights)), (12, 2));
    /// # Ok::<(), geosweep::surface::SurfaceError>(())
    /// ```
    ///
    /// # Errors
    /// As for [`Self::from_heights`].
    pub fn from_shared_heights(
        rows: usize,
        cols: usize,
        heights: Arc<dyn AsRef<[f64]> + Send + Sync>,
        spacing: Spacing,
    ) -> Result<Self, SurfaceError> {
        if !spacing.is_usable() {
            return Err(SurfaceError::Spacing { dx: spacing.dx, dy: spacing.dy });
        }
        Self::new(rows, cols, Geometry::Heights { heights: Values::shared(heights), spacing })
    }

    /// Makes a surface from 3D points as [`Self::from_positions`] does, from points that stay where they are:
    /// in an array of the program, which the surface and its clones keep. The values must not change
    /// meanwhile.
    pub fn from_shared_positions(
        rows: usize,
        cols: usize,
        positions: Arc<dyn AsRef<[DVec3]> + Send + Sync>,
    ) -> Result<Self, SurfaceError> {
        Self::new(rows, cols, Geometry::Positions(Values::shared(positions)))
    }

    /// Makes a surface given only by its metric (paper, eq. 3) in index coordinates, row-major. A tensor with
    /// a NaN entry is a hole.
    pub fn from_metric(
        rows: usize,
        cols: usize,
        metric: Vec<MetricTensor>,
    ) -> Result<Self, SurfaceError> {
        Self::new(rows, cols, Geometry::Metric(metric.into()))
    }

    fn new(rows: usize, cols: usize, geometry: Geometry) -> Result<Self, SurfaceError> {
        if rows == 0 || cols == 0 {
            return Err(SurfaceError::Empty { rows, cols });
        }
        let chart = Chart { rows, cols };
        check_shape(geometry.what(), geometry.len(), chart)?;
        let present = geometry.points_present(chart)?;
        let is_scaled = geometry.jumps_in_scale(chart, &present);
        let inputs = Inputs { geometry, slowness: None, present, is_scaled };
        let (edge_rule, floor) = (EdgeRule::default(), OnceLock::new());
        Self { chart, inputs, edge_rule, floor, glued: None }.non_empty()
    }

    /// Sets the rule by which edges are measured.
    pub fn with_edge_rule(mut self, edge_rule: EdgeRule) -> Self {
        self.edge_rule = edge_rule;
        self
    }

    fn non_empty(self) -> Result<Self, SurfaceError> {
        if self.present().contains(&true) { Ok(self) } else { Err(SurfaceError::NoPoint) }
    }

    /// Returns the grid's size.
    pub fn chart(&self) -> Chart {
        self.chart
    }

    /// Returns the number of rows, M.
    pub fn rows(&self) -> usize {
        self.chart.rows
    }

    /// Returns the number of columns, N.
    pub fn cols(&self) -> usize {
        self.chart.cols
    }

    /// Returns the number of points that are not holes.
    pub fn points(&self) -> usize {
        self.present().iter().filter(|&&present| present).count()
    }

    /// Returns the positions, heights or metric, as given.
    pub fn geometry(&self) -> &Geometry {
        &self.inputs.geometry
    }

    /// Returns the rule by which edges are measured. A surface given only by its metric always has
    /// [`EdgeRule::Chord`].
    pub fn edge_rule(&self) -> EdgeRule {
        if self.geometry().has_positions() { self.edge_rule } else { EdgeRule::Chord }
    }

    /// Returns for each point, row-major, whether the surface is present (true) or has a hole (false).
    pub fn present(&self) -> &[bool] {
        &self.inputs.present
    }

    /// Returns whether the grid has this point and it is not a hole.
    pub fn has(&self, row: usize, col: usize) -> bool {
        row < self.rows() && col < self.cols() && self.present()[self.chart.index(row, col)]
    }

    /// Returns the 3D position of a grid point. The result is `None` at holes, and for a surface given only
    /// by its metric.
    pub fn position(&self, row: usize, col: usize) -> Option<DVec3> {
        self.has(row, col).then(|| self.geometry().position(self.chart, row, col))?
    }

    /// Returns whether the surface is a floor plan: a flat, evenly spaced grid without a slowness and without
    /// gluing, with or without holes. The grid may be sheared as long as no triangle of neighbours is obtuse.
    /// It may have about 30 million points at most. Over a floor plan, and from points,
    /// [`crate::Wavefront::Anchored`] is exact.
    ///
    /// ```
    /// use geosweep::{Spacing, Surface};
    /// let floor = Surface::from_heights(3, 4, vec![1.0; 12], Spacing { dx: 0.5, dy: 0.25 })?;
    /// assert!(floor.is_floor_plan());
    /// let mut heights = vec![1.0; 12];
    /// heights[5] = 1.1;
    /// assert!(!Surface::from_heights(3, 4, heights, Spacing { dx: 0.5, dy: 0.25 })?.is_floor_plan());
    /// # Ok::<(), geosweep::surface::SurfaceError>(())
    /// ```
    pub fn is_floor_plan(&self) -> bool {
        self.floor().is_some()
    }

    /// Returns the even grid of a floor plan.
    pub(crate) fn floor(&self) -> Option<EvenGrid> {
        let grid = || EvenGrid::of(self).filter(|grid| !grid.is_obtuse());
        // Anchors are places of the chart, and seams lead to other places.
        let is_open = has_numbers(self.chart) && !self.is_glued();
        *self.floor.get_or_init(|| is_open.then(grid).flatten())
    }

    /// Returns whether the surface has an edge from a grid point to a neighbour. Both ends must be present. A
    /// diagonal also needs a third corner of its cell beside it; otherwise a path would slip through between
    /// two holes.
    pub fn has_edge(&self, row: usize, col: usize, to: Direction) -> bool {
        let has = |to| self.chart.neighbour(row, col, to).is_some_and(|(r, c)| self.has(r, c));
        let beside = !to.is_diagonal() || has(to.previous()) || has(to.next());
        self.has(row, col) && has(to) && beside
    }
}

/// Number of anchors that a front can name. Half of the numbers are for grid points, half for sources inside
/// cells. See `update/anchor.rs`.
pub(crate) const ANCHORS: usize = 1 << 26;

/// Upper bound for the number of rows and columns that engines keep around a grid.
const AROUND: usize = 16;

/// Returns whether fronts can carry the numbers of all points of a grid.
fn has_numbers(chart: Chart) -> bool {
    (chart.rows + AROUND) * (chart.cols + AROUND) <= ANCHORS / 2
}

fn check_shape(what: &'static str, found: usize, chart: Chart) -> Result<(), SurfaceError> {
    let Chart { rows, cols } = chart;
    if rows.checked_mul(cols) == Some(found) {
        Ok(())
    } else {
        Err(SurfaceError::Shape { what, found, rows, cols })
    }
}

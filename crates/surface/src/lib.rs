//! Surfaces: grids of points with a geometry, holes and sources.
//!
//! The solvers need only lengths. Every kind of surface becomes the lengths of the edges between neighbouring grid
//! points ([`EdgeLengths`]), and every source becomes initial values at grid points ([`Seed`]).

mod angle;
mod arc;
pub mod builtin;
mod chart;
mod coarsen;
mod completed;
#[doc(hidden)]
pub mod constants;
mod corner;
mod edges;
mod error;
mod even_cells;
mod even_grid;
mod fan;
mod floor_plan;
mod gaussian_curvature;
mod geodetic;
mod geometry;
mod gluing;
mod inputs;
mod iteration_bound;
mod jump;
#[doc(hidden)]
pub mod lanes;
mod map;
mod measure;
mod measured;
mod metric_curvature;
mod monitor;
#[doc(hidden)]
pub mod name;
mod obtuse;
mod points;
mod precision;
mod real;
mod refine;
mod resolution;
mod seams;
#[doc(hidden)]
pub mod shown;
mod skewed_cells;
mod slowed_curvature;
mod slowness;
mod sources;
mod stop;
mod tag;
mod targets;
mod unfold;
pub mod update;
mod window;

pub use arc::EdgeRule;
#[doc(hidden)]
pub use chart::{
    Block, Cell, Edge, EdgeSlot, Lines, Offset, Tiling, corner_weights, grid_crossings, ring,
    triangles,
};
pub use chart::{Chart, Direction, GridSide};
pub use coarsen::Coarsened;
pub use completed::{CompletedGrid, LastLine, Layout};
#[doc(hidden)]
pub use corner::{is_corner, is_open};
pub use edges::EdgeLengths;
pub use error::SurfaceError;
#[doc(hidden)]
pub use even_grid::EvenGrid;
#[doc(hidden)]
pub use fan::Fan;
#[doc(hidden)]
pub use gaussian_curvature::{DIFFRACTS, LACKING};
pub use geodetic::{Ellipsoid, GeodeticError, GeodeticGrid};
#[doc(hidden)]
pub use geometry::Sample;
pub use geometry::{Geometry, MetricTensor, Spacing, Values};
#[doc(hidden)]
pub use gluing::{Glued, Lattice, Ring, Sheet, SolverGrid, UNGLUED};
pub use gluing::{Gluing, GluingError, Groups, Run};
#[doc(hidden)]
pub use jump::jumps;
pub use lanes::Instructions;
pub use map::{DistanceMap, Report, UsedEngine};
pub use monitor::{Cancelled, Monitor};
pub use name::UnknownName;
#[doc(hidden)]
pub use obtuse::{PartsAround, SplitPart, is_obtuse, reach::reduced_basis, reach::splits_within};
pub use real::{FAR, LONGEST_EDGE, Real, SHORTEST_EDGE};
#[doc(hidden)]
pub use real::{max, min, relative_change};
pub use resolution::Resolution;
pub use seams::Seam;
use skewed_cells::MostSkewed;
pub use skewed_cells::Unresolved;
#[doc(hidden)]
pub use sources::Origins;
#[doc(hidden)]
pub use sources::with_diagonals;
pub use sources::{Heading, Origin, Seed, Source, SourceError, Sources};
pub use stop::{Convergence, DEFAULT_TOLERANCE, DEFAULT_TOLERANCE_F64, Stop};
#[doc(hidden)]
pub use tag::{TAG, Tagged};
pub use targets::Targets;
pub use update::Wavefront;

use std::sync::{Arc, OnceLock};

use glam::DVec3;

use error::{check_shape, check_size};
use inputs::Inputs;

/// An M x N grid of points on a surface: positions, heights or a metric, with an optional slowness and holes.
///
/// Values are stored in double precision. In single precision, coordinates far from the origin (such as the eastings of
/// a map projection) would lose the digits of a short edge.
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
    known: Known,
    /// The gluing, if sides of the grid are glued.
    glued: Option<Arc<Glued>>,
}

/// Values that a surface computes on first request and keeps. A change of its inputs discards them.
#[derive(Clone, Debug, Default)]
struct Known {
    /// The grid of a floor plan.
    floor: OnceLock<Option<EvenGrid>>,
    resolution: OnceLock<Option<Resolution>>,
    /// See [`Surface::unresolved`].
    most_skewed: OnceLock<MostSkewed>,
    /// See [`Surface::even_metric`].
    even_metric: OnceLock<Option<[f64; 3]>>,
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
        Self::from_shared_heights(rows, cols, Arc::new(heights), spacing)
    }

    /// Makes a height field as [`Self::from_heights`] does, from heights that stay in an array of the
    /// program. The surface and its clones keep this array alive, and its values must not change meanwhile.
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

    /// Makes a surface from 3D points as [`Self::from_positions`] does, from points that stay in an array of
    /// the program. The surface and its clones keep this array alive, and its values must not change
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
        check_size(chart)?;
        check_shape(geometry.what(), geometry.len(), chart)?;
        let present = geometry.points_present(chart)?;
        let is_scaled = geometry.jumps_in_scale(chart, &present);
        let inputs = Inputs { geometry, slowness: None, present, is_scaled };
        let (edge_rule, known) = (EdgeRule::default(), Known::default());
        Self { chart, inputs, edge_rule, known, glued: None }.non_empty()
    }

    /// Sets the rule by which edges are measured.
    pub fn with_edge_rule(mut self, edge_rule: EdgeRule) -> Self {
        self.edge_rule = edge_rule;
        // The facts that a surface keeps were found with other lengths of edges.
        self.known = Known::default();
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

    /// Returns whether no point is missing.
    #[doc(hidden)]
    pub fn is_whole(&self) -> bool {
        self.present().iter().all(|&is| is)
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

    /// Returns whether the surface has an edge from a grid point to a neighbour. Both ends must be present. A
    /// diagonal also needs a third corner of its cell beside it; otherwise a path would slip through between
    /// two holes.
    pub fn has_edge(&self, row: usize, col: usize, to: Direction) -> bool {
        let has = |to| self.chart.neighbour(row, col, to).is_some_and(|(r, c)| self.has(r, c));
        let beside = !to.is_diagonal() || has(to.previous()) || has(to.next());
        self.has(row, col) && has(to) && beside
    }
}

/// Returns the value in a lock, computed on the first call. It is computed outside the lock: a thread that waits for
/// others in `compute` may take up work that needs the value too.
fn kept<T>(lock: &OnceLock<T>, compute: impl FnOnce() -> T) -> &T {
    lock.get().unwrap_or_else(|| {
        let value = compute();
        lock.get_or_init(|| value)
    })
}

/// Number of anchors that a front can name. Half of the numbers are for grid points, half for sources inside
/// cells. See `update/anchor.rs`.
pub(crate) const ANCHORS: usize = 1 << 26;

//! Traces geodesic paths: shortest paths from any place back to the source (paper, section 6.3).
//!
//! A path follows the direction of steepest descent of the arrival time, -G^-1 grad t (eq. 21). Gradients from finite
//! differences mix both sides where wavefronts meet, and are wrong near a source or a corner of a hole. So each step
//! solves a minimisation in place of the gradient, as the solvers do. Among all straight lines across the cell,
//! measured in the cell's own lengths, it takes the line on which the wavefront arrives first (the Hopf-Lax form of eq.
//! 5). Arrival times along the cell's sides come from cubics through the squares of the map's values.
//!
//! Steps are as long as the cells, which bounds their error to second order. A line ends at a grid point
//! where the path bends around the corner of a hole, and at the source if the source lies in the cell. Most
//! lines run on nearly straight: if the straight continuation fits the arrival time, no other line is
//! searched for. Afterwards the path is pulled taut around the corners of holes.
//!
//! Where wavefronts meet, the map's values are too early, and a path from there would run along the cut
//! locus. A path that turns out longer than the map's value is traced again with a map of the surroundings of
//! its start. Over a slowness its vertices first slide to where it costs least.

mod ahead;
mod around;
mod cell;
mod corners;
mod edge_times;
mod entry;
mod first_line;
mod goals;
mod linked_path;
mod place;
mod seams;
mod search;
mod shared_parts;
mod slides;
mod slowed_edge;
mod taut;
mod tracer;
mod walk;

use glam::DVec2;
use rayon::prelude::*;

use super::Curve;
use super::copies::Copies;
use corners::Corners;
pub(super) use first_line::{FirstLine, LineEnd};
use geosweep_surface::shown::exact;
use geosweep_surface::{Chart, EdgeLengths, Source, SourceError, Sources, Surface};
use goals::Goals;
use linked_path::{LinkedPath, SharedParts};
use place::Stuck;
use seams::parts_of_source;
use tracer::Tracer;

/// A shortest path from a place to a source.
#[derive(Clone, Debug, PartialEq)]
pub struct Path {
    /// The path from the start to the source; both ends are exact. The vertices lie on the grid's edges, and
    /// the path is straight between them. If the start is at the source, there is a single vertex. Where the
    /// path passes a seam of a closed surface, two consecutive vertices are the same place of the surface at
    /// different rows and columns.
    pub curve: Curve,
    /// The map's value at the start. Between grid points it is the earliest arrival along a straight line
    /// across the cell.
    pub distance: f64,
    /// The length of the path, measured like the map: in the surface's unit of length, along arcs
    /// ([`geosweep_surface::EdgeRule`]), times the slowness if there is one. The length plus the source's initial value
    /// equals `distance` up to the errors of both.
    pub length: f64,
    /// The index of the source, in the order in which the sources were given.
    pub source: usize,
}

/// The reason why there is no path.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum PathError {
    /// A source does not lie on the surface.
    #[error(transparent)]
    Source(#[from] SourceError),
    /// The number of distances differs from the number of grid points.
    #[error("{found} distances do not fill a grid of {rows} x {cols} points")]
    Shape {
        /// Number of distances.
        found: usize,
        /// Rows of the grid.
        rows: usize,
        /// Columns of the grid.
        cols: usize,
    },
    /// The start lies off the grid.
    #[error(
        "start {},{} lies outside the grid: rows run from 0 to {last_row}, columns from 0 to {last_col}",
        exact(*row),
        exact(*col)
    )]
    Outside {
        /// Row of the start.
        row: f64,
        /// Column of the start.
        col: f64,
        /// The grid's last row.
        last_row: usize,
        /// The grid's last column.
        last_col: usize,
    },
    /// The start lies in a hole.
    #[error(
        "start {row},{col} lies in a hole of the surface (NaN or masked out); move it to a point of the surface"
    )]
    Hole {
        /// Row of the start.
        row: f64,
        /// Column of the start.
        col: f64,
    },
    /// No wavefront reaches the start.
    #[error("start {row},{col} cannot be reached from any source: holes lie between them")]
    Unreachable {
        /// Row of the start.
        row: f64,
        /// Column of the start.
        col: f64,
    },
    /// The map does not lead to a source.
    #[error(
        "the path from {row},{col} gets lost at {lost_row},{lost_col}, where the map does not lead on to a source; it must be the converged map of these sources on this surface"
    )]
    Lost {
        /// Row of the start.
        row: f64,
        /// Column of the start.
        col: f64,
        /// Row where the path ends.
        lost_row: f64,
        /// Column where the path ends.
        lost_col: f64,
    },
}

/// The number of paths that a thread traces together. There are more paths than lanes, so that a lane whose
/// path ends takes another path and does not wait for the longest one.
const TOGETHER: usize = 64;

/// A distance map, prepared for tracing paths.
///
/// All paths that reach the same corner of a hole are identical from there on. This part is traced once and stored for
/// other paths of this call and of later calls. It takes 16 bytes for each cell up to the next corner.
///
/// ```
/// use geosweep::geometry::PathTracer;
/// use geosweep::surface::{EdgeLengths, builtin::Builtin};
/// use geosweep::{Engine, Options, Sources, distance_map};
///
/// let surface = Builtin::Maze.surface(101, 101)?;
/// let sources = Sources::point(0.0, 0.0);
/// let options = Options::default().with_engine(Engine::Cpu);
/// let map = distance_map(&surface, &sources, &options)?;
///
/// let edges = EdgeLengths::new(&surface)?;
/// let paths = PathTracer::new(&surface, &edges, &sources, &map.distances)?;
/// let path = paths.trace([50.5, 48.25])?;
/// assert_eq!(path.curve.vertices.last(), Some(&[0.0, 0.0]));
/// let exact = Builtin::Maze.exact_distance(101, 101, [50.5, 48.25], [0.0, 0.0]).unwrap();
/// assert!((path.length - exact).abs() < 1e-6 * exact);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct PathTracer<'a> {
    surface: &'a Surface,
    tracer: Tracer<'a>,
    /// A place on the first source.
    around: DVec2,
}

impl<'a> PathTracer<'a> {
    /// Prepares a map for tracing. `distances` is the map of these sources on this surface, row-major, as in
    /// [`geosweep_surface::DistanceMap::distances`]. `edges` are the edge lengths of `surface`.
    ///
    /// # Errors
    /// [`PathError::Shape`], [`PathError::Source`].
    pub fn new(
        surface: &'a Surface,
        edges: &'a EdgeLengths<f32>,
        sources: &Sources,
        distances: &[f32],
    ) -> Result<Self, PathError> {
        let chart = surface.chart();
        let Chart { rows, cols } = chart;
        for found in [distances.len(), edges.chart().points()] {
            if found != chart.points() {
                return Err(PathError::Shape { found, rows, cols });
            }
        }
        sources.seeds(surface)?;
        let times = chart.with_border(distances, f32::INFINITY);
        let parts = |own| parts_of_source(surface, own);
        let goals = Goals::new(chart, sources, |point| times[point] < f32::INFINITY, parts);
        let place = |source: &Source| match source {
            Source::Point { at, .. } => Some(*at),
            Source::Curve { vertices, .. } => vertices.first().copied(),
        };
        let around = sources.iter().find_map(place).unwrap_or_default();
        let corners = Corners::new(chart, &times);
        let (start, shared_parts) = (sources.start(), SharedParts::default());
        let seams = Copies::new(edges);
        let tracer =
            Tracer { edges, times, start, goals, corners, shortens: true, shared_parts, seams };
        Ok(Self { surface, tracer, around })
    }

    /// Follows the map alone, like the paths on a device (`geosweep::vulkan::embed::Paths`).
    ///
    /// Where wavefronts meet, the map is too early, and a path from there can run along the cut locus for a
    /// while. Such a path is up to 8e-3 of its length too long on the built-in face at 257 x 257 points.
    /// Without this option, a path that is longer than the map's value is traced again. This takes a small
    /// map of the surroundings of its start and some twenty more paths. On smooth surfaces few paths are
    /// traced again, on rough surfaces many.
    ///
    /// A path along the map is also too long by up to a twentieth of a cell around each corner of a hole.
    /// Without this option it is pulled taut there. Over a slowness, vertices slide along their edges to where the path
    /// costs least, with this option too.
    #[must_use]
    pub fn along_the_map(mut self) -> Self {
        self.tracer.shortens = false;
        // The parts stored so far are taut.
        self.tracer.shared_parts = SharedParts::default();
        self
    }

    /// Traces the path from a place, given as fractional row and column, to its source.
    ///
    /// # Errors
    /// If the place is outside the grid, in a hole or not reached by any source, or the map is not the map of
    /// the sources ([`PathError::Lost`]).
    pub fn trace(&self, start: [f64; 2]) -> Result<Path, PathError> {
        self.trace_some(&[start]).remove(0)
    }

    /// Traces the paths from many places in parallel. The result is in the order of `starts`.
    pub fn trace_all(&self, starts: &[[f64; 2]]) -> Vec<Result<Path, PathError>> {
        // Paths from neighbouring directions run side by side, so that data read for one is in the cache for
        // the next.
        let direction = |&[row, col]: &[f64; 2]| (col - self.around.y).atan2(row - self.around.x);
        let mut order: Vec<(f64, usize)> =
            starts.iter().enumerate().map(|(number, start)| (direction(start), number)).collect();
        order.sort_unstable_by(|(a, i), (b, j)| a.total_cmp(b).then(i.cmp(j)));
        let order: Vec<usize> = order.into_iter().map(|(_, number)| number).collect();
        let trace = |numbers: &[usize]| {
            let starts: Vec<_> = numbers.iter().map(|&number| starts[number]).collect();
            numbers.iter().copied().zip(self.trace_some(&starts)).collect::<Vec<_>>()
        };
        let mut paths: Vec<_> = order.par_chunks(TOGETHER).flat_map_iter(trace).collect();
        paths.sort_unstable_by_key(|(number, _)| *number);
        paths.into_iter().map(|(_, path)| path).collect()
    }

    /// Traces the paths from some places on one thread. The result is in the order of `starts`.
    fn trace_some(&self, starts: &[[f64; 2]]) -> Vec<Result<Path, PathError>> {
        let places: Vec<_> = starts.iter().map(|&start| self.place(start)).collect();
        let there: Vec<_> = places.iter().flatten().copied().collect();
        let mut traces = self.tracer.traces(&there).into_iter();
        places
            .into_iter()
            .map(|place| {
                let DVec2 { x: row, y: col } = place?;
                let trace = traces.next().expect("each place has a trace");
                let trace = trace.map_err(|Stuck(at)| PathError::Lost {
                    row,
                    col,
                    lost_row: at.x,
                    lost_col: at.y,
                })?;
                let trace = self.tracer.slid(trace);
                let trace = if self.tracer.shortens { self.tracer.shortest(trace) } else { trace };
                let LinkedPath { vertices, time, length, source, .. } = trace;
                let vertices = vertices.into_iter().map(|at| at.to_array()).collect();
                let curve = Curve { vertices, closed: false };
                Ok(Path { curve, distance: time, length, source })
            })
            .collect()
    }

    /// Returns the place from which a path starts, if a wavefront reaches it.
    fn place(&self, [row, col]: [f64; 2]) -> Result<DVec2, PathError> {
        let (chart, start) = (self.surface.chart(), DVec2::new(row, col));
        if !chart.holds(start) {
            let (last_row, last_col) = chart.last();
            Err(PathError::Outside { row, col, last_row, last_col })
        } else if !self.surface.contains(start) {
            Err(PathError::Hole { row, col })
        } else if !self.tracer.reaches(start) {
            Err(PathError::Unreachable { row, col })
        } else {
            Ok(start)
        }
    }
}

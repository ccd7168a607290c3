//! The distance map, and the report on how it was computed.

use std::fmt;
use std::time::Duration;

use crate::update::Wavefront;
use crate::{Chart, Real, Resolution, Seam, Unresolved};

/// Geodesic distances from the sources to every grid point, in single precision or in double precision
/// (`geosweep::distance_map_f64`).
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct DistanceMap<R = f32> {
    /// The grid's size.
    pub chart: Chart,
    /// Distances, row-major, in the surface's unit of length (times the slowness, if any). The value is
    /// +infinity at holes and at points that no source reaches.
    pub distances: Vec<R>,
    /// Report on how the map was computed.
    pub report: Report,
}

/// Engine that has computed a map or rows of a matrix.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum UsedEngine {
    /// The CPU, in the order of updates that is best.
    Cpu,
    /// Fast marching on the CPU: updates in the order of time.
    FastMarching,
    /// A Vulkan device.
    Vulkan,
}

impl UsedEngine {
    /// Returns the name of the engine in reports: `cpu`, `fast-marching` or `vulkan`.
    pub fn name(self) -> &'static str {
        match self {
            Self::Cpu => "cpu",
            Self::FastMarching => "fast-marching",
            Self::Vulkan => "vulkan",
        }
    }
}

impl fmt::Display for UsedEngine {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// Report on how a map was computed.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Report {
    /// Engine that computed the map.
    pub engine: UsedEngine,
    /// Name of the Vulkan device.
    pub device: Option<String>,
    /// Reason for the choice of the engine, if the choice was left to the crate.
    pub reason: Option<String>,
    /// Error of the chosen GPU, if it failed and the CPU computed the map instead.
    pub fallback: Option<String>,
    /// Name of the order of updates.
    pub schedule: &'static str,
    /// The wavefront that was assumed inside a triangle.
    pub wavefront: Wavefront,
    /// Number of iterations of four scans.
    pub iterations: u32,
    /// Largest relative change of an arrival time in the last iteration; 1 if that iteration reached a point
    /// for the first time.
    pub residual: f64,
    /// The residual at which the iterations stop.
    pub tolerance: f64,
    /// Whether the residual fell to the tolerance before the iterations ran out.
    pub converged: bool,
    /// Time of the solve itself. On Vulkan it lasts from the first submission to the last fence, without
    /// device creation, upload and read-back.
    pub solve_time: Duration,
    /// Number of points of the surface, without holes.
    pub points: usize,
    /// Number of points with a finite distance.
    pub reached: usize,
    /// Largest finite distance.
    pub max_distance: f64,
    /// Distance after which the map ends, by `geosweep::Options::radius` or `geosweep::Options::targets`. `None`
    /// for a whole map.
    pub ends_at: Option<f64>,
    /// Seams: the places where the surface is closed and the grid is not. Paths across a seam are not found,
    /// and two grid points that are one point of the surface have separate distances.
    pub seams: Vec<Seam>,
    /// Measure of how well the grid resolves the surface ([`crate::Surface::resolution`]). Where the surface
    /// normals turn by tens of degrees from point to point, distances are those of a polyhedron. `None` over
    /// a metric.
    pub resolution: Option<Resolution>,
    /// Where the cells are too skewed for updates ([`crate::Surface::unresolved`]), if anywhere. Distances there may be
    /// late by tens of per cent.
    pub unresolved: Option<Unresolved>,
}

impl Report {
    /// Returns a minimal report on a converged map.
    pub fn new(engine: UsedEngine, wavefront: Wavefront) -> Self {
        Self {
            engine,
            device: None,
            reason: None,
            fallback: None,
            schedule: "",
            wavefront,
            iterations: 0,
            residual: 0.0,
            tolerance: 0.0,
            converged: true,
            solve_time: Duration::ZERO,
            points: 0,
            reached: 0,
            max_distance: f64::NEG_INFINITY,
            ends_at: None,
            seams: Vec::new(),
            resolution: None,
            unresolved: None,
        }
    }
}

impl<R: Real> DistanceMap<R> {
    /// Returns a map of `distances`, row-major, which were computed elsewhere: for instance those that a
    /// renderer has read back. Functions on maps, such as `geosweep::geometry::contours`, take it. All points
    /// of the grid count as points of the surface.
    ///
    /// # Panics
    /// If there are not as many distances as grid points.
    pub fn new(chart: Chart, distances: Vec<R>, report: Report) -> Self {
        assert_eq!(distances.len(), chart.points(), "one distance for each grid point");
        let finite = || distances.iter().map(|distance| distance.wide()).filter(|d| d.is_finite());
        let (reached, max_distance) =
            (finite().count(), finite().fold(f64::NEG_INFINITY, f64::max));
        let report = Report { points: chart.points(), reached, max_distance, ..report };
        Self { chart, distances, report }
    }

    /// Makes a map with a complete report.
    #[doc(hidden)]
    pub fn reported(chart: Chart, distances: Vec<R>, report: Report) -> Self {
        Self { chart, distances, report }
    }

    /// Returns the map with the reason for the choice of its engine.
    #[doc(hidden)]
    #[must_use]
    pub fn because(mut self, reason: String) -> Self {
        self.report.reason = Some(reason);
        self
    }

    /// Returns the distance at a grid point.
    ///
    /// # Panics
    /// If the grid has no such point.
    pub fn distance(&self, row: usize, col: usize) -> R {
        assert!(row < self.chart.rows && col < self.chart.cols, "point outside the grid");
        self.distances[self.chart.index(row, col)]
    }

    /// Returns the map rounded to single precision. Contours, paths and all other functions on maps take maps
    /// in this precision.
    pub fn to_single(&self) -> DistanceMap {
        let distances = self.distances.iter().map(|distance| distance.wide() as f32).collect();
        DistanceMap { chart: self.chart, distances, report: self.report.clone() }
    }
}

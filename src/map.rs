//! The distance map, and how it was computed.

use std::time::Duration;

use crate::surface::{Chart, Real, Resolution, Seam};
use crate::update::Wavefront;

/// Geodesic distances from the sources to every grid point, in single precision or in double
/// ([`crate::distance_map_f64`]).
#[derive(Clone, Debug)]
pub struct DistanceMap<R = f32> {
    /// The grid's size.
    pub chart: Chart,
    /// Distances, row-major, in the surface's unit of length (times the slowness, if any);
    /// +infinity at holes and at points that no source reaches.
    pub distances: Vec<R>,
    /// How the map was computed.
    pub report: Report,
}

/// How a map was computed.
#[derive(Clone, Debug, PartialEq)]
pub struct Report {
    /// `vulkan`, `cpu` or `fast-marching`.
    pub engine: &'static str,
    /// Name of the Vulkan device.
    pub device: Option<String>,
    /// Why this engine, where the choice was left to the crate.
    pub reason: Option<String>,
    /// What kept the GPU that was chosen from computing the map, so that the CPU did.
    pub fallback: Option<String>,
    /// The order of updates.
    pub schedule: &'static str,
    /// The front assumed inside a triangle.
    pub wavefront: Wavefront,
    /// Iterations of four scans.
    pub iterations: u32,
    /// Largest relative change of an arrival time in the last iteration; 1 if a point was
    /// first reached in it.
    pub residual: f64,
    /// What the residual was to come down to.
    pub tolerance: f64,
    /// Whether it did before the iterations ran out.
    pub converged: bool,
    /// Time of the solve itself: on Vulkan from the first submission to the last fence, without
    /// device creation, upload and read-back.
    pub solve_time: Duration,
    /// Points of the surface, without holes.
    pub points: usize,
    /// Points with a finite distance.
    pub reached: usize,
    /// Largest finite distance.
    pub max_distance: f64,
    /// Where the surface is closed and the grid is not. Paths across a seam are not found, and two points
    /// of the grid that are one on the surface have distances of their own.
    pub seams: Vec<Seam>,
    /// How well the grid resolves the surface ([`crate::Surface::resolution`]): where its normals turn by tens of
    /// degrees from point to point, distances are those of a polyhedron. `None` over a metric.
    pub resolution: Option<Resolution>,
}

impl<R: Real> DistanceMap<R> {
    /// Distance at a grid point.
    ///
    /// # Panics
    /// If the grid has no such point.
    pub fn distance(&self, row: usize, col: usize) -> R {
        assert!(row < self.chart.rows && col < self.chart.cols, "point outside the grid");
        self.distances[self.chart.index(row, col)]
    }

    /// The map rounded to single precision, which contours, paths and all else that is made of a map
    /// take.
    pub fn to_single(&self) -> DistanceMap {
        let distances = self.distances.iter().map(|distance| distance.wide() as f32).collect();
        DistanceMap { chart: self.chart, distances, report: self.report.clone() }
    }
}

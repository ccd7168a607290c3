//! Reports how a map was computed.

use std::io;

use geosweep::DistanceMap;
use geosweep::geometry::farthest;
use geosweep::surface::Seam;
use serde::Serialize;

use super::Scene;
use crate::precision::{Number, Precision};
use crate::terminal::print_json;

/// The part of the JSON output that describes the map. Every command on a map prints it.
#[derive(Serialize)]
pub struct MapSummary<'a, R = f32> {
    precision: Precision,
    engine: &'a str,
    device: Option<&'a str>,
    reason: Option<&'a str>,
    fallback: Option<&'a str>,
    schedule: &'a str,
    wavefront: &'a str,
    iterations: u32,
    iteration_bound: Option<u64>,
    residual: f64,
    converged: bool,
    solve_seconds: f64,
    rows: usize,
    cols: usize,
    points: usize,
    reached: usize,
    max_distance: R,
    farthest: Option<[usize; 2]>,
    seams: Vec<String>,
    sharp_edges: Option<f64>,
    unresolved: Option<[usize; 2]>,
}

/// The report in the precision in which the map was computed.
#[derive(Serialize)]
#[serde(untagged)]
pub enum MapReport<'a> {
    Single(MapSummary<'a>),
    Double(MapSummary<'a, f64>),
}

impl<'a> MapReport<'a> {
    /// Reports on a map in single precision, or on the map in double precision from which it was rounded.
    pub fn new(scene: &Scene, map: &'a DistanceMap, double: Option<&'a DistanceMap<f64>>) -> Self {
        match double {
            None => Self::Single(MapSummary::new(scene, map)),
            Some(map) => Self::Double(MapSummary::new(scene, map)),
        }
    }

    /// Prints this report and the results that follow from the map as one JSON object.
    pub fn print(&self, command: &str, results: &impl Serialize) -> io::Result<()> {
        print_json(command, &WithResults { map: self, results })
    }
}

#[derive(Serialize)]
struct WithResults<'a, T> {
    #[serde(flatten)]
    map: &'a MapReport<'a>,
    #[serde(flatten)]
    results: &'a T,
}

impl<'a, R: Number> MapSummary<'a, R> {
    pub fn new(scene: &Scene, map: &'a DistanceMap<R>) -> Self {
        let (report, chart) = (&map.report, scene.chart());
        Self {
            precision: R::PRECISION,
            engine: report.engine.name(),
            device: report.device.as_deref(),
            reason: report.reason.as_deref(),
            fallback: report.fallback.as_deref(),
            schedule: report.schedule,
            wavefront: report.wavefront.name(),
            iterations: report.iterations,
            iteration_bound: scene.surface.iteration_bound(),
            residual: report.residual,
            converged: report.converged,
            solve_seconds: report.solve_time.as_secs_f64(),
            rows: chart.rows,
            cols: chart.cols,
            points: report.points,
            reached: report.reached,
            max_distance: R::of(report.max_distance),
            farthest: farthest(chart, &scene.crop(&map.distances))
                .map(|point| [point.row, point.col]),
            seams: report.seams.iter().map(Seam::to_string).collect(),
            sharp_edges: report.resolution.map(|resolution| resolution.sharp_edges),
            unresolved: report.unresolved.map(|of| [of.row, of.col]),
        }
    }
}

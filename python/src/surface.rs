//! The surface: its constructors, and what is computed on it.

use std::sync::Arc;
use std::sync::atomic::{AtomicU32, Ordering};

use geosweep::geometry::FarthestPoints;
use geosweep::glam::{DVec2, DVec3};
use geosweep::surface::Geometry;
use geosweep::{
    Convergence, DEFAULT_TOLERANCE, DEFAULT_TOLERANCE_F64, DistanceMap, Report, UsedEngine,
    Wavefront,
};
use geosweep::{EdgeRule, MetricTensor, Monitor, Spacing, estimate_error, estimate_error_f64};
use numpy::{
    IntoPyArray, PyArray1, PyArray2, PyReadonlyArray2, PyReadonlyArray3, PyUntypedArrayMethods,
};
use pyo3::prelude::*;
use rayon::prelude::*;

use crate::gluing::Glue;
use crate::map::{Distances, Map, ReportItems, in_either, report};
use crate::on_grid::OnGrid;
use crate::settings::{Line, Problem, sources};
use crate::{arrays, errors, work};

/// A surface, and its edges once they are needed. Maps on the surface share both.
#[pyclass(frozen, module = "geosweep._geosweep")]
pub struct Surface {
    pub inner: Arc<OnGrid>,
}

impl From<geosweep::Surface> for Surface {
    fn from(surface: geosweep::Surface) -> Self {
        Self { inner: Arc::new(OnGrid::new(surface)) }
    }
}

/// Distances in either precision.
#[derive(FromPyObject)]
enum Values<'py> {
    #[pyo3(transparent)]
    Single(PyReadonlyArray2<'py, f32>),
    #[pyo3(transparent)]
    Double(PyReadonlyArray2<'py, f64>),
}

/// The errors of a map, the improved map, and the observed order.
type Estimate<'py> = (Bound<'py, PyAny>, Bound<'py, PyAny>, Option<f64>);

#[pymethods]
impl Surface {
    /// Makes a height field, which keeps and reads the array itself.
    #[staticmethod]
    fn heights(
        py: Python<'_>,
        array: PyReadonlyArray2<'_, f64>,
        dy: f64,
        dx: f64,
    ) -> PyResult<Self> {
        let (rows, cols) = (array.shape()[0], array.shape()[1]);
        let heights = arrays::scalars(&array)?;
        let make =
            || geosweep::Surface::from_shared_heights(rows, cols, heights, Spacing { dx, dy });
        Ok(work::on_points(py, rows * cols, make)?.map_err(errors::value)?.into())
    }

    /// Makes a surface from points (M, N, 3), which keeps and reads the array itself.
    #[staticmethod]
    fn positions(py: Python<'_>, array: PyReadonlyArray3<'_, f64>) -> PyResult<Self> {
        let (rows, cols) = (array.shape()[0], array.shape()[1]);
        let points = arrays::vectors(&array)?;
        let make = || geosweep::Surface::from_shared_positions(rows, cols, points);
        Ok(work::on_points(py, rows * cols, make)?.map_err(errors::value)?.into())
    }

    /// Makes a surface from a metric (M, N, 3): the entries `rr`, `rc` and `cc` of each point's tensor.
    #[staticmethod]
    fn metric(py: Python<'_>, array: PyReadonlyArray3<'_, f64>) -> PyResult<Self> {
        let (rows, cols) = (array.shape()[0], array.shape()[1]);
        let entries = arrays::vectors(&array)?;
        let tensor = |&DVec3 { x: rr, y: rc, z: cc }: &DVec3| MetricTensor { rr, rc, cc };
        let make = || {
            let metric = (*entries).as_ref().iter().map(tensor).collect();
            geosweep::Surface::from_metric(rows, cols, metric)
        };
        Ok(work::on_points(py, rows * cols, make)?.map_err(errors::value)?.into())
    }

    /// Returns the surface with holes, a slowness and a rule for edges.
    fn with_inputs(
        &self,
        mask: Option<PyReadonlyArray2<'_, bool>>,
        slowness: Option<PyReadonlyArray2<'_, f64>>,
        chords: bool,
    ) -> PyResult<Self> {
        let rule = if chords { EdgeRule::Chord } else { EdgeRule::Arc };
        let mut surface = self.inner.surface().clone().with_edge_rule(rule);
        if let Some(mask) = mask {
            let mask: Vec<bool> = mask.as_array().iter().copied().collect();
            surface = surface.with_mask(&mask).map_err(errors::value)?;
        }
        if let Some(slowness) = slowness {
            let slowness: Vec<f64> = slowness.as_array().iter().copied().collect();
            surface = surface.with_slowness(slowness).map_err(errors::value)?;
        }
        Ok(surface.into())
    }

    /// Returns the surface with sides of the grid glued.
    fn with_gluing(&self, py: Python<'_>, glue: Glue) -> PyResult<Self> {
        Ok(work::detached(py, || glue.apply(self.inner.surface().clone()))??.into())
    }

    /// Descriptions of the sides of the grid that coincide, are neighbours or are one point, and are not
    /// glued.
    #[getter]
    fn seams(&self, py: Python<'_>) -> PyResult<Vec<String>> {
        let seams = work::detached(py, || self.inner.surface().seams())?;
        Ok(seams.iter().map(ToString::to_string).collect())
    }

    #[getter]
    fn is_glued(&self) -> bool {
        self.inner.surface().is_glued()
    }

    #[getter]
    fn shape(&self) -> (usize, usize) {
        self.inner.shape()
    }

    #[getter]
    fn points(&self) -> usize {
        self.inner.surface().points()
    }

    #[getter]
    fn is_floor_plan(&self, py: Python<'_>) -> PyResult<bool> {
        work::detached(py, || self.inner.surface().is_floor_plan())
    }

    #[getter]
    fn edges(&self) -> &'static str {
        match self.inner.surface().edge_rule() {
            EdgeRule::Arc => "arc",
            EdgeRule::Chord => "chord",
        }
    }

    /// Kind of the geometry: heights, positions or metric.
    #[getter]
    fn kind(&self) -> &'static str {
        match self.inner.surface().geometry() {
            Geometry::Heights { .. } => "heights",
            Geometry::Positions(_) => "positions",
            Geometry::Metric(_) => "metric",
        }
    }

    /// A copy of the heights, of the coordinates x, y, z of each point, or of the metric's three entries,
    /// row-major.
    fn values<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        let values = match self.inner.surface().geometry() {
            Geometry::Heights { heights, .. } => heights.to_vec(),
            Geometry::Positions(points) => points.iter().flat_map(DVec3::to_array).collect(),
            Geometry::Metric(metric) => {
                metric.iter().flat_map(|it| [it.rr, it.rc, it.cc]).collect()
            }
        };
        values.into_pyarray(py)
    }

    /// The distance between rows and the distance between columns, for heights.
    #[getter]
    fn spacing(&self) -> Option<(f64, f64)> {
        match self.inner.surface().geometry() {
            Geometry::Heights { spacing, .. } => Some((spacing.dy, spacing.dx)),
            _ => None,
        }
    }

    /// Whether each point is present, as a view.
    #[getter]
    fn present(self_: Bound<'_, Self>) -> PyResult<Bound<'_, PyArray2<bool>>> {
        let inner = self_.get().inner.clone();
        // SAFETY: the surface is never changed, and the array keeps it.
        unsafe { arrays::view(inner.shape(), inner.surface().present(), self_.into_any()) }
    }

    /// The slowness, as a view.
    #[getter]
    fn slowness(self_: Bound<'_, Self>) -> PyResult<Option<Bound<'_, PyArray2<f64>>>> {
        let inner = self_.get().inner.clone();
        let Some(slowness) = inner.surface().slowness() else { return Ok(None) };
        // SAFETY: the surface is never changed, and the array keeps it.
        unsafe { arrays::view(inner.shape(), slowness, self_.into_any()).map(Some) }
    }

    /// Computes a map.
    fn solve(
        &self,
        py: Python<'_>,
        problem: Problem<'_>,
        progress: Option<Py<PyAny>>,
    ) -> PyResult<Map> {
        let sources = problem.sources()?;
        let distances = self.distances_of(py, &sources, &problem, progress)?;
        Ok(Map::new(self.inner.clone(), sources, distances))
    }

    /// Returns whether each place (n, 2) lies on the surface, within the grid and off holes.
    fn have_points<'py>(
        &self,
        py: Python<'py>,
        places: PyReadonlyArray2<'py, f64>,
    ) -> PyResult<Bound<'py, PyArray1<bool>>> {
        let places: Vec<_> =
            places.as_array().rows().into_iter().map(|at| DVec2::new(at[0], at[1])).collect();
        let surface = self.inner.surface();
        let find = || places.par_iter().map(|&at| surface.contains(at)).collect::<Vec<_>>();
        Ok(work::on_points(py, places.len(), find)?.into_pyarray(py))
    }

    /// Returns a map of distances (M, N) that were computed before.
    fn restored(&self, problem: Problem<'_>, distances: Values<'_>) -> PyResult<Map> {
        let chart = self.inner.surface().chart();
        let report = Report::new(UsedEngine::Cpu, Wavefront::Curved);
        macro_rules! restored {
            ($precision:ident, $distances:expr) => {{
                if $distances.shape() != [chart.rows, chart.cols] {
                    return Err(errors::value("the distances do not have the surface's shape"));
                }
                let distances = $distances.as_array().iter().copied().collect();
                Distances::$precision(DistanceMap::new(chart, distances, report))
            }};
        }
        let distances = match distances {
            Values::Single(distances) => restored!(Single, distances),
            Values::Double(distances) => restored!(Double, distances),
        };
        Ok(Map::new(self.inner.clone(), problem.sources()?, distances))
    }

    /// Computes only the distances, in an array that belongs to the caller, and the report.
    fn distances<'py>(
        &self,
        py: Python<'py>,
        problem: Problem<'_>,
        progress: Option<Py<PyAny>>,
    ) -> PyResult<(Bound<'py, PyAny>, ReportItems)> {
        let (sources, shape) = (problem.sources()?, self.inner.shape());
        Ok(in_either!(self.distances_of(py, &sources, &problem, progress)?, map => {
            let items = report(&map.report);
            (arrays::handed_over(py, shape, map.distances)?.into_any(), items)
        }))
    }

    /// Estimates the error of a map.
    fn error<'py>(&self, py: Python<'py>, problem: Problem<'_>) -> PyResult<Estimate<'py>> {
        let (sources, shape) = (problem.sources()?, self.inner.shape());
        let (monitor, surface) = (Monitor::default(), self.inner.surface());
        let Problem(_, _, settings, double) = &problem;
        let options = settings.options(&monitor)?;
        macro_rules! estimated {
            ($estimate:ident) => {{
                let work = || $estimate(surface, &sources, &options);
                let found = work::watched(py, settings.threads, &monitor, |_| Ok(()), work)?;
                let found = found.map_err(errors::of)?;
                let errors = arrays::handed_over(py, shape, found.errors)?.into_any();
                let better = arrays::handed_over(py, shape, found.extrapolated)?.into_any();
                Ok((errors, better, found.observed_order))
            }};
        }
        if *double { estimated!(estimate_error_f64) } else { estimated!(estimate_error) }
    }

    /// Returns `count` samples, each the point farthest from the sources and the samples before it, and the covering
    /// radius.
    fn farthest_points(
        &self,
        py: Python<'_>,
        points: PyReadonlyArray2<'_, f64>,
        lines: Vec<Line<'_>>,
        count: usize,
    ) -> PyResult<(Vec<(usize, usize)>, f32)> {
        let sources = sources(&points, &lines)?;
        let sampled = work::stoppable(py, |monitor| {
            let inner = &self.inner;
            let mut samples = FarthestPoints::new(inner.surface(), inner.edges()?, &sources)?;
            let wanted = samples.by_ref().take(count).take_while(|_| !monitor.is_cancelled());
            let found = wanted.map(|at| (at.row, at.col)).collect();
            Ok((found, samples.radius()))
        })?;
        sampled.map_err(errors::of)
    }
}

impl Surface {
    fn distances_of(
        &self,
        py: Python<'_>,
        sources: &geosweep::Sources,
        Problem(_, _, settings, double): &Problem<'_>,
        progress: Option<Py<PyAny>>,
    ) -> PyResult<Distances> {
        let monitor = Monitor::default();
        let (options, solver) = (settings.options(&monitor)?, &self.inner.solver);
        let tolerance = settings.tolerance.unwrap_or(match double {
            true => DEFAULT_TOLERANCE_F64,
            false => DEFAULT_TOLERANCE,
        });
        let most = AtomicU32::new(0);
        let tell = |py: Python<'_>| {
            let Some(progress) = &progress else { return Ok(()) };
            let done = share_done(monitor.progress(), tolerance, settings.iterations);
            let done = most.fetch_max(done, Ordering::Relaxed).max(done);
            progress.call1(py, (done, ALL_DONE)).map(drop)
        };
        let solve = || match double {
            true => solver.distance_map_f64(sources, &options).map(Distances::Double),
            false => solver.distance_map(sources, &options).map(Distances::Single),
        };
        let (rows, cols) = self.inner.shape();
        let threads = settings.threads;
        let solved = work::watched_on_points(py, rows * cols, threads, &monitor, tell, solve)?;
        let solved = solved.map_err(errors::of)?;
        if let Some(progress) = &progress {
            progress.call1(py, (ALL_DONE, ALL_DONE))?;
        }
        Ok(solved)
    }
}

/// Share of a map that is complete, as callbacks count it.
const ALL_DONE: u32 = 100;

/// Returns the share of a map that is done: how far the change of an iteration has fallen towards the tolerance, on a
/// logarithmic scale, or the share of the largest number of iterations. It stays below [`ALL_DONE`].
fn share_done(now: Convergence, tolerance: f64, iterations: Option<u32>) -> u32 {
    let fallen = match now.residual {
        _ if now.iterations == 0 => 0.0,
        residual => residual.max(f64::MIN_POSITIVE).ln() / tolerance.max(f64::MIN_POSITIVE).ln(),
    };
    let of_iterations =
        iterations.map_or(0.0, |most| f64::from(now.iterations) / f64::from(most.max(1)));
    let share = f64::from(ALL_DONE) * fallen.max(of_iterations);
    // An infinite change or a tolerance of 1 makes no share.
    (share.clamp(0.0, f64::from(ALL_DONE - 1))) as u32
}

//! The map: distances, and geometry from them.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::fmt::Display;
use std::sync::Arc;

use geosweep::geometry::{
    Contour, Levels, MapError, PathTracer, Side, Voronoi, contours, farthest, offset_curves, ridges,
};
use geosweep::surface::EdgeLengths;
use geosweep::{DistanceMap, Report, Sources};
use numpy::{PyArray1, PyArray2, ToPyArray};
use pyo3::IntoPyObjectExt;
use pyo3::prelude::*;

use crate::on_grid::OnGrid;
use crate::{arrays, errors, work};

/// A map in either precision.
pub enum Distances {
    Single(DistanceMap<f32>),
    Double(DistanceMap<f64>),
}

/// Evaluates an expression for a map of either precision.
macro_rules! in_either {
    ($distances:expr, $map:ident => $value:expr) => {
        match $distances {
            $crate::map::Distances::Single($map) => $value,
            $crate::map::Distances::Double($map) => $value,
        }
    };
}
pub(crate) use in_either;

/// The number of paths that are traced between two checks for Ctrl-C. They take tens of milliseconds on large grids.
const PATHS_AT_ONCE: usize = 256;

/// The entries of a report.
pub type ReportItems = BTreeMap<&'static str, Py<PyAny>>;

/// Returns the entries of a report.
pub fn report(report: &Report) -> ReportItems {
    Python::attach(|py| {
        let mut items = ReportItems::new();
        macro_rules! add {
            ($($name:ident: $value:expr),* $(,)?) => {
                // Numbers, texts and None always convert.
                $(items.insert(stringify!($name), $value.into_py_any(py).expect("a plain value"));)*
            };
        }
        add! {
            engine: report.engine.name(), device: report.device.clone(),
            reason: report.reason.clone(), fallback: report.fallback.clone(),
            schedule: report.schedule, wavefront: report.wavefront.to_string(),
            iterations: report.iterations, residual: report.residual,
            tolerance: report.tolerance, converged: report.converged,
            solve_seconds: report.solve_time.as_secs_f64(), points: report.points,
            reached: report.reached, max_distance: report.max_distance,
            unresolved: report.unresolved.map(|of| (of.row, of.col)),
        }
        items
    })
}

/// A distance map, with its surface and its sources.
#[pyclass(frozen, module = "geosweep._geosweep")]
pub struct Map {
    pub on: Arc<OnGrid>,
    pub sources: Sources,
    pub distances: Distances,
}

impl Map {
    pub fn new(on: Arc<OnGrid>, sources: Sources, distances: Distances) -> Self {
        Self { on, sources, distances }
    }

    /// Returns the map in single precision, in which geometry is computed.
    pub fn single(&self) -> Cow<'_, DistanceMap> {
        match &self.distances {
            Distances::Single(map) => Cow::Borrowed(map),
            Distances::Double(map) => Cow::Owned(map.to_single()),
        }
    }

    /// Runs `read` on the edges of the surface and on the map in single precision, without the interpreter's lock.
    pub fn read<T: Send, E: Display>(
        &self,
        py: Python<'_>,
        read: impl FnOnce(&EdgeLengths<f32>, &DistanceMap) -> Result<T, E> + Send,
    ) -> PyResult<T> {
        let found = work::detached(py, || {
            let edges = self.on.edges().map_err(|error| error.to_string())?;
            read(edges, &self.single()).map_err(|error| error.to_string())
        })?;
        found.map_err(errors::value)
    }
}

/// Curves as arrays (n, 2).
type Curves<'py> = Vec<Bound<'py, PyArray2<f64>>>;
/// The region of each point, the borders (the regions on either side and the curve), and the area of each region.
type Regions<'py> =
    (Bound<'py, PyArray2<i32>>, Vec<([u32; 2], Bound<'py, PyArray2<f64>>)>, Vec<f64>);

/// Hands contours over: each level, with its curves.
fn levelled<'py>(py: Python<'py>, contours: &[Contour]) -> PyResult<Vec<(f64, Curves<'py>)>> {
    let curves = |contour: &Contour| {
        contour.curves.iter().map(|curve| arrays::curve(py, curve)).collect::<PyResult<_>>()
    };
    contours.iter().map(|contour| Ok((contour.level, curves(contour)?))).collect()
}

#[pymethods]
impl Map {
    /// The distances, as a view.
    #[getter]
    fn distance(self_: Bound<'_, Self>) -> PyResult<Bound<'_, PyAny>> {
        let (map, owner) = (self_.get(), self_.clone().into_any());
        let shape = map.on.shape();
        // SAFETY: the map is never changed, and the array keeps it.
        Ok(in_either!(&map.distances, map => unsafe {
            arrays::view(shape, &map.distances, owner)?.into_any()
        }))
    }

    #[getter]
    fn report(&self) -> ReportItems {
        in_either!(&self.distances, map => report(&map.report))
    }

    /// Returns the path from each end to its source: its vertices, length and source.
    #[expect(clippy::type_complexity, reason = "one use")]
    fn paths<'py>(
        &self,
        py: Python<'py>,
        ends: Vec<[f64; 2]>,
    ) -> PyResult<Vec<(Bound<'py, PyArray2<f64>>, f64, usize)>> {
        let traced = work::stoppable(py, |monitor| {
            let map = self.single();
            let edges = self.on.edges().map_err(|error| error.to_string())?;
            let tracer = PathTracer::new(self.on.surface(), edges, &self.sources, &map.distances);
            let tracer = tracer.map_err(|error| error.to_string())?;
            let parts = ends.chunks(PATHS_AT_ONCE).take_while(|_| !monitor.is_cancelled());
            let paths = parts.flat_map(|part| tracer.trace_all(part));
            paths.collect::<Result<Vec<_>, _>>().map_err(|error| error.to_string())
        })?;
        traced
            .map_err(errors::value)?
            .iter()
            .map(|path| Ok((arrays::curve(py, &path.curve)?, path.length, path.source)))
            .collect()
    }

    /// Returns the curves of each level.
    fn contours<'py>(
        &self,
        py: Python<'py>,
        levels: Vec<f64>,
    ) -> PyResult<Vec<(f64, Curves<'py>)>> {
        let found = work::detached(py, || {
            let map = self.single();
            let levels = Levels::List(levels).on(&map, &self.sources)?;
            Ok::<_, geosweep::geometry::LevelError>(contours(&map, &self.sources, &levels))
        })?;
        levelled(py, &found.map_err(errors::value)?)
    }

    /// Returns evenly spaced levels, or levels `step` apart.
    fn levels(&self, count: Option<usize>, step: Option<f64>) -> PyResult<Vec<f64>> {
        let levels = match (count, step) {
            (_, Some(step)) => Levels::Spacing(step),
            (count, None) => Levels::Count(count.unwrap_or(10)),
        };
        levels.on(&self.single(), &self.sources).map_err(errors::value)
    }

    /// Returns the curves of each level on one side of the sources.
    fn offsets<'py>(
        &self,
        py: Python<'py>,
        levels: Vec<f64>,
        left: bool,
    ) -> PyResult<Vec<(f64, Curves<'py>)>> {
        let side = if left { Side::Left } else { Side::Right };
        let found = self.read(py, |edges, map| {
            offset_curves(self.on.surface(), edges, &self.sources, map, &levels, side)
        })?;
        levelled(py, &found)
    }

    /// Returns the regions of the sources. `merged` holds the number of the region of each source, and the number of
    /// regions, if sources share regions.
    fn voronoi<'py>(
        &self,
        py: Python<'py>,
        merged: Option<(Vec<u32>, usize)>,
    ) -> PyResult<Regions<'py>> {
        let surface = self.on.surface();
        let (areas, found) = self.read(py, |edges, map| {
            let found = Voronoi::new(surface, edges, &self.sources, &map.distances)?;
            let found = match &merged {
                Some((numbers, regions)) => found.merged(numbers, *regions),
                None => found,
            };
            Ok::<_, MapError>((found.areas(surface), found))
        })?;
        let borders = found.borders.iter();
        let borders = borders.map(|it| Ok((it.regions, arrays::curve(py, &it.curve)?)));
        let borders = borders.collect::<PyResult<_>>()?;
        Ok((arrays::labels(py, self.on.shape(), &found.labels)?, borders, areas))
    }

    /// Returns the ridges: each curve, and the angle at each of its vertices.
    #[expect(clippy::type_complexity, reason = "one use")]
    fn ridges<'py>(
        &self,
        py: Python<'py>,
        least_angle: f64,
    ) -> PyResult<Vec<(Bound<'py, PyArray2<f64>>, Bound<'py, PyArray1<f64>>)>> {
        self.read(py, |edges, map| ridges(edges, &map.distances, least_angle))?
            .iter()
            .map(|ridge| {
                let mut angles = ridge.angles.clone();
                if ridge.curve.closed {
                    angles.extend(ridge.angles.first());
                }
                Ok((arrays::curve(py, &ridge.curve)?, angles.to_pyarray(py)))
            })
            .collect()
    }

    /// Returns row, column and distance of the farthest point.
    fn farthest(&self, py: Python<'_>) -> PyResult<Option<(usize, usize, f64)>> {
        work::detached(py, || {
            in_either!(&self.distances, map => {
                let found = farthest(map.chart, &map.distances)?;
                Some((found.row, found.col, geosweep::surface::Real::wide(found.distance)))
            })
        })
    }
}

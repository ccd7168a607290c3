//! Directions on a map, nearest sources, log maps and signed distances.

use std::sync::Arc;

use geosweep::geometry::{BackDirections, Nearest, signed_distances, signed_distances_by_mask};
use numpy::{PyArray2, PyArray3, PyReadonlyArray2};
use pyo3::prelude::*;

use crate::map::{Map, in_either};
use crate::on_grid::OnGrid;
use crate::{arrays, errors, work};

/// The index of the nearest source of each point, and the place on it.
type NearestItems<'py> = (Bound<'py, PyArray2<i32>>, Bound<'py, PyArray3<f64>>);

/// Returns the nearest source of each point, and the place on it (M, N, 2).
#[pyfunction]
pub fn nearest<'py>(py: Python<'py>, map: &Map) -> PyResult<NearestItems<'py>> {
    let found = work::stoppable(py, |monitor| {
        let edges = map.on.edges().map_err(|error| error.to_string())?;
        let distances = &map.single().distances;
        let found = Nearest::watched(map.on.surface(), edges, &map.sources, distances, monitor);
        found.map_err(|error| error.to_string())
    })?;
    let found = found.map_err(errors::value)?;
    let shape = map.on.shape();
    let places = arrays::vectors_handed_over(py, shape, found.places)?;
    Ok((arrays::handed_over(py, shape, found.sources)?, places))
}

/// Runs `read` on the ways back.
fn on_ways<T: Send>(
    py: Python<'_>,
    map: &Map,
    read: impl FnOnce(&BackDirections<'_>) -> T + Send,
) -> PyResult<T> {
    map.read(py, |edges, single| {
        BackDirections::new(map.on.surface(), edges, &map.sources, &single.distances)
            .map(|ways| read(&ways))
    })
}

/// Returns the way back at each point: a bearing (M, N), or a vector in the grid (M, N, 2) or in space
/// (M, N, 3).
#[pyfunction]
pub fn back_direction<'py>(py: Python<'py>, map: &Map, unit: &str) -> PyResult<Bound<'py, PyAny>> {
    let shape = map.on.shape();
    Ok(match unit {
        "grid" => {
            let ways = on_ways(py, map, |ways| ways.in_chart())?;
            arrays::vectors_handed_over(py, shape, ways)?.into_any()
        }
        "space" => {
            let ways = on_ways(py, map, |ways| ways.in_space())?.ok_or_else(|| {
                errors::value("unit='space' needs a surface of heights or positions, not a metric")
            })?;
            arrays::vectors_handed_over(py, shape, ways)?.into_any()
        }
        "grass" => {
            arrays::handed_over(py, shape, on_ways(py, map, |ways| ways.grass())?)?.into_any()
        }
        _ => arrays::handed_over(py, shape, on_ways(py, map, |ways| ways.compass())?)?.into_any(),
    })
}

/// Returns the code of the next grid point on the way back.
#[pyfunction]
pub fn back_link<'py>(py: Python<'py>, map: &Map) -> PyResult<Bound<'py, PyArray2<i8>>> {
    let links = on_ways(py, map, |ways| ways.links())?;
    arrays::handed_over(py, map.on.shape(), links)
}

/// Returns signed distances, negative inside the sources' closed curves, or where the mask `inside` is true.
#[pyfunction]
pub fn signed<'py>(
    py: Python<'py>,
    map: &Map,
    inside: Option<PyReadonlyArray2<'py, bool>>,
) -> PyResult<Bound<'py, PyAny>> {
    let inside: Option<Vec<bool>> = inside.map(|mask| mask.as_array().iter().copied().collect());
    let (chart, shape) = (map.on.surface().chart(), map.on.shape());
    Ok(in_either!(&map.distances, values => {
        let found = work::detached(py, || match &inside {
            Some(inside) => signed_distances_by_mask(chart, &values.distances, inside),
            None => signed_distances(map.on.surface(), &map.sources, &values.distances),
        })?;
        arrays::handed_over(py, shape, found.map_err(errors::value)?)?.into_any()
    }))
}

/// The place of each point in the tangent plane of its source.
#[pyclass(frozen, module = "geosweep._geosweep")]
pub struct LogMap {
    on: Arc<OnGrid>,
    inner: geosweep::geometry::LogMap,
}

/// The axes of a log map at a source: the source's place, the axes u and v in rows and columns, and both axes in
/// space.
type Basis = ([f64; 2], [f64; 2], [f64; 2], Option<[[f64; 3]; 2]>);

/// Computes the log map.
#[pyfunction]
pub fn log_map(py: Python<'_>, map: &Map) -> PyResult<LogMap> {
    use geosweep::geometry::LogMapError;
    let made = work::stoppable(py, |monitor| {
        geosweep::geometry::LogMap::watched(map.on.surface(), &map.sources, monitor)
    })?;
    let inner = made.map_err(|error| match error {
        LogMapError::Surface(error) => errors::of(error.into()),
        LogMapError::Source(error) => errors::of(error.into()),
        LogMapError::Cancelled(error) => errors::of(error.into()),
        error => errors::value(error),
    })?;
    Ok(LogMap { on: map.on.clone(), inner })
}

#[pymethods]
impl LogMap {
    /// Coordinates (M, N, 2).
    #[getter]
    fn coordinates<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray3<f32>>> {
        arrays::vectors_handed_over(py, self.on.shape(), self.inner.coordinates.clone())
    }

    /// The nearest source of each point; -1 where there is none.
    #[getter]
    fn labels<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<i32>>> {
        arrays::labels(py, self.on.shape(), &self.inner.labels)
    }

    #[getter]
    fn bases(&self) -> Vec<Basis> {
        self.inner.bases.iter().map(|basis| (basis.at, basis.u, basis.v, basis.in_space)).collect()
    }

    /// Returns the bearing in which each point's path leaves its source.
    fn source_direction<'py>(
        &self,
        py: Python<'py>,
        unit: &str,
    ) -> PyResult<Bound<'py, PyArray2<f32>>> {
        let bearings = work::detached(py, || match unit {
            "grass" => self.inner.source_grass(self.on.surface()),
            _ => self.inner.source_compass(self.on.surface()),
        })?;
        arrays::handed_over(py, self.on.shape(), bearings)
    }

    /// Returns the row and column of the point with these coordinates in the tangent plane of a source.
    fn place(&self, source: usize, coordinates: [f64; 2]) -> PyResult<Option<[f64; 2]>> {
        let sources = self.inner.bases.len();
        if source >= sources {
            return Err(errors::value(format!(
                "source={source} is unknown; sources are 0 to {}",
                sources - 1
            )));
        }
        Ok(self.inner.place(source, coordinates))
    }
}

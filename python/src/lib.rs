//! The compiled part of the package `geosweep` for Python. It converts arrays, releases the interpreter's
//! lock and turns errors into exceptions; all else is in the library. The Python part checks arguments
//! and describes them (`geosweep/*.py`).

mod arrays;
mod completed;
mod directions;
mod errors;
mod gluing;
mod map;
mod on_grid;
mod pairs;
mod pairwise;
mod settings;
mod surface;
mod work;

use geosweep::glam::DVec2;
use geosweep::surface::{Chart, Source};
use geosweep_crs::{CoordinateSystem, Georeference, MapScale, SystemUnits};
use numpy::{PyArray2, PyReadonlyArray2, PyUntypedArrayMethods};
use pyo3::prelude::*;

/// A Vulkan device: its index, name, kind, Vulkan version and driver, and what it lacks.
type Device = (usize, String, &'static str, String, String, Vec<String>);

/// Lists no devices: this build has no Vulkan engine.
#[cfg(not(feature = "vulkan"))]
#[pyfunction]
fn devices() -> Vec<Device> {
    Vec::new()
}

/// Lists the Vulkan devices of this machine.
#[cfg(feature = "vulkan")]
#[pyfunction]
fn devices(py: Python<'_>) -> PyResult<Vec<Device>> {
    use geosweep::vulkan::VulkanError::{NoDevice, NoLoader};
    match work::detached(py, geosweep::vulkan::devices)? {
        Ok(found) => Ok(found
            .into_iter()
            .map(|it| (it.index, it.name, it.kind, it.api_version, it.driver, it.unmet))
            .collect()),
        Err(NoLoader(_) | NoDevice) => Ok(Vec::new()),
        Err(error) => Err(errors::of(error.into())),
    }
}

/// Returns the projection and the least and largest scale of the map with this number in the EPSG register, if that
/// differs from 1. A grid is given by x and y of its first point, its steps, rows and columns.
#[pyfunction]
fn map_scale(
    epsg: u16,
    place: (f64, f64, f64, f64, usize, usize),
) -> Option<(&'static str, f64, f64)> {
    let (x, y, dx, dy, rows, cols) = place;
    let system = Some(CoordinateSystem::Projected(epsg));
    let place = Georeference { origin: [x, y], down: [0.0, -dy], right: [dx, 0.0], system };
    let MapScale { projection, range: [least, largest] } = place.map_scale(Chart { rows, cols })?;
    Some((projection, least, largest))
}

/// The zero of a level set: grid points, and curves as arrays (n, 2) of rows and columns.
type Zero<'py> = (Vec<[f64; 2]>, Vec<Bound<'py, PyArray2<f64>>>);

/// Returns the zero of a level set. NaN is missing.
#[pyfunction]
fn level_set<'py>(py: Python<'py>, values: PyReadonlyArray2<'py, f64>) -> PyResult<Zero<'py>> {
    let chart = Chart { rows: values.shape()[0], cols: values.shape()[1] };
    let values = arrays::scalars(&values)?;
    let find = || geosweep::geometry::level_set(chart, (*values).as_ref());
    let sources = work::on_points(py, chart.points(), find)?.map_err(errors::value)?;
    let (mut points, mut curves) = (Vec::new(), Vec::new());
    for source in sources.iter() {
        match source {
            Source::Point { at, .. } => points.push(at.to_array()),
            Source::Curve { vertices, .. } => {
                let numbers = vertices.iter().flat_map(DVec2::to_array).collect();
                curves.push(arrays::handed_over(py, (vertices.len(), 2), numbers)?);
            }
        }
    }
    Ok((points, curves))
}

/// Returns whether the coordinates of a reference system are angles, and the units of its map and of its heights in
/// metres, or `None` for texts that are not understood.
#[pyfunction]
fn units_of_system(text: &str) -> Option<(bool, Option<f64>, Option<f64>)> {
    let SystemUnits { are_angles, length, height } = SystemUnits::parse(text)?;
    Some((are_angles, length, height))
}

#[pymodule(gil_used = false)]
fn _geosweep(module: &Bound<'_, PyModule>) -> PyResult<()> {
    // Programs compute one map after another, and opening a device takes longer than most maps.
    #[cfg(feature = "vulkan")]
    geosweep::vulkan::keep_devices(true);
    module.add("__version__", env!("CARGO_PKG_VERSION"))?;
    module.add_class::<surface::Surface>()?;
    module.add_class::<completed::CompletedGrid>()?;
    module.add_class::<map::Map>()?;
    module.add_class::<directions::LogMap>()?;
    module.add_function(wrap_pyfunction!(devices, module)?)?;
    module.add_function(wrap_pyfunction!(map_scale, module)?)?;
    module.add_function(wrap_pyfunction!(level_set, module)?)?;
    module.add_function(wrap_pyfunction!(units_of_system, module)?)?;
    module.add_function(wrap_pyfunction!(directions::nearest, module)?)?;
    module.add_function(wrap_pyfunction!(directions::back_direction, module)?)?;
    module.add_function(wrap_pyfunction!(directions::back_link, module)?)?;
    module.add_function(wrap_pyfunction!(directions::log_map, module)?)?;
    module.add_function(wrap_pyfunction!(directions::signed, module)?)?;
    module.add_function(wrap_pyfunction!(pairs::within, module)?)?;
    module.add_function(wrap_pyfunction!(pairs::nearest_others, module)?)?;
    module.add_function(wrap_pyfunction!(pairwise::pairwise, module)?)?;
    module.add_function(wrap_pyfunction!(pairwise::canonical, module)?)
}

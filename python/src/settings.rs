//! Converts sources and options.

use geosweep::{Engine, Monitor, Options, Sources, Targets, Wavefront};
use numpy::{PyReadonlyArray2, PyUntypedArrayMethods};
use pyo3::prelude::*;

use crate::errors;

/// Options of a solve, as the Python part passes them.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub struct Settings {
    engine: String,
    device: Option<String>,
    wavefront: Option<String>,
    pub tolerance: Option<f64>,
    pub iterations: Option<u32>,
    pub threads: Option<usize>,
    radius: Option<f64>,
    targets: Option<Vec<[usize; 2]>>,
    /// Number of targets whose distances are needed; `None` for all.
    needed: Option<usize>,
}

impl Settings {
    /// Returns the library's options, with a monitor.
    pub fn options(&self, monitor: &Monitor) -> PyResult<Options> {
        let engine = match &*self.engine {
            "gpu" => self.device_engine()?,
            "cpu" => Engine::Cpu,
            _ => Engine::Auto,
        };
        let targets = self.targets.clone().map(|targets| match self.needed {
            Some(needed) => Targets::nearest(needed, targets),
            None => Targets::all(targets),
        });
        let wavefront = self.wavefront.as_deref().map(str::parse::<Wavefront>).transpose();
        Ok(Options::default()
            .with_engine(engine)
            .with_wavefront(wavefront.map_err(errors::value)?)
            .with_tolerance(self.tolerance)
            .with_iterations(self.iterations)
            .with_radius(self.radius)
            .with_targets(targets)
            .with_monitor(monitor.clone()))
    }

    /// Returns whether a device was asked for.
    pub fn are_for_device(&self) -> bool {
        self.engine == "gpu"
    }

    #[cfg(feature = "vulkan")]
    fn device_engine(&self) -> PyResult<Engine> {
        use geosweep::DeviceChoice;
        let named = self.device.as_ref().and_then(|name| name.parse().ok());
        Ok(Engine::Vulkan(named.unwrap_or(DeviceChoice::Any)))
    }

    #[cfg(not(feature = "vulkan"))]
    fn device_engine(&self) -> PyResult<Engine> {
        let device = self.device.as_deref().map(|name| format!(" for {name}")).unwrap_or_default();
        Err(errors::value(format!(
            "this build of geosweep has no Vulkan engine{device}; leave engine=\"gpu\" out"
        )))
    }
}

/// A line's vertices (n, 2), and the start time along it.
pub type Line<'py> = (PyReadonlyArray2<'py, f64>, f64);

/// Inputs of a map: points, lines, options, and whether the map is in double precision.
#[derive(FromPyObject)]
pub struct Problem<'py>(pub PyReadonlyArray2<'py, f64>, pub Vec<Line<'py>>, pub Settings, pub bool);

impl Problem<'_> {
    pub fn sources(&self) -> PyResult<Sources> {
        sources(&self.0, &self.1)
    }
}

/// Returns sources from `lines` and from `points`, whose rows are (row, col, start).
pub fn sources(points: &PyReadonlyArray2<'_, f64>, lines: &[Line<'_>]) -> PyResult<Sources> {
    let mut sources = Sources::default();
    if points.shape()[1] != 3 {
        return Err(errors::value("points need a row, a column and a start"));
    }
    for point in points.as_array().rows() {
        sources = sources.and_point(point[0], point[1], point[2]);
    }
    for (vertices, start) in lines {
        if vertices.shape()[1] != 2 {
            return Err(errors::value("vertices need a row and a column"));
        }
        let vertices = vertices.as_array();
        sources = sources.and_curve(vertices.rows().into_iter().map(|at| [at[0], at[1]]), *start);
    }
    Ok(sources)
}

//! All pairs of points, and canonical forms.

use std::sync::atomic::{AtomicUsize, Ordering};

use geosweep::geometry::canonical::{Distances, FormOptions, canonical_form};
use geosweep::pairwise::Pairwise;
use geosweep::{Error, Monitor};
use numpy::{IntoPyArray, PyArray1};
use numpy::{PyArray2, PyReadonlyArray2, PyReadwriteArray2, PyUntypedArrayMethods};
use pyo3::prelude::*;

use crate::settings::Settings;
use crate::surface::Surface;
use crate::{arrays, errors, work};

/// The largest number of iterations of a map, the residual, whether all maps converged, and the engine.
type PairwiseItems = (u32, f64, bool, &'static str);
/// The coordinates, the indices of the points, the stress, and whether the stress converged.
type Form<'py> = (Bound<'py, PyArray2<f64>>, Bound<'py, PyArray1<i64>>, f64, bool);

/// Computes rows of the matrix into `out` (k, M N).
#[pyfunction]
pub fn pairwise(
    py: Python<'_>,
    surface: &Surface,
    rows: Vec<usize>,
    mut out: PyReadwriteArray2<'_, f32>,
    settings: Settings,
    progress: Option<Py<PyAny>>,
) -> PyResult<PairwiseItems> {
    let (monitor, surface) = (Monitor::default(), surface.inner.surface());
    let points = surface.chart().points();
    if out.shape() != [rows.len(), points] {
        return Err(errors::value("out must have a row for each source"));
    }
    let options = settings.options(&monitor)?;
    let mut left = out.as_slice_mut().map_err(errors::value)?;
    let done = AtomicUsize::new(0);
    let tell = |py: Python<'_>| match &progress {
        Some(progress) => {
            progress.call1(py, (done.load(Ordering::Relaxed), rows.len())).map(|_| ())
        }
        None => Ok(()),
    };
    let work = || {
        let mut pairwise = Pairwise::new(surface, &options)?;
        let report = pairwise.rows(&rows, |rows| {
            if let Some(part) = left.split_off_mut(..rows.distances.len()) {
                part.copy_from_slice(rows.distances);
            }
            done.fetch_add(rows.sources.len(), Ordering::Relaxed);
            Ok::<_, Error>(())
        })?;
        Ok((report.iterations, report.residual, report.converged(), report.engine.name()))
    };
    let solved = work::watched(py, settings.threads, &monitor, tell, work)?;
    let solved = solved.map_err(errors::of)?;
    tell(py)?;
    Ok(solved)
}

/// Computes the canonical form of the largest connected piece of a matrix of distances.
#[pyfunction]
pub fn canonical<'py>(
    py: Python<'py>,
    matrix: PyReadonlyArray2<'py, f32>,
    dimensions: usize,
    iterations: usize,
) -> PyResult<Form<'py>> {
    let points = matrix.shape()[0];
    let values: Vec<f32> = matrix.as_array().iter().copied().collect();
    let form = work::detached(py, || {
        let (distances, kept) = Distances::of_largest_piece(points, values)?;
        let options =
            FormOptions::default().with_dimensions(dimensions).with_iterations(iterations);
        canonical_form(&distances, &options).map(|form| (form, kept))
    })?;
    let (form, kept) = form.map_err(errors::value)?;
    let (stress, converged, shape) = (form.stress_1(), form.converged, (form.points(), dimensions));
    let kept: Vec<i64> = kept.into_iter().map(|point| point as i64).collect();
    let coordinates = arrays::handed_over(py, shape, form.coordinates)?;
    Ok((coordinates, kept.into_pyarray(py), stress, converged))
}

//! Sparse pairs of points: those within a radius, and the nearest ones.

use geosweep::pairwise::{nearest_points, pairs_within};
use geosweep::{Error, Monitor};
use numpy::{IntoPyArray, PyArray1};
use pyo3::prelude::*;
use rayon::prelude::*;

use crate::settings::Settings;
use crate::surface::Surface;
use crate::{errors, work};

/// The distances and columns of a sparse matrix's entries, and the number of the first entry of each row.
type Csr<'py> = (Bound<'py, PyArray1<f32>>, Bound<'py, PyArray1<i64>>, Bound<'py, PyArray1<i64>>);

fn handed_over(py: Python<'_>, indptr: Vec<usize>, indices: Vec<i64>, data: Vec<f32>) -> Csr<'_> {
    let indptr: Vec<i64> = indptr.into_iter().map(|first| first as i64).collect();
    (data.into_pyarray(py), indices.into_pyarray(py), indptr.into_pyarray(py))
}

/// Computes the distances within the radius of `settings` from the grid points with the indices `rows` to all points.
/// Also returns the largest number of iterations of a map, the residual, and whether all maps have converged.
#[pyfunction]
pub fn within<'py>(
    py: Python<'py>,
    surface: &Surface,
    rows: Vec<usize>,
    settings: Settings,
) -> PyResult<(Csr<'py>, u32, f64, bool)> {
    let (monitor, surface) = (Monitor::default(), surface.inner.surface());
    let options = settings.options(&monitor)?;
    let work = || pairs_within(surface, &rows, &options);
    let solved = work::watched(py, settings.threads, &monitor, |_| Ok(()), work)?;
    let (found, report) = solved.map_err(errors::of)?;
    let indices = found.indices.into_iter().map(i64::from).collect();
    let csr = handed_over(py, found.indptr, indices, found.data);
    Ok((csr, report.iterations, report.residual, report.converged()))
}

/// Computes, for each of `points` (row and column), the distances to the `count` nearest others of them.
#[pyfunction]
pub fn nearest_others<'py>(
    py: Python<'py>,
    surface: &Surface,
    points: Vec<[usize; 2]>,
    count: usize,
    settings: Settings,
) -> PyResult<Csr<'py>> {
    let (monitor, surface) = (Monitor::default(), surface.inner.surface());
    let options = settings.options(&monitor)?;
    let row = |(index, &[row, col]): (usize, &[usize; 2])| {
        // The nearest points include the point itself, so `count + 1` are needed. Points at the same place may come
        // before it.
        let place = [row as f64, col as f64];
        let found = nearest_points(surface, place, &points, count + 1, &options)?;
        let others = found.into_iter().filter(|near| near.index != index).take(count);
        let mut others: Vec<_> = others.map(|near| (near.index, near.distance)).collect();
        others.sort_by_key(|&(index, _)| index);
        Ok::<_, Error>(others)
    };
    let work = || {
        // Each of several calls at the same time would open a device of its own.
        if settings.are_for_device() {
            return points.iter().enumerate().map(row).collect::<Result<Vec<_>, _>>();
        }
        points.par_iter().enumerate().map(row).collect()
    };
    let solved = work::watched(py, settings.threads, &monitor, |_| Ok(()), work)?;
    let rows = solved.map_err(errors::of)?;
    let mut indptr = vec![0];
    indptr.extend(rows.iter().scan(0, |entries, row| {
        *entries += row.len();
        Some(*entries)
    }));
    let (indices, data) = rows.into_iter().flatten().map(|(index, d)| (index as i64, d)).unzip();
    Ok(handed_over(py, indptr, indices, data))
}

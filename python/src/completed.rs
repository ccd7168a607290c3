//! Completes grids of closed surfaces that lack lines which gluing needs.

use geosweep::surface::{LastLine, Layout};
use numpy::{IntoPyArray, PyArray1, PyArray2, PyReadonlyArray2};
use pyo3::prelude::*;

use crate::surface::Surface;
use crate::{arrays, errors, work};

/// A given grid that lacks lines, and the completed grid that has them.
#[pyclass(frozen, module = "geosweep._geosweep")]
pub struct CompletedGrid {
    grid: geosweep::surface::CompletedGrid,
}

#[pymethods]
impl CompletedGrid {
    /// Finds the lines that the grid of an open surface lacks.
    #[new]
    #[pyo3(signature = (surface, layout, last=None))]
    fn new(py: Python<'_>, surface: &Surface, layout: &str, last: Option<&str>) -> PyResult<Self> {
        let layout = named(layout)?;
        let surface = surface.inner.surface();
        use geosweep::surface::CompletedGrid as Found;
        let find = || match last {
            None => Found::new(surface, layout),
            Some("repeated") => Found::with_last_line(surface, layout, LastLine::Repeats),
            Some(_) => Found::with_last_line(surface, layout, LastLine::IsApart),
        };
        Ok(Self { grid: work::detached(py, find)?.map_err(errors::value)? })
    }

    #[getter]
    fn given_shape(&self) -> (usize, usize) {
        (self.grid.given().rows, self.grid.given().cols)
    }

    #[getter]
    fn shape(&self) -> (usize, usize) {
        (self.grid.chart().rows, self.grid.chart().cols)
    }

    /// Returns the completed and glued surface.
    fn complete(&self, py: Python<'_>, surface: &Surface) -> PyResult<Surface> {
        let complete = || self.grid.complete(surface.inner.surface());
        Ok(work::detached(py, complete)?.map_err(errors::value)?.into())
    }

    /// Returns the row-major index on the completed grid of each given point.
    fn given_points<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<usize>> {
        self.grid.given_points().into_pyarray(py)
    }

    /// Returns the rows and columns (n, 2), on the completed grid, of places on the given grid.
    fn to_completed<'py>(
        &self,
        py: Python<'py>,
        places: PyReadonlyArray2<'_, f64>,
    ) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let place = |[row, col]: [f64; 2]| {
            self.grid.to_completed([row, col]).ok_or_else(|| {
                let [[above, below], [left, right]] = self.grid.margins();
                let (rows, cols) = self.given_shape();
                errors::value(format!(
                    "place ({row}, {col}) is off the surface: rows go from {} to {}, columns from {} to {}",
                    0.0 - above,
                    rows as f64 - 1.0 + below,
                    0.0 - left,
                    cols as f64 - 1.0 + right
                ))
            })
        };
        each(py, &places, place)
    }

    /// Returns the rows and columns (n, 2), on the given grid, of places on the completed grid.
    fn to_given<'py>(
        &self,
        py: Python<'py>,
        places: PyReadonlyArray2<'_, f64>,
    ) -> PyResult<Bound<'py, PyArray2<f64>>> {
        each(py, &places, |place| Ok(self.grid.to_given(place)))
    }
}

/// Returns the layout with the name `layout`.
fn named(layout: &str) -> PyResult<Layout> {
    Ok(match layout {
        "columns" => Layout::Columns,
        "rows" => Layout::Rows,
        "both" => Layout::Both,
        "flipped-columns" => Layout::FlippedColumns,
        "flipped-rows" => Layout::FlippedRows,
        "globe" => Layout::Globe,
        "cube" => Layout::Cube,
        _ => {
            return Err(errors::value(format!(
                "layout='{layout}' is unknown; choose 'columns', 'rows', 'both', 'flipped-columns', 'flipped-rows', \
                 'globe' or 'cube'"
            )));
        }
    })
}

/// Converts each place of an array (n, 2).
fn each<'py>(
    py: Python<'py>,
    places: &PyReadonlyArray2<'_, f64>,
    convert: impl Fn([f64; 2]) -> PyResult<[f64; 2]>,
) -> PyResult<Bound<'py, PyArray2<f64>>> {
    let given = places.as_array();
    let converted: Vec<[f64; 2]> =
        given.rows().into_iter().map(|at| convert([at[0], at[1]])).collect::<PyResult<_>>()?;
    arrays::handed_over(py, (given.nrows(), 2), converted.into_flattened())
}

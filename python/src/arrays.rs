//! Takes NumPy arrays without copies, and hands results over as arrays.

use std::marker::PhantomData;
use std::sync::Arc;

use geosweep::geometry::Curve;
use geosweep::glam::DVec3;
use numpy::{Element, IntoPyArray, PyArray, PyArray2, PyArray3, PyArrayMethods, PyReadonlyArray};
use numpy::{PyUntypedArrayMethods, ndarray};
use pyo3::prelude::*;

use crate::errors;

/// The elements of a C-contiguous array as values of type `T`. This value keeps the array alive.
pub struct Shared<T> {
    first: *const T,
    count: usize,
    _array: Py<PyAny>,
    _elements: PhantomData<T>,
}

// SAFETY: the elements are only read, and the array may be dropped by any thread.
unsafe impl<T: Sync> Send for Shared<T> {}
// SAFETY: see above.
unsafe impl<T: Sync> Sync for Shared<T> {}

impl<T> AsRef<[T]> for Shared<T> {
    fn as_ref(&self) -> &[T] {
        // SAFETY: the array has these elements and lives as long as this value. With `copy=False` the
        // caller must not write to the elements meanwhile.
        unsafe { std::slice::from_raw_parts(self.first, self.count) }
    }
}

fn shared<T, D: ndarray::Dimension>(
    array: &PyReadonlyArray<'_, f64, D>,
    numbers: usize,
) -> PyResult<Arc<Shared<T>>> {
    let slice = array.as_slice().map_err(errors::value)?;
    Ok(Arc::new(Shared {
        first: slice.as_ptr().cast(),
        count: slice.len() / numbers,
        _array: array.as_any().clone().unbind(),
        _elements: PhantomData,
    }))
}

/// Shares the elements of an array.
pub fn scalars<D: ndarray::Dimension>(
    array: &PyReadonlyArray<'_, f64, D>,
) -> PyResult<Arc<Shared<f64>>> {
    shared(array, 1)
}

/// Shares an array whose last axis has three coordinates.
pub fn vectors<D: ndarray::Dimension>(
    array: &PyReadonlyArray<'_, f64, D>,
) -> PyResult<Arc<Shared<DVec3>>> {
    const { assert!(size_of::<DVec3>() == 24 && align_of::<DVec3>() == align_of::<f64>()) };
    if array.shape().last() != Some(&3) {
        return Err(errors::value("points need three coordinates"));
    }
    shared(array, 3)
}

/// Returns a read-only array of rows x cols `values`, which lie in `owner`. The array keeps `owner` alive.
///
/// # Safety
/// The values must stay where they are while `owner` lives.
pub unsafe fn view<'py, T: Element>(
    (rows, cols): (usize, usize),
    values: &[T],
    owner: Bound<'py, PyAny>,
) -> PyResult<Bound<'py, PyArray2<T>>> {
    let view = ndarray::ArrayView2::from_shape((rows, cols), values).map_err(errors::value)?;
    // SAFETY: the caller's contract.
    let array = unsafe { PyArray2::borrow_from_array(&view, owner) };
    array.call_method1("setflags", (false,))?;
    Ok(array)
}

/// Hands values over as an array of rows x cols, without a copy.
pub fn handed_over<'py, T: Element>(
    py: Python<'py>,
    (rows, cols): (usize, usize),
    values: Vec<T>,
) -> PyResult<Bound<'py, PyArray2<T>>> {
    let array: Bound<'py, PyArray<T, _>> = values.into_pyarray(py);
    array.reshape([rows, cols])
}

/// Hands labels of regions over as an array of rows x cols. `NO_REGION` becomes -1.
pub fn labels<'py>(
    py: Python<'py>,
    shape: (usize, usize),
    labels: &[u32],
) -> PyResult<Bound<'py, PyArray2<i32>>> {
    handed_over(py, shape, labels.iter().map(|label| label.cast_signed()).collect())
}

/// Hands vectors over as an array of rows x cols x `N` numbers, without a copy.
pub fn vectors_handed_over<'py, T: Element, const N: usize>(
    py: Python<'py>,
    (rows, cols): (usize, usize),
    values: Vec<[T; N]>,
) -> PyResult<Bound<'py, PyArray3<T>>> {
    values.into_flattened().into_pyarray(py).reshape([rows, cols, N])
}

/// Hands the vertices of a curve over as an array (n, 2). A closed curve ends with its first vertex.
pub fn curve<'py>(py: Python<'py>, curve: &Curve) -> PyResult<Bound<'py, PyArray2<f64>>> {
    let numbers: Vec<f64> = curve.points().flatten().collect();
    handed_over(py, (numbers.len() / 2, 2), numbers)
}

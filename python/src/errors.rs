//! Turns errors of the library into exceptions.

use pyo3::PyErr;
use pyo3::exceptions::{PyMemoryError, PyRuntimeError, PyValueError};

/// Returns the exception for an error: `MemoryError`, `RuntimeError` for a device and for a computation that
/// was cancelled, else `ValueError`.
pub fn of(error: geosweep::Error) -> PyErr {
    use geosweep::Error::{Cancelled, MapMemory, Memory};
    match error {
        Memory { .. } | MapMemory { .. } => PyMemoryError::new_err(error.to_string()),
        #[cfg(feature = "vulkan")]
        geosweep::Error::Vulkan(_) => PyRuntimeError::new_err(error.to_string()),
        Cancelled => PyRuntimeError::new_err(error.to_string()),
        _ => value(error),
    }
}

/// Returns a `ValueError`.
pub fn value(error: impl std::fmt::Display) -> PyErr {
    PyValueError::new_err(error.to_string())
}

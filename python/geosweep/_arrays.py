"""Conversion of callers' arrays to NumPy arrays."""

import warnings
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

Floats = NDArray[np.float64]

# DLPack's numbers for memory that the processor reads: its own, and what CUDA and ROCm pin.
_HOST = (1, 3, 11, 13)


class HostCopyWarning(UserWarning):
    """An array was copied from a device to the host."""


def on_host(name: str, value: ArrayLike) -> NDArray[Any]:
    """Return the content of ``value`` as a NumPy array.

    Arrays of CuPy, PyTorch, JAX and others come through DLPack. Arrays in the host's memory are not
    copied. Arrays in a device's memory are copied, with a `HostCopyWarning`.
    """
    if isinstance(value, np.ndarray) or not hasattr(value, "__dlpack_device__"):
        return np.asarray(value)
    array: Any = value
    try:
        if array.__dlpack_device__()[0] in _HOST:
            return np.from_dlpack(array)
        found = _copied(array)
    except (BufferError, RuntimeError, TypeError, ValueError) as error:
        raise TypeError(
            f"{name} cannot be taken through DLPack ({error}); give a NumPy array"
        ) from error
    warnings.warn(
        f"{name} lies on a device and was copied to the host, where edges are measured",
        HostCopyWarning,
        stacklevel=4,
    )
    return found


def _copied(array: Any) -> NDArray[Any]:
    """Copy an array from its device, by DLPack or by a method of the array's library."""
    try:
        return np.from_dlpack(array, device="cpu")
    except (BufferError, RuntimeError, TypeError, ValueError):
        # NumPy before 2.1, or a library that cannot export to another device.
        for method in ("get", "cpu"):  # CuPy's and PyTorch's
            if hasattr(array, method):
                return np.asarray(getattr(array, method)())
        raise


def is_number(value: object) -> bool:
    """Return whether a value is one real number, so that no array has to be made of it."""
    return isinstance(value, (int, float, np.integer, np.floating))


def numbers(name: str, value: ArrayLike) -> Floats:
    """Return an array of float64 in C order, or raise TypeError."""
    try:
        array = on_host(name, value)
        if array.dtype.kind not in "biuf":
            raise TypeError(f"{name} must be real numbers, not {array.dtype}")
        # An array that was received from another process may not be aligned.
        return np.require(array, np.float64, ["C", "A"])
    except (TypeError, ValueError) as error:
        said = f"{name} must be an array of real numbers, not {value!r:.60}"
        raise TypeError(f"{said} ({error})" if "DLPack" in str(error) else said) from error


def flags(name: str, value: ArrayLike) -> NDArray[np.bool_]:
    """Return whether each entry of a mask is other than zero, in C order."""
    array = on_host(name, value)
    if array.dtype.kind not in "biuf":
        raise TypeError(f"{name} must be an array of booleans or numbers, not of {array.dtype}")
    return np.ascontiguousarray(array != 0)

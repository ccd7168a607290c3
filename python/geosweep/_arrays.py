"""Conversion of callers' arrays to NumPy arrays.

Values that an array marks as missing, by a mask or by attributes, never enter a computation: they
become holes, walls or no sources, or the array is refused by name.
"""

import sys
import warnings
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ._attributes import decoded

Floats = NDArray[np.float64]

# DLPack's numbers for memory that the processor reads: its own, and what CUDA and ROCm pin.
_HOST = (1, 3, 11, 13)


class HostCopyWarning(UserWarning):
    """An array was copied from a device to the host."""


def on_host(name: str, value: ArrayLike) -> NDArray[Any]:
    """Return the content of ``value`` as a NumPy array, or raise ValueError if values are missing.

    Arrays of CuPy, PyTorch, JAX and others come through DLPack. Arrays in the host's memory are not
    copied. Arrays in a device's memory are copied, with a `HostCopyWarning`.
    """
    array = given(name, value)
    if np.ma.is_masked(array):
        where = np.argwhere(np.ma.getmaskarray(array))[0].tolist()
        raise ValueError(
            f"{name} has a masked value at {where}, which is no number; fill it, or leave it out"
        )
    return np.ma.getdata(array) if isinstance(array, np.ma.MaskedArray) else array


def given(name: str, value: ArrayLike) -> NDArray[Any]:
    """Return the content of ``value`` as a NumPy array, masked where values are missing."""
    if isinstance(value, np.ma.MaskedArray):
        return value
    _refuse_unit(name, value)
    if isinstance(value, np.ndarray):
        return np.asarray(value)
    if is_data_array(value):
        return decoded(name, value)
    if isinstance(value, (list, tuple)) and any(isinstance(v, np.ma.MaskedArray) for v in value):
        return np.ma.array(value)
    if not hasattr(value, "__dlpack_device__"):
        # A variable of a NetCDF file, for one, makes a masked array.
        try:
            found = np.asanyarray(value)
        except ValueError as error:
            raise TypeError(f"{name} is no array, since its rows have different lengths") from error
        except TypeError as error:
            raise TypeError(f"{name} is no array, but {described(value)}") from error
        return found if isinstance(found, np.ma.MaskedArray) else np.asarray(found)
    array: Any = value
    try:
        if array.__dlpack_device__()[0] in _HOST:
            return np.from_dlpack(array)
        copied = _copied(array)
    except (BufferError, RuntimeError, TypeError, ValueError) as error:
        raise TypeError(
            f"{name} cannot be taken through DLPack ({error}); give a NumPy array"
        ) from error
    warnings.warn(
        f"{name} lies on a device and was copied to the host, where edges are measured",
        HostCopyWarning,
        stacklevel=5,
    )
    return copied


def _refuse_unit(name: str, value: Any) -> None:
    """Raise ValueError for a quantity of astropy or pint, whose unit NumPy would drop."""
    unit = getattr(value, "unit", getattr(value, "units", None))
    # The units of xarray and NetCDF are texts, and those of dates have no array.
    if unit is None or isinstance(unit, str) or not hasattr(value, "to"):
        return
    if str(unit) not in ("", "dimensionless"):
        raise ValueError(
            f"{name} is in {unit}, and units are not converted; give its numbers, in the unit of "
            "all other lengths"
        )


def is_data_array(value: object) -> bool:
    """Return whether a value is one of xarray's arrays, without importing xarray."""
    xarray = sys.modules.get("xarray")
    return xarray is not None and isinstance(value, xarray.DataArray)


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
    numeric = (int, float, np.integer, np.floating)
    return isinstance(value, numeric) and not isinstance(value, bool)


def is_count(value: object) -> bool:
    """Return whether a value is one whole number, of Python's or NumPy's types."""
    if isinstance(value, (bool, np.bool_)):
        return False
    is_scalar = isinstance(value, np.ndarray) and value.ndim == 0 and value.dtype.kind in "iu"
    return isinstance(value, (int, np.integer)) or is_scalar


def real(name: str, value: Any) -> float:
    """Return a value that must be one real number, also an array of no dimensions."""
    if is_number(value):
        return float(value)
    array = on_host(name, value)
    if array.shape != () or array.dtype.kind not in "iuf":
        raise TypeError(f"{name} must be one number, not {described(value)}")
    return float(array)


def described(value: Any) -> str:
    """Return what a value of a wrong type is, for messages."""
    if isinstance(value, (str, bool, int, float, complex, type(None))):
        return f"{value!r:.60}"
    dtype, shape = getattr(value, "dtype", None), getattr(value, "shape", None)
    if dtype is not None and shape:
        return f"an array of {dtype} with the shape {shape}"
    if isinstance(value, (list, tuple, dict, set, frozenset)):
        return f"{value!r:.60}"
    return f"a {type(value).__name__}"


# Whole numbers up to this one suit the compiled part on all machines.
_MOST = 2**31 - 1


def count(name: str, value: Any, least: int = 1, most: int = _MOST) -> int:
    """Return a value that must be one whole number from ``least`` to ``most``."""
    if not is_count(value):
        raise TypeError(f"{name}={value!r:.60} must be a whole number")
    found = int(np.asarray(value))
    if not least <= found <= most:
        raise ValueError(f"{name}={found} must lie from {least} to {most}")
    return found


def switch(name: str, value: object) -> bool:
    """Return a value that must be True or False. A text or a number is likely meant otherwise."""
    if not isinstance(value, (bool, np.bool_)):
        raise TypeError(f"{name}={value!r:.60} must be True or False")
    return bool(value)


def numbers(name: str, value: ArrayLike, missing: float | None = None) -> Floats:
    """Return an array of float64 in C order, or raise TypeError.

    Missing values become ``missing``. Without that, they raise ValueError.
    """
    try:
        array = on_host(name, value) if missing is None else given(name, value)
    except (TypeError, ValueError) as error:
        if str(error).startswith(name):
            raise
        # Lists of unequal lengths, for one.
        raise TypeError(_no_numbers(name, described(value))) from error
    if array.dtype.kind == "O":
        array = _of_objects(name, array)
    if array.dtype.kind not in "iuf":
        what = described(value if np.shape(value) == array.shape else array)
        of_masks = "; booleans are for mask=, holes= and rasters of sources"
        more = of_masks if array.dtype.kind == "b" else ""
        raise TypeError(_no_numbers(name, what) + more)
    if np.ma.is_masked(array):
        array = np.ma.filled(np.ma.asarray(array, np.float64), missing)
    # An array that was received from another process may not be aligned.
    return np.require(np.ma.getdata(array), np.float64, ["C", "A"])


def _no_numbers(name: str, what: str) -> str:
    return f"{name} must be an array of real numbers, not {what}"


def _of_objects(name: str, array: NDArray[Any]) -> NDArray[Any]:
    """Return an array of objects as numbers, or raise TypeError for the first that is none."""
    hidden = np.ma.getmaskarray(array)
    for place, one in np.ndenumerate(np.ma.getdata(array)):
        if not hidden[place] and not is_number(one):
            where = f" at {list(place)}" if place else ""
            raise TypeError(f"{_no_numbers(name, described(one))}{where}")
    found = np.ma.masked_array(np.where(hidden, 0, np.ma.getdata(array)).astype(np.float64), hidden)
    return found if hidden.any() else np.ma.getdata(found)


def flags(name: str, value: ArrayLike, missing: bool = False) -> NDArray[np.bool_]:
    """Return whether each entry of a mask is other than zero, in C order.

    Missing values and NaN become ``missing``.
    """
    array = given(name, value)
    if array.dtype.kind not in "biuf":
        what = f"an array of {array.dtype}" if array.shape else f"a {type(value).__name__}"
        raise TypeError(f"{name} must be an array of booleans or numbers, not {what}")
    unknown = np.ma.getmaskarray(array)
    values = np.ma.getdata(array)
    if values.dtype.kind == "f":
        unknown = unknown | np.isnan(values)
    return np.require(np.where(unknown, missing, values != 0), requirements="C")

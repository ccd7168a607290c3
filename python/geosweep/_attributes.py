"""The attributes by which arrays of xarray describe their values."""

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

# Values that stand for "no value", as CF, rioxarray, xarray's former open_rasterio and others name
# them.
_FILLS = ("_FillValue", "missing_value", "nodata", "nodatavals", "fill_value")
_RANGES = ("valid_min", "valid_max", "valid_range")
# Attributes that describe the values of an array. Results computed from it do not take them over.
OF_VALUES = {
    *_FILLS,
    "_Unsigned",
    "scale_factor",
    "add_offset",
    "scales",
    "offsets",
    "long_name",
    "standard_name",
    "valid_min",
    "valid_max",
    "valid_range",
    "actual_range",
}


def decoded(name: str, array: Any) -> NDArray[Any]:
    """Return the values of a DataArray as its attributes describe them.

    The result is masked where there is no value: at a fill value, and outside the valid range. A
    scale and an offset are applied. xarray removes these attributes when it decodes a file, so what
    is left has not been applied.
    """
    values, attrs = np.asarray(array.values), array.attrs
    if values.dtype.kind not in "iuf":
        return values

    def numbers(key: str) -> list[float]:
        found = _numbers(name, attrs, key)
        if values.dtype.kind == "u" and key in (*_FILLS, *_RANGES):
            # With _Unsigned these are stored as signed numbers, too.
            return [number % 2 ** (8 * values.itemsize) for number in found]
        return found

    if values.dtype.kind == "i" and str(attrs.get("_Unsigned")).lower() == "true":
        values = values.view(values.dtype.str.replace("i", "u"))
    fills = {fill for key in _FILLS for fill in numbers(key)}
    fills.update(_nodata_of(array))
    missing = np.zeros(values.shape, np.bool_)
    for fill in fills:
        missing |= _stands_for(values, fill)
    valid = numbers("valid_range")
    for least in (*valid[:1], *numbers("valid_min")):
        missing |= values < least
    for largest in (*valid[1:], *numbers("valid_max")):
        missing |= values > largest
    scale = (*numbers("scale_factor"), *numbers("scales"), 1.0)[0]
    offset = (*numbers("add_offset"), *numbers("offsets"), 0.0)[0]
    if (scale, offset) != (1.0, 0.0):
        values = values * scale + offset
    return np.ma.masked_array(values, missing) if missing.any() else values


def _nodata_of(array: Any) -> list[float]:
    """Return the value that was set with rioxarray's set_nodata(), beside the attributes."""
    try:
        found = array.rio.nodata if hasattr(array, "rio") else None
    except (TypeError, ValueError, OverflowError):
        # An attribute of several numbers, or of another type than the array.
        return []
    return [] if found is None or np.ndim(found) != 0 else [float(found)]


def _numbers(name: str, attrs: Mapping[Any, Any], key: str) -> list[float]:
    """Return the numbers of an attribute; none if the array lacks it."""
    found = [value for value in np.ravel(attrs.get(key, [])).tolist() if value is not None]
    try:
        return [float(value) for value in found]
    except (TypeError, ValueError):
        raise ValueError(
            f"{name}: the attribute {key}={attrs[key]!r:.40} is not a number; remove or mend it"
        ) from None


def _stands_for(values: NDArray[Any], fill: float) -> NDArray[np.bool_]:
    """Return where values are a fill value, which may be rounded or of a longer type."""
    if np.isnan(fill):
        return np.asarray(np.isnan(values))
    if values.dtype.kind != "f":
        return np.asarray(values == fill)
    with np.errstate(over="ignore", invalid="ignore"):
        fill = values.dtype.type(fill)
        # As GDAL compares, to four units in the last place of float32. Sums of the largest numbers
        # overflow.
        rounding = values.dtype.type(2 * np.finfo(np.float32).eps) * np.abs(values + fill)
        return np.asarray((values == fill) | (np.abs(values - fill) < rounding))

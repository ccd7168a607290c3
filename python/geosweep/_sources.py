"""Sources in the forms that callers have them."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Lines:
    """Polylines, every point of which is a source.

    Parameters
    ----------
    vertices
        An array (n, 2) of rows and columns for each line.
    starts
        Arrival time along each line, or one for all.
    """

    vertices: Sequence[ArrayLike]
    starts: ArrayLike = 0.0


Source = ArrayLike | Lines
Native = tuple[Floats, list[tuple[Floats, float]]]


def numbers(name: str, value: ArrayLike) -> Floats:
    """Return an array of float64, or raise TypeError."""
    try:
        array = np.asarray(value)
        if array.dtype.kind not in "biuf":
            raise TypeError
        return np.asarray(array, dtype=np.float64, order="C")
    except (TypeError, ValueError) as error:
        raise TypeError(f"{name} must be an array of real numbers, not {value!r:.60}") from error


def native(source: Source, shape: tuple[int, int]) -> Native:
    """Return points (n, 3) with starts, and lines with starts."""
    if isinstance(source, Lines):
        lines = [numbers("source", line) for line in source.vertices]
        for line in lines:
            if line.ndim != 2 or line.shape[1] != 2:
                raise ValueError(f"source: a line needs the shape (n, 2), not {line.shape}")
        starts = np.broadcast_to(numbers("source starts", source.starts), (len(lines),))
        return np.empty((0, 3)), list(zip(lines, starts.tolist(), strict=True))
    array = numbers("source", source)
    if array.shape == (2,) or array.shape == (3,):
        array = array[None, :]
    elif array.shape == shape and np.asarray(source).dtype.kind in "biu":
        array = np.argwhere(array != 0).astype(np.float64)
        if not len(array):
            raise ValueError("source: the raster has no cell other than zero")
    if array.ndim != 2 or array.shape[1] not in (2, 3):
        raise ValueError(
            "source must be (row, col), an array (n, 2), an array (n, 3) with start times, Lines, "
            f"or a boolean or integer raster of the shape {shape}, not an array of the shape "
            f"{array.shape}"
        )
    if array.shape[1] == 2:
        array = np.column_stack([array, np.zeros(len(array))])
    return np.ascontiguousarray(array), []

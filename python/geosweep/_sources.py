"""Sources in the forms in which callers give them."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from ._arrays import Floats, is_number, numbers, on_host
from ._settings import Settings


@dataclass(frozen=True)
class Lines:
    """Polylines, every point of which is a source.

    Parameters
    ----------
    vertices
        An array (n, 2) of rows and columns for each line.
    starts
        Arrival time along each line, or one for all.

    Examples
    --------
    >>> import numpy as np, geosweep as gs
    >>> surface = gs.Surface.from_heights(np.zeros((5, 9)))
    >>> shore = gs.Lines([[(0, 0), (0, 8)]])
    >>> round(surface.solve(shore).distance[3, 4].item(), 3)
    3.0
    """

    vertices: Sequence[ArrayLike]
    starts: ArrayLike = 0.0


@dataclass(frozen=True)
class Mixed:
    """Points (n, 3) and lines, as the compiled part takes them."""

    points: Floats
    lines: list[tuple[Floats, float]]


Source = ArrayLike | Lines | Mixed
Native = tuple[Floats, list[tuple[Floats, float]]]
# Points, lines, options, and whether a map is in double precision, as the compiled part takes them.
Problem = tuple[Floats, list[tuple[Floats, float]], Settings, bool]


def native(source: Source, shape: tuple[int, int]) -> Native:
    """Return points (n, 3) with starts, and lines with starts."""
    if isinstance(source, tuple) and len(source) in (2, 3) and all(map(is_number, source)):
        return np.array([(*source, 0.0)[:3]], dtype=np.float64), []
    if isinstance(source, Mixed):
        return source.points, source.lines
    if isinstance(source, Lines):
        lines = [numbers("source", line) for line in source.vertices]
        for line in lines:
            if line.ndim != 2 or line.shape[1] != 2:
                raise ValueError(f"source: a line needs the shape (n, 2), not {line.shape}")
        starts = np.broadcast_to(numbers("source starts", source.starts), (len(lines),))
        return np.empty((0, 3)), list(zip(lines, starts.tolist(), strict=True))
    if isinstance(source, (list, tuple)):
        array = numbers("source", source)
        is_raster = False
    else:
        given = on_host("source", source)
        is_raster = given.shape == shape and given.dtype.kind in "biu"
        array = (
            np.argwhere(given != 0).astype(np.float64) if is_raster else numbers("source", given)
        )
    if is_raster and not len(array):
        raise ValueError("source: the raster has no cell other than zero")
    if array.shape == (2,) or array.shape == (3,):
        array = array[None, :]
    if array.ndim != 2 or array.shape[1] not in (2, 3):
        raise ValueError(
            "source must be (row, col), an array (n, 2), an array (n, 3) with start times, Lines, "
            f"or a boolean or integer raster of the shape {shape}, not an array of the shape "
            f"{array.shape}"
        )
    if array.shape[1] == 2:
        array = np.column_stack([array, np.zeros(len(array))])
    return np.ascontiguousarray(array), []

"""The results of geometry on maps: paths, curves, regions and axes."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ._arrays import Floats


class Path(NamedTuple):
    """A shortest path."""

    vertices: Floats
    """Rows and columns (n, 2), from the given end to the source."""
    length: float
    """Length, in the map's unit."""
    source: int
    """Index of the source."""


class Curves(NamedTuple):
    """The curves of one level."""

    level: float
    """The distance."""
    curves: list[Floats]
    """Rows and columns (n, 2) of each curve. A closed curve ends with its first vertex."""


class Ridge(NamedTuple):
    """A curve where wavefronts meet."""

    vertices: Floats
    """Rows and columns (n, 2)."""
    angles: Floats
    """Angle between the wavefronts at each vertex, in degrees."""


class Voronoi(NamedTuple):
    """The regions of the sources."""

    labels: NDArray[np.int32]
    """Index of the nearest source (M, N); -1 at holes and where no source reaches."""
    borders: list[tuple[tuple[int, int], Floats]]
    """For each border, the regions on both sides and the vertices (n, 2)."""
    areas: Floats
    """Area of each region."""


class Basis(NamedTuple):
    """The axes of a log map at its source: steps of unit length at a right angle."""

    at: tuple[float, float]
    """Row and column of the source."""
    u: tuple[float, float]
    """The axis of u in rows and columns, along the direction of the columns."""
    v: tuple[float, float]
    """The axis of v in rows and columns, on the side of increasing rows."""
    in_space: Floats | None
    """The two axes in space (2, 3); None if the surface is given by its metric."""

"""The distance map, and geometry from it."""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _geosweep
from ._settings import Settings, refuse
from ._sources import Floats, Native, numbers


class Path(NamedTuple):
    """A shortest path."""

    vertices: Floats
    """Rows and columns (n, 2), from the end that was given to the source."""
    length: float
    """Length, in the map's unit."""
    source: int
    """Index of the source."""


class Curves(NamedTuple):
    """The curves of one level."""

    level: float
    """The distance."""
    curves: list[Floats]
    """Rows and columns (n, 2) of each curve. A closed one ends with its first vertex."""


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
    """The two regions on either side, and the vertices (n, 2), of each border."""
    areas: Floats
    """Area of each region."""


class DistanceMap:
    """Distances from sources to every point of a surface. `Surface.solve` makes it."""

    def __init__(
        self,
        surface: "_geosweep.Surface",
        map_: "_geosweep.Map",
        problem: tuple[Native, Settings, bool],
        out: NDArray[Any] | None,
    ) -> None:
        self._surface = surface
        self._map = map_
        self._problem = problem
        self._out = out

    @property
    def distance(self) -> NDArray[Any]:
        """Distances (M, N), in the surface's unit; inf where no source reaches.

        They are a read-only view of the map, or the array ``out`` if that was given.
        """
        return self._map.distance if self._out is None else self._out

    @property
    def report(self) -> dict[str, Any]:
        """How the map was computed: engine, iterations, residual, converged and more."""
        return self._map.report

    @property
    def nearest(self) -> NDArray[np.int32]:
        """Index of the nearest source (M, N); -1 where no source reaches."""
        return self.voronoi().labels

    def error(self) -> Floats:
        """Estimate the error of each distance (M, N), by maps on other grids.

        The estimate takes a map more and a third of one, over floor plans four to five.
        """
        points, lines = self._problem[0]
        return self._surface.error(points, lines, *self._problem[1:])[0]

    def paths(self, ends: ArrayLike) -> list[Path]:
        """Trace the shortest path from each end, rows and columns (n, 2), to its source."""
        array = numbers("ends", ends)
        if array.ndim != 2 or array.shape[1] != 2:
            raise ValueError(f"ends must have the shape (n, 2), not {array.shape}")
        return [Path(*path) for path in self._map.paths(array.tolist())]

    def contours(
        self, levels: ArrayLike | None = None, *, step: float | None = None
    ) -> list[Curves]:
        """Return the curves of equal distance.

        Parameters
        ----------
        levels
            A number of levels, evenly spaced (default: 10), or the distances themselves.
        step
            Distance between levels, in place of them.
        """
        if step is not None or levels is None:
            chosen = self._map.levels(None, step)
        elif isinstance(levels, int):
            chosen = self._map.levels(levels, None)
        else:
            chosen = numbers("levels", levels).ravel().tolist()
        return [Curves(*curves) for curves in self._map.contours(chosen)]

    def voronoi(self) -> Voronoi:
        """Return the regions of the sources, and their borders."""
        labels, borders, areas = self._map.voronoi()
        return Voronoi(labels, [((a, b), line) for (a, b), line in borders], np.asarray(areas))

    def offsets(self, levels: ArrayLike, side: str = "left") -> list[Curves]:
        """Return curves at the given distances on one side of the sources, which are lines.

        The side is ``"left"`` or ``"right"``, as seen in a picture with rows downwards.
        """
        if side not in ("left", "right"):
            refuse("side", side, "'left' or 'right'")
        chosen = np.atleast_1d(numbers("levels", levels)).tolist()
        return [Curves(*curves) for curves in self._map.offsets(chosen, side == "left")]

    def ridges(self, least_angle: float = 30.0) -> list[Ridge]:
        """Return the curves where wavefronts meet at ``least_angle`` degrees or more."""
        return [Ridge(*ridge) for ridge in self._map.ridges(least_angle)]

    def farthest(self) -> tuple[int, int, float]:
        """Return row, column and distance of the farthest point that is reached."""
        return self._map.farthest()

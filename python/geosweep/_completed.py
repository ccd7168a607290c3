"""Grids of closed surfaces without the lines that gluing needs twice."""

from typing import Literal, get_args

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _geosweep
from ._arrays import Floats, given
from ._settings import check_choice
from ._surface import Glue, Surface, compiled_of
from ._tables import any_places_of

Layout = Literal["columns", "rows", "both", "flipped-columns", "flipped-rows", "globe", "cube"]


class CompletedGrid:
    """A grid of a closed surface that lacks lines, and the completed grid that has them.

    Examples are longitudes from 0 to 359 degrees, latitudes at the middles of cells, and faces of
    a cube at the middles of texels. The completed grid repeats the first line behind the last one
    and has lines at poles and between faces, whose points are found from the points beside them.

    Parameters
    ----------
    surface
        The open surface on the given grid. Its positions, or its values on opposite sides, tell
        which lines are lacking.
    layout
        The sides that continue each other: "columns", "rows", "both", "flipped-columns",
        "flipped-rows", "globe" (rows are latitudes) or "cube" (six faces).
    last
        Whether the last line is the first one again, "repeated", or one step from it, "apart". By
        default positions tell it, and lines of heights, of a metric, of a slowness or of holes that
        differ are apart.

    Raises
    ------
    ValueError
        If the sides are neither the same line nor neighbours, or the grid is too small. Also if
        both lines of a surface without positions are equal and ``last`` is not given.

    Examples
    --------
    >>> import geosweep as gs
    >>> import numpy as np
    >>> lat, lon = np.radians(np.arange(87.5, -90, -5))[:, None], np.radians(np.arange(0, 360, 5))
    >>> z = np.sin(lat) + 0 * lon
    >>> xyz = np.stack([np.cos(lat) * np.cos(lon), np.cos(lat) * np.sin(lon), z], axis=-1)
    >>> given = gs.Surface.from_positions(xyz)
    >>> grid = gs.CompletedGrid(given, "globe")
    >>> globe = grid.complete(given)
    >>> globe.shape
    (38, 73)
    >>> m = globe.solve(grid.to_completed([(-0.5, 0)]))  # from the north pole
    >>> grid.crop(m.distance).shape
    (36, 72)
    """

    def __init__(
        self,
        surface: Surface,
        layout: Layout,
        *,
        last: Literal["repeated", "apart"] | None = None,
    ) -> None:
        check_choice("layout", layout, *get_args(Layout))
        if last is not None:
            check_choice("last", last, "repeated", "apart")
        self._grid = _geosweep.CompletedGrid(compiled_of(surface), layout, last)
        self._glue: Glue = "charts" if layout == "cube" else layout

    def __repr__(self) -> str:
        (rows, cols), (given_rows, given_cols) = self.shape, self.given_shape
        return f"<geosweep.CompletedGrid: {given_rows} x {given_cols} of {rows} x {cols}>"

    @property
    def given_shape(self) -> tuple[int, int]:
        """Rows and columns of the given grid."""
        return self._grid.given_shape

    @property
    def shape(self) -> tuple[int, int]:
        """Rows and columns of the completed grid."""
        return self._grid.shape

    def complete(self, surface: Surface) -> Surface:
        """Return the completed and glued surface of an open one of the given shape.

        Holes, the slowness and the rule for edges are completed too.
        """
        return Surface(self._grid.complete(compiled_of(surface)), (self._glue,))

    def to_completed(self, places: ArrayLike) -> Floats:
        """Return rows and columns on the completed grid, for sources and other places.

        Parameters
        ----------
        places
            Row and column on the given grid, or an array (..., 2) of them. Places may lie beyond
            the grid where the surface does: with latitudes at the middles of cells, a pole is row
            -0.5.

        Raises
        ------
        ValueError
            If a place is off the surface.
        """
        at = _places(places)
        return self._grid.to_completed(at.reshape(-1, 2)).reshape(at.shape)

    def to_given(self, places: ArrayLike) -> Floats:
        """Return rows and columns on the given grid, from places (..., 2) on the completed grid."""
        at = _places(places)
        return self._grid.to_given(at.reshape(-1, 2)).reshape(at.shape)

    def crop(self, values: ArrayLike) -> NDArray[np.generic]:
        """Return the values at the given points, from values (M, N, ...) on the completed grid.

        Given points between the faces of a cube have the value of a hole.
        """
        array = given("values", values)
        if array.shape[:2] != self.shape:
            raise ValueError(f"values must have the shape {self.shape}, not {array.shape}")
        flat = array.reshape(-1, *array.shape[2:])
        return flat[self._grid.given_points()].reshape(*self.given_shape, *array.shape[2:])


def _places(places: ArrayLike) -> Floats:
    at = any_places_of("places", places)
    if at.ndim == 0 or at.shape[-1] != 2:
        raise ValueError(f"places must be rows and columns (..., 2), not {at.shape}")
    return at

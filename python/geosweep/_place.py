"""Coordinates of a grid's points."""

from dataclasses import dataclass

import numpy as np

from ._arrays import Floats


@dataclass(frozen=True)
class Place:
    """Location of a grid: row numbers increase southwards, column numbers increase eastwards."""

    x0: float
    """x of column 0."""
    y0: float
    """y of row 0, the largest."""
    dx: float
    """Distance between columns."""
    dy: float
    """Distance between rows."""
    shape: tuple[int, int]
    crs: str | None
    """Coordinate reference system as WKT."""

    stored: tuple[Floats, Floats] | None = None
    """The coordinates of rows and of columns as the array stores them, if they are rounded."""

    def to_grid(self, name: str, xy: Floats, strict: bool = True) -> Floats:
        """Return the rows and columns (n, 2) of coordinates (n, 2).

        Places in the outer half of a border cell are moved to its point, as a GIS gives them the
        value of that cell. Places that lie outside raise ValueError, or are returned as they are if
        ``strict`` is false.
        """
        places = np.column_stack([(self.y0 - xy[:, 1]) / self.dy, (xy[:, 0] - self.x0) / self.dx])
        last = np.subtract(self.shape, 1)
        if self.stored is not None:
            # A coordinate of the array is that of its row or column, though it is rounded.
            for axis, coordinates in enumerate(self.stored):
                nearest = np.clip(np.rint(places[:, axis]), 0, last[axis]).astype(np.int64)
                same = coordinates[nearest] == xy[:, 1 - axis]
                places[same, axis] = nearest[same]
        inside = np.clip(places, 0, last)
        beyond = ~(np.abs(places - inside) <= 0.5 + 1e-6).all(axis=1)
        if not strict or not beyond.any():
            inside[beyond] = places[beyond]
            return inside
        first = "; ".join(f"x={x:.10g}, y={y:.10g}" for x, y in xy[beyond][:5].tolist())
        count = int(beyond.sum())
        raise ValueError(
            f"{name}: {first} {'lies' if count == 1 else 'and so on lie' if count > 5 else 'lie'} "
            f"outside the raster ({count} of {len(xy)} places), whose points have x from "
            f"{self.x0:.10g} to {self.x0 + self.dx * last[1]:.10g} and y from "
            f"{self.y0 - self.dy * last[0]:.10g} to {self.y0:.10g}"
        )

    def to_xy(self, places: Floats) -> Floats:
        """Return coordinates (n, 2) of rows and columns (n, 2)."""
        x = self.x0 + self.dx * places[:, 1]
        return np.column_stack([x, self.y0 - self.dy * places[:, 0]])

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

    def to_grid(self, name: str, xy: Floats) -> Floats:
        """Return the rows and columns (n, 2) of coordinates (n, 2).

        Raise ValueError if any of them lies outside the grid.
        """
        places = np.column_stack([(self.y0 - xy[:, 1]) / self.dy, (xy[:, 0] - self.x0) / self.dx])
        last = np.subtract(self.shape, 1)
        # Coordinates at the border may be off by rounding.
        inside = np.clip(places, 0, last)
        outside = ~(np.abs(places - inside) < 1e-6).all(axis=1)
        if outside.any():
            x, y = xy[outside][0].tolist()
            raise ValueError(
                f"{name}: x={x:.10g}, y={y:.10g} lies outside the raster, whose points have x from "
                f"{self.x0:.10g} to {self.x0 + self.dx * last[1]:.10g} and y from "
                f"{self.y0 - self.dy * last[0]:.10g} to {self.y0:.10g}"
            )
        return inside

    def to_xy(self, places: Floats) -> Floats:
        """Return coordinates (n, 2) of rows and columns (n, 2)."""
        x = self.x0 + self.dx * places[:, 1]
        return np.column_stack([x, self.y0 - self.dy * places[:, 0]])

"""Sources in the forms in which callers give them."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _geosweep
from ._arrays import Floats, described, flags, given, is_number, numbers, on_host
from ._settings import Settings
from ._tables import ROW_COL, columns_of, is_frame, refuse_apart


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


@dataclass(frozen=True, eq=False)
class LevelSet:
    """The zero of a function, to both sides of which fronts start.

    It is a curve between grid points, of second order where the function is smooth. scikit-fmm
    starts its fronts in this way.

    Parameters
    ----------
    phi
        Values (M, N). Masked values and NaN are unknown: nothing starts beside them.

    Examples
    --------
    >>> import numpy as np, geosweep as gs
    >>> row, col = np.mgrid[:65, :65]
    >>> circle = gs.LevelSet(np.hypot(row - 32, col - 32) - 20.0)
    >>> round(gs.Surface.from_heights(np.zeros((65, 65))).solve(circle).distance[32, 32].item(), 1)
    20.0
    """

    phi: ArrayLike

    def values(self) -> Floats:
        """Return the values, NaN where they are unknown."""
        return numbers("phi", self.phi, np.nan)


@dataclass(frozen=True)
class Placed:
    """Points (n, 3) and lines, as the compiled part takes them.

    Points come before lines in the order of sources.
    """

    points: Floats
    lines: list[tuple[Floats, float]] = field(default_factory=list)
    rows: NDArray[np.int64] | None = None
    """The row of the caller's table for each source; None if that is the source's index."""
    count: int = 0
    """Number of rows of the caller's table, if there are ``rows``."""

    @property
    def given(self) -> int:
        """Number of sources as the caller counts them."""
        return len(self.points) + len(self.lines) if self.rows is None else self.count


Source = ArrayLike | Lines | LevelSet | Placed
Native = tuple[Floats, list[tuple[Floats, float]]]
# Points, lines, options, and whether a map is in double precision, as the compiled part takes them.
Problem = tuple[Floats, list[tuple[Floats, float]], Settings, bool]


def native(source: Source, surface: Any) -> Native:
    """Return points (n, 3) with starts, and lines with starts."""
    found = placed(source, surface)
    return found.points, found.lines


def placed(source: Source, surface: Any) -> Placed:
    """Return sources as the compiled part takes them, and the caller's numbers of them."""
    if isinstance(source, tuple) and len(source) in (2, 3) and all(map(is_number, source)):
        return Placed(np.array([(*source, 0.0)[:3]], dtype=np.float64))
    if isinstance(source, Placed):
        return source
    if isinstance(source, Lines):
        lines = [vertices_of(line) for line in source.vertices]
        starts = numbers("source starts", source.starts)
        if starts.shape not in ((), (len(lines),)):
            raise ValueError(
                f"source starts must be one number, or one for each of {len(lines)} lines, not of "
                f"the shape {starts.shape}"
            )
        starts = np.broadcast_to(starts, (len(lines),))
        return Placed(np.empty((0, 3)), list(zip(lines, starts.tolist(), strict=True)))
    if isinstance(source, LevelSet):
        return _zero_of(source, surface)
    refuse_apart("source", source)
    if is_frame(source):
        table = points_of(columns_of("source", source, ROW_COL, starts=True))
        assert table is not None  # It has two or three columns.
        return table
    if hasattr(source, "geom_type") or hasattr(source, "geometry"):
        raise TypeError(
            "source: geometries have x and y, and this surface has rows and columns; use the "
            "accessor da.geosweep of an array with coordinates, or give rows and columns"
        )
    values, shape = given("source", source), surface.shape
    if values.shape == shape and values.dtype.kind in "biu":
        cells = np.argwhere(flags("source", values)).astype(np.float64)
        if not len(cells):
            raise ValueError("source: the raster has no cell other than zero and missing ones")
        return Placed(np.column_stack([cells, np.zeros(len(cells))]))
    forms = (
        "source must be (row, col), an array (n, 2), an array (n, 3) with start times, Lines, a "
        f"table, or a boolean or integer raster of the shape {shape}, not "
    )
    if values.dtype.kind not in "biufO" or values.shape == ():
        raise TypeError(forms + described(source))
    found = points_of(values)
    if found is None:
        float_raster = values.shape == shape
        more = "; make a raster boolean: (source > 0)" if float_raster else ""
        raise ValueError(f"{forms}{described(values)}{more}")
    return found


def _zero_of(source: LevelSet, surface: Any) -> Placed:
    """Return the points and lines at which a level set is zero, away from a surface's holes."""
    phi = source.values()
    if phi.shape != surface.shape:
        raise ValueError(f"phi must have the grid's shape {surface.shape}, not {phi.shape}")
    found, curves = _geosweep.level_set(np.where(surface.present, phi, np.nan))
    points = np.zeros((len(found), 3))
    points[:, :2] = np.reshape(found, (-1, 2))
    return Placed(points, [(curve, 0.0) for curve in curves])


def vertices_of(line: ArrayLike) -> Floats:
    """Return the vertices (n, 2) of one of `Lines`."""
    refuse_apart("source", line)
    vertices = numbers("source", line)
    if vertices.ndim != 2 or vertices.shape[1] != 2:
        raise ValueError(
            f"source: each line needs the shape (n, 2), not {vertices.shape}; Lines takes a list "
            "of lines"
        )
    return vertices


def points_of(values: NDArray[Any]) -> Placed | None:
    """Return points from an array (n, 2) of places or (n, 3) with starts, or None for other shapes.

    Rows in which a number is masked are left out.
    """
    if values.size == 0:
        raise ValueError("source is empty; give at least one")
    if values.shape == (2,) or values.shape == (3,):
        values = values[None, :]
    if values.ndim != 2 or values.shape[1] not in (2, 3):
        return None
    count, rows = len(values), None
    if np.ma.is_masked(values):
        rows = np.flatnonzero(~np.ma.getmaskarray(values).any(axis=1))
        values = values[rows]
        if not len(rows):
            raise ValueError("source: all rows are masked")
    array = numbers("source", values)
    if array.shape[1] == 2:
        array = np.column_stack([array, np.zeros(len(array))])
    return Placed(np.ascontiguousarray(array), rows=rows, count=count)


def labels_of(labels: Any, source: Any, found: Placed, shape: tuple[int, int]) -> Any:
    """Return the label of each source as the caller counts them."""
    if isinstance(labels, str):
        if not hasattr(source, "columns") or labels not in source.columns:
            raise ValueError(f"labels={labels!r} is not a column of the table of sources")
        labels = source[labels]
    values = given("labels", labels)
    if values.ndim == 2 and values.shape == shape:
        rows, cols = found.points[:, :2].astype(np.int64).T
        if found.lines or not np.array_equal(found.points[:, 0], rows):
            raise ValueError("labels: a raster of labels is for a raster of sources")
        values = values[rows, cols]
    if values.shape != (found.given,):
        raise ValueError(
            f"labels must have one value for each of {found.given} sources, not {values.shape}"
        )
    return on_host("labels", values)


def on_surface(found: Placed, surface: Any, outside: str) -> Placed:
    """Return sources without points outside a surface or in its holes.

    ``outside`` says what becomes of these: they raise ValueError ("refuse"), are left out ("skip"),
    or are moved to the nearest point of the surface ("snap").
    """
    points = found.points
    there = surface.have_points(points[:, :2])
    if there.all():
        return found
    missed = np.flatnonzero(~there)
    if outside == "refuse":
        first = ", ".join(f"({row:.7g}, {col:.7g})" for row, col in points[missed[:5], :2].tolist())
        more = "" if len(missed) <= 5 else f" and {len(missed) - 5} more"
        rows, cols = surface.shape
        raise ValueError(
            f"{len(missed)} of {len(points)} source points lie outside the grid or in holes (NaN "
            f"or masked out): {first}{more}; rows run from 0 to {rows - 1}, columns from 0 to "
            f"{cols - 1}. sources_outside='skip' leaves them out, 'snap' moves them to the surface"
        )
    if outside == "skip":
        if not there.any() and not found.lines:
            raise ValueError("no source lies on the surface, so nothing is left")
        rows_of = np.arange(found.given) if found.rows is None else found.rows
        kept = np.concatenate([there, np.ones(len(found.lines), np.bool_)])
        return Placed(points[there], found.lines, rows_of[kept], found.given)
    known = np.isfinite(points[missed, :2]).all(axis=1)
    if not known.all():
        raise ValueError(
            f"source point {missed[~known][0]} is not finite, so that no point is nearest to it; "
            "leave it out, as sources_outside='skip' does"
        )
    present = np.argwhere(surface.present)
    steps = surface.spacing or (1.0, 1.0)
    moved = points.copy()
    for index in missed.tolist():
        apart = ((present - points[index, :2]) * steps) ** 2
        moved[index, :2] = present[apart.sum(axis=1).argmin()]
    return Placed(moved, found.lines, found.rows, found.count)

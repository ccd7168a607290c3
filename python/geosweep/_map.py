"""The distance map, and geometry from it."""

from typing import TYPE_CHECKING, Any, Literal, get_args

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _geosweep
from ._arrays import Floats, count, flags, is_count, numbers, real, switch
from ._plot import draw, round_levels
from ._results import Basis, Curves, Path, Ridge, Voronoi
from ._settings import check_choice
from ._sources import Placed, Problem
from ._tables import places_of

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from ._surface import Surface

Direction = Literal["compass", "grass", "grid", "space"]


class LogMap:
    """Places of points in the tangent plane of their source, made by `DistanceMap.log_map`."""

    def __init__(self, compiled: "_geosweep.LogMap", of: "DistanceMap") -> None:
        self._map = compiled
        self._of = of

    def __repr__(self) -> str:
        rows, cols = self.coordinates.shape[:2]
        return f"<geosweep.LogMap: {rows} x {cols} from {len(self._map.bases)} sources>"

    def __reduce__(self) -> tuple[Any, ...]:
        """Pickle the map of distances, from which the log map is computed again."""
        return DistanceMap.log_map, (self._of,)

    @property
    def coordinates(self) -> NDArray[np.float32]:
        """Coordinates u, v (M, N, 2) in the unit of distances; NaN where no source reaches."""
        return self._map.coordinates

    @property
    def nearest(self) -> NDArray[np.int32]:
        """Index (M, N) of the source in whose plane a point lies; -1 where no source reaches."""
        return self._map.labels

    @property
    def bases(self) -> list[Basis]:
        """The axes at each source."""
        return [
            Basis((a, b), (c, d), (e, f), None if space is None else np.asarray(space))
            for (a, b), (c, d), (e, f), space in self._map.bases
        ]

    def place(self, u: float, v: float, source: int = 0) -> tuple[float, float] | None:
        """Return row and column of the point with coordinates (u, v) in the plane of a source.

        The result is None beyond the source's region, a hole or the cut locus.
        """
        at = real("u", u), real("v", v)
        found = self._map.place(count("source", source, 0), at)
        return None if found is None else (found[0], found[1])

    def source_direction(
        self, unit: Literal["compass", "grass"] = "compass"
    ) -> NDArray[np.float32]:
        """Return the bearing (M, N) in which each point's path leaves its source, in degrees.

        `DistanceMap.back_direction` explains the units. The bearing is 0 at sources and -1 where no
        source reaches.
        """
        check_choice("unit", unit, "compass", "grass")
        return self._map.source_direction(unit)


class DistanceMap:
    """Distances from sources to every point of a surface, made by `Surface.solve`."""

    def __init__(
        self,
        surface: "Surface",
        map_: "_geosweep.Map",
        problem: Problem,
        sources: Placed,
        labels: NDArray[Any] | None,
        out: NDArray[Any] | None,
    ) -> None:
        self._whole = surface
        self._surface = surface._surface
        self._map = map_
        self._problem = problem
        self._sources = sources
        self._labels = labels
        self._out = out
        self._report: dict[str, Any] | None = None

    def __repr__(self) -> str:
        report = self.report
        (rows, cols), reached = self._surface.shape, report["reached"]
        return (
            f"<geosweep.DistanceMap: {rows} x {cols}, {reached} of {report['points']} points "
            f"reached, largest distance {report['max_distance']:.7g}>"
        )

    def __reduce__(self) -> tuple[Any, ...]:
        """Pickle the surface, the sources and the distances."""
        state = (self._problem, self._sources, self._labels)
        return _restored, (self._whole, np.asarray(self._map.distance), self.report, *state)

    @property
    def distance(self) -> NDArray[Any]:
        """Distances (M, N), in the surface's unit; inf where no source reaches.

        They are a read-only view of the map, or the array ``out`` if that was given.
        """
        return self._map.distance if self._out is None else self._out

    @property
    def report(self) -> dict[str, Any]:
        """Report on the computation: engine, iterations, residual, converged and more."""
        return self._map.report if self._report is None else dict(self._report)

    @property
    def nearest(self) -> NDArray[Any]:
        """The nearest source (M, N): its number, or its label if labels were given.

        Sources are numbered as they were given: a row of a table or an array, a line, or a cell of
        a raster in row-major order. Where no source reaches, the number is -1, and the label is -1,
        NaN or None.
        """
        numbers = self.voronoi().labels
        return numbers if self._labels is None else _labelled(numbers, self._labels)

    def nearest_places(self) -> Floats:
        """Return row and column (M, N, 2) of the place where each point's path meets its source.

        They are NaN where no source reaches. Paths to lines are traced, which takes time.
        """
        return _geosweep.nearest(self._map)[1]

    def back_direction(self, unit: Direction = "compass") -> NDArray[np.float32]:
        """Return the direction in which each point's shortest path to its source leaves the point.

        Parameters
        ----------
        unit
            ``"compass"``: degrees (M, N) clockwise from north, 90 is east and 360 north, as in
            ArcGIS. ``"grass"``: degrees (M, N) counter-clockwise from east, 90 is north and 360
            east, as in GRASS. ``"grid"``: vectors (M, N, 2) of length 1 in rows and columns.
            ``"space"``: unit vectors (M, N, 3), tangent to the surface.

        Returns
        -------
        directions
            Bearings are 0 at sources and -1 where no source reaches. Vectors are 0 at sources and
            NaN where no source reaches. Over heights rows run to the south and columns to the east.

        Examples
        --------
        >>> import numpy as np, geosweep as gs
        >>> m = gs.Surface.from_heights(np.zeros((21, 21))).solve((10, 10))
        >>> m.back_direction()[10, 0].item(), m.back_direction("grid")[20, 10, 0].item()
        (90.0, -1.0)
        """
        check_choice("unit", unit, *get_args(Direction))
        return _geosweep.back_direction(self._map, unit)

    def back_link(self) -> NDArray[np.int8]:
        """Return the code (M, N) of the next grid point on the way back, as in ArcGIS.

        1 is the neighbour to the east, 2 to the south-east and so on clockwise to 8. The code is 0
        at sources and -1 where no source reaches.
        """
        return _geosweep.back_link(self._map)

    def log_map(self) -> LogMap:
        """Compute the direction in which paths leave their source, times their length.

        The log map needs point sources. For it nine maps are computed in double precision on the
        CPU.

        Examples
        --------
        >>> import numpy as np, geosweep as gs
        >>> m = gs.Surface.from_heights(np.zeros((33, 33)), spacing=(1, 2)).solve((10, 12))
        >>> m.log_map().coordinates[15, 16].round(4).tolist()  # 4 columns and 5 rows away
        [8.0, 5.0]
        """
        return LogMap(_geosweep.log_map(self._map), self)

    def signed(self, inside: ArrayLike | None = None) -> NDArray[Any]:
        """Return the distances (M, N) with a minus inside closed curves.

        Parameters
        ----------
        inside
            Mask (M, N) that is true inside. By default the inside is to the left of the sources, as
            seen with rows downwards. The sources must then be closed lines. On a glued surface
            lines may pass seams, and must divide the surface.

        Returns
        -------
        distances
            Negative inside, positive outside, inf where no source reaches.
        """
        inside = self._whole._aligned("inside", inside)
        mask = None if inside is None else flags("inside", inside)
        if mask is not None and mask.shape != self._surface.shape:
            shape = self._surface.shape
            raise ValueError(f"inside must have the grid's shape {shape}, not {mask.shape}")
        return _geosweep.signed(self._map, mask)

    def error(self) -> Floats:
        """Estimate the error of each distance (M, N), by maps on other grids.

        This takes the time of one and a third maps, or of four to five maps over floor plans.
        """
        return self._surface.error(self._problem)[0]

    def paths(self, ends: ArrayLike) -> list[Path]:
        """Trace the shortest path from each end, rows and columns (n, 2), to its source."""
        array = places_of("ends", ends)
        rows = self._sources.rows
        own = (lambda source: source) if rows is None else (lambda source: int(rows[source]))
        found = self._map.paths(array.tolist())
        return [Path(vertices, length, own(source)) for vertices, length, source in found]

    def contours(
        self, levels: ArrayLike | None = None, *, step: float | None = None
    ) -> list[Curves]:
        """Return the curves of equal distance.

        Parameters
        ----------
        levels
            A number of levels, evenly spaced (default: 10), or the distances themselves.
        step
            Distance between levels, instead of ``levels``.
        """
        if step is not None and levels is not None:
            raise ValueError("give levels or step, the distance between them, and not both")
        if step is not None or levels is None:
            chosen = self._map.levels(None, None if step is None else real("step", step))
        elif isinstance(levels, (bool, np.bool_)):
            raise TypeError(f"levels must be a number of levels or distances, not {levels!r}")
        elif is_count(levels):
            if int(np.asarray(levels)) < 0:
                raise ValueError(f"levels={levels!r}: a number of levels is not negative")
            chosen = self._map.levels(count("levels", levels, 0), None)
        else:
            chosen = numbers("levels", levels).ravel().tolist()
        return [Curves(*curves) for curves in self._map.contours(chosen)]

    def voronoi(self) -> Voronoi:
        """Return the regions of the sources, and their borders.

        The parts of a row of a table, such as the points of a MultiPoint, have one region.
        """
        rows = self._sources.rows
        merged = None if rows is None else (rows.tolist(), self._sources.count)
        labels, borders, areas = self._map.voronoi(merged)
        return Voronoi(labels, [((a, b), line) for (a, b), line in borders], np.asarray(areas))

    def offsets(self, levels: ArrayLike, side: str = "left") -> list[Curves]:
        """Return curves at the given distances on one side of the sources, which must be lines.

        The side is ``"left"`` or ``"right"``, as seen in a picture with rows downwards.
        """
        check_choice("side", side, "left", "right")
        chosen = np.atleast_1d(numbers("levels", levels)).tolist()
        return [Curves(*curves) for curves in self._map.offsets(chosen, side == "left")]

    def ridges(self, least_angle: float = 30.0) -> list[Ridge]:
        """Return the curves where wavefronts meet at ``least_angle`` degrees or more."""
        least = real("least_angle", least_angle)
        return [Ridge(*ridge) for ridge in self._map.ridges(least)]

    def farthest(self) -> tuple[int, int, float]:
        """Return row, column and distance of the farthest point that is reached."""
        return self._map.farthest()

    def plot(
        self,
        ax: "Axes | None" = None,
        *,
        contours: int | ArrayLike = 10,
        paths: ArrayLike | None = None,
        cmap: str = "viridis",
        colorbar: bool = True,
    ) -> "Axes":
        """Draw the distances, lines of equal distance and paths with matplotlib.

        Parameters
        ----------
        ax
            Axes to draw into; by default those of a new figure.
        contours
            Number of lines at round distances, or the distances of the lines. The labels are in the
            map's unit.
        paths
            Rows and columns (n, 2) from which shortest paths are drawn.
        cmap
            Name of the colour map.
        colorbar
            Whether to draw the colour bar.

        Returns
        -------
        ax
            The axes, with rows downwards.
        """
        spacing = self._surface.spacing or (1.0, 1.0)
        lines = self._lines(contours, paths)
        return draw(ax, self.distance, spacing, lines, cmap, switch("colorbar", colorbar))

    def _lines(
        self, contours: int | ArrayLike, paths: ArrayLike | None
    ) -> tuple[list[Curves], list[Path]]:
        """Return the lines of equal distance and the paths of a picture; see `plot`."""
        levels = contours
        if is_count(contours):
            levels = round_levels(self.distance, int(np.asarray(contours)))
        curves = self.contours(levels) if np.size(levels) else []
        return curves, [] if paths is None else self.paths(paths)


def _labelled(numbers: NDArray[np.int32], labels: NDArray[Any]) -> NDArray[Any]:
    """Return the label of each source's number."""
    none: Any = None
    if labels.dtype.kind in "iu" and labels.max() <= np.iinfo(np.int64).max:
        labels, none = labels.astype(np.int64), -1
    elif labels.dtype.kind == "f":
        none = np.nan
    else:
        labels = labels.astype(object)
    found = labels[np.maximum(numbers, 0)]
    found[numbers < 0] = none
    return found


def _restored(
    surface: "Surface",
    distances: NDArray[Any],
    report: dict[str, Any],
    problem: Problem,
    sources: Placed,
    labels: NDArray[Any] | None,
) -> DistanceMap:
    """Restore a map that was pickled."""
    # Arrays of another process may not be aligned.
    distances = np.require(distances, None, ["C", "A"])
    map_ = surface._surface.restored(problem, distances)
    found = DistanceMap(surface, map_, problem, sources, labels, None)
    found._report = report
    return found

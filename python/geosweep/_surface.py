"""Surfaces, and maps in one call."""

import warnings
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike, DTypeLike, NDArray

from . import _geosweep
from ._arrays import Floats, described, flags, is_data_array, numbers, switch
from ._arrays import count as whole
from ._axes import GridAxes
from ._inputs import Inputs
from ._map import DistanceMap
from ._settings import Engine, Wavefront, check_choice, check_progress, is_double, settings
from ._sources import LevelSet, Placed, Source, labels_of, native, on_surface, placed
from ._warnings import SeamWarning, check

Spacing = float | tuple[float, float]
Progress = Callable[[int, int], object]
Line = tuple[tuple[int, int], tuple[int, int]]
Glue = (
    Literal[
        "auto",
        "columns",
        "rows",
        "both",
        "flipped-columns",
        "flipped-rows",
        "globe",
        "octahedral",
        "charts",
    ]
    | Sequence[tuple[Line, Line]]
)


def _steps(spacing: Spacing) -> tuple[float, float]:
    """Return the distances of rows and of columns."""
    wanted = f"spacing must be one number or (dy, dx), not {described(spacing)}"
    try:
        steps = numbers("spacing", spacing)
    except TypeError:
        raise TypeError(wanted) from None
    if steps.shape not in ((), (2,)):
        raise ValueError(wanted)
    dy, dx = np.broadcast_to(steps, (2,)).tolist()
    if not (0 < dy < np.inf and 0 < dx < np.inf):
        raise ValueError(
            f"spacing is ({dy:.10g}, {dx:.10g}), the distances of rows and of columns; both must "
            "be positive and finite"
        )
    return dy, dx


def _kept(name: str, array: ArrayLike, copy: bool) -> Floats:
    """Return an array of float64 in C order that nobody else changes, unless ``copy`` is false.

    Missing values are holes, NaN.
    """
    values = numbers(name, array, np.nan)
    is_shared = np.may_share_memory(values, np.asarray(array))
    return values.copy() if switch("copy", copy) and is_shared else values


def _checked(glue: Glue) -> Any:
    """Return a gluing whose pairs of lines are checked."""
    if isinstance(glue, str):
        return glue
    try:
        ends = np.asarray(glue)
    except ValueError:
        ends = np.empty(0)
    if ends.ndim != 4 or ends.shape[1:] != (2, 2, 2) or ends.dtype.kind not in "iu":
        raise TypeError(
            "glue must be a name, or pairs of lines, each given by its first and last (row, col): "
            f"[(((0, 0), (0, 9)), ((5, 0), (5, 9)))]; not {described(glue)}"
        )
    if ends.min() < 0:
        raise ValueError(f"glue: {ends.min()} is no row or column, which count from 0")
    return [tuple(tuple(map(tuple, line)) for line in pair) for pair in ends.tolist()]


class Surface:
    """A grid of points with a geometry, holes and perhaps a slowness.

    Make it by `from_heights`, `from_positions` or `from_metric`.
    """

    def __init__(
        self,
        compiled: "_geosweep.Surface",
        glued: tuple[Glue, ...] = (),
        axes: GridAxes | None = None,
        read: NDArray[Any] | None = None,
    ) -> None:
        if not isinstance(compiled, _geosweep.Surface):
            raise TypeError("use Surface.from_heights, from_positions or from_metric")
        self._surface = compiled
        self._glued = glued
        self._axes = axes
        self._read = read

    def __repr__(self) -> str:
        rows, cols = self.shape
        glued = ", glued" if self.is_glued else ""
        return f"<geosweep.Surface: {rows} x {cols} {self._surface.kind}{glued}>"

    def __dask_tokenize__(self) -> tuple[Any, ...]:
        return ("geosweep.Surface", *self.__reduce__()[1])

    def __reduce__(self) -> tuple[Any, ...]:
        """Pickle the arrays of which the surface was made."""
        made = self._surface
        inputs = (made.present, made.slowness, made.edges, self._glued, self._axes)
        return _restored, (made.kind, made.values(), self.shape, made.spacing, *inputs)

    @staticmethod
    def _made(
        compiled: "_geosweep.Surface",
        inputs: Inputs,
        edges: str,
        glue: Glue | None,
        axes: GridAxes | None = None,
        read: NDArray[Any] | None = None,
    ) -> "Surface":
        check_choice("edges", edges, "arc", "chord")
        points, slow = inputs.on(compiled.shape)
        if points is not None or slow is not None or edges == "chord":
            compiled = compiled.with_inputs(points, slow, edges == "chord")
        if glue is not None:
            compiled = compiled.with_gluing(_checked(glue))
        return Surface(compiled, () if glue is None else (glue,), axes, read)

    @classmethod
    def from_heights(
        cls,
        heights: ArrayLike,
        spacing: Spacing | None = None,
        *,
        mask: ArrayLike | None = None,
        holes: ArrayLike | None = None,
        slowness: ArrayLike | None = None,
        speed: ArrayLike | None = None,
        edges: str = "arc",
        glue: Glue | None = None,
        copy: bool = True,
    ) -> "Surface":
        """Make a height field.

        Parameters
        ----------
        heights
            Heights (M, N). NaN is a hole, and so is a value that is missing: one that a NumPy array
            masks, or an array of xarray names as its fill value.
        spacing
            Distance of rows and of columns in the unit of the heights. It is in the order of the
            axes, (dy, dx), as in scikit-fmm and scikit-image. The command-line tool takes DX,DY. By
            default it is that of the coordinates of an array of xarray, which must run north to
            south and west to east, and otherwise 1.
        mask
            Mask (M, N) that is true where there are points and false at holes, the reverse of
            NumPy's masks. NaN and missing values are holes.
        holes
            Mask (M, N) that is true at holes, like NumPy's masks.
        slowness
            Reciprocal speed (M, N): distances become travel times. Infinite, NaN and missing values
            are walls, and 0 is free travel.
        speed
            Speed (M, N), the reciprocal of a slowness. Zero, NaN and missing values are walls.
        edges
            ``"arc"`` measures edges along the smooth surface, ``"chord"`` straight through space.
        glue
            Sides of the grid that are the same line of a closed surface; see `with_gluing`.
        copy
            Whether to copy the heights. Otherwise an array of float64 in C order is read where
            it is, and must not change while the surface is used.
        """
        inputs, axes = Inputs(mask, holes, slowness, speed), None
        values = _kept("heights", heights, copy)
        if values.ndim != 2:
            raise ValueError(
                f"heights must have the shape (M, N), not {values.shape}; select a band or a time"
            )
        if is_data_array(heights):
            from .xarray import spacing_of

            axes = GridAxes.of(heights)
            inputs = inputs.aligned(axes)
            spacing = spacing_of(heights) if spacing is None else spacing
        made = _geosweep.Surface.heights(values, *_steps(1.0 if spacing is None else spacing))
        return cls._made(made, inputs, edges, glue, axes, None if copy else values)

    @classmethod
    def from_positions(
        cls,
        positions: ArrayLike,
        *,
        mask: ArrayLike | None = None,
        holes: ArrayLike | None = None,
        slowness: ArrayLike | None = None,
        speed: ArrayLike | None = None,
        edges: str = "arc",
        glue: Glue | None = None,
        copy: bool = True,
    ) -> "Surface":
        """Make a surface from 3D points.

        Parameters
        ----------
        positions
            Coordinates (M, N, 3). A point with a NaN or a missing value is a hole.
        mask, holes, slowness, speed, edges, glue, copy
            As in `from_heights`.

        Warns
        -----
        SeamWarning
            If sides of the grid coincide and are not glued, since no path crosses them.

        Examples
        --------
        A globe whose last column repeats its first one:

        >>> import numpy as np, geosweep as gs
        >>> p, l = np.mgrid[0:181:2, 0:361:2] * np.pi / 180
        >>> xyz = np.stack([np.sin(p) * np.cos(l), np.sin(p) * np.sin(l), np.cos(p)], axis=-1)
        >>> globe = gs.Surface.from_positions(xyz, glue="globe")
        >>> d = globe.solve((45, 10)).distance
        >>> round(d[45, 170].item(), 3)  # 20 steps of 2 degrees across the seam
        0.698
        """
        values = _kept("positions", positions, copy)
        if values.ndim != 3 or values.shape[2] != 3:
            raise ValueError(f"positions must have the shape (M, N, 3), not {values.shape}")
        compiled = _geosweep.Surface.positions(values)
        inputs = Inputs(mask, holes, slowness, speed)
        made = cls._made(compiled, inputs, edges, glue, read=None if copy else values)
        open_seams = [seam for seam in made.seams if "single point" not in seam]
        if open_seams:
            warnings.warn(
                f"the surface is closed: {', '.join(open_seams)}; no path crosses such a seam "
                "unless it is glued (glue=)",
                SeamWarning,
                stacklevel=2,
            )
        return made

    @classmethod
    def from_metric(
        cls,
        metric: ArrayLike,
        *,
        mask: ArrayLike | None = None,
        holes: ArrayLike | None = None,
        slowness: ArrayLike | None = None,
        speed: ArrayLike | None = None,
        glue: Glue | None = None,
    ) -> "Surface":
        """Make a surface from its metric in steps of rows and columns.

        The metric is (M, N, 2, 2), or (M, N, 3) with the entries row-row, row-column and
        column-column.
        """
        values = numbers("metric", metric, np.nan)
        if values.ndim == 4 and values.shape[2:] == (2, 2):
            if not np.array_equal(values[..., 0, 1], values[..., 1, 0], equal_nan=True):
                raise ValueError("metric must be symmetric: its entries 0, 1 and 1, 0 differ")
            values = np.ascontiguousarray(values.reshape(*values.shape[:2], 4)[..., [0, 1, 3]])
        if values.ndim != 3 or values.shape[2] != 3:
            raise ValueError(
                f"metric must have the shape (M, N, 2, 2) or (M, N, 3), not {values.shape}"
            )
        inputs = Inputs(mask, holes, slowness, speed)
        return cls._made(_geosweep.Surface.metric(values), inputs, "arc", glue)

    def with_gluing(self, glue: Glue) -> "Surface":
        """Return the surface with sides of the grid joined, where the surface is closed.

        Both sides must hold the points of the seam: the last column of a tube repeats its first.

        Parameters
        ----------
        glue
            ``"columns"`` (tubes), ``"rows"``, ``"both"`` (tori), ``"flipped-columns"`` (Moebius
            strips), ``"flipped-rows"``, ``"globe"`` (latitudes by longitudes, a row at each pole),
            ``"octahedral"``, ``"charts"`` (the faces of a cube), ``"auto"`` (all sides of positions
            that coincide), or pairs of lines, each given by its first and last (row, column).
        """
        glued = self._surface.with_gluing(_checked(glue))
        return Surface(glued, (*self._glued, glue), self._axes, self._read)

    @property
    def is_glued(self) -> bool:
        """Whether sides of the grid are joined."""
        return self._surface.is_glued

    @property
    def seams(self) -> list[str]:
        """Descriptions of unglued sides that coincide, are neighbours or are one point."""
        return self._surface.seams

    @property
    def shape(self) -> tuple[int, int]:
        """Numbers of rows and columns."""
        return self._surface.shape

    @property
    def points(self) -> int:
        """Number of points that are not holes."""
        return self._surface.points

    @property
    def present(self) -> NDArray[np.bool_]:
        """Whether each point (M, N) is not a hole, as a read-only view."""
        return self._surface.present

    @property
    def is_floor_plan(self) -> bool:
        """Whether the surface is flat and even, so that ``"anchored"`` fronts are exact."""
        return self._surface.is_floor_plan

    def solve(
        self,
        source: Source,
        *,
        wavefront: Wavefront = "auto",
        engine: Engine = "auto",
        device: str | int | None = None,
        dtype: DTypeLike = "float32",
        tolerance: float | None = None,
        iterations: int | None = None,
        radius: float | None = None,
        targets: ArrayLike | None = None,
        needed: int | None = None,
        threads: int | None = None,
        strict: bool = False,
        progress: Progress | None = None,
        out: NDArray[Any] | None = None,
        labels: Any = None,
        sources_outside: Literal["refuse", "skip", "snap"] = "refuse",
    ) -> DistanceMap:
        """Compute the distance from the sources to every point.

        Parameters
        ----------
        source
            (row, col); (n, 2); (n, 3) with start times; `Lines`; a `LevelSet`; a table with columns
            row and col, and perhaps start; or a boolean or integer raster (M, N), whose cells other
            than zero and missing ones are sources. Rows of an array with a masked number are left
            out.
        wavefront
            Front assumed inside a triangle.
        engine
            ``"cpu"``, ``"gpu"`` (a Vulkan device) or ``"auto"``.
        device
            Index, or a part of the name, of the Vulkan device; see `devices`. It implies
            ``engine="gpu"``.
        dtype
            Precision of the map: ``"float32"``, or on the CPU ``"float64"``.
        tolerance, iterations
            Limits at which to stop: the relative change, and the number of iterations.
        radius
            Largest distance. Farther points are unreached, and not computed. With ``targets`` too,
            the map ends where the first of both limits is.
        targets
            Grid points (n, 2) that the map is for. Points farther than the farthest of them are
            unreached, and not computed.
        needed
            Number of the nearest targets that are needed; all by default.
        threads
            Number of threads of the CPU. By default all calls share as many as there are cores.
        strict
            Whether a map that has not converged is an error. Otherwise it is a warning.
        progress
            Called with the per cent that are done and 100, some 50 times a second and at the end.
            On a device, nothing is known before the end.
        out
            Array (M, N) of ``dtype`` that takes the distances.
        labels
            Values that `DistanceMap.nearest` brings back in place of the sources' numbers: one for
            each source, the name of a column of the table, or for a raster of sources a raster of
            labels, which may be the same one.
        sources_outside
            What becomes of points outside the grid or in holes: they are an error, left out
            (``"skip"``), or moved to the nearest point of the surface (``"snap"``).
        """
        double = _precision(dtype, out, self.shape)
        if out is not None and self._read is not None and np.may_share_memory(out, self._read):
            raise ValueError(
                "out lies in the array that the surface reads (copy=False); give another one"
            )
        chosen = settings(
            engine, device, wavefront, tolerance, iterations, threads, radius, targets, needed
        )
        strict = switch("strict", strict)
        check_progress(progress)
        source, labels = self._aligned("source", source), self._aligned("labels", labels)
        sources = self._placed(source, sources_outside)
        names = None if labels is None else labels_of(labels, source, sources, self.shape)
        problem = (sources.points, sources.lines, chosen, double)
        found = self._surface.solve(problem, progress)
        report = found.report
        check(report["converged"], report, strict)
        if out is not None:
            np.copyto(out, found.distance)
        return DistanceMap(self, found, problem, sources, names, out)

    def _placed(self, source: Source, outside: str) -> Placed:
        """Return sources on the surface, as the compiled part takes them."""
        check_choice("sources_outside", outside, "refuse", "skip", "snap")
        return on_surface(placed(source, self._surface), self._surface, outside)

    def _aligned(self, name: str, value: Any) -> Any:
        """Return a raster of xarray in the order of the grid, if that was made of another one."""
        axes = self._axes
        return value if axes is None or not axes.are_those_of(value) else axes.north_up(name, value)

    def farthest_points(self, source: Source, count: int) -> tuple[NDArray[np.int64], float]:
        """Sample the surface evenly.

        Each sample is the point farthest from the source and all samples before.

        Returns
        -------
        samples
            Rows and columns (count, 2); fewer if the surface has no more points.
        radius
            Largest distance of a point from the nearest sample or source.
        """
        wanted = native(self._aligned("source", source), self._surface)
        samples, radius = self._surface.farthest_points(*wanted, whole("count", count, 0))
        return np.asarray(samples, dtype=np.int64).reshape(-1, 2), radius


def _restored(
    kind: str,
    values: Floats,
    shape: tuple[int, int],
    spacing: tuple[float, float] | None,
    present: NDArray[np.bool_],
    slowness: Floats | None,
    edges: str,
    glued: tuple[Glue, ...],
    axes: GridAxes | None,
) -> Surface:
    """Restore a surface that was pickled."""
    values = numbers("values", values)
    if kind == "heights":
        assert spacing is not None
        compiled = _geosweep.Surface.heights(values.reshape(shape), *spacing)
    else:
        make = _geosweep.Surface.positions if kind == "positions" else _geosweep.Surface.metric
        compiled = make(values.reshape(*shape, 3))
    surface = Surface._made(compiled, Inputs(mask=present, slowness=slowness), edges, None, axes)
    for glue in glued:
        surface = surface.with_gluing(glue)
    return surface


def _precision(dtype: DTypeLike, out: object, shape: tuple[int, ...]) -> bool:
    """Return whether maps are in double precision; check that ``out``, if given, can take one."""
    double = is_double(dtype)
    if out is not None:
        check_out(out, shape, np.float64 if double else np.float32)
    return double


def compiled_of(surface: object) -> "_geosweep.Surface":
    """Return the compiled part of a surface, or raise TypeError for other values."""
    if isinstance(surface, Surface):
        return surface._surface
    raise TypeError(
        f"surface must be a geosweep.Surface, not {type(surface).__name__}; make it by "
        "Surface.from_heights, from_positions or from_metric"
    )


def check_out(out: object, shape: tuple[int, ...], dtype: DTypeLike) -> None:
    """Check that an array can take results."""
    if not isinstance(out, np.ndarray) or isinstance(out, np.ma.MaskedArray):
        raise TypeError(f"out must be a plain NumPy array, not {type(out).__name__}")
    if not out.flags.writeable:
        raise ValueError("out is read-only, so that it cannot take results")
    if out.shape != shape or out.dtype != dtype:
        raise ValueError(
            f"out must be an array of {np.dtype(dtype)} with the shape {shape}, not of "
            f"{out.dtype} with {out.shape}"
        )


def distance(
    heights: ArrayLike,
    source: Source,
    spacing: Spacing | None = None,
    *,
    mask: ArrayLike | None = None,
    holes: ArrayLike | None = None,
    slowness: ArrayLike | None = None,
    speed: ArrayLike | None = None,
    edges: str = "arc",
    glue: Glue | None = None,
    wavefront: Wavefront = "auto",
    engine: Engine = "auto",
    device: str | int | None = None,
    dtype: DTypeLike = "float32",
    tolerance: float | None = None,
    iterations: int | None = None,
    radius: float | None = None,
    targets: ArrayLike | None = None,
    needed: int | None = None,
    threads: int | None = None,
    strict: bool = False,
    progress: Progress | None = None,
    out: NDArray[Any] | None = None,
    sources_outside: Literal["refuse", "skip", "snap"] = "refuse",
) -> NDArray[Any]:
    """Compute the distance (M, N) from the sources over a height field.

    The arguments are those of `Surface.from_heights` and `Surface.solve`. An array of float64 in
    C order is not copied. The result is inf where no source reaches.
    """
    surface = Surface.from_heights(
        heights,
        spacing,
        mask=mask,
        holes=holes,
        slowness=slowness,
        speed=speed,
        edges=edges,
        glue=glue,
        copy=False,
    )
    double = _precision(dtype, out, surface.shape)
    chosen = settings(
        engine, device, wavefront, tolerance, iterations, threads, radius, targets, needed
    )
    strict = switch("strict", strict)
    check_progress(progress)
    sources = surface._placed(surface._aligned("source", source), sources_outside)
    problem = (sources.points, sources.lines, chosen, double)
    found, report = surface._surface.distances(problem, progress)
    check(report["converged"], report, strict)
    if out is None:
        return found
    np.copyto(out, found)
    return out


def travel_time(
    source: Source | None = None,
    spacing: Spacing | None = None,
    *,
    phi: ArrayLike | None = None,
    speed: ArrayLike | None = None,
    slowness: ArrayLike | None = None,
    mask: ArrayLike | None = None,
    holes: ArrayLike | None = None,
    glue: Glue | None = None,
    wavefront: Wavefront = "auto",
    dtype: DTypeLike = "float32",
    radius: float | None = None,
    targets: ArrayLike | None = None,
    needed: int | None = None,
    threads: int | None = None,
    strict: bool = False,
    progress: Progress | None = None,
    out: NDArray[Any] | None = None,
    sources_outside: Literal["refuse", "skip", "snap"] = "refuse",
) -> NDArray[Any]:
    """Compute the travel time (M, N) from the sources over a flat grid.

    Parameters
    ----------
    source
        As in `Surface.solve`.
    spacing
        Distance of rows and of columns, (dy, dx), or one number for both.
    phi
        Level set (M, N) in place of ``source``: fronts start where it is zero, to both sides, as in
        scikit-fmm (`LevelSet`). Points at which it is masked or NaN are holes.
    speed, slowness
        One of both, (M, N). Zero speed, infinite slowness, NaN and masked values are walls.
    mask, holes, glue, wavefront, dtype, radius, targets, needed, threads, strict, progress, out
        As in `Surface.from_heights` and `Surface.solve`. For many maps of one grid make a
        `Surface` with the slowness, and `Surface.solve`: it keeps its edges.
    sources_outside
        As in `Surface.solve`.

    Returns
    -------
    Travel times in the unit of spacing over speed, inf where no source reaches. Times are positive
    on both sides of a level set.

    Examples
    --------
    >>> import numpy as np, geosweep as gs
    >>> row, col = np.mgrid[:41, :61]
    >>> speed = np.where(col < 30, 1.0, 2.0)
    >>> time = gs.travel_time(phi=row - 10.5, speed=speed, spacing=0.5)
    >>> round(time[20, 5].item(), 3), round(time[20, 50].item(), 3)
    (4.75, 2.375)
    """
    field = slowness if speed is None else speed
    if field is None:
        raise ValueError("travel_time needs speed= or slowness=; distance() has neither")
    if (source is None) == (phi is None):
        raise ValueError("travel_time needs a source or phi=, a level set, and not both")
    if phi is not None:
        source = LevelSet(phi)
    if isinstance(source, LevelSet):
        unknown = np.isnan(source.values())
        holes = unknown if holes is None else unknown | flags("holes", holes, missing=True)
    assert source is not None
    shape = np.shape(field)
    if len(shape) != 2:
        raise ValueError(f"speed and slowness must have the shape (M, N), not {shape}")
    flat: Any = np.zeros(shape)
    if is_data_array(field):
        flat = field.copy(data=flat)  # type: ignore[union-attr]
    return distance(
        flat,
        source,
        spacing,
        mask=mask,
        holes=holes,
        slowness=slowness,
        speed=speed,
        glue=glue,
        wavefront=wavefront,
        dtype=dtype,
        radius=radius,
        targets=targets,
        needed=needed,
        threads=threads,
        strict=strict,
        progress=progress,
        out=out,
        sources_outside=sources_outside,
    )


def route(
    heights: ArrayLike,
    start: tuple[float, float],
    end: tuple[float, float],
    spacing: Spacing | None = None,
    *,
    mask: ArrayLike | None = None,
    holes: ArrayLike | None = None,
    slowness: ArrayLike | None = None,
    speed: ArrayLike | None = None,
) -> tuple[Floats, float]:
    """Find the shortest path over a height field.

    Returns
    -------
    path
        Rows and columns (n, 2) from the start to the end.
    length
        Length of the path; with a slowness, its travel time.
    """
    surface = Surface.from_heights(
        heights, spacing, mask=mask, holes=holes, slowness=slowness, speed=speed, copy=False
    )
    path = surface.solve(end).paths([start])[0]
    return path.vertices, path.length


@dataclass(frozen=True)
class Device:
    """A Vulkan device."""

    index: int
    name: str
    kind: str
    api_version: str
    driver: str
    unmet: list[str]
    """Requirements that the device does not meet; empty if the device can be used."""


def devices() -> list[Device]:
    """List the Vulkan devices of this machine."""
    return [Device(*device) for device in _geosweep.devices()]

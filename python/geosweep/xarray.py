"""The accessor ``da.geosweep`` of xarray's arrays of heights.

>>> import numpy as np, xarray as xr, geosweep.xarray
>>> x, y = 500000 + 30.0 * np.arange(80), 4000000 - 30.0 * np.arange(60)
>>> heights = xr.DataArray(np.zeros((60, 80)), {"y": y, "x": x}, ("y", "x"))
>>> d = heights.geosweep.distance((500300, 3999400))
>>> round(d.sel(x=500660, y=3999130).item())
450
"""

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _frames, _plot
from ._arrays import Floats, numbers
from ._map import DistanceMap
from ._optional import needed
from ._place import Place
from ._sources import Lines, Mixed, Source
from ._surface import Surface

if TYPE_CHECKING:
    import xarray as xr
    from geopandas import GeoDataFrame
    from matplotlib.axes import Axes
else:
    xr = needed("xarray", "xarray", "da.geosweep")

_X = {"x", "lon", "longitude", "easting"}
_Y = {"y", "lat", "latitude", "northing"}
# Attributes that describe the values of the heights. Results do not take them over.
_OF_VALUES = {
    "long_name",
    "standard_name",
    "scale_factor",
    "add_offset",
    "_FillValue",
    "missing_value",
    "valid_min",
    "valid_max",
    "valid_range",
    "actual_range",
}
# The largest accepted deviation of a coordinate from even spacing, as a fraction of a step.
_UNEVEN = 1e-3


@dataclass(frozen=True)
class _Grid:
    """The relation between the user's array and the grid, which is north up."""

    template: "xr.DataArray"
    place: Place
    turned: bool
    """Whether the array has columns first."""
    flips: tuple[slice, slice]
    """Steps of 1 or -1 along y and x."""

    def north_up(self, name: str, array: ArrayLike) -> NDArray[Any]:
        """Return the values of an array of the template's shape in the order of the grid."""
        if isinstance(array, xr.DataArray):
            array = _like(name, array, self.template)
        values = np.asarray(array)
        if values.shape not in (self.template.shape, self.template.shape[-2:]):
            shape = self.template.shape
            raise ValueError(f"{name} must have the array's shape {shape}, not {values.shape}")
        values = values.reshape(self.template.shape[-2:])
        return (values.T if self.turned else values)[self.flips]

    def back(self, name: str, values: NDArray[Any], description: str) -> "xr.DataArray":
        """Return values on the grid as an array with the template's coordinates and attributes."""
        values = values[self.flips]
        values = np.ascontiguousarray(values.T if self.turned else values)
        made = self.template.copy(data=values.reshape(self.template.shape)).rename(name)
        made.attrs = {
            key: value
            for key, value in self.template.attrs.items()
            if key not in _OF_VALUES and not key.startswith("STATISTICS_")
        } | {"long_name": description}
        kept = {"grid_mapping", "coordinates"}
        made.encoding = {key: made.encoding[key] for key in kept if key in made.encoding}
        if values.dtype.kind == "f":
            made.encoding["_FillValue"] = np.nan
        return made


def _like(name: str, array: "xr.DataArray", template: "xr.DataArray") -> "xr.DataArray":
    """Return an array with its dimensions in the template's order.

    Its coordinates must be those of the template.
    """
    try:
        array = array.squeeze(drop=True).transpose(*template.dims[-2:])
        xr.align(array, template.squeeze(drop=True), join="exact", copy=False)
    except ValueError as error:
        raise ValueError(f"{name} must have the coordinates of the heights: {error}") from error
    return array


def _crs(da: "xr.DataArray") -> str | None:
    """Return the coordinate reference system as WKT, from rioxarray or CF's attributes."""
    if hasattr(da, "rio") and da.rio.crs is not None:
        return str(da.rio.crs.to_wkt())
    for name in (da.encoding.get("grid_mapping"), da.attrs.get("grid_mapping"), "spatial_ref"):
        if name in da.coords:
            attrs = da.coords[name].attrs
            found = attrs.get("crs_wkt", attrs.get("spatial_ref"))
            if found:
                return str(found)
    found = da.attrs.get("crs")
    return None if found is None else str(found)


def _steps(da: "xr.DataArray", dim: str) -> tuple[float, float]:
    """Return the first coordinate along a dimension, and the step between coordinates."""
    if dim not in da.coords:
        raise ValueError(
            f"the array has no coordinates along {dim!r}; assign them, or use geosweep.distance"
        )
    values = da.coords[dim].values
    if values.dtype.kind not in "iuf" or len(values) < 2:
        raise ValueError(f"{dim!r} must have two coordinates or more, which are numbers")
    values = values.astype(np.float64)
    step = (values[-1] - values[0]) / (len(values) - 1)
    even = values[0] + step * np.arange(len(values))
    if step == 0 or not (np.abs(values - even) <= _UNEVEN * abs(step)).all():
        raise ValueError(
            f"the coordinates along {dim!r} are not evenly spaced; resample them, or give the "
            "points to geosweep.Surface.from_positions"
        )
    return float(values[0]), float(step)


def _refuse_degrees(da: "xr.DataArray", dims: tuple[str, str], crs: str | None) -> None:
    units = [str(da.coords[dim].attrs.get("units", "")).lower() for dim in dims]
    geographic = ("GEOGCS", "GEOGCRS", "GEODCRS", "EPSG:4326", "OGC:CRS84")
    is_geographic = crs is not None and crs.upper().startswith(geographic)
    named = {"lon", "longitude", "lat", "latitude"} & {str(dim).lower() for dim in dims}
    if is_geographic or any(unit.startswith("degree") for unit in units) or named:
        raise ValueError(
            f"the coordinates {dims[1]!r} and {dims[0]!r} are degrees, which have no length; "
            "project the array first, with rioxarray: da.rio.reproject(da.rio.estimate_utm_crs())"
        )


def _grid(da: "xr.DataArray") -> _Grid:
    if da.ndim < 2 or any(size != 1 for size in da.shape[:-2]):
        raise ValueError(
            f"heights need two dimensions, y and x; this array has {dict(da.sizes)}; select a band "
            "or a time first"
        )
    first, second = (str(dim) for dim in da.dims[-2:])
    turned = first.lower() in _X or second.lower() in _Y
    y, x = (second, first) if turned else (first, second)
    (y0, dy), (x0, dx) = _steps(da, y), _steps(da, x)
    crs = _crs(da)
    _refuse_degrees(da, (y, x), crs)
    shape = (da.sizes[y], da.sizes[x])
    # Rows run to the south, columns to the east.
    top = y0 if dy < 0 else y0 + dy * (shape[0] - 1)
    left = x0 if dx > 0 else x0 + dx * (shape[1] - 1)
    flips = (slice(None, None, 1 if dy < 0 else -1), slice(None, None, 1 if dx > 0 else -1))
    return _Grid(da, Place(left, top, abs(dx), abs(dy), shape, crs), turned, flips)


def _without_fill(da: "xr.DataArray", values: NDArray[Any]) -> Floats:
    """Return heights as float64, with NaN in place of the values that stand for holes."""
    heights = numbers("heights", values)
    for key in ("_FillValue", "missing_value"):
        if key in da.attrs:
            fill = np.asarray(da.attrs[key], dtype=np.float64)
            heights = np.where(np.isin(heights, fill), np.nan, heights)
    return heights


class GeoMap:
    """A distance map whose points have coordinates. ``da.geosweep.solve`` makes it."""

    def __init__(self, grid: _Grid, map_: DistanceMap) -> None:
        self._grid = grid
        self.map = map_
        """The map on the grid, with rows from north to south and columns from west to east."""

    @property
    def distance(self) -> "xr.DataArray":
        """Distances, NaN where no source reaches, with the coordinates of the heights."""
        found = self.map.distance
        shown = np.where(np.isfinite(found), found, np.asarray(np.nan, found.dtype))
        return self._grid.back("distance", shown, "geodesic distance")

    @property
    def nearest(self) -> "xr.DataArray":
        """Index of the nearest source; -1 where no source reaches."""
        return self._grid.back("nearest", self.map.nearest, "index of the nearest source")

    def back_direction(self, unit: Literal["compass", "grass"] = "compass") -> "xr.DataArray":
        """Return the bearing of the way back in degrees; see `DistanceMap.back_direction`."""
        if unit not in ("compass", "grass"):
            raise ValueError(f"unit={unit!r} is unknown; choose 'compass' or 'grass'")
        found = self.map.back_direction(unit)
        return self._grid.back("back_direction", found, "direction of the way back, in degrees")

    def back_link(self) -> "xr.DataArray":
        """Return the code of the next grid point on the way back; see `DistanceMap.back_link`."""
        return self._grid.back("back_link", self.map.back_link(), "next cell on the way back")

    def error(self) -> "xr.DataArray":
        """Estimate the error of each distance; see `DistanceMap.error`."""
        return self._grid.back("error", self.map.error(), "estimated error of the distance")

    def paths(self, ends_xy: "ArrayLike | GeoDataFrame") -> "GeoDataFrame":
        """Trace the shortest path from each end, given as x and y (n, 2) or a table of points.

        The columns of the result are ``length`` and ``source``.
        """
        return _frames.paths_table(self.map.paths(_ends(ends_xy, self._grid.place)), self._place)

    def contours(
        self, levels: ArrayLike | None = None, *, step: float | None = None
    ) -> "GeoDataFrame":
        """Return the curves of equal distance; see `DistanceMap.contours`."""
        return _frames.contours_table(self.map.contours(levels, step=step), self._place)

    def regions(self) -> "GeoDataFrame":
        """Return the region of each source, as the cells around its points, and its area.

        The area is measured on the surface. `borders` returns the borders themselves, which run
        between the points.
        """
        return _frames.regions_table(self.map.voronoi(), self._place)

    def borders(self) -> "GeoDataFrame":
        """Return the curves between the regions of two sources."""
        return _frames.borders_table(self.map.voronoi(), self._place)

    def plot(
        self,
        ax: "Axes | None" = None,
        *,
        contours: int | ArrayLike = 10,
        paths: "ArrayLike | GeoDataFrame | None" = None,
        cmap: str = "viridis",
        colorbar: bool = True,
    ) -> "Axes":
        """Draw the map in its coordinates; see `DistanceMap.plot`."""
        place = self._place
        (left, top), (right, bottom) = place.to_xy(
            np.array([[-0.5, -0.5], np.subtract(place.shape, 0.5)])
        )
        extent = (left, right, bottom, top)
        lines = self.map._lines(contours, None if paths is None else _ends(paths, place))
        ax = _plot.raster(ax, self.map.distance, extent, 1.0, cmap, colorbar)
        _plot.add_lines(ax, lines, place.to_xy)
        ax.ticklabel_format(style="plain", useOffset=False)
        ax.locator_params(axis="x", nbins=4)
        ax.set_xlabel("x")
        ax.set_ylabel("y")
        return ax

    @property
    def _place(self) -> Place:
        return self._grid.place


def _ends(ends: Any, place: Place) -> Floats:
    if _frames.is_table(ends):
        return _frames.points_of("ends", ends, place)
    xy = np.atleast_2d(numbers("ends", ends))
    if xy.ndim != 2 or xy.shape[1] != 2:
        raise ValueError(f"ends must be x and y (n, 2), not {xy.shape}")
    return place.to_grid("ends", xy)


@xr.register_dataarray_accessor("geosweep")
class Accessor:
    """Distances over an array of heights with coordinates x and y.

    Spacing comes from the coordinates, which must be lengths and evenly spaced. Rows may run to
    the north or to the south. The heights have the unit of the coordinates.
    """

    def __init__(self, da: "xr.DataArray") -> None:
        self._da = da

    def _source(self, source: Any, grid: _Grid) -> Source:
        place = grid.place
        if _frames.is_table(source):
            return _frames.sources_of(source, place)
        if isinstance(source, Lines):
            lines = [place.to_grid("source", numbers("source", xy)) for xy in source.vertices]
            return Lines(lines, source.starts)
        if isinstance(source, xr.DataArray) or np.shape(source) == self._da.shape:
            cells: NDArray[np.bool_] = grid.north_up("source", source) != 0
            return cells
        array = np.atleast_2d(numbers("source", source))
        if array.ndim != 2 or array.shape[1] not in (2, 3):
            raise ValueError(
                "source must be (x, y), an array (n, 2), an array (n, 3) with start times, Lines, "
                f"a GeoDataFrame, or a raster like the heights, not of the shape {array.shape}"
            )
        starts = array[:, 2] if array.shape[1] == 3 else np.zeros(len(array))
        return Mixed(np.column_stack([place.to_grid("source", array[:, :2]), starts]), [])

    def surface(
        self,
        *,
        mask: ArrayLike | None = None,
        slowness: ArrayLike | None = None,
        edges: str = "arc",
    ) -> Surface:
        """Return the surface, with rows to the south and columns to the east.

        Parameters
        ----------
        mask, slowness
            As in `Surface.from_heights`, with the array's shape or as DataArrays.
        edges
            As in `Surface.from_heights`.
        """
        return self._surface(_grid(self._da), mask, slowness, edges)

    def _surface(
        self, grid: _Grid, mask: ArrayLike | None, slowness: ArrayLike | None, edges: str
    ) -> Surface:
        return Surface.from_heights(
            _without_fill(self._da, grid.north_up("heights", self._da)),
            (grid.place.dy, grid.place.dx),
            mask=None if mask is None else grid.north_up("mask", mask),
            slowness=None if slowness is None else grid.north_up("slowness", slowness),
            edges=edges,
        )

    def solve(
        self,
        source_xy: Any,
        *,
        mask: ArrayLike | None = None,
        slowness: ArrayLike | None = None,
        edges: str = "arc",
        **options: Any,
    ) -> GeoMap:
        """Compute a map with coordinates, for paths, contours, regions and pictures.

        Parameters
        ----------
        source_xy
            (x, y); (n, 2); (n, 3) with start times; `Lines` of x and y; a GeoDataFrame of points
            and lines, perhaps with a column ``start``; or a raster like the heights.
        mask, slowness, edges
            As in `surface`.
        options
            As in `Surface.solve`.
        """
        grid = _grid(self._da)
        surface = self._surface(grid, mask, slowness, edges)
        return GeoMap(grid, surface.solve(self._source(source_xy, grid), **options))

    def distance(self, source_xy: Any, **options: Any) -> "xr.DataArray":
        """Compute distances, NaN where no source reaches.

        The parameters are those of `solve`. The result keeps the coordinates, dimensions,
        attributes and the CRS of the heights.
        """
        return self.solve(source_xy, **options).distance

"""The accessor ``da.geosweep`` of xarray's arrays of heights.

>>> import numpy as np, xarray as xr, geosweep.xarray
>>> x, y = 500000 + 30.0 * np.arange(80), 4000000 - 30.0 * np.arange(60)
>>> heights = xr.DataArray(np.zeros((60, 80)), {"y": y, "x": x}, ("y", "x"))
>>> d = heights.geosweep.distance((500300, 3999400))
>>> round(d.sel(x=500660, y=3999130).item())
450
"""

import re
import warnings
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _frames, _geosweep, _plot
from ._arrays import Floats, described, flags, given, switch
from ._attributes import OF_VALUES
from ._axes import GridAxes
from ._inputs import Inputs
from ._map import DistanceMap
from ._optional import needed
from ._place import Place
from ._settings import check_choice
from ._sources import Lines, Placed, Source, points_of, vertices_of
from ._surface import Surface, check_out
from ._tables import XY, columns_of, is_frame, places_of, refuse_apart
from ._warnings import ScaleWarning

if TYPE_CHECKING:
    import xarray as xr
    from geopandas import GeoDataFrame
    from matplotlib.axes import Axes
else:
    xr = needed("xarray", "xarray", "da.geosweep")

_X = {"x", "lon", "longitude", "easting"}
_Y = {"y", "lat", "latitude", "northing"}
# The largest accepted deviation of a coordinate from even spacing, as a fraction of a step.
_UNEVEN = 1e-3


@dataclass(frozen=True)
class _Grid:
    """The user's array, and the grid, which is north up."""

    template: "xr.DataArray"
    place: Place
    axes: GridAxes

    def back(
        self, name: str, values: NDArray[Any], description: str, units: str | None
    ) -> "xr.DataArray":
        """Return values on the grid as an array with the template's coordinates and attributes.

        ``units`` is the unit of the values, or None if they have none.
        """
        values = values[self.axes.flips]
        values = np.ascontiguousarray(values.T if self.axes.turned else values)
        made = self.template.copy(data=values.reshape(self.template.shape)).rename(name)
        made.attrs = {
            key: value
            for key, value in self.template.attrs.items()
            if key not in OF_VALUES and not key.startswith("STATISTICS_")
        } | {"long_name": description}
        made.attrs.pop("units", None)
        if units is not None:
            made.attrs["units"] = units
        kept = {"grid_mapping", "coordinates"}
        made.encoding = {key: made.encoding[key] for key in kept if key in made.encoding}
        if values.dtype.kind == "f":
            made.encoding["_FillValue"] = np.nan
        return made


def _crs(da: "xr.DataArray") -> str | None:
    """Return the coordinate reference system as WKT, from rioxarray or CF's attributes."""
    try:
        of_rio = da.rio.crs if hasattr(da, "rio") else None
    except (RuntimeError, ValueError):
        # rioxarray cannot interpret an attribute, which may be enough here.
        of_rio = None
    if of_rio is not None:
        return str(of_rio.to_wkt())
    for name in (da.encoding.get("grid_mapping"), da.attrs.get("grid_mapping"), "spatial_ref"):
        if name in da.coords:
            attrs = da.coords[name].attrs
            found = attrs.get("crs_wkt", attrs.get("spatial_ref"))
            if found:
                return str(found)
    found = da.attrs.get("crs")
    return None if found is None else str(found)


@dataclass(frozen=True)
class _Axis:
    """The coordinates along a dimension, which are evenly spaced up to their rounding."""

    first: float
    step: float
    stored: Floats
    is_rounded: bool


def _of_transform(da: "xr.DataArray") -> str:
    """Return a remark on an array that says where it lies by other means than coordinates."""
    dims = set(da.dims[-2:])
    for name, coord in da.coords.items():
        if coord.ndim == 2 and set(coord.dims) == dims:
            return (
                f"; its coordinates {name!r} vary along both axes, so that its cells are turned or "
                "uneven: reproject it, or use geosweep.Surface.from_positions"
            )
    transforms = [key for coord in da.coords.values() for key in coord.attrs]
    if "GeoTransform" in transforms or "transform" in da.attrs:
        return "; it has a GeoTransform, of which rioxarray makes them with parse_coordinates=True"
    return ""


def _axis(da: "xr.DataArray", dim: str) -> _Axis:
    """Return the coordinates along a dimension."""
    if dim not in da.coords:
        raise ValueError(
            f"the array has no coordinates along {dim!r}; assign them, or give the spacing to "
            f"geosweep.distance{_of_transform(da)}"
        )
    given_values = da.coords[dim].values
    if given_values.dtype.kind not in "iuf" or len(given_values) < 2:
        raise ValueError(f"{dim!r} must have two coordinates or more, which are numbers")
    values = given_values.astype(np.float64)
    step = (values[-1] - values[0]) / (len(values) - 1)
    even = values[0] + step * np.arange(len(values))
    rounding = 0.0
    if given_values.dtype.kind == "f":
        rounding = float(np.finfo(given_values.dtype).eps * np.abs(values).max())
    if 2 * rounding > abs(step) > 0:
        raise ValueError(
            f"the coordinates along {dim!r} are {given_values.dtype}, whose rounding of "
            f"{rounding:.2g} hides their step; assign them in float64"
        )
    if step == 0 or not (np.abs(values - even) <= max(_UNEVEN * abs(step), rounding)).all():
        raise ValueError(
            f"the coordinates along {dim!r} are not evenly spaced; resample them, or give the "
            "points to geosweep.Surface.from_positions"
        )
    return _Axis(float(values[0]), float(step), values, rounding > _UNEVEN * abs(step))


# The units of lengths that attributes name, in metres.
_LENGTHS = {
    **dict.fromkeys(("m", "metre", "metres", "meter", "meters"), 1.0),
    **dict.fromkeys(("km", "kilometre", "kilometres", "kilometer", "kilometers"), 1000.0),
    **dict.fromkeys(("cm", "centimetre", "centimetres", "centimeter", "centimeters"), 0.01),
    **dict.fromkeys(("mm", "millimetre", "millimetres", "millimeter", "millimeters"), 0.001),
    **dict.fromkeys(("ft", "foot", "feet", "international_foot"), 0.3048),
    **dict.fromkeys(("us_survey_foot", "us survey foot", "us_ft", "us-ft", "ftus"), 1200 / 3937),
    **dict.fromkeys(("mi", "mile", "miles"), 1609.344),
}


def _check_units(da: "xr.DataArray", dims: tuple[str, str], crs: str | None) -> None:
    """Check that coordinates are lengths, in the unit of the heights as far as both are named."""
    named = {dim: str(da.coords[dim].attrs.get("units", "")).strip() for dim in dims}
    system = None if crs is None else _geosweep.units_of_system(crs)
    are_angles, length, height = (False, None, None) if system is None else system
    angular = any(unit.lower().startswith(_ANGLES) for unit in named.values())
    by_name = {"lon", "longitude", "lat", "latitude"} & {dim.lower() for dim in dims}
    if are_angles or angular or by_name or _has_geographic_mapping(da):
        raise ValueError(
            f"the coordinates {dims[1]!r} and {dims[0]!r} are angles (degrees), which have no "
            "length; project the array first, with rioxarray: "
            "da.rio.reproject(da.rio.estimate_utm_crs())"
        )
    named["the heights"] = str(da.attrs.get("units", "")).strip()
    known = {name: _LENGTHS.get(unit.lower()) for name, unit in named.items()}
    known["the coordinate system"] = length
    named["the coordinate system"] = f"units of {length} m"
    if known["the heights"] is None and not named["the heights"] and height is not None:
        known["the heights"], named["the heights"] = height, f"units of {height} m (by their CRS)"
    lengths = {name: unit for name, unit in known.items() if unit is not None}
    if lengths and max(lengths.values()) > min(lengths.values()) * (1 + _ROUNDED_UNIT):
        said = ", ".join(f"{name} in {named[name]}" for name in lengths)
        raise ValueError(
            f"coordinates and heights have different units ({said}); convert one of them, or mend "
            "the attribute units"
        )
    is_metric = length is None or abs(length - 1) < _ROUNDED_UNIT
    if not is_metric and known["the heights"] is None:
        raise ValueError(
            f"the coordinate system has units of {length} m, and the array does not say the unit "
            "of its heights; set da.attrs['units'], after a conversion if they are in metres"
        )


# Beginnings of the names of units of angles.
_ANGLES = ("degree", "deg", "rad", "grad", "gon", "arc")
# Relative difference of units that are one, since the US survey foot is also called the foot.
_ROUNDED_UNIT = 1e-5


def _has_geographic_mapping(da: "xr.DataArray") -> bool:
    """Return whether attributes after CF name a grid mapping of longitudes and latitudes."""
    mapping = da.encoding.get("grid_mapping", da.attrs.get("grid_mapping", "spatial_ref"))
    name = da.coords[mapping].attrs.get("grid_mapping_name", "") if mapping in da.coords else ""
    return str(name) in ("latitude_longitude", "rotated_latitude_longitude")


def _warn_of_scale(place: Place) -> None:
    """Warn if lengths on the map are not those on the ground."""
    # The system of heights, if there is one, follows that of the map.
    across = re.split(r",\s*VERT", place.crs or "")[0]
    found = re.findall(r'(?:AUTHORITY|ID)\["EPSG",\s*"?(\d+)"?\]\s*\]\s*$', across)
    if not found or int(found[-1]) > 32766:
        return
    at = (place.x0, place.y0, place.dx, place.dy, *place.shape)
    scale = _geosweep.map_scale(int(found[-1]), at)
    if scale is not None:
        projection, least, largest = scale
        warnings.warn(
            f"the {projection} map has a scale of {least:.3f} to {largest:.3f} here, so that "
            "distances on it are that many times those on the ground; project the array for its "
            "area, with rioxarray: da.rio.reproject(da.rio.estimate_utm_crs())",
            ScaleWarning,
            stacklevel=5,
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
    ys, xs = _axis(da, y), _axis(da, x)
    (y0, dy), (x0, dx) = (ys.first, ys.step), (xs.first, xs.step)
    crs = _crs(da)
    _check_units(da, (y, x), crs)
    shape = (da.sizes[y], da.sizes[x])
    # Rows run to the south, columns to the east.
    top = y0 if dy < 0 else y0 + dy * (shape[0] - 1)
    left = x0 if dx > 0 else x0 + dx * (shape[1] - 1)
    flips = (slice(None, None, 1 if dy < 0 else -1), slice(None, None, 1 if dx > 0 else -1))
    stored = (ys.stored[flips[0]], xs.stored[flips[1]])
    rounded = stored if ys.is_rounded or xs.is_rounded else None
    place = Place(left, top, abs(dx), abs(dy), shape, crs, rounded)
    _warn_of_scale(place)
    dims, sizes = da.dims[-2:], da.shape[-2:]
    coords = {dim: da.coords[dim].values for dim in dims}
    axes = GridAxes((dims[0], dims[1]), (sizes[0], sizes[1]), coords, turned, flips)
    return _Grid(da, place, axes)


def spacing_of(da: "xr.DataArray") -> tuple[float, float] | None:
    """Return the distance of rows and of columns of an array, or None if it has no coordinates.

    Raise ValueError if the array is not north up, so that its rows and columns would be mistaken
    for those of a map.
    """
    if da.ndim < 2 or not (any(dim in da.coords for dim in da.dims[-2:]) or _of_transform(da)):
        return None
    grid = _grid(da)
    if grid.axes.turned or any(axis.step == -1 for axis in grid.axes.flips):
        raise ValueError(
            "heights: the array's rows do not run north to south and its columns west to east, as "
            "its coordinates tell; use heights.geosweep, which turns it, or give the spacing"
        )
    return grid.place.dy, grid.place.dx


class GeoMap:
    """A distance map whose points have coordinates. ``da.geosweep.solve`` makes it."""

    def __init__(self, grid: _Grid, map_: DistanceMap) -> None:
        self._grid = grid
        self.map = map_
        """The map on the grid, with rows from north to south and columns from west to east."""

    def __repr__(self) -> str:
        return f"<geosweep.xarray.GeoMap of {self.map!r}>"

    @property
    def distance(self) -> "xr.DataArray":
        """Distances, NaN where no source reaches, with the coordinates of the heights."""
        found = self.map.distance
        shown = np.where(np.isfinite(found), found, np.asarray(np.nan, found.dtype))
        what = "travel time" if self._is_slowed else "geodesic distance"
        return self._grid.back("distance", shown, what, self._units)

    @property
    def nearest(self) -> "xr.DataArray":
        """Index of the nearest source; -1 where no source reaches."""
        what = "number of the nearest source" if self.map._labels is None else "nearest source"
        return self._grid.back("nearest", self.map.nearest, what, None)

    def back_direction(self, unit: Literal["compass", "grass"] = "compass") -> "xr.DataArray":
        """Return the bearing of the way back in degrees; see `DistanceMap.back_direction`."""
        check_choice("unit", unit, "compass", "grass")
        found = self.map.back_direction(unit)
        what = "direction of the way back, in degrees"
        return self._grid.back("back_direction", found, what, "degree")

    def back_link(self) -> "xr.DataArray":
        """Return the code of the next grid point on the way back; see `DistanceMap.back_link`."""
        what = "next cell on the way back"
        return self._grid.back("back_link", self.map.back_link(), what, None)

    def error(self) -> "xr.DataArray":
        """Estimate the error of each distance; see `DistanceMap.error`."""
        what = "estimated error of the distance"
        return self._grid.back("error", self.map.error(), what, self._units)

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
        return _frames.regions_table(self.map.voronoi(), self._place, self.map._labels)

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
        shown = switch("colorbar", colorbar)
        ax = _plot.raster(ax, self.map.distance, extent, 1.0, cmap, shown)
        _plot.add_lines(ax, lines, place.to_xy)
        ax.ticklabel_format(style="plain", useOffset=False)
        ax.locator_params(axis="x", nbins=4)
        ax.set_xlabel("x")
        ax.set_ylabel("y")
        return ax

    @property
    def _is_slowed(self) -> bool:
        return self.map._surface.slowness is not None

    @property
    def _units(self) -> str | None:
        """The unit of distances, which is that of the heights; None for travel times."""
        units = self._grid.template.attrs.get("units")
        return None if units is None or self._is_slowed else str(units)

    @property
    def _place(self) -> Place:
        return self._grid.place


def _column(table: Any, name: str) -> Any:
    if name not in table.columns:
        raise ValueError(f"labels={name!r} is not a column of the table of sources")
    return np.asarray(table[name])


def _shape(value: Any) -> tuple[int, ...]:
    """Return the shape of an array; that of none for lists of unequal lengths."""
    try:
        return np.shape(value)
    except ValueError:
        return ()


def _ends(ends: Any, place: Place) -> Floats:
    if _frames.is_table(ends):
        return _frames.points_of("ends", ends, place)
    if _frames.is_shape(ends):
        shapes = ends if isinstance(ends, (list, tuple)) else [ends]
        return _frames.points_of_shapes("ends", list(shapes), place)
    return place.to_grid("ends", places_of("ends", ends, XY))


@xr.register_dataarray_accessor("geosweep")
class Accessor:
    """Distances over an array of heights with coordinates x and y.

    Spacing comes from the coordinates, which must be lengths and evenly spaced. Rows may run to
    the north or to the south. The heights have the unit of the coordinates.
    """

    def __init__(self, da: "xr.DataArray") -> None:
        self._da = da

    def _source(self, source: Any, grid: _Grid, strict: bool) -> Source:
        place = grid.place
        if _frames.is_table(source):
            return _frames.sources_of(source, place, strict)
        if _frames.is_shape(source):
            shapes = list(source) if isinstance(source, (list, tuple)) else [source]
            return _frames.sources_of_shapes(shapes, np.zeros(len(shapes)), place, strict)
        if isinstance(source, Lines):
            lines = [place.to_grid("source", vertices_of(xy)) for xy in source.vertices]
            return Lines(lines, source.starts)
        if grid.axes.are_those_of(source) or grid.axes.fit(_shape(source)):
            return flags("source", grid.axes.north_up("source", source))
        refuse_apart("source", source)
        if is_frame(source):
            source = columns_of("source", source, XY, starts=True)
        found = points_of(given("source", source))
        if not isinstance(found, Placed):
            raise ValueError(
                "source must be (x, y), an array (n, 2), an array (n, 3) with start times, Lines, "
                "a table, geometries, or a raster like the heights, not "
                f"{described(source)}"
            )
        places = place.to_grid("source", found.points[:, :2], strict)
        points = np.column_stack([places, found.points[:, 2]])
        return Placed(points, rows=found.rows, count=found.count)

    def surface(
        self,
        *,
        mask: ArrayLike | None = None,
        holes: ArrayLike | None = None,
        slowness: ArrayLike | None = None,
        speed: ArrayLike | None = None,
        edges: str = "arc",
    ) -> Surface:
        """Return the surface, with rows to the south and columns to the east.

        Parameters
        ----------
        mask, holes, slowness, speed
            As in `Surface.from_heights`, with the array's shape or as DataArrays.
        edges
            As in `Surface.from_heights`.
        """
        inputs = Inputs(mask, holes, slowness, speed)
        return self._surface(_grid(self._da), inputs, edges)

    def _surface(self, grid: _Grid, inputs: Inputs, edges: str) -> Surface:
        on_grid: dict[str, Any] = {
            name: grid.axes.north_up(name, array) for name, array in inputs.given().items()
        }
        heights = grid.axes.north_up("heights", given("heights", self._da))
        spacing = (grid.place.dy, grid.place.dx)
        made = Surface.from_heights(heights, spacing, edges=edges, **on_grid)
        made._axes = grid.axes
        return made

    def solve(
        self,
        source_xy: Any,
        *,
        mask: ArrayLike | None = None,
        holes: ArrayLike | None = None,
        slowness: ArrayLike | None = None,
        speed: ArrayLike | None = None,
        edges: str = "arc",
        labels: Any = None,
        targets: ArrayLike | None = None,
        out: NDArray[Any] | None = None,
        **options: Any,
    ) -> GeoMap:
        """Compute a map with coordinates, for paths, contours, regions and pictures.

        Parameters
        ----------
        source_xy
            (x, y); (n, 2); (n, 3) with start times; `Lines` of x and y; a GeoDataFrame of points
            and lines, or a DataFrame with columns x and y, perhaps with a column ``start``;
            geometries of shapely; or a raster like the heights, whose cells other than zero, NaN
            and missing ones are sources.
        mask, holes, slowness, speed, edges
            As in `surface`.
        labels
            As in `Surface.solve`: a value for each source, the name of a column of a table, or a
            raster like the heights.
        targets
            As in `Surface.solve`: integers (n, 2), indices along the axes of this array.
        out
            Array of this array's shape that takes the distances as `distance` returns them.
        options
            As in `Surface.solve`.
        """
        grid = _grid(self._da)
        surface = self._surface(grid, Inputs(mask, holes, slowness, speed), edges)
        if targets is not None:
            options["targets"] = grid.axes.points("targets", targets)
        if out is not None:
            check_out(out, self._da.shape, np.dtype(options.get("dtype", np.float32)))
        strict = options.get("sources_outside", "refuse") == "refuse"
        source = self._source(source_xy, grid, strict)
        if isinstance(labels, str) and hasattr(source_xy, "columns"):
            labels = _column(source_xy, labels)
        elif grid.axes.are_those_of(labels) or grid.axes.fit(_shape(labels)):
            labels = grid.axes.north_up("labels", labels)
        found = GeoMap(grid, surface.solve(source, labels=labels, **options))
        if out is not None:
            np.copyto(out, found.distance.values)
        return found

    def distance(self, source_xy: Any, **options: Any) -> "xr.DataArray":
        """Compute distances, NaN where no source reaches.

        The parameters are those of `solve`. The result keeps the coordinates, dimensions,
        attributes and the CRS of the heights.
        """
        return self.solve(source_xy, **options).distance

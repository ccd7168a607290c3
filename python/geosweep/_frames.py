"""Sources from tables of GeoPandas, and tables of curves and regions."""

from typing import TYPE_CHECKING, Any

import numpy as np

from ._arrays import Floats, numbers
from ._optional import needed
from ._place import Place
from ._results import Curves, Path, Voronoi
from ._sources import Placed

if TYPE_CHECKING:
    from geopandas import GeoDataFrame


def is_table(value: object) -> bool:
    """Return whether a value is a GeoDataFrame or a GeoSeries."""
    return hasattr(value, "geometry") and hasattr(value, "to_crs")


def _projected(name: str, table: Any, crs: str | None) -> Any:
    """Return the geometries in a raster's coordinates."""
    geometry = table.geometry
    if crs is None and geometry.crs is not None:
        raise ValueError(
            f"{name}: the table is in {geometry.crs.to_string():.40}, and the array names no CRS; "
            "write its own with rioxarray, da.rio.write_crs(...), or take away the table's"
        )
    if crs is not None and geometry.crs is not None:
        geometry = geometry.to_crs(crs)
    if len(geometry) == 0 or geometry.isna().any() or geometry.is_empty.any():
        raise ValueError(f"{name}: the table is empty or has rows without a geometry; drop them")
    return geometry


def sources_of(table: Any, place: Place, strict: bool) -> Placed:
    """Return the points and lines of a table as sources, which keep the numbers of their rows.

    A column ``start`` holds start times.
    """
    geometry = _projected("source", table, place.crs)
    starts = np.zeros(len(geometry))
    if "start" in getattr(table, "columns", ()):
        starts = numbers("source starts", table["start"])
    return sources_of_shapes(list(geometry), starts, place, strict)


def is_shape(value: object) -> bool:
    """Return whether a value is a geometry of shapely, or a list of them."""
    if isinstance(value, (list, tuple)):
        return bool(value) and all(map(is_shape, value))
    return hasattr(value, "geom_type") and hasattr(value, "__geo_interface__")


def sources_of_shapes(shapes: list[Any], starts: Floats, place: Place, strict: bool) -> Placed:
    """Return geometries in a raster's coordinates as sources, numbered as they are listed."""
    points: list[Floats] = []
    lines: list[tuple[Floats, float]] = []
    of_points: list[int] = []
    of_lines: list[int] = []
    for row, (shape, start) in enumerate(zip(shapes, starts.tolist(), strict=True)):
        for part in _parts(shape):
            if part.is_empty:
                raise ValueError(f"source: the geometry of row {row} is empty; leave it out")
            if part.geom_type not in ("Point", "LineString", "LinearRing"):
                raise ValueError(
                    f"source: a {part.geom_type} is neither points nor lines; take its .boundary "
                    "or .centroid"
                )
            xy = np.asarray(part.coords, dtype=np.float64)[:, :2]
            is_point = part.geom_type == "Point"
            places = place.to_grid("source", xy, strict or not is_point)
            if is_point:
                points.append(np.column_stack([places, [start]]))
                of_points.append(row)
            else:
                lines.append((np.ascontiguousarray(places), start))
                of_lines.append(row)
    rows = np.array(of_points + of_lines, dtype=np.int64)
    all_points = np.concatenate(points) if points else np.empty((0, 3))
    return Placed(all_points, lines, rows, len(shapes))


def _parts(shape: Any) -> list[Any]:
    """Return the parts of a geometry, also of nested collections."""
    return (
        [part for one in shape.geoms for part in _parts(one)]
        if hasattr(shape, "geoms")
        else [shape]
    )


def points_of(name: str, table: Any, place: Place) -> Floats:
    """Return rows and columns (n, 2) of a table of points."""
    return points_of_shapes(name, list(_projected(name, table, place.crs)), place)


def points_of_shapes(name: str, shapes: list[Any], place: Place) -> Floats:
    """Return rows and columns (n, 2) of points in a raster's coordinates."""
    others = {shape.geom_type for shape in shapes} - {"Point"}
    if others or any(shape.is_empty for shape in shapes):
        raise ValueError(f"{name} must be points alone, not {', '.join(others) or 'empty ones'}")
    return place.to_grid(name, np.array([[shape.x, shape.y] for shape in shapes]))


def _table(columns: dict[str, Any], geometry: list[Any], place: Place) -> "GeoDataFrame":
    geopandas = needed("geopandas", "geopandas", "a table of curves or regions")
    return geopandas.GeoDataFrame(columns, geometry=geometry, crs=place.crs)


def _line(places: Floats, place: Place) -> Any:
    shapely = needed("shapely", "geopandas", "a table of curves or regions")
    # A path from a source to itself is one point. A line needs two.
    return shapely.LineString(place.to_xy(places if len(places) > 1 else places.repeat(2, axis=0)))


def paths_table(paths: list[Path], place: Place) -> "GeoDataFrame":
    """Return a table of paths, with their lengths and sources."""
    columns = {"length": [path.length for path in paths], "source": [path.source for path in paths]}
    return _table(columns, [_line(path.vertices, place) for path in paths], place)


def contours_table(contours: list[Curves], place: Place) -> "GeoDataFrame":
    """Return a table of curves, with their distances."""
    curves = [(contour.level, curve) for contour in contours for curve in contour.curves]
    columns = {"distance": [level for level, _ in curves]}
    return _table(columns, [_line(curve, place) for _, curve in curves], place)


def borders_table(voronoi: Voronoi, place: Place) -> "GeoDataFrame":
    """Return a table of borders, with the sources on either side."""
    sides = [sides for sides, _ in voronoi.borders]
    columns = {"source": [a for a, _ in sides], "other": [b for _, b in sides]}
    return _table(columns, [_line(curve, place) for _, curve in voronoi.borders], place)


def regions_table(voronoi: Voronoi, place: Place, names: Any) -> "GeoDataFrame":
    """Return a table of regions, each the union of the cells around its points, with areas.

    ``names`` holds the labels of the sources, or is None.
    """
    shapely = needed("shapely", "geopandas", "a table of curves or regions")
    labels = voronoi.labels
    # Runs of equal labels along rows, as rectangles that go half a step beyond their points.
    rows, firsts = np.nonzero(np.diff(labels, axis=1, prepend=-2))
    ends = np.append(firsts[1:], 0)
    ends[ends == 0] = labels.shape[1]
    low = place.to_xy(np.column_stack([rows + 0.5, firsts - 0.5]))
    high = place.to_xy(np.column_stack([rows - 0.5, ends - 0.5]))
    boxes = shapely.box(low[:, 0], low[:, 1], high[:, 0], high[:, 1])
    of = labels[rows, firsts]
    present = [source for source in range(len(voronoi.areas)) if (of == source).any()]
    columns = {"source": present, "area": voronoi.areas[present]}
    if names is not None:
        columns["label"] = names[present]
    return _table(columns, [shapely.union_all(boxes[of == source]) for source in present], place)

"""Places in tables with named columns: those of pandas, Polars and others."""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from ._arrays import Floats, numbers


class Columns(NamedTuple):
    """Names of the columns of places, in lower case."""

    first: tuple[str, ...]
    second: tuple[str, ...]
    described: str


ROW_COL = Columns(("row",), ("col", "column"), "rows and columns: row and col")
XY = Columns(
    ("x", "easting", "east"),
    ("y", "northing", "north"),
    "map coordinates: x and y, or easting and northing",
)
_STARTS = ("start", "t0", "time", "start_value", "start_time", "initial")


def is_frame(value: object) -> bool:
    """Return whether a value is a table with named columns, or a row of it, without geometries."""
    return (
        (hasattr(value, "columns") or _is_row(value))
        and hasattr(value, "__getitem__")
        and not hasattr(value, "to_crs")
    )


def _is_row(value: Any) -> bool:
    """Return whether a value is a Series of pandas whose numbers have names."""
    return hasattr(value, "to_frame") and any(isinstance(name, str) for name in value.index)


def columns_of(name: str, table: Any, wanted: Columns, starts: bool = False) -> Floats:
    """Return the places (n, 2) of a table, or (n, 3) with start times if it has them."""
    table = table.to_frame().T.infer_objects() if _is_row(table) else table
    there = {str(column).strip().lower(): column for column in table.columns}
    names = (wanted.first, wanted.second, _STARTS if starts else ())
    found = [[there[key] for key in keys if key in there] for keys in names]
    if not (found[0] and found[1]) or any(len(columns) > 1 for columns in found):
        raise ValueError(
            f"{name}: the table must have columns with {wanted.described}"
            f"{', and perhaps start' if starts else ''}; it has "
            f"{', '.join(map(str, table.columns))}"
        )
    return np.column_stack([_column(name, table, column) for [column] in filter(None, found)])


def _column(name: str, table: Any, column: Any) -> Floats:
    """Return a column of numbers; NaN where pandas has none."""
    values = table[column]
    # Columns of integers that may be missing are of a type of their own.
    if getattr(values.dtype, "kind", "") in ("i", "u", "f") and hasattr(values, "to_numpy"):
        values = values.to_numpy(dtype=np.float64, na_value=np.nan)
    return numbers(f"{name}: {column}", np.asarray(values))


def places_of(name: str, value: ArrayLike, columns: Columns = ROW_COL) -> Floats:
    """Return places (n, 2), also from one place and from a table, by the names of its columns."""
    places = any_places_of(name, value, columns)
    if places.shape in ((0,), (2,)):  # no place, or one
        places = places.reshape(-1, 2)
    if places.ndim != 2 or places.shape[1] != 2:
        order = "x and y" if columns is XY else "rows and columns"
        raise ValueError(f"{name} must be {order} (n, 2), not of the shape {places.shape}")
    return places


def any_places_of(name: str, value: ArrayLike, columns: Columns = ROW_COL) -> Floats:
    """Return places (..., 2); those of a table by the names of its columns."""
    refuse_apart(name, value)
    return columns_of(name, value, columns) if is_frame(value) else numbers(name, value)


def refuse_apart(name: str, value: object) -> None:
    """Raise ValueError for a tuple of two arrays, as np.nonzero returns it.

    It would be taken for two points if both arrays had two numbers.
    """
    arrays = value if isinstance(value, tuple) and len(value) in (2, 3) else ()
    if arrays and all(getattr(one, "ndim", 0) == 1 for one in arrays):
        raise ValueError(
            f"{name}: a tuple of arrays does not say whether they are points or coordinates; give "
            f"np.column_stack({name}) if they are coordinates, and np.array({name}) if points"
        )

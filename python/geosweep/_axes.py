"""The axes of arrays of xarray, beside those of the grid that is made of one."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ._arrays import given, is_data_array
from ._settings import grid_points


@dataclass(frozen=True)
class GridAxes:
    """The relation between the axes of the user's array and those of the grid."""

    dims: tuple[Any, Any]
    shape: tuple[int, int]
    """The sizes of these dimensions of the user's array."""
    coords: dict[Any, NDArray[Any]]
    """The coordinates along these dimensions, if the user's array has them."""
    turned: bool
    """Whether the array has columns first."""
    flips: tuple[slice, slice]
    """Steps of 1 or -1 along y and x."""

    @classmethod
    def of(cls, da: Any) -> "GridAxes":
        """Return the axes of a grid that is in the order of an array."""
        dims = da.dims[-2:]
        coords = {dim: da.coords[dim].values for dim in dims if dim in da.coords}
        shape = (da.sizes[dims[0]], da.sizes[dims[-1]])
        return cls((dims[0], dims[-1]), shape, coords, False, (slice(None), slice(None)))

    def fit(self, shape: tuple[int, ...]) -> bool:
        """Return whether an array of this shape has a value for each point."""
        return shape[-2:] == self.shape and all(size == 1 for size in shape[:-2])

    def are_those_of(self, value: Any) -> bool:
        """Return whether a value is an array of xarray with a number for each point of the grid.

        Its axes have the same names, or its size is that of the grid.
        """
        if not is_data_array(value):
            return False
        shape = tuple(size for size in value.shape if size != 1)
        return set(self.dims) <= set(value.dims) or shape in (self.shape, self.shape[::-1])

    def north_up(self, name: str, array: Any) -> NDArray[Any]:
        """Return the values of an array of the user's array's shape in the order of the grid."""
        values = given(name, array)
        if is_data_array(array):
            # What the array's attributes say of its values would not outlive a selection.
            places = np.arange(values.size).reshape(values.shape)
            values = values.ravel()[self._like(name, array.copy(data=places)).values]
        if not self.fit(values.shape):
            raise ValueError(f"{name} must have the array's shape {self.shape}, not {values.shape}")
        values = values.reshape(self.shape)
        return (values.T if self.turned else values)[self.flips]

    def _like(self, name: str, array: Any) -> Any:
        """Return an array with its dimensions in the user's array's order.

        Its coordinates must be those of the user's array, in either order.
        """
        try:
            array = array.squeeze(drop=True).transpose(*self.dims)
            for dim, values in self.coords.items():
                is_there = dim in array.coords and array.sizes[dim] == len(values)
                if is_there and not np.array_equal(array.coords[dim].values, values):
                    if not array.indexes[dim].is_unique:
                        raise ValueError(f"coordinates along {dim!r} are given twice")
                    array = array.sel({dim: values})
        except (KeyError, ValueError) as error:
            raise ValueError(f"{name} must have the coordinates of the heights: {error}") from error
        if array.shape != self.shape:
            raise ValueError(
                f"{name} must have the coordinates of the heights, and has {dict(array.sizes)} of "
                f"{dict(zip(self.dims, self.shape, strict=True))} points"
            )
        return array

    def points(self, name: str, indices: ArrayLike) -> NDArray[np.int64]:
        """Return rows and columns (n, 2) on the grid, from indices along the array's own axes."""
        points = grid_points(name, indices)
        if (points >= self.shape).any():
            raise ValueError(f"{name} must be indices into the array, whose shape is {self.shape}")
        rows_cols = self.shape[::-1] if self.turned else self.shape
        points = points[:, ::-1] if self.turned else points
        last = np.subtract(rows_cols, 1)
        backwards = [axis.step == -1 for axis in self.flips]
        return np.where(backwards, last - points, points)

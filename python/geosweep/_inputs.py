"""What surfaces are given at each point beside their geometry: holes and a slowness."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ._arrays import Floats, flags, is_data_array, numbers
from ._axes import GridAxes


@dataclass(frozen=True)
class Inputs:
    """Holes and a slowness, as the caller gives them."""

    mask: ArrayLike | None = None
    holes: ArrayLike | None = None
    slowness: ArrayLike | None = None
    speed: ArrayLike | None = None

    def given(self) -> Mapping[str, Any]:
        """Return the arrays that are given, by their names."""
        return {name: array for name, array in vars(self).items() if array is not None}

    def aligned(self, axes: GridAxes) -> "Inputs":
        """Return inputs in the order of a grid; arrays of xarray must have its coordinates."""
        given = self.given().items()
        return Inputs(
            **{name: axes.north_up(name, it) if is_data_array(it) else it for name, it in given}
        )

    def on(self, shape: tuple[int, int]) -> tuple[NDArray[np.bool_] | None, Floats | None]:
        """Return where points are present, and the slowness; None for what is not given."""
        points, slow = self._points(shape), self._slow(shape)
        if slow is not None:
            walls = ~np.isfinite(slow)
            if ((slow == 1) | walls).all():
                # Such a slowness weights nothing. Without it, fronts over floor plans are exact.
                return ~walls if points is None else points & ~walls, None
        return points, slow

    def _points(self, shape: tuple[int, int]) -> NDArray[np.bool_] | None:
        """Return where points are present, or None if no holes are given."""
        mask = None if self.mask is None else flags("mask", self.mask)
        # A value that is not known marks a hole in either mask.
        holes = None if self.holes is None else flags("holes", self.holes, missing=True)
        _check_shapes(shape, mask=mask, holes=holes)
        if holes is None:
            return mask
        return ~holes if mask is None else mask & ~holes

    def _slow(self, shape: tuple[int, int]) -> Floats | None:
        """Return the slowness, infinite at walls, or None if there is none."""
        if self.slowness is not None and self.speed is not None:
            raise ValueError("give slowness or speed, its reciprocal, and not both")
        if self.speed is None:
            slow = None if self.slowness is None else numbers("slowness", self.slowness, np.inf)
            _check_shapes(shape, slowness=slow)
            return slow
        speed = numbers("speed", self.speed, 0.0)
        _check_shapes(shape, speed=speed)
        if (speed < 0).any():
            row, col = np.argwhere(speed < 0)[0].tolist()
            raise ValueError(f"speed {speed[row, col]} at row {row}, column {col} is negative")
        # Nothing passes where the speed is zero or not known.
        with np.errstate(divide="ignore"):
            return np.where(np.isnan(speed), np.inf, 1 / speed)


def _check_shapes(shape: tuple[int, int], **arrays: NDArray[Any] | None) -> None:
    for name, array in arrays.items():
        if array is not None and array.shape != shape:
            raise ValueError(f"{name} must have the grid's shape {shape}, not {array.shape}")

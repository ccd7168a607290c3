"""Pictures of maps."""

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ._arrays import Floats
from ._optional import needed
from ._results import Curves, Path

if TYPE_CHECKING:
    from matplotlib.axes import Axes

# Turns rows and columns (n, 2) into the axes' x and y (n, 2).
ToAxes = Callable[[Floats], Floats]


def draw(
    ax: "Axes | None",
    distances: NDArray[Any],
    spacing: tuple[float, float],
    lines: tuple[list[Curves], list[Path]],
    cmap: str,
    colorbar: bool,
) -> "Axes":
    """Draw a map in rows and columns."""
    rows, cols = distances.shape
    dy, dx = spacing
    extent = (-0.5, cols - 0.5, rows - 0.5, -0.5)
    ax = raster(ax, distances, extent, dy / dx, cmap, colorbar)
    add_lines(ax, lines, lambda places: places[:, ::-1])
    ax.set_xlabel("column")
    ax.set_ylabel("row")
    return ax


def round_levels(distances: NDArray[Any], count: int) -> Floats:
    """Return about ``count`` round distances between the least and the largest one."""
    reached = distances[np.isfinite(distances)]
    if count == 0 or not reached.size or reached.min() == reached.max():
        return np.empty(0)
    ticker = needed("matplotlib.ticker", "plot", "plot()")
    least, largest = float(reached.min()), float(reached.max())
    found: Floats = ticker.MaxNLocator(count).tick_values(least, largest)
    return found[(found > least) & (found < largest)]


def raster(
    ax: "Axes | None",
    distances: Any,
    extent: tuple[float, float, float, float],
    aspect: float,
    cmap: str,
    colorbar: bool,
) -> "Axes":
    """Draw distances as colours. Unreached points stay empty."""
    pyplot = needed("matplotlib.pyplot", "plot", "plot()")
    if ax is None:
        ax = pyplot.figure(layout="constrained").add_subplot()
    shown = np.where(np.isfinite(distances), distances, np.nan)
    image = ax.imshow(shown, cmap=cmap, extent=extent, aspect=aspect, interpolation="nearest")
    if colorbar:
        ax.figure.colorbar(image, ax=ax, label="distance")
    return ax


def add_lines(ax: "Axes", lines: tuple[list[Curves], list[Path]], to_axes: ToAxes) -> None:
    """Draw lines of equal distance, with their distances, and paths."""
    collections = needed("matplotlib.collections", "plot", "plot()")
    levels, paths = lines
    for level in levels:
        curves = [to_axes(curve) for curve in level.curves]
        ax.add_collection(collections.LineCollection(curves, colors="white", linewidths=0.7))
        longest = max(curves, key=len, default=None)
        if longest is not None and len(longest) > 8:
            x, y = longest[len(longest) // 2]
            text = np.format_float_positional(level.level, 6, fractional=False, trim="-")
            ax.text(x, y, text, color="white", fontsize=7, ha="center", va="center")
    for path in paths:
        x, y = to_axes(path.vertices).T
        ax.plot(x, y, color="crimson", linewidth=1.5)
        ax.plot(x[:1], y[:1], "o", color="crimson", markersize=4)

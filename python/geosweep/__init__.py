"""Geodesic distance maps on grids of points: heights, positions or a metric.

Rows come first everywhere: shapes are (M, N), places are (row, column), spacing is (dy, dx).
"""

import importlib
import sys
from typing import Any

from ._arrays import HostCopyWarning
from ._completed import CompletedGrid
from ._geosweep import __version__
from ._map import DistanceMap, LogMap
from ._matrix import CanonicalForm, canonical_form, pairwise
from ._pairs import pairs
from ._results import Basis, Curves, Path, Ridge, Voronoi
from ._sources import LevelSet, Lines
from ._surface import Device, Surface, devices, distance, route, travel_time
from ._warnings import (
    ConvergenceError,
    ConvergenceWarning,
    ScaleWarning,
    SeamWarning,
    SkewWarning,
)

__all__ = [
    "Basis",
    "CanonicalForm",
    "CompletedGrid",
    "ConvergenceError",
    "ConvergenceWarning",
    "Curves",
    "Device",
    "DistanceMap",
    "HostCopyWarning",
    "LevelSet",
    "Lines",
    "LogMap",
    "Path",
    "Ridge",
    "ScaleWarning",
    "SeamWarning",
    "SkewWarning",
    "Surface",
    "Voronoi",
    "__version__",
    "canonical_form",
    "devices",
    "distance",
    "pairs",
    "pairwise",
    "route",
    "travel_time",
]


def __getattr__(name: str) -> Any:
    """Import ``geosweep.dask`` or ``geosweep.xarray``, which need other packages, at first use."""
    if name in ("dask", "xarray"):
        return importlib.import_module(f"{__name__}.{name}")
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


# A program that has imported xarray before gets `da.geosweep`. Other programs need
# `import geosweep.xarray`, since importing xarray takes long.
if "xarray" in sys.modules:
    importlib.import_module(f"{__name__}.xarray")

"""Geodesic distance maps on grids of points: heights, positions or a metric.

Rows come first everywhere: shapes are (M, N), places are (row, column), spacing is (dy, dx).
"""

from ._arrays import HostCopyWarning
from ._geosweep import __version__
from ._map import Basis, Curves, DistanceMap, LogMap, Path, Ridge, Voronoi
from ._matrix import CanonicalForm, canonical_form, pairwise
from ._sources import Lines
from ._surface import Device, Surface, devices, distance, route
from ._warnings import ConvergenceError, ConvergenceWarning, SeamWarning

__all__ = [
    "Basis",
    "CanonicalForm",
    "ConvergenceError",
    "ConvergenceWarning",
    "Curves",
    "Device",
    "DistanceMap",
    "HostCopyWarning",
    "Lines",
    "LogMap",
    "Path",
    "Ridge",
    "SeamWarning",
    "Surface",
    "Voronoi",
    "__version__",
    "canonical_form",
    "devices",
    "distance",
    "pairwise",
    "route",
]

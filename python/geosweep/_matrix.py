"""All pairs of points, and canonical forms."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _geosweep
from ._arrays import count, numbers, on_host, switch
from ._settings import Engine, Wavefront, check_progress, settings
from ._surface import Surface, check_out, compiled_of
from ._warnings import check

Matrix = NDArray[np.float32]


def indices(surface: Surface, rows: ArrayLike | None) -> NDArray[np.int64]:
    """Return row-major indices of grid points after a check; all points by default."""
    points = surface.shape[0] * surface.shape[1]
    wanted = np.arange(points) if rows is None else np.atleast_1d(on_host("rows", rows))
    if wanted.size and (wanted.ndim != 1 or wanted.dtype.kind not in "iu"):
        raise TypeError("rows must be integers, the row-major indices of grid points")
    if len(wanted) and not 0 <= wanted.min() <= wanted.max() < points:
        raise ValueError(f"rows must lie from 0 to {points - 1}")
    return wanted.ravel().astype(np.int64, copy=False)


def pairwise(
    surface: Surface,
    rows: ArrayLike | None = None,
    out: Matrix | None = None,
    *,
    wavefront: Wavefront = "auto",
    engine: Engine = "auto",
    device: str | int | None = None,
    tolerance: float | None = None,
    iterations: int | None = None,
    threads: int | None = None,
    strict: bool = False,
    progress: Callable[[int, int], object] | None = None,
) -> Matrix:
    """Compute rows of the matrix of all distances, (k, M N).

    Parameters
    ----------
    surface
        The surface, with M x N points.
    rows
        Row-major indices of the k points from which distances are wanted; all by default.
    out
        Array of float32 in C order, a memory map for instance, into which rows are written.
    progress
        Called with the number of rows that are done and the number of all rows.
    """
    compiled, strict = compiled_of(surface), switch("strict", strict)
    check_progress(progress)
    wanted = indices(surface, rows)
    points = surface.shape[0] * surface.shape[1]
    chosen = settings(engine, device, wavefront, tolerance, iterations, threads)
    shape = (len(wanted), points)
    if out is None:
        out = np.empty(shape, np.float32)
    check_out(out, shape, np.float32)
    if not out.flags.c_contiguous:
        raise ValueError("out must be in C order")
    found = _geosweep.pairwise(compiled, wanted.tolist(), out, chosen, progress)
    report = {"iterations": found[0], "residual": found[1]}
    check(found[2], report, strict)
    return out


class CanonicalForm(NamedTuple):
    """Points in space whose straight distances approximate geodesic ones."""

    coordinates: NDArray[np.float64]
    """Coordinates (n, dimensions), in the unit of the distances."""
    points: NDArray[np.int64]
    """Indices of the n points: those of the largest connected piece."""
    stress: float
    """Kruskal's stress-1."""
    converged: bool
    """Whether the stress has settled."""


def canonical_form(
    matrix: ArrayLike, dimensions: int = 3, *, iterations: int = 1000
) -> CanonicalForm:
    """Place points in space so that their distances fit a matrix (n, n) best."""
    values = np.ascontiguousarray(numbers("matrix", matrix), dtype=np.float32)
    if values.ndim != 2 or values.shape[0] != values.shape[1]:
        raise ValueError(f"matrix must be square, not of the shape {values.shape}")
    limits = count("dimensions", dimensions), count("iterations", iterations)
    return CanonicalForm(*_geosweep.canonical(values, *limits))

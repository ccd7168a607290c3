"""Sparse matrices of distances: pairs within a radius, and nearest points."""

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from . import _geosweep
from ._arrays import count, switch
from ._optional import needed
from ._settings import Engine, Wavefront, grid_points, settings
from ._surface import Surface, compiled_of
from ._warnings import check

if TYPE_CHECKING:
    from scipy.sparse import csr_array


def pairs(
    surface: Surface,
    points: ArrayLike | None = None,
    *,
    radius: float | None = None,
    k: int | None = None,
    wavefront: Wavefront = "auto",
    engine: Engine = "auto",
    tolerance: float | None = None,
    iterations: int | None = None,
    threads: int | None = None,
    strict: bool = False,
) -> "csr_array":
    """Compute the distances between points that are close, as a sparse matrix (n, n).

    Parameters
    ----------
    surface
        The surface.
    points
        Rows and columns (n, 2) of grid points; all M N, in row-major order, by default.
    radius
        Largest distance of a pair.
    k
        Number of nearest other points in each row. A radius may limit them further.
    wavefront, engine, tolerance, iterations, threads, strict
        As in `Surface.solve`.

    Returns
    -------
    matrix
        Distances from each point (rows) to others (columns). There is no entry for points that
        are farther or not reached, nor for a point and itself or an equal point. Needs SciPy.

    Examples
    --------
    >>> import numpy as np, geosweep as gs
    >>> plane = gs.Surface.from_heights(np.zeros((9, 9)))
    >>> near = gs.pairs(plane, [(0, 0), (0, 3), (8, 8)], radius=5.0)
    >>> near[[0], [1]].item(), near.nnz
    (3.0, 2)
    """
    sparse = needed("scipy.sparse", "sparse", "pairs()")
    if radius is None and k is None:
        raise ValueError("give a radius or k, or compute all distances with pairwise()")
    k = None if k is None else count("k", k)
    chosen = settings(engine, None, wavefront, tolerance, iterations, threads, radius)
    strict, compiled = switch("strict", strict), compiled_of(surface)
    rows, cols = compiled.shape
    places = np.argwhere(np.ones((rows, cols))) if points is None else grid_points("points", points)
    if (places >= (rows, cols)).any():
        raise ValueError(f"points must lie from (0, 0) to ({rows - 1}, {cols - 1})")
    if k is not None:
        csr = _geosweep.nearest_others(compiled, places.tolist(), k, chosen)
        return sparse.csr_array(csr, shape=(len(places), len(places)))
    of_grid = places[:, 0] * cols + places[:, 1]
    found = _geosweep.within(compiled, of_grid.tolist(), chosen)
    csr, iterations, residual, converged = found
    check(converged, {"iterations": iterations, "residual": residual}, strict)
    matrix = sparse.csr_array(csr, shape=(len(places), rows * cols))[:, of_grid]
    # A point has distance 0 from itself and from equal points, for which there are no entries.
    matrix.setdiag(0)
    matrix.eliminate_zeros()
    return matrix

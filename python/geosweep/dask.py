"""Many maps of one surface as Dask arrays, which workers of `dask.distributed` compute.

The surface is a task of its own: each worker receives it once and keeps it. If a worker is lost,
its part is computed again elsewhere, with the same digits.

>>> import numpy as np, geosweep as gs, geosweep.dask
>>> surface = gs.Surface.from_heights(np.zeros((8, 9)))
>>> matrix = gs.dask.pairwise(surface, chunks=24)
>>> matrix.shape, matrix.chunks[0]
((72, 72), (24, 24, 24))
>>> round(matrix[0, 71].compute().item(), 3)
10.63
"""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, DTypeLike, NDArray

from ._arrays import count as whole
from ._matrix import indices
from ._matrix import pairwise as _pairwise
from ._optional import needed
from ._settings import is_double, settings
from ._sources import Source, native
from ._surface import Surface, compiled_of

if TYPE_CHECKING:
    import dask
    import dask.array as da
else:
    dask = needed("dask", "dask", "geosweep.dask")
    da = needed("dask.array", "dask", "geosweep.dask")


def _as_task(value: Any, name: str) -> Any:
    return dask.delayed(value, name=f"{name}-{dask.base.tokenize(value)}", traverse=False)


def _rows(rows: NDArray[np.int64], surface: Surface, options: dict[str, Any]) -> Any:
    return _pairwise(surface, rows, **options)


def _maps(
    which: NDArray[np.int64],
    surface: Surface,
    sources: list[Source],
    options: dict[str, Any],
) -> NDArray[Any]:
    found = np.empty((len(which), *surface.shape), options["dtype"])
    for k, source in enumerate(which.ravel().tolist()):
        surface.solve(sources[source], out=found[k], **options)
    return found


def pairwise(
    surface: Surface,
    rows: ArrayLike | None = None,
    *,
    chunks: int = 256,
    threads: int | None = 1,
    **options: Any,
) -> "da.Array":
    """Describe rows of the matrix of all distances, (k, M N) of float32, for Dask to compute.

    Parameters
    ----------
    surface
        The surface, with M x N points.
    rows
        Row-major indices of the k points from which distances are wanted; all by default.
    chunks
        Number of rows in a chunk. Multiples of 16 suit the lanes of processors.
    threads
        Number of threads that compute a chunk. Dask computes several chunks at once.
    options
        As in `geosweep.pairwise`.

    Returns
    -------
    matrix
        A Dask array. Its ``to_zarr`` writes the matrix to storage, so that it need not fit into
        memory.
    """
    compiled_of(surface)
    wanted, chunks = indices(surface, rows), whole("chunks", chunks)
    _check(options)
    columns = surface.shape[0] * surface.shape[1]
    return da.from_array(wanted, chunks=chunks, name=False).map_blocks(
        _rows,
        _as_task(surface, "surface"),
        options | {"threads": threads},
        dtype=np.float32,
        new_axis=1,
        chunks=(_sizes(len(wanted), chunks), (columns,)),
        meta=np.empty((0, 0), np.float32),
        name=f"geosweep-pairwise-{dask.base.tokenize(surface, wanted, chunks, options)}",
    )


def distances(
    surface: Surface,
    sources: Sequence[Source],
    *,
    chunks: int = 1,
    threads: int | None = 1,
    dtype: DTypeLike = "float32",
    **options: Any,
) -> "da.Array":
    """Describe a map (M, N) for each of n sources, (n, M, N), for Dask to compute.

    Parameters
    ----------
    surface
        The surface.
    sources
        The source of each map, in any form that `Surface.solve` takes.
    chunks
        Number of maps in a chunk.
    threads
        Number of threads that compute a map. Dask computes several maps at once.
    dtype, options
        As in `Surface.solve`.
    """
    compiled_of(surface)
    chunks = whole("chunks", chunks)
    for source in sources:
        native(source, surface)
    _check(options)
    precision = np.dtype(np.float64 if is_double(dtype) else np.float32)
    options = options | {"threads": threads, "dtype": precision}
    given = list(sources)
    return da.arange(len(given), chunks=chunks).map_blocks(
        _maps,
        _as_task(surface, "surface"),
        _as_task(given, "sources"),
        options,
        dtype=precision,
        new_axis=(1, 2),
        chunks=(_sizes(len(given), chunks), *((size,) for size in surface.shape)),
        meta=np.empty((0, 0, 0), precision),
        name=f"geosweep-distances-{dask.base.tokenize(surface, given, chunks, options)}",
    )


def _check(options: dict[str, Any]) -> None:
    """Check the options here, so that errors are not first raised in a worker."""
    for name in ("out", "progress", "labels"):
        if name in options:
            raise TypeError(f"{name} has no meaning for Dask's arrays; leave it out")
    others = ("strict", "sources_outside")
    settings(**{key: value for key, value in options.items() if key not in others})


def _sizes(count: int, chunk: int) -> tuple[int, ...]:
    return (chunk,) * (count // chunk) + ((count % chunk,) if count % chunk else ())

"""Matrices and maps that Dask computes, with a worker lost on the way."""

import os
import signal
import threading
import time

import numpy as np
import pytest

import geosweep as gs

pytest.importorskip("dask.array")


def surface() -> gs.Surface:
    z = np.random.default_rng(3).normal(size=(24, 30)).cumsum(axis=0).cumsum(axis=1) / 20
    return gs.Surface.from_heights(z, 0.5)


def test_dask_gives_the_same_digits() -> None:
    rows = np.arange(0, 720, 7)
    matrix = gs.dask.pairwise(surface(), rows, chunks=16)
    assert matrix.shape == (103, 720) and matrix.dtype == np.float32
    parts = [gs.pairwise(surface(), rows[k : k + 16]) for k in range(0, 103, 16)]
    assert np.array_equal(matrix.compute(scheduler="threads"), np.concatenate(parts))
    sources = [(3, 4), [(1, 2), (20, 20)], gs.Lines([[(0, 0), (23, 29)]])]
    maps = gs.dask.distances(surface(), sources, dtype="float64")
    assert maps.shape == (3, 24, 30) and maps.dtype == np.float64
    for found, source in zip(maps.compute(scheduler="threads"), sources, strict=True):
        assert np.array_equal(found, surface().solve(source, dtype="float64").distance)


def test_names_depend_on_the_content_alone() -> None:
    first, second = (gs.dask.pairwise(surface(), chunks=c) for c in (90, 90))
    assert first.name == second.name != gs.dask.pairwise(surface(), chunks=80).name


def test_wrong_arguments_are_refused_at_once() -> None:
    for options, kind in [({"engine": "tpu"}, ValueError), ({"out": None}, TypeError)]:
        with pytest.raises(kind):
            gs.dask.pairwise(surface(), **options)
    with pytest.raises(ValueError, match="source"):
        gs.dask.distances(surface(), [(1, 2, 3, 4)])
    with pytest.raises(ValueError, match="rows"):
        gs.dask.pairwise(surface(), [720])


def test_a_lost_worker_changes_nothing(tmp_path) -> None:  # type: ignore[no-untyped-def]
    distributed = pytest.importorskip("distributed")
    expected = gs.dask.pairwise(surface(), chunks=16).compute(scheduler="threads")
    cluster = distributed.LocalCluster(
        n_workers=4, threads_per_worker=1, processes=True, dashboard_address=None
    )
    with cluster, distributed.Client(cluster) as client:
        workers = client.run(os.getpid)
        assert len(workers) == 4
        # A wait in each chunk makes sure that the worker is lost midway.
        slowed = gs.dask.pairwise(surface(), chunks=16).map_blocks(waiting, dtype=np.float32)
        future = client.compute(slowed)
        done = threading.Event()
        future.add_done_callback(lambda _: done.set())
        time.sleep(1.0)
        assert not done.is_set()
        os.kill(next(iter(workers.values())), signal.SIGKILL)
        assert np.array_equal(future.result(timeout=120), expected)
        if zarr := pytest.importorskip("zarr"):
            gs.dask.pairwise(surface(), chunks=90).to_zarr(str(tmp_path / "matrix.zarr"))
            stored = zarr.open(str(tmp_path / "matrix.zarr"))
            assert stored.shape == (720, 720) and np.allclose(stored[:], expected, rtol=1e-5)


def waiting(block: np.ndarray) -> np.ndarray:
    time.sleep(0.2)
    return block

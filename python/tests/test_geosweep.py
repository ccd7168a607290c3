"""Tests of the package, as users call it."""

import os
import signal
import subprocess
import sys
import threading
import time
import warnings
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pytest

import geosweep as gs

ROWS, COLS = 61, 81


def hill() -> np.ndarray:
    rows, cols = np.mgrid[:ROWS, :COLS]
    return 8.0 * np.exp(-((rows - 30.0) ** 2 + (cols - 40.0) ** 2) / 300.0)


def winding(side: int) -> np.ndarray:
    """Return a mask of a square grid whose present points form a winding corridor."""
    mask = np.ones((side, side), bool)
    mask[1::2] = False
    mask[1::4, -1] = True
    mask[3::4, 0] = True
    return mask


def test_distances_on_a_plane_are_exact() -> None:
    d = gs.distance(np.zeros((ROWS, COLS)), (12, 7.5), spacing=(2.0, 3.0))
    rows, cols = np.mgrid[:ROWS, :COLS]
    exact = np.hypot(2.0 * (rows - 12), 3.0 * (cols - 7.5))
    assert d.dtype == np.float32 and d.flags.writeable
    assert np.allclose(d, exact, rtol=2e-6, atol=1e-5)


def test_all_ways_give_the_same_map() -> None:
    z = hill()
    surface = gs.Surface.from_heights(z, spacing=0.5)
    d = surface.solve((3, 4)).distance
    same = [
        gs.distance(z, (3, 4), 0.5),
        gs.distance(np.asfortranarray(z), (3, 4), 0.5),
        gs.distance(z, (3, 4), 0.5, threads=1),
        gs.Surface.from_heights(z, 0.5, copy=False).solve([[3, 4]]).distance,
        surface.solve(np.arange(ROWS * COLS).reshape(ROWS, COLS) == 3 * COLS + 4).distance,
    ]
    for other in same:
        assert np.array_equal(d, other)
    double = gs.distance(z, (3, 4), 0.5, dtype=np.float64)
    assert double.dtype == np.float64 and np.allclose(double, d, rtol=1e-5)


def test_positions_and_a_metric_agree_with_heights() -> None:
    flat = np.zeros((21, 31))
    rows, cols = np.mgrid[:21, :31].astype(float)
    of_heights = gs.distance(flat, (2, 3), (2.0, 1.0))
    positions = np.stack([cols, 2 * rows, flat], axis=-1)
    metric = np.zeros((21, 31, 2, 2))
    metric[..., 0, 0], metric[..., 1, 1] = 4.0, 1.0
    for surface in (gs.Surface.from_positions(positions), gs.Surface.from_metric(metric)):
        assert np.allclose(surface.solve((2, 3)).distance, of_heights, rtol=1e-5)


def test_a_map_is_written_into_the_array_of_the_caller() -> None:
    z = hill()
    m = gs.Surface.from_heights(z).solve((3, 4))
    assert not m.distance.flags.writeable
    out = np.empty((ROWS, COLS), np.float32)
    assert gs.distance(z, (3, 4), out=out) is out
    assert np.array_equal(out, m.distance)
    distance = m.distance
    del m
    assert np.array_equal(out, distance)


def test_a_surface_keeps_a_copy_unless_told_otherwise() -> None:
    z = hill()
    surface = gs.Surface.from_heights(z)
    before = surface.solve((3, 4)).distance
    z[:] = 0.0
    assert np.array_equal(surface.solve((3, 4)).distance, before)


@pytest.mark.parametrize("kind", ["heights", "positions"])
def test_a_surface_without_a_copy_reads_the_array_of_the_caller(kind: str) -> None:
    rows, cols = np.mgrid[:ROWS, :COLS].astype(float)
    array = hill() if kind == "heights" else np.stack([cols, rows, hill()], axis=-1)
    make = gs.Surface.from_heights if kind == "heights" else gs.Surface.from_positions
    surface = make(array, copy=False)
    array[..., -1 if kind == "positions" else slice(None)] = 0.0
    flat = np.hypot(rows - 3, cols - 4)
    assert np.allclose(surface.solve((3, 4)).distance, flat, rtol=1e-5)


def test_results_are_views_of_memory_that_outlives_the_map() -> None:
    surface = gs.Surface.from_heights(hill(), mask=hill() < 7.9)
    m = surface.solve((3, 4))
    assert np.shares_memory(m.distance, m.distance)
    assert np.shares_memory(surface.present, surface.present)
    out = np.empty((ROWS, COLS), np.float32)
    assert np.shares_memory(surface.solve((3, 4), out=out).distance, out)
    rows = np.empty((2, ROWS * COLS), np.float32)
    assert np.shares_memory(gs.pairwise(surface, [3, 4], out=rows), rows)
    present = surface.present
    del surface
    assert np.array_equal(present, np.isfinite(m.distance))


def test_sources_have_starts_and_may_be_lines() -> None:
    surface = gs.Surface.from_heights(np.zeros((ROWS, COLS)))
    d = surface.solve([(10, 10, 5.0), (50, 70, 0.0)]).distance
    assert d[10, 10] == 5.0 and d[50, 70] == 0.0
    line = surface.solve(gs.Lines([[(30, 0), (30, 80)]])).distance
    assert np.allclose(line, np.abs(np.mgrid[:ROWS, :COLS][0] - 30.0), atol=1e-4)


def test_geometry_of_a_map() -> None:
    surface = gs.Surface.from_heights(np.zeros((ROWS, COLS)))
    m = surface.solve([(30, 20), (30, 61)])
    assert (m.nearest[:, :40] == 0).all() and (m.nearest[:, 41:] == 1).all()
    (regions, border), *_ = m.voronoi().borders
    assert regions == (0, 1) and np.allclose(border[:, 1], 40.5, atol=0.01)
    path = m.paths([(30, 35)])[0]
    assert path.source == 0 and path.length == pytest.approx(15.0, rel=1e-6)
    assert path.vertices[0].tolist() == [30, 35] and path.vertices[-1].tolist() == [30, 20]
    level = m.contours([10.0])[0]
    assert len(level.curves) == 2
    assert np.allclose(np.hypot(*(level.curves[0] - level.curves[0].mean(axis=0)).T), 10, atol=0.3)
    assert any(np.allclose(ridge.vertices[:, 1], 40.5, atol=0.6) for ridge in m.ridges())
    row, col, far = m.farthest()
    assert m.distance[row, col] == pytest.approx(far) == m.report["max_distance"]
    assert np.nanmax(np.where(np.isfinite(m.error()), m.error(), 0)) < 1.0
    along = surface.solve(gs.Lines([[(30, 20), (30, 60)]]))
    (offset,) = along.offsets([8.0], side="left")
    assert all((curve[:, 0] < 30.5).all() for curve in offset.curves)


def test_route_runs_from_start_to_end() -> None:
    path, length = gs.route(np.zeros((ROWS, COLS)), (0, 0), (30, 40), spacing=2.0)
    assert path[0].tolist() == [0, 0] and path[-1].tolist() == [30, 40]
    assert length == pytest.approx(100.0, rel=1e-6)


def test_pairs_and_canonical_forms() -> None:
    surface = gs.Surface.from_heights(np.zeros((8, 9)))
    matrix = gs.pairwise(surface)
    rows, cols = np.divmod(np.arange(72), 9)
    exact = np.hypot(rows[:, None] - rows, cols[:, None] - cols)
    assert np.allclose(matrix, exact, rtol=2e-5)
    out = np.empty((2, 72), np.float32)
    assert gs.pairwise(surface, [5, 30], out=out) is out
    assert np.allclose(out, matrix[[5, 30]], rtol=2e-5)
    form = gs.canonical_form(matrix, 2)
    assert form.coordinates.shape == (72, 2) and form.stress < 1e-3 and form.converged
    samples, radius = surface.farthest_points((0, 0), 3)
    assert samples[0].tolist() == [7, 8] and 0 < radius < 8


def test_a_winding_corridor_is_reached_to_its_end() -> None:
    mask = winding(256)
    d = gs.distance(np.zeros(mask.shape), (0, 0), mask=mask)
    assert np.array_equal(np.isfinite(d), mask) and mask.sum() == 32896


def test_errors_name_the_argument() -> None:
    z = hill()
    cases = [
        (lambda: gs.distance(z, (300, 4)), ValueError, "source"),
        (lambda: gs.distance(z, "here"), TypeError, "source"),
        (lambda: gs.distance(z, np.zeros((ROWS, COLS), bool)), ValueError, "source"),
        (lambda: gs.distance(z[0], (3, 4)), ValueError, "heights"),
        (lambda: gs.distance(z, (3, 4), spacing=-1), ValueError, "spacing"),
        (lambda: gs.distance(z, (3, 4), spacing=(1, 2, 3)), ValueError, "spacing"),
        (lambda: gs.distance(z, (3, 4), mask=np.ones(3)), ValueError, "mask"),
        (lambda: gs.distance(z, (3, 4), engine="tpu"), ValueError, "engine"),  # type: ignore
        (lambda: gs.distance(z, (3, 4), dtype="int8"), ValueError, "dtype"),
        (lambda: gs.distance(z, (3, 4), out=np.empty((2, 2))), ValueError, "out"),
        (lambda: gs.distance(z, (3, 4), threads=0), ValueError, "threads"),
        (lambda: gs.distance(z * np.inf, (3, 4)), ValueError, "height|NaN"),
        (lambda: gs.pairwise(gs.Surface.from_heights(z), [-1]), ValueError, "rows"),
    ]
    for call, kind, name in cases:
        with pytest.raises(kind, match=name):
            call()


def test_a_map_that_has_not_converged_is_reported() -> None:
    mask = winding(65)
    surface = gs.Surface.from_heights(np.zeros(mask.shape), mask=mask)
    with pytest.warns(gs.ConvergenceWarning, match="iterations"):
        surface.solve((0, 0), iterations=2)
    with pytest.raises(gs.ConvergenceError, match="iterations"):
        surface.solve((0, 0), iterations=2, strict=True)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert surface.solve((0, 0)).report["converged"]


def test_an_exception_in_the_callback_ends_the_solve() -> None:
    mask = winding(1025)
    surface = gs.Surface.from_heights(np.zeros(mask.shape), mask=mask)
    raised = []

    def stop(done: int, total: int) -> None:
        raised.append(time.monotonic())
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        surface.solve((0, 0), wavefront="curved", engine="cpu", progress=stop)
    assert len(raised) == 1 and time.monotonic() - raised[0] < 3.0


@pytest.mark.parametrize("what", ["solve", "paths", "log_map", "farthest_points"])
def test_ctrl_c_ends_a_computation(what: str) -> None:
    mask = winding(1025)
    maze = gs.Surface.from_heights(np.zeros(mask.shape), mask=mask)
    rows = np.arange(513.0)
    surface = gs.Surface.from_heights(30 * np.sin(rows / 9)[:, None] * np.cos(rows / 7))
    m = surface.solve((100, 100), engine="cpu")
    ends = np.random.default_rng(3).uniform(0, 512, (200000, 2))
    call = {
        "solve": lambda: maze.solve((0, 0), wavefront="curved", engine="cpu"),
        "paths": lambda: m.paths(ends),
        "log_map": m.log_map,
        "farthest_points": lambda: surface.farthest_points((0, 0), 100000),
    }[what]
    # Programs that are started in the background may ignore the signal.
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    timer = threading.Timer(0.1, signal.raise_signal, [signal.SIGINT])
    timer.start()
    try:
        with pytest.raises(KeyboardInterrupt):
            call()
    finally:
        timer.join()
        signal.signal(signal.SIGINT, before)


def test_threads_do_not_disturb_one_another() -> None:
    surface = gs.Surface.from_heights(hill())
    sources = [(3, k) for k in range(16)]
    expected = [surface.solve(source).distance for source in sources]
    found: dict[int, np.ndarray] = {}

    def work(first: int) -> None:
        for k in range(first, 16, 4):
            found[k] = surface.solve(sources[k], threads=1).distance

    threads = [threading.Thread(target=work, args=(k,)) for k in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert all(np.array_equal(found[k], expected[k]) for k in range(16))


def exit_status(child: int, seconds: float) -> int:
    """Return the exit status of a child. A child that takes longer than `seconds` is killed."""
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        ended, status = os.waitpid(child, os.WNOHANG)
        if ended == child:
            return os.waitstatus_to_exitcode(status)
        time.sleep(0.02)
    os.kill(child, signal.SIGKILL)
    return os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])


@pytest.mark.skipif(not hasattr(os, "fork"), reason="this system has no fork")
@pytest.mark.parametrize("threads", [None, 2])
def test_a_forked_child_computes_the_same_map(threads: int | None) -> None:
    def farthest() -> tuple[np.ndarray, tuple[int, int, float]]:
        m = gs.Surface.from_heights(hill()).solve((3, 4), threads=threads)
        return m.distance, m.farthest()

    expected, far = farthest()
    with warnings.catch_warnings():
        # Python 3.12 and later warn of a fork beside other threads.
        warnings.simplefilter("ignore", DeprecationWarning)
        child = os.fork()
    if child == 0:
        status = 1
        try:
            found, again = farthest()
            status = 0 if np.array_equal(found, expected) and again == far else 2
        finally:
            os._exit(status)
    assert exit_status(child, seconds=120) == 0


def test_devices_are_listed() -> None:
    assert all(isinstance(device, gs.Device) for device in gs.devices())


def usable_devices() -> list[gs.Device]:
    wanted = os.environ.get("GEOSWEEP_TEST_DEVICE", "")
    return [device for device in gs.devices() if wanted in device.name and not device.unmet]


def test_a_device_gives_the_same_map() -> None:
    usable = usable_devices()
    if not usable:
        with pytest.raises(RuntimeError):
            gs.distance(hill(), (3, 4), engine="gpu", device="no such device")
        pytest.skip("no Vulkan device")
    surface = gs.Surface.from_heights(hill())

    def solve(_: int) -> gs.DistanceMap:
        return surface.solve((3, 4), engine="gpu", device=usable[0].index)

    m = solve(0)
    assert m.report["device"] == usable[0].name
    assert np.allclose(m.distance, gs.distance(hill(), (3, 4), engine="cpu"), rtol=1e-5)
    # The device stays open for later calls. Calls at the same time open the device once each.
    with ThreadPoolExecutor(2) as threads:
        assert all(
            np.array_equal(again.distance, m.distance) for again in threads.map(solve, range(4))
        )


def test_the_pipelines_of_an_open_device_are_saved(tmp_path: Path) -> None:
    usable = usable_devices()
    if not usable:
        pytest.skip("no Vulkan device")
    device = usable[0].index
    program = f"""
import numpy as np, geosweep as gs
gs.distance(np.zeros((9, 12)), (3, 4), engine="gpu", device={device})
"""
    environment = {**os.environ, "GEOSWEEP_PIPELINES": str(tmp_path)}
    subprocess.run([sys.executable, "-c", program], env=environment, check=True, timeout=300)
    assert len(list(tmp_path.glob("*.pipelines"))) == 1

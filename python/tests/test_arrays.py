"""Arrays of other libraries, and maps of the tool."""

import os
import subprocess
from pathlib import Path

import numpy as np
import pytest

import geosweep as gs

Z = np.hypot(*np.mgrid[-20:21, -30:31]) / 3


class Elsewhere:
    """An array on a device, as DLPack shows it."""

    def __init__(self, array: np.ndarray, device: tuple[int, int]) -> None:
        self.array = array
        self.device = device
        self.copies = 0

    def __dlpack_device__(self) -> tuple[int, int]:
        return self.device

    def __dlpack__(self, *, dl_device=None, copy=None, **options):  # type: ignore[no-untyped-def]
        if self.device[0] == 1:
            return self.array.__dlpack__(**options)
        if dl_device != (1, 0):
            raise BufferError("not on the host")
        self.copies += 1
        return self.array.__dlpack__(**options)


def test_arrays_that_are_not_aligned_are_copied() -> None:
    memory = np.empty(Z.nbytes + 1, np.uint8)
    z = memory[1:].view(np.float64).reshape(Z.shape)
    z[:] = Z
    assert not z.flags.aligned
    assert np.array_equal(gs.distance(z, (3, 4)), gs.distance(Z, (3, 4)))


def test_dlpack_on_the_host_is_not_copied() -> None:
    z = Z.copy()
    there = Elsewhere(z, (1, 0))
    surface = gs.Surface.from_heights(there, copy=False)  # type: ignore[arg-type]
    assert np.array_equal(surface.solve((3, 4)).distance, gs.distance(z, (3, 4)))
    # An array must not change while the surface is used. A change before shows that it is shared.
    shared = gs.Surface.from_heights(there, copy=False)  # type: ignore[arg-type]
    z[:] = z[::-1].copy()
    assert np.array_equal(shared.solve((3, 4)).distance, gs.distance(z, (3, 4)))


@pytest.mark.skipif(np.lib.NumpyVersion(np.__version__) < "2.1.0", reason="needs NumPy 2.1")
def test_dlpack_on_a_device_is_copied_and_said() -> None:
    there = Elsewhere(Z, (2, 0))
    with pytest.warns(gs.HostCopyWarning, match="heights lies on a device"):
        d = gs.distance(there, (3, 4))  # type: ignore[arg-type]
    assert there.copies == 1 and np.array_equal(d, gs.distance(Z, (3, 4)))


def test_arrays_that_cannot_be_exported_are_refused() -> None:
    class Stubborn(Elsewhere):
        def __dlpack__(self, **_):  # type: ignore[no-untyped-def]
            raise BufferError("needs its gradient")

    for device in [(1, 0), (2, 0)]:
        with pytest.raises(TypeError, match=r"heights.*needs its gradient"):
            gs.distance(Stubborn(Z, device), (3, 4))  # type: ignore[arg-type]


@pytest.mark.parametrize("library", ["torch", "jax.numpy"])
def test_arrays_of_other_libraries(library: str) -> None:
    module = pytest.importorskip(library)
    z = Z.astype(np.float32)
    there = module.asarray(z)
    inside = module.asarray(Z > 1)
    assert np.array_equal(
        gs.distance(there, (3, 4), mask=inside), gs.distance(z, (3, 4), mask=Z > 1)
    )


def test_maps_equal_those_of_the_tool(tmp_path: Path) -> None:
    tool = os.environ.get("GEOSWEEP_TOOL")
    if not tool:
        pytest.skip("GEOSWEEP_TOOL names no tool")
    z = np.random.default_rng(7).normal(size=(90, 120)).cumsum(axis=0).cumsum(axis=1) / 50
    np.save(tmp_path / "z.npy", z)
    for precision, dtype in [("single", np.float32), ("double", np.float64)]:
        out = tmp_path / f"{precision}.npy"
        # The tool's spacing is DX,DY, ours (dy, dx).
        arguments = ["--spacing", "2,3", "--source", "20.5,30", "--engine", "cpu"]
        command = [tool, "distance", tmp_path / "z.npy", *arguments, "--precision", precision]
        subprocess.run([*map(str, command), "-o", str(out)], check=True, capture_output=True)
        d = gs.distance(z, (20.5, 30), spacing=(3, 2), engine="cpu", dtype=dtype)
        found = np.load(out)
        assert found.dtype == d.dtype and np.array_equal(found, d)

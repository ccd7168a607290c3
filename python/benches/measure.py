"""Measures what the package adds to the library: time of a call, memory, and how threads scale.

    python python/benches/measure.py [SIDE]

SIDE is the size of the large map, 4096 by default. Run it on an idle machine.
"""

import resource
import sys
import time
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor

import numpy as np

import geosweep as gs
from geosweep._settings import settings
from geosweep._sources import native


def waves(side: int) -> np.ndarray:
    """Return smooth heights."""
    i = np.arange(side) * 0.05
    return np.sin(i)[:, None] * np.cos(i)


def least(call: Callable[[], object], repeats: int) -> float:
    """Return the least time of a call in microseconds."""
    times = []
    for _ in range(repeats):
        start = time.perf_counter()
        call()
        times.append(time.perf_counter() - start)
    return 1e6 * min(times)


def peak() -> float:
    """Return the largest memory of the process so far, in MB."""
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024


class Solved:
    """Stand-in for a compiled surface, with a map that is computed in advance."""

    def __init__(self, compiled: "gs._geosweep.Surface") -> None:
        self.shape = compiled.shape
        problem = (*native((3, 4), compiled.shape), settings("cpu"), False)
        self.found = compiled.solve(problem, None)

    def solve(self, *_: object) -> "gs._geosweep.Map":
        """Return the map."""
        return self.found


def main() -> None:
    """Print the figures."""
    surface = gs.Surface.from_heights(waves(64))
    whole = least(lambda: surface.solve((3, 4), engine="cpu"), 2000)
    surface._surface = Solved(surface._surface)  # type: ignore[assignment]
    around = least(lambda: surface.solve((3, 4), engine="cpu"), 2000)
    print(f"64 x 64: {whole:.0f} us a call, of which {around:.1f} us before and after Rust")

    surface = gs.Surface.from_heights(waves(512))
    sources = [(k, 2 * k) for k in range(16)]
    seconds = {}
    for threads in (1, 2):
        with ThreadPoolExecutor(threads) as pool:
            start = time.perf_counter()
            list(pool.map(lambda source: surface.solve(source, engine="cpu", threads=1), sources))
            seconds[threads] = time.perf_counter() - start
    print(f"two threads: {seconds[1] / seconds[2]:.2f} times as many maps of 512 x 512 as one")

    side = int(sys.argv[1]) if len(sys.argv) > 1 else 4096
    heights = waves(side)
    print(f"{side} x {side}: {peak():.0f} MB before the solve", end=", ")
    gs.distance(heights, (3, 4), engine="cpu")
    print(f"{peak():.0f} MB at most")


if __name__ == "__main__":
    main()

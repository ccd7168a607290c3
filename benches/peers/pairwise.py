"""All pairs: compares geosweep's matrix of distances with other solvers.

On square grids of a sphere, whose distances are known, this measures time, distances per second
and mean relative error of each solver. Set-up (factoring, building structures) does not count.
Peers compute rows of some sources, spread over the grid, in one process per core, since none of
them uses more than one core. geosweep computes the whole matrix on all cores. No time includes
writing a file. For a solver that is not installed, a line says so.

    .venv/bin/python benches/peers/pairwise.py --geosweep target/release/geosweep
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from grids import Grid
from references import sphere
from solvers import Exact, GeometryCentralHeat, Place, Solver, lacks


class Gdist(Solver):
    """The Virtual Brain's wrapper of Kirsanov's exact algorithm, one source at a time."""

    name, needs = "gdist (exact on the mesh)", ("gdist",)

    def solve(self, source: Place) -> np.ndarray:
        import gdist

        start = np.array([self.vertex(source)], dtype=np.int32)
        return self.grid.to_map(gdist.compute_gdist(self.grid.vertices, self.grid.faces, start))


# The number of sources for each peer. It keeps the time at seconds instead of minutes.
PEERS: dict[Callable[[], Solver], int] = {GeometryCentralHeat: 512, Exact: 128, Gdist: 64}

OURS = {
    "geosweep planar, 1 iteration": ("--wavefront", "planar", "--iterations", "1"),
    "geosweep circular": ("--wavefront", "circular"),
    "geosweep curved": ("--wavefront", "curved"),
}


@dataclass(frozen=True)
class Result:
    """Rate at which a solver computed rows of the matrix, and the error of these rows."""

    name: str
    rows: int
    seconds: float
    rate: float
    error: float


def spread_sources(points: int, count: int) -> np.ndarray:
    return np.linspace(0, points - 1, count).round().astype(int)


def mean_error(grid: Grid, rows: np.ndarray, sources: np.ndarray) -> float:
    """Returns the mean over sources of the mean relative error over all other points."""

    def of(row: np.ndarray, source: int) -> float:
        place = np.unravel_index(source, grid.shape)
        exact = sphere(*grid.shape, (int(place[0]), int(place[1])))
        other = exact > 0
        return float(np.abs(row.reshape(grid.shape)[other] / exact[other] - 1).mean())

    return float(np.mean([of(row, source) for row, source in zip(rows, sources, strict=True)]))


_solver: Solver


def _prepare(maker: Callable[[], Solver], positions: np.ndarray) -> None:
    """Sets a process up, with one solve as a warm-up."""
    global _solver
    _solver = maker()
    _solver.prepare(Grid(positions))
    _solver.solve((0, 0))


def _rows(places: list[Place]) -> tuple[float, list[np.ndarray]]:
    clock = time.perf_counter()
    rows = [_solver.solve(place).ravel() for place in places]
    return time.perf_counter() - clock, rows


def peer(maker: Callable[[], Solver], grid: Grid, count: int, processes: int) -> Result:
    """Computes rows of some sources in several processes at once."""
    sources = spread_sources(grid.present.size, count)
    places = [tuple(map(int, np.unravel_index(source, grid.shape))) for source in sources]
    parts = [places[start::processes] for start in range(processes)]
    arguments = (maker, grid.positions)
    with ProcessPoolExecutor(processes, initializer=_prepare, initargs=arguments) as pool:
        # A first call without sources sets up all processes before the clocks start.
        list(pool.map(_rows, [[] for _ in parts]))
        done = list(pool.map(_rows, parts))
    seconds = max(taken for taken, _ in done)
    rows = np.empty((count, grid.present.size))
    for start, (_, part) in enumerate(done):
        rows[start::processes] = part
    rate = count * grid.present.size / seconds
    return Result(maker().name, count, seconds, rate, mean_error(grid, rows, sources))


def ours(name: str, binary: Path, grid: Grid, runs: int) -> Result:
    """Computes the whole matrix in some runs, and returns the run with the median time."""
    with tempfile.TemporaryDirectory() as folder:
        positions, matrix = Path(folder) / "positions.npy", Path(folder) / "matrix.npy"
        np.save(positions, grid.positions)
        command = [binary, "pairwise", positions, "--json", *OURS[name]]
        reports = []
        for _ in range(runs):
            run = subprocess.run(command, check=True, capture_output=True, text=True)
            reports.append(json.loads(run.stdout))
        subprocess.run([*command, "-o", matrix], check=True, capture_output=True)
        reports.sort(key=lambda report: report["solve_seconds"])
        middle = reports[len(reports) // 2]
        sources = spread_sources(grid.present.size, 64)
        error = mean_error(grid, np.load(matrix, mmap_mode="r")[sources], sources)
    seconds, rate = middle["solve_seconds"], middle["distances_per_second"]
    return Result(name, grid.present.size, seconds, rate, error)


def table(results: list[Result]) -> str:
    """Returns a table of all solvers.

    In a peer's row, the last column has the rates, relative to the peer's, of those geosweep
    methods whose error is no larger than the peer's.
    """
    own = [result for result in results if result.name.startswith("geosweep")]
    lines = [
        "| solver | rows | seconds | distances/s | mean relative error | geosweep's rate over it |",
        "|---|---:|---:|---:|---:|---|",
    ]
    for result in results:
        ratio = ""
        if result not in own:
            # A method that is exact on the mesh has an error too, that of the mesh.
            better = [one for one in own if one.error <= result.error]
            ratio = ", ".join(f"{one.rate / result.rate:.0f} ({one.name[9:]})" for one in better)
        lines.append(
            f"| {result.name} | {result.rows} | {result.seconds:.3g} | {result.rate / 1e6:.3g} M "
            f"| {result.error:.1e} | {ratio} |"
        )
    return "\n".join(lines)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--geosweep", type=Path, required=True, help="the tool")
    parser.add_argument("--size", type=int, default=65, help="points a side (default 65)")
    parser.add_argument("--runs", type=int, default=5, help="runs of geosweep; the median counts")
    processes = len(os.sched_getaffinity(0))
    parser.add_argument("--processes", type=int, default=processes, help="for peers (all cores)")
    options = parser.parse_args()

    with tempfile.TemporaryDirectory() as folder:
        positions = Path(folder) / "positions.npy"
        name = f"sphere:{options.size}x{options.size}"
        subprocess.run([options.geosweep, "builtin", name, "-o", positions], check=True)
        grid = Grid.load(positions)
    results = [ours(name, options.geosweep.resolve(), grid, options.runs) for name in OURS]
    for maker, count in PEERS.items():
        if missing := lacks(maker()):
            print(f"{maker().name}: {missing} is not installed", file=sys.stderr)
            continue
        try:
            results.append(peer(maker, grid, count, options.processes))
        except Exception as error:  # A failing peer does not end the run.
            print(f"{maker().name}: {error}", file=sys.stderr)
    print(table(results))


if __name__ == "__main__":
    main()

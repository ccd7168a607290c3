#!/usr/bin/env python3
"""Compares geosweep on Vulkan with agd's eikonal solver in CUDA, on the same NVIDIA GPU.

    pip install agd==0.2.16 "cupy-cuda12x[ctk]" numpy scipy
    python benches/peers/agd_gpu.py --geosweep target/release/geosweep --device NVIDIA

Without a GPU, `--mode cpu` sends the same input to agd's CPU solver (needs hfmpy), which tests
all of this script except the GPU's part.

agd's input is the first fundamental form of the grid per step, as for HFM in compare.py, in
single precision. It is scaled so that a step has a length of about one: agd's tolerance is
partly absolute and made for such grids. agd's time is `solverGPUTime`, its own clock around its
iterations, after one run that does not count (CUDA compiles then). The rest of its run, which
decomposes the metric and copies, counts as set-up. geosweep's times are as in compare.py.
"""

from __future__ import annotations

import argparse
import statistics
import subprocess
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

import references
import report
from compare import numbers, source_of, words
from grids import Grid, errors
from solvers import WAVEFRONTS, Geosweep, Place, Solver, first_fundamental_form


@dataclass(frozen=True)
class Setting:
    """Settings with which agd solves."""

    order: int
    radius: float
    solver: str

    def __str__(self) -> str:
        factored = f"factored to {self.radius:.0f} steps" if self.radius else "not factored"
        return f"agd {self.solver}, order {self.order}, {factored}"


class Agd(Solver):
    """agd's solver: `gpu` in CUDA through CuPy, `cpu` by HFM with the same input."""

    def __init__(self, mode: str, setting: Setting) -> None:
        self.mode, self.setting, self.name = mode, setting, str(setting)

    def prepare(self, grid: Grid) -> None:
        super().prepare(grid)
        metric = first_fundamental_form(grid)
        self.step = float(np.sqrt(np.trace(metric).mean() / 2))
        self.metric = self.array(metric / self.step**2)

    def array(self, values: np.ndarray) -> Any:
        """Returns the array on the GPU in single precision, or unchanged."""
        if self.mode == "cpu":
            return values
        import cupy

        return cupy.asarray(values, dtype=cupy.float32)

    def solve(self, source: Place) -> np.ndarray:
        from agd import Eikonal

        entries = self.input(source)
        self.wait()
        output = Eikonal.dictIn(entries).Run()
        self.wait()
        self.seconds = float(output["FMCPUTime" if self.mode == "cpu" else "solverGPUTime"])
        values = output["values"]
        return self.step * np.asarray(
            values.get() if self.mode == "gpu" else values, dtype=np.float64
        )

    def input(self, source: Place) -> dict[str, Any]:
        from agd import Metrics

        entries = {
            "mode": self.mode,
            "model": "Riemann2",
            "metric": Metrics.Riemann(self.metric),
            "dims": np.array(self.grid.shape),
            "gridScale": 1.0,
            "origin": np.array([-0.5, -0.5]),
            "seed": np.array(source, dtype=float),
            "order": self.setting.order,
            "exportValues": 1.0,
            "verbosity": 0,
        }
        if self.setting.radius:
            entries["factoringRadius"] = self.setting.radius
        if self.mode == "gpu":
            entries["solver"] = self.setting.solver
            # agd does not accept NumPy arrays together with CuPy arrays.
            for name in ("dims", "origin", "seed"):
                entries[name] = entries[name].tolist()
        if not self.grid.present.all():
            walls = ~self.grid.present
            entries["walls"] = (
                walls.astype(float) if self.mode == "cpu" else self.array(walls).astype(bool)
            )
        return entries

    def wait(self) -> None:
        """Waits until the GPU is idle, since calls to it return at once."""
        if self.mode == "gpu":
            import cupy

            cupy.cuda.Device().synchronize()


def let_new_cupy_compile() -> None:
    """Makes CuPy compile without agd's option `-default-device` if compiling with it fails.

    Since version 13.3 CuPy adds the option itself, and the compiler refuses an option that is given
    twice. agd 0.2.16 leaves the option out for CuPy 13.3 only.
    """
    import cupy

    original = cupy.RawModule

    def module(*arguments: Any, options: tuple[str, ...] = (), **others: Any) -> Any:
        try:
            compiled = original(*arguments, options=options, **others)
            compiled.compile()
        except cupy.cuda.compiler.CompileException as error:
            if "default" not in str(error):
                raise
            rest = tuple(option for option in options if option != "-default-device")
            compiled = original(*arguments, options=rest, **others)
        return compiled

    cupy.RawModule = module


def main() -> None:
    options = arguments()
    if options.mode == "gpu":
        let_new_cupy_compile()
    rows = []
    with tempfile.TemporaryDirectory() as folder:
        for size in options.sizes:
            for surface in options.surfaces:
                rows += compare(surface, size, options, Path(folder))
    print(report.markdown(rows))
    if options.csv:
        report.write_csv(options.csv, rows)


def arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument(
        "--geosweep", type=Path, required=True, help="the tool, package geosweep-cli"
    )
    parser.add_argument(
        "--device", default="0", help="of geosweep: index or part of a name in `geosweep devices`"
    )
    parser.add_argument("--mode", choices=("gpu", "cpu"), default="gpu", help="where agd runs")
    parser.add_argument("--surfaces", type=words, default=("plane", "sphere", "cone", "maze"))
    parser.add_argument(
        "--sizes", type=numbers, default=[1200], help="points a side, e.g. 400,1200"
    )
    parser.add_argument("--orders", type=numbers, default=[1, 2])
    parser.add_argument("--radii", type=numbers, default=[0, 10, 30], help="of factoring, in steps")
    parser.add_argument("--solvers", type=words, default=("AGSI", "FIM"), help="agd's schedules")
    parser.add_argument("--repeats", type=int, default=5, help="solves of which the median counts")
    parser.add_argument("--csv", type=Path, help="where to write the rows")
    options = parser.parse_args()
    options.geosweep = options.geosweep.resolve()
    return options


def compare(surface: str, size: int, options: argparse.Namespace, folder: Path) -> list[report.Row]:
    positions = folder / "positions.npy"
    subprocess.run(
        [options.geosweep, "builtin", f"{surface}:{size}x{size}", "-o", positions], check=True
    )
    grid, source = Grid.load(positions), source_of(surface, size)
    exact = references.exact(surface, grid.present, source, None)
    if exact is None:
        return []
    return [
        measured(surface, size, solver, grid, source, exact, options.repeats)
        for solver in solvers(options)
    ]


def solvers(options: argparse.Namespace) -> list[Solver]:
    device = ("--device", options.device)
    ours = [Geosweep(options.geosweep, "vulkan", wavefront, device) for wavefront in WAVEFRONTS]
    schedules = options.solvers if options.mode == "gpu" else ("CPU",)
    settings = [Setting(o, r, s) for s in schedules for o in options.orders for r in options.radii]
    return [*ours, *(Agd(options.mode, setting) for setting in settings)]


def measured(
    surface: str,
    size: int,
    solver: Solver,
    grid: Grid,
    source: Place,
    exact: np.ndarray,
    repeats: int,
) -> report.Row:
    """Measures a solver in this process, to keep the GPU's context. The first solve warms up."""
    try:
        solver.prepare(grid)
        solver.solve(source)
        times = []
        for _ in range(repeats):
            clock = time.perf_counter()
            distances = solver.solve(source)
            whole, solve = time.perf_counter() - clock, solver.seconds or 0.0
            times.append((whole - solve, solve))
    except Exception as error:  # A failing setting must not stop the others.
        return report.Row(
            surface, size, solver.name, failure=f"{type(error).__name__}: {error}".splitlines()[0]
        )
    set_up, solve = (statistics.median(column) for column in zip(*times, strict=True))
    found = errors(distances, exact)
    return report.Row(
        surface, size, solver.name, set_up, solve, found.mean, found.largest, found.missing
    )


if __name__ == "__main__":
    main()

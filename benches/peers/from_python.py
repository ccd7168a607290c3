#!/usr/bin/env python3
"""Compares solvers that a program in Python can call, on a terrain and on half a cylinder.

    python benches/peers/from_python.py

All solvers get the same heights with their spacing; those on meshes get the triangles of grids.py. This script
needs requirements.txt, and `pip install ./python scikit-image xarray-spatial`.

The terrain is that of terrain.py: crops of 65 x 65 points, whose reference is exact on a finer mesh. The half
cylinder has 400 x 400 points and a closed form. Solvers that see no heights measure distances in the map's
plane; their errors show how much the heights matter.
"""

from __future__ import annotations

import statistics
import tempfile
from collections.abc import Callable
from functools import partial
from pathlib import Path

import numpy as np

from grids import Grid, errors
from measure import Failure, measure
from report import fraction
from solvers import (
    Exact,
    GeometryCentralHeat,
    GeometryCentralMarching,
    HamiltonFastMarching,
    Place,
    ScikitFmm,
    Solver,
    lacks,
)
from terrain import CROPS, prepared

SIDE = 400
# The cylinder's radius, and the largest |x| of the grid as a fraction of it. Slopes reach 1.3.
RADIUS, PART = 1.0, 0.8
SOURCE = (124, 164)


class OnHeights(Solver):
    """A solver on heights above an even grid."""

    def prepare(self, grid: Grid) -> None:
        super().prepare(grid)
        x, y, self.heights = np.moveaxis(grid.positions, 2, 0)
        self.heights = np.ascontiguousarray(self.heights)
        self.spacing = (abs(y[1, 0] - y[0, 0]), abs(x[0, 1] - x[0, 0]))


class Geosweep(OnHeights):
    """geosweep's package for Python: one call from heights to distances, edges included."""

    needs = ("geosweep",)

    def __init__(self, dtype: str) -> None:
        self.dtype = dtype
        self.name = f"geosweep, {dtype}"

    def solve(self, source: Place) -> np.ndarray:
        import geosweep

        options = {"engine": "cpu", "dtype": self.dtype}
        return geosweep.distance(self.heights, source, self.spacing, **options)


class XarraySpatial(OnHeights):
    """Dijkstra over the edges to eight neighbours, in space."""

    name, needs = "xarray-spatial surface_distance", ("xrspatial", "xarray")

    def prepare(self, grid: Grid) -> None:
        import xarray

        super().prepare(grid)
        rows, cols = grid.shape
        dy, dx = self.spacing
        coords = {"y": dy * np.arange(rows)[::-1], "x": dx * np.arange(cols)}
        self.elevation = xarray.DataArray(self.heights, coords, ("y", "x"))
        self.solve((0, 0))  # compiles

    def solve(self, source: Place) -> np.ndarray:
        from xrspatial.surface_distance import surface_distance

        cells = self.elevation * 0
        cells[source] = 1
        return surface_distance(cells, self.elevation).values


class Mcp(OnHeights):
    """Dijkstra over the edges to eight neighbours, in the plane."""

    name, needs = "scikit-image MCP_Geometric (sees no heights)", ("skimage.graph",)

    def solve(self, source: Place) -> np.ndarray:
        from skimage.graph import MCP_Geometric

        ways = MCP_Geometric(np.ones(self.grid.shape), sampling=self.spacing)
        return ways.find_costs([source])[0]


class Flat(ScikitFmm):
    """Second-order fast marching in the plane."""

    name = "scikit-fmm (sees no heights)"


SOLVERS: list[Callable[[], Solver]] = [
    partial(Geosweep, "float32"),
    partial(Geosweep, "float64"),
    Exact,
    partial(HamiltonFastMarching, 2, 10),
    GeometryCentralHeat,
    GeometryCentralMarching,
    XarraySpatial,
    Mcp,
    Flat,
]


def half_cylinder() -> tuple[np.ndarray, np.ndarray]:
    """Returns positions (M, N, 3) and exact distances from the source."""
    x = np.linspace(-PART * RADIUS, PART * RADIUS, SIDE)
    y = np.linspace(0, 2 * PART * RADIUS, SIDE)
    positions = np.stack(
        np.broadcast_arrays(x[None], y[:, None], np.sqrt(RADIUS**2 - x**2)[None]), axis=-1
    )
    around = RADIUS * np.arcsin(x / RADIUS)
    row, col = SOURCE
    return positions, np.hypot(y[:, None] - y[row], around[None] - around[col])


def line(make: Callable[[], Solver], folder: Path) -> str:
    """Returns a solver's row of the table."""
    solver = make()
    missing = lacks(solver)
    if missing:
        return f"| {solver.name} | {missing} is not installed | | | |"
    means, largest = [], []
    for crop in CROPS:
        for case in CASES[crop]:
            result = measure(make, case.positions, case.source, repeats=1, limit=300, cores=1)
            if isinstance(result, Failure):
                return f"| {solver.name} | {result.reason} | | | |"
            found = errors(result.distances, case.exact)
            means.append(found.mean)
            largest.append(found.largest)
    row = f"| {solver.name} | {fraction(statistics.mean(means))} | {fraction(max(largest))} |"
    positions, exact = half_cylinder()
    file = folder / "half-cylinder.npy"
    np.save(file, positions)
    result = measure(make, file, SOURCE, repeats=3, limit=100, cores=1)
    if isinstance(result, Failure):
        return f"{row} {result.reason} | |"
    seconds = f"{result.solve:.3f}" + (f" + {result.set_up:.2f}" if result.set_up > 0.02 else "")
    return f"{row} {fraction(errors(result.distances, exact).mean)} | {seconds} |"


if __name__ == "__main__":
    with tempfile.TemporaryDirectory() as name:
        CASES = {crop: prepared(crop, Path(name)) for crop in CROPS}
        print("| solver | terrain: mean | largest | half cylinder: mean | seconds |")
        print("|---|---:|---:|---:|---:|")
        for maker in SOLVERS:
            print(line(maker, Path(name)), flush=True)

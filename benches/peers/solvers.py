"""Peers, one small class each: a name, the set-up, and a solve for one source.

If a solver's `solve` does more than solve, it measures the solving alone and stores the time in
`seconds`. Otherwise the clock around `solve` counts.
"""

from __future__ import annotations

import ctypes
import importlib.util
import json
import subprocess
import tempfile
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from grids import Grid

Place = tuple[int, int]

# The longest distance that peers are asked to compute. It exceeds all distances on the surfaces.
FAR = 1e9


class Solver:
    """Base of all solvers. Without the modules that it `needs`, a solver is left out."""

    name = ""
    needs: tuple[str, ...] = ()
    seconds: float | None = None
    # Whether `solve` also repeats set-up, whose result could be kept but is not.
    sets_up_each_time = False

    def suits(self, surface: str) -> bool:
        """Returns whether the method is meant for a surface."""
        return True

    def prepare(self, grid: Grid) -> None:
        """Prepares everything that does not depend on the source."""
        self.grid = grid

    def solve(self, source: Place) -> np.ndarray:
        """Returns distances (M, N) from a grid point, infinite at points that are not reached."""
        raise NotImplementedError

    def vertex(self, source: Place) -> int:
        return int(self.grid.index[source])


class Geosweep(Solver):
    """geosweep's tool, from a file of positions to a file of distances."""

    sets_up_each_time = True

    def __init__(
        self, binary: Path, engine: str, wavefront: str, options: tuple[str, ...] = ()
    ) -> None:
        self.binary, self.options = binary, ("--engine", engine, "--wavefront", wavefront, *options)
        precision = ", double precision" if DOUBLE[1] in options else ""
        self.name = f"geosweep {engine}, {wavefront}{precision}"

    def prepare(self, grid: Grid) -> None:
        super().prepare(grid)
        self.folder = tempfile.TemporaryDirectory()
        self.positions, self.map = (
            Path(self.folder.name) / f"{name}.npy" for name in ("positions", "map")
        )
        np.save(self.positions, grid.positions)

    def solve(self, source: Place) -> np.ndarray:
        place = f"{source[0]},{source[1]}"
        command: list[str | Path] = [self.binary, "distance", self.positions, "--source", place]
        command += ["-o", self.map, "--json", *self.options]
        run = subprocess.run(command, check=True, capture_output=True, text=True)
        report = json.loads(run.stdout)
        self.seconds = report["solve_seconds"]
        if not report["converged"] and report["engine"] != "fast-marching":
            raise RuntimeError(f"not converged after {report['iterations']} iterations")
        return np.load(self.map).astype(np.float64)


class MeshLib(Solver):
    """Fast marching in single precision."""

    name, needs = "MeshLib fast marching", ("meshlib.mrmeshpy", "meshlib.mrmeshnumpy")

    def prepare(self, grid: Grid) -> None:
        from meshlib import mrmeshnumpy

        super().prepare(grid)
        self.mesh = mrmeshnumpy.meshFromFacesVerts(grid.faces, grid.vertices)

    def solve(self, source: Place) -> np.ndarray:
        from meshlib import mrmeshpy

        start = mrmeshpy.VertBitSet()
        start.resize(len(self.grid.vertices))
        start.set(mrmeshpy.VertId(self.vertex(source)), True)
        clock = time.perf_counter()
        distances = mrmeshpy.computeSurfaceDistances(self.mesh, start)
        self.seconds = time.perf_counter() - clock
        return self.grid.to_map(floats(distances.vec))


def floats(vector: Any) -> np.ndarray:
    """Reads a C++ vector of floats by its address, since the binding returns one at a time."""
    if vector.element_type_byte_size == ctypes.sizeof(ctypes.c_float):
        values = (ctypes.c_float * vector.size()).from_address(vector.data_pointer())
        return np.ctypeslib.as_array(values).copy()
    return np.fromiter(vector, dtype=np.float32)


class GeometryCentralMarching(Solver):
    """Kimmel and Sethian's fast marching."""

    name, needs = "geometry-central fast marching", ("potpourri3d",)

    def prepare(self, grid: Grid) -> None:
        import potpourri3d

        super().prepare(grid)
        self.solver = potpourri3d.MeshFastMarchingDistanceSolver(grid.vertices, grid.faces)

    def solve(self, source: Place) -> np.ndarray:
        return self.grid.to_map(self.solver.compute_distance([[(self.vertex(source), [])]]))


class GeometryCentralHeat(Solver):
    """The heat method with geometry-central's defaults; the set-up factors two matrices."""

    name, needs = "geometry-central heat method", ("potpourri3d",)

    def prepare(self, grid: Grid) -> None:
        import potpourri3d

        super().prepare(grid)
        self.solver = potpourri3d.MeshHeatMethodDistanceSolver(grid.vertices, grid.faces)

    def solve(self, source: Place) -> np.ndarray:
        return self.grid.to_map(self.solver.compute_distance(self.vertex(source)))


class MeshLab(Solver):
    """MeshLab's filter: exact on flat surfaces without walls, and not exact on curved ones."""

    name, needs = "MeshLab geodesic distance", ("pymeshlab",)

    def prepare(self, grid: Grid) -> None:
        import pymeshlab

        super().prepare(grid)
        self.meshes = pymeshlab.MeshSet()
        self.meshes.add_mesh(pymeshlab.Mesh(grid.vertices, grid.faces))

    def solve(self, source: Place) -> np.ndarray:
        import pymeshlab

        start = self.grid.vertices[self.vertex(source)]
        far = pymeshlab.PureValue(FAR)
        clock = time.perf_counter()
        self.meshes.compute_scalar_by_geodesic_distance_from_given_point_per_vertex(
            startpoint=start, maxdistance=far
        )
        self.seconds = time.perf_counter() - clock
        return self.grid.to_map(self.meshes.current_mesh().vertex_scalar_array())


class Exact(Solver):
    """Mitchell, Mount and Papadimitriou's exact distances on the mesh, in Kirsanov's program."""

    name, needs = "pygeodesic (exact on the mesh)", ("pygeodesic.geodesic",)

    def prepare(self, grid: Grid) -> None:
        from pygeodesic import geodesic

        super().prepare(grid)
        self.solver = geodesic.PyGeodesicAlgorithmExact(grid.vertices, grid.faces)

    def solve(self, source: Place) -> np.ndarray:
        return self.grid.to_map(
            self.solver.geodesicDistances(np.array([self.vertex(source)]), None)[0]
        )


class HamiltonFastMarching(Solver):
    """Mirebeau's fast marching for metrics, of a higher order, with factored distances.

    The solver needs the metric at each point. The metric comes from cubic splines through the
    positions, so that the solver sees the same numbers as the others. Within `radius` steps of the
    source, the solver writes the distance as the distance in the source's constant metric, times or
    plus a smooth rest.
    """

    needs = ("HFMpy.HFM_Riemann2", "agd.Eikonal", "scipy.interpolate")
    sets_up_each_time = True

    def __init__(self, order: int, radius: float | None) -> None:
        self.order, self.radius = order, radius
        within = "everywhere" if radius is None else f"to {radius:.0f} steps"
        self.name = f"HFM, order {order}, factored {within}"

    def prepare(self, grid: Grid) -> None:
        from agd import Eikonal, Metrics

        super().prepare(grid)
        self.input = Eikonal.dictIn(
            {
                "model": "Riemann2",
                "metric": Metrics.Riemann(first_fundamental_form(grid)),
                "dims": np.array(grid.shape),
                "gridScale": 1.0,
                "origin": np.array([-0.5, -0.5]),
                "order": self.order,
                "factoringRadius": self.radius or float(sum(grid.shape)),
                "exportValues": 1.0,
                "verbosity": 0,
            }
        )
        if not grid.present.all():
            self.input["walls"] = (~grid.present).astype(float)

    def solve(self, source: Place) -> np.ndarray:
        self.input["seed"] = np.array(source, dtype=float)
        with np.errstate(
            invalid="ignore"
        ):  # agd divides by zero at the source, where a vector has no length.
            output = self.input.Run()
        # Stencils depend only on the metric but are computed again in each run.
        self.seconds = float(output["FMCPUTime"])
        return np.asarray(output["values"])


def first_fundamental_form(grid: Grid) -> np.ndarray:
    """Returns the metric (2, 2, M, N) per step of a row and a column; holes get the mean metric."""
    from scipy.interpolate import CubicSpline

    points = filled(grid)
    along = [
        CubicSpline(np.arange(n), points, axis=axis)(np.arange(n), 1)
        for axis, n in enumerate(grid.shape)
    ]
    return np.array([[np.einsum("ijk,ijk->ij", a, b) for b in along] for a in along])


def filled(grid: Grid) -> np.ndarray:
    """Returns positions without holes, by an affine fit: only flat grids have holes here."""
    if grid.present.all():
        return grid.positions
    rows, cols = np.indices(grid.shape)
    terms = np.stack([np.ones(grid.shape), rows, cols], axis=2)
    fit, *_ = np.linalg.lstsq(terms[grid.present], grid.positions[grid.present], rcond=None)
    return np.where(grid.present[..., None], grid.positions, terms @ fit)


class ScikitFmm(Solver):
    """Second-order fast marching on a flat Cartesian grid, so for the plane and the maze only."""

    name, needs = "scikit-fmm (flat grids only)", ("skfmm",)

    def suits(self, surface: str) -> bool:
        return surface in ("plane", "maze")

    def prepare(self, grid: Grid) -> None:
        super().prepare(grid)
        there = grid.positions[grid.present]
        self.spacing = (there[:, :2].max(axis=0) - there[:, :2].min(axis=0))[::-1] / (
            np.array(grid.shape) - 1
        )

    def solve(self, source: Place) -> np.ndarray:
        import skfmm

        front = np.ones(self.grid.shape)
        front[source] = 0
        if not self.grid.present.all():
            front = np.ma.MaskedArray(front, ~self.grid.present)
        clock = time.perf_counter()
        distances = skfmm.distance(front, dx=self.spacing)
        self.seconds = time.perf_counter() - clock
        return np.ma.filled(distances, np.inf)


WAVEFRONTS = ("planar", "circular", "curved")
DOUBLE = ("--precision", "double")


def geosweep_solvers(binary: Path, engines: tuple[str, ...]) -> dict[str, Callable[[], Solver]]:
    """Returns geosweep's solvers by name: every wavefront with every engine.

    On the CPU there are circular and curved fronts in double precision too.
    """
    makers = [
        partial(Geosweep, binary, engine, front) for engine in engines for front in WAVEFRONTS
    ]
    if "cpu" in engines:
        makers += [partial(Geosweep, binary, "cpu", front, DOUBLE) for front in WAVEFRONTS[1:]]
    return {maker().name: maker for maker in makers}


def peers() -> dict[str, Callable[[], Solver]]:
    """Returns the peers by name."""
    makers: list[Callable[[], Solver]] = [
        MeshLib,
        GeometryCentralMarching,
        GeometryCentralHeat,
        MeshLab,
        partial(HamiltonFastMarching, 2, 10),
        partial(HamiltonFastMarching, 2, None),
        partial(HamiltonFastMarching, 3, None),
        ScikitFmm,
        Exact,
    ]
    return {maker().name: maker for maker in makers}


def lacks(solver: Solver) -> str | None:
    """Returns the first package that a solver needs and this Python lacks, if any."""
    # The package is looked up without loading it, since each peer is loaded in its own process.
    packages = (module.partition(".")[0] for module in solver.needs)
    return next(
        (package for package in packages if importlib.util.find_spec(package) is None), None
    )

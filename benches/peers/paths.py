#!/usr/bin/env python3
"""Compares shortest paths over real terrain with exact paths on the terrain's triangles.

    python benches/peers/paths.py --geosweep target/release/geosweep

The surfaces are crops of the elevation model in examples/data, 65 x 65 points, as in terrain.py,
each with two sources and starts at random points. Unlike there, the surface is the crop's triangles
themselves, and the reference is the exact paths on these triangles (pygeodesic). The paths of
`geosweep path --edges chord` are compared with it, and so are MeshLib's, which are straightened
over the same triangles.
"""

from __future__ import annotations

import argparse
import json
import subprocess
import tempfile
from collections.abc import Iterable
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import numpy as np

from grids import Grid
from report import fraction
from solvers import WAVEFRONTS, Exact, Place
from terrain import CROPS, SIZE, SOURCES, SPACING, crop_of_heights, lifted

# The number of starts for each crop and source, and their least distance from the source in cells.
STARTS = 25
FAR_ENOUGH = 5
# The distance between the places at which two paths are compared, in cells.
STEP = 0.1
# The distance from the exact path, in cells, beyond which a path counts as another route of about
# the same length.
ANOTHER_WAY = 2.0


@dataclass(frozen=True)
class Traced:
    """A path. `distance` is the value of the solver's map at the path's start (NaN without a map),
    and `length` is the path's length according to the solver, both in metres. `places` are rows and
    columns (K, 2)."""

    distance: float
    length: float
    places: np.ndarray


@dataclass(frozen=True)
class Case:
    """A crop, a source, starts, and the exact path from each of them."""

    grid: Grid
    source: Place
    starts: list[Place]
    exact: list[Traced]


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument(
        "--geosweep", type=Path, required=True, help="the tool, package geosweep-cli"
    )
    print(study(parser.parse_args().geosweep.resolve()))


def study(binary: Path) -> str:
    """Returns a Markdown table with a line for each solver."""
    random = np.random.default_rng(1)
    cases = [prepared(crop, source, random) for crop in CROPS for source in SOURCES]
    solvers = {
        f"geosweep cpu, {wavefront}": partial(geosweep_paths, binary, wavefront)
        for wavefront in WAVEFRONTS
    } | {"MeshLib": meshlib_paths}
    lines = [
        "| solver | distance: mean | largest | length: mean | signed mean | largest "
        "| laid down: mean | largest | apart, cells: median | largest | another way |",
        "|---|---:|---:|---:|---:|---:|---:|---:|---:|---:|---:|",
    ]
    for name, solve in solvers.items():
        lines.append(f"| {name} | {line([(case, solve(case)) for case in cases])} |")
    return "\n".join(lines)


def prepared(crop: Place, source: Place, random: np.random.Generator) -> Case:
    """Returns starts, and exact paths on the triangles of the crop."""
    points = lifted(crop_of_heights(crop), 1).astype(np.float32).astype(np.float64)
    grid = Grid(points)
    starts: list[Place] = []
    while len(starts) < STARTS:
        row, col = (int(place) for place in random.integers(0, SIZE, 2))
        if np.hypot(row - source[0], col - source[1]) >= FAR_ENOUGH:
            starts.append((row, col))
    solver = Exact()
    solver.prepare(grid)
    exact = []
    for start in starts:
        vertices = solver.vertex(source), solver.vertex(start)
        length, path = solver.solver.geodesicDistance(*vertices)
        exact.append(Traced(float(length), float(length), on_grid(np.asarray(path))))
    return Case(grid, source, starts, exact)


def on_grid(points: np.ndarray) -> np.ndarray:
    """Returns rows and columns of points (K, 3) in metres."""
    return points[:, [1, 0]] / (SPACING[1], SPACING[0])


def geosweep_paths(binary: Path, wavefront: str, case: Case) -> list[Traced]:
    """Runs geosweep, from a file of positions to a file of paths."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        np.save(folder / "positions.npy", case.grid.positions)
        starts = "".join(f"{row},{col}\n" for row, col in case.starts)
        (folder / "starts.csv").write_text(starts)
        command = [binary, "path", folder / "positions.npy", "--edges", "chord"]
        command += ["--engine", "cpu", "--wavefront", wavefront, "--json"]
        command += ["--source", "{},{}".format(*case.source)]
        command += ["--from-file", folder / "starts.csv", "-o", folder / "paths.npy"]
        run = subprocess.run(command, check=True, capture_output=True, text=True)
        rows = np.load(folder / "paths.npy")[:, :2]
    ends = np.flatnonzero(np.isnan(rows[:, 0]))
    paths = [path[~np.isnan(path[:, 0])] for path in np.split(rows, ends)]
    said = json.loads(run.stdout)["paths"]
    return [
        Traced(own["distance"], own["length"], path) for own, path in zip(said, paths, strict=True)
    ]


def meshlib_paths(case: Case) -> list[Traced]:
    """Computes paths by fast marching, and straightens them until they are locally shortest."""
    from meshlib import mrmeshnumpy, mrmeshpy

    mesh = mrmeshnumpy.meshFromFacesVerts(case.grid.faces, case.grid.vertices)

    def vertex(place: Place) -> mrmeshpy.MeshTriPoint:
        index = int(case.grid.index[place])
        return mrmeshpy.MeshTriPoint(mesh.topology, mrmeshpy.VertId(index))

    paths = []
    for start in case.starts:
        crossings = mrmeshpy.computeGeodesicPath(mesh, vertex(start), vertex(case.source))
        middle = [mesh.edgePoint(crossing) for crossing in crossings]
        ends = [case.grid.positions[place] for place in (start, case.source)]
        points = [ends[0], *([point.x, point.y, point.z] for point in middle), ends[1]]
        points = np.asarray(points, dtype=np.float64)
        paths.append(Traced(np.nan, along(points), on_grid(points)))
    return paths


def along(points: np.ndarray) -> float:
    return float(np.linalg.norm(np.diff(points, axis=0), axis=1).sum())


def on_triangles(grid: Grid, places: np.ndarray) -> float:
    """Returns the length of a path on the grid's triangles, straight within each of them."""
    rising = grid.rising
    cuts = [places[0]]
    for a, b in zip(places[:-1], places[1:], strict=True):
        cuts.extend(crossings(rising, a, b))
        cuts.append(b)
    return along(np.array([height(grid, rising, np.asarray(cut)) for cut in cuts]))


def crossings(rising: np.ndarray, a: np.ndarray, b: np.ndarray) -> Iterable[np.ndarray]:
    """Returns where the straight line between two places of a cell crosses the cell's diagonal."""
    cell = np.clip(np.floor((a + b) / 2), 0, SIZE - 2)

    def beside(place: np.ndarray) -> float:
        down, right = place - cell
        return down + right - 1 if rising[tuple(cell.astype(int))] else down - right

    from_a, from_b = beside(a), beside(b)
    if from_a * from_b < 0:
        yield a + (b - a) * from_a / (from_a - from_b)


def height(grid: Grid, rising: np.ndarray, place: np.ndarray) -> np.ndarray:
    """Returns the point on the triangles at a row and column."""
    row, col = (int(min(x, SIZE - 2)) for x in place)
    down, right = place - (row, col)
    north_west, north_east, south_west, south_east = (
        grid.positions[row + r, col + c] for r in (0, 1) for c in (0, 1)
    )
    if rising[row, col]:
        if down + right <= 1:
            return north_west + down * (south_west - north_west) + right * (north_east - north_west)
        to_west, to_north = (1 - right), (1 - down)
        west, north = south_west - south_east, north_east - south_east
        return south_east + to_west * west + to_north * north
    if down >= right:
        return north_west + down * (south_west - north_west) + right * (south_east - south_west)
    return north_west + right * (north_east - north_west) + down * (south_east - north_east)


def apart(a: np.ndarray, b: np.ndarray) -> float:
    """Returns the largest distance from a place of either path to the other, in cells."""
    return max(farthest(a, b), farthest(b, a))


def farthest(path: np.ndarray, other: np.ndarray) -> float:
    counts = np.maximum(np.ceil(np.abs(np.diff(path, axis=0)).max(axis=1) / STEP), 1).astype(int)
    pieces = [
        a + (b - a) * np.arange(count)[:, None] / count
        for a, b, count in zip(path[:-1], path[1:], counts, strict=True)
    ]
    places = np.concatenate([*pieces, path[-1:]])
    starts, steps = other[:-1], np.diff(other, axis=0)
    squares = np.maximum((steps**2).sum(axis=1), 1e-30)
    shares = ((places[:, None] - starts) * steps).sum(axis=2) / squares
    feet = starts + np.clip(shares, 0, 1)[..., None] * steps
    return float(np.linalg.norm(places[:, None] - feet, axis=2).min(axis=1).max())


def line(found: list[tuple[Case, list[Traced]]]) -> str:
    pairs = [
        (case.grid, path, exact)
        for case, paths in found
        for path, exact in zip(paths, case.exact, strict=True)
    ]
    distance = np.array([path.distance / exact.length - 1 for _, path, exact in pairs])
    length = np.array([path.length / exact.length - 1 for _, path, exact in pairs])
    excess = np.array(
        [on_triangles(grid, path.places) / exact.length - 1 for grid, path, exact in pairs]
    )
    # No path on the triangles is shorter than the exact path.
    assert excess.min() > -1e-6, excess.min()
    cells = np.array([apart(path.places, exact.places) for _, path, exact in pairs])
    same = cells <= ANOTHER_WAY
    sign = "-" if length.mean() < 0 else "+"
    known = not np.isnan(distance).any()
    return " | ".join(
        [
            fraction(np.abs(distance).mean()) if known else "",
            fraction(np.abs(distance).max()) if known else "",
            fraction(np.abs(length).mean()),
            sign + fraction(abs(length.mean())),
            fraction(np.abs(length).max()),
            fraction(excess.mean()),
            fraction(excess.max()),
            f"{np.median(cells[same]):.2f}",
            f"{cells[same].max():.2f}",
            f"{np.count_nonzero(~same)} of {len(cells)}",
        ]
    )


if __name__ == "__main__":
    main()

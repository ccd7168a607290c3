#!/usr/bin/env python3
"""Compares geodesic distances over rough terrain with exact ones on a finer mesh.

    python benches/peers/terrain.py --geosweep target/release/geosweep

Crops of the elevation model in examples/data, 65 x 65 points, are refined fourfold by a bicubic
spline. Exact distances on the triangles of the refined grid (pygeodesic) are the reference, at
the points of the crop. All solvers get only the crop, so the comparison shows how well they
interpolate between the points.
"""

from __future__ import annotations

import argparse
import statistics
import tempfile
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from grids import Errors, Grid, errors
from measure import Failure, measure
from report import fraction
from solvers import Exact, Place, Solver, geosweep_solvers, lacks, peers

ELEVATION = Path(__file__).resolve().parents[2] / "examples" / "data" / "jacksboro.png"
# The metres between columns and between rows, from the README next to the elevation model.
SPACING = (74.573, 92.475)
SIZE = 65
FINER = 4
# The row and column of each crop's first point. The last crop contains the highest point of all.
CROPS = ((20, 40), (60, 300), (170, 150), (265, 185))
# One source off the centre, and one near a corner, where paths are longest.
SOURCES = ((20, 27), (60, 4))


@dataclass(frozen=True)
class Case:
    """A crop, a source, and exact distances on the finer mesh at the crop's points."""

    positions: Path
    source: Place
    exact: np.ndarray


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
    makers = geosweep_solvers(binary, ("cpu",)) | peers()
    lines = [
        "| solver | mean | largest of the means | signed mean | largest |",
        "|---|---:|---:|---:|---:|",
    ]
    with tempfile.TemporaryDirectory() as folder:
        cases = [case for crop in CROPS for case in prepared(crop, Path(folder))]
        for name, make in makers.items():
            if make().suits("terrain") and not lacks(make()):
                lines.append(f"| {name} | {line(make, cases)} |")
    return "\n".join(lines)


def prepared(crop: Place, folder: Path) -> list[Case]:
    """Returns the crop as a file, and exact distances from each of the sources."""
    heights = crop_of_heights(crop)
    positions = folder / f"{crop[0]}-{crop[1]}.npy"
    np.save(positions, lifted(heights, 1))
    finer = Exact()
    finer.prepare(Grid(lifted(refined(heights), FINER)))
    maps = [finer.solve((FINER * row, FINER * col))[::FINER, ::FINER] for row, col in SOURCES]
    return [Case(positions, source, exact) for source, exact in zip(SOURCES, maps, strict=True)]


def crop_of_heights(crop: Place) -> np.ndarray:
    from PIL import Image

    row, col = crop
    heights = np.array(Image.open(ELEVATION), dtype=np.float64)
    return heights[row : row + SIZE, col : col + SIZE]


def refined(heights: np.ndarray) -> np.ndarray:
    from scipy.interpolate import RectBivariateSpline

    points = np.arange(SIZE)
    finer = np.arange((SIZE - 1) * FINER + 1) / FINER
    return RectBivariateSpline(points, points, heights)(finer, finer)


def lifted(heights: np.ndarray, finer: int) -> np.ndarray:
    """Returns positions (M, N, 3) in metres."""
    rows, cols = np.indices(heights.shape) / finer
    return np.stack([cols * SPACING[0], rows * SPACING[1], heights], axis=2)


def line(make: Callable[[], Solver], cases: list[Case]) -> str:
    found: list[Errors] = []
    for case in cases:
        result = measure(make, case.positions, case.source, repeats=1, limit=120.0, cores=1)
        if isinstance(result, Failure):
            return f"{result.reason} | | | "
        found.append(errors(result.distances, case.exact))
    means = [each.mean for each in found]
    signed = statistics.mean(each.signed for each in found)
    largest = max(each.largest for each in found)
    sign = "-" if signed < 0 else "+"
    mean, worst = fraction(statistics.mean(means)), fraction(max(means))
    return f"{mean} | {worst} | {sign}{fraction(abs(signed))} | {fraction(largest)}"


if __name__ == "__main__":
    main()

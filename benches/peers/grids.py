"""Grids for all solvers: the same positions, and one triangulation of them."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np

# The relative difference below which two diagonals count as equally long. It keeps rounding from
# choosing diagonals at random on a plane.
TIE = 1e-4


@dataclass(frozen=True)
class Grid:
    """Positions (M, N, 3) in double precision, NaN at holes."""

    positions: np.ndarray

    @staticmethod
    def load(path: Path) -> Grid:
        """Reads positions. Solvers in single precision round them themselves."""
        return Grid(np.load(path).astype(np.float64))

    @property
    def shape(self) -> tuple[int, int]:
        return self.positions.shape[:2]

    @cached_property
    def present(self) -> np.ndarray:
        return np.isfinite(self.positions).all(axis=2)

    @cached_property
    def index(self) -> np.ndarray:
        """Vertex of each grid point, -1 at holes: meshes must have no vertex without a triangle."""
        index = np.full(self.shape, -1, dtype=np.int64)
        index[self.present] = np.arange(self.present.sum())
        return index

    @cached_property
    def vertices(self) -> np.ndarray:
        return np.ascontiguousarray(self.positions[self.present])

    @cached_property
    def faces(self) -> np.ndarray:
        """Two triangles per cell along its shorter diagonal, north-west to south-east in a tie.

        The shorter diagonal suits solvers on meshes: the longer one makes obtuse triangles. A
        cell with one hole has the triangle of its other corners.
        """
        nw, ne = self.index[:-1, :-1].ravel(), self.index[:-1, 1:].ravel()
        sw, se = self.index[1:, :-1].ravel(), self.index[1:, 1:].ravel()
        rising = self.rising.ravel()
        falling = np.concatenate([np.stack([nw, sw, se], 1), np.stack([nw, se, ne], 1)])
        other = np.concatenate([np.stack([nw, sw, ne], 1), np.stack([ne, sw, se], 1)])
        faces = np.where(np.tile(rising, 2)[:, None], other, falling)
        return np.ascontiguousarray(faces[(faces >= 0).all(axis=1)].astype(np.int32))

    @cached_property
    def rising(self) -> np.ndarray:
        """Whether each cell (M - 1, N - 1) is cut from south-west to north-east."""
        points, present = self.positions, self.present
        falling = np.linalg.norm(points[:-1, :-1] - points[1:, 1:], axis=2)
        rising = np.linalg.norm(points[1:, :-1] - points[:-1, 1:], axis=2)
        whole_falling = present[:-1, :-1] & present[1:, 1:]
        whole_rising = present[1:, :-1] & present[:-1, 1:]
        shorter = rising < falling * (1 - TIE)
        return np.where(whole_falling & whole_rising, shorter, whole_rising)

    def to_map(self, values: np.ndarray) -> np.ndarray:
        """Returns values of vertices as a map (M, N), infinite at holes."""
        distances = np.full(self.shape, np.inf)
        distances[self.present] = np.asarray(values, dtype=np.float64).reshape(-1)
        return distances


@dataclass(frozen=True)
class Errors:
    """Errors relative to the exact distances, over all points except the source."""

    mean: float
    largest: float
    signed: float
    missing: int


def errors(distances: np.ndarray, exact: np.ndarray) -> Errors:
    """Compares points with a positive, finite exact distance, and counts unreached ones."""
    where = np.isfinite(exact) & (exact > 0)
    reached = where & np.isfinite(distances)
    difference = distances[reached] / exact[reached] - 1
    return Errors(
        mean=float(np.abs(difference).mean()),
        largest=float(np.abs(difference).max()),
        signed=float(difference.mean()),
        missing=int(where.sum() - reached.sum()),
    )

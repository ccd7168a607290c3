"""Exact distances, computed from the definitions of the surfaces, independently of the crate."""

from __future__ import annotations

from pathlib import Path

import numpy as np

Place = tuple[int, int]

# Sizes of the surfaces that `geosweep builtin` writes; see the documentation of
# `surface::builtin::Builtin`.
TURN = 1.5 * np.pi
CYLINDER_HEIGHT = 3.0
CONE_SLOPE = 0.5
CONE_INNER = 0.5


def exact(
    surface: str, present: np.ndarray, source: Place, folder: Path | None
) -> np.ndarray | None:
    """Returns exact distances (M, N) from a grid point, or None if they are not known.

    For surfaces without a closed form, `folder` may have exact distances as SURFACE-ROWSxCOLS.npy.
    """
    name, _, angle = surface.partition("@")
    rows, cols = present.shape
    stored = folder / f"{surface}-{rows}x{cols}.npy" if folder else None
    if stored and stored.exists():
        return np.load(stored)
    if name == "maze":
        return flat_paths(present, source)
    if name == "sheared-plane":
        return sheared_plane(rows, cols, source, float(angle or 60))
    closed = {"plane": plane, "sphere": sphere, "cylinder": cylinder, "cone": cone}.get(name)
    return closed(rows, cols, source) if closed else None


def unit_square(rows: int, cols: int) -> tuple[np.ndarray, np.ndarray]:
    """Returns u along columns and v along rows, both from 0 to 1."""
    return np.meshgrid(np.linspace(0, 1, cols), np.linspace(0, 1, rows))


def plane(rows: int, cols: int, source: Place) -> np.ndarray:
    return sheared_plane(rows, cols, source, 0.0)


def sheared_plane(rows: int, cols: int, source: Place, degrees: float) -> np.ndarray:
    u, v = unit_square(rows, cols)
    x = u + v * np.tan(np.radians(degrees))
    return np.hypot(x - x[source], v - v[source])


def cylinder(rows: int, cols: int, source: Place) -> np.ndarray:
    u, v = unit_square(rows, cols)
    return np.hypot(TURN * (u - u[source]), CYLINDER_HEIGHT * (v - v[source]))


def sphere(rows: int, cols: int, source: Place) -> np.ndarray:
    u, v = unit_square(rows, cols)
    cube = np.stack(
        [np.tan(np.pi / 2 * (u - 0.5)), np.tan(np.pi / 2 * (v - 0.5)), np.ones_like(u)], 2
    )
    points = cube / np.linalg.norm(cube, axis=2, keepdims=True)
    here = points[source]
    return np.arctan2(np.linalg.norm(np.cross(points, here), axis=2), points @ here)


def cone(rows: int, cols: int, source: Place) -> np.ndarray:
    """Returns distances on the unrolled sector.

    A path is a line, or two tangents of the inner circle and an arc of it.
    """
    u, v = unit_square(rows, cols)
    slant, angle = CONE_INNER + v, CONE_SLOPE * TURN * np.abs(u - u[source])
    here = slant[source]
    arc = angle - np.arccos(CONE_INNER / slant) - np.arccos(CONE_INNER / here)
    straight = np.hypot(slant - here, 2 * np.sqrt(slant * here) * np.sin(angle / 2))
    tangents = np.sqrt(slant**2 - CONE_INNER**2) + np.sqrt(here**2 - CONE_INNER**2)
    return np.where(arc > 0, tangents + CONE_INNER * arc, straight)


def flat_paths(present: np.ndarray, source: Place) -> np.ndarray:
    """Returns the lengths of shortest paths over the flat unit square around its missing points.

    They are exact up to rounding. The floor is the union of the triangles between present points,
    so a rectangle of missing points blocks an octagon: the places less than one step (along rows
    plus along columns) from the rectangle. A shortest path bends only at corners of octagons. So
    Dijkstra's algorithm runs over these corners, and each point is then reached from the source or
    a corner.
    """
    octagons = [Octagon(*rectangle) for rectangle in sorted(set(rectangles(~present)))]
    spacing = 1.0 / (np.array(present.shape) - 1)
    corners = {c for o in octagons for c in o.corners() if inside(c, present)} - {source}
    anchors = dijkstra(source, sorted(corners), octagons, spacing)
    places = np.argwhere(present).astype(float)
    best = np.full(len(places), np.inf)
    for anchor, start in sorted(anchors.items(), key=lambda item: item[1]):
        through = start + np.linalg.norm((places - anchor) * spacing, axis=1)
        shorter = np.flatnonzero(through < best)
        seen = shorter[sees(np.array(anchor, float), places[shorter], octagons)]
        best[seen] = through[seen]
    distances = np.full(present.shape, np.inf)
    distances[present] = best
    return distances


def inside(corner: Place, present: np.ndarray) -> bool:
    row, col = corner
    return 0 <= row < present.shape[0] and 0 <= col < present.shape[1] and bool(present[corner])


def dijkstra(
    source: Place, corners: list[Place], octagons: list, spacing: np.ndarray
) -> dict[Place, float]:
    """Returns distances from the source to the corners, along unblocked straight lines."""
    places = np.array(corners, dtype=float).reshape(-1, 2)
    best, done = np.full(len(corners), np.inf), np.zeros(len(corners), bool)
    anchors, here, start = {source: 0.0}, np.array(source, float), 0.0
    while not done.all():
        through = start + np.linalg.norm((places - here) * spacing, axis=1)
        shorter = (through < best) & ~done
        shorter[shorter] = sees(here, places[shorter], octagons)
        best[shorter] = through[shorter]
        nearest = int(np.argmin(np.where(done, np.inf, best)))
        if done[nearest] or not np.isfinite(best[nearest]):
            break
        done[nearest], here, start = True, places[nearest], best[nearest]
        anchors[corners[nearest]] = start
    return anchors


def rectangles(missing: np.ndarray) -> list[tuple[int, int, int, int]]:
    """Returns rectangles (first and last row, first and last column) that cover all missing points.

    Each is as long as possible along a row or a column, so that rectangles that meet in a corner
    overlap and leave no bevel between them.
    """
    left, found = missing.copy(), []
    for row, col in np.argwhere(missing):
        if left[row, col]:
            found += [grow(missing, row, col, rows_first) for rows_first in (True, False)]
            for r0, r1, c0, c1 in found[-2:]:
                left[r0 : r1 + 1, c0 : c1 + 1] = False
    return found


def grow(missing: np.ndarray, row: int, col: int, rows_first: bool) -> tuple[int, int, int, int]:
    """Returns a rectangle of missing points around a missing point.

    It is grown along one axis first, then along the other.
    """
    if not rows_first:
        c0, c1, r0, r1 = grow(missing.T, col, row, True)
        return r0, r1, c0, c1
    r0 = r1 = row
    while r0 > 0 and missing[r0 - 1, col]:
        r0 -= 1
    while r1 + 1 < len(missing) and missing[r1 + 1, col]:
        r1 += 1
    whole = missing[r0 : r1 + 1].all(axis=0)
    c0 = c1 = col
    while c0 > 0 and whole[c0 - 1]:
        c0 -= 1
    while c1 + 1 < len(whole) and whole[c1 + 1]:
        c1 += 1
    return int(r0), int(r1), int(c0), int(c1)


class Octagon:
    """Region that a rectangle of missing points blocks: an open convex set of eight half-planes."""

    def __init__(self, r0: int, r1: int, c0: int, c1: int) -> None:
        self.bounds = (r0, r1, c0, c1)
        sides = [(-1, 0, 1 - r0), (1, 0, r1 + 1), (0, -1, 1 - c0), (0, 1, c1 + 1)]
        bevels = [
            (-1, -1, 1 - r0 - c0),
            (-1, 1, 1 - r0 + c1),
            (1, -1, r1 + 1 - c0),
            (1, 1, r1 + c1 + 1),
        ]
        self.half_planes = sides + bevels

    def corners(self) -> list[Place]:
        r0, r1, c0, c1 = self.bounds
        across = [(r, c) for r in (r0 - 1, r1 + 1) for c in (c0, c1)]
        along = [(r, c) for r in (r0, r1) for c in (c0 - 1, c1 + 1)]
        return across + along

    def blocks(self, start: np.ndarray, ends: np.ndarray) -> np.ndarray:
        """Returns for each end whether the straight line to it passes through the inside."""
        enter, leave = np.zeros(len(ends)), np.ones(len(ends))
        outside = np.zeros(len(ends), bool)
        for a, b, limit in self.half_planes:
            room = limit - 1e-9 - (a * start[0] + b * start[1])
            rate = a * (ends[:, 0] - start[0]) + b * (ends[:, 1] - start[1])
            outside |= (rate == 0) & (room <= 0)
            with np.errstate(divide="ignore", invalid="ignore"):
                at = room / rate
            leave = np.where(rate > 0, np.minimum(leave, at), leave)
            enter = np.where(rate < 0, np.maximum(enter, at), enter)
        return ~outside & (enter < leave)


def sees(start: np.ndarray, ends: np.ndarray, octagons: list[Octagon]) -> np.ndarray:
    """Returns for each end whether the straight line from a place to it is unblocked."""
    seen = np.ones(len(ends), bool)
    for octagon in octagons:
        seen[seen] = ~octagon.blocks(start, ends[seen])
    return seen

"""Prints the stress that scikit-learn's SMACOF reaches, for the test tests/maps/canonical.rs.

    pip install scikit-learn==1.9.1
    python smacof.py

The distances are those of great circles between the points of a grid on the unit sphere, and the
start is a formula too, so that the test can compute both. The output is the raw stress at the
start, after one, two and ten Guttman transforms, and when the stress no longer changes.
"""

from __future__ import annotations

import warnings

import numpy as np
from numpy.typing import NDArray
from sklearn.manifold import smacof

ROWS, COLS = 12, 15


def directions() -> NDArray[np.float64]:
    """Returns unit vectors of a patch of the sphere: latitudes to 60 degrees, longitudes to 100."""
    latitude = np.radians(np.linspace(-60.0, 60.0, ROWS))[:, None]
    longitude = np.radians(np.linspace(-100.0, 100.0, COLS))[None, :]
    parts = (
        np.cos(latitude) * np.cos(longitude),
        np.cos(latitude) * np.sin(longitude),
        np.sin(latitude) + 0.0 * longitude,
    )
    return np.stack(parts, axis=-1).reshape(-1, 3)


def start(dimensions: int) -> NDArray[np.float64]:
    """Returns a start in which coordinate k of point i is sin(i (k + 1) + k)."""
    points = np.arange(ROWS * COLS)[:, None]
    axes = np.arange(dimensions)[None, :]
    return np.sin(points * (axes + 1.0) + axes)


def main() -> None:
    warnings.simplefilter("ignore")
    unit = directions()
    distances = np.arccos(np.clip(unit @ unit.T, -1.0, 1.0))
    np.fill_diagonal(distances, 0.0)
    for dimensions in (2, 3):
        initial = start(dimensions)
        across = np.linalg.norm(initial[:, None] - initial[None, :], axis=-1)
        stresses = [((across - distances) ** 2).sum() / 2.0]
        for iterations in (1, 2, 10, 100_000):
            _, stress, count = smacof(
                distances,
                n_components=dimensions,
                init=initial,
                n_init=1,
                max_iter=iterations,
                eps=1e-14,
                return_n_iter=True,
                normalized_stress=False,
            )
            stresses.append(stress)
        print(dimensions, "dimensions:", ", ".join(f"{s:.6f}" for s in stresses), "after", count)


if __name__ == "__main__":
    main()

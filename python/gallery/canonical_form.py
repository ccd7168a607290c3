"""All pairs of distances on a rolled sheet, and its canonical form, which unrolls it.

    python canonical_form.py [FOLDER]

Needs geosweep[plot].
"""

import sys
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import geosweep as gs


def main() -> None:
    """Draw canonical_form.png."""
    folder = Path(sys.argv[1] if len(sys.argv) > 1 else ".")
    folder.mkdir(parents=True, exist_ok=True)
    rows, cols = 24, 64
    width, angle = np.mgrid[0 : 1 : rows * 1j, 0 : 3.5 * np.pi : cols * 1j]
    radius = 0.3 + 0.06 * angle
    sheet = np.stack([radius * np.cos(angle), width, radius * np.sin(angle)], axis=-1)

    matrix = gs.pairwise(gs.Surface.from_positions(sheet))
    form = gs.canonical_form(matrix, dimensions=2)
    print(f"{matrix.shape[0]} points, stress {form.stress:.1e}, converged: {form.converged}")

    figure = plt.figure(figsize=(10, 4.2), layout="constrained")
    space = figure.add_subplot(1, 2, 1, projection="3d")
    colours = dict(c=angle.ravel(), cmap="viridis", s=8)
    space.scatter(*sheet.reshape(-1, 3).T, **colours)
    space.set_title("a sheet in space")
    space.set_box_aspect(np.ptp(sheet.reshape(-1, 3), axis=0))
    flat = figure.add_subplot(1, 2, 2)
    flat.scatter(*form.coordinates.T, **colours)
    flat.set_title("its canonical form in the plane")
    flat.set_aspect("equal")
    figure.savefig(folder / "canonical_form.png", dpi=80)


if __name__ == "__main__":
    main()

"""Ways through a building: exact distances around walls.

    python floor_plan.py [FOLDER]

Needs geosweep[plot].
"""

import sys
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import geosweep as gs


def building() -> np.ndarray:
    """Return a mask of the points where one can walk; they are 10 cm apart."""
    walk = np.ones((121, 201), bool)
    walk[[0, -1]] = False
    walk[:, [0, -1]] = False
    walk[50:52] = walk[70:72] = False  # a corridor between two rows of rooms
    for col in (50, 100, 150):
        walk[:52, col : col + 2] = False
        walk[70:, col : col + 2] = False
    for col in (20, 70, 120, 170):  # doors
        walk[50:52, col : col + 10] = True
        walk[70:72, col + 5 : col + 15] = True
    return walk


def main() -> None:
    """Draw floor_plan.png."""
    folder = Path(sys.argv[1] if len(sys.argv) > 1 else ".")
    folder.mkdir(parents=True, exist_ok=True)
    walk = building()
    plan = gs.Surface.from_heights(np.zeros(walk.shape), spacing=0.1, mask=walk)
    assert plan.is_floor_plan  # so that "auto" takes anchored fronts, which are exact here
    exit_, desks = (60, 2), [(10, 190), (110, 110), (15, 60), (100, 20)]
    m = plan.solve(exit_)
    for path in m.paths(desks):
        print(f"from {path.vertices[0].tolist()}: {path.length:.2f} m")
    row, col, far = m.farthest()
    print(f"farthest from the exit: row {row}, column {col}, {far:.2f} m")
    figure, ax = plt.subplots(figsize=(9, 5), layout="constrained")
    ax.set_facecolor("0.25")
    m.plot(ax, contours=np.arange(2, far, 2), paths=desks)
    ax.set_title("metres from the exit")
    figure.savefig(folder / "floor_plan.png", dpi=80)


if __name__ == "__main__":
    main()

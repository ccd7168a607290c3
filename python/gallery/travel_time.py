"""Travel times: hills, a road, and a lake that is slow to swim.

    python travel_time.py [FOLDER]

Needs geosweep[plot].
"""

import sys
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import geosweep as gs


def main() -> None:
    """Draw travel_time.png."""
    folder = Path(sys.argv[1] if len(sys.argv) > 1 else ".")
    folder.mkdir(parents=True, exist_ok=True)
    y, x = np.mgrid[0:3000:10.0, 0:4000:10.0]  # metres
    heights = 250 * np.exp(-((x - 1300) ** 2 + (y - 900) ** 2) / 4e5)
    heights += 180 * np.exp(-((x - 2900) ** 2 + (y - 2100) ** 2) / 3e5)

    speed = np.full(x.shape, 1.2)  # metres per second, on foot
    speed[np.abs(y - 1500 - 500 * np.sin(x / 700)) < 40] = 8.0  # a road
    lake = (x - 2700) ** 2 + 3 * (y - 700) ** 2 < 500**2
    speed[lake] = 0.4
    surface = gs.Surface.from_heights(heights, spacing=(10, 10), slowness=1 / speed)

    start, ends = (250, 20), [(40, 270), (60, 380), (280, 380), (20, 120)]
    m = surface.solve(start)
    for end, path in zip(ends, m.paths(ends), strict=True):
        print(f"to row {end[0]}, column {end[1]}: {path.length / 60:.1f} minutes")
    figure, ax = plt.subplots(figsize=(9, 6), layout="constrained")
    m.plot(ax, contours=12, paths=ends)
    ax.contour(lake, [0.5], colors="deepskyblue")
    ax.set_title("seconds of travel")
    figure.savefig(folder / "travel_time.png", dpi=80)


if __name__ == "__main__":
    main()

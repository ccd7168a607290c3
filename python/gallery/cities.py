"""Voronoi regions of cities on the globe, from a metric.

    python cities.py [FOLDER]

Needs geosweep[plot].
"""

import sys
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import geosweep as gs

RADIUS = 6371.0  # km
CITIES = {  # latitude and longitude in degrees
    "Madrid": (40.42, -3.70),
    "Paris": (48.86, 2.35),
    "London": (51.51, -0.13),
    "Rome": (41.90, 12.50),
    "Berlin": (52.52, 13.40),
    "Vienna": (48.21, 16.37),
    "Warsaw": (52.23, 21.01),
    "Stockholm": (59.33, 18.07),
    "Oslo": (59.91, 10.75),
    "Athens": (37.98, 23.73),
    "Kyiv": (50.45, 30.52),
    "Dublin": (53.35, -6.26),
}


def main() -> None:
    """Draw cities.png."""
    folder = Path(sys.argv[1] if len(sys.argv) > 1 else ".")
    folder.mkdir(parents=True, exist_ok=True)
    step = 0.1
    latitudes = np.arange(66, 34.95, -step)
    longitudes = np.arange(-12, 36.05, step)

    # Lengths of a step of one row and of one column.
    down = RADIUS * np.radians(step)
    right = down * np.cos(np.radians(latitudes))
    metric = np.zeros((len(latitudes), len(longitudes), 3))
    metric[..., 0] = down**2
    metric[..., 2] = (right**2)[:, None]

    places = np.array(list(CITIES.values()))
    source = np.column_stack([(66 - places[:, 0]) / step, (places[:, 1] + 12) / step])
    m = gs.Surface.from_metric(metric).solve(source)
    voronoi = m.voronoi()
    for city, area in sorted(zip(CITIES, voronoi.areas, strict=True), key=lambda it: -it[1]):
        print(f"{city:10} {area:12,.0f} km2")

    figure, ax = plt.subplots(figsize=(9, 6.5), layout="constrained")
    extent = (longitudes[0], longitudes[-1], latitudes[-1], latitudes[0])
    ax.imshow(voronoi.labels, cmap="tab20", alpha=0.6, extent=extent, aspect=1.6)
    shade = ax.contour(longitudes, latitudes, m.distance, 12, colors="0.3", linewidths=0.5)
    ax.clabel(shade, fmt="%d km", fontsize=7)
    for _, border in voronoi.borders:
        ax.plot(-12 + step * border[:, 1], 66 - step * border[:, 0], color="black", linewidth=1.5)
    for city, (latitude, longitude) in CITIES.items():
        ax.plot(longitude, latitude, "o", color="crimson", markersize=4)
        ax.annotate(city, (longitude, latitude), (3, 3), textcoords="offset points", fontsize=8)
    ax.set(xlim=extent[:2], ylim=extent[2:], xlabel="longitude", ylabel="latitude")
    ax.set_title("the nearest capital, and the distance to it")
    figure.savefig(folder / "cities.png", dpi=80)


if __name__ == "__main__":
    main()

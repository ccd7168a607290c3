"""Distances over terrain from a GeoTIFF, with paths and contours in its coordinates.

    python terrain.py [FOLDER [DEM.tif]]

Needs geosweep[all]. Without a GeoTIFF of your own, the script takes the elevation around the
Jacksboro fault (examples/data), and first writes it as a GeoTIFF whose coordinates are degrees.
"""

import sys
from pathlib import Path

import geopandas
import matplotlib.pyplot as plt
import numpy as np
import rasterio
import rioxarray
from PIL import Image
from rasterio.transform import from_origin

import geosweep.xarray  # noqa: F401, gives arrays da.geosweep

DATA = Path(__file__).parents[2] / "examples/data/jacksboro.png"


def jacksboro(folder: Path) -> Path:
    """Write the elevation model as a GeoTIFF."""
    heights = np.asarray(Image.open(DATA)).astype(np.float32)
    path = folder / "jacksboro.tif"
    options = {"driver": "GTiff", "count": 1, "dtype": "float32", "crs": "EPSG:4326"}
    rows, cols = heights.shape
    place = from_origin(-84.41375, 36.73292, 1 / 1200, 1 / 1200)
    with rasterio.open(path, "w", height=rows, width=cols, transform=place, **options) as file:
        file.write(heights, 1)
    return path


def main() -> None:
    """Draw terrain.png and write contours.geojson."""
    folder = Path(sys.argv[1] if len(sys.argv) > 1 else ".")
    folder.mkdir(parents=True, exist_ok=True)
    path = Path(sys.argv[2]) if len(sys.argv) > 2 else jacksboro(folder)

    heights = rioxarray.open_rasterio(path, masked=True).squeeze("band")
    if heights.rio.crs.is_geographic:  # degrees have no length
        heights = heights.rio.reproject(heights.rio.estimate_utm_crs(), resampling=1)

    top = heights[heights.argmax(...)]
    m = heights.geosweep.solve((top.x, top.y))
    west, south, east, north = heights.rio.bounds()
    ends = geopandas.GeoSeries(
        geopandas.points_from_xy(
            west + (east - west) * np.array([0.1, 0.9, 0.85, 0.15]),
            south + (north - south) * np.array([0.1, 0.15, 0.9, 0.85]),
            crs=heights.rio.crs,
        )
    )
    ways = m.paths(ends)
    print(ways)
    m.contours(step=5000).to_crs("EPSG:4326").to_file(folder / "contours.geojson")

    figure, (left, right) = plt.subplots(1, 2, figsize=(11, 4.2), layout="constrained")
    heights.plot.imshow(ax=left, cmap="terrain", cbar_kwargs={"label": "height (m)"})
    left.ticklabel_format(style="plain", useOffset=False)
    left.locator_params(axis="x", nbins=4)
    left.set(title="heights", xlabel="x", ylabel="y")
    left.set_aspect("equal")
    m.plot(right, paths=ends, contours=12)
    right.set_title("distance from the highest point (m)")
    figure.savefig(folder / "terrain.png", dpi=80)


if __name__ == "__main__":
    main()

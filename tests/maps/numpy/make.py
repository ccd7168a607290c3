"""Writes the archives of this folder by NumPy."""

import os

import numpy as np

here = os.path.dirname(os.path.abspath(__file__))
heights = np.arange(35, dtype="f4").reshape(5, 7)
mask = heights % 3 > 0
slowness = 1 + heights.astype("f8")
metric = np.tile(np.diag([4.0, 1.0]), (5, 7, 1, 1))
points = np.array([[1, 2], [3, 4]])

np.savez(os.path.join(here, "one.npz"), heights)
np.savez_compressed(os.path.join(here, "one-compressed.npz"), np.asfortranarray(heights))
np.savez_compressed(
    os.path.join(here, "several.npz"),
    heights=heights, mask=mask, slowness=slowness, metric=metric, points=points, distances=heights,
)  # fmt: skip
np.savez(os.path.join(here, "unnamed.npz"), heights, mask)

"""Tests of grids that do not repeat the samples of a seam."""

import pickle

import numpy as np
import pytest

import geosweep as gs


def sphere(lat: np.ndarray, lon: np.ndarray) -> np.ndarray:
    """Return a grid of points on the unit sphere. Latitudes and longitudes are in degrees."""
    lat, lon = np.radians(np.meshgrid(lat, lon, indexing="ij"))
    return np.stack([np.cos(lat) * np.cos(lon), np.cos(lat) * np.sin(lon), np.sin(lat)], axis=-1)


def angles(points: np.ndarray, to: np.ndarray) -> np.ndarray:
    return np.arctan2(np.linalg.norm(np.cross(points, to), axis=-1), points @ to)


@pytest.mark.parametrize("half", [0.0, 0.5])
@pytest.mark.parametrize("down", [True, False])
def test_a_globe_at_the_middles_of_cells_is_whole(half: float, down: bool) -> None:
    step = 2.0
    lat = np.arange(-90 + 0.5 * step, 90, step)
    xyz = sphere(lat[::-1] if down else lat, step * (np.arange(180) + half))
    given = gs.Surface.from_positions(xyz)
    grid = gs.CompletedGrid(given, "globe")
    assert grid.given_shape == (90, 180) and grid.shape == (92, 181)
    globe = grid.complete(given)
    assert globe.is_glued and globe.shape == grid.shape
    for place in ((20.0, 179.5), (-0.5, 3.0), (89.5, 0.0), (44.0, 0.0)):
        source = grid.to_completed([place])
        assert np.allclose(grid.to_given(source), place) or place[0] in (-0.5, 89.5)
        m = globe.solve(source)
        south = -1.0 if down else 1.0
        at = np.array([south * (-90 + step * (place[0] + 0.5)), step * (place[1] + half)])
        exact = angles(xyz, sphere(at[:1], at[1:])[0, 0])
        found = grid.crop(m.distance)
        assert found.shape == exact.shape
        assert np.abs(found - exact).mean() < 1e-4


def plane(rows: int, cols: int) -> gs.Surface:
    """Return a plane, whose heights do not tell whether the last column repeats the first."""
    return gs.Surface.from_heights(np.zeros((rows, cols)))


@pytest.mark.parametrize("bump", [0.0, 1e-9])
@pytest.mark.parametrize("layout", ["columns", "rows", "both"])
def test_equal_lines_may_be_one_or_two(bump: float, layout: str) -> None:
    z = np.zeros((20, 30))
    z[-1, 0] = bump
    given = gs.Surface.from_heights(z)
    with pytest.raises(ValueError, match="may be one line that the grid repeats or two"):
        gs.CompletedGrid(given, layout)  # type: ignore[arg-type]
    with pytest.raises(ValueError, match="last='twice' is unknown"):
        gs.CompletedGrid(given, "columns", last="twice")  # type: ignore[arg-type]
    for last, missing in (("apart", 0), ("repeated", 1)):
        grid = gs.CompletedGrid(given, layout, last=last)  # type: ignore[arg-type]
        d = grid.crop(grid.complete(given).solve((0, 0)).distance)
        rows, cols = np.mgrid[:20, :30]
        if layout in ("rows", "both"):
            rows = np.minimum(rows, 20 - missing - rows)
        if layout in ("columns", "both"):
            cols = np.minimum(cols, 30 - missing - cols)
        assert np.allclose(d, np.hypot(rows, cols), atol=1e-4)


def test_lines_that_differ_are_two() -> None:
    z, mask = np.zeros((20, 30)), np.ones((20, 30), bool)
    mask[5:9, 0] = False
    slowness = 1 + 0.04 * np.arange(30) / 30 + 0 * z
    for surface in (
        gs.Surface.from_heights(z + np.arange(30)),
        gs.Surface.from_heights(z, mask=mask),
        gs.Surface.from_heights(z, slowness=slowness),
    ):
        assert gs.CompletedGrid(surface, "columns").shape == (20, 31)
    with pytest.raises(ValueError, match=r"slowness of 1 and of 1\.038"):
        surface = gs.Surface.from_heights(z, slowness=slowness)
        gs.CompletedGrid(surface, "columns", last="repeated").complete(surface)


def test_heights_and_colours_go_round() -> None:
    given = plane(20, 36)
    grid = gs.CompletedGrid(given, "columns", last="apart")
    tube = grid.complete(given)
    d = grid.crop(tube.solve((10, 35)).distance)
    rows, cols = np.mgrid[:20, :36]
    across = np.minimum((35 - cols) % 36, (cols - 35) % 36)
    assert np.allclose(d, np.hypot(rows - 10, across), rtol=1e-5)
    colours = np.arange(20 * 37 * 3).reshape(20, 37, 3)
    assert np.array_equal(grid.crop(colours), colours[:, :36])
    places = np.zeros((4, 5, 2))
    assert grid.to_completed(places).shape == places.shape


def test_a_completed_surface_survives_pickling() -> None:
    given = plane(9, 12)
    tube = gs.CompletedGrid(given, "columns", last="apart").complete(given)
    again = pickle.loads(pickle.dumps(tube))
    assert again.is_glued
    assert np.array_equal(again.solve((4, 0)).distance, tube.solve((4, 0)).distance)


def test_mistakes_are_named() -> None:
    given = plane(9, 12)
    with pytest.raises(ValueError, match="layout='tube' is unknown"):
        gs.CompletedGrid(given, "tube")  # type: ignore[arg-type]
    grid = gs.CompletedGrid(given, "columns", last="apart")
    with pytest.raises(ValueError, match=r"place \(9.*\) is off the surface: rows go from"):
        grid.to_completed((9.0, 1.0))
    with pytest.raises(ValueError, match="places must be rows and columns"):
        grid.to_given([1.0, 2.0, 3.0])
    with pytest.raises(ValueError, match=r"values must have the shape \(9, 13\)"):
        grid.crop(np.zeros((9, 12)))
    with pytest.raises(ValueError, match="x"):
        grid.complete(gs.Surface.from_heights(np.zeros((9, 11))))
    with pytest.raises(ValueError, match="pole"):
        gs.CompletedGrid(given, "globe", last="apart")


def test_crops_keep_masks() -> None:
    given = gs.Surface.from_heights(np.zeros((6, 8)))
    grid = gs.CompletedGrid(given, "columns", last="apart")
    hidden = np.zeros(grid.shape, bool)
    hidden[2, 3] = True
    values = np.ma.masked_array(np.arange(54.0).reshape(6, 9), hidden)
    found = grid.crop(values)
    assert np.array_equal(np.ma.getmaskarray(found), hidden[:, :8])
    assert np.array_equal(np.ma.getdata(found), np.ma.getdata(values)[:, :8])

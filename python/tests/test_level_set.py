"""Fronts that start from level sets, against closed forms."""

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import geosweep as gs

Function = Callable[[NDArray[Any], NDArray[Any]], NDArray[Any]]


def circle(x: NDArray[Any], y: NDArray[Any]) -> NDArray[Any]:
    return np.hypot(x - 0.47, y - 0.52) - 0.23


def plane(x: NDArray[Any], y: NDArray[Any]) -> NDArray[Any]:
    return (np.cos(0.4) * (x - 0.41) + np.sin(0.4) * (y - 0.37)).astype(np.float64)


def two_circles(x: NDArray[Any], y: NDArray[Any]) -> NDArray[Any]:
    left = np.hypot(x - 0.27, y - 0.31) - 0.12
    return np.minimum(left, np.hypot(x - 0.72, y - 0.66) - 0.17)


def grid(n: int) -> tuple[NDArray[Any], NDArray[Any]]:
    y, x = np.mgrid[:n, :n] / (n - 1)
    return x, y


def errors(function: Function, n: int, scale: Function | None = None, **options: Any) -> Any:
    """Return the mean and the largest error of distances from the zero of a signed distance.

    The level set may be the distance times a positive function.
    """
    x, y = grid(n)
    exact = function(x, y)
    phi = exact if scale is None else exact * scale(x, y)
    found = gs.travel_time(
        phi=phi, speed=np.ones((n, n)), spacing=1 / (n - 1), dtype="float64", **options
    )
    apart = np.abs(found - np.abs(exact))
    return apart.mean(), apart.max()


@pytest.mark.parametrize("function", [circle, two_circles])
@pytest.mark.parametrize("scaled", [False, True])
def test_distances_from_smooth_zeros_are_of_second_order(function: Function, scaled: bool) -> None:
    scale = (lambda x, y: 1 + 0.5 * np.sin(3 * x + 2 * y)) if scaled else None
    found = np.array([errors(function, n, scale) for n in (33, 65, 129)])
    mean = found[:, 0]
    assert mean[1] < mean[0] / 3.3 and mean[2] < mean[1] / 3.3, found
    assert mean[0] < 6e-4, found


def test_distances_from_a_straight_zero_are_exact() -> None:
    # Beyond the border the line goes on, and fronts fan out from its ends there.
    x, y = grid(65)
    exact = plane(x, y)
    found = gs.travel_time(phi=3 * exact, speed=np.ones((65, 65)), spacing=1 / 64, dtype="float64")
    along = -np.sin(0.4) * (x - 0.41) + np.cos(0.4) * (y - 0.37)
    foot = [0.41 - along * np.sin(0.4), 0.37 + along * np.cos(0.4)]
    inside = (np.minimum(*foot) > 0) & (np.maximum(*foot) < 1)
    assert inside.mean() > 0.7
    assert np.abs(found - np.abs(exact))[inside].max() < 1e-9


def test_times_over_a_speed_are_those_of_both_sides() -> None:
    x, y = grid(65)
    apart = np.abs(circle(x, y))
    speed = np.where(apart < 0.1, 1.0, 2.0)
    time = gs.travel_time(phi=circle(x, y), speed=speed, spacing=1 / 64)
    expected = np.minimum(apart, 0.1) + np.maximum(apart - 0.1, 0) / 2
    # The speed jumps somewhere between two points.
    assert np.abs(time / expected - 1)[apart > 0.03].max() < 0.08
    same = gs.travel_time(phi=circle(x, y), slowness=1 / speed, spacing=1 / 64)
    assert (time == same).all()


def test_masked_values_are_holes() -> None:
    x, y = grid(41)
    wall = (np.abs(x - 0.6) < 0.02) & (y < 0.8)
    phi = np.ma.array(x - 0.2, mask=wall)
    time = gs.travel_time(phi=phi, speed=np.ones((41, 41)), spacing=1 / 40)
    assert np.isinf(time[wall]).all() and np.isfinite(time[~wall]).all()
    assert time[0, 40] > 1.1  # around the wall
    nan = gs.travel_time(phi=phi.filled(np.nan), speed=np.ones((41, 41)), spacing=1 / 40)
    assert (time == nan).all()
    masked = gs.travel_time(
        phi=x - 0.2, speed=np.ma.array(np.ones((41, 41)), mask=wall), spacing=1 / 40
    )
    assert (time == masked).all()


def test_a_surface_keeps_what_maps_from_level_sets_share() -> None:
    x, y = grid(33)
    speed = 1 + x
    surface = gs.Surface.from_heights(np.zeros((33, 33)), 1 / 32, speed=speed)
    for _ in range(2):
        found = surface.solve(gs.LevelSet(circle(x, y)))
        one = gs.travel_time(phi=circle(x, y), speed=speed, spacing=1 / 32)
        assert (found.distance == one).all()
    near = surface.solve(gs.LevelSet(circle(x, y)), radius=0.1).distance
    assert np.isinf(near).any()
    # Holes of the surface cut the zero off.
    holed = gs.Surface.from_heights(np.zeros((33, 33)), 1 / 32, holes=x > 0.5)
    assert np.isfinite(holed.solve(gs.LevelSet(circle(x, y))).distance[x <= 0.5]).all()


def test_points_at_zero_are_sources() -> None:
    row, col = np.mgrid[:21, :31]
    cone = np.hypot(row - 7, col - 12)
    found = gs.travel_time(phi=cone, speed=np.ones((21, 31)))
    assert np.abs(found - cone).max() < 1e-5
    same = gs.travel_time((7, 12), speed=np.ones((21, 31)))
    assert (found == same).all()


def test_level_sets_that_start_nothing_are_refused() -> None:
    ones = np.ones((5, 6))
    with pytest.raises(ValueError, match="positive everywhere"):
        gs.travel_time(phi=ones, speed=ones)
    with pytest.raises(ValueError, match="phi must have the grid's shape"):
        gs.Surface.from_heights(ones).solve(gs.LevelSet(ones[:4]))
    with pytest.raises(ValueError, match=r"speed= or slowness="):
        gs.travel_time(phi=ones)
    with pytest.raises(ValueError, match="and not both"):
        gs.travel_time((1, 1), phi=ones, speed=ones)
    with pytest.raises(ValueError, match="a source or phi="):
        gs.travel_time(speed=ones)

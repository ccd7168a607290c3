"""Directions, log maps, signed distances and closed surfaces."""

import pickle
import warnings

import numpy as np
import pytest

import geosweep as gs


def flat(rows: int = 21, cols: int = 31) -> gs.Surface:
    return gs.Surface.from_heights(np.zeros((rows, cols)))


def tube(rows: int = 33, around: int = 64) -> np.ndarray:
    angle = np.linspace(0, 2 * np.pi, around + 1)
    ring = np.stack([np.cos(angle), np.sin(angle), np.zeros_like(angle)], axis=-1)
    return ring + np.arange(rows)[:, None, None] * [0.0, 0.0, 0.1]


def test_bearings_vectors_and_links_lead_to_the_source() -> None:
    m = flat().solve((10, 10))
    compass, grass, grid = m.back_direction(), m.back_direction("grass"), m.back_direction("grid")
    rows, cols = np.mgrid[:21, :31]
    down, right = 10 - rows, 10 - cols
    exact = np.degrees(np.arctan2(right, -down)) % 360
    others = (down != 0) | (right != 0)
    turn = np.abs(compass - exact)
    assert np.minimum(turn, 360 - turn)[others].max() < 0.01 and compass[10, 10] == 0
    sum_of_both = (compass + grass)[others] % 360
    assert np.allclose(sum_of_both, 90, atol=0.01)
    length = np.hypot(down, right)[others]
    assert np.allclose(
        grid[others], np.stack([down, right], -1)[others] / length[:, None], atol=1e-4
    )
    assert np.allclose(m.back_direction("space")[others][:, 2], 0, atol=1e-6)
    links = m.back_link()
    assert links.dtype == np.int8 and links[10, 10] == 0
    assert (links[10, 0], links[0, 0], links[0, 10], links[20, 20]) == (1, 2, 3, 6)


def test_unreached_points_have_no_direction() -> None:
    mask = np.ones((9, 9), bool)
    mask[:, 4] = False
    m = gs.Surface.from_heights(np.zeros((9, 9)), mask=mask).solve((4, 1))
    assert (m.back_direction()[:, 4:] == -1).all() and (m.back_link()[:, 4:] == -1).all()
    assert np.isnan(m.back_direction("grid")[:, 4:]).all()
    assert (m.nearest[:, 4:] == -1).all() and np.isinf(m.distance[:, 4:]).all()


def test_nearest_places_lie_on_the_sources() -> None:
    m = flat().solve(gs.Lines([[(2, 0), (2, 30)]]))
    places = m.nearest_places()
    assert np.allclose(places[..., 0], 2) and np.allclose(
        places[10, :, 1], np.arange(31), atol=1e-3
    )


def test_log_map_and_its_inverse() -> None:
    log_map = gs.Surface.from_heights(np.zeros((21, 31)), (1.0, 2.0)).solve((10, 12)).log_map()
    rows, cols = np.mgrid[:21, :31]
    exact = np.stack([2.0 * (cols - 12), rows - 10.0], axis=-1)
    assert np.allclose(log_map.coordinates, exact, atol=1e-5)
    assert log_map.place(8.0, 5.0) == pytest.approx((15, 16), abs=1e-4)
    assert log_map.place(800.0, 5.0) is None
    assert log_map.source_direction()[10, 20] == pytest.approx(90)
    assert log_map.bases[0].at == (10.0, 12.0)
    with pytest.raises(ValueError, match="source=3"):
        log_map.place(1.0, 1.0, source=3)


def test_signed_distances() -> None:
    square = [(5, 5), (15, 5), (15, 15), (5, 15), (5, 5)]
    m = flat(21, 21).solve(gs.Lines([square]))
    signed = m.signed()
    assert signed[10, 8] == pytest.approx(-3, abs=1e-5) and signed[10, 2] == pytest.approx(
        3, abs=1e-5
    )
    inside = np.zeros((21, 21), bool)
    inside[6:15, 6:15] = True
    assert np.array_equal(m.signed(inside), signed)
    with pytest.raises(ValueError, match="point"):
        flat().solve((3, 4)).signed()
    with pytest.raises(ValueError, match="inside"):
        m.signed(inside[1:])


def test_a_glued_tube_is_closed() -> None:
    xyz = tube()
    with pytest.warns(gs.SeamWarning, match="first column and its last column"):
        cut = gs.Surface.from_positions(xyz)
    named = cut.with_gluing("columns")
    line = lambda col: ((0, col), (32, col))  # noqa: E731
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        found = gs.Surface.from_positions(xyz, glue="auto")
        # Lines are glued as charts that meet at any angle, which is less accurate.
        lines = gs.Surface.from_positions(xyz, glue=[(line(0), line(64))])
    d = named.solve((16, 2)).distance
    assert d[16, 62] == pytest.approx(4 * 2 * np.pi / 64, abs=1e-4)
    assert cut.solve((16, 2)).distance[16, 62] > 5
    assert named.is_glued and not cut.is_glued and cut.seams and not named.seams
    assert np.array_equal(found.solve((16, 2)).distance, d)
    assert np.allclose(lines.solve((16, 2)).distance, d, atol=1e-4)
    for glue, said in [("sideways", "unknown"), ("rows", "glue"), ([((0, 0), (3, 1))] * 2, "line")]:
        with pytest.raises((ValueError, TypeError), match=said):
            cut.with_gluing(glue if isinstance(glue, str) else [tuple(glue)])  # type: ignore
    with pytest.raises(ValueError, match="no sides"):
        gs.Surface.from_positions(xyz[:, :20], glue="auto")


def test_surfaces_can_be_pickled() -> None:
    z = np.random.default_rng(1).normal(size=(12, 17)).cumsum(axis=0)
    mask = np.ones(z.shape, bool)
    mask[3:6, 4] = False
    metric = np.broadcast_to([1.0, 0.2, 2.0], (12, 17, 3))
    surfaces = [
        gs.Surface.from_heights(z, (2.0, 1.0), mask=mask, slowness=1 + z**2),
        gs.Surface.from_heights(z, edges="chord"),
        gs.Surface.from_positions(tube(), glue="columns"),
        gs.Surface.from_metric(metric, mask=mask),
    ]
    for surface in surfaces:
        again = pickle.loads(pickle.dumps(surface))
        assert repr(again) == repr(surface)
        assert np.array_equal(again.solve((1, 2)).distance, surface.solve((1, 2)).distance)

"""Parts of maps, and sparse pairs."""

import numpy as np
import pytest

import geosweep as gs

Z = np.random.default_rng(5).normal(size=(60, 70)).cumsum(axis=0).cumsum(axis=1) / 30
SURFACE = gs.Surface.from_heights(Z)


def test_a_radius_leaves_out_what_is_farther() -> None:
    whole = SURFACE.solve((20, 30)).distance
    m = SURFACE.solve((20, 30), radius=15.0)
    assert np.array_equal(m.distance, np.where(whole <= 15, whole, np.inf))
    assert m.report["reached"] == (whole <= 15).sum()
    assert np.array_equal(gs.distance(Z, (20, 30), radius=15.0), m.distance)


def test_targets_end_a_map() -> None:
    whole = SURFACE.solve((20, 30)).distance
    targets = [(25, 30), (20, 50), (50, 60)]
    times = sorted(whole[target] for target in targets)
    for needed, last in [(None, times[2]), (1, times[0]), (2, times[1])]:
        found = SURFACE.solve((20, 30), targets=targets, needed=needed).distance
        assert np.array_equal(found, np.where(whole <= last, whole, np.inf))


def test_limits_are_checked() -> None:
    for options, said in [
        ({"radius": 0.0}, "radius"),
        ({"targets": [(1.5, 2.0)]}, "targets"),
        ({"targets": [(1, 200)]}, "target"),
        ({"needed": 2}, "needed"),
    ]:
        with pytest.raises(ValueError, match=said):
            SURFACE.solve((20, 30), **options)  # type: ignore[arg-type]


def test_pairs() -> None:
    pytest.importorskip("scipy")
    rng = np.random.default_rng(2)
    points = np.column_stack([rng.permutation(60)[:25], rng.permutation(70)[:25]])
    matrix = gs.pairwise(SURFACE, points @ [70, 1])[:, points @ [70, 1]]
    np.fill_diagonal(matrix, np.inf)
    near = gs.pairs(SURFACE, points, radius=20.0)
    assert near.shape == (25, 25)
    dense = near.toarray()
    assert np.array_equal(dense > 0, matrix <= 20)
    assert np.allclose(dense[dense > 0], matrix[matrix <= 20], rtol=2e-5)
    nearest = gs.pairs(SURFACE, points, k=3)
    assert (np.diff(nearest.indptr) == 3).all()
    order = np.sort(matrix, axis=1)[:, :3]
    assert np.allclose(np.sort(nearest.data.reshape(25, 3), axis=1), order, rtol=1e-3)
    both = gs.pairs(SURFACE, points, radius=10.0, k=3).toarray()
    assert both.max() <= 10 and np.allclose(both[both > 0], dense[both > 0], rtol=1e-3)
    small = gs.Surface.from_heights(Z[:6, :7])
    assert gs.pairs(small, radius=1.5).shape == (42, 42)
    for options, said in [({}, "radius or k"), ({"k": 0}, "k=0"), ({"radius": -1.0}, "radius")]:
        with pytest.raises(ValueError, match=said):
            gs.pairs(SURFACE, points, **options)
    with pytest.raises(ValueError, match="points must lie"):
        gs.pairs(SURFACE, [(3, 70)], k=1)

"""Values that are missing: masked arrays, NaN and attributes."""

from typing import Any

import numpy as np
import pytest

import geosweep as gs

Z = np.hypot(*np.mgrid[-10:11, -15:16]) / 4
BAD = np.zeros(Z.shape, bool)
BAD[4:9, 12:20] = True
M = np.ma.masked_array
WANT = gs.distance(Z, (15, 10), mask=~BAD)


@pytest.mark.parametrize("fill", [-9999.0, np.nan, 3.0, -3.4e38])
@pytest.mark.parametrize("dtype", ["float64", "float32"])
def test_masked_heights_are_holes(fill: float, dtype: str) -> None:
    values = np.where(BAD, fill, Z).astype(dtype)
    expected = gs.distance(Z.astype(dtype), (15, 10), mask=~BAD)
    for heights in (M(values, BAD), list(M(values, BAD))):
        for copy in (True, False):
            surface = gs.Surface.from_heights(heights, copy=copy)
            assert np.array_equal(surface.present, ~BAD)
            assert np.array_equal(surface.solve((15, 10)).distance, expected)


def test_masked_integers_positions_and_metrics_are_holes() -> None:
    heights = M(np.where(BAD, -9999, 7), BAD)
    assert np.array_equal(gs.Surface.from_heights(heights).present, ~BAD)
    xyz = np.dstack([*np.mgrid[:21, :31][::-1], np.where(BAD, 1e6, Z)]).astype(float)
    for k in range(3):
        mask = np.zeros(xyz.shape, bool)
        mask[..., k] = BAD
        assert np.array_equal(gs.Surface.from_positions(M(xyz, mask)).present, ~BAD)
    metric = np.zeros((*Z.shape, 2, 2))
    metric[..., 0, 0] = metric[..., 1, 1] = 1
    mask = np.repeat(np.repeat(BAD[..., None, None], 2, 2), 2, 3)
    assert np.array_equal(gs.Surface.from_metric(M(metric, mask)).present, ~BAD)


@pytest.mark.parametrize("data", [0.001, 1.0, np.nan])
def test_masked_slowness_and_speed_are_walls(data: float) -> None:
    values = np.where(BAD, data, 1.0)
    for walls in ({"slowness": M(values, BAD)}, {"speed": M(values, BAD)}):
        assert np.allclose(gs.distance(Z, (15, 10), **walls), WANT)  # type: ignore[arg-type]
    speed = np.where(BAD, 0.0, 2.0)
    assert np.allclose(gs.distance(Z, (15, 10), speed=speed), WANT / 2)
    with pytest.raises(ValueError, match="slowness or speed"):
        gs.distance(Z, (15, 10), speed=speed, slowness=speed)
    with pytest.raises(ValueError, match=r"speed -1\.0 at row 2, column 3 is negative"):
        gs.distance(Z, (15, 10), speed=np.where(np.arange(651).reshape(21, 31) == 65, -1.0, 1.0))


def test_masks_and_holes_are_of_opposite_senses() -> None:
    for mask in (~BAD, M(np.ones(Z.shape), BAD), np.where(BAD, np.nan, 1.0), (~BAD).astype(int)):
        assert np.array_equal(gs.distance(Z, (15, 10), mask=mask), WANT)
    for holes in (BAD, M(np.zeros(Z.shape), BAD), np.where(BAD, np.nan, 0.0), BAD.astype("u1")):
        assert np.array_equal(gs.distance(Z, (15, 10), holes=holes), WANT)
    half = BAD & (np.arange(31) < 16)
    both = gs.Surface.from_heights(Z, mask=~half, holes=BAD & ~half)
    assert np.array_equal(both.present, ~BAD)
    with pytest.raises(ValueError, match="holes must have the grid's shape"):
        gs.distance(Z, (15, 10), holes=BAD[:5])


def test_masked_cells_and_rows_are_no_sources() -> None:
    cells = np.zeros(Z.shape, int)
    cells[15, 10], cells[2, 2] = 1, 99
    found = gs.distance(Z, M(cells, cells == 99))
    assert np.array_equal(found, gs.distance(Z, (15, 10)))
    table = M([[15.0, 10.0], [2.0, 2.0], [18.0, 28.0]], [[0, 0], [0, 1], [0, 0]])
    m = gs.Surface.from_heights(Z).solve(table)
    assert (m.distance == 0).sum() == 2
    # Numbers are rows of the caller's table.
    assert [m.nearest[15, 10], m.nearest[18, 28]] == [0, 2]
    assert [path.source for path in m.paths([(15, 10), (18, 28)])] == [0, 2]
    assert m.voronoi().areas[1] == 0
    with pytest.raises(ValueError, match="all rows are masked"):
        gs.distance(Z, M([[1.0, 2.0]], True))


@pytest.mark.parametrize(
    ("name", "call"),
    [
        ("targets", lambda a: gs.distance(Z, (1, 2), targets=a.astype(int))),
        ("ends", lambda a: gs.Surface.from_heights(Z).solve((1, 2)).paths(a)),
        ("source", lambda a: gs.distance(Z, gs.Lines([a]))),
        ("rows", lambda a: gs.pairwise(gs.Surface.from_heights(Z), a[:, 0].astype(int))),
        ("matrix", lambda a: gs.canonical_form(a)),
        ("levels", lambda a: gs.Surface.from_heights(Z).solve((1, 2)).contours(a[:, 0])),
    ],
)
def test_masked_values_elsewhere_are_refused_by_name(name: str, call: Any) -> None:
    array = M([[1.0, 2.0], [3.0, 4.0]], [[1, 0], [0, 0]])
    with pytest.raises(ValueError, match=f"{name} .*masked"):
        call(array)


def test_out_is_a_plain_array() -> None:
    with pytest.raises(TypeError, match="out must be a plain NumPy array"):
        gs.distance(Z, (1, 2), out=M(np.zeros(Z.shape, np.float32), BAD))


@pytest.mark.parametrize(
    "attrs",
    [
        {"_FillValue": -9999.0},
        {"_FillValue": np.float64(-9999.0)},
        {"missing_value": -9999},
        {"nodata": -9999.0},
        {"nodatavals": (-9999.0,)},
        {"fill_value": "-9999"},
        {"_FillValue": [-1e30, -9999]},
        {"valid_min": 0},
        {"valid_range": (0.0, 100.0)},
    ],
)
@pytest.mark.parametrize("dtype", ["float32", "float64", "int16"])
def test_attributes_name_missing_values(attrs: dict[str, Any], dtype: str) -> None:
    xr = pytest.importorskip("xarray")
    import geosweep.xarray  # noqa: F401

    heights = np.where(BAD, -9999, 10 * Z).astype(dtype)
    da = xr.DataArray(
        heights, {"y": -np.arange(21.0), "x": np.arange(31.0)}, ("y", "x"), attrs=attrs
    )
    assert np.array_equal(da.geosweep.surface().present, ~BAD)
    assert np.array_equal(gs.Surface.from_heights(da).present, ~BAD)
    plain = da.copy(data=np.ones_like(heights))
    plain.attrs = {}
    assert np.array_equal(plain.geosweep.surface(slowness=da).present, ~BAD)
    d = plain.geosweep.distance(da)
    assert int((d == 0).sum()) == int((~BAD & (heights != 0)).sum())


def test_rounded_and_packed_values() -> None:
    xr = pytest.importorskip("xarray")
    coords = {"y": -np.arange(21.0), "x": np.arange(31.0)}
    for data, fill in ((-3.4028234663852886e38, -3.4e38), (-0.1, -0.1)):
        heights = np.where(BAD, data, Z).astype("float32")
        da = xr.DataArray(heights, coords, ("y", "x"), attrs={"_FillValue": fill})
        assert np.array_equal(gs.Surface.from_heights(da).present, ~BAD)
    attrs = {"_FillValue": -32768, "scale_factor": 0.1, "add_offset": 5.0}
    packed = xr.DataArray(
        np.where(BAD, -32768, 40).astype("int16"), coords, ("y", "x"), attrs=attrs
    )
    surface = gs.Surface.from_heights(packed)
    assert np.array_equal(surface.present, ~BAD)
    assert np.allclose(surface._surface.values().reshape(BAD.shape)[~BAD], 9.0)
    with pytest.raises(ValueError, match="attribute nodata='none' is not a number"):
        gs.distance(xr.DataArray(Z, coords, ("y", "x"), attrs={"nodata": "none"}), (1, 2))


def test_nan_in_rasters_of_sources_is_none() -> None:
    xr = pytest.importorskip("xarray")
    import geosweep.xarray  # noqa: F401

    da = xr.DataArray(Z, {"y": np.arange(21.0), "x": np.arange(31.0)}, ("y", "x"))
    sources = xr.full_like(da, np.nan)
    sources[3, 4] = 1.0
    assert int((da.geosweep.distance(sources) == 0).sum()) == 1
    assert int((da.geosweep.distance(sources.values) == 0).sum()) == 1

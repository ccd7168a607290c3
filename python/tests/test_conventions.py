"""What Python's users take for granted: numbers, tables, pickles, coordinates and units."""

import pickle
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

import geosweep as gs

Z = np.hypot(*np.mgrid[-20:21, -20:21]) / 3
FLAT = np.zeros((41, 41))


def test_whole_numbers_of_numpy_are_numbers_of_levels() -> None:
    m = gs.Surface.from_heights(FLAT).solve((20, 20))
    for count in (5, np.int64(5), np.uint8(5), np.array(5)):
        assert len(m.contours(count)) == 5
    for level in (5.0, np.float32(5), [5], np.array([5])):
        assert [c.level for c in m.contours(level)] == [5.0]


def test_radius_is_inclusive() -> None:
    for step in (1.0, 0.1, 0.3, 1e-3, 7.7):
        surface = gs.Surface.from_heights(np.zeros((9, 9)), step)
        for k in (1, 3, 7):
            d = surface.solve((0, 0), radius=k * step).distance
            assert np.isfinite(d[0, k]) and np.isinf(d[0, k + 1]), (step, k)
            double = surface.solve((0, 0), radius=k * step, dtype="float64").distance
            assert np.isfinite(double[0, k])
            if pytest.importorskip("scipy"):
                found = gs.pairs(surface, [(0, 0), (0, k), (0, k + 1)], radius=k * step)
                assert found.toarray()[0, 1] > 0 and found.toarray()[0, 2] == 0


@pytest.mark.parametrize(
    "options",
    [
        {"device": "no such device"},
        {"device": 99},
        {"engine": "gpu", "device": "no such device"},
        {"engine": "cpu", "device": 0},
        {"targets": [(3, 4)], "needed": 5},
        {"targets": [(3, 4)], "needed": 0},
        {"needed": 1},
    ],
)
def test_options_that_cannot_be_met_are_refused(options: dict[str, Any]) -> None:
    surface = gs.Surface.from_heights(FLAT)
    with pytest.raises((ValueError, RuntimeError)):
        surface.solve((3, 3), **options)
    with pytest.raises((ValueError, RuntimeError)):
        gs.distance(FLAT, (3, 3), **options)


def test_maps_are_pickled_and_shown() -> None:
    surface = gs.Surface.from_heights(Z, mask=Z > 1)
    for dtype in ("float32", "float64"):
        m = surface.solve(gs.Lines([[(0, 0), (0, 30)]]), dtype=dtype, radius=15)
        again = pickle.loads(pickle.dumps(m))
        assert np.array_equal(again.distance, m.distance) and again.distance.dtype == dtype
        assert again.report == m.report
        assert np.array_equal(again.nearest, m.nearest)
        [a], [b] = m.paths([(9, 9)]), again.paths([(9, 9)])
        assert np.array_equal(a.vertices, b.vertices)
        assert "41 x 41" in repr(again) and repr(again) == repr(m)
    labelled = surface.solve([(0, 0), (40, 40)], labels=["a", "b"])
    assert pickle.loads(pickle.dumps(labelled)).nearest[40, 40] == "b"
    log_map = surface.solve((0, 0)).log_map()
    assert repr(log_map) == "<geosweep.LogMap: 41 x 41 from 1 sources>"
    again = pickle.loads(pickle.dumps(log_map))
    assert np.array_equal(again.coordinates, log_map.coordinates, equal_nan=True)
    assert again.place(3, 4) == log_map.place(3, 4) and again.bases[0].u == log_map.bases[0].u
    assert np.array_equal(again.source_direction(), log_map.source_direction())


def test_progress_has_a_total() -> None:
    mask = np.ones((401, 401), bool)
    mask[20:380:20, :-9] = mask[10:380:20, 9:] = False
    surface = gs.Surface.from_heights(np.zeros(mask.shape), mask=mask)
    heights = np.zeros(mask.shape)
    solves: list[Callable[[Any], object]] = [
        lambda tell: surface.solve((0, 0), engine="cpu", wavefront="curved", progress=tell),
        lambda tell: gs.distance(heights, (0, 0), mask=mask, iterations=999, progress=tell),
        lambda tell: gs.pairwise(surface, [0, 7, 99], engine="cpu", progress=tell),
    ]
    for solve in solves:
        told: list[tuple[int, int]] = []
        solve(lambda *of, told=told: told.append(of))
        done = [done for done, _ in told]
        assert done == sorted(done) and len({total for _, total in told}) == 1
        assert told[-1][0] == told[-1][1] > 0 and done[0] >= 0


def test_many_maps_of_one_surface_are_those_of_fresh_ones() -> None:
    surface = gs.Surface.from_heights(Z, 0.5)
    cases: list[tuple[Any, dict[str, Any]]] = [
        ((3, 4), {}),
        ((30, 9), {"radius": 4.0}),
        ((30, 9), {}),
        ((2.5, 3.5), {"targets": [(9, 9)]}),
        ((2.5, 3.5), {"dtype": "float64"}),
        (gs.Lines([[(0, 0), (9, 9)]]), {"threads": 1}),
        ((30, 9), {"wavefront": "planar"}),
        ((30, 9), {"iterations": 1000}),
        ((3, 4), {}),
    ]
    for source, options in cases * 2:
        fresh = gs.Surface.from_heights(Z, 0.5).solve(source, **options).distance
        assert np.array_equal(surface.solve(source, **options).distance, fresh)


LABELS = [
    np.array([7, 3, 9]),
    np.array(["a", "b", "c"]),
    np.array([0.5, 1.5, 2.5]),
    [True, False, True],
]


@pytest.mark.parametrize("labels", LABELS)
def test_labels_come_back(labels: Any) -> None:
    z = FLAT.copy()
    z[:, 35] = np.nan
    m = gs.Surface.from_heights(z).solve([(5, 5), (5, 30), (35, 5)], labels=labels)
    for k, place in enumerate([(5, 5), (5, 30), (35, 5)]):
        assert m.nearest[place] == labels[k]
    unreached = m.nearest[0, 40]
    assert unreached is None or unreached == -1 or np.isnan(unreached)
    with pytest.raises(ValueError, match="one value for each of 3 sources"):
        gs.Surface.from_heights(z).solve([(5, 5), (5, 30), (35, 5)], labels=[1, 2])


def test_labels_of_a_raster_are_those_of_its_cells() -> None:
    raster = np.zeros(FLAT.shape, int)
    raster[1, 1], raster[1, 2], raster[30, 30] = 7, 7, 3
    m = gs.Surface.from_heights(FLAT).solve(raster, labels=raster)
    assert set(np.unique(m.nearest)) == {3, 7} and m.nearest[40, 40] == 3


def test_tables_are_read_by_the_names_of_their_columns() -> None:
    pd = pytest.importorskip("pandas")
    table = pd.DataFrame({"name": ["a", "b"], "col": [3, 30], "row": [20, 4], "start": [0.0, 2.0]})
    surface = gs.Surface.from_heights(FLAT)
    m = surface.solve(table, labels="name")
    expected = surface.solve([(20, 3, 0.0), (4, 30, 2.0)])
    assert np.array_equal(m.distance, expected.distance) and m.nearest[4, 30] == "b"
    for columns in ({"x": [1], "y": [2]}, {"row": [1]}, {"row": [1], "col": [1], "column": [2]}):
        with pytest.raises(ValueError, match="columns with rows and columns"):
            surface.solve(pd.DataFrame(columns))
    with pytest.raises(ValueError, match="not a column"):
        surface.solve(table, labels="nome")


class TestXarray:
    """With coordinates."""

    @pytest.fixture(autouse=True)
    def _xarray(self) -> None:
        self.xr = pytest.importorskip("xarray")
        import geosweep.xarray  # noqa: F401

    def array(self, x: Any, y: Any, values: Any = None, **attrs: Any) -> Any:
        data = np.zeros((len(y), len(x))) if values is None else values
        return self.xr.DataArray(data, {"y": y, "x": x}, ("y", "x"), attrs=attrs)

    @pytest.mark.parametrize("step", [10.0, 30.3, 1.1])
    def test_rounded_coordinates_are_even(self, step: float) -> None:
        x = (500000 + step * np.arange(81)).astype("f4")
        y = (4000000 - step * np.arange(61)).astype("f4")
        d = self.array(x, y).geosweep.distance((float(x[3]), float(y[5])))
        assert d.values[5, 3] == 0
        assert abs(d.values[5, 80] - 77 * step) < 0.3
        uneven = x.copy()
        uneven[40] += 3
        with pytest.raises(ValueError, match="not evenly spaced"):
            self.array(uneven, y).geosweep.surface()

    def test_rounding_that_hides_the_step_is_told(self) -> None:
        y = (4000000 - 0.1 * np.arange(61)).astype("f4")
        with pytest.raises(ValueError, match="float32, whose rounding"):
            self.array(np.arange(5.0), y).geosweep.surface()

    def orientations(self) -> list[Any]:
        x, y = 500000 + 30.0 * np.arange(31), 4000000 - 20.0 * np.arange(21)
        rng = np.random.default_rng(5)
        da = self.array(x, y, rng.normal(size=(21, 31)).cumsum(0).cumsum(1))
        flips = [da[::a, ::b] for a in (1, -1) for b in (1, -1)]
        return flips + [flip.transpose() for flip in flips]

    def test_all_options_are_in_the_frame_of_the_array(self) -> None:
        source = (500150.0, 3999700.0)
        north_up = self.orientations()[0]
        whole = north_up.geosweep.distance(source)
        mask = self.xr.ones_like(north_up)
        mask[3:9, 20] = 0
        holed = north_up.geosweep.distance(source, mask=mask)
        for da in self.orientations():
            out = np.empty(da.shape, np.float32)
            d = da.geosweep.distance(source, out=out)
            assert np.array_equal(out, d.values)
            assert np.array_equal(d.transpose("y", "x").sel(x=whole.x, y=whole.y).values, whole)
            # A target 4 cells to the east of the source, by its indices in this array.
            at = {"x": 500150.0 + 120, "y": 3999700.0}
            target = [list(da.get_index(dim)).index(at[dim]) for dim in da.dims]
            near = da.geosweep.distance(source, targets=[target])
            assert np.isfinite(near.sel(at).item())
            assert np.isfinite(near).mean().item() < 0.5
            for inputs in ({"mask": mask}, {"holes": 1 - mask}, {"speed": mask}):
                found = da.geosweep.distance(source, **inputs)
                same = found.transpose("y", "x").sel(x=whole.x, y=whole.y).values
                assert np.allclose(same, holed, equal_nan=True)
            raw = mask.transpose(*da.dims).sel(x=da.x, y=da.y).values
            found = da.geosweep.distance(source, holes=raw == 0).transpose("y", "x")
            assert np.array_equal(found.sel(x=whole.x, y=whole.y).values, holed, equal_nan=True)
            m = da.geosweep.solve(source)
            bearing = m.back_direction().sel(x=500150.0 + 300, y=3999700.0).item()
            assert 225 < bearing < 315
        with pytest.raises(ValueError, match="targets must be indices into the array"):
            north_up.geosweep.distance(source, targets=[(40, 2)])

    def test_heights_with_coordinates_have_their_spacing(self) -> None:
        x, y = 500000 + 30.0 * np.arange(31), 4000000 - 20.0 * np.arange(21)
        da = self.array(x, y)
        expected = gs.distance(da.values, (3, 4), spacing=(20, 30))
        assert np.array_equal(gs.distance(da, (3, 4)), expected)
        surface = gs.Surface.from_heights(da)
        assert np.array_equal(surface.solve((3, 4)).distance, expected)
        assert np.array_equal(gs.distance(da, (3, 4), spacing=1), gs.distance(da.values, (3, 4)))
        bare = self.xr.DataArray(da.values)
        assert np.array_equal(gs.distance(bare, (3, 4)), gs.distance(da.values, (3, 4)))
        for other in (da[::-1], da[:, ::-1], da.transpose()):
            with pytest.raises(ValueError, match="north to south"):
                gs.distance(other, (3, 4))
        degrees = da.rename(x="lon", y="lat")
        with pytest.raises(ValueError, match="degrees"):
            gs.distance(degrees, (3, 4))
        mask = self.xr.ones_like(da)
        mask[5, 6] = 0
        assert np.isinf(gs.distance(da, (3, 4), mask=mask[::-1])[5, 6])  # by coordinates

    def test_places_in_the_outer_half_of_a_border_cell(self) -> None:
        da = self.array(500000 + 10.0 * np.arange(31), 4000000 - 10.0 * np.arange(21))
        for xy, at in [((499996, 4000000), (0, 0)), ((500304.9, 3999900), (10, 30))]:
            assert da.geosweep.distance(xy).values[at] == 0
        places = [(499994, 4000000), (500000, 4000000), (500306, 3999900)]
        with pytest.raises(ValueError, match=r"2 of 3 places"):
            da.geosweep.distance(places)

    def test_units(self) -> None:
        da = self.array(500000 + 10.0 * np.arange(31), 4000000 - 10.0 * np.arange(21), units="m")
        m = da.geosweep.solve((500010.0, 3999990.0))
        assert m.distance.attrs["units"] == "m" and m.error().attrs["units"] == "m"
        assert m.back_direction().attrs["units"] == "degree"
        assert "units" not in m.nearest.attrs and "units" not in m.back_link().attrs
        slow = da.geosweep.distance((500010.0, 3999990.0), slowness=np.full(da.shape, 2.0))
        assert "units" not in slow.attrs and slow.attrs["long_name"] == "travel time"
        for unit in ("km", "feet"):
            da.x.attrs["units"] = da.y.attrs["units"] = unit
            with pytest.raises(ValueError, match="different units"):
                da.geosweep.surface()
        da.x.attrs["units"] = da.y.attrs["units"] = "metres"
        da.geosweep.surface()

    def test_mercator_is_told(self) -> None:
        da = self.array(1e6 + 100.0 * np.arange(9), 8399737.9 - 100.0 * np.arange(9))
        wkt = 'PROJCS["WGS 84 / Pseudo-Mercator",UNIT["metre",1],AUTHORITY["EPSG","3857"]]'
        da.attrs["crs"] = wkt
        with pytest.warns(gs.ScaleWarning, match=r"Mercator map has a scale of 2\.0"):
            da.geosweep.distance((1e6, 8399737.9))

    def test_tables_of_geometries_keep_their_rows(self) -> None:
        geopandas = pytest.importorskip("geopandas")
        shapely = pytest.importorskip("shapely")
        x, y = 500000 + 30.0 * np.arange(81), 4000000 - 30.0 * np.arange(61)
        da = self.array(x, y)
        point = shapely.Point(x[70], y[30])
        for first in (
            shapely.LineString([(x[5], y[5]), (x[5], y[50])]),
            shapely.MultiPoint([(x[5], y[5]), (x[6], y[50])]),
            shapely.GeometryCollection(
                [shapely.Point(x[3], y[3]), shapely.LineString([(x[5], y[5]), (x[5], y[50])])]
            ),
        ):
            table = geopandas.GeoDataFrame({"name": ["river", "well"]}, geometry=[first, point])
            m = da.geosweep.solve(table)
            assert m.nearest.values[30, 70] == 1 and m.nearest.values[5, 5] == 0
            regions = m.regions()
            assert regions.source.tolist() == [0, 1]
            assert np.isclose(regions["area"].sum(), 2400 * 1800)
            assert m.borders()[["source", "other"]].drop_duplicates().values.tolist() == [[0, 1]]
            assert m.paths([(x[70], y[30])]).source.tolist() == [1]
            named = da.geosweep.solve(table, labels="name")
            assert named.nearest.values[30, 70] == "well"
            assert named.regions().label.tolist() == ["river", "well"]
            bare = da.geosweep.solve([first, point])
            assert np.array_equal(bare.nearest.values, m.nearest.values)
        assert da.geosweep.distance(point).values[30, 70] == 0
        pd = pytest.importorskip("pandas")
        wells = pd.DataFrame({"id": [4], "y": [y[30]], "x": [x[70]]})
        assert da.geosweep.distance(wells).values[30, 70] == 0
        with pytest.raises(TypeError, match="geometries have x and y"):
            gs.distance(da.values, point)


def test_sources_elsewhere_are_refused_skipped_or_snapped() -> None:
    z = FLAT.copy()
    z[10:15, 10:15] = np.nan
    surface = gs.Surface.from_heights(z, (2.0, 1.0))
    sources = [(3, 3), (12, 11), *[(50 + k, 4) for k in range(6)], (20, 20.5)]
    with pytest.raises(ValueError, match=r"7 of 9 source points .*\(12, 11\).* and 2 more"):
        surface.solve(sources)
    skipped = surface.solve(sources, sources_outside="skip")
    assert np.array_equal(skipped.distance, surface.solve([(3, 3), (20, 20.5)]).distance)
    assert skipped.nearest[20, 20] == 8  # The row of the caller's list.
    snapped = surface.solve(sources, sources_outside="snap")
    assert snapped.distance[12, 9] == 0 and snapped.distance[40, 4] == 0
    with pytest.raises(ValueError, match="nothing is left"):
        surface.solve((12, 12), sources_outside="skip")
    with pytest.raises(ValueError, match="sources_outside='drop' is unknown"):
        surface.solve((3, 3), sources_outside="drop")  # type: ignore[arg-type]
    with pytest.raises(ValueError, match="1 of 1 source points"):
        gs.distance(z, (12, 12))


def test_mistakes_that_would_be_silent_are_named() -> None:
    surface = gs.Surface.from_heights(FLAT)
    for count in (2, 3, 7):
        with pytest.raises(ValueError, match="tuple of arrays"):
            surface.solve((np.arange(count), np.arange(count)))
    m = surface.solve((3, 4))
    for wrong in (True, np.True_):
        with pytest.raises(TypeError, match="levels"):
            m.contours(wrong)
    with pytest.raises(ValueError, match="not negative"):
        m.contours(-3)
    pd = pytest.importorskip("pandas")
    row = pd.Series({"col": 4, "row": 3})
    assert surface.solve(row).distance[3, 4] == 0
    assert surface.solve(pd.Series([3, 4])).distance[3, 4] == 0
    with pytest.raises(ValueError, match="columns with rows and columns"):
        surface.solve(pd.Series({"x": 4, "y": 3}))
    geopandas = pytest.importorskip("geopandas")
    shapely = pytest.importorskip("shapely")
    xr = pytest.importorskip("xarray")
    import geosweep.xarray  # noqa: F401

    da = xr.DataArray(FLAT, {"y": -np.arange(41.0), "x": np.arange(41.0)}, ("y", "x"))
    table = geopandas.GeoDataFrame(geometry=[shapely.Point(3, -4)], crs=4326)
    with pytest.raises(ValueError, match="EPSG:4326, and the array names no CRS"):
        da.geosweep.distance(table)
    with pytest.raises(ValueError, match="tuple of arrays"):
        da.geosweep.distance((np.array([1.0, 2.0]), np.array([-3.0, -4.0])))

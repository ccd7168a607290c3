"""Places in tables, and rasters of xarray, in whatever order they come."""

import pickle
from typing import Any

import numpy as np
import pytest

import geosweep as gs

Z = np.random.default_rng(3).normal(size=(17, 21)).cumsum(0).cumsum(1) / 5
SURFACE = gs.Surface.from_heights(Z)


@pytest.mark.parametrize(
    "names", [("row", "col"), ("col", "row"), ("Column", "ROW"), ("id", "col", "row")]
)
def test_tables_of_places_are_read_by_name(names: tuple[str, ...]) -> None:
    pd = pytest.importorskip("pandas")
    places = [(2, 3), (15, 4), (9, 20)]
    rows, cols = zip(*places, strict=True)
    columns = {"row": rows, "col": cols, "column": cols, "id": (7, 8, 9)}
    m = SURFACE.solve((8, 8))
    for dtype in ("int64", "float32", "Int64"):
        table = pd.DataFrame({name: columns[name.lower()] for name in names}).astype(dtype)
        assert np.array_equal(SURFACE.solve(table).distance, SURFACE.solve(places).distance)
        found, expected = m.paths(table), m.paths(places)
        assert [path.length for path in found] == [path.length for path in expected]
        near = SURFACE.solve((8, 8), targets=table, needed=1).distance
        assert np.array_equal(near, SURFACE.solve((8, 8), targets=places, needed=1).distance)
        row = m.paths(table.iloc[1])
        assert row[0].length == expected[1].length


def test_tables_without_a_place_are_refused() -> None:
    pd = pytest.importorskip("pandas")
    m = SURFACE.solve((8, 8))
    for table in (pd.DataFrame({"x": [3], "y": [4]}), pd.DataFrame({"row": [3]})):
        for name, call in {
            "ends": lambda it: m.paths(it),
            "targets": lambda it: SURFACE.solve((8, 8), targets=it),
            "source": lambda it: SURFACE.solve(it),
        }.items():
            with pytest.raises(ValueError, match=f"^{name}: the table must have columns with rows"):
                call(table)
    hole = pd.DataFrame({"row": pd.array([3, None], "Int64"), "col": [4, 5]})
    with pytest.raises(ValueError, match=r"1 of 2 source points .*\(nan, 5\)"):
        SURFACE.solve(hole)
    with pytest.raises(ValueError, match="targets must be integers"):
        SURFACE.solve((8, 8), targets=hole)
    with pytest.raises(TypeError, match=r"source: row must be .* not '3' at \[0\]"):
        SURFACE.solve(pd.DataFrame({"row": ["3"], "col": ["4"]}, dtype=object))
    mixed = pd.DataFrame({"name": ["a"], "row": [3], "col": [4]}).iloc[0]
    assert SURFACE.solve(mixed).distance[3, 4] == 0


@pytest.mark.parametrize("count", [2, 3, 7])
def test_tuples_of_arrays_are_neither_points_nor_coordinates(count: int) -> None:
    pd = pytest.importorskip("pandas")
    m = SURFACE.solve((8, 8))
    rows, cols = np.arange(count), np.arange(count) + 4
    for pair in ((rows, cols), (pd.Series(rows), pd.Series(cols)), tuple(np.array([rows, cols]))):
        for name, call in {
            "source": SURFACE.solve,
            "ends": m.paths,
            "targets": lambda it: SURFACE.solve((8, 8), targets=it),
        }.items():
            with pytest.raises(ValueError, match=f"^{name}: a tuple of arrays does not say"):
                call(pair)
        with pytest.raises(ValueError, match=r"^source: a tuple of arrays"):
            SURFACE.solve(gs.Lines([pair]))


class TestXarray:
    """Rasters with coordinates."""

    @pytest.fixture(autouse=True)
    def _xarray(self) -> None:
        self.xr = pytest.importorskip("xarray")
        import geosweep.xarray  # noqa: F401

        self.x, self.y = 500000 + 30.0 * np.arange(21), 4000000 - 20.0 * np.arange(17)
        self.heights = self.array(Z)

    def array(self, values: Any, **attrs: Any) -> Any:
        return self.xr.DataArray(values, {"y": self.y, "x": self.x}, ("y", "x"), attrs=attrs)

    def orders(self, da: Any) -> list[Any]:
        flips = [da[::a, ::b] for a in (1, -1) for b in (1, -1)]
        return flips + [flip.transpose() for flip in flips] + [da.expand_dims("band")]

    def test_rasters_of_sources_labels_and_insides_are_placed_by_coordinates(self) -> None:
        cells = np.zeros(Z.shape, int)
        cells[2, 3], cells[14, 19] = 4, 9
        ring = gs.Lines([[(0, 0), (0, 20), (9, 20), (9, 0), (0, 0)]])
        inside = np.arange(17)[:, None] + np.zeros(21) < 9
        surface = gs.Surface.from_heights(self.heights)
        sources, within = self.array(cells), self.array(inside)
        expected = surface.solve(cells)
        signed = surface.solve(ring).signed(inside)
        for again in (surface, pickle.loads(pickle.dumps(surface))):
            for source, labels, mask in zip(
                *map(self.orders, (sources, sources, within)), strict=True
            ):
                m = again.solve(source, labels=labels)
                assert np.array_equal(m.distance, expected.distance)
                assert m.nearest[2, 3] == 4 and m.nearest[14, 19] == 9
                assert np.array_equal(gs.distance(self.heights, source), expected.distance)
                assert np.array_equal(again.solve(ring).signed(mask), signed)
                samples = again.farthest_points(source, 2)[0]
                assert np.array_equal(samples, surface.farthest_points(cells, 2)[0])
        # A map of the accessor is in the grid's order, whatever the array's is.
        curve = gs.Lines([np.column_stack([self.x[[0, 20, 20, 0, 0]], self.y[[0, 0, 9, 9, 0]]])])
        for heights in self.orders(self.heights)[:8]:
            for mask in self.orders(within)[:8]:
                found = heights.geosweep.solve(curve).map.signed(mask)
                assert np.allclose(found, signed, rtol=1e-4)

    def test_rasters_elsewhere_are_refused(self) -> None:
        cells = np.zeros(Z.shape, int)
        cells[2, 3] = 1
        surface = gs.Surface.from_heights(self.heights)
        elsewhere = self.array(cells).assign_coords(x=self.x + 30)
        for wrong in (elsewhere, self.array(cells)[:, :-1], self.array(cells).rename(x="lon")):
            for call in (surface.solve, lambda it: gs.distance(self.heights, it)):
                with pytest.raises(
                    ValueError, match="source must have the coordinates of the heigh"
                ):
                    call(wrong)
            with pytest.raises(ValueError, match="labels must have the coordinates of the heights"):
                surface.solve(cells, labels=wrong)
        # An array of places is none of the grid's rasters.
        places = self.xr.DataArray([[2, 3], [14, 19]], dims=("place", "axis"))
        assert (surface.solve(places).distance == 0).sum() == 2
        xy = self.xr.DataArray(np.column_stack([self.x[[3, 19]], self.y[[2, 14]]]))
        found = self.heights.geosweep.distance(xy)
        assert np.array_equal(found, surface.solve(places).distance)
        with pytest.raises(ValueError, match="takes a list of lines"):
            self.heights.geosweep.distance(gs.Lines(xy.values))

    def test_coordinates_that_are_given_twice(self) -> None:
        twice = self.heights.assign_coords(x=np.arange(21) // 2)
        mask = self.xr.ones_like(twice)
        mask[5, 6] = 0
        d = gs.distance(twice, (0, 0), spacing=1, mask=mask)
        assert np.isinf(d[5, 6]) and np.isinf(d).sum() == 1
        with pytest.raises(ValueError, match=r"mask must have the coordinates .* given twice"):
            gs.distance(twice, (0, 0), spacing=1, mask=mask[:, ::-1])

    def test_places_that_are_no_coordinates_along_the_axes_are_told(self) -> None:
        two = {"lat": (("j", "i"), Z), "lon": (("j", "i"), Z)}
        curvilinear = self.xr.DataArray(Z, two, ("j", "i"))
        transform = self.xr.DataArray(0, attrs={"GeoTransform": "500000 30 0 4000000 0 -20"})
        placed = self.xr.DataArray(Z, {"spatial_ref": transform}, ("y", "x"))
        for da, said in ((curvilinear, "vary along both axes"), (placed, "has a GeoTransform")):
            for call in (lambda it: gs.distance(it, (0, 0)), gs.Surface.from_heights):
                with pytest.raises(ValueError, match=said):
                    call(da)
            assert np.array_equal(gs.distance(da, (0, 0), spacing=1), gs.distance(Z, (0, 0)))
        with pytest.raises(ValueError, match="no coordinates along 'y'; assign them"):
            gs.distance(self.heights.drop_vars("y"), (0, 0))

    def test_ends_are_geometries_and_tables_by_name(self) -> None:
        shapely = pytest.importorskip("shapely")
        pytest.importorskip("geopandas")
        pd = pytest.importorskip("pandas")
        for heights in self.orders(self.heights)[:8]:
            m = heights.geosweep.solve((self.x[3], self.y[2]))
            ends = np.column_stack([self.x[[20, 5]], self.y[[9, 16]]])
            expected = m.paths(ends)
            table = pd.DataFrame({"northing": ends[:, 1], "n": [1, 2], "easting": ends[:, 0]})
            points = [shapely.Point(*end) for end in ends]
            for given in (table, points, tuple(points)):
                assert m.paths(given).geometry.tolist() == expected.geometry.tolist()
            assert m.paths(points[1]).length.tolist() == expected.length.tolist()[1:]
            for wrong in (shapely.box(0, 0, 1, 1), [points[0], shapely.Point()]):
                with pytest.raises(ValueError, match="ends must be points alone"):
                    m.paths(wrong)
        with pytest.raises(ValueError, match="geometry of row 1 is empty"):
            self.heights.geosweep.solve([shapely.Point(self.x[3], self.y[2]), shapely.Point()])

    @pytest.mark.parametrize(
        "crs",
        [
            "EPSG:4326",
            "epsg:4807",
            "urn:ogc:def:crs:OGC:1.3:CRS84",
            "+proj=longlat +datum=WGS84",
            'COMPD_CS["C",GEOGCS["W",DATUM["D",SPHEROID["W",6378137,298.257]],UNIT["degree",'
            '0.0174532925199433]],VERT_CS["E",VERT_DATUM["E",2005],UNIT["metre",1]]]',
            'BOUNDCRS[SOURCECRS[GEOGCRS["W",DATUM["D",ELLIPSOID["W",6378137,298.257]],'
            'ANGLEUNIT["degree",0.0174532925199433]]],TARGETCRS[PROJCRS["x"]]]',
        ],
    )
    def test_angles_are_refused(self, crs: str) -> None:
        with pytest.raises(ValueError, match="are angles"):
            self.heights.assign_attrs(crs=crs).geosweep.surface()
        mapping = self.xr.DataArray(0, attrs={"crs_wkt": crs})
        for da in (self.heights.assign_coords(spatial_ref=mapping),):
            with pytest.raises(ValueError, match="are angles"):
                gs.distance(da, (0, 0))

    @pytest.mark.parametrize(
        "unit", ["rad", "radian", "degrees_north", "deg", "grad", "arc_second"]
    )
    def test_units_of_angles_are_refused(self, unit: str) -> None:
        coords = {"y": ("y", self.y, {"units": unit}), "x": ("x", self.x, {"units": unit})}
        with pytest.raises(ValueError, match="are angles"):
            self.xr.DataArray(Z, coords, ("y", "x")).geosweep.surface()

    def test_the_unit_of_a_coordinate_system_is_that_of_the_heights(self) -> None:
        feet = 'PROJCS["A",GEOGCS["W",UNIT["degree",0.0174532925199433]],UNIT["US survey foot",'
        feet += "0.304800609601219]]"
        up = 'VERT_CS["N",VERT_DATUM["N",2005],UNIT["{}",{}]]'
        wrong = [
            (feet, "m", "different units"),
            (feet, "", "does not say the unit of its heights"),
            (f'COMPD_CS["C",{feet},{up.format("metre", 1)}]', "", "different units"),
            ('PROJCS["A",UNIT["metre",1]]', "ft", "different units"),
            ('PROJCS["A",UNIT["kilometre",1000]]', "m", "different units"),
        ]
        for crs, unit, said in wrong:
            da = self.array(Z, crs=crs, **({"units": unit} if unit else {}))
            for call in (lambda it: it.geosweep.surface(), lambda it: gs.distance(it, (0, 0))):
                with pytest.raises(ValueError, match=said):
                    call(da)
        right = [
            (feet, "ft"),
            (feet, "US_survey_foot"),
            (f'COMPD_CS["C",{feet},{up.format("US survey foot", 0.3048006096012192)}]', ""),
            ('PROJCS["A",UNIT["metre",1]]', ""),
            ('PROJCS["A",UNIT["metre",1]]', "metres"),
            ('LOCAL_CS["site",UNIT["metre",1]]', "m"),
        ]
        for crs, unit in right:
            da = self.array(Z, crs=crs, **({"units": unit} if unit else {}))
            assert np.array_equal(gs.distance(da, (0, 0)), gs.distance(Z, (0, 0), spacing=(20, 30)))

    def test_unsigned_and_set_missing_values(self) -> None:
        low = Z < np.median(Z)
        for fill, key in ((-1, "_FillValue"), (-2, "missing_value"), (255, "_FillValue")):
            stored = np.where(low, fill % 256, 100).astype("u1").view("i1")
            da = self.array(stored, **{"_Unsigned": "true", key: fill})
            assert np.array_equal(gs.Surface.from_heights(da).present, ~low)
        valid = self.array(
            np.where(low, -1, 100).astype("i1"), _Unsigned="true", valid_range=(0, -56)
        )
        assert np.array_equal(gs.Surface.from_heights(valid).present, ~low)
        pytest.importorskip("rioxarray")
        da = self.array(np.where(low, -9999, Z)).rio.set_nodata(-9999)
        for surface in (gs.Surface.from_heights(da), da.geosweep.surface()):
            assert np.array_equal(surface.present, ~low)
        walled = self.heights.geosweep.surface(
            slowness=self.array(np.where(low, 7, 1)).rio.set_nodata(7)
        )
        assert np.array_equal(walled.present, ~low)

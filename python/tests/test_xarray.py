"""The accessor of xarray, and tables of GeoPandas."""

import numpy as np
import pytest

import geosweep as gs

xr = pytest.importorskip("xarray")
import geosweep.xarray  # noqa: E402

X = 500000 + 30.0 * np.arange(50)
Y = 4000000 - 20.0 * np.arange(40)
UTM = (
    'PROJCS["UTM 33N",GEOGCS["WGS 84",DATUM["WGS_1984",SPHEROID["WGS 84",6378137,298.257223563]],'
    'PRIMEM["Greenwich",0],UNIT["degree",0.0174532925199433]],PROJECTION["Transverse_Mercator"],'
    'PARAMETER["latitude_of_origin",0],PARAMETER["central_meridian",15],'
    'PARAMETER["scale_factor",0.9996],PARAMETER["false_easting",500000],'
    'PARAMETER["false_northing",0],UNIT["metre",1]]'
)
WGS84 = (
    'GEOGCS["WGS 84",DATUM["WGS_1984",SPHEROID["WGS 84",6378137,298.257223563]],'
    'PRIMEM["Greenwich",0],UNIT["degree",0.0174532925199433]]'
)


def dem() -> "xr.DataArray":
    x, y = np.meshgrid(X - X.mean(), Y - Y.mean())
    z = 200 * np.exp(-(x**2 + y**2) / 2e5) + x / 10
    attrs = {"units": "m", "long_name": "height", "station": "A"}
    coords = {"y": Y, "x": X, "spatial_ref": ((), 0, {"crs_wkt": UTM})}
    return xr.DataArray(z, coords, ("y", "x"), name="z", attrs=attrs)


def test_coordinates_and_attributes_are_kept() -> None:
    da = dem()
    source = (X[7] + 10, Y[12])
    d = da.geosweep.distance(source)
    assert d.dims == da.dims and d.name == "distance" and d.dtype == np.float32
    assert d.attrs == {"units": "m", "long_name": "geodesic distance", "station": "A"}
    assert d.coords.equals(da.coords) and d.spatial_ref.attrs == da.spatial_ref.attrs
    expected = gs.distance(da.values, (12, 7 + 1 / 3), spacing=(20, 30))
    assert np.array_equal(d.values, expected)


@pytest.mark.parametrize("orientation", ["south-up", "westwards", "transposed", "band", "all"])
def test_every_orientation_gives_the_same_map(orientation: str) -> None:
    da = dem()
    turned = {
        "south-up": lambda: da[::-1],
        "westwards": lambda: da[:, ::-1],
        "transposed": lambda: da.transpose(),
        "band": lambda: da.expand_dims(band=[1]),
        "all": lambda: da[::-1, ::-1].transpose().expand_dims(band=[1]),
    }[orientation]()
    source = [(X[7], Y[12]), (X[40], Y[3])]
    d = turned.geosweep.distance(source)
    assert d.dims == turned.dims and d.coords.equals(turned.coords)
    same = d.squeeze(drop=True).transpose("y", "x").sel(x=X, y=Y)
    assert np.array_equal(same.values, da.geosweep.distance(source).values)
    bearing = turned.geosweep.solve(source[:1]).back_direction()
    assert bearing.squeeze().sel(x=X[7], y=Y[39]).item() == pytest.approx(360, abs=30)
    link = turned.geosweep.solve(source[:1]).back_link()
    assert link.dims == turned.dims and link.squeeze().sel(x=X[7], y=Y[39]).item() in (6, 7, 8)


def test_masks_slowness_and_holes() -> None:
    da = dem()
    wall = xr.ones_like(da, dtype=bool)
    wall[:, 20] = False
    d = da[::-1].geosweep.distance((X[7], Y[12]), mask=wall[::-1])
    assert np.isnan(d.sel(x=X[20:])).all() and np.isfinite(d.sel(x=X[:20])).all()
    slow = da.geosweep.distance((X[7], Y[12]), slowness=np.full(da.shape, 2.0))
    assert np.allclose(slow, 2 * da.geosweep.distance((X[7], Y[12])), rtol=1e-5)
    holes = da.copy().assign_attrs(_FillValue=-9999.0)
    holes[5, 5] = -9999.0
    found = holes.geosweep.distance((X[7], Y[12]))
    assert np.isnan(found[5, 5]) and "_FillValue" not in found.attrs
    with pytest.raises(ValueError, match="mask must have the coordinates"):
        da.geosweep.distance((X[7], Y[12]), mask=wall[:-1])


def test_sources_of_all_sorts() -> None:
    da = dem()
    raster = np.zeros(da.shape, bool)
    raster[3, 4] = True
    one = da.geosweep.distance((X[4], Y[3])).values
    of_raster = da[::-1].geosweep.distance(xr.DataArray(raster, da.coords, da.dims)[::-1])
    assert np.array_equal(of_raster.values[::-1], one)
    assert da.geosweep.distance([(X[4], Y[3], 9.0)]).values[3, 4] == 9.0
    line = da.geosweep.distance(gs.Lines([[(X[0], Y[3]), (X[-1], Y[3])]]))
    assert (line.values[3] == 0).all()


def test_what_has_no_lengths_is_refused() -> None:
    da = dem()
    source = (X[4], Y[3])
    units = da.copy()
    units.coords["x"].attrs["units"] = "degrees_east"
    in_degrees = da.assign_coords(spatial_ref=((), 0, {"crs_wkt": WGS84}))
    cases = [
        (units, "degrees"),
        (in_degrees, "degrees"),
        (da.rename(x="lon", y="lat"), "degrees"),
        (da.drop_vars("x"), "no coordinates along 'x'"),
        (da.assign_coords(x=X**1.1), "not evenly spaced"),
        (da.expand_dims(time=[1, 2]), "two dimensions"),
    ]
    for wrong, said in cases:
        with pytest.raises(ValueError, match=said):
            wrong.geosweep.distance(source)
    with pytest.raises(ValueError, match="outside the raster"):
        da.geosweep.distance((0, 0))


def test_rioxarray_gives_the_crs() -> None:
    pytest.importorskip("rioxarray")
    pytest.importorskip("geopandas")
    da = dem().drop_vars("spatial_ref").rio.write_crs("EPSG:32633")
    m = da.geosweep.solve((X[4], Y[3]))
    assert m.distance.rio.crs == da.rio.crs
    assert m.contours([300.0]).crs.to_epsg() == 32633
    with pytest.raises(ValueError, match="degrees"):
        da.rio.reproject("EPSG:4326").geosweep.distance((15, 36))


def test_tables_of_geopandas() -> None:
    geopandas = pytest.importorskip("geopandas")
    shapely = pytest.importorskip("shapely")
    flat = dem() * 0
    points = [shapely.Point(X[10], Y[20]), shapely.Point(X[41], Y[20])]
    table = geopandas.GeoDataFrame({"start": [0.0, 30.0]}, geometry=points)
    m = flat.geosweep.solve(table)
    assert m.distance.values[20, 41] == 30.0
    even = flat.geosweep.solve(table[["geometry"]])
    paths = even.paths(geopandas.GeoDataFrame(geometry=[shapely.Point(X[10], Y[0])]))
    assert paths.geometry[0].length == pytest.approx(400) == paths.length[0]
    assert paths.source[0] == 0
    assert tuple(paths.geometry[0].coords[0]) == (X[10], Y[0])
    circle = even.contours([100.0])
    assert len(circle) == 2 and circle.length.iloc[0] == pytest.approx(200 * np.pi, rel=1e-2)
    regions = even.regions()
    assert regions.source.tolist() == [0, 1]
    assert regions.geometry[0].contains(points[0]) and regions.geometry[1].contains(points[1])
    assert regions.geometry.area.sum() == pytest.approx(40 * 20 * 50 * 30)
    assert regions["area"].sum() == pytest.approx(39 * 20 * 49 * 30)
    border = even.borders().geometry[0]
    assert np.allclose(np.array(border.coords)[:, 0], (X[10] + X[41]) / 2, atol=0.1)
    lines = geopandas.GeoSeries([shapely.LineString([(X[0], Y[20]), (X[-1], Y[20])]), points[0]])
    assert (flat.geosweep.distance(lines).values[20] == 0).all()
    with pytest.raises(ValueError, match="boundary"):
        flat.geosweep.distance(geopandas.GeoSeries([points[0].buffer(50)]))


def test_pictures(tmp_path) -> None:  # type: ignore[no-untyped-def]
    matplotlib = pytest.importorskip("matplotlib")
    matplotlib.use("Agg")
    m = dem().geosweep.solve((X[4], Y[3]))
    ax = m.plot(paths=[(X[30], Y[30])], contours=[200, 400])
    assert [text.get_text() for text in ax.texts] == ["200", "400"]
    assert len(ax.collections) == 2 and len(ax.lines) == 2
    ax.figure.savefig(tmp_path / "map.png")
    ax = m.map.plot(contours=0, paths=[(30, 30)], colorbar=False)
    assert ax.get_xlabel() == "column" and not ax.texts and ax.get_ylim() == (39.5, -0.5)

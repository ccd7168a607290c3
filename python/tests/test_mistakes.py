"""Arguments of a wrong type or value are refused by name."""

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

import geosweep as gs

Z = np.hypot(*np.mgrid[-8:9, -10:11]) / 3
SURFACE = gs.Surface.from_heights(Z)
MAP = SURFACE.solve([(0, 0), (16, 20)])
FORM = np.abs(np.subtract.outer(np.arange(5.0), np.arange(5.0)))
Call = Callable[[Any], object]

SWITCHES: dict[str, list[Call]] = {
    "strict": [
        lambda it: SURFACE.solve((0, 0), strict=it),
        lambda it: gs.distance(Z, (0, 0), strict=it),
        lambda it: gs.pairwise(SURFACE, [0], strict=it),
    ],
    "copy": [
        lambda it: gs.Surface.from_heights(Z, copy=it),
        lambda it: gs.Surface.from_positions(np.dstack([Z, Z, Z]), copy=it),
    ],
}
NUMBERS: dict[str, list[Call]] = {
    "radius": [
        lambda it: SURFACE.solve((0, 0), radius=it),
        lambda it: gs.distance(Z, (0, 0), radius=it),
    ],
    "tolerance": [lambda it: SURFACE.solve((0, 0), tolerance=it)],
    "step": [lambda it: MAP.contours(step=it)],
    "least_angle": [lambda it: MAP.ridges(it)],
    "u": [lambda it: MAP.log_map().place(it, 0)],
    "v": [lambda it: MAP.log_map().place(0, it)],
}
COUNTS: dict[str, list[Call]] = {
    "iterations": [
        lambda it: SURFACE.solve((0, 0), iterations=it),
        lambda it: gs.canonical_form(FORM, 1, iterations=it),
    ],
    "threads": [
        lambda it: SURFACE.solve((0, 0), threads=it),
        lambda it: gs.pairwise(SURFACE, [0], threads=it),
    ],
    "needed": [lambda it: SURFACE.solve((0, 0), targets=[(1, 1), (2, 2)], needed=it)],
    "dimensions": [lambda it: gs.canonical_form(FORM, it)],
    "count": [lambda it: SURFACE.farthest_points((0, 0), it)],
    "source": [lambda it: MAP.log_map().place(0, 0, it)],
}


def cases(table: dict[str, list[Call]]) -> list[Any]:
    return [pytest.param(name, call, id=name) for name, calls in table.items() for call in calls]


@pytest.mark.parametrize(("name", "call"), cases(SWITCHES))
def test_switches_are_true_or_false(name: str, call: Call) -> None:
    for wrong in ("no", 1, None, [True]):
        with pytest.raises(TypeError, match=f"{name}=.* must be True or False"):
            call(wrong)
    call(np.True_)
    call(False)


@pytest.mark.parametrize(("name", "call"), cases(NUMBERS))
def test_numbers_are_single_and_real(name: str, call: Call) -> None:
    for wrong in ("0.5", True, np.True_, [0.5, 0.6], np.array([0.5, 0.6]), 0.5j, {0.5}):
        with pytest.raises(TypeError, match=f"^{name} must be one number, not "):
            call(wrong)
    with pytest.raises(ValueError, match=f"{name} has a masked value"):
        call(np.ma.masked)
    for right in (0.5, np.float32(0.5), np.array(0.5), np.array(0.5, ">f8"), np.float16(0.5)):
        call(right)


@pytest.mark.parametrize(("name", "call"), cases(COUNTS))
def test_counts_are_whole(name: str, call: Call) -> None:
    for wrong in (2.5, "2", True, np.array([1, 2]), 1.0):
        with pytest.raises(TypeError, match=f"^{name}=.* must be a whole number"):
            call(wrong)
    for wrong in (-1, 2**40, np.int64(-5)):
        with pytest.raises(ValueError, match=f"^{name}=-?[0-9]+ "):
            call(wrong)
    for right in (1, np.uint8(1), np.array(1)):
        call(right)


def test_pools_of_many_thousand_threads_are_refused() -> None:
    with pytest.raises(ValueError, match="threads=100000 must lie from 1 to 1024"):
        SURFACE.solve((0, 0), threads=100_000)


@pytest.mark.parametrize("wrong", [Z, None, "surface", MAP])
def test_surfaces_are_asked_for(wrong: Any) -> None:
    calls: list[Call] = [gs.pairwise, lambda it: gs.CompletedGrid(it, "columns")]
    calls.append(gs.CompletedGrid(SURFACE, "columns", last="apart").complete)
    for call in calls:
        with pytest.raises(TypeError, match=r"surface must be a geosweep\.Surface, not "):
            call(wrong)


BOOLEANS: dict[str, Call] = {
    "heights": lambda it: gs.distance(it, (0, 0)),
    "positions": lambda it: gs.Surface.from_positions(np.dstack([it, it, it])),
    "metric": lambda it: gs.Surface.from_metric(np.dstack([it, it, it])),
    "slowness": lambda it: gs.distance(Z, (0, 0), slowness=it),
    "speed": lambda it: gs.distance(Z, (0, 0), speed=it),
    "source": lambda it: SURFACE.solve(it[:5, :2]),
    "ends": lambda it: MAP.paths(it[:5, :2]),
    "targets": lambda it: SURFACE.solve((0, 0), targets=it[:5, :2]),
    "levels": lambda it: MAP.contours(it[0]),
}


@pytest.mark.parametrize("name", BOOLEANS)
def test_booleans_are_no_numbers(name: str) -> None:
    with pytest.raises(TypeError, match=f"^{name} must be an array of real numbers.*booleans are"):
        BOOLEANS[name](Z > 2)
    with pytest.raises(TypeError, match="source must be"):
        SURFACE.solve((True, False))
    with pytest.raises(TypeError, match="spacing must be one number or"):
        gs.distance(Z, (0, 0), spacing=True)


def test_arrays_of_objects_are_numbers_or_the_first_other_one_is_named() -> None:
    expected = gs.distance(Z, (3, 4))
    assert np.array_equal(gs.distance(Z.astype(object), (3, 4)), expected)
    masked = np.ma.masked_array(Z.astype(object), Z < 1)
    assert np.array_equal(gs.distance(masked, (0, 0)), gs.distance(Z, (0, 0), holes=Z < 1))
    for wrong, said in ((None, "None"), ("7", "'7'"), (1j, "1j"), (True, "True")):
        heights = Z.astype(object)
        heights[3, 5] = wrong
        with pytest.raises(TypeError, match=rf"heights .*not {said} at \[3, 5\]"):
            gs.distance(heights, (0, 0))
    for ragged in ([[1.0, 2.0], [3.0]], [(1, 2), (3, 4, 5)]):
        for call in (lambda it: gs.distance(it, (0, 0)), SURFACE.solve, MAP.paths):
            with pytest.raises(TypeError, match="rows have different lengths"):
                call(ragged)


class Quantity(np.ndarray):
    """An array with a unit, as astropy has it."""

    unit: Any = None

    def to(self, unit: Any) -> "Quantity":
        raise NotImplementedError


def test_units_of_quantities_are_not_dropped() -> None:
    class Unit:
        def __init__(self, name: str) -> None:
            self.name = name

        def __str__(self) -> str:
            return self.name

    quantity = Z.view(Quantity)
    for name, call in {
        "heights": lambda it: gs.distance(it, (0, 0)),
        "slowness": lambda it: gs.distance(Z, (0, 0), slowness=it),
        "mask": lambda it: gs.distance(Z, (0, 0), mask=it),
        "ends": lambda it: MAP.paths(it[:3, :2]),
    }.items():
        quantity.unit = Unit("km")
        Quantity.unit = Unit("km")
        with pytest.raises(ValueError, match=f"{name} is in km, and units are not converted"):
            call(quantity)
        Quantity.unit = quantity.unit = Unit("")
        call(np.abs(quantity) + 1)


def test_masks_that_an_array_makes_are_kept() -> None:
    class Variable:
        """A variable of a NetCDF file."""

        units = "m"
        shape, dtype = Z.shape, Z.dtype

        def __array__(self, *_: Any, **__: Any) -> Any:
            return np.ma.masked_array(np.where(Z < 1, -9999, Z), Z < 1)

    surface = gs.Surface.from_heights(Variable())  # type: ignore[arg-type]
    assert np.array_equal(surface.present, Z >= 1)


def test_spacing_and_lines_are_described() -> None:
    for wrong in ((1, 2, 3), np.ones((2, 2)), []):
        with pytest.raises(ValueError, match="spacing must be one number or"):
            gs.distance(Z, (0, 0), spacing=wrong)  # type: ignore[arg-type]
    for wrong in ("30", ("1", "2"), 1j, {}):
        with pytest.raises(TypeError, match="spacing must be one number or"):
            gs.distance(Z, (0, 0), spacing=wrong)  # type: ignore[arg-type]
    for wrong in (0, (30, -30), (np.nan, 1), (1, np.inf)):
        with pytest.raises(ValueError, match="the distances of rows and of columns; both"):
            gs.distance(Z, (0, 0), spacing=wrong)
    with pytest.raises(ValueError, match="takes a list of lines"):
        SURFACE.solve(gs.Lines([(0, 0), (0, 5)]))
    with pytest.raises(ValueError, match="one for each of 1 lines"):
        SURFACE.solve(gs.Lines([[(0, 0), (0, 5)]], starts=[1, 2]))


def test_gluings_are_described() -> None:
    pairs: Any = [(((0, 0), (16, 0)), ((0, 20), (16, 20)))]
    tube = np.hypot(*np.mgrid[-8:9, -10:11])
    glued = gs.Surface.from_heights(tube, glue=pairs).solve((3, 0)).distance
    assert glued[3, 20] == 0 and glued[3, 19] < 1.5
    for lines in (np.array(pairs), [[[[0, 0], [16, 0]], [[0, 20], [16, 20]]]]):
        found = gs.Surface.from_heights(tube, glue=lines).solve((3, 0)).distance
        assert np.array_equal(found, glued)
    for wrong in (
        3,
        [((0, 0), (16, 0))],
        [[1], [2, 3]],
        [(((0, 0), (16.5, 0)), ((0, 20), (16, 20)))],
    ):
        with pytest.raises(TypeError, match="glue must be a name, or pairs of lines"):
            gs.Surface.from_heights(tube, glue=wrong)  # type: ignore[arg-type]
    with pytest.raises(ValueError, match="glue: -1 is no row or column"):
        gs.Surface.from_heights(tube, glue=[(((0, 0), (16, 0)), ((0, -1), (16, -1)))])


def test_options_that_contradict_are_refused() -> None:
    with pytest.raises(ValueError, match="levels or step"):
        MAP.contours(3, step=2.0)
    for angle in (-1.0, 0.0, 181.0, np.nan):
        with pytest.raises(ValueError, match=r"least angle of .* is not above 0"):
            MAP.ridges(angle)
    with pytest.raises(ValueError, match="dtype=None"):
        SURFACE.solve((0, 0), dtype=None)
    with pytest.raises(TypeError, match="progress=True must be a function"):
        SURFACE.solve((0, 0), progress=True)  # type: ignore[arg-type]
    with pytest.raises(ValueError, match="targets is empty"):
        SURFACE.solve((0, 0), targets=[])
    with pytest.raises(ValueError, match="source is empty"):
        SURFACE.solve([])
    assert MAP.paths([]) == []
    with pytest.raises(ValueError, match="out is read-only"):
        SURFACE.solve((0, 0), out=np.broadcast_to(np.float32(0), Z.shape))


def test_a_target_that_is_given_twice_is_one() -> None:
    targets = [(3, 3), (3, 3), (12, 15)]
    expected = SURFACE.solve((0, 0), targets=targets[1:], needed=2).distance
    assert np.array_equal(SURFACE.solve((0, 0), targets=targets, needed=2).distance, expected)
    with pytest.raises(ValueError, match="there are 2 targets"):
        SURFACE.solve((0, 0), targets=targets, needed=3)


@pytest.mark.parametrize("place", [(np.nan, 4), (3, np.inf), (np.nan, np.nan)])
def test_places_that_are_not_finite_have_no_nearest_point(place: tuple[float, float]) -> None:
    for sources in (place, [(3, 4), place], [place, (50, 50)]):
        with pytest.raises(ValueError, match="not finite, so that no point is nearest"):
            SURFACE.solve(sources, sources_outside="snap")
    left = SURFACE.solve([(3, 4), place], sources_outside="skip")
    assert np.array_equal(left.distance, SURFACE.solve((3, 4)).distance)


def test_labels_are_neither_masked_nor_wrapped() -> None:
    sources = np.zeros(Z.shape, int)
    sources[2, 3] = sources[9, 9] = 1
    hidden = np.zeros(Z.shape, bool)
    hidden[0, 0] = True
    labels = np.ma.masked_array(np.full(Z.shape, 7), hidden)
    assert SURFACE.solve(sources, labels=labels).nearest[5, 5] == 7
    hidden[9, 9] = True
    for given, to in ((sources, labels), ([(0, 0), (1, 1)], np.ma.masked_array([5, 6], [0, 1]))):
        with pytest.raises(ValueError, match="labels has a masked value"):
            SURFACE.solve(given, labels=to)
    for label in (2**63 + 5, 2**53 + 1):
        m = SURFACE.solve((0, 0), labels=np.array([label], np.uint64))
        assert m.nearest[3, 3] == label


def test_results_do_not_overwrite_the_surface() -> None:
    heights = Z.copy()
    surface = gs.Surface.from_heights(heights, copy=False)
    big = np.zeros((40, 40))
    big[5:22, 5:26] = Z
    part = gs.Surface.from_heights(big[5:22, 5:26], copy=False)  # not in C order, so copied
    for one, out in (
        (surface, heights),
        (surface.with_gluing([(((0, 0), (0, 3)), ((16, 0), (16, 3)))]), heights),
    ):
        with pytest.raises(ValueError, match="out lies in the array that the surface reads"):
            one.solve((0, 0), dtype="float64", out=out)
    assert np.array_equal(heights, Z)
    part.solve((0, 0), dtype="float64", out=big[5:22, 5:26])
    # One call needs the heights no more.
    expected = gs.distance(Z, (0, 0), dtype="float64")
    assert np.array_equal(gs.distance(heights, (0, 0), dtype="float64", out=heights), expected)


CHOICES: dict[str, Call] = {
    "engine": lambda it: SURFACE.solve((0, 0), engine=it),
    "wavefront": lambda it: gs.distance(Z, (0, 0), wavefront=it),
    "sources_outside": lambda it: SURFACE.solve((0, 0), sources_outside=it),
    "edges": lambda it: gs.Surface.from_heights(Z, edges=it),
    "unit": lambda it: MAP.back_direction(it),
    "side": lambda it: SURFACE.solve(gs.Lines([[(0, 0), (5, 5)]])).offsets([1.0], it),
    "layout": lambda it: gs.CompletedGrid(SURFACE, it),
    "last": lambda it: gs.CompletedGrid(SURFACE, "columns", last=it),
}


@pytest.mark.parametrize("name", CHOICES)
def test_choices_are_listed(name: str) -> None:
    for wrong in ("Nothing", "", 3, np.array(["auto", "cpu"]), ["cpu"], True):
        with pytest.raises(ValueError, match=rf"^{name}=.* is unknown; choose '.*' or '"):
            CHOICES[name](wrong)


def test_devices_are_named_or_numbered() -> None:
    for wrong in ("", 0.0, True, ["llvmpipe"]):
        with pytest.raises(TypeError, match=r"device=.* must be the index or a part of the name"):
            SURFACE.solve((0, 0), device=wrong)  # type: ignore[arg-type]


def test_places_on_given_grids_are_read_like_others() -> None:
    grid = gs.CompletedGrid(SURFACE, "columns", last="apart")
    places = np.array([[2.0, 3.0], [4.0, 5.0]])
    for convert in (grid.to_completed, grid.to_given):
        assert convert(places.reshape(2, 1, 2)).shape == (2, 1, 2)
        with pytest.raises(ValueError, match="places: a tuple of arrays does not say"):
            convert(tuple(places.T))
        pd = pytest.importorskip("pandas")
        table = pd.DataFrame({"col": places[:, 1], "row": places[:, 0]})
        assert np.array_equal(convert(table), convert(places))
    with pytest.raises(ValueError, match="rows go from 0 to 16, columns from 0 to 21"):
        grid.to_completed((-1.0, 3.0))


def test_rows_may_be_none() -> None:
    assert gs.pairwise(SURFACE, []).shape == (0, Z.size)
    for wrong in ([1.0], np.ones(Z.size, bool), [[0, 1]]):
        with pytest.raises(TypeError, match="rows must be integers"):
            gs.pairwise(SURFACE, wrong)

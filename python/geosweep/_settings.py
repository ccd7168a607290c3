"""Options that solves share."""

from typing import Literal, TypedDict

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ._arrays import count, is_count, real
from ._tables import places_of

Engine = Literal["auto", "cpu", "gpu"]
Wavefront = Literal["auto", "planar", "circular", "curved", "anchored", "rays"]


class Settings(TypedDict):
    """Options, as the compiled part takes them."""

    engine: str
    device: str | None
    wavefront: str | None
    tolerance: float | None
    iterations: int | None
    threads: int | None
    radius: float | None
    targets: list[list[int]] | None
    needed: int | None


def check_choice(name: str, value: object, *choices: str) -> None:
    """Raise ValueError, which names the argument and its choices, for a value that is none."""
    if isinstance(value, str) and value in choices:
        return
    *others, last = (repr(choice) for choice in choices)
    raise ValueError(f"{name}={value!r:.60} is unknown; choose {', '.join(others)} or {last}")


def grid_points(name: str, value: ArrayLike) -> NDArray[np.int64]:
    """Return rows and columns (n, 2) of grid points."""
    places = places_of(name, value)
    points = np.rint(places)
    if not ((points == places) & (np.abs(places) < 2**53)).all():
        raise ValueError(f"{name} must be integers, the rows and columns (n, 2) of grid points")
    if points.size and points.min() < 0:
        raise ValueError(f"{name} must not be negative")
    return points.astype(np.int64)


def check_progress(progress: object) -> None:
    """Raise TypeError if a callback cannot be called."""
    if progress is not None and not callable(progress):
        raise TypeError(f"progress={progress!r:.60} must be a function of two numbers")


def settings(
    engine: str = "auto",
    device: str | int | None = None,
    wavefront: str = "auto",
    tolerance: float | None = None,
    iterations: int | None = None,
    threads: int | None = None,
    radius: float | None = None,
    targets: ArrayLike | None = None,
    needed: int | None = None,
) -> Settings:
    """Check options, and return them as the compiled part takes them."""
    check_choice("engine", engine, "auto", "cpu", "gpu")
    fronts = ("auto", "planar", "circular", "curved", "anchored", "rays")
    check_choice("wavefront", wavefront, *fronts)
    iterations = None if iterations is None else count("iterations", iterations)
    # A pool of many thousands takes minutes to start.
    threads = None if threads is None else count("threads", threads, most=1024)
    tolerance = None if tolerance is None else real("tolerance", tolerance)
    radius = None if radius is None else real("radius", radius)
    if radius is not None and not radius > 0:
        raise ValueError(f"radius={radius!r} must be positive; leave it out for no limit")
    if device is not None and not is_count(device) and not (isinstance(device, str) and device):
        raise TypeError(
            f"device={device!r:.60} must be the index or a part of the name of a device"
        )
    if device is not None and engine == "cpu":
        raise ValueError(f"device={device!r} is for engine='gpu'; leave out one of them")
    points = None
    if targets is not None:
        # A target that is given twice is one of those that are needed.
        points = np.unique(grid_points("targets", targets), axis=0).tolist()
    if points == []:
        raise ValueError("targets is empty; give at least one, or leave it out")
    needed = None if needed is None else count("needed", needed)
    if needed is not None and (points is None or needed > len(points)):
        there = "no targets are given" if points is None else f"there are {len(points)} targets"
        raise ValueError(f"needed={needed} is a number of targets, and {there}")
    return {
        # As in the tool, a device asks for the engine that it is for.
        "engine": engine if device is None else "gpu",
        "device": None if device is None else str(device),
        "wavefront": None if wavefront == "auto" else wavefront,
        "tolerance": tolerance,
        "iterations": iterations,
        "threads": threads,
        "radius": radius,
        "targets": points,
        "needed": needed,
    }


def is_double(dtype: object) -> bool:
    """Return whether maps are computed in double precision."""
    try:
        # NumPy takes None for float64.
        found = None if dtype is None else np.dtype(dtype)  # type: ignore[call-overload]
    except TypeError:
        found = None
    if found == np.float32:
        return False
    if found == np.float64:
        return True
    raise ValueError(f"dtype={dtype!r} is unknown; choose 'float32' or 'float64'")

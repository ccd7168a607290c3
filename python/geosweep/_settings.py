"""Options that solves share."""

from typing import Literal, NoReturn, TypedDict

Engine = Literal["auto", "cpu", "gpu"]
Wavefront = Literal["auto", "planar", "circular", "curved", "anchored"]


class Settings(TypedDict):
    """Options, as the compiled part takes them."""

    engine: str
    device: str | None
    wavefront: str | None
    tolerance: float | None
    iterations: int | None
    threads: int | None


def refuse(name: str, value: object, choices: str) -> NoReturn:
    """Raise a ValueError that names the argument and its choices."""
    raise ValueError(f"{name}={value!r} is unknown; choose {choices}")


def settings(
    engine: str = "auto",
    device: str | int | None = None,
    wavefront: str = "auto",
    tolerance: float | None = None,
    iterations: int | None = None,
    threads: int | None = None,
) -> Settings:
    """Check options."""
    if engine not in ("auto", "cpu", "gpu"):
        refuse("engine", engine, "'auto', 'cpu' or 'gpu'")
    if wavefront not in ("auto", "planar", "circular", "curved", "anchored"):
        refuse("wavefront", wavefront, "'auto', 'planar', 'circular', 'curved' or 'anchored'")
    if iterations is not None and iterations < 1:
        raise ValueError(f"iterations={iterations!r}: at least one is needed")
    if threads is not None and threads < 1:
        raise ValueError(f"threads={threads!r}: give at least 1, or None for all")
    return {
        "engine": engine,
        "device": None if device is None else str(device),
        "wavefront": None if wavefront == "auto" else wavefront,
        "tolerance": tolerance,
        "iterations": iterations,
        "threads": threads,
    }


def is_double(dtype: object) -> bool:
    """Return whether maps are computed in double precision."""
    import numpy as np

    try:
        found = np.dtype(dtype)  # type: ignore[call-overload]
    except TypeError:
        found = None
    if found == np.float32:
        return False
    if found == np.float64:
        return True
    refuse("dtype", dtype, "'float32' or 'float64'")

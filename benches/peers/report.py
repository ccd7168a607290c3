"""Tables for people (Markdown) and for programs (CSV), and the machine of the measurements."""

from __future__ import annotations

import csv
import os
import platform
import re
import subprocess
from collections.abc import Callable
from dataclasses import dataclass
from importlib import metadata
from pathlib import Path

PACKAGES = (
    "meshlib",
    "potpourri3d",
    "pymeshlab",
    "pygeodesic",
    "agd",
    "hfmpy",
    "scikit-fmm",
    "numpy",
    "scipy",
)


COLUMNS = (
    "surface",
    "size",
    "solver",
    "seconds",
    "mean_error",
    "largest_error",
    "set_up_seconds",
    "missing",
    "failure",
)


# Sizes on the page, and parts of the names of solvers that are left out there. The CSV file has
# all sizes and solvers.
PAGE_SIZES = (400,)
LEFT_OUT = ("vulkan", "fast-marching, circular", "fast-marching, curved", "all cores")


@dataclass(frozen=True)
class Row:
    """One solver on one surface. Without a map, `failure` says why."""

    surface: str
    size: int
    solver: str
    set_up: float = float("nan")
    seconds: float = float("nan")
    mean_error: float = float("nan")
    largest_error: float = float("nan")
    missing: int = 0
    failure: str = ""


def markdown(rows: list[Row]) -> str:
    """Returns a table for each surface and size, in the order of the measurements."""
    tables = dict.fromkeys((row.surface, row.size) for row in rows)
    return "\n\n".join(
        _table(*key, [row for row in rows if (row.surface, row.size) == key]) for key in tables
    )


def _table(surface: str, size: int, rows: list[Row]) -> str:
    head = [
        f"### {surface}, {size} x {size} points",
        "",
        "| solver | set-up, s | solve, s | mean error | largest error |",
        "|---|---:|---:|---:|---:|",
    ]
    return "\n".join(head + [_line(row) for row in rows])


def _line(row: Row) -> str:
    if row.failure:
        return f"| {row.solver} | {row.failure} | | | |"
    missing = f" ({row.missing} points not reached)" if row.missing else ""
    times = f"{seconds(row.set_up)} | {seconds(row.seconds)}"
    errors = f"{fraction(row.mean_error)} | {fraction(row.largest_error)}{missing}"
    return f"| {row.solver} | {times} | {errors} |"


def summary(rows: list[Row]) -> str:
    """Returns two tables for each size of the page: mean errors, and times, by surface."""
    rows = [row for row in rows if row.size in PAGE_SIZES and not _is_left_out(row.solver)]
    sizes = sorted({row.size for row in rows})
    return "\n\n".join(_summary(size, [row for row in rows if row.size == size]) for size in sizes)


def _is_left_out(solver: str) -> bool:
    return any(part in solver for part in LEFT_OUT)


def _summary(size: int, rows: list[Row]) -> str:
    errors = _by_surface(rows, lambda row: fraction(row.mean_error))
    times = _by_surface(rows, lambda row: seconds(row.seconds))
    return (
        f"### {size} x {size} points\n\nMean relative error:\n\n{errors}\n\n"
        f"Seconds to solve:\n\n{times}"
    )


def _by_surface(rows: list[Row], cell: Callable[[Row], str]) -> str:
    """Returns a table with a line for each solver and a column for each surface."""
    surfaces = list(dict.fromkeys(row.surface for row in rows))
    cells = {(row.solver, row.surface): "failed" if row.failure else cell(row) for row in rows}
    lines = [
        " | ".join([solver, *(cells.get((solver, surface), "") for surface in surfaces)])
        for solver in dict.fromkeys(row.solver for row in rows)
    ]
    head = " | ".join(["solver", *surfaces])
    rule = "|---" + "|---:" * len(surfaces) + "|"
    return "\n".join([f"| {head} |", rule, *(f"| {line} |" for line in lines)])


def fraction(error: float) -> str:
    """Formats a number with two digits: 1.2e-5."""
    return f"{error:.1e}".replace("e-0", "e-")


def seconds(time: float) -> str:
    """Formats a number with three digits, without an exponent."""
    if time >= 10:
        return f"{time:.1f}"
    return f"{time:.2f}" if time >= 1 else f"{time:.4f}" if time < 0.01 else f"{time:.3f}"


def write_csv(path: Path, rows: list[Row]) -> None:
    with path.open("w", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(COLUMNS)
        for row in rows:
            times = [
                f"{row.seconds:.6f}",
                f"{row.mean_error:.3e}",
                f"{row.largest_error:.3e}",
                f"{row.set_up:.6f}",
            ]
            values = [
                row.surface,
                row.size,
                row.solver,
                *times,
                row.missing,
                row.failure,
            ]
            writer.writerow("" if value == "nan" else value for value in values)


def read_csv(path: Path) -> list[Row]:
    """Reads rows that `write_csv` wrote; returns none if there is no such file."""
    if not path.exists():
        return []
    with path.open(newline="") as file:
        return [_row(line) for line in csv.DictReader(file)]


def _row(line: dict[str, str]) -> Row:
    number = {key: float(line[key] or "nan") for key in COLUMNS[3:7]}
    return Row(
        surface=line["surface"],
        size=int(line["size"]),
        solver=line["solver"],
        set_up=number["set_up_seconds"],
        seconds=number["seconds"],
        mean_error=number["mean_error"],
        largest_error=number["largest_error"],
        missing=int(line["missing"]),
        failure=line["failure"],
    )


def renewed(old: list[Row], new: list[Row], surfaces: tuple[str, ...]) -> list[Row]:
    """Returns the old rows without those of a surface and size that is in `new`, and the new rows.

    The result is sorted by size, then by surface.
    """
    again = {(row.surface, row.size) for row in new}
    kept = [row for row in old if (row.surface, row.size) not in again]
    order = {surface: place for place, surface in enumerate(surfaces)}
    return sorted(kept + new, key=lambda row: (row.size, order.get(row.surface, len(order))))


def conditions(geosweep: Path) -> str:
    """Returns the machine and the versions, without names that identify the machine's owner."""
    version = subprocess.run(
        [geosweep, "--version"], check=True, capture_output=True, text=True
    ).stdout.strip()
    cores = len(os.sched_getaffinity(0))
    versions = ", ".join(f"{name} {found}" for name in PACKAGES if (found := _version(name)))
    return (
        f"Machine: {_cpu()}, {cores} cores, {platform.system()} on {platform.machine()}; "
        f"Python {platform.python_version()}.\n\nVersions: {version}, {versions}."
    )


def _version(package: str) -> str | None:
    try:
        return metadata.version(package)
    except metadata.PackageNotFoundError:
        return None


def _cpu() -> str:
    """Returns the processor's name, with family and model, which tell virtual processors apart."""
    fields = dict(
        re.findall(r"^(model name|cpu family|model)\s*:\s*(.*)$", _read("/proc/cpuinfo"), re.M)
    )
    name = fields.get("model name") or platform.processor() or "unknown processor"
    return (
        f"{name} (family {fields['cpu family']}, model {fields['model']})"
        if "model" in fields
        else name
    )


def _read(path: str) -> str:
    try:
        return Path(path).read_text()
    except OSError:
        return ""


def replace_between(page: Path, name: str, text: str) -> None:
    """Puts text between `<!-- NAME -->` and `<!-- end NAME -->`, which the page must have."""
    begin, end = f"<!-- {name} -->", f"<!-- end {name} -->"
    old = page.read_text()
    if begin not in old or end not in old:
        raise SystemExit(f"{page}: has no lines {begin} and {end} to write between")
    before, rest = old.split(begin, 1)
    page.write_text(f"{before}{begin}\n{text}\n{end}{rest.split(end, 1)[1]}")

#!/usr/bin/env python3
"""Compares times and errors of geosweep and other solvers on the same arrays, in one run.

    python benches/peers/compare.py --geosweep target/release/geosweep
    python benches/peers/compare.py --geosweep target/release/geosweep --docs

The first command prints tables. The second one also updates docs/peers.csv, where it replaces the rows
of the measured surfaces and sizes, and docs/figures/peers.md, where it replaces the summary of all rows of
docs/peers.csv, and the tables of terrain.py and paths.py.
"""

from __future__ import annotations

import argparse
import subprocess
import sys
import tempfile
from pathlib import Path

import paths
import references
import report
import terrain
from grids import Grid, errors
from measure import Failure, measure
from solvers import Exact, Place, geosweep_solvers, lacks, peers

SURFACES = ("plane", "sheared-plane@60", "sphere", "cylinder", "cone", "torus", "peaks", "maze")
ENGINES = ("cpu", "vulkan", "fast-marching")
ALL_CORES = "all cores"
DOCS = Path(__file__).resolve().parents[2] / "docs"


def main() -> None:
    options = arguments()
    rows = []
    with tempfile.TemporaryDirectory() as folder:
        for size in options.sizes:
            for surface in options.surfaces:
                rows += compare(surface, size, options, Path(folder))
    print(report.markdown(rows))
    if options.csv:
        report.write_csv(options.csv, rows)
    if options.docs:
        renew(options, rows)


def arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument(
        "--geosweep", type=Path, required=True, help="the tool, package geosweep-cli"
    )
    parser.add_argument(
        "--surfaces", type=words, default=SURFACES, help=f"default {','.join(SURFACES)}"
    )
    parser.add_argument("--sizes", type=numbers, default=[400], help="points a side, e.g. 400,1200")
    parser.add_argument(
        "--solvers", type=words, default=(), help="only those whose name contains one of these"
    )
    parser.add_argument(
        "--engines", type=words, default=ENGINES, help=f"of geosweep; default {','.join(ENGINES)}"
    )
    parser.add_argument(
        "--all-cores", action="store_true", help="geosweep's CPU engine on all cores too"
    )
    parser.add_argument("--repeats", type=int, default=5, help="solves of which the median counts")
    parser.add_argument(
        "--limit", type=float, default=120.0, help="seconds after which a solver is stopped"
    )
    parser.add_argument(
        "--exact-up-to",
        type=int,
        default=150,
        metavar="SIZE",
        help="run pygeodesic on grids up to this size; larger ones take minutes",
    )
    parser.add_argument(
        "--references", type=Path, help="folder with SURFACE-ROWSxCOLS.npy, exact distances"
    )
    parser.add_argument("--csv", type=Path, help="where to write the rows")
    parser.add_argument(
        "--docs", action="store_true", help="update docs/figures/peers.md and docs/peers.csv"
    )
    parser.add_argument(
        "--no-terrain", action="store_true", help="keep the page's tables of terrain (minutes)"
    )
    options = parser.parse_args()
    options.geosweep = options.geosweep.resolve()
    return options


def words(text: str) -> tuple[str, ...]:
    return tuple(text.split(","))


def numbers(text: str) -> list[int]:
    return [int(number) for number in text.split(",")]


def source_of(surface: str, size: int) -> Place:
    """Returns a source off the centre, as in `geosweep-lab accuracy`, or the maze's first point."""
    return (0, 0) if surface == "maze" else (round(0.31 * (size - 1)), round(0.41 * (size - 1)))


def compare(surface: str, size: int, options: argparse.Namespace, folder: Path) -> list[report.Row]:
    """Runs all solvers on one surface."""
    positions = folder / "positions.npy"
    subprocess.run(
        [options.geosweep, "builtin", f"{surface}:{size}x{size}", "-o", positions], check=True
    )
    source = source_of(surface, size)
    exact = references.exact(surface, Grid.load(positions).present, source, options.references)
    if exact is None:
        say(f"{surface}: left out, no exact distances; --references can give them")
        return []
    rows = []
    for name, make in chosen(surface, size, options).items():
        cores = 0 if "vulkan" in name or ALL_CORES in name else 1
        say(f"{surface} {size}: {name}")
        result = measure(make, positions, source, options.repeats, options.limit, cores)
        if isinstance(result, Failure):
            rows.append(report.Row(surface, size, name, failure=result.reason))
        else:
            found = errors(result.distances, exact)
            rows.append(
                report.Row(
                    surface,
                    size,
                    name,
                    set_up=result.set_up,
                    seconds=result.solve,
                    mean_error=found.mean,
                    largest_error=found.largest,
                    missing=found.missing,
                )
            )
    return rows


def chosen(surface: str, size: int, options: argparse.Namespace) -> dict:
    """Returns the solvers to run on a surface, by name."""
    found = {}
    ours = geosweep_solvers(options.geosweep, options.engines)
    if options.all_cores:
        ours |= {f"{name}, {ALL_CORES}": make for name, make in ours.items() if "cpu" in name}
    for name, make in (ours | peers()).items():
        solver = make()
        wanted = not options.solvers or any(part in name for part in options.solvers)
        too_slow = isinstance(solver, Exact) and size > options.exact_up_to
        if not wanted or too_slow or not solver.suits(surface):
            continue
        if missing := lacks(solver):
            say(f"{name}: left out, this Python has no module {missing}")
        else:
            found[name] = make
    return found


def renew(options: argparse.Namespace, rows: list[report.Row]) -> None:
    """Writes the measurements into the documentation."""
    page, figures = DOCS / "figures" / "peers.md", DOCS / "peers.csv"
    rows = report.renewed(report.read_csv(figures), rows, SURFACES)
    report.write_csv(figures, rows)
    report.replace_between(page, "conditions", report.conditions(options.geosweep))
    report.replace_between(page, "surfaces", report.summary(rows))
    if not options.no_terrain:
        report.replace_between(page, "terrain", terrain.study(options.geosweep))
        report.replace_between(page, "paths", paths.study(options.geosweep))


def say(text: str) -> None:
    print(text, file=sys.stderr, flush=True)


if __name__ == "__main__":
    main()

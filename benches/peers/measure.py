"""Runs one solver on one grid in a process of its own, so that none can hang or crash the rest."""

from __future__ import annotations

import importlib
import multiprocessing
import os
import statistics
import time
import traceback
from dataclasses import dataclass
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Callable

import numpy as np

from grids import Grid
from solvers import Place, Solver

# Libraries that would start threads read these when they are loaded.
THREADS = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "TBB_NUM_THREADS", "RAYON_NUM_THREADS")

# A solver is not asked again once its repeats have taken this long, in seconds.
LONG = 15.0


@dataclass(frozen=True)
class Result:
    """One solver on one grid: the map, and medians of its times in seconds."""

    distances: np.ndarray
    set_up: float
    solve: float
    repeats: int
    note: str = ""


@dataclass(frozen=True)
class Failure:
    """Why there is no map, in a few words."""

    reason: str


def measure(
    make: Callable[[], Solver], positions: Path, source: Place, repeats: int, limit: float, cores: int
) -> Result | Failure:
    """Prepares once and solves up to `repeats` times, on so many cores (0: all of them)."""
    context = multiprocessing.get_context("fork")
    receiver, sender = context.Pipe(duplex=False)
    child = context.Process(target=_child, args=(sender, make, positions, source, repeats, cores))
    child.start()
    sender.close()
    try:
        if not receiver.poll(limit):
            return Failure(f"not done in {limit:.0f} s")
        return receiver.recv()
    except EOFError:
        child.join()
        return Failure(f"crashed, exit status {child.exitcode}")
    finally:
        child.kill()
        child.join()


def _child(sender: Connection, make: Callable[[], Solver], positions: Path, source: Place, repeats: int, cores: int) -> None:
    try:
        if cores:
            _confine(cores)
        sender.send(_measure(make(), Grid.load(positions), source, repeats))
    except Exception as error:  # Whatever a peer raises is its result.
        traceback.print_exc()
        sender.send(Failure(f"{type(error).__name__}: {str(error).splitlines()[0] if str(error) else ''}"))
    sender.close()


def _confine(cores: int) -> None:
    """Leaves this process, and those it starts, so many cores and threads."""
    os.sched_setaffinity(0, sorted(os.sched_getaffinity(0))[-cores:])
    os.environ.update({name: str(cores) for name in THREADS})


def _measure(solver: Solver, grid: Grid, source: Place, repeats: int) -> Result:
    # No part of anyone's set-up: the triangles, which are given to all, and loading of modules.
    grid.faces
    for module in solver.needs:
        importlib.import_module(module)
    clock = time.perf_counter()
    solver.prepare(grid)
    prepared = time.perf_counter() - clock
    times: list[tuple[float, float]] = []
    began = time.perf_counter()
    for _ in range(repeats):
        clock = time.perf_counter()
        distances = solver.solve(source)
        around = time.perf_counter() - clock
        solve = around if solver.seconds is None else solver.seconds
        times.append((prepared if solver.set_up_seconds is None else solver.set_up_seconds, solve))
        if time.perf_counter() - began > LONG:
            break
    set_up, solve = (statistics.median(column) for column in zip(*times))
    return Result(distances, set_up, solve, len(times), solver.note)

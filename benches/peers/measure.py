"""Runs one solver on one grid in its own process, so that it cannot hang or crash the others."""

from __future__ import annotations

import importlib
import multiprocessing
import os
import resource
import statistics
import time
import traceback
from collections.abc import Callable
from dataclasses import dataclass
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Any

import numpy as np

from grids import Grid
from solvers import Place, Solver

# Libraries that start threads read these variables when they are loaded.
THREADS = (
    "OMP_NUM_THREADS",
    "OPENBLAS_NUM_THREADS",
    "MKL_NUM_THREADS",
    "TBB_NUM_THREADS",
    "RAYON_NUM_THREADS",
)

# The total time of repeats, in seconds, after which a solver is not run again.
LONG = 15.0


@dataclass(frozen=True)
class Result:
    """Result of one solver on one grid: the map, and medians of its times in seconds."""

    distances: np.ndarray
    set_up: float
    solve: float


@dataclass(frozen=True)
class Failure:
    """Reason why there is no map, in a few words."""

    reason: str


def measure(
    make: Callable[[], Solver],
    positions: Path,
    source: Place,
    repeats: int,
    limit: float,
    cores: int,
) -> Result | Failure:
    """Prepares once and solves up to `repeats` times, on `cores` cores (0: all of them)."""
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


def _child(
    sender: Connection,
    make: Callable[[], Solver],
    positions: Path,
    source: Place,
    repeats: int,
    cores: int,
) -> None:
    try:
        if cores:
            _confine(cores)
        sender.send(_measure(make(), Grid.load(positions), source, repeats, cores))
    except Exception as error:  # Any exception of a peer is its result.
        traceback.print_exc()
        sender.send(
            Failure(f"{type(error).__name__}: {str(error).splitlines()[0] if str(error) else ''}")
        )
    sender.close()


def _confine(cores: int) -> None:
    """Limits this process, and those that it starts, to `cores` cores and threads."""
    os.sched_setaffinity(0, sorted(os.sched_getaffinity(0))[-cores:])
    os.environ.update({name: str(cores) for name in THREADS})


def _measure(solver: Solver, grid: Grid, source: Place, repeats: int, cores: int) -> Result:
    # The triangles, which all solvers get, and the loading of modules do not count as set-up.
    _ = grid.faces
    for module in solver.needs:
        importlib.import_module(module)
    _, prepared = _timed(lambda: solver.prepare(grid), cores)
    times: list[tuple[float, float]] = []
    began = time.perf_counter()
    for _ in range(repeats):
        distances, call = _timed(lambda: solver.solve(source), cores)
        solve = call if solver.seconds is None else min(call, solver.seconds)
        times.append((prepared + (call - solve if solver.sets_up_each_time else 0.0), solve))
        if time.perf_counter() - began > LONG:
            break
    set_up, solve = (statistics.median(column) for column in zip(*times, strict=True))
    return Result(distances, set_up, solve)


def _timed(call: Callable[[], Any], cores: int) -> tuple[Any, float]:
    """Returns the result of a call, and the time that the call took.

    On one core this is the processor's time, which leaves out other work on the core but nothing of
    the call. On several cores the processor's time is the sum over the cores, so the clock is used.
    """
    clock, processor = time.perf_counter(), _processor_time()
    result = call()
    clock, processor = time.perf_counter() - clock, _processor_time() - processor
    return result, min(clock, processor) if cores == 1 else clock


def _processor_time() -> float:
    """Returns the processor time of this process and of the child processes it waited for."""
    children = resource.getrusage(resource.RUSAGE_CHILDREN)
    return time.process_time() + children.ru_utime + children.ru_stime

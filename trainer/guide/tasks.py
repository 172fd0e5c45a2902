"""Flights to be flown, on as many processors as there are, with the same result on any number."""

import multiprocessing
import os
from collections.abc import Callable, Iterable
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, replace
from functools import cache, partial
from pathlib import Path

from trainer.config import ConfigError
from trainer.fitout import Method
from trainer.study.manoeuvres.catalogue import within_limits
from trainer.study.manoeuvres.flight import Flight, Manoeuvre, fly
from trainer.study.manoeuvres.submarine import Rig, Submarine
from trainer.vessel_file import VesselFile, load_vessel

CHUNK = 6  # flights handed to a process at once


@dataclass(frozen=True)
class Task:
    """One flight to be flown."""

    manoeuvre: Manoeuvre
    speed: float  # [m/s]
    method: Method
    rig: Rig = Rig()
    zeroed: tuple[str, ...] = ()  # coefficients taken away


Flown = dict[Task, Flight | str]  # in words why there is no flight


def processors() -> int:
    """Return how many processors this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


@cache
def _vessel(path: Path) -> VesselFile:
    """Return the boat of a file, read once in each process."""
    return load_vessel(str(path))


def flown(path: Path, task: Task) -> Flight | str:
    """Return the flight of a task by the boat of that file, or why there is none."""
    file = _vessel(path)
    if task.zeroed:
        nothing = dict.fromkeys(task.zeroed, 0.0)
        file = replace(file, coefficients={**file.coefficients, **nothing})
    boat = Submarine(file, task.method, task.rig)
    try:
        return fly(boat, within_limits(task.manoeuvre, boat), task.speed)
    except ConfigError as wrong:
        return str(wrong)


def fly_all(
    path: Path, tasks: Iterable[Task], cores: int, step: Callable[[], None]
) -> Flown:
    """Return the flights of all ``tasks`` by the boat of a file; ``step`` is called after each.

    The first is flown here, so that machine code is there for the other processes to load.
    """
    wanted = list(dict.fromkeys(tasks))
    found: Flown = {}
    for task in wanted[:1] if cores > 1 else wanted:
        found[task] = flown(path, task)
        step()
    rest = [task for task in wanted if task not in found]
    if not rest:
        return found
    spawn = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(cores, mp_context=spawn) as pool:
        for task, flight in zip(
            rest, pool.map(partial(flown, path), rest, chunksize=CHUNK), strict=True
        ):
            found[task] = flight
            step()
    return found

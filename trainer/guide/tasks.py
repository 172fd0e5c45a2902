"""Flights to be flown, on as many processors as there are, with the same result on any number."""

import os
from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from functools import cache, partial
from pathlib import Path
from time import monotonic
from typing import Final

from trainer.config import ConfigError
from trainer.files.vessel_file import VesselFile, load_vessel
from trainer.fitout import Method
from trainer.study.manoeuvres.catalogue import within_limits
from trainer.study.manoeuvres.flight import Flight, Manoeuvre, fly
from trainer.study.manoeuvres.submarine import Rig, Submarine
from trainer.workers import workers

OWN: Final = Rig()
ALONE: Final = 4.0  # [s]
CHUNK: Final = 6  # flights handed to a process at once


@dataclass(frozen=True)
class Task:
    """One flight to be flown."""

    manoeuvre: Manoeuvre
    speed: float  # [m/s]
    method: Method
    rig: Rig = OWN
    zeroed: tuple[str, ...] = ()  # coefficients taken away
    beside: Method | None = None  # of a flight whose events it takes within a cycle, as Conn has it


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
    manoeuvre = within_limits(task.manoeuvre, boat)
    try:
        others: tuple[float | None, ...] = ()
        if task.beside:
            others = fly(Submarine(file, task.beside, task.rig), manoeuvre, task.speed).events
        return fly(boat, manoeuvre, task.speed, others)
    except ConfigError as wrong:
        return str(wrong)


def fly_all(path: Path, tasks: Iterable[Task], cores: int, step: Callable[[], None]) -> Flown:
    """Return the flights of all ``tasks`` by the boat of a file; ``step`` is called after each.

    Other processors are called in for what this one has not done in ALONE, which is about what
    starting them takes; they load the machine code that is there by then.
    """
    wanted = list(dict.fromkeys(tasks))
    found: Flown = {}
    begin = monotonic()
    for task in wanted:
        if cores > 1 and monotonic() - begin > ALONE:
            break
        found[task] = flown(path, task)
        step()
    rest = wanted[len(found) :]
    if rest:
        with workers(cores) as pool:
            flights = pool.map(partial(flown, path), rest, chunksize=CHUNK)
            for task, flight in zip(rest, flights, strict=True):
                found[task] = flight
                step()
    return found

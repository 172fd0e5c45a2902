"""The speed of many boats side by side, beside one alone, ours and in C.

What one thread does is measured by its own time, which others on the processor do not lengthen.
"""

import math
import subprocess
import sys
import time
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor, wait
from dataclasses import dataclass
from typing import Final

import numpy as np
from c_twin.compiler import BUILDS, build
from helpers.places import tests_environment

from trainer.analysis.bench.standard_hour import TickRunner, for_level, levels_here
from trainer.analysis.bench.tick import STANDARD_METHOD, in_a_loop, ready_boat
from trainer.analysis.fleet.ensemble import NO_ORDERS, Ensemble, fly_members
from trainer.boat.boat import Boat
from trainer.boat.export.targets import NoCompilerError
from trainer.config.files import ConfigError
from trainer.config.vessel import VesselFile, load_vessel

FEW, MANY = 1024, 65536  # boats
TICKS: Final = 120  # of a flight
ALONE: Final = 20_000  # [ticks] of one boat
FLIGHTS: Final = 9  # the fastest counts: interference only slows
THREADS: Final = 2
IN_A_ROW: Final = 10  # flights of a thread: to wake one takes a good part of a flight
Clock = Callable[[], float]  # [s]
CHILD: Final = """
import sys
from bench.fleet import few_per_s
print(few_per_s(sys.argv[1]))
"""


@dataclass(frozen=True)
class SideBySide:
    """Boat-ticks a second [1/s], a flight of ``ticks_a_flight`` each, by one thread or as said."""

    vessel: str
    ticks_a_flight: int
    alone_per_s: float  # one boat, in a compiled loop
    c_per_s: float | None  # the same in C, by gcc -O3; None without a compiler
    few_boats: int
    few_per_s: float
    levels_per_s: dict[str, float]  # the few, compiled for a level of processor
    many_boats: int
    many_per_s: float
    threads: int
    threads_per_s: float  # so many threads, each with few boats
    many_of_few: float
    threads_of_one: float


def fleet_of(boat: Boat, members: int) -> Ensemble:
    """Return so many of a boat as it is. Each has a depth and a course to keep."""
    states = np.repeat(boat.records.state, members)
    states["ordered_depth"] += np.linspace(-10.0, 10.0, members)
    states["ordered_psi"] += np.linspace(-1.0, 1.0, members)
    return Ensemble(boat.records.vessel, boat.records.compact, boat.records.scheme, states)


def flight_of(boat: Boat, members: int) -> Callable[[], None]:
    """Return what flies so many of a boat on for TICKS."""
    fleet = fleet_of(boat, members)

    def fly() -> None:
        fly_members(fleet, NO_ORDERS, TICKS, TICKS, ("z",))

    return fly


def alone_of(boat: Boat, ticks: TickRunner) -> Callable[[], None]:
    """Return what takes ALONE ticks of one boat."""

    def run() -> None:
        ticks(boat.records, ALONE)

    return run


def fastest_s(works: Sequence[Callable[[], object]], clock: Clock) -> list[float]:
    """Return the least time [s] of each of ``works``.

    They take turns. The first runs do not count.
    """
    least = [math.inf for _ in works]
    for flight in range(1 + FLIGHTS):
        for place, work in enumerate(works):
            begun = clock()
            work()
            taken = clock() - begun
            if flight > 0:
                least[place] = min(least[place], taken)
    return least


def under_way(file: VesselFile) -> Boat:
    """Return a boat that keeps depth and course in a calm, by these equations."""
    boat = ready_boat(file, STANDARD_METHOD, file.run.step_s)
    boat.state.trim_by_hand = 1.0  # with water on the move it would fly alone
    return boat


def few_per_s(vessel: str) -> float:
    """Return the boat-ticks a second [1/s] of few boats, compiled as this process compiles."""
    [taken] = fastest_s([flight_of(under_way(load_vessel(vessel)), FEW)], time.thread_time)
    return FEW * TICKS / taken


def level_per_s(file: VesselFile, level: str) -> float:
    """Return the same, compiled for a level of processor; ConfigError if that fails."""
    done = subprocess.run(
        [sys.executable, "-c", CHILD, str(file.path)],
        env=tests_environment(**for_level(level)),
        capture_output=True,
        text=True,
        check=False,
    )
    if done.returncode != 0:
        raise ConfigError(f"boats side by side failed for {level}: {done.stderr.strip()}")
    return float(done.stdout)


def c_per_s(file: VesselFile) -> float | None:
    """Return the ticks a second [1/s] of one boat in plain C. None without a compiler."""
    try:
        ticks = build(BUILDS[0])
    except NoCompilerError:
        return None
    [taken] = fastest_s([alone_of(under_way(file), ticks)], time.thread_time)
    return ALONE / taken


def in_a_row(flight: Callable[[], None]) -> Callable[[], None]:
    """Return what flies IN_A_ROW such flights."""

    def fly() -> None:
        for _ in range(IN_A_ROW):
            flight()

    return fly


def threads_s(file: VesselFile) -> tuple[float, float]:
    """Return the time [s] of few boats' flights, and of more in THREADS.

    There are as many in each.
    """
    one, *beside = (in_a_row(flight_of(under_way(file), FEW)) for _ in range(1 + THREADS))
    with ThreadPoolExecutor(THREADS) as pool:

        def at_once() -> None:
            wait([pool.submit(flight) for flight in beside])

        single, together = fastest_s([one, at_once], time.perf_counter)
    return single, together


def time_side_by_side(file: VesselFile) -> SideBySide:
    """Return the rates of a boat, and of fleets of it."""
    boat = under_way(file)
    few, many = flight_of(boat, FEW), flight_of(boat, MANY)
    alone_s, few_s, many_s = fastest_s([alone_of(boat, in_a_loop), few, many], time.thread_time)
    single, together = threads_s(file)
    return SideBySide(
        vessel=file.name,
        ticks_a_flight=TICKS,
        alone_per_s=ALONE / alone_s,
        c_per_s=c_per_s(file),
        few_boats=FEW,
        few_per_s=FEW * TICKS / few_s,
        levels_per_s={level: level_per_s(file, level) for level in levels_here()},
        many_boats=MANY,
        many_per_s=MANY * TICKS / many_s,
        threads=THREADS,
        threads_per_s=THREADS * IN_A_ROW * FEW * TICKS / together,
        many_of_few=(MANY / many_s) / (FEW / few_s),
        threads_of_one=THREADS * single / together,
    )


def lines(figures: SideBySide) -> list[str]:
    """Return the figures as lines of a page."""
    other = figures.c_per_s or figures.alone_per_s
    few = figures.few_boats

    def row(name: str, rate: float, note: str) -> str:
        return f"  {name:<34}{rate / 1e6:>9.2f}{rate / other:>16.2f}   {note}".rstrip()

    unit = "in C" if figures.c_per_s else "alone"
    found = [
        "",
        f"BOATS SIDE BY SIDE (calm, modified lagged adams2, {figures.ticks_a_flight} ticks)",
        f"  {'million boat-ticks a second':<34}{'':>9}{'of one ' + unit:>16}",
        row("one, in a compiled loop", figures.alone_per_s, ""),
    ]
    if figures.c_per_s:
        found.append(row("one, in C, gcc -O3", figures.c_per_s, ""))
    threads = f"{figures.threads} threads of {few}"
    return [
        *found,
        row(f"{few}", figures.few_per_s, ""),
        *(row(f"{few}, for {name}", rate, "") for name, rate in figures.levels_per_s.items()),
        row(f"{figures.many_boats}", figures.many_per_s, f"{figures.many_of_few:.0%} of {few}"),
        row(threads, figures.threads_per_s, f"{figures.threads_of_one:.2f} of one"),
    ]

"""What a tick costs each of many boats flown side by side, against one boat in a compiled loop."""

import math
import time
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor, wait
from dataclasses import dataclass
from typing import Final

import numpy as np

from trainer.boat import Boat
from trainer.core.ensemble import Fleet
from trainer.study.fleet import NO_ORDERS, fly_members
from trainer.study.hot import take_ticks

FEW, MANY = 1024, 65536  # boats
TICKS: Final = 120  # of a flight
ALONE: Final = 20_000  # [ticks] of one boat
FLIGHTS: Final = 9  # the fastest counts: interference only slows
THREADS: Final = 2


@dataclass(frozen=True)
class SideBySide:
    """Boat-ticks a second [1/s], in one thread but for the last."""

    alone_per_s: float  # one boat, in a compiled loop
    few_boats: int
    few_per_s: float
    many_boats: int
    many_per_s: float
    threads: int
    threads_per_s: float  # so many threads, each with few boats
    few_times_the_alone: float
    many_of_few_percent: float
    threads_times_the_one: float


def fleet_of(boat: Boat, members: int) -> Fleet:
    """Return so many of a boat as she is, each with a depth and a course of her own to keep."""
    states = np.repeat(boat.records.state, members)
    states["ordered_depth"] += np.linspace(-10.0, 10.0, members)
    states["ordered_psi"] += np.linspace(-1.0, 1.0, members)
    return Fleet(boat.records.vessel, boat.records.compact, boat.records.scheme, states)


def flight_of(boat: Boat, members: int) -> Callable[[], None]:
    """Return what flies so many of a boat on for TICKS."""
    fleet = fleet_of(boat, members)

    def fly() -> None:
        fly_members(fleet, NO_ORDERS, TICKS, TICKS, ("z",))

    return fly


def alone_of(boat: Boat) -> Callable[[], None]:
    """Return what advances one boat by ALONE ticks in a compiled loop."""
    vessel, compact, scheme, state, scratch = boat.records

    def loop() -> None:
        take_ticks(vessel, compact, scheme, ALONE, state, scratch)

    return loop


def fastest_s(works: Sequence[Callable[[], object]], clock: Callable[[], float]) -> list[float]:
    """Return the least time [s] of each of ``works`` by a clock [s], the first run left out."""
    least = [math.inf for _ in works]
    for flight in range(1 + FLIGHTS):
        for place, work in enumerate(works):
            begun = clock()
            work()
            taken = clock() - begun
            if flight > 0:
                least[place] = min(least[place], taken)
    return least


def time_side_by_side(boat: Boat) -> SideBySide:
    """Return the rates of a boat that is under way, and of fleets of her as she is now.

    What one thread does is measured by its own time, which others on the processor do not lengthen.
    """
    few, many = flight_of(boat, FEW), flight_of(boat, MANY)
    alone_s, few_s, many_s = fastest_s([alone_of(boat), few, many], time.thread_time)
    beside = [flight_of(boat, FEW) for _ in range(THREADS)]
    with ThreadPoolExecutor(THREADS) as pool:
        one_s, both_s = fastest_s(
            [few, lambda: wait([pool.submit(flight) for flight in beside])], time.perf_counter
        )
    alone, of_few, of_many = ALONE / alone_s, FEW * TICKS / few_s, MANY * TICKS / many_s
    return SideBySide(
        alone_per_s=alone,
        few_boats=FEW,
        few_per_s=of_few,
        many_boats=MANY,
        many_per_s=of_many,
        threads=THREADS,
        threads_per_s=THREADS * FEW * TICKS / both_s,
        few_times_the_alone=of_few / alone,
        many_of_few_percent=100.0 * of_many / of_few,
        threads_times_the_one=THREADS * one_s / both_s,
    )

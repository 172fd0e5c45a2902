"""The tick is timed against plain C and against the interpreter, in one run.

Ratios are medians over pairs of short batches, one right after the other, so that a busy machine
disturbs both alike. Each tick's boat is its own, in the same sea, keeping depth and course.
"""

import statistics
import subprocess
import sys
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import Final

from bench.batches import SEA_NAME, Voyage, time_repetitions
from bench.standard_hour import TickRunner
from helpers.loops import in_a_loop
from helpers.places import tests_environment

from c_twin.compiler import BUILDS, build, version
from trainer.analysis.bench.ticks import STANDARD_METHOD, ready_boat
from trainer.boat.boat import Boat
from trainer.config.boat.vessel import VesselFile, load_vessel
from trainer.config.files import ConfigError
from trainer.config.world.sea import load_sea

TICKS: Final = 4000  # in a batch
PAIRS: Final = 101
SLOW_TICKS: Final = 400  # of the interpreter
CHILD: Final = """
import sys
from c_twin.comparison import interpreted_ns
print(interpreted_ns(sys.argv[1]))
"""


@dataclass(frozen=True)
class Against:
    """The trainer's tick against one other."""

    other: str
    flags: str
    tick_ns: float  # the least, as in the others: interference only adds
    other_ns: float
    median_ratio: float  # of the trainer's to the other's


@dataclass(frozen=True)
class AgainstC:
    """The trainer's tick against the others."""

    vessel: str
    sea: str
    compiler: str
    pairs: int
    ticks_a_batch: int
    in_a_sea: tuple[Against, ...]
    in_a_calm: tuple[Against, ...]
    interpreted_ns: float
    times_interpreted: float  # least over least


def under_way(file: VesselFile, sea: str) -> Boat:
    """Return a boat keeping depth and course in a sea."""
    boat = ready_boat(file, STANDARD_METHOD, file.run.step_s)
    boat.put_to_sea(load_sea(sea))
    return boat


def batch(boat: Boat, take: TickRunner) -> Callable[[int], None]:
    """Return what takes so many ticks of a boat put back before."""
    return Voyage.of(boat, partial(take, boat.records))


def time_pair(
    work: Callable[[int], None], other: Callable[[int], None]
) -> tuple[float, float, float]:
    """Return the least times [ns] of two works' ticks, and their batches' median ratio."""
    for each in (work, other):
        time_repetitions(each, TICKS)
    pairs = [(time_repetitions(work, TICKS), time_repetitions(other, TICKS)) for _ in range(PAIRS)]
    ones, others = zip(*pairs, strict=True)
    ratio = statistics.median(one / another for one, another in pairs)
    return min(ones) / TICKS, min(others) / TICKS, ratio


def against(file: VesselFile, sea: str, ticks: list[TickRunner]) -> tuple[Against, ...]:
    """Return the tick in a sea against each of the builds in C."""
    found = []
    for way, take in zip(BUILDS, ticks, strict=True):
        one, other, ratio = time_pair(
            batch(under_way(file, sea), in_a_loop), batch(under_way(file, sea), take)
        )
        found.append(Against(way.name, " ".join(way.flags), one, other, ratio))
    return tuple(found)


def interpreted_ns(vessel: str) -> float:
    """Return the time [ns] of a tick in a sea, by this process's core."""
    run = batch(under_way(load_vessel(vessel), SEA_NAME), in_a_loop)
    return min(time_repetitions(run, SLOW_TICKS) for _ in range(3)) / SLOW_TICKS


def without_jit(file: VesselFile) -> float:
    """Return the time [ns] of a tick in a sea by a Python without JIT. ConfigError if it fails."""
    done = subprocess.run(
        [sys.executable, "-c", CHILD, str(file.path)],
        env=tests_environment(NUMBA_DISABLE_JIT="1"),
        capture_output=True,
        text=True,
        check=False,
    )
    if done.returncode != 0:
        raise ConfigError(f"the tick without JIT failed: {done.stderr.strip()}")
    return float(done.stdout)


def against_c(file: VesselFile) -> AgainstC:
    """Return the tick against C and the interpreter; NoCompilerError without a C compiler."""
    ticks = [build(way) for way in BUILDS]
    at_sea, calm = against(file, SEA_NAME, ticks), against(file, "calm", ticks)
    slow = without_jit(file)
    return AgainstC(
        vessel=file.name,
        sea=SEA_NAME,
        compiler=version(),
        pairs=PAIRS,
        ticks_a_batch=TICKS,
        in_a_sea=at_sea,
        in_a_calm=calm,
        interpreted_ns=slow,
        times_interpreted=slow / min(each.tick_ns for each in at_sea),
    )


def lines(figures: AgainstC) -> list[str]:
    """Return the figures as lines of a page."""
    found = [
        "",
        f"AGAINST PLAIN C ({figures.compiler})",
        f"  median of {figures.pairs} pairs of batches of {figures.ticks_a_batch} ticks",
    ]
    for title, rows in ((figures.sea, figures.in_a_sea), ("calm", figures.in_a_calm)):
        found.append(f"  {title:<34}{'ours [ns]':>11}{'C [ns]':>9}{'ratio':>8}")
        found += [
            f"    {row.other:<32}{row.tick_ns:>11.0f}{row.other_ns:>9.0f}{row.median_ratio:>8.2f}"
            for row in rows
        ]
    slow = f"{figures.interpreted_ns / 1e3:.0f} us a tick"
    return [
        *found,
        *(f"  {row.other}: {row.flags}" for row in figures.in_a_sea),
        f"  interpreted {slow}: {figures.times_interpreted:.0f} times",
    ]

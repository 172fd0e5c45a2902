"""One hour is the same everywhere, in every way of this machine.

However the tick is computed, compiled or interpreted, for whatever processor, the hour ends in the
same bits; ``digest`` is their name. Orders are carried out by the helm, between ticks, on the
records themselves. ``python -m tests.bench --same-bits`` flies it in each way.
"""

import hashlib
import os
import subprocess
import sys
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Final

import click
from helpers.loops import in_a_loop

from trainer.boat.assemble import Method, Records
from trainer.boat.boat import Boat
from trainer.boat.due_orders import obey_all, orders_due
from trainer.boat.export.targets import NATIVE_NAME, find_processor
from trainer.boat.machine_code import way_name
from trainer.boat.platforms import PROCESSOR_LEVELS
from trainer.config.boat.vessel import load_vessel
from trainer.config.files import ConfigError
from trainer.config.world.sea import load_sea
from trainer.debrief.marks.rehearsal import stretches
from trainer.io.orders.schedule import BadSchedule, ScheduledOrder, parse_schedule
from trainer.units import KNOT

VESSEL_PATH: Final = Path(__file__).with_name("standard_boat.toml")
HOUR_METHOD: Final = Method("modified", "lagged", "exact", "adams2", 0.5)
START_SPEED_KN: Final = 10.0  # [kn]
START_DEPTH_M: Final = 60.0  # [m]
SEA_NAME: Final = "sea-state-5"
HOUR_SEED: Final = 1969  # of the sea; it stays, so that digests of old and new cores compare
HOUR_TICKS: Final = 7200  # [ticks] of half a second
HOUR_ORDERS: Final = """
60 depth 90
120 course 075
300 pump trim forward 4
400 speed 14
500 casualty rudder-slow 0.7 ramp 30
600 course left 120
800 clear rudder-slow
900 casualty stern-stuck
1000 clear stern-stuck
1100 sea state 3
1200 casualty leak-auxiliary ramp 20
1300 pump auxiliary 3
1400 clear leak-auxiliary
1500 rudder right 5
1530 course 030
1600 speed 2
1700 depth 40
1800 hover on
2000 flood depth-control 2
2100 hover off
2200 speed 8
2300 casualty gyro-biased
2400 periscope depth
2700 emergency blow
2800 blow stop
3000 compressor on
3100 dive
3200 depth 50
3400 planes manual
3450 planes auto
"""

TickRunner = Callable[[Records, int], int]  # so many ticks of a boat; the status of the last
CHILD_PROGRAM: Final = """
from helpers.loops import in_a_loop
from bench.standard_hour import digest, fly_standard_hour
print(digest(fly_standard_hour(in_a_loop, {last})))
"""


def orders() -> list[ScheduledOrder]:
    """Return what is ordered in the hour, by time."""
    schedule = parse_schedule(HOUR_ORDERS, "the standard hour")
    if isinstance(schedule, BadSchedule):
        raise TypeError(str(schedule))
    return schedule


def standard_boat() -> Boat:
    """Return the boat at the start of the hour."""
    boat = Boat(load_vessel(str(VESSEL_PATH)), HOUR_METHOD)
    boat.start(START_SPEED_KN * KNOT, START_DEPTH_M, 0.0, HOUR_SEED)
    boat.put_to_sea(load_sea(SEA_NAME))
    return boat


def fly_standard_hour(take: TickRunner, last: int = HOUR_TICKS) -> Boat:
    """Return the boat after the hour, its ticks taken by ``take``. Up to tick ``last`` if sooner.

    RuntimeError if an order is refused or the boat loses its numbers.
    """
    boat = standard_boat()
    due = orders_due(boat, orders())
    for tick, until in stretches(0, last, due):
        for words, why in obey_all(boat, due.get(tick, ())):
            raise RuntimeError(f"{words}: {why}")
        if status := take(boat.records, until - tick):
            raise RuntimeError(boat.failure(status))
    return boat


def digest(boat: Boat) -> str:
    """Return the SHA-256 of the whole state."""
    return hashlib.sha256(boat.records.state.tobytes()).hexdigest()


@dataclass(frozen=True)
class SameBits:
    """In what bits the standard hour ends."""

    ticks: int
    sha256: dict[str, str]  # by how it was computed
    same: bool


def in_another_process(environment: dict[str, str], last: int = HOUR_TICKS) -> str:
    """Return the digest of the hour up to ``last``, computed with other numba settings.

    ConfigError if it fails.
    """
    done = subprocess.run(
        [sys.executable, "-c", CHILD_PROGRAM.format(last=last)],
        env=os.environ | environment | {"PYTHONPATH": str(Path(__file__).parents[1])},
        capture_output=True,
        text=True,
        check=False,
    )
    if done.returncode != 0:
        raise ConfigError(f"the standard hour failed under {environment}: {done.stderr.strip()}")
    return done.stdout.strip()


def levels_here() -> list[str]:
    """Return the processor levels whose machine code this processor can run."""
    here = set(find_processor(NATIVE_NAME).needs)
    return [level for level, flags in PROCESSOR_LEVELS.items() if here.issuperset(flags)]


def for_level(level: str) -> dict[str, str]:
    """Return the settings that let numba compile for a level of processor."""
    return {"NUMBA_CPU_NAME": level, "NUMBA_CPU_FEATURES": "+sse2"}


def fly_hour(take: TickRunner, last: int = HOUR_TICKS) -> str:
    """Return the digest of the hour up to ``last``, its ticks taken by ``take``."""
    return digest(fly_standard_hour(take, last))


def ways(last: int = HOUR_TICKS) -> dict[str, Callable[[], str]]:
    """Return how to compute the hour up to ``last``, by name."""
    interpreted = {"NUMBA_DISABLE_JIT": "1"}
    return {
        way_name(): partial(fly_hour, in_a_loop, last),
        "interpreted": partial(in_another_process, interpreted, last),
        **{level: partial(in_another_process, for_level(level), last) for level in levels_here()},
    }


def same_bits(ways: Mapping[str, Callable[[], str]]) -> SameBits:
    """Return in what bits the hour ends in each of these ways."""
    digests: dict[str, str] = {}
    quiet = not sys.stderr.isatty()
    with click.progressbar(ways.items(), label="an hour", file=sys.stderr, hidden=quiet) as bar:
        for name, way in bar:
            digests[name] = way()
    return SameBits(HOUR_TICKS, digests, len(set(digests.values())) == 1)


def lines(figures: SameBits) -> list[str]:
    """Return the answer as lines of a page."""
    same = f"the same bits in all {len(figures.sha256)} ways"
    answer = same if figures.same else "NOT THE SAME BITS"
    return [
        "",
        f"STANDARD HOUR ({figures.ticks} ticks; SHA-256 of the whole state): {answer}",
        *(f"  {name:<32}{sha256[:32]}" for name, sha256 in figures.sha256.items()),
    ]

"""The standard hour in every way of this machine, with one set of bits.

A part of ``trainer dev bench``: compiled and interpreted runs, a fleet, other processors' machine
code end in the same state bit by bit, or the bench says which does not.
"""

import os
import subprocess
import sys
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial
from typing import Final

import click
import numpy as np

from trainer.analysis.bench.standard_hour import HOUR_TICKS, TickRunner, digest, fly_standard_hour
from trainer.analysis.bench.tick import in_a_loop
from trainer.analysis.fleet.ensemble import NO_ORDERS, Fleet, fly_members
from trainer.boat.assemble import Records
from trainer.boat.export.targets import NATIVE_NAME, find_processor
from trainer.boat.machine_code import way_name
from trainer.boat.platforms import PROCESSOR_LEVELS
from trainer.config.files import ConfigError

FLEET_MEMBERS: Final = 17  # a full block of LANE_COUNT boats, and one boat that begins the next
CHILD_PROGRAM: Final = """
from trainer.analysis.bench.tick import in_a_loop
from trainer.analysis.bench.standard_hour import digest, fly_standard_hour
print(digest(fly_standard_hour(in_a_loop, {last})))
"""


@dataclass(frozen=True)
class SameBits:
    """In what bits the standard hour ends."""

    ticks: int
    sha256: dict[str, str]  # by how it was computed
    same: bool


def in_a_fleet(records: Records, count: int) -> int:
    """Take ``count`` ticks as the last member of a fleet. Return 1 where any member is lost.

    A fleet flies a member alone where side by side cannot compute it, such as in a sea. The test
    covers that too.
    """
    vessel, compact, scheme, state, _ = records
    fleet = Fleet(vessel, compact, scheme, np.repeat(state, FLEET_MEMBERS))
    lost = fly_members(fleet, NO_ORDERS, count, max(count, 1), ()).lost
    state[:] = fleet.states[-1:]
    return int((lost >= 0).any())


def in_another_process(environment: dict[str, str], last: int = HOUR_TICKS) -> str:
    """Return the digest of the hour up to ``last``, computed with other numba settings.

    ConfigError if it fails.
    """
    done = subprocess.run(  # noqa: S603
        [sys.executable, "-c", CHILD_PROGRAM.format(last=last)],
        env=os.environ | environment,
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
        f"in a fleet of {FLEET_MEMBERS}": partial(fly_hour, in_a_fleet, last),
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

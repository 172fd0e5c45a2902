"""The worth of a compact set: its differences, its cost, each coefficient's effect.

``reduction`` asks for it, of a set just found or of the one in the file, and ``page`` prints it. A
set that passes flies like the full one for a fraction of its work in each tick.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from time import perf_counter_ns
from typing import Final

import numpy as np

from trainer.analysis.guide import verdicts
from trainer.analysis.guide.programme import Leg, fly_all, guide_legs
from trainer.analysis.guide.reasons import DropEffect, MeasureNames, drop_effects, tasks_without
from trainer.analysis.guide.verdicts import BEYOND_TOLERANCE, NOT_DETERMINED, allowed_multiple
from trainer.analysis.manoeuvres.vehicle import ALLOWED_PERCENT
from trainer.analysis.reduce.objective import Candidate, Yardstick
from trainer.analysis.reduce.programme import flyable_legs, holdout_legs, turn_legs
from trainer.boat.assemble import Method
from trainer.boat.boat import Boat
from trainer.config.files import ConfigError
from trainer.config.vessel import VesselFile
from trainer.core.entry import LOOKOUT, ROW_COLUMNS, sail
from trainer.core.terms import COEFFICIENTS
from trainer.units import KNOT

PART_TOLERANCES: Final = {  # [%] of change allowed, [s] of zero crossings
    "guide": ALLOWED_PERCENT,
    "steady turns": ALLOWED_PERCENT,
    "held out": 2.0 * ALLOWED_PERCENT,
}
TIMED_TICKS: Final = 2000  # [ticks] timed at once, long against the resolution of the clock
TIMING_REPEATS: Final = 7  # of which the fastest counts: other programs only add to the time
DEEP_WATER_M: Final = 1000.0  # [m]
SENSITIVITY_MEASURES: Final[MeasureNames] = {
    "turn": ("steady diameter", "steady speed", "largest roll"),
    "meander": ("pitch peak 1", "damping ratio"),
    "overshoot": ("largest pitch", "depth change"),
    "roll-decay": ("period", "amplitude after cycle 1"),
}


@dataclass(frozen=True)
class LegVerdict:
    """One leg by the compact set."""

    part: str
    leg: str
    judged: int  # numbers; none where the full set cannot start or is lost
    beyond: int
    worst: float  # [-] of what is allowed
    quantity: str  # that is the worst
    undetermined: tuple[str, ...] = ()  # beyond, but not determined by the hull: not judged

    @property
    def passed(self) -> bool | None:
        """Return whether nothing judged is beyond what is allowed; None: nothing is judged."""
        return not self.beyond if self.judged else None


def verdict_legs(file: VesselFile, part: str) -> Sequence[Leg]:
    """Return the legs of a part of the verdict."""
    if part == "guide":
        return guide_legs(file)
    return flyable_legs(file, turn_legs(file)) if part == "steady turns" else holdout_legs(file)


def judge_legs(file: VesselFile, candidate: Candidate) -> tuple[LegVerdict, ...]:
    """Return every leg of every part judged."""
    return tuple(one for part in PART_TOLERANCES for one in _part(file, part, candidate))


def _part(file: VesselFile, part: str, candidate: Candidate) -> Iterator[LegVerdict]:
    """Yield the legs of one part."""
    share = PART_TOLERANCES[part] / ALLOWED_PERCENT
    wanted = verdict_legs(file, part)
    yardstick = Yardstick(file, wanted)
    for leg in wanted:
        if leg not in yardstick.legs:
            yield LegVerdict(part, leg.title, 0, 0, 0.0, "")
    for leg, judgements in yardstick.judged(candidate, share):
        if not judgements:
            yield LegVerdict(part, leg.title, 1, 1, float("inf"), "it cannot start")
            continue
        judged = [one for one in judgements if one.allowed]
        lost = [one for one in judgements if one.verdict == BEYOND_TOLERANCE and not one.allowed]
        sizes = {one.quantity: abs(allowed_multiple(one)) / share for one in judged}
        sizes |= {one.quantity: float("inf") for one in lost}
        worst = max(sizes, key=lambda name: sizes[name], default="")
        beyond = sum(size > 1.0 for size in sizes.values())
        apart = tuple(one.quantity for one in judgements if one.verdict == NOT_DETERMINED)
        yield LegVerdict(part, leg.title, len(sizes), beyond, sizes.get(worst, 0.0), worst, apart)


def passes_legs(checked: Sequence[LegVerdict]) -> bool:
    """Return whether something is judged, and nothing beyond what is allowed."""
    return verdicts.passes_all([one.passed for one in checked])


@dataclass(frozen=True)
class TickCost:
    """The least time of a tick, the whole boat's, back to back."""

    full_ns: float
    compact_ns: float

    @property
    def ratio(self) -> float:
        """Return the compact set's cost as a share of the full set's."""
        return self.compact_ns / self.full_ns


def measure_cost(file: VesselFile) -> TickCost | None:
    """Return the cost of a tick, full set exact, compact lagged. None of a boat that cannot start.

    Both sets are integrated by Adams, at the boat's own step and speed.
    """
    try:
        full, compact = (
            _nanoseconds(file, Method(equations, rates, "exact", "adams2", file.run.step_s))
            for equations, rates in (("full", "exact"), ("modified", "lagged"))
        )
    except ConfigError:
        return None
    return TickCost(full, compact)


def _nanoseconds(file: VesselFile, method: Method) -> float:
    """Return the least time [ns] of a tick."""
    boat = Boat(file, method)
    eye = np.zeros(1, LOOKOUT)
    eye["last"], eye["steepest"] = 1e18, 10.0
    rows = np.empty((TIMED_TICKS, ROW_COLUMNS))
    least = float("inf")
    for _ in range(TIMING_REPEATS):
        boat.start(file.run.start_speed_kn * KNOT, DEEP_WATER_M, 0.0)
        begin = perf_counter_ns()
        flown = sail(boat.records, eye, rows)
        least = min(least, (perf_counter_ns() - begin) / max(flown, 1))
    return least


def hull_coefficients(file: VesselFile) -> tuple[str, ...]:
    """Return the coefficients that this hull has."""
    return tuple(term.key for term in COEFFICIENTS if file.coefficients[term.key])


def flight_count(file: VesselFile) -> int:
    """Return how many flights the table takes."""
    return len(set(tasks_without(file, hull_coefficients(file), SENSITIVITY_MEASURES)))


def effect_table(file: VesselFile, cores: int, step: Callable[[], None]) -> tuple[DropEffect, ...]:
    """Return the effect [%] of each coefficient at zero in the full set, largest first."""
    wanted = tasks_without(file, hull_coefficients(file), SENSITIVITY_MEASURES)
    flown = fly_all(file.path, wanted, cores, step)
    return drop_effects(file, flown, hull_coefficients(file), SENSITIVITY_MEASURES)

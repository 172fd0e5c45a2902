"""Measures of a record: what a value is, and why there is none.

``tallies`` counts most measures tick by tick, some from columns that are made here of several of
the state. What is told of people, ships and the ground beside the boat's numbers is measured here:
both judges (``scoring`` of a whole record, ``ticks/judge``) write those values into their tallies.
"""

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, fields
from functools import partial
from typing import Final

import numpy as np

from trainer.boat.boat import Boat
from trainer.boat.depths import lowest_depth
from trainer.boat.limits import FULL_BALLAST_SHARE
from trainer.boat.world.bottom import ground_under
from trainer.config.exercise.exercise import ExerciseLimits
from trainer.config.exercise.score_rules import AIR_BANKS, MeasuredQuantity, ScoreRule
from trainer.core.ballast.tanks import BANKS
from trainer.core.kernel import Numbers
from trainer.debrief.passage.ships_met import ContactReport, LookOut
from trainer.debrief.passage.trajectory import (
    QUANTITY_FUNCTIONS,
    Trajectory,
    missing_quantities,
)
from trainer.session.stations.alerts import SEEN_RANKS, Alert

NO_TEST_DEPTH: Final = "this boat has no test depth"
PLANE_NAMES: Final = ("stern", "bow")
NEAREST_RANGE: Final = "cpa_m"  # of the nearest ship
LIMIT_QUANTITIES: Final[Mapping[str, MeasuredQuantity]] = {  # by the keys of an exercise's limits
    "depth_m": MeasuredQuantity("depth", "m", 1.0),
    "pitch_deg": MeasuredQuantity("pitch", "deg", float(np.radians(1.0))),
    "heel_deg": MeasuredQuantity("heel", "deg", float(np.radians(1.0))),
    "speed_kn": MeasuredQuantity("speed", "kn", 1852.0 / 3600.0),
    "clearance_m": MeasuredQuantity("clearance", "m", 1.0),
    "speed_over_ground_kn": MeasuredQuantity("speed_over_ground", "kn", 1852.0 / 3600.0),
}
FALSE_MARK_PENALTY_S: Final = 30.0  # [s] for each mark of a ship where none was seen

IsLookedAt = Callable[[int], bool]  # of a tick, by a rule


@dataclass(frozen=True)
class Measurement:
    """The value of a measure, or the reason why there is none."""

    value: float | None
    tick: int | None  # where in the record
    why: str = ""
    counts: bool = True  # a value that lacks by the crew's own doing earns nothing
    beyond_record: bool = False  # it lacks because the record ends before what is looked at


def lacking(boat: Boat, rule: ScoreRule) -> str:
    """Return what a boat lacks that a rule is about, in words, "" for nothing."""
    if missing := missing_quantities(boat, rule):
        return f"this boat has no {missing[0]}"
    measure = rule.score.measure
    if measure == "aground" and ground_under(boat) is None:
        return "there is no ground here"
    if measure.endswith("beyond-test-depth") and boat.file.hull.test_depth_m is None:
        return NO_TEST_DEPTH
    if measure == "reserve-air" and not full_air(boat, air_banks(rule)):
        return "this boat has no air banks"
    return ""


def air_banks(rule: ScoreRule) -> tuple[str, ...]:
    """Return the banks of air that a rule looks at."""
    return (rule.measured.name,) if rule.measured else AIR_BANKS


def full_air(boat: Boat, banks: Iterable[str]) -> float:
    """Return the air [kg] of full banks."""
    full = boat.vessel.bank_full
    return sum(float(full[BANKS.index(name.removeprefix("bank_"))]) for name in banks)


def air_share(banks: tuple[str, ...], trajectory: Trajectory) -> Numbers:
    """Return the air in some banks [%] of full at each tick."""
    air = sum(trajectory.columns[name] for name in banks)
    return 100.0 * np.asarray(air / full_air(trajectory.boat, banks))


def hull_depth(trajectory: Trajectory) -> Numbers:
    """Return the depth [m] of the hull's lowest point at each tick."""
    column = trajectory.columns
    return lowest_depth(column["z"], column["theta"], trajectory.boat.file.hull.length)


def over_test_depth(trajectory: Trajectory) -> Numbers:
    """Return how far [m] the hull is beyond test depth, 0 within it.

    While the depth is frozen the boat is not beyond it.
    """
    beyond = hull_depth(trajectory) - (trajectory.boat.file.hull.test_depth_m or math.inf)
    return np.where(trajectory.columns["held_depth"] == 0.0, np.maximum(beyond, 0.0), 0.0)


def surfacing(trajectory: Trajectory) -> Numbers:
    """Return 1 at ticks at which main ballast is being blown, or blown."""
    vessel, column = trajectory.boat.vessel, trajectory.columns
    if not vessel.fitted:
        return np.zeros(trajectory.ticks.size)
    tanks = ("forward", "mid", "aft")
    held = sum(column[f"water_{name}"] for name in tanks)
    blown = sum(column[f"blow_{name}"] for name in tanks)
    full = held >= FULL_BALLAST_SHARE * float(vessel.capacity[:3].sum())
    return np.where(full & (np.asarray(blown) <= 0.0), 0.0, 1.0)


AIR_COLUMNS: Final = {banks: f"air {' '.join(banks)}" for banks in (*zip(AIR_BANKS), AIR_BANKS)}
MADE_COLUMNS: Final[Mapping[str, Callable[[Trajectory], Numbers]]] = {  # of several of the state
    **QUANTITY_FUNCTIONS,
    **{name: partial(air_share, banks) for banks, name in AIR_COLUMNS.items()},
    "hull_depth": hull_depth,
    "over_test_depth": over_test_depth,
    "surfacing": surfacing,
}


def measure_detection(
    look_out_report: LookOut, is_looked_at: IsLookedAt, rule: ScoreRule, step: float
) -> Measurement:
    """Return the mean time [s] to mark a ship, with ticks of ``step`` [s].

    The mean, because each ship is to earn its own part. A time counts from the rule's ``full`` to
    its ``zero``, and a ship not marked as ``zero``. Each mark that meant no ship adds
    FALSE_MARK_PENALTY_S to their sum.
    """
    ships = [each for each in look_out_report.ships if is_looked_at(each.there)]
    if not ships:
        return Measurement(None, None, "no ship came in sight", counts=False)
    score = rule.score
    times = [
        math.inf if each.seen is None or each.marked is None else step * (each.marked - each.seen)
        for each in ships
    ]
    missed = [each for each in ships if each.marked is None]
    if len(missed) == len(ships):
        names = " and ".join(each.name for each in ships)
        unmarked = f"{names} {'were' if len(ships) > 1 else 'was'} not marked"
        seen = any(each.seen is not None for each in ships)
        why = unmarked if seen else f"nobody looked for {names}"
        return Measurement(None, ships[0].there, why)
    wrong = sum(map(is_looked_at, look_out_report.false))
    low, high = sorted((score.full, score.zero))
    value = float(np.clip(times, low, high).mean()) + FALSE_MARK_PENALTY_S * wrong / len(ships)
    slowest = ships[int(np.argmax(times))]
    return Measurement(value, slowest.there if slowest.marked is None else slowest.marked)


def measure_report(
    shown: int | None, reports: Sequence[tuple[ContactReport, bool]], step: float
) -> Measurement:
    """Return the time [s] from a periscope's first look to a right report of contacts.

    ``shown`` is the tick of that look; each report has with it whether a ship was close.
    """
    if shown is None:
        return Measurement(None, None, "nobody looked")
    told = [(each, close) for each, close in reports if each.tick >= shown]
    right = [each.tick for each, close in told if not (each.none and close)]
    if not right:
        why = "a ship was close" if told else "contacts were not reported"
        return Measurement(None, shown, why)
    return Measurement((right[0] - shown) * step, right[0])


def measure_alerts(
    alerts: Iterable[Alert], is_looked_at: IsLookedAt, rule: ScoreRule, step: float, end: int
) -> Measurement:
    """Return the mean time [s] from an alert to its acknowledgement.

    An alert that a graver one of its kind has replaced is owed none, nor one that came so late that
    the record ends, at the tick ``end``, before the rule's ``zero``.
    """
    score = rule.score
    low, high = sorted((score.full, score.zero))
    times: list[tuple[float, int]] = []
    for alert in alerts:
        named = alert.rank in SEEN_RANKS and score.rank in (None, alert.rank.value)
        if not named or not is_looked_at(alert.raised.tick) or (alert.seen and not alert.seen_by):
            continue
        answered = alert.seen.tick if alert.seen else None
        if answered is not None or (end - alert.raised.tick) * step >= high:
            late = high if answered is None else (answered - alert.raised.tick) * step
            times.append((min(max(late, low), high), answered or alert.raised.tick))
    if not times:
        return Measurement(None, None, "no such alert came", counts=False)
    return Measurement(math.fsum(late for late, _ in times) / len(times), max(times)[1])


def measure_groundings(faults: Iterable[int], is_looked_at: IsLookedAt) -> Measurement:
    """Return how often the boat was aground, of the ticks of its faults."""
    ticks = [tick for tick in faults if is_looked_at(tick)]
    return Measurement(float(len(ticks)), ticks[0] if ticks else None)


def limits_of(limits: ExerciseLimits) -> list[str]:
    """Return the limits that an exercise sets, by their keys."""
    names = [item.name for item in fields(limits)]
    known = [
        name for name in names if name.rpartition("_")[0] in (*LIMIT_QUANTITIES, NEAREST_RANGE)
    ]
    return [name for name in known if getattr(limits, name) is not None]

"""Measures: what can be judged in a passage, each one number and its place in the record.

A measure is a function of the passage, of the rows that its rule looks at (one at least), and of
the rule. Numbers are in the unit of the quantity where a rule names one.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, fields
from typing import Final

import numpy as np

from trainer.analysis.debrief.episodes import answer_to, spells
from trainer.analysis.debrief.trajectory import Rows, Trajectory
from trainer.boat.limits import COVERED, FULL
from trainer.config.score_rules import Measured, Rule
from trainer.core.ballast.tanks import BANKS
from trainer.core.kernel import Numbers
from trainer.core.sea.free_surface import DECK_REACH

PLANES: Final = ("stern", "bow")
LIMITED: Final[Mapping[str, Measured]] = {  # by the keys of an exercise's limits
    "depth_m": Measured("depth", "m", 1.0),
    "pitch_deg": Measured("pitch", "deg", float(np.radians(1.0))),
    "heel_deg": Measured("heel", "deg", float(np.radians(1.0))),
    "speed_kn": Measured("speed", "kn", 1852.0 / 3600.0),
}


@dataclass(frozen=True)
class Attained:
    """What a measure has come to; without a value it says why."""

    value: float | None
    tick: int | None  # where in the record
    why: str = ""
    counts: bool = True  # a value that lacks by the crew's own doing earns nothing


def overshoot(passage: Trajectory, rows: Rows, rule: Rule) -> Attained:
    """Return how far the quantity went beyond its target, seen from where it began."""
    beyond = _off(passage, rows, rule)
    beyond = -beyond if beyond[0] > 0.0 else beyond  # now from below
    if beyond.max() < -(rule.score.band or 0.0):
        return Attained(None, None, "the target was never reached")
    furthest = int(np.argmax(beyond))
    return Attained(max(float(beyond[furthest]), 0.0), int(passage.ticks[rows][furthest]))


def time_to(passage: Trajectory, rows: Rows, rule: Rule) -> Attained:
    """Return the time [s] until the quantity is in its band for good."""
    outside = np.flatnonzero(~_inside(passage, rows, rule))
    ticks = passage.ticks[rows]
    first = int(outside[-1]) + 1 if outside.size else 0
    if first == ticks.size:
        return Attained(None, None, "not in the band at the end")
    seconds = float(ticks[first] - ticks[0]) * passage.boat.method.step
    return Attained(seconds, int(ticks[first]))


def rms(passage: Trajectory, rows: Rows, rule: Rule) -> Attained:
    """Return the root of the mean square distance from the target."""
    off = _off(passage, rows, rule)
    worst = int(np.argmax(np.abs(off)))
    return Attained(float(np.sqrt(np.mean(off * off))), int(passage.ticks[rows][worst]))


def in_band(passage: Trajectory, rows: Rows, rule: Rule) -> Attained:
    """Return the share [%] of the ticks at which the quantity is in its band."""
    worst = int(np.argmax(np.abs(_off(passage, rows, rule))))
    share = 100.0 * float(np.mean(_inside(passage, rows, rule)))
    return Attained(share, int(passage.ticks[rows][worst]))


def highest(passage: Trajectory, rows: Rows, rule: Rule) -> Attained:
    """Return the greatest value of the quantity; of a depth the deepest."""
    return _extreme(passage, rows, _quantity(passage, rows, rule), np.argmax)


def lowest(passage: Trajectory, rows: Rows, rule: Rule) -> Attained:
    """Return the smallest value of the quantity."""
    return _extreme(passage, rows, _quantity(passage, rows, rule), np.argmin)


def largest(passage: Trajectory, rows: Rows, rule: Rule) -> Attained:
    """Return the quantity at its largest either way, without its sign."""
    return _extreme(passage, rows, np.abs(_quantity(passage, rows, rule)), np.argmax)


def activity(passage: Trajectory, rows: Rows, rule: Rule) -> Attained:
    """Return how far the surfaces are moved [deg/min], both pairs of planes if none is named."""
    named = (rule.measured.name,) if rule.measured else PLANES
    moved = np.zeros(passage.ticks.size)
    for surface in filter(passage.has, named):
        angle = np.degrees(passage.series(surface))
        moved[1:] += np.abs(np.diff(angle))
    both = rows & np.concatenate(([False], rows[:-1]))  # from one row looked at to the next
    seconds = float(np.sum(np.diff(passage.seconds)[both[1:]]))
    if not seconds:
        return Attained(None, None, "a single moment", counts=False)
    fastest = int(np.argmax(np.where(both, moved, -1.0)))
    return Attained(60.0 * float(moved[both].sum()) / seconds, int(passage.ticks[fastest]))


def distance(passage: Trajectory, rows: Rows, _rule: Rule) -> Attained:
    """Return the distance [m] run over the ground."""
    run = np.hypot(np.diff(passage.columns["x"]), np.diff(passage.columns["y"]))
    return Attained(float(run[rows[1:] & rows[:-1]].sum()), int(passage.ticks[rows][-1]))


def broaches(passage: Trajectory, rows: Rows, _rule: Rule) -> Attained:
    """Return how often sail or deck came out of the sea without main ballast being blown."""
    found = [row for row in broached(passage) if rows[row]]
    return Attained(float(len(found)), int(passage.ticks[found[0]]) if found else None)


def beyond_limits(passage: Trajectory, rows: Rows, _rule: Rule) -> Attained:
    """Return the time [s] at which any limit of the exercise was passed."""
    beyond = np.any([passed(passage, name) for name in limits_of(passage)], axis=0) & rows
    first = np.flatnonzero(beyond)
    seconds = float(beyond.sum()) * passage.boat.method.step
    return Attained(seconds, int(passage.ticks[first[0]]) if first.size else None)


def response(passage: Trajectory, _rows: Rows, rule: Rule) -> Attained:
    """Return the time [s] from the casualty's first onset to the crew's answer."""
    kind = rule.casualty.kind if rule.casualty else ""
    spell = next((each for each in spells(passage) if each.kind == kind), None)
    if spell is None:
        return Attained(None, None, "it did not happen", counts=False)
    answer = answer_to(passage, spell, rule.score.orders)
    if answer is None:
        return Attained(None, None, "it was not answered")
    return Attained((answer.tick - spell.begun) * passage.boat.method.step, answer.tick)


def reserve_air(passage: Trajectory, rows: Rows, rule: Rule) -> Attained:
    """Return the least share [%] left in the bank named, or else in all together."""
    vessel = passage.boat.vessel
    names = (rule.measured.name,) if rule.measured else tuple(f"bank_{name}" for name in BANKS)
    full = sum(float(vessel.bank_full[BANKS.index(name.removeprefix("bank_"))]) for name in names)
    if not full:
        return Attained(None, None, "this boat has no air banks", counts=False)
    left = sum(passage.columns[name] for name in names) / full
    return _extreme(passage, rows, 100.0 * np.asarray(left)[rows], np.argmin)


def limits_of(passage: Trajectory) -> list[str]:
    """Return the limits that the exercise sets, by their keys."""
    names = [item.name for item in fields(passage.limits)]
    return [name for name in names if getattr(passage.limits, name) is not None]


def passed(passage: Trajectory, name: str) -> Rows:
    """Return at which ticks a limit of the exercise is passed."""
    key, _, end = name.rpartition("_")
    value, limit = passage.measured(LIMITED[key]), getattr(passage.limits, name)
    value = np.abs(value) if key in ("pitch_deg", "heel_deg") else value
    beyond: Rows = value > limit if end == "max" else value < limit
    return beyond


def showing(passage: Trajectory) -> Numbers:
    """Return the height [m] of the highest part of sail and deck above the sea."""
    vessel, column = passage.boat.vessel, passage.columns
    sine, cosine = np.sin(column["theta"]), np.cos(column["theta"])
    upright = cosine * np.cos(column["phi"])
    reach = DECK_REACH * float(vessel.ell)
    points = (
        (float(vessel.x_sail), float(vessel.z_sail)),
        (reach, float(vessel.z_deck)),
        (-reach, float(vessel.z_deck)),
    )
    lifted: Numbers = np.max([x * sine - z * upright for x, z in points], axis=0)
    return lifted - column["z"] - column["eta_wave"]


def surfacing(passage: Trajectory) -> Rows:
    """Return at which ticks main ballast is being blown, or blown."""
    vessel, column = passage.boat.vessel, passage.columns
    if not vessel.fitted:
        return np.zeros(passage.ticks.size, bool)
    tanks = ("forward", "mid", "aft")
    held = sum(column[f"water_{name}"] for name in tanks)
    blown = sum(column[f"blow_{name}"] for name in tanks)
    return np.asarray((held < FULL * float(vessel.capacity[:3].sum())) | (np.asarray(blown) > 0.0))


def broached(passage: Trajectory) -> list[int]:
    """Return the rows at which she broached, as the watch calls it out."""
    height, meant = showing(passage), surfacing(passage)
    shows, found = bool(height[0] > 0.0), []
    for row in range(1, height.size):
        if not shows and height[row] > 0.0 and not meant[row]:
            found.append(row)
        shows = bool(height[row] > (-COVERED if shows else 0.0))
    return found


def _quantity(passage: Trajectory, rows: Rows, rule: Rule) -> Numbers:
    assert rule.measured  # noqa: S101 (checked when the rule was read)
    return passage.measured(rule.measured)[rows]


def _off(passage: Trajectory, rows: Rows, rule: Rule) -> Numbers:
    assert rule.measured  # noqa: S101
    return passage.off(rule.measured, rule.score.target)[rows]


def _inside(passage: Trajectory, rows: Rows, rule: Rule) -> Rows:
    return np.abs(_off(passage, rows, rule)) <= (rule.score.band or 0.0)


def _extreme(
    passage: Trajectory, rows: Rows, values: Numbers, furthest: Callable[[Numbers], np.intp]
) -> Attained:
    place = int(furthest(values))
    return Attained(float(values[place]), int(passage.ticks[rows][place]))

"""Measures of a passage: each is one number and its place in the record.

A passage is what was flown to the end of a branch of a recording (``trajectory``); ``scoring``
calls a measure by its name. It is a function of the passage, of the rows that its rule looks at
(one at least), and of the rule. Numbers are in the unit of the quantity where a rule names one.
"""

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, fields
from typing import Final

import numpy as np

from trainer.boat.depths import lowest_depth
from trainer.boat.limits import FULL_BALLAST_SHARE, RECALL_COVER_M
from trainer.config.exercise.score_rules import MeasuredQuantity, ScoreRule
from trainer.core.ballast.tanks import BANKS
from trainer.core.kernel import Numbers
from trainer.core.surfaces import SURFACES
from trainer.debrief.passage.episodes import answer_to, first_spell
from trainer.debrief.passage.groundings import groundings
from trainer.debrief.passage.ships_met import (
    ContactReport,
    LookOut,
    look_out,
    meet_ships,
    reports_near_ships,
    shown_rows,
)
from trainer.debrief.passage.trajectory import RowMask, Trajectory, shown_height
from trainer.session.stations.alerts import SEEN_RANKS

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
HELD_TIME_S: Final = 30.0  # [s] in the band from which a target counts as reached
SLIP_COST: Final = 3.0  # [s] of them for each second outside; an estimate
EDGE_SHARE: Final = 0.5  # of a band, outside it, over which being there fades; an estimate
SETTLING_WINDOW_S: Final = 120.0  # [s] of a window, in which the boat has to have settled


@dataclass(frozen=True)
class Measurement:
    """The value of a measure, or the reason why there is none."""

    value: float | None
    tick: int | None  # where in the record
    why: str = ""
    counts: bool = True  # a value that lacks by the crew's own doing earns nothing
    beyond_record: bool = False  # it lacks because the record ends before what is looked at


def overshoot(trajectory: Trajectory, rows: RowMask, rule: ScoreRule) -> Measurement:
    """Return how far the quantity went beyond its target, seen from where it began."""
    beyond = _off(trajectory, rows, rule)
    beyond = -beyond if beyond[0] > 0.0 else beyond  # now from below
    if beyond.max() < -(rule.score.band or 0.0):
        return Measurement(None, None, "the target was never reached")
    furthest = int(np.argmax(beyond))
    return Measurement(max(float(beyond[furthest]), 0.0), int(trajectory.ticks[rows][furthest]))


def time_to(trajectory: Trajectory, rows: RowMask, rule: ScoreRule) -> Measurement:
    """Return the time [s] until the quantity is in its band, held for HELD_TIME_S.

    Each second outside takes SLIP_COST of those held, because else a slip of one tick would cost
    all, and a crew that swings through its band would be there. A quantity that begins in its band
    first has to leave it. Where the window ends too soon, it has to stay there to the end.
    """
    inside, ticks = _inside(trajectory, rows, rule), trajectory.ticks[rows]
    outside = np.flatnonzero(~inside)
    if not outside.size:
        return Measurement(0.0, int(ticks[0]))
    step, left = trajectory.boat.method.step, int(outside[0])
    # ticks held, which count up inside the band, down outside it, and never below zero
    sums = np.cumsum(np.where(inside[left:], 1.0, -SLIP_COST))
    held = sums - np.minimum(np.minimum.accumulate(sums), 0.0)
    needed = math.ceil(HELD_TIME_S / step - 1e-9)
    reached = np.flatnonzero(held > needed)
    if reached.size:
        # counted back from the tick at which enough were held
        there = max(int(reached[0]) - needed, 0)
        entered = left + int(reached[0]) - np.argmax(held[reached[0] :: -1] == 0.0) + 1
        return Measurement(there * step, int(ticks[entered]))
    first = int(outside[-1]) + 1
    if first == ticks.size:
        if (late := _time_at_pace(trajectory, rows, rule)) is not None:
            return Measurement(late, int(ticks[-1]))
        beyond = abs(float(_off(trajectory, rows, rule)[-1])) - (rule.score.band or 0.0)
        unit = rule.measured.unit if rule.measured else ""
        far = f"{float(f'{beyond:.2g}'):g} {unit}"  # two digits that count
        return Measurement(None, None, f"not in the band at the end, {far} beyond it")
    return Measurement(float(ticks[first] - ticks[0]) * step, int(ticks[first]))


def _time_at_pace(trajectory: Trajectory, rows: RowMask, rule: ScoreRule) -> float | None:
    """Return the time [s] to the band at the mean pace of a window that ended before.

    None where the quantity came no nearer, or the record ends with the window.
    """
    off, band = np.abs(_off(trajectory, rows, rule)), rule.score.band or 0.0
    if rows[-1] or off[-1] >= off[0]:
        return None
    seconds = float(np.ptp(trajectory.ticks[rows])) * trajectory.boat.method.step
    return seconds * float((off[0] - band) / (off[0] - off[-1]))


def reach(trajectory: Trajectory, rows: RowMask, rule: ScoreRule) -> Measurement:
    """Return what ``time_to`` does. A quantity that began in its band has no such time."""
    if _inside(trajectory, rows, rule)[0]:
        return _near_at_order(rule)
    return time_to(trajectory, rows, rule)


def _near_at_order(rule: ScoreRule) -> Measurement:
    """Return that there was no way to go, whether the boat lay there or only passed by."""
    unit = rule.measured.unit if rule.measured else ""
    band = f"{rule.score.band or 0.0:g} {unit}".rstrip()
    return Measurement(None, None, f"already within {band} of it when it was ordered")


def settled(trajectory: Trajectory, rows: RowMask, rule: ScoreRule) -> Measurement:
    """Return the share [%] of the last seconds in the band, having been outside."""
    if _inside(trajectory, rows, rule)[0]:
        return _near_at_order(rule)
    seconds = trajectory.seconds
    return in_band(trajectory, rows & (seconds >= seconds[rows][-1] - SETTLING_WINDOW_S), rule)


def final(trajectory: Trajectory, rows: RowMask, rule: ScoreRule) -> Measurement:
    """Return the quantity at the last of the rows, or its distance from its target."""
    if rule.score.target is None:
        value = float(_quantity(trajectory, rows, rule)[-1])
    else:
        value = abs(float(_off(trajectory, rows, rule)[-1]))
    return Measurement(value, int(trajectory.ticks[rows][-1]))


def rms(trajectory: Trajectory, rows: RowMask, rule: ScoreRule) -> Measurement:
    """Return the root of the mean square distance from the target."""
    if rule.conditions and rows.sum() < _fewest_rows(trajectory):
        return Measurement(None, None, f"{rule.score.when} for less than {HELD_TIME_S:g} s")
    off = _off(trajectory, rows, rule)
    worst = int(np.argmax(np.abs(off)))
    return Measurement(float(np.sqrt(np.mean(off * off))), int(trajectory.ticks[rows][worst]))


def in_band(trajectory: Trajectory, rows: RowMask, rule: ScoreRule) -> Measurement:
    """Return the share [%] of the ticks at which the quantity is in its band.

    A tick outside counts by how near it is, down to nothing at EDGE_SHARE of the band beyond it:
    else the last centimetre would decide over a boat that lies at the edge all the time.

    Where the rule's condition holds for less than HELD_TIME_S (in a short record a quarter of the
    record), the share is of HELD_TIME_S and not of those ticks: to meet the condition for a moment
    and be in the band then is next to nothing.
    """
    off, band = np.abs(_off(trajectory, rows, rule)), rule.score.band or 0.0
    inside = np.clip(1.0 - (off - band) / (EDGE_SHARE * band), 0.0, 1.0)
    few = _fewest_rows(trajectory) if rule.conditions else 1
    share = 100.0 * float(inside.sum()) / max(inside.size, few)
    return Measurement(share, int(trajectory.ticks[rows][np.argmax(off)]))


def _fewest_rows(trajectory: Trajectory) -> int:
    """Return for how many rows a condition has to hold, that it is more than a moment."""
    return min(round(HELD_TIME_S / trajectory.boat.method.step), trajectory.ticks.size // 4)


def highest(trajectory: Trajectory, rows: RowMask, rule: ScoreRule) -> Measurement:
    """Return the greatest value of the quantity; of a depth the deepest."""
    return _extreme(trajectory, rows, _quantity(trajectory, rows, rule), np.argmax)


def lowest(trajectory: Trajectory, rows: RowMask, rule: ScoreRule) -> Measurement:
    """Return the smallest value of the quantity."""
    return _extreme(trajectory, rows, _quantity(trajectory, rows, rule), np.argmin)


def largest(trajectory: Trajectory, rows: RowMask, rule: ScoreRule) -> Measurement:
    """Return the quantity, or its distance from the target, at its largest either way."""
    away = rule.score.target is not None
    values = _off(trajectory, rows, rule) if away else _quantity(trajectory, rows, rule)
    return _extreme(trajectory, rows, np.abs(values), np.argmax)


def activity(trajectory: Trajectory, rows: RowMask, rule: ScoreRule) -> Measurement:
    """Return the travel of the surfaces [deg/min]. Without a name it is both pairs of planes."""
    named = (rule.measured.name,) if rule.measured else PLANE_NAMES
    return _travel(trajectory, rows, dict.fromkeys(named, rows))


def hand_travel(trajectory: Trajectory, rows: RowMask, _rule: ScoreRule) -> Measurement:
    """Return the travel [deg/min] of planes and rudder while each was worked by hand."""
    by_hand = {name: trajectory.columns[f"{name}_by_hand"] != 0.0 for name in SURFACES}
    return _travel(trajectory, rows, by_hand)


def _travel(trajectory: Trajectory, rows: RowMask, moving: Mapping[str, RowMask]) -> Measurement:
    """Return the travel [deg/min] of surfaces, each at the rows at which it counts."""
    moved = np.zeros(trajectory.ticks.size)
    for surface in filter(trajectory.has, moving):
        angle = np.degrees(trajectory.series(surface))
        moved[1:] += np.where(moving[surface][1:], np.abs(np.diff(angle)), 0.0)
    both = rows & np.concatenate(([False], rows[:-1]))  # from one row looked at to the next
    seconds = float(np.sum(np.diff(trajectory.seconds)[both[1:]]))
    if not seconds:
        return Measurement(None, None, "a single moment", counts=False)
    fastest = int(np.argmax(np.where(both, moved, -1.0)))
    return Measurement(60.0 * float(moved[both].sum()) / seconds, int(trajectory.ticks[fastest]))


def distance(trajectory: Trajectory, rows: RowMask, _rule: ScoreRule) -> Measurement:
    """Return the distance [m] run over the ground."""
    run = np.hypot(np.diff(trajectory.columns["x"]), np.diff(trajectory.columns["y"]))
    return Measurement(float(run[rows[1:] & rows[:-1]].sum()), int(trajectory.ticks[rows][-1]))


def closest_approach(trajectory: Trajectory, rows: RowMask, _rule: ScoreRule) -> Measurement:
    """Return the least range [m] to any ship."""
    nearest = meet_ships(trajectory).nearest[rows]
    if not np.isfinite(nearest).any():
        return Measurement(None, None, "there was no ship", counts=False)
    return _extreme(trajectory, rows, nearest, np.argmin)


def exposed(trajectory: Trajectory, rows: RowMask, _rule: ScoreRule) -> Measurement:
    """Return the time [s] for which the periscope's head was out of the water."""
    return _time_in(trajectory, shown_rows(trajectory)[0] & rows)


def exposed_raise(trajectory: Trajectory, rows: RowMask, rule: ScoreRule) -> Measurement:
    """Return the time [s] of the raise that showed longest."""
    raises = shown_rows(trajectory)[1]
    each = [exposed(trajectory, rows & (raises == one), rule) for one in np.unique(raises)]
    return max(each, key=lambda attained: attained.value or 0.0)


def time_to_detect(trajectory: Trajectory, rows: RowMask, rule: ScoreRule) -> Measurement:
    """Return the mean time [s] from a ship in sight to its mark.

    The mean, because each ship is to earn its own part. A time counts from the rule's ``full`` to
    its ``zero``, and a ship not marked as ``zero``. Each mark that meant no ship adds
    FALSE_MARK_PENALTY_S to their sum.
    """
    ticks = set(trajectory.ticks[rows].tolist())
    step = trajectory.boat.method.step
    return measure_detection(look_out(trajectory), ticks.__contains__, rule, step)


def measure_detection(
    look_out_report: LookOut, is_looked_at: Callable[[int], bool], rule: ScoreRule, step: float
) -> Measurement:
    """Return the same of what a look-out saw; ``step`` is that of a tick [s]."""
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


def time_to_report(trajectory: Trajectory, rows: RowMask, _rule: ScoreRule) -> Measurement:
    """Return the time [s] from a periscope's first look to a right report of contacts."""
    shown, ticks = np.flatnonzero(shown_rows(trajectory)[0] & rows), trajectory.ticks
    first = int(ticks[shown[0]]) if shown.size else None
    return measure_report(first, reports_near_ships(trajectory), trajectory.boat.method.step)


def measure_report(
    shown: int | None, reports: Sequence[tuple[ContactReport, bool]], step: float
) -> Measurement:
    """Return the same of a first look, and reports with whether a ship was close."""
    if shown is None:
        return Measurement(None, None, "nobody looked")
    told = [(each, close) for each, close in reports if each.tick >= shown]
    right = [each.tick for each, close in told if not (each.none and close)]
    if not right:
        why = "a ship was close" if told else "contacts were not reported"
        return Measurement(None, shown, why)
    return Measurement((right[0] - shown) * step, right[0])


def broaches(trajectory: Trajectory, rows: RowMask, _rule: ScoreRule) -> Measurement:
    """Return how often sail or deck left the sea without a main ballast blow."""
    return _count_in(trajectory, rows, broach_rows(trajectory))


def aground(trajectory: Trajectory, rows: RowMask, _rule: ScoreRule) -> Measurement:
    """Return how often the boat was aground, where it was not laid down well."""
    if not trajectory.has("clearance"):
        return Measurement(None, None, "there is no ground here", counts=False)
    at_fault = (each.row for each in groundings(trajectory) if each.at_fault)
    return _count_in(trajectory, rows, at_fault)


def beyond_limits(trajectory: Trajectory, rows: RowMask, _rule: ScoreRule) -> Measurement:
    """Return the time [s] at which any limit of the exercise was passed."""
    beyond = (
        np.any([rows_beyond(trajectory, name) for name in limits_of(trajectory)], axis=0) & rows
    )
    return _time_in(trajectory, beyond)


def beyond_test_depth(trajectory: Trajectory, rows: RowMask, _rule: ScoreRule) -> Measurement:
    """Return the most [m] of the hull's lowest point beyond test depth."""
    beyond = depth_beyond(trajectory)
    if beyond is None:
        return Measurement(None, None, NO_TEST_DEPTH, counts=False)
    if not np.any(beyond[rows] > 0.0):
        return Measurement(0.0, None)
    return _extreme(trajectory, rows, beyond[rows], np.argmax)


def time_beyond_test_depth(trajectory: Trajectory, rows: RowMask, _rule: ScoreRule) -> Measurement:
    """Return the time [s] of the hull's lowest point beyond test depth."""
    beyond = depth_beyond(trajectory)
    if beyond is None:
        return Measurement(None, None, NO_TEST_DEPTH, counts=False)
    return _time_in(trajectory, (beyond > 0.0) & rows)


def response(trajectory: Trajectory, _rows: RowMask, rule: ScoreRule) -> Measurement:
    """Return the time [s] from the casualty's first onset to the crew's answer."""
    episode = first_spell(trajectory, rule.casualty)
    if episode is None:
        return Measurement(None, None, "it did not happen", counts=False)
    answer = answer_to(trajectory, episode, rule.score.orders)
    if answer is None:
        return Measurement(None, None, "it was not answered")
    return Measurement((answer.tick - episode.begun) * trajectory.boat.method.step, answer.tick)


def alert_response(trajectory: Trajectory, rows: RowMask, rule: ScoreRule) -> Measurement:
    """Return the mean time [s] from an alert to its acknowledgement.

    An alert that a graver one of its kind has replaced is owed none, nor one that came so late that
    the record ends before the rule's ``zero``.
    """
    step, score, end = trajectory.boat.method.step, rule.score, int(trajectory.ticks[-1])
    low, high = sorted((score.full, score.zero))
    looked_at = set(trajectory.ticks[rows].tolist())
    times: list[tuple[float, int]] = []
    for alert in trajectory.alerts:
        named = alert.rank in SEEN_RANKS and score.rank in (None, alert.rank.value)
        if not named or alert.raised.tick not in looked_at or (alert.seen and not alert.seen_by):
            continue
        answered = alert.seen.tick if alert.seen else None
        if answered is not None or (end - alert.raised.tick) * step >= high:
            late = high if answered is None else (answered - alert.raised.tick) * step
            times.append((min(max(late, low), high), answered or alert.raised.tick))
    if not times:
        return Measurement(None, None, "no such alert came", counts=False)
    return Measurement(math.fsum(late for late, _ in times) / len(times), max(times)[1])


def reserve_air(trajectory: Trajectory, rows: RowMask, rule: ScoreRule) -> Measurement:
    """Return the least share [%] of air left in the named bank, or in all."""
    vessel = trajectory.boat.vessel
    names = (rule.measured.name,) if rule.measured else tuple(f"bank_{name}" for name in BANKS)
    full = sum(float(vessel.bank_full[BANKS.index(name.removeprefix("bank_"))]) for name in names)
    if not full:
        return Measurement(None, None, "this boat has no air banks", counts=False)
    air_shares = sum(trajectory.columns[name] for name in names) / full
    return _extreme(trajectory, rows, 100.0 * np.asarray(air_shares)[rows], np.argmin)


def limits_of(trajectory: Trajectory) -> list[str]:
    """Return the limits that the exercise sets, by their keys."""
    names = [item.name for item in fields(trajectory.limits)]
    known = [
        name for name in names if name.rpartition("_")[0] in (*LIMIT_QUANTITIES, NEAREST_RANGE)
    ]
    return [name for name in known if getattr(trajectory.limits, name) is not None]


def rows_beyond(trajectory: Trajectory, name: str) -> RowMask:
    """Return at which ticks a limit of the exercise is passed."""
    beyond: RowMask = excess_beyond(trajectory, name) > 0.0
    return beyond


def excess_beyond(trajectory: Trajectory, name: str) -> Numbers:
    """Return how far a limit is passed at each tick, in its unit."""
    key, _, end = name.rpartition("_")
    limit = getattr(trajectory.limits, name)
    value = (
        meet_ships(trajectory).nearest
        if key == NEAREST_RANGE
        else trajectory.measured(LIMIT_QUANTITIES[key])
    )
    value = np.abs(value) if key in ("pitch_deg", "heel_deg") else value
    excess: Numbers = value - limit if end == "max" else limit - value
    return excess


def depth_beyond(trajectory: Trajectory) -> Numbers | None:
    """Return the hull's depth [m] beyond test depth at each tick. None: the boat has no test depth.

    While the depth is frozen the boat is not beyond it.
    """
    hull, column = trajectory.boat.file.hull, trajectory.columns
    if hull.test_depth_m is None:
        return None
    beyond = lowest_depth(column["z"], column["theta"], hull.length) - hull.test_depth_m
    return np.where(column["held_depth"] == 0.0, beyond, np.minimum(beyond, 0.0))


def surfacing(trajectory: Trajectory) -> RowMask:
    """Return at which ticks main ballast is being blown, or blown."""
    vessel, column = trajectory.boat.vessel, trajectory.columns
    if not vessel.fitted:
        return np.zeros(trajectory.ticks.size, bool)
    tanks = ("forward", "mid", "aft")
    held = sum(column[f"water_{name}"] for name in tanks)
    blown = sum(column[f"blow_{name}"] for name in tanks)
    return np.asarray(
        (held < FULL_BALLAST_SHARE * float(vessel.capacity[:3].sum())) | (np.asarray(blown) > 0.0)
    )


def broach_rows(trajectory: Trajectory) -> list[int]:
    """Return the rows at which the boat broached, as the watch calls it out."""
    height, meant_rows = shown_height(trajectory), surfacing(trajectory)
    shows, broached = bool(height[0] > 0.0), []
    for row in range(1, height.size):
        if not shows and height[row] > 0.0 and not meant_rows[row]:
            broached.append(row)
        shows = bool(height[row] > (-RECALL_COVER_M if shows else 0.0))
    return broached


def _quantity(trajectory: Trajectory, rows: RowMask, rule: ScoreRule) -> Numbers:
    assert rule.measured  # noqa: S101 (checked when the rule was read)
    return trajectory.measured(rule.measured)[rows]


def _off(trajectory: Trajectory, rows: RowMask, rule: ScoreRule) -> Numbers:
    assert rule.measured  # noqa: S101
    return trajectory.off(rule.measured, rule.score.target)[rows]


def _inside(trajectory: Trajectory, rows: RowMask, rule: ScoreRule) -> RowMask:
    return np.abs(_off(trajectory, rows, rule)) <= (rule.score.band or 0.0)


def _time_in(trajectory: Trajectory, rows: RowMask) -> Measurement:
    """Return the time [s] of rows, and the first of them."""
    ticks = np.flatnonzero(rows)
    seconds = float(ticks.size) * trajectory.boat.method.step
    return Measurement(seconds, int(trajectory.ticks[ticks[0]]) if ticks.size else None)


def _count_in(trajectory: Trajectory, rows: RowMask, events: Iterable[int]) -> Measurement:
    """Return how many events are at these rows, and the first of them."""
    events_inside = [row for row in events if rows[row]]
    return Measurement(
        float(len(events_inside)),
        int(trajectory.ticks[events_inside[0]]) if events_inside else None,
    )


def _extreme(
    trajectory: Trajectory, rows: RowMask, values: Numbers, furthest: Callable[[Numbers], np.intp]
) -> Measurement:
    index = int(furthest(values))
    return Measurement(float(values[index]), int(trajectory.ticks[rows][index]))

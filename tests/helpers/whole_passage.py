"""The other way of counting: measures, limits and losses of a whole passage at once, by numpy.

The judge counts tick by tick, in machine code; here the same is said as functions of all rows of a
passage, which a reader can check against docs/measures.md. Tests compare both.
"""

import math
from collections.abc import Callable, Iterable, Iterator, Mapping

import numpy as np

from trainer.boat.boat import FLAT_WORDS
from trainer.boat.depths import lowest_depth
from trainer.boat.limits import LIMIT_WORDS, RECALL_COVER_M
from trainer.config.exercise.derived import Loss
from trainer.config.exercise.loss_words import word_loss
from trainer.config.exercise.score_rules import ScoreRule
from trainer.core.ballast.tanks import BANKS
from trainer.core.kernel import Numbers
from trainer.core.surfaces import SURFACES
from trainer.debrief.marks.mark_numbers import (
    EDGE_SHARE,
    FULL_BREACH_S,
    FULL_EXCESS,
    GATE_CAP,
    GATE_TIME_S,
    HELD_TIME_S,
    LEAST_EXCESS,
    SETTLING_WINDOW_S,
    SLIP_COST,
    TURNED_HEEL,
    TURNED_PITCH,
)
from trainer.debrief.marks.measures import (
    LIMIT_QUANTITIES,
    NEAREST_RANGE,
    NO_TEST_DEPTH,
    PLANE_NAMES,
    Measurement,
    lacking,
    limits_of,
    measure_detection,
    measure_report,
    surfacing,
)
from trainer.debrief.marks.tallied_record import looked_at
from trainer.debrief.passage.episodes import answer_to, first_spell
from trainer.debrief.passage.groundings import groundings
from trainer.debrief.passage.ships_met import (
    look_out,
    meet_ships,
    reports_near_ships,
    shown_rows,
)
from trainer.debrief.passage.trajectory import (
    RowMask,
    Trajectory,
    row_stretches,
    shown_height,
)
from trainer.report.svg import clock
from trainer.session.past.plan import Plan
from trainer.session.stations.alerts import SEEN_RANKS


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


def time_to_report(trajectory: Trajectory, rows: RowMask, _rule: ScoreRule) -> Measurement:
    """Return the time [s] from a periscope's first look to a right report of contacts."""
    shown, ticks = np.flatnonzero(shown_rows(trajectory)[0] & rows), trajectory.ticks
    first = int(ticks[shown[0]]) if shown.size else None
    return measure_report(first, reports_near_ships(trajectory), trajectory.boat.method.step)


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
    limits = limits_of(trajectory.limits)
    beyond = np.any([rows_beyond(trajectory, name) for name in limits], axis=0) & rows
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
    assert rule.measured
    return trajectory.measured(rule.measured)[rows]


def _off(trajectory: Trajectory, rows: RowMask, rule: ScoreRule) -> Numbers:
    assert rule.measured
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


def take_measure(trajectory: Trajectory, rule: ScoreRule) -> Measurement:
    """Return the measure of a rule in a passage."""
    if why := lacking(trajectory.boat, rule):
        return Measurement(None, None, why, counts=False)
    rows = looked_at(trajectory, rule)
    if rows is None:
        return Measurement(None, None, "it did not happen", counts=False)
    if not np.any(rows):
        reason = f"the record ends at {trajectory.seconds[-1]:g} s"
        return Measurement(None, None, reason, counts=False, beyond_record=True)
    for condition in rule.conditions:
        rows &= trajectory.holds(condition)
    if not np.any(rows):
        return Measurement(None, None, f"never {rule.score.when}")
    counted: Measurement = globals()[rule.score.measure.replace("-", "_")](trajectory, rows, rule)
    return counted


def broken_limits(trajectory: Trajectory) -> Iterator[tuple[str, float]]:
    """Yield the limits that were broken for GATE_TIME_S.

    What is left falls by how far each was passed, and for how long: no second decides it.
    """
    for name in limits_of(trajectory.limits):
        excess = excess_beyond(trajectory, name)
        row = first_for(excess > 0.0, GATE_TIME_S, trajectory)
        if row is not None:
            limit = getattr(trajectory.limits, name)
            width = max(FULL_EXCESS * abs(limit), LEAST_EXCESS[name.rpartition("_")[0]])
            share = _excess_time(excess, trajectory) / (width * FULL_BREACH_S)
            text = f"{LIMIT_WORDS[name].format(limit)} at {clock(float(trajectory.seconds[row]))}"
            yield (text, 100.0 - (100.0 - GATE_CAP) * min(share, 1.0))


def _excess_time(excess: Numbers, trajectory: Trajectory) -> float:
    """Return the excess over the time [unit of the limit times s], stretches of GATE_TIME_S on."""
    step, times = trajectory.boat.method.step, trajectory.seconds
    return step * sum(
        float(excess[first:after].sum())
        for first, after in row_stretches(excess > 0.0)
        if times[after - 1] - times[first] >= GATE_TIME_S - 1e-9
    )


def first_for(holds: RowMask, seconds: float, trajectory: Trajectory) -> int | None:
    """Return the first row from which something holds for so long. None: it never does."""
    times = trajectory.seconds
    return next(
        (
            first
            for first, after in row_stretches(holds)
            if times[after - 1] - times[first] >= seconds - 1e-9
        ),
        None,
    )


def turned_over(trajectory: Trajectory) -> str:
    """Return that the boat turned over, and when."""
    pitch, heel = np.abs(trajectory.columns["theta"]), np.abs(trajectory.columns["phi"])
    over = np.flatnonzero((pitch > TURNED_PITCH) | (heel > TURNED_HEEL))
    if not over.size:
        return ""
    row = int(over[0])
    angles = f"pitch {np.degrees(pitch[row]):.0f} deg, heel {np.degrees(heel[row]):.0f} deg"
    told = f"turned over at {clock(float(trajectory.seconds[row]))}: {angles}"
    return told + _flat_words(trajectory, row)


def _flat_words(trajectory: Trajectory, row: int) -> str:
    """Return words for a loss at a row where the battery was flat, else ""."""
    full = float(trajectory.boat.vessel.battery_full)
    return FLAT_WORDS if 0.0 < full <= trajectory.columns["battery_spent"][row] else ""


def losses(trajectory: Trajectory, losses: tuple[Loss, ...]) -> Iterator[str]:
    """Yield the conditions that lost the exercise, and when."""
    for loss in losses:
        holds = np.ones(trajectory.ticks.size, bool)
        for condition in loss.conditions:
            holds &= trajectory.holds(condition)
        row = first_for(holds, loss.seconds, trajectory)
        if row is not None:
            told = f"{word_loss(loss.text)} at {clock(float(trajectory.seconds[row]))}"
            yield told + _flat_words(trajectory, row)


def ended(trajectory: Trajectory, plan: Plan) -> str:
    """Return that the hull has collapsed."""
    limit = plan.file.hull.collapse_depth_m
    if limit is None:
        return ""
    column = trajectory.columns
    depths = lowest_depth(column["z"], column["theta"], plan.file.hull.length)
    if not (depths >= limit).any():
        return ""
    flat = _flat_words(trajectory, int((depths >= limit).argmax()))
    return f"the hull collapsed at {depths.max():.0f} m{flat}"


def told_of_caps(trajectory: Trajectory, plan: Plan) -> tuple[dict[str, float], list[str]]:
    """Return what each broken limit leaves [%], and how the boat was lost, in words."""
    told = [turned_over(trajectory), *losses(trajectory, plan.lost), ended(trajectory, plan)]
    return dict(broken_limits(trajectory)), told

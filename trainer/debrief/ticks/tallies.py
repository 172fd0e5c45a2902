"""The marks of an exercise tick by tick, in machine code.

``tick_judge`` lays the rules of a plan out as rows here, and has each tick taken into account. What
a value means is said by ``measures``, ``gates`` and ``judgement``, whose marks these are at every
tick; here is what they need to remember. numba compiles it where it is first asked for.
"""

import math
from typing import Any, Final

from trainer.core.kernel import Numbers, Record, inline_kernel, kernel, record_dtype
from trainer.debrief.marks.gates import FULL_BREACH_S, GATE_CAP, GATE_TIME_S
from trainer.debrief.marks.judgement import (
    HARD_CAP,
    KEEPING_SHARE,
    LOST_CAP,
    MAX_NOBODY_PERCENT,
    WEAKEST_SHARE,
    WHOLE_TASK_PERCENT,
)
from trainer.debrief.marks.measures import EDGE_SHARE, HELD_TIME_S, SLIP_COST

# what a row is about: measures by their names, then what caps the marks
MEASURE_NAMES: Final = (
    *("in-band", "settled", "reach", "time-to", "overshoot", "rms"),
    *("largest", "highest", "lowest", "final"),
    *("activity", "hand-travel", "distance", "response"),
    *("closest-approach", "exposed", "exposed-raise"),
    *("aground", "time-to-detect", "time-to-report"),
)
IN_BAND, SETTLED, REACH, TIME_TO, OVERSHOOT, RMS = 0, 1, 2, 3, 4, 5  # off a target
LARGEST, HIGHEST, LOWEST, FINAL = 6, 7, 8, 9  # how far it goes
ACTIVITY, HAND_TRAVEL, DISTANCE, RESPONSE = 10, 11, 12, 13
CLOSEST, EXPOSED, EXPOSED_RAISE = 14, 15, 16  # of ships and the periscope
AGROUND, TIME_TO_DETECT, TIME_TO_REPORT = 17, 18, 19  # whose value others write
AIMED_MEASURES: Final = MEASURE_NAMES[: RMS + 1]
GATE, LOSS, TURNED, COLLAPSED, STRUCK = 30, 31, 32, 33, 34
HARD, GROUNDED, LAID_BADLY = 35, 36, 37  # whose ``extreme`` is written by who watches the ground
TASK, ANSWER, KEEPING = 0, 1, 2
TICK_COLUMN: Final = 0  # of a row of numbers
TOTAL, ENDED = 0, 1  # columns of the totals
FEW_SHARE: Final = 4  # a condition holds for a while from this part of a short record on

Row = Any  # one row of a record array

TALLY_RULE: Final = record_dtype(
    "measure",  # [-] IN_BAND to LAID_BADLY
    "part",  # [-] TASK, ANSWER or KEEPING
    "column",  # [-] of the quantity
    "size",  # [SI] of its unit
    "around",  # [unit] after which it is the same again, 0 for never
    "target",  # [unit] NaN: the quantity itself; of a cap its limit
    "aim",  # [-] column of what is ordered, -1 where the target is a number; or of the raises
    "band",  # [unit] of a collapse the reach of the hull [m]
    "begin",  # [ticks] from the start, or from the casualty on
    "end",  # [ticks]
    "full",  # [unit] value of all marks
    "zero",  # [unit] value of none
    "weight",
    "since",  # [-] code of the casualty from which the ticks count, 0 for none
    "slots",  # [-] first column of the casualties, or of angles and hands
    "slot_count",
    "surfaces",  # [-] bits of those that count
    "first_condition",
    "conditions",  # [-] how many, from the first on
    "needed",  # [ticks] for which something has to hold
    "ring",  # [-] which memory of the last ticks
    "sense",  # [-] 1: beyond means above, -1: below
    "absolute",  # [-] 1: either way
    "step",  # [s]
)
TALLY_CONDITION: Final = record_dtype(
    "column",
    "size",
    "around",
    "sense",
    "strict",
    "threshold",  # [SI]
)
TALLY: Final = record_dtype(
    "free",  # [%] marks with nobody aboard
    "rows",  # [ticks] looked at
    "previous",  # [-] 1: the last tick was
    "sum",
    "extreme",
    "began_inside",
    "first_off",
    "last_off",
    "first_tick",
    "last_tick",
    "entered",  # [tick] at which it came in last
    "left",  # [rows] since it was outside first, 0 for not yet
    "held",  # [rows]
    "reached",  # [rows] 0 for not yet
    "inside",  # [-] 1: at the last tick
    "travel",  # [ticks]
    "onset",  # [ticks] of the casualty and one, 0 for not yet
    "answered",  # [s] after its onset, or the value that was written; NaN for none
    "idle",  # [-] 1: there is nothing that this value could be of, so that it does not count
    "marks",  # [%] NaN: it does not count
    "earned",  # [%] NaN: it does not count, or earns nothing
)


@inline_kernel
def off_target(rule: Row, row: Numbers) -> float:
    """Return how far a quantity is above its target, a course the short way round."""
    target = rule.target if rule.aim < 0.0 else row[int(rule.aim)] / rule.size
    off = row[int(rule.column)] / rule.size - target
    if rule.around > 0.0:
        off = (off + 0.5 * rule.around) % rule.around - 0.5 * rule.around
    return float(off)


@inline_kernel
def all_hold(rule: Row, conditions: Record, row: Numbers) -> bool:
    """Return whether all conditions of a rule hold."""
    first = int(rule.first_condition)
    for i in range(first, first + int(rule.conditions)):
        each = conditions[i]
        value = row[int(each.column)] / each.size
        if each.around > 0.0:
            value = value % each.around
        above = each.sense * (value - each.threshold)
        if above < 0.0 or (each.strict > 0.0 and above == 0.0) or math.isnan(above):
            return False
    return True


@inline_kernel
def moved(rule: Row, rows: Numbers, k: int) -> float:
    """Return how far the surfaces of a rule moved to a tick [deg]."""
    total, slots, count = 0.0, int(rule.slots), int(rule.slot_count)
    for i in range(count):
        by_hand = rule.measure == ACTIVITY or rows[k, slots + count + i] != 0.0
        if (int(rule.surfaces) >> i) & 1 and by_hand:
            total += abs(math.degrees(rows[k, slots + i]) - math.degrees(rows[k - 1, slots + i]))
    return total


@inline_kernel
def remember(ring: Numbers, tick: int, share: float) -> float:
    """Keep a share as that of a tick; return the one before it."""
    at = tick % ring.size
    gone = float(ring[at])
    ring[at] = share
    return gone


@inline_kernel
def follow_band(t: Row, tick: int, needed: float, inside: float) -> None:
    """Count how long the quantity was in its band since it was first outside."""
    if inside > 0.0 and t.inside == 0.0:
        t.entered = tick
    if inside == 0.0 or t.left > 0.0:
        t.left += 1.0
        t.held = max(t.held + (1.0 if inside > 0.0 else -SLIP_COST), 0.0)
        if t.reached == 0.0 and t.held > needed:
            t.reached = t.left
    t.inside = inside


@inline_kernel
def take_way(rule: Row, t: Row, rows: Numbers, k: int) -> None:
    """Add the way of the surfaces [deg] or of the boat [m] to a tick."""
    t.travel += 1.0
    if rule.measure != DISTANCE:
        t.sum += moved(rule, rows, k)
        return
    x = int(rule.column)
    t.sum += math.hypot(rows[k, x] - rows[k - 1, x], rows[k, x + 1] - rows[k - 1, x + 1])


@inline_kernel
def take_off(rule: Row, t: Row, tick: int, off: float, ring: Numbers) -> None:
    """Take into account how far a quantity is above its target."""
    measure, inside = int(rule.measure), 1.0 if abs(off) <= rule.band else 0.0
    if t.rows == 1.0:
        t.began_inside, t.first_off, t.inside = inside, off, inside
    t.last_off = off
    if measure in (REACH, TIME_TO):
        follow_band(t, tick, rule.needed, inside)
    elif measure == OVERSHOOT:
        beyond = -off if t.first_off > 0.0 else off
        t.extreme = beyond if t.rows == 1.0 else max(t.extreme, beyond)
    elif measure == RMS:
        t.sum += off * off
    else:
        over = 1.0 - (abs(off) - rule.band) / (EDGE_SHARE * rule.band)
        share = min(max(over, 0.0), 1.0)
        t.sum += share if measure == IN_BAND else share - remember(ring, tick, share)


@inline_kernel
def take_extreme(rule: Row, t: Row, row: Numbers) -> None:
    """Take into account how far a quantity goes, or its distance from a target."""
    measure, first = int(rule.measure), t.rows == 1.0
    value = row[int(rule.column)] / rule.size
    if measure in (LARGEST, FINAL) and not math.isnan(rule.target):
        value = abs(off_target(rule, row))
    elif measure == LARGEST:
        value = abs(value)
    if first or measure == FINAL:
        t.extreme = value
    else:
        t.extreme = min(t.extreme, value) if measure == LOWEST else max(t.extreme, value)


@inline_kernel
def take_shown(rule: Row, t: Row, row: Numbers) -> None:
    """Take the nearest ship into account, or the periscope's head."""
    value = row[int(rule.column)]
    if rule.measure == CLOSEST:
        t.extreme = value if t.rows == 1.0 else min(t.extreme, value)
        return
    if rule.measure == EXPOSED_RAISE and row[int(rule.aim)] != t.last_off:
        t.last_off, t.sum = row[int(rule.aim)], 0.0
    t.sum += value
    t.extreme = max(t.extreme, t.sum)


@inline_kernel
def take_row(rule: Row, t: Row, conditions: Record, rows: Numbers, k: int, ring: Numbers) -> None:
    """Take one tick into account for a rule whose window it may be in."""
    row, since, was = rows[k], max(t.onset - 1.0, 0.0), t.previous
    tick, measure = int(row[TICK_COLUMN]), int(rule.measure)
    t.previous = 0.0
    if not since + rule.begin - 1e-6 <= tick <= since + rule.end + 1e-6:
        return
    if measure == RESPONSE or not all_hold(rule, conditions, row):
        return
    if t.rows == 0.0:
        t.first_tick = tick
    t.rows, t.previous, t.last_tick = t.rows + 1.0, 1.0, tick
    if measure >= CLOSEST:
        if measure < AGROUND:
            take_shown(rule, t, row)
    elif measure >= ACTIVITY:
        if was > 0.0:
            take_way(rule, t, rows, k)
    elif measure >= LARGEST:
        take_extreme(rule, t, row)
    else:
        take_off(rule, t, tick, off_target(rule, row), ring)


@inline_kernel
def take_cap(rule: Row, t: Row, conditions: Record, row: Numbers) -> None:
    """Take one tick into account for a cap: ``extreme`` is then 1."""
    measure, value = int(rule.measure), row[int(rule.column)] / rule.size
    if measure == GATE:
        if rule.absolute > 0.0:
            value = abs(value)
        excess = rule.sense * (value - rule.target)
        if not excess > 0.0:
            t.rows = t.first_off = 0.0
            return
        t.rows += 1.0
        t.first_off += excess  # of this stretch, until it costs
        if (t.rows - 1.0) * rule.step >= GATE_TIME_S - 1e-9:
            t.sum, t.first_off, t.extreme = t.sum + t.first_off, 0.0, 1.0
    elif measure == LOSS:
        t.rows = t.rows + 1.0 if all_hold(rule, conditions, row) else 0.0
        if t.rows > 0.0 and (t.rows - 1.0) * rule.step >= rule.needed - 1e-9:
            t.extreme = 1.0
    elif measure in (TURNED, STRUCK):
        if abs(value) > rule.target:
            t.extreme = 1.0
    elif value + rule.band * abs(math.sin(row[int(rule.aim)])) >= rule.target:
        t.extreme = 1.0


@inline_kernel
def timed(rule: Row, t: Row, tick: int) -> float:
    """Return the time [s] to the band, as ``measures.time_to`` says. NaN: there is none."""
    if t.left == 0.0:
        return 0.0
    if t.reached > 0.0:
        return float(max(t.reached - 1.0 - rule.needed, 0.0) * rule.step)
    if t.inside > 0.0:
        return float((t.entered - t.first_tick) * rule.step)
    first, last = abs(t.first_off), abs(t.last_off)
    if (t.previous > 0.0 and t.last_tick == tick) or last >= first:
        return math.nan
    return float((t.last_tick - t.first_tick) * rule.step * (first - rule.band) / (first - last))


@inline_kernel
def value_of(rule: Row, t: Row, tick: int) -> float:
    """Return the value of a rule that has looked at a tick. NaN: there is none."""
    measure, value = int(rule.measure), float(t.extreme)
    few = 1.0
    if rule.conditions > 0.0:
        few = float(min(round(HELD_TIME_S / rule.step), (tick + 1) // FEW_SHARE))
    if measure in (SETTLED, REACH) and t.began_inside > 0.0:
        value = math.nan
    elif measure == IN_BAND:
        value = 100.0 * t.sum / max(t.rows, few)
    elif measure == SETTLED:
        value = 100.0 * t.sum / min(t.rows, rule.needed)
    elif measure in (REACH, TIME_TO):
        value = timed(rule, t, tick)
    elif measure == OVERSHOOT:
        value = math.nan if value < -rule.band else max(value, 0.0)
    elif measure == RMS:
        value = math.nan if t.rows < few else math.sqrt(t.sum / t.rows)
    if measure >= CLOSEST:
        return shown_of(rule, t)
    return way_of(rule, t) if measure >= ACTIVITY else value


@inline_kernel
def shown_of(rule: Row, t: Row) -> float:
    """Return a least range [m], the time [s] of a head, or what was written."""
    if rule.measure == CLOSEST:
        return float(t.extreme)
    return float(t.answered if rule.measure >= AGROUND else rule.step * t.extreme)


@inline_kernel
def way_of(rule: Row, t: Row) -> float:
    """Return the way [m], or the pace [deg/min]."""
    return float(t.sum if rule.measure == DISTANCE else 60.0 * t.sum / (t.travel * rule.step))


@inline_kernel
def is_idle(measure: int, t: Row) -> bool:
    """Return whether there is nothing that a value could be of."""
    if measure in (ACTIVITY, HAND_TRAVEL):
        return bool(t.travel == 0.0)
    return bool(t.idle > 0.0 or (measure == CLOSEST and math.isinf(t.extreme)))


@inline_kernel
def marks_now(rule: Row, t: Row, tick: int) -> float:
    """Return the marks of a rule [%]. NaN: it does not count."""
    measure = int(rule.measure)
    if rule.since > 0.0 and t.onset == 0.0:
        return math.nan
    if measure == RESPONSE:
        value = float(t.answered)
    elif t.rows == 0.0:
        return 0.0
    elif is_idle(measure, t):
        return math.nan
    else:
        value = value_of(rule, t, tick)
    if math.isnan(value):
        return 0.0
    share = (value - rule.zero) / (rule.full - rule.zero)
    return float(100.0 * min(max(share, 0.0), 1.0))


@inline_kernel
def cap_of(rules: Record, tallies: Record) -> float:
    """Return the most that is left [%]; -1 where the boat turned over."""
    cap, lost, hard = 100.0, False, False
    for r in range(rules.size):
        rule, t = rules[r], tallies[r]
        if rule.measure < GATE or t.extreme == 0.0:
            continue
        if rule.measure == TURNED:
            return -1.0
        if rule.measure == GATE:
            share = rule.step * t.sum / (rule.band * FULL_BREACH_S)
            cap = min(cap, 100.0 - (100.0 - GATE_CAP) * min(share, 1.0))
        elif rule.measure == LAID_BADLY:
            cap = min(cap, GATE_CAP)
        elif rule.measure == HARD:
            hard = True
        else:
            lost = True
    return HARD_CAP if hard else LOST_CAP if lost else float(cap)


@inline_kernel
def has_ended(rules: Record, tallies: Record) -> bool:
    """Return whether the boat or the exercise is lost for good."""
    for r in range(rules.size):
        measure, t = rules[r].measure, tallies[r]
        if measure <= GATE or measure == LAID_BADLY or t.extreme == 0.0:
            continue
        if measure != GROUNDED or t.held > 0.0:  # a boat that was laid down may yet come to lie
            return True
    return False


@inline_kernel
def earn_tasks(rules: Record, tallies: Record, tick: int) -> float:
    """Write what each rule earned; return the mean of the tasks [%]."""
    tasks = weight = 0.0
    for r in range(rules.size):
        rule, t = rules[r], tallies[r]
        t.earned = t.marks = math.nan
        if rule.measure >= GATE:
            continue
        t.marks = marks_now(rule, t, tick)
        counts = not math.isnan(t.marks) and t.free <= MAX_NOBODY_PERCENT
        if rule.part != KEEPING and counts:
            t.earned = 100.0 * max(0.0, (t.marks - t.free) / (100.0 - t.free))
        if rule.part == TASK and not math.isnan(t.earned):
            tasks += rule.weight * t.earned
            weight += rule.weight
    return tasks / weight if weight > 0.0 else 100.0


@inline_kernel
def total_now(rules: Record, tallies: Record, tick: int) -> float:
    """Return the total [%] of a record that ends at a tick; void is 0."""
    others, earned, weight = earn_tasks(rules, tallies, tick), 0.0, 0.0
    kept, kept_weight, weakest, count = 0.0, 0.0, 1.0, 0
    for r in range(rules.size):
        rule, t = rules[r], tallies[r]
        if not math.isnan(t.earned):
            answer = rule.part == ANSWER
            weakest = min(weakest, (t.marks if answer else t.earned) / WHOLE_TASK_PERCENT)
            earned += rule.weight * t.earned * (others / 100.0 if answer else 1.0)
            weight += rule.weight
            count += 1
        elif rule.part == KEEPING and not math.isnan(t.marks):
            kept += rule.weight * t.marks
            kept_weight += rule.weight
    tasks = earned / weight if weight > 0.0 else 0.0
    keeping = kept / kept_weight if kept_weight > 0.0 else 100.0
    total = tasks * (1.0 - KEEPING_SHARE + KEEPING_SHARE * keeping / 100.0)
    total *= 1.0 - WEAKEST_SHARE + WEAKEST_SHARE * (weakest if count > 1 else 1.0)
    return float(max(min(total, cap_of(rules, tallies)), 0.0))


@inline_kernel
def ends_record(rules: Record, tallies: Record) -> bool:
    """Return whether a run would have ended before this tick."""
    for r in range(rules.size):
        if rules[r].measure in (COLLAPSED, STRUCK) and tallies[r].extreme > 0.0:
            return True
    return False


@inline_kernel
def find_onset(rule: Row, t: Row, row: Numbers) -> bool:
    """Return whether the casualty of a rule comes at this tick."""
    if rule.since == 0.0 or t.onset > 0.0:
        return False
    first = int(rule.slots)
    for i in range(first, first + int(rule.slot_count)):
        if row[i] == rule.since:
            t.onset = max(row[TICK_COLUMN] - 1.0, 0.0) + 1.0
            return True
    return False


@kernel
def take_ticks(
    rules: Record,
    conditions: Record,
    rows: Numbers,
    tallies: Record,
    rings: Numbers,
    totals: Numbers,
) -> None:
    """Take each boat's ticks into account; write its total [%], and whether it has ended.

    ``rows`` [boats, 1 + ticks, columns] begin with a tick that was taken before; of a boat whose
    total is NaN none is taken. ``tallies`` are [boats, rules], ``rings`` [boats, rings, ticks].
    """
    for b in range(rows.shape[0]):
        if math.isnan(totals[b, TOTAL]):
            continue
        own, t, last = rows[b], tallies[b], 0
        for k in range(1, rows.shape[1]):
            if ends_record(rules, t):
                break
            last = k
            for r in range(rules.size):
                rule = rules[r]
                if rule.measure >= GATE:
                    if rule.measure < HARD:
                        take_cap(rule, t[r], conditions, own[k])
                    continue
                ring = rings[b, int(rule.ring)]
                if find_onset(rule, t[r], own[k]) and own[k, TICK_COLUMN] > 0.0:
                    take_row(rule, t[r], conditions, own, k - 1, ring)
                if rule.since == 0.0 or t[r].onset > 0.0:
                    take_row(rule, t[r], conditions, own, k, ring)
        totals[b, TOTAL] = total_now(rules, t, int(own[last, TICK_COLUMN]))
        totals[b, ENDED] = 1.0 if has_ended(rules, t) else 0.0

"""The marks of an exercise tick by tick, in machine code.

``tally_sheet`` lays the rules of a plan out as rows, and each tick is taken into account: of a
whole record by ``tallied_record``, while a boat goes on by ``ticks/judge``. A tally is what a rule
remembers of the ticks so far: what it took, and at which tick. No function of a library is called,
so that the machine code can be shipped.
"""

# long: one kernel, with the records that it takes

import math
from typing import Any, Final

from trainer.core.kernel import Numbers, Record, inline_kernel, kernel, record_dtype
from trainer.debrief.marks.mark_numbers import (
    EDGE_SHARE,
    FULL_BREACH_S,
    GATE_CAP,
    HARD_CAP,
    KEEPING_SHARE,
    LOST_CAP,
    MAX_NOBODY_PERCENT,
    SLIP_COST,
    WEAKEST_SHARE,
    WHOLE_TASK_PERCENT,
)

# what a row is about: measures by their names, then what caps the marks
MEASURE_NAMES: Final = (
    *("in-band", "settled", "reach", "time-to", "overshoot", "rms"),
    *("largest", "highest", "lowest", "final"),
    *("closest-approach", "reserve-air", "beyond-test-depth"),
    *("activity", "hand-travel", "distance", "response"),
    *("exposed", "exposed-raise", "time-beyond-test-depth", "beyond-limits", "broaches"),
    *("aground", "time-to-detect", "time-to-report", "alert-response"),
)
IN_BAND, SETTLED, REACH, TIME_TO, OVERSHOOT, RMS = range(6)  # off a target
LARGEST, HIGHEST, LOWEST, FINAL, CLOSEST, AIR, TEST_DEPTH = range(6, 13)  # how far it goes
ACTIVITY, HAND_TRAVEL, DISTANCE, RESPONSE = range(13, 17)
EXPOSED, EXPOSED_RAISE, TEST_TIME, LIMIT_TIME, BROACHES = range(17, 22)  # how often it is so
AGROUND, ALERT_RESPONSE = 22, 25  # from one to the other others write the value
AIMED_MEASURES: Final = MEASURE_NAMES[: RMS + 1]
GATE, LOSS, TURNED, COLLAPSED, STRUCK = 30, 31, 32, 33, 34
HARD, GROUNDED, LAID_BADLY = 35, 36, 37  # whose ``extreme`` is written by who watches the ground
TASK, ANSWER, KEEPING = 0, 1, 2
TICK_COLUMN: Final = 0  # of a row of numbers
TOTAL, ENDED, TOTALS = 0, 1, 2  # columns of the totals, and how many
FEW_SHARE: Final = 4  # a condition holds for a while from this part of a short record on

Row = Any  # one row of a record array

TALLY_RULE: Final = record_dtype(
    "measure",  # [-] IN_BAND to LAID_BADLY
    "part",  # [-] TASK, ANSWER or KEEPING
    "column",  # [-] of the quantity
    "size",  # [SI] of its unit
    "around",  # [unit] after which it is the same again, 0 for never
    "target",  # [unit] NaN: the quantity itself; of a cap its limit
    "aim",  # [-] column of what is ordered, -1 where that is a number; of raises or a blow
    "band",  # [unit] of broaches the cover [m] from which the sail is under water again
    "begin",  # [ticks] from the start, or from the casualty on
    "end",  # [ticks]
    "full",  # [unit] value of all marks
    "zero",  # [unit] value of none
    "weight",
    "since",  # [-] code of the casualty from which the ticks count, 0 for none
    "slots",  # [-] first column of the casualties
    "slot_count",
    "angles",  # [-] first column of the surfaces' angles; behind them is who works each
    "angle_count",
    "surfaces",  # [-] bits of those that count
    "first_condition",
    "conditions",  # [-] how many, from the first on
    "needed",  # [ticks] for which something has to hold
    "moment",  # [ticks] that a condition has to hold for, in a long record
    "ring",  # [-] which memory of the last ticks
    "sense",  # [-] 1: beyond means above, -1: below
    "absolute",  # [-] 1: either way
    "step",  # [s]
    "ends",  # [-] 1: a run ends with the tick at which this comes
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
    "at",  # [tick] at which the value was taken, -1 where there is none
    "first_tick",
    "last_tick",
    "entered",  # [tick] at which it came in last
    "left",  # [rows] since it was outside first, 0 for not yet
    "held",  # [rows], also of what is remembered; or 1: the boat broached at this tick
    "near",  # [rows] of those remembered, in part in the band
    "spell",  # [tick] from which it counts as held
    "reached",  # [rows] 0 for not yet
    "inside",  # [-] 1: at the last tick
    "travel",  # [ticks]
    "onset",  # [ticks] of the casualty and one, 0 for not yet
    "answered",  # [s] after its onset, or the value that was written; NaN for none
    "value",  # [unit] of all ticks so far, NaN for none
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
        off -= rule.around * math.floor(off / rule.around + 0.5)
    return float(off)


@inline_kernel
def all_hold(rule: Row, conditions: Record, row: Numbers) -> bool:
    """Return whether all conditions of a rule hold."""
    first = int(rule.first_condition)
    for i in range(first, first + int(rule.conditions)):
        each = conditions[i]
        value = row[int(each.column)] / each.size
        if each.around > 0.0:
            value -= each.around * math.floor(value / each.around)
        above = each.sense * (value - each.threshold)
        if above < 0.0 or (each.strict > 0.0 and above == 0.0) or math.isnan(above):
            return False
    return True


@inline_kernel
def moved(rule: Row, rows: Numbers, k: int) -> float:
    """Return how far the surfaces of a rule moved to a tick [deg]."""
    total, first, count = 0.0, int(rule.angles), int(rule.angle_count)
    for i in range(count):
        by_hand = rule.measure == ACTIVITY or rows[k, first + count + i] != 0.0
        if (int(rule.surfaces) >> i) & 1 and by_hand:
            total += abs(math.degrees(rows[k, first + i]) - math.degrees(rows[k - 1, first + i]))
    return total


@inline_kernel
def share_inside(rule: Row, off: float) -> float:
    """Return 1 in the band, in part to EDGE_SHARE of it beyond."""
    over = 1.0 - (off - rule.band) / (EDGE_SHARE * rule.band)
    return min(max(over, 0.0), 1.0)


@inline_kernel
def remember(rule: Row, t: Row, ring: Numbers, tick: int, off: float) -> None:
    """Keep how far off it is at a tick; forget what is too old."""
    first = tick if t.rows == 1.0 else max(int(t.last_tick) + 1, tick - ring.size + 1)
    for each in range(first, tick + 1):
        gone = ring[each % ring.size]
        if not math.isnan(gone):
            share = share_inside(rule, gone)
            t.sum -= share
            t.held -= 1.0
            t.near -= 1.0 if share > 0.0 else 0.0
        ring[each % ring.size] = math.nan
    ring[tick % ring.size] = off
    share = share_inside(rule, off)
    t.held += 1.0
    t.near += 1.0 if share > 0.0 else 0.0
    t.sum = t.sum + share if t.near > 0.0 else 0.0  # and not what rounding has left


@inline_kernel
def follow_band(rule: Row, t: Row, tick: int, inside: float) -> None:
    """Count how long the quantity was in its band since it was first outside."""
    if inside > 0.0 and t.inside == 0.0:
        t.entered = tick
    if inside == 0.0 or t.left > 0.0:
        t.left += 1.0
        if t.reached == 0.0:
            if t.held == 0.0:
                t.spell = tick
            t.held = max(t.held + (1.0 if inside > 0.0 else -SLIP_COST), 0.0)
            if t.held > rule.needed:
                t.reached = t.left
    t.inside = inside


@inline_kernel
def take_furthest(t: Row, tick: int, value: float) -> None:
    """Keep the greatest of values, and where it was first."""
    if t.rows == 1.0 or value > t.extreme:
        t.extreme, t.at = value, tick


@inline_kernel
def take_way(rule: Row, t: Row, rows: Numbers, k: int) -> None:
    """Add the way of the surfaces [deg] or of the boat [m] to a tick."""
    tick = rows[k, TICK_COLUMN]
    t.travel += tick - rows[k - 1, TICK_COLUMN]
    if rule.measure == DISTANCE:
        x, y = int(rule.column), int(rule.aim)
        north, east = rows[k, x] - rows[k - 1, x], rows[k, y] - rows[k - 1, y]
        t.sum += math.sqrt(north * north + east * east)
        return
    way = moved(rule, rows, k)
    t.sum += way
    if t.at < 0.0 or way > t.extreme:
        t.extreme, t.at = way, tick


@inline_kernel
def take_off(rule: Row, t: Row, tick: int, off: float, ring: Numbers) -> None:
    """Take into account how far a quantity is above its target."""
    measure, inside = int(rule.measure), 1.0 if abs(off) <= rule.band else 0.0
    if t.rows == 1.0:
        t.began_inside, t.first_off, t.inside = inside, off, inside
    t.last_off = off
    if measure in (REACH, TIME_TO):
        follow_band(rule, t, tick, inside)
    elif measure == OVERSHOOT:
        take_furthest(t, tick, -off if t.first_off > 0.0 else off)
    elif measure == SETTLED:
        remember(rule, t, ring, tick, abs(off))
    else:
        take_furthest(t, tick, abs(off))
        t.sum += off * off if measure == RMS else share_inside(rule, abs(off))


@inline_kernel
def take_extreme(rule: Row, t: Row, row: Numbers) -> None:
    """Take into account how far a quantity goes, or its distance from a target."""
    measure, tick = int(rule.measure), int(row[TICK_COLUMN])
    value = row[int(rule.column)] / rule.size
    if measure in (LARGEST, FINAL) and not math.isnan(rule.target):
        value = abs(off_target(rule, row))
    elif measure == LARGEST:
        value = abs(value)
    if measure == FINAL:
        t.extreme, t.at = value, tick
    elif measure in (LOWEST, CLOSEST, AIR):
        if t.rows == 1.0 or value < t.extreme:
            t.extreme, t.at = value, tick
    else:
        take_furthest(t, tick, value)


@inline_kernel
def excess_of(rule: Row, row: Numbers) -> float:
    """Return how far a limit is passed [unit], below zero within it."""
    value = row[int(rule.column)] / rule.size
    if rule.absolute > 0.0:
        value = abs(value)
    return float(rule.sense * (value - rule.target))


@inline_kernel
def is_beyond_limit(rules: Record, row: Numbers) -> bool:
    """Return whether any limit is passed."""
    for r in range(rules.size):
        if rules[r].measure == GATE and excess_of(rules[r], row) > 0.0:
            return True
    return False


@inline_kernel
def follow_broach(rule: Row, t: Row, row: Numbers) -> None:
    """Note whether the boat broaches at a tick, and whether it shows."""
    height, first = row[int(rule.column)] / rule.size, t.left == 0.0
    broached = not first and t.inside == 0.0 and height > 0.0 and row[int(rule.aim)] == 0.0
    t.held = 1.0 if broached else 0.0
    t.inside = 1.0 if height > (-rule.band if t.inside > 0.0 else 0.0) else 0.0
    t.left = 1.0


@inline_kernel
def take_count(rules: Record, rule: Row, t: Row, row: Numbers) -> None:
    """Count a tick at which it is so; of raises keep that with most."""
    measure, tick = int(rule.measure), int(row[TICK_COLUMN])
    if measure == LIMIT_TIME:
        so = is_beyond_limit(rules, row)
    elif measure == BROACHES:
        so = t.held > 0.0
    else:
        so = row[int(rule.column)] > 0.0
    if measure == EXPOSED_RAISE and row[int(rule.aim)] != t.last_off:
        t.last_off, t.sum = row[int(rule.aim)], 0.0
    if not so:
        return
    if t.sum == 0.0:
        t.entered = tick
    t.sum += 1.0
    if t.sum > t.extreme:
        t.extreme, t.at = t.sum, t.entered


@inline_kernel
def looks_at(rule: Row, t: Row, conditions: Record, row: Numbers) -> bool:
    """Return whether a tick is in a rule's window, and its conditions hold."""
    tick, since = row[TICK_COLUMN], max(t.onset - 1.0, 0.0)
    if rule.measure == RESPONSE or (rule.since > 0.0 and t.onset == 0.0):
        return False
    inside = since + rule.begin - 1e-6 <= tick <= since + rule.end + 1e-6
    return inside and all_hold(rule, conditions, row)


@inline_kernel
def take_row(rules: Record, r: int, t: Row, rows: Numbers, k: int, ring: Numbers) -> None:
    """Take a tick into account that a rule looks at."""
    rule, row, was = rules[r], rows[k], t.previous
    tick, measure = int(row[TICK_COLUMN]), int(rule.measure)
    if t.rows == 0.0:
        t.first_tick = tick
    t.rows, t.previous = t.rows + 1.0, 1.0
    if measure >= EXPOSED:
        if measure < AGROUND:
            take_count(rules, rule, t, row)
    elif measure >= ACTIVITY:
        if was > 0.0:
            take_way(rule, t, rows, k)
    elif measure >= LARGEST:
        take_extreme(rule, t, row)
    else:
        take_off(rule, t, tick, off_target(rule, row), ring)
    t.last_tick = tick


@inline_kernel
def take_cap(rule: Row, t: Row, conditions: Record, row: Numbers) -> None:
    """Take one tick into account for a cap; ``extreme`` is then 1."""
    measure, tick = int(rule.measure), row[TICK_COLUMN]
    if measure in (GATE, LOSS):
        excess = excess_of(rule, row) if measure == GATE else 0.0
        if not (excess > 0.0 if measure == GATE else all_hold(rule, conditions, row)):
            t.rows = t.first_off = 0.0
            return
        if t.rows == 0.0:
            t.first_tick = tick
        t.rows += 1.0
        t.first_off += excess  # of this stretch, until it costs
        if (tick - t.first_tick) * rule.step >= rule.needed - 1e-9:
            t.sum, t.first_off = t.sum + t.first_off, 0.0
            if t.extreme == 0.0:
                t.extreme, t.at = 1.0, t.first_tick
    elif t.extreme == 0.0 and abs(row[int(rule.column)] / rule.size) > rule.target:
        t.extreme, t.at = 1.0, tick


@inline_kernel
def timed(rule: Row, t: Row, tick: int) -> float:
    """Return the time [s] to the band, and keep where. NaN: there is none.

    Where a window ends on the way, it is that at its mean pace.
    """
    if t.left == 0.0:
        t.at = t.first_tick
        return 0.0
    if t.reached > 0.0:
        t.at = t.spell
        return float(max(t.reached - 1.0 - rule.needed, 0.0) * rule.step)
    if t.inside > 0.0:
        t.at = t.entered
        return float((t.entered - t.first_tick) * rule.step)
    t.at, first, last = t.last_tick, abs(t.first_off), abs(t.last_off)
    if (t.previous > 0.0 and t.last_tick == tick) or last >= first:
        return math.nan
    seconds = (t.last_tick - t.first_tick) * rule.step
    return float(seconds * ((first - rule.band) / (first - last)))


@inline_kernel
def value_of(rule: Row, t: Row, tick: int) -> float:
    """Return the value of a rule that has looked at a tick. NaN: there is none."""
    measure, value, few = int(rule.measure), float(t.extreme), 1.0
    if rule.conditions > 0.0:
        few = min(rule.moment, float((tick + 1) // FEW_SHARE))
    if measure in (SETTLED, REACH) and t.began_inside > 0.0:
        value = math.nan
    elif measure in (IN_BAND, SETTLED):
        value = 100.0 * t.sum / max(t.rows if measure == IN_BAND else t.held, few)
    elif measure in (REACH, TIME_TO):
        value = timed(rule, t, tick)
    elif measure == OVERSHOOT:
        value = math.nan if value < -rule.band else max(value, 0.0)
    elif measure == RMS:
        value = math.nan if t.rows < few else math.sqrt(t.sum / t.rows)
    elif measure >= AGROUND:
        value = t.answered
    elif measure >= EXPOSED:
        value = value if measure == BROACHES else rule.step * value
    elif measure >= ACTIVITY:
        value = way_of(rule, t)
    return float(value)


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
    measure, t.value = int(rule.measure), math.nan
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
    t.value = value
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
        rule, t = rules[r], tallies[r]
        if rule.ends > 0.0 and t.extreme > 0.0:
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


@inline_kernel
def take_tick(
    rules: Record, conditions: Record, tallies: Record, rows: Numbers, k: int, rings: Numbers
) -> None:
    """Take one tick of a boat into account."""
    for r in range(rules.size):
        rule, t = rules[r], tallies[r]
        if rule.measure >= GATE:
            if rule.measure < HARD:
                take_cap(rule, t, conditions, rows[k])
            continue
        # a state shows what acted in the tick that led to it
        first = k - 1 if find_onset(rule, t, rows[k]) and rows[k, TICK_COLUMN] > 0.0 else k
        for each in range(first, k + 1):
            if rule.measure == BROACHES and each == k:
                follow_broach(rule, t, rows[k])
            if looks_at(rule, t, conditions, rows[each]):
                take_row(rules, r, t, rows, each, rings[int(rule.ring)])
            else:
                t.previous = 0.0


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

    Of each boat there are ``rows`` [1 + ticks, columns], which begin with a tick that was taken
    before, ``tallies`` [rules], ``rings`` [rings, ticks] and ``totals`` [2], one boat's after the
    other's. Of a boat whose total is NaN none is taken.
    """
    boats = totals.shape[0]
    length, memories = rows.shape[0] // boats, rings.shape[0] // boats
    for b in range(boats):
        if math.isnan(totals[b, TOTAL]):
            continue
        own, t = rows[b * length : (b + 1) * length], tallies[b * rules.size : (b + 1) * rules.size]
        last, own_rings = 0, rings[b * memories : (b + 1) * memories]
        for k in range(1, length):
            if ends_record(rules, t):
                break
            last = k
            take_tick(rules, conditions, t, own, k, own_rings)
        totals[b, TOTAL] = total_now(rules, t, int(own[last, TICK_COLUMN]))
        totals[b, ENDED] = 1.0 if has_ended(rules, t) else 0.0

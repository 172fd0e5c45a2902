"""Ticks as they are called from outside the core: one, or many in one call.

``Boat`` takes one tick with ``tick`` and many with ``fly``. A manoeuvre waits for a heading, a
pitch or a speed, then gives its next order: ``analysis/manoeuvres/submarine`` writes that mark to a
lookout and calls ``sail``, so that the interpreter is not asked between ticks. Whoever learns or
plans orders one boat or many by numbers, and calls ``steer``.
"""

from typing import Final

from trainer.core.casualties import instruments
from trainer.core.elementary import cosine, nearest_turn, sine
from trainer.core.kernel import Numbers, Record, inline_kernel, kernel, record_dtype
from trainer.core.soundings import sound
from trainer.core.update import update

ROW_COLUMNS: Final = 17  # numbers of a row
# how an order by number writes to the state, as ``boat/effects`` explains
CONST, NUMBER, OVER, PLACE, SHORT, SHORTER = 0, 1, 2, 3, 4, 5
# the columns of a write, and the bounds of its order
OF_ORDER, PUT_AT, PUT_HOW, ARGUMENT, LOWEST, HIGHEST, RULE_COLUMNS = 0, 1, 2, 3, 4, 5, 6
NO_QUANTITY, PITCH, PITCH_SIZE, HEADING, SPEED, DEPTH_RATE = 0, 1, 2, 3, 4, 5  # what is watched

LOOKOUT: Final = record_dtype(
    "watched",  # [-] NO_QUANTITY to DEPTH_RATE; that one leaves roll out
    "side",  # [-] 1: until the quantity is at or above its mark, -1: at or below it
    "mark",  # [rad] or [m/s]
    "last",  # [ticks] at which to stop in any case
    "steepest",  # [rad] pitch beyond which the boat is lost
    "status",  # [-] of the tick that failed, 0 if none did
)


@inline_kernel
def tick(records: tuple[Record, ...], chart: Numbers) -> int:
    """Sound the ground of a chart that has numbers, then advance by one tick.

    ``records`` are those of ``update``, whose status it returns.
    """
    vessel, compact, scheme, state, scratch = records
    if chart.size > 0:
        sound(vessel, chart, state)
    return update(vessel, compact, scheme, state, scratch)


@kernel
def fly(records: tuple[Record, ...], chart: Numbers, offsets: Numbers, out: Numbers) -> int:
    """Advance by a tick for each row of ``out`` [n, columns].

    Return the status of the last one. A row has the numbers at those offsets of the state, then
    what the gauges read, if it is longer.
    """
    _, _, _, state, scratch = records
    count = offsets.size
    for i in range(out.shape[0]):
        status = tick(records, chart)
        if status != 0:
            return status
        for k in range(count):
            out[i, k] = state[0].whole[int(offsets[k])]
        if out.shape[1] > count:
            instruments(state, scratch)
            for k in range(scratch[0].reading.size):
                out[i, count + k] = scratch[0].reading[k]
    return 0


@inline_kernel
def find_refused(rules: Numbers, values: Numbers) -> int:
    """Return 1 + the first order whose value is out of bounds, else 0."""
    for k in range(rules.shape[0]):
        order = int(rules[k, OF_ORDER])
        if not rules[k, LOWEST] <= values[order] <= rules[k, HIGHEST]:  # which NaN is not, either
            return order + 1
    return 0


@inline_kernel
def obey_numbers(rules: Numbers, values: Numbers, state: Record) -> None:
    """Write to the state what orders by numbers ask for, rule by rule."""
    s = state[0]
    for k in range(rules.shape[0]):
        x, place = values[int(rules[k, OF_ORDER])], int(rules[k, PUT_AT])
        how, argument = rules[k, PUT_HOW], rules[k, ARGUMENT]
        if how == CONST:
            s.whole[place] = argument
        elif how == NUMBER:
            s.whole[place] = argument * x
        elif how == OVER:
            s.whole[place] = x / argument
        elif how == PLACE:
            s.whole[place] = s.whole[int(argument)]
        else:
            near = s.whole[int(argument)]
            angle = x if how == SHORT else s.whole[place]
            s.whole[place] = near + nearest_turn(angle - near)


@kernel
def steer(
    boats: tuple[Record, ...],
    rules: Numbers,
    values: Numbers,
    offsets: Numbers,
    ticks: int,
    out: Numbers,
) -> int:
    """Have each boat obey its row of ``values`` [boats, orders], then advance.

    Return how many boats rest. ``boats`` are the records of ``update``, but a state for each boat
    and a scratch for each or one for all, and then the chart of ``tick``. A row of ``rules`` [n,
    RULE_COLUMNS] is a write: its order, the place, how, the argument, and the order's bounds.

    The first number of a row of ``out`` is the boat's status: 0 as long as it goes on; -k where
    value k was refused, with the state as it was; else what ``update`` returned. A boat whose
    status is not 0 rests. The others are the numbers at ``offsets`` of the state, at the end, or
    after each tick if there is room for so many.
    """
    vessel, compact, scheme, states, scratches, chart = boats
    count, resting = offsets.size, 0
    for i in range(states.size):
        state = states[i : i + 1]
        j = i if scratches.size > 1 else 0
        own = vessel, compact, scheme, state, scratches[j : j + 1]
        if out[i, 0] == 0.0:
            out[i, 0] = -float(find_refused(rules, values[i]))
        going = out[i, 0] == 0.0
        if going:
            obey_numbers(rules, values[i], state)
        at = 1
        for k in range(ticks):
            if going:
                out[i, 0] = float(tick(own, chart))
                going = out[i, 0] == 0.0
            if out.shape[1] > 1 + count or k == ticks - 1:
                for m in range(count):
                    out[i, at + m] = state[0].whole[int(offsets[m])]
                at += count
        if not going:
            resting += 1
    return resting


@kernel
def has_passed(lookout: Record, state: Record) -> bool:
    """Return whether the quantity watched has passed its mark."""
    eye = lookout[0]
    s = state[0]
    if eye.watched == NO_QUANTITY:
        return False
    if eye.watched == PITCH:
        value = s.theta
    elif eye.watched == PITCH_SIZE:
        value = abs(s.theta)
    elif eye.watched == HEADING:
        value = s.psi
    elif eye.watched == SPEED:
        value = s.u
    else:
        value = s.w * cosine(s.theta) - s.u * sine(s.theta)
    return bool(eye.side * (value - eye.mark) >= 0.0)


@kernel
def write_row(state: Record, h: float, out: Numbers) -> None:
    """Write time, motion, surfaces and command speed [SI, rad] to ``out``."""
    s = state[0]
    out[0] = s.tick * h
    out[1], out[2], out[3] = s.u, s.v, s.w
    out[4], out[5], out[6] = s.p, s.q, s.r
    out[7], out[8], out[9] = s.x, s.y, s.z
    out[10], out[11], out[12] = s.phi, s.theta, s.psi
    out[13], out[14], out[15], out[16] = s.delta_r, s.delta_s, s.delta_b, s.u_c


@kernel
def sail(records: tuple[Record, ...], lookout: Record, out: Numbers) -> int:
    """Advance tick by tick, and write a row of ``out`` [n, ROW_COLUMNS] for each.

    Return how many rows were written. It ends where the quantity watched has passed its mark, at
    the last tick, when ``out`` is full, or when the boat is lost; that tick has no row. ``records``
    are those of ``update``.
    """
    vessel, compact, scheme, state, scratch = records
    eye = lookout[0]
    s = state[0]
    h = scheme[0].h
    eye.status = 0.0
    for i in range(out.shape[0]):
        if s.tick >= eye.last or has_passed(lookout, state):
            return i
        eye.status = float(update(vessel, compact, scheme, state, scratch))
        if eye.status != 0.0 or abs(s.theta) > eye.steepest:
            return i
        write_row(state, h, out[i])
    return int(out.shape[0])

"""Ticks as they are called from outside the core: one, or many in one call.

``Boat`` takes one tick with ``tick`` and many with ``fly``. A manoeuvre waits for a heading, a
pitch or a speed, then gives its next order: ``analysis/manoeuvres/submarine`` writes that mark to a
lookout and calls ``sail``, so that the interpreter is not asked between ticks.
"""

from typing import Final

from trainer.core.casualties import instruments
from trainer.core.elementary import cosine, sine
from trainer.core.kernel import Numbers, Record, kernel, part, record_dtype
from trainer.core.soundings import sound
from trainer.core.update import update

ROW_COLUMNS: Final = 17  # numbers of a row
NO_QUANTITY, PITCH, PITCH_SIZE, HEADING, SPEED, DEPTH_RATE = 0, 1, 2, 3, 4, 5  # what is watched

LOOKOUT: Final = record_dtype(
    "watched",  # [-] NO_QUANTITY to DEPTH_RATE; that one leaves roll out
    "side",  # [-] 1: until the quantity is at or above its mark, -1: at or below it
    "mark",  # [rad] or [m/s]
    "last",  # [ticks] at which to stop in any case
    "steepest",  # [rad] pitch beyond which the boat is lost
    "status",  # [-] of the tick that failed, 0 if none did
)


@part
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

"""One step of the twelve motion variables: any linear multistep method, Runge-Kutta 4.

Controls are held over the step. [ASSES] III-B, errata D1-D10.
"""

from trainer.core.kernel import Record, kernel, part
from trainer.core.rates import rates
from trainer.core.scheme import ADAMS, MULTISTEP, RUNGE_KUTTA
from trainer.core.state import HISTORY

SMALLEST, LARGEST = 0.05, 2.0  # [s] variable step, [ASSES] III-B
TOLERANCE = 1e-3  # of each variable's largest value
FLOOR = 0.01  # [m/s], [rad/s], [rad], [m] smaller largest values count as this


@part
def remember(state: Record) -> None:
    """Complete the rates' history after a start or a jump: as if the present rate had held.

    "Past rate = present rate" (errata D10).
    """
    s = state[0]
    if s.history == 0.0:
        for i in range(12):
            for back in range(HISTORY):
                s.past_rates[back, i] = s.rates[i]
        s.history = float(HISTORY)


@part
def remember_motion(h: float, state: Record) -> None:
    """Complete the motion's history likewise, for methods that look back on it."""
    s = state[0]
    if s.history == 0.0:
        for i in range(12):
            for back in range(HISTORY):
                s.past_motion[back, i] = s.motion[i] - (back + 1) * h * s.rates[i]


@part
def recall(scheme: Record, state: Record) -> None:
    """Put sum a_i X_n-i in the place of the motion, and shift its history."""
    how = scheme[0]
    s = state[0]
    remember_motion(how.h, state)
    for i in range(12):
        value = how.a[0] * s.motion[i]
        for back in range(how.depth - 1):
            value += how.a[back + 1] * s.past_motion[back, i]
        for back in range(HISTORY - 1, 0, -1):
            s.past_motion[back, i] = s.past_motion[back - 1, i]
        s.past_motion[0, i] = s.motion[i]
        s.motion[i] = value


@part
def adams_of(scheme: Record, terms: int, state: Record) -> None:
    """Advance by h sum b_i X'_n-i, i to ``terms``, and shift the history of the rates."""
    how = scheme[0]
    s = state[0]
    remember(state)
    for i in range(12):
        slope = how.b[0] * s.rates[i]
        for back in range(terms - 1):
            slope += how.b[back + 1] * s.past_rates[back, i]
        for back in range(HISTORY - 1, 0, -1):
            s.past_rates[back, i] = s.past_rates[back - 1, i]
        s.past_rates[0, i] = s.rates[i]
        s.motion[i] += how.h * slope


@part
def adams(scheme: Record, state: Record) -> None:
    """Advance by the scheme's method, one of Adams' kind: a_1 = 1 and no other."""
    adams_of(scheme, scheme[0].depth, state)


@part
def multistep(scheme: Record, state: Record) -> None:
    """Advance by X_n = sum a_i X_n-i + h sum b_i X'_n-i, the scheme's method."""
    recall(scheme, state)
    adams(scheme, state)


@kernel
def stage(state: Record, scratch: Record, weight: float, share: float) -> None:
    """Add ``weight`` of the present rates to the sum, and move ``share`` [s] along them."""
    s = state[0]
    work = scratch[0]
    for i in range(12):
        work.slope[i] += weight * s.rates[i]
        s.motion[i] = work.start[i] + share * s.rates[i]


@kernel
def runge_kutta(
    vessel: Record, compact: Record, scheme: Record, state: Record, scratch: Record, h: float
) -> None:
    """Advance by ``h`` [s] with the classical 4th-order method from rates already computed."""
    s = state[0]
    work = scratch[0]
    for i in range(12):
        work.start[i] = s.motion[i]
        work.slope[i] = 0.0
    stage(state, scratch, 1.0, 0.5 * h)
    rates(vessel, compact, scheme, state, scratch)
    stage(state, scratch, 2.0, 0.5 * h)
    rates(vessel, compact, scheme, state, scratch)
    stage(state, scratch, 2.0, h)
    rates(vessel, compact, scheme, state, scratch)
    stage(state, scratch, 1.0, 0.0)
    for i in range(12):
        s.motion[i] = work.start[i] + h / 6.0 * work.slope[i]


@kernel
def restart(state: Record, scratch: Record) -> None:
    """Put motion and rates back to where the present substep began."""
    s = state[0]
    work = scratch[0]
    for i in range(12):
        s.motion[i] = work.origin[i]
        s.rates[i] = work.origin_rates[i]


@kernel
def worst_error(state: Record, scratch: Record) -> float:
    """Return the local error [-] as a multiple of the tolerance: one step against two halves."""
    s = state[0]
    work = scratch[0]
    worst = 0.0
    for i in range(12):
        allowed = TOLERANCE * max(s.largest[i], FLOOR)
        ratio = abs(s.motion[i] - work.coarse[i]) / (15.0 * allowed)
        if not ratio <= worst:  # a NaN counts as the worst
            worst = ratio
    return worst


@kernel
def variable_runge_kutta(
    vessel: Record, compact: Record, scheme: Record, state: Record, scratch: Record
) -> None:
    """Advance by the scheme's step in substeps of 0.05 to 2 s, each halved or doubled by its error.

    Rates are already computed. The program KUTTA of [ASSES], by step doubling (errata D7).
    """
    s = state[0]
    work = scratch[0]
    remaining = scheme[0].h
    if s.substep == 0.0:
        s.substep = LARGEST
    while remaining > 1e-12:
        for i in range(12):
            s.largest[i] = max(s.largest[i], abs(s.motion[i]))
            work.origin[i] = s.motion[i]
            work.origin_rates[i] = s.rates[i]
        h = min(s.substep, remaining)
        runge_kutta(vessel, compact, scheme, state, scratch, h)
        for i in range(12):
            work.coarse[i] = s.motion[i]
        restart(state, scratch)
        runge_kutta(vessel, compact, scheme, state, scratch, 0.5 * h)
        rates(vessel, compact, scheme, state, scratch)
        runge_kutta(vessel, compact, scheme, state, scratch, 0.5 * h)
        error = worst_error(state, scratch)
        if error > 1.0 and h > SMALLEST:
            restart(state, scratch)
            s.substep = max(0.5 * h, SMALLEST)
        else:
            remaining -= h
            if remaining > 1e-12:
                rates(vessel, compact, scheme, state, scratch)
            if error < 1.0 / 32.0:
                s.substep = min(2.0 * max(h, s.substep), LARGEST)


@part
def advance(
    vessel: Record, compact: Record, scheme: Record, state: Record, scratch: Record
) -> None:
    """Advance the motion by one step of the scheme, controls held."""
    how = scheme[0]
    rates(vessel, compact, scheme, state, scratch)
    if how.method == ADAMS:
        adams(scheme, state)
    elif how.method == MULTISTEP:
        multistep(scheme, state)
    elif how.method == RUNGE_KUTTA:
        runge_kutta(vessel, compact, scheme, state, scratch, how.h)
    else:
        variable_runge_kutta(vessel, compact, scheme, state, scratch)

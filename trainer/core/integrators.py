"""One step of the twelve motion variables: linear multistep, predictor-corrector, Runge-Kutta.

``update`` calls ``advance`` once a tick, and the scheme says by which method. Past rates and
motions are kept in the state, because multistep methods look back; after a jump that history is
made anew. Controls are held over the step. [ASSES] III-B, errata D1-D10.
"""

from trainer.core.attitude import (
    bring_within,
    forget_rates,
    is_beyond,
    is_polar,
    take_attitude,
    turned,
)
from trainer.core.envelope import substeps
from trainer.core.kernel import Numbers, Record, inline_kernel, kernel
from trainer.core.rates import rates
from trainer.core.scheme import (
    ADAMS,
    MULTISTEP_CODES,
    PREDICTOR_CORRECTOR,
    RUNGE_KUTTA,
    VARIABLE_RUNGE_KUTTA,
)
from trainer.core.state import PAST_CYCLES, PHI, PSI, THETA, P, Q, R

NOW, BEFORE = 0, 1  # indices in a method's weights: this cycle's, and the last one's
MIN_STEP_S, MAX_STEP_S = 0.05, 2.0  # [s] variable step, [ASSES] III-B
STEP_TOLERANCE = 1e-3  # of each variable's largest value
MIN_SCALE = 0.01  # [m/s], [rad/s], [rad], [m] least value that a largest one counts as


@inline_kernel
def remember(state: Record) -> None:
    """Complete the history of the rates after a start or a jump.

    It is as if the present rate had always held: "Past rate = present rate" (errata D10).
    """
    s = state[0]
    if s.history == 0.0:
        for i in range(12):
            for back in range(PAST_CYCLES):
                s.past_rates[back, i] = s.rates[i]
        s.history = float(PAST_CYCLES)


@inline_kernel
def remember_motion(h: float, state: Record) -> None:
    """Complete the history of the motion likewise, for methods that look back on it."""
    s = state[0]
    if s.history == 0.0:
        for i in range(12):
            for back in range(PAST_CYCLES):
                s.past_motion[back, i] = s.motion[i] - (back + 1) * h * s.rates[i]


@inline_kernel
def recall(scheme: Record, state: Record) -> None:
    """Put sum a_i X_n-i in the place of the motion, and shift its history."""
    how = scheme[0]
    s = state[0]
    remember_motion(how.h, state)
    for i in range(12):
        value = how.a[0] * s.motion[i]
        for back in range(how.depth - 1):
            value += how.a[back + 1] * s.past_motion[back, i]
        for back in range(PAST_CYCLES - 1, 0, -1):
            s.past_motion[back, i] = s.past_motion[back - 1, i]
        s.past_motion[0, i] = s.motion[i]
        s.motion[i] = value


@inline_kernel
def shift_rates(state: Record) -> None:
    """Put the present rates at the head of the past ones.

    A row at a time costs least.
    """
    s = state[0]
    for back in range(PAST_CYCLES - 1, 0, -1):
        for i in range(12):
            s.past_rates[back, i] = s.past_rates[back - 1, i]
    for i in range(12):
        s.past_rates[0, i] = s.rates[i]


@inline_kernel
def adams_of(scheme: Record, terms: int, state: Record) -> None:
    """Advance by h sum b_i X'_n-i and shift the history of the rates.

    i runs up to ``terms``. Two terms, as most runs have, are written out: that makes vector code,
    with the same bits.
    """
    how = scheme[0]
    s = state[0]
    remember(state)
    h, now, before = how.h, how.b[NOW], how.b[BEFORE]
    if terms == 2:
        for i in range(12):
            s.motion[i] += h * (now * s.rates[i] + before * s.past_rates[0, i])
    else:
        for i in range(12):
            slope = now * s.rates[i]
            for back in range(terms - 1):
                slope += how.b[back + 1] * s.past_rates[back, i]
            s.motion[i] += h * slope
    shift_rates(state)


@inline_kernel
def adams(scheme: Record, state: Record) -> None:
    """Advance by the scheme's method, one of Adams' kind: a_1 = 1 and no other."""
    adams_of(scheme, scheme[0].depth, state)


@inline_kernel
def past_share(h: float, state: Record) -> float:
    """Return c [-] of Adams' second order over unequal steps.

    x += h((1 + c) x' - c x'_past).
    """
    last = state[0].last_step
    return 0.5 * h / last if last > 0.0 else 0.5


@inline_kernel
def adams_unequal(h: float, state: Record) -> None:
    """Advance by ``h`` [s] with second order, after a step of another length."""
    s = state[0]
    remember(state)
    share = past_share(h, state)
    for i in range(12):
        slope = (1.0 + share) * s.rates[i] - share * s.past_rates[0, i]
        s.motion[i] += h * slope
    shift_rates(state)


@inline_kernel
def turn_of(h: float, state: Record) -> tuple[float, float, float]:
    """Return the turn [rad] about the body's axes in a step of ``h`` [s].

    It is of second order.
    """
    s = state[0]
    share = past_share(h, state) if s.history != 0.0 else 0.0
    ahead = (1.0 + share) * h
    behind = share * h
    return (
        ahead * s.p - behind * s.last_p,
        ahead * s.q - behind * s.last_q,
        ahead * s.r - behind * s.last_r,
    )


@inline_kernel
def multistep_step(scheme: Record, h: float, state: Record) -> None:
    """Advance by ``h`` [s] from rates already computed; near the vertical by turning."""
    how = scheme[0]
    s = state[0]
    polar = how.envelope != 0 and is_polar(state)
    if s.polar != 0.0 and not polar:
        forget_rates(state)
    phi, theta, psi, turn = s.phi, s.theta, s.psi, (0.0, 0.0, 0.0)
    p, q, r = s.p, s.q, s.r
    if polar:
        turn = turn_of(h, state)
    if h != how.h or s.last_step not in (h, 0.0):
        adams_unequal(h, state)
    elif how.method == ADAMS:
        adams(scheme, state)
    else:
        multistep(scheme, state)
    if polar:
        heel, pitch, heading = turned(phi, theta, psi, turn)
        take_attitude(heel, pitch, heading, state)
    elif how.envelope != 0 and is_beyond(state):
        bring_within(state)
    s.last_p, s.last_q, s.last_r = p, q, r
    s.last_step = h
    s.polar = 1.0 if polar else 0.0


@inline_kernel
def multistep(scheme: Record, state: Record) -> None:
    """Advance by X_n = sum a_i X_n-i + h sum b_i X'_n-i, the scheme's method."""
    recall(scheme, state)
    adams(scheme, state)


@inline_kernel
def turn_from_start(share: float, turn: Numbers, state: Record, scratch: Record) -> None:
    """Turn the attitude from that at the step's start.

    It is turned for ``share`` [s] at ``turn`` [rad/s].
    """
    start = scratch[0].start
    along = (share * turn[P], share * turn[Q], share * turn[R])
    s = state[0]
    s.phi, s.theta, s.psi = turned(start[PHI], start[THETA], start[PSI], along)


@kernel
def stage(state: Record, scratch: Record, weight: float, share: float, polar: int) -> None:
    """Add ``weight`` of the present rates to the sum, and move ``share`` [s] along them."""
    s = state[0]
    work = scratch[0]
    for i in range(3):
        work.spin[i] = s.motion[3 + i]
        work.turn[i] += weight * s.motion[3 + i]
    for i in range(12):
        work.slope[i] += weight * s.rates[i]
        s.motion[i] = work.start[i] + share * s.rates[i]
    if polar != 0:
        turn_from_start(share, work.spin, state, scratch)


@kernel
def runge_kutta(
    vessel: Record, compact: Record, scheme: Record, state: Record, scratch: Record, h: float
) -> None:
    """Advance by ``h`` [s] with the scheme's stages from rates already computed."""
    how = scheme[0]
    s = state[0]
    work = scratch[0]
    polar = 1 if scheme[0].envelope != 0 and is_polar(state) else 0
    for i in range(12):
        work.start[i] = s.motion[i]
        work.slope[i] = 0.0
    for i in range(3):
        work.turn[i] = 0.0
    for number in range(how.stages):
        if number > 0:
            rates(vessel, compact, scheme, state, scratch)
        stage(state, scratch, how.weight[number], how.share[number] * h, polar)
    for i in range(12):
        s.motion[i] = work.start[i] + h / how.weight_sum * work.slope[i]
    if polar != 0:
        turn_from_start(h / how.weight_sum, work.turn, state, scratch)
    elif scheme[0].envelope != 0 and is_beyond(state):
        bring_within(state)


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
    """Return the local error [-] as a multiple of the tolerance.

    It compares one step with two halves.
    """
    s = state[0]
    work = scratch[0]
    worst = 0.0
    for i in range(12):
        allowed = STEP_TOLERANCE * max(s.largest[i], MIN_SCALE)
        ratio = abs(s.motion[i] - work.coarse[i]) / (15.0 * allowed)
        if not ratio <= worst:  # a NaN counts as the worst
            worst = ratio
    return worst


@kernel
def variable_runge_kutta(
    vessel: Record, compact: Record, scheme: Record, state: Record, scratch: Record
) -> None:
    """Advance by the scheme's step in substeps of 0.05 to 2 s.

    Each substep is halved or doubled by its error. Rates are already computed. This is the program
    KUTTA of [ASSES], by step doubling (errata D7).
    """
    s = state[0]
    work = scratch[0]
    remaining = scheme[0].h
    if s.substep == 0.0:
        s.substep = MAX_STEP_S
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
        if error > 1.0 and h > MIN_STEP_S:
            restart(state, scratch)
            s.substep = max(0.5 * h, MIN_STEP_S)
        else:
            remaining -= h
            if remaining > 1e-12:
                rates(vessel, compact, scheme, state, scratch)
            if error < 1.0 / 32.0:
                s.substep = min(2.0 * max(h, s.substep), MAX_STEP_S)


@inline_kernel
def look_back(a: Numbers, b: Numbers, depth: int, h: float, state: Record, out: Numbers) -> None:
    """Write sum a_i X_n-i + h sum b_i X'_n-i to ``out`` (12,).

    The present motion and rates are the first ones.
    """
    s = state[0]
    for i in range(12):
        value = a[0] * s.motion[i] + h * (b[0] * s.rates[i])
        for back in range(depth - 1):
            value += a[back + 1] * s.past_motion[back, i]
            value += h * (b[back + 1] * s.past_rates[back, i])
        out[i] = value


@inline_kernel
def shift_histories(state: Record) -> None:
    """Put the present motion and rates at the head of the past ones."""
    s = state[0]
    for i in range(12):
        for back in range(PAST_CYCLES - 1, 0, -1):
            s.past_motion[back, i] = s.past_motion[back - 1, i]
        s.past_motion[0, i] = s.motion[i]
    shift_rates(state)


@kernel
def predict_and_correct(
    vessel: Record, compact: Record, scheme: Record, state: Record, scratch: Record
) -> None:
    """Advance by the scheme's pair of formulas, open and closed, from rates already computed."""
    how = scheme[0]
    s = state[0]
    work = scratch[0]
    remember_motion(how.h, state)
    remember(state)
    look_back(how.a, how.b, how.depth, how.h, state, work.coarse)
    look_back(how.closed_a, how.closed_b[1:], how.depth, how.h, state, work.slope)
    shift_histories(state)
    for i in range(12):
        s.motion[i] = work.coarse[i]
    rates(vessel, compact, scheme, state, scratch)
    for i in range(12):
        s.motion[i] = work.slope[i] + how.h * (how.closed_b[0] * s.rates[i])
    if how.envelope != 0 and is_beyond(state):
        bring_within(state)


@kernel
def pair_step(
    vessel: Record, compact: Record, scheme: Record, state: Record, scratch: Record, h: float
) -> None:
    """Advance by ``h`` [s] with the scheme's pair of formulas.

    Near the vertical, and in a part of a step, Runge-Kutta is used, and the history begins anew.
    """
    how = scheme[0]
    if h == how.h and not (how.envelope != 0 and is_polar(state)):
        predict_and_correct(vessel, compact, scheme, state, scratch)
    else:
        runge_kutta(vessel, compact, scheme, state, scratch, h)
        state[0].history = 0.0


@inline_kernel
def forget_unequal(scheme: Record, state: Record) -> None:
    """Forget the history after substeps, unless the method can use it.

    Only Adams' second order goes on over steps of any length.
    """
    how = scheme[0]
    adams_2 = how.method == ADAMS and how.depth == 2 and how.b[0] == 1.5
    if not adams_2:
        state[0].history = 0.0


@inline_kernel
def advance(
    vessel: Record, compact: Record, scheme: Record, state: Record, scratch: Record
) -> None:
    """Advance the motion by one step of the scheme, controls held.

    The step is divided into parts where it must be.
    """
    how = scheme[0]
    several = how.method in MULTISTEP_CODES
    looks_back = several or how.method == PREDICTOR_CORRECTOR
    count = 1
    if how.envelope != 0 and how.method != VARIABLE_RUNGE_KUTTA:
        count = substeps(vessel, how.h, int(looks_back) * int(scratch[0].cut), state)
    h = how.h / count if count > 1 else how.h
    for _ in range(count):
        rates(vessel, compact, scheme, state, scratch)
        if several:
            multistep_step(scheme, h, state)
        elif how.method == RUNGE_KUTTA:
            runge_kutta(vessel, compact, scheme, state, scratch, h)
        elif how.method == PREDICTOR_CORRECTOR:
            pair_step(vessel, compact, scheme, state, scratch, h)
        else:
            variable_runge_kutta(vessel, compact, scheme, state, scratch)
    if count > 1:
        forget_unequal(scheme, state)

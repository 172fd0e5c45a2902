"""The likelihood of a record by an extended Kalman filter, with slopes by the coefficients.

A pass goes along the readings: each one corrects the state, then the motion goes on to the next
time. Slopes are those of the state's mean, the gain held. The innovations are a martingale
difference and each slope depends on the past alone, so the sum of innovation times slope has the
mean zero at the truth; the equations that ``search`` solves are therefore unbiased, and the sum of
squared slopes is their information. No derivative of the covariance is needed.

[Jaz] Jazwinski, Stochastic Processes and Filtering Theory (1970), ch. 8: the filter. [Lju] Ljung,
System Identification (1999), ch. 7: the likelihood by innovations.
"""

import math
from typing import Final, NamedTuple

import numpy as np

from trainer.core.kernel import Numbers
from trainer.identify.boat.motion import (
    BODY_PLACES,
    MOTION_COUNT,
    STATE,
    STATE_COUNT,
    BoatNumbers,
    product,
    write_rates,
)
from trainer.identify.boat.regressors import ATOM_PLACES
from trainer.identify.kernels.kernel import kernel, lean_kernel

CHANNEL_NAMES: Final = ("speed", "heading", "pitch", "roll", "depth", "p", "q", "r", "ground_speed")
CHANNEL_COUNT: Final = len(CHANNEL_NAMES)
SPEED_CHANNEL, GROUND_CHANNEL = CHANNEL_NAMES.index("speed"), CHANNEL_NAMES.index("ground_speed")
# by channel, of those that read a state as it is: that, and the error of its gauge
ANGLE_ROWS: Final = (
    (STATE.PSI, -1),
    (STATE.THETA, STATE.PITCH_ERROR),
    (STATE.PHI, STATE.ROLL_ERROR),
)
RATE_ROWS: Final = ((STATE.P, -1), (STATE.Q, -1), (STATE.R, -1))
READ_STATES: Final = np.array([(-1, -1), *ANGLE_ROWS, (STATE.Z, -1), *RATE_ROWS, (-1, -1)])
DRIVEN_COUNT: Final = 6  # accelerations that a disturbance drives
# differences for the Jacobian: u v w p q r phi theta, then weight and trim
SLOPE_STEPS: Final = 1e-5 * np.array([1.0, 0.1, 0.1, 0.01, 0.01, 0.01, 0.1, 0.1, 1e-3, 1e-2])
SLOPE_STATES: Final = np.array(
    [*range(STATE.THETA + 1), STATE.WEIGHT, STATE.TRIM]
)  # whose rates the motion has; heading and depth change none
ROLLING, PITCHING = 3, 4  # rows of forces
MAX_SPEED_M_S, MAX_PITCH_RAD = 100.0, 1.5  # beyond, the motion is none of a boat


class RecordNumbers(NamedTuple):
    """A record as kernels take it: readings are NaN where there is none."""

    readings: Numbers  # (n, CHANNEL_COUNT)
    inputs: Numbers  # (n, 4) of motion.CONTROL, straight between readings
    interval: float  # [s] from reading to reading
    steps: int  # of Runge and Kutta in it


class FilterStart(NamedTuple):
    """The state at the first reading, and how it goes astray."""

    state: Numbers  # (STATE_COUNT,)
    covariance: Numbers  # (STATE_COUNT, STATE_COUNT)
    disturbance: Numbers  # (6,) [m/s2, rad/s2 per root of Hz] of the accelerations
    walk: Numbers  # (7,) densities by which the slow states walk
    errors: Numbers  # (CHANNEL_COUNT,) standard deviations of readings
    gate: float  # [-] deviations of an innovation, beyond which a reading is wild


class FilterResult(NamedTuple):
    """What a pass leaves. Innovations are NaN where nothing was read."""

    cost: float  # minus the logarithm of the likelihood; infinite if the boat does not fly it
    innovations: Numbers  # (n, CHANNEL_COUNT)
    variances: Numbers  # (n, CHANNEL_COUNT)
    states: Numbers  # (n, STATE_COUNT) after the readings
    covariance: Numbers  # of the last
    gradient: Numbers  # (m,) of the cost by the parameters
    information: Numbers  # (m, m)


class PassRoom(NamedTuple):
    """Scratch of a pass."""

    atoms: Numbers
    force: Numbers
    rate: Numbers
    stage: Numbers
    total: Numbers
    control: Numbers  # (3, 4) at begin, middle and end of a step
    A: Numbers
    AA: Numbers
    G: Numbers
    Phi: Numbers
    work: Numbers
    row: Numbers
    h: Numbers  # slopes of a reading by the state
    gain: Numbers  # the same times the covariance
    J: Numbers  # slopes of an innovation by the parameters


class RowSums(NamedTuple):
    """Where the readings of one time go."""

    innovations: Numbers  # (CHANNEL_COUNT,)
    variances: Numbers
    gradient: Numbers
    information: Numbers
    room: PassRoom


@kernel
def _new_room(count: int) -> PassRoom:
    """Return scratch for a pass with slopes by ``count`` parameters."""
    n, size = STATE_COUNT, MOTION_COUNT
    return PassRoom(
        np.zeros(ATOM_PLACES.RDOT + 1),
        np.zeros(6),
        np.zeros(size),
        np.zeros(n),
        np.zeros(size),
        np.zeros((3, 4)),
        np.zeros((size, n)),
        np.zeros((size, n)),
        np.zeros((size, n)),
        np.zeros((size, n)),
        np.zeros((size, max(count, n))),
        np.zeros(max(count, n)),
        np.zeros(n),
        np.zeros(n),
        np.zeros(count),
    )


@lean_kernel
def predict_reading(x: Numbers, channel: int, h: Numbers) -> float:
    """Return what a channel should read, and write its slopes by the state to ``h``."""
    for i in range(STATE_COUNT):
        h[i] = 0.0
    if channel == SPEED_CHANNEL:  # the log, in the water
        h[STATE.U], h[STATE.LOG_ERROR] = 1.0 + x[STATE.LOG_ERROR], x[STATE.U]
        return x[STATE.U] * (1.0 + x[STATE.LOG_ERROR])
    if channel == GROUND_CHANNEL:  # ahead over ground
        cosine, sine = math.cos(x[STATE.PSI]), math.sin(x[STATE.PSI])
        h[STATE.U], h[STATE.NORTH], h[STATE.EAST] = 1.0, cosine, sine
        h[STATE.PSI] = x[STATE.EAST] * cosine - x[STATE.NORTH] * sine
        return x[STATE.U] + x[STATE.NORTH] * cosine + x[STATE.EAST] * sine
    value = 0.0
    for k in range(READ_STATES.shape[1]):  # a state, and its gauge's error where it has one
        at = READ_STATES[channel, k]
        if at >= 0:
            h[at] = 1.0
            value += x[at]
    return value


@lean_kernel
def _set_controls(inputs: Numbers, k: int, begin: float, end: float, control: Numbers) -> None:
    """Write the controls at begin, middle and end of a step, straight between readings."""
    last = min(k + 1, inputs.shape[0] - 1)
    for i in range(inputs.shape[1]):
        change = inputs[last, i] - inputs[k, i]
        control[0, i] = inputs[k, i] + begin * change
        control[1, i] = inputs[k, i] + 0.5 * (begin + end) * change
        control[2, i] = inputs[k, i] + end * change


@lean_kernel
def step_motion(boat: BoatNumbers, x: Numbers, h: float, room: PassRoom) -> None:
    """Move a state on by ``h`` [s], by the four stages of Runge and Kutta."""
    for i in range(STATE_COUNT):
        room.stage[i] = x[i]
    for i in range(MOTION_COUNT):
        room.total[i] = 0.0
    for stage in range(4):
        controls = room.control[(stage + 1) // 2]
        write_rates(boat, room.stage, controls, room.atoms, room.force, room.rate)
        weight = 1.0 / 6.0 if stage in (0, 3) else 1.0 / 3.0
        ahead = h if stage == 2 else 0.5 * h
        for i in range(MOTION_COUNT):
            room.total[i] += weight * room.rate[i]
            room.stage[i] = x[i] + ahead * room.rate[i]
    for i in range(MOTION_COUNT):
        x[i] += h * room.total[i]


@lean_kernel
def _set_transition(boat: BoatNumbers, middle: Numbers, h: float, room: PassRoom) -> None:
    """Write Phi of a step, G by which rates act on its end, and the products at its middle.

    G = h (I + h/2 A (I + h/3 A)), Phi = I + G A: the exponential to the third power. Slopes are
    taken away from zero, because some forces have a step where drift or heave changes its sign, and
    a slope across it is none.
    """
    control, n = room.control[1], STATE_COUNT
    for i in range(MOTION_COUNT):
        for j in range(n):
            room.A[i, j] = 0.0
    for k in range(SLOPE_STATES.size):
        j = SLOPE_STATES[k]
        kept = middle[j]
        middle[j] = kept + math.copysign(SLOPE_STEPS[k], kept)
        write_rates(boat, middle, control, room.atoms, room.force, room.rate)
        middle[j] = kept
        for i in range(MOTION_COUNT):
            room.A[i, j] = room.rate[i]
    # the middle itself comes last: its products and accelerations are what slopes are made of
    write_rates(boat, middle, control, room.atoms, room.force, room.rate)
    for k in range(SLOPE_STATES.size):
        j = SLOPE_STATES[k]
        for i in range(MOTION_COUNT):
            step = math.copysign(SLOPE_STEPS[k], middle[j])
            room.A[i, j] = (room.A[i, j] - room.rate[i]) / step
    _multiply(room.A, room.A, room.AA)
    for i in range(MOTION_COUNT):
        for j in range(n):
            room.G[i, j] = h * (0.5 * h * room.A[i, j] + h * h / 6.0 * room.AA[i, j])
        room.G[i, i] += h
    _multiply(room.G, room.A, room.Phi)
    for i in range(MOTION_COUNT):
        room.Phi[i, i] += 1.0


@lean_kernel
def _multiply(left: Numbers, right: Numbers, out: Numbers) -> None:
    """Write the product of two matrices (10, 17), whose slow rows are zero and left out."""
    for i in range(MOTION_COUNT):
        for j in range(STATE_COUNT):
            out[i, j] = 0.0
        for k in range(MOTION_COUNT):
            factor = left[i, k]
            for j in range(STATE_COUNT):
                out[i, j] += factor * right[k, j]


@lean_kernel
def _carry_slopes(boat: BoatNumbers, x: Numbers, S: Numbers, room: PassRoom) -> None:
    """Carry the slopes (17, m) over a step: S = Phi S + G inv(M) (what each coefficient pushes)."""
    count = S.shape[1]
    for i in range(MOTION_COUNT):
        for j in range(count):
            room.work[i, j] = 0.0
        for k in range(STATE_COUNT):
            factor = room.Phi[i, k]
            for j in range(count):
                room.work[i, j] += factor * S[k, j]
    _push_slopes(boat, x, count, room)
    for i in range(MOTION_COUNT):
        for j in range(count):
            S[i, j] = room.work[i, j]


@lean_kernel
def _push_slopes(boat: BoatNumbers, x: Numbers, count: int, room: PassRoom) -> None:
    """Add what each parameter pushes in a step; the last is the height of buoyancy."""
    last = count - 1
    for j in range(last):
        room.row[j] = product(boat.factors, j, room.atoms) * boat.scales[j]
    buoyancy = boat.body[BODY_PLACES.BUOYANCY]
    rolling = buoyancy * math.cos(x[STATE.THETA]) * math.sin(x[STATE.PHI])
    pitching = buoyancy * math.sin(x[STATE.THETA])
    for i in range(MOTION_COUNT):
        for row in range(6):  # a force's whole effect on the state
            effect = 0.0
            for k in range(6):
                effect += room.G[i, k] * boat.inverse[k, row]
            room.AA[i, row] = effect
        for j in range(last):
            room.work[i, j] += room.AA[i, boat.rows[j]] * room.row[j]
        room.work[i, last] += room.AA[i, ROLLING] * rolling + room.AA[i, PITCHING] * pitching


@lean_kernel
def _carry_covariance(P: Numbers, start: FilterStart, h: float, room: PassRoom) -> None:
    """Carry the covariance over a step, with what disturbances and slow walks add.

    The slow states stand still, so Phi has the unit matrix there, and their own block stays.
    """
    n, Phi, work = STATE_COUNT, room.Phi, room.work
    for i in range(MOTION_COUNT):  # Phi P
        for j in range(n):
            work[i, j] = 0.0
        for k in range(n):
            factor = Phi[i, k]
            for j in range(n):
                work[i, j] += factor * P[k, j]
    for i in range(MOTION_COUNT):
        for j in range(i + 1):  # (Phi P) Phi'
            total = 0.0
            for k in range(n):
                total += work[i, k] * Phi[j, k]
            P[i, j], P[j, i] = total, total
        for j in range(MOTION_COUNT, n):
            P[i, j], P[j, i] = work[i, j], work[i, j]
    _disturb(P, start, h, room)


@lean_kernel
def _disturb(P: Numbers, start: FilterStart, h: float, room: PassRoom) -> None:
    """Add half the disturbances of a step at its begin and half at its end, and the walks."""
    Phi, variance = room.Phi, room.force
    for k in range(DRIVEN_COUNT):
        variance[k] = 0.5 * h * start.disturbance[k] * start.disturbance[k]
        P[k, k] += variance[k]
    for i in range(MOTION_COUNT):
        for j in range(i + 1):
            added = 0.0
            for k in range(DRIVEN_COUNT):
                added += Phi[i, k] * variance[k] * Phi[j, k]
            P[i, j] += added
            P[j, i] = P[i, j]
    for i in range(MOTION_COUNT, STATE_COUNT):
        P[i, i] += h * start.walk[i - MOTION_COUNT] * start.walk[i - MOTION_COUNT]


@lean_kernel
def _spread_reading(P: Numbers, h: Numbers, error: float, g: Numbers) -> float:
    """Write P h to ``g``, and return the variance of the innovation."""
    for i in range(STATE_COUNT):
        g[i] = 0.0
    for j in range(STATE_COUNT):
        if h[j] != 0.0:
            for i in range(STATE_COUNT):
                g[i] += P[j, i] * h[j]
    variance = error * error
    for i in range(STATE_COUNT):
        variance += h[i] * g[i]
    return variance


@lean_kernel
def _take_reading(
    x: Numbers, P: Numbers, S: Numbers, innovation: float, variance: float, room: PassRoom
) -> None:
    """Correct state, covariance and slopes by one reading."""
    g, J = room.gain, room.J
    for i in range(STATE_COUNT):
        gain = g[i] / variance
        x[i] += gain * innovation
        for j in range(STATE_COUNT):
            P[i, j] -= gain * g[j]
        for j in range(S.shape[1]):
            S[i, j] += gain * J[j]


@lean_kernel
def _slope_reading(S: Numbers, h: Numbers, J: Numbers) -> None:
    """Write the slopes of an innovation by the parameters to ``J``: -h'S."""
    for j in range(S.shape[1]):
        J[j] = 0.0
    for i in range(STATE_COUNT):
        if h[i] != 0.0:
            for j in range(S.shape[1]):
                J[j] -= h[i] * S[i, j]


@lean_kernel
def _add_information(
    J: Numbers, innovation: float, variance: float, gradient: Numbers, information: Numbers
) -> None:
    """Add one reading, whose innovation has the slopes ``J``."""
    for i in range(gradient.size):
        weighted = J[i] / variance
        gradient[i] += weighted * innovation
        for j in range(i + 1):
            information[i, j] += weighted * J[j]


@lean_kernel
def _read_row(
    readings: Numbers, x: Numbers, P: Numbers, S: Numbers, start: FilterStart, row: RowSums
) -> float:
    """Take all readings of one time; return what they add to the cost."""
    room, cost = row.room, 0.0
    for channel in range(CHANNEL_COUNT):
        if math.isnan(readings[channel]):
            continue
        innovation = readings[channel] - predict_reading(x, channel, room.h)
        variance = _spread_reading(P, room.h, start.errors[channel], room.gain)
        size = innovation * innovation / variance
        cost += 0.5 * (math.log(2.0 * math.pi * variance) + min(size, start.gate * start.gate))
        if size > start.gate * start.gate:  # a wild reading moves nothing
            continue
        _slope_reading(S, room.h, room.J)
        row.innovations[channel], row.variances[channel] = innovation, variance
        _add_information(room.J, innovation, variance, row.gradient, row.information)
        _take_reading(x, P, S, innovation, variance, room)
    return cost


@lean_kernel
def _is_lost(x: Numbers) -> bool:
    """Return whether a state is none of a boat."""
    lost = not abs(x[STATE.THETA]) < MAX_PITCH_RAD
    for i in range(STATE.W + 1):
        lost = lost or not abs(x[i]) < MAX_SPEED_M_S
    return lost


@kernel
def filter_record(
    boat: BoatNumbers, record: RecordNumbers, start: FilterStart, count: int
) -> FilterResult:
    """Return a pass over a record, with slopes by ``count`` parameters: all or none."""
    n, step = record.readings.shape[0], record.interval / record.steps
    x, P = start.state.copy(), start.covariance.copy()
    S, room = np.zeros((STATE_COUNT, count)), _new_room(count)
    innovations = np.full((n, CHANNEL_COUNT), np.nan)
    variances, states = np.full((n, CHANNEL_COUNT), np.nan), np.full((n, STATE_COUNT), np.nan)
    gradient, information = np.zeros(count), np.zeros((count, count))
    middle, cost = np.zeros(STATE_COUNT), 0.0
    for k in range(n):
        row = RowSums(innovations[k], variances[k], gradient, information, room)
        cost += _read_row(record.readings[k], x, P, S, start, row)
        states[k] = x
        for part in range(record.steps if k < n - 1 else 0):
            begin, end = part / record.steps, (part + 1) / record.steps
            _set_controls(record.inputs, k, begin, end, room.control)
            middle[:] = x
            step_motion(boat, x, step, room)
            if _is_lost(x):
                cost = math.inf
                return FilterResult(cost, innovations, variances, states, P, gradient, information)
            for i in range(MOTION_COUNT):
                middle[i] = 0.5 * (middle[i] + x[i])
            _set_transition(boat, middle, step, room)
            if count > 0:
                _carry_slopes(boat, middle, S, room)
            _carry_covariance(P, start, step, room)
    for i in range(count):
        for j in range(i):
            information[j, i] = information[i, j]
    return FilterResult(cost, innovations, variances, states, P, gradient, information)


@kernel
def sail_controls(boat: BoatNumbers, record: RecordNumbers, state: Numbers) -> Numbers:
    """Return the states (n, STATE_COUNT) that inputs alone lead to; NaN once it is lost."""
    n, step = record.inputs.shape[0], record.interval / record.steps
    states, x, room = np.full((n, STATE_COUNT), np.nan), state.copy(), _new_room(0)
    for k in range(n):
        states[k] = x
        for part in range(record.steps):
            begin, end = part / record.steps, (part + 1) / record.steps
            _set_controls(record.inputs, k, begin, end, room.control)
            step_motion(boat, x, step, room)
        if _is_lost(x):
            break
    return states

"""The forces of a ship with hull polynomials, slipstream, wake and rudder, as accelerations.

``motion`` sails ships by them, and ``identify`` fits their coefficients. Rudder, slipstream and
wake are those of Yasukawa and Yoshimura 2015 (J Mar Sci Technol 20, 37-52), their wake with C1 = 2.
Every term is an acceleration in prime units times U^2/L, so that no mass is needed. The terms are
forward numbers, whose directions are u, v, r, then gamma, l, kappa, c_w and gamma_a. A positive
rudder turns the ship to starboard here.

A ship may also roll: its state then has roll rate and roll behind u, v, r and heading, and roll has
a fourth equation. A term may be multiplied by roll rate or by roll. A term's part is a number that
says which equation it is in and by what it is multiplied: 0 to 3 by nothing, 4 to 7 by roll rate,
8 to 11 by roll. Accelerations have a row for each part.
"""

import math
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from trainer.boat.ship.forward_numbers import (
    DIRECTION_COUNT,
    SLOPES,
    VALUE,
    Quantity,
    quantities,
    run_steps,
)
from trainer.core.kernel import Numbers, inline_kernel, kernel

Terms = NDArray[np.int64]
DrivenStates = tuple[int, ...]  # indices of what the equations accelerate


class Units(NamedTuple):
    """The units of terms, and the two motions by which terms are multiplied."""

    length: float
    stiffness: float  # of roll
    roll_rate: float
    roll: float


class System(NamedTuple):
    """A ship as the kernels take it.

    The length of ``driven`` is known to the compiler.
    """

    ship: Numbers
    terms: Terms  # their parts and rows
    values: Numbers  # their factors, and what follows them
    free: Terms  # indices of the free ones
    driven: DrivenStates


PART, ROW = 0, 1  # columns of the terms
LENGTH: Final = 0  # index in the ship's numbers
U, V, R = 0, 1, 2  # indices in the state
RUDDER, TURNS, WIND_AHEAD, WIND_ASIDE = 0, 1, 2, 3  # indices in the inputs
NONLINEAR_COUNT: Final = 5  # coefficients that are not factors of a term
SHIP_NUMBER_COUNT: Final = 6  # length, propeller diameter, three coefficients of K_T, 1-w
ADVANCE_INDEX: Final = 6  # index of the ship's own advance [m] a turn, after these
STIFFNESS_INDEX: Final = 7  # and of g GM/k^2 [1/s^2] of roll
ROLL_RATE_INDEX, ROLL_INDEX = 4, 5  # indices in the state
LEVEL_EQUATIONS: Final = (0, 1, 2)  # equations without roll
HEEL_EQUATIONS: Final = (0, 1, 2, ROLL_RATE_INDEX)  # and with it
AXIS_COUNT: Final = len(HEEL_EQUATIONS)
PART_COUNT: Final = 3 * AXIS_COUNT
# further constants: rudder, its sine and cosine, revolutions, wind, the speed that the revolutions
# hold, and numbers of the equations
INPUT_COUNT: Final = 8
TERM_NUMBERS: Final = (0.0, 1.0, 2.0, -2.0, 8.0 / math.pi, 0.48, 0.85, 1e-4)
CONSTANT_COUNT: Final = SHIP_NUMBER_COUNT + INPUT_COUNT + len(TERM_NUMBERS)


def _terms() -> tuple[dict[str, int], list[tuple[int, int, int]]]:
    """Return the row of each term, and the steps that lead to them.

    v' = v/U and r' = rL/U. The propeller meets the drift of a point 0.48 L behind midships;
    0.85 is propeller over rudder height; |z| is sqrt(z^2 + 1e-4). Last come the terms of Abkowitz
    1964 beside the cubes, whose u' is (u - u_n)/U: u_n is the speed that the revolutions hold.
    """
    rows = quantities(DIRECTION_COUNT, CONSTANT_COUNT)
    u, v, r, gamma, lever, kappa, c_w, gamma_a = rows[:DIRECTION_COUNT]
    L, D, k0, k1, k2, one_w = rows[DIRECTION_COUNT : DIRECTION_COUNT + SHIP_NUMBER_COUNT]
    delta, sine, cosine, n, side, both, ahead, u_n = rows[DIRECTION_COUNT + SHIP_NUMBER_COUNT :][
        :INPUT_COUNT
    ]
    zero, one, two, minus_two, jet, behind, covered, small = rows[-len(TERM_NUMBERS) :]

    def size(z: Quantity) -> Quantity:
        return (z * z + small).root()

    UU = u * u + v * v
    U = UU.root()
    per_length = UU / L
    v_, r_ = v / U, r * L / U
    beta_P = v_ - behind * r_
    u_P = one_w * u * (one + c_w * (one - (minus_two * size(beta_P)).exponential()))
    tip = n * D
    pull = k0 * tip * tip + k1 * tip * u_P + k2 * u_P * u_P
    T_ = two * D * D / (L * L) * pull / UU
    q = (u_P * u_P + jet * pull).root()
    mean = u_P + kappa * (q - u_P)
    u_R = (covered * mean * mean + (one - covered) * u_P * u_P).root()
    b = (v + lever * L * r) / U
    v_R = zero - U * (gamma * b + gamma_a * size(b))
    F = (u_R * u_R + v_R * v_R).root() * (u_R * sine - v_R * cosine) / UU
    vv, rr = v_ * v_, r_ * r_
    terms = {
        "1": one * per_length,
        "T": T_ * per_length,
        "v": v_ * per_length,
        "r": r_ * per_length,
        "d": delta * per_length,
        "ur": (u / U - one) * r_ * per_length,
        "vvd": vv * delta * per_length,
        "Td": T_ * delta * per_length,
        "vvv": vv * v_ * per_length,
        "vvr": vv * r_ * per_length,
        "vrr": v_ * rr * per_length,
        "rrr": r_ * rr * per_length,
        "F": F * cosine * per_length,
        "w": side / L,
        "ww": both / L,
        "vv": vv * per_length,
        "vr": v_ * r_ * per_length,
        "rr": rr * per_length,
        "dd": delta * delta * per_length,
        "X_F": zero - F * sine * per_length,
        "X_w": ahead / L,
    }
    u_, dd = (u - u_n) / U, delta * delta
    uu = u_ * u_
    terms |= {
        "u": u_ * per_length,
        "uu": uu * per_length,
        "uuu": uu * u_ * per_length,
        "udd": u_ * dd * per_length,
        "vd": v_ * delta * per_length,
        "uvd": u_ * v_ * delta * per_length,
        "vu": v_ * u_ * per_length,
        "ru": r_ * u_ * per_length,
        "ud": u_ * delta * per_length,
        "uud": uu * delta * per_length,
        "ddd": dd * delta * per_length,
        "vdd": v_ * dd * per_length,
    }
    return {name: term.row for name, term in terms.items()}, u.steps


TERM_ROWS, _STEP_LIST = _terms()
TERM_ROWS["one"] = DIRECTION_COUNT + SHIP_NUMBER_COUNT + INPUT_COUNT + TERM_NUMBERS.index(1.0)
TERM_STEPS: Final = np.array(_STEP_LIST)
ROW_COUNT: Final = DIRECTION_COUNT + CONSTANT_COUNT + len(TERM_STEPS)
LITERAL_VALUES: Final = np.array(TERM_NUMBERS)


@kernel
def _hold(table: Numbers, row: int, value: float) -> None:
    """Write a constant to a row: a value without derivatives."""
    for i in range(table.shape[1]):
        table[row, i] = 0.0
    table[row, VALUE] = value


@kernel
def set_terms(table: Numbers, ship: Numbers, x: Numbers, c: Numbers, rudder: Numbers) -> None:
    """Write every term at state ``x`` (u, v, r) and inputs ``c``, times U^2/L.

    ``ship`` is length, propeller diameter, three coefficients of K_T, 1-w and the advance a turn,
    then the stiffness of roll;
    ``c`` is rudder [rad], revolutions [1/s] and relative wind from ahead and from starboard [m/s];
    ``rudder`` is gamma, l, kappa, c_w and gamma_a. A table of fewer rows has fewer terms.
    """
    for i in range(DIRECTION_COUNT):
        _hold(table, i, x[i] if i < 3 else rudder[i - 3])
        if SLOPES + i < table.shape[1]:
            table[i, SLOPES + i] = 1.0
    for i in range(SHIP_NUMBER_COUNT):
        _hold(table, DIRECTION_COUNT + i, ship[i])
    angle, turns, ahead, aside = c[RUDDER], c[TURNS], c[WIND_AHEAD], c[WIND_ASIDE]
    wind = math.sqrt(ahead * ahead + aside * aside + 1e-4)
    helm = angle, math.sin(angle), math.cos(angle), turns
    inputs = (*helm, aside * wind, ahead * aside, ahead * wind, ship[ADVANCE_INDEX] * turns)
    for i in range(INPUT_COUNT):
        _hold(table, DIRECTION_COUNT + SHIP_NUMBER_COUNT + i, inputs[i])
    for i in range(LITERAL_VALUES.size):
        _hold(table, DIRECTION_COUNT + SHIP_NUMBER_COUNT + INPUT_COUNT + i, LITERAL_VALUES[i])
    run_steps(table, TERM_STEPS, DIRECTION_COUNT + CONSTANT_COUNT)


@kernel
def rows_of(terms: Terms) -> int:
    """Return how many rows of a table these terms need."""
    most = 0
    for j in range(terms.shape[0]):
        most = max(most, terms[j, ROW] + 1)
    return most


@inline_kernel
def units_of(ship: Numbers, x: Numbers) -> Units:
    """Return length and stiffness with the last two of the state."""
    return Units(ship[LENGTH], ship[STIFFNESS_INDEX], x[x.size - 2], x[x.size - 1])


@inline_kernel
def in_units(factor: float, part: int, units: Units) -> float:
    """Return a factor in the units of its part.

    Yaw and roll are over the length. Roll's own stiffness and damping are in units of those that
    the ship's file says.
    """
    if part < 2:
        return factor
    if part in (2, 3, 2 * AXIS_COUNT + 2):
        return factor / units.length
    if part == AXIS_COUNT + 3:
        return factor * math.sqrt(units.stiffness)
    return factor * units.stiffness if part == 2 * AXIS_COUNT + 3 else factor


@kernel
def add_terms(table: Numbers, terms: Terms, factors: Numbers, ship: Numbers, out: Numbers) -> None:
    """Write accelerations as forward numbers (parts, columns); ``terms`` are (part, row).

    Without roll there are three parts: du/dt, dv/dt and dr/dt.
    """
    units = units_of(ship, ship)
    for e in range(out.shape[0]):
        for i in range(out.shape[1]):
            out[e, i] = 0.0
    for j in range(terms.shape[0]):
        part = terms[j, PART]
        factor = in_units(factors[j], part, units)
        for i in range(out.shape[1]):
            out[part, i] += factor * table[terms[j, ROW], i]


@kernel
def add_heel(x: Numbers, out: Numbers) -> None:
    """Add to the accelerations what is times roll rate and roll."""
    for e in range(AXIS_COUNT):
        for i in range(out.shape[1]):
            heeled = (
                x[ROLL_RATE_INDEX] * out[AXIS_COUNT + e, i]
                + x[ROLL_INDEX] * out[2 * AXIS_COUNT + e, i]
            )
            out[e, i] += heeled


@inline_kernel
def states_of(driven: DrivenStates) -> int:
    """Return how many states there are.

    Each equation has its speed; all but surge and sway have an angle too.
    """
    return 2 * len(driven) - 2

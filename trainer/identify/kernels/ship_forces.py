"""The forces of a ship with hull polynomials, slipstream, wake and rudder, as accelerations.

Rudder, slipstream and wake are those of Yasukawa and Yoshimura 2015 (J Mar Sci Technol 20, 37-52),
their wake with C1 = 2. Every term is an acceleration in prime units times U^2/L, so that no mass
is needed. Rows of the table are forward numbers: directions are u, v, r, then gamma, l, kappa,
c_w and gamma_a. A positive rudder turns the ship to starboard here.
"""

import math
from typing import Final

import numpy as np
from numpy.typing import NDArray

from trainer.core.kernel import Numbers
from trainer.identify.kernels.forward_numbers import (
    combine,
    decay,
    hold,
    invert,
    multiply,
    root,
    scale,
    second_place,
    vary,
)
from trainer.identify.kernels.kernel import lean

Terms = NDArray[np.int64]

# rows of the terms: sway and yaw have the first fifteen, surge the first two and the last six
ONE, THRUST, SWAY, YAW, HELM, SLOW, VVD, TD, VVV, VVR, VRR, RRR, FORCE, WIND, WIND_2 = range(15)
VV, VR, RR, DD, DRAG, HEADWIND = range(15, 21)
TERMS: Final = 21
# and of the work
U, V, R, GAMMA, LEVER, KAPPA, WAKE, UNEQUAL = range(TERMS, TERMS + 8)
SPEED, INVERSE, PER_LENGTH, INFLOW, PULL, JET, AHEAD, ACROSS, FIRST_WORK, SECOND_WORK = range(
    TERMS + 8, TERMS + 18
)
ROWS: Final = TERMS + 18
NONLINEAR: Final = 5  # coefficients that are not factors of a term
BEHIND: Final = 0.48  # [-] of the length: the propeller's place, where drift is taken
COVERED: Final = 0.85  # [-] of the rudder in the slipstream: propeller over rudder height
SMOOTH: Final = 1e-4  # [-] square of the size at which |z| is rounded


@lean
def _smooth_size(table: Numbers, a: int, out: int) -> None:
    """Write sqrt(z^2 + SMOOTH), a smooth |z|."""
    multiply(table, a, a, out)
    scale(table, out, 1.0, SMOOTH, out)
    root(table, out, out)


@lean
def _set_motion(table: Numbers, x: Numbers, rudder: Numbers, length: float) -> None:
    """Write the variables, U, 1/U, U^2/L, and v' and r'."""
    for i in range(3):
        vary(table, U + i, x[i], i)
    for i in range(NONLINEAR):
        vary(table, GAMMA + i, rudder[i], 3 + i)
    multiply(table, U, U, FIRST_WORK)
    multiply(table, V, V, SECOND_WORK)
    combine(table, (FIRST_WORK, 1.0), (SECOND_WORK, 1.0), FIRST_WORK)
    scale(table, FIRST_WORK, 1.0 / length, 0.0, PER_LENGTH)
    root(table, FIRST_WORK, SPEED)
    invert(table, SPEED, INVERSE)
    multiply(table, V, INVERSE, SWAY)
    multiply(table, R, INVERSE, YAW)
    scale(table, YAW, length, 0.0, YAW)


@lean
def _set_inflow(table: Numbers, ship: Numbers, turns: float) -> None:
    """Write inflow u_P, thrust per rho D^2, T' and the slipstream's speed q."""
    length, diameter = ship[0], ship[1]
    combine(table, (SWAY, 1.0), (YAW, -BEHIND), FIRST_WORK)
    _smooth_size(table, FIRST_WORK, FIRST_WORK)
    decay(table, FIRST_WORK, 2.0, FIRST_WORK)
    scale(table, FIRST_WORK, -1.0, 1.0, FIRST_WORK)
    multiply(table, FIRST_WORK, WAKE, FIRST_WORK)
    scale(table, FIRST_WORK, ship[5], ship[5], FIRST_WORK)
    multiply(table, U, FIRST_WORK, INFLOW)
    multiply(table, INFLOW, INFLOW, FIRST_WORK)
    tip = turns * diameter
    combine(table, (FIRST_WORK, ship[4]), (INFLOW, ship[3] * tip), PULL)
    scale(table, PULL, 1.0, ship[2] * tip * tip, PULL)
    combine(table, (FIRST_WORK, 1.0), (PULL, 8.0 / math.pi), JET)
    root(table, JET, JET)
    multiply(table, INVERSE, INVERSE, SECOND_WORK)
    multiply(table, PULL, SECOND_WORK, THRUST)
    scale(table, THRUST, 2.0 * diameter * diameter / (length * length), 0.0, THRUST)


@lean
def _set_rudder_flow(table: Numbers, length: float) -> None:
    """Write the flow at the rudder, u_R ahead and v_R across."""
    combine(table, (JET, 1.0), (INFLOW, -1.0), FIRST_WORK)
    multiply(table, FIRST_WORK, KAPPA, FIRST_WORK)
    combine(table, (FIRST_WORK, 1.0), (INFLOW, 1.0), FIRST_WORK)
    multiply(table, FIRST_WORK, FIRST_WORK, FIRST_WORK)
    multiply(table, INFLOW, INFLOW, SECOND_WORK)
    combine(table, (FIRST_WORK, COVERED), (SECOND_WORK, 1.0 - COVERED), AHEAD)
    root(table, AHEAD, AHEAD)
    multiply(table, LEVER, R, FIRST_WORK)
    combine(table, (FIRST_WORK, length), (V, 1.0), FIRST_WORK)
    multiply(table, FIRST_WORK, INVERSE, FIRST_WORK)
    _smooth_size(table, FIRST_WORK, SECOND_WORK)
    multiply(table, FIRST_WORK, GAMMA, FIRST_WORK)
    multiply(table, SECOND_WORK, UNEQUAL, SECOND_WORK)
    combine(table, (FIRST_WORK, -1.0), (SECOND_WORK, -1.0), ACROSS)
    multiply(table, ACROSS, SPEED, ACROSS)


@lean
def _set_rudder_force(table: Numbers, helm: float) -> None:
    """Write the rudder's force F' times cos and minus sin of the rudder."""
    multiply(table, AHEAD, AHEAD, FIRST_WORK)
    multiply(table, ACROSS, ACROSS, SECOND_WORK)
    combine(table, (FIRST_WORK, 1.0), (SECOND_WORK, 1.0), FIRST_WORK)
    root(table, FIRST_WORK, FIRST_WORK)
    combine(table, (AHEAD, math.sin(helm)), (ACROSS, -math.cos(helm)), SECOND_WORK)
    multiply(table, FIRST_WORK, SECOND_WORK, FIRST_WORK)
    multiply(table, INVERSE, INVERSE, SECOND_WORK)
    multiply(table, FIRST_WORK, SECOND_WORK, FIRST_WORK)
    scale(table, FIRST_WORK, math.cos(helm), 0.0, FORCE)
    scale(table, FIRST_WORK, -math.sin(helm), 0.0, DRAG)


@lean
def _set_polynomials(table: Numbers, helm: float) -> None:
    """Write the products of v', r', T' and the rudder."""
    hold(table, ONE, 1.0)
    hold(table, HELM, helm)
    hold(table, DD, helm * helm)
    multiply(table, U, INVERSE, FIRST_WORK)
    scale(table, FIRST_WORK, 1.0, -1.0, FIRST_WORK)
    multiply(table, FIRST_WORK, YAW, SLOW)
    multiply(table, SWAY, SWAY, VV)
    multiply(table, SWAY, YAW, VR)
    multiply(table, YAW, YAW, RR)
    scale(table, VV, helm, 0.0, VVD)
    scale(table, THRUST, helm, 0.0, TD)
    multiply(table, VV, SWAY, VVV)
    multiply(table, VV, YAW, VVR)
    multiply(table, SWAY, RR, VRR)
    multiply(table, YAW, RR, RRR)


@lean
def _set_wind(table: Numbers, ahead: float, starboard: float, length: float) -> None:
    """Write the terms of the wind, which are over U^2 and so have it no more."""
    size = math.sqrt(ahead * ahead + starboard * starboard + SMOOTH)
    hold(table, WIND, starboard * size / length)
    hold(table, WIND_2, ahead * starboard / length)
    hold(table, HEADWIND, ahead * size / length)


@lean
def set_terms(table: Numbers, ship: Numbers, x: Numbers, c: Numbers, rudder: Numbers) -> None:
    """Write every term at state ``x`` (u, v, r) and inputs ``c``, times U^2/L.

    ``ship`` is length, propeller diameter, three coefficients of K_T and 1-w; ``c`` is rudder
    [rad], revolutions [1/s] and relative wind from ahead and from starboard [m/s].
    """
    _set_motion(table, x, rudder, ship[0])
    _set_inflow(table, ship, c[1])
    _set_rudder_flow(table, ship[0])
    _set_rudder_force(table, c[0])
    _set_polynomials(table, c[0])
    for term in range(TERMS):
        multiply(table, term, PER_LENGTH, term)
    _set_wind(table, c[2], c[3], ship[0])


@lean
def add_terms(table: Numbers, terms: Terms, factors: Numbers, length: float, out: Numbers) -> None:
    """Write du/dt, dv/dt, dr/dt as forward numbers (3, columns); ``terms`` are (axis, row)."""
    for e in range(3):
        for i in range(out.shape[1]):
            out[e, i] = 0.0
    for j in range(terms.shape[0]):
        axis = terms[j, 0]
        factor = factors[j] / length if axis == 2 else factors[j]
        for i in range(out.shape[1]):
            out[axis, i] += factor * table[terms[j, 1], i]


@lean
def set_jacobian(rates: Numbers, A: Numbers) -> None:
    """Write df/dx (4, 4) from the forward numbers of the accelerations."""
    for e in range(3):
        for i in range(3):
            A[e, i] = rates[e, 1 + i]
        A[e, 3] = 0.0
        A[3, e] = 0.0
    A[3, 2] = 1.0
    A[3, 3] = 0.0


@lean
def slope_of(
    table: Numbers, rates: Numbers, terms: Terms, length: float, which: int, out: Numbers
) -> None:
    """Write d/d(coefficient) of the accelerations, and of their derivatives by u, v, r (3, 4).

    ``which`` counts the factors of ``terms`` first, then the nonlinear coefficients.
    """
    for e in range(3):
        for i in range(4):
            out[e, i] = 0.0
    if which < terms.shape[0]:
        axis, row = terms[which, 0], terms[which, 1]
        for i in range(min(4, table.shape[1])):
            out[axis, i] = table[row, i] / length if axis == 2 else table[row, i]
        return
    direction = 3 + which - terms.shape[0]
    for e in range(3):
        out[e, 0] = rates[e, 1 + direction]
        if rates.shape[1] > 1 + 8:
            for i in range(3):
                out[e, 1 + i] = rates[e, second_place(i, direction)]

"""Thrust less drag, and the engine room that answers the telegraph.

The command speed u_c [m/s] stands for the propeller's revolutions, which are it times a constant.
eta is u_c over the speed of the boat: 1 in steady flight, more while the boat gathers way. Where
the vessel file gives limits of torque and power, they hold the revolutions.

Both sets of equations take the thrust from here, in each evaluation of the rates; ``update`` moves
the revolutions once a tick.
"""

import math
from typing import Final

from trainer.core.casualties import PROPULSION_LOST, PROPULSION_STUCK, slot_of
from trainer.core.elementary import exponential
from trainer.core.envelope import (
    AHEAD,
    ASTERN,
    BY_FLOW_FLOW,
    BY_N_FLOW,
    BY_N_N,
    BY_U_U,
    BY_U_UC,
    BY_UC_UC,
    STOPPING,
    TURNING_AHEAD,
    TURNING_ASTERN,
)
from trainer.core.kernel import Record, inline_kernel, kernel
from trainer.core.plant.parts import FED_PROPULSION, FED_TELEGRAPH, is_dead

POWER_ROOT_STEPS: Final = 24  # at most: from ten times the root ten are enough


@inline_kernel
def thrust(vessel: Record, state: Record) -> float:
    """Return thrust less axial drag [N], the third line of [ASSES] (1).

    It has three rows of eta. The row is found by comparison, without dividing (errata A29): eta =
    u_c/u, or u_c/U for a vessel that has it so (A28). Departure: going astern the drag a_i u^2 is
    taken as a_i u|u|, since it would otherwise push the boat ever faster astern.
    """
    c = vessel[0]
    s = state[0]
    u = s.u
    u_c = s.u_c
    a1, b1, c1 = c.a1, c.b1, c.c1
    a2, b2, c2 = c.a2, c.b2, c.c2
    a3, b3, c3 = c.a3, c.b3, c.c3
    speed = u
    if c.eta_whole != 0.0:
        speed = math.sqrt(u * u + s.v * s.v + s.w * s.w)
    if speed > 0.0:
        first, second = u_c >= c.eta_1 * speed, u_c >= c.eta_2 * speed
    else:
        first, second = u_c >= 0.0, False
    a, b, k = (a1, b1, c1) if first else ((a2, b2, c2) if second else (a3, b3, c3))
    return u * (a * abs(u) + b * u_c) + k * u_c * u_c


@inline_kernel
def thrust_astern(vessel: Record, state: Record) -> float:
    """Return thrust less axial drag [N] going astern, by the propeller's other two quadrants."""
    s = state[0]
    row = vessel[0].thrust_astern[TURNING_ASTERN if s.u_c < 0.0 else TURNING_AHEAD]
    return s.u * (row[BY_U_U] * s.u + row[BY_U_UC] * s.u_c) + row[BY_UC_UC] * s.u_c * s.u_c


@kernel
def excess_eta(vessel: Record, state: Record) -> float:
    """Return eta - 1 [-].

    It is 0 at u = 0, or at U = 0 for a vessel with eta by U (errata A28, A29). By it the terms of
    the propeller's slip act on rudder, planes and hull.
    """
    s = state[0]
    speed = s.u
    if vessel[0].eta_whole != 0.0:
        speed = math.sqrt(s.u * s.u + s.v * s.v + s.w * s.w)
    if speed == 0.0:
        return 0.0
    return s.u_c / speed - 1.0


@inline_kernel
def propulsion_target(state: Record) -> float:
    """Return the command speed [m/s] that the propulsion aims at, casualties included."""
    s = state[0]
    if is_dead(FED_PROPULSION, state):
        return 0.0
    stuck, lost = slot_of(PROPULSION_STUCK, state), slot_of(PROPULSION_LOST, state)
    wanted = s.casualty_amount[stuck] if stuck >= 0 else s.telegraph_answer
    return wanted * (1.0 - s.casualty_amount[lost]) if lost >= 0 else wanted


@inline_kernel
def within_power(vessel: Record, way: int, flow: float, n: float) -> float:
    """Return the revolutions [1/s], at most ``n``, that the engine's power allows: P/(2 pi Q).

    The root of n (q0 n^2 + q1 n u/D + q2 (u/D)^2) = P/(2 pi rho D^5) by Newton's method, which
    comes down to it from above, where power rises ever faster with n.
    """
    c = vessel[0]
    q = c.torque[way]
    square, linear, fixed = q[BY_N_N], q[BY_N_FLOW] * flow, q[BY_FLOW_FLOW] * flow * flow
    for _ in range(POWER_ROOT_STEPS):
        over = n * (n * (square * n + linear) + fixed) - c.power_limit
        slope = n * (3.0 * square * n + 2.0 * linear) + fixed
        if over <= 0.0 or slope <= 0.0:
            break
        n -= over / slope
    return n


@inline_kernel
def most_revolutions(vessel: Record, way: int, flow: float) -> float:
    """Return the most revolutions [1/s] that the limits of torque and power allow.

    The flow is u/D [1/s], 0 or above. That of torque is the root of q0 n^2 + q1 n u/D +
    q2 (u/D)^2 = Q/(rho D^5); it is 0 where even a stopped propeller has more torque.
    """
    c = vessel[0]
    q = c.torque[way]
    half, rest = 0.5 * q[BY_N_FLOW] * flow, q[BY_FLOW_FLOW] * flow * flow - c.torque_limit
    square = half * half - q[BY_N_N] * rest
    n = max((math.sqrt(square) - half) / q[BY_N_N], 0.0) if square > 0.0 else 0.0
    return within_power(vessel, way, flow, n) if c.power_limit > 0.0 else n


@inline_kernel
def within_engine(vessel: Record, wanted: float, state: Record) -> float:
    """Return the command speed [m/s] that the engine can turn, at most ``wanted``."""
    c = vessel[0]
    u = state[0].u
    if wanted > max(u, 0.0):
        most = most_revolutions(vessel, AHEAD, max(u, 0.0) / c.screw) / c.turns
        return min(wanted, max(most, u))
    if wanted < min(u, 0.0):
        way = STOPPING if u >= 0.0 else ASTERN
        return max(wanted, -most_revolutions(vessel, way, abs(u) / c.screw) / c.turns)
    return wanted


@inline_kernel
def lag_share(vessel: Record, h: float) -> float:
    """Return the share [-] of their way that the revolutions go in ``h`` [s]."""
    lag = vessel[0].propulsion_lag
    return 1.0 - exponential(-h / lag) if lag > 0.0 else 1.0


@kernel
def write_lag_share(vessel: Record, h: float, scratch: Record) -> None:
    """Write the share of a tick of ``h`` [s], and what it is of."""
    work = scratch[0]
    work.lag_h, work.lag = h, vessel[0].propulsion_lag
    work.lag_share = lag_share(vessel, h)


@inline_kernel
def kept_lag_share(vessel: Record, h: float, scratch: Record) -> float:
    """Return the share of a tick of ``h`` [s], made anew where needed."""
    work = scratch[0]
    if work.lag_h != h or work.lag != vessel[0].propulsion_lag:
        write_lag_share(vessel, h, scratch)
    return float(work.lag_share)


@inline_kernel
def answer_telegraph(vessel: Record, h: float, state: Record) -> None:
    """Advance the command speed by ``h`` [s] towards ``command_u_c``.

    The engine room acts upon a new standing order after the dead time. The revolutions then
    approach it exponentially ([ASSES] suggests the form, the vessel file gives the numbers).
    """
    turn_propeller(vessel, h, lag_share(vessel, h), state)


@inline_kernel
def turn_propeller(vessel: Record, h: float, share: float, state: Record) -> None:
    """Advance the command speed likewise, by a ``share`` [-] that is known."""
    c = vessel[0]
    s = state[0]
    if not is_dead(FED_TELEGRAPH, state):  # else nobody answers it
        revolutions, speed = s.ordered_u_c, s.ordered_speed
        standing = revolutions if s.speed_by_hand != 0.0 else speed
        if standing != s.telegraph_order:
            s.telegraph_order = standing
            s.telegraph_ticks = math.floor(c.telegraph_dead_time / h + 0.5)
        if s.telegraph_ticks > 0.0:
            s.telegraph_ticks -= 1.0
        else:
            s.telegraph_answer = s.command_u_c
    target = propulsion_target(state)
    if c.torque_limit > 0.0:
        target = within_engine(vessel, target, state)
    s.u_c += share * (target - s.u_c)

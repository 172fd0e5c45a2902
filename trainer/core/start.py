"""The start of a boat in straight level flight, with orders to go on so.

``boat`` and sweeps begin each run by ``level_flight`` and ``set_out``, because a boat that is out
of trim would begin with a motion that nobody ordered.
"""

import math

from trainer.core.ballast.ballast import start_ballast
from trainer.core.kernel import Record, kernel
from trainer.core.rates import rates
from trainer.core.trim import BOTH_PLANES, STERN_PLANES, trim


@kernel
def is_within_limits(vessel: Record, most: float, state: Record) -> bool:
    """Return whether a trim can be flown within ``most`` [-] of the planes' limits."""
    c, s = vessel[0], state[0]
    return (
        abs(s.theta) < 0.5 * math.pi
        and abs(s.delta_s) <= most * c.limit_s
        and abs(s.delta_b) <= most * c.limit_b
        and abs(s.delta_r) <= most * c.limit_r
    )


@kernel
def level_flight(
    vessel: Record, compact: Record, scheme: Record, state: Record, scratch: Record, speed: float
) -> int:
    """Bring a boat into straight level flight at ``speed`` [m/s].

    Return 1, or 0 if it cannot fly so. It flies by the stern planes if they can; else level, by
    both pairs of planes, as a boat does near and below the critical speed of the stern planes.
    ``scheme`` must ask for the exact solve, and for the equations of 1969 alone, which know no
    surface.
    """
    s = state[0]
    for i in range(6):
        scratch[0].external[i] = 0.0
    for attempt in range(3):
        by = BOTH_PLANES if attempt == 1 else STERN_PLANES
        most = 0.3 if attempt == 0 else 1.0
        s.v = s.w = s.phi = s.theta = 0.0
        s.delta_r = s.delta_s = s.delta_b = 0.0
        s.u = s.u_c = speed
        settled = trim(vessel, compact, scheme, state, scratch, by)
        if settled != 0 and is_within_limits(vessel, most, state):
            return 1
    return 0


@kernel
def order_as_it_goes(vessel: Record, state: Record) -> None:
    """Order depth, course, speed and surfaces as they are, with everything in hand.

    So nothing moves until somebody orders it.
    """
    s = state[0]
    s.ordered_depth, s.ordered_psi, s.ordered_speed = s.z, s.psi, s.u
    s.ordered_u_c = s.command_u_c = s.telegraph_answer = s.u_c
    s.ordered_r, s.ordered_s, s.ordered_b = s.delta_r, s.delta_s, s.delta_b
    s.speed_trim = s.u_c - s.u
    s.speed_followed = s.speed_order = s.u
    s.telegraph_order = s.u if vessel[0].gain_count > 0.0 else s.u_c
    s.rudder_by_hand = s.stern_by_hand = s.bow_by_hand = s.speed_by_hand = s.trim_by_hand = 1.0


@kernel
def set_out(
    vessel: Record, compact: Record, scheme: Record, state: Record, scratch: Record
) -> None:
    """Complete the state of a boat in trim for its first tick.

    The boat is at its depth and course. The autopilot must still follow what is in hand
    (``stand_by_all``), and the sea must still be ordered.
    """
    s = state[0]
    start_ballast(vessel, state)
    rates(vessel, compact, scheme, state, scratch)
    for i in range(6):
        s.rates[i] = 0.0
    order_as_it_goes(vessel, state)

"""Many boats started, each as ``Boat.start`` and a manoeuvre's ``Submarine`` start one."""

import math
from typing import NamedTuple

from trainer.analysis.fleet.ensemble import Fleet
from trainer.core.autopilot import autopilot
from trainer.core.ballast.ballast import start_ballast
from trainer.core.kernel import Numbers, Record, kernel
from trainer.core.rates import rates
from trainer.core.sea.sea import order_sea
from trainer.core.trim import BOTH, STERN, trim


class Start(NamedTuple):
    """How all boats of a fleet start."""

    speed: Numbers  # [member] [m/s]
    depth: float  # [m]
    law: float  # of depth keeping
    calm: Numbers  # [member, ...] what ``order_sea`` takes


@kernel
def is_trim(vessel: Record, most: float, state: Record) -> bool:
    """Return whether a trim found is one to fly in."""
    c, s = vessel[0], state[0]
    return (
        abs(s.theta) < 0.5 * math.pi
        and abs(s.delta_s) <= most * c.limit_s
        and abs(s.delta_b) <= most * c.limit_b
        and abs(s.delta_r) <= most * c.limit_r
    )


@kernel
def level(
    vessel: Record, compact: Record, exact: Record, state: Record, scratch: Record, speed: float
) -> bool:
    """Bring one boat into straight level flight at ``speed`` [m/s]; return whether it can be."""
    s = state[0]
    for i in range(6):
        scratch[0].external[i] = 0.0
    for attempt in range(3):
        by = BOTH if attempt == 1 else STERN
        most = 0.3 if attempt == 0 else 1.0
        s.v = s.w = s.phi = s.theta = 0.0
        s.delta_r = s.delta_s = s.delta_b = 0.0
        s.u = s.u_c = speed
        done = trim(vessel, compact, exact, state, scratch, by)
        if done != 0 and is_trim(vessel, most, state):
            return True
    return False


@kernel
def give_orders(vessel: Record, speed: float, depth: float, state: Record) -> None:
    """Order one boat in trim to go on as it does, with hands on."""
    c, s = vessel[0], state[0]
    s.ordered_depth, s.ordered_psi, s.ordered_speed = depth, 0.0, speed
    s.ordered_u_c = s.command_u_c = s.telegraph_answer = s.u_c
    s.ordered_r, s.ordered_s, s.ordered_b = s.delta_r, s.delta_s, s.delta_b
    s.speed_trim = s.u_c - speed
    s.telegraph_order = speed if c.gain_count > 0.0 else s.u_c
    s.rudder_by_hand = s.stern_by_hand = s.bow_by_hand = s.speed_by_hand = 1.0


@kernel
def start_one(
    vessel: Record, compact: Record, scheme: Record, state: Record, scratch: Record, depth: float
) -> None:
    """Complete the state of one boat in trim, as it begins its first tick."""
    s = state[0]
    speed = s.u  # the trim leaves it as it is
    s.z, s.psi, s.seed = depth, 0.0, 1.0
    start_ballast(vessel, vessel, state)
    rates(vessel, compact, scheme, state, scratch)
    for i in range(6):
        s.rates[i] = 0.0
    give_orders(vessel, speed, depth, state)
    autopilot(vessel, scheme[0].h, state, scratch[0].gains)
    s.telegraph_order = s.u_c


@kernel
def start_fleet(fleet: Fleet, exact: Record, how: Start, scratch: Record, fit: Numbers) -> None:
    """Start every boat of a fleet at depth in a calm; ``fit`` tells 1 where one flies straight."""
    scheme = fleet.scheme
    for member in range(fleet.states.size):
        own = min(member, fleet.compacts.size - 1)  # one may serve them all
        vessel, compact = fleet.vessels[member : member + 1], fleet.compacts[own : own + 1]
        state = fleet.states[member : member + 1]
        c, s = vessel[0], state[0]
        for i in range(s.whole.size):
            s.whole[i] = 0.0
        s.weight, s.x_g, s.y_g, s.z_g = c.weight, c.x_g, c.y_g, c.z_g
        if not level(vessel, compact, exact, state, scratch, how.speed[member]):
            fit[member] = 0.0
            continue
        fit[member] = 1.0
        start_one(vessel, compact, scheme, state, scratch, how.depth)
        calm = how.calm[min(member, how.calm.shape[0] - 1)]
        for i in range(1, s.sea.size):
            s.sea[i] = calm[i]
        order_sea(vessel, scheme[0].h, 0.0, calm, scratch, state)
        s.depth_law = how.law

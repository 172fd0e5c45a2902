"""The start of many boats, each as ``Boat.start`` or a manoeuvre's ``Submarine`` starts one."""

from typing import NamedTuple

from trainer.analysis.fleet.ensemble import Fleet
from trainer.core.autopilot.autopilot import autopilot
from trainer.core.kernel import Numbers, Record, kernel
from trainer.core.sea.sea import order_sea
from trainer.core.start import level_flight, set_out


class Start(NamedTuple):
    """How all boats of a fleet start."""

    speed: Numbers  # [member] [m/s]
    depth: float  # [m]
    law: float  # of depth keeping
    calm: Numbers  # [member, ...] what ``order_sea`` takes


@kernel
def start_fleet(fleet: Fleet, exact: Record, how: Start, scratch: Record, fit: Numbers) -> None:
    """Start every boat of a fleet at depth in a calm.

    ``fit`` becomes 1 where a boat flies straight, else 0.
    """
    scheme = fleet.scheme
    for member in range(fleet.states.size):
        own = min(member, fleet.compacts.size - 1)  # one may serve them all
        vessel, compact = fleet.vessels[member : member + 1], fleet.compacts[own : own + 1]
        state = fleet.states[member : member + 1]
        c, s = vessel[0], state[0]
        for i in range(s.whole.size):
            s.whole[i] = 0.0
        s.weight, s.x_g, s.y_g, s.z_g = c.weight, c.x_g, c.y_g, c.z_g
        fit[member] = level_flight(vessel, compact, exact, state, scratch, how.speed[member])
        if fit[member] == 0.0:
            continue
        s.z, s.seed = how.depth, 1.0
        set_out(vessel, compact, scheme, state, scratch)
        autopilot(vessel, scheme[0].h, state, scratch[0].gains)
        s.telegraph_order = s.u_c
        calm = how.calm[min(member, how.calm.shape[0] - 1)]
        for i in range(1, s.sea.size):
            s.sea[i] = calm[i]
        order_sea(vessel, scheme[0].h, 0.0, calm, scratch, state)
        s.depth_law = how.law

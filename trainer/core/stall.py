"""Stall of rudder and planes ahead.

The equations of 1969 let lift grow with any angle. What they have beyond the angle of stall is
taken off here. The incidence of a surface is its angle and that of the flow where it stands; the
arm follows from its own coefficients. The form is derived here, and no trial has confirmed it.
Where the file gives no angle, nothing stalls.

``rates`` takes the lost lift off both sets of equations.
"""

from trainer.core.kernel import Numbers, Record, inline_kernel
from trainer.core.state import AXIAL, LATERAL, NORMAL, PITCHING, ROLLING, YAWING


@inline_kernel
def incidence(vessel: Record, surface: int, state: Record) -> float:
    """Return u times the incidence of rudder (0), stern (1) or bow planes (2) [m/s]."""
    s = state[0]
    arm = vessel[0].stall_arm[surface]
    flow = -(s.v + arm * s.r) if surface == 0 else s.w - arm * s.q
    return s.u * s.surface[surface] + flow


@inline_kernel
def is_stalled(vessel: Record, state: Record) -> bool:
    """Return whether rudder or planes are beyond their stall, going ahead."""
    u = state[0].u
    if u <= 0.0:
        return False
    stalled = False
    for i in range(3):
        stalled |= abs(incidence(vessel, i, state)) > u * vessel[0].stall_ahead[i]
    return stalled


@inline_kernel
def lost_lift(vessel: Record, surface: int, state: Record) -> float:
    """Return the part of u^2 times a surface's angle that stall takes [m2/s2]."""
    c, u = vessel[0], state[0].u
    angle, most = incidence(vessel, surface, state), u * c.stall_ahead[surface]
    beyond = max(angle - most, 0.0) + min(angle + most, 0.0)
    return (1.0 - c.stall_slope[surface]) * u * beyond


@inline_kernel
def write_stalled(vessel: Record, outer: Numbers, state: Record, out: Numbers) -> None:
    """Write forces [N] and moments [N m] from outside, less the lift that stall takes."""
    c = vessel[0]
    rudder = lost_lift(vessel, 0, state)
    stern, bow = lost_lift(vessel, 1, state), lost_lift(vessel, 2, state)
    out[AXIAL] = outer[AXIAL]
    out[LATERAL] = outer[LATERAL] - c.Y_dr * rudder
    out[NORMAL] = outer[NORMAL] - c.Z_ds * stern - c.Z_db * bow
    out[ROLLING] = outer[ROLLING] - c.K_dr * rudder
    out[PITCHING] = outer[PITCHING] - c.M_ds * stern - c.M_db * bow
    out[YAWING] = outer[YAWING] - c.N_dr * rudder

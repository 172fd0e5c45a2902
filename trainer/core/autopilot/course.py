"""Course keeping by the rudder.

Its angle is the sum of gains times course error, yaw rate and sway, plus an integral. The integral
learns the rudder that holds a straight course. It rests in a turn, whose lasting error would wind
it up.

``autopilot`` calls it in each tick while nobody has the rudder in hand; a fleet does so for its
lanes.
"""

from trainer.core.autopilot.reference import within
from trainer.core.autopilot.steering import ASTERN_SPEED, RUDDER, stand_by, steer
from trainer.core.kernel import Numbers, Record, inline_kernel
from trainer.core.vessel import COURSE_GAIN, COURSE_INTEGRAL_GAIN, SWAY_GAIN, YAW_RATE_GAIN


@inline_kernel
def course_law(state: Record, gains: Numbers) -> float:
    """Return the rudder angle [rad] of a boat going ahead, without the integral."""
    s = state[0]
    return (
        gains[COURSE_GAIN] * (s.psi_reference - s.psi)
        + gains[YAW_RATE_GAIN] * (s.psi_reference_rate - s.r)
        + gains[SWAY_GAIN] * s.v
    )


@inline_kernel
def keep_course(vessel: Record, h: float, gains: Numbers, state: Record) -> None:
    """Command the rudder.

    Going astern it is put over the other way, because the flow meets it from behind. The integral
    then learns nothing, since its angle is that of a boat going ahead.
    """
    s = state[0]
    law = course_law(state, gains)
    if s.rudder_by_hand != 0.0:
        s.command_r = s.ordered_r
        stand_by(state, RUDDER, law, abs(s.r) < vessel[0].turning_rate)
    elif s.u < ASTERN_SPEED:
        s.command_r = within(-law, 0.0, vessel[0].limit_r)
        stand_by(state, RUDDER, law, False)  # noqa: FBT003 a fact
    else:
        step = 0.0
        if abs(s.psi_reference_rate) < vessel[0].turning_rate:
            step = h * gains[COURSE_INTEGRAL_GAIN] * (s.psi_reference - s.psi)
        steer(vessel, state, RUDDER, law, step)

"""The depth law of [ASSES], for comparison with this project's own.

It gives both pairs of planes one angle and has no integral. ``depth`` asks for it where an order
has chosen it (the state's ``depth_law``), so that a flight can be set beside the report's.
"""

import math
from typing import Final

from trainer.core.autopilot.reference import within
from trainer.core.autopilot.steering import BOW, REPORT_LITERAL
from trainer.core.elementary import cosine, sine
from trainer.core.kernel import Record, kernel
from trainer.units import FOOT

# the numbers of the law in ``report_law``, in SI
REPORT_DEPTH: Final = 0.008 / FOOT  # [rad/m]
REPORT_PITCH: Final = 3.5  # [-]
REPORT_CLIMB: Final = 0.012 / FOOT  # [rad s/m]
REPORT_PITCH_RATE: Final = 2.0  # [s]
REPORT_LIMIT: Final = math.radians(35.0)
REPORT_FURTHEST: Final = 50.0 * FOOT  # [m] project's clamp on the depth error (errata G5)


@kernel
def report_law(state: Record) -> float:
    """Return the plane angle [rad] of [ASSES] IV.

    DS = .008 (ZC - Z) + 3.5 theta + .012 (u sin theta - w cos theta) + 2 q, in feet, radians and
    seconds; the bracket is the rate of climb (errata G). Here ZC - Z is held within 50 ft. That is
    not the report's, and the literal law does not do it: there the planes are hard over from 76 ft
    on.
    """
    s = state[0]
    climb_rate = s.u * sine(s.theta) - s.w * cosine(s.theta)
    error = s.ordered_depth - s.z
    if s.depth_law != REPORT_LITERAL:
        error = within(error, 0.0, REPORT_FURTHEST)
    angle = (
        REPORT_DEPTH * error
        + REPORT_PITCH * s.theta
        + REPORT_CLIMB * climb_rate
        + REPORT_PITCH_RATE * s.q
    )
    return within(angle, 0.0, REPORT_LIMIT)


@kernel
def report_angle(vessel: Record, state: Record, surface: int) -> float:
    """Return the angle [rad] that the law of [ASSES] gives one pair of planes.

    Taken literally, DB = DS works against the stern planes where bow planes to dive are negative
    (Z_db < 0). There the sign is turned, unless the literal law is asked for (errata G3).
    """
    angle = report_law(state)
    if surface == BOW and vessel[0].Z_db <= 0.0 and state[0].depth_law != REPORT_LITERAL:
        return -angle
    return angle

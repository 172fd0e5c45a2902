"""Automatic trim: water takes over what the planes carry, and pitch becomes zero.

Lift and moment of the planes in steady flight, averaged over TRIM_MEMORY_S, say how heavy the boat
is and where. So much water is let into the auxiliary tank or pumped out, and moved between the trim
tanks. The pumps are those that the crew uses, and they work as fast as for the crew. Meanwhile the
integral of the stern planes levels the boat, so that the angle which remains is that of level
flight. The law is this project's own; its limits are estimates, taken per mass and length of the
boat on which they were flown.

``autopilot`` calls it in each tick while the trim is not in hand, because planes that carry weight
have less left for the depth.
"""

import math
from typing import Final

from trainer.core.autopilot.steering import OWN_LAW, is_turning
from trainer.core.ballast.hover import is_hovering
from trainer.core.ballast.tanks import TRIM_AFT, TRIM_FORWARD
from trainer.core.kernel import Record, inline_kernel

TRIM_MEMORY_S: Final = 60.0  # [s]
MAX_DEPTH_ERROR_M: Final = 2.0  # [m] of the ordered depth
MIN_TRIM_SPEED: Final = 1.0  # [m/s]
TRIM_TIME_S: Final = 200.0  # [s] in which the trim is corrected
MIN_HEAVINESS: Final = 3.4e-5  # [-] of the mass (150 kg for BB2): less is left alone ...
MIN_IMBALANCE: Final = 9.1e-6  # [-] ... likewise of what moves between the trim tanks (40 kg)
MAX_FLOOD_RATE, MAX_TRANSFER_RATE = 20.0, 50.0  # [kg/s] at most
LEVELLING_RATE: Final = 0.004  # [1/s] rate of the stern planes' integral per pitch
MAX_FREE_PLANES: Final = 20.0 * math.pi / 180.0  # [rad] beyond it the stern planes have other work


@inline_kernel
def is_trimming(state: Record) -> bool:
    """Return whether the boat is in the steady flight in which its trim shows."""
    s = state[0]
    automatic = s.stern_by_hand == 0.0 and s.bow_by_hand == 0.0
    free = s.ascent == 0.0 and not is_hovering(state) and s.depth_law == OWN_LAW
    near = abs(s.ordered_depth - s.z) < MAX_DEPTH_ERROR_M and s.u > MIN_TRIM_SPEED
    return automatic and free and near


@inline_kernel
def beyond(wanted: float, least: float, h: float, most: float) -> float:
    """Return how much [kg] is moved in ``h`` [s] of what is ``wanted`` [kg].

    It is at most ``most`` [kg/s], and nothing if less than ``least`` [kg] is wanted.
    """
    if abs(wanted) <= least:
        return 0.0
    return min(max(wanted * h / TRIM_TIME_S, -most * h), most * h)


@inline_kernel
def keep_trim(vessel: Record, h: float, state: Record) -> None:
    """Follow what the planes carry, and level the boat.

    Write how much water the pumps are to move of it.
    """
    c = vessel[0]
    s = state[0]
    s.trim_flood = s.trim_forward = 0.0
    if s.trim_by_hand != 0.0:
        return
    share = h / (TRIM_MEMORY_S + h)
    square = s.u * s.u
    lift = square * (c.Z_ds * s.delta_s + c.Z_db * s.delta_b)
    moment = square * (c.M_ds * s.delta_s + c.M_db * s.delta_b)
    s.trim_lift += share * (lift - s.trim_lift)
    s.trim_moment += share * (moment - s.trim_moment)
    s.trim_pitch += share * (s.theta - s.trim_pitch)
    if not is_trimming(state) or is_turning(vessel, state):
        return
    if c.limit_b > 0.0 and abs(s.delta_s) < MAX_FREE_PLANES:
        down = 1.0 if c.M_ds <= 0.0 else -1.0
        s.stern_integral += down * LEVELLING_RATE * h * s.trim_pitch
    arm = c.x[TRIM_FORWARD] - c.x[TRIM_AFT]
    s.trim_flood = beyond(s.trim_lift / c.g, MIN_HEAVINESS * c.mass, h, MAX_FLOOD_RATE)
    if arm > 0.0:
        along = -s.trim_moment / (c.g * arm)
        s.trim_forward = beyond(along, MIN_IMBALANCE * c.mass, h, MAX_TRANSFER_RATE)

"""The reference that depth and course keeping follow on the way to their orders.

It moves to the ordered depth or course as fast as the boat can follow, so that the errors stay
small and the integrals do not wind up. The reference is never far from the boat, so that a boat
that was driven off returns at the allowed rate, and not with all surfaces hard over.
"""

import math

from trainer.core.kernel import Numbers, Record, inline_kernel
from trainer.core.vessel import DEPTH_SLEW, SLEW_ACCELERATION, SLEW_COUNT, SLEW_RATE

DEPTH_AXIS, COURSE_AXIS = 0, 1  # which of the two references
COURSE_SLEW = DEPTH_SLEW + SLEW_COUNT * COURSE_AXIS
ASTERN_PACE = 0.25  # [-] of turns astern: there a drift grows, and the rudder must stop it (flown)

LEASH_SHARE = 0.25  # [-]
APPROACH_TICKS = 4.0  # [ticks] time constant of the last approach, too slow to hunt


@inline_kernel
def slewed_rate(distance: float, rate: float, fastest: float, gentlest: float, h: float) -> float:
    """Return the next rate of a reference ``distance`` short of its order.

    It is at most ``fastest``, changes by at most ``gentlest`` per second, and is slow enough to
    stop at the order. All are in metres (depth) or radians (course), and seconds.
    """
    size = abs(distance)
    wanted = min(fastest, math.sqrt(gentlest * size), size / (APPROACH_TICKS * h))
    if distance < 0.0:
        wanted = -wanted
    change = min(max(wanted - rate, -gentlest * h), gentlest * h)
    return rate + change


@inline_kernel
def leash(gains: Numbers, slew: int) -> float:
    """Return how far [m or rad] a reference may be from the boat.

    It is LEASH_SHARE of rate^2/acceleration: the way at its full rate in the time that it takes to
    reach that rate.
    """
    rate, acceleration = gains[slew + SLEW_RATE], gains[slew + SLEW_ACCELERATION]
    if acceleration > 0.0:
        return LEASH_SHARE * rate * rate / acceleration
    return 0.0


@inline_kernel
def within(value: float, centre: float, most: float) -> float:
    """Return ``value``, or the nearest to it that is at most ``most`` from ``centre``."""
    return min(max(value, centre - most), centre + most)


@inline_kernel
def move_reference(axis: int, here: float, h: float, gains: Numbers, state: Record) -> None:
    """Move the reference of depth or course to its order for ``h`` [s].

    The boat is ``here`` [m or rad].
    """
    s = state[0]
    slew = DEPTH_SLEW + SLEW_COUNT * axis
    fastest, gentlest = gains[slew + SLEW_RATE], gains[slew + SLEW_ACCELERATION]
    distance, rate = s.ordered_place[axis] - s.reference[axis], s.reference_rate[axis]
    s.reference_rate[axis] = slewed_rate(distance, rate, fastest, gentlest, h)
    moved = s.reference[axis] + h * s.reference_rate[axis]
    s.reference[axis] = within(moved, here, leash(gains, slew))


@inline_kernel
def follow_boat(axis: int, here: float, rate: float, gains: Numbers, state: Record) -> None:
    """Leave the reference of depth or course at the boat.

    The boat is ``here`` [m or rad] and moves at ``rate``. The reference moves on with it, but no
    faster than it ever is slewed. So a boat that is handed over in a hard turn or in a steep dive
    is stopped, not followed.
    """
    s = state[0]
    s.reference[axis] = here
    fastest = gains[DEPTH_SLEW + SLEW_COUNT * axis + SLEW_RATE]
    s.reference_rate[axis] = within(rate, 0.0, fastest)


@inline_kernel
def slew_depth(h: float, gains: Numbers, state: Record) -> None:
    """Move the depth reference by ``h`` [s].

    With both pairs of planes in hand, or on the way up after a blow, it is the boat's depth.
    """
    s = state[0]
    if (s.stern_by_hand != 0.0 and s.bow_by_hand != 0.0) or s.ascent != 0.0:
        follow_boat(DEPTH_AXIS, s.z, s.zdot, gains, state)
    else:
        move_reference(DEPTH_AXIS, s.z, h, gains, state)


@inline_kernel
def slow_turns(gains: Numbers, state: Record) -> None:
    """Make a turn astern slower than one ahead, so that it ends as far on."""
    s = state[0]
    gains[COURSE_SLEW + SLEW_RATE] *= ASTERN_PACE
    gains[COURSE_SLEW + SLEW_ACCELERATION] *= ASTERN_PACE * ASTERN_PACE
    s.psi_reference_rate = within(s.psi_reference_rate, 0.0, gains[COURSE_SLEW + SLEW_RATE])


@inline_kernel
def slew_course(h: float, gains: Numbers, state: Record) -> None:
    """Move the heading reference by ``h`` [s].

    With the rudder in hand it is the boat's heading.
    """
    s = state[0]
    if s.rudder_by_hand != 0.0:
        follow_boat(COURSE_AXIS, s.psi, s.r, gains, state)
    else:
        move_reference(COURSE_AXIS, s.psi, h, gains, state)

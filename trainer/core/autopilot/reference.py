"""What the autopilot steers for: ordered depth and course, slewed as fast as the boat can follow.

The errors stay small that way and the integrals do not wind up. A reference is never far from
the boat, so that a boat driven off returns at the rate it is allowed and not with all hard over.
"""

import math

from trainer.core.kernel import Numbers, Record, part

DEPTH, COURSE = 0, 1  # axes
DEPTH_SLEW = 16  # place in the schedule of gains: a rate, an acceleration; the course's follow

LEASH = 0.25  # [-]
APPROACH = 4.0  # [ticks] time constant of the last approach, too slow to hunt


@part
def slewed_rate(distance: float, rate: float, fastest: float, gentlest: float, h: float) -> float:
    """Return the next rate of a reference ``distance`` short of its order.

    At most ``fastest``, changing by at most ``gentlest`` per second, and slow enough to stop.
    """
    size = abs(distance)
    wanted = min(fastest, math.sqrt(gentlest * size), size / (APPROACH * h))
    if distance < 0.0:
        wanted = -wanted
    change = min(max(wanted - rate, -gentlest * h), gentlest * h)
    return rate + change


@part
def leash(gains: Numbers, slew: int) -> float:
    """Return how far [m or rad] a reference may be from the boat.

    A share of what it goes at its rate in the time it needs to take that up.
    """
    if gains[slew + 1] > 0.0:
        return LEASH * gains[slew] * gains[slew] / gains[slew + 1]
    return 0.0


@part
def within(value: float, centre: float, most: float) -> float:
    """Return ``value``, or the nearest to it that is at most ``most`` from ``centre``."""
    return min(max(value, centre - most), centre + most)


@part
def move_reference(axis: int, here: float, h: float, gains: Numbers, state: Record) -> None:
    """Move the reference of depth or course to its order for ``h`` [s]; the boat is ``here``."""
    s = state[0]
    slew = DEPTH_SLEW + 2 * axis
    distance, rate = s.ordered_place[axis] - s.reference[axis], s.reference_rate[axis]
    s.reference_rate[axis] = slewed_rate(distance, rate, gains[slew], gains[slew + 1], h)
    moved = s.reference[axis] + h * s.reference_rate[axis]
    s.reference[axis] = within(moved, here, leash(gains, slew))


@part
def slew_depth(h: float, gains: Numbers, state: Record) -> None:
    """Move the depth reference by ``h`` [s].

    With both pairs of planes in hand, or on the way up after a blow, it is the boat's.
    """
    s = state[0]
    if (s.stern_by_hand != 0.0 and s.bow_by_hand != 0.0) or s.ascent != 0.0:
        s.depth_reference, s.depth_reference_rate = s.z, s.zdot
    else:
        move_reference(DEPTH, s.z, h, gains, state)


@part
def slew_course(h: float, gains: Numbers, state: Record) -> None:
    """Move the heading reference by ``h`` [s]; with the rudder in hand it is the boat's."""
    s = state[0]
    if s.rudder_by_hand != 0.0:
        s.psi_reference, s.psi_reference_rate = s.psi, s.r
    else:
        move_reference(COURSE, s.psi, h, gains, state)

"""Depth keeping by both pairs of planes.

The law is this project's own: the angle of a pair is the sum of gains times the errors in depth,
depth rate, pitch and pitch rate, plus an integral. In a turn a lasting angle of the bow planes is
handed over to the stern planes, where those carry it better. In straight flight that would only
trade the angle for pitch; trim removes it there (see ``trimming``). In waves the law leaves the
waves' own band alone (see ``waves``).

Going astern the planes work the other way round: the stern planes level the boat, and the bow
planes keep the depth. Slower than LEAST_ASTERN the planes hold nothing and stay amidships; the
tanks must keep the depth.

``autopilot`` calls it in each tick, for those planes that nobody has in hand; ``boat/pilot`` tells
the crew what the law has given up.
"""

from typing import Final

from trainer.core.autopilot.reference import leash, within
from trainer.core.autopilot.report_law import report_angle
from trainer.core.autopilot.steering import (
    ASTERN_SPEED,
    BOW,
    LEVEL_SHARE,
    MIN_DIVISOR_SPEED,
    OWN_LAW,
    STERN,
    first_gain,
    is_level,
    is_turning,
    stand_by,
    steer,
)
from trainer.core.autopilot.waves import law_in_waves, learning_in_waves, pass_notches, soften
from trainer.core.kernel import Numbers, Record, inline_kernel
from trainer.core.vessel import (
    DEPTH_GAIN,
    DEPTH_RATE_GAIN,
    DEPTH_SLEW,
    INTEGRAL_GAIN,
    PITCH_GAIN,
    PITCH_RATE_GAIN,
    RELIEF_GAIN,
    SLEW_RATE,
)
from trainer.units import KNOT

FAR_SHARE: Final = 0.5  # [-] share of the leash, and of the allowed depth rate
# Both are estimates, like the whole law astern (docs/autopilot.md).
LEAST_ASTERN: Final = 3.0 * KNOT  # [m/s] below it planes do not hold a boat going astern
SURE_ASTERN: Final = 3.5 * KNOT  # [m/s] from there on they are used in full


@inline_kernel
def plane_law(state: Record, gains: Numbers, first: int) -> float:
    """Return a plane angle [rad] without its integral.

    ``first`` is the index where its gains begin.
    """
    s = state[0]
    # in level flight zdot = -u theta: this pitch gives the rate of the reference
    pitch_wanted = -s.depth_reference_rate / max(s.u, MIN_DIVISOR_SPEED)
    return (
        gains[first + DEPTH_GAIN] * (s.depth_reference - s.z)
        + gains[first + DEPTH_RATE_GAIN] * (s.depth_reference_rate - s.zdot)
        + gains[first + PITCH_GAIN] * (s.theta - pitch_wanted)
        + gains[first + PITCH_RATE_GAIN] * s.q
    )


@inline_kernel
def law_astern(state: Record, gains: Numbers, surface: int) -> float:
    """Return a plane angle [rad] going astern, where each force of a plane is turned.

    The stern planes level the boat. The bow planes keep the depth by their own lift, since what
    pitch does to depth is turned once more. This is an estimate: the gains are those of a boat that
    goes ahead.
    """
    s = state[0]
    first = first_gain(surface)
    if surface == STERN:
        return -gains[first + PITCH_GAIN] * s.theta - gains[first + PITCH_RATE_GAIN] * s.q
    depth = gains[first + DEPTH_GAIN] * (s.depth_reference - s.z)
    return -depth - gains[first + DEPTH_RATE_GAIN] * (s.depth_reference_rate - s.zdot)


@inline_kernel
def depth_error(gains: Numbers, state: Record) -> float:
    """Return the depth error [m] to be integrated.

    It is 0 while the error says nothing about the trim: while the boat changes depth as it should,
    and while it is far off and moves, either on its way back or being taken away. A boat that is
    held far off learns.
    """
    s = state[0]
    error = s.depth_reference - s.z
    rate, share = s.depth_reference_rate, LEVEL_SHARE
    if abs(error) > FAR_SHARE * leash(gains, DEPTH_SLEW):
        rate, share = s.zdot, FAR_SHARE
    return error if abs(rate) < share * gains[DEPTH_SLEW + SLEW_RATE] else 0.0


@inline_kernel
def back(vessel: Record, gains: Numbers, state: Record, surface: int) -> None:
    """Command a pair of planes of a boat that goes astern.

    From LEAST_ASTERN to SURE_ASTERN its angle grows from zero to the law's, without a jump.
    """
    s = state[0]
    share = min(max((-s.u - LEAST_ASTERN) / (SURE_ASTERN - LEAST_ASTERN), 0.0), 1.0)
    angle = within(law_astern(state, gains, surface), 0.0, vessel[0].limit[surface])
    s.command[surface] = share * angle


@inline_kernel
def keep_plane(
    vessel: Record, h: float, scratch: Record, state: Record, surface: int, lasting: float
) -> None:
    """Command one pair of planes.

    ``lasting`` [rad] is the bow planes' angle that the stern planes are to take over.
    """
    s, gains = state[0], scratch[0].gains
    first = first_gain(surface)
    law = plane_law(state, gains, first)
    pass_notches(h, scratch, state, surface, law)
    law = law_in_waves(state, surface, law)
    if s.by_hand[surface] != 0.0:
        s.command[surface] = s.ordered[surface]
        stand_by(state, surface, law, is_level(gains, state))
    elif s.depth_law != OWN_LAW:
        s.command[surface] = report_angle(vessel, state, surface)
        stand_by(state, surface, law, is_level(gains, state))
    elif s.u < ASTERN_SPEED:
        back(vessel, gains, state, surface)
        stand_by(state, surface, law, False)  # noqa: FBT003 a fact
    else:
        step = h * gains[first + INTEGRAL_GAIN] * depth_error(gains, state)
        step *= learning_in_waves(scratch, state)
        steer(vessel, state, surface, law, step + h * gains[first + RELIEF_GAIN] * lasting)


@inline_kernel
def keep_depth(vessel: Record, h: float, scratch: Record, state: Record) -> None:
    """Command both pairs of planes.

    The stern planes relieve the bow planes only while they can move as commanded: they are not in
    hand, and the rudder's share of an X-tail does not hold them.
    """
    s = state[0]
    able = abs(s.command_s - s.delta_s) <= vessel[0].surface_rate * h
    automatic = s.stern_by_hand == 0.0 and s.bow_by_hand == 0.0
    lasting = s.delta_b if able and automatic and is_turning(vessel, state) else 0.0
    soften(vessel, h, scratch, state)
    keep_plane(vessel, h, scratch, state, STERN, lasting)
    keep_plane(vessel, h, scratch, state, BOW, lasting)

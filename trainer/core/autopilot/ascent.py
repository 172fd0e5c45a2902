"""The way up with the planes automatic: bow up in an emergency, level in surfacing.

Planes that keep a depth, be it 0, would work against the blow: it lifts the boat faster than they
ask, so they would put the bow down, and afloat they would go to their stops. While the emergency
valve of a main tank is open, the stern planes hold a pitch of ASCENT_BUBBLE, more at speed. While
the boat surfaces, with ordinary valves and an ordered depth of 0, they hold her level. The bow
planes lie amidships.

In an emergency the after group is blown only while the bow is up, since the planes alone cannot
hold it up at slow speed. Once the blow is over and the boat has come to rest for QUIET_TIME_S, it
keeps the depth that it has, and depth keeping takes over without a jump. At the surface no depth is
kept until one is ordered. The law is this project's own; its figures and what it does on BB2 are in
docs/autopilot.md.
"""

import math
from typing import Final

from trainer.core.autopilot.steering import OWN_LAW, stand_by
from trainer.core.kernel import Numbers, Record, inline_kernel
from trainer.core.vessel import PITCH_GAIN, PITCH_RATE_GAIN, STERN_GAINS
from trainer.units import KNOT

NO_ASCENT, ASCENT_RISING, ASCENT_AFLOAT = 0, 1, 2  # of the state's ``ascent``
EMERGENCY_OPENING: Final = 2.0  # [-] of a blow valve

DEGREE: Final = math.pi / 180.0
ASCENT_BUBBLE: Final = 10.0 * DEGREE  # [rad] bow up: a bubble is a pitch, in a submarine's words
EXTRA_BUBBLE: Final = 5.0 * DEGREE  # [rad] at speed
EXTRA_BUBBLE_SPEEDS: Final = (9.0 * KNOT, 10.0 * KNOT)  # [m/s] from which to which it is added
BUBBLE_RATE: Final = 1.5 * DEGREE  # [rad/s] at which that pitch is taken up and given back
AFT_BLOW_PITCH: Final = 5.0 * DEGREE  # [rad] pitch below which the after group is not blown
MIN_PITCH_GAIN, MIN_PITCH_RATE_GAIN = 1.5, 8.0  # [-], [s] least gains on pitch and its rate
MAX_STERN_ANGLE: Final = 25.0 * DEGREE  # [rad] of the stern planes

# a boat slower and more level than this for so long has come to rest: the ascent is over
QUIET_TIME_S: Final = 30.0  # [s]
QUIET_RATE: Final = 0.3  # [m/s] of depth
QUIET_PITCH: Final = 5.0 * DEGREE
SURFACED_DEPTH: Final = 0.625  # [diameters] of the origin: the boat is at the surface


@inline_kernel
def is_blown(state: Record) -> bool:
    """Return whether a main tank's emergency valve is open."""
    s = state[0]
    return EMERGENCY_OPENING in (s.blow_forward, s.blow_mid, s.blow_aft)


@inline_kernel
def is_surfacing(state: Record) -> bool:
    """Return whether main ballast is blown to keep depth 0.

    A blow with another depth ordered is the crew's, and the planes go on keeping that depth.
    """
    s = state[0]
    return s.ordered_depth == 0.0 and max(s.blow_forward, s.blow_mid, s.blow_aft) > 0.0


@inline_kernel
def minds_blow(vessel: Record, state: Record) -> bool:
    """Return whether the pilot has planes with which to answer a blow."""
    s = state[0]
    planes = s.stern_by_hand == 0.0 or s.bow_by_hand == 0.0
    return planes and s.depth_law == OWN_LAW and vessel[0].gain_count > 0.0


@inline_kernel
def watch_blow(vessel: Record, state: Record) -> None:
    """Begin an ascent when main ballast is blown in an emergency, or to surface.

    End it where the pilot has no planes. A boat that has surfaced stays afloat with valves open.
    """
    s = state[0]
    begins = is_surfacing(state) and s.ascent == NO_ASCENT
    if not minds_blow(vessel, state):
        s.ascent = NO_ASCENT
    elif begins or (is_blown(state) and s.ascent != ASCENT_RISING):
        s.ascent = ASCENT_RISING
        s.ascent_pitch = s.theta
        s.ascent_quiet = s.ordered_depth = 0.0


@inline_kernel
def take_up_bubble(h: float, state: Record) -> None:
    """Move the pitch that is to be held by ``h`` [s].

    It goes bow up in an emergency blow, and to zero in surfacing and after a blow.
    """
    s = state[0]
    wanted = 0.0
    if is_blown(state):
        slow, fast = EXTRA_BUBBLE_SPEEDS
        share = (s.u - slow) / (fast - slow)
        wanted = ASCENT_BUBBLE + EXTRA_BUBBLE * min(max(share, 0.0), 1.0)
    change = wanted - s.ascent_pitch
    s.ascent_pitch += min(max(change, -BUBBLE_RATE * h), BUBBLE_RATE * h)


@inline_kernel
def hold_bubble(vessel: Record, h: float, gains: Numbers, state: Record) -> None:
    """Command the planes and the after group of a boat that comes up.

    Planes in hand take what they are ordered.
    """
    c = vessel[0]
    s = state[0]
    take_up_bubble(h, state)
    angle = max(MIN_PITCH_GAIN, abs(gains[STERN_GAINS + PITCH_GAIN])) * (s.theta - s.ascent_pitch)
    angle += max(MIN_PITCH_RATE_GAIN, abs(gains[STERN_GAINS + PITCH_RATE_GAIN])) * s.q
    most = min(MAX_STERN_ANGLE, c.limit_s)
    down = 1.0 if c.M_ds <= 0.0 else -1.0  # [-] sign of an angle that takes the bow down
    s.command_s = s.ordered_s if s.stern_by_hand != 0.0 else min(max(down * angle, -most), most)
    s.command_b = s.ordered_b if s.bow_by_hand != 0.0 else 0.0
    if s.blow_forward == EMERGENCY_OPENING:
        s.blow_aft = EMERGENCY_OPENING if s.theta > AFT_BLOW_PITCH else 0.0


@inline_kernel
def hand_back(vessel: Record, h: float, state: Record) -> None:
    """End an ascent that has come to rest.

    The boat then keeps the depth that it has; at the surface it keeps none. Deep, one that surfaces
    goes on, because at great depth it takes minutes until the blow lifts it.
    """
    s = state[0]
    still = abs(s.zdot) < QUIET_RATE and abs(s.theta) < QUIET_PITCH and not is_blown(state)
    s.ascent_quiet = s.ascent_quiet + h if still else 0.0
    if s.ascent_quiet < QUIET_TIME_S:
        return
    if s.z < SURFACED_DEPTH * vessel[0].diameter:
        s.ascent = ASCENT_AFLOAT
        return
    if is_surfacing(state):
        return
    s.ascent = NO_ASCENT
    s.ordered_depth = s.depth_reference = s.z
    s.depth_reference_rate = 0.0


@inline_kernel
def come_up(vessel: Record, h: float, gains: Numbers, state: Record) -> None:
    """Command the planes from a blow until a depth is kept again."""
    if state[0].ascent == ASCENT_AFLOAT:
        lay_amidships(state)
    else:
        hold_bubble(vessel, h, gains, state)
        hand_back(vessel, h, state)


@inline_kernel
def lay_amidships(state: Record) -> None:
    """Command the planes to zero, but those in hand to their order."""
    s = state[0]
    s.command_s = s.ordered_s if s.stern_by_hand != 0.0 else 0.0
    s.command_b = s.ordered_b if s.bow_by_hand != 0.0 else 0.0


@inline_kernel
def go_on_from(state: Record, surface: int, law: float) -> None:
    """Keep the depth ``law`` [rad] of a plane ready during an ascent.

    It follows the angle of the plane, so that depth keeping takes over without a jump. Once the
    ascent is over, the integral takes the angle that is left, as the plane's trim.
    """
    s = state[0]
    stand_by(state, surface, law, False)  # noqa: FBT003 a fact
    if s.ascent == NO_ASCENT:
        s.integral[surface] += s.handover[surface]
        s.handover[surface] = 0.0

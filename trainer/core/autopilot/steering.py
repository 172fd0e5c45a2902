"""The common parts of depth and course keeping: gains by speed, integrals, surfaces in hand.

A surface in hand is followed, so that the autopilot takes it over at the angle where it stands. The
difference between that angle and the autopilot's own is the hand-over; it fades afterwards.
"""

from typing import Final

from trainer.core.elementary import exponential
from trainer.core.kernel import Numbers, Record, inline_kernel
from trainer.core.vessel import (
    DEPTH_SLEW,
    GAINS,
    PLANE_COUNT,
    SLEW_ACCELERATION,
    SLEW_RATE,
    STERN_GAINS,
)

OWN_LAW, REPORT_LAW, REPORT_LITERAL = 0, 1, 2  # depth laws: this project's, then [ASSES]'s two
RUDDER, STERN, BOW = 0, 1, 2  # surfaces, as in the state record

GAIN_COUNT: Final = len(GAINS)

MIN_DIVISOR_SPEED: Final = 0.5  # [m/s] the least speed that is divided by
ASTERN_SPEED: Final = -0.25  # [m/s] below it surfaces are put over the other way
HANDOVER_LENGTHS: Final = 0.25  # [-] boat lengths that are run while a hand-over fades
LEVEL_SHARE: Final = (
    0.1  # [-] share of the allowed rate and acceleration, below which flight is level
)
ARRIVAL_TOLERANCE: Final = 1e-6  # [rad] a surface this near its order has arrived


@inline_kernel
def scheduled_gains(vessel: Record, u: float, gains: Numbers) -> None:
    """Write the gains for speed ``u`` [m/s], interpolated.

    Outside the schedule its first and last gains hold.
    """
    c = vessel[0]
    last = int(c.gain_count) - 1
    upper = 1
    while upper < last and c.gain_speed[upper] < u:
        upper += 1
    lower = upper - 1
    share = (u - c.gain_speed[lower]) / (c.gain_speed[upper] - c.gain_speed[lower])
    share = min(max(share, 0.0), 1.0)
    for i in range(GAIN_COUNT):
        gains[i] = c.gain[lower, i] + share * (c.gain[upper, i] - c.gain[lower, i])


@inline_kernel
def first_gain(surface: int) -> int:
    """Return the index [-] of the first gain of a pair of planes."""
    return STERN_GAINS + PLANE_COUNT * (surface - STERN)


@inline_kernel
def is_level(gains: Numbers, state: Record) -> bool:
    """Return whether the boat neither changes depth nor pitches, so that its trim shows."""
    s = state[0]
    pitch_rate = LEVEL_SHARE * gains[DEPTH_SLEW + SLEW_ACCELERATION] / max(s.u, MIN_DIVISOR_SPEED)
    return abs(s.zdot) < LEVEL_SHARE * gains[DEPTH_SLEW + SLEW_RATE] and abs(s.q) < pitch_rate


@inline_kernel
def is_turning(vessel: Record, state: Record) -> bool:
    """Return whether the boat turns.

    The ordered turn counts, or with the rudder in hand the turn that the boat makes.
    """
    s = state[0]
    rate = s.turn_followed if s.rudder_by_hand != 0.0 else s.psi_reference_rate
    return abs(rate) >= vessel[0].turning_rate


@inline_kernel
def stand_by(state: Record, surface: int, law: float, settled: bool) -> None:  # noqa: FBT001 a fact
    """Follow a surface that others command, for a bumpless change to its own ``law`` [rad].

    In settled flight the angle of the surface is its trim, and the integral learns it. Otherwise
    the difference is a hand-over, which fades once the autopilot has the surface.
    """
    s = state[0]
    trim = s.surface[surface] - law
    if settled and abs(s.command[surface] - s.surface[surface]) < ARRIVAL_TOLERANCE:
        s.integral[surface] = trim
    s.handover[surface] = trim - s.integral[surface]


@inline_kernel
def steer(vessel: Record, state: Record, surface: int, law: float, step: float) -> None:
    """Command a surface by its ``law`` [rad] and its integral, which moves by ``step`` [rad].

    The integral rests where it would drive the surface past its limit.
    """
    s = state[0]
    limit = vessel[0].limit[surface]
    angle = law + s.integral[surface] + s.handover[surface]
    if not (angle > limit and step > 0.0) and not (angle < -limit and step < 0.0):
        s.integral[surface] += step
    angle = law + s.integral[surface] + s.handover[surface]
    s.command[surface] = min(max(angle, -limit), limit)


@inline_kernel
def is_handed_over(state: Record) -> bool:
    """Return whether a hand-over is left to fade."""
    s = state[0]
    return bool(s.rudder_handover != 0.0 or s.stern_handover != 0.0 or s.bow_handover != 0.0)


@inline_kernel
def fade(vessel: Record, h: float, state: Record) -> None:
    """Make the hand-overs of steered surfaces smaller, by ``h`` [s] of their fading.

    They fade with the way that is run, since planes act by it.
    """
    s = state[0]
    left = exponential(-h * max(s.u, MIN_DIVISOR_SPEED) / (HANDOVER_LENGTHS * vessel[0].ell))
    for surface in range(3):
        steered = s.by_hand[surface] == 0.0 and (surface == RUDDER or s.depth_law == OWN_LAW)
        s.handover[surface] *= left if steered else 1.0

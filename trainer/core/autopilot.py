"""The automatic helmsman and planesman: depth, course and speed keeping.

Own law: each surface gets gain times error in depth, depth rate, pitch and pitch rate (course, yaw
rate and sway for the rudder) plus an integral, the gains interpolated over speed. Orders are
slewed: the reference moves at a rate and an acceleration the boat can follow, so that the errors
stay small and the integrals do not wind up. [ASSES]'s depth law stands beside it for comparison.
"""

import math

from trainer.core.kernel import Numbers, Record, kernel
from trainer.core.elementary import cosine, sine

OWN, REPORT, REPORT_LITERAL = 0, 1, 2  # depth laws

# places in the gain table, in the order of vessel.GAINS
STERN, BOW, RUDDER, DEPTH_SLEW, COURSE_SLEW = 0, 5, 10, 14, 16

FOOT = 0.3048
REPORT_DEPTH = 0.008 / FOOT  # [rad/m]
REPORT_PITCH = 3.5  # [-]
REPORT_CLIMB = 0.012 / FOOT  # [rad s/m]
REPORT_PITCH_RATE = 2.0  # [s]
REPORT_LIMIT = math.radians(35.0)
REPORT_FURTHEST = 50.0 * FOOT  # [m] project's clamp on the depth error (errata G5)

SLOWEST = 0.5  # [m/s] below it speed is not divided by
SPEED_BAND = 0.5  # [m/s] speed errors beyond it are left to the propeller


@kernel
def scheduled_gains(vessel: Record, u: float, gains: Numbers) -> None:
    """Write the gains for speed ``u`` [m/s], interpolated; the end values hold beyond the ends."""
    c = vessel[0]
    last = int(c.gain_count) - 1
    upper = 1
    while upper < last and c.gain_speed[upper] < u:
        upper += 1
    lower = upper - 1
    share = (u - c.gain_speed[lower]) / (c.gain_speed[upper] - c.gain_speed[lower])
    share = min(max(share, 0.0), 1.0)
    for i in range(18):
        gains[i] = c.gain[lower, i] + share * (c.gain[upper, i] - c.gain[lower, i])


@kernel
def slewed_rate(distance: float, rate: float, fastest: float, gentlest: float, h: float) -> float:
    """Return the next rate of a reference ``distance`` short of its order.

    At most ``fastest``, changing by at most ``gentlest`` per second, and slow enough to stop.
    """
    size = abs(distance)
    # braking at `gentlest` from here; near the end an exponential that does not hunt
    wanted = min(fastest, math.sqrt(gentlest * size), size / (4.0 * h))
    if distance < 0.0:
        wanted = -wanted
    change = min(max(wanted - rate, -gentlest * h), gentlest * h)
    return rate + change


@kernel
def slew_references(h: float, gains: Numbers, state: Record) -> None:
    """Move the depth and heading references by ``h`` [s]; with hands on, they follow the boat."""
    s = state[0]
    if s.stern_by_hand != 0.0 and s.bow_by_hand != 0.0:
        s.depth_reference, s.depth_reference_rate = s.z, s.zdot
    else:
        s.depth_reference_rate = slewed_rate(
            s.ordered_depth - s.depth_reference,
            s.depth_reference_rate,
            gains[DEPTH_SLEW],
            gains[DEPTH_SLEW + 1],
            h,
        )
        s.depth_reference += h * s.depth_reference_rate
    if s.rudder_by_hand != 0.0:
        s.psi_reference, s.psi_reference_rate = s.psi, s.r
    else:
        s.psi_reference_rate = slewed_rate(
            s.ordered_psi - s.psi_reference,
            s.psi_reference_rate,
            gains[COURSE_SLEW],
            gains[COURSE_SLEW + 1],
            h,
        )
        s.psi_reference += h * s.psi_reference_rate


@kernel
def climb_rate(state: Record) -> float:
    """Return u sin theta - w cos theta [m/s], the report's rate of climb."""
    s = state[0]
    return s.u * sine(s.theta) - s.w * cosine(s.theta)


@kernel
def plane_law(state: Record, gains: Numbers, first: int) -> float:
    """Return a plane angle [rad] without its integral; ``first`` is where its gains begin."""
    s = state[0]
    pitch_wanted = -s.depth_reference_rate / max(s.u, SLOWEST)
    return (
        gains[first] * (s.depth_reference - s.z)
        + gains[first + 1] * (s.depth_reference_rate - s.zdot)
        + gains[first + 2] * (s.theta - pitch_wanted)
        + gains[first + 3] * s.q
    )


@kernel
def report_law(state: Record) -> float:
    """Return the plane angle [rad] of [ASSES] IV, DS = .008 (ZC - Z) + 3.5 theta + ..."""
    s = state[0]
    error = min(max(s.ordered_depth - s.z, -REPORT_FURTHEST), REPORT_FURTHEST)
    angle = (
        REPORT_DEPTH * error
        + REPORT_PITCH * s.theta
        + REPORT_CLIMB * climb_rate(state)
        + REPORT_PITCH_RATE * s.q
    )
    return min(max(angle, -REPORT_LIMIT), REPORT_LIMIT)


@kernel
def course_law(state: Record, gains: Numbers) -> float:
    """Return the rudder angle [rad] without its integral."""
    s = state[0]
    return (
        gains[RUDDER] * (s.psi_reference - s.psi)
        + gains[RUDDER + 1] * (s.psi_reference_rate - s.r)
        + gains[RUDDER + 2] * s.v
    )


@kernel
def wound(integral: float, step: float, law: float, limit: float) -> float:
    """Return the integral [rad] one step on, unless that drives the surface past its limit."""
    angle = law + integral
    if (angle > limit and step > 0.0) or (angle < -limit and step < 0.0):
        return integral
    return integral + step


@kernel
def keep_depth(vessel: Record, h: float, gains: Numbers, state: Record) -> None:
    """Command the planes; a pair in hand keeps its integral ready for a bumpless change."""
    c = vessel[0]
    s = state[0]
    error = s.depth_reference - s.z
    stern, bow = plane_law(state, gains, STERN), plane_law(state, gains, BOW)
    if s.depth_law != OWN:
        report = report_law(state)
        toward = 1.0 if s.depth_law == REPORT_LITERAL or c.Z_db > 0.0 else -1.0
        s.command_s = s.ordered_s if s.stern_by_hand != 0.0 else report
        s.command_b = s.ordered_b if s.bow_by_hand != 0.0 else toward * report
        s.stern_integral, s.bow_integral = s.command_s - stern, s.command_b - bow
        return
    if s.stern_by_hand != 0.0:
        s.command_s = s.ordered_s
        s.stern_integral = s.delta_s - stern
    else:
        step = h * gains[STERN + 4] * error
        s.stern_integral = wound(s.stern_integral, step, stern, c.limit_s)
        s.command_s = stern + s.stern_integral
    if s.bow_by_hand != 0.0:
        s.command_b = s.ordered_b
        s.bow_integral = s.delta_b - bow
    else:
        step = h * gains[BOW + 4] * error
        s.bow_integral = wound(s.bow_integral, step, bow, c.limit_b)
        s.command_b = bow + s.bow_integral


@kernel
def keep_course(vessel: Record, h: float, gains: Numbers, state: Record) -> None:
    """Command the rudder; in hand, its integral is kept ready for a bumpless change."""
    c = vessel[0]
    s = state[0]
    law = course_law(state, gains)
    if s.rudder_by_hand != 0.0:
        s.command_r = s.ordered_r
        s.rudder_integral = s.delta_r - law
    else:
        step = h * gains[RUDDER + 3] * (s.psi_reference - s.psi)
        s.rudder_integral = wound(s.rudder_integral, step, law, c.limit_r)
        s.command_r = law + s.rudder_integral


@kernel
def keep_speed(vessel: Record, h: float, state: Record) -> None:
    """Command the revolutions; their trim is learnt in straight flight and rests in turns."""
    c = vessel[0]
    s = state[0]
    if s.speed_by_hand != 0.0:
        s.command_u_c = s.ordered_u_c
        return
    error = s.ordered_speed - s.u
    if abs(s.r) < c.turning_rate and abs(error) < SPEED_BAND:
        s.speed_trim += h * c.speed_integral * error
    s.command_u_c = min(max(s.ordered_speed + s.speed_trim, c.u_c_astern), c.u_c_ahead)


@kernel
def autopilot(vessel: Record, h: float, state: Record, gains: Numbers) -> None:
    """Write the commanded rudder, planes and revolutions of this tick."""
    s = state[0]
    if vessel[0].gain_count > 0.0:
        scheduled_gains(vessel, s.u, gains)
    slew_references(h, gains, state)
    keep_depth(vessel, h, gains, state)
    keep_course(vessel, h, gains, state)
    keep_speed(vessel, h, state)

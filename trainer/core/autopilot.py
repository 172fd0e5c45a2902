"""The automatic helmsman and planesman: depth, course and speed keeping.

Own law: each surface gets gain times error in depth, depth rate, pitch and pitch rate (course, yaw
rate and sway for the rudder) plus an integral, the gains interpolated over speed. Both pairs of
planes serve depth; a lasting angle of the bow planes is handed over to the stern planes where those
carry it better. [ASSES]'s depth law stands beside it for comparison. A surface in hand is followed,
so that the autopilot takes it over at the angle where it stands.
"""

import math

from trainer.core.casualties import AUTOPILOT_FAILED, slot_of
from trainer.core.elementary import cosine, exponential, sine
from trainer.core.kernel import Numbers, Record, kernel, part
from trainer.core.reference import DEPTH_SLEW, leash, slew_course, slew_depth, within
from trainer.units import FOOT

OWN, REPORT, REPORT_LITERAL = 0, 1, 2  # depth laws
RUDDER, STERN, BOW = 0, 1, 2  # surfaces, as in the state record

# places in the schedule of gains, in the order of vessel.GAINS
PLANE_GAINS, RUDDER_GAINS, GAIN_COUNT = 6, 12, 20

REPORT_DEPTH = 0.008 / FOOT  # [rad/m]
REPORT_PITCH = 3.5  # [-]
REPORT_CLIMB = 0.012 / FOOT  # [rad s/m]
REPORT_PITCH_RATE = 2.0  # [s]
REPORT_LIMIT = math.radians(35.0)
REPORT_FURTHEST = 50.0 * FOOT  # [m] project's clamp on the depth error (errata G5)

SLOWEST = 0.5  # [m/s] below it speed is not divided by
SPEED_BAND = 0.5  # [m/s] speed errors beyond it are left to the propeller
HANDOVER = 0.25  # [-] lengths run while a hand-over fades
SETTLED = 0.1  # [-] share of the allowed depth rate and acceleration below which flight is level
FAR = 0.5  # [-] share of the leash, and of the allowed depth rate
STANDS = 1e-6  # [rad] a surface this near its order has arrived


@part
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
    for i in range(GAIN_COUNT):
        gains[i] = c.gain[lower, i] + share * (c.gain[upper, i] - c.gain[lower, i])


@part
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


@part
def course_law(state: Record, gains: Numbers) -> float:
    """Return the rudder angle [rad] without its integral."""
    s = state[0]
    return (
        gains[RUDDER_GAINS] * (s.psi_reference - s.psi)
        + gains[RUDDER_GAINS + 1] * (s.psi_reference_rate - s.r)
        + gains[RUDDER_GAINS + 2] * s.v
    )


@kernel
def report_law(state: Record) -> float:
    """Return the plane angle [rad] of [ASSES] IV.

    DS = .008 (ZC - Z) + 3.5 theta + .012 (u sin theta - w cos theta) + 2 q, in feet, radians and
    seconds; the bracket is the rate of climb (errata G).
    """
    s = state[0]
    climb_rate = s.u * sine(s.theta) - s.w * cosine(s.theta)
    angle = (
        REPORT_DEPTH * within(s.ordered_depth - s.z, 0.0, REPORT_FURTHEST)
        + REPORT_PITCH * s.theta
        + REPORT_CLIMB * climb_rate
        + REPORT_PITCH_RATE * s.q
    )
    return within(angle, 0.0, REPORT_LIMIT)


@kernel
def report_angle(vessel: Record, state: Record, surface: int) -> float:
    """Return what [ASSES]'s law gives one pair of planes [rad].

    Its DB = DS literally works against the stern planes where bow planes to dive are negative
    (Z_db < 0); there the sign is turned unless the literal law is asked for (errata G3).
    """
    angle = report_law(state)
    if surface == BOW and vessel[0].Z_db <= 0.0 and state[0].depth_law != REPORT_LITERAL:
        return -angle
    return angle


@part
def stand_by(state: Record, surface: int, law: float, settled: bool) -> None:  # noqa: FBT001 a fact
    """Follow a surface that others command, for a bumpless change to its own ``law`` [rad].

    In settled flight its angle is its trim, and the integral learns it; otherwise the difference
    is a hand-over, which fades once the autopilot has it.
    """
    s = state[0]
    trim = s.surface[surface] - law
    if settled and abs(s.command[surface] - s.surface[surface]) < STANDS:
        s.integral[surface] = trim
    s.handover[surface] = trim - s.integral[surface]


@part
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


@part
def fade(vessel: Record, h: float, state: Record) -> None:
    """Let the hand-overs of the surfaces that are steered fade for ``h`` [s]."""
    s = state[0]
    left = exponential(-h * max(s.u, SLOWEST) / (HANDOVER * vessel[0].ell))
    for surface in range(3):
        steered = s.by_hand[surface] == 0.0 and (surface == RUDDER or s.depth_law == OWN)
        s.handover[surface] *= left if steered else 1.0


@part
def is_level(gains: Numbers, state: Record) -> bool:
    """Return whether the boat neither changes depth nor pitches, so that its trim shows."""
    s = state[0]
    pitch_rate = SETTLED * gains[DEPTH_SLEW + 1] / max(s.u, SLOWEST)
    return abs(s.zdot) < SETTLED * gains[DEPTH_SLEW] and abs(s.q) < pitch_rate


@part
def depth_error(gains: Numbers, state: Record) -> float:
    """Return the depth error [m] to be integrated, 0 while it says nothing about the trim.

    That is while the boat changes depth as it should, and while it is far off and under way: either
    returning or being taken away. Held far off, it learns.
    """
    s = state[0]
    error = s.depth_reference - s.z
    rate, share = s.depth_reference_rate, SETTLED
    if abs(error) > FAR * leash(gains, DEPTH_SLEW):
        rate, share = s.zdot, FAR
    return error if abs(rate) < share * gains[DEPTH_SLEW] else 0.0


@part
def keep_plane(
    vessel: Record, h: float, gains: Numbers, state: Record, surface: int, lasting: float
) -> None:
    """Command one pair of planes; ``lasting`` [rad] is the bow planes' angle to be relieved of."""
    s = state[0]
    first = PLANE_GAINS * (surface - STERN)
    law = plane_law(state, gains, first)
    if s.by_hand[surface] != 0.0:
        s.command[surface] = s.ordered[surface]
        stand_by(state, surface, law, is_level(gains, state))
    elif s.depth_law != OWN:
        s.command[surface] = report_angle(vessel, state, surface)
        stand_by(state, surface, law, is_level(gains, state))
    else:
        error = depth_error(gains, state)
        step = h * (gains[first + 4] * error + gains[first + 5] * lasting)
        steer(vessel, state, surface, law, step)


@part
def keep_depth(vessel: Record, h: float, gains: Numbers, state: Record) -> None:
    """Command both pairs of planes.

    The stern planes relieve the bow planes only while they can move as told: not in hand, and not
    held by the rudder's share of an X-tail.
    """
    s = state[0]
    able = abs(s.command_s - s.delta_s) <= vessel[0].surface_rate * h
    lasting = 0.0
    if able and s.stern_by_hand == 0.0 and s.bow_by_hand == 0.0:
        lasting = s.delta_b
    keep_plane(vessel, h, gains, state, STERN, lasting)
    keep_plane(vessel, h, gains, state, BOW, lasting)


@part
def keep_course(vessel: Record, h: float, gains: Numbers, state: Record) -> None:
    """Command the rudder."""
    s = state[0]
    law = course_law(state, gains)
    if s.rudder_by_hand != 0.0:
        s.command_r = s.ordered_r
        stand_by(state, RUDDER, law, abs(s.r) < vessel[0].turning_rate)
    else:
        step = 0.0
        if abs(s.psi_reference_rate) < vessel[0].turning_rate:
            step = h * gains[RUDDER_GAINS + 3] * (s.psi_reference - s.psi)
        steer(vessel, state, RUDDER, law, step)


@part
def drive(vessel: Record, h: float, state: Record) -> None:
    """Command the revolutions; their trim is learnt in straight flight and rests in turns.

    While the boat still answers to the propeller, at its own surge rate, there is nothing to learn:
    its acceleration makes up for the error that remains.
    """
    c = vessel[0]
    s = state[0]
    error = s.ordered_speed - s.u
    step = h * (c.speed_integral * max(s.u, 0.0) / c.gain_speed[0] * error - s.udot)
    wanted = s.ordered_speed + s.speed_trim + step
    possible = c.u_c_astern < wanted < c.u_c_ahead
    if possible and abs(s.r) < c.turning_rate and abs(error) < SPEED_BAND:
        s.speed_trim += step
    command = s.ordered_speed + s.speed_trim
    s.command_u_c = min(max(command, c.u_c_astern), c.u_c_ahead)


@part
def keep_speed(vessel: Record, h: float, state: Record) -> None:
    """Command the revolutions, as ordered by hand or to keep the speed."""
    s = state[0]
    if s.speed_by_hand != 0.0 or vessel[0].gain_count == 0.0:
        s.command_u_c = s.ordered_u_c
    else:
        drive(vessel, h, state)


@kernel
def hold_commands(gains: Numbers, state: Record) -> None:
    """Leave the commands of a failed autopilot as they are; hands still take what they order.

    Its laws stand by, so that it goes on without a bump.
    """
    s = state[0]
    if s.speed_by_hand != 0.0:
        s.command_u_c = s.ordered_u_c
    for surface in range(3):
        if s.by_hand[surface] != 0.0:
            s.command[surface] = s.ordered[surface]
    stand_by(state, RUDDER, course_law(state, gains), False)  # noqa: FBT003 a fact
    stand_by(state, STERN, plane_law(state, gains, 0), False)  # noqa: FBT003
    stand_by(state, BOW, plane_law(state, gains, PLANE_GAINS), False)  # noqa: FBT003


@part
def autopilot(vessel: Record, h: float, state: Record, gains: Numbers) -> None:
    """Write the commanded rudder, planes and revolutions of this tick."""
    s = state[0]
    if vessel[0].gain_count > 0.0:
        scheduled_gains(vessel, s.u, gains)
    slew_depth(h, gains, state)
    slew_course(h, gains, state)
    if slot_of(AUTOPILOT_FAILED, state) >= 0:
        hold_commands(gains, state)
        return
    keep_depth(vessel, h, gains, state)
    keep_course(vessel, h, gains, state)
    fade(vessel, h, state)
    keep_speed(vessel, h, state)


@kernel
def stand_by_all(vessel: Record, h: float, state: Record, scratch: Record) -> None:
    """Let the autopilot take note of what is in hand, ready for a bumpless change."""
    autopilot(vessel, h, state, scratch[0].gains)

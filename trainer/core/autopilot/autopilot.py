"""The automatic helmsman and planesman: depth, course, speed and trim keeping, tick by tick.

The angle of a plane is the sum of gains times the errors in depth, depth rate, pitch and pitch
rate, plus an integral. For the rudder the errors are those in course and yaw rate, and sway. The
gains are interpolated over speed. The depth law of [ASSES] stands beside it for comparison.
``update`` calls ``autopilot`` once a tick, before the forces. What is "in hand" the crew commands
itself; its law then only stands by and follows, so that the autopilot can take over without a jump.
"""

from trainer.core.autopilot.ascent import NO_ASCENT, come_up, go_on_from, lay_amidships, watch_blow
from trainer.core.autopilot.course import course_law, keep_course
from trainer.core.autopilot.depth import keep_depth, plane_law
from trainer.core.autopilot.reference import slew_course, slew_depth, slow_turns
from trainer.core.autopilot.speed import keep_speed
from trainer.core.autopilot.steering import (
    ASTERN_SPEED,
    BOW,
    RUDDER,
    STERN,
    fade,
    first_gain,
    is_handed_over,
    scheduled_gains,
    stand_by,
)
from trainer.core.autopilot.trimming import keep_trim
from trainer.core.autopilot.waves import sense_waves
from trainer.core.ballast.hover import is_hovering
from trainer.core.casualties import AUTOPILOT_FAILED, slot_of
from trainer.core.kernel import Numbers, Record, inline_kernel, kernel
from trainer.core.plant.parts import FED_AUTOPILOT, is_dead


@kernel
def hold_commands(gains: Numbers, state: Record) -> None:
    """Leave the commands of a failed autopilot as they are.

    What is in hand still takes what is ordered. The laws stand by, so that the autopilot goes on
    without a bump. It asks nothing of the trim pumps.
    """
    s = state[0]
    s.trim_flood = s.trim_forward = 0.0
    if s.speed_by_hand != 0.0:
        s.command_u_c = s.ordered_u_c
    for surface in range(3):
        if s.by_hand[surface] != 0.0:
            s.command[surface] = s.ordered[surface]
    stand_by(state, RUDDER, course_law(state, gains), False)  # noqa: FBT003 a fact
    stand_by(state, STERN, plane_law(state, gains, first_gain(STERN)), False)  # noqa: FBT003
    stand_by(state, BOW, plane_law(state, gains, first_gain(BOW)), False)  # noqa: FBT003


@inline_kernel
def keep_planes(vessel: Record, h: float, scratch: Record, state: Record) -> None:
    """Command both pairs of planes.

    They keep the depth, or bring the boat up in a blow. While the boat hovers, its tank keeps the
    depth and the planes lie amidships.
    """
    s, gains = state[0], scratch[0].gains
    watch_blow(vessel, state)
    if s.ascent != NO_ASCENT:
        come_up(vessel, h, gains, state)
        go_on_from(state, STERN, plane_law(state, gains, first_gain(STERN)))
        go_on_from(state, BOW, plane_law(state, gains, first_gain(BOW)))
    elif is_hovering(state):
        lay_amidships(state)
        stand_by(state, STERN, plane_law(state, gains, first_gain(STERN)), False)  # noqa: FBT003 a fact
        stand_by(state, BOW, plane_law(state, gains, first_gain(BOW)), False)  # noqa: FBT003
    else:
        keep_depth(vessel, h, scratch, state)
        return
    s.wave_share = 0.0  # the law for waves begins anew


@inline_kernel
def autopilot(vessel: Record, h: float, state: Record, scratch: Record) -> None:
    """Write the commanded rudder, planes and revolutions of this tick.

    The references move first, then each keeper commands its part. An autopilot that failed or
    has no power leaves all as it is. The gains in the work space are filled for the present speed.
    """
    s, gains = state[0], scratch[0].gains
    if vessel[0].gain_count > 0.0:
        scheduled_gains(vessel, abs(s.u), gains)
        if s.u < ASTERN_SPEED:
            slow_turns(gains, state)
    slew_depth(h, gains, state)
    slew_course(h, gains, state)
    if slot_of(AUTOPILOT_FAILED, state) >= 0 or is_dead(FED_AUTOPILOT, state):
        hold_commands(gains, state)
        return
    sense_waves(vessel, h, gains, state)
    keep_planes(vessel, h, scratch, state)
    keep_course(vessel, h, gains, state)
    if is_handed_over(state):
        fade(vessel, h, state)
    keep_speed(vessel, h, state)
    keep_trim(vessel, h, state)


@kernel
def stand_by_all(vessel: Record, h: float, state: Record, scratch: Record) -> None:
    """Make the autopilot follow what is in hand, ready for a change without a jump.

    A boat that is started calls it once, before the first tick.
    """
    autopilot(vessel, h, state, scratch)

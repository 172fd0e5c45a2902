"""Control surfaces: lag, rate and angle limits, casualties, and the X-tail's shared planes.

``update`` moves them once a tick, after the forces, towards what the autopilot or the crew
commands.
"""

import math

from trainer.core.autopilot.reference import within
from trainer.core.casualties import (
    FOLLOW_UP_LOST,
    KIND_FAULTS,
    SERVO_CODE,
    SURFACE_FREE,
    SURFACE_SLOW,
    fault_of,
    slot_of,
)
from trainer.core.elementary import exponential
from trainer.core.kernel import Record, inline_kernel, kernel
from trainer.core.plant.oil import draw_oil, fed_share
from trainer.core.plant.parts import NORMAL

AMIDSHIPS_ANGLE = math.radians(0.5)  # [rad] a command this small is one amidships


@inline_kernel
def advance_surface(
    angle: float, ordered: float, limit: float, furthest: float, share: float
) -> float:
    """Return where a surface [rad] stands after one step.

    Its lag covers ``share`` of the distance to the order. Its rate allows at most ``furthest``
    [rad], and it stays within ``limit`` [rad].
    """
    target = min(max(ordered, -limit), limit)
    travel = share * (target - angle)
    return angle + min(max(travel, -furthest), furthest)


@inline_kernel
def target_angle(vessel: Record, furthest: float, surface: int, slot: int, state: Record) -> float:
    """Return the angle [rad] towards which a surface moves.

    That is its command, or what a casualty makes of it. A target ``furthest`` [rad] away is the
    farthest that the rate can answer in this tick, because the lag covers a share. ``slot`` is that
    of the casualty, -1 if the surface is sound. Without follow-up the command says only which way
    to move; a command amidships, within AMIDSHIPS_ANGLE, stops the surface.
    """
    c = vessel[0]
    s = state[0]
    angle, command = s.surface[surface], s.command[surface]
    if slot < 0:
        return command
    amount = s.casualty_amount[slot]
    fault = KIND_FAULTS[int(s.casualty[slot])]
    if fault == SURFACE_SLOW:
        most = furthest * (1.0 - amount)
        command = within(command, angle, most)
    elif fault == FOLLOW_UP_LOST:
        command = (
            angle if abs(command) < AMIDSHIPS_ANGLE else math.copysign(c.limit[surface], command)
        )
    elif fault == SURFACE_FREE:
        command = within(0.0, angle, amount * furthest)
    else:
        command = amount
    return within(command, 0.0, c.limit[surface])


@inline_kernel
def servo_fault_of(surface: int, state: Record) -> int:
    """Return the slot [-] of the stuck servo that drives a surface, -1 for none.

    It does so in normal alone: emergency and hand have valves of their own.
    """
    if state[0].mode[surface] != NORMAL:
        return -1
    return slot_of(SERVO_CODE[surface], state)


@inline_kernel
def fed_target(vessel: Record, furthest: float, surface: int, share: float, state: Record) -> float:
    """Return the angle [rad] towards which a surface moves with a plant.

    ``share`` is what it has of its rate [-], ``furthest`` as in ``target_angle``. What
    nothing feeds trails to zero, if it moves at all.
    """
    if share == 0.0 and vessel[0].trail_share > 0.0:
        return 0.0
    slot = servo_fault_of(surface, state)
    if slot >= 0:
        return within(state[0].casualty_amount[slot], 0.0, vessel[0].limit[surface])
    return target_angle(vessel, furthest, surface, fault_of(surface, state), state)


@kernel
def move_fed_surfaces(vessel: Record, h: float, lag_share: float, state: Record) -> None:
    """Advance rudder and planes by ``h`` [s] at the rates that the plant gives.

    They draw its oil. Each lag covers ``lag_share`` of the way.
    """
    c = vessel[0]
    s = state[0]
    furthest = c.surface_rate * h
    was_r, was_s, was_b = s.delta_r, s.delta_s, s.delta_b
    fed_r, fed_s, fed_b = (
        fed_share(vessel, 0, state),
        fed_share(vessel, 1, state),
        fed_share(vessel, 2, state),
    )
    rudder = fed_target(vessel, furthest / lag_share, 0, fed_r, state)
    stern = fed_target(vessel, furthest / lag_share, 1, fed_s, state)
    bow = fed_target(vessel, furthest / lag_share, 2, fed_b, state)
    most_r = furthest * (fed_r if fed_r > 0.0 else c.trail_share)
    most_s = furthest * (fed_s if fed_s > 0.0 else c.trail_share)
    most_b = furthest * (fed_b if fed_b > 0.0 else c.trail_share)
    if c.x_tail != 0.0:
        most = min(most_r, most_s)
        if fault_of(0, state) >= 0 or servo_fault_of(0, state) >= 0:
            stern = within(stern, 0.0, max(c.limit_s - abs(rudder), 0.0))
        elif fault_of(1, state) >= 0 or servo_fault_of(1, state) >= 0:
            rudder = within(rudder, 0.0, max(c.limit_s - abs(stern), 0.0))
        one, other = s.delta_s + s.delta_r, s.delta_s - s.delta_r
        one = advance_surface(one, stern + rudder, c.limit_s, most, lag_share)
        other = advance_surface(other, stern - rudder, c.limit_s, most, lag_share)
        s.delta_s, s.delta_r = 0.5 * (one + other), 0.5 * (one - other)
    else:
        s.delta_s = advance_surface(s.delta_s, stern, c.limit_s, most_s, lag_share)
        s.delta_r = advance_surface(s.delta_r, rudder, c.limit_r, most_r, lag_share)
    s.delta_b = advance_surface(s.delta_b, bow, c.limit_b, most_b, lag_share)
    draw_oil(vessel, abs(s.delta_r - was_r), abs(s.delta_s - was_s), abs(s.delta_b - was_b), state)


@inline_kernel
def move_surfaces(vessel: Record, h: float, state: Record) -> None:
    """Advance rudder and planes by ``h`` [s] towards their commands.

    On an X-tail each diagonal pair of planes carries the sum or the difference of the stern-plane
    and rudder angles, so that the limit and the rate hold for |delta_r| + |delta_s|. If rudder or
    stern planes have a casualty, they take the angle that it gives, and the other has what is left
    of the limit.
    """
    c = vessel[0]
    s = state[0]
    share = 1.0
    if c.surface_lag > 0.0:
        share = 1.0 - exponential(-h / c.surface_lag)
    if s.plant_touched != 0.0:
        move_fed_surfaces(vessel, h, share, state)
        return
    furthest = c.surface_rate * h
    rudder_fault, stern_fault = fault_of(0, state), fault_of(1, state)
    rudder = target_angle(vessel, furthest / share, 0, rudder_fault, state)
    stern = target_angle(vessel, furthest / share, 1, stern_fault, state)
    if c.x_tail != 0.0:
        if rudder_fault >= 0:
            left = max(c.limit_s - abs(rudder), 0.0)
            stern = within(stern, 0.0, left)
        elif stern_fault >= 0:
            left = max(c.limit_s - abs(stern), 0.0)
            rudder = within(rudder, 0.0, left)
        one, other = s.delta_s + s.delta_r, s.delta_s - s.delta_r
        one = advance_surface(one, stern + rudder, c.limit_s, furthest, share)
        other = advance_surface(other, stern - rudder, c.limit_s, furthest, share)
        s.delta_s, s.delta_r = 0.5 * (one + other), 0.5 * (one - other)
    else:
        s.delta_s = advance_surface(s.delta_s, stern, c.limit_s, furthest, share)
        s.delta_r = advance_surface(s.delta_r, rudder, c.limit_r, furthest, share)
    bow = target_angle(vessel, furthest / share, 2, fault_of(2, state), state)
    s.delta_b = advance_surface(s.delta_b, bow, c.limit_b, furthest, share)

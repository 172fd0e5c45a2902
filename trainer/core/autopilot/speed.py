"""Speed keeping: revolutions for the ordered speed, and a trim that is learnt.

The command speed of the propeller is the ordered speed plus this trim, because drag of planes and
sea makes the boat slower than its revolutions would in calm, straight flight. While the boat
answers to the propeller, at its own surge rate, there is nothing to learn: its acceleration makes
up for the error that remains. What is to be learnt passes two low-passes. A gate on the error is
not used, because the acceleration in waves sums to zero over a cycle, but not through a gate. The
law is this project's own; times and limits are estimates, except for what docs/autopilot.md shows.
"""

from typing import Final

from trainer.core.autopilot.steering import is_turning
from trainer.core.kernel import Record, inline_kernel

LOW_PASS_TIME_S: Final = 5.0  # [s] of the low-passes
ANSWER_TIME_S: Final = 400.0  # [s] after an order, in which ...
ANSWER_ERROR: Final = 0.25  # [m/s] ... a larger error means that the boat still answers
MAX_SPEED_TRIM: Final = (0.5, 0.5)  # [-] of the ordered speed, [m/s]: the largest trim
PROPELLER_SLACK: Final = (
    0.1  # [m/s] command speed that the propeller may lack and count as at its order
)


@inline_kernel
def follow_speed(h: float, state: Record) -> None:
    """Follow speed and yaw rate for ``h`` [s].

    Count the time since another speed was ordered.
    """
    s = state[0]
    share = h / (LOW_PASS_TIME_S + h)
    s.speed_followed += share * (s.u - s.speed_followed)
    s.turn_followed += share * (s.r - s.turn_followed)
    s.speed_since = 0.0 if s.ordered_speed != s.speed_order else s.speed_since + h
    s.speed_order = s.ordered_speed


@inline_kernel
def largest_trim(state: Record) -> float:
    """Return the largest trim [m/s] that is allowed, either way.

    The trim is what the command speed has more than the ordered speed.
    """
    share, rest = MAX_SPEED_TRIM
    return share * abs(state[0].ordered_speed) + rest


@inline_kernel
def follow_trim(vessel: Record, h: float, state: Record) -> None:
    """Follow for ``h`` [s] what the boat shows of its trim.

    That is nothing while the boat turns or answers an order, or while the propeller does not turn
    as commanded.
    """
    c = vessel[0]
    s = state[0]
    share = h / (LOW_PASS_TIME_S + h)
    pace = c.speed_integral * max(s.speed_followed, 0.0) / c.gain_speed[0]
    rate = pace * (s.ordered_speed - s.u) - s.udot
    rate = 0.0 if is_turning(vessel, state) else rate
    answering = (
        abs(s.ordered_speed - s.speed_followed) > ANSWER_ERROR and s.speed_since < ANSWER_TIME_S
    )
    first = s.speed_rate_1 + share * (rate - s.speed_rate_1)
    answering = answering or abs(s.command_u_c - s.u_c) > PROPELLER_SLACK
    first = 0.0 if answering else first
    second = s.speed_rate_2 + share * (first - s.speed_rate_2)
    s.speed_rate_1, s.speed_rate_2 = first, 0.0 if answering else second


@inline_kernel
def learnt(vessel: Record, h: float, state: Record) -> float:
    """Return the speed trim [m/s] after ``h`` [s].

    The trim stays as it is where more of it would ask for more than the engine or the limit gives.
    """
    c = vessel[0]
    s = state[0]
    most = largest_trim(state)
    new = s.speed_trim + h * s.speed_rate_2
    command = s.ordered_speed + new
    over = (command > c.u_c_ahead or new > most) and new > s.speed_trim
    under = (command < c.u_c_astern or new < -most) and new < s.speed_trim
    return s.speed_trim if over or under else new


@inline_kernel
def is_short(vessel: Record, state: Record) -> bool:
    """Return whether the engine gives all it can and the boat remains too slow."""
    c = vessel[0]
    s = state[0]
    lacking = s.ordered_speed - s.speed_followed > ANSWER_ERROR
    all_given = s.command_u_c >= c.u_c_ahead or s.command_u_c - s.u_c > PROPELLER_SLACK
    all_given = all_given or s.speed_trim >= largest_trim(state)
    return lacking and all_given and not is_turning(vessel, state)


@inline_kernel
def keep_speed(vessel: Record, h: float, state: Record) -> None:
    """Command the revolutions, as ordered by hand or to keep the speed.

    To keep a speed ahead they are never turned astern.
    """
    c = vessel[0]
    s = state[0]
    follow_speed(h, state)
    if s.speed_by_hand != 0.0 or c.gain_count == 0.0:
        s.command_u_c = s.ordered_u_c
        s.speed_since = s.speed_short = s.speed_rate_1 = s.speed_rate_2 = 0.0
        return
    follow_trim(vessel, h, state)
    s.speed_trim = learnt(vessel, h, state)
    least = max(c.u_c_astern, min(s.ordered_speed, 0.0))
    s.command_u_c = min(max(s.ordered_speed + s.speed_trim, least), c.u_c_ahead)
    s.speed_short = s.speed_short + h if is_short(vessel, state) else 0.0

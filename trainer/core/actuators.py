"""Control surfaces: lag, rate and angle limits, and the X-tail's shared planes."""

from trainer.core.elementary import exponential
from trainer.core.kernel import Record, kernel


@kernel
def moved(angle: float, ordered: float, limit: float, furthest: float, share: float) -> float:
    """Return where a surface [rad] stands after one step.

    ``share`` of the distance to the order is covered by the lag, at most ``furthest`` [rad] by
    the rate, and nothing beyond ``limit`` [rad].
    """
    target = ordered
    if target > limit:
        target = limit
    elif target < -limit:
        target = -limit
    travel = share * (target - angle)
    if travel > furthest:
        travel = furthest
    elif travel < -furthest:
        travel = -furthest
    return angle + travel


@kernel
def move_surfaces(vessel: Record, h: float, state: Record) -> None:
    """Advance rudder and planes by ``h`` [s] towards their commands.

    On an X-tail each diagonal pair of planes carries the sum or the difference of the stern-plane
    and rudder angles, so that the limit and the rate hold for |delta_r| + |delta_s|.
    """
    c = vessel[0]
    s = state[0]
    share = 1.0
    if c.surface_lag > 0.0:
        share = 1.0 - exponential(-h / c.surface_lag)
    furthest = c.surface_rate * h
    if c.x_tail != 0.0:
        one, other = s.delta_s + s.delta_r, s.delta_s - s.delta_r
        one = moved(one, s.command_s + s.command_r, c.limit_s, furthest, share)
        other = moved(other, s.command_s - s.command_r, c.limit_s, furthest, share)
        s.delta_s, s.delta_r = 0.5 * (one + other), 0.5 * (one - other)
    else:
        s.delta_s = moved(s.delta_s, s.command_s, c.limit_s, furthest, share)
        s.delta_r = moved(s.delta_r, s.command_r, c.limit_r, furthest, share)
    s.delta_b = moved(s.delta_b, s.command_b, c.limit_b, furthest, share)

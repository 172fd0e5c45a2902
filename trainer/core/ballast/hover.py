"""Hovering: the depth-control tank keeps the ordered depth of a boat that makes little way.

An order to hover at more than MAX_WAY_SPEED waits: the planes keep the depth until then, never
both.

A depth error asks for a depth rate, within limits. An error in that rate asks for an acceleration,
and so for water, at the natural frequency of the vessel file and a damping ratio. In waves that are
felt it does so more softly. The error passes notches at those waves and a low-pass: unfiltered
waves would keep the pump at its most. Under waves suction grows towards the surface, which makes
the boat unstable there; that growth is added to the water asked for. The integral learns how much
the boat is out of trim. It rests while the tank or the pump cannot give what is wanted.

What the pump cannot hold is given up, and the planes keep the depth. Under waves that is an error
that has grown by MAX_ERROR_GROWTH_M, or one that grows faster than the pump can turn, CATCH_SHARE
of R g/(Q p^3) for the pole p of the suction. It is also a pump that has been at its most for
MAX_CATCH_TIME_S. Law and limits are this project's own; docs/autopilot.md has its figures.
"""

import math
from typing import Final

from trainer.core.autopilot.sections import OUTPUT, SECTION_SIZE, low_pass, notch, pass_section
from trainer.core.autopilot.waves import (
    LOWER_NOTCH,
    UPPER_NOTCH,
    are_counted,
    are_felt,
    frequency_met,
)
from trainer.core.ballast.tanks import DEPTH_CONTROL, DEPTH_CONTROL_PUMP
from trainer.core.kernel import Record, inline_kernel, kernel
from trainer.core.sea.forces import suction
from trainer.units import KNOT

# in a calm, and in waves that are felt
FREQUENCY_FACTORS: Final = (1.0, 0.8)  # [-] on the natural frequency
DAMPING_RATIOS: Final = (1.0, 1.5)  # [-]
INTEGRAL_FACTORS: Final = (0.4, 0.2)  # [-] times frequency^2
ZERO_DAMPING, POLE_DAMPING = 0.1, 0.6  # [-] damping ratios of the notches
LOWER, UPPER, SMOOTH = (
    0,
    SECTION_SIZE,
    2 * SECTION_SIZE,
)  # indices of the filter: two notches, the low-pass
SLOW_FREQUENCY, SLOW_DAMPING = 0.15, 0.8  # [rad/s], [-] of the low-pass
MAX_SUCTION_ERROR_M: Final = 5.0  # [m] most error for which the growth of suction is counted
LEARNING_TIME_S: Final = 20.0  # [s] of pumping; where less is ordered the integral learns

MAX_WAY_SPEED: Final = 3.0 * KNOT  # [m/s] from there on planes hold a boat better
MAX_ERROR_GROWTH_M: Final = 5.0  # [m]
CATCH_SHARE: Final = 0.7  # [-]
MAX_CATCH_TIME_S: Final = 120.0  # [s]
GIVE_UP_SPEED: Final = 4.0 * KNOT  # [m/s] speed ordered where hovering is given up
GROUP_FACTOR: Final = 2.5  # [-] pump wanted over p F/g, since waves come in groups: estimate
SURE_PUMP_SHARE: Final = 0.8  # [-] of the pump that may be wanted


@inline_kernel
def is_hovering(state: Record) -> bool:
    """Return whether the tank keeps the depth."""
    s = state[0]
    return s.hover > 0.0 and abs(s.u) < MAX_WAY_SPEED


@inline_kernel
def heaved_mass(vessel: Record) -> float:
    """Return the mass [kg] that heaves: displaced and added mass."""
    return vessel[0].buoyancy / vessel[0].g - vessel[0].Z_wdot


@kernel
def suction_gradient(vessel: Record, depth: float, state: Record) -> float:
    """Return by how much suction per mass falls with depth [1/s2].

    It is that of the sea in force.
    """
    s = state[0]
    if s.sea_height == 0.0 or s.sea_suction == 0.0:
        return 0.0
    _, gradient = suction(vessel[0].g, s.sea_omega, s.sea_height, depth)
    return s.sea_suction * gradient


@kernel
def wanted_pump(vessel: Record, depth: float, state: Record) -> float:
    """Return the pump rate [kg/s] for hovering at ``depth`` [m] in the sea in force."""
    s = state[0]
    gradient = suction_gradient(vessel, depth, state)
    if gradient == 0.0:
        return 0.0
    lift, _ = suction(vessel[0].g, s.sea_omega, s.sea_height, depth)
    lift *= s.sea_suction * heaved_mass(vessel)
    return GROUP_FACTOR * math.sqrt(gradient) * lift / vessel[0].g


@inline_kernel
def follow_error(h: float, state: Record) -> None:
    """Follow the filtered depth error [m] and its rate [m/s] for ``h`` [s].

    The filter takes the waves out.
    """
    s = state[0]
    kept = s.hover_filter
    fresh = s.hover_time == 0.0 or s.ordered_depth != s.hover_order
    s.hover_order = s.ordered_depth
    x = s.ordered_depth - s.z
    if are_counted(state):
        omega = frequency_met(state)
        anew = fresh or s.hover_notched == 0.0
        pass_section(
            notch(LOWER_NOTCH * omega, h, ZERO_DAMPING, POLE_DAMPING), x, anew, LOWER, kept
        )
        x = kept[LOWER + OUTPUT]
        pass_section(
            notch(UPPER_NOTCH * omega, h, ZERO_DAMPING, POLE_DAMPING), x, anew, UPPER, kept
        )
        x = kept[UPPER + OUTPUT]
        s.hover_notched = 1.0
    else:
        s.hover_notched = 0.0
    last = kept[SMOOTH + OUTPUT]
    pass_section(low_pass(SLOW_FREQUENCY, h, SLOW_DAMPING), x, fresh, SMOOTH, kept)
    s.hover_error = kept[SMOOTH + OUTPUT]
    s.hover_error_rate = 0.0 if fresh else (s.hover_error - last) / h
    room = abs(s.hover_error) + MAX_ERROR_GROWTH_M
    s.hover_room = room if fresh else max(min(s.hover_room, room), MAX_ERROR_GROWTH_M)


@inline_kernel
def is_beyond(vessel: Record, gradient: float, state: Record) -> bool:
    """Return whether the pump cannot bring the boat back.

    ``gradient`` [1/s2] is that of the suction.
    """
    s = state[0]
    error, rate = s.hover_error, s.hover_error_rate
    if gradient == 0.0:
        return False
    pole = math.sqrt(gradient)
    rate_of_pump = vessel[0].pump_rate[DEPTH_CONTROL_PUMP]
    caught = rate_of_pump * vessel[0].g / (heaved_mass(vessel) * pole * pole * pole)
    lost = abs(error) > s.hover_room or abs(error + rate / pole) > CATCH_SHARE * caught
    return lost or s.hover_full > MAX_CATCH_TIME_S


@inline_kernel
def give_up(state: Record) -> None:
    """Leave the depth to the planes.

    Where speed is automatic, order way for them.
    """
    s = state[0]
    s.hover, s.hover_lost = 0.0, 1.0
    s.to_move[DEPTH_CONTROL_PUMP] = 0.0
    s.hover_time = 0.0
    if s.speed_by_hand == 0.0:
        s.ordered_speed = max(s.ordered_speed, GIVE_UP_SPEED)


@inline_kernel
def order_water(vessel: Record, gradient: float, h: float, state: Record) -> None:
    """Order water for the depth-control tank by the filtered error.

    The integral learns from it for ``h`` [s].
    """
    c = vessel[0]
    s = state[0]
    rough = 1 if are_felt(state) else 0
    frequency, damping = FREQUENCY_FACTORS[rough] * c.hover_frequency, DAMPING_RATIOS[rough]
    per_acceleration = heaved_mass(vessel) / c.g  # [kg s2/m] of water
    asked = s.hover_error * frequency / (2.0 * damping)
    lack = min(max(asked, -c.hover_rate), c.hover_rate) + s.hover_error_rate
    held = gradient * min(max(s.hover_error, -MAX_SUCTION_ERROR_M), MAX_SUCTION_ERROR_M)
    wanted = s.hover_integral
    wanted += per_acceleration * (2.0 * damping * frequency * lack + held)
    possible = min(max(wanted, 0.0), c.capacity[DEPTH_CONTROL])
    s.to_move[DEPTH_CONTROL_PUMP] = possible - s.water[DEPTH_CONTROL]
    rate = c.pump_rate[DEPTH_CONTROL_PUMP]
    size = abs(s.to_move[DEPTH_CONTROL_PUMP])
    s.hover_full = s.hover_full + h if size > rate * h else 0.0
    if wanted == possible and size < LEARNING_TIME_S * rate:
        learnt = INTEGRAL_FACTORS[rough] * frequency * frequency * lack * h
        s.hover_integral += per_acceleration * learnt


@kernel
def hover(vessel: Record, h: float, state: Record) -> None:
    """Keep the ordered depth by the depth-control tank for ``h`` [s], or give it up."""
    s = state[0]
    follow_error(h, state)
    s.hover_time += h
    gradient = suction_gradient(vessel, s.ordered_depth, state)
    if is_beyond(vessel, gradient, state):
        give_up(state)
        return
    order_water(vessel, gradient, h, state)

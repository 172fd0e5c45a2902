"""Pumps: trim transfer, trim-and-drain, and depth control.

An order is what is still to be moved [kg]. It counts down to zero, so that a leak belongs to no
order. A pump lets sea water in at its own rate at any depth; out, its rate falls with depth.

``ballast`` calls it once a tick.
"""

import math

from trainer.core.ballast.hover import hover, is_hovering
from trainer.core.ballast.tanks import (
    AUXILIARY_TANK,
    DEPTH_CONTROL,
    DEPTH_CONTROL_PUMP,
    DRAIN_PUMP,
    FIRST_DRY,
    TANKS_END,
    TRIM_AFT,
    TRIM_FORWARD,
    TRIM_PUMP,
    admit,
)
from trainer.core.kernel import Record, inline_kernel
from trainer.core.plant.parts import FED_TRIM, is_dead


@inline_kernel
def delivery(ballast: Record, depth: float) -> float:
    """Return the share [-] of its rate that a pump delivers to the sea.

    The boat is at ``depth`` [m]. The pump is centrifugal: its head falls with the square of its
    flow.
    """
    left = 1.0 - max(depth, 0.0) / ballast[0].shutoff_depth
    return math.sqrt(left) if left > 0.0 else 0.0


@inline_kernel
def sound_rate(ballast: Record, pump: int, state: Record) -> float:
    """Return the rate [kg/s] of a pump, less what its fault takes; 0 without power."""
    if is_dead(FED_TRIM + pump, state):
        return 0.0
    return ballast[0].pump_rate[pump] * (1.0 - min(max(state[0].pump_fault[pump], 0.0), 1.0))


@inline_kernel
def pump_tank(ballast: Record, pump: int, tank: int, h: float, state: Record) -> None:
    """Move the water that is ordered between a tank and the sea.

    An order ends when the tank is full or empty.
    """
    s = state[0]
    order = s.to_move[pump]
    most = sound_rate(ballast, pump, state) * h
    amount = min(max(order, -most * delivery(ballast, s.z)), most)
    admit(ballast, tank, amount, state)
    s.to_move[pump] = order - amount
    full = order > 0.0 and s.water[tank] >= ballast[0].capacity[tank]
    if full or (order < 0.0 and s.water[tank] <= 0.0):
        s.to_move[pump] = 0.0


@inline_kernel
def possible_forward(ballast: Record, amount: float, state: Record) -> float:
    """Return how much of ``amount`` [kg] of trim water can move forward, aft if negative."""
    b = ballast[0]
    s = state[0]
    forward, aft = s.water[TRIM_FORWARD], s.water[TRIM_AFT]
    possible = min(amount, aft, b.capacity[TRIM_FORWARD] - forward)
    return max(possible, -forward, aft - b.capacity[TRIM_AFT])


@inline_kernel
def move_forward(ballast: Record, amount: float, state: Record) -> None:
    """Move ``amount`` [kg] of trim water forward, aft if negative."""
    b = ballast[0]
    s = state[0]
    forward, aft = s.water[TRIM_FORWARD] + amount, s.water[TRIM_AFT] - amount
    s.water[TRIM_FORWARD] = min(max(forward, 0.0), b.capacity[TRIM_FORWARD])
    s.water[TRIM_AFT] = min(max(aft, 0.0), b.capacity[TRIM_AFT])


@inline_kernel
def transfer_trim(ballast: Record, h: float, state: Record) -> None:
    """Move trim water forward, or aft if negative.

    The amount is the ordered one, or without an order that of automatic trim.
    """
    s = state[0]
    order = s.to_move[TRIM_PUMP]
    most = sound_rate(ballast, TRIM_PUMP, state) * h
    amount = min(max(order if order != 0.0 else s.trim_forward, -most), most)
    possible = possible_forward(ballast, amount, state)
    move_forward(ballast, possible, state)
    if order != 0.0:
        s.to_move[TRIM_PUMP] = order - amount if possible == amount else 0.0


@inline_kernel
def flood_auxiliary(ballast: Record, h: float, state: Record) -> None:
    """Flood the auxiliary tank by the amount that automatic trim wants.

    Pump it out if the amount is negative.
    """
    s = state[0]
    most = sound_rate(ballast, DRAIN_PUMP, state) * h
    amount = min(max(s.trim_flood, -most * delivery(ballast, s.z)), most)
    admit(ballast, AUXILIARY_TANK, amount, state)


@inline_kernel
def drain(ballast: Record, h: float, state: Record) -> None:
    """Pump out the compartment ordered."""
    s = state[0]
    tank = FIRST_DRY - 1 + int(s.drained)
    if FIRST_DRY <= tank < TANKS_END:
        most = sound_rate(ballast, DRAIN_PUMP, state) * h
        admit(ballast, tank, -most * delivery(ballast, s.z), state)


@inline_kernel
def work_pumps(vessel: Record, h: float, state: Record) -> None:
    """Advance all pumped tanks by ``h`` [s].

    One pump serves the auxiliary tank and the compartments, the compartments first. Automatic trim
    has the pumps that nobody has given an order. While hovering is off, its integral follows the
    tank, so that it starts without a bump.
    """
    s = state[0]
    if is_hovering(state):
        hover(vessel, h, state)
    else:
        s.hover_integral = s.water[DEPTH_CONTROL]
        s.hover_time = s.hover_full = 0.0
    if s.to_move[TRIM_PUMP] != 0.0 or s.trim_forward != 0.0:
        transfer_trim(vessel, h, state)
    if s.drained > 0.0:
        drain(vessel, h, state)
    elif s.to_move[DRAIN_PUMP] != 0.0:
        pump_tank(vessel, DRAIN_PUMP, AUXILIARY_TANK, h, state)
    elif s.trim_flood != 0.0:
        flood_auxiliary(vessel, h, state)
    if s.to_move[DEPTH_CONTROL_PUMP] != 0.0:
        pump_tank(vessel, DEPTH_CONTROL_PUMP, DEPTH_CONTROL, h, state)

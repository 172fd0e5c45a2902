"""Oil: accumulators, pumps and leaks, and what rate a surface has of it.

The gas of an accumulator is isothermal. A surface in normal is fed by the main system, in emergency
by the vital one, and moved without oil in hand.
"""

import math

from trainer.core.kernel import Record, inline_kernel
from trainer.core.plant.parts import (
    FIRST_LEG,
    HAND,
    HEADER,
    MAIN,
    MAIN_PUMP_COUNT,
    MAIN_VALVE,
    NORMAL,
    RUNNING,
    STANDING_BY,
    VITAL,
    VITAL_VALVE,
    is_dead,
)


@inline_kernel
def oil_held(vessel: Record, system: int, state: Record) -> float:
    """Return the oil [m3] in the accumulator of a system."""
    return vessel[0].oil_usable[system] - state[0].oil_spent[system]


@inline_kernel
def oil_pressure(vessel: Record, system: int, state: Record) -> float:
    """Return the pressure [Pa] of a system, by Boyle's law; 0 without oil."""
    c = vessel[0]
    if oil_held(vessel, system, state) <= 0.0:
        return 0.0
    full, low = c.oil_full[system], c.oil_low[system]
    gas = low * c.oil_usable[system] / (full - low)  # [m3] when the accumulator is full
    return full * gas / (gas + state[0].oil_spent[system])


@inline_kernel
def rate_share(vessel: Record, pressure: float) -> float:
    """Return the share [-] of a rate at a pressure [Pa], as an orifice flows."""
    c = vessel[0]
    if pressure >= c.oil_rated:
        return 1.0
    if pressure <= c.oil_dead:
        return 0.0
    return math.sqrt((pressure - c.oil_dead) / (c.oil_rated - c.oil_dead))


@inline_kernel
def system_of(mode: float) -> int:
    """Return the system that feeds a surface in normal or emergency."""
    return MAIN if mode == NORMAL else VITAL


@inline_kernel
def fed_share(vessel: Record, surface: int, state: Record) -> float:
    """Return the share [-] of its rate that a surface has, 0 where unfed."""
    c = vessel[0]
    s = state[0]
    if s.mode[surface] == HAND:
        return c.hand_rate / c.surface_rate
    system = system_of(s.mode[surface])
    if system == MAIN:
        shut = s.isolated[MAIN_VALVE] > 0.0 or s.isolated[surface] > 0.0
    else:
        shut = s.isolated[VITAL_VALVE] > 0.0
    share = 0.0 if shut else rate_share(vessel, oil_pressure(vessel, system, state))
    return share * c.emergency_share if system == VITAL else share


@inline_kernel
def run_pump(vessel: Record, pump: int, h: float, state: Record) -> None:
    """Advance a pump, which runs from its starting pressure until its accumulator is full."""
    c = vessel[0]
    s = state[0]
    system = MAIN if pump < MAIN_PUMP_COUNT else VITAL
    if s.hydraulic_pump[pump] == STANDING_BY:
        if oil_pressure(vessel, system, state) < c.oil_start[pump]:
            s.hydraulic_pump[pump] = RUNNING
    elif s.hydraulic_pump[pump] == RUNNING and s.oil_spent[system] <= 0.0:
        s.hydraulic_pump[pump] = STANDING_BY
    if s.hydraulic_pump[pump] == RUNNING and not is_dead(pump, state):
        lost = min(max(s.plant_fault[system], 0.0), 1.0)
        left = c.oil_reserve[system] + s.tank_gain[system]
        given = min(c.oil_rate[pump] * (1.0 - lost) * h, left, s.oil_spent[system])
        s.oil_spent[system] -= given
        s.tank_gain[system] -= given


@inline_kernel
def leak_oil(vessel: Record, h: float, state: Record) -> None:
    """Let main oil out that leaks from the header and from open legs."""
    s = state[0]
    if s.isolated[MAIN_VALVE] > 0.0:
        return
    leak = s.plant_fault[HEADER]
    for i in range(3):
        if s.isolated[i] == 0.0:
            leak += s.plant_fault[FIRST_LEG + i]
    if leak > 0.0:
        pressure = oil_pressure(vessel, MAIN, state)
        flow = leak * math.sqrt(pressure / vessel[0].oil_full[MAIN])
        s.oil_spent[MAIN] += min(h * flow, oil_held(vessel, MAIN, state))


@inline_kernel
def shift_modes(vessel: Record, h: float, state: Record) -> None:
    """Advance the surfaces that are being shifted to another mode.

    A surface that was automatic is taken in hand as it stands, when its shift begins.
    """
    c = vessel[0]
    s = state[0]
    for i in range(3):
        if s.mode_ticks[i] < 0.0:  # ordered since the last tick
            s.mode_ticks[i] = math.ceil(c.shift_time[int(s.mode_ordered[i])] / h - 1e-9)
            if s.mode_ordered[i] != NORMAL and s.by_hand[i] == 0.0:
                s.by_hand[i] = 1.0
                s.ordered[i] = s.surface[i]
        if s.mode_ticks[i] > 0.0:
            s.mode_ticks[i] -= 1.0
            if s.mode_ticks[i] == 0.0:
                s.mode[i] = s.mode_ordered[i]


@inline_kernel
def advance_oil(vessel: Record, h: float, state: Record) -> None:
    """Advance pumps, leaks and modes by ``h`` [s]."""
    for pump in range(3):
        run_pump(vessel, pump, h, state)
    leak_oil(vessel, h, state)
    shift_modes(vessel, h, state)


@inline_kernel
def draw_oil(vessel: Record, swept_r: float, swept_s: float, swept_b: float, state: Record) -> None:
    """Move the oil of what surfaces have swept [rad] into its tank.

    An X-tail's four planes are one machine: the larger of its two movements draws.
    """
    c = vessel[0]
    s = state[0]
    if c.x_tail != 0.0:
        swept_s = max(swept_r, swept_s)
        swept_r = 0.0
    for i in range(3):
        swept = swept_r if i == 0 else (swept_s if i == 1 else swept_b)
        if s.mode[i] == HAND or fed_share(vessel, i, state) == 0.0:
            continue
        system = system_of(s.mode[i])
        drawn = min(c.oil_angle[i] * swept, oil_held(vessel, system, state))
        s.oil_spent[system] += drawn
        s.tank_gain[system] += drawn

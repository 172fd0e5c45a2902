"""Compressed air: banks, blow valves, vents, and the tanks whose water it drives out.

Gas law: the air is isothermal at sea temperature, in the banks and in the tanks. A real bank that
empties within a minute cools. So this gives a fast blow some 15 % more pressure at its end than an
adiabatic bank has, and the same once the heat is back.

A tank is a box with the flood port at its foot and the vent at its top, both at the pressure of the
sea. Its air moves towards the volume at which it balances the water outside; the ports limit how
fast. ``ballast`` works the blown tanks by it in each tick in which any of them can change.
"""

import math
from typing import Final

from trainer.core.ballast.tanks import (
    ATMOSPHERIC_PRESSURE,
    EMERGENCY_BANK,
    MAIN_BANK,
    NEGATIVE_TANK,
    admit,
    sea_pressure,
    through_hole,
)
from trainer.core.kernel import Record, inline_kernel, kernel

MIN_TANK_PRESSURE: Final = (
    0.5 * ATMOSPHERIC_PRESSURE
)  # [Pa] in a tank high out of the water, whose ports draw air
CRITICAL_RATIO: Final = 0.528  # [-] pressure ratio above which the flow of air is not choked


@inline_kernel
def sonic_share(ratio: float) -> float:
    """Return the mass flow [-] as a share of the choked flow.

    ``ratio`` [-] is the pressure behind over the pressure before. The law is ISO 6358's quarter
    ellipse, within 2 % of St. Venant's equation and free of powers.
    """
    if ratio <= CRITICAL_RATIO:
        return 1.0
    if ratio >= 1.0:
        return 0.0
    beyond = (ratio - CRITICAL_RATIO) / (1.0 - CRITICAL_RATIO)
    return math.sqrt(1.0 - beyond * beyond)


@inline_kernel
def bank_flow(ballast: Record, bank: int, area: float, pressure: float, state: Record) -> float:
    """Return the air flow [kg/s] from a bank through ``area`` [m2] against ``pressure`` [Pa]."""
    b = ballast[0]
    held = state[0].bank[bank]
    if held <= 0.0 or area <= 0.0:
        return 0.0
    own = held * b.gas / b.bank_volume[bank]
    flow = b.choked * area * own * sonic_share(pressure / own)
    return flow * (1.0 - min(max(state[0].bank_fault[bank], 0.0), 1.0))


@inline_kernel
def pass_air(
    ballast: Record, bank: int, tank: int, flow: float, pressure: float, state: Record
) -> None:
    """Move ``flow`` [kg] of air from a bank to a tank.

    It stops where the bank's pressure is equal to ``pressure`` [Pa].
    """
    b = ballast[0]
    s = state[0]
    spare = s.bank[bank] - pressure * b.bank_volume[bank] / b.gas
    before = s.bank[bank]
    s.bank[bank] = max(before - max(min(flow, spare), 0.0), 0.0)
    s.tank_air[tank] += before - s.bank[bank]


@inline_kernel
def blow(ballast: Record, tank: int, pressure: float, h: float, state: Record) -> None:
    """Blow a tank against ``pressure`` [Pa] for ``h`` [s], as its valves stand.

    The main bank serves the blow valves. The emergency bank serves the emergency valves, which are
    open as far as the order exceeds 1.
    """
    b = ballast[0]
    order = state[0].blow[tank]
    sound = 1.0 - min(max(state[0].blow_fault[tank], 0.0), 1.0)
    area = b.blow_area[tank] * min(order, 1.0) * sound
    flow = bank_flow(ballast, MAIN_BANK, area, pressure, state)
    pass_air(ballast, MAIN_BANK, tank, flow * h, pressure, state)
    if order > 1.0:
        area = b.emergency_area[tank] * min(order - 1.0, 1.0) * sound
        flow = bank_flow(ballast, EMERGENCY_BANK, area, pressure, state)
        pass_air(ballast, EMERGENCY_BANK, tank, flow * h, pressure, state)


@inline_kernel
def vent_opening(tank: int, state: Record) -> float:
    """Return how far [-] a vent is open.

    It is open as ordered, less what its fault takes, or it is stuck open.
    """
    fault = state[0].vent_fault[tank]
    if fault < 0.0:
        return min(-fault, 1.0)
    return min(state[0].vent[tank], 1.0) * (1.0 - min(fault, 1.0))


@inline_kernel
def vent(vessel: Record, tank: int, top: float, h: float, state: Record) -> None:
    """Pass air out of a tank whose vent is at depth ``top`` [m].

    Where the vent is in the air, air may come in. The head between the water inside and the sea at
    the vent drives the flow. It is that of an incompressible fluid through an orifice, since the
    head is a small part of the pressure.
    """
    c = vessel[0]
    s = state[0]
    area = c.vent_area[tank] * vent_opening(tank, state)
    volume, space = (c.capacity[tank] - s.water[tank]) / c.rho, c.capacity[tank] / c.rho
    head = min(top, 0.0) + c.height[tank] * volume / space  # [m] negative only in the open air
    pressure = ATMOSPHERIC_PRESSURE + c.rho * c.g * (head + max(top, 0.0))
    density = max(pressure, MIN_TANK_PRESSURE) / c.gas
    flow = through_hole(density, area, c.rho * c.g * abs(head)) * h
    passed = min(flow, abs(head) / c.height[tank] * space * density)
    passed = min(passed, s.tank_air[tank]) if head > 0.0 else -passed
    if volume <= 0.0 <= top:  # the last bubbles, too small to show in the water's mass
        passed = s.tank_air[tank]
    s.tank_air[tank] -= passed
    s.air_taken -= passed


@inline_kernel
def settle(vessel: Record, tank: int, top: float, h: float, state: Record) -> None:
    """Move the water in a tank towards its balance with the sea.

    It follows the tank's air, through the open ports. The air's volume V in balance: air gas/V =
    p_top + rho g height V/volume. Air for which a tank empty of water has no room bubbles out
    through the ports.
    """
    c = vessel[0]
    s = state[0]
    space = c.capacity[tank] / c.rho
    volume = (c.capacity[tank] - s.water[tank]) / c.rho
    p_top = max(ATMOSPHERIC_PRESSURE + c.rho * c.g * top, MIN_TANK_PRESSURE)
    slope = c.rho * c.g * c.height[tank] / space
    content = s.tank_air[tank] * c.gas
    balance = 2.0 * content / (p_top + math.sqrt(p_top * p_top + 4.0 * slope * content))
    inward = c.capacity[tank] - c.rho * balance - s.water[tank]  # [kg]
    if volume > 0.0:
        excess = abs(content / volume - p_top - slope * volume)
        reach = through_hole(c.rho, c.port[tank], excess) * h
        inward = min(max(inward, -reach), reach)
    admit(vessel, tank, inward, state)
    if s.water[tank] == 0.0:
        surplus = s.tank_air[tank] - (p_top + slope * space) * space / c.gas
        if surplus > 0.0:
            s.tank_air[tank] -= surplus
            s.air_taken -= surplus


@inline_kernel
def at_work(ballast: Record, tank: int, state: Record) -> bool:
    """Return whether anything can happen in a blown tank.

    Nothing does in a tank that is full and shut. Main ballast ports stand open. The flood valve of
    the negative tank seals it, and its other valves work only while the flood valve is open.
    """
    b = ballast[0]
    s = state[0]
    if tank == NEGATIVE_TANK and s.negative_flood <= 0.0:
        return False
    if s.tank_air[tank] > 0.0 or s.water[tank] < b.capacity[tank]:
        return True
    if s.blow[tank] == 0.0 and s.vent[tank] == 0.0 and s.vent_fault[tank] == 0.0:
        return False
    opened = s.blow[tank] > 0.0 or vent_opening(tank, state) > 0.0
    return opened and b.capacity[tank] > 0.0


@inline_kernel
def work_blown_tank(vessel: Record, tank: int, depth: float, h: float, state: Record) -> None:
    """Advance a tank with open flood ports by ``h`` [s].

    Its centre is at ``depth`` [m].
    """
    c = vessel[0]
    s = state[0]
    top = depth - 0.5 * c.height[tank]
    if s.blow[tank] > 0.0:
        level = top + c.height[tank] * (1.0 - s.water[tank] / c.capacity[tank])
        blow(vessel, tank, sea_pressure(c.rho * c.g, level), h, state)
    if vent_opening(tank, state) > 0.0:
        vent(vessel, tank, top, h, state)
    settle(vessel, tank, top, h, state)


@kernel
def fill_with_air(vessel: Record, tank: int, depth: float, state: Record) -> None:
    """Give a blown tank the air that balances its water.

    Its centre is at ``depth`` [m]. The negative tank is sealed and starts at atmospheric pressure.
    """
    c = vessel[0]
    s = state[0]
    if c.capacity[tank] <= 0.0:
        return
    empty = 1.0 - s.water[tank] / c.capacity[tank]
    level = depth + c.height[tank] * (empty - 0.5)
    pressure = (
        ATMOSPHERIC_PRESSURE
        if tank == NEGATIVE_TANK
        else ATMOSPHERIC_PRESSURE + c.rho * c.g * level
    )
    s.tank_air[tank] = pressure * empty * c.capacity[tank] / (c.rho * c.gas)


@inline_kernel
def compress(ballast: Record, h: float, state: Record) -> None:
    """Charge the banks for ``h`` [s], the first that is not full before the other.

    The air comes from above: what the hull holds at the pressure of its crew fills no bank.
    """
    b = ballast[0]
    s = state[0]
    if s.z > b.intake_depth:
        return
    left = b.compressor_rate * h
    for i in range(2):
        before = s.bank[i]
        s.bank[i] = min(before + left, max(b.bank_full[i], before))
        s.air_taken += s.bank[i] - before
        left -= s.bank[i] - before

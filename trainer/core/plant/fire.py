"""Fire and smoke in the compartments, and what fighting and ventilation do to them.

A fire grows as a logistic curve: it doubles while there is air and fuel, and ends at the whole
compartment. Times and shares are estimates of the vessel file.
"""

import math

from trainer.core.kernel import Record, inline_kernel
from trainer.core.plant.parts import (
    AFT,
    CONTROL,
    EXHAUSTING,
    FIRST_FIRE,
    FORWARD,
    RUN_VENTILATION,
    SECURED,
)


@inline_kernel
def kindle(vessel: Record, place: int, state: Record) -> None:
    """Begin a fire as its fault grows.

    As the fault is cleared, the fire goes with all that it burnt.
    """
    s = state[0]
    fault, lit = s.plant_fault[FIRST_FIRE + place], s.kindled[place]
    if fault > lit:
        s.fire[place] = min(s.fire[place] + vessel[0].fire_start * (fault - lit), 1.0)
    elif fault < lit:
        s.fire[place] *= fault / lit
        if fault == 0.0:
            s.burnt[place] = 0.0
    s.kindled[place] = fault


@inline_kernel
def fighting_share(vessel: Record, place: int, state: Record) -> float:
    """Return how well [-] a fire is fought, 0 where it is not.

    It is whole with ventilation secured and the compartment's bus dead.
    """
    s = state[0]
    if s.fighting != place + 1.0 or s.fight_ticks != 0.0:
        return 0.0
    bus = int(vessel[0].place_bus[place])
    measures = 0
    if s.ventilation == SECURED:
        measures += 1
    if bus < 0 or s.bus_dead[bus] > 0.0:
        measures += 1
    return 0.25 * (1 << measures)


@inline_kernel
def burn(vessel: Record, place: int, h: float, state: Record) -> None:
    """Advance the fire of a compartment, and the dose of what stands there."""
    c = vessel[0]
    s = state[0]
    fire = s.fire[place]
    if fire == 0.0:
        return
    fought = fighting_share(vessel, place, state)
    fire += h * (fire * (1.0 - fire) / c.fire_growth - fought * fire / c.fire_fight)
    if fought > 0.0 and fire < c.fire_out:
        fire = 0.0
    s.fire[place] = fire
    s.burnt[place] += h * fire


@inline_kernel
def spread_smoke(vessel: Record, h: float, state: Record) -> None:
    """Advance the smoke: made by fire, mixed by ventilation, cleared where it is exhausted.

    It can be exhausted where the boat has air from above.
    """
    c = vessel[0]
    s = state[0]
    first, middle, last = s.smoke[FORWARD], s.smoke[CONTROL], s.smoke[AFT]
    for i in range(3):
        change = s.fire[i] * (1.0 - s.smoke[i]) / c.smoke_time
        if s.ventilation == RUN_VENTILATION:
            mean = (first + middle + last) / 3.0
            if i == FORWARD:
                mean = 0.5 * (first + middle)
            elif i == AFT:
                mean = 0.5 * (middle + last)
            change += (mean - s.smoke[i]) / c.smoke_spread
        elif s.ventilation == EXHAUSTING and s.z <= c.intake_depth:
            change -= s.smoke[i] / c.smoke_clear
        s.smoke[i] = min(max(s.smoke[i] + h * change, 0.0), 1.0)


@inline_kernel
def advance_fire(vessel: Record, h: float, state: Record) -> None:
    """Advance fires, the party that fights one, and smoke by ``h`` [s]."""
    s = state[0]
    if s.fight_ticks < 0.0:  # ordered since the last tick
        s.fight_ticks = math.ceil(vessel[0].fire_party / h - 1e-9)
    elif s.fight_ticks > 0.0:
        s.fight_ticks -= 1.0
    for place in range(3):
        kindle(vessel, place, state)
        burn(vessel, place, h, state)
    spread_smoke(vessel, h, state)

"""The plant of one boat in a tick.

Until then it is well, all its numbers in the state are 0, and nothing of it is computed, copied or
saved but what is drained of the battery. So a boat whose plant is well moves as one without.
``actuators``, ``propulsion``, ``autopilot``, ``ballast/pumps`` and ``casualties`` ask what is fed.
"""

import math
from typing import Final

from trainer.core.casualties import GYRO, reading
from trainer.core.kernel import Record, inline_kernel, kernel
from trainer.core.plant.fire import advance_fire
from trainer.core.plant.oil import advance_oil
from trainer.core.plant.parts import FED_GYRO, is_dead
from trainer.core.plant.power import cut_off_consumers, drain_battery, feed_buses, lose_cells

CALM_TICKS: Final = 20.0  # between two looks at the battery of a plant that is well


@inline_kernel
def stop_gauges(state: Record) -> None:
    """Keep what gyro, log and sounder read for as long as they have no power."""
    s = state[0]
    for i in range(3):
        if not is_dead(FED_GYRO + i, state):
            s.gauge_held[i] = reading(GYRO + i, state)


@kernel
def work_plant(vessel: Record, h: float, state: Record) -> None:
    """Advance a plant of which something has been touched by ``h`` [s]."""
    lose_cells(vessel, state)
    feed_buses(vessel, h, state)
    cut_off_consumers(vessel, h, state)
    stop_gauges(state)
    drain_battery(vessel, h, state)
    advance_oil(vessel, h, state)
    advance_fire(vessel, h, state)


@inline_kernel
def advance_plant(vessel: Record, h: float, state: Record) -> None:
    """Advance the plant by ``h`` [s].

    Of one that is well it is the battery alone, now and then.
    """
    s = state[0]
    if s.plant_touched != 0.0:
        work_plant(vessel, h, state)
    elif s.tick == CALM_TICKS * math.floor(s.tick * (1.0 / CALM_TICKS)):
        drain_battery(vessel, CALM_TICKS * h, state)

"""The ground under the boat: a chart that each tick sounds, and what an exercise says of it."""

from typing import Any, Final

import numpy as np

from trainer.config.bottom import Bottom
from trainer.config.world import WorldTables
from trainer.core.kernel import Numbers
from trainer.core.soundings import FIRST, sound
from trainer.io.orders.grammar import Order, Refused, Reply

LONGEST: Final = 1.0  # [s] step, with which the ground's spring is held


def chart_of(bottom: Bottom) -> Numbers:
    """Return the ground as ``core.soundings`` reads it."""
    grid = bottom.depth
    ends = float(bottom.known is not None)
    head = (grid.south, grid.west, *(1.0 / each for each in grid.cell), ends, *grid.values.shape)
    return np.concatenate((np.array(head, np.float64), grid.values.ravel()))


def is_level(chart: Numbers) -> bool:
    """Return whether a chart is the same everywhere, so that it need be sounded but once."""
    return bool(np.all(chart[FIRST:] == chart[FIRST]))


class Ground:
    """The ground of an exercise. Its numbers are written by the tick itself, in machine code."""

    acts = False

    def __init__(self, boat: Any, bottom: Bottom | None) -> None:
        """Put the ground under a boat, None for none."""
        self.bottom = bottom
        boat.records.scheme["friction"] = bottom.friction if bottom else 0.0
        boat.records.scheme["breakout"] = bottom.breakout * boat.vessel.g if bottom else 0.0
        if bottom is None:
            boat.sound_by(None)
            return
        chart = chart_of(bottom)
        sound(boat.records.vessel, chart, boat.records.state)
        boat.sound_by(None if is_level(chart) else chart)

    def obey(self, order: Order, _tick: int) -> Reply:
        """Refuse an order: nobody orders the ground."""
        return Refused(f"nobody orders the {order.name}")

    def forget(self) -> None:
        """Be as the exercise has it, as it always is."""

    def write(self, _state: Any) -> None:
        """Write nothing: the tick does."""


def ground_of(boat: Any, tables: WorldTables) -> Ground:
    """Return the ground of an exercise under a boat."""
    return Ground(boat, tables.get("bottom"))


def ground_under(boat: Any) -> Bottom | None:
    """Return the ground of the exercise that a boat is in, None without one."""
    part = boat.world.parts.get("bottom")
    return part.bottom if isinstance(part, Ground) else None

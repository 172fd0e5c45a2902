"""The ground of an exercise under the boat: a chart that each tick sounds.

``world`` puts it round the boat. ``Boat`` gets the chart once and has it sounded before each tick,
in machine code as soon as that is ready, because compiled ticks cannot call Python. ``limits``,
``grounding`` and the stations ask here how far the keel is above the ground.
"""

import math
from collections.abc import Callable, Sequence
from typing import Any, Final

import numpy as np

from trainer.config.files import ConfigError
from trainer.config.world.bottom import START_RADIUS_M, Bottom, is_charted, land_near
from trainer.config.world.world import WorldTables
from trainer.core.bottom import SOUNDING_STATIONS as STATIONS
from trainer.core.kernel import Numbers
from trainer.core.soundings import FIRST_SAMPLE, sound
from trainer.core.state import STATE
from trainer.io.orders.grammar import Order, Refused, Reply

MAX_GROUND_STEP_S: Final = 1.0  # [s] step, with which the ground's spring is held
START_ROOM_M: Final = 5.0  # [m] under the keel, with which a boat may start
STATE_OFFSETS: Final = {name: int(field[1]) // 8 for name, field in (STATE.fields or {}).items()}
BOTTOM_OFFSET, THETA, PHI, Z = (STATE_OFFSETS[name] for name in ("bottom", "theta", "phi", "z"))
TICK_OFFSET: Final = STATE_OFFSETS["tick"]


def keel_of(vessel: Any) -> float:
    """Return how far [m] the keel is below the origin."""
    return float(0.5 * vessel.hull_diameter + vessel.hull_axis)


def height_of_keel(numbers: Sequence[float], length: float, keel: float) -> float:
    """Return the least height [m] of a keel over the ground; infinite without a ground.

    ``numbers`` are a state's; ``length`` [m] is the boat's, ``keel`` [m] how far it is below.
    """
    if numbers[BOTTOM_OFFSET] == 0.0:
        return math.inf
    lean = length * math.sin(numbers[THETA])
    least = min(numbers[BOTTOM_OFFSET + i] + x * lean for i, x in enumerate(STATIONS))
    return least - numbers[Z] - keel * math.cos(numbers[THETA]) * math.cos(numbers[PHI])


def heights_of_keel(
    grounds: Sequence[Numbers], column: Callable[[str], Numbers], length: float, keel: float
) -> Numbers:
    """Return the same in many states, but for the last bits.

    ``grounds`` has the depths [m] under each station, ``column`` numbers of the states by name.
    """
    sine, upright = np.sin(column("theta")), np.cos(column("theta")) * np.cos(column("phi"))
    depths = [ground + x * length * sine for ground, x in zip(grounds, STATIONS, strict=True)]
    least: Numbers = np.min(depths, axis=0) - column("z") - keel * upright
    return np.where(grounds[0] == 0.0, math.inf, least)


def chart_of(bottom: Bottom) -> Numbers:
    """Return the ground as ``core.soundings`` reads it."""
    grid = bottom.depth
    ends = float(bottom.known is not None)
    head = (grid.south, grid.west, *(1.0 / each for each in grid.cell), ends, *grid.values.shape)
    return np.concatenate((np.array(head, np.float64), grid.values.ravel()))


def is_level(chart: Numbers) -> bool:
    """Return whether a chart is level, so that it need be sounded but once."""
    return bool(np.all(chart[FIRST_SAMPLE:] == chart[FIRST_SAMPLE]))


def refuse_start(boat: Any, bottom: Bottom) -> None:
    """Raise ConfigError with all that a run cannot begin with over this ground."""
    north, east = float(boat.state.x), float(boat.state.y)
    room = height_of_keel(boat.plain, float(boat.vessel.ell), keel_of(boat.vessel))
    land = land_near(bottom, north, east)
    step = boat.method.step
    coarse = f"[bottom] with a step of {step:g} s: {MAX_GROUND_STEP_S:g} s at most"
    empty = f"{land:.0f} m from the start: {START_RADIUS_M:g} m at least"
    low = f"{room:.1f} m under the keel: {START_ROOM_M:g} m at least"
    problems = {
        coarse: step > MAX_GROUND_STEP_S,
        "[bottom] grid: the boat starts off it": not is_charted(bottom, north, east),
        f"[bottom] grid: has no value {empty}": land < math.inf,
        f"[bottom]: the boat starts with {low}": room < START_ROOM_M,
    }
    if any(problems.values()):
        raise ConfigError(*(told for told, is_so in problems.items() if is_so))


class Ground:
    """The ground of an exercise. It never acts, because ``Boat`` sounds it before each tick."""

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
        """Do nothing: no order changes the ground."""

    def stands(self, _tick: int) -> bool:
        """Return yes: the ground stays, and the core sounds it by its chart."""
        return True

    def write(self, _numbers: Any) -> None:
        """Write nothing: ``Boat`` sounds the chart instead."""


def ground_of(boat: Any, tables: WorldTables) -> Ground:
    """Return the ground of an exercise under a boat; ConfigError where it cannot start there."""
    part = Ground(boat, tables.get("bottom"))
    if part.bottom is not None:
        refuse_start(boat, part.bottom)
    return part


def ground_under(boat: Any) -> Bottom | None:
    """Return the ground of the exercise that a boat is in, None without one."""
    part = boat.world.parts.get("bottom")
    return part.bottom if isinstance(part, Ground) else None

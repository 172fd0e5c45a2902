"""Conditions on the state are read from text. Examples are ``depth > 100`` and ``speed_kn < 4``."""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final

from trainer.core.ballast.tanks import BANKS, BLOWN, COMPARTMENTS, PUMPED

# Units of a quantity [SI], its own first.
LENGTH: Final = {"m": 1.0, "ft": 0.3048}
RATE: Final = {"m_s": 1.0}
SPEED: Final = {"kn": 1852.0 / 3600.0, "m_s": 1.0}
ANGLE: Final = {"deg": math.radians(1.0)}
TURN: Final = {"deg_s": math.radians(1.0)}
MASS: Final = {"t": 1000.0, "kg": 1.0}
PRESSURE: Final = {"mpa": 1e6, "bar": 1e5}
TIME: Final = {"s": 1.0, "min": 60.0}
TURNS: Final = {"rpm": 1.0 / 60.0}


@dataclass(frozen=True)
class Quantity:
    """A quantity of conditions: its place in the state, its units, and its meaning."""

    place: str
    units: Mapping[str, float]
    meaning: str


QUANTITIES: Final[Mapping[str, Quantity]] = {
    "time": Quantity("tick", TIME, "since the start of the run"),
    "depth": Quantity("z", LENGTH, "of the boat's origin"),
    "depth_rate": Quantity("zdot", RATE, "positive going down"),
    "north": Quantity("x", LENGTH, "of the start"),
    "east": Quantity("y", LENGTH, "of the start"),
    "speed": Quantity("u", SPEED, "ahead through the water"),
    "pitch": Quantity("theta", ANGLE, "positive bow up"),
    "heel": Quantity("phi", ANGLE, "positive to starboard"),
    "turn_rate": Quantity("r", TURN, "positive to starboard"),
    "rudder": Quantity("delta_r", ANGLE, "positive right"),
    "stern": Quantity("delta_s", ANGLE, "stern planes, positive rise"),
    "bow": Quantity("delta_b", ANGLE, "bow planes, positive rise"),
    "turns": Quantity("u_c", TURNS, "propeller revolutions"),
    "wave": Quantity("eta_wave", LENGTH, "surface elevation above the boat"),
    **{
        f"water_{name}": Quantity(f"water_{name}", MASS, "water in that tank")
        for name in (*BLOWN, *PUMPED)
    },
    **{
        name.replace("compartment", "flood"): Quantity(
            name.replace("compartment", "flood"), MASS, "water in that compartment"
        )
        for name in COMPARTMENTS
    },
    **{
        f"bank_{name}": Quantity(f"bank_{name}", PRESSURE, "absolute pressure in that air bank")
        for name in BANKS
    },
}

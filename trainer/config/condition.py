"""The quantities of the state that a condition may name, and their units.

Triggers, marks and crew rules have conditions such as ``depth > 100`` and ``speed_kn < 4``.
``derived`` reads them, and adds quantities that are made from several of these.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final

from trainer.core.ballast.tanks import BANKS, BLOWN_TANKS, COMPARTMENTS, PUMPED_TANKS

# Units of a quantity [SI], its own first.
LENGTH_UNITS: Final = {"m": 1.0, "ft": 0.3048}
DEPTH_RATE_UNITS: Final = {"m_s": 1.0}
SPEED_UNITS: Final = {"kn": 1852.0 / 3600.0, "m_s": 1.0}
ANGLE_UNITS: Final = {"deg": math.radians(1.0)}
TURN_RATE_UNITS: Final = {"deg_s": math.radians(1.0)}
MASS_UNITS: Final = {"t": 1000.0, "kg": 1.0}
PRESSURE_UNITS: Final = {"mpa": 1e6, "bar": 1e5}
TIME_UNITS: Final = {"s": 1.0, "min": 60.0}
REVOLUTION_UNITS: Final = {"rpm": 1.0 / 60.0}


@dataclass(frozen=True)
class Quantity:
    """A quantity of conditions: its field of the state, its units, and its meaning."""

    field: str
    units: Mapping[str, float]
    meaning: str


STATE_QUANTITIES: Final[Mapping[str, Quantity]] = {
    "time": Quantity("tick", TIME_UNITS, "since the start of the run"),
    "depth": Quantity("z", LENGTH_UNITS, "of the boat's origin"),
    "depth_rate": Quantity("zdot", DEPTH_RATE_UNITS, "positive going down"),
    "north": Quantity("x", LENGTH_UNITS, "of the start"),
    "east": Quantity("y", LENGTH_UNITS, "of the start"),
    "speed": Quantity("u", SPEED_UNITS, "ahead through the water"),
    "pitch": Quantity("theta", ANGLE_UNITS, "positive bow up"),
    "heel": Quantity("phi", ANGLE_UNITS, "positive to starboard"),
    "turn_rate": Quantity("r", TURN_RATE_UNITS, "positive to starboard"),
    "rudder": Quantity("delta_r", ANGLE_UNITS, "positive right"),
    "stern": Quantity("delta_s", ANGLE_UNITS, "stern planes, positive rise"),
    "bow": Quantity("delta_b", ANGLE_UNITS, "bow planes, positive rise"),
    "turns": Quantity("u_c", REVOLUTION_UNITS, "propeller revolutions"),
    "wave": Quantity("eta_wave", LENGTH_UNITS, "surface elevation above the boat"),
    **{
        f"water_{name}": Quantity(f"water_{name}", MASS_UNITS, "water in that tank")
        for name in (*BLOWN_TANKS, *PUMPED_TANKS)
    },
    **{
        name.replace("compartment", "flood"): Quantity(
            name.replace("compartment", "flood"), MASS_UNITS, "water in that compartment"
        )
        for name in COMPARTMENTS
    },
    **{
        f"bank_{name}": Quantity(
            f"bank_{name}", PRESSURE_UNITS, "absolute pressure in that air bank"
        )
        for name in BANKS
    },
}

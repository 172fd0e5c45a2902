"""The quantities of the state that a condition may name, and their units.

Triggers, marks and crew rules have conditions such as ``depth > 100`` and ``speed_kn < 4``.
``derived`` reads them, and adds quantities that are made from several of these.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final

from trainer.core.ballast.tanks import BANKS, BLOWN_TANKS, COMPARTMENTS, PUMPED_TANKS
from trainer.core.plant.parts import BUS_NAMES, OIL_SYSTEMS, PLACE_NAMES
from trainer.core.surfaces import SURFACES

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
OIL_UNITS: Final = {"l": 1e-3}
SHARE_UNITS: Final = {"percent": 0.01}
CODE_UNITS: Final = {"code": 1.0}


@dataclass(frozen=True)
class Quantity:
    """A quantity of conditions: its field of the state, its units, and its meaning."""

    field: str
    units: Mapping[str, float]
    meaning: str


PLANT_QUANTITIES: Final[Mapping[str, Quantity]] = {  # which a boat without a plant has not
    **{
        f"oil_out_{name}": Quantity(
            f"oil_spent_{name}", OIL_UNITS, "oil out of that accumulator, as its pressure shows"
        )
        for name in OIL_SYSTEMS
    },
    **{
        f"oil_tank_{name}": Quantity(
            f"tank_gain_{name}", OIL_UNITS, "oil in that tank, less what was there at the start"
        )
        for name in OIL_SYSTEMS
    },
    **{
        f"isolated_{name}": Quantity(f"{name}_isolated", SHARE_UNITS, "100 while that is isolated")
        for name in (*SURFACES, *OIL_SYSTEMS)
    },
    **{
        f"mode_{name}": Quantity(f"{name}_mode", CODE_UNITS, "0 normal, 1 emergency, 2 hand")
        for name in SURFACES
    },
    **{
        f"bus_dead_{name}": Quantity(f"{name}_dead", SHARE_UNITS, "100 while that bus is dead")
        for name in BUS_NAMES
    },
    "bus_tie": Quantity("bus_tie", SHARE_UNITS, "100 while it is shut"),
    "loads_shed": Quantity("loads_shed", SHARE_UNITS, "100 while they are off"),
    **{
        f"fire_{name}": Quantity(f"fire_{name}", SHARE_UNITS, "of that room")
        for name in PLACE_NAMES
    },
    **{
        f"smoke_{name}": Quantity(f"smoke_{name}", SHARE_UNITS, "in that room")
        for name in PLACE_NAMES
    },
}
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
        name: Quantity(f"{name}_mid", SHARE_UNITS, f"100 while the {name} amidships is open")
        for name in ("vent", "blow")
    },
    **{
        f"bank_{name}": Quantity(
            f"bank_{name}", PRESSURE_UNITS, "absolute pressure in that air bank"
        )
        for name in BANKS
    },
    **PLANT_QUANTITIES,
}

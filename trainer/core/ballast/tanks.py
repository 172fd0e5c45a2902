"""The tanks, banks and pumps of one boat, and the flows into a tank.

Water is a mass [kg] between empty and full. All that crosses the hull is entered in the two ledgers
of the state, ``water_taken`` and ``air_taken``, so that nothing is made or lost.
"""

import math
from typing import Final

import numpy as np

from trainer.core.kernel import Field, Record, inline_kernel, record_dtype

BLOWN_TANKS: Final = (
    "forward",
    "mid",
    "aft",
    "negative",
)  # emptied by air through their flood ports
PUMPED_TANKS: Final = ("trim_forward", "trim_aft", "auxiliary", "depth_control")
COMPARTMENTS: Final = ("compartment_forward", "compartment_centre", "compartment_aft")
TANKS: Final = (*BLOWN_TANKS, *PUMPED_TANKS, *COMPARTMENTS)
BANKS: Final = ("main", "emergency")
PUMPS: Final = ("trim", "drain", "depth_control")

# indices in the above
NEGATIVE_TANK = 3
TRIM_FORWARD, TRIM_AFT, AUXILIARY_TANK, DEPTH_CONTROL = 4, 5, 6, 7
FIRST_DRY, TANKS_END = 8, 11  # the compartments
MAIN_BANK, EMERGENCY_BANK = 0, 1
TRIM_PUMP, DRAIN_PUMP, DEPTH_CONTROL_PUMP = 0, 1, 2

ATMOSPHERIC_PRESSURE: Final = 101325.0  # [Pa] outside, and in a tank or compartment vented inboard
DISCHARGE_COEFFICIENT: Final = 0.6  # [-] of a sharp-edged hole

HULL_STATIONS: Final = 5  # stations along the hull at which its buoyancy at the surface is found
MAX_DENSITY_LAYERS: Final = 4  # most points of the density profile

BALLAST_FIELDS: Final[tuple[Field, ...]] = (
    "fitted",  # [-] 0: a boat without tanks, whose weight and balance are never touched
    # by tank
    ("capacity", (len(TANKS),)),  # [kg] of sea water
    ("x", (len(TANKS),)),  # [m] centre
    ("y", (len(TANKS),)),
    ("z", (len(TANKS),)),
    ("start", (len(TANKS),)),  # [kg] at which the vessel's weight and balance hold
    # by blown tank
    ("height", (len(BLOWN_TANKS),)),  # [m] flood port to vent
    ("port", (len(BLOWN_TANKS),)),  # [m2] effective area of the flood ports
    ("vent_area", (len(BLOWN_TANKS),)),  # [m2] effective area of the vent, likewise of the valves
    ("blow_area", (len(BLOWN_TANKS),)),
    ("emergency_area", (len(BLOWN_TANKS),)),
    # by bank
    ("bank_volume", (len(BANKS),)),  # [m3]
    ("bank_full", (len(BANKS),)),  # [kg]
    "gas",  # [J/kg] gas constant times temperature
    "choked",  # [s/m] mass flow of a sonic nozzle per area and pressure
    "compressor_rate",  # [kg/s]
    "intake_depth",  # [m] of the origin, down to which the compressor has air from above
    ("pump_rate", (len(PUMPS),)),  # [kg/s]
    "shutoff_depth",  # [m] where the pumps no longer deliver to the sea
    "hover_frequency",  # [rad/s]
    "hover_rate",  # [m/s] most depth rate in hovering
    # hull in the water
    "compressibility",  # [kg/m] buoyancy lost with depth
    "reference_depth",  # [m] where the vessel's buoyancy holds
    "layers",  # [-] points of the density profile
    ("layer_depth", (MAX_DENSITY_LAYERS,)),  # [m] ascending
    ("layer_density", (MAX_DENSITY_LAYERS,)),  # [kg/m3] above the vessel file's
    "hull_diameter",  # [m] of the section that emerges
    "hull_axis",  # [m] z of its centre
    ("station_x", (HULL_STATIONS,)),  # [m]
    ("station_share", (HULL_STATIONS,)),  # [-] of the buoyancy
)

BALLAST: Final = record_dtype(*BALLAST_FIELDS)


def new_ballast() -> Record:
    """Return the constants of a boat without tanks."""
    return np.zeros(1, BALLAST)


@inline_kernel
def sea_pressure(specific: float, depth: float) -> float:
    """Return the absolute pressure [Pa] at ``depth`` [m] in the sea.

    ``specific`` is the weight of the water per volume [N/m3]. Above the sea it is the pressure of
    the atmosphere.
    """
    return ATMOSPHERIC_PRESSURE + specific * max(depth, 0.0)


@inline_kernel
def admit(ballast: Record, tank: int, wanted: float, state: Record) -> None:
    """Admit ``wanted`` [kg] of sea water to a tank, or let it out if negative.

    It ends where the tank is full or empty.
    """
    s = state[0]
    before = s.water[tank]
    s.water[tank] = min(max(before + wanted, 0.0), ballast[0].capacity[tank])
    s.water_taken += s.water[tank] - before


@inline_kernel
def through_hole(rho: float, area: float, pressure: float) -> float:
    """Return the flow [kg/s] that ``pressure`` [Pa] drives through ``area`` [m2].

    The area is the effective one.
    """
    return area * math.sqrt(2.0 * rho * pressure) if pressure > 0.0 else 0.0

"""The parts of a plant: its systems, buses, consumers and compartments, and its constants.

Two oil systems feed the surfaces, three buses the consumers; three compartments can burn. What
there is follows the manuals of the fleet boats (NAVPERS 16160 and its volumes on hydraulics and on
electricity); the numbers stand in the vessel file, which says that they are estimates.
"""

from typing import Final

from trainer.core.kernel import Field, Record, inline_kernel

OIL_SYSTEMS: Final = ("main", "vital")
MAIN, VITAL = 0, 1
OIL_PUMPS: Final = ("1", "2", "vital")
MAIN_PUMP_COUNT: Final = 2  # the first of them feed the main system
STANDING_BY, RUNNING, STOPPED = 0, 1, 2  # of such a pump
MODE_NAMES: Final = ("normal", "emergency", "hand")  # how a surface is moved
NORMAL, EMERGENCY, HAND = 0, 1, 2
BUS_NAMES: Final = ("port", "starboard", "dc")
PORT, STARBOARD, DC = 0, 1, 2
CONSUMER_NAMES: Final = (
    *("hydraulic_1", "hydraulic_2", "hydraulic_vital"),
    *("trim", "drain", "depth_control", "compressor"),
    *("autopilot", "gyro", "log", "sounder", "telegraph", "propulsion"),
)
CONSUMER_COUNT: Final = 13
HYDRAULIC_END: Final = 3  # the pumps of the oil come first, in their order
FED_TRIM, FED_DRAIN, FED_DEPTH_CONTROL, FED_COMPRESSOR = 3, 4, 5, 6  # as PUMPS of the water
FED_AUTOPILOT, FED_GYRO, FED_LOG, FED_SOUNDER, FED_TELEGRAPH, FED_PROPULSION = 7, 8, 9, 10, 11, 12
PLACE_NAMES: Final = ("forward", "control", "aft")  # compartments that can burn
FORWARD, CONTROL, AFT = 0, 1, 2
BURNING_ITEMS: Final = (*CONSUMER_NAMES, *BUS_NAMES)  # what a fire can take away
MAIN_VALVE, VITAL_VALVE = 3, 4  # of what can be isolated, after the legs of the surfaces
RUN_VENTILATION, SECURED, EXHAUSTING = 0, 1, 2

# where faults begin in the state's plant_fault, after those of the two systems' pumps
HEADER, FIRST_LEG, FIRST_BUS, CELLS, DIP, FIRST_FIRE = 2, 3, 6, 9, 10, 11

PLANT_FIELDS: Final[tuple[Field, ...]] = (
    # oil, by system: accumulator full, its gas without oil, its oil, and the tank's at the start
    ("oil_full", (2,)),  # [Pa]; 0: a boat without a plant
    ("oil_low", (2,)),  # [Pa]
    ("oil_usable", (2,)),  # [m3]
    ("oil_reserve", (2,)),  # [m3]
    "oil_rated",  # [Pa] from here on a surface has its whole rate
    "oil_dead",  # [Pa] here and below it does not move
    ("oil_start", (3,)),  # [Pa] below which a pump starts
    ("oil_rate", (3,)),  # [m3/s] that it delivers
    ("oil_angle", (3,)),  # [m3/rad] that rudder, stern planes and bow planes draw
    "emergency_share",  # [-] of the rate
    "hand_rate",  # [rad/s]
    "trail_share",  # [-] of the rate, with which an unfed surface goes to zero; 0: it stays
    ("shift_time", (3,)),  # [s] to shift to each mode
    # power
    ("feeders", (CONSUMER_COUNT,)),  # [-] a bit for each bus
    ("power_drawn", (CONSUMER_COUNT,)),  # [W]
    ("hotel", (3,)),  # [W] by bus
    ("hotel_shed", (3,)),  # [W] of it that can be shed
    "bus_limit",  # [W]
    "overload_time",  # [s] after which the breaker opens
    "screw_power",  # [W] at the command speed below
    "screw_speed",  # [m/s]
    "cell_power",  # [W] at which half of what is drained is lost
    "battery_full",  # [J]
    "gyro_time",  # [s] on its own battery
    # fire
    ("burn_place", (CONSUMER_COUNT + 3,)),  # [-] compartment of an item, -1: none burns it
    ("burn_dose", (CONSUMER_COUNT + 3,)),  # [s] of a whole fire that it stands
    ("place_bus", (3,)),  # [-] bus of a compartment, -1: none
    "fire_start",  # [-] size at severity 1
    "fire_growth",  # [s]
    "fire_fight",  # [s]
    "fire_party",  # [s] from the order until it is fought
    "fire_out",  # [-] size below which a fire that is fought is out
    "smoke_time",  # [s]
    "smoke_spread",  # [s]
    "smoke_clear",  # [s]
)


@inline_kernel
def is_dead(consumer: int, state: Record) -> bool:
    """Return whether a consumer is without power, or burnt."""
    unpowered = state[0].unpowered
    return unpowered != 0.0 and (int(unpowered) >> consumer) & 1 == 1

"""The channels of the plant: what a crew sees of oil, power, smoke and surfaces.

A boat without a plant has none of them. What broke is not among them, and a fire shows by its
smoke: the instructor's channel ``casualties`` has the cause.
"""

from typing import Final

from trainer.boat.boat import Boat
from trainer.boat.plant_effects import lacking_plant
from trainer.core.plant.parts import (
    BUS_NAMES,
    CONSUMER_NAMES,
    MODE_NAMES,
    OIL_PUMPS,
    OIL_SYSTEMS,
    PLACE_NAMES,
)
from trainer.core.surfaces import SURFACES
from trainer.io.orders.grammar import Refused
from trainer.session.stations.panels import (
    MEGAPASCAL,
    PERCENT,
    Channel,
    Field,
    Value,
    number_of_state,
    reading,
    word,
    word_of_state,
)
from trainer.session.stations.view import Frame

LITRE, KILOWATT = 1e-3, 1e3  # [m3] [W]
PUMP_WORDS: Final = ("standing by", "running", "stopped")
AIRWAY_WORDS: Final = ("running", "secured", "exhausting")


def lack_of_plant(boat: Boat) -> Refused | None:
    """Return that a boat has no plant, None where it has one."""
    return None if boat.file.plant else lacking_plant(boat)


def dead_consumers(frame: Frame) -> Value:
    """Return what has no power, or is burnt, None where all have it."""
    dead = int(frame["unpowered"])
    return "+".join(name for bit, name in enumerate(CONSUMER_NAMES) if dead >> bit & 1) or None


def seconds_left(name: str, ticks: str) -> Field:
    """Return the time [s] until something is done that was ordered."""

    def left(frame: Frame) -> Value:
        return abs(frame[ticks]) * frame.boat.method.step if frame[ticks] else None

    return Field(name, "s", 1, left)


def supply_fields(surface: str) -> tuple[Field, ...]:
    """Return what moves a surface, and to what it is being shifted."""

    def carried(frame: Frame, field: str) -> Value:
        return MODE_NAMES[int(frame[f"{surface}_{field}"])] if frame.boat.carries(surface) else None

    def coming(frame: Frame) -> Value:
        return carried(frame, "mode_ordered") if frame[f"{surface}_mode_ticks"] else None

    return (
        word(f"{surface}_supply", lambda frame: carried(frame, "mode")),
        word(f"{surface}_shifted_to", coming),
        seconds_left(f"{surface}_shift", f"{surface}_mode_ticks"),
    )


PRESSURE_FIELDS: Final = tuple(
    reading(f"{name}_pressure", "MPa", 1, MEGAPASCAL) for name in OIL_SYSTEMS
)
SUPPLY_FIELDS: Final = tuple(field for name in SURFACES for field in supply_fields(name))
PLANT_CHANNELS: Final = (
    Channel(
        "supply",
        "what moves each surface, and the oil's pressure",
        (*SUPPLY_FIELDS, *PRESSURE_FIELDS),
        lack=lack_of_plant,
    ),
    Channel(
        "plant",
        "oil, buses, battery, smoke, and what moves each surface",
        (
            *PRESSURE_FIELDS,
            *(reading(f"{name}_level", "L", 0, LITRE) for name in OIL_SYSTEMS),
            *(
                word_of_state(f"pump_{name}", f"hydraulic_pump_{name}", *PUMP_WORDS)
                for name in OIL_PUMPS
            ),
            *(
                word_of_state(f"{name}_oil", f"{name}_isolated", "open", "isolated")
                for name in (*SURFACES, *OIL_SYSTEMS)
            ),
            *SUPPLY_FIELDS,
            *(word_of_state(f"{name}_bus", f"{name}_dead", "live", "dead") for name in BUS_NAMES),
            *(reading(f"{name}_load", "kW", 0, KILOWATT) for name in BUS_NAMES),
            *(
                word_of_state(f"{name}_breaker", f"{name}_open", "shut", "open")
                for name in BUS_NAMES[:2]
            ),
            word_of_state("tie", "bus_tie", "open", "shut"),
            reading("overload_left", "s", 0),
            word_of_state("loads", "loads_shed", "on", "shed"),
            reading("charge", "%", 1, PERCENT),
            word("dead", dead_consumers),
            *(
                number_of_state(f"smoke_{name}", f"smoke_{name}", "%", 0, PERCENT)
                for name in PLACE_NAMES
            ),
            word_of_state("ventilation", "ventilation", *AIRWAY_WORDS),
            word_of_state("party", "fighting", "", *PLACE_NAMES),
            seconds_left("party_due", "fight_ticks"),
        ),
        lack=lack_of_plant,
    ),
)

"""A vessel file's plant becomes the constants of the core's record.

``assemble`` calls ``write_plant``. A boat without the table has zeros, and no plant.
"""

import math
from dataclasses import dataclass, replace
from typing import Any, Final

from trainer.config.boat.plant_records import Plant
from trainer.config.boat.vessel import VesselFile
from trainer.core.kernel import Record
from trainer.core.plant.parts import (
    BURNING_ITEMS,
    BUS_NAMES,
    CONSUMER_NAMES,
    FED_AUTOPILOT,
    OIL_PUMPS,
    OIL_SYSTEMS,
    PLACE_NAMES,
)
from trainer.units import KNOT

LITRE: Final = 1e-3  # [m3]
STROKE_RAD: Final = math.radians(60.0)  # [rad] of which the file says the oil
KILOWATT_HOUR: Final = 3.6e6  # [J]
ENDLESS_KWH: Final = 1e24  # [kWh] so many that what is drawn in a voyage is lost in rounding
NO_PLACE: Final = -1.0
ENDURANCE_SPEEDS_KN: Final = (5.0, 10.0, 15.0, 20.0)


@dataclass(frozen=True)
class PlantFacts:
    """What a plant is worth while it is well."""

    endurance_h: dict[str, float]  # by speed [kn], in whole numbers
    strokes: dict[str, float]  # [-] by oil system, without its pumps


def plant_facts(plant: Plant, fastest: float) -> PlantFacts:
    """Return how long a plant lasts at speeds up to ``fastest`` [kn], and its strokes.

    A stroke is that of the stern planes, 60 degrees; the pumps stand still.
    """
    always = CONSUMER_NAMES[FED_AUTOPILOT:]
    loads = sum(row.power_w for row in plant.hotel)
    loads += sum(row.power_w for row in plant.consumers if row.name in always)
    battery = plant.battery
    hours = {}
    for speed in (knots for knots in ENDURANCE_SPEEDS_KN if knots <= fastest):
        power = loads + battery.propeller_w * (speed / battery.propeller_kn) ** 3
        drained = power * (1.0 + power / battery.cell_w)
        hours[f"{speed:g}"] = battery.capacity_kwh * 1e3 / drained
    return PlantFacts(
        endurance_h=hours,
        strokes={
            name: getattr(plant, name).usable_m3 / (LITRE * plant.surfaces.stern_l)
            for name in OIL_SYSTEMS
        },
    )


def without_drain(file: VesselFile) -> VesselFile:
    """Return a boat whose battery no voyage drains; lost cells still take their share."""
    if file.plant is None:
        return file
    battery = replace(file.plant.battery, capacity_kwh=ENDLESS_KWH)
    return replace(file, plant=replace(file.plant, battery=battery))


def write_plant(file: VesselFile, record: Record) -> None:
    """Write the constants of the boat's plant [SI] to the vessel record."""
    plant = file.plant
    if plant is None:
        return
    c: Any = record[0]
    _write_oil(plant, c)
    _write_power(plant, c)
    _write_fire(plant, c)


def _write_oil(plant: Plant, c: Any) -> None:
    """Write accumulators, tanks, pumps, and what the surfaces draw."""
    for system, name in enumerate(OIL_SYSTEMS):
        row = getattr(plant, name)
        c.oil_full[system], c.oil_low[system] = 1e6 * row.full_mpa, 1e6 * row.low_mpa
        c.oil_usable[system], c.oil_reserve[system] = row.usable_m3, row.tank_m3
    for pump in plant.pumps:
        index = OIL_PUMPS.index(pump.name)
        c.oil_start[index], c.oil_rate[index] = 1e6 * pump.start_mpa, LITRE * pump.rate_l_s
    surfaces = plant.surfaces
    strokes = surfaces.rudder_l, surfaces.stern_l, surfaces.bow_l
    for surface, litres in enumerate(strokes):
        c.oil_angle[surface] = LITRE * litres / STROKE_RAD
    c.oil_rated, c.oil_dead = 1e6 * surfaces.rated_mpa, 1e6 * surfaces.dead_mpa
    c.emergency_share, c.trail_share = surfaces.emergency_share, surfaces.trail_share
    c.hand_rate = math.radians(surfaces.hand_deg_s)
    c.shift_time[:] = surfaces.shift_s, surfaces.shift_s, surfaces.man_s


def _write_power(plant: Plant, c: Any) -> None:
    """Write what draws power, from where, and the battery."""
    for row in plant.consumers:
        index = CONSUMER_NAMES.index(row.name)
        c.feeders[index] = sum(1 << BUS_NAMES.index(bus) for bus in row.buses)
        c.power_drawn[index] = row.power_w
    for hotel in plant.hotel:
        bus = BUS_NAMES.index(hotel.bus)
        c.hotel[bus], c.hotel_shed[bus] = hotel.power_w, hotel.shed_w
    battery = plant.battery
    c.bus_limit, c.overload_time = battery.bus_limit_w, battery.overload_s
    c.screw_power, c.screw_speed = battery.propeller_w, battery.propeller_kn * KNOT
    c.cell_power, c.battery_full = battery.cell_w, battery.capacity_kwh * KILOWATT_HOUR
    c.gyro_time = battery.gyro_s


def _write_fire(plant: Plant, c: Any) -> None:
    """Write what burns where, and how."""
    c.burn_place[:] = c.place_bus[:] = NO_PLACE
    for item in plant.burning:
        index = BURNING_ITEMS.index(item.name)
        c.burn_place[index], c.burn_dose[index] = PLACE_NAMES.index(item.compartment), item.dose_s
    for row in plant.compartments:
        if row.bus:
            c.place_bus[PLACE_NAMES.index(row.name)] = BUS_NAMES.index(row.bus)
    fire = plant.fire
    c.fire_start, c.fire_growth, c.fire_fight = fire.start, fire.growth_s, fire.fight_s
    c.fire_party, c.fire_out = fire.party_s, fire.out
    c.smoke_time, c.smoke_spread, c.smoke_clear = fire.smoke_s, fire.spread_s, fire.clear_s

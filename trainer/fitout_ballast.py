"""The table [ballast] of a vessel file made into the core's record."""

import math
from typing import Final

from trainer.core.kernel import Record
from trainer.core.tanks import BANKS, BLOWN, STATIONS, TANKS, new_ballast
from trainer.files.ballast_records import Ballast, BlownTank, Compartment, PumpedTank, Sea
from trainer.files.vessel_file import VesselFile

GAS_CONSTANT: Final = 287.05  # [J/(kg K)] of air
ADIABATIC: Final = 1.4  # [-] of air
ZERO_CELSIUS: Final = 273.15  # [K]

# Stations along the hull in lengths from the centre of buoyancy, and their shares of the buoyancy:
# a full middle and finer ends, project's own. Their radius of gyration is 0.235 lengths.
STATION_PLACES: Final = (-0.4, -0.2, 0.0, 0.2, 0.4)
STATION_SHARES: Final = (0.11, 0.25, 0.28, 0.25, 0.11)
PRISMATIC: Final = 0.75  # [-] fullness of a hull whose file gives no breadth


def ballast_record(file: VesselFile) -> Record:
    """Return the constants of the boat's tanks; a boat without the table has none."""
    record = new_ballast()
    _write_hull(file, record)
    if file.ballast is None:
        return record
    record["fitted"] = 1.0
    _write_tanks(file.ballast, file.fluid.rho, record)
    _write_air(file.ballast, record)
    _write_pumps(file.ballast, record)
    _write_sea(file.ballast.sea, record)
    return record


def _write_hull(file: VesselFile, record: Record) -> None:
    """Write the circle that emerges at the surface: keel to deck, or as the displacement is."""
    hull = file.hull
    volume = hull.buoyancy / (file.fluid.rho * file.fluid.g)
    diameter = math.sqrt(4.0 * volume / (math.pi * PRISMATIC * hull.length))
    axis = hull.cb[2]
    if hull.height_to_deck and hull.height_to_sail_top and hull.cg_below_sail_top:
        diameter = hull.height_to_deck
        keel = hull.cg[2] - hull.cg_below_sail_top + hull.height_to_sail_top
        axis = keel - 0.5 * diameter
    record["hull_diameter"], record["hull_axis"] = diameter, axis
    for i in range(STATIONS):
        record["station_x"][0, i] = hull.cb[0] + STATION_PLACES[i] * hull.length
        record["station_share"][0, i] = STATION_SHARES[i]


def _write_tanks(ballast: Ballast, rho: float, record: Record) -> None:
    """Write capacities [kg], centres [m] and start fillings [kg] of all tanks there are."""
    rows: list[BlownTank | PumpedTank | Compartment] = [*ballast.blown, *ballast.pumped]
    for row in [*rows, *ballast.compartments]:
        place = TANKS.index(row.name)
        capacity = row.capacity_m3 * rho
        record["capacity"][0, place] = capacity
        for axis, centre in zip("xyz", row.centre_m, strict=True):
            record[axis][0, place] = centre
        record["start"][0, place] = capacity * getattr(row, "start_fill", 0.0)
    for row in ballast.blown:
        place = BLOWN.index(row.name)
        record["height"][0, place] = row.height_m
        record["port"][0, place] = row.flood_port_m2
        record["vent_area"][0, place] = row.vent_cm2 * 1e-4
        record["blow_area"][0, place] = row.blow_mm2 * 1e-6
        record["emergency_area"][0, place] = row.emergency_blow_mm2 * 1e-6


def _write_air(ballast: Ballast, record: Record) -> None:
    """Write banks, compressor and the constants of the gas."""
    gas = GAS_CONSTANT * (ballast.air.temperature_c + ZERO_CELSIUS)
    record["gas"] = gas
    # St. Venant's choked nozzle
    exponent = (ADIABATIC + 1.0) / (2.0 * (ADIABATIC - 1.0))
    record["choked"] = math.sqrt(ADIABATIC / gas) * (2.0 / (ADIABATIC + 1.0)) ** exponent
    record["compressor_rate"] = ballast.air.compressor_kg_s
    for row in ballast.banks:
        place = BANKS.index(row.name)
        record["bank_volume"][0, place] = row.volume_m3
        record["bank_full"][0, place] = row.pressure_mpa * 1e6 * row.volume_m3 / gas


def _write_pumps(ballast: Ballast, record: Record) -> None:
    """Write the pumps and how the boat hovers."""
    pumps = ballast.pumps
    record["pump_rate"][0] = [pumps.trim_kg_s, pumps.drain_kg_s, pumps.depth_control_kg_s]
    record["shutoff_depth"] = pumps.shutoff_depth_m
    record["hover_frequency"] = ballast.hover.frequency_rad_s
    record["hover_rate"] = ballast.hover.depth_rate_m_s


def _write_sea(sea: Sea, record: Record) -> None:
    """Write how buoyancy changes with depth."""
    count = len(sea.layer_depth_m)
    record["compressibility"] = sea.compressibility_kg_m
    record["reference_depth"] = sea.reference_depth_m
    record["layers"] = count
    record["layer_depth"][0, :count] = sea.layer_depth_m
    record["layer_density"][0, :count] = sea.layer_kg_m3

"""Every constant of a boat as the core gets it. These are the listings of EB920 and EC790.

``trainer boat check`` lists them. A constant is named by its symbol in the core's record, in SI
units and radians. It comes from a key of the vessel file, or from the defaults file, or is derived
from other constants.
"""

import tomllib
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import lru_cache
from typing import Any, Final, NamedTuple

import numpy as np

from trainer.boat.assemble import Method, fit_out
from trainer.config.boat.vessel import VesselFile
from trainer.core.ballast.tanks import BANKS, BLOWN_TANKS, PUMPS, TANKS
from trainer.core.kernel import Record
from trainer.core.terms import COMPACT_TERMS, EXTRA_TERMS, TERM_TABLE
from trainer.core.vessel import GAINS, INVERTED_NAMES
from trainer.report.text import INDENT, cut_text, titled_table, wrap

FILE_ORIGIN, DEFAULT_ORIGIN, DERIVED_ORIGIN, ABSENT_ORIGIN = "file", "default", "derived", "absent"
# of rho/2 L^power, whatever the term multiplies, since angles have no unit
DIMENSION_UNITS: Final = {2: "kg/m", 3: "kg", 4: "kg m", 5: "kg m2"}
INVERSE_UNITS: Final = {3: "1/m2", 4: "1/m", 5: "-"}  # the same over a moment of inertia
MOMENT_AXES: Final = "KMN"  # whose compact constants are over a moment of inertia
SURFACE_NAMES: Final = ("rudder", "stern planes", "bow planes")
MASS_UNITS: Final = {**dict.fromkeys("123", "kg"), **dict.fromkeys("456", "kg m2")}
# what the columns of an array are, where they have names
COLUMN_NAMES: Final[Mapping[str, tuple[str, ...]]] = {
    **dict.fromkeys(("capacity", "x", "y", "z", "start"), TANKS),
    **dict.fromkeys(("height", "port", "vent_area", "blow_area", "emergency_area"), BLOWN_TANKS),
    **dict.fromkeys(("bank_volume", "bank_full"), BANKS),
    "pump_rate": PUMPS,
    "gain": tuple(GAINS),
    **dict.fromkeys(
        ("stall_ahead", "stall_slope", "stall_astern", "stall_arm", "plane_drag"), SURFACE_NAMES
    ),
}
# which constants tell how many rows and columns of an array are in use
ARRAY_COUNTS: Final[Mapping[str, tuple[str, str]]] = {
    "gain_speed": ("", "gain_count"),
    "gain": ("gain_count", ""),
    "surface_depth": ("", "surface_depths"),
    "surface_speed": ("", "surface_speeds"),
    **dict.fromkeys(("surface_Z", "surface_M"), ("surface_speeds", "surface_depths")),
    **dict.fromkeys(("surface_Z_w", "surface_M_w"), ("", "surface_depths")),
    **dict.fromkeys(("layer_depth", "layer_density"), ("", "layers")),
}
_tables = lru_cache(maxsize=2)(tomllib.loads)  # of a vessel file, parsed once for all of its keys


class ConstantSource(NamedTuple):
    """Unit of a constant, and the key that it comes from. "= KEYS": derived from those."""

    unit: str
    key: str


def _sources(unit: str, **keys: str) -> dict[str, ConstantSource]:
    """Return sources of one unit by symbol."""
    return {symbol: ConstantSource(unit, key) for symbol, key in keys.items()}


HULL_SOURCES: Final = {
    **_sources("kg/m3", rho="fluid.rho"),
    **_sources("m/s2", g="fluid.g"),
    **_sources("m", ell="vessel.length"),
    **_sources("kg", mass="vessel.mass"),
    **_sources("N", weight="vessel.weight", buoyancy="vessel.buoyancy"),
    **_sources("m", x_g="vessel.cg", y_g="vessel.cg", z_g="vessel.cg"),
    **_sources("m", x_b="vessel.cb", y_b="vessel.cb", z_b="vessel.cb"),
    **_sources("kg m2", I_x="vessel.Ix", I_y="vessel.Iy", I_z="vessel.Iz"),
    **_sources("kg m2", I_xy="vessel.Ixy", I_yz="vessel.Iyz", I_xz="vessel.Ixz"),
}
CONTROL_SOURCES: Final = {
    **_sources(
        "rad",
        limit_r="control_surfaces.rudder_limit_deg",
        limit_s="control_surfaces.stern_plane_limit_deg",
        limit_b="control_surfaces.bow_plane_limit_deg",
    ),
    **_sources("rad/s", surface_rate="control_surfaces.rate_deg_s"),
    **_sources("s", surface_lag="control_surfaces.time_constant_s"),
    **_sources("-", x_tail="control_surfaces.tail"),
    **_sources("s", telegraph_dead_time="propulsion.dead_time_s"),
    **_sources("s", propulsion_lag="propulsion.time_constant_s"),
    **_sources(
        "m/s", u_c_ahead="propulsion.max_ordered_speed_kn", u_c_astern="propulsion.bells_kn"
    ),
    **_sources("1/s", speed_integral="autopilot.speed_integral"),
    **_sources("rad/s", turning_rate="autopilot.turning_rate_deg_s"),
    **_sources("-", gain_count="autopilot.speed_kn"),
    **_sources("m/s", gain_speed="autopilot.speed_kn"),
    **_sources("SI, rad", gain="autopilot"),
}
SURFACE_SOURCES: Final = {
    **_sources(
        "m", diameter="= vessel.diameter, beam", x_sail="= vessel.sail_from_nose, cg_from_nose"
    ),
    **_sources("m", z_sail="= vessel.cg_below_sail_top", z_deck="= vessel.height_to_deck"),
    **_sources("-", surface_depths="free_surface.depth_m", surface_speeds="free_surface.rows"),
    **_sources("m", surface_depth="free_surface.depth_m"),
    **_sources("m/s", surface_speed="free_surface.rows"),
    **_sources("kg/m", surface_Z="free_surface.rows"),
    **_sources("kg", surface_M="free_surface.rows"),
    **_sources("kg/m", surface_Z_w="free_surface.Z_w"),
    **_sources("kg", surface_M_w="free_surface.M_w"),
}
BALLAST_SOURCES: Final = {
    **_sources("-", fitted="ballast"),
    **_sources("kg", capacity="ballast", start="ballast"),
    **_sources("m", x="ballast", y="ballast", z="ballast", height="ballast.blown"),
    **_sources("m2", port="ballast.blown", vent_area="ballast.blown"),
    **_sources("m2", blow_area="ballast.blown", emergency_area="ballast.blown"),
    **_sources("m3", bank_volume="ballast.banks"),
    **_sources("kg", bank_full="= ballast.banks, ballast.air"),
    **_sources("J/kg", gas="= ballast.air.temperature_c"),
    **_sources("s/m", choked="= ballast.air.temperature_c"),
    **_sources("kg/s", compressor_rate="ballast.air.compressor_kg_s", pump_rate="ballast.pumps"),
    **_sources("m", shutoff_depth="ballast.pumps.shutoff_depth_m"),
    **_sources("m", intake_depth="= ballast.air.intake_depth_m, vessel"),
    **_sources("rad/s", hover_frequency="ballast.hover.frequency_rad_s"),
    **_sources("m/s", hover_rate="ballast.hover.depth_rate_m_s"),
    **_sources("kg/m", compressibility="ballast.sea.compressibility_kg_m"),
    **_sources("m", reference_depth="ballast.sea.reference_depth_m"),
    **_sources("-", layers="ballast.sea.layer_depth_m"),
    **_sources("m", layer_depth="ballast.sea.layer_depth_m"),
    **_sources("kg/m3", layer_density="ballast.sea.layer_kg_m3"),
    **_sources("m", hull_diameter="= vessel", hull_axis="= vessel", station_x="= vessel.length"),
    **_sources("-", station_share="= program's estimate"),
}
ENVELOPE_SOURCES: Final = {
    **_sources("-", tested="envelope.tested_deg"),
    **_sources("-", handover_from="envelope.handover_deg", handover_to="envelope.handover_deg"),
    **_sources("m2", cross_arm="= vessel.length"),
    **_sources("1/m", stiffness="= coefficients"),
    **_sources("rad/s", still_mode="= righting moment and inertia"),
    **{f"m{i}{i}": ConstantSource(unit, "= coefficients") for i, unit in MASS_UNITS.items()},
    **_sources("kg m", m26="= coefficients", m35="= coefficients", m24="= coefficients"),
    **_sources("kg m2", m46="= coefficients"),
    **_sources("kg/m, kg, kg m", lateral="= coefficients", vertical="= coefficients"),
    **_sources("kg m", roll_damping="= coefficients"),
    **_sources("kg m2", roll_drag="= coefficients"),
    **_sources("kg/m", crossflow_Y="envelope.crossflow_y", crossflow_Z="envelope.crossflow_z"),
    **_sources("m", tail_x="envelope.tail_place"),
    **_sources("kg/m", tail_Y="envelope.tail_y", tail_Z="envelope.tail_z"),
    **_sources("m", strip_x="envelope.sail_place", strip_z="envelope.sail_place"),
    **_sources("kg/m", strip_Y="envelope.sail_y"),
    **_sources("m", lift_x="envelope.sail_lift_place", lift_z="envelope.sail_lift_place"),
    **_sources("kg/m", sail_lift="envelope.sail_lift"),
    **_sources("kg", sail_mass="envelope.sail_added_mass"),
    **_sources("m", sail_height="= vessel"),
    **_sources("-", astern_effect="envelope.plane_effect_astern"),
    **_sources("rad", stall_ahead="envelope.stall_deg", stall_astern="envelope.stall_astern_deg"),
    **_sources("-", stall_slope="envelope.stall_slope"),
    **_sources("m", stall_arm="= coefficients"),
    **_sources("kg/m", plane_drag="= coefficients", thrust_astern="= propulsion.sets"),
    **_sources("m", surface_line="= vessel", station_reach="= vessel", hull_reach="= vessel"),
    **_sources("-", surface_damping="envelope.surface_damping"),
    **_sources("rad/s", surface_mode="= vessel, coefficients"),
    **_sources("N s6/m6", wave_drag="= vessel.length"),
    **_sources("1/s2", torque_limit="= propulsion.torque_limit_n_m"),
    **_sources("1/s3", power_limit="= propulsion.shaft_power_w"),
    **_sources("-", torque="= propulsion.KQ"),
    **_sources("1/m", turns="propulsion.rps_per_mps"),
    **_sources("m", screw="propulsion.propeller_diameter"),
    **_sources("-", strips="wave_strips"),
}
PLANT_SOURCES: Final = {
    **_sources("Pa", oil_full="plant", oil_low="plant", oil_start="plant.pumps"),
    **_sources("Pa", oil_rated="plant.surfaces.rated_mpa", oil_dead="plant.surfaces.dead_mpa"),
    **_sources("m3", oil_usable="plant", oil_reserve="plant"),
    **_sources("m3/s", oil_rate="plant.pumps"),
    **_sources("m3/rad", oil_angle="plant.surfaces"),
    **_sources(
        "-",
        emergency_share="plant.surfaces.emergency_share",
        trail_share="plant.surfaces.trail_share",
    ),
    **_sources("rad/s", hand_rate="plant.surfaces.hand_deg_s"),
    **_sources("s", shift_time="plant.surfaces"),
    **_sources("-", feeders="plant.consumers"),
    **_sources("W", power_drawn="plant.consumers", hotel="plant.hotel", hotel_shed="plant.hotel"),
    **_sources("W", bus_limit="plant.battery.bus_limit_w", cell_power="plant.battery.cell_w"),
    **_sources("s", overload_time="plant.battery.overload_s", gyro_time="plant.battery.gyro_s"),
    **_sources("W", screw_power="plant.battery.propeller_w"),
    **_sources("m/s", screw_speed="plant.battery.propeller_kn"),
    **_sources("J", battery_full="plant.battery.capacity_kwh"),
    **_sources("-", burn_place="plant.burning", place_bus="plant.compartments"),
    **_sources("s", burn_dose="plant.burning"),
    **_sources("-", fire_start="plant.fire.start", fire_out="plant.fire.out"),
    **_sources("s", fire_growth="plant.fire.growth_s", fire_fight="plant.fire.fight_s"),
    **_sources("s", fire_party="plant.fire.party_s", smoke_time="plant.fire.smoke_s"),
    **_sources("s", smoke_spread="plant.fire.spread_s", smoke_clear="plant.fire.clear_s"),
}
SOURCE_GROUPS: Final[Mapping[str, Mapping[str, ConstantSource]]] = {
    "SIZE, MASS AND BALANCE": HULL_SOURCES,
    "RUDDER, PLANES, ENGINE AND AUTOPILOT": CONTROL_SOURCES,
    "THE BOAT NEAR THE SURFACE": SURFACE_SOURCES,
    "TANKS, AIR AND PUMPS": BALLAST_SOURCES,
    "BEYOND THE RANGE OF THE COEFFICIENTS, AND IN WAVES": ENVELOPE_SOURCES,
    "OIL, POWER, BATTERY AND FIRE": PLANT_SOURCES,
}


@dataclass(frozen=True)
class Constant:
    """One constant of a record, or an array of them in its rows."""

    symbol: str
    unit: str
    values: tuple[tuple[float, ...], ...]  # one row of one number, unless it is an array
    places: tuple[str, ...]  # what the columns are; empty: no names
    origin: str  # file, default, derived, absent
    key: str  # of the vessel file, or what it is derived from


@dataclass(frozen=True)
class Coefficient:
    """One of the 131 terms, in the file, the full set and the compact sets."""

    symbol: str
    mnemonic: str  # of 1969
    prime: float  # [-]
    value: float
    unit: str
    origin: str
    key: str


@dataclass(frozen=True)
class CompactConstant:
    """One constant of the compact sets, [ASSES] equation (18), as program EC790 prints them."""

    symbol: str
    mnemonic: str
    unit: str
    modified: float
    basic: float


@dataclass(frozen=True)
class ConstantsReport:
    """All that ``trainer boat check --constants`` says about a vessel."""

    vessel: str
    path: str
    groups: dict[str, tuple[Constant, ...]]
    coefficients: tuple[Coefficient, ...]
    compact: tuple[CompactConstant, ...]


def origin_of(file: VesselFile, key: str) -> str:
    """Return whether a key is of the file, of the defaults file, or of neither."""
    inside: Any = _tables(file.text)
    for name in key.split("."):
        inside = inside.get(name) if isinstance(inside, Mapping) else None
    if inside is not None:
        return FILE_ORIGIN
    defaulted = any(f"{key}.".startswith(f"{name}.") for name in file.defaulted)
    return DEFAULT_ORIGIN if defaulted else ABSENT_ORIGIN


def _constants(
    file: VesselFile, record: Record, sources: Mapping[str, ConstantSource]
) -> tuple[Constant, ...]:
    """Return the constants of a group."""
    constant_list = []
    for symbol, (unit, key) in sources.items():
        origin = DERIVED_ORIGIN if key.startswith("= ") else origin_of(file, key)
        values = np.asarray(record[symbol][0], float)
        rows = values.reshape(-1, values.shape[-1]) if values.ndim else values.reshape(1, 1)
        counts = ARRAY_COUNTS.get(symbol, ("", ""))  # of rows and columns in use
        high, wide = (int(record[name][0]) if name else None for name in counts)
        numbers = tuple(tuple(map(float, row[:wide])) for row in rows[:high])
        names = COLUMN_NAMES.get(symbol, ())
        constant_list.append(Constant(symbol, unit, numbers, names, origin, key.removeprefix("= ")))
    return tuple(constant_list)


def _compact(file: VesselFile) -> Iterator[CompactConstant]:
    """Yield the constants of both compact sets, the further terms of the file among them."""
    modified, basic = (
        fit_out(file, Method(equations, "lagged", "exact", "adams2", file.run.step_s)).compact
        for equations in ("modified", "basic")
    )
    powers = {term.key: (term.power, term.mnemonic) for term in TERM_TABLE}
    further = tuple(name for name in EXTRA_TERMS if name in file.compact.extra_terms)
    names = []
    for name in (*COMPACT_TERMS, *further):
        power, mnemonic = powers[name]
        symbol = INVERTED_NAMES.get(name, name)
        unit = INVERSE_UNITS[power] if name[0] in MOMENT_AXES else DIMENSION_UNITS[power]
        names.append((symbol, mnemonic, unit if symbol == name else "1/(kg m2)"))
    for named in (*names, *((symbol, symbol, "N m") for symbol in ("XB", "YB", "ZB"))):
        yield CompactConstant(*named, *(float(of[named[0]][0]) for of in (modified, basic)))


def list_vessel_constants(file: VesselFile) -> ConstantsReport:
    """Return every constant of the boat, SI and radians, and where each comes from."""
    record = fit_out(file, Method("full", "exact", "exact", "adams2", file.run.step_s)).vessel
    groups = {name: _constants(file, record, sources) for name, sources in SOURCE_GROUPS.items()}
    rows = _sources("-", eta_1="propulsion.sets", eta_2="propulsion.sets")
    rows |= _sources("-", eta_whole="propulsion.eta_speed")
    groups["LIMITS OF THE THRUST ROWS"] = _constants(file, record, rows)
    coefficients = []
    for term in TERM_TABLE:
        value = float(record[term.key][0])
        key = f"coefficients.{term.key}" if term.key in file.coefficients else "propulsion.sets"
        prime = value / (0.5 * file.fluid.rho * file.hull.length**term.power)
        unit, origin = DIMENSION_UNITS[term.power], origin_of(file, key)
        coefficients.append(Coefficient(term.key, term.mnemonic, prime, value, unit, origin, key))
    return ConstantsReport(
        vessel=file.name,
        path=str(file.path),
        groups=groups,
        coefficients=tuple(coefficients),
        compact=tuple(_compact(file)),
    )


def _number(value: float) -> str:
    """Return a number in nine digits, as many as tell it from its neighbours on a page."""
    return f"{value:.9g}"


def _array(constant: Constant) -> Iterator[str]:
    """Yield an array: a row a line, or a number a line where its columns have names."""
    yield f"{INDENT}{constant.symbol} [{constant.unit}]  {constant.origin}  {constant.key}"
    rows = [" ".join(map(_number, row)) for row in constant.values]
    if constant.places:
        columns = zip(constant.places, zip(*constant.values, strict=True), strict=True)
        rows = [f"{name}: " + " ".join(map(_number, column)) for name, column in columns]
    for text in rows:
        yield from wrap(text, 2 * INDENT, 4 * INDENT)


def render(report: ConstantsReport) -> str:
    """Return the listing as text."""
    lines = [report.vessel, INDENT + cut_text(report.path, 77)]
    for title, group in report.groups.items():
        single = [one for one in group if len(one.values) == 1 == len(one.values[0])]
        rows = [
            (one.symbol, _number(one.values[0][0]), one.unit, one.origin, cut_text(one.key, 25))
            for one in single
        ]
        lines += titled_table(title, ("", "value", "unit", "from", ""), rows)
        lines += [line for one in group if one not in single for line in _array(one)]
    lines += titled_table(
        "COEFFICIENTS (EB920; value: rho/2 L^n times prime)",
        ("", "1969", "prime [-]", "value", "unit", "from"),
        [
            (one.symbol, one.mnemonic, f"{one.prime:.6g}", _number(one.value), one.unit, one.origin)
            for one in report.coefficients
        ],
    )
    lines += titled_table(
        "COMPACT CONSTANTS (EC790; compensation applied)",
        ("", "1969", "modified", "basic", "unit"),
        [
            (one.symbol, one.mnemonic, _number(one.modified), _number(one.basic), one.unit)
            for one in report.compact
        ],
    )
    return "\n".join(lines)

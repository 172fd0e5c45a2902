"""A vessel file becomes the core's records: units become SI, rows and tables become fields.

``boat.Boat`` calls ``fit_out`` once, when it is made. The core reads its records by name at each
tick, and knows neither files nor units. What a file leaves out gets its usual value here.
"""

import math
from dataclasses import dataclass
from typing import Final, NamedTuple

import numpy as np

from trainer.boat.envelope import write_envelope
from trainer.boat.plant import write_plant
from trainer.config.boat.ballast_records import (
    Ballast,
    BlownTank,
    Compartment,
    HullBuoyancy,
    PumpedTank,
)
from trainer.config.boat.vessel import VesselFile
from trainer.config.files import ConfigError
from trainer.core import kinematics, scheme, state, vessel
from trainer.core.ballast.tanks import BANKS, BLOWN_TANKS, HULL_STATIONS, TANKS, new_ballast
from trainer.core.kernel import Record
from trainer.core.terms import BASIC_DROPS, COMPACT_TERMS
from trainer.units import KNOT

GAS_CONSTANT: Final = 287.05  # [J/(kg K)] of air
ADIABATIC_INDEX: Final = 1.4  # [-] of air
ZERO_CELSIUS: Final = 273.15  # [K]

# Stations along the hull in lengths from the centre of buoyancy, and their shares of the buoyancy:
# a full middle and finer ends, project's own. Their radius of gyration is 0.235 lengths.
EVEN_STATIONS: Final = (-0.4, -0.2, 0.0, 0.2, 0.4)
STATION_SHARES: Final = (0.11, 0.25, 0.28, 0.25, 0.11)
PRISMATIC_COEFFICIENT: Final = 0.75  # [-] fullness of a hull whose file gives no breadth


def ballast_record(file: VesselFile) -> Record:
    """Return the constants of the boat's tanks; a boat without the table has none."""
    record = new_ballast()
    # write the circle that emerges at the surface: keel to deck, or as the displacement is
    hull = file.hull
    volume = hull.buoyancy / (file.fluid.rho * file.fluid.g)
    diameter = math.sqrt(4.0 * volume / (math.pi * PRISMATIC_COEFFICIENT * hull.length))
    axis = hull.cb[2]
    if hull.height_to_deck and hull.height_to_sail_top and hull.cg_below_sail_top:
        diameter = hull.height_to_deck
        keel = hull.cg[2] - hull.cg_below_sail_top + hull.height_to_sail_top
        axis = keel - 0.5 * diameter
    record["hull_diameter"], record["hull_axis"] = diameter, axis
    for i in range(HULL_STATIONS):
        record["station_x"][0, i] = hull.cb[0] + EVEN_STATIONS[i] * hull.length
        record["station_share"][0, i] = STATION_SHARES[i]
    if file.ballast is None:
        return record
    record["fitted"] = 1.0
    _write_tanks(file.ballast, file.fluid.rho, record)
    _write_air(file.ballast, record)
    # write the pumps and how the boat hovers
    pumps = file.ballast.pumps
    record["pump_rate"][0] = [pumps.trim_kg_s, pumps.drain_kg_s, pumps.depth_control_kg_s]
    record["shutoff_depth"] = pumps.shutoff_depth_m
    record["hover_frequency"] = file.ballast.hover.frequency_rad_s
    record["hover_rate"] = file.ballast.hover.depth_rate_m_s
    _write_sea(file.ballast.sea, record)
    return record


def _write_tanks(ballast: Ballast, rho: float, record: Record) -> None:
    """Write capacities [kg], centres [m] and start fillings [kg] of all tanks there are."""
    rows: list[BlownTank | PumpedTank | Compartment] = [*ballast.blown, *ballast.pumped]
    for row in [*rows, *ballast.compartments]:
        index = TANKS.index(row.name)
        capacity = row.capacity_m3 * rho
        record["capacity"][0, index] = capacity
        for axis, centre in zip("xyz", row.centre_m, strict=True):
            record[axis][0, index] = centre
        record["start"][0, index] = capacity * getattr(row, "start_fill", 0.0)
    for row in ballast.blown:
        index = BLOWN_TANKS.index(row.name)
        record["height"][0, index] = row.height_m
        record["port"][0, index] = row.flood_port_m2
        record["vent_area"][0, index] = row.vent_cm2 * 1e-4
        record["blow_area"][0, index] = row.blow_mm2 * 1e-6
        record["emergency_area"][0, index] = row.emergency_blow_mm2 * 1e-6


def _write_air(ballast: Ballast, record: Record) -> None:
    """Write banks, compressor and the constants of the gas."""
    gas = GAS_CONSTANT * (ballast.air.temperature_c + ZERO_CELSIUS)
    record["gas"] = gas
    # St. Venant's choked nozzle
    exponent = (ADIABATIC_INDEX + 1.0) / (2.0 * (ADIABATIC_INDEX - 1.0))
    record["choked"] = (
        math.sqrt(ADIABATIC_INDEX / gas) * (2.0 / (ADIABATIC_INDEX + 1.0)) ** exponent
    )
    record["compressor_rate"] = ballast.air.compressor_kg_s
    awash = 0.5 * record["hull_diameter"] - record["hull_axis"]
    mast = ballast.air.intake_depth_m
    record["intake_depth"] = awash if mast is None else mast
    for row in ballast.banks:
        index = BANKS.index(row.name)
        record["bank_volume"][0, index] = row.volume_m3
        record["bank_full"][0, index] = row.pressure_mpa * 1e6 * row.volume_m3 / gas


def _write_sea(sea: HullBuoyancy, record: Record) -> None:
    """Write how buoyancy changes with depth."""
    count = len(sea.layer_depth_m)
    record["compressibility"] = sea.compressibility_kg_m
    record["reference_depth"] = sea.reference_depth_m
    record["layers"] = count
    record["layer_depth"][0, :count] = sea.layer_depth_m
    record["layer_density"][0, :count] = sea.layer_kg_m3


@dataclass(frozen=True)
class Method:
    """How a boat is computed: equations, accelerations, angles, integrator and step.

    The words are those of the command line; ``scheme_record`` makes the core's scheme of them.
    """

    equations: str
    rates: str  # "exact" or "lagged"
    trig: str  # "exact" or "report"
    integrator: str  # a name of the scheme module, or "a=...;b=..." of a multistep method
    step: float  # [s]


class Records(NamedTuple):
    """The arguments of the kernels of one boat, in the order that they take."""

    vessel: Record
    compact: Record
    scheme: Record
    state: Record
    scratch: Record

    def copy(self) -> "Records":
        """Return a copy, of plain bytes: numpy copies a record name by name, and slowly."""
        return Records(*(each.view(np.uint8).copy().view(each.dtype) for each in self))


def body_values(file: VesselFile) -> dict[str, float]:
    """Return size, mass and balance [SI] by the core's names."""
    hull = file.hull
    return {
        "rho": file.fluid.rho,
        "g": file.fluid.g,
        "ell": hull.length,
        "mass": hull.mass,
        "weight": hull.weight,
        "buoyancy": hull.buoyancy,
        **dict(zip(("x_g", "y_g", "z_g"), hull.cg, strict=True)),
        **dict(zip(("x_b", "y_b", "z_b"), hull.cb, strict=True)),
        "I_x": hull.Ix,
        "I_y": hull.Iy,
        "I_z": hull.Iz,
        "I_xy": hull.Ixy,
        "I_yz": hull.Iyz,
        "I_xz": hull.Ixz,
    }


def thrust_rows(file: VesselFile) -> tuple[dict[str, float], tuple[float, float, float]]:
    """Return the nine thrust coefficients, missing rows filled by the last, and what eta is.

    The core always has three rows; a file may give one or two. Of two sets the first fills both
    upper rows. What eta is: its two limits [-], and 1 where it is by the whole speed U, 0 by u.
    """
    sets = file.thrust.ahead
    rows = sets if len(sets) == 3 else (sets[0], sets[0], sets[-1])
    lowest = -math.inf
    second = rows[1].eta_min if len(sets) > 1 else lowest
    eta = (rows[0].eta_min, second, float(file.propulsion.eta_speed == "whole"))
    names = {f"{name}{i + 1}": getattr(row, name) for i, row in enumerate(rows) for name in "abc"}
    return names, eta


def compact_coefficients(file: VesselFile, equations: str) -> dict[str, float]:
    """Return the coefficients that the compact set keeps, compensated."""
    factors = file.compensation["basic" if equations == "basic" else "modified"]
    dropped = BASIC_DROPS if equations == "basic" else ()
    kept_names = [*COMPACT_TERMS, *file.compact.extra_terms]
    return {
        name: file.coefficients[name] * factors.get(name, 1.0)
        for name in kept_names
        if name not in dropped
    }


def _control(file: VesselFile) -> dict[str, float]:
    """Return limits, rates and lags [SI] by the vessel record's names."""
    surfaces, propulsion = file.surfaces, file.propulsion
    numbers = {
        "limit_r": math.radians(surfaces.rudder_limit_deg),
        "limit_s": math.radians(surfaces.stern_plane_limit_deg),
        "limit_b": math.radians(surfaces.bow_plane_limit_deg),
        "surface_rate": math.radians(surfaces.rate_deg_s),
        "surface_lag": surfaces.time_constant_s,
        "x_tail": float(surfaces.tail == "x"),
        "telegraph_dead_time": propulsion.dead_time_s,
        "propulsion_lag": propulsion.time_constant_s,
        "u_c_ahead": propulsion.max_ordered_speed_kn * KNOT,
        "u_c_astern": min(propulsion.bells_kn.values()) * KNOT,
    }
    if file.autopilot:
        numbers["speed_integral"] = file.autopilot.speed_integral
        numbers["turning_rate"] = math.radians(file.autopilot.turning_rate_deg_s)
    return numbers


def _write_gains(file: VesselFile, record: Record) -> None:
    """Write the autopilot's schedule [SI] to the vessel record."""
    gains = file.autopilot
    if not gains:
        return
    count = len(gains.speed_kn)
    record["gain_count"] = count
    record["gain_speed"][0, :count] = np.array(gains.speed_kn) * KNOT
    units = {
        "depth_rate": ("depth_rate_m_s", 1.0),
        "depth_acceleration": ("depth_acceleration_m_s2", 1.0),
        "course_rate": ("course_rate_deg_s", math.radians(1.0)),
        "course_acceleration": ("course_acceleration_deg_s2", math.radians(1.0)),
    }
    for index, name in enumerate(vessel.GAINS):
        key, factor = units.get(name, (name, 1.0))
        record["gain"][0, :count, index] = np.array(getattr(gains, key)) * factor


def _geometry(file: VesselFile) -> dict[str, float]:
    """Return where hull, deck and sail are [m] by the vessel record's names.

    What the file does not say is taken from what it says: a sail as high as the deck, a deck half
    a diameter above the axis.
    """
    hull = file.hull
    diameter = hull.diameter or hull.beam or 0.0
    deck = sail = -0.5 * diameter
    if hull.cg_below_sail_top is not None:
        deck = sail = hull.cg[2] - hull.cg_below_sail_top
        if hull.height_to_sail_top is not None and hull.height_to_deck is not None:
            deck = sail + hull.height_to_sail_top - hull.height_to_deck
    x_sail = 0.0
    if hull.cg_from_nose is not None and hull.sail_from_nose is not None:
        x_sail = hull.cg[0] + hull.cg_from_nose - hull.sail_from_nose
    return {"diameter": diameter, "x_sail": x_sail, "z_sail": sail, "z_deck": deck}


def _write_surface(file: VesselFile, record: Record) -> None:
    """Write the tables of the calm surface [SI] to the vessel record."""
    tables = file.free_surface
    if not tables:
        return
    rows, columns = len(tables.rows), len(tables.depth_m)
    area = 0.5 * file.fluid.rho * file.hull.length**2
    record["surface_speeds"], record["surface_depths"] = rows, columns
    record["surface_depth"][0, :columns] = tables.depth_m
    record["surface_Z_w"][0, :columns] = area * np.array(tables.Z_w or 0.0)
    record["surface_M_w"][0, :columns] = area * file.hull.length * np.array(tables.M_w or 0.0)
    for i, row in enumerate(tables.rows):
        record["surface_speed"][0, i] = row.speed_kn * KNOT
        record["surface_Z"][0, i, :columns] = area * np.array(row.Z_star)
        record["surface_M"][0, i, :columns] = area * file.hull.length * np.array(row.M_star)


def _write_strips(file: VesselFile, record: Record) -> None:
    """Write the strips that waves push on; without them they stay those of a usual hull."""
    table = file.wave_strips
    if table:
        along = np.array(table.x_m) / file.hull.length
        masses = (table.displaced_kg, table.added_down_kg, table.added_side_kg)
        record["strips"][0] = vessel.strips(along, *masses)


def read_integrator(text: str) -> scheme.Multistep | scheme.PredictorCorrector:
    """Return the method written ``a=1;b=1.5,-0.5``; ConfigError if it is not one.

    With ``c`` and ``d`` as well it is a pair: they are the a_i and b_i of what corrects.
    """
    try:
        parts = dict(part.split("=") for part in text.split(";"))
        numbers = {name: tuple(map(float, parts[name].split(","))) for name in parts}
    except ValueError:
        numbers = {}
    for name, values in numbers.items():
        if not all(map(math.isfinite, values)):
            raise ConfigError(f"--integrator {text!r}: {name} = {parts[name]}: must be finite")
    if set(numbers) == set("ab"):
        return scheme.Multistep(numbers["a"], numbers["b"])
    if set(numbers) == set("abcd"):
        a, b, c, d = (numbers[name] for name in "abcd")
        return scheme.PredictorCorrector(scheme.Multistep(a, b), scheme.Multistep(c, d))
    raise ConfigError(
        f"--integrator {text!r}: give one of {', '.join(scheme.INTEGRATOR_NAMES)}, or the "
        "coefficients of a "
        "multistep method such as 'a=1;b=1.5,-0.5', with those of its corrector "
        "'a=1;b=1.5,-0.5;c=1;d=0.5,0.5'"
    )


def scheme_record(method: Method) -> Record:
    """Return the scheme of ``method``; ConfigError if its integrator is none."""
    trig = kinematics.EXACT_TRIGONOMETRY
    if method.trig == "report":
        trig = {
            "modified": kinematics.POLYNOMIAL_TRIGONOMETRY,
            "basic": kinematics.LINEAR_TRIGONOMETRY,
        }.get(method.equations, kinematics.EXACT_TRIGONOMETRY)
    equations = {"full": scheme.FULL_EQUATIONS, "longitudinal": scheme.LONGITUDINAL_EQUATIONS}.get(
        method.equations, scheme.COMPACT_EQUATIONS
    )
    record = scheme.new_scheme(method.step, equations, exact=method.rates == "exact", trig=trig)
    set_integrator(record, method.integrator)
    return record


def set_integrator(record: Record, name: str) -> None:
    """Make a scheme integrate by a method's name or coefficients; ConfigError if it is none."""
    if name in scheme.RUNGE_KUTTAS:
        scheme.set_runge_kutta(record, scheme.RUNGE_KUTTAS[name])
        return
    formula = scheme.INTEGRATORS.get(name) or scheme.PAIRS.get(name) or read_integrator(name)
    try:
        if isinstance(formula, scheme.PredictorCorrector):
            scheme.set_pair(record, formula)
        else:
            scheme.set_multistep(record, formula)
    except ValueError as wrong:
        raise ConfigError(f"--integrator {name}: {wrong}") from None


def fit_out(file: VesselFile, method: Method) -> Records:
    """Return the records of a boat at rest at the origin. Weight and balance are its file's."""
    hull = body_values(file)
    rows, eta = thrust_rows(file)
    full = vessel.vessel_record(hull, {**file.coefficients, **rows}, eta)
    for name, value in _control(file).items():
        full[name] = value
    _write_gains(file, full)
    tanks = ballast_record(file)
    for name in tanks.dtype.names or ():
        if name != "whole":
            full[name] = tanks[name]
    for name, value in _geometry(file).items():
        full[name] = value
    _write_surface(file, full)
    _write_strips(file, full)
    write_envelope(file, full)
    write_plant(file, full)
    compact_values = {**compact_coefficients(file, method.equations), **rows}
    boat = state.new_state()
    for name in ("weight", "x_g", "y_g", "z_g"):
        boat[name] = hull[name]
    return Records(
        full,
        vessel.compact_record(hull, compact_values, eta),
        scheme_record(method),
        boat,
        state.new_scratch(),
    )

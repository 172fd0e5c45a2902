"""The members of a study as one fleet, with records, starts and orders together.

Each member flies as ``Submarine`` would fly it, to the bit; a test compares them.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import lru_cache
from typing import Any, Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from trainer.analysis.manoeuvres.flight import MAX_FLIGHT_CYCLES, Conn, Manoeuvre, Mark
from trainer.analysis.manoeuvres.submarine import CONTROL_SURFACES, DEEP_WATER_M
from trainer.analysis.manoeuvres.vehicle import Control
from trainer.analysis.sweep.ensemble import NO_ORDERS, Ensemble, Schedule, boat_of, orders
from trainer.boat.assemble import (
    Method,
    body_values,
    compact_coefficients,
    fit_out,
    scheme_record,
    thrust_rows,
)
from trainer.boat.boat import STATE_OFFSETS, Boat
from trainer.boat.envelope import write_envelope
from trainer.config.boat.vessel import VesselFile
from trainer.config.world.sea import load_sea, sea_settings
from trainer.core.autopilot.autopilot import stand_by_all
from trainer.core.kernel import Numbers, Record
from trainer.core.scheme import equations_alone
from trainer.core.sea.sea import order_sea
from trainer.core.start import level_flight, set_out
from trainer.core.state import STATE
from trainer.core.terms import LENGTH_POWERS
from trainer.core.vessel import COMPACT, VESSEL, compact_record, vessel_record

SURFACE_SENSES: Final = {"rudder": ("N_dr", 1.0), "stern": ("M_ds", 1.0), "bow": ("Z_db", -1.0)}
DEPTH_SURFACES: Final = ("stern", "bow")  # that keep depth


class ScriptLine(NamedTuple):
    """One action of a manoeuvre, done before the tick of that number."""

    tick: int
    verb: str  # "order" or "keep"
    what: str  # control or quantity
    value: float  # SI, of a surface from its neutral angle


class Script(NamedTuple):
    """All actions of a manoeuvre, and its length."""

    lines: tuple[ScriptLine, ...]
    marks: tuple[Mark, ...]
    ticks: int


class Scribe:
    """A vehicle that does not move, and writes down the orders that it gets."""

    name = "scribe"
    length = 1.0
    columns = ("t",)

    def __init__(self, step: float, controls: Mapping[str, Control]) -> None:
        """Begin at the first tick."""
        self.step = step
        self.controls = controls
        self.tick = 0
        self.lines: list[ScriptLine] = []

    def start(self, speed: float) -> None:
        """Begin anew."""
        del speed
        self.tick = 0

    def incline(self, heel: float) -> None:
        """Raise KeyError, because a fleet has no order that heels a boat."""
        raise KeyError(heel)

    def order(self, control: str, value: float) -> None:
        """Write down an order."""
        self.lines.append(ScriptLine(self.tick, "order", control, value))

    def keep(self, quantity: str) -> None:
        """Write down what is to be kept."""
        self.lines.append(ScriptLine(self.tick, "keep", quantity, 0.0))

    def observe(self) -> tuple[float, ...]:
        """Return the time [s]."""
        return (self.tick * self.step,)

    def advance(self) -> None:
        """Advance by a cycle."""
        self.tick += 1


@lru_cache(maxsize=4096)
def script_of(
    manoeuvre: Manoeuvre, step: float, controls: tuple[tuple[str, Control], ...]
) -> Script | None:
    """Return a manoeuvre's script; None if its orders depend on how the vehicle moves."""
    scribe = Scribe(step, dict(controls))
    conn: Any = Conn(scribe)
    try:
        for _ in manoeuvre.schedule(conn):
            scribe.advance()
            conn.look()
            if scribe.tick > MAX_FLIGHT_CYCLES:
                return None
    except KeyError:  # it asks for what the scribe has not
        return None
    if any(line.verb == "keep" and (line.tick or line.what != "depth") for line in scribe.lines):
        return None  # what is kept is as it is then, which is known at the start alone
    return Script(tuple(scribe.lines), tuple(conn.marks), scribe.tick)


class VesselBatch(NamedTuple):
    """Vessels by member, and the sense of a deflection as ``Boat.toward`` has it."""

    vessels: Record
    compacts: Record
    toward: dict[str, Numbers]  # [member] by surface


def toward_of(coefficients: Mapping[str, Any], count: int) -> dict[str, Numbers]:
    """Return the sign of a surface's deflection that turns right or makes it rise."""
    senses = {}
    for surface, (name, sign) in SURFACE_SENSES.items():
        effect = sign * np.broadcast_to(np.asarray(coefficients[name], float), count)
        senses[surface] = np.where(effect == 0.0, 0.0, np.copysign(1.0, effect))
    return senses


def by_coefficients(
    boat: Boat, changes: Mapping[tuple[str, ...], Numbers], count: int
) -> VesselBatch:
    """Return one boat with coefficients, or their factors, that differ from member to member.

    ``changes`` are by the steps of their key, "coefficients" or "compensation" first.
    """
    file, method = boat.file, boat.method
    coefficients: dict[str, Any] = dict(file.coefficients)
    factors: dict[str, dict[str, Any]] = {name: dict(of) for name, of in file.compensation.items()}
    terms = [steps[1] for steps in changes if steps[0] == "coefficients"]
    for steps, numbers in changes.items():
        (coefficients if steps[0] == "coefficients" else factors[steps[1]])[steps[-1]] = numbers
    wide = replace(file, coefficients=coefficients, compensation=factors)
    hull, (rows, eta) = body_values(file), thrust_rows(file)
    vessels = np.zeros(count, VESSEL)
    vessels["whole"] = boat.records.vessel["whole"]
    full = vessel_record(hull, {**coefficients, **rows}, eta)
    for name in set(terms) & set(LENGTH_POWERS):
        vessels[name] = full[name]
    if terms:
        write_envelope(file, vessels)
    values: dict[str, Any] = {**compact_coefficients(wide, method.equations), **rows}
    compacts = compact_record(hull, values, eta)
    return VesselBatch(vessels, compacts, toward_of(coefficients, count))


def by_files(files: Sequence[VesselFile], method: Method) -> VesselBatch:
    """Return boats of their own files."""
    count = len(files)
    vessels, compacts = np.zeros(count, VESSEL), np.zeros(count, COMPACT)
    for i, file in enumerate(files):
        records = fit_out(file, method)
        vessels["whole"][i] = records.vessel["whole"]
        compacts["whole"][i] = records.compact["whole"]
    names = (name for name, _ in SURFACE_SENSES.values())
    effects = {name: [file.coefficients[name] for file in files] for name in names}
    return VesselBatch(vessels, compacts, toward_of(effects, count))


def carries_surface(made: VesselBatch, surface: str) -> NDArray[np.bool_]:
    """Return which members have a surface that has an effect."""
    letter = {"rudder": "r", "stern": "s", "bow": "b"}[surface]
    return np.asarray((made.toward[surface] != 0.0) & (made.vessels[f"limit_{letter}"] > 0.0))


def start_member(boat: tuple[Record, ...], exact: Record, speed: float, calm: Numbers) -> bool:
    """Start a boat at depth in a calm; return whether it flies straight.

    ``speed`` is in m/s, ``exact`` the scheme with the equations alone, ``calm`` what ``order_sea``
    takes.
    """
    vessel, compact, scheme, state, scratch = boat
    c, s, h = vessel[0], state[0], float(scheme["h"][0])
    s.weight, s.x_g, s.y_g, s.z_g = c.weight, c.x_g, c.y_g, c.z_g
    if not level_flight(vessel, compact, exact, state, scratch, speed):
        return False
    s.z, s.seed = DEEP_WATER_M, 1.0
    set_out(*boat)
    stand_by_all(vessel, h, state, scratch)
    s.telegraph_order = s.u_c
    s.sea[1:] = calm[1 : s.sea.size]
    order_sea(vessel, h, 0.0, calm, scratch, state)
    return True


def start_members(
    made: VesselBatch, method: Method, speeds: Numbers, law: float, needs: Sequence[str]
) -> tuple[Ensemble, NDArray[np.bool_]]:
    """Return the fleet started at ``speeds`` [m/s], as ``Submarine.start`` starts each.

    Return also which members can fly straight and have the controls.
    """
    count = made.vessels.size
    made.vessels["torque_limit"] = 0.0  # as a manoeuvre holds its revolutions
    scheme = scheme_record(method)
    exact = equations_alone(scheme)
    exact["exact"] = 1
    calm = load_sea("calm")
    gravities = made.vessels["g"]
    settings = {g: np.array(sea_settings(calm, g)) for g in np.unique(gravities).tolist()}
    fleet = Ensemble(made.vessels, made.compacts, scheme, np.zeros(count, STATE))
    with np.errstate(all="ignore"):
        able = np.array(
            [
                start_member(
                    boat_of(fleet, i), exact, float(speeds[i]), settings[float(gravities[i])]
                )
                for i in range(count)
            ]
        )
    fleet.states["depth_law"] = law
    for control in needs:
        if control in CONTROL_SURFACES:
            able &= carries_surface(made, CONTROL_SURFACES[control][0])
    return fleet, able


def join_scripts(states: Record, made: VesselBatch, scripts: Sequence[Script]) -> Schedule:
    """Return the orders of scripts that differ in numbers alone. ``keep`` acts at the start."""
    surfaces = CONTROL_SURFACES.items()
    neutral = {name: states[f"delta_{letter}"].copy() for name, (_, letter) in surfaces}
    by_hand = np.ones(states.size)
    order_rows: list[tuple[int, int, Numbers]] = []
    for i, line in enumerate(scripts[0].lines):
        numbers = np.array([script.lines[i].value for script in scripts])
        if line.verb == "keep":
            states["ordered_depth"] = states["z"]
            for surface in DEPTH_SURFACES:
                states[f"{surface}_by_hand"][carries_surface(made, surface)] = 0.0
        elif line.what == "engine":
            order_rows.append((line.tick, STATE_OFFSETS["speed_by_hand"], by_hand))
            order_rows.append((line.tick, STATE_OFFSETS["ordered_u_c"], numbers))
        else:
            surface, letter = CONTROL_SURFACES[line.what]
            angle = neutral[line.what] + made.toward[surface] * numbers
            order_rows.append((line.tick, STATE_OFFSETS[f"{surface}_by_hand"], by_hand))
            order_rows.append((line.tick, STATE_OFFSETS[f"ordered_{letter}"], angle))
    if not order_rows:
        return NO_ORDERS
    ticks, offsets, values = zip(*order_rows, strict=True)
    return orders(ticks, offsets, np.array(values).T)

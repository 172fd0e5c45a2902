"""The members of a study as one fleet, with records, starts and orders together.

Each is the boat that ``Submarine`` would be, to the bit; a test holds it.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from trainer.analysis.fleet.ensemble import Fleet, Schedule, orders
from trainer.analysis.manoeuvres.submarine import DEEP, SURFACES
from trainer.analysis.sweep.script import Script
from trainer.analysis.sweep.start import Start, start_fleet
from trainer.boat.assemble import (
    Method,
    body,
    compact_coefficients,
    fit_out,
    scheme_record,
    thrust_rows,
)
from trainer.boat.boat import PLACES, Boat
from trainer.boat.envelope import write_envelope
from trainer.config.sea import load_sea, sea_settings
from trainer.config.vessel import VesselFile
from trainer.core.kernel import Numbers, Record
from trainer.core.scheme import equations_alone
from trainer.core.state import STATE, new_scratch
from trainer.core.terms import POWERS
from trainer.core.vessel import COMPACT, VESSEL, compact_record, vessel_record

SENSES: Final = {"rudder": ("N_dr", 1.0), "stern": ("M_ds", 1.0), "bow": ("Z_db", -1.0)}
KEPT: Final = (("stern", "s"), ("bow", "b"))  # what keeps depth


class Made(NamedTuple):
    """Vessels by member, and the sense of a deflection as ``Boat.toward`` has it."""

    vessels: Record
    compacts: Record
    toward: dict[str, Numbers]  # [member] by surface


@dataclass(frozen=True)
class Ready:
    """A fleet at its start. ``fit`` tells which members can fly straight and have the controls."""

    fleet: Fleet
    toward: dict[str, Numbers]
    fit: NDArray[np.bool_]


def toward_of(coefficients: Mapping[str, Any], count: int) -> dict[str, Numbers]:
    """Return the sign of a surface's deflection that turns right or makes it rise."""
    found = {}
    for surface, (name, sign) in SENSES.items():
        effect = sign * np.broadcast_to(np.asarray(coefficients[name], float), count)
        found[surface] = np.where(effect == 0.0, 0.0, np.copysign(1.0, effect))
    return found


def by_coefficients(boat: Boat, changes: Mapping[tuple[str, ...], Numbers], count: int) -> Made:
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
    hull, (rows, eta) = body(file), thrust_rows(file)
    vessels = copies(boat.records.vessel, VESSEL, count)
    full = vessel_record(hull, {**coefficients, **rows}, eta)
    for name in set(terms) & set(POWERS):
        vessels[name] = full[name]
    if terms:
        write_envelope(file, vessels)
    kept: dict[str, Any] = {**compact_coefficients(wide, method.equations), **rows}
    compacts = compact_record(hull, kept, eta)
    return Made(vessels, compacts, toward_of(coefficients, count))


def by_files(files: Sequence[VesselFile], method: Method) -> Made:
    """Return boats of their own files."""
    count = len(files)
    vessels, compacts = np.zeros(count, VESSEL), np.zeros(count, COMPACT)
    toward = {surface: np.zeros(count) for surface in SENSES}
    for i, file in enumerate(files):
        records = fit_out(file, method)
        vessels["whole"][i], compacts["whole"][i] = (
            records.vessel["whole"],
            records.compact["whole"],
        )
        for surface, signs in toward_of(file.coefficients, 1).items():
            toward[surface][i] = signs[0]
    return Made(vessels, compacts, toward)


def copies(record: Record, kind: np.dtype[Any], count: int) -> Record:
    """Return ``count`` copies of one record."""
    found = np.zeros(count, kind)
    found["whole"] = record["whole"]
    return found


def carries_surface(made: Made, surface: str) -> NDArray[np.bool_]:
    """Return which members have a surface that does something."""
    letter = {"rudder": "r", "stern": "s", "bow": "b"}[surface]
    return np.asarray((made.toward[surface] != 0.0) & (made.vessels[f"limit_{letter}"] > 0.0))


def start_members(
    made: Made, method: Method, speeds: Numbers, law: float, needs: Sequence[str]
) -> Ready:
    """Return the fleet started at ``speeds`` [m/s], as ``Submarine.start`` starts each."""
    count = made.vessels.size
    made.vessels["torque_limit"] = 0.0  # as a manoeuvre holds its revolutions
    scheme = scheme_record(method)
    exact = equations_alone(scheme)
    exact["exact"] = 1
    calm = load_sea("calm")
    gravities = np.unique(made.vessels["g"])
    if len(gravities) > 1:
        gravities = made.vessels["g"]
    settings = np.array([sea_settings(calm, float(g)) for g in gravities])
    fleet = Fleet(made.vessels, made.compacts, scheme, np.zeros(count, STATE))
    fit = np.zeros(count)
    with np.errstate(all="ignore"):
        start_fleet(fleet, exact, Start(speeds, DEEP, law, settings), new_scratch(), fit)
    able = fit > 0.0
    for control in needs:
        if control in SURFACES:
            able &= carries_surface(made, SURFACES[control][0])
    return Ready(fleet, made.toward, able)


def join_scripts(ready: Ready, made: Made, scripts: Sequence[Script]) -> Schedule:
    """Return the orders of scripts alike but for their numbers. What is kept is kept at once."""
    states = ready.fleet.states
    neutral = {name: states[f"delta_{letter}"].copy() for name, (_, letter) in SURFACES.items()}
    ticks: list[int] = []
    places: list[int] = []
    values: list[Numbers] = []

    def put(tick: int, name: str, numbers: Any) -> None:
        ticks.append(tick)
        places.append(PLACES[name])
        values.append(np.broadcast_to(np.asarray(numbers, float), states.size))

    for i, line in enumerate(scripts[0].lines):
        numbers = np.array([script.lines[i].value for script in scripts])
        if line.verb == "keep":
            states["ordered_depth"] = states["z"]
            for surface, _ in KEPT:
                states[f"{surface}_by_hand"][carries_surface(made, surface)] = 0.0
        elif line.what == "engine":
            put(line.tick, "speed_by_hand", 1.0)
            put(line.tick, "ordered_u_c", numbers)
        else:
            surface, letter = SURFACES[line.what]
            put(line.tick, f"{surface}_by_hand", 1.0)
            angle = neutral[line.what] + made.toward[surface] * numbers
            put(line.tick, f"ordered_{letter}", angle)
    return orders(ticks, places, np.array(values).T if values else [])

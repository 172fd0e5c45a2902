"""Members fly a manoeuvre in fleets where orders are known, else one by one.

A member is one run of a study. ``cli/workshop/subjects`` chooses this module for a study with a
table [manoeuvre]. A fleet computes many boats at once, but only by orders that are known before; a
zig-zag waits for an angle, so its boats fly one by one.
"""

from collections import defaultdict
from collections.abc import Iterable, Mapping
from dataclasses import asdict, dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from trainer.analysis.manoeuvres.catalogue import PARAMETERS, adjust_manoeuvre, find_manoeuvre
from trainer.analysis.manoeuvres.flight import Flight, Manoeuvre, fly_manoeuvre
from trainer.analysis.manoeuvres.submarine import (
    BOAT_COLUMNS,
    DEPTH_LAWS,
    MAX_PITCH_RAD,
    Rig,
    Submarine,
)
from trainer.analysis.sweep import fleets
from trainer.analysis.sweep.ensemble import fly_members
from trainer.analysis.sweep.fleets import Script, script_of
from trainer.analysis.sweep.job import Batch, Output, asked_of, fly_each, member_values, read_off
from trainer.analysis.sweep.records import ManoeuvreTable
from trainer.analysis.sweep.study import Study, method_of
from trainer.boat.assemble import Method
from trainer.config.boat.coefficients import COEFFICIENT_QUANTITY, FACTOR_QUANTITY
from trainer.config.boat.vessel import VesselFile, read_vessel
from trainer.config.files import ConfigError, Position
from trainer.config.schema import read_record
from trainer.config.ship.series import Series
from trainer.core.autopilot.steering import REPORT_LAW
from trainer.units import KNOT

if TYPE_CHECKING:
    from trainer.core.kernel import Numbers

FLEET_CHUNK_MEMBERS, SINGLE_CHUNK_MEMBERS = 512, 16  # members of a chunk
UNTIMED_COLUMNS: Final = BOAT_COLUMNS[1:]  # all but the time
MAX_FLIGHTS_HELD: Final = 128  # members whose flights are in memory at once
# plausible only within the hull: these go through the whole check of a vessel file
CHECKED_COEFFICIENTS: Final = ("X_udot", "Y_vdot", "Z_wdot", "K_pdot", "M_qdot", "N_rdot")
FIELD_LIMITS: Final = {
    "coefficients": COEFFICIENT_QUANTITY.limits,
    "compensation": FACTOR_QUANTITY.limits,
}


@dataclass(frozen=True)
class MemberCase:
    """One member: a boat, how it is computed and handled, and what it flies."""

    file: VesselFile
    method: Method
    rig: Rig
    table: ManoeuvreTable


def case_of(study: Study, drawn: Mapping[str, Any]) -> MemberCase:
    """Return the member with these numbers; ConfigError if there can be no such boat."""
    tables, file = study.varied(drawn), study.file
    if file is None:
        raise ConfigError(f"{study.path.name}: has no boat")
    if any(variable.steps[0] == "vessel" for variable in study.variables):
        file = read_vessel(tables["vessel"], file.text, file.path)
    position = Position(study.path.name, "manoeuvre")
    table = read_record(ManoeuvreTable, tables["manoeuvre"], position, ())
    rig = Rig(table.controls or "own", table.trim or "own", table.law or "trainer")
    return MemberCase(file, method_of(study.method, file), rig, table)


def manoeuvre_of(table: ManoeuvreTable, vehicle: Any) -> Manoeuvre:
    """Return the manoeuvre of a study for a vehicle; ConfigError if it cannot fly it."""
    own, keys = asdict(table), PARAMETERS.items()
    parameters = {name: own[key] for name, key in keys if own[key] is not None}
    try:
        manoeuvre = adjust_manoeuvre(table.name, vehicle, parameters)
    except ConfigError as wrong:
        raise ConfigError(f"[manoeuvre] {str(wrong).removeprefix('--')}") from None
    if table.depth_kept is None:
        return manoeuvre
    if not hasattr(manoeuvre, "keep") or "keep" not in asdict(manoeuvre):
        raise ConfigError(f"[manoeuvre] depth_kept: {table.name} has no such choice")
    return replace(manoeuvre, keep=("depth",) * table.depth_kept)  # type: ignore[call-arg]


def speed_of(table: ManoeuvreTable, usual: float) -> float:
    """Return the speed [m/s] that a member begins with; ConfigError for a speed at rest.

    It is ``usual`` [kn] if the study has none.
    """
    if not find_manoeuvre(table.name).from_rest:
        return (usual if table.speed_kn is None else table.speed_kn) * KNOT
    if table.speed_kn is not None:
        raise ConfigError("[manoeuvre] speed_kn: this manoeuvre starts from rest")
    return 0.0


def fly_case(case: MemberCase) -> tuple[Manoeuvre, Flight]:
    """Return the manoeuvre of a case and its flight; ConfigError if it cannot begin."""
    boat = Submarine(case.file, case.method, case.rig)
    manoeuvre = manoeuvre_of(case.table, boat)
    speed = speed_of(case.table, case.file.run.start_speed_kn)
    return manoeuvre, fly_manoeuvre(boat, manoeuvre, speed)


class ManoeuvreSubject:
    """The members of a study that fly a manoeuvre."""

    def __init__(self, study: Study) -> None:
        """Take the study; ConfigError if its middle member cannot fly."""
        self.study = study
        self.middle = case_of(study, study.draws.middle())
        self.trial, self.flight = fly_case(self.middle)
        self.boat = Submarine(self.middle.file, self.middle.method, self.middle.rig)

    @cached_property
    def outputs(self) -> tuple[Output, ...]:
        """Return the outputs of each member; ConfigError if the study asks for another."""
        return asked_of(self.study, self.flight, self.trial.measures(self.flight))

    @cached_property
    def together(self) -> bool:
        """Return whether members are flown in fleets."""
        rig = self.middle.rig
        alike = rig.controls == "own" and rig.trim == "own" and not self.trial.from_rest
        return alike and self._script(self.trial) is not None

    @property
    def chunk(self) -> int:
        """Return how many members are flown, and kept, at once."""
        return FLEET_CHUNK_MEMBERS if self.together else SINGLE_CHUNK_MEMBERS

    def _script(self, manoeuvre: Manoeuvre) -> Script | None:
        return script_of(manoeuvre, self.middle.method.step, tuple(self.boat.controls.items()))

    def batch(self, first: int, count: int) -> Batch:
        """Return the results of ``count`` members from ``first`` on."""
        done: dict[int, list[float]] = {}
        if self.together:
            drawn = self.study.draws.drawn(first, count)
            for begin in range(0, count, MAX_FLIGHTS_HELD):
                size = min(MAX_FLIGHTS_HELD, count - begin)
                part = {name: values[begin : begin + size] for name, values in drawn.items()}
                cases, groups = self._cases(part, size), defaultdict(list)
                for i, (_, manoeuvre) in cases.items():
                    if (script := self._script(manoeuvre)) is not None:
                        form = tuple(line[:3] for line in script.lines)
                        groups[form, script.ticks].append(i)
                for members in groups.values():
                    done |= {begin + i: x for i, x in self._flown(part, cases, members)}
        return fly_each(self.study.draws, first, count, len(self.outputs), self._alone, done)

    def _alone(self, drawn: Mapping[str, Any], _seed: int) -> list[float]:
        """Return the numbers of one member flown by itself; ConfigError why there are none."""
        manoeuvre, flight = fly_case(case_of(self.study, drawn))
        if flight.lost:
            raise ConfigError(flight.lost)
        return read_off(self.outputs, flight, manoeuvre.measures(flight))

    def _cases(self, drawn: dict[str, Any], count: int) -> dict[int, tuple[MemberCase, Manoeuvre]]:
        """Return case and manoeuvre of the members for which there can be any.

        Where nothing but coefficients varies, all cases are the middle one: the coefficients of the
        members are not in them.
        """
        if self._by_coefficients:
            good = np.ones(count, bool)
            for variable in self.study.variables:
                limits = FIELD_LIMITS[str(variable.steps[1])]
                values = variable.value(drawn[variable.row.name])
                good &= (limits.low <= values) & (values <= limits.high)
            return {int(i): (self.middle, self.trial) for i in np.flatnonzero(good)}
        cases = {}
        for i in range(count):
            try:
                case = case_of(self.study, member_values(drawn, i))
                boat = self.boat if case.file is self.middle.file else None
                boat = boat or Submarine(case.file, case.method, case.rig)
                cases[i] = case, manoeuvre_of(case.table, boat)
            except ConfigError:
                continue  # it is told when the member is tried alone
        return cases

    @cached_property
    def _by_coefficients(self) -> bool:
        """Return whether nothing but coefficients varies, and none of CHECKED_COEFFICIENTS."""
        return all(
            len(steps) > 1
            and steps[0] == "vessel"
            and steps[1] in FIELD_LIMITS
            and steps[-1] not in CHECKED_COEFFICIENTS
            for steps in (variable.steps for variable in self.study.variables)
        )

    def _flown(
        self,
        drawn: dict[str, Any],
        cases: dict[int, tuple[MemberCase, Manoeuvre]],
        members: list[int],
    ) -> Iterable[tuple[int, list[float]]]:
        """Yield index and numbers of members that fly well, whose scripts are alike."""
        own_cases = [cases[i] for i in members]
        case = own_cases[0][0]
        written = [script for _, each in own_cases if (script := self._script(each)) is not None]
        if self._by_coefficients:
            changes: dict[tuple[str, ...], Numbers] = {}
            for variable in self.study.variables:
                numbers = np.asarray(variable.value(drawn[variable.row.name][members]))
                changes[tuple(map(str, variable.steps[1:]))] = numbers
            made = fleets.by_coefficients(self.boat.boat, changes, len(members))
        else:
            made = fleets.by_files([one.file for one, _ in own_cases], case.method)
        usual = [(one.table, one.file.run.start_speed_kn) for one, _ in own_cases]
        speeds = np.array([speed_of(*pair) for pair in usual])
        law = DEPTH_LAWS[case.rig.law]
        if not self.boat.boat.automatic:
            law = max(law, REPORT_LAW)  # without gains the report's
        fleet, able = fleets.start_members(made, case.method, speeds, law, self.trial.needs)
        schedule = fleets.join_scripts(fleet.states, made, written)
        flight = fly_members(fleet, schedule, written[0].ticks, UNTIMED_COLUMNS)
        t = case.method.step * np.arange(written[0].ticks + 1.0)
        steep = np.abs(flight.rows[:, :, UNTIMED_COLUMNS.index("theta")]) > MAX_PITCH_RAD
        good = able & (flight.lost < 0) & ~steep.any(axis=1)
        named = Path(case.file.name)
        for i in np.flatnonzero(good):
            each, manoeuvre = own_cases[i]
            columns = {"t": t, **dict(zip(UNTIMED_COLUMNS, flight.rows[i].T, strict=True))}
            speed, length, step = float(speeds[i]), each.file.hull.length, each.method.step
            seen = Flight(speed, length, step, Series(named, columns), written[i].marks, "")
            yield members[i], read_off(self.outputs, seen, manoeuvre.measures(seen))

"""Members that fly an exercise: seas, casualties and scheduled orders, as ``trainer run`` does.

A member is one run of a study. ``cli/workshop/subjects`` chooses this module for a study with a
table [exercise]. Nobody is aboard: only what the exercise itself orders moves the boat.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Any, Final

from trainer.analysis.manoeuvres.flight import Flight
from trainer.analysis.sweep.job import Batch, Output, asked_of, fly_each, read_off
from trainer.analysis.sweep.study import Study, method_of
from trainer.config.boat.vessel import read_vessel
from trainer.config.exercise.exercise import read_exercise
from trainer.config.files import ConfigError
from trainer.config.ship.series import Series
from trainer.config.world.sea import load_sea
from trainer.debrief.marks.rehearsal import ByReference
from trainer.debrief.marks.rehearsal import Flight as UnderWay
from trainer.io.orders.words import BOAT_ORDERS, CREW_TALK
from trainer.io.tables import MOTION_COLUMNS
from trainer.session.past.plan import Plan, into_hand

CHUNK_MEMBERS: Final = 16  # members flown by a process before they are kept
STATE_COLUMNS: Final = tuple("tick" if name == "t" else name for name in MOTION_COLUMNS)


@dataclass(frozen=True)
class Outing:
    """One exercise flown, and the first order that the boat refused, "" if none."""

    flight: Flight
    refused: str


def plan_of(study: Study, drawn: Mapping[str, Any], seed: int) -> Plan:
    """Return the plan of one member; ConfigError if its tables make no exercise."""
    tables, file = study.varied(drawn), study.file
    if file is None:
        raise ConfigError(f"{study.path.name}: has no boat")
    if any(variable.steps[0] == "vessel" for variable in study.variables):
        file = read_vessel(tables["vessel"], file.text, file.path)
    exercise = read_exercise(tables["exercise"], study.path)
    duration = exercise.heading.duration_s
    if duration is None:
        raise ConfigError(f"{study.path.name}: [exercise] lacks duration_s")
    schedule = [
        scheduled
        for scheduled in (*into_hand(exercise, file), *exercise.schedule_of(seed))
        if scheduled.order.name not in CREW_TALK - BOAT_ORDERS  # said to people, it moves nothing
    ]
    said, table = exercise.heading, study.method
    study_fields = {  # the study's word over the exercise's
        key: getattr(table, key) or getattr(said, key)
        for key in ("equations", "rates", "integrator", "step_s")
    }
    late = [each for each in schedule if each.order.name not in BOAT_ORDERS]
    if late:
        raise ConfigError(f"{late[0].order.text}: has no place in a study: it is about time")
    return Plan(
        file=file,
        method=method_of(replace(table, **study_fields), file),
        sea=exercise.sea or load_sea("calm"),
        seed=seed,
        duration=duration,
        title=exercise.heading.name,
        briefing=exercise.heading.briefing,
        initial=exercise.initial,
        schedule=sorted(schedule, key=lambda entry: entry.seconds),
        casualties=exercise.casualties,
        armed=exercise.armed,
        limits=exercise.limits,
        scores=(),
        world=exercise.world,
    )


def go_out(plan: Plan) -> Outing:
    """Return the exercise flown from its start to its end; ConfigError if it cannot begin."""
    under_way = UnderWay(plan, plan.launch_boat(), ByReference(), STATE_COLUMNS)
    under_way.fly_schedule()
    refused = [each for each in under_way.journal.entries if each.accepted is False]
    columns, step = under_way.rows.columns(), plan.method.step
    motion = {
        name: columns[kept].copy() for name, kept in zip(MOTION_COLUMNS, STATE_COLUMNS, strict=True)
    }
    motion["t"] *= step  # the state counts ticks
    series = Series(Path(plan.file.name), motion)
    speed = float(motion["u"][0])
    flight = Flight(speed, plan.file.hull.length, step, series, (), under_way.lost)
    why = f"{refused[0].text}: refused: {refused[0].answer}" if refused else ""
    return Outing(flight, why)


class ExerciseSubject:
    """The members of a study that fly an exercise."""

    chunk = CHUNK_MEMBERS

    def __init__(self, study: Study) -> None:
        """Take the study; ConfigError if its middle member cannot fly, or is refused an order."""
        self.study = study
        seed = int(study.draws.seeds(0, 1)[0])
        self.trial = go_out(plan_of(study, study.draws.middle(), seed))
        if self.trial.refused:
            raise ConfigError(f"{study.path.name}: {self.trial.refused}")
        for variable in study.variables:
            for word in variable.row.values or ():
                if isinstance(word, str):  # each is read, so that all who fly know it
                    plan_of(study, {**study.draws.middle(), variable.row.name: word}, seed)

    @cached_property
    def outputs(self) -> tuple[Output, ...]:
        """Return the outputs of each member; ConfigError if the study asks for another."""
        return asked_of(self.study, self.trial.flight, [])

    def batch(self, first: int, count: int) -> Batch:
        """Return the results of ``count`` members from ``first`` on."""
        return fly_each(self.study.draws, first, count, len(self.outputs), self._flown)

    def _flown(self, drawn: dict[str, Any], seed: int) -> list[float]:
        """Return the numbers of one member; ConfigError why there are none."""
        outing = go_out(plan_of(self.study, drawn, seed))
        if outing.flight.lost or outing.refused:
            raise ConfigError(outing.flight.lost or outing.refused)
        return read_off(self.outputs, outing.flight, [])

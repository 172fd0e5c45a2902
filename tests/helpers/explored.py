"""Flights of shipped exercises by crews with a fault, and what could still be earned in them."""

from functools import cache, partial
from typing import Any

from helpers.givers import journalled
from helpers.sessions import start_plan
from trainer.boat.reference_crew import CrewReaction
from trainer.debrief.attainable.explorer import RunExplorer
from trainer.debrief.marks.judgement import judge_run, plain_marks
from trainer.debrief.marks.rehearsal import Departure, Rehearsal, fly, fly_rehearsal
from trainer.io.recording.facts import GiverKind
from trainer.session.past.options import RunOptions
from trainer.session.past.plan import Plan, plan_run


@cache
def plan_of(name: str) -> Plan:
    return plan_run(RunOptions(exercise=name)).alone()


@cache
def nobody_of(name: str) -> dict[str, float]:
    return plain_marks(fly_rehearsal(plan_of(name)).trajectory, plan_of(name))


@cache
def by_crew(name: str) -> Rehearsal:
    return fly_rehearsal(plan_of(name), plan_of(name).crew)


def explored(name: str, run: Rehearsal) -> RunExplorer:
    plan = plan_of(name)
    judge = partial(judge_run, plan=plan, nobody=nobody_of(name))
    explorer = RunExplorer(plan, run.trajectory, judge)
    explorer.fly_again()
    return explorer


def planted(name: str, seconds: float, text: str, without: str = "") -> Rehearsal:
    """Return the reference crew's run with one order more, and perhaps one less."""
    plan = plan_of(name)
    boat = start_plan(plan)
    given = [each for each in by_crew(name).trajectory.orders if each.text != without]
    orders: dict[int, list[Any]] = {}
    more = [journalled(9000, round(2 * seconds), "panel", text, "")] if text else []
    for entry in (*given, *more):
        orders.setdefault(entry.tick, []).append(entry)
    return fly(plan, Departure(0, boat.records.state.copy()), orders)[0]


def with_fault(name: str, right: str, wrong: str | None, late: float) -> Rehearsal:
    """Return the reference crew's run with an order given otherwise, later [s] or not at all."""
    plan = plan_of(name)
    given = by_crew(name).trajectory.orders
    own = (each for each in given if each.text == right)
    due = next(each for each in own if each.giver.kind is GiverKind.REFERENCE)
    fault = [journalled(9000, due.tick + round(2 * late), "panel", wrong, "")] if wrong else []
    orders: dict[int, list[Any]] = {}
    for entry in (*(each for each in given if each is not due), *fault):
        orders.setdefault(entry.tick, []).append(entry)
    boat = start_plan(plan)
    return fly(plan, Departure(0, boat.records.state.copy()), orders)[0]


def late(name: str, seconds: float) -> Rehearsal:
    """Return the run of the reference crew, slower by some seconds in all it does."""
    return fly_rehearsal(plan_of(name), plan_of(name).crew, CrewReaction(late=seconds))


def with_nobody_else(name: str, seconds: float, text: str) -> Rehearsal:
    """Return a run in which nobody gives any order but one."""
    plan = plan_of(name)
    boat = start_plan(plan)
    alone = journalled(9000, round(2 * seconds), "panel", text, "")
    orders: dict[int, list[Any]] = {}
    for entry in (*fly_rehearsal(plan).trajectory.orders, alone):
        orders.setdefault(entry.tick, []).append(entry)
    return fly(plan, Departure(0, boat.records.state.copy()), orders)[0]

"""What the texts of an exercise say is flown: stated figures, steps of a lesson.

``trainer exercise check`` calls it. A text that says "level within 90 seconds" goes wrong unseen
when the boat changes; its row in [[stated]] is flown by nobody or by the reference crew. The steps
are flown by newcomers who do exactly what they say, because a step that they cannot end would keep
a trainee for ever. They type the orders in backquotes of a step's text, in their order, one nearly
at once when the step has begun, one after a long look.
"""

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from trainer.boat.boat import Boat
from trainer.boat.due_orders import obey_all, orders_due
from trainer.boat.quantities import is_met
from trainer.config.exercise.stated import StatedValue
from trainer.config.exercise.steps import Step
from trainer.config.files import Position
from trainer.core.surfaces import SURFACES
from trainer.debrief.marks.rehearsal import Rehearsal, fly_rehearsal
from trainer.debrief.passage.trajectory import Trajectory
from trainer.session.exercise.exercise import LossMonitor
from trainer.session.past.plan import Plan

READING_TIMES_S: Final = (0.5, 2.0, 4.0, 8.0)  # [s] until each newcomer types; an estimate


@dataclass(frozen=True)
class StatedFigure:
    """One stated figure and its flight."""

    stated: StatedValue
    flown: float | None  # [s] or in the quantity's unit; None: it did not come, or cannot be flown
    tolerance: float  # in the unit of ``flown``

    @property
    def holds(self) -> bool:
        """Return whether the boat does what the text says."""
        return self.flown is not None and abs(self.flown - self.stated.target) <= self.tolerance

    @property
    def difference(self) -> str:
        """Return in words how the flown figure differs from the stated one."""
        stated, row = self.stated, self.stated.row
        what = row.when if row.when is not None else f"{row.measure} {row.quantity}"
        by = "nobody aboard" if row.by == "nobody" else "the reference crew"
        flown = "never so" if self.flown is None else f"{self.flown:.4g} {stated.unit}"
        sentence = f"flown by {by}, {what} is {flown}, not {stated.target:g} {stated.unit} within"
        return f"{sentence} {self.tolerance:.3g}: correct the text and its row"


def fly_stated(
    plan: Plan, stated: tuple[StatedValue, ...], flights: Mapping[str, Rehearsal]
) -> list[StatedFigure]:
    """Return stated figures flown. ``flights`` has flights by nobody and the crew made before."""
    flights = dict(flights)
    figures = []
    for entry in stated:
        order_words = (f", {order.seconds:g} {order.order.text}" for order in entry.orders)
        way = entry.row.by + "".join(order_words)
        if way not in flights:
            schedule = sorted([*plan.schedule, *entry.orders], key=lambda order: order.seconds)
            crew = plan.crew if entry.row.by == "crew" else None
            flights[way] = fly_rehearsal(replace(plan, schedule=schedule), crew)
        trajectory = flights[way].trajectory
        step = trajectory.boat.method.step if entry.measured is None else 0.0
        figures.append(
            StatedFigure(entry, _measured(entry, trajectory), max(entry.tolerance, step))
        )
    return figures


def _measured(stated: StatedValue, trajectory: Trajectory) -> float | None:
    """Return the figure of the boat's flight, None if it never comes to one."""
    row, measured = stated.row, stated.measured
    names = [condition.quantity for condition in stated.conditions]
    names += [measured.name] if measured else []
    if not all(trajectory.has(name) for name in names):
        return None
    if measured is None:
        held = trajectory.between(row.from_s, row.to_s)
        for condition in stated.conditions:
            held &= trajectory.holds(condition)
        return float(trajectory.seconds[np.argmax(held)]) if held.any() else None
    window = trajectory.between(row.from_s, row.to_s)
    if row.measure == "value":
        window = trajectory.between(row.at_s, row.at_s)
    values = stated.target + trajectory.off(measured, stated.target)[window]
    if values.size == 0:
        return None
    return float(values.max() if row.measure == "highest" else values.min())


@dataclass(frozen=True)
class StepFlight:
    """The flight of one step: its time [s] and end, what lost it, orders refused."""

    seconds: float
    done: bool
    lost: str = ""
    refused: tuple[tuple[str, str], ...] = ()


def fly_steps(plan: Plan, boat: Boat, reading_s: float) -> list[StepFlight]:
    """Return how each step of a plan goes, flown by a newcomer. The last one may fail.

    ``boat`` is launched for the plan, and is where the steps have led it afterwards. ``reading_s``
    [s] after a step has begun its orders are typed.
    """
    guards = [LossMonitor(each, boat.ticks_in(each.seconds)) for each in plan.lost]
    due = orders_due(boat, plan.schedule)
    flights: list[StepFlight] = []
    for step in plan.steps:
        begun, held, refused = boat.time, 0, obey_all(boat, step.given)
        typed = done = False
        lost: list[str] = []
        while not (done or lost) and boat.time - begun < step.row.within_s:
            obey_all(boat, due.get(boat.ticks, ()))
            if not typed and boat.time - begun >= reading_s:
                typed = True
                refused += obey_all(boat, step.typed)
            boat.tick()
            lost = [each.loss.text for each in guards if each.look(boat)]
            holds = all(is_met(each, boat) for each in step.conditions)
            held = held + 1 if holds else 0
            done = holds and held * boat.method.step > step.row.for_s
        seconds, why = boat.time - begun, "".join(lost[:1])
        flights.append(StepFlight(seconds, done and not why, why, tuple(refused)))
        if not flights[-1].done:
            break
    return flights


def _beyond(plan: Plan, step: Step, number: int, position: Position) -> Iterator[str]:
    """Yield the conditions of a step that ask a surface for more than this boat gives."""
    boat = Boat(plan.file, plan.method)
    for each in step.conditions:
        if each.quantity not in SURFACES:
            continue
        surface = each.quantity
        most = float(boat.vessel[f"limit_{SURFACES[surface]}"]) if boat.toward[surface] else 0.0
        asked = each.sense * each.threshold
        if asked > most or (each.strict and asked == most):
            why = f"this boat's {surface} goes to {math.degrees(most):g} deg: it never ends"
            yield position.inside(f"steps[{number}]").wrong("when", each.text, why)


def step_problems(plan: Plan, position: Position) -> Iterator[str]:
    """Yield what keeps a trainee from the end of a lesson."""
    beyond = [
        text for i, step in enumerate(plan.steps) for text in _beyond(plan, step, i, position)
    ]
    if beyond:
        yield from beyond
        return
    for reading_s in READING_TIMES_S if plan.steps else ():
        problems = list(_flight_problems(plan, reading_s, position))
        yield from problems
        if problems:
            return


def _flight_problems(plan: Plan, reading_s: float, position: Position) -> Iterator[str]:
    """Yield what keeps one newcomer from the end of a lesson."""
    flights = fly_steps(plan, plan.launch_boat(), reading_s)
    took = sum(flight.seconds for flight in flights)
    if plan.duration is not None and took > plan.duration:
        late = f"ends before its steps, which take a newcomer {took:g} s: leave duration_s out"
        yield position.wrong("duration_s", plan.duration, late)
    for i, flight in enumerate(flights):
        inside, row = position.inside(f"steps[{i}]"), plan.steps[i].row
        for text, why in flight.refused:
            yield inside.wrong("text", text, f"the boat refuses it: {why}")
        if not flight.done:
            whose = f"flown by a newcomer who does what the texts say, {reading_s:g} s later"
            why = f"{flight.lost} loses" if flight.lost else f"not within {row.within_s:g} s"
            yield inside.problem(
                f"when: never ends, {whose}: {why}; have the text say the orders, in backquotes"
            )

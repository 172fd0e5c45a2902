"""A newcomer who does exactly what the steps of a lesson say, and nothing else.

``trainer exercise check`` has him fly a lesson, because a step that he cannot end would keep a
trainee for ever. He types the orders in backquotes of a step's text, in their order, some seconds
after the step has begun.
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Final

from trainer.boat.boat import Boat
from trainer.boat.helm import obey_order
from trainer.config.files import Position
from trainer.config.steps import Step
from trainer.core.surfaces import SURFACES
from trainer.io.orders.grammar import Order, Refused
from trainer.io.orders.table import BOAT_ORDERS
from trainer.session.exercise import is_met
from trainer.session.plan import Plan

READING_TIME_S: Final = 6.0  # [s] until he types; an estimate


@dataclass(frozen=True)
class StepFlight:
    """The flight of one step: its time [s], its end, and the orders refused."""

    seconds: float
    done: bool
    refused: tuple[tuple[str, str], ...] = ()


def fly_steps(plan: Plan) -> list[StepFlight]:
    """Return how each step of a plan goes, flown by the newcomer. The last one may fail."""
    boat = plan.launch_boat()
    timed = iter([*plan.schedule])
    coming = next(timed, None)
    flights: list[StepFlight] = []
    for step in plan.steps:
        begun, held, refused = boat.time, 0, list(_refusals(boat, step.given))
        typed = False
        done = False
        while not done and boat.time - begun < step.row.within_s:
            while coming and coming.seconds <= boat.time:
                obey_order(boat, coming.order)
                coming = next(timed, None)
            if not typed and boat.time - begun >= READING_TIME_S:
                typed = True
                refused += _refusals(boat, step.typed)
            boat.tick()
            holds = all(is_met(each, boat) for each in step.conditions)
            held = held + 1 if holds else 0
            done = holds and held * boat.method.step > step.row.for_s
        flights.append(StepFlight(boat.time - begun, done, tuple(refused)))
        if not done:
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


def _refusals(boat: Boat, orders: tuple[Order, ...]) -> Iterator[tuple[str, str]]:
    """Have the boat obey; yield each order that it refuses, and why."""
    for order in orders:
        answer = obey_order(boat, order) if order.name in BOAT_ORDERS else ""
        if isinstance(answer, Refused):
            yield order.text, answer.reason


def step_problems(plan: Plan, position: Position) -> Iterator[str]:
    """Yield what keeps a trainee from the end of a lesson."""
    beyond = [
        text for i, step in enumerate(plan.steps) for text in _beyond(plan, step, i, position)
    ]
    if beyond:
        yield from beyond
        return
    for i, flight in enumerate(fly_steps(plan)):
        inside, row = position.inside(f"steps[{i}]"), plan.steps[i].row
        for text, why in flight.refused:
            yield inside.wrong("text", text, f"the boat refuses it: {why}")
        if not flight.done:
            whose = "flown by a newcomer who does what the texts say"
            yield inside.problem(
                f"when: never ends, {whose}: not within {row.within_s:g} s; "
                "have the text say the orders, in backquotes"
            )

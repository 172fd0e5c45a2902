"""Recordings made without a session: an exercise flown, with orders of a crew at their times."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from helpers.givers import giver_at
from helpers.orders import read_order
from helpers.sessions import begin_run
from trainer.boat.due_orders import entries_due
from trainer.boat.helm import obey_order
from trainer.debrief.marks.rehearsal import last_tick
from trainer.io.orders.grammar import Order, Refused, Reply
from trainer.io.orders.words import BOAT_ORDERS, CREW_TALK
from trainer.io.recording.facts import NO_CREW_FACT, SCHEDULE_GIVER, Giver
from trainer.io.recording.recording import Recording
from trainer.session.crew.crew import CrewTalk
from trainer.session.crew.manning import HandWork
from trainer.session.past.options import RunOptions

PANEL = "planes at a panel"


def record(
    path: Path,
    exercise: str,
    crew: Mapping[float, str] | Sequence[tuple[float, str]],
    who: str = PANEL,
    **options: Any,
) -> Path:
    """Fly an exercise with orders by their times [s] into a recording, and return its path."""
    given = frozenset(options) - {"trainee", "width"}
    chosen = RunOptions(exercise=exercise, given=given, **options)
    plan, boat, header = begin_run(chosen)
    state = boat.records.state.tobytes()
    recording = Recording.create(path, header, state)
    timed = crew.items() if isinstance(crew, Mapping) else crew
    given_at = [(round(second / plan.method.step), text) for second, text in timed]

    talk = CrewTalk(boat, HandWork(boat))

    def give(by: Giver, order: Order, number: int | None) -> None:
        entry = recording.order(boat.ticks, by, order.text, number)
        answer = answer_to(order, by)
        refused = isinstance(answer, Refused)
        fact = NO_CREW_FACT if refused else talk.fact_of(order, by.role)
        if not refused:
            talk.note(order, by, boat.ticks, fact)
        recording.answered(entry, str(answer), not refused, fact)

    def answer_to(order: Order, by: Giver) -> Reply:
        if order.name in CREW_TALK:
            return talk.obey(order, by.role)
        return obey_order(boat, order) if order.name in BOAT_ORDERS else f"noted: {order.text}"

    with np.errstate(all="ignore"):
        due = entries_due(boat, plan.schedule)
        for tick in range(last_tick(plan)):
            for place in due.get(tick, ()):
                give(SCHEDULE_GIVER, plan.schedule[place].order, place)
            for text in (text for when, text in given_at if when == tick):
                order = read_order(text)
                give(giver_at(who), order, None)
                if order.name == "mark":
                    recording.event(tick, "mark", who, order.subject, giver_at(who).role)
            boat.tick()
            recording.state(boat.ticks, boat.records.state.tobytes())
    recording.close()
    return path

"""The replay of a recording by its orders, comparing states bit by bit.

``trainer replay`` flies each branch again from its first recorded state, gives the recorded orders
at their ticks, and compares every state. Where ticks were lost, it flies on to the state after them
by the orders given there, if all of these are kept. The same program has to arrive at the same
bits; what differs shows a change of the equations. With another step or vessel (``otherwise``)
states cannot be the same: then the branch is flown from the plan's start, and the first difference
is reported.
"""

from collections import deque
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

import click
import numpy as np

from trainer.boat.boat import Boat
from trainer.boat.helm import obey_order
from trainer.config.files import ConfigError, collecting, json_text
from trainer.core.kernel import Record
from trainer.io.lines import plain
from trainer.io.orders.grammar import Refused
from trainer.io.orders.words import BOAT_ORDERS
from trainer.io.recording.facts import BranchCause, GiverKind
from trainer.io.recording.recording import Branch, RecordedOrder, Recording
from trainer.session.past.header import (
    NO_CHANGES,
    differences,
    layout_of,
    method_of,
    notes,
    open_whole_recording,
    plan_of,
)
from trainer.session.past.journal import WorldOrders, order_of, worlds_begun
from trainer.session.past.layout import StateDifference, read_state, state_difference
from trainer.session.past.plan import Plan
from trainer.session.resume import refuse_other


@dataclass(frozen=True)
class Divergence:
    """The first difference between a flight and its recording."""

    tick: int  # of the recording
    unlike: StateDifference

    def __str__(self) -> str:
        name, recorded, flown, numbers = self.unlike
        others = f", and {numbers - 1} numbers more" if numbers > 1 else ""
        return f"tick {self.tick}: {name} was {recorded!r}, is now {flown!r}{others}"


@dataclass
class ReplayFlight:
    """One branch flown again."""

    branch: Branch
    compared: int = 0  # states
    unequal: int = 0  # of them
    parting: Divergence | None = None
    answers: list[str] = field(default_factory=list)  # that are not the recorded ones
    trouble: str = ""  # why it could not be flown, or not to its end

    @property
    def same(self) -> bool:
        """Return whether all states and answers were as recorded."""
        return not (self.unequal or self.answers or self.trouble)


@dataclass(frozen=True)
class Course:
    """The plan, boat and world with which the branches of a recording are flown."""

    plan: Plan
    boat: Boat
    layout: tuple[str, ...]  # of the recorded states
    pace: float  # [-] ticks flown for one recorded
    afresh: bool  # from the plan's start, not from the states recorded
    worlds: Mapping[int, WorldOrders]  # the orders to it where each branch begins
    gaps: Mapping[int | None, Branch]  # by each branch, the one that went on after lost ticks


def replay_anyway(
    recording: Recording, otherwise: Mapping[str, Any] = NO_CHANGES
) -> list[ReplayFlight]:
    """Fly every branch again by this version, from the recorded texts.

    ``header.differences`` tells what differs today, and whether the bits can be the same at all.
    ``otherwise`` has options, such as a step or a vessel, that replace the recorded ones: then
    each branch is flown from the plan's start, with all the orders of its past.
    """
    header = recording.header()
    plan = plan_of(header, otherwise)
    boat = Boat(plan.file, plan.method)
    pace = method_of(header).step / plan.method.step
    flights = [ReplayFlight(branch) for branch in recording.branches()]
    begun = [flight.branch for flight in flights]
    course = Course(
        *(plan, boat, layout_of(header), pace, bool(otherwise), worlds_begun(recording)),
        {each.parent: each for each in begun if each.cause is BranchCause.GAP},
    )
    for flight in flights:
        troubles: list[str] = []
        with collecting(troubles), np.errstate(all="ignore"):
            _fly(recording, flight, course)
        flight.trouble = "; ".join(troubles)
    return flights


def _fly(recording: Recording, flight: ReplayFlight, course: Course) -> None:
    """Fly a branch to its end; ConfigError if it cannot be flown so far."""
    branch, boat = flight.branch, course.boat
    course.plan.start(boat)  # also what no state holds: the triggers armed
    if branch.parent is None:
        compare_states(flight, branch.tick, branch.state, course)
    flown, after = 0, 0
    if not course.afresh:
        boat.restore(recorded_state(branch.state, course))
        boat.world.obey_anew(course.worlds[branch.id])
        flown, after = branch.tick, branch.after
    orders = deque(recording.orders(branch.id, after))
    gap = course.gaps.get(branch.id)
    if gap and gap.after != (orders[-1].id if orders else after):
        gap = None  # some orders of it are lost too
    for tick, state in recording.states(branch.id):
        flown = fly_to(tick, flown, orders, flight, course)
        if tick > branch.tick and stands_at(tick, flown, course):
            compare_states(flight, tick, state, course)
    while orders:  # of ticks of which no state is kept
        flown = fly_to(orders[0].tick, flown, orders, flight, course)
        give_orders(orders, flown, flight, course)
    if gap:
        flown = fly_to(gap.tick, flown, orders, flight, course)
        if stands_at(gap.tick, flown, course):
            compare_states(flight, gap.tick, gap.state, course)


def stands_at(tick: int, flown: int, course: Course) -> bool:
    """Return whether a recorded tick is reached, which another step may pass over."""
    return abs(flown - tick * course.pace) < 1e-9


def fly_to(
    tick: int, flown: int, orders: deque[RecordedOrder], flight: ReplayFlight, course: Course
) -> int:
    """Fly to a recorded tick by the orders before it; return the tick flown to."""
    while flown < tick * course.pace - 1e-9:
        give_orders(orders, flown, flight, course)
        if status := course.boat.tick():
            raise ConfigError(course.boat.failure(status))
        flown += 1
    return flown


def give_orders(
    orders: deque[RecordedOrder], flown: float, flight: ReplayFlight, course: Course
) -> None:
    """Give the boat the orders of the tick that stands at ``flown`` ticks now."""
    while orders and orders[0].tick * course.pace <= flown + 1e-9:
        entry = orders.popleft()
        order = order_of(entry, course.plan.schedule)
        if order is None or order.name not in BOAT_ORDERS:
            continue
        if entry.accepted is False and entry.giver.kind is GiverKind.PLAN:
            continue  # no gate is here that may have refused it
        answer = obey_order(course.boat, order)
        refused = isinstance(answer, Refused)
        if entry.accepted is refused:
            text = answer.reason if isinstance(answer, Refused) else answer
            flight.answers.append(f"tick {entry.tick}: {entry.text}: {entry.answer}; now: {text}")


def compare_states(flight: ReplayFlight, tick: int, recorded: bytes, course: Course) -> None:
    """Compare the boat as it is with the state recorded at ``tick``."""
    flown = course.boat.records.state.tobytes()
    flight.compared += 1
    if recorded == flown:
        return
    then = recorded_state(recorded, course)
    if course.pace != 1.0:
        then["tick"] = course.boat.state.tick
    difference = state_difference(then.tobytes(), flown)
    if difference:
        flight.unequal += 1
        flight.parting = flight.parting or Divergence(tick, difference)


def recorded_state(state: bytes, course: Course) -> Record:
    """Return a recorded state as a record of this version."""
    return read_state(state, course.layout, course.boat.records.state)


def replay_file(path: Path, otherwise: Mapping[str, Any], *, anyway: bool, as_json: bool) -> int:
    """Fly a recording again and print how it went; return the exit code."""
    with open_whole_recording(path) as recording:
        header = recording.header()
        changes = differences(header, otherwise)
        refuse_other(path, changes, anyway=anyway)
        for note in (*changes, *notes(header)):
            click.echo(plain(f"note: {note}"), err=True)
        flights = replay_anyway(recording, otherwise)
    lines = (plain(line) for flight in flights for line in describe_flight(flight))
    rows = [as_row(each) for each in flights]
    click.echo(json_text(rows, indent=1) if as_json else "\n".join(lines))
    return 0 if all(flight.same for flight in flights) else 1


def as_row(flight: ReplayFlight) -> dict[str, Any]:
    """Return the fields of a flight for JSON."""
    parting = flight.parting and asdict(flight.parting)
    return {
        "branch": flight.branch.id,
        "from_tick": flight.branch.tick,
        "why": flight.branch.why,
        "states_compared": flight.compared,
        "states_unequal": flight.unequal,
        "same": flight.same,
        "first_difference": parting,
        "answers": flight.answers,
        "trouble": flight.trouble,
    }


def describe_flight(flight: ReplayFlight) -> list[str]:
    """Return a flight in words."""
    branch = flight.branch
    begun = f", from tick {branch.tick} ({branch.why})" if branch.parent else ""
    verdict = "the same to the last bit"
    if not flight.same:
        verdict = f"NOT THE SAME: {flight.unequal} of them differ"
    lines = [f"branch {branch.id}{begun}: {flight.compared} states, {verdict}"]
    lines += [f"  {flight.parting}"] if flight.parting else []
    lines += [f"  {answer}" for answer in flight.answers]
    return lines + ([f"  {flight.trouble}"] if flight.trouble else [])

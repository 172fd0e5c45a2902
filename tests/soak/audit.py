"""A recording holds every answered order, every tick, and the same bits again."""

import contextlib
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path

from trainer.io.recording.recording import RecordedOrder, Recording
from trainer.session.replay import replay_anyway


@dataclass(frozen=True)
class Check:
    """One promise: what was looked at, whether it was kept, and what was seen."""

    promise: str
    kept: bool
    seen: str


@dataclass(frozen=True)
class Answered:
    """An order, or a mark, that a station had an answer to."""

    who: str  # as the recording calls it
    text: str  # the full wording; of a mark its remark
    mark: bool = False


def journal(recording: Recording) -> list[RecordedOrder]:
    """Return every order of a recording, on all branches, in the order they were given."""
    branches = recording.branches()
    every = {order.id: order for each in branches for order in recording.orders(each.id)}
    return [every[number] for number in sorted(every)]


def audit(path: Path, answered: Iterable[Answered]) -> list[Check]:
    """Return what holds of a recording that is not written any more."""
    with contextlib.closing(Recording.look(path)) as recording:
        return [check_journal(recording, answered), complete(recording), same_bits(recording)]


def check_journal(recording: Recording, answered: Iterable[Answered]) -> Check:
    """Return whether every answered order is there, in the order that each line gave them.

    And every mark.
    """
    every = list(answered)
    written = by_line((order.who, order.text) for order in journal(recording))
    wanted = by_line((order.who, order.text) for order in every if not order.mark)
    lost = sum(1 for who, texts in wanted.items() if written.get(who, [])[: len(texts)] != texts)
    told = sum(map(len, wanted.values()))
    missing = lost_marks(recording, every)
    marks = sum(order.mark for order in every)
    seen = f"{told} orders answered at {len(wanted)} lines; {lost} lines lack any"
    seen += f"; {marks} marks, {len(missing)} lost"
    return Check("every answered order is in the journal", not (lost or missing), seen)


def lost_marks(recording: Recording, answered: Iterable[Answered]) -> list[str]:
    """Return the marks that were answered and are not among the events."""
    made = {event.text for event in recording.events() if event.kind == "mark"}
    return [each.text for each in answered if each.mark and each.text not in made]


def by_line(pairs: Iterable[tuple[str, str]]) -> Mapping[str, list[str]]:
    """Return the texts of each line, in order."""
    found: dict[str, list[str]] = {}
    for who, text in pairs:
        found.setdefault(who, []).append(text)
    return found


def complete(recording: Recording) -> Check:
    """Return whether every branch's ticks have their states and their ledger entries."""
    ticks = missing = 0
    for branch in recording.branches():
        states = [tick for tick, _ in recording.states(branch.id)][1:]
        timed = {tick for tick, _, _ in recording.ledger(branch.id)}
        whole = range(branch.tick + 1, states[-1] + 1) if states else range(0)
        ticks += len(whole)
        missing += len(set(whole) - set(states)) + len(set(whole) - timed)
    return Check(
        "the ledger and the states are complete", not missing, f"{ticks} ticks; {missing} missing"
    )


def same_bits(recording: Recording) -> Check:
    """Return whether all of it, flown again, is the same to the last bit."""
    flights = replay_anyway(recording)
    states = sum(flight.compared for flight in flights)
    wrong = [flight for flight in flights if not flight.same]
    seen = f"{states} states of {len(flights)} branches; {len(wrong)} branches differ"
    return Check("flown again it is the same to the last bit", not wrong, seen)

"""Whose the marks of each task are: a station's, the crew's, or nobody's.

All is from the journal. A task is of a station and its person alone if only this station worked
the task's axes (``controls``) in its time. Else the crew shared it, and it is told with whom. It is
nobody's where an instructor worked an axis, or where an automatic alone held it.
"""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Final, NamedTuple

from trainer.debrief.marks.judgement import marks_given
from trainer.debrief.marks.scoring import RuleScore, Scorecard
from trainer.debrief.marks.tallied_record import looked_at
from trainer.debrief.passage.controls import ORDERED_AXES, moved_axes, moving_axes, working_roles
from trainer.debrief.passage.episodes import INSTRUCTOR_ROLE, answer_to, changed_orders, first_spell
from trainer.debrief.passage.trajectory import Trajectory
from trainer.debrief.passage.watches import Watch, persons_at
from trainer.io.orders.grammar import Order, parse
from trainer.io.orders.words import ORDER_WORDS
from trainer.io.recording.facts import REFERENCE_GIVER, GiverKind
from trainer.io.recording.recording import RecordedOrder

AUTOMATIC_HOLDER: Final = "the autopilot"  # has what is held by order
STRANGE_HANDS: Final = {INSTRUCTOR_ROLE, REFERENCE_GIVER.role}  # whose no marks of a crew are
UNNAMED_PERSON: Final = "not named"  # had the watch until somebody said a name


class TaskHand(NamedTuple):
    """Who worked a task: a station's role, an instructor or an automatic, and its persons."""

    role: str
    persons: tuple[str, ...] = ()  # that had the watch then; "" where none was named

    def __str__(self) -> str:
        names = ", then ".join(each or UNNAMED_PERSON for each in self.persons)
        return f"{self.role} ({names})" if names else self.role


@dataclass(frozen=True)
class TaskMarks:
    """The marks of one task, and whose they are."""

    name: str
    marks: float  # [%]
    weight: float
    able: tuple[str, ...]  # the stations that can move it
    hands: tuple[TaskHand, ...]  # that had its axes in its time

    @property
    def own(self) -> TaskHand | None:
        """Return the station whose the marks are alone, None for several or none."""
        return self.hands[0] if len(self.hands) == 1 and self.crewed else None

    @property
    def crewed(self) -> bool:
        """Return whether the crew worked it, and no instructor."""
        roles = {each.role for each in self.hands}
        return bool(roles - {AUTOMATIC_HOLDER}) and not roles & STRANGE_HANDS

    @property
    def person(self) -> str:
        """Return the person whose the marks are alone, "" if there is none."""
        persons = self.own.persons if self.own else ()
        return persons[0] if len(persons) == 1 else ""

    @property
    def whose(self) -> str:
        """Return in words whose the marks are."""
        names = " and ".join(map(str, self.hands))
        if self.own:
            return names
        if self.crewed:
            return f"the crew's: {names}"
        return f"nobody's: {names} had it" if names else "nobody's: nobody worked it"


class _Hold(NamedTuple):
    """Who has an axis from a tick on: a role, AUTOMATIC_HOLDER, or "" by the schedule."""

    tick: int
    axis: str
    role: str


def attribute_marks(
    trajectory: Trajectory, card: Scorecard, watches: Sequence[Watch]
) -> tuple[TaskMarks, ...]:
    """Return whose the marks of each task are, of those that count."""
    holds = tuple(_holds(trajectory.orders))
    there = {hold.role for hold in holds} - {"", AUTOMATIC_HOLDER} - STRANGE_HANDS
    alone = there.pop() if len(there) == 1 else ""
    last, found = int(trajectory.ticks[-1]), []
    for score in card.scores:
        if score.marks is None:
            continue
        axes = moving_axes(score.rule)
        hands = tuple(_hands(trajectory, holds, score, axes, watches))
        if alone and not hands:  # who is alone aboard answers for what nobody worked
            hands = (TaskHand(alone, persons_at(watches, alone, 0, last)),)
        marks = marks_given(score) or 0.0
        found.append(TaskMarks(score.name, marks, score.rule.weight, working_roles(axes), hands))
    return tuple(found)


def marks_of_person(tasks: Iterable[TaskMarks], person: str) -> float | None:
    """Return the mean by weight [%] of the tasks that are one person's alone. None: there are none.

    Names are compared without regard to capitals; "" is who had a watch without a name.
    """
    own = [each for each in tasks if each.own and each.person.casefold() == person.casefold()]
    weight = sum(each.weight for each in own)
    return sum(each.weight * each.marks for each in own) / weight if weight else None


def _holds(orders: Iterable[RecordedOrder]) -> Iterator[_Hold]:
    """Yield who has each axis, from each order that moves or claims it on."""
    for entry in orders:
        order = parse(entry.text)
        if entry.accepted is False or not isinstance(order, Order):
            continue
        scheduled = entry.giver.kind is GiverKind.SCHEDULE
        role = AUTOMATIC_HOLDER if entry.giver.kind is GiverKind.GUARD else entry.giver.role
        for axis in moved_axes(order):
            yield _Hold(entry.tick, axis, "" if scheduled else role)
            if axis in ORDER_WORDS[order.name].automates(order.word):
                yield _Hold(entry.tick + (not scheduled), axis, AUTOMATIC_HOLDER)


def _hands(
    trajectory: Trajectory,
    holds: Sequence[_Hold],
    score: RuleScore,
    axes: Sequence[str],
    watches: Sequence[Watch],
) -> Iterator[TaskHand]:
    """Yield who had the axes of a task in its time.

    The first axis steers it: it is somebody's also while he lets it stand. Another one counts where
    somebody worked it. An answer to a casualty is of who gave it, one to an alert
    of who acknowledged it.
    """
    spans: dict[str, list[tuple[int, int]]] = {}
    begin, end = _time_of(trajectory, score)
    for role, tick in _answers(trajectory, score, begin, end):
        spans.setdefault(role, []).append((tick, tick))
    for place, axis in enumerate(() if spans else axes):
        for role, first, last in _spells(holds, axis, begin, end, carried=place == 0):
            if role and not (place and role == AUTOMATIC_HOLDER):
                spans.setdefault(role, []).append((first, last))
    ordered = {axis for axis, steering in ORDERED_AXES.items() if steering in axes[:1]}
    for axis, entry in changed_orders(trajectory.orders):
        if axis not in ordered or entry.giver.kind is not GiverKind.STATION:
            continue
        if entry.giver.role != INSTRUCTOR_ROLE and begin <= entry.tick < end:
            spans.setdefault(entry.giver.role, []).append((entry.tick, entry.tick))
    for role, times in spans.items():
        first, last = min(each[0] for each in times), max(each[1] for each in times)
        yield TaskHand(role, persons_at(watches, role, first, last))


def _answers(
    trajectory: Trajectory, score: RuleScore, begin: int, end: int
) -> Iterator[tuple[str, int]]:
    """Yield who answered the casualty that a task is about, or its alerts, and at which tick."""
    rule = score.rule.score
    if rule.casualty and (episode := first_spell(trajectory, score.rule.casualty)):
        if answer := answer_to(trajectory, episode, rule.orders):
            yield answer.giver.role, answer.tick
    elif rule.measure == "alert-response":
        for alert in trajectory.alerts:
            if alert.seen and alert.seen_by and begin <= alert.raised.tick <= end:
                yield alert.seen_by, alert.seen.tick


def _time_of(trajectory: Trajectory, score: RuleScore) -> tuple[int, int]:
    """Return the first tick that a task looks at, and the last."""
    rows = looked_at(trajectory, score.rule)
    ticks = trajectory.ticks if rows is None or not rows.any() else trajectory.ticks[rows]
    return int(ticks[0]), int(ticks[-1])


def _spells(
    holds: Sequence[_Hold], axis: str, begin: int, end: int, *, carried: bool
) -> Iterator[tuple[str, int, int]]:
    """Yield who had an axis within a time, from which tick to which.

    ``carried``: also who had it as that time began.
    """
    never = _Hold(end, axis, "")
    for hold, after in pairwise((*(each for each in holds if each.axis == axis), never)):
        first, last = max(hold.tick, begin), min(after.tick, end)
        if first < last and (carried or hold.tick >= begin):
            yield hold.role, first, last

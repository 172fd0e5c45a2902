"""The changes of the marks that could still be earned, each with what made it.

``curve`` finds them. What one order cost and what it won again are one change here, so that
the marks of all changes add up to those lost.
"""

from collections.abc import Iterable
from dataclasses import dataclass, replace
from enum import Enum
from typing import Final

from trainer.debrief.attainable.falls import SteepFall, bound_falls, join_falls
from trainer.debrief.passage.controls import control_of

MIN_TOLD_MARKS: Final = 0.5  # [%] that a change must have come to


class ChangeCause(Enum):
    """The causes of a change. The values stand in the figures of a debrief."""

    ORDER = "order"  # one of the crew's
    WRONG_WAY = "wrong-way"  # one of the crew's: the opposite would have been right
    MISSING = "missing"  # one that did not come, or came late; of a hand, its first one
    STEERING = "steering"  # planes or rudder, worked otherwise than by the reference crew
    BETTER = "better"  # an order of the crew's that the reference crew does not give
    NO_ORDER = "no-order"  # none made it: marks rise and fall a little between two hands
    RECORD_ENDS = "record-ends"  # before the exercise does


@dataclass(frozen=True)
class MarkChange:
    """A stretch over which the attainable marks fell or rose, and why."""

    begin: int  # [tick]
    end: int
    marks: float  # [%] more at its end than at its begin
    cause: ChangeCause
    order: str = ""  # that was given, or did not come; "" of a hand that did nothing yet
    tick: int | None = None  # when it was given, or due
    came: int | None = None  # [tick] when one that was missing was given after all
    control: str = ""  # that a hand works
    who: str = ""  # gave it
    right: str = ""  # what it should have been
    back: int | None = None  # [tick] when it was taken back
    falls: tuple[SteepFall, ...] = ()  # the steep ones within it
    better: tuple[tuple[int, str], ...] | None = None  # the reference crew's, each with its tick

    @property
    def told_at(self) -> int:
        """Return the tick at which charts have it: of its order, else of its begin."""
        return self.begin if self.tick is None else self.tick

    @property
    def fault(self) -> tuple[object, ...]:
        """Return what was done wrong, which is alike in the parts of one change."""
        return self.cause, self.order, self.tick, self.control

    def with_more(self, other: "MarkChange") -> "MarkChange":
        """Return this change and another one's marks as one, which costs something or nothing."""
        falls = join_falls((*self.falls, *other.falls))
        end, marks = max(self.end, other.end), self.marks + other.marks
        return replace(self, end=end, marks=marks, falls=bound_falls(falls, abs(marks)))


def join_changes(changes: Iterable[MarkChange]) -> list[MarkChange]:
    """Return the changes, those of one fault that follow each other as one."""
    joined: list[MarkChange] = []
    for change in changes:
        if joined and change.fault == joined[-1].fault:
            joined[-1] = joined[-1].with_more(change)
        else:
            joined.append(change)
    return joined


def net_changes(changes: Iterable[MarkChange]) -> list[MarkChange]:
    """Return the changes, each order with what it cost in the end.

    What an order won is taken off what it cost itself, or what one cost that it takes back.
    """
    found = join_changes(changes)
    for rise in [each for each in found if each.cause is ChangeCause.BETTER]:
        lost = next((each for each in reversed(found) if is_undone(each, rise)), None)
        if lost is None:
            continue
        marks = lost.marks + rise.marks
        whole = lost.with_more(replace(rise, marks=min(rise.marks, -lost.marks)))
        whole = replace(whole, back=lost.back if rise.order == lost.order else rise.tick)
        rest = replace(rise, marks=max(marks, 0.0))
        found = [whole if each is lost else rest if each is rise else each for each in found]
    return join_changes(each for each in found if abs(each.marks) >= MIN_TOLD_MARKS)


def is_undone(lost: MarkChange, rise: MarkChange) -> bool:
    """Return whether a rise is of the order that cost marks, or takes it back."""
    if lost.marks >= 0.0 or not lost.order or lost.tick is None or rise.tick is None:
        return False
    if rise.order == lost.order:
        return rise.tick in (lost.tick, lost.came)
    ordered = lost.cause in (ChangeCause.ORDER, ChangeCause.WRONG_WAY) and lost.tick < rise.tick
    return ordered and control_of(lost.order) == control_of(rise.order)

"""The falls of what could still be earned, each with its fault."""

from collections.abc import Iterable
from dataclasses import dataclass, replace
from enum import Enum


class FaultKind(Enum):
    """The kinds of faults. Of edits that keep as much, the one of the earliest kind is told.

    The values stand in the figures of a debrief.
    """

    UNDONE = "undone"  # one of the crew's took back what a rule had ordered
    WRONG_WAY = "wrong-way"
    WRONG_PLACE = "wrong-place"
    WRONG_AMOUNT = "wrong-amount"
    LATE = "late"
    MISSING = "missing"  # it never came, and nothing in its place
    TURNED = "order-of-two"  # two came in the wrong order
    NEEDLESS = "needless"  # no rule wants it
    STEERING = "steering"  # planes or rudder, worked otherwise than by the reference crew
    UNPROVED = "no-order"  # no one edit keeps the marks
    UNSEARCHED = "not-searched"  # the debrief has flown as much as it may
    RECORD_ENDS = "record-ends"  # before the exercise does


@dataclass(frozen=True)
class MarkChange:
    """A stretch over which the attainable marks fell, and what made them."""

    begin: int  # [tick]
    end: int
    marks: float  # [%] more at its end than at its begin
    fault: FaultKind
    order: str = ""  # that was given, or did not come
    tick: int | None = None  # when it was given, or due
    came: int | None = None  # [tick] when one that was late was given
    who: str = ""  # gave it
    right: str = ""  # what it should have been, or what it undid
    late_orders: int = 1  # that came late together
    until: int | None = None  # [tick] the last at which all could still be put right
    remedy: tuple[tuple[int, str], ...] = ()  # the orders of the flight that proves it, by tick

    @property
    def told_at(self) -> int:
        """Return the tick at which charts have it: of its order, else of its begin."""
        return self.begin if self.tick is None else self.tick

    @property
    def cause(self) -> tuple[object, ...]:
        """Return what was done wrong, which is alike in the parts of one change."""
        return self.fault, self.order, self.tick, self.right


def join_changes(changes: Iterable[MarkChange]) -> list[MarkChange]:
    """Return the changes, those of one order as one."""
    joined: dict[object, MarkChange] = {}
    for change in changes:
        cause = change.cause if change.order else change
        first = joined.setdefault(cause, change)
        if first is not change:
            marks, end = first.marks + change.marks, max(first.end, change.end)
            joined[cause] = replace(first, marks=marks, end=end)
    return list(joined.values())

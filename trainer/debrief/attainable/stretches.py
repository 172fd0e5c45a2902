"""The stretches over which the marks that could still be earned fall or rise.

``explorer`` flies the points of the curve, and the causes of what is found here. How near to each
other points may lie is decided here too: from each the rest of the run is flown, so the work would
grow by the square of its length.
"""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Final

import numpy as np

from trainer.debrief.marks.scoring import Scorecard

WORTH_MARKS: Final = 3.0  # [%] of marks from which a change is looked into, and told
POINT_PERIODS: Final = 10  # of the finest period, from point to point where little changes
IDLE_POINTS: Final = 8  # times as far where nobody orders anything either
FINEST_PERIOD_S: Final = 1.0  # [s] down to which a change is halved, in a run that is not too long
MAX_TICKS: Final = 500_000  # flown for the points where little changes, 10 to 25 s of processor
MAX_TRIED_ORDERS: Final = 12  # orders left out one after another to explain one change
STEADY_MARKS: Final = 0.5  # [%] less in STEADY_TIME_S is no change: rounding, and the sea
STEADY_TIME_S: Final = 30.0  # [s] before and after a moment: a minute in all


def finest_period(last: int, step: float) -> int:
    """Return how many ticks lie between the nearest moments to depart from.

    It widens with the length [ticks] of a run of steps [s], so that the points where little changes
    take at most MAX_TICKS.
    """
    within = math.ceil(last**2 / (2 * POINT_PERIODS * MAX_TICKS))
    return max(round(FINEST_PERIOD_S / step), within, 1)


def most_tried(last: int) -> int:
    """Return how many orders are left out to explain one change of a run [ticks]."""
    return min(max(MAX_TICKS // last, 1), MAX_TRIED_ORDERS)


@dataclass(frozen=True)
class AttainablePoint:
    """The marks to be had from one moment on, and the outcome."""

    tick: int
    marks: float  # [%]
    won: bool
    lost: bool
    card: Scorecard | None = None  # of that run

    @property
    def fate(self) -> tuple[bool, bool]:
        """Return whether the exercise is won, and whether it is lost."""
        return self.won, self.lost


@dataclass(frozen=True)
class MarkStretch:
    """A stretch over which the marks fall or rise, without those that came back untouched."""

    begin: AttainablePoint
    end: AttainablePoint
    marks: float  # [%] of the change, with what is too slow to tell beside it
    points: tuple[AttainablePoint, ...]  # from begin to end

    @classmethod
    def of(
        cls,
        points: Sequence[AttainablePoint],
        begin: AttainablePoint,
        end: AttainablePoint,
        marks: float,
    ) -> "MarkStretch":
        """Return the stretch between two of some points."""
        between = tuple(each for each in points if begin.tick <= each.tick <= end.tick)
        return cls(begin, end, marks, between)

    @property
    def half(self) -> AttainablePoint:
        """Return the first point by which half of the change has come."""
        way = [(each, (each.marks - self.begin.marks) / self.marks) for each in self.points]
        done = (each for each, share in way if share >= 0.5)
        return next(done, self.end)


def without_luck(
    points: Sequence[AttainablePoint], given: Sequence[int]
) -> tuple[AttainablePoint, ...]:
    """Return the points without rises that nobody made.

    Such marks were to be had by waiting. ``given`` are the ticks at which the crew gave orders.
    """
    level = [points[-1]]
    for before in reversed(points[:-1]):
        after = level[-1]
        idle = not any(before.tick <= tick < after.tick for tick in given)
        better = idle and after.marks > before.marks
        level.append(replace(after, tick=before.tick) if better else before)
    return tuple(reversed(level))


def changed_stretches(points: Sequence[AttainablePoint], step: float) -> Iterator[MarkStretch]:
    """Yield the stretches in which the marks change by more than WORTH_MARKS in all.

    Each ends where they turn, or stay for a minute. ``step`` [s] is that of the run. What lies
    between is added to the stretch beside it, so that all marks lost are accounted for.
    """
    for first, last in legs(points):
        leg = [each for each in points if first.tick <= each.tick <= last.tick]
        moves = [is_moving(leg, index, step) for index in range(len(leg) - 1)]
        found: list[MarkStretch] = []
        begin, told = None, first.marks
        for (before, _), moving in zip(pairwise(leg), moves, strict=True):
            if moving:
                begin = begin or before
            elif begin is not None and abs(before.marks - told) > WORTH_MARKS:
                found.append(MarkStretch.of(leg, begin, before, before.marks - told))
                begin, told = None, before.marks
        rest = last.marks - told
        if found and abs(rest) <= WORTH_MARKS:
            found[-1] = replace(found[-1], marks=found[-1].marks + rest)
        else:
            found.append(MarkStretch.of(leg, begin or first, last, rest))
        yield from found


def legs(points: Sequence[AttainablePoint]) -> Iterator[tuple[AttainablePoint, AttainablePoint]]:
    """Yield begin and end of each way from turn to turn.

    The marks turn where they come back by more than WORTH_MARKS.
    """
    begin = furthest = points[0]
    for point in points[1:]:
        way = furthest.marks - begin.marks
        if (point.marks - furthest.marks) * way >= 0.0:
            furthest = point if point.marks != furthest.marks else furthest
        elif abs(point.marks - furthest.marks) > WORTH_MARKS:
            if abs(way) > WORTH_MARKS:
                yield begin, furthest
                begin = furthest
            furthest = point
    if abs(furthest.marks - begin.marks) > WORTH_MARKS:
        yield begin, furthest


def is_moving(leg: Sequence[AttainablePoint], index: int, step: float) -> bool:
    """Return whether marks change after a point, at once or over a minute."""
    before, after = leg[index], leg[index + 1]
    if abs(after.marks - before.marks) >= STEADY_MARKS:
        return True
    ticks, marks = [each.tick for each in leg], [each.marks for each in leg]
    ahead = STEADY_TIME_S / step
    later, earlier = np.interp([before.tick + ahead, after.tick - ahead], ticks, marks)
    return bool(min(abs(later - before.marks), abs(after.marks - earlier)) >= STEADY_MARKS)

"""Steep falls of the marks that could still be earned, and what passes there.

``stretches`` finds those over which the marks fall, ``causes`` why. Where they fall within a second
no order need come there: the last moment for something has gone.
"""

from collections import defaultdict
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from enum import Enum
from itertools import pairwise
from typing import Final

import numpy as np

from trainer.debrief.attainable.stretches import WORTH_MARKS, AttainablePoint
from trainer.debrief.marks.judgement import before_gate, marks_given, share_of
from trainer.debrief.marks.scoring import Scorecard

STEPS_AROUND: Final = 5  # finest periods before and after a steep fall (estimate)
STEEP_SHARE: Final = 0.4  # [-] of what goes in that time, and it is steep (estimate)


class PassedKind(Enum):
    """The kinds of what passes where the marks fall within a second."""

    LOSS = "loss"  # from there on even the reference crew loses the exercise
    LIMIT = "limit"  # it breaks a limit, or breaks it by more
    RULE = "rule"  # it falls short in one score


@dataclass(frozen=True)
class SteepFall:
    """Falls by more than WORTH_MARKS within the finest period each, and what passes there."""

    tick: int  # at the end of the first
    marks: float  # [%]
    kind: PassedKind
    text: str


def lasting_points(points: Sequence[AttainablePoint]) -> tuple[AttainablePoint, ...]:
    """Return at each point the best that it or any later one still had.

    What a later take-over has again was not lost for good.
    """
    lasting: list[AttainablePoint] = []
    for point in reversed(points):
        later = lasting[-1] if lasting else point
        best = point if point.marks >= later.marks else later
        lost = point.lost and later.lost
        lasting.append(replace(best, tick=point.tick, lost=lost))
    return tuple(reversed(lasting))


def steep_falls(points: Sequence[AttainablePoint], finest: int) -> tuple[SteepFall, ...]:
    """Return the falls of lasting points within ``finest`` ticks, those of one kind as one.

    Where marks go in a row of steps, because a crew looks from time to time, none is a steep fall.
    """
    ticks, marks = ([getattr(each, name) for each in points] for name in ("tick", "marks"))

    def is_steep(before: AttainablePoint, after: AttainablePoint) -> bool:
        fall, near = before.marks - after.marks, STEPS_AROUND * finest
        begun, ended = np.interp((before.tick - near, after.tick + near), ticks, marks)
        return fall > max(WORTH_MARKS, STEEP_SHARE * float(begun - ended))

    return join_falls(
        SteepFall(after.tick, before.marks - after.marks, *what_passes(before, after))
        for before, after in pairwise(points)
        if after.tick - before.tick <= finest and is_steep(before, after)
    )


def join_falls(falls: Iterable[SteepFall]) -> tuple[SteepFall, ...]:
    """Return the falls, those of one score or kind as one.

    It has the words of the steepest.
    """
    alike: dict[tuple[PassedKind, str], list[SteepFall]] = defaultdict(list)
    for fall in falls:
        alike[fall.kind, fall.text if fall.kind is PassedKind.RULE else ""].append(fall)
    return tuple(
        replace(
            max(group, key=lambda fall: fall.marks),
            tick=group[0].tick,
            marks=sum(fall.marks for fall in group),
        )
        for group in alike.values()
    )


def bound_falls(falls: Iterable[SteepFall], whole: float) -> tuple[SteepFall, ...]:
    """Return the steepest falls that a change of ``whole`` [%] can hold."""
    kept: list[SteepFall] = []
    every = tuple(falls)
    for fall in sorted(every, key=lambda each: -each.marks):
        if sum(each.marks for each in (*kept, fall)) <= whole:
            kept.append(fall)
    return tuple(each for each in every if each in kept)


def parted_falls(
    falls: Sequence[SteepFall], given: int, own: float, rest: float
) -> tuple[tuple[SteepFall, ...], tuple[SteepFall, ...]]:
    """Return the falls that an order cost, and those of the rest.

    Nothing fell because of it before the tick at which it was ``given``, and the parts of a fall by
    ``own`` and ``rest`` [%] do not add up to more.
    """
    of_order = bound_falls((each for each in falls if each.tick >= given), abs(own))
    return of_order, bound_falls((each for each in falls if each not in of_order), abs(rest))


def what_passes(before: AttainablePoint, after: AttainablePoint) -> tuple[PassedKind, str]:
    """Return what has passed between two points, for the reference crew's runs from there.

    A loss comes first, then a limit that leaves less than the marks of the scores, then the score
    that lost most.
    """
    if before.card is None or after.card is None:
        return PassedKind.RULE, ""
    verdict = after.card.verdict
    if verdict and (verdict.void or after.lost) and not before.lost:
        return PassedKind.LOSS, verdict.reason
    if verdict and verdict.gate and not after.lost and after.marks < before_gate(verdict):
        return PassedKind.LIMIT, verdict.gate
    return PassedKind.RULE, dearest_rule(before.card, after.card)


def dearest_rule(before: Scorecard, after: Scorecard) -> str:
    """Return the score that lost most between two runs, "" without scores."""
    earned = [
        {each.name: share_of(each, card) * (marks_given(each) or 0.0) for each in card.scores}
        for card in (before, after)
    ]
    lost = {name: marks - earned[1].get(name, 0.0) for name, marks in earned[0].items()}
    return max(lost, key=lambda name: lost[name], default="")

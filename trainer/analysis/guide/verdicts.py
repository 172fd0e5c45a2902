"""Verdicts on the full set by published figures, on a compact one by the full.

The first is that of ASME V&V 20: an error within the uncertainty of its comparison is none that
was seen. The second judges two flights of one manoeuvre: measures, peaks, zero crossings, change
of change. The guide and ``trainer boat reduce`` judge a compact set by it. By change of change the
report of 1969 judged: how much less or more a quantity has changed at 120 s than by the full set.

No coefficient is known to one in a hundred. Where a row of them so much larger or smaller moves a
number of the full set's own flight by more than a compact set may be off, a compact set that is
off there has lost nothing. Such a number is told and not judged.
"""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from enum import StrEnum
from itertools import product
from typing import Final

import numpy as np

from trainer.analysis.guide.programme import Leg, fly_boat
from trainer.analysis.manoeuvres.flight import Flight, Manoeuvre
from trainer.analysis.manoeuvres.vehicle import ALLOWED_PERCENT, Measure
from trainer.analysis.programs.compare import compare_runs
from trainer.config.boat.vessel import VesselFile
from trainer.core.terms import COEFFICIENTS

WITHIN_TOLERANCE: Final = "within"
BEYOND_TOLERANCE: Final = "BEYOND"
NOT_JUDGED: Final = "not judged"
NOT_DETERMINED: Final = "not determined"  # by the hull's own coefficients: ``neighbour_moves``
MAX_DIFFERENCE: Final = 10.0  # [-] of what is allowed: a difference beyond this counts as this
LOST_QUANTITY, CHANGE_PREFIX = "flown, without being lost, to", "change of "
RATE_UNITS: Final = {"u": "m/s", "w": "m/s", "v": "m/s", "z": "m", "x": "m", "y": "m"}
TURN_RATES: Final = ("p", "q", "r")
MAX_JUDGED_SHARE: Final = 0.3  # [-] of a published value: a larger uncertainty judges nothing
REFINEMENT: Final = 2.0  # [-] from step to step
FORMAL_ORDER: Final = 4.0  # of Runge and Kutta
MIN_ORDER: Final = 0.5  # a lower one that was observed is no convergence
GRID_SAFETY_FACTOR: Final = 1.25  # of three steps, Roache 1998
EXPANSION_FACTOR: Final = 1.15  # from that band to a standard deviation, ASME V&V 20, section 2
COEFFICIENT_ROWS: Final = tuple(dict.fromkeys(term.equation for term in COEFFICIENTS))
ROW_CHANGE: Final = 0.01  # [-] estimate: a towing tank measures no better


class Validity(StrEnum):
    """What a comparison with a published figure shows, in the manner of ASME V&V 20."""

    NOISE = "below the noise of this comparison"
    MODEL_ERROR = "model error"
    ABSENT = "model error: ours does not do it"
    UNCERTAIN = "too uncertain to judge"
    NOT_JUDGED = "not judged"


MODEL_ERRORS: Final = (Validity.MODEL_ERROR, Validity.ABSENT)


def judge_error(error: float | None, u_val: float | None, value: float) -> Validity:
    """Return the verdict of a simulation's error by its uncertainty and the published value.

    ``error`` is None where the simulated boat does not do what was published, such as a swing.
    ``u_val`` is None where it is not known.
    """
    if u_val is None:
        return Validity.NOT_JUDGED
    if error is None:
        return Validity.ABSENT
    if u_val > MAX_JUDGED_SHARE * abs(value):
        return Validity.UNCERTAIN
    return Validity.NOISE if abs(error) <= u_val else Validity.MODEL_ERROR


def step_uncertainty(by_step: Sequence[float]) -> tuple[float, float | None]:
    """Return the uncertainty by the step and the order observed, None where there is none.

    ``by_step`` has the result by a step, by twice and by four times it. Where these do not converge
    (events are seen at the starts of cycles) the uncertainty is the larger of their differences.
    """
    fine, coarse = by_step[0] - by_step[1], by_step[1] - by_step[2]
    if fine * coarse > 0.0:
        order = min(math.log(coarse / fine, REFINEMENT), FORMAL_ORDER)
        if order >= MIN_ORDER:
            share = GRID_SAFETY_FACTOR / (REFINEMENT**order - 1.0)
            return abs(fine) * share / EXPANSION_FACTOR, order
    return max(abs(fine), abs(coarse)), None


@dataclass(frozen=True)
class Judgement:
    """One number of a flight beside that of the full set, SI and radians."""

    quantity: str
    unit: str
    full: float | None
    other: float | None
    allowed: float | None
    verdict: str  # WITHIN_TOLERANCE, BEYOND_TOLERANCE, NOT_JUDGED or NOT_DETERMINED

    @property
    def difference(self) -> float | None:
        """Return how much larger the other number is; None if one is lacking."""
        if self.full is None or self.other is None:
            return None
        return self.other - self.full


def allowed_multiple(one: Judgement) -> float:
    """Return a difference as a multiple of what is allowed [-]. A lacking number counts as 0."""
    if not one.allowed or one.full is None:
        return MAX_DIFFERENCE
    other = 0.0 if one.other is None else one.other
    return float(np.clip((other - one.full) / one.allowed, -MAX_DIFFERENCE, MAX_DIFFERENCE))


def verdict_account(verdicts: Sequence[bool | None]) -> str:
    """Return in words how many judgements pass, and how many were not made (None).

    As in ``21 of 21 judged, 9 not judged``.
    """
    judged = [one for one in verdicts if one is not None]
    unjudged = len(verdicts) - len(judged)
    return f"{sum(judged)} of {len(judged)} judged" + f", {unjudged} not judged" * (unjudged > 0)


def passes_all(verdicts: Sequence[bool | None]) -> bool:
    """Return whether something was judged, and nothing of it failed."""
    return True in verdicts and False not in verdicts


def judge(manoeuvre: Manoeuvre, full: Flight, other: Flight) -> tuple[Judgement, ...]:
    """Return every measure and change of change of ``other`` against ``full``.

    Nothing is judged where the full set itself is lost, because its equations do not hold there.
    """
    judgements = (*_pair_measures(manoeuvre, full, other), *_changes(manoeuvre, full, other))
    if not full.lost:
        return judgements
    return tuple(replace(one, allowed=None, verdict=NOT_JUDGED) for one in judgements)


def _pair_measures(manoeuvre: Manoeuvre, full: Flight, other: Flight) -> Iterator[Judgement]:
    """Yield the measures. One that a flight lacks is beyond tolerance, unless 0 would be within."""
    if full.lost or other.lost:
        verdict = BEYOND_TOLERANCE if other.lost else NOT_JUDGED
        ends = float(full.t[-1]), float(other.t[-1])
        yield Judgement(LOST_QUANTITY, "s", *ends, None, verdict)
    by_other = {one.name: one for one in manoeuvre.measures(other)}
    for one in manoeuvre.measures(full):
        yield judge_measure(one, by_other.pop(one.name, None))
    for one in by_other.values():
        yield Judgement(one.name, one.unit, None, one.value, None, NOT_JUDGED)


def judge_measure(one: Measure, other: Measure | None) -> Judgement:
    """Return a full set's measure judged by that of another flight. None: it has none.

    A peak or an end that the other flight lacks counts as 0, and passes if the tolerance allows 0.
    """
    value = None if other is None else other.value
    if one.value is None or one.allowed is None:
        return Judgement(one.name, one.unit, one.value, value, None, NOT_JUDGED)
    lacking = abs(one.value) if value is None else abs(value - one.value)
    verdict = WITHIN_TOLERANCE if lacking <= one.allowed else BEYOND_TOLERANCE
    return Judgement(one.name, one.unit, one.value, value, one.allowed, verdict)


def keep_checks(found: Sequence[Judgement], checks: tuple[str, ...]) -> tuple[Judgement, ...]:
    """Return the judgements, those alone judged whose quantities begin as ``checks``.

    Where damping leaves none of them, the change at two minutes is (report of 1969, section V).
    """
    judged = any(one.allowed is not None and one.quantity.startswith(checks) for one in found)
    kept = checks if judged else (CHANGE_PREFIX,)
    return tuple(
        one
        if one.quantity.startswith((*kept, LOST_QUANTITY))
        else replace(one, allowed=None, verdict=NOT_JUDGED)
        for one in found
    )


def _changes(manoeuvre: Manoeuvre, full: Flight, other: Flight) -> Iterator[Judgement]:
    """Yield the change of change at 120 s of the columns that the manoeuvre names."""
    names = [name for name in manoeuvre.compared if full.has(name)]
    if not names or min(full.t.size, other.t.size) < 2:
        return
    report = compare_runs(full.series, other.series, names)
    for point in report.points:
        when = f"{report.until_s:g} s" if point.point == "at the end" else point.point
        allowed = abs(point.change_full) * ALLOWED_PERCENT / 100.0
        verdict = (
            (WITHIN_TOLERANCE if point.passed else BEYOND_TOLERANCE) if point.judged else NOT_JUDGED
        )
        yield Judgement(
            f"{CHANGE_PREFIX}{point.variable}, {when}",
            unit_of(point.variable),
            point.change_full,
            point.change_reduced,
            allowed if point.judged else None,
            verdict,
        )


def unit_of(column: str) -> str:
    """Return the unit of a column."""
    return RATE_UNITS.get(column, "rad/s" if column in TURN_RATES else "rad")


def neighbour_moves(file: VesselFile, leg: Leg, full: Flight) -> dict[str, float]:
    """Return how far neighbours move the numbers of the full set's flight of a leg.

    A neighbour has one row of coefficients one percent larger or smaller. The largest move of each
    number counts, a multiple of what is allowed [-]. A neighbour that cannot start moves nothing.
    """
    moves: dict[str, float] = {}
    for row, change in product(COEFFICIENT_ROWS, (ROW_CHANGE, -ROW_CHANGE)):
        moved = {
            name: value * (1.0 + change)
            for name, value in file.coefficients.items()
            if value and name.startswith(f"{row}_")
        }
        if not moved:
            continue
        neighbour = replace(file, coefficients={**file.coefficients, **moved})
        other = fly_boat(neighbour, leg.task(neighbour, "full"))
        if isinstance(other, str):
            continue
        for one in judge(leg.manoeuvre, full, other):
            if one.allowed:
                move = abs(allowed_multiple(one))
                moves[one.quantity] = max(moves.get(one.quantity, 0.0), move)
    return moves


def set_apart(
    file: VesselFile, leg: Leg, full: Flight, found: Sequence[Judgement], share: float = 1.0
) -> tuple[Judgement, ...]:
    """Return judgements of a leg; what is beyond, and beyond by neighbours too, is NOT_DETERMINED.

    ``share`` is of what is allowed. Neighbours fly only where something is beyond.
    """
    if not any(_beyond(one, share) for one in found):
        return tuple(found)
    moves = neighbour_moves(file, leg, full)
    return tuple(
        replace(one, allowed=None, verdict=NOT_DETERMINED)
        if _beyond(one, share) and moves.get(one.quantity, 0.0) > share
        else one
        for one in found
    )


def _beyond(one: Judgement, share: float) -> bool:
    """Return whether a number is off by more than ``share`` of what is allowed."""
    return bool(one.allowed) and abs(allowed_multiple(one)) > share

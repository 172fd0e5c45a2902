"""Two flights of one manoeuvre judged: measures, peaks, zero crossings, change of change."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Final

from trainer.analysis.manoeuvres.flight import Flight, Manoeuvre
from trainer.analysis.manoeuvres.vehicle import ALLOWED_PERCENT, Measure
from trainer.analysis.programs.compare import compare_runs

WITHIN_TOLERANCE: Final = "within"
BEYOND_TOLERANCE: Final = "BEYOND"
NOT_JUDGED: Final = "not judged"
RATE_UNITS: Final = {"u": "m/s", "w": "m/s", "v": "m/s", "z": "m", "x": "m", "y": "m"}
TURN_RATES: Final = ("p", "q", "r")


@dataclass(frozen=True)
class Judgement:
    """One number of a flight beside that of the full set, SI and radians."""

    quantity: str
    unit: str
    full: float | None
    other: float | None
    allowed: float | None
    verdict: str  # WITHIN_TOLERANCE, BEYOND_TOLERANCE or NOT_JUDGED

    @property
    def difference(self) -> float | None:
        """Return how much larger the other number is; None if one is lacking."""
        if self.full is None or self.other is None:
            return None
        return self.other - self.full


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
        yield Judgement("flown, without being lost, to", "s", *ends, None, verdict)
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
            f"change of {point.variable}, {when}",
            unit_of(point.variable),
            point.change_full,
            point.change_reduced,
            allowed if point.judged else None,
            verdict,
        )


def unit_of(column: str) -> str:
    """Return the unit of a column."""
    return RATE_UNITS.get(column, "rad/s" if column in TURN_RATES else "rad")

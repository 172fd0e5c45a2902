"""Two flights of one manoeuvre judged: measures, peaks, zero crossings, change of change."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Final

from trainer.analysis.guide.programme import Flown, Task
from trainer.analysis.manoeuvres.catalogue import find_manoeuvre
from trainer.analysis.manoeuvres.flight import Flight, Manoeuvre
from trainer.analysis.manoeuvres.vehicle import PERCENT, Measure
from trainer.analysis.programs.compare import compare
from trainer.boat.assemble import Method
from trainer.config.vessel import VesselFile
from trainer.core.terms import COEFFICIENTS
from trainer.units import KNOT

WITHIN: Final = "within"
BEYOND: Final = "BEYOND"
SHOWN: Final = "not judged"
UNITS: Final = {"u": "m/s", "w": "m/s", "v": "m/s", "z": "m", "x": "m", "y": "m"}
RATES: Final = ("p", "q", "r")


@dataclass(frozen=True)
class Judgement:
    """One number of a flight beside that of the full set, SI and radians."""

    quantity: str
    unit: str
    full: float | None
    other: float | None
    allowed: float | None
    verdict: str  # WITHIN, BEYOND or SHOWN

    @property
    def difference(self) -> float | None:
        """Return how much larger the other number is; None if one is lacking."""
        if self.full is None or self.other is None:
            return None
        return self.other - self.full


def account(verdicts: Sequence[bool | None]) -> str:
    """Return in words how many judgements pass, and how many were not made (None).

    As in ``21 of 21 judged, 9 not judged``.
    """
    judged = [one for one in verdicts if one is not None]
    left = len(verdicts) - len(judged)
    return f"{sum(judged)} of {len(judged)} judged" + f", {left} not judged" * (left > 0)


def passes(verdicts: Sequence[bool | None]) -> bool:
    """Return whether something was judged, and nothing of it failed."""
    return True in verdicts and False not in verdicts


def judge(manoeuvre: Manoeuvre, full: Flight, other: Flight) -> tuple[Judgement, ...]:
    """Return every measure and change of change of ``other`` against ``full``.

    Where the full set itself is lost, beyond what its equations are good for, nothing is judged.
    """
    found = (*_pair_measures(manoeuvre, full, other), *_changes(manoeuvre, full, other))
    if not full.lost:
        return found
    return tuple(replace(one, allowed=None, verdict=SHOWN) for one in found)


def _pair_measures(manoeuvre: Manoeuvre, full: Flight, other: Flight) -> Iterator[Judgement]:
    """Yield the measures; what only one flight has is beyond, unless it may be nothing."""
    if full.lost or other.lost:
        verdict = BEYOND if other.lost else SHOWN
        ends = float(full.t[-1]), float(other.t[-1])
        yield Judgement("flown, without being lost, to", "s", *ends, None, verdict)
    by_other = {one.name: one for one in manoeuvre.measures(other)}
    for one in manoeuvre.measures(full):
        yield judge_measure(one, by_other.pop(one.name, None))
    for one in by_other.values():
        yield Judgement(one.name, one.unit, None, one.value, None, SHOWN)


def judge_measure(one: Measure, other: Measure | None) -> Judgement:
    """Return a full set's measure judged by that of another flight. None: it has none.

    A peak or an end that the other lacks counts as zero, which is within if so much is allowed.
    """
    value = None if other is None else other.value
    if one.value is None or one.allowed is None:
        return Judgement(one.name, one.unit, one.value, value, None, SHOWN)
    lacking = abs(one.value) if value is None else abs(value - one.value)
    verdict = WITHIN if lacking <= one.allowed else BEYOND
    return Judgement(one.name, one.unit, one.value, value, one.allowed, verdict)


def _changes(manoeuvre: Manoeuvre, full: Flight, other: Flight) -> Iterator[Judgement]:
    """Yield the change of change at 120 s of the columns that the manoeuvre names."""
    names = [name for name in manoeuvre.compared if full.has(name)]
    if not names or min(full.t.size, other.t.size) < 2:
        return
    report = compare(full.series, other.series, names)
    for point in report.points:
        when = f"{report.until_s:g} s" if point.point == "at the end" else point.point
        allowed = abs(point.change_full) * PERCENT / 100.0
        verdict = (WITHIN if point.passed else BEYOND) if point.judged else SHOWN
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
    return UNITS.get(column, "rad/s" if column in RATES else "rad")


# The reason of a difference: each dropped coefficient's effect on a turn and a meander.


Look = Mapping[str, tuple[str, ...]]  # manoeuvre: measures that are shown
LOOKED_AT: Final[Look] = {
    "turn": ("steady diameter", "steady speed", "largest roll"),
    "meander": ("pitch peak 1", "damping ratio"),
}
NOTHING: Final = 0.1  # [%] a smaller effect on everything is not shown


@dataclass(frozen=True)
class Drop:
    """One coefficient put to zero in the full set."""

    coefficient: str
    value: float  # [-]
    percent: dict[str, float | None]  # change by manoeuvre and measure

    @property
    def worst(self) -> float:
        """Return the largest change [%] of any measure."""
        return max((abs(x) for x in self.percent.values() if x is not None), default=0.0)


def list_dropped(file: VesselFile) -> tuple[str, ...]:
    """Return the coefficients of this boat that its modified set drops."""
    kept = file.compact.extra_terms
    factors = file.compensation["modified"]
    return tuple(
        term.key
        for term in COEFFICIENTS
        if file.coefficients[term.key]
        and (not (term.kept or term.key in kept) or factors.get(term.key) == 0.0)
    )


def _task(file: VesselFile, name: str, zeroed: tuple[str, ...]) -> Task:
    """Return the flight of one manoeuvre by the full set, at the boat's start speed."""
    method = Method("full", "exact", "exact", "rk4", file.run.step_s)
    return Task(find_manoeuvre(name), file.run.start_speed_kn * KNOT, method, zeroed=zeroed)


def drop_tasks(file: VesselFile) -> Iterator[Task]:
    """Yield the flights that tell what the dropped coefficients do."""
    yield from tasks_without(file, list_dropped(file), LOOKED_AT)
    for name in LOOKED_AT:
        yield _task(file, name, list_dropped(file))


def tasks_without(file: VesselFile, coefficients: Sequence[str], look: Look) -> Iterator[Task]:
    """Yield the flights with all coefficients, and without each of some."""
    for name in look:
        yield _task(file, name, ())
        for coefficient in coefficients:
            yield _task(file, name, (coefficient,))


def _figures(look: Look, name: str, flight: Flight | str) -> dict[str, float | None]:
    """Return the measures looked at, by manoeuvre and name."""
    if isinstance(flight, str):
        return {}
    values = {one.name: one.value for one in find_manoeuvre(name).measures(flight)}
    return {f"{name}: {measure}": values.get(measure) for measure in look[name]}


def drop_study(file: VesselFile, flown: Flown) -> tuple[Drop, ...]:
    """Return the effect of each dropped coefficient, the largest first, then of all together."""
    together = _drop(file, flown, list_dropped(file), LOOKED_AT)
    return (*effects(file, flown, list_dropped(file), LOOKED_AT), together)


def effects(
    file: VesselFile, flown: Flown, coefficients: Sequence[str], look: Look
) -> tuple[Drop, ...]:
    """Return what each of some coefficients does, the largest effect first, none of NOTHING."""
    alone = [_drop(file, flown, (coefficient,), look) for coefficient in coefficients]
    alone = [drop for drop in alone if drop.worst >= NOTHING]
    return tuple(sorted(alone, key=lambda drop: -drop.worst))


def _drop(file: VesselFile, flown: Flown, zeroed: tuple[str, ...], look: Look) -> Drop:
    """Return what putting coefficients to zero changes [%]."""
    percent: dict[str, float | None] = {}
    for name in look:
        before = _figures(look, name, flown[_task(file, name, ())])
        after = _figures(look, name, flown[_task(file, name, zeroed)])
        for measure, value in before.items():
            new = after.get(measure)
            percent[measure] = 100.0 * (new - value) / abs(value) if value and new else None
    if len(zeroed) == 1:
        return Drop(zeroed[0], file.coefficients[zeroed[0]], percent)
    return Drop("all of them", 0.0, percent)

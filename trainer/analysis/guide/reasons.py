"""The reason of a difference: each dropped coefficient's effect on a turn and a meander.

A compact set lacks terms that the full set has. Where its flights differ, the guide and
``trainer boat reduce`` put each such coefficient to zero in the full set alone, to say which of
them makes the difference.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Final

from trainer.analysis.guide.programme import FlightTable, Task
from trainer.analysis.manoeuvres.catalogue import find_manoeuvre
from trainer.analysis.manoeuvres.flight import Flight
from trainer.boat.assemble import Method
from trainer.config.boat.vessel import VesselFile
from trainer.core.terms import COEFFICIENTS
from trainer.units import KNOT

MeasureNames = Mapping[str, tuple[str, ...]]  # manoeuvre: measures that are shown


JUDGED_MEASURES: Final[MeasureNames] = {
    "turn": ("steady diameter", "steady speed", "largest roll"),
    "meander": ("pitch peak 1", "damping ratio"),
}
MIN_EFFECT_PERCENT: Final = 0.1  # [%] a smaller effect on everything is not shown


@dataclass(frozen=True)
class DropEffect:
    """One coefficient put to zero in the full set."""

    coefficient: str
    value: float  # [-]
    percent: dict[str, float | None]  # change by manoeuvre and measure

    @property
    def worst(self) -> float:
        """Return the largest change [%] of any measure."""
        return max((abs(x) for x in self.percent.values() if x is not None), default=0.0)


def list_dropped(file: VesselFile) -> tuple[str, ...]:
    """Return the coefficients of this boat that its modified set drops.

    A term outside the set is dropped, and so is one whose factor is 0: ``trainer boat reduce``
    drops a term of 1969 so, because the kernel has a place for it in any case.
    """
    extra_terms = file.compact.extra_terms
    factors = file.compensation["modified"]
    return tuple(
        term.key
        for term in COEFFICIENTS
        if file.coefficients[term.key]
        and (not (term.kept or term.key in extra_terms) or factors.get(term.key) == 0.0)
    )


def _task(file: VesselFile, name: str, zeroed: tuple[str, ...]) -> Task:
    """Return the flight of one manoeuvre by the full set, at the boat's start speed.

    The full set flies, because it alone has the terms that the others drop.
    """
    method = Method("full", "exact", "exact", "rk4", file.run.step_s)
    return Task(find_manoeuvre(name), file.run.start_speed_kn * KNOT, method, zeroed=zeroed)


def drop_tasks(file: VesselFile) -> Iterator[Task]:
    """Yield the flights without each dropped coefficient, and without all of them."""
    yield from tasks_without(file, list_dropped(file), JUDGED_MEASURES)
    for name in JUDGED_MEASURES:
        yield _task(file, name, list_dropped(file))


def tasks_without(
    file: VesselFile, coefficients: Sequence[str], look: MeasureNames
) -> Iterator[Task]:
    """Yield the flights with all coefficients, and without each of ``coefficients``."""
    for name in look:
        yield _task(file, name, ())
        for coefficient in coefficients:
            yield _task(file, name, (coefficient,))


def _figures(look: MeasureNames, name: str, flight: Flight | str) -> dict[str, float | None]:
    """Return the measures in ``look`` of one flight by name; none of a flight that failed."""
    if isinstance(flight, str):
        return {}
    values = {one.name: one.value for one in find_manoeuvre(name).measures(flight)}
    return {f"{name}: {measure}": values.get(measure) for measure in look[name]}


def drop_study(file: VesselFile, flown: FlightTable) -> tuple[DropEffect, ...]:
    """Return the effect of each dropped coefficient, the largest first, then of all together."""
    together = _drop(file, flown, list_dropped(file), JUDGED_MEASURES)
    return (*drop_effects(file, flown, list_dropped(file), JUDGED_MEASURES), together)


def drop_effects(
    file: VesselFile, flown: FlightTable, coefficients: Sequence[str], look: MeasureNames
) -> tuple[DropEffect, ...]:
    """Return the effects of single coefficients, the largest first; small ones are left out."""
    alone = [_drop(file, flown, (coefficient,), look) for coefficient in coefficients]
    alone = [drop for drop in alone if drop.worst >= MIN_EFFECT_PERCENT]
    return tuple(sorted(alone, key=lambda drop: -drop.worst))


def _drop(
    file: VesselFile, flown: FlightTable, zeroed: tuple[str, ...], look: MeasureNames
) -> DropEffect:
    """Return what putting coefficients to zero changes [%].

    A measure that one of the flights lacks has no percent, nor has one that is 0 in either.
    """
    percent: dict[str, float | None] = {}
    for name in look:
        before = _figures(look, name, flown[_task(file, name, ())])
        after = _figures(look, name, flown[_task(file, name, zeroed)])
        for measure, value in before.items():
            new = after.get(measure)
            percent[measure] = 100.0 * (new - value) / abs(value) if value and new else None
    if len(zeroed) == 1:
        return DropEffect(zeroed[0], file.coefficients[zeroed[0]], percent)
    return DropEffect("all of them", 0.0, percent)

"""Why a reduced set differs: what each coefficient that it drops does to a turn and a meander."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Final

from trainer.files.terms import coefficient_terms
from trainer.files.vessel_file import VesselFile
from trainer.fitout import KNOT, Method
from trainer.guide.tasks import Flown, Task
from trainer.study.manoeuvres.catalogue import named
from trainer.study.manoeuvres.flight import Flight

LOOKED_AT: Final = {  # manoeuvre: measures that are shown
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


def dropped(file: VesselFile) -> tuple[str, ...]:
    """Return the coefficients of this boat that its modified set drops."""
    kept = file.compact.extra_terms
    return tuple(
        term.key
        for term in coefficient_terms()
        if not term.kept and term.key not in kept and file.coefficients.get(term.key, 0.0)
    )


def _task(file: VesselFile, name: str, zeroed: tuple[str, ...]) -> Task:
    """Return the flight of one manoeuvre by the full set, at the boat's start speed."""
    method = Method("full", "exact", "exact", "rk4", file.run.step_s)
    return Task(named(name), file.run.start_speed_kn * KNOT, method, zeroed=zeroed)


def tasks(file: VesselFile) -> Iterator[Task]:
    """Yield the flights that tell."""
    for name in LOOKED_AT:
        yield _task(file, name, ())
        for coefficient in dropped(file):
            yield _task(file, name, (coefficient,))
        yield _task(file, name, dropped(file))


def _figures(name: str, flight: Flight | str) -> dict[str, float | None]:
    """Return the measures looked at, by manoeuvre and name."""
    if isinstance(flight, str):
        return {}
    values = {one.name: one.value for one in named(name).measures(flight)}
    return {f"{name}: {measure}": values.get(measure) for measure in LOOKED_AT[name]}


def study(file: VesselFile, flown: Flown) -> tuple[Drop, ...]:
    """Return the effect of each dropped coefficient, the largest first, then of all together."""
    alone = [_drop(file, flown, coefficient, (coefficient,)) for coefficient in dropped(file)]
    alone = [drop for drop in alone if drop.worst >= NOTHING]
    together = _drop(file, flown, "all of them", dropped(file))
    return (*sorted(alone, key=lambda drop: -drop.worst), together)


def _drop(file: VesselFile, flown: Flown, called: str, zeroed: tuple[str, ...]) -> Drop:
    """Return what putting coefficients to zero changes [%]."""
    percent: dict[str, float | None] = {}
    for name in LOOKED_AT:
        before = _figures(name, flown[_task(file, name, ())])
        after = _figures(name, flown[_task(file, name, zeroed)])
        for measure, value in before.items():
            new = after.get(measure)
            percent[measure] = 100.0 * (new - value) / abs(value) if value and new else None
    return Drop(called, file.coefficients.get(called, 0.0), percent)

"""What each coefficient of a hull does by itself: the tables 5, 7, 9 and 11 of 1969."""

from collections.abc import Callable
from typing import Final

from trainer.files.terms import coefficient_terms
from trainer.files.vessel_file import VesselFile
from trainer.guide.drops import Drop, Look, effects, tasks_without
from trainer.guide.tasks import fly_all

LOOKED_AT: Final[Look] = {
    "turn": ("steady diameter", "steady speed", "largest roll"),
    "meander": ("pitch peak 1", "damping ratio"),
    "overshoot": ("largest pitch", "depth change"),
    "roll-decay": ("period", "amplitude after cycle 1"),
}


def coefficients(file: VesselFile) -> tuple[str, ...]:
    """Return the coefficients that this hull has."""
    return tuple(term.key for term in coefficient_terms() if file.coefficients[term.key])


def flights(file: VesselFile) -> int:
    """Return how many flights the table takes."""
    return len(set(tasks_without(file, coefficients(file), LOOKED_AT)))


def table(file: VesselFile, cores: int, step: Callable[[], None]) -> tuple[Drop, ...]:
    """Return the effect [%] of each coefficient put to zero in the full set, the largest first."""
    wanted = tasks_without(file, coefficients(file), LOOKED_AT)
    flown = fly_all(file.path, wanted, cores, step)
    return effects(file, flown, coefficients(file), LOOKED_AT)

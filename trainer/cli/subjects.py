"""The members of any study are made ready to fly."""

from collections.abc import Callable, Mapping
from typing import Final

from trainer.analysis.sweep.exercises import Exercising
from trainer.analysis.sweep.job import Subject
from trainer.analysis.sweep.manoeuvres import Manoeuvring
from trainer.analysis.sweep.study import EXERCISE, IDENTIFICATION, MANOEUVRE, Study
from trainer.identify.monte_carlo import Identifying
from trainer.identify.ships.vehicle import Sailing

SUBJECTS: Final[Mapping[str, Callable[[Study], Subject]]] = {
    MANOEUVRE: Manoeuvring,
    EXERCISE: Exercising,
    IDENTIFICATION: Identifying,
}


def subject_of(study: Study) -> Subject:
    """Return what every member is; ConfigError if its middle member cannot be."""
    if study.kind == MANOEUVRE and study.file is None:
        return Sailing(study)
    return SUBJECTS[study.kind](study)

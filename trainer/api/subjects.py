"""Which program makes and flies the members of a study, by the study's kind.

Sweeps (``analysis``) know no identification, which stands above them. So the choice is made here.
"""

from collections.abc import Callable, Mapping
from typing import Final

from trainer.analysis.sweep.exercises import ExerciseSubject
from trainer.analysis.sweep.job import Subject
from trainer.analysis.sweep.manoeuvres import ManoeuvreSubject
from trainer.analysis.sweep.study import (
    EXERCISE_STUDY,
    IDENTIFICATION_STUDY,
    MANOEUVRE_STUDY,
    Study,
)
from trainer.identify.monte_carlo import IdentificationSubject
from trainer.identify.ships.vehicle import SailingSubject

SUBJECT_MAKERS: Final[Mapping[str, Callable[[Study], Subject]]] = {
    MANOEUVRE_STUDY: ManoeuvreSubject,
    EXERCISE_STUDY: ExerciseSubject,
    IDENTIFICATION_STUDY: IdentificationSubject,
}


def subject_of(study: Study) -> Subject:
    """Return the subject of a study; ConfigError if its middle member cannot fly."""
    if study.kind == MANOEUVRE_STUDY and study.file is None:
        return SailingSubject(study)
    return SUBJECT_MAKERS[study.kind](study)

"""Whatever the members of a study are, made ready to be flown."""

from collections.abc import Callable, Mapping
from typing import Final

from trainer.sweep.batch import Subject
from trainer.sweep.exercising import Exercising
from trainer.sweep.identifying import Identifying
from trainer.sweep.manoeuvring import Manoeuvring
from trainer.sweep.study_file import EXERCISE, IDENTIFICATION, MANOEUVRE, Study

SUBJECTS: Final[Mapping[str, Callable[[Study], Subject]]] = {
    MANOEUVRE: Manoeuvring,
    EXERCISE: Exercising,
    IDENTIFICATION: Identifying,
}


def subject_of(study: Study) -> Subject:
    """Return what every member is; ConfigError if its middle member cannot be."""
    return SUBJECTS[study.kind](study)

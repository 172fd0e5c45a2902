"""The terms of a session: what it flies, for whom, and who judges.

``run`` draws them up from plan and options before the session is made, and ``Conduct`` makes its
parts by them. A session of a boat alone has none of it: the defaults hold.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from trainer.config.exercise.class_course import NO_COURSE, ClassCourse
from trainer.config.exercise.course import following
from trainer.config.exercise.derived import Loss
from trainer.io.orders.grammar import Refused
from trainer.session.exercise.marks import DebriefSource
from trainer.session.past.plan import Plan

SINGLE_REFUSAL: Final = Refused("this session is one run")


@dataclass(frozen=True)
class Terms:
    """What is settled of a session before it begins."""

    plan: Plan | None = None
    exercise: str = ""  # its name, "" for none
    losses: Sequence[Loss] = ()  # that end it
    seconds: float | None = None  # [s] after which its time is up
    kept: Path | None = None  # where it is recorded
    debriefing: DebriefSource | None = None
    trainees: tuple[str, ...] = ()  # whose progress is kept
    learners: tuple[str, ...] = ()  # whose is shown to who may train here
    course: ClassCourse = NO_COURSE  # of its class; without rows the shipped course holds
    barred: Refused | None = SINGLE_REFUSAL  # why another exercise needs another process

    @property
    def keeper(self) -> Sequence[str]:
        """Return the command that keeps progress, with the recording; empty for none."""
        progress = self.debriefing.progress if self.debriefing else ()
        return (*progress, str(self.kept)) if progress and self.kept else ()

    def following(self) -> str:
        """Return the name of what comes after this exercise; "" after the last."""
        if self.course.rows:
            return self.course.following(self.exercise)
        after = following(self.exercise)
        return after.name if after else ""

"""Who trains: the progress that is kept, and the exercise that is flown next.

A process of its own puts a run into the files of its trainees, when the exercise is over and when
the session ends. From these files ``next`` suggests to who trains what is weakest and longest ago.
"""

import contextlib
import subprocess
from collections.abc import Iterator
from dataclasses import dataclass
from datetime import UTC, datetime
from typing import Final

from trainer.config.exercise.course import course, lessons
from trainer.config.exercise.exercise import load_exercise
from trainer.config.exercise.outcome import Outcome
from trainer.config.exercise.progress import Progress, read_progress
from trainer.config.files import ConfigError
from trainer.io.orders.grammar import Refused, Reply
from trainer.session.aside import BackgroundTask, begin_aside, hear_out
from trainer.session.exercise.exercise import ExerciseEnd
from trainer.session.exercise.marks import Marks
from trainer.session.exercise.step_guide import StepGuide
from trainer.session.exercise.terms import Terms
from trainer.session.past.control import Control
from trainer.session.stations.event_log import EventLog
from trainer.session.stations.roles import INSTRUCTOR_ROLE, TRAINEE_ROLE, Role
from trainer.session.stations.station import Fact, LongAnswer, Request

COURSE_WORD: Final = "course"  # of the order that goes on in the class's course


@dataclass
class Training:
    """The progress of who trains in one session, and what follows its exercise."""

    control: Control
    log: EventLog
    work: BackgroundTask
    ending: ExerciseEnd
    guide: StepGuide
    terms: Terms
    marks: Marks
    _remembered: tuple[int, int] | None = None  # branch and tick

    def remember(self) -> None:
        """Have a process put this run into the files of its trainees."""
        recording, boat = self.control.history.recording, self.control.boat
        here = recording.branch, boat.ticks
        if (
            not (self.terms.keeper and self.terms.trainees and boat.ticks)
            or here == self._remembered
        ):
            return
        self._remembered = here
        recording.flush()
        ended = self.ending.outcome or Outcome.LEFT
        how = Outcome.DONE if self.guide.done and ended is not Outcome.LOST else ended
        whole = (*self.terms.keeper, str(recording.branch), how)

        def hear() -> str:
            process = begin_aside(whole)
            try:
                return hear_out(process, self.work.closing, 0.0)[0].decode().strip()
            except subprocess.TimeoutExpired:
                return ""  # a session that ends leaves it to itself

        def tell(text: str) -> None:
            if text:
                self.log.tell("exercise", text)

        self.work.begin("progress", hear, tell, lambda error: tell(f"no progress: {error}"))

    def go_on(self, asked: Request) -> Reply | LongAnswer:
        """Answer the order ``next``: end the session for the exercise that follows."""
        name, trains = asked.order.subject, asked.station.role is TRAINEE_ROLE
        reason = ""
        if asked.order.word == COURSE_WORD or (trains and self.terms.course.rows):
            following = self._next_of_course(name, asked.station.role)
            if isinstance(following, Refused):
                return following
            name, reason = following, "the one after this in the course"
        elif trains and not name:
            if self.ending.over and self.guide.undone:
                return Refused(self.guide.undone_text)
            name, reason = self._suggested()
            if not name:
                return Refused("this is the last of the course")
        if not name:
            names = [each.name for each in course()]
            return LongAnswer(names, "type next NAME to begin one of these")
        row = self.terms.course.row_of(name)
        numbered = (each.name for each in course() if each.word == name)
        file = row.exercise if row else next(numbered, name)
        if refused := self._problem(file):
            return refused
        self.log.tell("time", "the next exercise is being made ready")
        for station in self.log.stations:  # the file's name may tell what is hidden
            name_told = name if station.role is INSTRUCTOR_ROLE else ""
            self.log.note(station, [Fact("next", name_told)])
        self.control.following, self.control.trains, self.control.ended = file, trains, True
        return f"next: {reason or asked.order.subject}"

    def _next_of_course(self, asked: str, role: Role) -> str | Refused:
        """Return what follows in the course of the class, or what is missing to go on.

        ``asked`` is what who trains has named, "" for nothing.
        """
        course, name = self.terms.course, self.terms.following()
        if not course.rows:
            return Refused("this session is of no class with a course: next NAME")
        if not name:
            return Refused("this is the last of the course")
        if asked not in ("", name):
            return Refused(f"next in the course is {name}; an instructor may choose another")
        row = course.row_of(self.terms.exercise)
        if self.ending.over and row and row.reach:
            return self.marks.short_of(row.reach, role) or name
        return name

    def progress_facts(self) -> Iterator[tuple[str, str]]:
        """Yield what who trains has done, as ``exercise-5:71:passed``, and what is next."""
        progress, offered = self._progress() or Progress(""), [*lessons(), *course()]
        done = [
            f"{each.word}:{progress.best(each.name)}{':passed' * progress.passed(each.name)}"
            for each in offered
            if progress.of(each.name)
        ]
        yield from (("done", ",".join(done)) for _ in done[:1])
        if suggestion := progress.suggest(offered, datetime.now(UTC).date()):
            yield "suggested", suggestion.lesson.word

    def _suggested(self) -> tuple[str, str]:
        """Return what is best flown next, and why; "" for none.

        That is the weakest and longest ago of who trains, else what follows in the course.
        """
        offered = [*lessons(), *course()]
        if progress := self._progress():
            others = [each for each in offered if each.name != self.terms.exercise]
            if suggestion := progress.suggest(others, datetime.now(UTC).date()):
                return suggestion.lesson.name, suggestion.reason
        name = self.terms.following()
        return name, "the one after this" if name else ""

    def _progress(self) -> Progress | None:
        """Return the progress of who trains; None for nobody, or a file that cannot be read."""
        with contextlib.suppress(ConfigError):
            names = self.terms.trainees or self.terms.learners
            return read_progress(names[0]) if names else None
        return None

    def _problem(self, name: str) -> Refused | None:
        """Return why that exercise cannot follow, None if it can."""
        elsewhere = self.terms.barred
        if not elsewhere and not all(each.visits for each in self.log.stations):
            elsewhere = Refused("this session has lines of its own")
        if elsewhere:
            return Refused(f"{elsewhere.reason}: quit, then trainer run {name}")
        begun = self.terms.exercise or self.control.boat.ticks
        if begun and not self.ending.over:
            return Refused("this exercise is not over: type end exercise first")
        try:
            load_exercise(name)
        except ConfigError as error:
            return Refused(str(error))
        return None

"""The marks of an exercise and its debrief, made beside the session.

Judging a recording takes seconds. So a thread makes the marks when the exercise has ended, and a
debrief is written in a process of its own. The instructor gets the marks first, and releases them
to the crew; who trains alone gets them at once. The functions that judge a recording and write its
debrief come from the command line, because this package may not import ``debrief``.
"""

import math
import threading
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from itertools import zip_longest
from pathlib import Path
from typing import NamedTuple

from trainer.config.exercise.outcome import Outcome
from trainer.io.orders.grammar import Refused, Reply
from trainer.io.orders.words import TRAINEE
from trainer.io.recording.recording import Moment
from trainer.session.aside import BackgroundTask
from trainer.session.exercise.evaluation import UNRECORDED_REFUSAL
from trainer.session.exercise.exercise import ExerciseEnd
from trainer.session.past.control import Control
from trainer.session.stations.event_log import EventLog
from trainer.session.stations.roles import INSTRUCTOR_ROLE, TRAINEE_ROLE, Role
from trainer.session.stations.station import Fact, Request, Station


@dataclass(frozen=True)
class Judgement:
    """The result of an exercise: its outcome, all marks, and their reasons."""

    outcome: Outcome
    total: float | None  # [%] None: nothing counts
    reasons: tuple[str, ...] = ()
    uncounted: tuple[str, ...] = ()  # scores of what did not come: for the instructor
    times: tuple[float | None, ...] = ()  # [s] of the reasons, where they are about a moment
    aids: tuple[str, ...] = ()  # that were used

    def __str__(self) -> str:
        marks = "no marks" if self.total is None else f"{self.total:.0f} marks of 100"
        told = (self.outcome, marks, *(f"with {aid}" for aid in self.aids))
        return ", ".join(filter(None, told))

    @property
    def fields(self) -> str:
        """Return the fields of outcome and total for programs, and of the aids, if any."""
        total = "" if self.total is None else f"{self.total:.1f}"
        return ",".join((self.outcome, total, *self.aids))

    @property
    def facts(self) -> list[Fact]:
        """Return the facts of the marks and of each reason, its time [s] first."""
        times = ("" if time is None else f"{time:g}" for time in self.times)
        pairs = zip_longest(times, self.reasons, fillvalue="")
        return [Fact("marks", self.fields), *(Fact("reason", ",".join(pair)) for pair in pairs)]

    @property
    def uncounted_facts(self) -> list[Fact]:
        """Return the facts of the measures that do not count, which the instructor is told."""
        return [Fact("reason", f",{name}: does not count") for name in self.uncounted]


class WrittenDebrief(NamedTuple):
    """A debrief: its file, and what each minute cost, each with its time [s]."""

    page: str
    minutes: Sequence[tuple[float, str]] = ()

    @property
    def facts(self) -> list[Fact]:
        """Return what each minute cost, as reasons of the marks with their times [s]."""
        return [Fact("reason", f"{seconds:g},{told}") for seconds, told in self.minutes]


@dataclass(frozen=True)
class DebriefSource:
    """Two functions: one judges a branch of a recording, one has its debrief written.

    They raise RuntimeError with the reason if they cannot. Threads of their own call them, because
    both may take long. The event tells that the session ends; the last function is told the share
    that is written.
    """

    judge: Callable[[Path, int], Judgement]
    write: Callable[[Path, int, threading.Event, Callable[[float], object]], WrittenDebrief]
    evaluator: Sequence[str] = ()  # the command of a process, before the recording
    progress: Sequence[str] = ()  # the same, before recording, branch, and how it ended


@dataclass
class Marks:
    """The marks and the debrief of one exercise."""

    control: Control
    log: EventLog
    work: BackgroundTask
    ending: ExerciseEnd
    debriefing: DebriefSource | None
    kept: Path | None  # where the session is recorded
    scored: bool  # there is something to judge
    found: Judgement | None = None  # once they are there
    released: bool = False
    debrief: WrittenDebrief | None = None  # once it is written

    def __post_init__(self) -> None:
        self._pen = threading.Lock()  # held while a debrief is written
        self._dossier = threading.Lock()  # held by who judges a recording: it takes 20 MB

    def begin(self) -> None:
        """Have a thread judge the exercise, or announce why it has no marks."""
        if missing := self._missing:
            fact = Fact("marks", f"{self.ending.outcome},")
            self.log.tell("time", f"no marks: {missing.reason}", fact=fact)
        elif self.debriefing and self.kept:
            judge, kept, branch = self.debriefing.judge, self.kept, self._flushed_branch()
            ending = self.ending.over

            def judge_alone() -> Judgement:
                with self._dossier:
                    return judge(kept, branch)

            def take(marks: Judgement) -> None:
                if self.ending.over == ending:  # else time has gone back, and they are of no use
                    self._take(marks)

            self.work.begin("marks", judge_alone, take, partial(self._give_up, "marks"))

    def final(self) -> Judgement | None:
        """Return the marks of the branch that was flown last. Its recording has to be closed."""
        judged = self.debriefing and self.kept and self.scored and self.control.boat.ticks
        if self.found or not (judged and self.debriefing and self.kept):
            return self.found
        try:
            return self.debriefing.judge(self.kept, self.control.history.recording.branch)
        except Exception:  # noqa: BLE001 the summary is printed even if the marks fail
            return None

    def facts(self, role: Role) -> list[Fact]:
        """Return the facts of the end for a newcomer, with marks its role may see."""
        ending, instructs = self.ending, role is INSTRUCTOR_ROLE
        if not ending.over:
            return []
        facts = [Fact("exercise-over", ending.outcome)]
        if self.found and (self.released or instructs):
            facts += self.found.facts
            facts += self.found.uncounted_facts if instructs else []
        elif self._missing:
            facts.append(Fact("marks", f"{ending.outcome},"))
        if self.debrief and instructs:
            facts += [Fact("debrief", self.debrief.page), *self.debrief.facts]
        return facts

    def release(self, _asked: Request) -> Reply:
        """Answer the order ``release marks``."""
        if not self.ending.over:
            return Refused("the exercise is not over: type end exercise first")
        if self.found is None:
            return self._missing or Refused("there are no marks yet")
        self._release(self.found)
        return "everybody has the marks"

    def short_of(self, reach: float, role: Role) -> Refused | None:
        """Return what is missing to so many marks [%], None where they are reached.

        Before the marks are released only an instructor is told how many there are.
        """
        if self.found is None:
            return self._missing or Refused("the marks are being made: once more in a moment")
        total = self.found.total or 0.0
        if total >= reach:
            return None
        told = self.released or role is INSTRUCTOR_ROLE
        had = f"{math.floor(total)} of {reach:g} marks" if told else f"{reach:g} marks not reached"
        return Refused(f"{had}: again, or an instructor's next NAME goes on anyway")

    def write(self, asked: Request) -> Reply:
        """Answer the order ``debrief``: have one written."""
        station = asked.station
        if self.debriefing is None or self.kept is None:
            return Refused("no debrief: this session is not recorded")
        if not self.control.time.frozen:
            return Refused("a debrief takes some seconds: first freeze, or end exercise")
        if station.role is TRAINEE_ROLE and not self.ending.over:
            return Refused("a debrief tells what is hidden: first end exercise")
        if not self._pen.acquire(blocking=False):
            return Refused("one is being written: it is told here when it is done")
        write, kept, branch = self.debriefing.write, self.kept, self._flushed_branch()
        ending = self.ending.over

        def note_share(done: str) -> None:
            fact = Fact("debriefing", done)
            self.work.post(lambda: self._note([fact], station))

        def write_alone() -> WrittenDebrief:
            try:
                return write(
                    kept, branch, self.work.closing, lambda done: note_share(f"{done:.2f}")
                )
            finally:
                note_share("")
                self._pen.release()

        def take(debrief: WrittenDebrief) -> None:
            stands = bool(ending) and self.ending.over == ending  # else they are of another run
            self.debrief = debrief = debrief if stands else debrief._replace(minutes=())
            page = Fact("debrief", debrief.page)
            kind = "marks" if station.role is TRAINEE_ROLE else "exercise"
            self.log.tell(kind, f"debrief written: {debrief.page}", fact=page)
            self._note(debrief.facts, station)

        self.work.begin("debrief", write_alone, take, partial(self._give_up, "debrief"))
        return f"the debrief of branch {branch} is being written"

    def follow(self, _moment: Moment) -> None:
        """Forget marks and debrief, because time has jumped."""
        self.found = self.debrief = None
        self.released = False

    @property
    def _missing(self) -> Refused | None:
        """Return why this exercise ends without marks, None where it has some."""
        if self.debriefing is None or self.kept is None:
            return UNRECORDED_REFUSAL
        return None if self.scored else Refused("nothing in this exercise has marks")

    def _flushed_branch(self) -> int:
        """Return the present branch, written whole: its reader has a connection of its own."""
        recording = self.control.history.recording
        recording.flush()
        return recording.branch

    def _take(self, found: Judgement) -> None:
        """Tell the instructor the marks."""
        self.found = found
        self._tell_marks("exercise", found)
        if self.log.attended(TRAINEE) and not self.log.attended(INSTRUCTOR_ROLE.name):
            self._release(found)
        for fact in found.uncounted_facts:
            self.log.tell("exercise", f"  {fact.subject[1:]}", fact=fact)
        change = f'trainer debrief {self.kept} --change "NAME: WHAT, REASON"'
        self.log.tell("exercise", f"  to change a mark: {change}")

    def _release(self, marks: Judgement) -> None:
        """Tell everybody the marks."""
        self.released = True
        self._tell_marks("marks", marks)
        minutes = self.debrief.facts if self.debrief else []
        for station in self.log.stations:  # the marks told anew take the place of all before
            if station.role is INSTRUCTOR_ROLE:
                self.log.note(station, [*marks.uncounted_facts, *minutes])

    def _tell_marks(self, kind: str, marks: Judgement) -> None:
        """Tell the marks and their reasons, as news of that kind."""
        words = f"marks: {marks}", *(f"  {reason}" for reason in marks.reasons)
        for text, fact in zip(words, marks.facts, strict=True):
            self.log.tell(kind, text, fact=fact)

    def _give_up(self, what: str, error: Exception) -> None:
        self.log.tell("exercise", f"no {what}: {error}")

    def _note(self, facts: Sequence[Fact], asker: Station) -> None:
        """Send facts to the instructors, and to who has asked."""
        for station in self.log.stations:
            if station is asker or station.role is INSTRUCTOR_ROLE:
                self.log.note(station, facts)

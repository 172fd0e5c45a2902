"""The rules of a session: who commands, who is ready, how an exercise ends.

The session calls ``judge_tick`` after each tick, which ends the exercise or freezes time where its
rules say so. At the end time stands still at all stations, and the marks are made in a
thread, because judging a recording takes seconds, and a debrief is written in a process of its own.
The instructor gets the marks first, and releases them to the crew. The gates of ``dispatch`` ask
here whether an order is barred.
"""

# long: the end, its marks and its debrief are one state, and each order reads a part of it

import contextlib
import math
import subprocess
import threading
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from datetime import UTC, datetime
from pathlib import Path
from typing import Final, TypeVar

from trainer.boat.calls import Rank
from trainer.boat.depths import collapse_of, hull_depth
from trainer.boat.grounding import GroundCall, GroundMonitor
from trainer.boat.world.encounters import EncounterMonitor
from trainer.config.course import course, lessons
from trainer.config.files import ConfigError
from trainer.config.outcome import Outcome
from trainer.config.progress import read_progress
from trainer.io.orders.grammar import Order, Refused, Reply
from trainer.io.recording.recording import Moment
from trainer.session.aids import Aids
from trainer.session.aside import begin_aside, hear_out
from trainer.session.chair import Chair
from trainer.session.command import Command
from trainer.session.control import PRESENT_MOMENT, Control
from trainer.session.evaluation import UNRECORDED_REFUSAL
from trainer.session.event_log import EventLog
from trainer.session.exercise import (
    BackgroundTask,
    DebriefSource,
    ExerciseEnd,
    Judgement,
    NextExercises,
    WrittenDebrief,
)
from trainer.session.hints import Hints
from trainer.session.manning import unmanned_axes
from trainer.session.run_faces import JudgementScope
from trainer.session.stations.past import PastReader
from trainer.session.stations.roles import (
    INSTRUCTOR_ROLE,
    STRANGER_ROLE,
    TRAINEE,
    TRAINEE_ROLE,
    Role,
)
from trainer.session.stations.station import Duty, Fact, LongAnswer, Request, Station
from trainer.session.step_guide import StepGuide

ResultT = TypeVar("ResultT")
QUIT_AGAIN_WITHIN_S: Final = 10.0  # [s] for the second `quit`, which ends a session for others too
# roles that are not counted when the crew is asked whether it is ready
NOT_CREW: Final = (INSTRUCTOR_ROLE.name, STRANGER_ROLE.name, "observer", "visitor", TRAINEE)
# after the end of the exercise, by role
WAYS_ON: Final = {
    TRAINEE: "again, again from 2 min, next or quit",
    INSTRUCTOR_ROLE.name: "again, again from 2 min, next, debrief, release marks or quit",
}


@dataclass
class Conduct:
    """The rules of one session: who commands, who is ready, how its exercise ends."""

    control: Control
    log: EventLog
    show: Callable[[], None]  # the present moment
    wake: Callable[[], object]  # has the session's thread listen
    ending: ExerciseEnd = field(default_factory=ExerciseEnd)
    debriefing: DebriefSource | None = None
    scored: bool = False  # there is something to judge
    kept: Path | None = None  # where the session is recorded
    visitors: bool = False  # may begin the exercise again
    following: NextExercises = field(default_factory=NextExercises)
    clock: Callable[[], float] = time.monotonic
    ready: list[Station] = field(default_factory=list)
    begun: bool = False  # time has run since the start
    deserted: str = ""  # why the session ended before its time: nobody was left to say run
    halted: str = ""  # what the exercise has frozen time for, until it runs again
    hand: frozenset[str] = frozenset()  # axes that the exercise has worked by hand
    exercise: str = ""  # its name, "" for none
    trainees: tuple[str, ...] = ()  # whose progress is kept
    command: Command = field(init=False)
    guide: StepGuide = field(init=False)
    chair: Chair = field(init=False)
    aids: Aids = field(init=False)  # made where the screens' output is there, too
    hints: Hints = field(init=False)  # likewise
    work: BackgroundTask = field(init=False)
    past: PastReader = field(init=False)

    def __post_init__(self) -> None:
        self.command = Command(self.log, self.wake, self.clock)
        self.guide = StepGuide(self.control, self.log, finish=self.end_lesson)
        self.work = BackgroundTask(self.wake)
        history = self.control.history
        self.chair = Chair(self.log, history)
        history.recording.wake = self.wake
        self.ground = GroundMonitor(history.boat)
        self.past = PastReader(history.boat, self.work, self.log)
        self._remembered: tuple[int, int] | None = None  # branch and tick
        self._pen = threading.Lock()  # held while a debrief is written
        self._dossier = threading.Lock()  # held by who judges a recording: it takes 20 MB
        self._quitting: tuple[Station | None, float] = None, 0.0  # who said quit, and when [s]

    @property
    def duties(self) -> Mapping[str, Duty]:
        """Return the functions that answer the orders about the conduct of the session."""
        return {
            "end": self._end,
            "release-marks": self._release,
            "debrief": self._debrief,
            "next": self._next,
            "history": self._history,
            "hint": self.hints.ask,
            "ready": self._be_ready,
            "who": self._who,
            "command": self.command.ask,
            "give": self.command.give,
            "keep": self.command.keep,
        }

    def tend(self) -> None:
        """Tell trouble, take the results of background tasks, and pass command on if due."""
        self.log.tell_trouble()
        self.work.take_results()
        self.command.tend()

    # The end of the exercise

    def look(self) -> None:
        """End the exercise if the tick that was just computed ends it."""
        self.begun = self.control.boat.ticks > 0
        lost, ending = self.control.failure, self.ending
        if lost and ending.watched and not ending.over:
            ending.end(Outcome.LOST, f"lost at {self.control.boat.time:g} s", lost)
            self._stop()
        elif ending.look(self.control.boat):
            self._stop()
        elif not ending.over:
            self.guide.look()

    def end_lesson(self) -> None:
        """End a lesson after its last step, unless it has a time of its own."""
        if self.ending.last_tick == math.inf:
            self.ending.end(Outcome.ENDED, f"the last step is over at {self.control.boat.time:g} s")
            self._stop()

    def judge_hull(self) -> None:
        """Announce grounding or collapse, and freeze or end as the exercise says."""
        for call in self.tell_ground():
            if call.aground:
                self.halt(call.text, call.how)
        control = self.control
        if control.failure:
            return
        control.failure = collapse_of(control.boat)
        if control.failure:
            depth = hull_depth(control.boat)
            fact = Fact("collapse", f"{depth:.1f}")
            self.tell_depth(control.failure, fact, Rank.EMERGENCY)

    def tell_ground(self) -> list[GroundCall]:
        """Announce contact with the ground; return the calls."""
        calls = list(self.ground.look()) if self.ground.bottom else []
        for call in calls:
            self.tell_depth(call.text, rank=Rank.ALARM if call.aground else Rank.CAUTION)
        return calls

    def judge_tick(self, met: EncounterMonitor) -> None:
        """Judge a tick: a collision in it, and the moment at its end."""
        if self.control.history.flown.judged is JudgementScope.ALL:
            self.collide(met)
        self.judge_moment()

    def judge_moment(self) -> None:
        """Judge the present moment. Time may have jumped to it."""
        judged = self.control.history.flown.judged
        if judged is JudgementScope.ALL:
            self.judge_hull()
            self.look()
        elif judged is JudgementScope.GROUND:
            self.tell_ground()

    def collide(self, met: EncounterMonitor) -> None:
        """Freeze or end after a collision, as the exercise says."""
        if met.struck:
            self.halt(f"collision with {met.struck}", met.rules.collision)

    def halt(self, why: str, how: str) -> None:
        """Freeze time, or end the exercise as lost, as ``how`` says; another word does nothing."""
        if how == "end" and not self.ending.over:
            self.ending.end(Outcome.LOST, f"lost at {self.control.boat.time:g} s", why)
            self._stop()
        elif how == "freeze":
            self.control.time.pacer.freeze()
            self.control.steps = 0
            self.halted = why
            self.log.tell("time", f"frozen: {why}")
            self.show()

    def tell_depth(self, words: str, fact: Fact | None = None, rank: Rank | None = None) -> None:
        """Announce a depth that was reached, with its tick and its rank."""
        boat = self.control.boat
        self.log.alert("depth", f"tick {boat.ticks} ({boat.time:g} s): {words}", fact, rank)

    # The gates, for which see ``dispatch``

    def past_its_end(self, order: Order, role: Role, *, after_end: bool) -> Refused | None:
        """Return why the end of the exercise bars an order, None if it does not."""
        if not self.ending.over:
            return None
        if order.name == "again" and order.subject == PRESENT_MOMENT:
            return Refused(
                "here is the end of the exercise: again from 2 min, or from a moment kept"
            )
        way_on = WAYS_ON.get(role.name, "the instructor goes on")
        return None if after_end else Refused(f"the exercise is over: {way_on}")

    def unconfirmed(self, station: Station) -> Refused | None:
        """Return why ``quit`` has to be said again, None where it need not be.

        It ends the session for all, so it has to be said twice where others are attached.
        """
        others = sum(1 for each in self._others(station))
        who, when = self._quitting
        if not others or (who is station and self.clock() - when <= QUIT_AGAIN_WITHIN_S):
            return None
        self._quitting = station, self.clock()
        attached = "1 station is" if others == 1 else f"{others} stations are"
        within = f"type quit again within {QUIT_AGAIN_WITHIN_S:g} s to end it for all, or detach"
        return Refused(f"{attached} attached: {within}")

    def go_on(self, order: Order) -> None:
        """Note that time goes on; announce who of the crew is not ready."""
        self.halted = ""
        late = [each.who for each in self._crew() if each not in self.ready]
        if late and not self.begun and order.name == "run":
            self.log.tell("station", f"not ready: {', '.join(late)}")

    def follow(self, moment: Moment) -> None:
        """Forget a halt and groundings, and at the start who is ready."""
        self.halted = ""
        self.ground.reset()
        if moment.tick == 0:
            self.begun = False
            self.ready.clear()

    def outcome_for(self, role: Role) -> list[Fact]:
        """Return the facts of the end for a newcomer, with marks its role may see."""
        ending = self.ending
        if not ending.over:
            return []
        facts = [Fact("exercise-over", ending.outcome)]
        if ending.marks and (ending.released or role is INSTRUCTOR_ROLE):
            facts.append(Fact("marks", ending.marks.fields))
            facts += [Fact("reason", fields) for fields in ending.marks.reason_fields]
            facts += ending.marks.uncounted_facts if role is INSTRUCTOR_ROLE else []
        elif self._unmarked:
            facts.append(Fact("marks", f"{ending.outcome},"))
        if ending.debrief and role is INSTRUCTOR_ROLE:
            facts.append(Fact("debrief", ending.debrief.page))
            facts += minute_facts(ending.debrief)
        return facts

    def desert(self) -> None:
        """Announce that nobody is left to say run, unless the exercise is over."""
        if self.ending.over:
            return
        cause = f" by {self.halted}" if self.halted else ""
        seconds = self.control.boat.time
        self.deserted = f"frozen at {seconds:g} s{cause}, and nobody is left to say run"
        self.log.tell("time", self.deserted)

    def final_marks(self) -> Judgement | None:
        """Return the marks of the branch that was flown last. Its recording has to be closed."""
        judged = self.debriefing and self.kept and self.scored and self.control.boat.ticks
        if self.ending.marks or not (judged and self.debriefing and self.kept):
            return self.ending.marks
        try:
            return self.debriefing.judge(self.kept, self.control.history.recording.branch)
        except Exception:  # noqa: BLE001 the summary is printed even if the marks fail
            return None

    def _stop(self) -> None:
        """Freeze time, announce the end, and begin judging in a thread."""
        self.control.time.pacer.freeze()
        self.control.steps = 0
        ending = self.ending
        over_fact = Fact("exercise-over", ending.outcome)
        self.log.tell("time", f"EXERCISE OVER: {ending.over}", fact=over_fact)
        if ending.why:
            self.log.tell("exercise", f"lost: {ending.why}")
        self.show()
        self.remember()
        if unmarked := self._unmarked:
            fact = Fact("marks", f"{ending.outcome},")
            self.log.tell("time", f"no marks: {unmarked.reason}", fact=fact)
        elif self.debriefing and self.kept:
            self._begin_judging(self.debriefing.judge, self.kept)

    def remember(self) -> None:
        """Have a process put this run into the files of its trainees."""
        recording, boat = self.control.history.recording, self.control.boat
        place = recording.branch, boat.ticks
        words = self.debriefing.progress if self.debriefing else ()
        if not (words and self.kept and self.trainees and boat.ticks) or place == self._remembered:
            return
        self._remembered = place
        recording.flush()
        how = Outcome.DONE if self.guide.over else self.ending.outcome or Outcome.LEFT
        whole = (*words, str(self.kept), str(recording.branch), how)

        def hear() -> str:
            process = begin_aside(whole)
            try:
                return hear_out(process, self.work.closing, 0.0)[0].decode().strip()
            except subprocess.TimeoutExpired:
                return ""  # a session that ends leaves it to itself

        def tell(text: str) -> None:
            if text:
                self.log.tell("exercise", text)

        self._begin("progress", hear, tell)

    @property
    def _unmarked(self) -> Refused | None:
        """Return why this exercise ends without marks, None where it has some."""
        if self.debriefing is None or self.kept is None:
            return UNRECORDED_REFUSAL
        return None if self.scored else Refused("nothing in this exercise has marks")

    def _begin_judging(self, judge: Callable[[Path, int], Judgement], kept: Path) -> None:
        recording = self.control.history.recording
        recording.flush()  # the judge reads the file by a connection of its own
        branch, ending = recording.branch, self.ending.over

        def judged(marks: Judgement) -> None:
            if self.ending.over == ending:  # else time has gone back, and the marks are of no use
                self._judged(marks)

        def judge_alone() -> Judgement:
            with self._dossier:
                return judge(kept, branch)

        self._begin("marks", judge_alone, judged)

    def _begin(
        self, what: str, make: Callable[[], ResultT], take: Callable[[ResultT], None]
    ) -> None:
        """Make something in a thread and take it, or announce why there is none."""

        def task() -> Callable[[], None]:
            try:
                made = make()
            except Exception as error:  # noqa: BLE001 whatever it is, the session goes on
                why = f"no {what}: {error}"
                return lambda: self.log.tell("exercise", why)
            return lambda: take(made)

        self.work.begin(what, task)

    def _judged(self, found: Judgement) -> None:
        """Tell the instructor the marks."""
        self.ending.marks = found
        self.log.tell("exercise", f"marks: {found}", fact=Fact("marks", found.fields))
        change = f'  to change a mark: trainer debrief {self.kept} --change "NAME: WHAT, REASON"'
        self._tell_reasons("exercise", found)
        if self.log.attended(TRAINEE) and not self.log.attended(INSTRUCTOR_ROLE.name):
            self._release_marks(found)
        for fact in found.uncounted_facts:
            self.log.tell("exercise", f"  {fact.subject[1:]}", fact=fact)
        self.log.tell("exercise", change)

    def _tell_reasons(self, kind: str, found: Judgement) -> None:
        """Tell the reasons of the marks, as news of that kind."""
        for reason, fields in zip(found.reasons, found.reason_fields, strict=True):
            self.log.tell(kind, f"  {reason}", fact=Fact("reason", fields))

    def _end(self, asked: Request) -> Reply:
        boat = self.control.boat
        self.ending.end(Outcome.ENDED, f"ended at {boat.time:g} s by the {asked.station.who}")
        self._stop()
        return "the exercise is over"

    def _release(self, _asked: Request) -> Reply:
        ending = self.ending
        if not ending.over:
            return Refused("the exercise is not over: type end exercise first")
        if ending.marks is None:
            return self._unmarked or Refused("there are no marks yet")
        self._release_marks(ending.marks)
        return "everybody has the marks"

    def _release_marks(self, marks: Judgement) -> None:
        """Tell everybody the marks."""
        self.ending.released = True
        self.log.tell("marks", f"marks: {marks}", fact=Fact("marks", marks.fields))
        self._tell_reasons("marks", marks)
        written = self.ending.debrief
        minutes = minute_facts(written) if written else []
        for station in self.log.stations:  # the marks told anew take the place of all before
            if station.role is INSTRUCTOR_ROLE:
                self.log.note(station, [*marks.uncounted_facts, *minutes])

    def _debrief(self, asked: Request) -> Reply:
        if self.debriefing is None or self.kept is None:
            return Refused("no debrief: this session is not recorded")
        if not self.control.time.frozen:
            return Refused("a debrief takes some seconds: first freeze, or end exercise")
        if asked.station.role is TRAINEE_ROLE and not self.ending.over:
            return Refused("a debrief tells what is hidden: first end exercise")
        if not self._pen.acquire(blocking=False):
            return Refused("one is being written: it is told here when it is done")
        write, recording_path = self.debriefing.write, self.kept
        recording = self.control.history.recording
        recording.flush()
        branch, ending = recording.branch, self.ending.over

        def note_share(done: str) -> None:
            fact = Fact("debriefing", done)
            self.work.post(lambda: self._note([fact], asked.station))

        def share(done: float) -> None:
            note_share(f"{done:.2f}")

        def write_alone() -> WrittenDebrief:
            try:
                return write(recording_path, branch, self.work.closing, share)
            finally:
                note_share("")
                self._pen.release()

        def written(debrief: WrittenDebrief) -> None:
            stands = bool(ending) and self.ending.over == ending  # else they are of another run
            debrief = debrief if stands else debrief._replace(minutes=())
            self.ending.debrief = debrief
            page = Fact("debrief", debrief.page)
            kind = "marks" if asked.station.role is TRAINEE_ROLE else "exercise"
            self.log.tell(kind, f"debrief written: {debrief.page}", fact=page)
            self._note(minute_facts(debrief), asked.station)

        self._begin("debrief", write_alone, written)
        return f"the debrief of branch {branch} is being written"

    def _note(self, facts: Sequence[Fact], asker: Station) -> None:
        """Send facts to the instructors, and to who has asked."""
        for station in self.log.stations:
            if station is asker or station.role is INSTRUCTOR_ROLE:
                self.log.note(station, facts)

    # What follows

    def _next(self, asked: Request) -> Reply | LongAnswer:
        name = asked.order.subject
        reason = ""
        if asked.station.role is TRAINEE_ROLE and not name:
            name, reason = self._following()
            if not name:
                return Refused("this is the last of the course")
        if not name:
            names = [each.name for each in course()]
            return LongAnswer(names, "type next NAME to begin one of these")
        if refused := self._no_next(name):
            return refused
        self.log.tell("time", "the next exercise is being made ready")
        for station in self.log.stations:  # the file's name may tell what is hidden
            name_told = name if station.role is INSTRUCTOR_ROLE else ""
            self.log.note(station, [Fact("next", name_told)])
        self.control.following, self.control.ended = name, True
        return f"next: {asked.order.subject or reason}"

    def _following(self) -> tuple[str, str]:
        """Return what is best flown next, and why; "" for none.

        That is the weakest and longest ago of who trains, else what follows in the course.
        """
        offered = [*lessons(), *course()]
        if self.trainees:
            with contextlib.suppress(ConfigError):  # a file that cannot be read tells nothing
                others = [each for each in offered if each.name != self.exercise]
                progress = read_progress(self.trainees[0])
                if suggestion := progress.suggest(others, datetime.now(UTC).date()):
                    return suggestion.lesson.name, suggestion.reason
        names = [each.name for each in offered]
        after = names[names.index(self.exercise) + 1 :] if self.exercise in names else names
        return (after[0], "the one after this") if after else ("", "")

    def lessons_done(self) -> str:
        """Return the lessons of who trains, as ``planes-and-bubble:done``; "" for none."""
        if not self.trainees:
            return ""
        with contextlib.suppress(ConfigError):  # a file that cannot be read tells nothing
            progress = read_progress(self.trainees[0])
            best = ((each.name, progress.best(each.name)) for each in lessons())
            return ",".join(f"{name}:{how}" for name, how in best if how)
        return ""

    def _no_next(self, name: str) -> Refused | None:
        """Return why that exercise cannot follow, None if it can."""
        elsewhere = self.following.barred
        if not elsewhere and not all(each.visits for each in self.log.stations):
            elsewhere = Refused("this session has lines of its own")
        if elsewhere:
            return Refused(f"{elsewhere.reason}: quit, then trainer run {name}")
        if not self.ending.over:
            return Refused("this exercise is not over: type end exercise first")
        return self.following.problem(name)

    def _history(self, asked: Request) -> None:
        self.past.answer(asked, self.control.history, self.kept)

    # Who is there

    def _who(self, asked: Request) -> LongAnswer:
        """Return the account of every station; tell a program the same in facts."""
        stations = self.log.stations
        facts = [Fact("stations", str(len(stations)))]
        facts += [Fact("aboard", self._aboard(each, asked.station)) for each in stations]
        self.log.note(asked.station, facts)
        return LongAnswer([each.account() for each in stations])

    def _aboard(self, station: Station, asker: Station) -> str:
        """Return the fields that tell a program about an attached station."""
        marks = {
            "you": station is asker,
            "command": station.role is INSTRUCTOR_ROLE and not self.command.elsewhere(station),
            "ready": station in self.ready,
        }
        told = " ".join(mark for mark, holds in marks.items() if holds)
        return f"{station.role.name},{station.called},{told},{station.line.name}"

    def _be_ready(self, asked: Request) -> Reply:
        station = asked.station
        if self.begun:
            return Refused("the exercise has begun")
        if station not in self.ready:
            self.ready.append(station)
        awaited = self._awaited()
        fact = Fact("ready", station.who)
        self.log.tell("station", f"{station.who} is ready{awaited}", station, fact)
        return f"ready{awaited}"

    def _awaited(self) -> str:
        """Return who is not ready yet; if all are, the axes that have nobody to work them."""
        late = [station.who for station in self._crew() if station not in self.ready]
        if late:
            return f"; not ready: {', '.join(late)}"
        unmanned = unmanned_axes(self.hand, self.log.attended)
        return f"; nobody mans the {' and the '.join(unmanned)}" if unmanned else "; everybody is"

    def _crew(self) -> list[Station]:
        """Return the stations of the crew, which are asked whether they are ready."""
        return [each for each in self.log.stations if each.role.name not in NOT_CREW]

    def _others(self, station: Station) -> list[Station]:
        """Return the other stations that came by themselves and said who they are."""
        visitors = [each for each in self.log.stations if each.visits and each.settled]
        return [each for each in visitors if each is not station and not each.line.ended]


def minute_facts(debrief: WrittenDebrief) -> list[Fact]:
    """Return what each minute cost, as reasons of the marks with their times [s]."""
    return [Fact("reason", f"{seconds:g},{told}") for seconds, told in debrief.minutes]

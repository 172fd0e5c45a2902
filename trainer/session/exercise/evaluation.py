"""What a careful crew could still earn from here, told to the instructor alone.

``debrief/live/evaluator`` finds it in a process of its own, which this module starts once an
instructor is there. A thread hands it the present moment every 10 s of exercise time, and when
time stands still. A tick leaves a moment in a slot and waits for nothing: one that comes before the
last has been answered takes its place, and is counted. Without a recording there is no evaluation.
"""

import base64
import contextlib
import json
import subprocess
import threading
from collections import deque
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import IO, Any, Final, cast

from trainer.config.exercise.outcome import Outcome
from trainer.io.orders.grammar import Order, Refused, Reply, parse
from trainer.io.orders.words import BOAT_ORDERS
from trainer.io.recording.recording import Moment
from trainer.io.status_line import clock
from trainer.session.aside import BackgroundTask, begin_aside
from trainer.session.past.history import History
from trainer.session.past.plan import Plan
from trainer.session.stations.event_log import EventLog
from trainer.session.stations.roles import INSTRUCTOR_ROLE
from trainer.session.stations.station import Fact, Request

MOMENT_PERIOD_S: Final = 10.0  # [s] of exercise time from moment to moment
TOLD_FALL_MARKS: Final = 10.0  # [%] of marks from which a fall is told in words
UNRECORDED_REFUSAL: Final = Refused("this session is not recorded")
MAX_STARTS: Final = 3  # of a process that dies


def why_unfit(plan: Plan) -> Refused | None:
    """Return why an exercise has no evaluation, None if it may have one."""
    if not plan.title:
        return Refused("the boat sails freely")
    if not plan.crew.rules:
        return Refused("this exercise has no reference crew")
    return None if plan.duration is not None else Refused("this exercise has no end")


Heard = Callable[[Mapping[str, Any] | Refused], None]  # takes an answer, or why there is none


@dataclass(frozen=True)
class Question:
    """A moment of which marks, a ``hint`` or the ``way`` on are asked."""

    moment: Moment
    seconds: float
    wants: str = "marks"
    order: str = ""  # with which the marks are asked too
    heard: Heard | None = None  # None: the marks are told to the instructors


class EvaluatorProcess:
    """The process that answers. It gives way to everything else on the machine."""

    def __init__(self, words: Sequence[str]) -> None:
        """Start it; OSError where the system has no room for it."""
        self._process = begin_aside(words, stdin=subprocess.PIPE)

    def ask(self, question: Question) -> Mapping[str, Any] | None:
        """Return the answer, however long it takes; None if the process has ended."""
        moment = question.moment
        line = {
            "branch": moment.branch,
            "tick": moment.tick,
            "after": moment.after,
            "state": base64.b64encode(moment.state).decode(),
            "wants": question.wants,
            "order": question.order,
        }
        sending = cast("IO[bytes]", self._process.stdin)
        hearing = cast("IO[bytes]", self._process.stdout)
        try:
            sending.write(json.dumps(line).encode() + b"\n")
            sending.flush()
            answer = json.loads(hearing.readline())
        except (OSError, ValueError):
            return None
        return answer if isinstance(answer, dict) else None

    def end(self) -> int:
        """End it, and return its exit code."""
        self._process.kill()
        return self._process.wait()


@dataclass
class Evaluation:
    """The evaluation of one run. While ``words`` and ``kept`` are empty there is none."""

    history: History
    log: EventLog
    work: BackgroundTask
    barred: Callable[[Order], Refused | None] = lambda _: None  # why the crew may not have an order
    over: Callable[[], object] = bool  # whether the exercise is
    words: Sequence[str] = ()  # the command of the process
    kept: Path | None = None  # the recording
    why_none: Refused | None = UNRECORDED_REFUSAL
    latest: Fact | None = None  # for who comes: what is known of the run, or why nothing is
    left_out: int = 0  # moments that came too soon
    _due: int = 0  # the tick of the next moment
    _given: tuple[int, int, int] | None = None  # branch, tick and order of the last moment
    _slot: deque[Question] = field(default_factory=lambda: deque(maxlen=1))
    _asked: deque[Question] = field(default_factory=deque)
    _news: threading.Event = field(default_factory=threading.Event)
    _thread: threading.Thread | None = None
    _process: EvaluatorProcess | None = None
    _behind: bool = False
    _free: int = 0  # the branch that was told to have no marks
    _best: tuple[int, float, float] | None = None  # branch, marks [%] and time [s] told last

    def begin(self, words: Sequence[str], kept: Path | None, plan: Plan) -> None:
        """Evaluate a run of a plan by a command, once an instructor is there."""
        self.why_none = why_unfit(plan) or (None if words and kept else UNRECORDED_REFUSAL)
        if self.why_none and plan.title:
            self.latest = Fact("no-attainable", self.why_none.reason)
        self.words, self.kept = words, kept

    def follow(self, moment: Moment) -> None:
        """Have the next moment handed over, because time has jumped."""
        self._due = moment.tick

    def look(self) -> None:
        """Hand over the moment after this tick if it is due."""
        if self.history.tick >= self._due or self._given is None:
            self.hand_over()

    def hand_over(self) -> None:
        """Leave the present moment for the process, unless it has it; wait for nothing."""
        if self.why_none or self.over() or not self.log.attended(INSTRUCTOR_ROLE.name):
            return
        history = self.history
        step = history.boat.method.step
        period = max(round(MOMENT_PERIOD_S / step), 1)
        self._due = (history.tick // period + 1) * period
        moment = history.now()
        here = moment.branch, moment.tick, moment.after
        if history.flown.replaying or history.flown.shows_way or here == self._given:
            return
        self._given = here
        if self._slot:
            self.left_out += 1
            if not self._behind:
                self._behind = True
                self._tell("the evaluation is behind: it leaves moments out")
        self._slot.append(Question(moment, history.boat.time))
        self._wake()

    def ask(self, asked: Request) -> Reply | None:
        """Answer ``what if ORDER`` later, by what the process says; refuse what it cannot."""
        order = parse(asked.order.subject)
        if not isinstance(order, Order) or order.name not in BOAT_ORDERS:
            return Refused(f"what if {asked.order.subject}: only of orders that move the boat")
        if refused := self.barred(order):
            return refused
        heard = partial(self._tell_what_if, asked, order.text, self.history.boat.time)
        return self.consult(heard, order=order.text)

    def consult(self, heard: Heard, wants: str = "marks", order: str = "") -> Refused | None:
        """Have something found of this moment; refuse where there is no evaluation."""
        if self.why_none:
            return Refused(f"no evaluation: {self.why_none.reason}")
        moment, seconds = self.history.now(), self.history.boat.time
        self._asked.append(Question(moment, seconds, wants, order, heard))
        self._wake()
        return None

    def status(self) -> str:
        """Return what is known, in a line."""
        if self.why_none or self.latest is None:
            return f"evaluation: {self.why_none.reason if self.why_none else 'not yet known'}"
        if self.latest.what == "no-attainable":
            return f"evaluation: {self.latest.subject}"
        seconds, marks, so_far, _, branch, left_out, *beyond = self.latest.subject.split(",")
        behind = f", {left_out} moments left out" if self.left_out else ""
        return (
            f"could still earn {float(marks):.0f} marks, {float(so_far):.0f} so far "
            f"(at {clock(float(seconds))}, branch {branch}{behind})"
            f"{basis_text(*beyond)}"
        )

    @property
    def facts(self) -> list[Fact]:
        """Return what an instructor who comes is told."""
        return [] if self.latest is None else [self.latest]

    def finish(self) -> None:
        """End the process, whatever it is at."""
        self.why_none = self.why_none or Refused("the session is over")
        self._news.set()
        if self._process is not None:
            self._process.end()
        if self._thread is not None:
            self._thread.join()

    # In the thread beside the ticks

    def _wake(self) -> None:
        self._news.set()
        if self._thread is None:
            self._thread = threading.Thread(target=self._serve, name="evaluation", daemon=True)
            self._thread.start()

    def _serve(self) -> None:
        """Have one question after another answered, until the session ends."""
        starts = 0
        while not self.why_none:
            self._news.wait()
            self._news.clear()
            while not self.why_none and (question := self._next()) is not None:
                starts += self._process is None
                if self._process is None and not self._start(last=starts > MAX_STARTS):
                    break
                answer = (
                    self._process.ask(question) if self._process and not self.why_none else None
                )
                if answer is None:
                    self._mourn(question)
                else:
                    self._post(self._take, question, answer)
        if self._process is not None:
            self._process.end()

    def _next(self) -> Question | None:
        for waiting in (self._asked, self._slot):
            with contextlib.suppress(IndexError):
                return waiting.popleft()
        return None

    def _start(self, *, last: bool) -> bool:
        """Start the process, unless it has died too often; return whether it is there."""
        why = f"its process has ended {MAX_STARTS} times" if last else ""
        if not last:
            try:
                self._process = EvaluatorProcess((*self.words, str(self.kept)))
            except OSError as error:
                why = f"its process cannot begin: {error.strerror}"
        if why:
            self._post(self._give_up, why)
            self.why_none = Refused(why)
        return not why

    def _mourn(self, question: Question) -> None:
        """Tell that the process has ended, and let the next question start another."""
        code = self._process.end() if self._process else 0
        self._process = None
        if not self.why_none:
            self._post(self._lost, question, f"the evaluation's process has ended with {code}")

    def _post(self, call: Callable[..., None], *words: Any) -> None:
        self.work.post(lambda: call(*words))

    # In the session's thread

    def _take(self, question: Question, answer: Mapping[str, Any]) -> None:
        """Tell the instructors an answer."""
        if why := answer.get("why", ""):
            self._refuse(question, why)
            self._give_up(why)
        elif free := answer.get("free", ""):
            self._take_free(question, free)
        elif question.heard:
            question.heard(answer)
        else:
            self._take_marks(question, answer)

    def _refuse(self, question: Question, why: str) -> None:
        if question.heard:
            question.heard(Refused(f"no evaluation: {why}"))

    def _take_free(self, question: Question, why: str) -> None:
        """Tell once that a branch has no marks. After a jump back there may be marks again."""
        self._refuse(question, why)
        branch = self.history.recording.branch
        if question.moment.branch == branch != self._free:
            self._free = branch
            self._note(Fact("no-attainable", why))
            self._tell(f"no evaluation: {why}")

    def _take_marks(self, question: Question, answer: Mapping[str, Any]) -> None:
        branch, marks, seconds = question.moment.branch, answer["marks"], question.seconds
        if branch != self.history.recording.branch:
            return  # time has gone back meanwhile
        either = Outcome.LOST if answer["lost"] else Outcome.OPEN
        outcome = Outcome.WON if answer["won"] else either
        numbers = f"{seconds:.3f},{marks:.1f},{answer['so_far'] or 0.0:.1f}"
        beyond = answer.get("beyond", "")
        last = f",{beyond}" if beyond else ""
        self._note(Fact("attainable", f"{numbers},{outcome},{branch},{self.left_out}{last}"))
        if self._behind and not self._slot:
            self._behind = False
            self._tell(f"the evaluation has caught up; left out so far: {self.left_out}")
        told = self._best if self._best and self._best[0] == branch else None
        if told is None or marks > told[1]:
            self._best = branch, marks, seconds
        elif marks <= told[1] - TOLD_FALL_MARKS and seconds > told[2]:
            fall = f"{told[1] - marks:.0f} less than at {clock(told[2])}"
            could = f"{clock(seconds)}: {marks:.0f} marks could still be earned, {fall}"
            self._tell(could + basis_text(beyond))
            self._best = branch, marks, seconds

    def _tell_what_if(
        self, asked: Request, text: str, seconds: float, answer: Mapping[str, Any] | Refused
    ) -> None:
        """Answer ``what if``; the other instructors hear of it, and the recording keeps it."""
        none = answer if isinstance(answer, Refused) else None
        reply = none or answer_in_words(text, seconds, cast("Mapping[str, Any]", answer))
        asked.station.answer(asked, reply)
        if not isinstance(reply, Refused):
            self.log.tell("exercise", f"what if: {reply}", asked.station)

    def _lost(self, question: Question, why: str) -> None:
        if question.heard:
            question.heard(Refused(f"{why}: ask again"))
        self._tell(f"{why}; it begins again")

    def _give_up(self, why: str) -> None:
        """Tell once that there is no evaluation; whoever has asked meanwhile is refused."""
        self.why_none = Refused(why)
        self._news.set()  # the thread ends
        self._note(Fact("no-attainable", why))
        self._tell(f"no evaluation: {why}")
        while self._asked:
            self._refuse(self._asked.popleft(), why)

    def _note(self, fact: Fact) -> None:
        """Send programs of instructors a fact that nobody has to read."""
        self.latest = fact
        for station in self.log.stations:
            if station.role is INSTRUCTOR_ROLE:
                self.log.note(station, [fact])

    def _tell(self, text: str) -> None:
        self.log.tell("exercise", text)


def basis_text(beyond: str = "") -> str:
    """Return what marks stand on where the instructor has ordered something else."""
    return f"; for the exercise's own orders, not for `{beyond}`" if beyond else ""


def answer_in_words(order: str, seconds: float, answer: Mapping[str, Any]) -> Reply:
    """Return the marks with and without an order in a line."""
    if why := answer.get("refused", ""):
        return Refused(f"{order}: {why}")
    return (
        f"with `{order}` and no other for 30 s: {answer['with']:.0f}, "
        f"without: {answer['marks']:.0f} "
        f"(from {clock(seconds)})"
    )

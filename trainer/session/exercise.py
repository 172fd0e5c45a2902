"""The end of an exercise: its moment, its outcome, and the marks.

The instructor gets the marks first. At the end time stands still at all stations, and the session
lives on. The functions that judge a recording and write its debrief come from the command line,
because this package may not import ``debrief``. Threads of their own call them.
"""

import math
import threading
import time
from collections import deque
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from itertools import zip_longest
from pathlib import Path
from typing import Final, NamedTuple

from trainer.boat.boat import STATE_PLACES, Boat
from trainer.boat.casualties import scale_of
from trainer.boat.grounding import clearance
from trainer.boat.limits import height_showing, is_deep, over_ground
from trainer.boat.world.scope import eye_height
from trainer.config.condition import STATE_QUANTITIES
from trainer.config.derived import Condition, Loss
from trainer.config.files import ConfigError
from trainer.config.outcome import Outcome
from trainer.io.orders.grammar import Refused
from trainer.io.recording.recording import Moment
from trainer.session.stations.station import Fact

CLOSE_TIMEOUT_S: Final = 20.0  # [s] at the end, for marks and pages
CAPSIZE_ANGLES_RAD: Final = math.radians(60.0), math.radians(45.0)  # [rad] heel and pitch: lost
PHI_PLACE, THETA_PLACE = STATE_PLACES["phi"], STATE_PLACES["theta"]


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
    def reason_fields(self) -> list[str]:
        """Return the fields of each reason for programs, its time [s] first."""
        times = ("" if time is None else f"{time:g}" for time in self.times)
        pairs = zip_longest(times, self.reasons, fillvalue="")
        return [",".join(pair) for pair in pairs]

    @property
    def uncounted_facts(self) -> list[Fact]:
        """Return the facts of the measures that do not count, which the instructor is told."""
        return [Fact("reason", f",{name}: does not count") for name in self.uncounted]


class WrittenDebrief(NamedTuple):
    """A debrief: its file, and what each minute cost, each with its time [s]."""

    page: str
    minutes: Sequence[tuple[float, str]] = ()


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
class LossMonitor:
    """The monitor of one losing condition, which loses when it has held long enough."""

    loss: Loss
    ticks: int  # for which they have to hold
    held: int = 0  # ticks for which they have held
    ends: set[bytes] = field(default_factory=set)  # states in which they lost the exercise

    @classmethod
    def of(cls, loss: Loss, boat: Boat) -> "LossMonitor":
        """Return the monitor of a losing condition for a boat."""
        return cls(loss, max(math.ceil(loss.seconds / boat.method.step - 1e-9), 0))

    def look(self, boat: Boat) -> bool:
        """Return whether the condition has lost the exercise after this tick."""
        holds = all(is_met(each, boat) for each in self.loss.conditions)
        self.held = self.held + 1 if holds else 0
        if self.held <= self.ticks:
            return False
        self.ends.add(boat.plain.tobytes())
        return True

    def follow(self, moment: Moment) -> None:
        """Count anew after a jump, unless that very moment has lost the exercise."""
        self.held = self.ticks if moment.state in self.ends else 0


def is_met(condition: Condition, boat: Boat) -> bool:
    """Return whether a condition holds now; False if the boat lacks its quantity."""
    value = quantity_of(boat, condition.quantity)
    beyond = condition.sense * (value - condition.threshold)
    return beyond > 0.0 if condition.strict else beyond >= 0.0


def quantity_of(boat: Boat, name: str) -> float:
    """Return the true value of a condition's quantity [SI]. NaN if the boat lacks it."""
    if name == "showing":
        return -math.inf if is_deep(boat) else height_showing(boat)
    if measure := {"eye": eye_height, "clearance": clearance}.get(name):
        return measure(boat)
    if name == "course":
        return boat.plain[STATE_PLACES["psi"]] % math.tau
    if name == "heavy":
        return (boat.plain[STATE_PLACES["weight"]] - float(boat.vessel.buoyancy)) / float(
            boat.vessel.g
        )
    if name == "speed_over_ground":
        return over_ground(boat.state)
    factor = scale_of(boat, name)
    return boat.plain[STATE_PLACES[STATE_QUANTITIES[name].place]] / factor if factor else math.nan


@dataclass
class ExerciseEnd:
    """The end of one exercise: over or not, and why."""

    last_tick: float = math.inf  # at which its time is up
    lost: Sequence[LossMonitor] = ()
    over: str = ""  # when and by whom, once it is
    why: str = ""  # it is lost: for the instructor, since it may tell what is hidden
    outcome: Outcome = Outcome.UNDECIDED  # LOST or ENDED, once it is
    marks: Judgement | None = None  # once they are there
    released: bool = False
    debrief: WrittenDebrief | None = None  # once it is written

    @classmethod
    def of(cls, boat: Boat, losses: Sequence[Loss], seconds: float | None) -> "ExerciseEnd":
        """Return the end of an exercise of so many ``seconds``, lost by any of these."""
        last = math.inf if seconds is None else round(seconds / boat.method.step)
        return cls(last, tuple(LossMonitor.of(each, boat) for each in losses))

    @property
    def watched(self) -> bool:
        """Return whether the exercise can end by itself, by its time or by a loss."""
        return bool(self.lost) or self.last_tick < math.inf

    def look(self, boat: Boat) -> bool:
        """Return whether the exercise ends with this tick; ``over`` tells why."""
        if self.over or not self.watched:
            return False
        if why := self._lost(boat):
            self.end(Outcome.LOST, f"lost at {boat.time:g} s", why)
        elif boat.ticks >= self.last_tick:
            self.end(Outcome.ENDED, f"time is up at {boat.time:g} s")
        return bool(self.over)

    def end(self, outcome: Outcome, when: str, why: str = "") -> None:
        """End the exercise."""
        self.outcome, self.over, self.why = outcome, when, why

    def follow(self, moment: Moment) -> None:
        """Begin it again, because time has jumped."""
        self.over = self.why = ""
        self.debrief = None
        self.outcome = Outcome.UNDECIDED
        for loss in self.lost:
            loss.follow(moment)
        self.marks, self.released = None, False

    def _lost(self, boat: Boat) -> str:
        """Return the condition that loses the exercise now, "" for none."""
        # A list, not the first match: each monitor has to count its ticks at every tick.
        lost = [each.loss.text for each in self.lost if each.look(boat)]
        heel, pitch = CAPSIZE_ANGLES_RAD
        turned = abs(boat.plain[PHI_PLACE]) > heel or abs(boat.plain[THETA_PLACE]) > pitch
        return lost[0] if lost else ("turned over" if turned else "")


@dataclass
class BackgroundTask:
    """Tasks in threads, and the calls that the session's thread makes with their results.

    A tick cannot wait for a task that takes seconds, such as marks. A result is handed over as a
    call, so that only the session's thread ever changes the session.
    """

    wake: Callable[[], object]  # has the session's thread call ``take_results``
    done: deque[Callable[[], None]] = field(default_factory=deque)
    closing: threading.Event = field(default_factory=threading.Event)
    threads: list[threading.Thread] = field(default_factory=list)

    def begin(self, name: str, task: Callable[[], Callable[[], None]]) -> None:
        """Do ``task`` in a thread. The session's thread then calls what it returns."""

        def run() -> None:
            self.post(task())

        thread = threading.Thread(target=run, name=name, daemon=True)
        self.threads = [each for each in self.threads if each.is_alive()] + [thread]
        thread.start()

    def post(self, call: Callable[[], None]) -> None:
        """Hand a call to the session's thread. Any thread may do so."""
        self.done.append(call)
        self.wake()

    def take_results(self) -> None:
        """Make the calls of the tasks that are done. Only the session's thread does so."""
        while self.done:
            self.done.popleft()()

    def finish(self) -> None:
        """Tell tasks that wait to give up, wait for the rest, and make their calls."""
        self.closing.set()
        end = time.monotonic() + CLOSE_TIMEOUT_S
        for thread in self.threads:
            thread.join(max(end - time.monotonic(), 0.0))
        self.take_results()


@dataclass(frozen=True)
class NextExercises:
    """The exercises that may follow in this process, or why another process is needed."""

    load: Callable[[str], object] = str  # ConfigError if it cannot
    barred: Refused | None = Refused("this session is one run")  # noqa: RUF009 (it is frozen)

    def problem(self, name: str) -> Refused | None:
        """Return why an exercise cannot be loaded, None if it can."""
        try:
            self.load(name)
        except ConfigError as error:
            return Refused(str(error))
        return None

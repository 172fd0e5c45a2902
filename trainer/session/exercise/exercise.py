"""The end of an exercise: when it comes, who ends it, and what it bars.

An exercise ends when its time is up, when it is lost, after the last step of a lesson, or when it
is ordered to. At the end time stands still at all stations, and the session lives on. The gates of
``dispatch`` ask here whether the end bars an order. The marks of an exercise are in ``marks``.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Final

from trainer.boat.boat import STATE_OFFSETS, Boat
from trainer.boat.quantities import is_met
from trainer.config.exercise.derived import Loss
from trainer.config.exercise.loss_words import word_loss
from trainer.config.exercise.outcome import Outcome
from trainer.io.orders.grammar import Order, Refused, Reply
from trainer.io.orders.words import TRAINEE
from trainer.io.recording.facts import OVER_WORDS
from trainer.io.recording.recording import Moment
from trainer.session.past.control import PRESENT_MOMENT, Control
from trainer.session.stations.event_log import EventLog
from trainer.session.stations.roles import INSTRUCTOR_ROLE, Role
from trainer.session.stations.station import Fact, Request

CAPSIZE_ANGLES_RAD: Final = math.radians(60.0), math.radians(45.0)  # [rad] heel and pitch: lost
PHI_OFFSET, THETA_OFFSET = STATE_OFFSETS["phi"], STATE_OFFSETS["theta"]
# after the end of the exercise, by role
WAYS_ON: Final = {
    TRAINEE: "again, again from 2 min, next or quit",
    INSTRUCTOR_ROLE.name: "again, again from 2 min, next, debrief, release marks or quit",
}


@dataclass
class LossMonitor:
    """The monitor of one losing condition, which loses when it has held long enough."""

    loss: Loss
    ticks: int  # for which they have to hold
    held: int = 0  # ticks for which they have held
    ends: set[bytes] = field(default_factory=set)  # states in which they lost the exercise

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


@dataclass
class ExerciseEnd:
    """The end of one exercise: over or not, and why."""

    control: Control
    log: EventLog
    show: Callable[[], None]  # the present moment
    then: Callable[[], None]  # what an end is followed by: marks, and progress kept
    last_tick: float = math.inf  # at which its time is up
    lost: Sequence[LossMonitor] = ()
    over: str = ""  # when and by whom, once it is
    why: str = ""  # it is lost: for the instructor, since it may tell what is hidden
    outcome: Outcome = Outcome.UNDECIDED  # LOST, ENDED, DONE or NOT_DONE, once it is

    def expect(self, losses: Sequence[Loss], seconds: float | None) -> None:
        """Watch for an end after so many ``seconds``, and for any of these losses."""
        boat = self.control.boat
        self.last_tick = math.inf if seconds is None else round(seconds / boat.method.step)
        self.lost = [LossMonitor(each, boat.ticks_in(each.seconds)) for each in losses]

    @property
    def watched(self) -> bool:
        """Return whether the exercise can end by itself, by its time or by a loss."""
        return bool(self.lost) or self.last_tick < math.inf

    def look(self) -> None:
        """End the exercise if the tick that was just computed ends it."""
        if self.over or not self.watched:
            return
        if why := self.control.failure or loss_of(self.lost, self.control.boat):
            self.lose(why)
        elif self.control.boat.ticks >= self.last_tick:
            self._end(Outcome.ENDED, "time is up")

    def lose(self, why: str) -> None:
        """End the exercise as lost, unless it is over."""
        if not self.over:
            self._end(Outcome.LOST, "lost", why)

    def end_lesson(self, outcome: Outcome) -> None:
        """End a lesson after its last step, unless it has a time of its own."""
        if self.last_tick == math.inf:
            self._end(outcome, "the last step is over")

    def ask(self, asked: Request) -> Reply:
        """Answer the order ``end exercise``."""
        self._end(Outcome.ENDED, "ended", by=f" by the {asked.station.who}")
        return "the exercise is over"

    def barred(self, order: Order, role: Role, *, after_end: bool) -> Refused | None:
        """Return why the end of the exercise bars an order, None if it does not."""
        if not self.over:
            return None
        if order.name == "again" and order.subject == PRESENT_MOMENT:
            way_on = "again from 2 min, or from a moment kept"
            return Refused(f"here is the end of the exercise: {way_on}")
        way_on = WAYS_ON.get(role.name, "the instructor goes on")
        return None if after_end else Refused(f"the exercise is over: {way_on}")

    def follow(self, moment: Moment) -> None:
        """Begin it again, because time has jumped."""
        self.over = self.why = ""
        self.outcome = Outcome.UNDECIDED
        for loss in self.lost:
            loss.follow(moment)

    def _end(self, outcome: Outcome, how: str, why: str = "", by: str = "") -> None:
        """End the exercise, freeze time, and announce it."""
        self.outcome, self.why = outcome, why
        self.over = f"{how} at {self.control.boat.time:g} s{by}"
        self.control.stop()
        fact = Fact("exercise-over", outcome)
        self.log.tell("time", f"{OVER_WORDS}{self.over}", fact=fact)
        if why:
            self.log.tell("exercise", f"lost: {word_loss(why)}")
        self.show()
        self.then()


def loss_of(monitors: Sequence[LossMonitor], boat: Boat) -> str:
    """Return the condition that loses the exercise after this tick, "" for none."""
    # A list, not the first match: each monitor has to count its ticks at every tick.
    lost = [each.loss.text for each in monitors if each.look(boat)]
    heel, pitch = CAPSIZE_ANGLES_RAD
    turned = abs(boat.plain[PHI_OFFSET]) > heel or abs(boat.plain[THETA_OFFSET]) > pitch
    why = lost[0] if lost else "turned over" if turned else ""
    return why and why + boat.flat_words

"""The steps of a lesson as a session leads through them.

After each tick ``look`` asks whether the step is done, has lasted so long that a hint is due, or is
missed. After a step that is missed the next begins, or the same again from its own moment where the
exercise says so, twice at most, so that nobody is stuck. A lesson is done when each of its steps
is. ``conduct`` calls it. The moment of each step is kept as a snapshot, ``step-3``, to which one
may also go back; where a step was given up, as ``step-3-missed``, for a run that is taken up again.
"""

import contextlib
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Final

from trainer.boat.quantities import is_met
from trainer.config.exercise.outcome import Outcome
from trainer.config.exercise.steps import MISSED_AGAIN, MISSED_ON, Step
from trainer.io.orders.grammar import Order, Refused, Reply
from trainer.io.recording.recording import Moment, RecordingError
from trainer.session.aside import BackgroundTask
from trainer.session.past.control import Control
from trainer.session.people.shown import ScreenOutput
from trainer.session.stations.event_log import EventLog
from trainer.session.stations.station import Fact

MAX_REPEATS: Final = 2  # of a step that is missed
LESSON_KIND: Final = "lesson"


@dataclass
class StepGuide:
    """The way of a trainee through the steps of an exercise. Without steps it does nothing."""

    control: Control
    log: EventLog
    work: BackgroundTask  # calls between two ticks
    shown: ScreenOutput
    finish: Callable[[Outcome], object]  # the last step is over
    following: Callable[[], str]  # the name of what comes after the lesson
    steps: Sequence[Step] = ()
    give: Callable[[Order], object] = bool  # an order of the exercise
    go_back: Callable[[Moment, str], object] = lambda _moment, _why: None
    index: int = -1  # of the present step; -1 before the first
    _begun: dict[int, Moment] = field(default_factory=dict)  # by index
    _missed: dict[int, Moment] = field(default_factory=dict)  # by index: given up, and when
    _repeats: dict[int, int] = field(default_factory=dict)  # by index
    _held: int = 0  # ticks for which its conditions have held
    _hinted: bool = False
    _returning: bool = False
    _ended: bool = False  # the exercise is over, wherever it was in its steps

    @property
    def done(self) -> bool:
        """Return whether each step of a lesson is done."""
        return bool(self.steps) and not self.undone

    @property
    def undone(self) -> list[int]:
        """Return the numbers of the steps that were given up or not reached."""
        counted = range(len(self.steps))
        return [n + 1 for n in counted if n >= self.index or n in self._missed]

    @property
    def undone_text(self) -> str:
        """Return in words which steps are not done, and how one may go on."""
        numbers = ", ".join(map(str, self.undone))
        which = f"step {numbers} is" if len(self.undone) == 1 else f"steps {numbers} are"
        onward = f", or next {name} to go on" if (name := self.following()) else ""
        return f"{which} not done: again{onward}"

    @property
    def facts(self) -> list[Fact]:
        """Return the facts that tell a program the present step, or how the lesson ended."""
        if self._ended:
            last = [Fact("step", "0")] if self.index >= len(self.steps) else []
            numbers = self.undone
            which = ",".join((self.following(), *map(str, numbers)))
            return [*last, Fact("steps-undone", which)] if numbers else last
        if not 0 <= self.index < len(self.steps):
            return []
        step = self.steps[self.index].row
        fields = f"{self.index + 1},{len(self.steps)},{step.light or ''},{step.text}"
        hint = [Fact("step-hint", step.hint)] if step.hint and self._hinted else []
        return [Fact("step", fields), *hint]

    def look(self) -> None:
        """Begin, end or repeat a step, or give its hint, as this tick asks for."""
        if not self.steps or self._returning or self.index >= len(self.steps):
            return
        if self.index < 0:
            self._begin(0)
            return
        step, boat = self.steps[self.index], self.control.boat
        holds = all(is_met(each, boat) for each in step.conditions)
        self._held = self._held + 1 if holds else 0
        lasted = boat.ticks - self._begun[self.index].tick
        if holds and self._held > boat.ticks_in(step.row.for_s):
            self.log.tell(LESSON_KIND, f"step {self.index + 1}: done")
            self._begin(self.index + 1)
        elif lasted >= boat.ticks_in(step.row.within_s):
            self._miss(step)
        elif step.row.hint and not self._hinted and lasted >= boat.ticks_in(step.row.hint_after_s):
            self._give_hint(step.row.hint)

    def give_hint(self) -> Reply:
        """Give the hint of the present step before its time; it costs nothing."""
        hint = self.steps[self.index].row.hint if 0 <= self.index < len(self.steps) else ""
        if not hint:
            return Refused("this step has no hint")
        self._give_hint(hint)
        return f"hint: {hint}"

    def _give_hint(self, hint: str) -> None:
        self._hinted = True
        self._tell(f"hint: {hint}", Fact("step-hint", hint))

    def end(self) -> None:
        """Tell which steps are not done, because the exercise is over."""
        self._ended = bool(self.steps)
        if self.undone:
            self.log.tell(LESSON_KIND, self.undone_text, fact=self.facts[-1])

    def follow(self, moment: Moment) -> None:
        """Find the step of a moment to which time has jumped."""
        if not self.steps:
            return
        tick, kept = moment.tick, dict[str, Moment]()
        with contextlib.suppress(RecordingError):  # those of this run are known without it
            kept = self.control.history.snapshots()
        for index in range(len(self.steps)):
            if begun := kept.get(_name(index)):
                self._begun.setdefault(index, begun)
            if missed := kept.get(_missed_name(index)):
                self._missed.setdefault(index, missed)
        self._begun = {n: each for n, each in self._begun.items() if each.tick <= tick}
        # one that was done when it was flown again has not led to the next step from there
        self._missed = {n: each for n, each in self._missed.items() if self._led_on(n, each)}
        self.index = max(self._begun, default=-1)
        # who begins anew, such as the next visitor, has all repeats before him
        self._repeats = {n: each for n, each in self._repeats.items() if n <= self.index}
        self._held, self._hinted, self._returning, self._ended = 0, False, False, False
        if self.index >= 0:
            self._announce()
            if self._begun[self.index].tick == tick:  # before its orders
                self._give_orders()

    def _begin(self, index: int) -> None:
        self.index, self._held, self._hinted = index, 0, False
        if index == len(self.steps):
            how = "done" if self.done else "over"
            self.log.tell(LESSON_KIND, f"the last step is {how}", fact=Fact("step", "0"))
            self.shown.show_lesson("")
            self.finish(Outcome.DONE if self.done else Outcome.NOT_DONE)
            return
        history = self.control.history
        self._begun[index] = history.now()
        history.keep(_name(index))
        self._announce()
        self._give_orders()

    def _announce(self) -> None:
        text = f"step {self.index + 1} of {len(self.steps)}: {self.steps[self.index].row.text}"
        self._tell(text, self.facts[0])

    def _tell(self, text: str, fact: Fact) -> None:
        self.log.tell(LESSON_KIND, text, fact=fact)
        self.shown.show_lesson(text)

    def _give_orders(self) -> None:
        for order in self.steps[self.index].given:
            self.give(order)

    def _miss(self, step: Step) -> None:
        """Tell that a step is missed, and go back to its beginning or on."""
        index, begun = self.index, self._begun[self.index]
        again = step.row.missed == MISSED_AGAIN and self._repeats.get(index, 0) < MAX_REPEATS
        what = "once more, from its beginning" if again else "on to the next"
        fact = Fact("step-missed", f"{index + 1},{MISSED_AGAIN if again else MISSED_ON}")
        self.log.tell(LESSON_KIND, f"step {index + 1}: not done; {what}", fact=fact)
        if not again:
            self._missed[index] = self.control.history.now()
            self.control.history.keep(_missed_name(index))
            self._begin(index + 1)
            return
        self._repeats[index] = self._repeats.get(index, 0) + 1
        self._returning = True
        self.work.post(lambda: self._return(begun, f"step {index + 1} again"))

    def _led_on(self, index: int, missed: Moment) -> bool:
        """Return whether the step after one began when that was given up."""
        after = self._begun.get(index + 1)
        return after is not None and (after.branch, after.tick) == (missed.branch, missed.tick)

    def _return(self, moment: Moment, why: str) -> None:
        """Go back to the beginning of a step, unless time has jumped meanwhile.

        It is called between two ticks, since a tick cannot be undone within itself.
        """
        if not self._returning:
            return
        try:
            self.go_back(moment, why)
        except RecordingError as error:  # the step goes on from here
            self._returning, self._begun[self.index] = False, self.control.history.now()
            self.log.tell(LESSON_KIND, f"not gone back: {error}")


def _name(index: int) -> str:
    return f"step-{index + 1}"


def _missed_name(index: int) -> str:
    return f"{_name(index)}-missed"

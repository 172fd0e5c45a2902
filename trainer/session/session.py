"""One run: the loop that waits, listens to the stations, and takes the ticks.

``run`` (the module) makes a Session and calls ``run``. All of it happens in one thread, so no two
orders and no order and tick act at once; the tick waits for no disk and no station.
docs/architecture.md has the order of what a tick does.
"""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import InitVar, dataclass, field
from functools import partial
from typing import Final

from trainer.boat.boat import TICK_OFFSET
from trainer.io.tables import ColumnSink, NoFile
from trainer.session.attendance import Attendance, Introduction
from trainer.session.dispatch import Dispatch
from trainer.session.exercise.terms import Terms
from trainer.session.jump import repeat_step
from trainer.session.parts import Parts
from trainer.session.questions import Questions
from trainer.session.quiet import QuietTicks
from trainer.session.stations.station import Duty, Fact, Request
from trainer.session.time.ledger import SECOND_NS
from trainer.session.time.pacer import WAIT_WOKEN, PacerEvent

STEPPING_PERIOD_NS: Final = SECOND_NS // 5  # of single steps before the stations are heard again


@dataclass
class ColumnFile:
    """The file of each tick's columns, if there is one."""

    recorder: ColumnSink = field(default_factory=NoFile)
    columns: tuple[str, ...] = ()


@dataclass
class Session(Parts):
    """One run from its first tick to its end."""

    introduction: InitVar[Introduction] = Introduction()  # noqa: RUF009  frozen
    rows: ColumnFile = field(default_factory=ColumnFile)
    last_tick: float = math.inf
    progress: Callable[[int], None] | None = None

    def __post_init__(self, terms: Terms, introduction: Introduction) -> None:
        super().__post_init__(terms)
        self.attendance = Attendance(
            self.event_log,
            self.history,
            self.conduct,
            self.crew,
            self.agenda,
            introduction,
            self.evaluation,
            self.wake,
            self._hear,
        )
        questions = Questions(
            self.history, self.event_log, self.agenda, self.shown, self.evaluation
        )
        briefing: Mapping[str, Duty] = {"briefing": self.attendance.brief}
        self.dispatch = Dispatch(self, {**briefing, **questions.duties, **self.conduct.duties})
        self.conduct.guide.give = self.dispatch.obey_step
        self.conduct.guide.go_back = partial(repeat_step, self)
        self.quiet = QuietTicks(self)
        self.in_force.read_journal()  # a recorded run goes on
        self.in_force.follow(self.history.now())

    def run(self, *, frozen: bool = False) -> None:
        """Run to the last tick, an order to quit, or until nobody can say run."""
        self._write_row()
        self.conduct.guide.follow(self.history.now())  # of a lesson that goes on
        self.conduct.judge_moment()  # a recorded run may have ended in a collapse, or be over
        self.event_log.take_up(self.holding())
        self.dispatch.answer_left_orders()
        if any(self.history.flown.due_of_schedule(self.agenda.schedule)):
            self.shown.show()  # the moment as it is recorded, before what is ordered in it
            self.dispatch.obey_schedule()  # the crew's controls are in hand before time runs
        if not (frozen or self.control.failure or self.conduct.ending.over):
            self.time.pacer.run()
        self.shown.show()
        while not self._over:
            if self.time.pacer.frozen and self._left_alone():
                self._desert()
                return
            if self.time.pacer.wait(self.wake) is WAIT_WOKEN:
                self.wake.clear()
                self.attendance.listen()
            elif self.quiet.fly(self.last_tick):
                self._keep_quiet()
            else:
                self.tick()
            if self.control.steps:
                self._take_steps()  # those of the schedule, and those still to be taken

    def _keep_quiet(self) -> None:
        """Write the rows of ticks in which nobody had anything to say; show how far it is."""
        for row in self.quiet.rows_of(self.rows.columns):
            self._write(row)
        if self.progress:
            self.progress(self.boat.ticks)

    def stop(self) -> None:
        """End the run after the present tick; may be called from another thread."""
        self.control.ended = True
        self.wake.set()

    def tick(self) -> None:
        """Carry out the orders that are due; take a tick unless they stop time."""
        if self._stopped_by_orders():
            return
        pacer = self.time.pacer
        was_frozen = pacer.frozen
        pacer.begin()
        status = self.boat.tick()
        tick = int(self.boat.plain[TICK_OFFSET])
        if status:
            self.control.failure = self.boat.failure(status)
            self.event_log.tell("trouble", f"FROZEN: {self.control.failure}")
        else:
            self._after_tick(tick)
        events = pacer.end()
        self.history.flown.keep_timing(tick, pacer.ledger.lateness, pacer.ledger.work)
        if self.control.failure:
            self.control.stop()
        if pacer.frozen and not was_frozen:
            self.shown.show()
        if events:
            self._tell_late(events)
        if self.progress:
            self.progress(tick)

    @property
    def _over(self) -> bool:
        """Return whether the run has been ended or has reached its last tick."""
        return self.control.ended or self.boat.plain[TICK_OFFSET] >= self.last_tick

    def _hear(self, asked: Request) -> None:
        """Answer a station's order or question, and take the steps that it orders."""
        self.dispatch.hear(asked)
        self._take_steps()

    def _take_steps(self) -> None:
        """Take the ordered single steps in a freeze. Stop to listen when they take long."""
        until = self.time.clock.now() + STEPPING_PERIOD_NS
        while self.control.steps and self.time.frozen and not self._over:
            if self.time.clock.now() > until:
                self.wake.set()
                return
            self.control.steps -= 1
            self.tick()

    def _desert(self) -> None:
        """Announce that nobody is left to say run, unless the exercise is over."""
        if self.conduct.ending.over:
            return
        halted = self.conduct.damage_watch.halted
        where = f"{self.boat.time:g} s by {halted}" if halted else f"{self.boat.time:g} s"
        self.control.deserted = f"frozen at {where}, and nobody is left to say run"
        self.event_log.tell("time", self.control.deserted)

    def _left_alone(self) -> bool:
        """Return whether time is frozen, and nobody is left who could order it to run."""
        if self.attendance.reception.awaited:
            return False
        silent = self.attendance.silent
        self.attendance.listen()  # what came before the silence
        return silent and self.time.frozen and not self._over and not self.control.steps

    def _stopped_by_orders(self) -> bool:
        """Carry out the orders that are due; return whether they stop time before a tick."""
        flown = self.history.flown
        if not (self.agenda.planned or flown.has_orders(self.agenda.schedule)):
            return False
        was_frozen = self.time.frozen
        ended = self.dispatch.obey_due()
        return ended or self.control.ended or (self.time.frozen and not was_frozen)

    def _after_tick(self, tick: int) -> None:
        """Record the state, show it, and announce what it means."""
        state = self.history.ticked(tick)
        flown = self.history.flown
        self.event_log.tell_trouble()
        flown.keep_row(self._write_row)
        self.shown.show_tick(tick, state)
        for call in self.monitors.limits.look(self.boat):
            self.event_log.alert("watch", call)
        for call in self.monitors.pilot.look(self.boat):
            self.event_log.alert("pilot", call)
        for call in self.monitors.plant.look(self.boat):
            self.event_log.alert("plant", call)
        if passed := self.monitors.depths.look(self.boat):  # on the way down
            self.conduct.damage_watch.tell_depth(passed.call, Fact("depth", f"{passed.depth:g}"))
        self.conduct.judge_tick(self.monitors.limits.encounters)
        self.event_log.settle(self.holding())
        self.evaluation.look()
        self.dispatch.tell_plans()
        if tick >= self.crew.due:
            self.dispatch.say(self.crew.missing(tick, self.event_log.attended))
        if flown.watched:
            self.dispatch.obey_watch()
        while self.sending.troubles:
            self.event_log.tell("trouble", self.sending.troubles.popleft())

    def _tell_late(self, events: tuple[PacerEvent, ...]) -> None:
        """Announce a late tick, and show the speed of time if it had to fall."""
        speed = self.time.speed
        for kind, text in self.time.judge(events):
            self.event_log.tell(kind, text)
        if self.time.speed != speed:
            self.shown.show()

    def _write_row(self) -> None:
        """Hand the state to the file of columns; announce at once if that fails."""
        if self.rows.columns:
            self._write(self.boat.numbers(self.rows.columns))

    def _write(self, row: Sequence[float]) -> None:
        """Hand a row to the file of columns; announce at once if that fails."""
        recorder = self.rows.recorder
        before = recorder.trouble
        recorder.row(row)
        if recorder.trouble != before:
            self.event_log.tell("trouble", f"NOT RECORDED: {recorder.trouble}")

"""The conduct of a session: the parts that have its rules, and what joins them.

Who commands is in ``command``, who is there and ready in ``muster``. When the exercise is over is
in ``exercise``, its marks are in ``marks``, what follows it is in ``training``. ``damage_watch``
has what happens to the boat, ``step_guide`` the way through a lesson. The session calls
``judge_tick`` after each tick, and ``judge_moment`` where time has jumped: they ask the parts in
their order.
"""

from collections.abc import Callable, Mapping

from trainer.boat.world.encounters import EncounterMonitor
from trainer.io.orders.grammar import Order
from trainer.session.aside import BackgroundTask
from trainer.session.exercise.aids import Aids
from trainer.session.exercise.damage_watch import DamageWatch
from trainer.session.exercise.evaluation import Evaluation
from trainer.session.exercise.exercise import ExerciseEnd
from trainer.session.exercise.hints import Hints
from trainer.session.exercise.marks import Marks
from trainer.session.exercise.step_guide import StepGuide
from trainer.session.exercise.terms import Terms
from trainer.session.exercise.training import Training
from trainer.session.past.control import Control
from trainer.session.past.run_modes import JudgementScope
from trainer.session.people.chair import Chair
from trainer.session.people.command import Command
from trainer.session.people.muster import Muster
from trainer.session.people.shown import ScreenOutput
from trainer.session.stations.event_log import EventLog
from trainer.session.stations.past import PastReader
from trainer.session.stations.station import Duty


class Conduct:
    """The parts that have the rules of one session."""

    def __init__(
        self,
        control: Control,
        log: EventLog,
        shown: ScreenOutput,
        wake: Callable[[], object],
        terms: Terms,
    ) -> None:
        history, plan = control.history, terms.plan
        history.recording.wake = wake
        self.control, self.terms = control, terms
        self.work = BackgroundTask(wake)
        self.command = Command(log, wake)
        visitors = plan is not None and plan.visitors
        self.muster = Muster(log, self.command, shown.crew.work.hand, visitors=visitors)
        self.chair = Chair(log, history)
        self.past = PastReader(history, self.work, log, terms.kept)
        self.aids = Aids(history, log, shown, self.work, self.past, plan)
        self.ending = ExerciseEnd(control, log, shown.show, self._wind_up)
        self.ending.expect(terms.losses, terms.seconds)
        steps, after = plan.steps if plan else (), terms.following
        self.guide = StepGuide(control, log, self.work, shown, self.ending.end_lesson, after, steps)
        self.evaluation = Evaluation(
            *(history, log, self.work, shown.crew.work.refuse),
            over=lambda: self.ending.over or control.failure,
        )
        self.hints = Hints(history, log, self.guide, self.aids, self.evaluation)
        self.damage_watch = DamageWatch(control, log, shown.show, self.ending)
        self.marks = Marks(
            *(control, log, self.work, self.ending, terms.debriefing, terms.kept),
            scored=plan is not None and bool(plan.scores),
        )
        self.training = Training(
            control, log, self.work, self.ending, self.guide, terms, self.marks
        )

    @property
    def duties(self) -> Mapping[str, Duty]:
        """Return the functions that answer the orders about the conduct of the session."""
        return {
            "end": self.ending.ask,
            "release-marks": self.marks.release,
            "debrief": self.marks.write,
            "next": self.training.go_on,
            "history": self.past.answer,
            "hint": self.hints.ask,
            "ready": self.muster.be_ready,
            "who": self.muster.who,
            "command": self.command.ask,
            "give": self.command.give,
            "keep": self.command.keep,
        }

    @property
    def between_runs(self) -> bool:
        """Return whether the run of a class's course has not begun, or is over."""
        waits = self.ending.over or not self.control.boat.ticks
        return bool(self.terms.course.rows and waits)

    def go_on(self, order: Order) -> None:
        """Note that time goes on; announce who of the crew is not ready."""
        self.damage_watch.halted = ""
        if order.name == "run":
            self.muster.tell_late()

    def judge_tick(self, met: EncounterMonitor) -> None:
        """Judge a tick: a collision in it, and the moment at its end."""
        if self.control.history.flown.judged is JudgementScope.ALL:
            self.damage_watch.collide(met)
        self.judge_moment()

    def judge_moment(self) -> None:
        """Judge the present moment. Time may have jumped to it."""
        judged = self.control.history.flown.judged
        if judged is JudgementScope.ALL:
            self.damage_watch.look()
            self.look()
        elif judged is JudgementScope.GROUND:
            self.damage_watch.tell_ground()

    def look(self) -> None:
        """End the exercise if this tick ends it; else lead on through its steps."""
        self.muster.begun = self.control.boat.ticks > 0
        self.ending.look()
        if not self.ending.over:
            self.guide.look()

    def _wind_up(self) -> None:
        """Tell what of a lesson is not done, keep the progress, and have the marks made."""
        self.guide.end()
        self.training.remember()
        self.marks.begin()

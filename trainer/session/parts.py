"""The objects that make up a session, and their reset after a jump in time.

``session`` and ``dispatch`` use these objects. After a jump to another moment each of them has to
forget what came after that moment: ``arrive`` does this for all of them.
"""

import threading
from dataclasses import dataclass, field

from trainer.boat.boat import Boat
from trainer.boat.depths import DepthMonitor
from trainer.boat.limits import LimitMonitor
from trainer.boat.pilot import PilotMonitor
from trainer.io.recording.recording import Moment
from trainer.session.agenda import Agenda
from trainer.session.aids import Aids
from trainer.session.conduct import Conduct
from trainer.session.control import Control
from trainer.session.crew import CrewTalk
from trainer.session.evaluation import Evaluation
from trainer.session.event_log import EventLog
from trainer.session.hints import Hints
from trainer.session.history import History
from trainer.session.shown import ScreenOutput
from trainer.session.standing import StandRecord
from trainer.session.stations.station import Fact
from trainer.session.stations.subscriptions import Sender
from trainer.session.time.timekeeping import Timekeeping


@dataclass
class Monitors:
    """The monitors that announce what a tick means: limits, depths, the autopilot."""

    limits: LimitMonitor
    depths: DepthMonitor
    pilot: PilotMonitor

    @classmethod
    def over(cls, boat: Boat, limits: LimitMonitor) -> "Monitors":
        """Return the monitors of a boat."""
        return cls(limits, DepthMonitor.over(boat), PilotMonitor.over(boat))

    @property
    def counting(self) -> tuple[LimitMonitor, DepthMonitor, PilotMonitor]:
        """Return those that count their calls."""
        return self.limits, self.depths, self.pilot

    @property
    def times(self) -> dict[str, list[float]]:
        """Return the times [s] of each call."""
        return self.limits.times | self.depths.times | self.pilot.times


@dataclass
class Parts:
    """The objects of one run that obey, remember, tell and show."""

    boat: Boat
    time: Timekeeping
    history: History
    sending: Sender
    agenda: Agenda
    crew: CrewTalk
    monitors: Monitors
    wake: threading.Event = field(default_factory=threading.Event)

    def __post_init__(self) -> None:
        self.event_log = EventLog(self.history)
        self.control = Control(self.boat, self.time, self.history, self.agenda.schedule)
        self.shown = ScreenOutput(self.history, self.time, self.crew, self.sending)
        self.conduct = Conduct(
            self.control, self.event_log, self.shown.show, self.wake.set, hand=self.crew.hand
        )
        self.evaluation = Evaluation(
            *(self.history, self.event_log, self.conduct.work, self.crew.in_hand),
            over=lambda: self.conduct.ending.over or self.control.failure,
        )
        self.shown.seen = self.evaluate_frozen
        self.standing = StandRecord(self.crew, self.agenda, self.history)
        conduct = self.conduct
        conduct.aids = Aids(self.history, self.event_log, self.shown, conduct.work, conduct.past)
        guide = self.conduct.guide
        conduct.hints = Hints(self.history, self.event_log, conduct.work, guide, conduct.aids)
        guide.later, guide.show = self.conduct.work.post, self.shown.show_lesson
        guide.go_back = self.repeat_step

    def evaluate_frozen(self) -> None:
        """Have the present moment evaluated if time stands still there."""
        if self.time.frozen:
            self.evaluation.hand_over()

    def return_to(self, moment: Moment, why: str) -> None:
        """Go back to a moment of this run: a new branch begins there, frozen."""
        self.control.go_to(moment, why)
        self.arrive()
        self.shown.show()

    def repeat_step(self, moment: Moment, why: str) -> None:
        """Go back to the beginning of a step of a lesson, and let time run."""
        self.return_to(moment, why)
        self.event_log.tell("moment", f"back: {why}", fact=Fact("back", why))
        self.event_log.recall(self.crew.unrepeated)
        self.time.pacer.run()
        self.shown.show()

    def arrive(self) -> None:
        """Reset all parts to the moment to which time has jumped, and announce nothing."""
        counting = self.monitors.counting
        for monitor in counting:
            monitor.settle(self.boat)
        self.conduct.settle()
        self.standing.go_back()
        self.conduct.guide.settle()
        self.event_log.settle(counting)
        self.conduct.aids.keep_on()
        self.conduct.chair.keep()
        self.conduct.hints.keep()
        self.history.flown.judge_arrival(self.conduct)

    def end_replay(self, outcome: str) -> None:
        """Freeze time where a replay has come to its end. The run can go on from there."""
        self.event_log.tell("moment", outcome)
        self.standing.arrive()
        self.conduct.judge_hull()
        self.conduct.look()
        self.time.pacer.freeze()
        self.control.steps = 0
        self.shown.show()

"""The parts of a session, and how all of them follow a jump in time."""

import threading
from dataclasses import dataclass, field

from trainer.boat.boat import Boat
from trainer.boat.depths import DepthMonitor
from trainer.boat.limits import LimitMonitor
from trainer.boat.pilot import PilotMonitor
from trainer.io.recording.recording import Moment
from trainer.session.agenda import Agenda
from trainer.session.conduct import Conduct
from trainer.session.control import Control
from trainer.session.crew import CrewTalk
from trainer.session.event_log import EventLog
from trainer.session.history import History
from trainer.session.shown import ScreenOutput
from trainer.session.standing import StandRecord
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
        self.standing = StandRecord(self.crew, self.agenda, self.history)

    def return_to(self, moment: Moment, why: str) -> None:
        """Go back to a moment of this run: a new branch begins there, frozen."""
        self.control.go_to(moment, why)
        self.arrive()
        self.shown.show()

    def arrive(self) -> None:
        """Reset all parts to the moment to which time has jumped, and announce nothing."""
        counting = self.monitors.limits, self.monitors.depths, self.monitors.pilot
        for monitor in counting:
            monitor.settle(self.boat)
        self.conduct.settle()
        self.standing.go_back()
        self.event_log.settle(counting)
        self.history.flown.judge_hull(self.conduct)

    def end_replay(self, outcome: str) -> None:
        """Freeze time where a replay has come to its end. The run can go on from there."""
        self.event_log.tell("moment", outcome)
        self.standing.arrive()
        self.conduct.judge_hull()
        self.conduct.look()
        self.time.pacer.freeze()
        self.control.steps = 0
        self.shown.show()

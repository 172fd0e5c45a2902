"""The objects that make up a session. ``session``, ``dispatch`` and ``jump`` use them."""

import threading
from dataclasses import InitVar, dataclass, field

from trainer.boat.boat import Boat
from trainer.boat.depths import DepthMonitor
from trainer.boat.limits import LimitMonitor
from trainer.boat.pilot import PilotMonitor
from trainer.boat.plant_alerts import PlantMonitor
from trainer.io.recording.recording import Moment
from trainer.session.crew.agenda import Agenda
from trainer.session.crew.crew import CrewTalk
from trainer.session.crew.orders_in_force import OrdersInForce
from trainer.session.exercise.conduct import Conduct
from trainer.session.exercise.terms import Terms
from trainer.session.past.control import Control
from trainer.session.past.history import History
from trainer.session.people.shown import ScreenOutput
from trainer.session.stations.event_log import EventLog
from trainer.session.stations.subscriptions import Sender
from trainer.session.time.timekeeping import Timekeeping


@dataclass
class Monitors:
    """The monitors that announce what a tick means: limits, depths, autopilot, plant."""

    boat: Boat
    limits: LimitMonitor
    depths: DepthMonitor
    pilot: PilotMonitor
    plant: PlantMonitor

    @classmethod
    def over(cls, boat: Boat, limits: LimitMonitor) -> "Monitors":
        """Return the monitors of a boat."""
        watches = DepthMonitor.over(boat), PilotMonitor.over(boat), PlantMonitor.over(boat)
        return cls(boat, limits, *watches)

    @property
    def counting(self) -> tuple[LimitMonitor, DepthMonitor, PilotMonitor, PlantMonitor]:
        """Return those that count their calls."""
        return self.limits, self.depths, self.pilot, self.plant

    def follow(self, _moment: Moment) -> None:
        """Take the boat as it is: nothing of it is news."""
        for monitor in self.counting:
            monitor.reset_to(self.boat)

    @property
    def times(self) -> dict[str, list[float]]:
        """Return the times [s] of each call."""
        times: dict[str, list[float]] = {}
        for monitor in self.counting:
            times |= monitor.times
        return times


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
    terms: InitVar[Terms] = Terms()  # noqa: RUF009  frozen

    def __post_init__(self, terms: Terms) -> None:
        self.event_log = EventLog(self.history, self.monitors.counting)
        self.control = Control(self.boat, self.time, self.history, self.agenda.schedule)
        self.shown = ScreenOutput(self.history, self.time, self.crew, self.sending)
        self.conduct = Conduct(*(self.control, self.event_log, self.shown, self.wake.set), terms)
        self.evaluation = self.conduct.evaluation
        self.shown.seen = self.evaluate_frozen
        self.in_force = OrdersInForce(self.crew, self.agenda, self.history)

    def holding(self) -> set[str]:
        """Return the keys of all alerts called that hold still."""
        monitors, hull = self.monitors, self.conduct.damage_watch
        known = monitors.limits.holding | monitors.depths.holding | hull.holding
        return known | monitors.plant.holding | monitors.pilot.holding(self.boat.time)

    def evaluate_frozen(self) -> None:
        """Have the present moment evaluated if time stands still there."""
        if self.time.frozen:
            self.evaluation.hand_over()

"""What befalls the hull: the ground, a collision, a collapse.

``conduct`` asks after each tick. What the exercise says of the ground and of a collision is done:
time is frozen, the exercise is lost, or nothing but the call. A boat whose hull has collapsed
cannot go on, whatever the exercise says.
"""

from collections.abc import Callable
from dataclasses import dataclass

from trainer.boat.calls import MonitorCall, Rank
from trainer.boat.depths import collapse_of, hull_depth
from trainer.boat.grounding import GroundCall, GroundMonitor
from trainer.boat.world.encounters import EncounterMonitor
from trainer.io.recording.recording import Moment
from trainer.session.exercise.exercise import ExerciseEnd
from trainer.session.past.control import Control
from trainer.session.stations.event_log import EventLog
from trainer.session.stations.station import Fact


@dataclass
class DamageWatch:
    """The watch over one hull."""

    control: Control
    log: EventLog
    show: Callable[[], None]  # the present moment
    ending: ExerciseEnd
    halted: str = ""  # what the exercise has frozen time for, until it runs again

    def __post_init__(self) -> None:
        self.ground = GroundMonitor(self.control.boat)

    def look(self) -> None:
        """Announce grounding or collapse, and freeze or end as the exercise says."""
        for call in self.tell_ground():
            if call.aground:
                self._halt(call.text, call.how)
        control = self.control
        if not control.failure and (collapse := collapse_of(control.boat)):
            control.failure = collapse
            fact = Fact("collapse", f"{hull_depth(control.boat):.1f}")
            self.tell_depth(MonitorCall(collapse, Rank.EMERGENCY, "collapse"), fact)

    def tell_ground(self) -> list[GroundCall]:
        """Announce contact with the ground; return the calls."""
        calls = list(self.ground.look()) if self.ground.bottom else []
        for call in calls:
            rank = Rank.ALARM if call.aground else Rank.CAUTION
            self.tell_depth(MonitorCall(call.text, rank, call.key))
        return calls

    @property
    def holding(self) -> set[str]:
        """Return the keys of the alerts called that hold still."""
        collapse = {"collapse"} if collapse_of(self.control.boat) else set()
        return self.ground.holding | collapse

    def collide(self, met: EncounterMonitor) -> None:
        """Freeze or end after a collision, as the exercise says."""
        if met.struck:
            self._halt(f"collision with {met.struck}", met.rules.collision)

    def tell_depth(self, call: MonitorCall, fact: Fact | None = None) -> None:
        """Announce a depth that was reached, with its tick."""
        boat = self.control.boat
        text = f"tick {boat.ticks} ({boat.time:g} s): {call.text}"
        self.log.alert("depth", call._replace(text=text), fact)

    def follow(self, _moment: Moment) -> None:
        """Forget a halt and groundings, because time has jumped."""
        self.halted = ""
        self.ground.reset()

    def _halt(self, why: str, how: str) -> None:
        """Freeze time, or end the exercise as lost, as ``how`` says; another word does nothing."""
        if how == "end":
            self.ending.lose(why)
        elif how == "freeze":
            self.control.stop()
            self.halted = why
            self.log.tell("time", f"frozen: {why}")
            self.show()

"""Who is there, who is ready, and when ``quit`` is meant.

Nobody waits for who is not ready: ``run`` tells of them, and time runs. ``quit`` ends the session
for all, so where others are attached it has to be said twice.
"""

import time
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Final

from trainer.io.orders.grammar import Refused, Reply
from trainer.io.orders.words import CLASS_LINE, TRAINEE
from trainer.io.recording.recording import Moment
from trainer.session.crew.manning import unmanned_axes
from trainer.session.people.command import Command
from trainer.session.stations.event_log import EventLog
from trainer.session.stations.roles import INSTRUCTOR_ROLE, STRANGER_ROLE
from trainer.session.stations.station import Fact, LongAnswer, Request, Station

QUIT_AGAIN_WITHIN_S: Final = 10.0  # [s] for the second `quit`, which ends a session for others too
# roles that are not counted when the crew is asked whether it is ready
NOT_CREW: Final = (
    *(INSTRUCTOR_ROLE.name, STRANGER_ROLE.name, "observer", "visitor", TRAINEE, CLASS_LINE),
)


@dataclass
class Muster:
    """The stations of one session, as they see each other."""

    log: EventLog
    command: Command
    hand: frozenset[str]  # axes that the exercise has worked by hand
    clock: Callable[[], float] = time.monotonic
    visitors: bool = False  # may begin the exercise again
    begun: bool = False  # time has run since the start
    ready: list[Station] = field(default_factory=list)

    def __post_init__(self) -> None:
        self._quitting: tuple[Station | None, float] = None, 0.0  # who said quit, and when [s]

    def be_ready(self, asked: Request) -> Reply:
        """Answer the order ``ready``."""
        station = asked.station
        if self.begun:
            return Refused("the exercise has begun")
        if station not in self.ready:
            self.ready.append(station)
        awaited = self._awaited()
        fact = Fact("ready", station.who)
        self.log.tell("station", f"{station.who} is ready{awaited}", station, fact)
        return f"ready{awaited}"

    def tell_late(self) -> None:
        """Announce who of the crew is not ready as time begins to run."""
        if not self.begun and (late := self._late()):
            self.log.tell("station", f"not ready: {late}")

    def who(self, asked: Request) -> LongAnswer:
        """Answer with the account of every station; tell a program the same in facts."""
        stations = self._people
        facts = [Fact("stations", str(len(stations)))]
        facts += [Fact("aboard", self._aboard(each, asked.station)) for each in stations]
        self.log.note(asked.station, facts)
        return LongAnswer([each.account() for each in stations])

    def unconfirmed(self, station: Station) -> Refused | None:
        """Return why ``quit`` has to be said again, None where it need not be."""
        came = [each for each in self._people if each.visits and each.settled]
        others = sum(each is not station and not each.line.ended for each in came)
        who, when = self._quitting
        if not others or (who is station and self.clock() - when <= QUIT_AGAIN_WITHIN_S):
            return None
        self._quitting = station, self.clock()
        attached = "1 station is" if others == 1 else f"{others} stations are"
        within = f"type quit again within {QUIT_AGAIN_WITHIN_S:g} s to end it for all, or detach"
        return Refused(f"{attached} attached: {within}")

    def follow(self, moment: Moment) -> None:
        """Forget at the start who is ready."""
        if moment.tick == 0:
            self.begun = False
            self.ready.clear()

    def _aboard(self, station: Station, asker: Station) -> str:
        """Return the fields that tell a program about an attached station."""
        marks = {
            "you": station is asker,
            "command": station.role is INSTRUCTOR_ROLE and not self.command.elsewhere(station),
            "ready": station in self.ready,
        }
        told = " ".join(mark for mark, holds in marks.items() if holds)
        return f"{station.role.name},{station.called},{told},{station.line.name}"

    @property
    def _people(self) -> list[Station]:
        """Return all stations but that of the class, where nobody sits."""
        return [each for each in self.log.stations if each.role.name != CLASS_LINE]

    def _awaited(self) -> str:
        """Return who is not ready yet; if all are, the axes that have nobody to work them."""
        if late := self._late():
            return f"; not ready: {late}"
        unmanned = unmanned_axes(self.hand, self.log.attended)
        return f"; nobody mans the {' and the '.join(unmanned)}" if unmanned else "; everybody is"

    def _late(self) -> str:
        """Return who of the crew is not ready, "" for nobody."""
        crew = [each for each in self.log.stations if each.role.name not in NOT_CREW]
        return ", ".join(each.who for each in crew if each not in self.ready)

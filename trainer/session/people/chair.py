"""A lone person's chair: who is alone may take another role.

Somebody who trains alone may look behind the scenes as the instructor, and go back. His marks then
say so. Where others are attached a line keeps its role, because they rely on who is who.
"""

from dataclasses import dataclass

from trainer.io.orders.grammar import Order, Refused, Reply
from trainer.io.orders.words import CLASS_LINE
from trainer.io.recording.facts import Giver
from trainer.io.recording.recording import Moment
from trainer.session.past.history import History
from trainer.session.stations.event_log import EventLog
from trainer.session.stations.roles import INSTRUCTOR_ROLE, ROLES
from trainer.session.stations.station import Fact, Station

STAYS_TEXT = "stays"


@dataclass
class Chair:
    """The changes of role of one session."""

    log: EventLog
    history: History
    seen: tuple[Order, Giver] | None = None  # the first change to or from the instructor's role

    def barred(self, order: Order, station: Station) -> Refused | None:
        """Return why a line may not take another role, None where it may."""
        if ROLES[order.word] is station.role:
            return Refused(f"you {station.role.part} already")
        people = [each for each in self.log.stations if each.role.name != CLASS_LINE]
        others = [each for each in people if each is not station]
        attached = [each.line.name for each in others if not each.line.ended]
        kept = f"you {station.role.part}: a line keeps its role while others are attached"
        return Refused(f"{kept} ({', '.join(attached)})") if attached else None

    def change(self, order: Order, giver: Giver, station: Station | None) -> Reply:
        """Give a line its new role; return the answer."""
        if station is None:
            return Refused("a role is a line's own: type it there")
        if self.seen is None and INSTRUCTOR_ROLE.name in (giver.role, order.word):
            self.seen = order, giver
        station.take_chair(ROLES[order.word])
        self.log.note(station, [Fact("chair", order.word)])
        return f"you {station.role.part}"

    def follow(self, _moment: Moment) -> None:
        """Journal again what was seen, because a new branch may begin before it."""
        if self.seen and not self.history.flown.barred:
            order, giver = self.seen
            self.history.answered(self.history.order(giver, order), STAYS_TEXT)

"""The watch bill: who works each axis by hand, and who has each watch.

Aboard, two people who can move the same planes say who has them: "I have the planes". Here a
station has an axis once it has said so or has worked it, until another one does. Nothing is locked,
but both stations and the instructor are told. Persons relieve each other at a station, which is a
role here, whatever line it has.
"""

from dataclasses import dataclass, field

from trainer.io.orders.grammar import Order
from trainer.io.orders.words import ORDER_WORDS
from trainer.io.recording.facts import Giver, GiverKind
from trainer.session.crew.manning import in_order
from trainer.session.crew.messages import CrewMessage
from trainer.session.stations.station import Fact


@dataclass
class WatchBill:
    """Who has each axis, and each watch."""

    hands: dict[str, Giver] = field(default_factory=dict)  # by axis: who has worked it last

    watch: dict[str, str] = field(default_factory=dict)  # the person who has it, by role

    @property
    def shown(self) -> str:
        """Return the axes with the roles that have them: "rudder helm; planes pilot"."""
        return "; ".join(f"{axis} {self.hands[axis].role}" for axis in in_order(self.hands))

    def standing(self) -> list[CrewMessage]:
        """Return the messages that tell a program who has what."""
        hands = [self._told(axis, "", "") for axis in in_order(self.hands)]
        watch = [Fact("watch", f"{role},{person},") for role, person in self.watch.items()]
        return hands + [CrewMessage("crew", "", fact) for fact in watch]

    def relieve(self, role: str, person: str) -> list[CrewMessage]:
        """Give the watch at a station to a person; return the message of it."""
        before, self.watch[role] = self.watch.get(role, ""), person
        text = f"{role}: {person} has the watch" + (f", {before} is relieved" if before else "")
        return [CrewMessage("crew", text, Fact("watch", f"{role},{person},{before}"))]

    def take(self, order: Order, giver: Giver) -> list[CrewMessage]:
        """Note who works an axis now; return what tells both stations where it was another's.

        The first who works an axis takes it from nobody, so that programs alone are told.
        """
        if giver.kind is not GiverKind.STATION:
            return []
        messages = []
        for axis in ORDER_WORDS[order.name].takes(order.word):
            before, self.hands[axis] = self.hands.get(axis), giver
            if before != giver:
                text = f"{giver} has the {axis}, which {before} had" if before else ""
                messages.append(self._told(axis, str(before or ""), text))
        return messages

    def _told(self, axis: str, before: str, text: str) -> CrewMessage:
        return CrewMessage("crew", text, Fact("has", f"{axis},{self.hands[axis]},{before}"))

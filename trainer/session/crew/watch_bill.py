"""The watch bill: which station works which axis (rudder, planes, speed, ballast) by hand.

Aboard, two people who can move the same planes say who has them: "I have the planes". Here a
station has an axis once it has said so or has worked it, until another one does. Nothing is locked,
but both stations and the instructor are told.
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
    """Who has each axis."""

    hands: dict[str, Giver] = field(default_factory=dict)  # by axis: who has worked it last

    @property
    def shown(self) -> str:
        """Return the axes with the roles that have them: "rudder helm; planes pilot"."""
        return "; ".join(f"{axis} {self.hands[axis].role}" for axis in in_order(self.hands))

    def standing(self) -> list[CrewMessage]:
        """Return the messages that tell a program who has what."""
        return [self._told(axis, "", "") for axis in in_order(self.hands)]

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

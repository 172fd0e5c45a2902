"""Messages about the crew, in words for people and facts for programs."""

from typing import NamedTuple

from trainer.io.orders.grammar import Order
from trainer.session.stations.roles import INSTRUCTOR_ROLE
from trainer.session.stations.station import Fact, Saying


class CrewMessage(NamedTuple):
    """A message about the crew: its kind, words for people, a fact for programs.

    Without words it is for programs alone.
    """

    kind: str
    text: str
    fact: Fact
    saying: Saying | None = None


def report_text(order: Order, role: str) -> list[CrewMessage]:
    """Return the message of a report."""
    words = f"{role}: {order.subject}"
    return [CrewMessage("crew", f"{role} reports: {order.subject}", Fact("report", words))]


def pump_text(by: str, done: str) -> CrewMessage:
    """Return the message of a pump's work. Only the instructor hears of his own."""
    fact = Fact("report", f"{by}: {done}")
    if by == INSTRUCTOR_ROLE.name:
        return CrewMessage("exercise", done, fact)
    return CrewMessage("crew", f"{by} reports: {done}", fact)

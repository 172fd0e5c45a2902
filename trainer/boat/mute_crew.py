"""The reference crew looks over a trainee's shoulder: it sees the gauges and gives nothing.

Debriefs fly recorded runs again with it (``attainable``). So it knows at each moment what it would
have ordered, what of that somebody has ordered, and what its hands remember. From any moment a copy
of it can take over and speak.
"""

import math
from collections.abc import Iterable, Iterator
from copy import copy
from operator import itemgetter

from trainer.boat.boat import Boat
from trainer.boat.crew_hands import TIME_ROUNDING_S
from trainer.boat.helm import obey_order
from trainer.boat.reference_crew import CrewReaction, ReferenceCrew, RuleProgress
from trainer.boat.world.world import WORLD_PARTS
from trainer.config.reference_crew import CREW_HANDS, SAID_ORDERS, Crew
from trainer.io.orders.grammar import Order, Refused


class MuteCrew:
    """The reference crew of one exercise, that gives no order."""

    def __init__(self, boat: Boat, crew: Crew, reaction: CrewReaction | None = None) -> None:
        """Come aboard where the run begins."""
        self.crew = ReferenceCrew(boat, crew, reaction)

    def follow(self, given: Iterable[Order]) -> None:
        """Look at the gauges and the orders of this tick.

        A rule is done when somebody gave its order since what it waits for came. It is also done
        when its order is due and would change nothing, because another order has done the same.
        """
        crew, orders = self.crew, list(given)
        crew.notice()
        for progress in crew.followed:
            if progress.due is None:
                continue
            order = progress.rule.order
            if order.name in CREW_HANDS:
                done = crew.is_due(progress)
            else:
                done = any(is_same_order(order, each) for each in orders) or (
                    crew.is_due(progress) and self._stands(order)
                )
            if done:
                crew.count(progress)
        for hand in crew.hands.values():
            hand.look(crew.gauges)
            hand.find_ordered()

    def aboard(self, boat: Boat) -> "MuteCrew":
        """Return a copy of this crew, aboard another boat in the same state."""
        other = copy(self)
        other.crew = self.crew.aboard(boat)
        return other

    def speak(self) -> ReferenceCrew:
        """Return the crew that gives orders from now on, what is overdue first."""
        self.crew.come_late()
        for hand in self.crew.hands.values():
            hand.find_ordered()
        return self.crew

    def pending(self, now: float) -> list[RuleProgress]:
        """Return the rules whose order is overdue at a time [s], the earliest first."""
        due = [(each.due, each) for each in self.crew.followed if each.due is not None]
        late = [(at, each) for at, each in due if at < now + TIME_ROUNDING_S]
        return [each for _, each in sorted(late, key=itemgetter(0))]

    def hand_orders(self) -> Iterator[tuple[str, list[str]]]:
        """Yield each hand with what it would order now, if it looked."""
        for name, hand in self.crew.hands.items():
            hand.find_ordered()
            hand.looked = -math.inf
            yield name, hand.look(self.crew.gauges)

    def _stands(self, order: Order) -> bool:
        """Return whether an order would change nothing of the boat.

        The order is tried, and the boat put back.
        """
        boat = self.crew.boat
        # what is said, or moves what no copy of a state undoes
        if order.name in SAID_ORDERS or order.name in WORLD_PARTS:
            return False
        before = boat.snapshot()
        refused = isinstance(obey_order(boat, order), Refused)
        same = boat.records.state.tobytes() == before.tobytes()
        boat.restore(before)
        return same and not refused


def is_same_order(order: Order, other: Order) -> bool:
    """Return whether two orders say the same to the same control."""
    return (order.name, order.word, order.subject, order.numbers, order.value) == (
        other.name,
        other.word,
        other.subject,
        other.numbers,
        other.value,
    )

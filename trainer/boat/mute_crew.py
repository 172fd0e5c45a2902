"""The reference crew looks over a trainee's shoulder: it sees the gauges and gives nothing.

Debriefs fly recorded runs again with it (``attainable``). So it knows at each moment what it would
have ordered, what of that somebody has ordered, and what its hands remember. From any moment a copy
of it can take over and speak.
"""

import math
from collections.abc import Iterable, Iterator, Sequence
from copy import copy
from operator import itemgetter
from typing import Final

import numpy as np

from trainer.boat.boat import Boat
from trainer.boat.crew_hands import TIME_ROUNDING_S
from trainer.boat.helm import obey_order
from trainer.boat.order_controls import OrderControls
from trainer.boat.reference_crew import CrewReaction, ReferenceCrew, RuleProgress
from trainer.boat.world.world import WORLD_PARTS
from trainer.config.exercise.reference_crew import CREW_HANDS, SAID_ORDERS, Crew
from trainer.io.orders.grammar import Order, Refused

AXES_OF_HANDS: Final = {"planesman": "planes", "helmsman": "rudder"}
WATER_ORDERS: Final = ("flood", "pump")  # so many tonnes into a tank, out of it, or to another


class MuteCrew:
    """The reference crew of one exercise, that gives no order."""

    def __init__(self, boat: Boat, crew: Crew, reaction: CrewReaction | None = None) -> None:
        """Come aboard where the run begins."""
        self.crew = ReferenceCrew(boat, crew, reaction)
        self.controls = OrderControls(boat)
        self.answered = False  # whether other orders have answered any rule
        self._standing: dict[str, bool] = {}  # orders, until somebody gives any

    def follow(self, given: Iterable[Order]) -> None:
        """Look at the gauges and the orders of this tick.

        A rule is done when somebody gave its order since what it waits for came, or when its order
        is due and would change nothing. It is answered, and what follows it may come, when its
        order is due and another one works all its controls.
        """
        crew, orders = self.crew, list(given)
        if orders:
            self.look_anew()
        crew.notice()
        for progress in crew.followed:
            if progress.due is None:
                continue
            order = progress.rule.order
            if order.name in CREW_HANDS:
                done = crew.is_due(progress)
            else:
                done = any(is_same_order(order, each) for each in orders) or (
                    crew.is_due(progress) and self.stands(order)
                )
            if not done and self._is_answered(progress, orders):
                self.answered = done = True
            if done:
                crew.count(progress)
        for hand in crew.hands.values():
            hand.look(crew.gauges)
            hand.find_ordered()

    def _is_answered(self, progress: RuleProgress, orders: Sequence[Order]) -> bool:
        """Return whether another order was given for a rule that is due."""
        order = progress.rule.order
        if order.name in (*CREW_HANDS, *SAID_ORDERS) or not self.crew.is_due(progress):
            return False
        wanted = self.controls.of(order)
        return any(self.controls.of(each) >= wanted for each in orders)

    def aboard(self, boat: Boat) -> "MuteCrew":
        """Return a copy of this crew, aboard another boat in the same state."""
        other = copy(self)
        other.crew = self.crew.aboard(boat)
        other.look_anew()
        return other

    def look_anew(self) -> None:
        """Have each order tried again, whether it stands."""
        self._standing = {}

    def pass_over(self, settled: Iterable[int], *, drops_late: bool) -> None:
        """Count rules as carried out, by index, and drop what is late."""
        for index in settled:
            self.crew.count(self.crew.followed[index])
        if drops_late:
            self.crew.come_late()

    def speak(self) -> ReferenceCrew:
        """Return the crew that gives orders from now on, what is overdue first."""
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

    def stands(self, order: Order) -> bool:
        """Return whether an order would set no control otherwise.

        What it has begun may go on: a shift of modes, a party under way. The order is tried, and
        the boat put back: once, until somebody orders anything.
        """
        if order.text not in self._standing:
            self._standing[order.text] = self._would_stand(order)
        return self._standing[order.text]

    def _would_stand(self, order: Order) -> bool:
        boat = self.crew.boat
        # what is said, or moves what no copy of a state undoes
        if order.name in SAID_ORDERS or order.name in WORLD_PARTS:
            return False
        before, places = boat.snapshot(), self.controls.places(order)
        refused = isinstance(obey_order(boat, order), Refused)
        after = boat.snapshot()
        boat.restore(before)
        old, new = (each.view(np.uint64).ravel() for each in (before, after))
        same = bool((old[places] == new[places]).all() if places else (old == new).all())
        return same and not refused


class StrictCrew(MuteCrew):
    """A mute crew to which no order answers a rule but the rule's own."""

    def _is_answered(self, _progress: RuleProgress, _orders: Sequence[Order]) -> bool:
        return False


def is_same_order(order: Order, other: Order) -> bool:
    """Return whether two orders say the same to the same control."""
    said, others = (
        (each.name, each.word, each.words, each.subject, each.numbers, each.value)
        for each in (order, other)
    )
    return said == others

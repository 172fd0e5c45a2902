"""The reference crew looks over a trainee's shoulder: it sees the gauges and gives nothing.

Debriefs fly recorded runs again with it (``attainable``). So it knows at each moment what it would
have ordered, what of that somebody has ordered, and what its hands remember. From any moment a copy
of it can take over and speak.
"""

import math
from collections.abc import Iterable, Iterator, Sequence
from copy import copy
from itertools import pairwise
from operator import itemgetter
from typing import Final

import numpy as np

from trainer.boat.boat import Boat
from trainer.boat.crew_hands import TIME_ROUNDING_S
from trainer.boat.helm import obey_order
from trainer.boat.reference_crew import CrewReaction, ReferenceCrew, RuleProgress
from trainer.boat.world.world import WORLD_PARTS
from trainer.config.exercise.reference_crew import CREW_HANDS, SAID_ORDERS, Crew
from trainer.config.exercise.score_rules import ANSWER_ORDERS
from trainer.io.orders.grammar import Order, Refused
from trainer.io.orders.words import ORDER_WORDS

AXES_OF_HANDS: Final = {"planesman": "planes", "helmsman": "rudder"}
WATER_ORDERS: Final = ("flood", "pump")  # so many tonnes into a tank, out of it, or to another


class MuteCrew:
    """The reference crew of one exercise, that gives no order."""

    def __init__(self, boat: Boat, crew: Crew, reaction: CrewReaction | None = None) -> None:
        """Come aboard where the run begins."""
        self.crew = ReferenceCrew(boat, crew, reaction)

    def follow(self, given: Iterable[Order]) -> None:
        """Look at the gauges and the orders of this tick.

        A rule is done when somebody gave its order since what it waits for came. It is also done
        when its order is due and would change nothing, because another order has done the same.
        What it ordered is then wanted, and due again once an order works its control against it.
        """
        crew, orders = self.crew, list(given)
        carried_out = []
        crew.notice()
        for progress in crew.followed:
            if progress.due is None:
                continue
            order = progress.rule.order
            if order.name in CREW_HANDS:
                done = crew.is_due(progress)
            else:
                done = any(is_same_order(order, each) for each in orders) or (
                    crew.is_due(progress)
                    and (not progress.undone or bool(orders))
                    and self._stands(order)
                )
            if done:
                crew.count(progress)
                carried_out.append(progress)
        if orders or carried_out:
            self._keep_wants(orders, carried_out)
        for hand in crew.hands.values():
            hand.look(crew.gauges)
            hand.find_ordered()

    def aboard(self, boat: Boat) -> "MuteCrew":
        """Return a copy of this crew, aboard another boat in the same state."""
        other = copy(self)
        other.crew = self.crew.aboard(boat)
        return other

    def ways(self) -> "Iterator[MuteCrew]":
        """Yield the crews that could go on: this one, and one that repeats nothing.

        They differ where an order was undone: what came of that may serve better by now.
        """
        yield self
        if any(each.undone for each in self.crew.followed):
            other = self.aboard(self.crew.boat)
            for each in other.crew.followed:
                if each.undone:
                    other.crew.forget(each)
            yield other

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

    def _keep_wants(self, orders: Sequence[Order], carried_out: Sequence[RuleProgress]) -> None:
        """Have each rule due again whose control an order has worked against it, and no other.

        So a party that fights a fire is not sent anew because a fan runs again. A later rule, or a
        hand that is at work, ends what an earlier rule wants of its control.
        """
        crew = self.crew
        steered = {AXES_OF_HANDS[hand] for hand in crew.hands}
        coming = {  # what hands steer that follow at once, and may have ordered in this tick
            AXES_OF_HANDS.get(each.rule.order.name)
            for lead, each in pairwise(crew.followed)
            if lead in carried_out and each.rule.row.then
        }
        for each in crew.followed:
            order = each.rule.order
            later = [other.rule.order for other in carried_out if other is not each]
            if not each.wanted:
                continue
            axes = axes_of(order)
            if axes & steered or any(self._undoes(other, order) for other in later):
                crew.forget(each)
            elif each.due is None and not axes & coming:
                others = (x for x in orders if x.name in ANSWER_ORDERS)
                if any(self._undoes(x, order) for x in others if not is_same_order(x, order)):
                    each.due, each.undone, each.over = crew.boat.time, True, False

    def _undoes(self, order: Order, wanted: Order) -> bool:
        """Return whether an order that stands is against one that is wanted.

        It is if it would put back what that would change. Both are tried, and the boat put back.
        """
        untried = {*SAID_ORDERS, *CREW_HANDS, *WORLD_PARTS}
        if {order.name, wanted.name} & untried or wanted.name in WATER_ORDERS:
            return False
        boat, before = self.crew.boat, self.crew.boat.snapshot()
        obey_order(boat, wanted)
        meant = boat.snapshot()
        obey_order(boat, order)
        after = boat.snapshot()
        boat.restore(before)
        old, new, last = (each.view(np.uint64) for each in (before, meant, after))
        return bool(((old != new) & (new != last)).any())

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


def axes_of(order: Order) -> set[str]:
    """Return the axes whose surfaces an order puts to an angle."""
    word = ORDER_WORDS.get(order.name)  # a hand of the crew has none
    return {*word.moves(order.word)} if word and word.needs != "plant" else set()


def is_same_order(order: Order, other: Order) -> bool:
    """Return whether two orders say the same to the same control."""
    said, others = (
        (each.name, each.word, each.words, each.subject, each.numbers, each.value)
        for each in (order, other)
    )
    return said == others

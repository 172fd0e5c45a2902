"""The reference crew works by its rules and its hands, through the boat's ordinary orders.

Debriefs and checks of exercises fly runs with it, to see what an exercise allows. It sees what the
gauges show, and gives nothing that a crew could not type. But it reads them without noise and does
not tire, so its marks are a ceiling for people.
"""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import cache, cached_property, partial
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from trainer.boat.boat import STATE_OFFSETS, Boat
from trainer.boat.casualties import InstrumentReadings, scale_of
from trainer.boat.crew_hands import (
    STAMP_OFFSET,
    TIME_ROUNDING_S,
    GaugeHistory,
    PlanesHand,
    RudderHand,
    TicksAhead,
)
from trainer.boat.crew_orders import CREW_AXES
from trainer.boat.grounding import clearance
from trainer.boat.helm import obey_order
from trainer.boat.limits import height_showing
from trainer.boat.world.bottom import heights_of_keel, keel_of
from trainer.boat.world.scope import eye_height
from trainer.config.exercise.condition import STATE_QUANTITIES
from trainer.config.exercise.derived import Condition
from trainer.config.exercise.reference_crew import (
    CREW_HANDS,
    MARK_ORDER,
    SAID_ORDERS,
    Crew,
    CrewRule,
)
from trainer.core.bottom import SOUNDING_STATIONS as STATIONS
from trainer.core.kernel import Numbers
from trainer.io.orders.grammar import Order, Reply, parse

MEAN_ROUNDING: Final = 1e-7  # [SI] between a sliding mean and one by itself, and far more
SEEN_QUANTITIES: Final[Mapping[str, Callable[[Boat], float]]] = {  # beside those of the state
    "showing": height_showing,
    "eye": eye_height,
    "clearance": clearance,
}


class GivenOrder(NamedTuple):
    """An order that the crew gave at this tick, and what was answered."""

    text: str
    reply: Reply


@dataclass
class CrewReaction:
    """How slow a crew is beyond its rules."""

    late: float = 0.0  # [s] added to every reaction
    jitter: float = 0.0  # [s] at most, by the seed
    seed: int = 0

    @cached_property
    def _draws(self) -> "np.random.Generator":  # few crews draw: numpy loads its own for them
        return np.random.default_rng(self.seed)

    def delay(self) -> float:
        """Return how much later the next reaction comes [s]."""
        return self.late + (self.jitter * float(self._draws.random()) if self.jitter else 0.0)


@dataclass
class RuleProgress:
    """One rule as it is followed."""

    rule: CrewRule
    due: float | None = None  # [s] when its order is to be given
    given: float | None = None  # [s] when it last was
    over: bool = False
    noticed: float = 0.0  # the order to the crew that it has reacted to, by its tick in the state


class ReferenceCrew:
    """The reference crew of one exercise aboard one boat, from this moment on."""

    def __init__(self, boat: Boat, crew: Crew, reaction: CrewReaction | None = None) -> None:
        """Come aboard with no rule carried out, and no hand at work."""
        self.boat = boat
        self.crew = crew
        self.reaction = reaction or CrewReaction()
        self.gauges = GaugeHistory(boat)
        self.follow_rules([RuleProgress(rule) for rule in crew.rules])
        self._factors: dict[str, float] = {}  # of the quantities that rules have asked for
        self.hands: dict[str, PlanesHand | RudderHand] = {}
        # who gives an order to the boat: in a session, the journal has it before it acts
        self.order: Callable[[Order], Reply] = partial(obey_order, boat)

    def look(self) -> list[GivenOrder]:
        """Follow the rules and the hands at this tick; return the orders given."""
        self.gauges.look()
        orders = []
        for lead, progress in self._led:
            if progress.over or (lead is not None and lead.given is None):
                continue
            if progress.due is None:
                self._notice(progress, lead)
            if self.is_due(progress):
                orders.append(self._carry_out(progress))
        for hand in list(self.hands.values()):
            orders += self.steer(hand)
        return orders

    def steer(self, hand: PlanesHand | RudderHand) -> list[GivenOrder]:
        """Have a hand look, and return what it orders."""
        return [self._give(text) for text in hand.look(self.gauges)]

    def next_look(self) -> float:
        """Return the time [s] until which nothing is due by the clock, while nobody orders.

        By then it looks again; ``first_sight`` tells whether gauges have it look before.
        """
        times = [self._next_look_of(each) for each in self._waiting()]
        for hand in self.hands.values():
            exact = self.gauges.exact  # else nobody knows before what a hand sees
            times.append(hand.next_change() if exact else hand.looked + hand.habits.look_s)
        return min(times, default=math.inf) - 2.0 * TIME_ROUNDING_S

    def first_sight(self, column: Callable[[str], Numbers], readings: Numbers) -> int:
        """Return after how many ticks a rule may begin, or a hand may order something.

        It is all of the ticks that were flown if nothing does.
        ``column`` gives a field of the state at these ticks, ``readings`` has a row for each of
        what the gauges read. Means are summed otherwise than by a look, which decides.
        """
        first = self.first_cause(column, readings)
        if self.hands and self.gauges.exact:
            step = self.boat.method.step
            begun = self.boat.ticks - len(readings)
            ahead = TicksAhead(begun, step, column, readings, self.gauges)
            first = min(first, *(hand.first_order(ahead) for hand in self.hands.values()))
        return first

    def first_cause(self, column: Callable[[str], Numbers], readings: Numbers) -> int:
        """Return after how many ticks a rule may begin by the gauges, or all."""
        first, now = len(readings), self.boat.time - len(readings) * self.boat.method.step
        for each in self._waiting():
            row = each.rule.row
            over = row.to_s is not None and now > row.to_s + 1.0
            if each.due is None and row.when and not over and self._begins(each) <= now + 1.0:
                shown = [
                    self._may_show(condition, row.mean_s or 0.0, column, readings)
                    for condition in each.rule.conditions
                ]
                shows = shown[0] if len(shown) == 1 else np.logical_and.reduce(shown)
                soonest = int(shows.argmax())
                if shows[soonest]:
                    first = min(first, soonest + 1)
        return first

    def pass_over(self, begun: int, readings: Numbers) -> None:
        """Take these ticks after a tick as seen, at which nothing was to be ordered.

        ``readings`` [ticks, gauges] are theirs. The next look is at the last of them.
        """
        step = self.boat.method.step
        ahead = TicksAhead(begun, step, lambda _: readings, readings[:-1], self.gauges)
        for hand in self.hands.values():
            if looks := ahead.looks(hand.looked, hand.habits.look_s):
                hand.looked = (begun + looks[-1] + 1) * step
        times = step * np.arange(begun + 1, begun + 1 + len(readings))
        self.gauges.remember(zip(times.tolist(), readings.tolist(), strict=True))

    @property
    def has_begun_anew(self) -> bool:
        """Return whether a rule was carried out now, so that others may follow."""
        return any(each.given == self.boat.time for each in self.followed)

    def _may_show(
        self,
        condition: Condition,
        mean: float,
        column: Callable[[str], Numbers],
        readings: Numbers,
    ) -> NDArray[np.bool_]:
        """Return at which ticks the gauges may show that a condition holds."""
        quantity, slack = condition.quantity, 1e-12
        if quantity in ("depth", "speed", "depth_rate"):
            slack = MEAN_ROUNDING
            rate = quantity == "depth_rate"
            values = self.gauges.over("depth" if rate else quantity, mean, readings, rate=rate)
        elif quantity == "course":
            values = readings[:, InstrumentReadings._fields.index("heading")] % math.tau
        elif quantity == "clearance":
            slack, vessel = MEAN_ROUNDING, self.boat.vessel
            grounds = [column(f"bottom[0,{i}]") for i in range(len(STATIONS))]
            values = heights_of_keel(grounds, column, float(vessel.ell), keel_of(vessel))
        elif quantity in SEEN_QUANTITIES:
            return np.ones(len(readings), bool)  # a look tells
        else:
            factor = self._factor(quantity)
            field, last = STATE_QUANTITIES[quantity].field, self.boat.ticks
            ticks = np.arange(last - len(readings), last, dtype=np.float64) + 1.0
            numbers = ticks if field == "tick" else column(field)
            values = numbers / factor if factor else np.zeros(len(readings))
        above = condition.sense * (values - condition.threshold)
        return above > 0.0 if condition.strict and slack == 1e-12 else above >= -slack

    def _waiting(self) -> list[RuleProgress]:
        """Return the rules that wait for something."""
        return [
            each
            for lead, each in self._led
            if not each.over and (lead is None or lead.given is not None)
        ]

    def follow_rules(self, rules: list[RuleProgress]) -> None:
        """Follow these rules, and no others."""
        self.followed = rules
        # each after the one that it follows upon, None for one that follows none
        self._led = [
            (lead if each.rule.row.then else None, each)
            for lead, each in zip((None, *rules), rules, strict=False)
        ]

    def _begins(self, each: RuleProgress) -> float:
        """Return the time [s] from which a rule about gauges looks at them."""
        row = each.rule.row
        again = 0.0 if row.every_s is None or each.given is None else each.given + row.every_s
        return max(row.from_s or 0.0, again)

    def _next_look_of(self, each: RuleProgress) -> float:
        """Return the time [s] before which a rule can neither be due nor noticed by the clock."""
        row = each.rule.row
        if each.due is not None:
            return each.due
        if row.at_s is not None:
            return row.at_s
        if row.ordered is not None:
            return math.inf
        if row.when is None:
            return 0.0
        begins = self._begins(each)
        return begins if begins > self.boat.time else math.inf

    def aboard(self, boat: Boat) -> "ReferenceCrew":
        """Return this crew with its rules, its gauges and its hands, aboard another boat."""
        crew = ReferenceCrew(boat, self.crew, self.reaction)
        crew.gauges.seen = self.gauges.seen.copy()
        crew.follow_rules([replace(progress) for progress in self.followed])
        crew.hands = {name: hand.aboard(boat) for name, hand in self.hands.items()}
        return crew

    def notice(self) -> None:
        """Read the gauges at this tick, and set when the orders of rules are due."""
        self.gauges.look()
        for lead, progress in self._led:
            if not progress.over and progress.due is None:
                self._notice(progress, lead)

    def is_due(self, progress: RuleProgress) -> bool:
        """Return whether the order of a rule is to be given by now."""
        return progress.due is not None and self.boat.time >= progress.due - TIME_ROUNDING_S

    def count(self, progress: RuleProgress) -> None:
        """Count a rule as carried out now; one that comes again waits again."""
        row, order = progress.rule.row, progress.rule.order
        progress.given, progress.due = self.boat.time, None
        progress.over = row.ordered is None and row.every_s is None
        if order.name in CREW_HANDS:
            self._switch(order)

    def come_late(self) -> None:
        """Have what is overdue, but whose cause is over, wait for it again."""
        for progress in self.followed:
            if self.is_late(progress):
                progress.due = None

    def is_late(self, progress: RuleProgress) -> bool:
        """Return whether the order of a rule is overdue, and its cause over."""
        overdue = progress.due is not None and progress.due < self.boat.time - TIME_ROUNDING_S
        return overdue and progress.rule.row.when is not None and self._begun(progress) is None

    def _stamp(self, axis: str | None) -> float:
        """Return which order to the crew stands on an axis, by its tick in the state; 0 none."""
        return self.boat.plain[STAMP_OFFSET + CREW_AXES.index(axis)] if axis else 0.0

    def _notice(self, each: RuleProgress, before: RuleProgress | None) -> None:
        """Set when a rule's order is due, if what it waits for has come."""
        if before is not None and before.given is None:
            return
        begun = self._begun(each)
        if begun is None:
            return
        if before is not None and before.given is not None:
            begun = max(begun, before.given)
        due = begun + (each.rule.row.after_s or 0.0) + self.reaction.delay()
        each.due = max(due, self.boat.time)

    def _begun(self, each: RuleProgress) -> float | None:
        """Return since when [s] what a rule waits for is there, None if it is not."""
        row, now = each.rule.row, self.boat.time
        if row.at_s is not None:
            return row.at_s if now >= row.at_s - TIME_ROUNDING_S else None
        if row.ordered is not None:
            stamp = self._stamp(row.ordered)
            if stamp in (0.0, each.noticed):
                return None
            each.noticed = stamp
            return now
        if row.when is None:
            return 0.0
        begins = row.from_s or 0.0
        if row.every_s is not None and each.given is not None:
            begins = max(begins, each.given + row.every_s)
        if (
            not begins - TIME_ROUNDING_S
            <= now
            <= (math.inf if row.to_s is None else row.to_s) + TIME_ROUNDING_S
        ):
            return None
        mean = row.mean_s or 0.0
        return now if all(self._shows(one, mean) for one in each.rule.conditions) else None

    def _shows(self, condition: Condition, mean: float) -> bool:
        """Return whether the gauges show that a condition holds."""
        above = condition.sense * (self._shown(condition.quantity, mean) - condition.threshold)
        return above > 0.0 if condition.strict else above >= -1e-12

    def _shown(self, quantity: str, mean: float) -> float:
        """Return a quantity [SI] as the crew sees it."""
        if quantity in ("depth", "speed"):
            return self.gauges.mean(quantity, mean)
        if quantity == "depth_rate":
            return self.gauges.rate("depth", mean)
        if quantity == "course":
            return self.gauges.now().heading % math.tau
        if quantity in SEEN_QUANTITIES:
            return SEEN_QUANTITIES[quantity](self.boat)
        factor = self._factor(quantity)
        return (
            self.boat.plain[STATE_OFFSETS[STATE_QUANTITIES[quantity].field]] / factor
            if factor
            else 0.0
        )

    def _factor(self, quantity: str) -> float:
        """Return the factor from a quantity to its field of the state, as ``scale_of``."""
        if quantity not in self._factors:
            self._factors[quantity] = scale_of(self.boat, quantity)
        return self._factors[quantity]

    def _carry_out(self, progress: RuleProgress) -> GivenOrder:
        """Give the order of a rule."""
        order = progress.rule.order
        self.count(progress)
        if order.name in CREW_HANDS:
            return GivenOrder(order.text, order.text)
        if order.name == MARK_ORDER:
            return GivenOrder(order.text, f"marked at {self.boat.time:g} s")
        if order.name in SAID_ORDERS:
            return GivenOrder(order.text, "reported")
        return GivenOrder(order.text, self.order(order))

    def _switch(self, order: Order) -> None:
        """Put a hand on planes or rudder, or take it off."""
        self.hands.pop(order.name, None)
        if order.word == "on" and order.name == "planesman":
            self.hands[order.name] = PlanesHand(
                self.boat, self.crew.planesman, self.reaction.delay()
            )
        elif order.word == "on":
            self.hands[order.name] = RudderHand(
                self.boat, self.crew.helmsman, self.reaction.delay()
            )

    def _give(self, text: str) -> GivenOrder:
        return GivenOrder(text, self.order(order_of_hand(text)))


@cache
def order_of_hand(text: str) -> Order:
    """Return the order of a hand, which has a few hundred words."""
    order = parse(text)
    assert isinstance(order, Order)  # noqa: S101 (a hand's own words)
    return order

"""What to order now, and the best way on from here.

A hint is an order whose coming now keeps marks that waiting loses, or one that is missing though
nothing is lost yet. It is never that of a rule which is not due.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, Final

import numpy as np

from trainer.boat.casualties import broken_gauges
from trainer.boat.depths import lowest_depth
from trainer.boat.helm import obey_order
from trainer.boat.reference_crew import RuleProgress
from trainer.debrief.attainable.continuations import Continuation, is_water
from trainer.debrief.attainable.search import (
    WORTH_MARKS,
    AttainablePoint,
    ContinuationSearch,
    OpenMoment,
    crew_of,
    order_at,
    parsed,
)
from trainer.debrief.marks.rehearsal import depart, last_tick
from trainer.io.orders.grammar import Order, Reply, parse
from trainer.io.recording.facts import REFERENCE_GIVER
from trainer.io.status_line import clock

WAIT_S: Final = 30.0  # [s] of waiting, whose price a hint tells
COMPARE_TEXT: Final = "compare your gauges, for one is wrong"
AXIS_TEXTS: Final = {"pitch": "an angle"}  # of an order to the crew


@dataclass
class Advisor:
    """Who advises at one moment of a run."""

    search: ContinuationSearch
    moment: OpenMoment

    def __post_init__(self) -> None:
        self.best = self.search.plainest(self.moment)
        self.later = self.moment.here.tick + round(WAIT_S / self.search.plan.method.step)
        self.later = min(self.later, last_tick(self.search.plan))
        crew = crew_of(self.moment.here)
        self.pending = crew.pending(self.moment.here.tick * self.search.plan.method.step)

    def marks(self) -> AttainablePoint:
        """Return the best that can be had now, or by waiting first."""
        if self.best.serves(100.0 - WORTH_MARKS, won=True):
            return self.best
        waited = self.search.best(self._waited(()), self.best.marks, won=self.best.won)
        return max(self.best, waited, key=lambda each: (each.marks, each.won))

    def answer(self, text: str) -> Reply:
        """Return what the boat answers to an order that is given now."""
        boat = depart(self.search.plan, self.moment.here)
        given = [*parsed(self.search.later.get(boat.ticks, ())), parse(text)]
        return [obey_order(boat, each) for each in given if isinstance(each, Order)][-1]

    def marks_after(self, text: str) -> float:
        """Return what can be had after an order, and no other for WAIT_S [%]."""
        return self.search.best(self._waited((text,))).marks

    def hint(self) -> str:
        """Return what to order now and what it is worth, "" where nothing is missing."""
        missing = self._missing()
        lost = self._lost_by(self._waited(()))
        if lost > WORTH_MARKS:
            enough = (e for e in missing if self._lost_by(self._waited((e,))) <= WORTH_MARKS)
            one = next(enough, "")
            if text := one or " and ".join(missing):
                why = self._why(one or missing[0])
                return f"{text}{why}: {_marks(lost)} lost by waiting {WAIT_S:g} s more"
        worth = {each: self._worth(each) for each in missing}
        text = max(worth, key=lambda each: worth[each], default="")
        if text and worth[text] > WORTH_MARKS:
            return f"{text}{self._why(text)}: {_marks(worth[text])} hang on it"
        crew = crew_of(self.moment.here).crew
        broken = broken_gauges(depart(self.search.plan, self.moment.here))
        if any(hand.gauge in broken for hand in crew.hands.values()):
            return COMPARE_TEXT
        return self._steering()

    def _missing(self) -> list[str]:
        """Return the orders that the way begins with, or that are due; none that is not due."""
        due = [each.rule.order.text for each in self.pending]
        rules = {each.rule.order.text for each in crew_of(self.moment.here).crew.followed}
        first = [e for e in self.best.way.first if e not in rules or e in due or self._was_given(e)]
        followed = crew_of(self.moment.here).crew.followed
        ahead = [followed[each] for each in self.best.way.settled]
        if any(each not in self.pending and each.given is None for each in ahead):
            first = [each for each in first if not is_water(each)]
        return list(dict.fromkeys((*due, *first)))

    def _steering(self) -> str:
        """Return what a hand of the reference crew would steer, if to steer on loses marks."""
        crew = crew_of(self.moment.here)
        if not crew.crew.hands:
            return ""
        lost = self._lost_by(self.search.fly_on(self.moment, self.later))
        if lost <= WORTH_MARKS:
            return ""
        aboard = crew.aboard(depart(self.search.plan, self.moment.here))
        orders = [(name, texts[0]) for name, texts in aboard.hand_orders() if texts]
        if not orders:
            return ""
        name, text = orders[0]
        return (
            f"{text}, as its {name} would steer: {_marks(lost)} lost by waiting {WAIT_S:g} s more"
        )

    def _waited(self, texts: Sequence[str]) -> OpenMoment:
        """Return the moment after some orders and a wait, in which hands at work steer on."""
        moment, tick = self.moment, self.moment.here.tick
        giver = moment.own[-1].giver if moment.own else REFERENCE_GIVER
        given = [order_at(tick, giver, text) for text in texts]
        orders = dict(self.search.later)
        orders[tick] = [*orders.get(tick, ()), *given]
        there, past = self.search.steer_on(moment.here, moment.past, orders, tick, self.later)
        return OpenMoment(there, past, (*moment.own, *given))

    def _lost_by(self, moment: OpenMoment) -> float:
        """Return the marks that are lost when the crew has come to a moment [%]."""
        there = self.search.best(moment, self.best.marks, won=self.best.won)
        return self.best.marks - max(there.marks, 0.0)

    def _worth(self, text: str) -> float:
        """Return the marks lost for good without an order [%]."""
        way = self.best.way
        rules = tuple(i for i, o in enumerate(self.search.plan.crew.rules) if o.order.text == text)
        first = tuple(each for each in way.first if each != text)
        without = replace(way, first=first, settled=(*way.settled, *rules))
        return self.best.marks - self.search.point(self.moment, without).marks

    def _why(self, text: str) -> str:
        """Return why an order is due, as it goes on in a sentence."""
        late = next((each for each in self.pending if each.rule.order.text == text), None)
        if late is None:
            return ", which was ordered and does not stand" if self._was_given(text) else ""
        return f", due since {clock(late.due or 0.0)}, for {_cause_words(late)}"

    def _was_given(self, text: str) -> bool:
        return any(
            each.rule.order.text == text and each.given is not None
            for each in crew_of(self.moment.here).crew.followed
        )

    def way(self) -> dict[str, Any]:
        """Return the best way on; its ``fault`` says why it is none to show."""
        way = self.best.way
        return {
            "first": list(way.first),
            "settled": list(way.settled),
            "drops_late": way.drops_late,
            "marks": self.best.marks,
            "fault": self._fault(way),
        }

    def _fault(self, way: Continuation) -> str:
        flown = self.search.fly(self.moment, way)
        hull, step = self.search.plan.launch_boat().file.hull, self.search.plan.method.step
        columns = flown.trajectory.columns
        depths = lowest_depth(columns["z"], columns["theta"], hull.length)
        deepest = int(np.argmax(depths))
        at = f"{depths[deepest]:.0f} m deep at {clock((self.moment.here.tick + deepest) * step)}"
        limit = hull.test_depth_m
        if self.best.lost:
            verdict = self.best.card.verdict if self.best.card else None
            return f"loses: {verdict.reason if verdict else flown.lost}"
        if limit is not None and depths[0] < limit <= depths[deepest]:
            return f"goes past test depth, {at}"
        return ""


def _marks(marks: float) -> str:
    return f"{marks:.0f} mark{'' if round(marks) == 1 else 's'}"


def _cause_words(progress: RuleProgress) -> str:
    """Return what a rule of the reference crew waited for, in words."""
    row = progress.rule.row
    if row.ordered is not None:
        return f"{AXIS_TEXTS.get(row.ordered, f'a {row.ordered}')} was ordered"
    if row.when is not None:
        return f"the gauges show {row.when}"
    return "it follows the order before" if row.at_s is None else f"it is {clock(row.at_s)}"

"""The controls that an order works, and what takes it back.

Both are found in what orders write into the state (``effects``): a control is a place there at
which two wordings write otherwise. So no list says what an order works. Orders with a procedure
have no effect, and are a control of their own by name.
"""

import math
from collections import defaultdict
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from trainer.boat.boat import Boat
from trainer.boat.effects import Effect, effects_of_boat
from trainer.core.kernel import Record
from trainer.io.orders.grammar import Order, parse

Controls = frozenset[int | str]  # places of the state, or the name of an order without an effect


class OrderControls:
    """What the orders of one boat work."""

    def __init__(self, boat: Boat) -> None:
        """Read the boat's effects."""
        self._effects = {each.words: each for each in effects_of_boat(boat)}
        written: dict[int, set[tuple[str, float]]] = defaultdict(set)
        for effect in self._effects.values():
            for place, rule, argument in effect.writes:
                written[place].add((rule, argument + 0.0))
        self._places = frozenset(
            place
            for place, ways in written.items()
            if len(ways) > 1 or any(rule != "const" for rule, _ in ways)
        )

    def of(self, order: Order) -> Controls:
        """Return the controls that an order works."""
        effect = self._effects.get(order.words)
        return self._worked(effect) if effect else frozenset({order.name})

    def places(self, order: Order) -> list[int]:
        """Return the places of the state that an order works; none of one by procedure."""
        return sorted(each for each in self.of(order) if isinstance(each, int))

    def setting(self, order: Order) -> dict[int, float]:
        """Return what an order sets its controls to, by their places."""
        writes = self._effects[order.words].writes if order.words in self._effects else ()
        ways = {"const": lambda a: a, "number": lambda a: a * order.value}
        ways["over"] = lambda a: order.value / a
        return {
            place: ways[rule](argument)
            for place, rule, argument in writes
            if place in self._places and rule in ways
        }

    def is_switch(self, order: Order) -> bool:
        """Return whether no order sets its controls by a number."""
        return not any(
            each.number and self._worked(each) & self.of(order) for each in self._effects.values()
        )

    def taking_back(self, order: Order, earlier: Sequence[Order], start: Record) -> str:
        """Return the order that takes another one back, "" for none.

        It is the last before it on the same controls, else what puts them back as they were at a
        ``start``.
        """
        controls = self.of(order)
        for each in reversed(earlier):
            if each.text != order.text and self.of(each) >= controls:
                return each.text
        effect = self._effects.get(order.words)
        if effect is None:
            return ""
        numbers = start.view(np.float64).ravel()
        was = {w.place: float(numbers[w.place]) for w in effect.writes if w.place in controls}
        after = _with_writes(was, effect)
        ways = [
            (_count_other(was, _with_writes(after, other)), len(other.writes), other)
            for other in self._effects.values()
            if not other.number
            and self._worked(other) & controls
            and isinstance(parse(other.words), Order)
        ]
        said, off = set(order.words.split()), _count_other(was, after)
        ways = [way for way in ways if way[0] < off]
        ways.sort(key=lambda way: (*way[:2], -len(said & set(way[2].words.split()))))
        return ways[0][2].words if ways else ""

    def _worked(self, effect: Effect) -> Controls:
        return frozenset(each.place for each in effect.writes) & self._places


def _with_writes(stands: Mapping[Any, float], effect: Effect) -> dict[Any, float]:
    """Return what stands after an effect; what it writes otherwise than constant is unlike any."""
    writes = [each for each in effect.writes if each.place in stands]
    put = {w.place: w.argument + 0.0 if w.rule == "const" else math.nan for w in writes}
    return {**stands, **put}


def _count_other(was: Mapping[Any, float], stands: Mapping[Any, float]) -> int:
    return sum(value != stands[place] for place, value in was.items())

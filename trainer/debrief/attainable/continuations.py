"""What a crew could do: some orders at once, then the reference crew's rules.

A rule is a want: what it ordered last on a control should stand there. A continuation gives again
what does not stand, moves water to the level that the rules want, or takes back what no rule
wants; what the exercise does not put in hand goes back to the autopilot. ``search`` flies them.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from enum import Enum
from typing import Final

from trainer.boat.mute_crew import AXES_OF_HANDS, WATER_ORDERS, MuteCrew
from trainer.boat.order_controls import OrderControls
from trainer.config.exercise.reference_crew import CREW_HANDS, SAID_ORDERS
from trainer.core.ballast.tanks import TANKS
from trainer.debrief.passage.controls import HAND_CONTROLS, SURFACE_ORDERS
from trainer.io.orders.grammar import Order, parse
from trainer.io.orders.words import BOAT_ORDERS, HAND_AXES, ORDER_WORDS
from trainer.session.past.plan import Plan

MODE_ORDERS: Final = frozenset({"rudder-mode", "planes-mode"})
ANGLE_ORDERS: Final = SURFACE_ORDERS - MODE_ORDERS  # what hands of the reference crew give
AUTOMATIC_ORDERS: Final = {  # by axis, where there is one of that name
    axis: order for axis in HAND_AXES if isinstance(order := parse(f"{axis} auto"), Order)
}
LEAST_WATER_KG: Final = 10.0  # that is worth a pump's order


class ContinuationKind(Enum):
    """The kinds of continuations. The values are told to programs."""

    OWN = "the crew's own orders"
    RENEW = "renew"
    RENEW_WATER = "renew, water"
    RENEW_ONE = "renew one"
    REFERENCE = "reference"
    STRICT = "list"
    ONE_ORDER = "one order"
    RESTORE = "restore"


@dataclass(frozen=True)
class Continuation:
    """Orders at a moment; from there the reference crew gives its own."""

    kind: ContinuationKind
    first: tuple[str, ...] = ()
    settled: tuple[int, ...] = ()  # rules, by index, that these orders carry out
    drops_late: bool = False  # what is overdue, where its cause is over

    @property
    def alike(self) -> object:
        """Return what continuations of two moments have in common; amounts of water differ."""
        names = tuple(" ".join(each.split()[:2]) if is_water(each) else each for each in self.first)
        single = self.kind in (ContinuationKind.ONE_ORDER, ContinuationKind.RENEW_ONE)
        return self.kind, names if single else ()


def is_water(text: str) -> bool:
    """Return whether an order moves water into a tank, out of it or to another."""
    return text.partition(" ")[0] in WATER_ORDERS


class Choices:
    """The continuations of the moments of one run."""

    def __init__(self, plan: Plan) -> None:
        """Find what the rules of the plan's crew work."""
        boat = plan.launch_boat()
        self.plan, self.start = plan, boat.snapshot()
        self.controls = OrderControls(boat)
        self.levels = [float(each) for each in boat.state.water]
        rules = [rule.order for rule in plan.crew.rules]
        self.orders = [order for order in rules if order.name not in (*CREW_HANDS, *SAID_ORDERS)]
        self.wanted = frozenset().union(*map(self.controls.of, self.orders))
        self.hands = {order.name for order in rules if order.name in CREW_HANDS}
        self.by_hand = frozenset().union(*(HAND_CONTROLS[hand][1] for hand in self.hands))

    def of(self, mute: MuteCrew, own: Sequence[Order]) -> list[Continuation]:
        """Return what could be done where a mute crew is, after the crew's own orders.

        They come in the order in which they are most often the best.
        """
        kinds = ContinuationKind
        again = [each.text for each in self._wants(mute) if not mute.stands(each)]
        base = (*again, *self._automatic(mute, own))
        found = [Continuation(kinds.RENEW, base)]
        water = self._water(mute, own, due=True)
        if water[0]:
            found.append(Continuation(kinds.RENEW_WATER, (*base, *water[0]), water[1]))
        whole = self._water(mute, own, due=False)
        if whole[0] and whole[0] != water[0]:
            found.append(Continuation(kinds.RENEW_WATER, (*base, *whole[0]), whole[1]))
        dropped = any(mute.crew.is_late(each) for each in mute.crew.followed)
        if base or dropped:
            found.append(Continuation(kinds.REFERENCE, drops_late=True))
        if base and dropped:
            found.append(Continuation(kinds.REFERENCE, base, drops_late=True))
        undone = tuple(self._taken_back(mute, own, again))
        if undone:
            settled = water[1] if water[0] else ()
            found.append(Continuation(kinds.RESTORE, (*base, *undone, *water[0]), settled))
        if len(base) > 1:  # given again, an order may set back what it has done: each alone too
            found += [Continuation(kinds.RENEW_ONE, (text,)) for text in base]
        return [*found, *self._single(mute, base, undone)]

    def _wants(self, mute: MuteCrew) -> list[Order]:
        """Return the orders of rules that should stand: those that no later rule is against."""
        last: dict[int | str, Order] = {}
        given = [each for each in mute.crew.followed if each.given is not None]
        for each in sorted(given, key=lambda each: each.given or 0.0):
            order = each.rule.order
            if order.name in CREW_HANDS:  # what it works is its own from now on
                for surface in _zero_orders(order.name):
                    for control in self.controls.of(surface):
                        last.pop(control, None)
            elif order.name not in SAID_ORDERS and order.name not in WATER_ORDERS:
                last.update(dict.fromkeys(self.controls.of(order), order))
        orders = dict.fromkeys(last.values())
        return [o for o in orders if all(last.get(each) is o for each in self.controls.of(o))]

    def _automatic(self, mute: MuteCrew, own: Sequence[Order]) -> Iterator[str]:
        """Yield what gives back to the autopilot axes that the crew has no business with."""
        for axis, automatic in AUTOMATIC_ORDERS.items():
            worked = any(axis in _moves(each) and each.name not in MODE_ORDERS for each in own)
            hands = {AXES_OF_HANDS[hand] for hand in self.hands}
            ours = axis in {*self.plan.hand, *hands} or bool(
                self.wanted & self.controls.of(automatic)
            )
            if worked and not ours and not mute.stands(automatic):
                yield automatic.text

    def _water(
        self, mute: MuteCrew, own: Sequence[Order], *, due: bool
    ) -> tuple[tuple[str, ...], tuple[int, ...]]:
        """Return the orders that bring tanks to the level of the rules, and these rules.

        They are those carried out or ``due`` by now, in tanks that the crew has worked; or all, in
        any tank. A tank's level counts, since a pump's order takes the place of the one under way.
        """
        boat = mute.crew.boat
        moved = [each for each in own if each.name in WATER_ORDERS]
        worked = {tank_of(each) for each in moved}
        under_way = {
            tank_of(e) for e in moved if any(boat.plain[p] for p in self.controls.places(e))
        }
        wanted: dict[str, float] = {}
        settled = []
        for index, each in enumerate(mute.crew.followed):
            order, given = each.rule.order, each.given is not None
            if order.name not in WATER_ORDERS:
                continue
            late = each.due is not None and mute.crew.is_due(each)
            if given or late or not due:
                wanted[tank_of(order)] = wanted.get(tank_of(order), 0.0) + amount_of(order)
            if late or not (given or due):
                settled.append(index)
        tanks = worked & set(wanted) if due else worked | set(wanted)
        orders = []
        for tank in sorted(tanks):
            index = TANKS.index(tank)
            mass = wanted.get(tank, 0.0) - (float(boat.state.water[index]) - self.levels[index])
            if abs(mass) > LEAST_WATER_KG or (tank in under_way and tank not in wanted):
                orders.append(water_text(tank, mass))
        return tuple(orders), tuple(settled)

    def _taken_back(
        self, mute: MuteCrew, own: Sequence[Order], again: Sequence[str]
    ) -> Iterator[str]:
        """Yield what takes back the crew's orders that no rule gives, nor a hand of its."""
        told = {each.text for each in self.orders} | set(again)
        for index, order in enumerate(own):
            if order.text in told or order.name in {*WATER_ORDERS, *ANGLE_ORDERS}:
                continue
            text = self.controls.taking_back(order, own[:index], self.start)
            back = parse(text) if text else None
            if isinstance(back, Order) and text not in told and not mute.stands(back):
                told.add(text)
                yield text

    def _single(
        self, mute: MuteCrew, base: Sequence[str], undone: Sequence[str]
    ) -> Iterator[Continuation]:
        """Yield continuations that begin with one order which neither stands nor is due."""
        pending = {each.rule.order.text for each in mute.pending(mute.crew.boat.time)}
        texts = (*(each.text for each in self.orders if each.text not in pending), *undone)
        for text in dict.fromkeys(each for each in texts if each not in base):
            order = parse(text)
            assert isinstance(order, Order)  # noqa: S101 (rules are)
            if order.name in WATER_ORDERS or not mute.stands(order):
                rest = [each for each in base if not self._meet(each, order)]
                yield Continuation(ContinuationKind.ONE_ORDER, (text, *rest))

    def _meet(self, text: str, order: Order) -> bool:
        other = parse(text)
        return isinstance(other, Order) and bool(self.controls.of(other) & self.controls.of(order))


def _zero_orders(hand: str) -> Iterator[Order]:
    """Yield orders to the surfaces that a hand works."""
    rudder = hand == "helmsman"
    texts = ("rudder amidships",) if rudder else ("stern planes zero", "bow planes zero")
    yield from (order for text in texts if isinstance(order := parse(text), Order))


def _moves(order: Order) -> tuple[str, ...]:
    return ORDER_WORDS[order.name].moves(order.word) if order.name in BOAT_ORDERS else ()


def tank_of(order: Order) -> str:
    """Return the tank whose level tells what a water order has moved."""
    return "trim_aft" if order.word.startswith("trim") else order.word


def amount_of(order: Order) -> float:
    """Return how much more there is in that tank after a water order [kg]."""
    inward = order.word.endswith("aft") if order.word.startswith("trim") else order.name == "flood"
    return order.value if inward else -order.value


def water_text(tank: str, mass: float) -> str:
    """Return the order that moves so much [kg] into that tank, or out of it."""
    tonnes = f"{max(round(abs(mass) / 1000.0, 1), 0.1):g}"
    if tank.startswith("trim"):
        return f"pump trim {'aft' if mass > 0.0 else 'forward'} {tonnes} t"
    return f"{'flood' if mass > 0.0 else 'pump'} {tank.replace('_', '-')} {tonnes} t"

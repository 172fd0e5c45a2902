"""What an exercise has worked by hand (rudder, planes, speed, ballast), and by which roles.

Such an axis may not be given to the autopilot, because the crew is to learn to work it. An order to
the crew, such as a course, has to be carried out by a person, who needs the axis that steers it
(the rudder). ``HandWork`` knows what is in hand as time goes on. ``dispatch`` refuses orders by it,
and says who should obey when nobody mans the axis.
"""

from collections.abc import Callable, Collection
from dataclasses import dataclass, field
from typing import Final, NamedTuple

from trainer.boat.boat import Boat
from trainer.boat.depths import DepthGuard
from trainer.io.orders.grammar import Order, Refused, Reply, parse, to_the_autopilot
from trainer.io.orders.words import CREW_ROLES, HAND_AXES, ORDER_WORDS, TRAINEE
from trainer.session.stations.roles import INSTRUCTOR_ROLE, ROLES, refusal

WORDS_AXIS: Final = "words"  # the axis of an order in words
STEERING_ROLES: Final = ("helm", "pilot", TRAINEE)
DIVING_ROLES: Final = ("planes", "pilot", "diving", TRAINEE)
REPEATING_ROLES: Final = {  # who repeats an order
    "course": STEERING_ROLES,
    "speed": STEERING_ROLES,
    "depth": DIVING_ROLES,
    "pitch": DIVING_ROLES,
    WORDS_AXIS: (*CREW_ROLES, TRAINEE),
}
# The axes that an exercise may have worked by hand: in words, and an order by hand.
BY_HAND: Final = {
    "rudder": ("the rudder is", "rudder left 5"),
    "planes": ("the planes are", "stern planes dive 5"),
    "speed": ("the engine is", "bell ahead standard"),
    "ballast": ("the ballast is", "pump depth-control 1"),
}
# the axis in hand that carries out an order on another axis; others are carried out by themselves
STEERED_BY_HAND: Final = {"course": "rudder", "depth": "planes", "pitch": "planes"}
# the orders by hand that carry it out, to a side
STEERING_ORDERS: Final = {
    axis: frozenset(w.name for w in ORDER_WORDS.values() if hand in w.works and w.has_sides)
    for axis, hand in STEERED_BY_HAND.items()
}


class HandAxis(NamedTuple):
    """An axis that is worked by hand, and why the autopilot may not have it."""

    axis: str
    why: str


@dataclass
class HandWork:
    """The axes that the exercise has worked by hand, and those let go."""

    boat: Boat
    hand: frozenset[str] = frozenset()  # of HAND_AXES
    hand_from: float = 0.0  # [s]
    allowed: frozenset[str] = frozenset()  # automatic orders allowed nevertheless
    guard: DepthGuard = field(default_factory=DepthGuard)
    freed: set[str] = field(default_factory=set)  # axes that may be automatic after all

    @property
    def taken_at(self) -> float:
        """Return the tick at which the crew takes its axes, 0 for the start."""
        return self.boat.ticks_in(self.hand_from) if self.hand else 0

    @property
    def in_force(self) -> frozenset[str]:
        """Return the axes that the exercise has had worked by hand since ``hand_from``."""
        return self.hand if self.boat.time >= self.hand_from else frozenset()

    @property
    def worked(self) -> frozenset[str]:
        """Return the axes that nobody may give to the autopilot."""
        return self.in_force - self.freed

    @property
    def automatic(self) -> str:
        """Return all that may be automatic all the same, with commas."""
        return ",".join(sorted(self.allowed | self.freed))

    def conditions(self, role: str) -> list[tuple[str, str]]:
        """Return the keys and values that tell programs which axes are worked by hand."""
        later = self.hand_from > 0.0 and role == INSTRUCTOR_ROLE.name
        values = {
            "hand-from": f"{self.hand_from:g}" if later else "",
            "hand": ",".join(in_order(self.in_force)),
            "allowed": self.automatic if self.in_force else "",
            "free": "yes" if self.freed else "",
        }
        return [(key, value) for key, value in values.items() if value]

    def refuse(self, order: Order) -> Refused | None:
        """Return why work by hand forbids an automatic order, None if it does not.

        An order to the planes is refused while the depth guard holds them.
        """
        planes = "planes" in ORDER_WORDS[order.name].moves(order.word)
        if planes and "planes" in self.worked and self.guard.holds(self.boat):
            deepest = self.guard.deepest
            return Refused(f"the boat levels by itself before {deepest:g} m: try again soon")
        taken = in_hand(order, self.worked, self.allowed)
        return Refused(f"{taken.why}, or the instructor says allow {taken.axis}") if taken else None

    def allow(self, axis: str) -> Reply:
        """Answer the order that allows an axis to be automatic."""
        says, _ = BY_HAND[axis]
        if axis not in self.hand:
            return Refused(f"{says} not in hand in this exercise: nothing is to be allowed")
        if axis in self.freed:
            return Refused(f"{axis} may be automatic already")
        return f"{axis} may be automatic; the run is free: it has no marks"

    def free(self, axis: str) -> None:
        """Let an axis be automatic."""
        self.freed.add(axis)

    def put_back(self, freed: Collection[str]) -> None:
        """Put back the axes that were let go at another moment, because time has jumped."""
        self.freed = {*freed}

    def guard_depth(self) -> Order | None:
        """Return the order by which the guard takes the planes, where these are in hand."""
        order = self.guard.order(self.boat)
        return order if "planes" in self.worked else None


def refuse_taking(order: Order, role: str) -> Refused | None:
    """Return why a role may not have the axis that it claims, or None."""
    works = parse(BY_HAND[order.word][1])
    return refusal(ROLES[role], works) if isinstance(works, Order) else None


def in_order(axes: Collection[str]) -> list[str]:
    """Return axes in the order in which people are told of them."""
    return [axis for axis in HAND_AXES if axis in axes]


def in_hand(order: Order, hand: Collection[str], allowed: Collection[str]) -> HandAxis | None:
    """Return the axis worked by hand that an order would make automatic, None for none."""
    names = {order.name.replace("periscope", "depth"), f"{order.name} {order.word}"}
    taken = [axis for axis in ORDER_WORDS[order.name].automates(order.word) if axis in hand]
    if names.intersection(allowed) or not taken:
        return None
    says, example = BY_HAND[taken[0]]
    return HandAxis(taken[0], f"{says} in hand in this exercise: {example}")


def axis_of(order: Order) -> str:
    """Return the axis of an order to the crew."""
    return order.word.partition("_")[0].replace("periscope", "depth")


def unmanned_axes(hand: Collection[str], attends: Callable[[str], bool]) -> list[str]:
    """Return the axes that are worked by hand and have nobody at them.

    ``attends`` tells whether somebody with that role is there.
    """
    return [
        axis
        for axis in HAND_AXES
        if axis in hand and not any(map(attends, (*workers(axis), TRAINEE)))
    ]


def workers(axis: str) -> list[str]:
    """Return the roles of the crew that may work an axis by hand."""
    order = parse(BY_HAND[axis][1])
    name = order.name if isinstance(order, Order) else ""
    return [role for role in CREW_ROLES if name in ROLES[role].commands]


def unheard(
    order: Order, hand: Collection[str], allowed: Collection[str], roles: Collection[str]
) -> str:
    """Return how to carry out an order that nobody hears, "" if somebody does.

    ``roles`` are the attended ones, ``hand`` the axes that are worked by hand, ``allowed`` the
    automatic orders that are allowed nevertheless.
    """
    if order.name not in ("order", "tell") or order.word.startswith("clear"):
        return ""
    axis = WORDS_AXIS if order.name == "tell" else axis_of(order)
    if not set(REPEATING_ROLES[axis]).isdisjoint(roles):
        return ""
    if axis == WORDS_AXIS:
        return "nobody of the crew is here"
    own_order = to_the_autopilot(order)
    automatic = ""
    meant = isinstance(own_order, Order) and own_order.name != order.name  # not to the crew again
    if isinstance(own_order, Order) and meant and not in_hand(own_order, hand, allowed):
        automatic = f"`{own_order.text}` for the autopilot, "
    by_hand = f"`{BY_HAND[STEERED_BY_HAND.get(axis, axis)][1]}` by hand"
    return f"nobody mans the {REPEATING_ROLES[axis][0]}: {automatic}{by_hand}"

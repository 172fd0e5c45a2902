"""Which control an order works and which way, its opposite, and what controls move.

``attainable`` tells by it what was done wrong, ``authoring/trainees`` makes crews that do it, and
``station_marks`` tells whose a task is.
"""

import re
from collections.abc import Collection, Mapping
from typing import Final

from trainer.boat.mute_crew import AXES_OF_HANDS, WATER_ORDERS
from trainer.config.exercise.condition import PLANT_QUANTITIES, STATE_QUANTITIES
from trainer.config.exercise.score_rules import ScoreRule
from trainer.io.orders.grammar import Order, parse
from trainer.io.orders.words import CREW_ROLES, HAND_AXES, ORDER_WORDS, PERISCOPE_CONTROL
from trainer.session.crew.manning import STEERED_BY_HAND, workers

OPPOSITE_WORDS: Final = (  # the first that an order has is turned round
    ("aft", "forward"),
    ("rise", "dive"),
    ("left", "right"),
    ("flood", "pump"),
    ("ahead", "astern"),
)
WAY_WORDS: Final = (*OPPOSITE_WORDS, ("flood", "blow"), ("on", "off"))
HAND_CONTROLS: Final = {  # what the reference crew's hands work, and the orders that do
    hand: (axis, frozenset(w.name for w in ORDER_WORDS.values() if axis in w.moves("")))
    for hand, axis in AXES_OF_HANDS.items()
}
SURFACE_ORDERS: Final = frozenset().union(*(orders for _, orders in HAND_CONTROLS.values()))
SCOPE_AXIS: Final = "scope"  # worked beside HAND_AXES
# The axes that move a quantity or, of a rule without one, a measure: the first one steers it. An
# estimate: everything aboard moves everything a little.
DEPTH_AXES: Final = ("planes", "ballast")
MOVING_AXES: Final[Mapping[str, tuple[str, ...]]] = {
    **dict.fromkeys(("course", "turn_rate", "heel", "rudder"), ("rudder",)),
    **dict.fromkeys(("depth", "depth_rate", "pitch", "clearance", "showing"), DEPTH_AXES),
    **dict.fromkeys(("broaches", "beyond-test-depth", "time-beyond-test-depth"), DEPTH_AXES),
    **dict.fromkeys(("stern", "bow", "activity"), ("planes",)),
    **dict.fromkeys(("speed", "turns", "speed_over_ground", "distance"), ("speed",)),
    **dict.fromkeys(("north", "east", "closest-approach"), ("rudder", "speed")),
    **dict.fromkeys(("eye", "exposed", "exposed-raise"), (SCOPE_AXIS, *DEPTH_AXES)),
    **dict.fromkeys(("aground", "beyond-limits", "response"), HAND_AXES),
    **dict.fromkeys(("time", "wave", "alert-response"), ()),
    **{
        name: ("ballast",)
        for name in ("heavy", "reserve-air", *STATE_QUANTITIES)
        if name.partition("_")[0]
        in ("heavy", "reserve-air", "water", "flood", "bank", "vent", "blow")
        or name in PLANT_QUANTITIES
    },
    "hand-travel": ("planes", "rudder"),
    **dict.fromkeys(("time-to-detect", "time-to-report"), (SCOPE_AXIS,)),
}
ORDERED_AXES: Final = {**STEERED_BY_HAND, "speed": "speed"}  # that carry out an order to the crew


def opposite_order(text: str) -> str:
    """Return an order with its side turned round; the order itself if it has none."""
    for pair in OPPOSITE_WORDS:
        for word, other in (pair, pair[::-1]):
            turned = re.sub(rf"\b{word}\b", other, text)
            if turned != text and isinstance(parse(turned), Order):
                return turned
    return text


def control_of(text: str) -> str:
    """Return what an order works: a tank, a surface, or what its role has."""
    order = parse(text)
    if not isinstance(order, Order):
        return text.partition(" ")[0]
    if order.name in WATER_ORDERS:
        return order.word.partition("_")[0]
    word = ORDER_WORDS[order.name]
    return order.name if word.name in SURFACE_ORDERS else word.control.says or word.name


def moved_axes(order: Order) -> tuple[str, ...]:
    """Return the axes that an order moves or claims, tanks as ballast."""
    word = ORDER_WORDS[order.name]
    if word.control is PERISCOPE_CONTROL:
        return (SCOPE_AXIS,)
    tanks = ("ballast",) if word.needs == "ballast" else ()
    return tuple(dict.fromkeys((*word.takes(order.word), *tanks)))


def moving_axes(rule: ScoreRule) -> tuple[str, ...]:
    """Return the axes that move what a rule judges, the one that steers it first."""
    return MOVING_AXES[rule.measured.name if rule.measured else rule.score.measure]


def working_roles(axes: Collection[str]) -> tuple[str, ...]:
    """Return the roles of the crew that work any of those axes."""
    able = {role for axis in axes for role in _workers_of(axis)}
    return tuple(role for role in CREW_ROLES if role in able)


def _workers_of(axis: str) -> Collection[str]:
    return PERISCOPE_CONTROL.roles if axis == SCOPE_AXIS else workers(axis)


def is_wrong_way(text: str, right: str) -> bool:
    """Return whether an order works the control of the right one the other way."""
    said, wanted = (set(re.findall("[a-z]+", each)) for each in (text, right))
    turned = any(
        (one in said and other in wanted) or (other in said and one in wanted)
        for one, other in WAY_WORDS
    )
    return turned and control_of(text) == control_of(right)

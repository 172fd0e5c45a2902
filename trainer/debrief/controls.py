"""Which control an order works, which way, and which order is its opposite.

``attainable`` tells by it what was done wrong, ``authoring/trainees`` makes crews that do it.
"""

import math
import re
from typing import Final

from trainer.boat.mute_crew import is_same_order
from trainer.io.orders.grammar import Order, parse
from trainer.io.orders.words import ORDER_WORDS

OPPOSITE_WORDS: Final = (  # the first that an order has is turned round
    ("aft", "forward"),
    ("rise", "dive"),
    ("left", "right"),
    ("flood", "pump"),
    ("ahead", "astern"),
)
WAY_WORDS: Final = (*OPPOSITE_WORDS, ("flood", "blow"), ("on", "off"))
HAND_CONTROLS: Final = {  # what the reference crew's hands work, and the orders that do
    hand: (axis, frozenset(w.name for w in ORDER_WORDS.values() if w.works == axis))
    for hand, axis in (("planesman", "planes"), ("helmsman", "rudder"))
}
SURFACE_ORDERS: Final = frozenset().union(*(orders for _, orders in HAND_CONTROLS.values()))
WATER_ORDERS: Final = ("flood", "pump")  # so many tonnes into a tank, out of it, or to another
ALIKE_RAD: Final = math.radians(2.0)  # estimate: less is not worth an order to most hands


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


def is_alike(text: str, other_text: str) -> bool:
    """Return whether two orders say the same, of a surface within ALIKE_RAD."""
    order, other = parse(text), parse(other_text)
    if not (isinstance(order, Order) and isinstance(other, Order)):
        return text == other_text
    by_hand = order.name == other.name in SURFACE_ORDERS
    by_hand = by_hand and not {"auto", "manual"} & {order.word, other.word}
    near = by_hand and abs(order.value - other.value) <= ALIKE_RAD
    return near or is_same_order(order, other)


def is_wrong_way(text: str, right: str) -> bool:
    """Return whether an order works the control of the right one the other way."""
    said, wanted = (set(re.findall("[a-z]+", each)) for each in (text, right))
    turned = any(
        (one in said and other in wanted) or (other in said and one in wanted)
        for one, other in WAY_WORDS
    )
    return turned and control_of(text) == control_of(right)


def share_of(text: str, right: str) -> float:
    """Return an order's share of the right angle [-]; 0 for another surface."""
    order, wanted = parse(text), parse(right)
    if not (isinstance(order, Order) and isinstance(wanted, Order)) or not wanted.value:
        return 0.0
    return order.value / wanted.value if order.name in (wanted.name, "lever") else 0.0

"""A boat flown without a session, by orders that are given when they are due.

``fly_ticks`` flies for those who look at each tick. Those who fly many in one call go from one tick
with an entry due to the next (``debrief/marks/rehearsal``).
"""

from collections import defaultdict
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from itertools import accumulate

import numpy as np

from trainer.boat.boat import Boat
from trainer.boat.helm import obey_order
from trainer.io.orders.grammar import Order, Refused
from trainer.io.orders.schedule import ScheduledOrder
from trainer.io.orders.words import BOAT_ORDERS


def entries_due(boat: Boat, schedule: Iterable[ScheduledOrder]) -> dict[int, list[int]]:
    """Return the entries of a schedule by the tick in which they are due.

    It is the first that is not before an order's time, and not before those ahead of it.
    """
    due: dict[int, list[int]] = defaultdict(list)
    for entry, tick in enumerate(ticks_due(boat, schedule)):
        due[max(tick, 0)].append(entry)
    return due


def ticks_due(boat: Boat, schedule: Iterable[ScheduledOrder]) -> Iterator[int]:
    """Return each entry's tick: its own time, or that of one ahead of it."""
    return accumulate((boat.ticks_in(each.seconds) for each in schedule), max)


def orders_due(boat: Boat, schedule: Sequence[ScheduledOrder]) -> dict[int, list[Order]]:
    """Return the orders of a schedule by the tick in which they are due."""
    due = entries_due(boat, schedule).items()
    return {tick: [schedule[entry].order for entry in entries] for tick, entries in due}


def obey_all(boat: Boat, orders: Iterable[Order]) -> list[tuple[str, str]]:
    """Have the boat obey; return the text of each order that it refuses, and why.

    What is said to people moves nothing.
    """
    given = [each for each in orders if each.name in BOAT_ORDERS]
    replies = [(order, obey_order(boat, order)) for order in given]
    return [(order.text, reply.reason) for order, reply in replies if isinstance(reply, Refused)]


def fly_ticks(
    boat: Boat,
    last: int,
    due: Mapping[int, Sequence[Order]],
    look: Callable[[Sequence[Order]], object],
) -> Iterator[int]:
    """Fly tick by tick to ``last``, and yield each; end where one fails.

    Before each tick the boat obeys the orders due, and then ``look`` is called with them.
    """
    while boat.ticks < last:
        now = due.get(boat.ticks, ())
        with np.errstate(all="ignore"):
            obey_all(boat, now)
            look(now)
            if boat.tick():
                return
        yield boat.ticks

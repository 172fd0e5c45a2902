"""A second boat, flown beside the session's by the reference crew.

From the start by the schedule alone it is the ghost. By the orders that were given aboard, with
the crew mute, it tells what that crew knows at a moment, from which it can then show the way.
``aids`` flies the ghost, ``demonstration`` and ``debrief/page/boat_page`` follow a run.

A session flies it in a thread, so it rests after each tick: the session's own tick never waits for
long.
"""

import threading
import time
from collections import defaultdict
from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import partial
from typing import Final

from trainer.boat.boat import Boat
from trainer.boat.casualties import instrument_readings
from trainer.boat.due_orders import fly_ticks, orders_due
from trainer.boat.mute_crew import MuteCrew
from trainer.boat.reference_crew import ReferenceCrew
from trainer.config.exercise.reference_crew import MARK_ORDER
from trainer.io.orders.grammar import Order, parse
from trainer.io.recording.recording import RecordedEvent, RecordedOrder
from trainer.session.past.history import History
from trainer.session.past.journal import order_of
from trainer.session.past.plan import Plan
from trainer.session.stations.aids import GhostReading

MAX_GHOST_S: Final = 3600.0  # [s] of an exercise without an end
REST_S: Final = 0.0001  # [s] after each tick, in which other threads have their turn


def fly_ghost(plan: Plan, closing: threading.Event) -> list[GhostReading]:
    """Return what the gauges read at each tick of the reference crew's run."""
    boat = plan.launch_boat()
    crew = ReferenceCrew(boat, plan.crew)
    last = round((plan.duration or MAX_GHOST_S) / plan.method.step)
    due = orders_due(boat, plan.schedule)
    readings = [reading_of(boat)]
    for _ in fly_ticks(boat, last, due, lambda _: crew.look()):
        readings.append(reading_of(boat))
        time.sleep(REST_S)
        if closing.is_set():
            break
    return readings


def reading_of(boat: Boat) -> GhostReading:
    """Return what the gauges read now, and how the surfaces stand."""
    shown, s, toward = instrument_readings(boat), boat.state, boat.toward
    surfaces = (("rudder", s.delta_r), ("stern", s.delta_s), ("bow", s.delta_b))
    angles = (toward[name] * float(angle) for name, angle in surfaces)
    return GhostReading(shown.depth, shown.heading, shown.speed, float(s.theta), *angles)


def follow_run(
    plan: Plan,
    orders: Sequence[RecordedOrder],
    marks: Iterable[RecordedEvent],
    last_tick: int,
) -> MuteCrew:
    """Return the mute crew that has followed a run up to a tick.

    It is aboard a boat of its own, which is where the run was at the end of that tick.
    """
    boat = plan.launch_boat()
    mute, given = MuteCrew(boat, plan.crew), orders_by_tick(plan, orders, marks)
    for _ in fly_ticks(boat, last_tick, given, mute.follow):
        time.sleep(REST_S)
    mute.follow(given.get(boat.ticks, ()))
    return mute


def crew_so_far(plan: Plan, history: History) -> Callable[[], MuteCrew]:
    """Return what has a thread's mute crew follow the run so far."""
    return partial(follow_run, plan, history.said(), history.noted(), history.tick)


def orders_by_tick(
    plan: Plan, orders: Sequence[RecordedOrder], marks: Iterable[RecordedEvent]
) -> Mapping[int, Sequence[Order]]:
    """Return the accepted orders of a run by tick, its marks among them."""
    by_tick: dict[int, list[Order]] = defaultdict(list)
    for entry in orders:
        order = order_of(entry, plan.schedule)
        if order is not None and entry.accepted:
            by_tick[entry.tick].append(order)
    for event in marks:
        mark = parse(f"{MARK_ORDER} {event.text}")
        if event.kind == MARK_ORDER and isinstance(mark, Order):
            by_tick[event.tick].append(mark)
    return by_tick

"""A recording for a page: how each branch began, and what its ticks do not follow from.

The core predicts each state from the one before. Kept is what orders wrote before a tick, and what
was recorded otherwise than predicted, which is nothing for a whole recording of this version.
"""

import base64
from collections import deque
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from trainer.boat.boat import Boat
from trainer.boat.helm import obey
from trainer.config.files import ConfigError
from trainer.core.kernel import Numbers
from trainer.io.orders.table import BOAT_ORDERS
from trainer.io.recording.recording import Branch, Journalled, Recording
from trainer.session.header import differences, layout_of, plan_of, reading
from trainer.session.history import order_of
from trainer.session.layout import read_state
from trainer.session.plan import Plan

Writes = list[tuple[int, float]]  # places of the state, and what is written there


def boat_of(path: Path) -> tuple[Boat, dict[str, Any]]:
    """Return the boat of a recording at its start, and the recording for a page.

    ConfigError where it is damaged, or not of this version.
    """
    with reading(path) as recording, np.errstate(all="ignore"):
        header = recording.header()
        for each in differences(header)[:1]:
            raise ConfigError(f"{path.name}: {each}: in a page it would not be the same run")
        plan = plan_of(header)
        boat = Boat(plan.file, plan.method)
        layout = layout_of(header)
        plan.start(boat)
        flown = [fly(recording, each, boat, plan, layout) for each in recording.branches()]
        told = {
            "from": path.name,
            "branches": flown,
            "orders": orders_of(recording),
            "events": [(each.tick, each.kind, each.text) for each in recording.events()],
            "exercise": exercise_of(plan),
        }
        plan.start(boat)
    return boat, told


def exercise_of(plan: Plan) -> list[tuple[str, str]]:
    """Return what a page is told of the exercise, as a session tells it."""
    found = [("title", plan.title or plan.file.name)]
    found += [("line", line) for line in plan.briefing]
    return found + ([] if plan.duration is None else [("duration", f"{plan.duration:g}")])


def orders_of(recording: Recording) -> list[tuple[int, int, str]]:
    """Return branch, tick and words of the orders that were carried out."""
    given: list[tuple[int, int, str]] = []
    for branch in recording.branches():
        own = recording.orders(branch.id, branch.after)
        given += [(each.branch, each.tick, each.text) for each in own if each.accepted]
    return given


def fly(
    recording: Recording, branch: Branch, boat: Boat, plan: Plan, layout: tuple[str, ...]
) -> dict[str, Any]:
    """Return one branch for a page, flown from its beginning beside the recorded states."""
    standing = boat.records.state
    boat.restore(read_state(branch.state, layout, standing))
    begun = standing.tobytes()
    orders = deque(recording.orders(branch.id, branch.after))
    before: list[tuple[int, Writes]] = []
    after: list[tuple[int, Writes]] = []
    last = branch.tick
    for tick, state in recorded(recording, branch):
        if written := given(orders, tick - 1, boat, plan):
            before.append((tick - 1, written))
        boat.tick()
        there = read_state(state, layout, standing)["whole"][0]
        if changed := changes(boat.state.whole, there):
            after.append((tick, changed))
            boat.state.whole[:] = there
        last = tick
    if written := given(orders, last, boat, plan):
        before.append((last, written))
    return {
        "number": branch.id,
        "parent": branch.parent or 0,
        "begun": branch.tick,
        "last": last,
        "why": branch.why,
        "state": base64.b64encode(begun).decode("ascii"),
        "before": before,
        "after": after,
    }


def recorded(recording: Recording, branch: Branch) -> Iterator[tuple[int, bytes]]:
    """Yield tick and state of what a branch recorded after its beginning."""
    return ((tick, state) for tick, state in recording.states(branch.id) if tick > branch.tick)


def given(orders: deque[Journalled], tick: int, boat: Boat, plan: Plan) -> Writes:
    """Give the boat the orders of a tick; return what they have written."""
    was = boat.state.whole.copy()
    while orders and orders[0].tick <= tick:
        order = order_of(orders.popleft(), plan.schedule)
        if order is not None and order.name in BOAT_ORDERS:
            obey(boat, order)
    return changes(was, boat.state.whole)


def changes(was: Numbers, now: Numbers) -> Writes:
    """Return the places where two states differ in a bit, and what the second has there."""
    places = np.flatnonzero(was.view(np.int64) != np.ascontiguousarray(now).view(np.int64))
    return [(int(place), float(now[place])) for place in places]

"""The orders to the world that hold at a moment: current, ships near, ground.

Whoever goes back, resumes or replays needs them: a current or a ship is no part of the boat's
state, and follows from the orders given to the world so far.
"""

from collections.abc import Sequence
from typing import NamedTuple

from trainer.boat.boat import Boat
from trainer.boat.world.world import WORLD_PARTS
from trainer.io.orders.grammar import Order, parse
from trainer.io.recording.recording import RecordedOrder, Recording, RecordingError

WorldOrders = Sequence[tuple[int, Order]]  # each with its tick


class WorldOrder(NamedTuple):
    """An order to the world with its tick, and the one before it.

    A chain shares its beginning with the chains of other branches.
    """

    number: int
    tick: int
    order: Order
    before: "WorldOrder | None"


def world_orders(latest: WorldOrder | None) -> WorldOrders:
    """Return an order to the world and all before it, the first one first."""
    orders = []
    while latest:
        orders.append((latest.tick, latest.order))
        latest = latest.before
    return orders[::-1]


def to_world(entry: RecordedOrder, before: WorldOrder | None) -> WorldOrder | None:
    """Return the latest order to the world after an order of the journal."""
    if entry.accepted is False or entry.text.partition(" ")[0] not in WORLD_PARTS:  # most are not
        return before
    order = parse(entry.text)
    return WorldOrder(entry.id, entry.tick, order, before) if isinstance(order, Order) else before


def worlds_begun(recording: Recording) -> dict[int, WorldOrders]:
    """Return the orders to the world that hold where each branch begins.

    It goes through all branches once, because each of a long chain needs all before it.
    """
    begun: dict[int, WorldOrders] = {}
    flown: dict[int | None, WorldOrder | None] = {None: None}  # to the end of each branch
    for branch in recording.branches():
        if branch.parent not in flown:
            raise RecordingError(
                f"branch {branch.id} begins in branch {branch.parent}: there is none"
            )
        latest = flown[branch.parent]
        while latest and latest.number > branch.after:
            latest = latest.before
        begun[branch.id] = world_orders(latest)
        for entry in recording.orders(branch.id, branch.after):
            latest = to_world(entry, latest)
        flown[branch.id] = latest
    return begun


def recorded_world_orders(recording: Recording, branch: int, after: int) -> WorldOrders:
    """Return the orders to the world that a branch has up to ``after``."""
    latest = None
    for entry in recording.orders(branch):
        latest = to_world(entry, latest) if entry.id <= after else latest
    return world_orders(latest)


def settle_world(boat: Boat, recording: Recording, branch: int, after: int) -> None:
    """Bring a boat's world to what a branch's orders up to ``after`` made it."""
    boat.world.obey_anew(recorded_world_orders(recording, branch, after))

"""The world of one run has parts, which write a few numbers into the state.

The parts are ground, ships near, current and periscope. ``Boat`` asks the world before each tick.
What it writes is a pure function of the exercise, of the orders given to it with their ticks, and
of the state. So whoever flies the same orders again gets the same numbers.
"""

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from typing import Any, Final, Protocol

from trainer.boat.world.bottom import ground_of
from trainer.boat.world.contacts import contacts_of
from trainer.boat.world.current import make_current
from trainer.boat.world.scope import Periscope
from trainer.config.world.world import WorldTables
from trainer.io.orders.grammar import Order, Refused, Reply


class WorldPart(Protocol):
    """One part of the world. A ``state`` is one row, as ``Boat.state`` is."""

    @property
    def acts(self) -> bool:
        """Return whether there is anything to write; only orders change it."""

    def obey(self, order: Order, tick: int) -> Reply:
        """Take an order from a tick on; return what holds, or a refusal.

        Its effect follows from its words and the tick alone, so that a replay has the same world.
        """

    def forget(self) -> None:
        """Forget all orders: the part is as the exercise has it."""

    def stands(self, tick: int) -> bool:
        """Return whether it would write the same at every tick from this one on."""

    def write(self, numbers: Any) -> None:
        """Write its own among a state's numbers, for the tick that comes."""


@dataclass
class World:
    """All parts, by the names of the orders that they obey.

    ``changed`` is the boat's own: it asks again whether any part acts.
    """

    parts: Mapping[str, WorldPart] = field(default_factory=dict)
    changed: Callable[[], object] = field(default=lambda: None, repr=False, compare=False)

    @property
    def acts(self) -> bool:
        """Return whether anything writes into the state."""
        return any(part.acts for part in self.parts.values())

    def stands(self, tick: int) -> bool:
        """Return whether the same would be written at every tick from this one on."""
        return all(part.stands(tick) for part in self.parts.values() if part.acts)

    def write(self, numbers: Any) -> None:
        """Write into a state's ``numbers`` [SI] for the tick that comes, by their offsets."""
        for part in self.parts.values():
            if part.acts:
                part.write(numbers)

    def obey(self, order: Order, tick: int) -> Reply:
        """Give a part an order of its own; return its answer."""
        part = self.parts.get(order.name)
        answer = part.obey(order, tick) if part else Refused(f"there is no {order.name} here")
        self.changed()
        return answer

    def obey_anew(self, orders: Iterable[tuple[int, Order]]) -> None:
        """Forget all orders, and obey these anew, each at its tick."""
        for part in self.parts.values():
            part.forget()
        for tick, order in orders:
            if order.name in self.parts:
                self.parts[order.name].obey(order, tick)
        self.changed()


# by the name of a part's order: from the boat and the tables of the exercise to the part
WORLD_PARTS: Final[Mapping[str, Callable[[Any, WorldTables], WorldPart]]] = {
    "bottom": ground_of,
    "contact": contacts_of,
    "current": make_current,
    "scope": Periscope,
}


def world_of(boat: Any, tables: WorldTables) -> World:
    """Return an exercise's world around a boat; ConfigError on what it cannot have."""
    return World({name: make(boat, tables) for name, make in WORLD_PARTS.items()})

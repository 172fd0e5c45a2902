"""The ships from one order to the next: what each is, and where.

``contacts`` has one fleet for each order that changes the ships. Their ways are computed for many
ticks at once, because nothing but the next order changes them.
"""

import functools
import math
import operator
from collections import deque
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from trainer.boat.world.consorts import body_of
from trainer.boat.world.steered import SteeredContact
from trainer.boat.world.tracks import Piece, ShipMotion, Situation, Way, situation
from trainer.config.world.contacts import SHIP_TYPES, ShipType
from trainer.core.kernel import Numbers

Ticks = NDArray[np.int64]
BLOCK_TICKS: Final = 256  # ticks of ships computed at once
BOATS_BLOCK_TICKS: Final = 16  # where orders about boats of the class change them all the time
KNOWN_BLOCKS: Final = 16  # [blocks] kept, of KNOWN_SHIPS at most, 1.5 MB each
KNOWN_SHIPS: Final = 20
NO_BLOCK: Final[tuple[int, list[list[ShipMotion]]]] = (0, [])  # first tick, motions by tick
# from a time [s] to how far water has gone [m] and how it goes [m/s], north and east each
Water = Callable[[float], tuple[tuple[float, float], tuple[float, float]]]


@dataclass(frozen=True)
class Ship:
    """One ship and its way."""

    name: str
    kind: str
    status: str
    mmsi: int | None
    way: Way  # through the water of a ship that drifts
    drifts: bool = False
    steered: SteeredContact | None = (
        None  # a ship that answers its rudder; its way is only where it began
    )
    hull: ShipType | None = None  # of another boat of the class: its own, at its depth

    @property
    def type(self) -> ShipType:
        """Return its kind, with its sizes."""
        return self.hull or SHIP_TYPES[self.kind]

    @property
    def body(self) -> ShipType:
        """Return what the boat's hull touches: of another boat it is larger by its errors."""
        return body_of(self.hull) if self.hull else self.type

    def lies(self, now: Piece) -> bool:
        """Return whether the ship lies still and is ordered to."""
        return now.speed == 0.0 and self.way.path[-1].speed in (None, 0.0)


class ContactFleet:
    """All ships from one order to the next. Any thread may read it, because nothing alters it."""

    def __init__(
        self, ships: Mapping[str, Ship], water: Water, step: float, recent: deque["ContactFleet"]
    ) -> None:
        """Hold ships by their names, in the water that carries those that drift.

        ``recent`` are the fleets that keep what they have computed, of as many as there may be.
        """
        self.ships = dict(ships)
        self.order = tuple(self.ships.values())
        self.step = step
        self._water = water
        self._recent = recent
        self._drifting = [i for i, ship in enumerate(self.order) if ship.drifts]
        self._latest = NO_BLOCK
        boats = any(ship.hull for ship in self.order)
        self._block_ticks = BOATS_BLOCK_TICKS if boats else BLOCK_TICKS

    def motions(self, tick: int) -> list[ShipMotion]:
        """Return how all go at a tick. Their ways are computed for many ticks at once."""
        begins, block = self._latest
        if not begins <= tick < begins + len(block):
            begins = tick - tick % self._block_ticks
            block = self._block(begins)
            self._latest = begins, block
            if len(self._recent) == self._recent.maxlen:
                self._recent[0].let_go()
            self._recent.append(self)
        if not self._drifting:
            return block[tick - begins]
        motions, carried = list(block[tick - begins]), self._carried(tick * self.step)
        for i in self._drifting:  # orders may change the current, and so it is in no block
            motions[i] = ShipMotion(*map(operator.add, motions[i], carried))
        return motions

    def _block(self, begins: int) -> list[list[ShipMotion]]:
        """Return how all would go in a block from a tick on if no water carried them."""
        if len(self.order) > KNOWN_SHIPS or any(ship.steered for ship in self.order):
            ways = self._ways(np.arange(begins, begins + self._block_ticks, dtype=np.int64))
            return motions_in(ways)
        return laid_block(self.order, self.step, begins, self._block_ticks)

    def let_go(self) -> None:
        """Forget what was computed; a class changes the fleet thousands of times."""
        self._latest = NO_BLOCK

    def over(self, ticks: Ticks) -> Situation:
        """Return where all are over ticks, a row for each ship."""
        ways = self._ways(ticks)
        if self._drifting:
            carried = np.array([self._carried(tick * self.step) for tick in ticks.tolist()]).T
            for column, by in zip(ways, carried, strict=True):
                column[self._drifting] += by
        return ways

    def _carried(self, time: float) -> tuple[float, ...]:
        """Return what the water adds by a time [s] to a ship that drifts."""
        (north, east), current = self._water(time)
        return north, east, 0.0, 0.0, 0.0, *current

    def _ways(self, ticks: Ticks) -> Situation:
        """Return where all would be over ticks if no water carried them, a row each."""
        if not self.order:
            return Situation(*np.empty((len(Situation._fields), 0, ticks.size)))
        times = ticks.astype(np.float64) * self.step
        ways = laid_ways(self.order, times)
        for i, ship in enumerate(self.order):
            if ship.steered:
                self._steer(ship.steered, times, Situation(*(column[i] for column in ways)))
        return ways

    def _steer(self, steered: SteeredContact, times: Numbers, row: Situation) -> None:
        """Write how a ship that answers its rudder goes into its row."""
        for k, time in enumerate(times.tolist()):
            now = steered.at(time)
            for column, value in zip(row, now[:5], strict=False):
                column[k] = value
            row.set_north[k] = -now.sway * math.sin(now.course)
            row.set_east[k] = now.sway * math.cos(now.course)


def laid_ways(ships: Sequence[Ship], times: Numbers) -> Situation:
    """Return where ships are at times [s] by their laid ways, a row each."""
    pieces = np.stack([ship.way.over(times) for ship in ships], axis=1)
    return Situation(*(column.copy() for column in situation(pieces, times)))


def motions_in(ways: Situation) -> list[list[ShipMotion]]:
    """Return how ships go, by column of a situation."""
    return [[ShipMotion(*row) for row in rows] for rows in np.array(ways).T.tolist()]


@functools.lru_cache(maxsize=KNOWN_BLOCKS)
def laid_block(
    ships: tuple[Ship, ...], step: float, begins: int, count: int
) -> list[list[ShipMotion]]:
    """Return how ships go by their laid ways in some ticks from a tick on. Nobody may alter it.

    It is kept because a debrief flies the same minutes among the same ships many times.
    """
    if not ships:
        return [[] for _ in range(count)]
    ticks = np.arange(begins, begins + count, dtype=np.int64)
    return motions_in(laid_ways(ships, ticks.astype(np.float64) * step))
